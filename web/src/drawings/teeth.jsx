// The teeth of both gears in mesh, at true scale, from the server's profile data: the pinion below, the gear above. The position
// in the mesh is moved by a slider or runs by itself; contact points move along the path of contact.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { fixed } from "../format.js";
import { complain } from "../parts/parts.jsx";
import { FileMenu } from "../plots/menu.jsx";
import { download, fileName, svgPng, svgText } from "../plots/picture.js";
import { drawingSvg } from "./take-away.js";

// The server's frame has the pinion's axis at the origin and the gear's to the right, y up. On the screen the pinion is below:
// (x, y) goes to (-y, -x).
const UPRIGHT = "matrix(0 -1 -1 0 0 0)";
const PERIOD_MS = 3000;
const PICTURE_WIDTH = 800; // px
const KEYS = [
  { name: "path of contact", selector: ".contact-path" },
  { name: "line of action", selector: ".action" },
  { name: "pitch circles", selector: ".construction .pitch" },
  { name: "base circles", selector: ".construction .base" },
];

const number = (value) => value.toFixed(4);

// The outline of a whole gear and its bore as one path, the first tooth's centre line along the x axis.
export function gearPath({ teeth, bore_radius_mm: bore, outline }) {
  const points = [];
  for (let k = 0; k < teeth; k++) {
    const [c, s] = [Math.cos((-2 * Math.PI * k) / teeth), Math.sin((-2 * Math.PI * k) / teeth)];
    for (let i = 0; i < outline.x_mm.length - 1; i++) {
      const [x, y] = [outline.x_mm[i], outline.y_mm[i]];
      points.push(`${number(c * x - s * y)},${number(s * x + c * y)}`);
    }
  }
  const circle = `M${bore},0A${bore},${bore} 0 1 0 ${-bore},0A${bore},${bore} 0 1 0 ${bore},0Z`;
  return `M${points.join("L")}Z${circle}`;
}

// The part of the plane that is shown: around the path of contact, as high as the teeth need and a few teeth wide.
function windowOf(profile) {
  const { line_of_action: line, pinion, gear, center_distance_mm: distance } = profile;
  const pitch = (2 * Math.PI * pinion.reference_radius_mm) / pinion.teeth;
  const depth = Math.max(pinion.outside_radius_mm - pinion.root_radius_mm, gear.outside_radius_mm - gear.root_radius_mm);
  const low = Math.min(pinion.root_radius_mm, distance - gear.outside_radius_mm) - 0.45 * depth;
  const high = Math.max(pinion.outside_radius_mm, distance - gear.root_radius_mm) + 0.45 * depth;
  const height = high - low;
  const width = Math.max(1.7 * height, 3.6 * pitch);
  const [, middle] = line.pitch_point_mm;
  return { left: -middle - width / 2, top: -high, width, height, low, pitch };
}

const useMotion = (isRunning, frames, setFrame) =>
  useEffect(() => {
    if (!isRunning) return undefined;
    const start = performance.now();
    let first = null;
    let request = 0;
    const step = (now) => {
      setFrame((frame) => {
        first ??= frame;
        return (first + Math.round(((now - start) / PERIOD_MS) * (frames - 1))) % (frames - 1);
      });
      request = requestAnimationFrame(step);
    };
    request = requestAnimationFrame(step);
    return () => cancelAnimationFrame(request);
  }, [isRunning, frames]);

function Circles({ gear, x }) {
  return (
    <g class="construction">
      <circle cx={x} cy="0" r={gear.base_radius_mm} class="base" />
      <circle cx={x} cy="0" r={gear.pitch_radius_mm} class="pitch" />
    </g>
  );
}

function Gear({ name, gear, x, angle, path }) {
  return (
    <path class={`tooth ${name}`} d={path} transform={`translate(${x} 0) rotate(${angle})`} fill-rule="evenodd">
      <title>{`${name}, ${gear.teeth} teeth`}</title>
    </path>
  );
}

const segment = ([x1, y1], [x2, y2]) => ({ x1, y1, x2, y2 });

function Contact({ profile, frame, unit }) {
  const line = profile.line_of_action;
  return (
    <g>
      <line class="action" {...segment(line.pinion_tangent_mm, line.gear_tangent_mm)} />
      <line class="contact-path" {...segment(line.path_start_mm, line.path_end_mm)} />
      <circle class="pitch-point" cx={line.pitch_point_mm[0]} cy={line.pitch_point_mm[1]} r={0.45 * unit} />
      {profile.mesh.contacts[frame].map(({ pair, at_mm: [x, y] }) => (
        <circle key={pair} class="touch" data-pair={pair} cx={x} cy={y} r={1.25 * unit} />
      ))}
    </g>
  );
}

// A length that reads well, about a fifth of the width.
function scaleLength(width) {
  const rough = width / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  return [5, 2, 1].map((step) => step * power).find((length) => length <= rough);
}

