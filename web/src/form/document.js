// Job documents as text and as objects: places in them by JSON pointer, and text that people like to read.

const keysOf = (pointer) =>
  pointer
    .split("/")
    .slice(1)
    .map((key) => key.replaceAll("~1", "/").replaceAll("~0", "~"));

export function getAt(document, pointer) {
  return keysOf(pointer).reduce((value, key) => (value && typeof value === "object" ? value[key] : undefined), document);
}

function setKeys(value, [key, ...rest], wanted) {
  const isArray = Array.isArray(value);
  const copy = isArray ? [...value] : { ...(value && typeof value === "object" ? value : {}) };
  copy[key] = rest.length ? setKeys(copy[key], rest, wanted) : wanted;
  return copy;
}

// A copy with another value at a place; objects on the way are made.
export function setAt(document, pointer, value) {
  return setKeys(document, keysOf(pointer), value);
}

function withoutKey(value, key) {
  if (Array.isArray(value)) return value.filter((_, i) => String(i) !== key);
  const { [key]: _, ...rest } = value;
  return rest;
}

// A copy without a place. Objects that become empty go as well, unless `keep(pointer)` says no.
export function removeAt(document, pointer, keep = () => true) {
  if (getAt(document, pointer) === undefined) return document;
  const parent = pointer.slice(0, pointer.lastIndexOf("/"));
  const rest = withoutKey(getAt(document, parent), keysOf(pointer).at(-1));
  const isEmpty = !Array.isArray(rest) && Object.keys(rest).length === 0;
  if (isEmpty && parent !== "" && !keep(parent)) return removeAt(document, parent, keep);
  return parent === "" ? rest : setAt(document, parent, rest);
}

const LINE = 100;

// JSON with what fits on a line on one line.
export function pretty(value, indent = "") {
  if (value === null || typeof value !== "object") return JSON.stringify(value);
  const isArray = Array.isArray(value);
  const entries = Object.entries(value);
  const label = (key) => (isArray ? "" : `${JSON.stringify(key)}: `);
  const [open, close] = isArray ? "[]" : "{}";
  const flat = `${open}${entries.map(([key, item]) => label(key) + pretty(item)).join(", ")}${close}`;
  const isPlain = entries.every(([, item]) => item === null || typeof item !== "object" || Array.isArray(item) === false);
  if (!flat.includes("\n") && indent && isPlain && flat.length + indent.length <= LINE) return flat;
  if (entries.length === 0) return open + close;
  if (isArray && !flat.includes("\n") && flat.length + indent.length <= LINE) return flat;
  const inner = `${indent}  `;
  const lines = entries.map(([key, item]) => `${inner}${label(key)}${pretty(item, inner)}`);
  return `${open}\n${lines.join(",\n")}\n${indent}${close}`;
}

// Where a JSON text breaks: {line, column, offset}, counted from 1 and 0, from the message of the browser's parser.
function placeOf(text, message) {
  const position = /position (\d+)/.exec(message);
  const lineColumn = /line (\d+) column (\d+)/.exec(message);
  if (!position && lineColumn) {
    const [line, column] = [Number(lineColumn[1]), Number(lineColumn[2])];
    const before = text.split("\n").slice(0, line - 1);
    return { line, column, offset: before.reduce((sum, one) => sum + one.length + 1, 0) + column - 1 };
  }
  const offset = Math.min(text.length, position ? Number(position[1]) : text.trimEnd().length);
  const lines = text.slice(0, offset).split("\n");
  return { line: lines.length, column: lines.at(-1).length + 1, offset };
}

// {document} or {error: {line, column, offset, message}}.
export function parse(text) {
  try {
    const document = JSON.parse(text);
    if (document && typeof document === "object" && !Array.isArray(document)) return { document };
    return { error: { line: 1, column: 1, offset: 0, message: "a job document is an object: { … }" } };
  } catch (error) {
    const message = error.message.replace(/ in JSON at.*$| at line.*$|^JSON\.parse: /g, "");
    return { error: { ...placeOf(text, error.message), message } };
  }
}
