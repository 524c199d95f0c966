// The views of jobs, of a job, and the comparison, in a real browser against a real daemon.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { endless, launch, skip, smallDocument, startDaemon, submit, waitForState } from "./harness.mjs";

let daemon, browser, context, page;
let finished; // a finished job's id
let result; // and its result
const errors = []; // what the browser complained of

const open = async (hash) => {
  await page.goto("about:blank");
  await page.goto(`${daemon.url}/${hash}`);
};
const getJson = async (path) => (await fetch(`${daemon.url}${path}`)).json();
const numberIn = (text) => Number(text.replaceAll("\u202f", "").replace("\u2212", "-"));

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  context = await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true });
  page = await context.newPage();
  page.setDefaultTimeout(10000);
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => {
    const isTooEarly = message.text().includes("409") && message.location().url.endsWith("/frequency-response");
    if (message.type() === "error" && !isTooEarly) errors.push(message.text());
  });
  finished = await submit(daemon.url, smallDocument());
  await waitForState(daemon.url, finished, "succeeded");
  result = await getJson(`/v1/jobs/${finished}/result`);
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

test("a job appears in the table while one looks, and is watched to its end", { skip }, async () => {
  await open("#/jobs");
  await page.getByText("live", { exact: true }).waitFor();
  const document = smallDocument((one) => {
    one.name = "watched";
    one.optimizer.random_samples = 60;
    one.analysis.speeds.count = 300;
  });
  const id = await submit(daemon.url, document);
  const row = page.locator("tr", { hasText: "watched" });
  await row.getByText("running").waitFor();
  await row.locator("progress").waitFor();
  await row.getByRole("link", { name: "watched" }).click();
  await page.getByRole("region", { name: "Progress" }).getByText(/of/).waitFor();
  await page.locator("h1 + .state", { hasText: "succeeded" }).waitFor();
  const { design, reference, verification } = await getJson(`/v1/jobs/${id}/result`);
  const shows = async (name, before, after) => {
    const shown = page.locator(".key", { has: page.getByText(name, { exact: true }) }).locator("dd");
    await shown.waitFor();
    assert.ok((await shown.innerText()).includes(`${before.f_dte.toFixed(4)} → ${after.f_dte.toFixed(4)}`));
  };
  await shows("F_DTE", reference, design);
  await shows(`F_DTE at ${verification.mesh_positions} positions`, verification.reference, verification.design);
});

// The plot with a title, and its area on the screen.
const plotOf = (title) => page.getByRole("region", { name: title }).locator(".plot-area");

test("a value is read off the curve", { skip }, async () => {
  await open(`#/jobs/${finished}`);
  const area = plotOf("Amplitude against frequency");
  await area.waitFor();
  const box = await area.boundingBox();
  await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2);
  const region = page.getByRole("region", { name: "Amplitude against frequency" });
  const reading = await region.locator(".reading").innerText();
  const [, ratio] = /frequency ratio ([\d.]+)/.exec(reading);
  const { frequency_ratio: ratios, rms } = result.design.load_cases[1].frequency_response;
  const index = ratios.findIndex((one) => Math.abs(one - Number(ratio)) < 1e-4);
  assert.ok(index > 10, reading);
  const value = await region.locator("tr", { hasText: "best" }).locator("output").nth(1).innerText();
  assert.ok(Math.abs(numberIn(value) / rms[index] - 1) < 1e-3, `${value} for ${rms[index]}`);
});

test("the cursor is moved by the keyboard, and says what it reads", { skip }, async () => {
  await open(`#/jobs/${finished}`);
  const area = plotOf("Amplitude against frequency");
  await area.focus();
  await page.keyboard.press("ArrowRight");
  const spoken = area.locator("[aria-live]");
  await spoken.getByText(/best, 155 N m/).waitFor();
  const before = await spoken.textContent();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(
    ([text]) => document.querySelector(".plot-area [aria-live]").textContent !== text,
    [before],
  );
  await page.keyboard.press("+");
  await page.getByRole("button", { name: "Whole range" }).click();
  assert.equal(await page.getByRole("button", { name: "Whole range" }).count(), 0);
});

