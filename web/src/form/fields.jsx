// The fields of the form, made from the JSON Schema: label and unit from the key, range and default from the schema, faults
// from the server. A field is named by its JSON pointer.
import { createContext } from "preact";
import { useContext, useState } from "preact/hooks";
import { nameAndUnit } from "../format.js";
import { faultsAt } from "./check.js";
import { getAt } from "./document.js";
import { remove, set, setKind, switchOff, switchOn } from "./draft.js";
import { rangeText, resolve, rulesFor, sortOf } from "./schema.js";
import { suggest } from "./suggest.js";

// {root: the schema, document, errors, geometry, rules}
export const FormContext = createContext(null);

export const idOf = (pointer) => `field${pointer.replaceAll("/", "-")}`;
const keyOf = (pointer) => pointer.split("/").at(-1);

// Words as people write them, where the key cannot say it so.
const SPELLINGS = [
  ["f dte", "F_DTE"],
  ["f pps", "F_PPS"],
  ["youngs", "Young\u2019s"],
  ["poisson ratio", "Poisson\u2019s ratio"],
];

const spell = (text) => SPELLINGS.reduce((words, [plain, right]) => words.replace(plain, right), text);

export function titleOf(key) {
  const text = spell(nameAndUnit(key).text);
  return text.charAt(0).toUpperCase() + text.slice(1);
}

// What a member is, in one sentence, with its range.
function explanation(node, unit) {
  const range = rangeText(node);
  return [node.description, range && `Allowed: ${range}${unit ? ` ${unit}` : ""}.`].filter(Boolean).join(" ");
}

export function Faults({ pointer, below }) {
  const { errors } = useContext(FormContext);
  const faults = faultsAt(errors, pointer, below);
  if (faults.length === 0) return null;
  return (
    <span class="fault" id={`${idOf(pointer)}-fault`}>
      {faults.map((fault) => fault.detail).join("; ")}
    </span>
  );
}

// Attributes that tie an input to its place, its explanation and its faults.
function useInput(pointer, node) {
  const { errors, document } = useContext(FormContext);
  const isWrong = faultsAt(errors, pointer, true).length > 0;
  return {
    value: getAt(document, pointer),
    attributes: {
      id: idOf(pointer),
      title: explanation(node, nameAndUnit(keyOf(pointer)).unit),
      "aria-invalid": isWrong || undefined,
      "aria-describedby": isWrong ? `${idOf(pointer)}-fault` : undefined,
      "data-pointer": pointer,
    },
  };
}

// What was typed: a number where it is one, also with a decimal comma; else the text itself, which the server will refuse.
function typed(text) {
  const number = Number(text.trim().replace(",", "."));
  return text.trim() !== "" && Number.isFinite(number) ? number : text;
}

const shown = (value) => (value === undefined || value === null ? "" : typeof value === "object" ? JSON.stringify(value) : String(value));

// An input for a value that is written back as what `typed` makes of it; empty removes. Keeps "1." while it is being typed.
export function ValueInput({ value, onValue, attributes, placeholder, wide, label }) {
  const [text, setText] = useState(shown(value));
  const isSame = text === "" ? value === undefined || value === null || value === "" : typed(text) === value || text === value;
  return (
    <input
      {...attributes}
      type="text"
      inputMode={wide ? undefined : "decimal"}
      class={wide ? "wide" : "number"}
      autocomplete="off"
      spellcheck={false}
      aria-label={label}
      placeholder={placeholder}
      value={isSame ? text : shown(value)}
      onInput={(event) => {
        setText(event.target.value);
        onValue(event.target.value);
      }}
    />
  );
}

// What the server takes for a gear's figure that is left out, rounded.
function derived(pointer, geometry) {
  const [, section, which, key, more] = pointer.split("/");
  const value = section === "gear_pair" && !more ? geometry?.[which]?.[key] : undefined;
  return Number.isFinite(value) ? Number(value.toPrecision(5)) : undefined;
}

