// Crowds of clients that want the daemon to hold much: bodies that never end, answers that nobody reads, streams, long polls,
// documents that are hard to parse, jobs as large as they may be. Each is played against a daemon of its own and tells what came
// back and the daemon's largest resident set. memory.mjs writes the figures down, memory.test.mjs holds small ones to a bound.
import { readFileSync } from "node:fs";
import net from "node:net";
import { example, startDaemon, submit, waitForState } from "../page/harness.mjs";
import { pause } from "./drive.mjs";

export const ALLOWANCE_MB = 268; // HELD_BYTES_MAX of server/http/http.c
const BODY = 1 << 20;

// The largest resident set of a process so far, MB.
export function peakMb(pid) {
  return (Number(/VmHWM:\s*(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) * 1024) / 1e6;
}

// Whether a process is built with sanitizers, which keep books on memory in memory.
export const isSanitized = (pid) => /lib(asan|tsan)/.test(readFileSync(`/proc/${pid}/maps`, "utf8"));

// Connections from several addresses of the loopback network: one address may have half of all places only. Each sends `text`,
// the i-th one text(i) when it is a function, and `bytes`, keeps the beginning of what it is told, and stops reading unless `reads`.
async function connect(url, count, text, { bytes = null, reads = false } = {}) {
  const { hostname, port } = new URL(url);
  const open = (i) =>
    new Promise((done) => {
      const socket = net.connect({ host: hostname, port: Number(port), localAddress: `127.0.0.${2 + (i % 4)}` });
      const client = { socket, said: "" };
      socket.on("error", () => done(client));
      socket.on("data", (part) => {
        if (client.said.length < 64) client.said += part.toString("latin1", 0, 64);
        if (!reads) socket.pause();
      });
      socket.on("connect", () => {
        socket.write(typeof text === "function" ? text(i) : text);
        if (bytes) socket.write(bytes);
        done(client);
      });
    });
  const clients = [];
  while (clients.length < count) {
    const batch = Math.min(100, count - clients.length);
    clients.push(...(await Promise.all(Array.from({ length: batch }, (_, i) => open(clients.length + i)))));
  }
  return clients;
}

const close = (clients) => clients.forEach(({ socket }) => socket.destroy());

// How many were told which status; "none" so far.
function statuses(clients) {
  const count = {};
  for (const { said } of clients) {
    const status = /^HTTP\/1\.1 (\d+)/.exec(said)?.[1] ?? "none";
    count[status] = (count[status] ?? 0) + 1;
  }
  return Object.entries(count)
    .map(([status, n]) => `${n} × ${status}`)
    .join(", ");
}

// Waits until what `look` tells has not changed for a second, ten at most.
async function settle(look) {
  let last = look();
  for (let i = 0, same = 0; i < 40 && same < 4; i++) {
    await pause(250);
    const next = look();
    same = next === last ? same + 1 : 0;
    last = next;
  }
}

const get = (path, fields = "") => `GET ${path} HTTP/1.1\r\nHost: localhost\r\n${fields}\r\n`;
const post = (path, length) =>
  `POST ${path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: ${length}\r\n\r\n`;

// Plays one scene: play(daemon) resolves to what came back. Resolves to {answers, before, peak}, MB.
async function scene(flags, play) {
  const daemon = await startDaemon({ jobs: "2", threads: "2", ...flags });
  try {
    const before = peakMb(daemon.child.pid);
    const answers = await play(daemon);
    const alive = await fetch(`${daemon.url}/healthz`);
    if (!alive.ok) throw new Error(`/healthz answered ${alive.status}`);
    return { answers, before, peak: peakMb(daemon.child.pid), sanitized: isSanitized(daemon.child.pid) };
  } finally {
    await daemon.remove();
  }
}

async function crowd(daemon, count, words, options) {
  const clients = await connect(daemon.url, count, words, options);
  await settle(() => `${statuses(clients)} ${peakMb(daemon.child.pid)}`);
  return clients;
}

export const nobody = () => scene({}, async () => "");

// Bodies of 1 MiB but for the last byte, and then that.
export const slowBodies = (count) =>
  scene({}, async (daemon) => {
    const clients = await crowd(daemon, count, post("/v1/jobs", BODY), { bytes: Buffer.alloc(BODY - 1, " "), reads: true });
    for (const { socket } of clients) socket.writable && socket.write(" ");
    await settle(() => statuses(clients));
    const answers = statuses(clients);
    close(clients);
    return answers;
  });

// A job whose result has some 12 MB.
async function largeResult(daemon) {
  const document = example("case_S_standard");
  document.analysis = { speeds: { min: 0.2, max: 1.4, count: 100000 } };
  const id = await submit(daemon.url, document);
  await waitForState(daemon.url, id, "succeeded");
  return id;
}

// Clients that ask for a large result and read nothing of it; and when they are gone, one that does.
export const unreadResults = (count, fields = () => "") =>
  scene({}, async (daemon) => {
    const id = await largeResult(daemon);
    const clients = await crowd(daemon, count, (i) => get(`/v1/jobs/${id}/result`, fields(i)));
    const answers = statuses(clients);
    const refused = await fetch(`${daemon.url}/v1/jobs/${id}/result`);
    if (refused.status !== 503 || !refused.headers.get("retry-after") || refused.headers.get("etag")) throw new Error(`one more: ${refused.status}`);
    if ((await refused.json()).type !== "urn:quietgear:problem:unavailable") throw new Error("one more is refused without a word");
    close(clients);
    await pause(300);
    const answer = await fetch(`${daemon.url}/v1/jobs/${id}/result`);
    const { design } = await answer.json();
    if (!(design.f_dte > 0)) throw new Error("the result cannot be had any more");
    return answers;
  });

// Clients that ask for the log of a search, compressed, and read nothing.
export const unreadLogs = (count) =>
  scene({}, async (daemon) => {
    const document = example("case_S_optimize");
    document.analysis = { speeds: { min: 0.2, max: 1.4, count: 8 } };
    document.optimizer = { ...document.optimizer, random_samples: 500, simplex_iterations: 0 };
    const id = await submit(daemon.url, document);
    await waitForState(daemon.url, id, "succeeded");
    const clients = await crowd(daemon, count, get(`/v1/jobs/${id}/evaluations`, "Accept-Encoding: gzip\r\n"));
    const answers = statuses(clients);
    close(clients);
    return answers;
  });

// Event streams, long polls, connections that say nothing.
export const waiting = (count, words) =>
  scene({}, async (daemon) => {
    const clients = await crowd(daemon, count, words);
    const answers = statuses(clients);
    close(clients);
    return answers;
  });
export const eventStreams = (count) => waiting(count, get("/v1/events"));
export const longPolls = (count) => waiting(count, get("/v1/jobs?limit=1", "Prefer: wait=60\r\n"));
export const silent = (count) => waiting(count, "GET /");

// Documents of 1 MiB that become as much as they can when they are read.
export const thickDocuments = (count) =>
  scene({}, async (daemon) => {
    const shapes = [`[${"0,".repeat(BODY / 2 - 2)}0]`, `{${'"":{},'.repeat(BODY / 6 - 2)}"":{}}`, "[".repeat(BODY - 1)];
    const told = {};
    for (let i = 0; i < count; i++) {
      const answer = await fetch(`${daemon.url}/v1/jobs`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: shapes[i % shapes.length],
      });
      await answer.arrayBuffer();
      told[answer.status] = (told[answer.status] ?? 0) + 1;
    }
    return Object.entries(told)
      .map(([status, n]) => `${n} × ${status}`)
      .join(", ");
  });

