// The form of a new job in a real browser against a real daemon: form, JSON and drawings are one draft, faults stand at their
// fields, and what is started is what was written.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, beforeEach, test } from "node:test";
import { example, launch, skip, smallDocument, startDaemon, submit, waitForState } from "./harness.mjs";

let daemon, browser, context, page;
const errors = []; // what the browser complained of, refused documents and results not yet there aside

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true });
});

// Every test has a tab of its own, and with it a draft of its own.
beforeEach(async () => {
  if (skip) return;
  await page?.close();
  page = await context.newPage();
  page.setDefaultTimeout(10000);
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error" && !/status of 4(00|09|22)/.test(message.text())) errors.push(message.text());
  });
  await page.goto(`${daemon.url}/#/new`);
  await field("/gear_pair/module_mm").waitFor();
  await canBeRun();
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

const field = (pointer) => page.locator(`#field${pointer.replaceAll("/", "-")}`);
const faultAt = (pointer) => page.locator(`#field${pointer.replaceAll("/", "-")}-fault`);
const json = () => page.getByLabel("Job document, JSON");
const start = () => page.getByRole("button", { name: "Start the job" });
const documentShown = async () => JSON.parse(await json().inputValue());
const canBeRun = () => page.locator(".verdict .good").waitFor();
const diagram = (name) => page.locator(".relief-diagram", { hasText: name }).locator("svg");
const tipOf = async (name) => Number(await diagram(name).getAttribute("data-tip-um"));
const until = (condition, argument) => page.waitForFunction(condition, argument);

