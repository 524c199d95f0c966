// The head of a job's view: its name and state, what can be done with it, and how far it is.
import { useRef, useState } from "preact/hooks";
import { cancelJob, deleteJob, request } from "../api.js";
import { OBJECTIVES, duration, fixed, jobTitle, objectiveText, percent, runningTime } from "../format.js";
import { forget } from "../jobs.js";
import { Confirm, ProgressBar, StateMark, complain, say, useNow } from "../parts/parts.jsx";
import { download, fileName } from "../plots/picture.js";
import { go, href } from "../router.js";

const canBeStopped = (job) => job.finished_at === null;

async function fetchAndSave(path, accept, name) {
  try {
    const response = await request(path, { accept });
    download(name, await response.blob());
  } catch (problem) {
    complain(problem);
  }
}

function TakeAway({ job, document }) {
  const sheet = useRef(null);
  const close = () => (sheet.current.open = false);
  const leave = (event) => event.relatedTarget && !sheet.current.contains(event.relatedTarget) && close();
  const name = fileName(jobTitle(job));
  const files = [
    ["Result, JSON", job.links.result, "application/json", `${name}.json`, job.state === "succeeded"],
    ["Frequency response, CSV", job.links.frequency_response, "text/csv", `${name}-frequency-response.csv`, true],
    ["Candidates, CSV", job.links.evaluations, "text/csv", `${name}-candidates.csv`, true],
  ];
  return (
    <details class="takeaway" ref={sheet} onKeyDown={(event) => event.key === "Escape" && close()} onFocusOut={leave}>
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

export function Heading({ job, document }) {
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

export function ProgressStrip({ job }) {
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
