// All that the page knows of the jobs: one store, filled by the list and kept fresh by the event stream. After a break of the
// stream the list is read again, so that nothing that happened meanwhile is missed, deletions included.
import { getJob, listJobs } from "./api.js";
import { followEvents } from "./events.js";
import { createStore } from "./store.js";

// {byId: Map of jobs, next: address of older ones or null, loaded: bool}
export const jobs = createStore({ byId: new Map(), next: null, loaded: false });

// {state: "connecting" | "live" | "lost", problem}
export const connection = createStore({ state: "connecting", problem: null });

function put(job) {
  jobs.update((known) => ({ ...known, byId: new Map(known.byId).set(job.id, job) }));
}

export function forget(id) {
  jobs.update((known) => {
    const byId = new Map(known.byId);
    byId.delete(id);
    return { ...known, byId };
  });
}

// Reads the newest page of the list. Jobs younger than its last that are not in it were deleted.
async function reload() {
  const { jobs: listed, next } = await listJobs();
  jobs.update((known) => {
    const oldest = listed.at(-1)?.submitted_at ?? "";
    const kept = next === null ? [] : [...known.byId.values()].filter((job) => job.submitted_at < oldest);
    const byId = new Map([...listed, ...kept].map((job) => [job.id, job]));
    return { byId, next: known.loaded && kept.length > 0 ? known.next : next, loaded: true };
  });
}

export async function loadOlder() {
  const address = jobs.get().next;
  if (!address) return;
  const { jobs: listed, next } = await listJobs(address);
  jobs.update((known) => {
    const byId = new Map(known.byId);
    for (const job of listed) if (!byId.has(job.id)) byId.set(job.id, job);
    return { ...known, byId, next };
  });
}

// Makes sure that a job is known; throws the Problem when there is none.
export async function loadJob(id) {
  if (jobs.get().byId.has(id)) return;
  try {
    put(await getJob(id));
  } catch (problem) {
    if (problem.status === 401) connection.set({ state: "lost", problem }); // the frame asks for a token
    throw problem;
  }
}

function onEvent({ event, data }) {
  if (event === "job") put(data);
  else if (event === "deleted") forget(data.id);
}

async function reloadSafely() {
  try {
    await reload();
  } catch (problem) {
    connection.set({ state: "lost", problem });
  }
}

function onState(state, problem = null) {
  connection.set({ state, problem });
  if (state === "live") reloadSafely();
}

let started = false;

// Starts to follow the jobs, once.
export function followJobs() {
  if (started) return;
  started = true;
  reloadSafely();
  followEvents(onEvent, onState);
}
