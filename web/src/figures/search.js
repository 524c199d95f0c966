// Figures of a search, a map and a reliability study, from the log of evaluations and the result.
import { OBJECTIVES, fixed, labelOf, nameAndUnit, percent, plain, significant } from "../format.js";

const SEARCH_PHASES = new Set(["random", "simplex"]);

// The value of an evaluation by objective "f_dte" or "f_pps".
export const valueOf = (evaluation, objective) => (objective === "f_pps" ? evaluation.f_pps_um : evaluation.f_dte);

export const isCandidate = (evaluation) => evaluation.phase !== "reliability" && evaluation.phase !== "reference";

// The value that nine in ten stay below: few bad candidates shall not press all others flat.
export function usualMost(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length ? sorted[Math.floor(0.9 * (sorted.length - 1))] : 1;
}

// The evaluations at which the best improved.
export function improvements(evaluations, objective) {
  let best = Infinity;
  return evaluations.filter((evaluation) => {
    const value = valueOf(evaluation, objective);
    if (!isCandidate(evaluation) || value === null || value >= best) return false;
    best = value;
    return true;
  });
}

export function historyFigure(evaluations, objective) {
  const { name, unit } = OBJECTIVES[objective];
  const tried = evaluations.filter((evaluation) => isCandidate(evaluation) && valueOf(evaluation, objective) !== null);
  const reference = evaluations.find((evaluation) => evaluation.phase === "reference");
  const numbers = tried.map((evaluation) => evaluation.evaluation);
  let best = Infinity;
  const course = tried.map((evaluation) => (best = Math.min(best, valueOf(evaluation, objective))));
  const values = tried.map((evaluation) => valueOf(evaluation, objective));
  const high = 1.1 * Math.max(usualMost(values), reference ? valueOf(reference, objective) : 0, course[0] ?? 0);
  const beyond = values.filter((value) => value > high).length;
  const simplex = tried.find((evaluation) => evaluation.phase === "simplex");
  const rules = [];
  if (reference) rules.push({ axis: "y", at: valueOf(reference, objective), name: `reference ${significant(valueOf(reference, objective))}` });
  if (simplex) rules.push({ axis: "x", at: simplex.evaluation, name: "simplex" });
  return {
    id: "search-history",
    title: "Search history",
    summary: tried.length ? `Best ${significant(course.at(-1))} ${unit} after ${tried.length} candidates.` : "No candidates yet.",
    x: { label: "evaluation", unit: "number" },
    y: { label: name, unit, range: [0, high] },
    series: [
      { key: "candidates", name: beyond ? `candidates (${beyond} beyond the axis)` : "candidates", kind: "points", x: numbers, y: tried.map((evaluation) => valueOf(evaluation, objective)), colour: "faint", size: 1.8, opacity: 0.6 },
      { key: "best", name: "best so far", x: numbers, y: course, colour: 0, width: 2, step: true },
    ],
    rules,
  };
}

// The parameters that vary over the evaluations.
export function movingParameters(evaluations) {
  const first = evaluations.find(isCandidate)?.parameters || {};
  return Object.keys(first).filter((key) =>
    evaluations.some((evaluation) => isCandidate(evaluation) && evaluation.parameters[key] !== first[key]),
  );
}

const axisOf = (parameter) => {
  const { text, unit } = nameAndUnit(parameter);
  return { label: text, unit, air: true };
};

// All candidates over two parameters, coloured by the objective, and the way of the best.
export function landscapeFigure(evaluations, objective, [first, second]) {
  const { name, unit } = OBJECTIVES[objective];
  const tried = evaluations
    .filter((evaluation) => SEARCH_PHASES.has(evaluation.phase) && valueOf(evaluation, objective) !== null)
    .sort((a, b) => valueOf(b, objective) - valueOf(a, objective)); // the best on top
  const values = tried.map((evaluation) => valueOf(evaluation, objective));
  const path = improvements(evaluations, objective);
  const at = (list, key) => list.map((evaluation) => evaluation.parameters[key]);
  return {
    id: "objective-landscape",
    title: "Candidates",
    summary: `${tried.length} candidates over ${labelOf(first)} and ${labelOf(second)}, coloured by ${name}.`,
    x: axisOf(first),
    y: axisOf(second),
    scale: { label: name, unit, range: [Math.min(...values), usualMost(values)] },
    series: [
      { key: "candidates", name: "candidates", kind: "points", x: at(tried, first), y: at(tried, second), heat: tried.map((evaluation) => valueOf(evaluation, objective)), size: 3.2 },
      { key: "path", name: "path of the best", x: at(path, first), y: at(path, second), colour: "ink", width: 1, opacity: 0.6, folded: true, read: false },
      { key: "end", name: "best", kind: "points", hollow: true, x: at(path.slice(-1), first), y: at(path.slice(-1), second), colour: "ink", size: 6 },
    ],
  };
}

