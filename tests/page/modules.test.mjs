// The page's modules that need no browser: events, numbers, and what is worked out from evaluations and results.
import assert from "node:assert/strict";
import { test } from "node:test";

const at = (path) => import(new URL(`../../web/src/${path}`, import.meta.url));
const { eventParser } = await at("events.js");
const { fixed, nameAndUnit, plain, significant, duration } = await at("format.js");
const { histogramOf, improvements, landscapeFigure, mapFigure, movingParameters, usualMost } =
  await at("figures/search.js");
const { designsOfResponse, designsOfResult } = await at("figures/designs.js");
const { loadShareFigure, responseFigure, transmissionErrorFigure } = await at("figures/curves.js");

test("events are cut from a stream wherever it is broken", () => {
  const stream =
    ': hello\nretry: 2000\nid: 7\nevent: job\ndata: {"a":\ndata: 1}\n\nevent: deleted\r\ndata: x\r\n\r\ndata\n\n';
  const expected = [
    { event: "job", data: '{"a":\n1}', id: "7" },
    { event: "deleted", data: "x", id: undefined },
    { event: "message", data: "", id: undefined },
  ];
  for (let cut = 0; cut <= stream.length; cut++) {
    const seen = [];
    const feed = eventParser((event) => seen.push(event));
    feed(stream.slice(0, cut));
    feed(stream.slice(cut));
    assert.deepEqual(seen, expected, `cut at ${cut}`);
  }
});

test("numbers keep their figures, and units come from names", () => {
  assert.equal(fixed(12345.678, 1), "12\u202f345.7");
  assert.equal(fixed(-0.5, 1), "\u22120.5");
  assert.equal(fixed(null, 2), "–");
  assert.equal(significant(0.0123456, 3), "0.0123");
  assert.equal(significant(1.5e-9, 3), "1.50e\u22129");
  assert.equal(plain(0.1 + 0.2), "0.3");
  assert.equal(plain(470), "470");
  assert.equal(duration(75), "75 s");
  assert.deepEqual(nameAndUnit("pinion.tip.amplitude_mm"), { text: "pinion tip amplitude", unit: "mm" });
  assert.deepEqual(nameAndUnit("mean_mesh_stiffness_n_per_mm"), { text: "mean mesh stiffness", unit: "N/mm" });
  assert.deepEqual(nameAndUnit("bounds.start_radius_mm.1"), { text: "bounds start radius, no. 2", unit: "mm" });
});

const evaluation = (number, phase, f_dte, amplitude = number) => ({
  evaluation: number,
  phase,
  parameters: { "pinion.tip.amplitude_mm": amplitude, "gear.tip.amplitude_mm": 1 },
  f_pps_um: null,
  f_dte,
});
const LOG = [
  evaluation(0, "reference", 0.1),
  evaluation(1, "random", 0.5),
  evaluation(2, "random", 0.7),
  evaluation(3, "simplex", 0.4),
  evaluation(4, "simplex", null),
  evaluation(5, "reliability", 0.01),
];

test("the best of a search counts neither the reference nor trials of reliability", () => {
  assert.deepEqual(
    improvements(LOG, "f_dte").map((one) => one.evaluation),
    [1, 3],
  );
  assert.deepEqual(movingParameters(LOG), ["pinion.tip.amplitude_mm"]);
  const { series } = landscapeFigure(LOG, "f_dte", ["pinion.tip.amplitude_mm", "gear.tip.amplitude_mm"]);
  assert.deepEqual(series[0].heat, [0.7, 0.5, 0.4]);
  assert.deepEqual(series[1].x, [1, 3]);
  assert.equal(usualMost([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1000]), 10);
});

test("a histogram counts every trial once", () => {
  const { from, to, counts } = histogramOf([1, 1, 2, 3, 3], 2);
  assert.deepEqual([from, to, counts], [1, 3, [2, 3]]);
  assert.deepEqual(histogramOf([4, 4], 3).counts, [2, 0, 0]);
});

