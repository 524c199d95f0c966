// The page when things break: reloaded in the middle, the daemon killed in the middle, no token where one is wanted.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, skip, smallDocument, startDaemon, submit } from "./harness.mjs";

let daemon, browser, page;

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  page = await browser.newPage();
  page.setDefaultTimeout(15000);
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

const slow = (name) =>
  smallDocument((one) => {
    one.name = name;
    one.optimizer.random_samples = 150;
    one.analysis.speeds.count = 300;
  });

const isSucceeded = () => page.locator("h1 + .state", { hasText: "succeeded" }).waitFor();

test("a reload in the middle goes on where it was", { skip }, async () => {
  const id = await submit(daemon.url, slow("reloaded"));
  await page.goto(`${daemon.url}/#/jobs/${id}`);
  await page.getByRole("region", { name: "Progress" }).waitFor();
  await page.reload();
  await page.getByRole("heading", { name: "reloaded" }).waitFor();
  await isSucceeded();
});

test(
  "a daemon killed in the middle and started again is found again, and the job ends the same",
  { skip },
  async () => {
    const id = await submit(daemon.url, slow("killed"));
    await page.goto(`${daemon.url}/#/jobs/${id}`);
    await page.getByRole("region", { name: "Progress" }).getByText(/best/).waitFor();
    await daemon.stop("SIGKILL");
    await page.locator(".connection.lost").waitFor();
    await daemon.start();
    await page.getByText("live", { exact: true }).waitFor();
    await isSucceeded();
    const result = async (one) => {
      const { design } = await (await fetch(`${daemon.url}/v1/jobs/${one}/result`)).json();
      return design;
    };
    const [first] = (await (await fetch(`${daemon.url}/v1/jobs?limit=2`)).json()).jobs.filter((job) => job.id !== id);
    assert.deepEqual(await result(id), await result(first.id));
  },
);

test("a job deleted by someone else leaves the view", { skip }, async () => {
  const id = await submit(daemon.url, smallDocument());
  await page.goto(`${daemon.url}/#/jobs/${id}`);
  await isSucceeded();
  await fetch(`${daemon.url}/v1/jobs/${id}`, { method: "DELETE" });
  await page.getByText("This job was deleted.").waitFor();
});

test("where tokens are wanted, the page asks for one and keeps it for the tab", { skip }, async () => {
  const guarded = await startDaemon({ "require-tokens": "always" });
  try {
    await page.goto(`${guarded.url}/#/jobs`);
    const field = page.getByLabel("This server asks for a token");
    await field.fill("wrong");
    await page.getByRole("button", { name: "Use it" }).click();
    await page.locator(".connection.lost").waitFor();
    await field.fill(readFileSync(join(guarded.state, "admin.token"), "utf8").trim());
    await page.getByRole("button", { name: "Use it" }).click();
    await page.getByText("No jobs yet.").waitFor();
    await page.getByText("live", { exact: true }).waitFor();
    await page.reload();
    await page.getByText("live", { exact: true }).waitFor();
    assert.equal(await field.count(), 0);
  } finally {
    await guarded.remove();
  }
});
