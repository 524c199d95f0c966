// The finite elements of the engaged teeth with their stress in colour, from the server's field, on a canvas: the pinion below, the
// gear above as in teeth.jsx. Displacements can be magnified; the pinion's contain its turn under load.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { fixed } from "../format.js";
import { complain } from "../parts/parts.jsx";
import { FileMenu } from "../plots/menu.jsx";
import { canvasPainter } from "../plots/painters.js";
import { heatCss, palette } from "../plots/palette.js";
import { canvasPng, download, fileName } from "../plots/picture.js";
import { useStore } from "../store.js";
import { theme } from "../theme.js";

export const QUANTITIES = {
  von_mises_mpa: { name: "von Mises stress", short: "von Mises" },
  max_principal_mpa: { name: "largest principal stress, tension", short: "tension" },
};
export const MAGNIFICATIONS = [0, 20, 50, 100, 200];

const HEIGHT = 420;
const BAR = 76; // px on the right for the scale
const SHADES = 48;
const PICTURE = { width: 800, height: HEIGHT + 66, top: 66 };
const DEPTHS = 3; // working depths of the teeth in the height of the canvas
const ABOVE_TENSION = 1.25; // where the colours end, in largest tensions: what roots bear is told apart, contact is beyond
const GEARS = ["pinion", "gear"];

// Places of the nodes on the plane of the screen, mm: (x, y) goes to (-y, -x), displaced.
function placesOf(gear, magnification) {
  const factor = magnification * 1e-3;
  return gear.x_mm.map((x, i) => [-(gear.y_mm[i] + factor * gear.displacement_y_um[i]), -(x + factor * gear.displacement_x_um[i])]);
}

const radii = ({ x_mm: x, y_mm: y, center_x_mm: center }) => x.map((one, i) => Math.hypot(one - center, y[i]));
const greatest = (values) => values.reduce((most, value) => Math.max(most, value), 0);

// Pixels of a place, at one scale for both axes: the teeth in mesh fill the height, with what their roots bear on.
function projection(field, width) {
  const tips = [field.pinion.center_x_mm + greatest(radii(field.pinion)), field.gear.center_x_mm - greatest(radii(field.gear))];
  const scale = HEIGHT / (DEPTHS * (tips[0] - tips[1]));
  const middle = -(tips[0] + tips[1]) / 2;
  return ([x, y]) => [(width - BAR) / 2 + scale * x, HEIGHT / 2 + scale * (y - middle)];
}

export function largest(field, quantity) {
  return GEARS.map((name) => greatest(field[name][quantity]));
}

// The stress at which the colours end.
function scaleEnd(field, quantity) {
  const tension = Math.max(...largest(field, "max_principal_mpa"));
  return Math.min(Math.max(...largest(field, quantity)), ABOVE_TENSION * tension) || 1;
}

// The middle of two points, or of two values.
const half = (a, b) => (Array.isArray(a) ? [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] : (a + b) / 2);

// Cuts a quadrilateral [a, b, c, d] of corners (or values) into four.
function quarters([a, b, c, d]) {
  const [ab, bc, cd, da] = [half(a, b), half(b, c), half(c, d), half(d, a)];
  const middle = half(ab, cd);
  return [
    [a, ab, middle, da],
    [ab, b, bc, middle],
    [middle, bc, c, cd],
    [da, middle, cd, d],
  ];
}

function tracePolygon(context, points) {
  context.moveTo(...points[0]);
  for (const point of points.slice(1)) context.lineTo(...point);
  context.closePath();
}

// Collects the pieces of each shade, so that a shade is filled at once.
function paintGear(context, { gear, quantity, most, place, magnification }) {
  const pixels = placesOf(gear, magnification).map(place);
  const shades = Array.from({ length: SHADES }, () => []);
  for (const quad of gear.quads) {
    const corners = quarters(quad.map((node) => pixels[node]));
    quarters(quad.map((node) => gear[quantity][node])).forEach((values, i) => {
      const mean = values.reduce((sum, value) => sum + value, 0) / 4;
      shades[Math.max(0, Math.min(SHADES - 1, Math.floor((mean / most) * SHADES)))].push(corners[i]);
    });
  }
  shades.forEach((pieces, shade) => {
    context.fillStyle = context.strokeStyle = heatCss((shade + 0.5) / SHADES);
    context.lineWidth = 0.6; // closes the hairlines between neighbours
    context.beginPath();
    for (const piece of pieces) tracePolygon(context, piece);
    context.fill();
    context.stroke();
  });
  return pixels;
}

function paintMesh(context, gear, pixels) {
  context.strokeStyle = "rgb(255 255 255 / 28%)";
  context.lineWidth = 0.5;
  context.beginPath();
  for (const quad of gear.quads) tracePolygon(context, quad.map((node) => pixels[node]));
  context.stroke();
}

// Round values up to `most`, about five.
function ticksOf(most) {
  const power = 10 ** Math.floor(Math.log10(most / 4 || 1));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => most / one <= 6);
  return Array.from({ length: Math.floor(most / step) + 1 }, (_, i) => i * step);
}

