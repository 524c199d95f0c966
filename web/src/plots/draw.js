// Drawing a figure. A figure is plain data; the same code draws it on the screen, into SVG and PNG, and on paper.
//
//   {id, title, summary,            summary: the text alternative
//    x, y: {label, short, unit, digits, range, usual, zero, air},   range: [from, to], made from the data when absent; usual: what is shown
//                                   at first, where the whole is seldom looked at; zero: begins at zero; air: some around the data
//    top: {label, unit, factor},    a second scale of x above: value = x * factor
//    series: [{key, name, kind, x: [], y: [], colour, width, dash, opacity, size, read, inCsv,
//              row, column, jump, step, heat, folded, extra}],
//                                   kind: line (default), points, bars (y over [x, x + barWidth]); row, column: its place in
//                                   the legend; read: false: the cursor passes over it; inCsv: false: not in the CSV; extra:
//                                   more columns for it; step: y holds until the next x
//                                   colour: a number of the palette, "ink", "faint", "alarm" or "mark"
//                                   y null: a gap; jump: differences in y above this are drawn dotted; heat: a value per
//                                   point, coloured by figure.scale; folded: x does not grow all along
//    rules: [{axis: "x" | "y", at, name, alarm, level}],   level: the line that its name stands on
//    scale: {label, unit, range},   of the colours of heat; what is beyond the range has the colour of its end
//    grid: {x: [], y: [], z: [row of y][of x], label, unit, digits}}   a heat map with contours
//
// Lengths are in CSS pixels, y downwards. A frame is what layout makes of a figure and a size: the scales and the margins.
import { contours } from "d3-contour";
import { scaleLinear } from "d3-scale";
import { curveStepAfter, line } from "d3-shape";
import { heatCss } from "./palette.js";

export const isVisible = (series, hidden) => !hidden?.has(series.key);

function extend(range, values) {
  for (const value of values) {
    if (value === null || value === undefined || Number.isNaN(value)) continue;
    if (value < range[0]) range[0] = value;
    if (value > range[1]) range[1] = value;
  }
  return range;
}

const EMPTY = () => [Infinity, -Infinity];

// Half a cell beyond the first and the last place, so that whole cells are seen.
function cellRange(values) {
  const first = values[0];
  const last = values.at(-1);
  const half = values.length > 1 ? Math.abs(last - first) / (values.length - 1) / 2 : Math.abs(first) / 2 || 0.5;
  return [Math.min(first, last) - half, Math.max(first, last) + half];
}

function dataRange(figure, axis, hidden) {
  if (figure.grid) return cellRange(figure.grid[axis]);
  const range = EMPTY();
  for (const series of figure.series) if (isVisible(series, hidden)) extend(range, series[axis]);
  if (axis === "x") for (const series of figure.series) if (series.kind === "bars") range[1] += series.barWidth;
  for (const rule of figure.rules || []) if (rule.axis === axis) extend(range, [rule.at]);
  return range[0] > range[1] ? [0, 1] : range;
}

// The range of an axis: as wanted, or that of the data with some air; from zero where the axis says so.
function axisRange(figure, axis, hidden) {
  const spec = figure[axis];
  if (spec.range) return spec.range;
  const [low, high] = dataRange(figure, axis, hidden);
  if (figure.grid || (axis === "x" && !spec.air)) return low === high ? [low - 0.5, high + 0.5] : [low, high];
  const air = (high - low || Math.abs(high) || 1) * 0.06;
  return [spec.zero ? Math.min(0, low) : low - air, high + air];
}

// The scales and margins of a figure at a size {width, height}. `zoom`: {x: range, y: range} instead of the whole.
export function layout(figure, { width, height }, { hidden, zoom, head = 0 } = {}) {
  const left = 58;
  const right = figure.grid || figure.scale ? 74 : 14;
  const top = head + (figure.top ? 40 : 10);
  const bottom = 40;
  const box = { left, top, width: Math.max(10, width - left - right), height: Math.max(10, height - top - bottom) };
  const x = scaleLinear(zoom?.x || axisRange(figure, "x", hidden), [left, left + box.width]);
  const y = scaleLinear(zoom?.y || axisRange(figure, "y", hidden), [top + box.height, top]);
  if (!figure.y.range && !zoom?.y && !figure.grid) y.nice(5);
  return { width, height, box, x, y, head };
}

const minus = (text) => text.replace("-", "\u2212").replaceAll(",", "\u202f");

function tickPlaces(scale, count) {
  const format = scale.tickFormat(count);
  return scale.ticks(count).map((value) => ({ value, text: minus(format(value)) }));
}

const axisLabel = ({ label, unit }) => (unit ? `${label}, ${unit}` : label);

