// Numbers, units and times as text. Units follow from the names in the documents: "amplitude_mm" is in mm.

const UNITS = [
  ["_n_per_mm", "N/mm"],
  ["_kg_per_m3", "kg/m³"],
  ["_kg_mm2", "kg mm²"],
  ["_percent", "%"],
  ["_mpa", "MPa"],
  ["_deg", "°"],
  ["_rpm", "rpm"],
  ["_kg", "kg"],
  ["_mm", "mm"],
  ["_um", "µm"],
  ["_nm", "N m"],
  ["_hz", "Hz"],
  ["_n", "N"],
  ["_s", "s"],
];

// What the end of a name says: {text: "tip amplitude", unit: "mm"}; unit "" when it says nothing.
export function nameAndUnit(key) {
  const [, name, index] = /^(.*?)(?:\.(\d+))?$/.exec(key); // "start_radius_mm.1": a list's second
  const found = UNITS.find(([ending]) => name.endsWith(ending));
  const bare = found ? name.slice(0, -found[0].length) : name;
  const place = index === undefined ? "" : `, no. ${Number(index) + 1}`;
  return { text: bare.replaceAll(".", " ").replaceAll("_", " ") + place, unit: found ? found[1] : "" };
}

// A label with its unit: "pinion tip amplitude, mm".
export function labelOf(key) {
  const { text, unit } = nameAndUnit(key);
  return unit ? `${text}, ${unit}` : text;
}

// What an objective is called and measured in; field: its name in evaluations and designs.
export const OBJECTIVES = {
  f_dte: { name: "F_DTE", field: "f_dte", unit: "b", long: "largest RMS of the dynamic transmission error", digits: 4 },
  f_pps: {
    name: "F_PPS",
    field: "f_pps_um",
    unit: "µm",
    long: "largest peak to peak of the static transmission error",
    digits: 2,
  },
  f_dte_percentile: {
    name: "F_DTE, percentile",
    field: "f_dte_percentile",
    unit: "b",
    long: "percentile of F_DTE under manufacturing errors",
    digits: 4,
  },
};

const groups = new Map();

// A number with `digits` decimals, thin spaces between thousands; "–" for none.
export function fixed(value, digits = 0) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!groups.has(digits)) {
    groups.set(
      digits,
      new Intl.NumberFormat("en", {
        minimumFractionDigits: digits,
        maximumFractionDigits: digits,
        useGrouping: "min2",
      }),
    );
  }
  return groups.get(digits).format(value).replaceAll(",", "\u202f").replace("-", "\u2212");
}

// A number with `digits` significant figures, without an exponent where it can be read.
export function significant(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size < -4 || size > 6) return value.toExponential(digits - 1).replace("-", "\u2212");
  return fixed(value, Math.max(0, Math.min(12, digits - 1 - size)));
}

// A number as it was given, without zeros at its end and without the noise of its last bits.
export function plain(value) {
  if (typeof value !== "number") return "–";
  const [, fraction = ""] = String(Number(value.toPrecision(9))).split(".");
  return /e/.test(fraction) ? significant(value, 6) : fixed(value, Math.min(12, fraction.length));
}

export function percent(share, digits = 0) {
  return share === null || share === undefined ? "–" : `${fixed(share * 100, digits)}\u202f%`;
}

// Seconds as people say them.
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  if (seconds < 10) return `${fixed(seconds, 1)} s`;
  if (seconds < 90) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  if (seconds < 129600) return `${fixed(seconds / 3600, 1)} h`;
  return `${Math.round(seconds / 86400)} d`;
}

export function age(time, now) {
  return time ? `${duration(Math.max(0, Math.round((now - Date.parse(time)) / 1000)))} ago` : "–";
}

// A value of an objective with its name and unit.
export function objectiveText(objective, value) {
  const { name, unit, digits } = OBJECTIVES[objective];
  return `${name} ${fixed(value, digits)} ${unit}`;
}

// How long a job ran, or has been running; null when it never did.
export function runningTime(job, now) {
  if (!job.started_at) return null;
  return ((job.finished_at ? Date.parse(job.finished_at) : now) - Date.parse(job.started_at)) / 1000;
}

// A time in the reader's zone.
export function localTime(time) {
  if (!time) return "–";
  return new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" }).format(new Date(time));
}

export function jobTitle(job) {
  return job.name || job.id;
}
