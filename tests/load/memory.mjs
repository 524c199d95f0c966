// What the daemon's memory comes to under crowds that want it to hold much (make memory). Writes the figures for
// docs/reliability.md; exit status 1 when one is beyond its bound.
import * as crowds from "./crowds.mjs";
import { beginSection, round, row, text } from "./drive.mjs";

const JOB_MB = 600;
const MB = (value) => round(value, 0);
// Scene, how often, the most that it may add to a daemon that nobody asks anything (MB).
const allowance = crowds.ALLOWANCE_MB + 120; // with one answer in the making, and what all connections cost
const scenes = [
  ["nobody asks anything", () => crowds.nobody(), 0],
  ["1600 bodies of 1 MiB whose last byte does not come for seconds", () => crowds.slowBodies(1600), allowance],
  ["40 clients that ask for a result of 12 MB and read nothing", () => crowds.unreadResults(40), allowance],
  ["the same, compressed", () => crowds.unreadResults(40, () => "Accept-Encoding: gzip\r\n"), allowance],
  ["200 clients that ask for a log of evaluations, compressed, and read nothing", () => crowds.unreadLogs(200), allowance],
  ["1600 event streams that nobody reads", () => crowds.eventStreams(1600), 150],
  ["1900 long polls", () => crowds.longPolls(1900), 150],
  ["1900 requests that stop in their first line", () => crowds.silent(1900), 150],
  ["100 documents of 1 MiB made to be thick when they are read", () => crowds.thickDocuments(100), 100],
  ["a job of three load cases at 100000 speeds each, bounded by its estimate", () => crowds.manySpeeds(100000), 0],
  ["a field at mesh_refinement 2, after its job", () => crowds.finestField(), 800],
  [`two jobs at once, each as large as max-job-memory = ${JOB_MB} allows`, () => crowds.largestJobs(JOB_MB, 2), 2 * JOB_MB],
];

beginSection("memory");
text(
  "`make memory`: crowds that want the daemon to hold much, each against a daemon of its own with two threads and two jobs at a time. " +
    "The largest resident set (VmHWM), the most that it may be, and what the clients were told.",
);
let idle = 0;
let broken = 0;
for (const [name, play, most] of scenes) {
  const { answers, before, peak, told } = await play();
  if (!idle) idle = Math.max(before, peak);
  const bound = idle + (told ?? most);
  if (bound > idle && peak > bound) broken++;
  row({ crowd: name, "largest, MB": MB(peak), "bound, MB": bound > idle ? MB(bound) : "", answers });
}
process.exit(broken ? 1 : 0);
