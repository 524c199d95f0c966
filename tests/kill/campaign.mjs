// kill -9 at random moments, and what has to hold afterwards.
//
// A client submits jobs, each with a key of its own, and repeats a submission that got no answer under the same key, as a
// client should. The daemon computes two of them at a time and delivers webhooks. It is killed after a random time, by
// SIGKILL, and started again, so many rounds long; then all jobs are waited for. What has to hold:
//   - the database as it lies there after each kill passes PRAGMA integrity_check (a copy is opened, so that it is the daemon
//     that recovers the original);
//   - every job that was accepted is there and has succeeded: none is lost, and no key has two jobs;
//   - none has finished twice: the trigger that writes a delivery with each change of a state has written one job.succeeded for
//     each job, and the receiver has got it at least once, under that one id;
//   - the result and the log of evaluations are to the last bit those of an undisturbed `quietgear run` and daemon.
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import http from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { BUILD, smallDocument, startDaemon } from "../page/harness.mjs";

const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const ESSENCE = ["job", "geometry", "design", "reference", "improvement", "search", "reliability"];
const essence = (result) => JSON.stringify(ESSENCE.map((name) => result[name]));

// Numbers from 0 to 1 that a seed determines (Numerical Recipes' linear congruential generator).
function generator(seed) {
  let drawn = seed >>> 0;
  return () => {
    drawn = (Math.imul(drawn, 1664525) + 1013904223) >>> 0;
    return drawn / 4294967296;
  };
}

// The documents that jobs are made of, from short to some hundred evaluations.
const documents = [
  [4, 2],
  [12, 6],
  [80, 20],
].map(([samples, iterations], i) =>
  JSON.stringify(
    smallDocument((one) => {
      one.name = `kind ${i}`;
      one.optimizer = { ...one.optimizer, random_samples: samples, simplex_iterations: iterations, seed: 7 + i };
    }),
  ),
);

const sqlite = (file, sql) => execFileSync("sqlite3", ["-readonly", file, sql], { encoding: "utf8" }).trim();

// A receiver of webhooks: ids of messages by job, for job.succeeded. A fifth of the deliveries is refused, so that some wait.
function receive(random) {
  const succeeded = new Map();
  const server = http.createServer((request, response) => {
    let body = "";
    request.on("data", (piece) => (body += piece));
    request.on("end", () => {
      const message = JSON.parse(body);
      const taken = random() < 0.8;
      if (taken && message.type === "job.succeeded") {
        const id = message.data.id;
        if (!succeeded.has(id)) succeeded.set(id, new Set());
        succeeded.get(id).add(request.headers["webhook-id"]);
      }
      response.statusCode = taken ? 204 : 500;
      response.end();
    });
  });
  return new Promise((done) => server.listen(0, "127.0.0.1", () => done({ server, succeeded, port: server.address().port })));
}

// What a document gives when nobody disturbs it.
async function undisturbed(work) {
  const daemon = await startDaemon({ jobs: "1" });
  const expected = [];
  for (const [i, document] of documents.entries()) {
    const file = join(work, `${i}.json`);
    writeFileSync(file, document);
    const alone = JSON.parse(execFileSync(join(BUILD, "quietgear"), ["run", file], { encoding: "utf8", maxBuffer: 1 << 28 }));
    const id = await post(daemon.url, document, `undisturbed ${i}`.replace(" ", "-"));
    await ended(daemon.url, id);
    expected.push({ result: essence(alone), log: await (await fetch(`${daemon.url}/v1/jobs/${id}/evaluations`)).text() });
  }
  await daemon.remove();
  return expected;
}

// Submits once; the id, or null when no answer came.
async function post(url, document, key) {
  const headers = { "Content-Type": "application/json", "Idempotency-Key": key };
  const answer = await fetch(`${url}/v1/jobs`, { method: "POST", headers, body: document }).catch(() => null);
  if (answer && answer.status !== 201 && answer.status !== 503) throw new Error(`POST: ${answer.status} ${await answer.text()}`);
  const job = answer?.status === 201 ? await answer.json().catch(() => null) : null;
  return job?.id ?? null;
}

async function ended(url, id) {
  for (;;) {
    const answer = await fetch(`${url}/v1/jobs/${id}`, { headers: { Prefer: "wait=5" } });
    if (answer.status !== 200) throw new Error(`job ${id}: ${answer.status}`);
    const job = await answer.json();
    if (job.finished_at) return job;
  }
}

// The submitting client: keeps up to `waiting` jobs ahead of the daemon, until it is told to stop. Every key ends with an id.
function submitter(daemon, random, waiting, wrong) {
  const again = { count: 0 };
  const jobs = []; // {key, kind, id}
  let stopping = false;
  const run = async () => {
    while (!stopping || jobs.some((job) => !job.id)) {
      const open = jobs.find((job) => !job.id);
      if (!open && !stopping && (await room(daemon, waiting)))
        jobs.push({ key: `key-${jobs.length}`, kind: Math.floor(random() * documents.length), id: null, tries: 0 });
      const job = jobs.find((one) => !one.id);
      if (job) {
        job.tries++;
        job.id = await post(daemon.url, documents[job.kind], job.key);
      } else if (jobs.length > 0) {
        // a client that did not believe the answer
        const earlier = jobs[Math.floor(random() * jobs.length)];
        const id = await post(daemon.url, documents[earlier.kind], earlier.key);
        if (id && id !== earlier.id) wrong.push(`key ${earlier.key}: ${earlier.id}, and then ${id}`);
        again.count += id ? 1 : 0;
      }
      if (!job?.id) await pause(20);
    }
  };
  const done = run();
  return { jobs, again, stop: () => ((stopping = true), done) };
}