test("a job is started from the form and runs as it was written", { skip }, async () => {
  await field("/name").fill("from the form");
  await field("/optimizer/random_samples").fill("7");
  await field("/optimizer/simplex_iterations").fill("2");
  await field("/analysis/speeds/count").fill("25");
  await field("/reliability").uncheck();
  await field("/relief/gear/tip/amplitude_mm").fill("0,014"); // a decimal comma is one too
  await canBeRun();
  await start().click();
  await page.waitForURL(/#\/jobs\/\w+/);
  const id = page.url().split("/").at(-1);
  await waitForState(daemon.url, id, "succeeded");
  const { job, search } = await (await fetch(`${daemon.url}/v1/jobs/${id}/result`)).json();
  assert.equal(job.name, "from the form");
  assert.equal(job.relief.gear.tip.amplitude_mm, 0.014);
  assert.equal(job.reliability, undefined);
  assert.equal(job.optimizer.random_samples, 7);
  assert.ok(search.evaluations >= 7 && search.evaluations < 30);
  await page.locator("h1 + .state", { hasText: "succeeded" }).waitFor();
  await diagram("Pinion").waitFor(); // the design, drawn in the view of the job
  await page.locator(".relief-diagram .reference").first().waitFor();
});

test("a wrong input is told at its field, with what was found and allowed", { skip }, async () => {
  await field("/gear_pair/pinion/teeth").fill("3");
  await faultAt("/gear_pair/pinion/teeth").getByText("found 3, allowed 5 to 1000").waitFor();
  assert.equal(await field("/gear_pair/pinion/teeth").getAttribute("aria-invalid"), "true");
  assert.ok(await start().isDisabled());
  await field("/gear_pair/module_mm").fill("three");
  await faultAt("/gear_pair/module_mm").getByText('found "three"').waitFor();
  await page.locator(".verdict").getByText("2 faults").waitFor();
  await page.getByRole("button", { name: "/gear_pair/module_mm" }).click();
  await until(() => document.activeElement.id === "field-gear_pair-module_mm");
  await field("/gear_pair/module_mm").fill("3");
  await field("/gear_pair/pinion/teeth").fill("28");
  await canBeRun();
  assert.equal(await page.locator(".job-form .fault").count(), 0);
});

test("what only the geometry forbids is told at its field too", { skip }, async () => {
  await field("/gear_pair/center_distance_mm").fill("108");
  await faultAt("/gear_pair/center_distance_mm").getByText(/negative backlash: the teeth overlap by \d/).waitFor();
  await page.getByText("of the last pair that could be made").waitFor();
});

test("form and JSON are in step, both ways", { skip }, async () => {
  await field("/gear_pair/damping_ratio").fill("0.02");
  assert.equal((await documentShown()).gear_pair.damping_ratio, 0.02);
  const document = await documentShown();
  document.gear_pair.gear.face_width_mm = 21.75;
  document.relief.shape = "parabolic";
  await json().fill(JSON.stringify(document));
  assert.equal(await field("/gear_pair/gear/face_width_mm").inputValue(), "21.75");
  assert.equal(await field("/relief/shape").inputValue(), "parabolic");
  await field("/relief/shape").selectOption("");
  assert.equal("shape" in (await documentShown()).relief, false);
});

test("broken JSON is told with line and column, and the form stays", { skip }, async () => {
  const text = await json().inputValue();
  await json().fill(text.replace('"module_mm": 3,', '"module_mm": 3'));
  const line = text.split("\n").findIndex((one) => one.includes("module_mm")) + 1;
  await page.locator("#editor-error").getByText(new RegExp(`Line ${line + 1}, column \\d+`)).waitFor();
  assert.equal(await field("/gear_pair/module_mm").inputValue(), "3");
  assert.ok(await start().isDisabled());
  await field("/gear_pair/module_mm").fill("3.0"); // the form's own document replaces what was broken
  await page.locator("#editor-error").waitFor({ state: "hidden" });
  await canBeRun();
});

test("the drawings follow the numbers", { skip }, async () => {
  assert.equal(await tipOf("Gear"), 18);
  await field("/relief/gear/tip/amplitude_mm").fill("0.025");
  await until(() => document.querySelectorAll(".relief-diagram svg")[1].dataset.tipUm === "25");
  const outline = () => page.locator(".tooth.pinion").getAttribute("d");
  const old = await outline();
  await field("/gear_pair/pinion/outside_radius_mm").fill("46.2");
  await until((d) => document.querySelector(".tooth.pinion").getAttribute("d") !== d, old);
  const radii = (await outline()).split("Z")[0].slice(1).split("L").map((point) => Math.hypot(...point.split(",").map(Number)));
  assert.ok(Math.abs(Math.max(...radii) - 46.2) < 1e-3);
});

test("the position in the mesh is moved by the keyboard; teeth turn and contacts move", { skip }, async () => {
  const angle = async () => Number(/rotate\(([-\d.e]+)\)/.exec(await page.locator(".tooth.pinion").getAttribute("transform"))[1]);
  const before = await angle();
  await page.getByRole("slider", { name: "Mesh position" }).focus();
  await page.keyboard.press("Home");
  await page.locator(".teeth svg[data-position='0']").waitFor();
  assert.ok(Math.abs(before - (await angle()) - 360 / 28 / 2) < 1e-6); // half a period is half a tooth
  await page.keyboard.press("End");
  await page.locator(".teeth svg[data-position='1']").waitFor();
  const touches = await page.locator(".touch").evaluateAll((all) => all.map((one) => Number(one.getAttribute("cy"))));
  const [low, high] = await page.locator(".contact-path").evaluate((line) => [line.y1.baseVal.value, line.y2.baseVal.value]);
  assert.ok(touches.length >= 1 && touches.every((y) => y >= low - 1e-9 && y <= high + 1e-9));
});

test("switches take parts out and bring them back, with numbers to begin with", { skip }, async () => {
  await field("/relief/pinion/root").check();
  await canBeRun();
  const { root } = (await documentShown()).relief.pinion;
  assert.ok(root.end_radius_mm > 40.4654 && root.amplitude_mm > 0);
  await field("/relief/pinion/tip").uncheck();
  assert.equal((await documentShown()).relief.pinion.tip, undefined);
  await field("/relief/pinion/tip").check();
  assert.deepEqual((await documentShown()).relief.pinion.tip, { start_radius_mm: 44.54, amplitude_mm: 0.016 });
  await field("/relief_bounds/gear/root/amplitude_mm").check();
  assert.equal((await documentShown()).relief_bounds.gear.root.amplitude_mm.length, 2);
});

test("another kind shows its own members, and keeps what it does not use for later", { skip }, async () => {
  await field("/kind").selectOption("evaluate");
  await canBeRun();
  const document = await documentShown();
  assert.deepEqual(["relief_bounds", "optimizer", "reliability", "objective"].filter((key) => key in document), []);
  assert.equal(await page.getByRole("heading", { name: "Optimizer" }).count(), 0);
  await field("/analysis/branches").waitFor();
  await field("/kind").selectOption("optimize");
  await canBeRun();
  assert.deepEqual((await documentShown()).relief_bounds, example("case_S_optimize").relief_bounds);
  await field("/kind").selectOption("map");
  await page.locator(".job-form .fault").first().waitFor(); // a grid is asked for
});

test("examples and past jobs are starts", { skip }, async () => {
  const choices = page.getByLabel("Start from");
  await choices.selectOption("example:case_H_optimize");
  await until(() => document.querySelector("#field-gear_pair-pinion-teeth").value === "40");
  await canBeRun();
  const document = smallDocument((one) => (one.gear_pair.damping_ratio = 0.033));
  const id = await submit(daemon.url, document);
  await page.goto(`${daemon.url}/#/new?from=${id}`);
  await until(() => document.querySelector("#field-gear_pair-damping_ratio").value === "0.033");
  assert.match(await page.locator(".headline small").innerText(), /from job/);
});

test("a search over macro-geometry has its form too, with nothing left to JSON", { skip }, async () => {
  await page.getByLabel("Start from").selectOption("example:case_S_macro");
  await until(() => document.querySelector("#field-kind").value === "macro");
  await canBeRun();
  await page.getByLabel("Module: moves").uncheck();
  assert.equal("module_mm" in ((await documentShown()).macro.ranges ?? {}), false);
  await page.getByLabel("Pinion: Teeth, lower limit").fill("20");
  assert.equal((await documentShown()).macro.ranges.pinion.teeth[0], 20);
  assert.equal(await page.locator(".job-form textarea").count(), 0);
});

// A drop of a file on the view, made from inside the page.
const drop = (name, text) =>
  page.evaluate(
    ([fileName, content]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([content], fileName, { type: "application/json" }));
      const view = document.querySelector(".new-job");
      for (const type of ["dragover", "drop"])
        view.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
    },
    [name, text],
  );

