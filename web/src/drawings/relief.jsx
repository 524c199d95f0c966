// The profile diagram of both gears: what is removed from the involute, in micrometres, over the roll length, material downwards,
// with the marks that gear people look for. Every design that a search may find lies within the shaded band.
import { scaleLinear } from "d3-scale";
import { line as shapeLine } from "d3-shape";
import { useRef, useState } from "preact/hooks";
import { fixed } from "../format.js";
import { FileMenu } from "../plots/menu.jsx";
import { download, fileName, svgPng, svgText } from "../plots/picture.js";
import { figureCsv } from "../plots/read.js";
import { complain } from "../parts/parts.jsx";
import { drawingSvg } from "./take-away.js";

const SIZE = { width: 440, height: 248, left: 46, right: 12, top: 46, bottom: 38 };
const MARKS = [
  ["form", "form", "form radius"],
  ["start_of_active_profile", "SAP", "start of active profile"],
  ["pitch_point", "P", "pitch point"],
  ["end_of_active_profile", "EAP", "end of active profile, the tip"],
];
// Between these one pair of teeth is alone; none at contact ratios of 2 and more. Each stands on its side of the zone.
const SINGLE_MARKS = [
  ["lowest_single_contact", "LPSTC", "lowest point of single tooth contact", "end"],
  ["highest_single_contact", "HPSTC", "highest point of single tooth contact", "start"],
];
const LEAST_DEPTH_UM = 5;

function scalesOf(gears, gear) {
  const deepest = Math.max(
    LEAST_DEPTH_UM,
    ...gears.flatMap((one) => [one.diagram.design, one.diagram.most]).flatMap((curve) => (curve ? curve.removed_um : [])),
  );
  const rolls = gear.diagram.design.roll_length_mm;
  return {
    x: scaleLinear([rolls[0], rolls.at(-1)], [SIZE.left, SIZE.width - SIZE.right]),
    y: scaleLinear([-0.06 * deepest, 1.06 * deepest], [SIZE.top, SIZE.height - SIZE.bottom]),
  };
}

const pointsOf = ({ roll_length_mm: roll, removed_um: removed }) => roll.map((x, i) => [x, removed[i]]);

function drawn({ x, y }, points, closed = "") {
  return shapeLine(
    ([roll]) => x(roll),
    ([, removed]) => y(removed),
  )(points) + closed;
}

function Band({ scales, least, most }) {
  if (!least || !most) return null;
  return <path class="band" d={drawn(scales, [...pointsOf(least), ...pointsOf(most).reverse()], "Z")} />;
}

function Axes({ scales: { x, y } }) {
  const bottom = SIZE.height - SIZE.bottom;
  return (
    <g class="axes">
      {x.ticks(6).map((value) => (
        <g key={value}>
          <line x1={x(value)} x2={x(value)} y1={bottom} y2={bottom + 4} />
          <text x={x(value)} y={bottom + 15} text-anchor="middle">
            {value}
          </text>
        </g>
      ))}
      {y.ticks(5).map((value) => (
        <g key={value}>
          <line class={value === 0 ? "zero" : "grid"} x1={SIZE.left} x2={SIZE.width - SIZE.right} y1={y(value)} y2={y(value)} />
          <text x={SIZE.left - 6} y={y(value) + 4} text-anchor="end">
            {value}
          </text>
        </g>
      ))}
      <path d={`M${SIZE.left},${SIZE.top}V${bottom}H${SIZE.width - SIZE.right}`} />
      <text x={(SIZE.left + SIZE.width - SIZE.right) / 2} y={SIZE.height - 6} text-anchor="middle" class="label">
        roll length, mm
      </text>
      <text transform={`translate(12 ${(SIZE.top + bottom) / 2}) rotate(-90)`} text-anchor="middle" class="label">
        removed, µm
      </text>
    </g>
  );
}

const markTitle = (long, { roll_length_mm: roll, radius_mm: radius, roll_angle_deg: angle }) =>
  `${long}: roll length ${fixed(roll, 3)} mm, roll angle ${fixed(angle, 2)}°, radius ${fixed(radius, 3)} mm`;

