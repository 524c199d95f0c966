// A figure on the screen: drawn on a canvas, with a cursor that reads values (mouse, finger, arrow keys), zoom by dragging
// over a stretch of x or a box, curves that can be hidden, and a menu to take it away as CSV, SVG or PNG.
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { fixed, significant } from "../format.js";
import { useStore } from "../store.js";
import { theme } from "../theme.js";
import { colourOf, draw, layout, legendColour } from "./draw.js";
import { FileMenu } from "./menu.jsx";
import { canvasPainter } from "./painters.js";
import { palette } from "./palette.js";
import { download, figurePng, figureSvgText, fileName } from "./picture.js";
import { figureCsv, nearestIndex, readAt, readGrid } from "./read.js";

const DRAG_LEAST_PX = 8;
const TALL_PX = 40; // a drag that high zooms in on y as well

const isTall = ({ from, to }) => Math.abs(to.py - from.py) > TALL_PX;

// The width of an element, followed.
function useWidth(element) {
  const [width, setWidth] = useState(0);
  useLayoutEffect(() => {
    setWidth(element.current.clientWidth);
    const observer = new ResizeObserver(([entry]) => setWidth(Math.floor(entry.contentRect.width)));
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return width;
}

function prepare(canvas, { width, height }) {
  const scale = devicePixelRatio || 1;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  return context;
}

// The cursor: a line, a dot on every curve that was read, and the stretch that is being dragged.
function drawCursor(context, figure, frame, colours, { place, values, drag }) {
  const painter = canvasPainter(context);
  const { box } = frame;
  context.clearRect(0, 0, frame.width, frame.height);
  if (drag) {
    const { from, to } = drag;
    const [top, height] = isTall(drag) ? [from.py, to.py - from.py] : [box.top, box.height];
    painter.path((p) => p.rect(from.px, top, to.px - from.px, height), { fill: colours.axis, opacity: 0.25 });
  }
  if (!place) return;
  painter.path((p) => (p.moveTo(place.px, box.top), p.lineTo(place.px, box.top + box.height)), {
    stroke: colours.axis,
  });
  for (const series of figure.series) {
    const value = values.get(series.key);
    if (!value || series.kind === "bars") continue;
    const [x, y] = [frame.x(value.x), frame.y(value.y)];
    const fill = colourOf(series, colours);
    painter.path((p) => p.arc(x, y, 4, 0, 2 * Math.PI), { fill, stroke: colours.ground, width: 1.5 });
  }
}

function Swatch({ series, colours }) {
  const colour = legendColour(series, colours);
  const { kind = "line", width = 1.5, dash = [], opacity = 1, hollow } = series;
  return (
    <svg width="22" height="10" aria-hidden="true" class="swatch">
      {kind === "line" && (
        <line
          x1="0"
          y1="5"
          x2="22"
          y2="5"
          stroke={colour}
          stroke-width={width}
          stroke-dasharray={dash.join(" ")}
          opacity={opacity}
        />
      )}
      {kind === "points" && (
        <circle cx="11" cy="5" r="3.5" fill={hollow ? "none" : colour} stroke={colour} stroke-width="1.5" />
      )}
      {kind === "bars" && <rect x="4" y="0" width="14" height="10" fill={colour} opacity="0.75" />}
    </svg>
  );
}

// The legend of curves that have a row (the design) and a column (the load case) each.
function LegendTable({ shown, hidden, values, colours, onToggle }) {
  const rows = [...new Set(shown.map((series) => series.row))];
  const columns = [...new Set(shown.map((series) => series.column))];
  const cell = (row, column) => {
    const series = shown.find((one) => one.row === row && one.column === column);
    if (!series) return <td key={column} />;
    const isHidden = hidden.has(series.key);
    return (
      <td key={column}>
        <button
          type="button"
          class="quiet"
          aria-pressed={!isHidden}
          aria-label={series.name}
          onClick={() => onToggle(series.key)}
        >
          <Swatch series={series} colours={colours} />
        </button>
        <output class="number">{values.has(series.key) ? significant(values.get(series.key).y, 4) : ""}</output>
      </td>
    );
  };
  return (
    <table class="legend-table">
      <caption class="unseen">Curves: choose one to hide or show it</caption>
      <thead>
        <tr>
          <td />
          {columns.map((column) => (
            <th scope="col" key={column}>
              {column}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row}>
            <th scope="row">{row}</th>
            {columns.map((column) => cell(row, column))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Legend({ figure, hidden, values, colours, onToggle }) {
  const shown = figure.series.filter((series) => series.name);
  if (shown.length === 0) return null;
  if (shown.every((series) => series.row))
    return <LegendTable shown={shown} hidden={hidden} values={values} colours={colours} onToggle={onToggle} />;
  return (
    <ul class="legend">
      {shown.map((series) => (
        <li key={series.key}>
          <button
            type="button"
            class="quiet"
            aria-pressed={!hidden.has(series.key)}
            onClick={() => onToggle(series.key)}
          >
            <Swatch series={series} colours={colours} />
            {series.name}
          </button>
          <output class="number">{values.has(series.key) ? significant(values.get(series.key).y, 4) : ""}</output>
        </li>
      ))}
    </ul>
  );
}

function axisValue({ label, short = label, unit, digits }, value) {
  return `${short} ${digits === undefined ? significant(value, 5) : fixed(value, digits)}${unit && unit !== "–" ? ` ${unit}` : ""}`;
}

// Where the cursor stands, in words.
export function placeText(figure, frame, place, values) {
  if (!place) return "";
  const cell = readGrid(figure, frame, place);
  if (cell)
    return [axisValue(figure.x, cell.x), axisValue(figure.y, cell.y), axisValue(figure.grid, cell.z)].join(" · ");
  const near = [...values.values()][0];
  const x = figure.snap !== false && near ? near.x : frame.x.invert(place.px);
  const parts = [axisValue(figure.x, x)];
  if (figure.top) parts.push(axisValue(figure.top, x * figure.top.factor));
  return parts.join(" · ");
}

// The same with all values, for those who listen.
function spokenText(figure, frame, place, values) {
  if (!place) return "";
  const read = figure.series.filter((series) => values.has(series.key) && series.name);
  const said = read.map((series) => `${series.name} ${significant(values.get(series.key).y, 4)} ${figure.y.unit}`);
  return [placeText(figure, frame, place, values), ...said].join("; ");
}

function Menu({ figure, name, hidden, zoom, onReset }) {
  const file = (ending) => `${fileName(name, figure.id)}.${ending}`;
  const csv = () => download(file("csv"), figureCsv(figure), "text/csv");
  const svg = () => download(file("svg"), figureSvgText(figure, { hidden, zoom }), "image/svg+xml");
  const png = async () => download(file("png"), await figurePng(figure, { hidden, zoom }));
  const files = [
    ["CSV", csv],
    ["SVG", svg],
    ["PNG", png],
  ];
  return (
    <FileMenu title={figure.title} files={files}>
      {zoom && (
        <button type="button" class="quiet" onClick={onReset}>
          Whole range
        </button>
      )}
    </FileMenu>
  );
}

// All that a pointer and the keyboard do to a plot: {place, drag, zoom, handlers, reset}.
function useCursor(frameRef, figure) {
  const [place, setPlace] = useState(null);
  const [drag, setDrag] = useState(null);
  const [zoom, setZoom] = useState(figure.y.usual ? { y: figure.y.usual } : null);
  const inside = (event) => {
    const { box } = frameRef.current;
    const bounds = event.currentTarget.getBoundingClientRect();
    const px = Math.max(box.left, Math.min(box.left + box.width, event.clientX - bounds.left));
    const py = Math.max(box.top, Math.min(box.top + box.height, event.clientY - bounds.top));
    return { px, py };
  };
  const finishDrag = () => {
    const { x, y } = frameRef.current;
    const ends = (scale, from, to) => [scale.invert(from), scale.invert(to)].sort((a, b) => a - b);
    if (drag && Math.abs(drag.to.px - drag.from.px) > DRAG_LEAST_PX)
      setZoom({
        x: ends(x, drag.from.px, drag.to.px),
        y: isTall(drag) ? ends(y, drag.from.py, drag.to.py) : zoom?.y,
      });
    setDrag(null);
  };
  const step = (sign, large) => {
    const { box, x } = frameRef.current;
    const curve = figure.series.find((series) => series.kind !== "points" && series.x.length > 1);
    const at = place?.px ?? box.left + box.width / 2;
    const py = place?.py ?? box.top + box.height / 2;
    let px = at + sign * (large ? 40 : 8);
    if (curve && !large) {
      const index = nearestIndex(curve.x, x.invert(at));
      px = x(curve.x[Math.max(0, Math.min(curve.x.length - 1, index + sign))]);
    }
    setPlace({ px: Math.max(box.left, Math.min(box.left + box.width, px)), py });
  };
  const zoomBy = (factor) => {
    const { x, box } = frameRef.current;
    const middle = x.invert(place?.px ?? box.left + box.width / 2);
    const [low, high] = x.domain();
    setZoom({ ...zoom, x: [middle - (middle - low) * factor, middle + (high - middle) * factor] });
  };
  const handlers = {
    onPointerMove(event) {
      const at = inside(event);
      setPlace(at);
      if (drag) setDrag({ ...drag, to: at });
    },
    onPointerDown(event) {
      if (event.button !== 0 || event.pointerType === "touch" || figure.grid) return;
      const at = inside(event);
      event.currentTarget.setPointerCapture(event.pointerId);
      setDrag({ from: at, to: at });
    },
    onPointerUp: finishDrag,
    onPointerLeave: () => drag || setPlace(null),
    onDblClick: () => setZoom(null),
    onBlur: () => setPlace(null),
    onKeyDown(event) {
      const keys = {
        ArrowLeft: () => step(-1, event.shiftKey),
        ArrowRight: () => step(1, event.shiftKey),
        "+": () => figure.grid || zoomBy(0.5),
        "-": () => zoom && zoomBy(2),
        Escape: () => (setZoom(null), setPlace(null)),
      };
      if (!keys[event.key]) return;
      keys[event.key]();
      event.preventDefault();
    },
  };
  return { place, drag, zoom, handlers, reset: () => setZoom(null) };
}

const KEYS_HINT = "Arrow keys move the cursor, plus and minus zoom, Escape resets.";

// name: what downloaded files are called after. height in CSS pixels. controls: more for the line above.
export function Plot({ figure, name, height = 280, controls }) {
  const holder = useRef(null);
  const canvas = useRef(null);
  const overlay = useRef(null);
  const frameRef = useRef(null);
  const width = useWidth(holder);
  const [hidden, setHidden] = useState(() => new Set(figure.hidden || []));
  const { place, drag, zoom, handlers, reset } = useCursor(frameRef, figure);
  const colours = palette(useStore(theme));
  const frame = useMemo(
    () => layout(figure, { width: Math.max(width, 200), height }, { hidden, zoom }),
    [figure, width, height, hidden, zoom],
  );
  frameRef.current = frame;
  const values = place ? readAt(figure, frame, place, hidden) : new Map();

  useLayoutEffect(() => {
    if (width === 0) return;
    draw(canvasPainter(prepare(canvas.current, frame)), figure, frame, colours, { hidden });
    if (performance.getEntriesByName("first plot").length === 0) performance.mark("first plot");
  }, [figure, frame, colours, hidden]);
  useEffect(() => {
    if (width > 0) drawCursor(prepare(overlay.current, frame), figure, frame, colours, { place, values, drag });
  });

  const toggle = (key) => {
    const next = new Set(hidden);
    if (!next.delete(key)) next.add(key);
    setHidden(next);
  };
  const summary = `${figure.summary || ""} ${KEYS_HINT}`;
  return (
    <figure class="plot">
      <Menu figure={figure} name={name} hidden={hidden} zoom={zoom} onReset={reset} />
      {controls && <div class="plot-bar">{controls}</div>}
      <div
        ref={holder}
        class="plot-area"
        tabIndex={0}
        role="group"
        aria-label={`${figure.title}. ${summary}`}
        {...handlers}
      >
        <canvas ref={canvas} aria-hidden="true" />
        <canvas ref={overlay} class="overlay" aria-hidden="true" />
        <span class="unseen" aria-live="polite">
          {document.activeElement === holder.current ? spokenText(figure, frame, place, values) : ""}
        </span>
      </div>
      <div class="reading number">{placeText(figure, frame, place, values) || "\u00a0"}</div>
      <Legend figure={figure} hidden={hidden} values={values} colours={colours} onToggle={toggle} />
    </figure>
  );
}
