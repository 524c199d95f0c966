// The daemon's page: asks for the list of jobs every few seconds and shows it. It knows the HTTP interface and nothing
// else; what a job may do is the server's affair. Text from jobs goes in as text, never as HTML.
"use strict";

const REFRESH_MS = 2000;
const FIRST_PAGE = "/v1/jobs?limit=50";

// Addresses of the list's pages on show: the first, and as many older ones as were asked for.
const pages = [FIRST_PAGE];

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function link(text, href) {
  const made = element("a", text);
  made.href = href;
  return made;
}

function duration(seconds) {
  if (seconds < 90) return `${Math.ceil(seconds)} s`;
  if (seconds < 5400) return `${Math.ceil(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

function nameCell(job) {
  const cell = element("td");
  cell.append(link(job.name || job.id, job.links.self), element("small", [job.kind, ...job.labels].join(", ")));
  return cell;
}

function stateCell(job) {
  const stopping = job.state === "running" && job.cancel_requested;
  const cell = element("td", stopping ? "stopping" : job.state, job.state);
  if (job.error) cell.append(element("small", job.error));
  return cell;
}

function progressCell(job) {
  const cell = element("td", undefined, "number");
  const { done, total, phase, eta_s: eta } = job.progress;
  if (job.state !== "running" || total === 0) return cell;
  const bar = element("progress");
  bar.max = total;
  bar.value = done;
  bar.setAttribute("aria-label", `${done} of ${total} steps`);
  cell.append(bar, element("small", `${phase}, ${done} of ${total}${eta === null ? "" : `, ${duration(eta)} left`}`));
  return cell;
}

function bestCell(job) {
  return element("td", job.progress.best === null ? "" : job.progress.best.toPrecision(4), "number");
}

function dataCell(job) {
  const cell = element("td");
  if (job.state === "succeeded") cell.append(link("result", job.links.result));
  cell.append(link("frequency response", job.links.frequency_response), link("evaluations", job.links.evaluations));
  return cell;
}

function row(job) {
  const made = element("tr");
  const submitted = element("td", new Date(job.submitted_at).toLocaleString());
  made.append(nameCell(job), stateCell(job), progressCell(job), bestCell(job), submitted, dataCell(job));
  return made;
}

// The address in a Link header field with rel="next"; null when there is none.
function nextPage(response) {
  const match = /<([^>]*)>;\s*rel="next"/.exec(response.headers.get("Link") || "");
  return match ? match[1] : null;
}

async function load(address) {
  const response = await fetch(address, { headers: { Accept: "application/json" } });
  const body = await response.json();
  if (!response.ok) throw new Error(body.detail || body.title);
  return { jobs: body.jobs, next: nextPage(response) };
}

function show(loaded) {
  const jobs = loaded.flatMap((page) => page.jobs);
  document.getElementById("jobs").replaceChildren(...jobs.map(row));
  document.getElementById("empty").hidden = jobs.length > 0;
  const older = document.getElementById("older");
  const next = loaded[loaded.length - 1].next;
  older.hidden = next === null;
  older.onclick = () => {
    pages.push(next);
    refresh();
  };
}

async function refresh() {
  const status = document.getElementById("status");
  try {
    show(await Promise.all(pages.map(load)));
    status.textContent = "";
  } catch (error) {
    status.textContent = `The server does not answer: ${error.message}`;
  }
}

async function keepFresh() {
  if (!document.hidden) await refresh();
  setTimeout(keepFresh, REFRESH_MS);
}

document.getElementById("origin").textContent = location.origin;
keepFresh();
