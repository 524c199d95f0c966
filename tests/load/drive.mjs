// What load, soak and their short form share: requests at a constant rate, a queue filled and listed, crowds of event streams,
// figures for docs/reliability.md.
import { appendFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import http from "node:http";
import net from "node:net";
import { join } from "node:path";
import { BUILD } from "../page/harness.mjs";

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));
export const now = () => performance.now();

// The q-th part of the values, sorted ascending: the smallest one that a share q of them does not exceed.
export const quantile = (values, q) => values[Math.min(values.length - 1, Math.max(0, Math.ceil(q * values.length) - 1))];
export const sorted = (values) => [...values].sort((a, b) => a - b);
export const round = (value, digits = 2) => Number(value.toFixed(digits));

// Figures of a section of docs/reliability.md, shown as well. The file is begun anew by beginSection.
let file;
export function beginSection(name) {
  mkdirSync(join(BUILD, "reliability"), { recursive: true });
  file = join(BUILD, "reliability", `${name}.jsonl`);
  writeFileSync(file, "");
}
function put(line) {
  console.log(JSON.stringify(line));
  appendFileSync(file, `${JSON.stringify(line)}\n`);
}
export const text = (words) => put({ text: words });
export const row = (fields) => put({ row: fields });

// Resident memory of a process, KiB.
export function residentKib(pid) {
  return Number(/VmRSS:\s*(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]);
}

// One request on a kept connection; resolves to {status, text}.
export function request(agent, url, options = {}, body = "") {
  return new Promise((done, fail) => {
    const asked = http.request(url, { agent, ...options }, (answer) => {
      const parts = [];
      answer.on("data", (part) => parts.push(part));
      answer.on("end", () => done({ status: answer.statusCode, headers: answer.headers, text: Buffer.concat(parts).toString() }));
      answer.on("error", fail);
    });
    asked.on("error", fail);
    asked.end(body);
  });
}

// Asks for a URL `rate` times a second for `seconds`. Each request has its time in the plan, and its latency counts from
// there: one that cannot be sent in time because others are late counts its waiting as well (no "coordinated omission").
// Returns latencies in ms, sorted.
export async function constantRate(url, rate, seconds) {
  const agent = new http.Agent({ keepAlive: true, maxSockets: 64 });
  const latencies = [];
  const count = rate * seconds;
  const start = now() + 20;
  const open = new Set();
  for (let sent = 0; sent < count; ) {
    for (; sent < count && start + (sent * 1000) / rate <= now(); sent++) {
      const due = start + (sent * 1000) / rate;
      const one = request(agent, url).then(({ status }) => {
        if (status !== 200) throw new Error(`${url} answered ${status}`);
        latencies.push(now() - due);
        open.delete(one);
      });
      open.add(one);
    }
    await pause(1);
  }
  await Promise.all(open);
  agent.destroy();
  return sorted(latencies);
}

// Submits documents, made by document(i), eight at a time; returns the ids.
export async function submitMany(url, count, document) {
  const agent = new http.Agent({ keepAlive: true, maxSockets: 8 });
  const ids = new Array(count);
  let next = 0;
  const worker = async () => {
    for (let i = next++; i < count; i = next++) {
      const answer = await request(agent, `${url}/v1/jobs`, { method: "POST", headers: { "Content-Type": "application/json" } }, JSON.stringify(document(i)));
      if (answer.status !== 201) throw new Error(`POST answered ${answer.status}: ${answer.text}`);
      ids[i] = JSON.parse(answer.text).id;
    }
  };
  await Promise.all(Array.from({ length: 8 }, worker));
  agent.destroy();
  return ids;
}

// Walks through all pages of the list from `path` on. Returns the ids in their order, and the ms that each page took.
export async function listAll(url, path, betweenPages = async () => {}) {
  const agent = new http.Agent({ keepAlive: true });
  const ids = [];
  const times = [];
  while (path) {
    const start = now();
    const answer = await request(agent, url + path);
    times.push(now() - start);
    if (answer.status !== 200) throw new Error(`${path} answered ${answer.status}`);
    ids.push(...JSON.parse(answer.text).jobs.map((job) => job.id));
    path = /<([^>]*)>; rel="next"/.exec(answer.headers.link ?? "")?.[1];
    await betweenPages();
  }
  agent.destroy();
  return { ids, times };
}

// Opens `count` streams of all events; each one's `said` is what came so far, the last 64 KiB of it.
export async function openStreams(url, count) {
  const { hostname, port } = new URL(url);
  const open = () =>
    new Promise((done, fail) => {
      const socket = net.connect({ host: hostname, port: Number(port) });
      const stream = { socket, said: "", closed: false };
      socket.once("error", fail);
      socket.on("close", () => (stream.closed = true));
      socket.on("data", (part) => {
        stream.said = (stream.said + part.toString("latin1")).slice(-65536);
        if (stream.said.includes("\r\n\r\n")) done(stream);
      });
      socket.write("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    });
  const streams = [];
  while (streams.length < count)
    streams.push(...(await Promise.all(Array.from({ length: Math.min(50, count - streams.length) }, open))));
  const refused = streams.find((stream) => !stream.said.startsWith("HTTP/1.1 200"));
  if (refused) throw new Error(`a stream was refused: ${refused.said}`);
  return streams;
}

// Waits until all streams have said what is wanted; returns how many have at the end of the patience.
export async function untilAllSaid(streams, wanted, patienceMs = 120000) {
  const end = now() + patienceMs;
  const heard = () => streams.filter((stream) => stream.said.includes(wanted)).length;
  while (heard() < streams.length && now() < end) await pause(5);
  return heard();
}

export function closeStreams(streams) {
  streams.forEach((stream) => stream.socket.destroy());
}
