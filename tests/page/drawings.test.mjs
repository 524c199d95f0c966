// The drawings of a finished job in a real browser: profile diagram, teeth in mesh, stress in colour, DXF.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before, test } from "node:test";
import { launch, skip, smallDocument, startDaemon, submit, waitForState } from "./harness.mjs";

let daemon, browser, page, id, result;
const errors = [];

before(async () => {
  if (skip) return;
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, acceptDownloads: true });
  id = await submit(daemon.url, smallDocument((one) => (one.name = "drawn")));
  await waitForState(daemon.url, id, "succeeded");
  result = await (await fetch(`${daemon.url}/v1/jobs/${id}/result`)).json();
  page = await context.newPage();
  page.setDefaultTimeout(15000);
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(`${daemon.url}/#/jobs/${id}`);
});

after(async () => {
  await browser?.close();
  await daemon?.remove();
});

const region = (name) => page.getByRole("region", { name });

test("the profile diagram shows the design beside the reference, and reads values", { skip }, async () => {
  const diagram = region("Profile diagram").locator("svg").first();
  await diagram.waitFor();
  const tip = result.design.relief.pinion.tip.amplitude_mm * 1000;
  assert.ok(Math.abs(Number(await diagram.getAttribute("data-tip-um")) - tip) < 1e-9);
  assert.equal(await region("Profile diagram").locator(".reference.curve").count(), 2);
  assert.equal(await region("Profile diagram").locator(".band").first().isVisible(), true);
  await diagram.scrollIntoViewIfNeeded();
  const box = await diagram.boundingBox();
  await page.mouse.move(box.x + box.width * 0.96, box.y + box.height / 2);
  const [, removed, radius] = /([\d.]+) µm at [\d.]+ mm, radius ([\d.]+) mm/.exec(await diagram.locator(".cursor text").textContent());
  const { start_radius_mm: start } = result.design.relief.pinion.tip;
  const expected = Math.max(0, (tip * (Number(radius) - start)) / (46.55 - start)); // linear over the radius
  assert.ok(Math.abs(Number(removed) - expected) < 0.3, `${removed}, wanted ${expected}`);
});

test("both gears of the design are taken away as DXF", { skip }, async () => {
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    region("Teeth in mesh").getByRole("button", { name: "DXF, both gears" }).click(),
  ]);
  assert.equal(download.suggestedFilename(), "drawn-gears.dxf");
  const answer = await fetch(`${daemon.url}/v1/jobs/${id}/profile?extent=gears&position=0.5`, { headers: { Accept: "image/vnd.dxf" } });
  assert.equal(readFileSync(await download.path(), "utf8"), await answer.text());
});

async function takeAway(name) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name, exact: true }).click()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

// An SVG file that shows these texts and needs nothing of the page: no class, no variable, nothing that older programs do not know.
async function assertStandsAlone(svg, texts) {
  assert.match(svg, /^<\?xml/);
  const shown = await page.evaluate((text) => {
    const read = new DOMParser().parseFromString(text, "image/svg+xml");
    return read.querySelector("parsererror") ? null : [...read.querySelectorAll("text")].map((one) => one.textContent);
  }, svg);
  for (const text of texts) assert.ok(shown?.includes(text), `"${text}" is missing in ${JSON.stringify(shown)}`);
  assert.doesNotMatch(svg, /class=|style=|var\(|color\(|color-mix|light-dark|vector-effect|NaN|undefined/);
  const shapes = svg.match(/<(path|line|circle|text) [^>]*>/g);
  assert.deepEqual(shapes.filter((shape) => !/ fill="(#[0-9a-f]{6}|none)"/.test(shape)), []);
}

// A PNG file's width and height, how many colours it shows, and the colours at some places.
async function readPng(bytes, places = []) {
  assert.equal(bytes.subarray(0, 8).toString("latin1"), "\x89PNG\r\n\x1a\n");
  const seen = await page.evaluate(async ([text, spots]) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(text), (one) => one.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    const pixel = spots.map(([x, y]) => [...context.getImageData(x, y, 1, 1).data].slice(0, 3));
    return { width: image.width, height: image.height, colours: new Set(new Uint32Array(data.buffer)).size, pixel };
  }, [bytes.toString("base64"), places]);
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [seen.width, seen.height]);
  return seen;
}

