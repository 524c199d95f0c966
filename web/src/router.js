// Addresses behind the hash: "#/jobs/ID/report?x=1" is {path: ["jobs", "ID", "report"], query: URLSearchParams}. The server
// knows nothing of them, and the browser's back button works.
import { createStore } from "./store.js";

function parse(hash) {
  const [path, query = ""] = hash.replace(/^#\/?/, "").split("?");
  return { path: path.split("/").filter(Boolean).map(decodeURIComponent), query: new URLSearchParams(query) };
}

export const route = createStore(parse(location.hash));
addEventListener("hashchange", () => route.set(parse(location.hash)));

// The address of a view: href("jobs", id), or with an object of query parameters last.
export function href(...parts) {
  const query = typeof parts.at(-1) === "object" ? parts.pop() : {};
  const search = new URLSearchParams(query).toString();
  return `#/${parts.map(encodeURIComponent).join("/")}${search ? `?${search}` : ""}`;
}

export function go(...parts) {
  location.hash = href(...parts);
}

// Replaces the query of the current view without a new entry in the history.
export function replaceQuery(query) {
  const address = href(...route.get().path, query);
  history.replaceState(null, "", address);
  route.set(parse(address));
}
