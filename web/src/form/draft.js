// The job document that is being written: one store for form, JSON text and drawings. The text is what will be sent; the
// document is the last text that was JSON. It outlives the view, and a reload of the tab.
import { getAt, parse, pretty, removeAt, setAt } from "./document.js";
import { createStore } from "../store.js";

const KEY = "quietgear.draft";

// {text, document, error, origin}: origin says in words where the document came from.
export const draft = createStore(load());

function load() {
  const empty = { text: "", document: null, error: null, origin: "" };
  try {
    const { text, origin } = JSON.parse(sessionStorage.getItem(KEY)) || {};
    return text ? { ...empty, text, origin, ...parse(text) } : empty;
  } catch {
    return empty;
  }
}

function put(next) {
  draft.set(next);
  try {
    sessionStorage.setItem(KEY, JSON.stringify({ text: next.text, origin: next.origin }));
  } catch {
    // storage forbidden or full: the draft lives as long as the page
  }
}

// What was typed into the text. While it is no JSON the form keeps the last document.
export function setText(text) {
  const { document, error = null } = parse(text);
  const old = draft.get();
  put({ ...old, text, error, document: document || old.document });
}

// A new document, from an example, a job, a file or another view.
export function startFrom(document, origin) {
  hidden.clear();
  put({ document, text: pretty(document), error: null, origin });
}

// The same as text, whose JSON may be broken: then it can be mended in the editor.
export function startFromText(text, origin) {
  hidden.clear();
  put({ ...draft.get(), origin });
  setText(text);
}

function change(document) {
  put({ ...draft.get(), document, text: pretty(document), error: null });
}

export const set = (pointer, value) => change(setAt(draft.get().document, pointer, value));
export const remove = (pointer, keep) => change(removeAt(draft.get().document, pointer, keep));

// What was taken out of the document by a switch of the form, to come back with it.
const hidden = new Map();

export function switchOff(pointer) {
  hidden.set(pointer, getAt(draft.get().document, pointer));
  remove(pointer);
}

export function switchOn(pointer, suggestion) {
  set(pointer, hidden.get(pointer) ?? suggestion);
}

// Another kind: members that it does not use go, and come back with a kind that does.
export function setKind(kind, rulesOf) {
  let document = setAt(draft.get().document, "/kind", kind);
  const { hidden: unused, required } = rulesOf(kind);
  for (const pointer of unused) {
    const value = getAt(document, pointer);
    if (value === undefined) continue;
    hidden.set(pointer, value);
    document = removeAt(document, pointer);
  }
  for (const pointer of required)
    if (hidden.has(pointer) && getAt(document, pointer) === undefined)
      document = setAt(document, pointer, hidden.get(pointer));
  change(document);
}
