// Whole programs without memory: each call that asks for some fails, once, in whatever library it is.
//
// A program is run undisturbed first; memory.c lists the sites from which it asks for memory, by the return addresses of the
// callers. Then it is run again for the first, the middle and the last call of each site; and with every call failing that
// wants so many bytes or more, for sizes from 64 MiB down to 1 KiB. A round ends in one of three ways:
//   right    the result is that of the undisturbed run, to the last bit
//   refused  a clear error: of the command, exit status 1 and a message; of the daemon, a problem document, a job that failed
//            with a reason, a connection that was closed without an answer, or a message and exit status 1
//   library  a library ended the process with a message of its own, for it knows no other way; LIBRARIES lists them
// Anything else is wrong: a crash, a program that hangs, a wrong result, an error without words. After each round of a daemon
// the next one, without faults, has to have everything that was promised.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { BUILD } from "../page/harness.mjs";
import { eachOf, everyNth, tally } from "./campaigns.mjs";
import { spendDay, spendEvening, receive, webhookFlags } from "./day.mjs";
import { complaint, document, essence, run, scratch, startDaemon, stopDaemon } from "./programs.mjs";

const SHIM = join(BUILD, "tests/faults/memory.so");
const DEPTH = "3"; // callers that make a site
export const KINDS = ["right", "refused", "library"];

// Libraries that end the process themselves: when, and what they say, or in whose code memory was missing and which signal came.
export const LIBRARIES = [
  { name: "libgomp", when: "a parallel region begins (CHOLMOD's)", says: /^libgomp: Out of memory allocating \d+ bytes/m },
  { name: "libgfortran", when: "it is loaded (by LAPACK)", says: /^Operating system error: Cannot allocate memory/m },
  { name: "OpenBLAS", when: "it is loaded, and starts threads", says: /^OpenBLAS blas_thread_init: pthread_create failed/m },
  { name: "GMP", when: "it computes for GnuTLS", says: /^GNU MP: Cannot (re)?allocate memory/m },
  { name: "GMP", when: "it computes for GnuTLS", asked: /^libgmp/, signal: "SIGABRT" },
  { name: "libtasn1", when: "it reads a certificate for GnuTLS (a null pointer)", asked: /^libtasn1/, signal: "SIGSEGV" },
  { name: "ld.so", when: "a library is loaded", says: /error while loading shared libraries|cannot allocate memory/ },
];
// The library that has ended a process: by its words, or by the signal and the first of the frames of who asked for memory.
const libraryOf = (error, { signal = "", frames = "" } = {}) =>
  LIBRARIES.find(({ says, asked, signal: own }) => (says ? says.test(error) : own === signal && asked.test(frames.split(" ")[1])))?.name;
// GnuTLS tells a lack of memory while it reads a certificate as a fault of the certificate: then the status is 2.
const isMisread = (ended, log, frames) => ended.status === 2 && /lib(gnutls|tasn1|hogweed|nettle)/.test(frames) && /certificate/.test(log);

const environment = (more) => ({ LD_PRELOAD: SHIM, QG_MEMORY_DEPTH: DEPTH, ...more });

// --- sites ---

// The list that memory.c wrote: [{site, calls, largest, owner: the library that asks, frames}].
function readSites(file) {
  return readFileSync(file, "utf8")
    .trim()
    .split("\n")
    .map((line) => {
      const [site, calls, largest, ...frames] = line.split(" ");
      return { site, calls: Number(calls), largest: Number(largest), owner: ownerOf(frames), frames };
    })
    .sort((a, b) => (a.site < b.site ? -1 : 1));
}

// The module that wants the memory: the innermost that is not the C library (strdup, fopen, pthread_create, ...).
function ownerOf(frames) {
  const modules = frames.map((frame) => frame.replace(/\.so.*/, "").replace(/\+0x.*/, ""));
  const mine = modules.find((module) => module !== "libc" && module !== "ld-linux-x86-64" && module !== "?");
  return mine === "program" ? "quietgear" : (mine ?? modules[0] ?? "?");
}