test("the first axis of a map runs to the right", () => {
  const cell = { cell: [0, 1], values: [1, 20], f_pps_um: 3, f_dte: 2 };
  const map = {
    axes: [
      { parameter: "pinion.tip.start_radius_mm", values: [1, 2] },
      { parameter: "gear.tip.start_radius_mm", values: [10, 20, 30] },
    ],
    f_dte: [
      [4, 2, 5],
      [7, 8, 9],
    ],
    f_pps_um: [
      [4, 3, 5],
      [7, 8, 9],
    ],
    minima: { f_dte: cell, f_pps: cell },
    local_minima: { f_dte: [cell], f_pps: [cell] },
  };
  const { grid } = mapFigure(map, "f_dte");
  assert.deepEqual(grid.x, [1, 2]);
  assert.deepEqual(grid.z, [
    [4, 7],
    [2, 8],
    [5, 9],
  ]);
});

const DESIGN = {
  key: "design",
  name: "best",
  role: "design",
  halfBacklash: 100,
  pinionTeeth: 20,
  design: {
    f_dte: 0.2,
    load_cases: [
      {
        torque_nm: 100,
        natural_frequency_hz: 2000,
        static_transmission_error_um: [1, 2, 3, 2],
        load_share: {
          pair: [-1, 0, 1],
          share: [
            [0, 0.4, 0.6],
            [0, 1, 0],
            [0, 1, 0],
            [0.3, 0.7, 0],
          ],
        },
        frequency_response: { frequency_ratio: [0.5, 1], rms: [0.1, 0.2], period: [1, 2] },
      },
    ],
  },
};

test("each design of a macro search is read by its own pair", () => {
  const result = {
    geometry: { backlash_mm: 0.3 },
    job: { gear_pair: { pinion: { teeth: 28 } } },
    reference: {},
    design: {},
    macro: { best: 1, candidates: [{}, { geometry: { backlash_mm: 0.2 }, gear_pair: { pinion: { teeth: 41 } } }] },
  };
  const read = (designs) => designs.map(({ halfBacklash, pinionTeeth }) => [Math.round(halfBacklash), pinionTeeth]);
  assert.deepEqual(read(designsOfResult(result)), [[150, 28], [100, 41]]);
  const side = (half_backlash_um, pinion_rpm) => ({
    half_backlash_um,
    load_cases: [{ natural_frequency_hz: 1000, pinion_rpm: [pinion_rpm] }],
  });
  const response = { half_backlash_um: 150, frequency_ratio: [0.7], reference: side(150, 1500), design: side(100, 1050) };
  assert.deepEqual(read(designsOfResponse(response)), [[150, 28], [100, 40]]);
  assert.deepEqual(read(designsOfResult({ ...result, macro: null })), [[150, 28], [150, 28]]);
});

test("the load of a pair of teeth is followed from its entry to its exit", () => {
  const [curve] = loadShareFigure([DESIGN]).series;
  assert.deepEqual(curve.x, [-0.5, -0.25, 0, 0.25, 0.5, 0.75, 1, 1.25]);
  assert.deepEqual(curve.y, [0, 30, 40, 100, 100, 70, 60, 0]);
});

test("a mesh cycle closes, and a frequency ratio is a speed of the pinion", () => {
  const [error] = transmissionErrorFigure([DESIGN]).series;
  assert.deepEqual(error.x, [0, 0.25, 0.5, 0.75, 1]);
  assert.equal(error.y.at(-1), error.y[0]);
  const { series, top } = responseFigure([DESIGN], { useRpm: true });
  assert.deepEqual(series[0].x, [3000, 6000]); // 2000 Hz * 60 / 20 teeth = 6000 rpm at ratio 1
  assert.equal(top, undefined);
  assert.deepEqual(series[1].x, [6000]); // the one speed without period 1
});
