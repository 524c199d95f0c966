// What results of several kinds look like on the page: answers of the daemon with members changed on their way to the browser,
// so that rare cases need no long computation.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { launch, skip, smallDocument, startDaemon, submit, waitForState } from "./harness.mjs";

let daemon, browser, page, id, result;

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  page = await browser.newPage();
  page.setDefaultTimeout(10000);
  id = await submit(daemon.url, smallDocument());
  await waitForState(daemon.url, id, "succeeded");
  result = await (await fetch(`${daemon.url}/v1/jobs/${id}/result`)).json();
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

// Opens the job's view with a changed result.
async function show(change) {
  const changed = structuredClone(result);
  change(changed);
  await page.unroute("**/result");
  await page.route("**/result", (route) => route.fulfill({ json: changed }));
  await page.goto("about:blank");
  await page.goto(`${daemon.url}/#/jobs/${id}`);
  await page.locator(".keys, .panels").first().waitFor();
}

const region = (name) => page.getByRole("region", { name, exact: true });

test("a macro search's pairs are listed, and one becomes a new job", { skip }, async () => {
  const pair = (sample, teeth, f_dte) => ({
    evaluation: sample,
    sample,
    among_best: true,
    on_front: sample === 1,
    contact_ratio: 1.9,
    contact_stress_factor: 0.98,
    root_stress_factor: 0.8,
    judged: true,
    f_pps_um: 4.5,
    f_dte,
    max_contact_pressure_mpa: 1100,
    max_root_stress_mpa: 320,
    loaded_contact_ratio: 2.2,
    mean_mesh_stiffness_n_per_mm: 3e5,
    geometry: { ...result.geometry, backlash_mm: teeth / 100 },
    gear_pair: { ...result.job.gear_pair, pinion: { ...result.job.gear_pair.pinion, teeth } },
  });
  await show((one) => {
    one.macro = {
      samples: 1000,
      passed: 2,
      rejected: [
        { constraint: "tip_clearance", count: 998 },
        { constraint: "hob", count: 0 },
      ],
      initial: { contact_ratio: 1.2, iso_contact_stress_mpa: 1200, iso_root_stress_mpa: 500 },
      front_size: 1,
      best: 1,
      candidates: [pair(1, 31, 0.3), pair(2, 32, 0.2)],
    };
  });
  await page.getByRole("table", { name: /^Gear pairs found/ }).waitFor();
  const rows = page.getByRole("table", { name: /^Gear pairs found/ }).locator("tbody tr:not(.filler)");
  assert.equal(await rows.count(), 2);
  assert.match(await rows.first().innerText(), /32\/43/); // sorted by F_DTE, the quietest first
  assert.match(await rows.first().innerText(), /0\.3200/); // a backlash of its own
  assert.equal(await region("Constraints").getByText("fail by tip clearance").count(), 1);
  assert.equal(await region("Constraints").getByText("fail by hob").count(), 0);
  await page.getByRole("button", { name: "Use sample 2 as new job" }).click();
  await page.waitForURL(/#\/new/);
  const draft = await page.evaluate(() => JSON.parse(sessionStorage.getItem("quietgear.draft")).text);
  assert.equal(JSON.parse(draft).gear_pair.pinion.teeth, 32);
});

test("a Pareto front is drawn for every pair of objectives", { skip }, async () => {
  const member = (evaluation, f_pps_um, f_dte) => ({
    evaluation,
    relief: {},
    f_pps_um,
    f_dte,
    f_dte_percentile: f_dte * 1.1,
  });
  await show((one) => {
    one.job.objectives = ["f_dte", "f_pps", "f_dte_percentile"];
    one.search.pareto = [member(3, 5, 0.3), member(4, 6, 0.2)];
  });
  const front = region("Pareto front");
  await front.getByLabel("Objectives shown").selectOption("1");
  assert.deepEqual(await front.getByLabel("Objectives shown").locator("option").allInnerTexts(), [
    "F_DTE and F_PPS",
    "F_DTE and F_DTE, percentile",
    "F_PPS and F_DTE, percentile",
  ]);
  assert.match(await front.locator(".plot-area").getAttribute("aria-label"), /2 designs/);
});

test("branches are drawn, unstable ones dashed, and what is far above waits for a wish", { skip }, async () => {
  await show((one) => {
    one.design.load_cases[0].branches = [
      {
        period: 1,
        ends: ["range", "amplitude"],
        frequency_ratio: [0.5, 0.6, 0.55, 0.7],
        rms: [0.1, 1, 2, 9],
        mean: [1, 1, 1, 1],
        stable: [true, true, false, false],
        multipliers: [],
        special_points: [{ type: "fold", frequency_ratio: 0.6, rms: 1 }],
      },
    ];
  });
  const response = region("Amplitude against frequency");
  await response.getByRole("button", { name: "unstable, 155 N m" }).waitFor();
  assert.equal(
    await response.getByRole("button", { name: "unstable, 155 N m" }).locator("line").getAttribute("stroke-dasharray"),
    "4 3",
  );
  await response.getByRole("button", { name: "Whole range" }).click();
  const stable = response.getByRole("button", { name: "stable, 155 N m", exact: true });
  await stable.click();
  assert.equal(await stable.getAttribute("aria-pressed"), "false");
});

test("a result without dynamics, without a reference and with warnings is shown", { skip }, async () => {
  await show((one) => {
    one.reference = one.improvement = one.search = one.reliability = null;
    one.design.f_dte = null;
    for (const loadCase of one.design.load_cases) {
      loadCase.frequency_response = loadCase.max_rms = loadCase.max_rms_at = loadCase.max_rms_at_pinion_rpm = null;
    }
    one.warnings = ["/relief: <b>careful</b>"];
  });
  await page.getByText("/relief: <b>careful</b>").waitFor();
  assert.equal(await region("Amplitude against frequency").count(), 0);
  await region("Static transmission error").locator(".plot-area").waitFor();
});

test("a search without any candidate is shown", { skip }, async () => {
  await show((one) => {
    one.design = one.reference = one.improvement = one.search = one.reliability = null;
    one.macro = {
      samples: 10,
      passed: 0,
      rejected: [{ constraint: "ratio", count: 10 }],
      initial: { contact_ratio: 1.2 },
      front_size: 0,
      best: null,
      candidates: [],
    };
  });
  await region("Constraints").getByText("satisfy all").waitFor();
  assert.equal(await region("Gear pairs found").count(), 0);
});
