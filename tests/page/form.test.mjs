// The form's modules that need no browser: places in documents, JSON for people, and what the form makes of the schema.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { SOURCE, example } from "./harness.mjs";

const at = (path) => import(new URL(`../../web/src/${path}`, import.meta.url));
const { getAt, parse, pretty, removeAt, setAt } = await at("form/document.js");
const { isPair, rangeText, resolve, rulesFor, sortOf } = await at("form/schema.js");

const schema = JSON.parse(readFileSync(join(SOURCE, "schema/job.schema.json"), "utf8"));

test("places are read, set and removed without touching the original", () => {
  const document = { a: { b: [1, { c: 2 }] } };
  assert.equal(getAt(document, "/a/b/1/c"), 2);
  assert.equal(getAt(document, "/a/x/y"), undefined);
  assert.deepEqual(setAt(document, "/a/b/1/c", 3), { a: { b: [1, { c: 3 }] } });
  assert.deepEqual(setAt(document, "/d/e", 4), { ...document, d: { e: 4 } });
  assert.deepEqual(setAt({}, "/a~1b/m~0n", 1), { "a/b": { "m~n": 1 } });
  assert.deepEqual(removeAt(document, "/a/b/0"), { a: { b: [{ c: 2 }] } });
  assert.deepEqual(removeAt({ a: { b: { c: 1 } }, d: 2 }, "/a/b/c", () => false), { d: 2 });
  assert.deepEqual(removeAt({ a: { b: { c: 1 } } }, "/a/b/c", (pointer) => pointer === "/a/b"), { a: { b: {} } });
  assert.deepEqual(document, { a: { b: [1, { c: 2 }] } });
});

test("JSON for people is the same JSON, in fewer lines", () => {
  for (const name of readdirSync(join(SOURCE, "schema/examples"))) {
    const document = example(name.replace(".json", ""));
    const text = pretty(document);
    assert.deepEqual(JSON.parse(text), document);
    assert.ok(text.split("\n").length < JSON.stringify(document, null, 2).split("\n").length);
    assert.ok(Math.max(...text.split("\n").map((line) => line.length)) <= 210);
  }
  assert.equal(pretty({}), "{}");
  assert.equal(pretty([]), "[]");
});

test("JSON that breaks is told with its place", () => {
  const { error } = parse('{\n  "a": 1\n  "b": 2\n}');
  assert.equal(error.line, 3);
  assert.equal(error.column, 3);
  assert.equal(parse('{"a": 1').error.line, 1);
  assert.equal(parse('{"a":\n\n').error.line, 1);
  assert.match(parse("[1]").error.message, /object/);
  assert.deepEqual(parse('{"a": 1}'), { document: { a: 1 } });
});

test("a kind hides what it does not use and asks for what it needs", () => {
  const evaluate = rulesFor(schema, "evaluate");
  const optimize = rulesFor(schema, "optimize");
  assert.ok(evaluate.hidden.has("/optimizer") && evaluate.hidden.has("/grid") && !evaluate.hidden.has("/relief"));
  assert.ok(optimize.hidden.has("/analysis/branches") && optimize.required.has("/relief_bounds"));
  assert.ok(rulesFor(schema, "reliability").required.has("/relief"));
  assert.ok(optimize.sometimes.has("/reliability") && !optimize.required.has("/reliability"));
});

test("every member of the schema has a way into the form", () => {
  const seen = new Set();
  const walk = (node) => {
    const inner = resolve(schema, node);
    const sort = sortOf(schema, inner);
    seen.add(sort);
    if (sort === "object") Object.values(inner.properties).forEach(walk);
  };
  Object.values(schema.properties).forEach(walk);
  for (const sort of ["choice", "number", "text", "range", "words", "rows", "object", "loose"]) assert.ok(seen.has(sort), sort);
  assert.ok(isPair(resolve(schema, schema.properties.gear_pair)) && isPair(resolve(schema, schema.properties.relief)));
  assert.ok(!isPair(resolve(schema, schema.properties.analysis)));
  assert.ok(!seen.has("json"), "a member has no better way than JSON");
  assert.equal(rangeText({ minimum: -1, maximum: 5 }), "\u22121 to 5");
});
