// The page's one stream of events, GET /v1/events. It is read by fetch, so that a token can go along; it comes back by
// itself after a break, with the last event's id, and says so through `onState`: "connecting", "live" or "lost".
import { Problem, headers } from "./api.js";

const RETRY_LEAST_MS = 500;
const RETRY_MOST_MS = 8000;
const SILENCE_MS = 40000; // the server says something every 15 s at least

// Cuts a stream of text into events, by the rules of the HTML standard: feed(text) calls back with {event, data, id}.
export function eventParser(onEvent) {
  let rest = "";
  let current = { event: "message", data: [], id: undefined };
  const line = (text) => {
    if (text === "") {
      if (current.data.length > 0) onEvent({ ...current, data: current.data.join("\n") });
      current = { event: "message", data: [], id: undefined };
      return;
    }
    const colon = text.indexOf(":");
    if (colon === 0) return; // a comment
    const field = colon < 0 ? text : text.slice(0, colon);
    const value = colon < 0 ? "" : text.slice(colon + 1).replace(/^ /, "");
    if (field === "data") current.data.push(value);
    else if (field === "event" || field === "id") current[field] = value;
  };
  return (text) => {
    const lines = (rest + text).split(/\r\n|\n|\r(?!$)/);
    rest = lines.pop();
    lines.forEach(line);
  };
}

// Reads one connection to its end; `heard` is called for every piece.
async function readStream(response, feed, heard) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    heard();
    feed(value);
  }
}

// Follows the events until the returned function is called. onEvent gets {event, data: object}, onState also the Problem of
// the last attempt.
export function followEvents(onEvent, onState) {
  let lastId = null;
  let wait = RETRY_LEAST_MS;
  let stopped = false;
  let abort = new AbortController();
  let silence = 0;

  const hear = () => {
    clearTimeout(silence);
    silence = setTimeout(() => abort.abort(), SILENCE_MS);
  };
  const feed = () =>
    eventParser(({ event, data, id }) => {
      if (id !== undefined) lastId = id;
      onEvent({ event, data: JSON.parse(data) });
    });

  async function connect() {
    abort = new AbortController();
    hear();
    const more = { Accept: "text/event-stream", ...(lastId === null ? {} : { "Last-Event-ID": lastId }) };
    const response = await fetch("/v1/events", { headers: headers(more), signal: abort.signal, cache: "no-store" });
    if (!response.ok) throw new Problem(response.status, await response.json().catch(() => ({})));
    wait = RETRY_LEAST_MS;
    onState("live");
    await readStream(response, feed(), hear);
  }

  async function run() {
    while (!stopped) {
      let problem = null;
      await connect().catch((error) => (problem = error));
      clearTimeout(silence);
      if (stopped) return;
      onState("lost", problem);
      await new Promise((resolve) => setTimeout(resolve, wait));
      wait = Math.min(2 * wait, RETRY_MOST_MS);
      onState("connecting", problem);
    }
  }

  onState("connecting", null);
  run();
  return () => {
    stopped = true;
    abort.abort();
  };
}
