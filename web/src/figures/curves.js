// Figures of designs over speed and over the mesh cycle. A design on show is
//   {name, role: "design" | "reference" | number, design: as in a result, halfBacklash: µm, pinionTeeth}
// Role "design" is drawn bold, "reference" thin; colours tell the load cases apart. A number (comparison) is the colour itself.
import { fixed, significant } from "../format.js";

const isCompared = (shown) => typeof shown.role === "number";

export const torqueText = (torque) => `${significant(torque, 3)} N m`;

// How a curve of load case i looks. In a comparison load cases are told apart by dashes.
function look(shown, i) {
  const dashes = [[], [6, 3], [2, 3], [9, 3, 2, 3]];
  const place = { row: shown.name, column: torqueText(shown.design.load_cases[i].torque_nm) };
  if (isCompared(shown)) return { ...place, colour: shown.role, width: 1.75, dash: dashes[i % dashes.length] };
  return {
    ...place,
    colour: i,
    width: shown.role === "design" ? 2.25 : 1,
    opacity: shown.role === "design" ? 1 : 0.85,
  };
}

const nameOf = (shown, loadCase) => `${shown.name}, ${torqueText(loadCase.torque_nm)}`;

export function rpmFactor(shown, loadCase) {
  return (loadCase.natural_frequency_hz * 60) / shown.pinionTeeth;
}

// The least difference between neighbours that may be a jump: one that can be seen.
const jumpLimit = (rms) => 0.03 * rms.reduce((most, value) => Math.max(most, value ?? 0), 0);

function responseCurves(shown, useRpm) {
  return shown.design.load_cases.flatMap((loadCase, i) => {
    const response = loadCase.frequency_response;
    if (!response) return [];
    const factor = useRpm ? rpmFactor(shown, loadCase) : 1;
    const x = useRpm ? response.frequency_ratio.map((ratio) => ratio * factor) : response.frequency_ratio;
    const name = nameOf(shown, loadCase);
    const key = `${shown.key}-${i}`;
    const curve = { key, name, x, y: response.rms, jump: jumpLimit(response.rms), ...look(shown, i) };
    curve.extra = [{ head: `${name}: period, mesh periods`, values: response.period }];
    return [curve, ...periodMarks(shown, key, i, curve, response), ...branchCurves(shown, key, i, loadCase, factor)];
  });
}

// Dots where the response does not repeat with every tooth.
function periodMarks(shown, key, i, curve, response) {
  if (shown.role === "reference") return [];
  const at = response.period.flatMap((period, k) => (period === 1 ? [] : [k]));
  if (at.length === 0) return [];
  const pick = (list) => at.map((k) => list[k]);
  return [
    {
      key,
      kind: "points",
      x: pick(curve.x),
      y: pick(curve.y),
      colour: look(shown, i).colour,
      size: 2.2,
      read: false,
      inCsv: false,
    },
  ];
}

// Concatenates the branches of a load case, with gaps between them and where `keep` says no.
function joinBranches(branches, factor, keep) {
  const joined = { x: [], y: [] };
  for (const branch of branches) {
    branch.frequency_ratio.forEach((ratio, k) => {
      joined.x.push(ratio * factor);
      joined.y.push(keep(branch, k) ? branch.rms[k] : null);
    });
    joined.x.push(joined.x.at(-1));
    joined.y.push(null);
  }
  return joined;
}

function branchCurves(shown, key, i, loadCase, factor) {
  if (!loadCase.branches?.length) return [];
  const torque = torqueText(loadCase.torque_nm);
  const isStable = (branch, k) => branch.stable[k];
  // an unstable stretch begins and ends at the last stable point, so that no gap is seen
  const isUnstable = (branch, k) =>
    !branch.stable[k] || branch.stable[k + 1] === false || branch.stable[k - 1] === false;
  const special = loadCase.branches.flatMap((branch) => branch.special_points);
  const common = { colour: look(shown, i).colour, column: torque, folded: true };
  return [
    {
      key: `${key}-stable`,
      row: "branches, stable",
      name: `stable, ${torque}`,
      width: 1.25,
      ...joinBranches(loadCase.branches, factor, isStable),
      ...common,
    },
    {
      key: `${key}-unstable`,
      row: "branches, unstable",
      name: `unstable, ${torque}`,
      width: 1.25,
      dash: [4, 3],
      opacity: 0.8,
      ...joinBranches(loadCase.branches, factor, isUnstable),
      ...common,
    },
    {
      key: `${key}-special`,
      row: "folds, period doublings",
      name: `folds, period doublings, ${torque}`,
      kind: "points",
      hollow: true,
      size: 3,
      x: special.map((point) => point.frequency_ratio * factor),
      y: special.map((point) => point.rms),
      ...common,
    },
  ];
}

// The unit of amplitudes: with its size where all designs have the same.
function halfBacklashText(designs) {
  const sizes = new Set(designs.map(({ halfBacklash }) => halfBacklash?.toFixed(3)));
  return sizes.size === 1 && designs[0].halfBacklash
    ? `b = ${fixed(designs[0].halfBacklash, 1)} µm`
    : "half-backlashes b";
}

