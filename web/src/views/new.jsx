// The form of a new job: the form, the drawing of what it describes and its JSON, all of one draft.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { drawDxf, getDocument, getExample, getSchema, listExamples, submitJob } from "../api.js";
import { nameIn } from "../drawings/files.js";
import { ReliefDrawing } from "../drawings/relief.jsx";
import { TeethDrawing } from "../drawings/teeth.jsx";
import { drawable, useChecked } from "../form/check.js";
import { draft, startFrom, startFromText } from "../form/draft.js";
import { Editor } from "../form/editor.jsx";
import { FormContext, idOf } from "../form/fields.jsx";
import { rulesFor } from "../form/schema.js";
import { Sections } from "../form/sections.jsx";
import { fixed, jobTitle } from "../format.js";
import { jobs } from "../jobs.js";
import { Panel, complain, useLoaded } from "../parts/parts.jsx";
import { download } from "../plots/picture.js";
import { go, replaceQuery } from "../router.js";
import { useStore } from "../store.js";

const FIRST_EXAMPLE = "case_S_optimize";
const FILE_BYTES_MOST = 1 << 20;

// ---- where the document comes from ----

// source: "example:NAME", or the id of a job.
async function startFromSource(source) {
  const name = source.replace(/^example:/, "");
  const job = jobs.get().byId.get(name);
  if (name !== source) startFrom(await getExample(name), `example ${name}`);
  else startFrom(await getDocument(name), `job ${job ? jobTitle(job) : name}`);
}

async function startFromFile(file) {
  if (file.size > FILE_BYTES_MOST) complain({ message: `${file.name} is larger than a document may be: 1 MB` });
  else startFromText(await file.text(), file.name);
}

function Sources() {
  const { value } = useLoaded(listExamples, []);
  const { byId } = useStore(jobs);
  const past = [...byId.values()].sort((a, b) => (a.submitted_at < b.submitted_at ? 1 : -1)).slice(0, 50);
  const file = useRef(null);
  const choose = (event) => {
    if (event.target.value) startFromSource(event.target.value).catch(complain);
    event.target.value = "";
  };
  return (
    <div class="filters">
      <label>
        Start from
        <select class="start" onChange={choose}>
          <option value="">…</option>
          <optgroup label="Examples">
            {(value?.examples || []).map((example) => (
              <option key={example.name} value={`example:${example.name}`}>
                {example.kind}: {example.title || example.name}
              </option>
            ))}
          </optgroup>
          {past.length > 0 && (
            <optgroup label="Past jobs">
              {past.map((job) => (
                <option key={job.id} value={job.id}>
                  {job.kind}: {jobTitle(job)}
                </option>
              ))}
            </optgroup>
          )}
        </select>
      </label>
      <button type="button" onClick={() => file.current.click()}>
        Open file…
      </button>
      <input
        ref={file}
        type="file"
        accept=".json,application/json"
        hidden
        onChange={(event) => event.target.files[0] && startFromFile(event.target.files[0]).catch(complain)}
      />
    </div>
  );
}

// Files may be dropped anywhere on the view.
function useDrop() {
  const [isOver, setOver] = useState(false);
  const hasFile = (event) => event.dataTransfer?.types.includes("Files");
  return {
    isOver,
    handlers: {
      onDragOver: (event) => {
        if (!hasFile(event)) return;
        event.preventDefault();
        setOver(true);
      },
      onDragLeave: (event) => event.currentTarget.contains(event.relatedTarget) || setOver(false),
      onDrop: (event) => {
        setOver(false);
        if (!hasFile(event)) return;
        event.preventDefault();
        startFromFile(event.dataTransfer.files[0]).catch(complain);
      },
    },
  };
}

// ---- the server's words ----

function goTo(pointer) {
  for (let place = pointer; place; place = place.slice(0, place.lastIndexOf("/"))) {
    const field = document.getElementById(idOf(place)) || document.querySelector(`[data-pointer="${CSS.escape(place)}"]`);
    if (!field) continue;
    field.scrollIntoView({ block: "center" });
    field.focus();
    return;
  }
}

function Remarks({ remarks, kind }) {
  return (
    <ul class={`remarks ${kind}`}>
      {remarks.map(({ pointer, detail }) => (
        <li key={pointer + detail}>
          <button type="button" class="quiet pointer" onClick={() => goTo(pointer)}>
            {pointer || "document"}
          </button>{" "}
          {detail}
        </li>
      ))}
    </ul>
  );
}

function Verdict({ checked, error }) {
  const { state, errors, warnings, problem } = checked;
  const count = errors.length;
  const words = {
    waiting: "checking…",
    valid: warnings.length ? "can be run, with remarks" : "can be run",
    invalid: `${count} ${count === 1 ? "fault" : "faults"}`,
    unknown: problem?.message || "not checked",
  };
  const isBad = error || state === "invalid" || state === "unknown";
  return (
    <div class="verdict" role="status">
      <p class={isBad ? "bad" : state === "valid" ? "good" : ""}>{error ? "the JSON is broken" : words[state]}</p>
      {!error && count > 0 && <Remarks remarks={errors} kind="faults" />}
      {!error && warnings.length > 0 && <Remarks remarks={warnings} kind="warnings" />}
    </div>
  );
}