function Marks({ gear, x }) {
  return (
    <g class="marks">
      {SINGLE_MARKS.filter(([key]) => gear.marks[key]).map(([key, short, long, anchor]) => {
        const at = x(gear.marks[key].roll_length_mm);
        return (
          <g key={key} class={`mark ${key}`}>
            <title>{markTitle(long, gear.marks[key])}</title>
            <line x1={at} x2={at} y1={SIZE.top - 4} y2={SIZE.height - SIZE.bottom} />
            <text x={at} y={SIZE.top - 7} text-anchor={anchor}>
              {short}
            </text>
          </g>
        );
      })}
      {MARKS.map(([key, short, long], i) => {
        const at = x(gear.marks[key].roll_length_mm);
        // neighbours that would overlap are set on both sides of their lines
        const next = MARKS[i + 1] && x(gear.marks[MARKS[i + 1][0]].roll_length_mm) - at < 34;
        const anchor = next || i === MARKS.length - 1 ? "end" : i > 0 && at - x(gear.marks[MARKS[i - 1][0]].roll_length_mm) < 34 ? "start" : "middle";
        return (
          <g key={key} class={`mark ${key}`}>
            <title>{markTitle(long, gear.marks[key])}</title>
            <line x1={at} x2={at} y1={SIZE.top - 16} y2={SIZE.height - SIZE.bottom} />
            <text x={at} y={SIZE.top - 20} text-anchor={anchor}>
              {short}
            </text>
          </g>
        );
      })}
    </g>
  );
}

// The value of a curve at a roll length.
function valueAt({ roll_length_mm: rolls, removed_um: removed }, roll) {
  const i = Math.max(1, rolls.findIndex((one) => one >= roll));
  const share = (roll - rolls[i - 1]) / (rolls[i] - rolls[i - 1] || 1);
  return removed[i - 1] + share * (removed[i] - removed[i - 1]);
}

function Cursor({ gear, scales: { x, y }, roll }) {
  const value = valueAt(gear.diagram.design, roll);
  const radius = Math.hypot(gear.base_radius_mm, roll);
  const [at, isRight] = [x(roll), x(roll) > SIZE.width / 2];
  return (
    <g class="cursor">
      <line x1={at} x2={at} y1={SIZE.top} y2={SIZE.height - SIZE.bottom} />
      <circle cx={at} cy={y(value)} r="3.5" />
      <text x={at + (isRight ? -7 : 7)} y={SIZE.height - SIZE.bottom - 8} text-anchor={isRight ? "end" : "start"}>
        {`${fixed(value, 2)} µm at ${fixed(roll, 2)} mm, radius ${fixed(radius, 2)} mm`}
      </text>
    </g>
  );
}

function summary(name, gear, hasReference) {
  const { roll_length_mm: roll, removed_um: removed } = gear.diagram.design;
  const first = removed.findLastIndex((value) => value === 0);
  const tip = removed.at(-1);
  const start = first >= 0 && first < roll.length - 1 ? `, from roll length ${fixed(roll[first], 2)} mm on` : "";
  return `Profile diagram of the ${name}: ${fixed(tip, 1)} µm removed at the tip${start}; ${fixed(removed[0], 1)} µm at the form radius.${
    hasReference ? " The reference is dashed." : ""
  }`;
}

function Diagram({ name, gears, gear, reference }) {
  const [roll, setRoll] = useState(null);
  const scales = scalesOf(gears, gear);
  const point = (event) => {
    const box = event.currentTarget.getBoundingClientRect();
    const at = scales.x.invert(((event.clientX - box.left) / box.width) * SIZE.width);
    const [low, high] = scales.x.domain();
    setRoll(at >= low && at <= high ? at : null);
  };
  return (
    <figure class="relief-diagram">
      <figcaption>{name === "pinion" ? "Pinion" : "Gear"}</figcaption>
      <svg
        viewBox={`0 0 ${SIZE.width} ${SIZE.height}`}
        role="img"
        aria-label={summary(name, gear, Boolean(reference))}
        data-tip-um={gear.diagram.design.removed_um.at(-1)}
        onPointerMove={point}
        onPointerLeave={() => setRoll(null)}
      >
        <Band scales={scales} least={gear.diagram.least} most={gear.diagram.most} />
        <Axes scales={scales} />
        <Marks gear={gear} x={scales.x} />
        {reference && <path class="curve reference" d={drawn(scales, pointsOf(reference.diagram.design))} />}
        <path class="curve design" d={drawn(scales, pointsOf(gear.diagram.design))} />
        {roll !== null && <Cursor gear={gear} scales={scales} roll={roll} />}
      </svg>
    </figure>
  );
}