// Amplitude against frequency. useRpm: over the pinion's speed instead of the frequency ratio.
export function responseFigure(designs, { useRpm = false, title = "Amplitude against frequency" } = {}) {
  const series = designs.flatMap((shown) => responseCurves(shown, useRpm));
  const first = designs.find(({ role }) => role === "design") || designs[0]; // whose speeds stand above
  const last = first?.design.load_cases.at(-1);
  const many = (series.some((curve) => curve.folded) && series.length > 4) || designs.length > 4;
  const most = (curves) => Math.max(0, ...curves.flatMap((curve) => curve.y.map((value) => value ?? 0)));
  const folded = series.filter((curve) => curve.folded);
  const responses = most(series.filter((curve) => !curve.folded));
  // branches that run away to large amplitudes would press the rest flat
  const usualMost = Math.max(1.25 * responses, 2.2);
  const isHigh = folded.length > 0 && most(folded) > 1.2 * usualMost;
  return {
    id: "frequency-response",
    title,
    summary: designs.map((shown) => `${shown.name}: largest RMS ${significant(shown.design.f_dte, 4)}.`).join(" "),
    x: useRpm
      ? { label: "pinion speed", unit: "rpm" }
      : { label: "frequency ratio: mesh frequency / natural frequency", short: "frequency ratio", unit: "–" },
    top:
      useRpm || !last
        ? undefined
        : {
            label: `pinion speed, ${first.name} at ${torqueText(last.torque_nm)}`,
            digits: 0,
            unit: "rpm",
            factor: rpmFactor(first, last),
          },
    y: {
      label: "RMS of dynamic transmission error",
      unit: halfBacklashText(designs),
      zero: true,
      usual: isHigh ? [0, usualMost] : undefined,
    },
    series,
    hidden: many
      ? series.filter((curve) => /-[1-9]\d*-(stable|unstable|special)$/.test(curve.key)).map((curve) => curve.key)
      : [],
  };
}

// One curve over the mesh cycle, closed at 1.
function cycleCurve(shown, i, values) {
  const x = [...values.keys(), values.length].map((k) => k / values.length);
  const name = nameOf(shown, shown.design.load_cases[i]);
  return { key: `${shown.key}-${i}`, name, x, y: [...values, values[0]], ...look(shown, i) };
}

// A quantity over the mesh cycle. pick(loadCase) gives its values.
function cycleFigure(designs, { pick, ...rest }) {
  const curves = designs.flatMap((shown) =>
    shown.design.load_cases.map((loadCase, i) => cycleCurve(shown, i, pick(loadCase))),
  );
  return figureOfCycle(curves, rest);
}

function figureOfCycle(series, { id, title, label, unit, zero }) {
  const shared = series.find((curve) => curve.x.length === series[0].x.length)?.x;
  for (const curve of series) if (curve.x.length === shared.length) curve.x = shared;
  const said = series.map(
    ({ name, y }) => `${name}: ${significant(Math.min(...y))} to ${significant(Math.max(...y))} ${unit}.`,
  );
  return {
    id,
    title,
    summary: said.join(" "),
    x: { label: "mesh position", unit: "mesh periods", range: [0, 1] },
    y: { label, unit, zero },
    series,
  };
}

export const transmissionErrorFigure = (designs) =>
  cycleFigure(designs, {
    id: "static-transmission-error",
    title: "Static transmission error",
    label: "static transmission error",
    unit: "µm",
    pick: (loadCase) => loadCase.static_transmission_error_um,
  });

export const stiffnessFigure = (designs) =>
  cycleFigure(designs, {
    id: "mesh-stiffness",
    title: "Mesh stiffness",
    label: "mesh stiffness",
    unit: "N/µm",
    pick: (loadCase) => loadCase.mesh_stiffness_n_per_mm.map((value) => value / 1000),
  });

export const pressureFigure = (designs) =>
  cycleFigure(designs, {
    id: "contact-pressure",
    title: "Contact pressure",
    label: "largest contact pressure",
    unit: "MPa",
    zero: true,
    pick: (loadCase) => loadCase.contact_pressure_mpa,
  });

// Tension in the roots of both gears, the gear's dashed; null where a result has none.
export function rootStressFigure(designs) {
  if (!designs.every(({ design }) => design.load_cases[0].root_stress_mpa)) return null;
  const curve = (shown, i, gear) => {
    const made = cycleCurve(shown, i, shown.design.load_cases[i].root_stress_mpa[gear].tension);
    const dash = gear === "gear" ? { dash: [7, 3] } : {};
    const { key, name, row } = made;
    return { ...made, ...dash, key: `${key}-${gear}`, name: `${name}, ${gear}`, row: `${row}, ${gear}` };
  };
  const curves = designs.flatMap((shown) =>
    ["pinion", "gear"].flatMap((gear) => shown.design.load_cases.map((_, i) => curve(shown, i, gear))),
  );
  const named = {
    id: "root-stress",
    title: "Root stress",
    label: "largest tension in the roots",
    unit: "MPa",
    zero: true,
  };
  return figureOfCycle(curves, named);
}

// The share of one pair of teeth from its entry to its exit: pair k at mesh position phi stands where pair 0 stands at phi + k.
function shareAlongPath({ pair, share }) {
  const points = [];
  share.forEach((shares, i) => shares.forEach((value, k) => points.push([pair[k] + i / share.length, value])));
  points.sort((a, b) => a[0] - b[0]);
  const loaded = points.flatMap(([, value], k) => (value > 0 ? [k] : []));
  const kept = points.slice(Math.max(0, loaded[0] - 1), loaded.at(-1) + 2);
  return { x: kept.map(([at]) => at), y: kept.map(([, value]) => 100 * value) };
}

export function loadShareFigure(designs) {
  const series = designs.flatMap((shown) =>
    shown.design.load_cases.map((loadCase, i) => ({
      key: `${shown.key}-${i}`,
      name: nameOf(shown, loadCase),
      ...shareAlongPath(loadCase.load_share),
      ...look(shown, i),
    })),
  );
  return {
    id: "load-sharing",
    title: "Load sharing",
    summary: "Share of the normal force that one pair of teeth carries on its way through the mesh.",
    x: { label: "position of the pair of teeth", unit: "mesh periods" },
    y: { label: "share of the normal force", unit: "%", range: [0, 105] },
    series,
  };
}
