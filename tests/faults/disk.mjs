// A whole daemon on a disk that fails: the n-th call that changes anything below its state directory, or all from the n-th on.
//
// Such calls are writes, syncs and truncations of files, and making, renaming and removing them (disk.c counts them). For each
// n a daemon is started on an empty directory, a client spends its day there (day.mjs), and the next daemon, on a disk that is
// whole again, has to have everything that was promised. A round ends in one of four ways:
//   right    every answer was the right one, or became it when asked again
//   refused  something was refused with a reason, until the day ended; jobs wait
//   failed   the job ended as failed, with a reason
//   stopped  the daemon said why it does not start, or cannot go on, and ended with status 1
// Anything else is wrong: an answer that is neither right nor a refusal, a connection that ends without an answer, a daemon that
// crashes or hangs, anything lost, doubled or changed in the evening.
import { readFileSync, rmSync } from "node:fs";
import { join } from "node:path";
import { eachOf, everyNth, tally } from "./campaigns.mjs";
import { spendDay, spendEvening, receive, webhookFlags } from "./day.mjs";
import { BUILD } from "../page/harness.mjs";
import { complaint, scratch, startDaemon, stopDaemon } from "./programs.mjs";

const SHIM = join(BUILD, "tests/faults/disk.so");
const ENDLESS = 1000000000;
// every, from: the n that a mode takes; a round of one that lasts takes long, and the two kinds differ little.
export const MODES = [
  { name: "one call, the disk is full", errno: 28, lasting: false, every: 1, from: 0 },
  { name: "one call, an error of the disk", errno: 5, lasting: false, every: 1, from: 0 },
  { name: "all from there on, the disk is full", errno: 28, lasting: true, every: 4, from: 1 },
  { name: "all from there on, errors of the disk", errno: 5, lasting: true, every: 4, from: 3 },
];
export const KINDS = ["right", "refused", "failed", "stopped"];

const read = (file) => {
  try {
    return readFileSync(file, "utf8").trim();
  } catch {
    return "";
  }
};

// A day with these faults, and its evening. {ending, wrong, reached: which call failed}.
export async function diskRound({ mode, n }, { expected, receiver, number }) {
  const place = scratch("disk");
  const state = join(place, "state");
  const trace = join(place, "trace");
  const env = {
    LD_PRELOAD: SHIM,
    QG_FAULT_NAMES: state,
    QG_FAULT_FIRST: String(n),
    QG_FAULT_LAST: String(mode.lasting ? ENDLESS : n),
    QG_FAULT_ERRNO: String(mode.errno),
    QG_FAULT_TRACE: trace,
  };
  const daemon = await startDaemon(state, { env, flags: webhookFlags(receiver) });
  const patience = mode.lasting ? 1500 : 15000;
  const options = { expected, receiver, number, patience, repeats: mode.lasting ? 2 : 5 };
  const day = daemon.url ? await spendDay(daemon, options) : { wrong: [], refused: [], lost: [] };
  const ended = await stopDaemon(daemon);
  const ending = judge({ mode, day, daemon, ended });
  await spendEvening(state, day, expected);
  const reached = read(trace);
  rmSync(place, { recursive: true, force: true });
  return { ending, wrong: day.wrong.map((words) => `${mode.name}, call ${n} (${reached}): ${words}`) };
}

// What kind of day it was; adds what is wrong with how the daemon behaved.
function judge({ mode, day, daemon, ended }) {
  const said = /quietgeard|: /.test(daemon.log) && daemon.log.trim().length > 0;
  if (complaint(daemon.log)) day.wrong.push(`a sanitizer complains: ${daemon.log}`);
  if (ended.hangs) day.wrong.push(`the daemon hangs: ${daemon.log}`);
  else if (ended.signal) day.wrong.push(`the daemon was ended by ${ended.signal}: ${daemon.log}`);
  else if (ended.status !== 0 && !(ended.status === 1 && said)) day.wrong.push(`the daemon ended with ${ended.status}: ${daemon.log}`);
  if (ended.status === 1) return "stopped";
  day.wrong.push(...day.lost.map((one) => `no answer: ${one}`));
  if (!mode.lasting && !day.id) day.wrong.push(`one fault, and no job was taken: ${day.refused}`);
  if (!mode.lasting && day.id && !day.state) day.wrong.push("one fault, and the job does not end");
  if (day.state === "failed") return "failed";
  return day.state === "succeeded" && day.second ? "right" : "refused";
}

// A day without faults: fills in `expected`, and says how many calls there are in it.
async function learn(expected, receiver) {
  const place = scratch("disk");
  const state = join(place, "state");
  const count = join(place, "count");
  const env = { LD_PRELOAD: SHIM, QG_FAULT_NAMES: state, QG_FAULT_COUNT: count };
  const daemon = await startDaemon(state, { env, flags: webhookFlags(receiver) });
  const day = await spendDay(daemon, { expected, receiver, learns: true });
  await stopDaemon(daemon);
  await spendEvening(state, day, expected);
  if (day.wrong.length || day.refused.length || day.lost.length) throw new Error([...day.wrong, ...day.refused, ...day.lost].join("\n"));
  const calls = Number(read(count));
  rmSync(place, { recursive: true, force: true });
  return calls;
}

// Every stride-th n of each mode, beginning with `first`. {calls, rows: [{mode, tried, right, ...}], wrong: [words]}.
export async function diskCampaign({ stride, first, tell } = {}) {
  const receiver = await receive();
  const expected = {};
  const calls = await learn(expected, receiver);
  const numbers = Array.from({ length: calls }, (_, i) => i + 1);
  const all = MODES.flatMap((mode) => numbers.filter((n) => n % mode.every === mode.from).map((n) => ({ mode, n })));
  const tasks = everyNth(all, { stride, first });
  const rounds = await eachOf(tasks, (task, at) => diskRound(task, { expected, receiver, number: at + 1 }), tell);
  receiver.close();
  const rows = MODES.map((mode) => {
    const mine = rounds.filter((_, at) => tasks[at].mode === mode);
    return { mode: mode.name, tried: mine.length, ...tally(mine, KINDS) };
  });
  return { calls, rows, wrong: rounds.flatMap(({ wrong }) => wrong) };
}
