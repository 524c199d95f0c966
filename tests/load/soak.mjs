// Mixed traffic for a long time, the daemon's memory watched: node soak.mjs --minutes N            (make soak SOAK_MINUTES=30)
//
// Two dozen event streams that come and go, jobs of three gear pairs that run, are cancelled and are deleted, readers of
// everything, bad documents, and a webhook whose receiver counts. What is asked for is drawn by a counted generator, the same
// in every run. Memory is sampled every second. The first quarter of the time, in which caches fill, is left out; flat means that
// the 95th percentile of the last quarter is at most FLAT_SHARE above that of the second: what the daemon holds with a job under
// way. The mean is told as well, but goes with how long jobs take, so with what else the machine does.
// Writes the figures for docs/reliability.md; exit status 1 when memory is not flat, or an answer was not one that may come.
import { appendFileSync, readFileSync, writeFileSync } from "node:fs";
import http from "node:http";
import { join } from "node:path";
import { BUILD, example, smallDocument, startDaemon } from "../page/harness.mjs";
import { beginSection, closeStreams, now, openStreams, pause, request, residentKib, round, row, text } from "./drive.mjs";

const at = process.argv.indexOf("--minutes");
const MINUTES = at > 0 ? Number(process.argv[at + 1]) : 30;
const END = now() + MINUTES * 60000;
const FLAT_SHARE = 0.05;
const JOBS_KEPT = 100;
const STREAMS = 24;

let drawn = 20261;
// A whole number from 0 to n - 1 (Numerical Recipes' linear congruential generator).
function draw(n) {
  drawn = (Math.imul(drawn, 1664525) + 1013904223) >>> 0;
  return Math.floor((drawn / 4294967296) * n);
}

const taken = { "job.succeeded": new Set(), "job.failed": new Set() }; // ids of jobs, by webhook
const count = { requests: 0, deliveries: 0, submitted: 0, deleted: 0, streams: 0 };
const strange = [];
const agent = new http.Agent({ keepAlive: true, maxSockets: 16 });
let daemon;

// Asks, and remembers an answer that is not one of those allowed.
async function ask(method, path, allowed, body, headers = {}) {
  const fields = body === undefined ? headers : { "Content-Type": "application/json", ...headers };
  const answer = await request(agent, daemon.url + path, { method, headers: fields }, body ?? "");
  count.requests++;
  if (!allowed.includes(answer.status)) strange.push(`${method} ${path}: ${answer.status} ${answer.text.slice(0, 200)}`);
  return answer;
}

// One of three pairs, a search or a single design, small.
function document(i) {
  return JSON.stringify(
    i % 3 === 2
      ? { ...example("case_H_stresses"), name: `soak ${i}`, labels: ["soak"] }
      : smallDocument((one) => {
          one.name = `soak ${i}`;
          one.labels = ["soak", `part ${i % 7}`];
          one.optimizer.seed = i;
          one.gear_pair.pinion.face_width_mm += i % 2;
        }),
  );
}

const known = []; // ids of jobs, oldest first
const someJob = () => known[draw(known.length)];

const deeds = [
  async () => {
    if (known.length > JOBS_KEPT) return;
    const answer = await ask("POST", "/v1/jobs", [201], document(count.submitted++), draw(2) ? { "Idempotency-Key": `"${count.submitted}"` } : {});
    if (answer.status === 201) known.push(JSON.parse(answer.text).id);
  },
  async () => known.length && ask("GET", `/v1/jobs/${someJob()}`, [200, 404], undefined, draw(3) ? {} : { Prefer: "wait=1" }),
  async () => ask("GET", `/v1/jobs?limit=${1 + draw(100)}${draw(2) ? "&state=succeeded" : "&label=soak"}`, [200]),
  async () => known.length && ask("GET", `/v1/jobs/${someJob()}/${["result", "frequency-response", "evaluations", "document", "profile"][draw(5)]}`, [200, 404, 409], undefined, draw(2) ? { "Accept-Encoding": "gzip" } : {}),
  async () => ask("POST", "/v1/check", [200, 400, 422], draw(2) ? document(draw(9)) : document(1).replace(/\d/g, (digit) => (draw(9) ? digit : "9"))),
  async () => ask("POST", "/v1/jobs", [400, 422], `{"kind":"map","colour":${draw(9)}`.slice(0, 5 + draw(30))),
  async () => ask("GET", ["/", "/assets/page.js", "/openapi.json", "/metrics", "/healthz", "/readyz", "/v1/examples"][draw(7)], [200], undefined, draw(2) ? { "Accept-Encoding": "gzip" } : {}),
  async () => ask("GET", `/${"x".repeat(draw(3000))}%00`, [400]),
  async () => known.length && draw(4) === 0 && ask("POST", `/v1/jobs/${someJob()}/cancel`, [200, 202, 404, 409]),
  async () => {
    const i = draw(known.length);
    if (known.length < JOBS_KEPT / 2) return;
    const answer = await ask("DELETE", `/v1/jobs/${known[i]}`, [204, 404, 409]);
    if (answer.status === 204) count.deleted++;
    if (answer.status !== 409) known.splice(known.indexOf(known[i]), 1);
  },
];