async function downloadBy(button) {
  const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

test("plots are taken away as CSV, SVG and PNG", { skip }, async () => {
  await open(`#/jobs/${finished}`);
  await plotOf("Amplitude against frequency").waitFor();
  const csv = await downloadBy(page.getByRole("button", { name: "Amplitude against frequency as CSV" }));
  assert.equal(csv.name, "small-frequency-response.csv");
  const [head, ...lines] = csv.bytes.toString().trim().split("\r\n");
  const column = head.match(/("[^"]*"|[^,]+)/g).findIndex((name) => name.includes("best, 155 N m: RMS"));
  const { rms } = result.design.load_cases[0].frequency_response;
  assert.deepEqual(
    lines.map((line) => Number(line.split(",")[column])),
    rms,
  );
  const svg = (
    await downloadBy(page.getByRole("button", { name: "Static transmission error as SVG" }))
  ).bytes.toString();
  assert.match(svg, /^<\?xml/);
  assert.match(svg, /mesh position, mesh periods/);
  assert.match(svg, /static transmission error, µm/);
  assert.match(svg, /best, 470 N m/);
  const isWellFormed = await page.evaluate(
    (text) => !new DOMParser().parseFromString(text, "image/svg+xml").querySelector("parsererror"),
    svg,
  );
  assert.ok(isWellFormed);
  const png = (await downloadBy(page.getByRole("button", { name: "Mesh stiffness as PNG" }))).bytes;
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.equal(png.readUInt32BE(16), 1600);
});

test("the result, the document and the candidates are taken away", { skip }, async () => {
  await open(`#/jobs/${finished}`);
  await page.getByText("Take away").click();
  const saved = await downloadBy(page.getByRole("button", { name: "Result, JSON" }));
  assert.deepEqual(JSON.parse(saved.bytes), result);
  const candidates = (await downloadBy(page.getByRole("button", { name: "Candidates, CSV" }))).bytes.toString();
  assert.ok(candidates.trim().split("\n").length > 20);
  const document = JSON.parse((await downloadBy(page.getByRole("button", { name: "Job document, JSON" }))).bytes);
  assert.deepEqual(document, result.job);
});

test("two designs are chosen in the table and compared", { skip }, async () => {
  const other = await submit(
    daemon.url,
    smallDocument((one) => {
      one.name = "other seed";
      one.optimizer.seed = 2;
    }),
  );
  await waitForState(daemon.url, other, "succeeded");
  const second = await getJson(`/v1/jobs/${other}/result`);
  await open("#/jobs");
  await page.getByLabel("Compare small", { exact: true }).check();
  await page.getByLabel("Compare other seed").check();
  await page.getByRole("button", { name: "Compare 2" }).click();
  const table = page.getByRole("region", { name: "Differences" });
  const cells = table.locator("tr", { hasText: "F_DTE" }).locator("td.number");
  await cells.nth(1).waitFor();
  assert.ok((await cells.nth(0).innerText()).startsWith(result.design.f_dte.toFixed(4)));
  assert.ok((await cells.nth(1).innerText()).startsWith(second.design.f_dte.toFixed(4)));
  const seeds = page.getByRole("region", { name: "Inputs that differ" }).locator("tr", { hasText: "optimizer seed" });
  assert.deepEqual(await seeds.locator("td.number").allInnerTexts(), ["1", "2"]);
  await page.getByText("Designs to compare").click();
  await page.getByRole("group", { name: "other seed" }).getByLabel("reference").check();
  await table.getByText("other seed, reference").waitFor();
  assert.match(page.url(), /reference/);
});

test("jobs are found by state, label and words, and the address keeps the filter", { skip }, async () => {
  await open("#/jobs");
  await page.getByLabel("Search").fill("other");
  await page.locator("tr", { hasText: "watched" }).waitFor({ state: "detached" });
  assert.equal(await page.locator("tbody tr").count(), 1);
  await page.getByRole("combobox", { name: /^State/ }).selectOption("failed");
  await page.getByText("No job fits these filters").waitFor();
  await page.reload();
  assert.equal(await page.getByLabel("Search").inputValue(), "other");
  await page.getByRole("combobox", { name: /^State/ }).selectOption("");
  await page.getByRole("combobox", { name: /^Label/ }).selectOption("test");
  await page.locator("tr", { hasText: "other seed" }).waitFor();
});

test("what a job calls itself is text, never markup", { skip }, async () => {
  const name = '<img src=x onerror="window.broken=1"><b>bold</b>';
  const id = await submit(
    daemon.url,
    smallDocument((one) => {
      one.name = name;
      one.labels = ["<i>label</i>"];
    }),
  );
  await waitForState(daemon.url, id, "succeeded");
  for (const hash of ["#/jobs", `#/jobs/${id}`, `#/jobs/${id}/report`, `#/compare?designs=${id}:design`]) {
    await open(hash);
    await page.getByText(name.slice(0, 20)).first().waitFor();
    assert.equal(
      await page.evaluate(() => document.querySelectorAll("main img, main b b, main i").length + (window.broken || 0)),
      0,
    );
  }
});

test("ten thousand candidates stay in a short document, sorted and scrolled", { skip }, async () => {
  const line = (i) =>
    JSON.stringify({
      evaluation: i,
      phase: i ? "random" : "reference",
      parameters: { "pinion.tip.amplitude_mm": 0.01 + i / 1e6, "gear.tip.amplitude_mm": 0.02 - i / 1e6 },
      f_pps_um: 10,
      f_dte: ((i * 7919) % 10007) / 10007,
    });
  const body = Array.from({ length: 10000 }, (_, i) => line(i)).join("\n");
  await page.route("**/evaluations", (route) => route.fulfill({ contentType: "application/x-ndjson", body }));
  await open(`#/jobs/${finished}`);
  const table = page.getByRole("table", { name: "Candidates tried" });
  await table.waitFor();
  assert.equal(await table.getAttribute("aria-rowcount"), "10001");
  assert.ok((await table.locator("tbody tr").count()) < 60);
  await table.getByRole("button", { name: /^No/ }).click();
  await table.getByRole("button", { name: /^No/ }).click();
  await table.locator("tbody tr:not(.filler)", { hasText: /^9\s?999/ }).waitFor();
  await table.evaluate((element) => (element.parentElement.scrollTop = 1e9));
  await table.locator('tr[aria-rowindex="10001"]').waitFor();
  await page.unroute("**/evaluations");
});

test("a job is cancelled and deleted, after a question", { skip }, async () => {
  const id = await submit(
    daemon.url,
    smallDocument((one) => {
      one.name = "doomed";
      endless(one);
    }),
  );
  await open("#/jobs");
  const row = page.locator("tr", { hasText: "doomed" });
  await row.getByText("running").waitFor();
  await page.getByRole("button", { name: "Cancel doomed" }).click();
  await row.getByText("cancelled").waitFor();
  await page.getByRole("button", { name: "Delete doomed" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Keep" }).click();
  assert.equal(await row.count(), 1);
  await page.getByRole("button", { name: "Delete doomed" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Delete" }).click();
  await row.waitFor({ state: "detached" });
  assert.equal((await fetch(`${daemon.url}/v1/jobs/${id}`)).status, 404);
});

test("a report is printed, with input, result, plots, reliability and version", { skip }, async () => {
  await open(`#/jobs/${finished}/report`);
  await page.locator("figure.static svg").first().waitFor();
  const text = await page.locator("article").innerText();
  for (const part of [
    "Result",
    "Reliability",
    "Pair and analysis",
    "Gears",
    `quietgear ${result.version}`,
    finished,
    "seed 1",
  ])
    assert.ok(text.includes(part), part);
  assert.ok((await page.locator("figure.static svg").count()) >= 7);
  const pdf = (await page.pdf({ format: "A4" })).toString("latin1");
  assert.match(pdf, /^%PDF/);
  const sheets = pdf.match(/\/Type\s*\/Page\b/g).length;
  assert.ok(sheets >= 2 && sheets <= 6, `${sheets} sheets`);
});

test("the first paint of a finished job with 1000 speeds and three torques, in figures", { skip }, async (t) => {
  const id = await submit(
    daemon.url,
    smallDocument((one) => (one.analysis.speeds.count = 1000)),
  );
  await waitForState(daemon.url, id, "succeeded");
  await open(`#/jobs/${id}`);
  await page.waitForFunction(() => document.querySelector(".plot-area canvas")?.width > 300);
  const times = await page.evaluate(() => {
    const paints = performance.getEntriesByType("paint").map((entry) => [entry.name, Math.round(entry.startTime)]);
    return {
      ...Object.fromEntries(paints),
      "first plot drawn": Math.round(performance.getEntriesByName("first plot")[0].startTime),
    };
  });
  t.diagnostic(`ms after the start of navigation: ${JSON.stringify(times)}`);
  assert.ok(times["first plot drawn"] > 0);
});

test("the browser had nothing to complain of, the policy on content included", { skip }, () => {
  assert.deepEqual(errors, []);
});
