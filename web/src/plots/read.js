// Reading values off a figure: what the curves say at a place, and the figure's data as a table.
import { isVisible } from "./draw.js";

// True when x grows, or falls, all along.
function isMonotone(x) {
  const sign = Math.sign(x.at(-1) - x[0]) || 1;
  for (let i = 1; i < x.length; i++) if ((x[i] - x[i - 1]) * sign < 0) return false;
  return true;
}

const monotone = new WeakMap();
function knownMonotone(x) {
  if (!monotone.has(x)) monotone.set(x, isMonotone(x));
  return monotone.get(x);
}

// The index of the entry of a growing list that is nearest to a value.
export function nearestIndex(list, value) {
  let low = 0;
  let high = list.length - 1;
  const up = list[high] >= list[low];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] < value === up) low = middle;
    else high = middle;
  }
  return Math.abs(list[low] - value) <= Math.abs(list[high] - value) ? low : high;
}

function nearestPoint(series, frame, place) {
  let best = -1;
  let least = 40 ** 2;
  for (let i = 0; i < series.x.length; i++) {
    if (series.y[i] === null) continue;
    const distance = (frame.x(series.x[i]) - place.px) ** 2 + (frame.y(series.y[i]) - place.py) ** 2;
    if (distance < least) [least, best] = [distance, i];
  }
  return best;
}

// What each series says at a place {px, py} in pixels: a Map from its key to {x, y, index}. A curve that is a function of x is
// read at the nearest x; points and folded curves where they come near.
export function readAt(figure, frame, place, hidden) {
  const values = new Map();
  const x = frame.x.invert(place.px);
  for (const series of figure.series) {
    if (series.read === false || series.x.length === 0 || !isVisible(series, hidden)) continue;
    let index;
    if (series.kind === "bars") index = series.x.findLastIndex((from) => from <= x && x < from + series.barWidth);
    else if (series.kind === "points" || !knownMonotone(series.x)) index = nearestPoint(series, frame, place);
    else index = nearestIndex(series.x, x);
    if (index < 0 || series.y[index] === null) continue;
    values.set(series.key, { x: series.x[index], y: series.y[index], index });
  }
  return values;
}

// The cell of a heat map at a place: {x, y, z} or null.
export function readGrid(figure, frame, place) {
  const { grid } = figure;
  if (!grid) return null;
  const i = nearestIndex(grid.x, frame.x.invert(place.px));
  const j = nearestIndex(grid.y, frame.y.invert(place.py));
  return { x: grid.x[i], y: grid.y[j], z: grid.z[j][i] };
}

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
const axisName = ({ label, unit }) => (unit ? `${label}, ${unit}` : label);

// All data of a figure as CSV (RFC 4180, full precision): series that share their x share its column.
export function figureCsv(figure) {
  if (figure.grid) return gridCsv(figure);
  const columns = [];
  const byX = new Map();
  for (const series of figure.series.filter((one) => one.inCsv !== false)) {
    const key = series.x;
    if (!byX.has(key)) byX.set(key, []);
    byX.get(key).push(series);
  }
  for (const [x, group] of byX) {
    const tag = byX.size > 1 ? ` (${group[0].name || group[0].key})` : "";
    columns.push({ head: axisName(figure.x) + tag, values: x });
    if (figure.top && byX.size === 1)
      columns.push({ head: axisName(figure.top), values: x.map((value) => value * figure.top.factor) });
    for (const series of group)
      columns.push({ head: `${series.name || series.key}: ${axisName(figure.y)}`, values: series.y });
    for (const series of group) if (series.heat) columns.push({ head: axisName(figure.scale), values: series.heat });
    for (const extra of group.flatMap((series) => series.extra || [])) columns.push(extra);
  }
  const length = Math.max(0, ...columns.map((column) => column.values.length));
  const rows = [columns.map((column) => quoted(column.head)).join(",")];
  for (let i = 0; i < length; i++) rows.push(columns.map((column) => (column.values[i] ?? "").toString()).join(","));
  return `${rows.join("\r\n")}\r\n`;
}

function gridCsv({ x, y, grid }) {
  const rows = [[axisName(x), axisName(y), axisName(grid)].map(quoted).join(",")];
  grid.z.forEach((row, j) => row.forEach((value, i) => rows.push([grid.x[i], grid.y[j], value ?? ""].join(","))));
  return `${rows.join("\r\n")}\r\n`;
}
