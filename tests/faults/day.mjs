// A client's day with a daemon whose disk or memory fails, and what has to hold in the evening.
//
// The day: a webhook is made, a job submitted under a key (again, after a refusal), followed to its end and read in every form;
// lists, metrics, page and schemas are read; a wrong document is checked; a second job is submitted, cancelled and deleted.
// Each answer has to be the right one, which is that of an undisturbed day, or a refusal that says so: a problem document of a
// status 5xx. A connection may also end without an answer (libmicrohttpd knows no other way when it has no memory); that is
// counted, and a campaign may forbid it.
//
// The evening: the database passes its integrity check, and a daemon without faults has every job that was accepted, once, and
// brings it to the right end, to the last bit.
import { existsSync, readFileSync } from "node:fs";
import http from "node:http";
import { join } from "node:path";
import { gunzipSync } from "node:zlib";
import { ask, document, essence, isClearRefusal, pause, query, startDaemon, stopDaemon } from "./programs.mjs";

const KEY = "the-day";

// Receives the webhooks of all days: seen has a path for each message about a job that succeeded.
export async function receive() {
  const seen = new Set();
  const server = http.createServer((request, response) => {
    let body = "";
    request.on("data", (piece) => (body += piece));
    request.on("end", () => {
      if (JSON.parse(body).type === "job.succeeded") seen.add(request.url);
      response.statusCode = 204;
      response.end();
    });
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return {
    seen,
    root: `http://127.0.0.1:${server.address().port}/`,
    close: () => (server.close(), server.closeAllConnections()),
  };
}

export const webhookFlags = (receiver) => ({
  "webhook-allow": receiver.root,
  "webhook-networks": "127.0.0.0/8",
  "webhook-retry": "1",
});

// One call of the day; the answer when it is right, else null. right(answer) judges an answer that is no refusal.
async function call(day, method, path, options, right) {
  const answer = await ask(day.daemon, method, path, options);
  if (answer.hangs) day.wrong.push(`${method} ${path}: no answer in time`);
  else if (answer.status === 0) day.lost.push(`${method} ${path}: ${answer.lost}`);
  else if (isClearRefusal(answer)) day.refused.push(`${method} ${path}: ${answer.body}`);
  else if (right(answer)) return answer;
  else day.wrong.push(`${method} ${path}: ${answer.status} ${String(answer.body).slice(0, 200)}`);
  return null;
}

const json = (answer) => {
  try {
    return JSON.parse(answer.body);
  } catch {
    return null;
  }
};
const body = (answer) => String(answer.headers["content-encoding"] === "gzip" ? gunzipSync(answer.body) : answer.body);

// What has to come back is what came back on the undisturbed day, which writes it down here.
function sameAs(day, name, read = body) {
  return (answer) => {
    if (answer.status !== 200) return false;
    if (day.learns) day.expected[name] ??= read(answer);
    return read(answer) === day.expected[name];
  };
}

const posted = { headers: { "Content-Type": "application/json", "Idempotency-Key": KEY }, body: JSON.stringify(document()) };
const isJob = (answer) => answer.status === 201 && json(answer)?.id;

async function makeWebhook(day) {
  const file = join(day.daemon.state, "admin.token");
  if (!day.hook || !existsSync(file)) return;
  const headers = { "Content-Type": "application/json", Authorization: `Bearer ${readFileSync(file, "utf8").trim()}` };
  const made = await call(
    day,
    "POST",
    "/v1/webhooks",
    { headers, body: JSON.stringify({ url: day.hook, events: ["job.succeeded"] }) },
    (answer) => answer.status === 201,
  );
  day.hooked = Boolean(made);
}

async function submit(day) {
  for (let i = 0; i < day.repeats && !day.id && !day.daemon.ended; i++) {
    if (i > 0) await pause(50);
    const answer = await call(day, "POST", "/v1/jobs", posted, isJob);
    if (answer) day.id = json(answer).id;
  }
}

async function follow(day) {
  const end = Date.now() + day.patience;
  while (Date.now() < end && !day.daemon.ended && !day.state) {
    const answer = await call(day, "GET", `/v1/jobs/${day.id}`, { headers: { Prefer: "wait=1" } }, (a) => json(a)?.state);
    const job = answer && json(answer);
    if (job?.finished_at) day.state = job.state;
    if (job?.state === "failed") day.failure = job.error;
    if (!answer) await pause(50);
  }
}

async function readJob(day) {
  const gzip = { headers: { "Accept-Encoding": "gzip" } };
  const path = `/v1/jobs/${day.id}`;
  await call(day, "GET", `${path}/result`, {}, sameAs(day, "result", (a) => essence(body(a))));
  await call(day, "GET", `${path}/result`, gzip, sameAs(day, "result", (a) => essence(body(a))));
  await call(day, "GET", `${path}/evaluations`, {}, sameAs(day, "evaluations"));
  await call(day, "GET", `${path}/frequency-response`, { headers: { Accept: "text/csv" } }, sameAs(day, "response"));
  await call(day, "GET", `${path}/profile`, {}, sameAs(day, "profile"));
  await call(day, "GET", `${path}/events`, { first: true }, (a) => a.status === 200 && String(a.body).includes("event:"));
}

async function readRest(day) {
  const gzip = { headers: { "Accept-Encoding": "gzip" } };
  const wrong = JSON.stringify({ kind: "evaluate" });
  await call(day, "GET", "/readyz", {}, (a) => a.status === 200);
  await call(day, "GET", "/v1/jobs", gzip, (a) => a.status === 200 && JSON.parse(body(a)).jobs.length === (day.id ? 1 : 0));
  await call(day, "GET", "/metrics", {}, (a) => a.status === 200 && body(a).includes("quietgear_"));
  await call(day, "GET", "/", gzip, sameAs(day, "page"));
  await call(day, "GET", "/v1/schemas/job.schema.json", {}, sameAs(day, "schema"));
  await call(day, "GET", "/v1/examples", {}, sameAs(day, "examples"));
  await call(day, "POST", "/v1/check", { ...posted, body: wrong }, (a) => a.status === 422 && json(a).errors.length > 0);
}

// Submits a job that would run for long, cancels it, and deletes it.
async function changeMind(day) {
  const long = document(1);
  long.optimizer.random_samples = 1000000;
  const options = { headers: { "Content-Type": "application/json" }, body: JSON.stringify(long) };
  const answer = await call(day, "POST", "/v1/jobs", options, isJob);
  if (!answer) return;
  const { id } = json(answer);
  // 409: it has failed before
  const cancelled = await call(day, "POST", `/v1/jobs/${id}/cancel`, {}, (a) => [200, 202, 409].includes(a.status));
  const end = Date.now() + day.patience;
  for (let over = !cancelled; !over && Date.now() < end && !day.daemon.ended; ) {
    const job = await call(day, "GET", `/v1/jobs/${id}`, { headers: { Prefer: "wait=1" } }, (a) => json(a)?.id === id);
    over = job && json(job).finished_at;
    if (!job) await pause(50);
  }
  day.second = { id, cancelled: Boolean(cancelled) && cancelled.status !== 409, asked: Boolean(cancelled), deleted: false };
  const forgotten = cancelled && (await call(day, "DELETE", `/v1/jobs/${id}`, {}, (a) => a.status === 204 || a.status === 409));
  day.second.deleted = forgotten?.status === 204;
}

async function awaitDelivery(day) {
  const end = Date.now() + day.patience;
  while (!day.receiver.seen.has(new URL(day.hook).pathname) && Date.now() < end && !day.daemon.ended) await pause(20);
  if (!day.receiver.seen.has(new URL(day.hook).pathname) && !day.daemon.ended) day.wrong.push("the webhook was never called");
}

// Spends a day. expected is what an undisturbed day has put there (learns: this is that day). repeats: how often a client
// that is refused submits; patience: how long it waits for what has begun, ms.
export async function spendDay(daemon, { expected, receiver = null, number = 0, learns = false, repeats = 5, patience = 15000 }) {
  const hook = receiver && `${receiver.root}day-${number}`;
  const day = { daemon, expected, receiver, hook, learns, repeats, patience, id: null, state: null, refused: [], lost: [], wrong: [] };
  await makeWebhook(day);
  await submit(day);
  if (day.id) await follow(day);
  if (day.state === "failed" && !day.failure) day.wrong.push("the job failed without a reason");
  if (day.state === "succeeded") await readJob(day);
  await readRest(day);
  await changeMind(day);
  if (day.hooked && day.state === "succeeded") await awaitDelivery(day);
  return day;
}

// Looks at what a day left, with a daemon that has no faults, and adds what is wrong. The first daemon is gone.
export async function spendEvening(state, day, expected) {
  const wrong = day.wrong;
  if (existsSync(join(state, "quietgear.db"))) {
    const verdict = query(state, "PRAGMA integrity_check");
    if (verdict !== "ok") wrong.push(`integrity_check: ${verdict}`);
  }
  const daemon = await startDaemon(state);
  if (!daemon.url) {
    wrong.push(`the next daemon does not start: ${daemon.log}`);
    return;
  }
  const evening = { daemon, expected, repeats: 1, patience: 15000, id: null, state: null, refused: [], lost: [], wrong };
  await submit(evening); // the same key again
  if (!evening.id) wrong.push(`the next daemon takes no job: ${evening.refused} ${evening.lost}`);
  else if (day.id && evening.id !== day.id) wrong.push(`job ${day.id} was accepted, and is ${evening.id} now`);
  if (evening.id) await follow(evening);
  const done = day.state === "failed" ? "failed" : "succeeded";
  if (evening.id && evening.state !== done) wrong.push(`the job is ${evening.state} in the end: ${evening.failure}`);
  if (evening.state === "succeeded") await readJob(evening);
  await stopDaemon(daemon);
  judgeJobs(state, day, wrong);
}

// Each key has one job, and what was answered about the second job holds. What was refused may have been done all the same: when
// only the waiting for the disk failed, SQLite says that the transaction did, and finds it complete in the log later.
function judgeJobs(state, day, wrong) {
  const count = Number(query(state, `SELECT count(*) FROM jobs WHERE name = '${document().name}'`));
  if (count !== 1) wrong.push(`the document that was submitted under one key has ${count} jobs`);
  if (!day.second) return;
  const found = query(state, `SELECT state, cancel_requested FROM jobs WHERE id = '${day.second.id}'`);
  if (day.second.deleted && found) wrong.push("a job that was deleted is there");
  if (!day.second.asked && !found) wrong.push("a job that was accepted is gone");
  if (day.second.cancelled && found && !found.startsWith("cancelled")) wrong.push(`a job that was cancelled is ${found}`);
}
