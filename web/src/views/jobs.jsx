// The table of jobs: live, filtered by state, label and words, with what can be done to each. The filters stand in the address.
import { useMemo, useState } from "preact/hooks";
import { cancelJob, deleteJob } from "../api.js";
import { OBJECTIVES, age, duration, fixed, jobTitle, localTime, percent, runningTime } from "../format.js";
import { forget, jobs, loadOlder } from "../jobs.js";
import { Confirm, ProgressBar, StateMark, complain, say, useNow } from "../parts/parts.jsx";
import { go, href, replaceQuery } from "../router.js";
import { useStore } from "../store.js";

const STATES = ["queued", "running", "succeeded", "failed", "cancelled"];
export const DESIGNS_MOST = 6;

const isOver = (job) => job.finished_at !== null;

// The jobs that the filters let through, newest first.
export function filterJobs(byId, { state, label, words }) {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (job) => {
    const text = [job.name, job.id, job.kind, ...job.labels].join(" ").toLowerCase();
    return (
      (!state || job.state === state) &&
      (!label || job.labels.includes(label)) &&
      wanted.every((word) => text.includes(word))
    );
  };
  return [...byId.values()].filter(fits).sort((a, b) => (a.submitted_at < b.submitted_at ? 1 : -1));
}

function Filters({ filter, labels, onChange }) {
  const change = (key) => (event) => onChange({ ...filter, [key]: event.target.value });
  return (
    <form class="filters" role="search" onSubmit={(event) => event.preventDefault()}>
      <label>
        Search
        <input type="search" value={filter.words} onInput={change("words")} placeholder="name, kind, label" />
      </label>
      <label>
        State
        <select value={filter.state} onChange={change("state")}>
          <option value="">all</option>
          {STATES.map((state) => (
            <option key={state}>{state}</option>
          ))}
        </select>
      </label>
      <label>
        Label
        <select value={filter.label} onChange={change("label")}>
          <option value="">all</option>
          {labels.map((label) => (
            <option key={label}>{label}</option>
          ))}
        </select>
      </label>
    </form>
  );
}

// The best value so far, with its unit.
function Best({ job }) {
  const { best } = job.progress;
  const objective = OBJECTIVES[job.objective];
  if (best === null || !objective) return "–";
  return (
    <>
      <small>{objective.name}</small> {fixed(best, objective.digits)} <small class="unit">{objective.unit}</small>
    </>
  );
}

function Progress({ job }) {
  const { done, total, phase, eta_s: eta } = job.progress;
  if (job.state !== "running") return null;
  return (
    <>
      <small class="number">
        {total ? percent(done / total) : "–"} {phase}
        {eta === null ? "" : ` · ${duration(eta)} left`}
      </small>
      <ProgressBar done={done} total={total} label={`${jobTitle(job)}: ${done} of ${total} steps`} />
    </>
  );
}

async function doCancel(job) {
  try {
    await cancelJob(job.id);
    say(`${jobTitle(job)}: to be cancelled`);
  } catch (problem) {
    complain(problem);
  }
}

function Actions({ job, onDelete }) {
  return isOver(job) || job.state === "queued" ? (
    <button type="button" class="quiet" onClick={() => onDelete(job)} aria-label={`Delete ${jobTitle(job)}`}>
      Delete
    </button>
  ) : (
    <button
      type="button"
      class="quiet"
      disabled={job.cancel_requested}
      onClick={() => doCancel(job)}
      aria-label={`Cancel ${jobTitle(job)}`}
    >
      Cancel
    </button>
  );
}