export function NumberInput({ pointer, node, label }) {
  const { geometry } = useContext(FormContext);
  const { value, attributes } = useInput(pointer, node);
  const fallback = node.default ?? derived(pointer, geometry);
  const placeholder = fallback === undefined ? undefined : String(fallback);
  const write = (text) => (text.trim() === "" ? remove(pointer, keepObject) : set(pointer, typed(text)));
  return <ValueInput {...{ value, attributes, placeholder, label }} onValue={write} />;
}

// Objects that were switched on stay when they become empty.
const keepObject = (pointer) => /\/(tip|root)$|^\/[a-z_]+$/.test(pointer);

function TextInput({ pointer, node }) {
  const { value, attributes } = useInput(pointer, node);
  const write = (text) => (text === "" ? remove(pointer, keepObject) : set(pointer, text));
  return (
    <input {...attributes} type="text" class="wide" value={value ?? ""} onInput={(event) => write(event.target.value)} />
  );
}

function ChoiceInput({ pointer, node }) {
  const { root } = useContext(FormContext);
  const { value, attributes } = useInput(pointer, node);
  const choose = (choice) => {
    if (pointer === "/kind") setKind(choice, (kind) => rulesFor(root, kind));
    else if (choice === "") remove(pointer, keepObject);
    else set(pointer, choice);
  };
  const words = (choice) => spell(choice.replaceAll("_", " "));
  return (
    <select {...attributes} value={value ?? ""} onChange={(event) => choose(event.target.value)}>
      {node.default !== undefined && <option value="">default: {words(node.default)}</option>}
      {value !== undefined && !node.enum.includes(value) && <option value={value}>{shown(value)}</option>}
      {node.enum.map((choice) => (
        <option key={choice} value={choice}>
          {words(choice)}
        </option>
      ))}
    </select>
  );
}

function WordsInput({ pointer, node }) {
  const { value, attributes } = useInput(pointer, node);
  const write = (text) => {
    const words = text.split(",").map((word) => word.trim());
    const kept = words.filter(Boolean);
    if (kept.length === 0) remove(pointer);
    else set(pointer, kept);
  };
  const [text, setText] = useState((value || []).join(", "));
  const now = Array.isArray(value) ? value.join(", ") : shown(value);
  const isSame = text.split(",").map((word) => word.trim()).filter(Boolean).join(", ") === now;
  return (
    <input
      {...attributes}
      type="text"
      class="wide"
      placeholder="words, with commas between"
      value={isSame ? text : now}
      onInput={(event) => {
        setText(event.target.value);
        write(event.target.value);
      }}
    />
  );
}

// A member for which the form has no better way: its JSON, taken over when it is some.
function JsonInput({ pointer, node }) {
  const { value, attributes } = useInput(pointer, node);
  const [text, setText] = useState(null);
  const write = () => {
    try {
      if (text !== null && text.trim() === "") remove(pointer);
      else if (text !== null) set(pointer, JSON.parse(text));
      setText(null);
    } catch {
      set(pointer, text); // a text, which the server will refuse at this place
    }
  };
  return (
    <textarea
      {...attributes}
      class="code"
      rows="3"
      value={text ?? (value === undefined ? "" : JSON.stringify(value))}
      onInput={(event) => setText(event.target.value)}
      onBlur={write}
    />
  );
}

// Lower and upper limit, behind a switch where the pair may be absent.
export function RangeInput({ pointer, node, label }) {
  const { document, geometry } = useContext(FormContext);
  const { value, attributes } = useInput(pointer, node);
  const isOn = value !== undefined;
  const pair = Array.isArray(value) ? value : [value, undefined];
  const write = (at) => (text) => set(pointer, [0, 1].map((i) => (i === at ? (text.trim() === "" ? null : typed(text)) : pair[i] ?? null)));
  const { id, ...others } = attributes;
  return (
    <span class="range">
      <input
        type="checkbox"
        id={id}
        checked={isOn}
        aria-label={`${label}: moves`}
        title={attributes.title}
        onChange={() => (isOn ? remove(pointer, () => false) : switchOn(pointer, suggest(pointer, document, geometry)))}
      />
      {isOn && (
        <>
          <ValueInput value={pair[0]} onValue={write(0)} attributes={others} label={`${label}, lower limit`} />
          <span aria-hidden="true">–</span>
          <ValueInput value={pair[1]} onValue={write(1)} attributes={others} label={`${label}, upper limit`} />
        </>
      )}
    </span>
  );
}

