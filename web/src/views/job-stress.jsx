// The stresses of a job's design, at a load case and mesh position of one's choice. The server computes a field when it is asked
// for, which takes some seconds; so it is asked for by a button.
import { useEffect, useState } from "preact/hooks";
import { getJobField } from "../api.js";
import { MAGNIFICATIONS, QUANTITIES, StressField } from "../drawings/stress.jsx";
import { fixed, jobTitle } from "../format.js";
import { Panel, complain } from "../parts/parts.jsx";

const POSITIONS = Array.from({ length: 9 }, (_, i) => i / 8);

function Choice({ label, value, options, onChange }) {
  return (
    <label>
      {label}
      <select value={value} onChange={(event) => onChange(event.target.value)}>
        {options.map(([key, text]) => (
          <option key={key} value={key}>
            {text}
          </option>
        ))}
      </select>
    </label>
  );
}

// The field of the last wish, {load_case, position}; while one is computed, isBusy.
function useField(job, wish) {
  const [state, setState] = useState({ field: null, isBusy: false });
  useEffect(() => {
    if (!wish) return undefined;
    const abort = new AbortController();
    setState((old) => ({ ...old, isBusy: true }));
    getJobField(job.id, wish, abort.signal).then(
      (field) => setState({ field, isBusy: false }),
      (problem) => {
        if (abort.signal.aborted) return;
        setState((old) => ({ ...old, isBusy: false }));
        complain(problem);
      },
    );
    return () => abort.abort();
  }, [wish]);
  return state;
}

export function JobStress({ job, loadCases }) {
  const [loadCase, setLoadCase] = useState(String(loadCases.indexOf(Math.max(...loadCases))));
  const [position, setPosition] = useState("0.5");
  const [quantity, setQuantity] = useState("von_mises_mpa");
  const [magnification, setMagnification] = useState("50");
  const [hasMesh, setMesh] = useState(false);
  const [wish, setWish] = useState(null);
  const { field, isBusy } = useField(job, wish);
  return (
    <Panel title="Stress in the teeth" note="finite elements, in colour">
      <div class="filters">
        <Choice label="Torque" value={loadCase} options={loadCases.map((torque, i) => [String(i), `${fixed(torque, 1)} N m`])} onChange={setLoadCase} />
        <Choice label="Mesh position" value={position} options={POSITIONS.map((one) => [String(one), fixed(one, 3)])} onChange={setPosition} />
        <button type="button" disabled={isBusy} onClick={() => setWish({ load_case: loadCase, position })}>
          {isBusy ? "Computing…" : "Compute"}
        </button>
      </div>
      {field && (
        <>
          <div class="filters">
            <Choice label="Show" value={quantity} options={Object.entries(QUANTITIES).map(([key, one]) => [key, one.name])} onChange={setQuantity} />
            <Choice label="Displacements" value={magnification} options={MAGNIFICATIONS.map((one) => [String(one), one ? `× ${one}` : "none"])} onChange={setMagnification} />
            <label>
              <input type="checkbox" checked={hasMesh} onChange={() => setMesh(!hasMesh)} /> elements
            </label>
          </div>
          <StressField field={field} quantity={quantity} magnification={Number(magnification)} hasMesh={hasMesh} name={jobTitle(job)} />
        </>
      )}
    </Panel>
  );
}
