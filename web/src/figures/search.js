// Figures of a search, a map and a reliability study, from the log of evaluations and the result.
import { OBJECTIVES, fixed, labelOf, nameAndUnit, percent, plain, significant } from "../format.js";

// The value of an evaluation by an objective; null where it was not judged by it.
export const valueOf = (evaluation, objective) => evaluation[OBJECTIVES[objective].field] ?? null;

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
  if (reference)
    rules.push({
      axis: "y",
      at: valueOf(reference, objective),
      name: `reference ${significant(valueOf(reference, objective))}`,
    });
  if (simplex) rules.push({ axis: "x", at: simplex.evaluation, name: "simplex" });
  return {
    id: "search-history",
    title: "Search history",
    summary: tried.length
      ? `Best ${significant(course.at(-1))} ${unit} after ${tried.length} candidates.`
      : "No candidates yet.",
    x: { label: "evaluation", unit: "number" },
    y: { label: name, unit, range: [0, high] },
    series: [
      {
        key: "candidates",
        name: beyond ? `candidates, ${beyond} above` : "candidates",
        kind: "points",
        x: numbers,
        y: tried.map((evaluation) => valueOf(evaluation, objective)),
        colour: "faint",
        size: 1.8,
        opacity: 0.6,
      },
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
    .filter((evaluation) => isCandidate(evaluation) && valueOf(evaluation, objective) !== null)
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
      {
        key: "candidates",
        name: "candidates",
        kind: "points",
        x: at(tried, first),
        y: at(tried, second),
        heat: tried.map((evaluation) => valueOf(evaluation, objective)),
        size: 3.2,
      },
      {
        key: "path",
        name: "path of the best",
        x: at(path, first),
        y: at(path, second),
        colour: "ink",
        width: 1,
        opacity: 0.6,
        folded: true,
        read: false,
      },
      {
        key: "end",
        name: "best",
        kind: "points",
        hollow: true,
        x: at(path.slice(-1), first),
        y: at(path.slice(-1), second),
        colour: "ink",
        size: 6,
      },
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
        {
          key: "minima",
          name: "local minima",
          kind: "points",
          hollow: true,
          x: marks.map((i) => axis.values[i]),
          y: marks.map((i) => values[i]),
          colour: 1,
          size: 5,
        },
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
    grid: {
      x: first.values,
      y: second.values,
      z: second.values.map((_, j) => first.values.map((_, i) => values[i][j])),
      label: name,
      unit,
    },
    series: [
      {
        key: "minima",
        name: "local minima",
        kind: "points",
        hollow: true,
        x: minima.map((cell) => cell.values[0]),
        y: minima.map((cell) => cell.values[1]),
        colour: "mark",
        size: 5,
        read: false,
      },
      {
        key: "least",
        name: "least",
        kind: "points",
        x: [least.values[0]],
        y: [least.values[1]],
        colour: "mark",
        size: 4,
        read: false,
      },
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
    if (at !== undefined && at !== null)
      rules.push({
        axis: "x",
        at,
        name: key === "0.5" ? "median" : `${fixed(100 * key)} %`,
        level: key === "0.5" ? 1 : 2,
      });
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
    series: [
      {
        key: "trials",
        name: "trials",
        kind: "bars",
        x: counts.map((_, i) => from + i * width),
        y: counts,
        barWidth: width,
        colour: 0,
      },
    ],
    rules,
  };
}

// The objectives of a result with several.
export const objectivesOf = (result) => result.job.objectives || ["f_pps", "f_dte"];

// The evaluation that is the result's design, by its relief.
export function chosenOf(result) {
  const same = (one) => JSON.stringify(one.relief) === JSON.stringify(result.design.relief);
  return result.search.pareto.find(same)?.evaluation;
}

// Designs none of which is better in all objectives, over two of them. front: of a result's search; chosen: the number of the
// evaluation that is the result's design.
export function paretoFigure(front, evaluations, [first, second], chosen) {
  const tried = evaluations.filter(
    (one) => isCandidate(one) && valueOf(one, first) !== null && valueOf(one, second) !== null,
  );
  const axis = (objective) => ({ label: OBJECTIVES[objective].name, unit: OBJECTIVES[objective].unit, air: true });
  const points = (list) => ({
    kind: "points",
    x: list.map((one) => valueOf(one, first)),
    y: list.map((one) => valueOf(one, second)),
  });
  const limits = (objective) => {
    const values = [...front, ...tried].map((one) => valueOf(one, objective));
    const low = Math.min(...values);
    const high = Math.max(usualMost(values), ...front.map((one) => valueOf(one, objective)));
    return [low - 0.04 * (high - low || 1), high + 0.04 * (high - low || 1)];
  };
  return {
    id: "pareto-front",
    title: "Pareto front",
    summary: `${front.length} designs none of which is better in all objectives.`,
    x: { ...axis(first), range: limits(first) },
    y: { ...axis(second), range: limits(second) },
    series: [
      { key: "candidates", name: "candidates", ...points(tried), colour: "faint", size: 1.8, opacity: 0.6 },
      { key: "front", name: "front", ...points(front), colour: 0, size: 3.5 },
      {
        key: "chosen",
        name: "chosen",
        ...points(front.filter((one) => one.evaluation === chosen)),
        hollow: true,
        colour: "ink",
        size: 6,
      },
      {
        key: "reference",
        name: "reference",
        ...points(evaluations.filter((one) => one.phase === "reference")),
        colour: 1,
        size: 4,
      },
    ],
  };
}

// The pairs of a macro search: contact ratio against the larger of the two stress factors.
export function macroFigure(macro) {
  const stress = (one) => Math.max(one.contact_stress_factor, one.root_stress_factor);
  const points = (list) => ({ kind: "points", x: list.map((one) => one.contact_ratio), y: list.map(stress) });
  const { candidates, initial, best } = macro;
  return {
    id: "macro-front",
    title: "Pairs found",
    summary: `${candidates.length} pairs of ${macro.passed} that satisfy every constraint, out of ${macro.samples} samples.`,
    x: { label: "contact ratio", unit: "–", air: true },
    y: { label: "larger ISO 6336 stress / the initial pair's", unit: "–" },
    series: [
      {
        key: "kept",
        name: "largest contact ratios",
        ...points(candidates.filter((one) => !one.on_front)),
        colour: 5,
        size: 3.5,
      },
      { key: "front", name: "on the front", ...points(candidates.filter((one) => one.on_front)), colour: 0, size: 3.5 },
      {
        key: "best",
        name: "quietest",
        ...points(best === null ? [] : [candidates[best]]),
        hollow: true,
        colour: "ink",
        size: 6,
      },
      {
        key: "initial",
        name: "initial pair",
        kind: "points",
        x: [initial.contact_ratio],
        y: [1],
        colour: 1,
        size: 4.5,
      },
    ],
  };
}
