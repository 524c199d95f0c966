// What may keep the daemon's one thread of HTTP busy: the heaviest answers, and how long other requests wait meanwhile.
import { execFile, execFileSync } from "node:child_process";
import http from "node:http";
import { join } from "node:path";
import { now, pause, request } from "./drive.mjs";

const LONG = "0".repeat(26);

// Puts a finished job with a long log and a long result beside what the daemon has, and a thousand with many labels.
export function addHeavyJobs(daemon, evaluations = 200000, numbers = 200000) {
  const columns = "seq, id, name, kind, labels, state, submitted_at, started_at, finished_at, document";
  const labels = JSON.stringify(Array.from({ length: 16 }, (_, i) => `label ${i} ${"x".repeat(48)}`));
  const sql = `
    BEGIN;
    INSERT INTO jobs (${columns}) VALUES (1000000, '${LONG}', 'long', 'evaluate', '[]', 'succeeded', 1, 2, 3, '{}');
    WITH RECURSIVE n(i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i < ${evaluations - 1})
      INSERT INTO evaluations SELECT 1000000, i, 'random', ${Array.from({ length: 8 }, (_, i) => `${i}.123456789 + i * 1e-7`)},
        1e-3 + i * 1e-9, 0.1 + i * 1e-7, NULL FROM n;
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ${numbers})
      INSERT INTO outputs SELECT 1000000, 'result', '{"design":[' || group_concat('[' || (i * 1.2345678901) || ',' || (i * 0.123) || ']') || ']}' FROM n;
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 1000)
      INSERT INTO jobs (${columns}) SELECT 1000000 + i, printf('%026d', i), 'labelled', 'evaluate', '${labels}', 'succeeded', 1, 2, 3, '{}' FROM n;
    COMMIT;`;
  execFileSync("sqlite3", ["-cmd", ".timeout 30000", join(daemon.state, "quietgear.db")], { input: sql });
}

// Has curl ask, so that this process does not wait for itself. Returns the bytes that came and the ms that it took.
function ask(url, flags) {
  return new Promise((done, failed) => {
    const start = now();
    execFile("curl", ["-sf", "-o", "/dev/null", "-w", "%{size_download}", ...flags, url], (error, out) =>
      error ? failed(error) : done({ bytes: Number(out), took: now() - start }));
  });
}

// Asks for something heavy; meanwhile, others ask for something light again and again. Adds how long the slowest of those took.
export async function askMeanwhile(daemon, path, flags = []) {
  const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
  const heavy = { done: false };
  const asked = ask(`${daemon.url}${path}`, flags).finally(() => (heavy.done = true));
  let slowest = 0;
  while (!heavy.done) {
    const start = now();
    await request(agent, `${daemon.url}/healthz`);
    slowest = Math.max(slowest, now() - start);
    await pause(1);
  }
  agent.destroy();
  return { ...(await asked), slowest };
}

const gzip = ["-H", "Accept-Encoding: gzip"];
export const heavyRequests = [
  ["a result of 5 MB", `/v1/jobs/${LONG}/result`, []],
  ["the same, gzip", `/v1/jobs/${LONG}/result`, gzip],
  ["200 000 evaluations, CSV", `/v1/jobs/${LONG}/evaluations`, ["-H", "Accept: text/csv"]],
  ["the same, gzip", `/v1/jobs/${LONG}/evaluations`, ["-H", "Accept: text/csv", ...gzip]],
  ["500 jobs with 16 labels each", "/v1/jobs?limit=500", []],
  ["metrics", "/metrics", []],
  ["deleting a job with 200 000 evaluations", `/v1/jobs/${LONG}`, ["-X", "DELETE"]],
];
