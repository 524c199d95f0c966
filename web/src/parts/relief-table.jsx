// Reliefs as a table: every number of the designs side by side.
import { fixed } from "../format.js";

const ROWS = [
  ["pinion", "tip", "start_radius_mm", "Pinion tip: start radius", 1, 3, "mm"],
  ["pinion", "tip", "amplitude_mm", "Pinion tip: amplitude", 1000, 2, "µm"],
  ["pinion", "root", "end_radius_mm", "Pinion root: end radius", 1, 3, "mm"],
  ["pinion", "root", "amplitude_mm", "Pinion root: amplitude", 1000, 2, "µm"],
  ["gear", "tip", "start_radius_mm", "Gear tip: start radius", 1, 3, "mm"],
  ["gear", "tip", "amplitude_mm", "Gear tip: amplitude", 1000, 2, "µm"],
  ["gear", "root", "end_radius_mm", "Gear root: end radius", 1, 3, "mm"],
  ["gear", "root", "amplitude_mm", "Gear root: amplitude", 1000, 2, "µm"],
];

// The number of a relief, by the first three of a row; null when it is absent.
const numberOf = (relief, [gear, place, key]) => relief?.[gear]?.[place]?.[key] ?? null;

// designs: [{key, name, design: {relief}}]
export function ReliefTable({ designs, caption = "Reliefs" }) {
  const rows = ROWS.filter((row) => designs.some(({ design }) => numberOf(design.relief, row) !== null));
  const shapes = designs.map(
    ({ design }) => `${design.relief?.shape || "linear"} over ${(design.relief?.ramp || "radius").replace("_", " ")}`,
  );
  if (rows.length === 0) return <p class="empty">Pure involutes: no relief.</p>;
  return (
    <table class="plain">
      <caption class="unseen">{caption}</caption>
      <thead>
        <tr>
          <th scope="col">Relief</th>
          {designs.map(({ key, name }) => (
            <th scope="col" class="number" key={key}>
              {name}
            </th>
          ))}
          <th scope="col">
            <span class="unseen">Unit</span>
          </th>
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row[3]}>
            <th scope="row">{row[3]}</th>
            {designs.map(({ key, design }) => {
              const value = numberOf(design.relief, row);
              return (
                <td class="number" key={key}>
                  {value === null ? "–" : fixed(value * row[4], row[5])}
                </td>
              );
            })}
            <td class="unit">{row[6]}</td>
          </tr>
        ))}
        <tr>
          <th scope="row">Ramp</th>
          {shapes.map((shape, i) => (
            <td class="number" key={designs[i].key}>
              {shape}
            </td>
          ))}
          <td />
        </tr>
      </tbody>
    </table>
  );
}
