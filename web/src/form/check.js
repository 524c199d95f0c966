// The server's judgement of the draft, and the drawing of it, asked for when typing pauses. The rules are the server's alone.
import { useEffect, useState } from "preact/hooks";
import { Problem, checkDocument, drawProfile } from "../api.js";

const PAUSE_MS = 250;

const pick = (document, keys) => Object.fromEntries(keys.filter((key) => key in document).map((key) => [key, document[key]]));

// The parts of a document that a drawing is about, from most to least: with what moves, without it, without any relief.
export function drawable(document) {
  const moving = { optimize: "relief_bounds", map: "grid" }[document.kind];
  const design = pick(document, ["gear_pair", "relief"]);
  const whole = moving && document[moving] ? [{ kind: document.kind, ...design, [moving]: document[moving] }] : [];
  return [...whole, design, pick(document, ["gear_pair"])];
}

// The drawing of the first part that the server takes; null when it takes none.
async function drawFirst(document, signal) {
  for (const part of drawable(document)) {
    try {
      return await drawProfile(part, signal);
    } catch (problem) {
      if (!(problem instanceof Problem) || ![400, 422].includes(problem.status)) throw problem;
    }
  }
  return null;
}

async function judge(text, signal) {
  try {
    const { geometry, warnings } = await checkDocument(text, signal);
    return { state: "valid", errors: [], warnings, geometry };
  } catch (problem) {
    if (!(problem instanceof Problem)) throw problem;
    if (problem.errors.length) return { state: "invalid", errors: problem.errors, warnings: [] };
    return { state: "unknown", errors: [], warnings: [], problem };
  }
}

const START = { state: "waiting", errors: [], warnings: [], geometry: null, profile: null, isOld: false, checked: "" };

// {state: "waiting" | "valid" | "invalid" | "unknown", errors, warnings, geometry, profile, isOld, checked}: the last three are
// kept from earlier as long as there are no newer ones; isOld says that the profile is such; checked is the text judged.
export function useChecked({ text, document, error }) {
  const [checked, setChecked] = useState(START);
  useEffect(() => {
    if (!document || error) return undefined;
    const abort = new AbortController();
    const timer = setTimeout(async () => {
      try {
        const [verdict, profile] = await Promise.all([judge(text, abort.signal), drawFirst(document, abort.signal)]);
        setChecked((old) => ({
          geometry: old.geometry,
          ...verdict,
          profile: profile || old.profile,
          isOld: !profile,
          checked: text,
        }));
      } catch (problem) {
        if (problem.name !== "AbortError") setChecked((old) => ({ ...old, state: "unknown", problem, checked: text }));
      }
    }, PAUSE_MS);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [text]);
  return checked;
}

// What the server said about a place, and, with `below`, about anything inside it.
export function faultsAt(errors, pointer, below = false) {
  return errors.filter((fault) => fault.pointer === pointer || (below && fault.pointer.startsWith(`${pointer}/`)));
}