// First, middle and last call of a site.
const callsOf = ({ calls }) => [...new Set([1, Math.ceil(calls / 2), calls])];
// OpenSSL's, which only its start has here, are so many and so alike that every fourth is taken.
const allTasks = (sites) => [
  ...sites.filter(({ owner }, at) => owner !== "libcrypto" || at % 4 === 0).flatMap((site) =>
    callsOf(site).map((n) => ({
      what: site.owner,
      name: `${site.site} call ${n} of ${site.calls}`,
      env: { QG_MEMORY_SITE: site.site, QG_MEMORY_CALL: String(n) },
    })),
  ),
  ...Array.from({ length: 17 }, (_, i) => 2 ** (26 - i)).map((bytes) => ({
    what: "all calls above a size",
    name: `${bytes} bytes and more`,
    env: { QG_MEMORY_ABOVE: String(bytes) },
  })),
];

// Every stride-th of the tasks of some owners (with commas between), or of all.
const tasksOf = (sites, { only, stride, first }) =>
  everyNth(
    allTasks(sites).filter(({ what }) => !only || only.split(",").includes(what)),
    { stride, first },
  );

// What is wrong with a round, in words.
function wordsOf(task, round) {
  const found = [...(KINDS.includes(round.ending) ? [] : [round.ending]), ...(round.wrong ?? [])];
  return found.map((words) => `${task.what}, ${task.name}: ${words}; asked by ${round.frames}; ${round.log.trim()}`);
}

// --- the command ---

function judgeCommand(ended, expected) {
  if (complaint(ended.error)) return { ending: "a sanitizer complains" };
  if (ended.hangs) return { ending: "hangs" };
  if (ended.status === 0) return { ending: essence(ended.out) === expected || ended.out === expected ? "right" : "wrong result" };
  const library = libraryOf(ended.error);
  if (library) return { ending: "library", library };
  if (ended.signal) return { ending: ended.signal };
  return { ending: ended.status === 1 && ended.error.trim() && !ended.out ? "refused" : `exit status ${ended.status}` };
}

// words: of the command; its result goes to standard output.
async function commandRound(words, task, expected) {
  const place = scratch("memory");
  const trace = join(place, "trace");
  const ended = await run("quietgear", words, environment({ ...task.env, QG_MEMORY_TRACE: trace }));
  const reached = existsSync(trace);
  const frames = reached ? readFileSync(trace, "utf8").trim() : "";
  rmSync(place, { recursive: true, force: true });
  const judged = judgeCommand(ended, expected);
  return { ...judged, reached, wrong: wordsOf(task, { ...judged, frames, log: ended.error }) };
}

// The command `quietgear run`, or another with its words before the document's file name. choice: {only: the calls of
// some owners, stride, first}.
export async function commandCampaign({ words = ["run", "--threads", "2"], tell, ...choice } = {}) {
  const place = scratch("memory");
  const file = join(place, "job.json");
  const list = join(place, "sites");
  writeFileSync(file, JSON.stringify(document()));
  const undisturbed = await run("quietgear", [...words, file], environment({ QG_MEMORY_SITES: list }));
  if (undisturbed.status !== 0) throw new Error(undisturbed.error);
  const expected = essence(undisturbed.out) ?? undisturbed.out;
  const sites = readSites(list);
  const tasks = tasksOf(sites, choice);
  const rounds = await eachOf(tasks, (task) => commandRound([...words, file], task, expected), tell);
  rmSync(place, { recursive: true, force: true });
  return summary(sites, tasks, rounds);
}

// --- the daemon ---

function judgeDaemon(daemon, day, ended, frames) {
  const library = ended.status !== 0 && libraryOf(daemon.log, { signal: ended.signal, frames });
  if (complaint(daemon.log)) day.wrong.push("a sanitizer complains");
  if (library) return { ending: "library", library };
  if (ended.hangs) day.wrong.push("the daemon hangs");
  else if (ended.signal) day.wrong.push(`the daemon was ended by ${ended.signal}`);
  else if (isMisread(ended, daemon.log, frames)) return { ending: "refused" };
  else if (ended.status !== 0 && !(ended.status === 1 && daemon.log.trim())) day.wrong.push(`the daemon ended with ${ended.status}`);
  if (ended.status === 0 && !day.id) day.wrong.push(`no job was taken: ${day.refused} ${day.lost}`);
  if (ended.status === 0 && day.id && !day.state) day.wrong.push("the job does not end");
  const all = day.state === "succeeded" && day.second && !day.refused.length && !day.lost.length;
  return { ending: ended.status === 0 && all ? "right" : "refused" };
}