const legendOf = (reference, hasBand) => [
  { name: reference ? "design" : "relief", kind: "design", selector: ".curve.design" },
  ...(reference ? [{ name: "reference", kind: "reference", selector: ".curve.reference" }] : []),
  ...(hasBand ? [{ name: "what the bounds allow", kind: "band", selector: ".band", isArea: true }] : []),
];

const isSame = (a, b) => a.length === b.length && a.every((value, i) => value === b[i]);

// The curves as the data of a figure, for CSV; those of a gear that have the same roll lengths share them.
export function reliefFigure(profile, reference) {
  const series = ["pinion", "gear"].flatMap((name) => {
    const { design, least, most } = profile[name].diagram;
    const other = reference?.[name].diagram.design;
    return [
      [reference ? "design" : "relief", design],
      ["reference", other],
      ["least that the bounds allow", least],
      ["most that the bounds allow", most],
    ]
      .filter(([, curve]) => curve)
      .map(([what, { roll_length_mm: roll, removed_um: removed }]) => ({
        key: `${name}-${what}`,
        name: `${name} ${what}`,
        x: isSame(roll, design.roll_length_mm) ? design.roll_length_mm : roll,
        y: removed,
      }));
  });
  return { x: { label: "roll length", unit: "mm" }, y: { label: "removed", unit: "µm" }, series };
}

function Files({ name, profile, reference, keys, holder, isOld }) {
  const title = "Profile diagram";
  const file = (ending) => `${fileName(name, title.toLowerCase())}.${ending}`;
  const picture = () => {
    const [pinion, gear] = holder.current.querySelectorAll("svg");
    const parts = [
      { svg: pinion, caption: "Pinion" },
      { svg: gear, caption: "Gear" },
    ];
    return drawingSvg({ title: `${title}, ${name}`, parts, partWidth: SIZE.width, keys });
  };
  const files = [
    ["CSV", () => download(file("csv"), figureCsv(reliefFigure(profile, reference)), "text/csv")],
    ["SVG", () => download(file("svg"), svgText(picture()), "image/svg+xml")],
    ["PNG", () => svgPng(picture()).then((blob) => download(file("png"), blob), complain)],
  ];
  return <FileMenu title={title} files={files} isOff={isOld} />;
}

// profile: of the design; reference: profile data to compare with, or null. Both gears have one scale of micrometres. name: what
// downloaded files are called after; without it, as on paper, nothing can be taken away.
export function ReliefDrawing({ profile, reference = null, isOld = false, name }) {
  const holder = useRef(null);
  const gears = [profile.pinion, profile.gear, ...(reference ? [reference.pinion, reference.gear] : [])];
  const keys = legendOf(reference, Boolean(profile.pinion.diagram.most));
  return (
    <div class={`drawing relief ${isOld ? "old" : ""}`} ref={holder}>
      {name && <Files name={name} profile={profile} reference={reference} keys={keys} holder={holder} isOld={isOld} />}
      <div class="diagrams">
        <Diagram name="pinion" gears={gears} gear={profile.pinion} reference={reference?.pinion} />
        <Diagram name="gear" gears={gears} gear={profile.gear} reference={reference?.gear} />
      </div>
      <p class="drawing-legend" aria-hidden="true">
        {keys.map((key) => (
          <span key={key.kind} class={`drawing-key ${key.kind}`}>
            {key.name}
          </span>
        ))}
      </p>
    </div>
  );
}
