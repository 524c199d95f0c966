// The load campaign's short form: what has to hold whatever the machine's speed. `make load` measures.
import assert from "node:assert/strict";
import http from "node:http";
import { after, before, test } from "node:test";
import { endless, smallDocument, startDaemon, submit, waitForState } from "../page/harness.mjs";
import { closeStreams, constantRate, listAll, openStreams, submitMany, untilAllSaid } from "./drive.mjs";
import { addHeavyJobs, askMeanwhile, heavyRequests } from "./heavy.mjs";

let daemon;

before(async () => {
  daemon = await startDaemon({ jobs: "1", threads: "1" });
  const busy = await submit(daemon.url, smallDocument(endless));
  await waitForState(daemon.url, busy, "running");
});

after(async () => {
  await daemon?.remove();
});

test("a list read by cursors has each job once, newest first, while others are added", async () => {
  const before = await submitMany(daemon.url, 600, (i) => smallDocument((one) => (one.name = `before ${i}`)));
  const added = [];
  const add = async () => added.push(...(await submitMany(daemon.url, 20, () => smallDocument((one) => (one.name = "added")))));
  const { ids } = await listAll(daemon.url, "/v1/jobs?state=queued&limit=50", add);
  assert.equal(ids.length, new Set(ids).size, "no job twice");
  const listed = new Set(ids);
  assert.deepEqual(before.filter((id) => !listed.has(id)), [], "no job missing that was there before the first page");
  assert.ok(added.length >= 20 && !added.some((id) => listed.has(id)), "what came later is newer than the pages to come");
  // ids ascend with the millisecond of submission
  const order = ids.map((id) => id.slice(0, 10));
  assert.deepEqual(order, [...order].sort().reverse(), "newest first");
});

test("200 event streams hear of a change, all of them", async () => {
  const streams = await openStreams(daemon.url, 200);
  const id = await submit(daemon.url, smallDocument((one) => (one.name = "announced")));
  const heard = await untilAllSaid(streams, id);
  closeStreams(streams);
  assert.equal(heard, 200);
});

test("requests at a constant rate are all answered while the daemon computes", async () => {
  const { jobs } = await (await fetch(`${daemon.url}/v1/jobs?state=running`)).json();
  const latencies = await constantRate(`${daemon.url}/v1/jobs/${jobs[0].id}`, 100, 2);
  assert.equal(latencies.length, 200);
});

// The log of 60 000 evaluations is read in pages: between them no snapshot is held that would keep the write-ahead log growing.
test("a download that stands still does not let the write-ahead log grow", async () => {
  addHeavyJobs(daemon, 60000, 100000);
  const download = await new Promise((done) => http.get(`${daemon.url}/v1/jobs/${"0".repeat(26)}/evaluations`, done));
  await new Promise((done) => download.once("readable", done)); // and no further
  const walBytes = async () =>
    Number(/^quietgear_database_wal_bytes (.*)$/m.exec(await (await fetch(`${daemon.url}/metrics`)).text())[1]);
  await submitMany(daemon.url, 500, () => smallDocument((one) => (one.name = "x".repeat(150)))); // 35 MB of the log
  const bytes = await walBytes();
  download.destroy();
  assert.ok(bytes < 20 << 20, `the write-ahead log has ${bytes} bytes`);
});

// Answered at once, such a request would have somebody else wait for almost as long as it takes, whatever the machine's speed. That
// somebody waits because the machine does other things happens, too, but not each time.
test("heavy requests are answered in portions, with others in between", async () => {
  const inPortions = heavyRequests.filter(([name]) => /evaluations/.test(name));
  assert.ok(inPortions.length >= 2);
  for (const [name, path, flags] of inPortions) {
    let took, slowest;
    for (let i = 0; i < 20 && !(slowest < took / 2); i++) ({ took, slowest } = await askMeanwhile(daemon, path, flags));
    assert.ok(slowest < took / 2, `${name}: took ${took} ms, and somebody waited ${slowest} ms, twenty times`);
  }
  assert.equal((await fetch(`${daemon.url}/v1/jobs/${"0".repeat(26)}`)).status, 404);
});
