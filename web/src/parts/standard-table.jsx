// Stresses by finite elements beside those of ISO 6336, which knows no reliefs.
import { fixed } from "../format.js";
import { torqueText } from "../figures/curves.js";

// The load case whose torque is that of the standard's figures; undefined when the job has none.
const loadCaseOf = (iso, design) =>
  design.load_cases.find((one) => Math.abs(one.torque_nm - iso.torque_nm) < 1e-6 * iso.torque_nm);

// iso: result.iso6336; design: a design of the same result
export function StandardTable({ iso, design }) {
  const same = loadCaseOf(iso, design);
  const rows = [
    [
      "Contact stress, MPa",
      same?.max_contact_pressure_mpa,
      Math.max(iso.contact_stress_mpa.pinion, iso.contact_stress_mpa.gear),
      0,
    ],
    ["Root stress of the pinion, MPa", same?.max_root_stress_mpa?.pinion, iso.root_stress_mpa.pinion, 0],
    ["Root stress of the gear, MPa", same?.max_root_stress_mpa?.gear, iso.root_stress_mpa.gear, 0],
    ["Mesh stiffness, N/µm", same && same.mean_mesh_stiffness_n_per_mm / 1000, iso.mesh_stiffness_n_per_mm / 1000, 1],
  ];
  return (
    <>
      <table class="plain">
        <caption>At {torqueText(iso.torque_nm)}; ISO 6336:2006, method B, without reliefs, load factors of 1</caption>
        <thead>
          <tr>
            <th scope="col">
              <span class="unseen">Quantity</span>
            </th>
            <th scope="col" class="number">
              Finite elements
            </th>
            <th scope="col" class="number">
              ISO 6336
            </th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([name, ours, theirs, digits]) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td class="number">{fixed(ours, digits)}</td>
              <td class="number">{fixed(theirs, digits)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {iso.outside_of_range?.length > 0 && (
        <p class="table-note">
          Outside of the standard's range: {iso.outside_of_range.map(({ detail }) => detail).join("; ")}.
        </p>
      )}
    </>
  );
}
