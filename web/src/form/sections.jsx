// The sections of the form: one for each object of the document; what pinion and gear have alike stands side by side.
import { useContext } from "preact/hooks";
import { nameAndUnit } from "../format.js";
import { getAt } from "./document.js";
import { Faults, Field, FormContext, NumberInput, RangeInput, Rows, Switch, idOf, titleOf } from "./fields.jsx";
import { isPair, resolve, sortOf } from "./schema.js";

const GEARS = ["pinion", "gear"];

// The rows of a pair's table: {key, path, node, group}; group rows head the members of an inner object.
function rowsOf(root, node, path = "") {
  return Object.entries(node.properties).flatMap(([key, member]) => {
    const inner = resolve(root, member);
    const row = { key, path: `${path}/${key}`, node: inner };
    if (sortOf(root, inner) !== "object") return [{ ...row, parent: path }];
    return [{ ...row, isGroup: true }, ...rowsOf(root, inner, row.path)];
  });
}

function PairCell({ pointer, row, which }) {
  const { root, document } = useContext(FormContext);
  const place = `${pointer}/${which}${row.path}`;
  const label = `${which === "pinion" ? "Pinion" : "Gear"}: ${titleOf(row.key)}`;
  if (row.isGroup) return <Switch pointer={place} label={<span class="unseen">{label}</span>} described={row.node.description} />;
  const isRange = sortOf(root, row.node) === "range";
  if (!isRange && row.parent && getAt(document, `${pointer}/${which}${row.parent}`) === undefined) return null;
  return isRange ? <RangeInput pointer={place} node={row.node} label={label} /> : <NumberInput pointer={place} node={row.node} label={label} />;
}

function PairRow({ pointer, row }) {
  const { unit } = nameAndUnit(row.key);
  return (
    <tr class={row.isGroup ? "group" : row.parent ? "inner" : ""}>
      <th scope="row" title={row.node.description}>
        {titleOf(row.key)}
        {unit && <small> {unit}</small>}
      </th>
      {GEARS.map((which) => (
        <td key={which}>
          <PairCell pointer={pointer} row={row} which={which} />
          <Faults pointer={`${pointer}/${which}${row.path}`} below={!row.isGroup} />
        </td>
      ))}
    </tr>
  );
}

// False for a row inside an object that neither gear has.
function isShown(document, pointer, row, ranges) {
  const isThere = (which) => getAt(document, `${pointer}/${which}${row.parent}`) !== undefined;
  return ranges || row.isGroup || !row.parent || GEARS.some(isThere);
}

// Pinion and gear side by side. Of bounds the groups need no switch: every number has its own.
function PairTable({ pointer, node }) {
  const { root, document } = useContext(FormContext);
  const all = rowsOf(root, resolve(root, node.properties.pinion));
  const ranges = all.some((row) => !row.isGroup && sortOf(root, row.node) === "range");
  const rows = all.filter((row) => isShown(document, pointer, row, ranges));
  return (
    <table class="pair">
      <thead>
        <tr>
          <th scope="col">
            <span class="unseen">Member</span>
          </th>
          <th scope="col">Pinion</th>
          <th scope="col">Gear</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((row) =>
          row.isGroup && ranges ? (
            <tr class="group" key={row.path}>
              <th scope="rowgroup" colSpan="3" title={row.node.description}>
                {titleOf(row.key)}
                {GEARS.map((which) => (
                  <Faults key={which} pointer={`${pointer}/${which}${row.path}`} />
                ))}
              </th>
            </tr>
          ) : (
            <PairRow key={row.path} pointer={pointer} row={row} />
          ),
        )}
      </tbody>
    </table>
  );
}

// The members of an object, in the order of the schema.
function Members({ pointer, node }) {
  const { root, rules } = useContext(FormContext);
  const pair = isPair(node);
  const members = Object.entries(node.properties).filter(
    ([key]) => !rules.hidden.has(`${pointer}/${key}`) && !(pair && GEARS.includes(key)),
  );
  const isInner = ([, member]) => ["object", "rows"].includes(sortOf(root, resolve(root, member)));
  const plain = members.filter((member) => !isInner(member));
  return (
    <>
      {plain.length > 0 && (
        <div class="fields">
          {plain.map(([key, member]) => (
            <Field key={key} pointer={`${pointer}/${key}`} node={resolve(root, member)} />
          ))}
        </div>
      )}
      {pair && <PairTable pointer={pointer} node={node} />}
      {members.filter(isInner).map(([key, member]) => (
        <Inner key={key} pointer={`${pointer}/${key}`} node={resolve(root, member)} />
      ))}
    </>
  );
}

function Inner({ pointer, node }) {
  const { root } = useContext(FormContext);
  return (
    <fieldset id={idOf(pointer)}>
      <legend title={node.description}>{titleOf(pointer.split("/").at(-1))}</legend>
      {sortOf(root, node) === "rows" ? <Rows pointer={pointer} node={node} /> : <Members pointer={pointer} node={node} />}
      <Faults pointer={pointer} />
    </fieldset>
  );
}

// A section: a member of the document that is an object or a table. One whose absence means something has a switch.
function Section({ pointer, node }) {
  const { root, document, rules } = useContext(FormContext);
  const isSwitched = rules.sometimes.has(pointer) && !rules.required.has(pointer);
  const isThere = getAt(document, pointer) !== undefined;
  const title = titleOf(pointer.slice(1));
  return (
    <section class="panel form-section" aria-labelledby={`${idOf(pointer)}-title`}>
      <h2 id={`${idOf(pointer)}-title`} title={node.description}>
        {isSwitched ? <Switch pointer={pointer} label={title} described={node.description} /> : title}
      </h2>
      {(!isSwitched || isThere) &&
        (sortOf(root, node) === "rows" ? <Rows pointer={pointer} node={node} /> : <Members pointer={pointer} node={node} />)}
      {sortOf(root, node) !== "rows" && <Faults pointer={pointer} />}
    </section>
  );
}

// The whole form.
export function Sections() {
  const { root, rules } = useContext(FormContext);
  const members = Object.entries(root.properties)
    .filter(([key]) => !rules.hidden.has(`/${key}`))
    .map(([key, member]) => ({ key, node: resolve(root, member) }));
  const isSection = ({ node }) => ["object", "rows"].includes(sortOf(root, node));
  const pairsFirst = (a, b) => Number(isPair(b.node)) - Number(isPair(a.node));
  return (
    <>
      <section class="panel form-section" aria-labelledby="field-job-title">
        <h2 id="field-job-title">Job</h2>
        <div class="fields">
          {members
            .filter((member) => !isSection(member))
            .map(({ key, node }) => (
              <Field key={key} pointer={`/${key}`} node={node} />
            ))}
        </div>
      </section>
      {members.filter(isSection).sort(pairsFirst).map(({ key, node }) => (
        <Section key={key} pointer={`/${key}`} node={node} />
      ))}
    </>
  );
}
