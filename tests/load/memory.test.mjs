// Crowds that want the daemon to hold much, in their short form: its memory stays below a bound, those that do not fit are told
// so, and there is room again when they have gone. `make memory` plays larger ones, and more of them.
import assert from "node:assert/strict";
import { test } from "node:test";
import * as crowds from "./crowds.mjs";

const MOST_MB = crowds.ALLOWANCE_MB + 120;

// The daemon's memory has not grown by more; nobody can tell under sanitizers.
function staysBelow({ before, peak, sanitized }, most) {
  if (!sanitized) assert.ok(peak - before < most, `grew from ${before} to ${peak} MB`);
}

test("bodies that come slowly share an allowance", async () => {
  const scene = await crowds.slowBodies(450);
  staysBelow(scene, MOST_MB);
  assert.match(scene.answers, /× 503/);
  assert.match(scene.answers, /× 400/); // those that fitted were read: blanks are no document
});

test("answers that nobody reads share it as well, plain and compressed", async () => {
  const scene = await crowds.unreadResults(30, (i) => (i % 2 ? "Accept-Encoding: gzip\r\n" : ""));
  staysBelow(scene, MOST_MB);
  assert.match(scene.answers, /× 503/);
  assert.match(scene.answers, /× 200/);
});

test("documents made to be thick when they are read cost little", async () => {
  const scene = await crowds.thickDocuments(6);
  staysBelow(scene, 100);
  assert.match(scene.answers, /^6 × 4\d\d$|^\d × 4\d\d, \d × 4\d\d$/);
});

test("the texts that a job leaves are in its estimate", async () => {
  const scene = await crowds.manySpeeds(60000);
  staysBelow(scene, scene.told);
});

test("jobs as large as they may be, two at a time, take what was allowed them", async () => {
  const scene = await crowds.largestJobs(250, 1);
  staysBelow(scene, 2 * 250);
  assert.equal(scene.answers, "2 × succeeded");
});
