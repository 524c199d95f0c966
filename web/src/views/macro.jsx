// What a search over macro-geometry found: the pairs kept, each as the start of a new job, and what the others failed by.
import { useMemo } from "preact/hooks";
import { macroFigure } from "../figures/search.js";
import { startFrom } from "../form/draft.js";
import { fixed, plain } from "../format.js";
import { LongTable, numberColumn as number } from "../parts/long-table.jsx";
import { Panel } from "../parts/parts.jsx";
import { Plot } from "../plots/plot.jsx";
import { go } from "../router.js";

// A job that judges one of the pairs as the search did.
export function jobOfPair(candidate, job) {
  return {
    kind: "evaluate",
    name: `${job.name || "macro search"}: sample ${candidate.sample}`,
    gear_pair: candidate.gear_pair,
    load_cases: job.load_cases,
    analysis: job.analysis,
  };
}

function columnsOf(job) {
  const use = (row) => {
    startFrom(jobOfPair(row, job), `sample ${row.sample}`);
    go("new");
  };
  return [
    number("sample", "Sample", (row) => row.sample, 0),
    {
      key: "teeth",
      head: "Teeth",
      isNumber: true,
      value: (row) => row.gear_pair.pinion.teeth,
      text: (row) => `${row.gear_pair.pinion.teeth}/${row.gear_pair.gear.teeth}`,
    },
    number("module", "Module, mm", (row) => row.gear_pair.module_mm, 4),
    number("angle", "Angle, °", (row) => row.gear_pair.pressure_angle_deg, 2),
    number("backlash", "Backlash, mm", (row) => row.geometry?.backlash_mm, 4),
    number("ratio", "Contact ratio", (row) => row.contact_ratio, 4),
    number("loaded", "under load", (row) => row.loaded_contact_ratio, 3),
    number("contact", "Contact stress, ×", (row) => row.contact_stress_factor, 3),
    number("root", "Root stress, ×", (row) => row.root_stress_factor, 3),
    number("f_dte", "F_DTE, b", (row) => row.f_dte, 4),
    number("f_pps", "F_PPS, µm", (row) => row.f_pps_um, 2),
    number("pressure", "Pressure, MPa", (row) => row.max_contact_pressure_mpa, 0),
    number("tension", "Root tension, MPa", (row) => row.max_root_stress_mpa, 0),
    {
      key: "use",
      head: "Job",
      value: () => 0,
      text: (row) => (
        <button type="button" class="quiet" onClick={() => use(row)} aria-label={`Use sample ${row.sample} as new job`}>
          Use
        </button>
      ),
    },
  ];
}

function Rejections({ macro }) {
  const rows = macro.rejected.filter(({ count }) => count > 0);
  return (
    <table class="plain">
      <caption class="unseen">Samples by the first constraint that they fail</caption>
      <tbody>
        <tr>
          <th scope="row">Samples</th>
          <td class="number">{fixed(macro.samples)}</td>
        </tr>
        {rows.map(({ constraint, count }) => (
          <tr key={constraint}>
            <th scope="row">fail by {constraint.replaceAll("_", " ")}</th>
            <td class="number">{fixed(count)}</td>
          </tr>
        ))}
        <tr>
          <th scope="row">
            <b>satisfy all</b>
          </th>
          <td class="number">
            <b>{fixed(macro.passed)}</b>
          </td>
        </tr>
      </tbody>
    </table>
  );
}

export function MacroPanels({ result, name }) {
  const { macro, job } = result;
  const figure = useMemo(() => macroFigure(macro), [macro]);
  const columns = useMemo(() => columnsOf(job), [job]);
  const best = macro.best === null ? null : macro.candidates[macro.best];
  return (
    <>
      <Panel
        title={figure.title}
        note={`initial pair: contact ratio ${plain(Number(macro.initial.contact_ratio.toFixed(4)))}`}
      >
        <Plot figure={figure} name={name} height={320} />
      </Panel>
      <Panel title="Constraints">
        <Rejections macro={macro} />
      </Panel>
      {macro.candidates.length > 0 && (
        <Panel title="Gear pairs found" note={`${fixed(macro.candidates.length)} kept`} wide>
          <LongTable
            caption="Gear pairs found; stresses by ISO 6336 as multiples of the initial pair's"
            columns={columns}
            rows={macro.candidates}
            rowKey={(row) => row.sample}
            marked={(row) => row === best}
            first={{ key: "f_dte", down: false }}
          />
        </Panel>
      )}
    </>
  );
}
