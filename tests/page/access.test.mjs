// Accessibility, judged by axe-core: no view has a serious or critical finding, light or dark, wide or narrow.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before, test } from "node:test";
import { example, launch, skip, smallDocument, startDaemon, submit, waitForState } from "./harness.mjs";

let daemon, browser, search, map;

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  search = await submit(daemon.url, smallDocument());
  const document = example("case_S_map_amplitudes");
  document.grid = document.grid.map((axis) => ({ ...axis, count: 4 }));
  document.analysis = { ...document.analysis, speeds: { min: 0.2, max: 1.4, count: 30 } };
  map = await submit(daemon.url, document);
  await waitForState(daemon.url, search, "succeeded");
  await waitForState(daemon.url, map, "succeeded");
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

// What axe-core finds serious or critical, in words.
async function findings(page) {
  const source = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  await page.evaluate(source);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .map(
      ({ id, nodes }) =>
        `${id}: ${nodes.map((node) => `${node.html.slice(0, 120)} ${node.failureSummary}`).join(" | ")}`,
    );
}

const VIEWS = {
  jobs: () => ["#/jobs", ".jobs"],
  job: () => [`#/jobs/${search}`, ".long"],
  map: () => [`#/jobs/${map}`, ".keys"],
  compare: () => [`#/compare?designs=${search}:design,${search}:reference,${map}:design`, ".legend-table"],
  "compare, choosing": () => ["#/compare", ".picker li"],
  new: () => ["#/new", ".teeth svg"],
  report: () => [`#/jobs/${search}/report`, "figure.static svg"],
};

for (const colorScheme of ["light", "dark"]) {
  for (const [name, view] of Object.entries(VIEWS)) {
    test(`${name}, ${colorScheme}`, { skip }, async () => {
      const width = colorScheme === "light" ? 1280 : 820; // a laptop, a tablet
      const page = await browser.newPage({ colorScheme, viewport: { width, height: 900 } });
      const [hash, ready] = view();
      await page.goto(`${daemon.url}/${hash}`);
      await page.locator(ready).first().waitFor();
      assert.deepEqual(await findings(page), []);
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(overflow <= 0, `the view is ${overflow} px wider than the window`);
      await page.close();
    });
  }
}

test("the question before deleting", { skip }, async () => {
  const page = await browser.newPage();
  await page.goto(`${daemon.url}/#/jobs`);
  await page.getByRole("button", { name: "Delete small" }).click();
  await page.getByRole("dialog").waitFor();
  assert.deepEqual(await findings(page), []);
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "hidden" });
  await page.close();
});