// The displacements and stresses of a design on the finest mesh that they are to be had for.
export const finestField = () =>
  scene({}, async (daemon) => {
    const document = example("case_H_stresses");
    document.analysis = { ...document.analysis, mesh_refinement: 2 };
    const id = await submit(daemon.url, document);
    await waitForState(daemon.url, id, "succeeded");
    for (let i = 0; i < 240; i++) {
      const answer = await fetch(`${daemon.url}/v1/jobs/${id}/field?load_case=0&position=0.5`);
      await answer.arrayBuffer();
      if (answer.status === 200) return "1 × 200";
      if (answer.status !== 202 && answer.status !== 503) throw new Error(`the field: ${answer.status}`);
      await pause(250);
    }
    throw new Error("the field does not come");
  });

// A job of many speeds, whose curves become long texts. Resolves to the estimate as well.
export async function manySpeeds(count) {
  let told;
  const played = await scene({}, async (daemon) => {
    const document = example("case_S_standard");
    document.analysis = { speeds: { min: 0.2, max: 1.4, count } };
    const id = await submit(daemon.url, document);
    told = (await (await fetch(`${daemon.url}/v1/jobs/${id}`)).json()).estimate.memory_mb;
    await waitForState(daemon.url, id, "succeeded");
    return "1 × succeeded";
  });
  return { ...played, told };
}

// Jobs at the same time, each as large as max-job-memory allows: the document's mesh positions are what the daemon advises.
export const largestJobs = (limitMb, refinement) =>
  scene({ "max-job-memory": String(limitMb) }, async (daemon) => {
    const ids = [];
    for (const name of ["case_S_standard", "case_H_stresses"]) {
      const document = example(name);
      document.analysis = { ...document.analysis, mesh_positions: 512, mesh_refinement: refinement };
      const answer = await fetch(`${daemon.url}/v1/check`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(document),
      });
      const { errors } = await answer.json();
      const advice = errors.find(({ pointer }) => pointer === "/analysis/mesh_positions");
      document.analysis.mesh_positions = Number(/up to (\d+)/.exec(advice.detail)[1]);
      ids.push(await submit(daemon.url, document));
    }
    for (const id of ids) await waitForState(daemon.url, id, "succeeded");
    return `${ids.length} × succeeded`;
  });