function Figures({ geometry }) {
  const rows = [
    ["contact ratio", fixed(geometry.contact_ratio, 3), ""],
    ["working pressure angle", fixed(geometry.working_pressure_angle_deg, 3), "°"],
    ["backlash", fixed(geometry.backlash_mm, 4), "mm"],
    ["path of contact", fixed(geometry.path_length_mm, 3), "mm"],
    ["form radius, pinion", fixed(geometry.pinion.form_radius_mm, 3), "mm"],
    ["form radius, gear", fixed(geometry.gear.form_radius_mm, 3), "mm"],
    ["tip clearance, pinion", fixed(geometry.pinion.tip_clearance_mm, 3), "mm"],
    ["tip clearance, gear", fixed(geometry.gear.tip_clearance_mm, 3), "mm"],
    ["tip thickness, pinion", fixed(geometry.pinion.tip_thickness_mm, 3), "mm"],
    ["tip thickness, gear", fixed(geometry.gear.tip_thickness_mm, 3), "mm"],
  ];
  return (
    <dl class="derived">
      {rows.map(([name, value, unit]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd class="number">
            {value} <small>{unit}</small>
          </dd>
        </div>
      ))}
    </dl>
  );
}

// ---- the drawings ----

async function saveDxf(document, extent, position) {
  const design = drawable(document).find((part) => !part.kind);
  const response = await drawDxf(design, { extent, position });
  download(nameIn(response, `${extent}.dxf`), await response.blob());
}

function Drawings({ checked, document }) {
  const { profile, isOld, geometry } = checked;
  const [position, setPosition] = useState(0.5);
  if (!profile) return <p class="empty">The drawing waits for a pair that can be made.</p>;
  const name = document.name || "pair";
  const save = (extent) => saveDxf(document, extent, position).catch(complain);
  return (
    <>
      <Panel title="Teeth in mesh" note={isOld ? "of the last pair that could be made" : "true scale"}>
        <TeethDrawing profile={profile} isOld={isOld} onPosition={setPosition} name={name} />
        <p class="buttons">
          <button type="button" disabled={isOld} onClick={() => save("gears")}>
            DXF, both gears
          </button>
          <button type="button" disabled={isOld} onClick={() => save("spaces")}>
            DXF, tooth spaces
          </button>
        </p>
      </Panel>
      <Panel title="Relief" note="profile diagram: what is removed, normal to the involute">
        <ReliefDrawing profile={profile} isOld={isOld} name={name} />
      </Panel>
      {geometry && (
        <Panel title="What follows">
          <Figures geometry={geometry} />
        </Panel>
      )}
    </>
  );
}

// ---- the view ----

// A key for each text, so that a repeated attempt is the same job.
function useKey(text) {
  return useMemo(() => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join(""), [text]);
}

function useSubmit(text) {
  const key = useKey(text);
  const [isBusy, setBusy] = useState(false);
  const submit = async () => {
    setBusy(true);
    try {
      const job = await submitJob(text, key);
      go("jobs", job.id);
    } catch (problem) {
      complain(problem);
    }
    setBusy(false);
  };
  return { isBusy, submit };
}

// The first document: what the address asks for, an earlier draft, or an example.
function useStart(query) {
  const from = query.get("from");
  useEffect(() => {
    const source = from || (draft.get().text ? "" : `example:${FIRST_EXAMPLE}`);
    if (source) startFromSource(source).catch(complain);
    if (from) replaceQuery({});
  }, [from]);
}

function Headline({ origin, isReady, submit }) {
  return (
    <div class="headline">
      <h1>New job</h1>
      <Sources />
      {origin && <small>from {origin}</small>}
      <span class="spread" />
      <button type="button" class="primary" disabled={!isReady} onClick={submit} title="Ctrl+Enter">
        Start the job
      </button>
    </div>
  );
}

export function NewJob({ query }) {
  useStart(query);
  const { text, document, error, origin } = useStore(draft);
  const { value: root, error: schemaError } = useLoaded((signal) => getSchema("job.schema.json", signal), []);
  const checked = useChecked({ text, document, error });
  const { isBusy, submit } = useSubmit(text);
  const { isOver, handlers } = useDrop();
  const rules = useMemo(() => root && rulesFor(root, document?.kind), [root, document?.kind]);
  const isReady = checked.state === "valid" && checked.checked === text && !isBusy && !error;
  const context = { root, document, errors: error ? [] : checked.errors, geometry: checked.geometry, rules };
  const onKeyDown = (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey) && isReady) submit();
  };
  return (
    <div class={`new-job ${isOver ? "drop" : ""}`} {...handlers} onKeyDown={onKeyDown}>
      <Headline origin={origin} isReady={isReady} submit={submit} />
      {schemaError && <p class="bad">{schemaError.message}</p>}
      {document && root && (
        <div class="workbench">
          <form class="job-form" aria-label="Job" onSubmit={(event) => event.preventDefault()}>
            <FormContext.Provider value={context}>
              <Sections />
            </FormContext.Provider>
          </form>
          <div class="side">
            <div class="drawings">
              <Drawings checked={checked} document={document} />
            </div>
            <div class="source">
              <Panel title="Check">
                <Verdict checked={checked} error={error} />
              </Panel>
              <Panel title="JSON" note="in step with the form; files may be dropped anywhere">
                <Editor text={text} error={error} />
              </Panel>
            </div>
          </div>
        </div>
      )}
    </div>
  );
}