const INPUTS = { number: NumberInput, loose: NumberInput, text: TextInput, choice: ChoiceInput, words: WordsInput, range: RangeInput, json: JsonInput };

// One line: label, input, unit, faults.
export function Field({ pointer, node }) {
  const { root } = useContext(FormContext);
  const { unit } = nameAndUnit(keyOf(pointer));
  const title = titleOf(keyOf(pointer));
  const sort = sortOf(root, node);
  const Input = INPUTS[sort];
  return (
    <div class="field">
      <label for={idOf(pointer)} title={explanation(node, unit)}>
        {title}
        {unit && <small> {unit}</small>}
      </label>
      <Input pointer={pointer} node={node} label={sort === "range" ? title : undefined} />
      <Faults pointer={pointer} below />
    </div>
  );
}

// A switch for an object that may be absent.
export function Switch({ pointer, label, described }) {
  const { document, geometry } = useContext(FormContext);
  const isOn = getAt(document, pointer) !== undefined;
  return (
    <label class="switch" title={described}>
      <input
        type="checkbox"
        id={idOf(pointer)}
        checked={isOn}
        data-pointer={pointer}
        onChange={() => (isOn ? switchOff(pointer) : switchOn(pointer, suggest(pointer, document, geometry)))}
      />
      {label}
    </label>
  );
}

// An array of objects: a row for each.
export function Rows({ pointer, node }) {
  const { root, document } = useContext(FormContext);
  const item = resolve(root, node.items);
  const columns = Object.entries(item.properties);
  const rows = getAt(document, pointer) ?? node.default ?? [];
  const isDefault = getAt(document, pointer) === undefined;
  if (!Array.isArray(rows)) return <JsonInput pointer={pointer} node={node} />;
  const own = () => isDefault && set(pointer, rows); // a default becomes the document's own when it is changed
  const last = rows.at(-1) || {};
  return (
    <>
      <table class="rows">
        <thead>
          <tr>
            {columns.map(([key]) => (
              <th scope="col" key={key}>
                {titleOf(key)}
                <small> {nameAndUnit(key).unit}</small>
              </th>
            ))}
            <th scope="col">
              <span class="unseen">Actions</span>
            </th>
          </tr>
        </thead>
        <tbody onInputCapture={own} onChangeCapture={own}>
          {rows.map((_, i) => (
            <tr key={i}>
              {columns.map(([key, member]) => (
                <td key={key}>
                  <Cell pointer={`${pointer}/${i}/${key}`} node={resolve(root, member)} row={i} fallback={isDefault ? rows[i][key] : undefined} />
                </td>
              ))}
              <td class="actions">
                {rows.length > (node.minItems || 0) && (
                  <button type="button" class="quiet" aria-label={`Remove row ${i + 1}`} onClick={() => set(pointer, rows.filter((__, j) => j !== i))}>
                    ×
                  </button>
                )}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      {rows.map((_, i) => (
        <Faults key={i} pointer={`${pointer}/${i}`} />
      ))}
      <Faults pointer={pointer} />
      {rows.length < (node.maxItems || Infinity) && (
        <button type="button" class="quiet" onClick={() => set(pointer, [...rows, last])}>
          + Add
        </button>
      )}
    </>
  );
}

function Cell({ pointer, node, row, fallback }) {
  const { root } = useContext(FormContext);
  const Input = INPUTS[sortOf(root, node)];
  const label = `${titleOf(keyOf(pointer))}, row ${row + 1}`;
  return (
    <>
      <span class="cell" aria-label={label}>
        <Input pointer={pointer} node={fallback === undefined ? node : { ...node, default: fallback }} label={label} />
      </span>
      <Faults pointer={pointer} below />
    </>
  );
}
