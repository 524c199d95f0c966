// The load campaign: node load.mjs [--seconds N] [--queue N] [--streams N]     (make load; needs wrk and lighttpd)
//
// With all processors computing, GET /v1/jobs/{id} at 500 requests a second; a queue of 10 000 jobs, listed and claimed; 1 000
// idle event streams; the heaviest requests, and who waits for them; and requests per second beside lighttpd with a static file
// of the same size. Writes the figures for
// docs/reliability.md. Exit status 1 when one of what is promised does not hold.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { cpus, tmpdir } from "node:os";
import { join } from "node:path";
import { BUILD, endless, smallDocument, startDaemon, submit, waitForState } from "../page/harness.mjs";
import { beginSection, closeStreams, constantRate, listAll, now, openStreams, pause, quantile, residentKib, round, row, sorted, submitMany, text, untilAllSaid } from "./drive.mjs";
import { addHeavyJobs, askMeanwhile, heavyRequests } from "./heavy.mjs";

const option = (name, fallback) => {
  const at = process.argv.indexOf(`--${name}`);
  return at > 0 ? Number(process.argv[at + 1]) : fallback;
};
const SECONDS = option("seconds", 30);
const QUEUE = option("queue", 10000);
const STREAMS = option("streams", 1000);
const RATE = 500;
const P99_MS = 20;
const WAIT_MS = 250; // for the heaviest request of all
const broken = [];
const promise = (kept, words) => kept || broken.push(words);

async function withDaemon(flags, work) {
  const daemon = await startDaemon(flags);
  try {
    await work(daemon);
  } finally {
    await daemon.remove();
  }
}

// Latency while everything computes. The plan's clock runs in this process, which shares the processors with the daemon.
async function latency(daemon) {
  const id = await submit(daemon.url, smallDocument(endless));
  await waitForState(daemon.url, id, "running");
  await pause(2000);
  const before = await (await fetch(`${daemon.url}/v1/jobs/${id}`)).json();
  const times = await constantRate(`${daemon.url}/v1/jobs/${id}`, RATE, SECONDS);
  const after = await (await fetch(`${daemon.url}/v1/jobs/${id}`)).json();
  const evaluated = after.progress.done - before.progress.done;
  row({
    request: "GET /v1/jobs/{id}",
    "requests/s": RATE,
    seconds: SECONDS,
    "p50, ms": round(quantile(times, 0.5)),
    "p99, ms": round(quantile(times, 0.99)),
    "p99.9, ms": round(quantile(times, 0.999)),
    "largest, ms": round(times.at(-1)),
    "designs judged meanwhile": evaluated,
  });
  promise(evaluated > 0, "the daemon computed meanwhile");
  promise(quantile(times, 0.99) < P99_MS, `p99 below ${P99_MS} ms`);
}

// Pages of the list with few and with many jobs queued, over HTTP; each job once.
async function queue(daemon) {
  const busy = await submit(daemon.url, smallDocument(endless));
  await waitForState(daemon.url, busy, "running");
  for (const depth of [100, QUEUE]) {
    const missing = depth - (await listAll(daemon.url, "/v1/jobs?state=queued&limit=100")).ids.length;
    const start = now();
    await submitMany(daemon.url, missing, (i) => smallDocument((one) => (one.name = `queued ${i}`)));
    const took = now() - start;
    const all = [];
    for (let i = 0; i < Math.max(1, 3000 / depth); i++) all.push(await listAll(daemon.url, "/v1/jobs?state=queued&limit=100"));
    const times = sorted(all.flatMap((one) => one.times));
    const ids = all[0].ids;
    promise(ids.length === depth && new Set(ids).size === depth, `each of ${depth} jobs listed once`);
    row({
      "queued jobs": depth,
      "submitted/s": round((missing * 1000) / took, 0),
      pages: all[0].times.length,
      "page of 100, median ms": round(quantile(times, 0.5)),
      "p99, ms": round(quantile(times, 0.99)),
      "last page, ms": round(all[0].times.at(-1)),
    });
  }
}

// The store by itself; its log, a line for each submission, is of no interest.
function claims() {
  const options = { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], maxBuffer: 1 << 28 };
  const said = execFileSync(join(BUILD, "tests/load/claims"), ["100", String(QUEUE)], options);
  for (const line of said.trim().split("\n")) row(JSON.parse(line).row);
}