function drawXAxis(painter, figure, frame, colours) {
  const { box, x } = frame;
  const base = box.top + box.height;
  for (const { value, text } of tickPlaces(x, Math.max(3, Math.round(box.width / 80)))) {
    const at = x(value);
    if (!figure.grid) painter.path((p) => (p.moveTo(at, box.top), p.lineTo(at, base)), { stroke: colours.line });
    painter.path((p) => (p.moveTo(at, base), p.lineTo(at, base + 4)), { stroke: colours.axis });
    painter.text(at, base + 16, text, { fill: colours.faint, anchor: "middle" });
  }
  painter.text(box.left + box.width / 2, base + 33, axisLabel(figure.x), { fill: colours.ink, anchor: "middle" });
}

function drawYAxis(painter, figure, frame, colours) {
  const { box, y } = frame;
  for (const { value, text } of tickPlaces(y, Math.max(3, Math.round(box.height / 48)))) {
    const at = y(value);
    if (!figure.grid)
      painter.path((p) => (p.moveTo(box.left, at), p.lineTo(box.left + box.width, at)), { stroke: colours.line });
    painter.path((p) => (p.moveTo(box.left - 4, at), p.lineTo(box.left, at)), { stroke: colours.axis });
    painter.text(box.left - 7, at + 4, text, { fill: colours.faint, anchor: "end" });
  }
  const middle = box.top + box.height / 2;
  painter.text(14, middle, axisLabel(figure.y), { fill: colours.ink, anchor: "middle", turn: -90 });
}

function drawTopAxis(painter, figure, frame, colours) {
  const { box, x } = frame;
  const { factor } = figure.top;
  const scale = scaleLinear(
    x.domain().map((value) => value * factor),
    x.range(),
  );
  for (const { value, text } of tickPlaces(scale, Math.max(3, Math.round(box.width / 90)))) {
    const at = scale(value);
    painter.path((p) => (p.moveTo(at, box.top - 4), p.lineTo(at, box.top)), { stroke: colours.axis });
    painter.text(at, box.top - 8, text, { fill: colours.faint, anchor: "middle" });
  }
  painter.text(box.left + box.width / 2, box.top - 25, axisLabel(figure.top), { fill: colours.ink, anchor: "middle" });
}

function drawFrame(painter, frame, colours) {
  const { left, top, width, height } = frame.box;
  painter.path((p) => p.rect(left, top, width, height), { stroke: colours.axis });
}

export function colourOf(series, colours) {
  if (series.colour === "mark") return "#ffffff";
  if (series.colour === "ink" || series.colour === "faint" || series.colour === "alarm") return colours[series.colour];
  return colours.series[(series.colour || 0) % colours.series.length];
}

// Cuts a curve with very many points to the least and greatest of each pixel's width, which looks the same.
function thinned(series, frame) {
  const { x, y } = series;
  const most = 4 * frame.box.width;
  if (x.length <= most || series.folded) return x.map((_, i) => i);
  const kept = [];
  const step = Math.ceil(x.length / (most / 2));
  for (let start = 0; start < x.length; start += step) {
    let low = start;
    let high = start;
    for (let i = start; i < Math.min(start + step, x.length); i++) {
      if (y[i] < y[low]) low = i;
      if (y[i] > y[high]) high = i;
    }
    kept.push(Math.min(low, high), ...(low === high ? [] : [Math.max(low, high)]));
  }
  return kept;
}

const isNumber = (value) => value !== null && value !== undefined && Number.isFinite(value);

// A step of y that is large, and far larger than those before and after it: a jump, not a steep slope.
function isJump({ y, jump }, from, to) {
  const step = (a, b) => (isNumber(y[a]) && isNumber(y[b]) ? Math.abs(y[b] - y[a]) : 0);
  const size = step(from, to);
  return jump !== undefined && size > jump && size > 3 * Math.max(step(from - 1, from), step(to, to + 1));
}

function drawLine(painter, series, frame, colours) {
  const { x, y } = frame;
  const indices = thinned(series, frame);
  const jumps = [];
  const target = line(
    (i) => x(series.x[i]),
    (i) => y(series.y[i]),
  ).defined((i) => isNumber(series.y[i]));
  if (series.step) target.curve(curveStepAfter);
  const runs = [[]];
  for (const i of indices) {
    const before = runs.at(-1).at(-1);
    if (before !== undefined && isJump(series, before, i)) {
      jumps.push([before, i]);
      runs.push([]);
    }
    runs.at(-1).push(i);
  }
  const stroke = colourOf(series, colours);
  const { width = 1.5, dash = [], opacity = 1 } = series;
  painter.path((p) => runs.forEach((run) => target.context(p)(run)), { stroke, width, dash, opacity });
  if (jumps.length)
    painter.path((p) => jumps.forEach((pair) => target.context(p)(pair)), { stroke, width: 1, dash: [2, 3], opacity });
}

