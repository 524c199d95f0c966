// One job: how far it is, what came of it, and why. Everything is drawn from the job's result, or, while it runs, from the best
// design so far and the log of evaluations.
import { useMemo, useState } from "preact/hooks";
import { cancelJob, deleteJob, request } from "../api.js";
import {
  loadShareFigure,
  pressureFigure,
  responseFigure,
  rootStressFigure,
  stiffnessFigure,
  torqueText,
  transmissionErrorFigure,
} from "../figures/curves.js";
import { historyFigure, landscapeFigure, mapFigure, movingParameters, paretoFigure } from "../figures/search.js";
import { OBJECTIVES, duration, fixed, jobTitle, labelOf, localTime, objectiveText, percent, runningTime, significant } from "../format.js";
import { designsOfResponse, designsOfResult, useJobData } from "../job-data.js";
import { forget } from "../jobs.js";
import { LongTable } from "../parts/long-table.jsx";
import { Confirm, Panel, ProgressBar, StateMark, complain, say, useNow } from "../parts/parts.jsx";
import { StandardTable } from "../parts/standard-table.jsx";
import { ReliefTable } from "../parts/relief-table.jsx";
import { download, fileName } from "../plots/picture.js";
import { Plot } from "../plots/plot.jsx";
import { go, href } from "../router.js";
import { JobDrawings } from "./job-drawings.jsx";
import { MacroPanel } from "./macro.jsx";
import { ReliabilityPanel } from "./reliability.jsx";
import { Report } from "./report.jsx";

const canBeStopped = (job) => job.finished_at === null;

// --- heading ---

async function fetchAndSave(path, accept, name) {
  try {
    const response = await request(path, { accept });
    download(name, await response.blob());
  } catch (problem) {
    complain(problem);
  }
}

function TakeAway({ job, document }) {
  const name = fileName(jobTitle(job));
  const files = [
    ["Result, JSON", job.links.result, "application/json", `${name}.json`, job.state === "succeeded"],
    ["Frequency response, CSV", job.links.frequency_response, "text/csv", `${name}-frequency-response.csv`, true],
    ["Candidates, CSV", job.links.evaluations, "text/csv", `${name}-candidates.csv`, true],
  ];
  return (
    <details class="takeaway">
      <summary class="button">Take away</summary>
      <div class="sheet">
        {files
          .filter((file) => file[4])
          .map(([text, path, accept, file]) => (
            <button type="button" class="quiet" key={text} onClick={() => fetchAndSave(path, accept, file)}>
              {text}
            </button>
          ))}
        {document && (
          <button
            type="button"
            class="quiet"
            onClick={() => download(`${name}-job.json`, `${JSON.stringify(document, null, 2)}\n`, "application/json")}
          >
            Job document, JSON
          </button>
        )}
        {job.state === "succeeded" && <a href={href("jobs", job.id, "report")}>Report to print</a>}
      </div>
    </details>
  );
}

function Heading({ job, document }) {
  const [asks, setAsks] = useState(false);
  const act = (call, text) => async () => {
    try {
      await call(job.id);
      say(`${jobTitle(job)}: ${text}`);
      return true;
    } catch (problem) {
      complain(problem);
      return false;
    }
  };
  const remove = async () => {
    setAsks(false);
    if (await act(deleteJob, "deleted")()) {
      forget(job.id);
      go("jobs");
    }
  };
  return (
    <div class="headline">
      <h1>{jobTitle(job)}</h1>
      <StateMark job={job} />
      <span class="kind">{job.kind}</span>
      {job.labels.map((label) => (
        <span class="label" key={label}>
          {label}
        </span>
      ))}
      <span class="spread" />
      <span class="actions">
        {job.state === "succeeded" && (
          <a class="button" href={href("compare", { designs: `${job.id}:design` })}>
            Compare
          </a>
        )}
        <a class="button" href={href("new", { from: job.id })}>
          Use as new job
        </a>
        <TakeAway job={job} document={document} />
        {canBeStopped(job) ? (
          <button type="button" disabled={job.cancel_requested} onClick={act(cancelJob, "to be cancelled")}>
            Cancel
          </button>
        ) : (
          <button type="button" onClick={() => setAsks(true)}>
            Delete
          </button>
        )}
      </span>
      <Confirm
        question={asks && `Delete “${jobTitle(job)}” with its results? This cannot be undone.`}
        action="Delete"
        onYes={remove}
        onNo={() => setAsks(false)}
      />
    </div>
  );
}