function ScaleBar({ view, unit }) {
  const length = scaleLength(view.width);
  const [x, y] = [view.left + 2.5 * unit, view.top + view.height - 2.5 * unit];
  return (
    <g class="scale-bar">
      <path d={`M${x},${y - unit / 2}V${y}H${x + length}V${y - unit / 2}`} />
      <text x={x + length / 2} y={y - unit} font-size={2.6 * unit} text-anchor="middle">
        {length} mm
      </text>
    </g>
  );
}

function Names({ view, unit, profile }) {
  const x = view.left + 2 * unit;
  const of = (name, gear) => `${name}, ${gear.teeth} teeth`;
  return (
    <g class="names">
      <text x={x} y={view.top + 4 * unit} font-size={2.8 * unit}>
        {of("Gear", profile.gear)}
      </text>
      <text x={view.left + view.width - 2 * unit} y={view.top + view.height - 2.5 * unit} font-size={2.8 * unit} text-anchor="end">
        {of("Pinion", profile.pinion)}
      </text>
    </g>
  );
}

function describe(profile, frame) {
  const touching = profile.mesh.contacts[frame];
  const where = touching
    .map((touch) => `${fixed(touch.pinion_roll_length_mm, 2)} mm on the pinion, ${fixed(touch.gear_roll_length_mm, 2)} mm on the gear`)
    .join("; ");
  return `${touching.length} ${touching.length === 1 ? "pair" : "pairs"} of teeth in contact, at roll lengths ${where}`;
}

function Files({ name, profile, position, drawing, isOld }) {
  const title = "Teeth in mesh";
  const file = (ending) => `${fileName(name, title.toLowerCase())}.${ending}`;
  const picture = () =>
    drawingSvg({
      title: `${title}, ${name}`,
      note: `mesh position ${fixed(position, 3)} mesh periods, center distance ${fixed(profile.center_distance_mm, 3)} mm`,
      parts: [{ svg: drawing.current }],
      partWidth: PICTURE_WIDTH,
      keys: KEYS,
    });
  const files = [
    ["SVG", () => download(file("svg"), svgText(picture()), "image/svg+xml")],
    ["PNG", () => svgPng(picture()).then((blob) => download(file("png"), blob), complain)],
  ];
  return <FileMenu title={title} files={files} isOff={isOld} />;
}

// profile: the answer of POST /v1/profile. onPosition(position) hears of the slider; isOld: the numbers have moved on without it;
// name: what downloaded files are called after.
export function TeethDrawing({ profile, isOld = false, onPosition, name }) {
  const drawing = useRef(null);
  const frames = profile.mesh.position.length;
  const [frame, setFrame] = useState(Math.floor(frames / 2));
  const [isRunning, setRunning] = useState(false);
  const paths = useMemo(() => ({ pinion: gearPath(profile.pinion), gear: gearPath(profile.gear) }), [profile]);
  const view = windowOf(profile);
  const unit = view.height / 75;
  const position = profile.mesh.position[frame];
  useMotion(isRunning, frames, setFrame);
  useEffect(() => onPosition?.(position), [position]);
  const distance = profile.center_distance_mm;
  return (
    <div class={`drawing teeth ${isOld ? "old" : ""}`}>
      <Files name={name} profile={profile} position={position} drawing={drawing} isOld={isOld} />
      <svg
        ref={drawing}
        viewBox={`${view.left} ${view.top} ${view.width} ${view.height}`}
        role="img"
        aria-label={`Teeth in mesh at true scale. ${describe(profile, frame)}.`}
        data-position={position}
      >
        <g transform={UPRIGHT}>
          <Gear name="pinion" gear={profile.pinion} x={0} angle={profile.mesh.pinion_angle_deg[frame]} path={paths.pinion} />
          <Gear name="gear" gear={profile.gear} x={distance} angle={profile.mesh.gear_angle_deg[frame]} path={paths.gear} />
          <Circles gear={profile.pinion} x={0} />
          <Circles gear={profile.gear} x={distance} />
          <Contact profile={profile} frame={frame} unit={unit} />
        </g>
        <Names view={view} unit={unit} profile={profile} />
        <ScaleBar view={view} unit={unit} />
      </svg>
      <div class="drawing-controls">
        <button type="button" class="quiet" onClick={() => setRunning(!isRunning)} aria-label={isRunning ? "Stop" : "Turn the gears"}>
          {isRunning ? "❚❚" : "▶"}
        </button>
        <input
          type="range"
          min="0"
          max={frames - 1}
          value={frame}
          aria-label="Mesh position"
          aria-valuetext={`${fixed(position, 3)} mesh periods`}
          onInput={(event) => {
            setRunning(false);
            setFrame(Number(event.target.value));
          }}
        />
        <output class="number">φ = {fixed(position, 3)}</output>
      </div>
      <p class="drawing-note">{describe(profile, frame)}.</p>
    </div>
  );
}