function paintScale(context, { most, width, name, colours }) {
  const [left, top, height] = [width - BAR + 14, 18, HEIGHT - 36];
  for (let shade = 0; shade < SHADES; shade++) {
    context.fillStyle = heatCss((shade + 0.5) / SHADES);
    context.fillRect(left, top + height * (1 - (shade + 1) / SHADES), 11, height / SHADES + 0.5);
  }
  context.fillStyle = colours.ink;
  context.font = "11px system-ui, sans-serif";
  for (const value of ticksOf(most)) context.fillText(String(value), left + 16, top + height * (1 - value / most) + 4);
  context.save();
  context.translate(width - 3, HEIGHT / 2);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.fillText(`${name}, MPa`, 0, 0);
  context.restore();
}

// Paints the field with its scale into width times HEIGHT pixels; answers what can be read: [{at, value, name}] of all nodes.
function paintField(context, width, { field, quantity, magnification, hasMesh, colours }) {
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, width, HEIGHT);
  const most = scaleEnd(field, quantity);
  const place = projection(field, width);
  const nodes = GEARS.flatMap((name) => {
    const pixels = paintGear(context, { gear: field[name], quantity, most, place, magnification });
    if (hasMesh) paintMesh(context, field[name], pixels);
    return pixels.map((at, i) => ({ at, value: field[name][quantity][i], name }));
  });
  context.fillStyle = colours.ground;
  context.fillRect(width - BAR, 0, BAR, HEIGHT);
  paintScale(context, { most, width, name: QUANTITIES[quantity].name, colours });
  return nodes;
}

function paint(canvas, view) {
  const width = canvas.clientWidth;
  const ratio = devicePixelRatio || 1;
  canvas.width = width * ratio;
  canvas.height = HEIGHT * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  return paintField(context, width, view);
}

// The field as a PNG Blob, in light colours, with a title and what it shows in words above.
function fieldPng(name, view) {
  const colours = palette("light");
  const { field, quantity, magnification } = view;
  const state = `${fixed(field.torque_nm, 1)} N m, mesh position ${fixed(field.mesh_position, 3)} mesh periods`;
  return canvasPng(PICTURE, (context) => {
    const painter = canvasPainter(context);
    painter.path((path) => path.rect(0, 0, PICTURE.width, PICTURE.height), { fill: colours.ground });
    painter.text(14, 20, `Stress in the teeth at ${state}; ${name}`, { fill: colours.ink, size: 13, weight: 600 });
    describe(field, quantity, magnification).forEach((line, i) => painter.text(14, 38 + 16 * i, line, { fill: colours.faint }));
    painter.clip(0, PICTURE.top, PICTURE.width, HEIGHT, () => {
      context.translate(0, PICTURE.top);
      paintField(context, PICTURE.width, { ...view, colours });
    });
  });
}

// What is shown, in two lines of words.
function describe(field, quantity, magnification) {
  const [pinion, gear] = largest(field, quantity);
  const displaced = magnification ? `displacements ${magnification} times their size` : "undeformed";
  return [
    `${QUANTITIES[quantity].name}: at most ${fixed(pinion)} MPa in the pinion, ${fixed(gear)} MPa in the gear`,
    `the colours end at ${fixed(scaleEnd(field, quantity))} MPa; ${displaced}`,
  ];
}

// The value of the node nearest to the pointer, when one is near.
function readAt(nodes, [x, y]) {
  let best = null;
  let least = 20 ** 2;
  for (const node of nodes) {
    const distance = (node.at[0] - x) ** 2 + (node.at[1] - y) ** 2;
    if (distance < least) [best, least] = [node, distance];
  }
  return best;
}

// field: schema/field.schema.json; quantity: a key of QUANTITIES; magnification of the displacements; name: what downloaded files
// are called after.
export function StressField({ field, quantity = "von_mises_mpa", magnification = 50, hasMesh = false, name }) {
  const canvas = useRef(null);
  const nodes = useRef([]);
  const [reading, setReading] = useState(null);
  const [width, setWidth] = useState(0);
  const scheme = useStore(theme);
  const colours = useMemo(() => palette(scheme), [scheme]);
  useEffect(() => {
    const watch = new ResizeObserver(() => setWidth(canvas.current?.clientWidth || 0));
    watch.observe(canvas.current);
    return () => watch.disconnect();
  }, []);
  useEffect(() => {
    if (canvas.current.clientWidth > BAR)
      nodes.current = paint(canvas.current, { field, quantity, magnification, hasMesh, colours });
  }, [field, quantity, magnification, hasMesh, colours, width]);
  const point = (event) => {
    const box = canvas.current.getBoundingClientRect();
    setReading(readAt(nodes.current, [event.clientX - box.left, event.clientY - box.top]));
  };
  const words = describe(field, quantity, magnification).join("; ");
  const savePng = () =>
    fieldPng(name, { field, quantity, magnification, hasMesh }).then(
      (blob) => download(`${fileName(name, "stress", QUANTITIES[quantity].short)}.png`, blob),
      complain,
    );
  return (
    <div class="drawing stress">
      <FileMenu title="Stress in the teeth" files={[["PNG", savePng]]} />
      <canvas
        ref={canvas}
        role="img"
        aria-label={`Stress in the engaged teeth. ${words}.`}
        data-largest={Math.max(...largest(field, quantity))}
        onPointerMove={point}
        onPointerLeave={() => setReading(null)}
      />
      <p class="drawing-note" aria-live="off">
        {reading ? `${reading.name}: ${fixed(reading.value)} MPa` : `${words}.`}
      </p>
    </div>
  );
}
