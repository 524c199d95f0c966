// Up to six designs of any jobs on shared axes, and what differs between them. The designs stand in the address:
// #/compare?designs=ID:design,ID:reference
import { useEffect, useMemo, useState } from "preact/hooks";
import { getResult } from "../api.js";
import {
  loadShareFigure,
  pressureFigure,
  responseFigure,
  rootStressFigure,
  stiffnessFigure,
  transmissionErrorFigure,
} from "../figures/curves.js";
import { scalesOf } from "../figures/designs.js";
import { fixed, jobTitle, nameAndUnit, plain } from "../format.js";
import { jobs, loadJob } from "../jobs.js";
import { Panel } from "../parts/parts.jsx";
import { ReliefTable } from "../parts/relief-table.jsx";
import { Plot } from "../plots/plot.jsx";
import { download } from "../plots/picture.js";
import { href, replaceQuery } from "../router.js";
import { useStore } from "../store.js";
import { DESIGNS_MOST } from "./jobs.jsx";

// "ID:design,ID:reference" as [{id, which}], at most DESIGNS_MOST, each once.
export function parseDesigns(text) {
  const parts = [...new Set((text || "").split(",").filter(Boolean))].slice(0, DESIGNS_MOST);
  return parts.map((part) => {
    const [id, which] = part.split(":");
    return { id, which: which === "reference" ? "reference" : "design" };
  });
}

const textOf = (wanted) => wanted.map(({ id, which }) => `${id}:${which}`).join(",");

// Results by id, each asked for once.
function useResults(ids) {
  const [results, setResults] = useState(new Map());
  useEffect(() => {
    const abort = new AbortController();
    for (const id of ids.filter((one) => !results.has(one))) {
      const put = (value) => abort.signal.aborted || setResults((old) => new Map(old).set(id, value));
      Promise.all([getResult(id, abort.signal), loadJob(id)]).then(
        ([result]) => put({ result }),
        (problem) => put({ problem }),
      );
    }
    return () => abort.abort();
  }, [ids.join(",")]);
  return results;
}

// Names that tell the designs apart: the job's, and a number where two jobs have the same.
function namesOf(wanted, byId) {
  const titles = wanted.map(({ id }) => (byId.has(id) ? jobTitle(byId.get(id)) : id));
  return wanted.map(({ id, which }, i) => {
    const isTwin = wanted.some((other, k) => other.id !== id && titles[k] === titles[i]);
    const title = titles[i].length > 28 ? `${titles[i].slice(0, 27)}…` : titles[i];
    return `${isTwin ? `${i + 1}. ` : ""}${title}${which === "reference" ? ", reference" : ""}`;
  });
}

function Picker({ wanted, succeeded, onChange }) {
  const toggle = (id, which) => {
    const kept = wanted.filter((one) => one.id !== id || one.which !== which);
    onChange(kept.length < wanted.length ? kept : [...wanted, { id, which }]);
  };
  const isWanted = (id, which) => wanted.some((one) => one.id === id && one.which === which);
  const box = (job, which) => (
    <label>
      <input
        type="checkbox"
        checked={isWanted(job.id, which)}
        disabled={!isWanted(job.id, which) && wanted.length >= DESIGNS_MOST}
        onChange={() => toggle(job.id, which)}
      />
      {which}
    </label>
  );
  return (
    <details class="panel picker" open={wanted.length < 2}>
      <summary>
        Designs to compare: {wanted.length} of at most {DESIGNS_MOST}
      </summary>
      <ul>
        {succeeded.map((job) => (
          <li key={job.id}>
            <span>
              {jobTitle(job)} <small>{job.kind}</small>
            </span>
            <span class="choices" role="group" aria-label={jobTitle(job)}>
              {box(job, "design")}
              {(job.kind === "optimize" || job.kind === "map") && box(job, "reference")}
            </span>
          </li>
        ))}
      </ul>
    </details>
  );
}

