// The campaigns over whole programs: node faults.mjs [--stride S [--first F]] [--only disk|command|export|daemon|tls] [--by LIBRARY]
// (make faults)
// Adds its figures to reliability/faults.jsonl in the build tree, for docs/reliability.md; exit status 1 when anything was wrong.
import { appendFileSync, mkdirSync, rmSync } from "node:fs";
import { join } from "node:path";
import { BUILD } from "../page/harness.mjs";
import { progress } from "./campaigns.mjs";
import { diskCampaign } from "./disk.mjs";
import { LIBRARIES, commandCampaign, daemonCampaign, tlsFlags } from "./memory.mjs";
import { scratch } from "./programs.mjs";

const TLS_LIBRARIES = "libgnutls,libnettle,libhogweed,libgmp,libtasn1,libp11-kit";

const option = (name, standard) => {
  const at = process.argv.indexOf(name);
  return at > 0 ? process.argv[at + 1] : standard;
};
const choice = { stride: Number(option("--stride", 1)), first: Number(option("--first", 0)), only: option("--by", "") };
const only = option("--only", "");
const wanted = (name) => !only || only === name;

mkdirSync(join(BUILD, "reliability"), { recursive: true });
const put = (line) => appendFileSync(join(BUILD, "reliability/faults.jsonl"), `${JSON.stringify(line)}\n`);
let wrongs = 0;

// Figures of one campaign; what was wrong goes to standard error.
function tell(words, rows, wrong) {
  put({ text: words });
  for (const row of rows) put({ row });
  console.table(rows);
  wrongs += wrong.length;
}

const named = (rows, who) => rows.map(({ who: name, ...rest }) => ({ [who]: name, ...rest }));
const counted = (libraries) =>
  Object.entries(libraries)
    .map(([name, rounds]) => `${name} in ${rounds}`)
    .join(", ") || "none";

if (wanted("disk")) {
  const { calls, rows, wrong } = await diskCampaign({ ...choice, tell: progress("disk") });
  tell(
    `A whole daemon on a disk that fails (\`tests/faults/disk.mjs\`): in one client's day, ${calls} calls write, sync, truncate, make, ` +
      "rename or remove a file below the state directory, and each is let fail, alone, every second one with all after it as well. `right`: every answer is the " +
      "right one, or becomes it when asked again; `refused`: answered by a problem document for as long as the disk fails; `failed`: the " +
      "job ended with a reason; `stopped`: the daemon does not start, and says why. After each round the next daemon, on a whole disk, has " +
      `every job that was accepted, once, with the right result, and its database passes \`PRAGMA integrity_check\`. Wrong: ${wrong.length}.`,
    rows.map(({ mode, ...rest }) => ({ "what fails": mode, ...rest })),
    wrong,
  );
}
if (wanted("command")) {
  const words = ["run", "--threads", "2"];
  const { sites, rows, libraries, wrong } = await commandCampaign({ words, ...choice, tell: progress("command") });
  tell(
    `\`quietgear run\` without memory (\`tests/faults/memory.mjs\`): it asks for memory at ${sites.length} sites, its libraries' included, a ` +
      "site being the return addresses of the innermost callers. The first, the middle and the last call at each fails once; and all calls " +
      "above a size. `right`: the undisturbed result, to the last bit; `refused`: exit status 1, a message, no output; `library`: a library " +
      `ended the process with a message of its own (${counted(libraries)} rounds). Crashes, hangs, wrong results: ${wrong.length}.`,
    named(rows, "who asks for memory"),
    wrong,
  );
}
if (wanted("export")) {
  const words = ["export", "--format", "json"];
  const { rows, wrong } = await commandCampaign({ words, ...choice, only: choice.only || "libcholmod,quietgear", tell: progress("export") });
  tell(
    `The same for \`quietgear export --format json\`, the fields of both gears, at the sites of CHOLMOD and our own. Wrong: ${wrong.length}.`,
    named(rows, "who asks for memory"),
    wrong,
  );
}
if (wanted("daemon")) {
  const { sites, rows, libraries, lost, wrong } = await daemonCampaign({ ...choice, tell: progress("daemon") });
  tell(
    `The same for the daemon over one client's day, at ${sites.length} sites. \`refused\`: problem documents, a job that failed with a ` +
      `reason, a start that ended with a message and status 1, or a connection closed without an answer (in ${lost} requests: what ` +
      `libmicrohttpd does when it has no memory itself). Ended by a library: ${counted(libraries)}. After each round that was not right ` +
      `the next daemon has everything that was promised. Wrong: ${wrong.length}.`,
    named(rows, "who asks for memory"),
    wrong,
  );
}
if (wanted("tls")) {
  const place = scratch("tls");
  const by = choice.only || TLS_LIBRARIES;
  const { rows, libraries, lost, wrong } = await daemonCampaign({ ...choice, only: by, flags: tlsFlags(place), tell: progress("tls") });
  rmSync(place, { recursive: true, force: true });
  tell(
    `The same for a daemon that speaks HTTPS, at the sites of GnuTLS and what it is built from. Short of memory while it reads a ` +
      `certificate, GnuTLS calls the certificate wrong, and the daemon passes that on (status 2). Ended by a library: ${counted(libraries)}; ` +
      `requests without an answer: ${lost}. Wrong: ${wrong.length}.`,
    named(rows, "who asks for memory"),
    wrong,
  );
}
if (!only)
  put({
    text:
      "Libraries that end the process when memory is missing, and cannot be told otherwise: " +
      [...new Set(LIBRARIES.map(({ name, when }) => `${name}, when ${when}`))].join("; ") +
      ". systemd starts the daemon again, and jobs go on from their logs.",
  });
process.exit(wrongs ? 1 : 0);