test("the profile diagram is taken away as CSV, SVG and PNG", { skip }, async () => {
  const csv = await takeAway("Profile diagram as CSV");
  assert.equal(csv.name, "drawn-profile-diagram.csv");
  const [head, ...lines] = csv.bytes.toString().trim().split("\r\n");
  const names = head.match(/"[^"]*"|[^,]+/g).map((one) => one.replaceAll('"', ""));
  const column = (name) => {
    assert.ok(names.includes(name), `${name} is missing in ${head}`);
    return lines.map((line) => line.split(",")[names.indexOf(name)]).filter((cell) => cell !== "").map(Number);
  };
  for (const of of ["design", "reference"]) {
    const profile = await (await fetch(`${daemon.url}/v1/jobs/${id}/profile?design=${of}`)).json();
    for (const gear of ["pinion", "gear"])
      assert.deepEqual(column(`${gear} ${of}: removed, µm`), profile[gear].diagram.design.removed_um);
    if (of === "design") assert.deepEqual(column("roll length, mm (pinion design)"), profile.pinion.diagram.design.roll_length_mm);
  }
  const svg = await takeAway("Profile diagram as SVG");
  assert.equal(svg.name, "drawn-profile-diagram.svg");
  const texts = ["roll length, mm", "removed, µm", "Pinion", "Gear", "design", "reference", "what the bounds allow", "SAP", "EAP"];
  await assertStandsAlone(svg.bytes.toString(), ["Profile diagram, drawn", ...texts]);
  const { width, height, colours } = await readPng((await takeAway("Profile diagram as PNG")).bytes);
  assert.deepEqual([width, height > 500, colours > 50], [1844, true, true], `${width} x ${height}, ${colours} colours`);
});

test("the teeth in mesh are taken away as SVG and PNG, in light colours from a dark page", { skip }, async () => {
  const light = await takeAway("Teeth in mesh as SVG");
  assert.equal(light.name, "drawn-teeth-in-mesh.svg");
  const bar = await region("Teeth in mesh").locator(".scale-bar text").textContent();
  assert.match(bar, /^\d+ mm$/);
  await assertStandsAlone(light.bytes.toString(), ["Teeth in mesh, drawn", bar, "path of contact", "Pinion, 28 teeth", "Gear, 43 teeth"]);
  await page.emulateMedia({ colorScheme: "dark" });
  const dark = await takeAway("Teeth in mesh as SVG");
  await page.emulateMedia({ colorScheme: "light" });
  const unnumbered = ({ bytes }) => bytes.toString().replaceAll(/clip-\d+/g, "clip");
  assert.equal(unnumbered(dark), unnumbered(light));
  const { width, height, colours } = await readPng((await takeAway("Teeth in mesh as PNG")).bytes);
  assert.deepEqual([width, height > 800, colours > 50], [1656, true, true], `${width} x ${height}, ${colours} colours`);
});

test("stresses are computed when asked for, drawn in colour, and read", { skip }, async () => {
  const panel = region("Stress in the teeth");
  await panel.getByLabel("Mesh position").selectOption("0.25");
  await panel.getByRole("button", { name: "Compute" }).click();
  const canvas = panel.locator("canvas");
  await canvas.waitFor();
  const field = await (await fetch(`${daemon.url}/v1/jobs/${id}/field?load_case=2&position=0.25`)).json();
  const most = Math.max(...field.pinion.von_mises_mpa, ...field.gear.von_mises_mpa);
  assert.equal(Number(await canvas.getAttribute("data-largest")), most);
  const colours = await canvas.evaluate((one) => {
    const { data } = one.getContext("2d").getImageData(0, 0, one.width, one.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add(`${data[i]} ${data[i + 1]} ${data[i + 2]}`);
    return seen.size;
  });
  assert.ok(colours > 60, `${colours} colours`);
  await panel.getByRole("combobox", { name: "Show" }).selectOption("max_principal_mpa");
  await panel.getByRole("combobox", { name: "Displacements" }).selectOption("200");
  await panel.locator(".drawing-note", { hasText: "200 times their size" }).waitFor();
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width * 0.42, box.y + box.height * 0.9);
  await panel.locator(".drawing-note", { hasText: /^(pinion|gear): [−\d]+ MPa$/ }).waitFor();
});

test("the stresses are taken away as PNG with their scale", { skip }, async () => {
  const png = await takeAway("Stress in the teeth as PNG");
  assert.equal(png.name, "drawn-stress-tension.png");
  const { width, height, colours, pixel } = await readPng(png.bytes, [
    [1490, 174], // the scale's upper end, in the middle of its bar
    [1490, 934], // and its lower end
    [4, 4], // the ground
  ]);
  assert.deepEqual([width, height, colours > 60], [1600, 972, true], `${width} x ${height}, ${colours} colours`);
  const [[red, , blue], [lowRed, , lowBlue], ground] = pixel;
  assert.ok(red > 220 && blue < 130 && lowRed < 60 && lowBlue > 80, JSON.stringify(pixel));
  assert.deepEqual(ground, [255, 255, 255]);
});

test("the drawings have no serious finding of axe-core", { skip }, async () => {
  await page.evaluate(readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8"));
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
    assert.deepEqual(violations.filter(({ impact }) => ["serious", "critical"].includes(impact)).map(({ id: rule, nodes }) => [rule, nodes[0].html]), []);
  }
});

test("the browser had nothing to complain of", { skip }, () => {
  assert.deepEqual(errors, []);
});