// --- the table of differences ---

// Every number and word of a document by its place: "gear_pair.pinion.teeth" → 28.
export function leaves(value, prefix = "") {
  if (value === null || typeof value !== "object") return [[prefix, value]];
  return Object.entries(value).flatMap(([key, inner]) => leaves(inner, prefix ? `${prefix}.${key}` : key));
}

// The places at which the documents differ: [{place, values}]; undefined where a document has none.
export function differences(documents) {
  const maps = documents.map((document) => new Map(leaves(document)));
  const places = [...new Set(maps.flatMap((map) => [...map.keys()]))];
  return places
    .map((place) => ({ place, values: maps.map((map) => map.get(place)) }))
    .filter(({ values }) => values.some((value) => value !== values[0]));
}

const shownValue = (value) =>
  value === undefined || value === null ? "–" : typeof value === "number" ? plain(value) : String(value);

const rootStress = (design, gear) =>
  design.load_cases[0].max_root_stress_mpa
    ? Math.max(...design.load_cases.map((one) => one.max_root_stress_mpa[gear]))
    : null;

function performanceRows(shown) {
  const value = (name, unit, pick, digits) => ({ name, unit, digits, values: shown.map((one) => pick(one)) });
  return [
    value("F_DTE", "b", ({ design }) => design.f_dte, 4),
    value("F_PPS", "µm", ({ design }) => design.f_pps_um, 2),
    value(
      "Contact pressure",
      "MPa",
      ({ design }) => Math.max(...design.load_cases.map((one) => one.max_contact_pressure_mpa)),
      0,
    ),
    value("Root stress of the pinion", "MPa", ({ design }) => rootStress(design, "pinion"), 0),
    value("Root stress of the gear", "MPa", ({ design }) => rootStress(design, "gear"), 0),
    value("Contact ratio", "", ({ result }) => result.geometry.contact_ratio, 3),
    value(
      "Probability of failure",
      "%",
      ({ result, which }) =>
        which === "design" && result.reliability ? 100 * result.reliability.probability_of_failure : null,
      1,
    ),
  ];
}

function Relative({ value, first }) {
  if (value === null || first === null || first === undefined || value === first || first === 0) return null;
  const change = (100 * (value - first)) / Math.abs(first);
  return (
    <small>
      {" "}
      {change > 0 ? "+" : "\u2212"}
      {fixed(Math.abs(change), 1)} %
    </small>
  );
}

const inputsOf = (shown) =>
  differences(shown.map(({ result }) => ({ ...result.job, name: undefined, labels: undefined, relief: undefined })));

function Heads({ first, shown }) {
  return (
    <thead>
      <tr>
        <th scope="col">{first}</th>
        {shown.map(({ key, name }) => (
          <th scope="col" class="number" key={key}>
            {name}
          </th>
        ))}
        <th scope="col">Unit</th>
      </tr>
    </thead>
  );
}