async function room(daemon, waiting) {
  const answer = await fetch(`${daemon.url}/v1/jobs?state=queued&limit=${waiting}`).catch(() => null);
  const list = answer?.ok ? await answer.json().catch(() => null) : null;
  return list && list.jobs.length < waiting;
}

// Looks at the database that a killed daemon left, in a copy. Says what was going on when it was killed.
function inspect(daemon, work, wrong, round) {
  const copy = join(work, "copy");
  rmSync(copy, { recursive: true, force: true });
  mkdirSync(copy);
  for (const name of ["quietgear.db", "quietgear.db-wal"])
    if (existsSync(join(daemon.state, name))) cpSync(join(daemon.state, name), join(copy, name));
  const file = join(copy, "quietgear.db");
  const ask = (sql) => execFileSync("sqlite3", [file, sql], { encoding: "utf8" }).trim();
  const verdict = ask("PRAGMA integrity_check");
  if (verdict !== "ok") wrong.push(`after kill ${round}: integrity_check: ${verdict}`);
  const broken = ask("PRAGMA foreign_key_check");
  if (broken) wrong.push(`after kill ${round}: foreign_key_check: ${broken}`);
  return {
    running: ask("SELECT count(*) FROM jobs WHERE state = 'running'") > 0,
    queued: ask("SELECT count(*) FROM jobs WHERE state = 'queued'") > 0,
    delivering: ask("SELECT count(*) FROM deliveries WHERE state = 'pending'") > 0,
  };
}

// Holds what came of all against what has to hold. The daemon has stopped.
async function judge(daemon, jobs, expected, receiver, wrong) {
  const ids = new Set(jobs.map((job) => job.id));
  if (ids.size !== jobs.length) wrong.push(`${jobs.length} keys gave ${ids.size} jobs`);
  for (const job of jobs) {
    const row = await ended(daemon.url, job.id);
    if (row.state !== "succeeded") wrong.push(`job ${job.id}: ${row.state}: ${row.error}`);
    const result = await (await fetch(`${daemon.url}/v1/jobs/${job.id}/result`)).json();
    if (essence(result) !== expected[job.kind].result) wrong.push(`job ${job.id}: its result differs`);
    const log = await (await fetch(`${daemon.url}/v1/jobs/${job.id}/evaluations`)).text();
    if (log !== expected[job.kind].log) wrong.push(`job ${job.id}: its evaluations differ`);
  }
  for (let i = 0; i < 3000 && jobs.some((job) => !receiver.succeeded.has(job.id)); i++) await pause(100);
  for (const job of jobs) {
    const messages = receiver.succeeded.get(job.id);
    if (!messages) wrong.push(`job ${job.id}: its end was never delivered`);
    else if (messages.size !== 1) wrong.push(`job ${job.id}: its end was told by ${messages.size} messages`);
  }
  await daemon.stop();
  const file = join(daemon.state, "quietgear.db");
  const count = Number(sqlite(file, "SELECT count(*) FROM jobs"));
  if (count !== jobs.length) wrong.push(`${jobs.length} jobs were accepted, ${count} are there`);
  const twice = sqlite(file, "SELECT job, count(*) FROM deliveries WHERE event = 'job.succeeded' GROUP BY job HAVING count(*) <> 1");
  if (twice) wrong.push(`finished more than once: ${twice}`);
  const attempts = Number(sqlite(file, "SELECT sum(attempt) FROM jobs"));
  return { attempts };
}

// Runs so many rounds. Returns figures, and the list of what was wrong.
export async function campaign({ rounds, seed = 1, longest = 1500, waiting = 6, tell = () => {} }) {
  const random = generator(seed);
  const work = mkdtempSync(join(tmpdir(), "quietgear-kill-"));
  const wrong = [];
  const met = { running: 0, queued: 0, delivering: 0 };
  const expected = await undisturbed(work);
  const receiver = await receive(generator(seed + 1));
  const hook = `http://127.0.0.1:${receiver.port}/`;
  const daemon = await startDaemon({ jobs: "2", "webhook-allow": hook, "webhook-networks": "127.0.0.0/8", "webhook-retry": "1" });
  const token = readFileSync(join(daemon.state, "admin.token"), "utf8").trim();
  const made = await fetch(`${daemon.url}/v1/webhooks`, {
    method: "POST",
    headers: { "Content-Type": "application/json", Authorization: `Bearer ${token}` },
    body: JSON.stringify({ url: hook, events: ["job.queued", "job.running", "job.succeeded", "job.failed"] }),
  });
  if (made.status !== 201) throw new Error(`the webhook: ${made.status} ${await made.text()}`);
  const client = submitter(daemon, generator(seed + 2), waiting, wrong);
  for (let round = 1; round <= rounds; round++) {
    await pause(random() * longest);
    await daemon.stop("SIGKILL");
    const state = inspect(daemon, work, wrong, round);
    for (const what of Object.keys(met)) met[what] += state[what] ? 1 : 0;
    await daemon.start();
    tell(round, client.jobs.length);
  }
  await client.stop();
  const { attempts } = await judge(daemon, client.jobs, expected, receiver, wrong);
  receiver.server.close();
  receiver.server.closeAllConnections();
  await daemon.remove();
  rmSync(work, { recursive: true, force: true });
  const repeated = client.jobs.filter((job) => job.tries > 1).length;
  return { rounds, jobs: client.jobs.length, repeated, again: client.again.count, attempts, met, wrong };
}
