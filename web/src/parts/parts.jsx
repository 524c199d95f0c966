// Small pieces that several views use.
import { useEffect, useRef, useState } from "preact/hooks";
import { createStore, useStore } from "../store.js";

// What the page says once, aloud as well: the last message, and whether it is an error.
const notice = createStore({ text: "", isError: false });

export function say(text) {
  notice.set({ text, isError: false });
}

// Says what went wrong; the text of a Problem is meant for people.
export function complain(error) {
  notice.set({ text: error.message, isError: true });
}

export function Notice() {
  const { text, isError } = useStore(notice);
  useEffect(() => {
    if (!text || isError) return undefined;
    const timer = setTimeout(() => notice.set({ text: "", isError: false }), 6000);
    return () => clearTimeout(timer);
  }, [text, isError]);
  return (
    <div class={`notice ${isError ? "bad" : ""}`} role={isError ? "alert" : "status"} hidden={!text}>
      <span>{text}</span>
      {text && (
        <button
          type="button"
          class="quiet"
          aria-label="Dismiss"
          onClick={() => notice.set({ text: "", isError: false })}
        >
          ×
        </button>
      )}
    </div>
  );
}

// The time, every `step` milliseconds while the page is looked at.
export function useNow(step = 1000) {
  const [now, setNow] = useState(Date.now());
  useEffect(() => {
    const timer = setInterval(() => document.hidden || setNow(Date.now()), step);
    return () => clearInterval(timer);
  }, [step]);
  return now;
}

// What an asynchronous `load(signal)` gives: {value, error, loading}; asked again when a key changes, while the earlier
// value stays.
export function useLoaded(load, keys) {
  const [state, setState] = useState({ value: null, error: null, loading: true });
  useEffect(() => {
    const abort = new AbortController();
    load(abort.signal).then(
      (value) => abort.signal.aborted || setState({ value, error: null, loading: false }),
      (error) => abort.signal.aborted || setState((old) => ({ ...old, error, loading: false })),
    );
    return () => abort.abort();
  }, keys);
  return state;
}

export function StateMark({ job }) {
  const stopping = job.state === "running" && job.cancel_requested;
  return <span class={`state ${job.state}`}>{stopping ? "stopping" : job.state}</span>;
}

export function ProgressBar({ done, total, label }) {
  return <progress max={Math.max(total, 1)} value={done} aria-label={label} />;
}

// Asks before something that cannot be undone. `question` null: closed.
export function Confirm({ question, action, onYes, onNo }) {
  const dialog = useRef(null);
  useEffect(() => {
    if (question) {
      dialog.current.showModal();
      dialog.current.querySelector("button:last-of-type").focus();
    } else dialog.current.close();
  }, [question]);
  return (
    <dialog ref={dialog} onClose={() => question && onNo()} aria-label={action}>
      <p>{question}</p>
      <p class="buttons">
        <button type="button" class="danger" onClick={onYes}>
          {action}
        </button>
        <button type="button" onClick={onNo}>
          Keep
        </button>
      </p>
    </dialog>
  );
}

// A part of a view with a heading.
export function Panel({ title, note, wide, children, id }) {
  const heading = `panel-${id || title.toLowerCase().replaceAll(/[^a-z]+/g, "-")}`;
  return (
    <section class={`panel ${wide ? "wide" : ""}`} aria-labelledby={heading}>
      <h2>
        <span id={heading}>{title}</span>
        {note && <small>{note}</small>}
      </h2>
      {children}
    </section>
  );
}
