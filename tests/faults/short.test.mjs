// The short forms of the campaigns over whole programs. `make faults` tries every n.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { BUILD } from "../page/harness.mjs";
import { diskCampaign } from "./disk.mjs";
import { commandCampaign, daemonCampaign } from "./memory.mjs";

const skip = existsSync(join(BUILD, "tests/faults/memory.so")) ? false : "no failing memory: make tests/faults/memory.so";

test("a daemon whose disk fails now and then, or from then on, refuses clearly and loses nothing", { skip }, async () => {
  const { calls, rows, wrong } = await diskCampaign({ stride: 131 });
  assert.deepEqual(wrong, []);
  assert.ok(calls > 100 && rows.some(({ tried }) => tried > 1), "there were calls to let fail");
});

test("a command without memory ends with a message or the right result", { skip }, async () => {
  const { sites, wrong } = await commandCampaign({ stride: 41 });
  assert.deepEqual(wrong, []);
  assert.ok(sites.length > 100);
  const { rows, ...large } = await commandCampaign({ only: "all calls above a size", stride: 6 });
  assert.deepEqual(large.wrong, []);
  assert.ok(rows[0].refused > 0, "OpenBLAS, whose buffers are large, was asked for room before it waits for it");
});

test("a daemon without memory refuses clearly and loses nothing", { skip }, async () => {
  const { sites, wrong } = await daemonCampaign({ stride: 211 });
  assert.deepEqual(wrong, []);
  assert.ok(sites.length > 300);
});