// A map over one or two parameters; objective "f_dte" or "f_pps".
export function mapFigure(map, objective) {
  const { name, unit, long } = OBJECTIVES[objective];
  const values = objective === "f_pps" ? map.f_pps_um : map.f_dte;
  const minima = map.local_minima[objective];
  const least = map.minima[objective];
  const title = `Map of ${name}`;
  if (map.axes.length === 1) {
    const [axis] = map.axes;
    const marks = minima.map((cell) => cell.cell[0]);
    return {
      id: `map-${objective}`,
      title,
      summary: `${long} over ${labelOf(axis.parameter)}.`,
      x: { ...axisOf(axis.parameter), air: false },
      y: { label: name, unit },
      series: [
        { key: "value", name, x: axis.values, y: values, colour: 0, width: 2 },
        { key: "minima", name: "local minima", kind: "points", hollow: true, x: marks.map((i) => axis.values[i]), y: marks.map((i) => values[i]), colour: 1, size: 5 },
      ],
    };
  }
  const [first, second] = map.axes;
  const numbers = values.flat().filter((value) => value !== null);
  return {
    id: `map-${objective}`,
    title,
    summary: numbers.length
      ? `${long} from ${significant(Math.min(...numbers))} to ${significant(Math.max(...numbers))} ${unit}; least at ${least.values.map((value) => significant(value, 5)).join(", ")} mm.`
      : "",
    x: axisOf(first.parameter),
    y: axisOf(second.parameter),
    grid: { x: first.values, y: second.values, z: second.values.map((_, j) => first.values.map((_, i) => values[i][j])), label: name, unit },
    series: [
      { key: "minima", name: "local minima", kind: "points", hollow: true, x: minima.map((cell) => cell.values[0]), y: minima.map((cell) => cell.values[1]), colour: "mark", size: 5, read: false },
      { key: "least", name: "least", kind: "points", x: [least.values[0]], y: [least.values[1]], colour: "mark", size: 4, read: false },
    ],
  };
}

// Bins of the trials so far, as the result has them at the end.
export function histogramOf(values, bins = 20) {
  const from = Math.min(...values);
  const to = Math.max(...values);
  const counts = new Array(bins).fill(0);
  for (const value of values) counts[Math.min(bins - 1, Math.floor(((value - from) / (to - from || 1)) * bins))]++;
  return { from, to, counts };
}

// Trials under manufacturing errors per bin of F_DTE, with the limit. reliability: of a result.
export function reliabilityFigure({ histogram, reliability, limit, trials }) {
  const { from, to, counts } = histogram;
  const width = (to - from) / counts.length || 1e-6;
  const rules = [{ axis: "x", at: limit, name: `limit ${plain(limit)}`, alarm: true }];
  for (const key of ["0.5", "0.95"]) {
    const at = reliability?.quantiles_f_dte[key];
    if (at !== undefined && at !== null) rules.push({ axis: "x", at, name: key === "0.5" ? "median" : `${fixed(100 * key)} %`, level: key === "0.5" ? 1 : 2 });
  }
  const verdict = reliability
    ? `Probability of failure ${percent(reliability.probability_of_failure, 1)}, 95 % confidence ${reliability.confidence_95.map((share) => percent(share, 1)).join(" to ")}.`
    : "";
  return {
    id: "reliability",
    title: "Reliability under manufacturing errors",
    summary: `${trials} trials from ${significant(from)} to ${significant(to)}, limit ${plain(limit)}. ${verdict}`,
    x: { label: "F_DTE, largest RMS of the dynamic transmission error", unit: "b", air: true },
    y: { label: "trials", unit: "number", zero: true },
    snap: false,
    series: [{ key: "trials", name: "trials", kind: "bars", x: counts.map((_, i) => from + i * width), y: counts, barWidth: width, colour: 0 }],
    rules,
  };
}

// Designs none of which is better in both objectives. front: [{f_dte, f_pps_um}]
export function paretoFigure(front, evaluations) {
  const tried = evaluations.filter((evaluation) => isCandidate(evaluation) && evaluation.f_dte !== null);
  const ordered = [...front].sort((a, b) => a.f_pps_um - b.f_pps_um);
  return {
    id: "pareto-front",
    title: "Pareto front",
    summary: `${front.length} designs none of which is better in both objectives.`,
    x: { label: "F_PPS, largest peak to peak of the static transmission error", unit: "µm", air: true },
    y: { label: "F_DTE", unit: "b" },
    series: [
      { key: "candidates", name: "candidates", kind: "points", x: tried.map((one) => one.f_pps_um), y: tried.map((one) => one.f_dte), colour: "faint", size: 1.8, opacity: 0.6 },
      { key: "front", name: "front", x: ordered.map((one) => one.f_pps_um), y: ordered.map((one) => one.f_dte), colour: 0, width: 1.5 },
      { key: "members", kind: "points", x: ordered.map((one) => one.f_pps_um), y: ordered.map((one) => one.f_dte), colour: 0, size: 3.5, read: false },
    ],
  };
}
