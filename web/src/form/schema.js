// What the form needs to know of a JSON Schema: references followed, what a kind of job uses and requires, and of which
// sort a member is. Nothing here knows a key of the job document but "kind".

// The schema of a member with its $ref followed; what stands beside the $ref wins.
export function resolve(root, node) {
  if (!node || typeof node !== "object" || !node.$ref) return node;
  const { $ref, ...own } = node;
  const name = $ref.split("/").at(-1);
  return { ...resolve(root, root.$defs[name]), ...own };
}

const speaksOf = (condition, kind) => {
  const named = condition?.properties?.kind;
  return named ? named.const === kind || Boolean(named.enum?.includes(kind)) : false;
};

// Pointers of members that are false in `then`, to any depth.
function forbidden(node, pointer = "") {
  return Object.entries(node?.properties || {}).flatMap(([key, member]) =>
    member === false ? [`${pointer}/${key}`] : forbidden(member, `${pointer}/${key}`),
  );
}

// {hidden, required, sometimes}: pointers that a kind does not use, that it needs, and that some other kind needs, whose
// absence therefore means something.
export function rulesFor(root, kind) {
  const rules = (root.allOf || []).map((rule) => [speaksOf(rule.if, kind), rule.then || {}]);
  const required = (part) => (part.required || []).map((key) => `/${key}`);
  return {
    hidden: new Set(rules.filter(([fits]) => fits).flatMap(([, then]) => forbidden(then))),
    required: new Set([root, ...rules.filter(([fits]) => fits).map(([, then]) => then)].flatMap(required)),
    sometimes: new Set(rules.flatMap(([, then]) => required(then))),
  };
}

// "choice", "number", "text", "range" (two numbers), "words" (array of texts), "rows" (array of objects), "object",
// "loose" (a number or a word), or "json" for all that the form has no better way for.
export function sortOf(root, node) {
  if (node.enum) return "choice";
  if (node.type === "number" || node.type === "integer") return "number";
  if (node.type === "string") return "text";
  if (node.anyOf?.some((one) => one.type === "number")) return "loose";
  if (node.type === "object" && node.properties) return "object";
  if (node.type !== "array") return "json";
  const item = resolve(root, node.items || {});
  if (["number", "integer"].includes(item.type) && node.maxItems === 2) return "range";
  if (item.type === "string" || item.enum) return "words";
  const isFlat = Object.values(item.properties || {}).every(
    (member) => !["object", "json"].includes(sortOf(root, resolve(root, member))),
  );
  return item.type === "object" && isFlat ? "rows" : "json";
}

// True for an object that has the same for the pinion and for the gear: they stand side by side.
export function isPair(node) {
  const { pinion, gear } = node.properties || {};
  return Boolean(pinion?.$ref && pinion.$ref === gear?.$ref);
}

// The range of a number in words: "0.05 to 100".
export function rangeText(node) {
  const number = (value) => String(value).replace("-", "\u2212");
  if (node.minimum === undefined && node.maximum === undefined) return "";
  return `${number(node.minimum ?? "\u2212∞")} to ${number(node.maximum ?? "∞")}`;
}
