// The kill campaign's short form. `make kill` has 200 rounds.
import assert from "node:assert/strict";
import { test } from "node:test";
import { campaign } from "./campaign.mjs";

test("a daemon killed six times under load loses nothing, finishes nothing twice and changes no bit", async () => {
  const figures = await campaign({ rounds: 6, seed: 3, longest: 700, waiting: 2 });
  assert.deepEqual(figures.wrong, []);
  assert.ok(figures.jobs > 0 && figures.met.running + figures.met.queued > 0, "it was killed while there was something to lose");
});