function ProgressStrip({ job }) {
  const now = useNow();
  const { done, total, phase, eta_s: eta, best } = job.progress;
  if (job.state === "queued") return <p class="strip">Waiting for a free place.</p>;
  if (!canBeStopped(job)) return job.error ? <p class="strip bad">{job.error}</p> : null;
  return (
    <section class="strip panel" aria-label="Progress">
      <ProgressBar done={done} total={total} label="Progress of the job" />
      <p class="number">
        <b>{phase}</b> · {fixed(done)} of {fixed(total)} ({total ? percent(done / total) : "–"}) · running for{" "}
        {duration(runningTime(job, now))}
        {eta !== null && <> · about {duration(eta)} left</>}
        {best !== null && OBJECTIVES[job.objective] && ` · best ${objectiveText(job.objective, best)}`}
      </p>
    </section>
  );
}

// --- figures that matter ---

function Change({ percent: change }) {
  if (change === null || change === undefined) return null;
  const isBetter = change >= 0;
  return (
    <small class={isBetter ? "good" : "bad"}>
      {isBetter ? "▼" : "▲"} {fixed(Math.abs(change), 1)} %
    </small>
  );
}

function KeyFigure({ name, unit, before, value, change, title }) {
  return (
    <div class="key" title={title}>
      <dt>{name}</dt>
      <dd class="number">
        {before !== undefined && <span class="before">{before} → </span>}
        <b>{value}</b> <small>{unit}</small>
        {change !== undefined && <Change percent={change} />}
      </dd>
    </div>
  );
}

function KeyFigures({ result }) {
  const { design, reference, improvement, reliability } = result;
  if (!design) return null;
  const worst = design.load_cases.reduce((most, one) => ((one.max_rms ?? -1) > (most.max_rms ?? -1) ? one : most));
  const pressure = Math.max(...design.load_cases.map((one) => one.max_contact_pressure_mpa));
  return (
    <dl class="keys">
      {design.f_dte !== null && (
        <KeyFigure
          name="F_DTE"
          title="Largest RMS of the dynamic transmission error over all load cases and speeds, in half-backlashes"
          unit="b"
          before={reference ? fixed(reference.f_dte, 4) : undefined}
          value={fixed(design.f_dte, 4)}
          change={improvement?.f_dte_percent}
        />
      )}
      <KeyFigure
        name="F_PPS"
        title="Largest peak to peak of the static transmission error over all load cases"
        unit="µm"
        before={reference ? fixed(reference.f_pps_um, 2) : undefined}
        value={fixed(design.f_pps_um, 2)}
        change={improvement?.f_pps_percent}
      />
      {reliability && (
        <KeyFigure
          name="Failures"
          title="Probability that F_DTE is above the limit under manufacturing errors, with its 95 % confidence interval"
          unit={`95 %: ${fixed(100 * reliability.confidence_95[0], 1)} to ${fixed(100 * reliability.confidence_95[1], 1)} %`}
          value={percent(reliability.probability_of_failure, 1)}
        />
      )}
      {worst.max_rms_at !== null && (
        <KeyFigure
          name="Worst speed"
          title={`At ${torqueText(worst.torque_nm)}, frequency ratio ${significant(worst.max_rms_at)}`}
          unit={`rpm at ${torqueText(worst.torque_nm)}`}
          value={fixed(worst.max_rms_at_pinion_rpm)}
        />
      )}
      <KeyFigure name="Contact pressure" unit="MPa" value={fixed(pressure)} />
      {design.load_cases[0].max_root_stress_mpa && (
        <KeyFigure
          name="Root stress"
          title="Largest tension in the tooth roots of pinion and gear over all load cases"
          unit="MPa"
          value={["pinion", "gear"]
            .map((gear) => fixed(Math.max(...design.load_cases.map((one) => one.max_root_stress_mpa[gear]))))
            .join(" / ")}
        />
      )}
    </dl>
  );
}