const HEAT_STEPS = 32;

// Points coloured by their value, step by step of the scale from the greatest to the least, so that the least end on top.
function drawHeatPoints(painter, series, frame, scale) {
  const [low, high] = scale.range || extend(EMPTY(), series.heat);
  const steps = Array.from({ length: HEAT_STEPS }, () => []);
  series.heat.forEach((value, i) => {
    const share = (value - low) / (high - low || 1);
    steps[Math.max(0, Math.min(HEAT_STEPS - 1, Math.floor(share * HEAT_STEPS)))].push(i);
  });
  for (let step = HEAT_STEPS - 1; step >= 0; step--) {
    const part = { ...series, x: steps[step].map((i) => series.x[i]), y: steps[step].map((i) => series.y[i]) };
    drawPoints(painter, { ...part, heat: undefined, css: heatCss((step + 0.5) / HEAT_STEPS) }, frame, {});
  }
}

function drawPoints(painter, series, frame, colours, figure) {
  if (series.heat) {
    drawHeatPoints(painter, series, frame, figure.scale);
    return;
  }
  const { x, y } = frame;
  const { size = 2.5, opacity = 1, hollow } = series;
  const colour = series.css || colourOf(series, colours);
  const build = (p) => {
    for (let i = 0; i < series.x.length; i++) {
      if (!isNumber(series.y[i])) continue;
      const [cx, cy] = [x(series.x[i]), y(series.y[i])];
      p.moveTo(cx + size, cy);
      p.arc(cx, cy, size, 0, 2 * Math.PI);
    }
  };
  painter.path(build, hollow ? { stroke: colour, width: 1.5, opacity } : { fill: colour, opacity });
}

function drawBars(painter, series, frame, colours) {
  const { x, y } = frame;
  const build = (p) => {
    for (let i = 0; i < series.x.length; i++) {
      const from = x(series.x[i]);
      const to = x(series.x[i] + series.barWidth);
      p.rect(from + 0.5, y(series.y[i]), Math.max(1, to - from - 1), y(0) - y(series.y[i]));
    }
  };
  painter.path(build, { fill: colourOf(series, colours), opacity: series.opacity ?? 0.75 });
}

const KINDS = { line: drawLine, points: drawPoints, bars: drawBars };

function drawRule(painter, rule, frame, colours) {
  const { box, x, y } = frame;
  const stroke = rule.alarm ? colours.alarm : colours.faint;
  const at = rule.axis === "x" ? x(rule.at) : y(rule.at);
  const build =
    rule.axis === "x"
      ? (p) => (p.moveTo(at, box.top), p.lineTo(at, box.top + box.height))
      : (p) => (p.moveTo(box.left, at), p.lineTo(box.left + box.width, at));
  painter.path(build, { stroke, width: 1.25, dash: [5, 3] });
  if (rule.axis === "x") {
    const anchor = at > box.left + box.width / 2 ? "end" : "start";
    painter.text(at + (anchor === "end" ? -5 : 5), box.top + 13 + 14 * (rule.level || 0), rule.name, {
      fill: stroke,
      anchor,
    });
  } else {
    painter.text(box.left + box.width - 5, at - 5, rule.name, { fill: stroke, anchor: "end" });
  }
}

// --- heat maps ---

export function gridRange(grid) {
  return grid.z.reduce(extend, EMPTY());
}

function drawCells(painter, grid, frame) {
  const [low, high] = gridRange(grid);
  const { x, y } = frame;
  const dx = grid.x.length > 1 ? (grid.x[1] - grid.x[0]) / 2 : 0.5;
  const dy = grid.y.length > 1 ? (grid.y[1] - grid.y[0]) / 2 : 0.5;
  grid.z.forEach((row, j) =>
    row.forEach((value, i) => {
      if (!isNumber(value)) return;
      const [x0, x1] = [x(grid.x[i] - dx), x(grid.x[i] + dx)].sort((a, b) => a - b);
      const [y0, y1] = [y(grid.y[j] - dy), y(grid.y[j] + dy)].sort((a, b) => a - b);
      const fill = heatCss((value - low) / (high - low || 1));
      painter.path((p) => p.rect(x0, y0, x1 - x0 + 0.5, y1 - y0 + 0.5), { fill });
    }),
  );
}

