// What the fault campaigns share: running a program, or a daemon, with a library before it that makes calls fail, and asking
// a daemon that may not answer.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import http from "node:http";
import https from "node:https";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { BUILD, SOURCE, smallDocument } from "../page/harness.mjs";

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));
// In memory, if there is such a place: each round waits for the disk some fifty times.
export const SCRATCH = existsSync("/dev/shm") ? "/dev/shm" : tmpdir();
export const scratch = (name) => mkdtempSync(join(SCRATCH, `quietgear-${name}-`));

const PATIENCE = 1000 * 20 * Number(process.env.QG_PATIENCE || 1); // ms, after which a program hangs

// The cheapest optimization there is: four evaluations, on the coarsest mesh. number makes it another one.
export const document = (number = 0) =>
  smallDocument((one) => {
    one.name = `faults ${number}`;
    one.load_cases = [{ torque_fraction: 1 }];
    one.analysis = { mesh_positions: 4, harmonics: 1, speeds: { min: 0.4, max: 1.2, count: 8 } };
    one.optimizer = { method: "random_simplex", random_samples: 2, simplex_iterations: 1, seed: 1 };
    delete one.reliability;
  });

// The members of a result that depend on nothing but the document; null when there is none.
export function essence(text) {
  try {
    const { timing, ...rest } = JSON.parse(text);
    return timing ? JSON.stringify(rest) : null;
  } catch {
    return null;
  }
}

// What a sanitizer complained of, in a program built with one; null.
export const complaint = (log) => /^.*(Sanitizer:|runtime error:)[^]*/m.exec(log)?.[0] ?? null;

const sanitizer = { ASAN_OPTIONS: "verify_asan_link_order=0:allocator_may_return_null=1" };

// Runs a program to its end: {status, signal, hangs, out, error}.
export function run(program, words, more = {}) {
  return new Promise((done) => {
    const child = spawn(join(BUILD, program), words, { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, ...sanitizer, ...more } });
    const ended = { out: "", error: "", hangs: false };
    const late = setTimeout(() => {
      ended.hangs = true;
      child.kill("SIGKILL");
    }, PATIENCE);
    child.stdout.on("data", (piece) => (ended.out += piece));
    child.stderr.on("data", (piece) => (ended.error += piece));
    child.on("close", (status, signal) => {
      clearTimeout(late);
      done({ ...ended, status, signal });
    });
  });
}

// --- a daemon ---

const flagsOf = (daemon) => ({
  config: "/dev/null",
  listen: "127.0.0.1:0",
  "port-file": daemon.portFile,
  "state-dir": daemon.state,
  "web-dir": existsSync(join(BUILD, "web/dist")) ? join(BUILD, "web/dist") : join(SOURCE, "web/dist"),
  "schema-dir": join(SOURCE, "schema"),
  jobs: "1",
  threads: "1",
  ...daemon.flags,
});

async function waitForPort(daemon) {
  const end = Date.now() + PATIENCE;
  while (!daemon.ended && Date.now() < end) {
    if (existsSync(daemon.portFile)) return Number(readFileSync(daemon.portFile, "utf8"));
    await pause(5);
  }
  return 0;
}

// Starts a daemon on a state directory, which need not exist. {state, log, url ("" when it did not come up), ended: null or
// {status, signal}}.
export async function startDaemon(state, { env = {}, flags = {} } = {}) {
  const daemon = { state, flags, portFile: `${state}.port`, log: "", url: "", ended: null };
  rmSync(daemon.portFile, { force: true });
  const words = Object.entries(flagsOf(daemon)).flatMap(([name, value]) => [`--${name}`, value]);
  daemon.child = spawn(join(BUILD, "quietgeard"), words, { stdio: ["ignore", "ignore", "pipe"], env: { ...process.env, ...sanitizer, ...env } });
  daemon.child.stderr.on("data", (piece) => (daemon.log += piece));
  daemon.gone = new Promise((done) =>
    daemon.child.on("close", (status, signal) => done((daemon.ended = { status, signal }))),
  );
  const port = await waitForPort(daemon);
  const secure = Boolean(flags["tls-certificate"]);
  if (port) daemon.url = `${secure ? "https" : "http"}://127.0.0.1:${port}`;
  daemon.agent = new (secure ? https : http).Agent({ keepAlive: true, rejectUnauthorized: false });
  return daemon;
}

// Asks it to stop, and kills it when it does not within its patience. {status, signal, hangs}.
export async function stopDaemon(daemon) {
  daemon.agent.destroy();
  if (!daemon.ended) daemon.child.kill("SIGTERM");
  const late = setTimeout(() => ((daemon.hangs = true), daemon.child.kill("SIGKILL")), PATIENCE);
  const ended = await daemon.gone;
  clearTimeout(late);
  return { ...ended, hangs: Boolean(daemon.hangs) };
}

// One request. {status, headers, body (a Buffer)}, or {status: 0, lost: why} when no whole answer came. first: the answer is
// a stream, of which the first piece is enough.
export function ask(daemon, method, path, { headers = {}, body = "", first = false, patience = PATIENCE } = {}) {
  return new Promise((done) => {
    const lose = (error) => done({ status: 0, lost: error.message, hangs: error.message === "late", body: Buffer.alloc(0) });
    const make = daemon.url.startsWith("https") ? https.request : http.request;
    const asked = make(daemon.url + path, { agent: daemon.agent, method, headers: { ...headers, "Content-Length": Buffer.byteLength(body) } });
    asked.setTimeout(patience, () => asked.destroy(new Error("late")));
    asked.on("error", lose);
    asked.on("response", (answer) => {
      const pieces = [];
      const finish = () => done({ status: answer.statusCode, headers: answer.headers, body: Buffer.concat(pieces) });
      answer.on("data", (piece) => {
        pieces.push(piece);
        if (first) finish(), asked.destroy();
      });
      answer.on("end", finish);
      answer.on("error", lose);
    });
    asked.end(body);
  });
}

// True for an answer that says clearly that the daemon could not: a problem document of a status 5xx.
export function isClearRefusal(answer) {
  if (answer.status < 500 || answer.headers["content-type"] !== "application/problem+json") return false;
  try {
    const problem = JSON.parse(answer.body);
    return problem.status === answer.status && problem.type.startsWith("urn:quietgear:problem:") && problem.title.length > 0;
  } catch {
    return false;
  }
}

// What an SQL statement answers, asked of the database that a daemon left.
export function query(state, sql) {
  const { status, stdout, stderr } = spawnSync("sqlite3", [join(state, "quietgear.db"), sql], { encoding: "utf8" });
  if (status !== 0) throw new Error(`sqlite3: ${stderr}`);
  return stdout.trim();
}