// One of several clients: a deed, a breath, another.
async function client() {
  while (now() < END) {
    await deeds[draw(deeds.length)]();
    await pause(20 + draw(100));
  }
}

// Streams that come and go.
async function followers() {
  let open = [];
  while (now() < END) {
    open.push(...(await openStreams(daemon.url, STREAMS - open.length)));
    count.streams += 8;
    await pause(3000);
    closeStreams(open.splice(0, 8));
  }
  closeStreams(open);
}

// Takes webhooks; refuses one in ten, so that it has to be sent again.
function startReceiver() {
  const server = http.createServer((asked, answer) => {
    const parts = [];
    asked.on("data", (part) => parts.push(part));
    asked.on("end", () => {
      const message = JSON.parse(Buffer.concat(parts).toString());
      const takes = draw(10) > 0;
      count.deliveries++;
      if (takes) taken[message.type].add(message.data.id);
      answer.writeHead(takes ? 204 : 500).end();
    });
  });
  return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
}

async function subscribe(port) {
  const token = readFileSync(join(daemon.state, "admin.token"), "utf8").trim();
  await ask("POST", "/v1/webhooks", [201], JSON.stringify({ url: `http://127.0.0.1:${port}/hooks`, events: Object.keys(taken) }), { Authorization: `Bearer ${token}` });
}

// Samples memory: [[minutes, KiB], ...], also as lines for plotting.
async function watch(samples, log) {
  const start = now();
  while (now() < END) {
    const minutes = (now() - start) / 60000;
    samples.push([minutes, residentKib(daemon.child.pid)]);
    appendFileSync(log, `${round(minutes, 4)} ${samples.at(-1)[1]}\n`);
    await pause(1000);
  }
}

// The line of least squares: {slope, mean}.
function fit(points) {
  const mean = (i) => points.reduce((sum, point) => sum + point[i], 0) / points.length;
  const [x, y] = [mean(0), mean(1)];
  const covariance = points.reduce((sum, point) => sum + (point[0] - x) * (point[1] - y), 0);
  const variance = points.reduce((sum, point) => sum + (point[0] - x) ** 2, 0);
  return { slope: covariance / variance, mean: y };
}

const receiver = await startReceiver();
const hooks = `http://127.0.0.1:${receiver.address().port}`;
daemon = await startDaemon({ "webhook-allow": hooks, "webhook-networks": "127.0.0.0/8", "webhook-retry": "1" });
beginSection("soak");
const log = join(BUILD, "reliability", "soak-memory.txt");
writeFileSync(log, "");
const samples = [];
try {
  await subscribe(receiver.address().port);
  await Promise.all([watch(samples, log), followers(), ...Array.from({ length: 4 }, client)]);
} finally {
  agent.destroy();
  await daemon.remove();
  receiver.close();
}
const quarter = (i) => samples.filter(([minutes]) => minutes >= (i * MINUTES) / 4 && minutes < ((i + 1) * MINUTES) / 4);
const peak = (some) => some.map(([, kib]) => kib).sort((a, b) => a - b)[Math.floor(0.95 * some.length)];
const [second, last] = [quarter(1), quarter(3)].map(peak);
const { slope } = fit(samples.filter(([minutes]) => minutes >= MINUTES / 4));
const isFlat = last <= (1 + FLAT_SHARE) * second;
text("`make soak`: jobs, readers, bad requests, event streams that come and go, and a webhook one in ten of whose deliveries is refused. Memory is that of the daemon (RSS), what 95 % of the samples of the second and of the last quarter of the time do not exceed; flat: the last is at most 5 % above the second. The mean and its trend by least squares, from the second quarter on, go with the share of the time in which jobs run, so with what else the machine does.");
row({
  minutes: MINUTES,
  requests: count.requests,
  "jobs submitted": count.submitted,
  "jobs deleted": count.deleted,
  "event streams": count.streams,
  "jobs succeeded": taken["job.succeeded"].size,
  "jobs failed": taken["job.failed"].size,
  deliveries: count.deliveries,
  "second quarter, MiB": round(second / 1024, 1),
  "last quarter, MiB": round(last / 1024, 1),
  "largest, MiB": round(Math.max(...samples.map((sample) => sample[1])) / 1024, 1),
  "mean, MiB": round(fit(samples).mean / 1024, 1),
  "trend of the mean, KiB/min": round(slope, 1),
  flat: isFlat ? "yes" : "no",
});
for (const words of strange.slice(0, 20)) console.error(`strange: ${words}`);
if (taken["job.succeeded"].size === 0) strange.push("no job succeeded");
process.exit(isFlat && strange.length === 0 ? 0 : 1);
