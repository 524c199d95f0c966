// The calls of the HTTP interface. What goes wrong comes as a Problem, made from the server's RFC 9457 document; no answer at
// all is a Problem with status 0. A token, where the server wants one, is kept for the browser tab and sent as a bearer.
const TOKEN_KEY = "quietgear.token";

export class Problem extends Error {
  constructor(status, document = {}) {
    super(document.detail || document.title || `HTTP status ${status}`);
    this.status = status;
    this.title = document.title || "";
    this.type = document.type || "";
    this.errors = document.errors || []; // [{pointer, detail}]
  }
}

export function setToken(token) {
  if (token) sessionStorage.setItem(TOKEN_KEY, token);
  else sessionStorage.removeItem(TOKEN_KEY);
}

// The header fields of every request.
export function headers(more = {}) {
  const token = sessionStorage.getItem(TOKEN_KEY);
  return token ? { Authorization: `Bearer ${token}`, ...more } : more;
}

async function problemOf(response) {
  const isProblem = (response.headers.get("Content-Type") || "").startsWith("application/problem+json");
  const document = isProblem ? await response.json().catch(() => ({})) : {};
  return new Problem(response.status, document);
}

// One request; the answer, or a Problem thrown. options: method, accept, body (text), type (of the body), key, signal.
export async function request(path, options = {}) {
  const { method = "GET", accept = "application/json", body, type = "application/json", key, signal } = options;
  const fields = headers({ Accept: accept });
  if (body !== undefined) fields["Content-Type"] = type;
  if (key) fields["Idempotency-Key"] = key;
  let response;
  try {
    response = await fetch(path, { method, headers: fields, body, signal });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Problem(0, { title: "The server does not answer" });
  }
  if (!response.ok) throw await problemOf(response);
  return response;
}

const json = async (path, options) => (await request(path, options)).json();
const jobPath = (id, tail = "") => `/v1/jobs/${encodeURIComponent(id)}${tail}`;

// The address behind rel="next" in a Link field; null.
export function nextPage(response) {
  const match = /<([^>]*)>;\s*rel="next"/.exec(response.headers.get("Link") || "");
  return match ? match[1] : null;
}

// One page of the list of jobs: {jobs, next}.
export async function listJobs(address = "/v1/jobs?limit=200") {
  const response = await request(address);
  return { jobs: (await response.json()).jobs, next: nextPage(response) };
}

export const getJob = (id, signal) => json(jobPath(id), { signal });
export const getResult = (id, signal) => json(jobPath(id, "/result"), { signal });
export const getFrequencyResponse = (id, signal) => json(jobPath(id, "/frequency-response"), { signal });
export const getDocument = (id, signal) => json(jobPath(id, "/document"), { signal });
export const cancelJob = (id) => json(jobPath(id, "/cancel"), { method: "POST" });
export const deleteJob = (id) => request(jobPath(id), { method: "DELETE", accept: "*/*" });
export const listExamples = (signal) => json("/v1/examples", { signal });
export const getExample = (name, signal) => json(`/v1/examples/${encodeURIComponent(name)}`, { signal });
export const getSchema = (name, signal) => json(`/v1/schemas/${encodeURIComponent(name)}`, { signal });

// Judges a document, as text, without queueing it: {valid, document, geometry, warnings}; its faults come as a Problem.
export const checkDocument = (text, signal) => json("/v1/check", { method: "POST", body: text, signal });

// Submits a document, as text. The key makes a repeated attempt the same job.
export const submitJob = (text, key) => json("/v1/jobs", { method: "POST", body: text, key });

// All candidates tried so far.
export async function getEvaluations(id, signal) {
  const response = await request(jobPath(id, "/evaluations"), { accept: "application/x-ndjson", signal });
  const text = await response.text();
  return text
    .split("\n")
    .filter(Boolean)
    .map((line) => JSON.parse(line));
}

const DXF = "image/vnd.dxf";
const drawingQuery = (options) => {
  const query = new URLSearchParams(options).toString();
  return query ? `?${query}` : "";
};

// The profile data of a design: a document, or {gear_pair, relief}.
export const drawProfile = (design, signal) =>
  json("/v1/profile", { method: "POST", body: JSON.stringify(design), signal });

// The profile data of a job: of its "design" or its "reference".
export const getJobProfile = (id, design, signal) => json(jobPath(id, `/profile?design=${design}`), { signal });

// The same as DXF; options: {extent: "gears" | "spaces", position}, of a job also {design}.
export const drawDxf = (design, options) =>
  request(`/v1/profile${drawingQuery(options)}`, { method: "POST", body: JSON.stringify(design), accept: DXF });
export const getJobDxf = (id, options) => request(jobPath(id, `/profile${drawingQuery(options)}`), { accept: DXF });

// The field of a job's design, {load_case, position} as wished. The server answers 202 until it is computed.
export async function getJobField(id, wish, signal) {
  for (;;) {
    const response = await request(jobPath(id, `/field${drawingQuery(wish)}`), { signal });
    if (response.status === 200) return response.json();
    const wait = Number(response.headers.get("Retry-After")) || 1;
    await new Promise((resolve) => setTimeout(resolve, 1000 * wait));
    signal?.throwIfAborted();
  }
}
