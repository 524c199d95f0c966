// One job: how far it is, what came of it, and why. Everything is drawn from the job's result, or, while it runs, from the best
// design so far and the log of evaluations.
import { useEffect, useMemo, useState } from "preact/hooks";
import {
  loadShareFigure,
  pressureFigure,
  responseFigure,
  rootStressFigure,
  stiffnessFigure,
  transmissionErrorFigure,
} from "../figures/curves.js";
import { designsOfResponse, designsOfResult } from "../figures/designs.js";
import {
  chosenOf,
  historyFigure,
  landscapeFigure,
  mapFigure,
  movingParameters,
  objectivesOf,
  paretoFigure,
} from "../figures/search.js";
import { OBJECTIVES, duration, fixed, jobTitle, labelOf, localTime } from "../format.js";
import { useJobData } from "../job-data.js";
import { LongTable, numberColumn as number } from "../parts/long-table.jsx";
import { Panel } from "../parts/parts.jsx";
import { StandardTable } from "../parts/standard-table.jsx";
import { ReliefTable } from "../parts/relief-table.jsx";
import { Plot } from "../plots/plot.jsx";
import { Heading, ProgressStrip } from "./job-head.jsx";
import { KeyFigures } from "./key-figures.jsx";
import { JobDrawings } from "./job-drawings.jsx";
import { JobStress } from "./job-stress.jsx";
import { MacroPanels } from "./macro.jsx";
import { ReliabilityPanel } from "./reliability.jsx";
import { Report } from "./report.jsx";

function ResponsePanel({ designs, name }) {
  const [useRpm, setUseRpm] = useState(false);
  const figure = useMemo(() => responseFigure(designs, { useRpm }), [designs, useRpm]);
  if (figure.series.length === 0) return null;
  const choice = (value, text) => (
    <label>
      <input type="radio" name="response-axis" checked={useRpm === value} onChange={() => setUseRpm(value)} />
      {text}
    </label>
  );
  return (
    <Panel title={figure.title} wide>
      <Plot
        key={useRpm}
        figure={figure}
        name={name}
        height={400}
        controls={
          <span class="choices" role="radiogroup" aria-label="Axis of speed">
            {choice(false, "frequency ratio")}
            {choice(true, "pinion speed")}
          </span>
        }
      />
    </Panel>
  );
}

function CyclePanels({ designs, name }) {
  const figures = useMemo(
    () =>
      [transmissionErrorFigure, stiffnessFigure, loadShareFigure, pressureFigure, rootStressFigure]
        .map((make) => make(designs))
        .filter(Boolean),
    [designs],
  );
  return figures.map((figure) => (
    <Panel title={figure.title} key={figure.id}>
      <Plot figure={figure} name={name} />
    </Panel>
  ));
}

function SearchPanels({ evaluations, objective, name }) {
  const parameters = useMemo(() => movingParameters(evaluations), [evaluations]);
  const [wanted, setWanted] = useState([null, null]);
  const first = wanted[0] || parameters[0];
  const second = wanted[1] || parameters.find((one) => one !== first);
  const history = useMemo(() => historyFigure(evaluations, objective), [evaluations, objective]);
  const landscape = useMemo(
    () => (first && second ? landscapeFigure(evaluations, objective, [first, second]) : null),
    [evaluations, objective, first, second],
  );
  const choose = (place) => (event) =>
    setWanted(place === 0 ? [event.target.value, second] : [first, event.target.value]);
  const choice = (place, current) => (
    <select
      aria-label={place === 0 ? "Horizontal parameter" : "Vertical parameter"}
      value={current}
      onChange={choose(place)}
    >
      {parameters.map((one) => (
        <option key={one} value={one}>
          {labelOf(one)}
        </option>
      ))}
    </select>
  );
  return (
    <>
      <Panel title={history.title}>
        <Plot figure={history} name={name} height={320} />
      </Panel>
      {landscape && (
        <Panel title="Objective landscape">
          <Plot
            key={`${first} ${second}`}
            figure={landscape}
            name={name}
            height={320}
            controls={
              <span class="choices">
                {choice(0, first)} {choice(1, second)}
              </span>
            }
          />
        </Panel>
      )}
    </>
  );
}

function MapPanels({ map, name }) {
  const figures = useMemo(
    () =>
      ["f_dte", "f_pps"]
        .filter((one) => map[one === "f_dte" ? "f_dte" : "f_pps_um"]?.flat().some((value) => value !== null))
        .map((one) => mapFigure(map, one)),
    [map],
  );
  return figures.map((figure) => (
    <Panel title={figure.title} key={figure.id}>
      <Plot figure={figure} name={name} height={380} />
    </Panel>
  ));
}

function candidateColumns(evaluations) {
  const parameters = movingParameters(evaluations);
  return [
    number("evaluation", "No.", (row) => row.evaluation, 0),
    { key: "phase", head: "Phase", value: (row) => row.phase, text: (row) => row.phase },
    number("f_dte", "F_DTE, b", (row) => row.f_dte, 5),
    number("f_pps_um", "F_PPS, µm", (row) => row.f_pps_um, 3),
    ...parameters.map((key) =>
      number(key, labelOf(key), (row) => row.parameters[key] ?? null, key.endsWith("amplitude_mm") ? 5 : 3),
    ),
  ];
}

function CandidatesPanel({ evaluations, objective }) {
  const columns = useMemo(() => candidateColumns(evaluations), [evaluations]);
  if (evaluations.length < 2) return null;
  return (
    <Panel title="Candidates" note={`${fixed(evaluations.length)} tried`} id="candidates-table" wide>
      <LongTable
        caption="Candidates tried"
        columns={columns}
        rows={evaluations}
        rowKey={(row) => row.evaluation}
        first={{ key: objective === "f_pps" ? "f_pps_um" : "f_dte", down: false }}
      />
    </Panel>
  );
}

