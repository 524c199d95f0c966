// What the page's tests share: a daemon of their own on a free port, a headless Chromium, and documents. Used by node's own
// test runner; QG_BUILD is the build tree, QG_SOURCE the sources, CHROMIUM the browser (/usr/bin/chromium).
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const here = import.meta.dirname ?? new URL(".", import.meta.url).pathname;
export const SOURCE = process.env.QG_SOURCE || resolve(here, "../..");
export const BUILD = process.env.QG_BUILD || SOURCE;
export const CHROMIUM = process.env.CHROMIUM || "/usr/bin/chromium";
const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-first-run",
];

// How long is waited for what has to happen: against hanging only, for nobody knows what else the machine does.
const PATIENCE_MS = 120000 * Number(process.env.QG_PATIENCE || 1);

const playwright = await import("playwright-core").catch(() => null);

// Why the tests cannot run here, or false: the value of node:test's `skip`.
export const skip = !playwright
  ? "playwright-core is not installed: npm ci in tests/"
  : !existsSync(CHROMIUM)
    ? `there is no ${CHROMIUM}`
    : false;

export async function launch(options = {}) {
  const browser = await playwright.chromium.launch({ executablePath: CHROMIUM, args: FLAGS, timeout: PATIENCE_MS, ...options });
  for (const name of ["newContext", "newPage"]) {
    const open = browser[name].bind(browser);
    browser[name] = async (...given) => {
      const opened = await open(...given);
      opened.setDefaultTimeout(PATIENCE_MS);
      return opened;
    };
  }
  return browser;
}

// A port that was free a moment ago: the daemon has to come back on the same one after a restart. Below those that the system
// gives to connections that go out, or one of them might have it by then.
function freePort() {
  return new Promise((done) => {
    const server = createServer();
    const attempt = () => server.listen(10240 + Math.floor(Math.random() * 22000), "127.0.0.1");
    server.on("error", attempt);
    server.on("listening", () => {
      const { port } = server.address();
      server.close(() => done(port));
    });
    attempt();
  });
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function waitUntilUp(url, child) {
  for (const end = Date.now() + PATIENCE_MS; Date.now() < end; ) {
    if (child.exitCode !== null) throw new Error(`the daemon ended with status ${child.exitCode}`);
    const answer = await fetch(`${url}/healthz`).catch(() => null);
    if (answer?.ok) return;
    await pause(50);
  }
  throw new Error("the daemon did not come up");
}

// A daemon on a state directory of its own, with more flags: {url, state, log, stop(signal), start(), remove()}. One
// built with sanitizers must not have complained when it is removed.
export async function startDaemon(more = {}) {
  const port = await freePort();
  const state = mkdtempSync(join(tmpdir(), "quietgear-page-"));
  const url = `http://127.0.0.1:${port}`;
  const built = join(BUILD, "web/dist");
  const daemon = { url, state, child: null, log: "" };
  daemon.start = async () => {
    const flags = {
      config: "/dev/null",
      listen: `127.0.0.1:${port}`,
      "state-dir": state,
      "web-dir": existsSync(built) ? built : join(SOURCE, "web/dist"),
      "schema-dir": join(SOURCE, "schema"),
      ...more,
    };
    const words = Object.entries(flags).flatMap(([name, value]) => [`--${name}`, value]);
    daemon.child = spawn(join(BUILD, "quietgeard"), words, { stdio: ["ignore", "ignore", "pipe"] });
    daemon.child.stderr.on("data", (piece) => (daemon.log += piece));
    await waitUntilUp(url, daemon.child);
  };
  daemon.stop = (signal = "SIGTERM") =>
    new Promise((done) => {
      if (daemon.child.exitCode !== null || daemon.child.signalCode !== null) return done();
      daemon.child.once("exit", done);
      daemon.child.kill(signal);
    });
  daemon.remove = async () => {
    await daemon.stop();
    const complaint = /^.*(Sanitizer|runtime error)[^]*/m.exec(daemon.log);
    if (complaint) throw new Error(complaint[0]);
    rmSync(state, { recursive: true, force: true });
  };
  await daemon.start();
  return daemon;
}

export function example(name) {
  return JSON.parse(readFileSync(join(SOURCE, "schema/examples", `${name}.json`), "utf8"));
}

// The example optimization with small figures, so that it takes a second. change(document) may alter it.
export function smallDocument(change = () => {}) {
  const document = example("case_S_optimize");
  document.name = "small";
  document.labels = ["test"];
  document.optimizer = { ...document.optimizer, random_samples: 12, simplex_iterations: 6 };
  document.analysis = { ...document.analysis, speeds: { min: 0.2, max: 1.4, count: 60 } };
  document.reliability = { ...document.reliability, samples: 20 };
  change(document);
  return document;
}

// A job that keeps the daemon busy for longer than any test.
export const endless = (document) => (document.optimizer.random_samples = 1000000);

export async function submit(url, document) {
  const answer = await fetch(`${url}/v1/jobs`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(document),
  });
  if (answer.status !== 201) throw new Error(await answer.text());
  return (await answer.json()).id;
}

// Waits until a job has a state.
export async function waitForState(url, id, state) {
  for (const end = Date.now() + PATIENCE_MS; Date.now() < end; ) {
    const job = await (await fetch(`${url}/v1/jobs/${id}`, { headers: { Prefer: "wait=1" } })).json();
    if (job.state === state) return job;
    if (job.finished_at) throw new Error(`the job ${job.state}: ${job.error}`);
  }
  throw new Error(`waited in vain for ${state}`);
}
