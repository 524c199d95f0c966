// What a search over macro-geometry found: its list of gear pairs as a table, whatever columns they have, and each as the start
// of a new job.
import { startFrom } from "../form/draft.js";
import { fixed, labelOf, significant } from "../format.js";
import { Panel } from "../parts/parts.jsx";
import { go } from "../router.js";

// Takes a document to the form of a new job.
function startHere(document) {
  startFrom(document, "a search over macro-geometry");
  go("new");
}

const isPlain = (value) => value === null || ["number", "string", "boolean"].includes(typeof value);

// {"a": {"b": 1}} as [["a.b", 1]], two levels deep; documents are left out.
function flatten(object, prefix = "", depth = 2) {
  return Object.entries(object).flatMap(([key, value]) => {
    if (isPlain(value)) return [[prefix + key, value]];
    if (depth > 1 && value && !Array.isArray(value) && key !== "job" && key !== "document" && key !== "relief")
      return flatten(value, `${prefix}${key}.`, depth - 1);
    return [];
  });
}

const text = (value) =>
  typeof value !== "number" ? String(value ?? "–") : Number.isInteger(value) ? fixed(value) : significant(value, 5);

// The first member that is a list of objects is the list of pairs.
function listOf(macro) {
  return Object.values(macro).find((value) => Array.isArray(value) && value.length && typeof value[0] === "object") || [];
}

export function MacroPanel({ macro }) {
  const pairs = listOf(macro);
  const rows = pairs.map((pair) => new Map(flatten(pair)));
  const keys = [...new Set(rows.flatMap((row) => [...row.keys()]))];
  return (
    <Panel title="Gear pairs found" note={String(pairs.length)} wide>
      <div class="scroll">
        <table>
          <caption class="unseen">Gear pairs found</caption>
          <thead>
            <tr>
              {keys.map((key) => (
                <th scope="col" class="number" key={key}>
                  {labelOf(key)}
                </th>
              ))}
              <th scope="col">
                <span class="unseen">Actions</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row, i) => (
              <tr key={i}>
                {keys.map((key) => (
                  <td class="number" key={key}>
                    {text(row.get(key))}
                  </td>
                ))}
                <td>
                  {(pairs[i].job || pairs[i].document) && (
                    <button type="button" class="quiet" onClick={() => startHere(pairs[i].job || pairs[i].document)}>
                      Use as new job
                    </button>
                  )}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </Panel>
  );
}
