// Draws the pictures of the page in docs/: runs the examples on a daemon of its own and looks at the main views.
// screenshots.mjs DIRECTORY
import { join } from "node:path";
import { example, launch, skip, startDaemon, submit, waitForState } from "./harness.mjs";

const directory = process.argv[2];
if (!directory || skip) {
  console.error(skip || "usage: screenshots.mjs DIRECTORY");
  process.exit(2);
}
const WIDTH = 1280;

const daemon = await startDaemon();
const browser = await launch();
try {
  const ids = {};
  for (const name of ["case_S_standard", "case_S_map_radii", "case_S_branches", "case_S_optimize"]) {
    ids[name] = await submit(daemon.url, example(name));
    await waitForState(daemon.url, ids[name], "succeeded");
  }
  const endless = example("case_S_optimize_parabolic");
  endless.name = "28/43 wide search";
  endless.labels = [];
  endless.optimizer.random_samples = 2000;
  const running = await submit(daemon.url, endless);
  const search = ids.case_S_optimize;
  const views = [
    {
      file: "page-jobs",
      hash: "#/jobs",
      ready: "progress",
      height: 400,
      until: () => document.querySelector("progress").position > 0.1,
    },
    { file: "page-job", hash: `#/jobs/${search}`, ready: ".long", height: 1250 },
    {
      file: "page-job-dark",
      hash: `#/jobs/${ids.case_S_branches}`,
      ready: ".legend-table",
      height: 900,
      colorScheme: "dark",
    },
    {
      file: "page-map",
      hash: `#/jobs/${ids.case_S_map_radii}`,
      ready: ".long",
      height: 640,
      from: "#panel-map-of-f-dte",
    },
    {
      file: "page-compare",
      hash: `#/compare?designs=${search}:design,${search}:reference,${ids.case_S_map_radii}:design`,
      ready: ".legend-table",
      height: 760,
    },
    { file: "page-new", hash: `#/new?from=${search}`, ready: "h1", height: 1100 },
  ];
  for (const { file, hash, ready, height, colorScheme = "light", from, until } of views) {
    const page = await browser.newPage({ colorScheme, viewport: { width: WIDTH, height } });
    await page.goto(`${daemon.url}/${hash}`);
    await page.locator(ready).first().waitFor();
    if (until) await page.waitForFunction(until, null, { timeout: 60000 });
    if (from) await page.locator(from).evaluate((element) => element.closest("section").scrollIntoView());
    if (from) await page.evaluate(() => scrollBy(0, -60));
    await page.waitForTimeout(800); // curves and images settle
    await page.screenshot({ path: join(directory, `${file}.png`) });
    await page.close();
    console.log(`${file}.png`);
  }
  await fetch(`${daemon.url}/v1/jobs/${running}/cancel`, { method: "POST" });
} finally {
  await browser.close();
  await daemon.remove();
}