async function daemonRound(task, { expected, receiver, flags, number }) {
  const place = scratch("memory");
  const state = join(place, "state");
  const trace = join(place, "trace");
  const env = environment({ ...task.env, QG_MEMORY_TRACE: trace });
  const daemon = await startDaemon(state, { env, flags: { ...webhookFlags(receiver), ...flags } });
  const lasting = Boolean(task.env.QG_MEMORY_ABOVE);
  const options = { expected, receiver, number, patience: lasting ? 3000 : 15000, repeats: lasting ? 2 : 5 };
  const day = daemon.url ? await spendDay(daemon, options) : { wrong: [], refused: [], lost: [] };
  const ended = await stopDaemon(daemon);
  const frames = existsSync(trace) ? readFileSync(trace, "utf8").trim() : "";
  const judged = lasting && ended.status === 0 ? { ending: "refused" } : judgeDaemon(daemon, day, ended, frames);
  if (judged.ending !== "right") await spendEvening(state, day, expected);
  rmSync(place, { recursive: true, force: true });
  const wrong = wordsOf(task, { ...judged, wrong: day.wrong, frames, log: daemon.log });
  return { ...judged, wrong, reached: Boolean(frames), lost: day.lost.length };
}

// A day without faults: fills in `expected`. Its sites.
async function learnDay({ expected, receiver, flags }) {
  const place = scratch("memory");
  const list = join(place, "sites");
  const options = { env: environment({ QG_MEMORY_SITES: list }), flags: { ...webhookFlags(receiver), ...flags } };
  const daemon = await startDaemon(join(place, "state"), options);
  if (!daemon.url) throw new Error(daemon.log);
  const day = await spendDay(daemon, { expected, receiver, learns: true });
  await stopDaemon(daemon);
  if (day.wrong.length || day.refused.length || day.lost.length) throw new Error([...day.wrong, ...day.refused, ...day.lost].join("\n"));
  const sites = readSites(list);
  rmSync(place, { recursive: true, force: true });
  return sites;
}

// The settings of a daemon that speaks HTTPS, with a certificate of its own in a directory.
export function tlsFlags(place) {
  const [key, template, certificate] = ["key", "template", "pem"].map((name) => join(place, name));
  writeFileSync(template, 'cn = "faults"\nip_address = "127.0.0.1"\ntls_www_server\nsigning_key\nexpiration_days = 2\n');
  execFileSync("certtool", ["--generate-privkey", "--key-type", "ecdsa", "--outfile", key], { stdio: "pipe" });
  const words = ["--generate-self-signed", "--load-privkey", key, "--template", template, "--outfile", certificate];
  execFileSync("certtool", words, { stdio: "pipe" });
  return { "tls-certificate": certificate, "tls-key": key };
}

// flags: of the daemon, beyond the usual.
export async function daemonCampaign({ flags = {}, tell, ...choice } = {}) {
  const receiver = await receive();
  const shared = { expected: {}, receiver, flags };
  const sites = await learnDay(shared);
  const tasks = tasksOf(sites, choice);
  const rounds = await eachOf(tasks, (task, at) => daemonRound(task, { ...shared, number: at + 1 }), tell);
  receiver.close();
  return summary(sites, tasks, rounds);
}

// --- figures ---

// {sites, rows: [{who, sites, tried, right, refused, library}], libraries: {name: rounds}, lost, wrong: [words]}
function summary(sites, tasks, rounds) {
  const owners = [...new Set(tasks.map(({ what }) => what))].sort();
  const rows = owners.map((who) => {
    const mine = rounds.filter((round, at) => tasks[at].what === who);
    const count = sites.filter(({ owner }) => owner === who).length;
    return { who, sites: count || "", tried: mine.length, "not reached": mine.filter(({ reached }) => !reached).length, ...tally(mine, KINDS) };
  });
  const libraries = {};
  for (const { library } of rounds) if (library) libraries[library] = (libraries[library] ?? 0) + 1;
  const lost = rounds.reduce((sum, round) => sum + (round.lost ?? 0), 0);
  return { sites, rows, libraries, lost, wrong: rounds.flatMap(({ wrong }) => wrong) };
}