function WarningsPanel({ warnings }) {
  if (!warnings?.length) return null;
  return (
    <section class="panel wide warnings" aria-label="Warnings">
      <ul>
        {warnings.map((warning) => (
          <li key={warning}>{warning}</li>
        ))}
      </ul>
    </section>
  );
}

function FactsPanel({ job, result, document }) {
  const seed = document?.optimizer?.seed;
  const facts = [
    ["Job", job.id],
    ["Submitted", localTime(job.submitted_at)],
    ["Started", localTime(job.started_at)],
    ["Finished", localTime(job.finished_at)],
    ["Contact ratio", result?.geometry && fixed(result.geometry.contact_ratio, 4)],
    ["Normal backlash", result?.geometry && `${fixed(result.geometry.backlash_mm, 4)} mm`],
    ["Version", result?.version],
    ["Seed", seed],
    ["Seed of the trials", document?.reliability?.seed],
    [
      "Time",
      result?.timing &&
        `${duration(result.timing.wall_s)}, ${result.timing.threads} thread${result.timing.threads === 1 ? "" : "s"}`,
    ],
    ["Finite elements", result?.timing && duration(result.timing.compliance_s)],
    ["Contact", result?.timing && duration(result.timing.static_s)],
    ["Dynamics", result?.timing && duration(result.timing.dynamic_s)],
    [
      "Unknowns of a sector",
      result?.model?.pinion &&
        `${fixed(result.model.pinion.degrees_of_freedom)} and ${fixed(result.model.gear.degrees_of_freedom)}`,
    ],
  ];
  return (
    <Panel title="Run">
      <dl class="facts">
        {facts
          .filter(([, value]) => value !== undefined && value !== null)
          .map(([name, value]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd class="number">{String(value)}</dd>
            </div>
          ))}
      </dl>
      {document && (
        <details>
          <summary>Job document</summary>
          <pre class="document" tabIndex={0} aria-label="Job document">
            {JSON.stringify(document, null, 2)}
          </pre>
        </details>
      )}
    </Panel>
  );
}

function StandardPanel({ result }) {
  const { iso6336, design } = result;
  if (!iso6336 || !design) return null;
  return (
    <Panel title="Stresses beside ISO 6336">
      <StandardTable iso={iso6336} design={design} />
    </Panel>
  );
}

function Panels({ data }) {
  const { job, result, response, evaluations, document } = data;
  const designs = useMemo(() => (result ? designsOfResult(result) : designsOfResponse(response)), [result, response]);
  const objective = job.objective || document?.objectives?.[0] || "f_dte";
  const name = jobTitle(job);
  const isSearch = job.kind === "optimize";
  return (
    <div class="panels">
      <WarningsPanel warnings={result?.warnings} />
      {designs.length > 0 && <ResponsePanel designs={designs} name={name} />}
      {result?.search?.pareto && <ParetoPanel result={result} evaluations={evaluations} name={name} />}
      {isSearch && evaluations.length > 1 && (
        <SearchPanels evaluations={evaluations} objective={objective} name={name} />
      )}
      {result?.map && <MapPanels map={result.map} name={name} />}
      {result?.macro && <MacroPanels result={result} name={name} />}
      <ReliabilityPanel result={result} evaluations={evaluations} document={document} name={name} />
      {result?.design && <CyclePanels designs={designs} name={name} />}
      {result && <StandardPanel result={result} />}
      {result?.design && <JobDrawings job={job} hasReference={Boolean(result.reference)} />}
      {result?.design && (
        <Panel title="Reliefs">
          <ReliefTable designs={designs} />
        </Panel>
      )}
      {result?.design && <JobStress job={job} loadCases={result.design.load_cases.map((one) => one.torque_nm)} />}
      <FactsPanel job={job} result={result} document={document} />
      <CandidatesPanel evaluations={evaluations} objective={objective} />
    </div>
  );
}

function ParetoPanel({ result, evaluations, name }) {
  const objectives = objectivesOf(result);
  const pairs = objectives.flatMap((first, i) => objectives.slice(i + 1).map((second) => [first, second]));
  const [pair, setPair] = useState(0);
  const figure = useMemo(
    () => paretoFigure(result.search.pareto, evaluations, pairs[pair], chosenOf(result)),
    [result, evaluations, pair],
  );
  const choice = (
    <select aria-label="Objectives shown" value={pair} onChange={(event) => setPair(Number(event.target.value))}>
      {pairs.map(([first, second], i) => (
        <option key={i} value={i}>
          {OBJECTIVES[first].name} and {OBJECTIVES[second].name}
        </option>
      ))}
    </select>
  );
  return (
    <Panel title={figure.title}>
      <Plot key={pair} figure={figure} name={name} height={320} controls={pairs.length > 1 ? choice : undefined} />
    </Panel>
  );
}

export function Job({ id, isReport }) {
  const data = useJobData(id);
  const { job, result, error, document, isDeleted } = data;
  const title = job ? jobTitle(job) : "";
  useEffect(() => {
    if (title) globalThis.document.title = `${title} – quietgear`;
  }, [title]);
  if (isDeleted) return <p class="empty">This job was deleted.</p>;
  if (error && !job) return <p class="empty bad">{error.message}</p>;
  if (!job) return <p class="empty">Loading…</p>;
  if (isReport)
    return result ? (
      <Report data={data} />
    ) : (
      <p class="empty">{job.state === "succeeded" ? "Loading…" : `The job is ${job.state}: there is no report.`}</p>
    );
  return (
    <>
      <Heading job={job} document={document} />
      <ProgressStrip job={job} />
      {result && <KeyFigures result={result} />}
      <Panels data={data} />
    </>
  );
}