async function streams(daemon) {
  const before = residentKib(daemon.child.pid);
  const open = await openStreams(daemon.url, STREAMS);
  await pause(500);
  const after = residentKib(daemon.child.pid);
  const start = now();
  const id = await submit(daemon.url, smallDocument(endless));
  const heard = await untilAllSaid(open, id);
  row({
    "event streams": STREAMS,
    "memory before, MiB": round(before / 1024, 1),
    "with them, MiB": round(after / 1024, 1),
    "KiB per stream": round((after - before) / STREAMS, 1),
    "heard of a job": heard,
    "all within, ms": round(now() - start, 0),
  });
  promise(heard === STREAMS, "every stream hears of the job");
  closeStreams(open);
}

// One thread answers all requests: who waits for the heaviest ones, and how long.
async function heavy(daemon) {
  addHeavyJobs(daemon);
  for (const [name, path, flags] of heavyRequests) {
    const { bytes, took, slowest } = await askMeanwhile(daemon, path, flags);
    row({ "a heavy request": name, "bytes sent": bytes, "whole, ms": round(took, 0), "others wait at most, ms": round(slowest, 1) });
    promise(slowest < WAIT_MS, `others wait less than ${WAIT_MS} ms for ${name}`);
  }
}

// Requests per second by wrk: one thread, 16 connections.
function wrk(url, seconds) {
  const said = execFileSync("wrk", ["-t1", "-c16", `-d${seconds}s`, url], { encoding: "utf8" });
  if (/Non-2xx|Socket errors/.test(said)) throw new Error(said);
  return Number(/Requests\/sec:\s*([\d.]+)/.exec(said)[1]);
}

async function startLighttpd(body) {
  const root = mkdtempSync(join(tmpdir(), "quietgear-lighttpd-"));
  const port = 20000 + (process.pid % 20000);
  writeFileSync(join(root, "job.json"), body);
  writeFileSync(join(root, "conf"), `server.document-root = "${root}"\nserver.bind = "127.0.0.1"\nserver.port = ${port}\n` +
    'mimetype.assign = (".json" => "application/json")\nserver.max-keep-alive-requests = 1000000\n');
  const child = spawn("lighttpd", ["-D", "-f", join(root, "conf")], { stdio: ["ignore", "ignore", "inherit"] });
  const url = `http://127.0.0.1:${port}/job.json`;
  for (let i = 0; i < 100 && !(await fetch(url).catch(() => null))?.ok; i++) await pause(50);
  return { url, stop: () => { child.kill(); rmSync(root, { recursive: true }); } };
}

// Beside a server that does nothing but send files; nothing is computed meanwhile.
async function compare(daemon) {
  const id = await submit(daemon.url, smallDocument());
  await waitForState(daemon.url, id, "succeeded");
  const url = `${daemon.url}/v1/jobs/${id}`;
  const body = await (await fetch(url)).text();
  const lighttpd = await startLighttpd(body);
  try {
    const seconds = Math.max(1, Math.round(SECONDS / 3));
    const [theirs, ours] = [wrk(lighttpd.url, seconds), wrk(url, seconds)];
    row({
      "body, bytes": body.length,
      "lighttpd, static file, requests/s": round(theirs, 0),
      "GET /v1/jobs/{id}, requests/s": round(ours, 0),
      ratio: round(ours / theirs),
    });
  } finally {
    lighttpd.stop();
  }
}

beginSection("load");
text(`\`make load\`, on ${cpus().length} processors; the clients run on the same machine. Latency counts from when a request was to be sent by the plan, so that waiting for others counts as well; all processors compute meanwhile. The queue over HTTP, while one processor computes, and below it in the store itself; then event streams; then what the heaviest requests take, and how long the slowest of others that ask every millisecond waits meanwhile; then requests per second by wrk with 16 connections, nothing being computed.`);
await withDaemon({}, latency);
await withDaemon({ threads: "1", jobs: "1" }, queue);
claims();
await withDaemon({ threads: "1", jobs: "1", "client-streams": "0" }, streams);
await withDaemon({}, heavy);
await withDaemon({}, compare);
for (const words of broken) console.error(`does not hold: ${words}`);
process.exit(broken.length ? 1 : 0);
