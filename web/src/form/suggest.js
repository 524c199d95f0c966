// Numbers to begin with where the form switches something on: usual proportions, meant to be changed. The server judges them
// like any others.
import { getAt } from "./document.js";

const round = (value, digits = 2) => Number(value.toFixed(digits));

function ramp(name, { module, outside, form }) {
  if (name === "tip") return { start_radius_mm: round(outside - 0.65 * module), amplitude_mm: round(0.005 * module, 4) };
  return { end_radius_mm: round(form + 0.3 * module), amplitude_mm: round(0.003 * module, 4) };
}

function limits(name, key, { module, outside, form }) {
  if (key === "amplitude_mm") return [round(0.001 * module, 4), round(0.012 * module, 4)];
  const low = Math.ceil(form * 100) / 100;
  return name === "tip" ? [low, outside] : [low, round(form + 0.8 * module)];
}

// The figures of the gear that a pointer is about; null when they are not known.
function figures(document, geometry, which) {
  const module = getAt(document, "/gear_pair/module_mm");
  const outside = getAt(document, `/gear_pair/${which}/outside_radius_mm`);
  const form = geometry?.[which]?.form_radius_mm;
  return [module, outside, form].every(Number.isFinite) ? { module, outside, form } : null;
}

// A value for a place of the document that is switched on.
export function suggest(pointer, document, geometry) {
  const [, section, which, name, key] = pointer.split("/");
  const known = figures(document, geometry, which);
  if (section === "relief" && name && known) return ramp(name, known);
  if (section === "relief_bounds" && key && known) return limits(name, key, known);
  if (section === "relief_bounds" && name && known)
    return Object.fromEntries(Object.keys(ramp(name, known)).map((one) => [one, limits(name, one, known)]));
  return key ? [null, null] : {};
}