test("files are dropped or opened", { skip }, async () => {
  await drop("mine.json", JSON.stringify(example("case_B_branches")));
  await until(() => document.querySelector("#field-gear_pair-pinion-teeth").value === "50");
  await canBeRun();
  assert.equal(await page.locator(".headline small").innerText(), "from mine.json");
  await drop("broken.json", '{"kind": "optimize",\n "gear_pair": }');
  await page.locator("#editor-error").getByText(/Line 2, column \d+/).waitFor();
  const [chooser] = await Promise.all([page.waitForEvent("filechooser"), page.getByRole("button", { name: "Open file…" }).click()]);
  await chooser.setFiles({ name: "s.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(example("case_S_none"))) });
  await until(() => document.querySelector("#field-name").value.length > 0 && document.querySelector("#field-kind").value === "evaluate");
  await canBeRun();
});

test("the drawing is taken away as DXF", { skip }, async () => {
  const save = async (name) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
    return [download.suggestedFilename(), readFileSync(await download.path(), "utf8")];
  };
  const [gears, text] = await save("DXF, both gears");
  assert.equal(gears, "gears.dxf");
  assert.ok(text.includes("AC1015") && text.match(/\nLWPOLYLINE\n/g).length === 2);
  const [spaces] = await save("DXF, tooth spaces");
  assert.equal(spaces, "tooth-spaces.dxf");
});

test("the draft outlives a reload", { skip }, async () => {
  await field("/name").fill("kept");
  await page.reload();
  await field("/name").waitFor();
  assert.equal(await field("/name").inputValue(), "kept");
});

test("the form is worked by the keyboard alone", { skip }, async () => {
  await field("/gear_pair/module_mm").focus();
  await page.keyboard.press("Tab");
  await until(() => document.activeElement.id === "field-gear_pair-pressure_angle_deg");
  await field("/name").fill("by keyboard");
  await field("/optimizer/random_samples").fill("3");
  await field("/optimizer/simplex_iterations").fill("1");
  await canBeRun();
  await until(() => !document.querySelector("button.primary").disabled);
  await page.keyboard.press("Control+Enter");
  await page.waitForURL(/#\/jobs\/\w+/);
});

test("the browser had nothing to complain of", { skip }, () => {
  assert.deepEqual(errors, []);
});