// Contour lines at round values; cells without a value count as high.
function drawContours(painter, grid, frame) {
  const columns = grid.x.length;
  const rows = grid.y.length;
  if (columns < 3 || rows < 3) return;
  const [low, high] = gridRange(grid);
  const levels = scaleLinear([low, high], [0, 1]).ticks(9);
  const values = grid.z.flat().map((value) => (isNumber(value) ? value : high + 1));
  const place = ([i, j]) => {
    const at = (list, k) => list[0] + (k - 0.5) * (list.length > 1 ? list[1] - list[0] : 1);
    return [frame.x(at(grid.x, i)), frame.y(at(grid.y, j))];
  };
  const inside = ([i, j]) => i > 0 && i < columns && j > 0 && j < rows; // what runs along the border is no contour
  for (const shape of contours().size([columns, rows]).thresholds(levels)(values)) {
    const build = (p) =>
      shape.coordinates.flat().forEach((ring) =>
        ring.forEach((point, k) => {
          const [px, py] = place(point);
          const joins = k > 0 && (inside(point) || inside(ring[k - 1]));
          if (joins) p.lineTo(px, py);
          else p.moveTo(px, py);
        }),
      );
    painter.path(build, { stroke: "#ffffff", width: 1, opacity: 0.55 });
  }
}

const heatRange = (figure) =>
  figure.scale.range || figure.series.reduce((range, series) => extend(range, series.heat || []), EMPTY());

// The scale of colours, right of the box.
function drawColourBar(painter, figure, frame, colours) {
  const { box } = frame;
  const spec = figure.grid || figure.scale;
  const [low, high] = figure.grid ? gridRange(figure.grid) : heatRange(figure);
  if (!(low < high)) return;
  const left = box.left + box.width + 12;
  const steps = 64;
  for (let i = 0; i < steps; i++) {
    const top = box.top + (box.height * i) / steps;
    painter.path((p) => p.rect(left, top, 10, box.height / steps + 0.5), { fill: heatCss(1 - (i + 0.5) / steps) });
  }
  const scale = scaleLinear([low, high], [box.top + box.height, box.top]);
  for (const { value, text } of tickPlaces(scale, Math.round(box.height / 40)))
    painter.text(left + 14, scale(value) + 4, text, { fill: colours.faint });
  const middle = box.top + box.height / 2;
  painter.text(frame.width - 4, middle, axisLabel(spec), { fill: colours.ink, anchor: "middle", turn: -90 });
}

// --- the whole ---

// Draws a figure into its frame. options: {hidden: Set of keys}
export function draw(painter, figure, frame, colours, { hidden } = {}) {
  const { box } = frame;
  painter.title(`${figure.title}. ${figure.summary || ""}`);
  painter.path((p) => p.rect(0, 0, frame.width, frame.height), { fill: colours.ground });
  drawXAxis(painter, figure, frame, colours);
  drawYAxis(painter, figure, frame, colours);
  if (figure.top) drawTopAxis(painter, figure, frame, colours);
  painter.clip(box.left, box.top, box.width, box.height, () => {
    if (figure.grid) {
      drawCells(painter, figure.grid, frame);
      drawContours(painter, figure.grid, frame);
    }
    for (const series of figure.series)
      if (isVisible(series, hidden)) KINDS[series.kind || "line"](painter, series, frame, colours, figure);
    for (const rule of figure.rules || []) drawRule(painter, rule, frame, colours);
  });
  if (figure.grid || figure.scale) drawColourBar(painter, figure, frame, colours);
  drawFrame(painter, frame, colours);
}

// Title and legend above the box, for pictures that leave the page; returns the height it took.
export function drawHead(painter, figure, width, colours, { hidden, measureOnly } = {}) {
  const shown = figure.series.filter((series) => series.name && isVisible(series, hidden));
  let x = 14;
  let y = 38;
  if (!measureOnly) painter.text(14, 18, figure.title, { fill: colours.ink, size: 13, weight: 600 });
  for (const series of shown) {
    const length = 30 + series.name.length * 6.2;
    if (x + length > width && x > 14) {
      x = 14;
      y += 16;
    }
    if (!measureOnly) drawSwatch(painter, series, x, y - 4, colours);
    if (!measureOnly) painter.text(x + 24, y, series.name, { fill: colours.ink });
    x += length;
  }
  return shown.length ? y + 10 : 26;
}

// The colour of a series where it stands beside the plot: marks on a heat map are white there.
export const legendColour = (series, colours) => (series.colour === "mark" ? colours.ink : colourOf(series, colours));

export function drawSwatch(painter, series, x, y, colours) {
  const stroke = legendColour(series, colours);
  const { kind = "line", width = 1.5, dash = [], opacity = 1 } = series;
  if (kind === "points")
    painter.path(
      (p) => (p.moveTo(x + 13, y), p.arc(x + 10, y, 3, 0, 2 * Math.PI)),
      series.hollow ? { stroke } : { fill: stroke },
    );
  else if (kind === "bars") painter.path((p) => p.rect(x + 4, y - 4, 12, 8), { fill: stroke, opacity: 0.75 });
  else painter.path((p) => (p.moveTo(x, y), p.lineTo(x + 20, y)), { stroke, width, dash, opacity });
}