function Row({ job, now, isSelected, canSelect, onSelect, onDelete }) {
  return (
    <tr class={isSelected ? "selected" : ""}>
      <td class="tick">
        <input
          type="checkbox"
          checked={isSelected}
          disabled={job.state !== "succeeded" || (!isSelected && !canSelect)}
          onChange={() => onSelect(job.id)}
          aria-label={`Compare ${jobTitle(job)}`}
        />
      </td>
      <th scope="row">
        <a href={href("jobs", job.id)}>{jobTitle(job)}</a>
        {job.labels.map((label) => (
          <span class="label" key={label}>
            {label}
          </span>
        ))}
        {job.error && <small class="bad">{job.error}</small>}
      </th>
      <td>{job.kind}</td>
      <td class="progress">
        <StateMark job={job} />
        <Progress job={job} />
      </td>
      <td class="number">
        <Best job={job} />
      </td>
      <td class="number" title={localTime(job.submitted_at)}>
        {age(job.submitted_at, now)}
      </td>
      <td class="number">{duration(runningTime(job, now))}</td>
      <td class="actions">
        <Actions job={job} onDelete={onDelete} />
      </td>
    </tr>
  );
}

function Table({ shown, selected, onSelect, onDelete }) {
  const now = useNow();
  return (
    <div class="scroll">
      <table class="jobs">
        <caption class="unseen">Jobs, newest first</caption>
        <thead>
          <tr>
            <th scope="col" class="tick">
              <span class="unseen">Compare</span>
            </th>
            <th scope="col">Job</th>
            <th scope="col">Kind</th>
            <th scope="col">State and progress</th>
            <th scope="col" class="number">
              Best
            </th>
            <th scope="col" class="number">
              Submitted
            </th>
            <th scope="col" class="number">
              Took
            </th>
            <th scope="col">
              <span class="unseen">Actions</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {shown.map((job) => (
            <Row
              key={job.id}
              job={job}
              now={now}
              isSelected={selected.includes(job.id)}
              canSelect={selected.length < DESIGNS_MOST}
              onSelect={onSelect}
              onDelete={onDelete}
            />
          ))}
        </tbody>
      </table>
    </div>
  );
}

async function remove(job) {
  try {
    if (job.state === "queued") await cancelJob(job.id);
    await deleteJob(job.id);
    forget(job.id);
    say(`${jobTitle(job)}: deleted`);
  } catch (problem) {
    complain(problem);
  }
}

function Empty({ any }) {
  if (any) return <p class="empty">No job fits these filters.</p>;
  return (
    <p class="empty">
      No jobs yet. <a href={href("new")}>Start one</a>.
    </p>
  );
}

export function Jobs({ query }) {
  const { byId, next, loaded } = useStore(jobs);
  const [selected, setSelected] = useState([]);
  const [doomed, setDoomed] = useState(null);
  const filter = {
    state: query.get("state") || "",
    label: query.get("label") || "",
    words: query.get("words") || "",
  };
  const shown = useMemo(() => filterJobs(byId, filter), [byId, filter.state, filter.label, filter.words]);
  const labels = [...new Set([...byId.values()].flatMap((job) => job.labels))].sort();
  const change = (wanted) => replaceQuery(Object.fromEntries(Object.entries(wanted).filter(([, value]) => value)));
  const select = (id) =>
    setSelected(selected.includes(id) ? selected.filter((other) => other !== id) : [...selected, id]);
  const removeDoomed = () => {
    setSelected(selected.filter((id) => id !== doomed.id));
    setDoomed(null);
    remove(doomed);
  };
  return (
    <>
      <div class="headline">
        <h1>Jobs</h1>
        <Filters filter={filter} labels={labels} onChange={change} />
        <span class="spread" />
        <button
          type="button"
          disabled={selected.length < 1}
          onClick={() => go("compare", { designs: selected.map((id) => `${id}:design`).join(",") })}
        >
          Compare{selected.length ? ` ${selected.length}` : ""}
        </button>
        <a class="button primary" href={href("new")}>
          New job
        </a>
      </div>
      {shown.length > 0 && <Table shown={shown} selected={selected} onSelect={select} onDelete={setDoomed} />}
      {loaded && shown.length === 0 && <Empty any={byId.size > 0} />}
      {next && (
        <p>
          <button type="button" onClick={() => loadOlder().catch(complain)}>
            Older jobs
          </button>
        </p>
      )}
      <Confirm
        question={doomed && `Delete “${jobTitle(doomed)}” with its results? This cannot be undone.`}
        action="Delete"
        onYes={removeDoomed}
        onNo={() => setDoomed(null)}
      />
    </>
  );
}