// --- panels ---

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
  const choose = (place) => (event) => setWanted(place === 0 ? [event.target.value, second] : [first, event.target.value]);
  const choice = (place, current) => (
    <select aria-label={place === 0 ? "Horizontal parameter" : "Vertical parameter"} value={current} onChange={choose(place)}>
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
    () => ["f_dte", "f_pps"].filter((one) => map[one === "f_dte" ? "f_dte" : "f_pps_um"]?.flat().some((value) => value !== null)).map((one) => mapFigure(map, one)),
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
  const number = (key, head, value, digits) => ({ key, head, value, isNumber: true, text: (row) => fixed(value(row), digits) });
  return [
    number("evaluation", "No.", (row) => row.evaluation, 0),
    { key: "phase", head: "Phase", value: (row) => row.phase, text: (row) => row.phase },
    number("f_dte", "F_DTE, b", (row) => row.f_dte, 5),
    number("f_pps_um", "F_PPS, µm", (row) => row.f_pps_um, 3),
    ...parameters.map((key) => number(key, labelOf(key), (row) => row.parameters[key] ?? null, key.endsWith("amplitude_mm") ? 5 : 3)),
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
    ["Time", result?.timing && `${duration(result.timing.wall_s)}, ${result.timing.threads} thread${result.timing.threads === 1 ? "" : "s"}`],
    ["Finite elements", result?.timing && duration(result.timing.compliance_s)],
    ["Contact", result?.timing && duration(result.timing.static_s)],
    ["Dynamics", result?.timing && duration(result.timing.dynamic_s)],
    ["Unknowns of a sector", result?.model?.pinion && `${fixed(result.model.pinion.degrees_of_freedom)} and ${fixed(result.model.gear.degrees_of_freedom)}`],
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
  const objective = job.objective || "f_dte";
  const name = jobTitle(job);
  const isSearch = job.kind === "optimize";
  return (
    <div class="panels">
      <WarningsPanel warnings={result?.warnings} />
      {designs.length > 0 && <ResponsePanel designs={designs} name={name} />}
      {isSearch && evaluations.length > 1 && <SearchPanels evaluations={evaluations} objective={objective} name={name} />}
      {result?.map && <MapPanels map={result.map} name={name} />}
      {result?.search?.pareto && <ParetoPanel front={result.search.pareto} evaluations={evaluations} name={name} />}
      {result?.macro && <MacroPanel macro={result.macro} />}
      <ReliabilityPanel result={result} evaluations={evaluations} document={document} name={name} />
      {result?.design && <CyclePanels designs={designs} name={name} />}
      {result?.design && (
        <Panel title="Reliefs">
          <ReliefTable designs={designs} />
        </Panel>
      )}
      {result?.design && <JobDrawings job={job} hasReference={Boolean(result.reference)} />}
      {result && <StandardPanel result={result} />}
      <FactsPanel job={job} result={result} document={document} />
      <CandidatesPanel evaluations={evaluations} objective={objective} />
    </div>
  );
}

function ParetoPanel({ front, evaluations, name }) {
  const figure = useMemo(() => paretoFigure(front, evaluations), [front, evaluations]);
  return (
    <Panel title={figure.title}>
      <Plot figure={figure} name={name} height={320} />
    </Panel>
  );
}

export function Job({ id, isReport }) {
  const data = useJobData(id);
  const { job, result, error, document, isDeleted } = data;
  if (isDeleted) return <p class="empty">This job was deleted.</p>;
  if (error && !job) return <p class="empty bad">{error.message}</p>;
  if (!job) return <p class="empty">Loading…</p>;
  if (isReport) return result ? <Report data={data} /> : <p class="empty">{job.state === "succeeded" ? "Loading…" : `The job is ${job.state}: there is no report.`}</p>;
  return (
    <>
      <Heading job={job} document={document} />
      <ProgressStrip job={job} />
      {result && <KeyFigures result={result} />}
      <Panels data={data} />
    </>
  );
}