function InputsPanel({ shown }) {
  const inputs = inputsOf(shown);
  if (inputs.length === 0) return null;
  return (
    <Panel title="Inputs that differ" note={String(inputs.length)} wide>
      <div class="scroll">
        <table>
          <caption class="unseen">Inputs that differ between the jobs; the reliefs have a table of their own</caption>
          <Heads first="Input" shown={shown} />
          <tbody>
            {inputs.map(({ place, values }) => (
              <tr key={place}>
                <th scope="row">{nameAndUnit(place).text}</th>
                {values.map((value, i) => (
                  <td class="number" key={i}>
                    {shownValue(value)}
                  </td>
                ))}
                <td class="unit">{nameAndUnit(place).unit}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Panel>
  );
}

function DifferencesTable({ shown }) {
  const csv = () => {
    const quote = (text) => `"${String(text ?? "").replaceAll('"', '""')}"`;
    const rows = [
      ["", "unit", ...shown.map(({ name }) => name)],
      ...performanceRows(shown).map(({ name, unit, values }) => [name, unit, ...values]),
      ...inputsOf(shown).map(({ place, values }) => [place, "", ...values]),
    ];
    download("comparison.csv", `${rows.map((row) => row.map(quote).join(",")).join("\r\n")}\r\n`, "text/csv");
  };
  return (
    <Panel title="Differences" wide>
      <span class="menu">
        <button type="button" class="quiet" onClick={csv} aria-label="Table of differences as CSV">
          CSV
        </button>
      </span>
      <div class="scroll">
        <table>
          <caption class="unseen">Differences; percentages are relative to the first design</caption>
          <Heads first="Quantity" shown={shown} />
          <tbody>
            {performanceRows(shown).map(({ name, unit, values, digits }) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                {values.map((value, i) => (
                  <td class="number" key={i}>
                    {fixed(value, digits)}
                    {i > 0 && <Relative value={value} first={values[0]} />}
                  </td>
                ))}
                <td class="unit">{unit}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Panel>
  );
}

function Plots({ shown }) {
  const [useRpm, setUseRpm] = useState(false);
  const figures = useMemo(
    () =>
      [
        responseFigure(shown, { useRpm }),
        ...[transmissionErrorFigure, stiffnessFigure, loadShareFigure, pressureFigure, rootStressFigure].map((make) =>
          make(shown),
        ),
      ].filter(Boolean),
    [shown, useRpm],
  );
  const controls = (
    <label class="choices">
      <span>
        <input type="checkbox" checked={useRpm} onChange={() => setUseRpm(!useRpm)} /> over pinion speed
      </span>
    </label>
  );
  return figures
    .filter((figure) => figure.series.length > 0)
    .map((figure, i) => (
      <Panel title={figure.title} key={figure.id} wide={i === 0}>
        <Plot
          key={useRpm}
          figure={figure}
          name="comparison"
          height={i === 0 ? 400 : 280}
          controls={i === 0 ? controls : undefined}
        />
      </Panel>
    ));
}

export function Compare({ query }) {
  const text = query.get("designs") || "";
  const wanted = useMemo(() => parseDesigns(text), [text]);
  const byId = useStore(jobs, (known) => known.byId);
  const results = useResults([...new Set(wanted.map(({ id }) => id))]);
  const names = namesOf(wanted, byId).join("\n");
  const shown = useMemo(
    () =>
      wanted.flatMap(({ id, which }, i) => {
        const result = results.get(id)?.result;
        if (!result?.[which]) return [];
        const name = names.split("\n")[i];
        return [
          {
            key: `${id}-${which}`,
            name,
            role: i,
            which,
            result,
            design: result[which],
            ...scalesOf(result, which),
          },
        ];
      }),
    [wanted, results, names],
  );
  const missing = wanted.filter(({ id, which }) => results.has(id) && !results.get(id).result?.[which]);
  const succeeded = [...byId.values()]
    .filter((job) => job.state === "succeeded")
    .sort((a, b) => (a.submitted_at < b.submitted_at ? 1 : -1));
  return (
    <>
      <div class="headline">
        <h1>Compare</h1>
        <span class="spread" />
        <a class="button" href={href("jobs")}>
          Choose among the jobs
        </a>
      </div>
      <Picker wanted={wanted} succeeded={succeeded} onChange={(next) => replaceQuery({ designs: textOf(next) })} />
      {missing.map(({ id, which }) => (
        <p class="bad" key={`${id}${which}`}>
          {byId.has(id) ? jobTitle(byId.get(id)) : id}: {results.get(id).problem?.message || `it has no ${which}`}
        </p>
      ))}
      {shown.length > 0 && (
        <div class="panels">
          <DifferencesTable shown={shown} />
          <Plots shown={shown} />
          <Panel title="Reliefs" wide>
            <ReliefTable designs={shown} />
          </Panel>
          <InputsPanel shown={shown} />
        </div>
      )}
    </>
  );
}
