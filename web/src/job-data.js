// What the view of a job works with: the job itself as the event stream tells it, and what it has left so far, asked for again
// while it runs, at most every REFRESH_MS.
import { useEffect, useRef, useState } from "preact/hooks";
import { getDocument, getEvaluations, getFrequencyResponse, getResult } from "./api.js";
import { jobs, loadJob } from "./jobs.js";
import { useLoaded } from "./parts/parts.jsx";
import { useStore } from "./store.js";

const REFRESH_MS = 1500;

// The value, changing at most every `ms`; `isLast` lets it through at once.
function useThrottled(value, ms, isLast) {
  const [shown, setShown] = useState(value);
  const since = useRef(0);
  useEffect(() => {
    const rest = isLast ? 0 : Math.max(0, since.current + ms - Date.now());
    const timer = setTimeout(() => {
      since.current = Date.now();
      setShown(value);
    }, rest);
    return () => clearTimeout(timer);
  }, [value, isLast]);
  return shown;
}

// null instead of the problem that there is none yet (409), or no such call (404).
const orNull = (promise) =>
  promise.catch((problem) => {
    if (problem.status === 409 || problem.status === 404) return null;
    throw problem;
  });

// {job, result, response, evaluations, document, error}; each null while there is none.
export function useJobData(id) {
  const job = useStore(jobs, (known) => known.byId.get(id)) || null;
  const wasKnown = useRef(false);
  wasKnown.current ||= job !== null;
  const { error } = useLoaded(() => loadJob(id), [id]);
  const isOver = job !== null && job.finished_at !== null;
  const step = useThrottled(job ? `${job.state} ${job.progress.done}` : "", REFRESH_MS, isOver);
  const best = useThrottled(job ? `${job.state} ${job.progress.best}` : "", REFRESH_MS, isOver);
  const state = job?.state;
  const result = useLoaded(
    (signal) => (state === "succeeded" ? getResult(id, signal) : Promise.resolve(null)),
    [id, state],
  );
  const wantsResponse = state && state !== "queued" && state !== "succeeded" && job.progress.best !== null;
  const response = useLoaded(
    (signal) => (wantsResponse ? orNull(getFrequencyResponse(id, signal)) : Promise.resolve(null)),
    [id, best, wantsResponse],
  );
  const evaluations = useLoaded(
    (signal) => (state ? orNull(getEvaluations(id, signal)) : Promise.resolve(null)),
    [id, step, state === undefined],
  );
  const document = useLoaded((signal) => orNull(getDocument(id, signal)), [id]);
  return {
    job,
    isDeleted: wasKnown.current && job === null,
    result: result.value,
    response: response.value,
    evaluations: evaluations.value || [],
    document: result.value?.job || document.value,
    error: error || result.error,
  };
}
