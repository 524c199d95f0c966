// The report of a finished job, for paper: input, result, plots, reliability, version. Pictures are SVG, sharp at any size.
import { useEffect, useMemo, useRef } from "preact/hooks";
import {
  loadShareFigure,
  pressureFigure,
  responseFigure,
  rootStressFigure,
  stiffnessFigure,
  torqueText,
  transmissionErrorFigure,
} from "../figures/curves.js";
import { designsOfResult } from "../figures/designs.js";
import { chosenOf, historyFigure, macroFigure, objectivesOf, mapFigure, paretoFigure } from "../figures/search.js";
import { OBJECTIVES, duration, fixed, jobTitle, localTime, percent, plain, significant } from "../format.js";
import { ReliefTable } from "../parts/relief-table.jsx";
import { StandardTable } from "../parts/standard-table.jsx";
import { figureSvg } from "../plots/picture.js";
import { href } from "../router.js";
import { JobRelief } from "./job-drawings.jsx";
import { ReliabilityNumbers, VarianceShares, makeReliabilityFigure } from "./reliability.jsx";

// A figure as SVG.
export function StaticFigure({ figure, width = 700, height = 330 }) {
  const holder = useRef(null);
  useEffect(() => holder.current.replaceChildren(figureSvg(figure, { size: { width, height } })), [figure]);
  return <figure class="static" ref={holder} />;
}

function Rows({ caption, rows }) {
  return (
    <table class="plain">
      <caption>{caption}</caption>
      <tbody>
        {rows.map(([name, ...values]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {values.map((value, i) => (
              <td class="number" key={i}>
                {value}
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function PairTable({ pair, geometry }) {
  const both = (name, key, digits, from = "pair") => {
    const pick = (gear) => (from === "pair" ? pair[gear][key] : geometry[gear][key]);
    return [name, fixed(pick("pinion"), digits), fixed(pick("gear"), digits)];
  };
  return (
    <table class="plain">
      <caption>Gears</caption>
      <thead>
        <tr>
          <th scope="col">
            <span class="unseen">Quantity</span>
          </th>
          <th scope="col" class="number">
            Pinion
          </th>
          <th scope="col" class="number">
            Gear
          </th>
        </tr>
      </thead>
      <tbody>
        {[
          both("Teeth", "teeth", 0),
          both("Profile shift, mm", "profile_shift_mm", 3),
          both("Outside radius, mm", "outside_radius_mm", 3),
          both("Root radius, mm", "root_radius_mm", 3),
          both("Bore diameter, mm", "bore_diameter_mm", 1),
          both("Face width, mm", "face_width_mm", 1),
          both("Base radius, mm", "base_radius_mm", 4, "geometry"),
          both("Form radius, mm", "form_radius_mm", 4, "geometry"),
        ].map(([name, pinion, gear]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            <td class="number">{pinion}</td>
            <td class="number">{gear}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function inputRows({ job, geometry }) {
  const { gear_pair: pair, analysis } = job;
  const { speeds } = analysis;
  return [
    ["Module, mm", plain(pair.module_mm)],
    ["Pressure angle, °", plain(pair.pressure_angle_deg)],
    ["Center distance, mm", fixed(pair.center_distance_mm, 3)],
    ["Contact ratio", fixed(geometry.contact_ratio, 3)],
    ["Normal backlash, mm", fixed(geometry.backlash_mm, 4)],
    ["Nominal torque on the pinion, N m", plain(pair.nominal_torque_nm)],
    ["Young's modulus, MPa", fixed(pair.material.youngs_modulus_mpa)],
    ["Damping ratio", plain(pair.damping_ratio)],
    ["Mesh stiffness", analysis.mesh_stiffness.replace("_", " ")],
    ["Branch of the response", analysis.branch.replace("_", " ")],
    ["Frequency ratios", `${plain(speeds.min)} to ${plain(speeds.max)}, ${fixed(speeds.count)} speeds`],
  ];
}

// The objectives judged again at more mesh positions.
function verifiedRows({ mesh_positions: positions, reference, design, improvement }) {
  const row = (name, unit, key, digits, change) => ({
    name: `${name} at ${positions} mesh positions, ${unit}`,
    before: reference[key],
    after: design[key],
    digits,
    change,
  });
  const rows = [row("F_PPS", "µm", "f_pps_um", 2, improvement.f_pps_percent)];
  if (design.f_dte !== null) rows.unshift(row("F_DTE", "b", "f_dte", 4, improvement.f_dte_percent));
  return rows;
}

function ResultTable({ result }) {
  const { design, reference, improvement } = result;
  const row = (name, unit, key, digits, change) => ({
    name: `${name}, ${unit}`,
    before: reference?.[key],
    after: design[key],
    digits,
    change,
  });
  const rows = [
    row("F_DTE, largest RMS of the dynamic transmission error", "b", "f_dte", 4, improvement?.f_dte_percent),
    row(
      "F_PPS, largest peak to peak of the static transmission error",
      "µm",
      "f_pps_um",
      2,
      improvement?.f_pps_percent,
    ),
  ];
  if (design.f_dte_percentile != null)
    rows.push(
      row(
        `F_DTE that ${result.job.reliability.percentile} % of trials under manufacturing errors stay below`,
        "b",
        "f_dte_percentile",
        4,
        improvement?.f_dte_percentile_percent,
      ),
    );
  if (result.verification) rows.push(...verifiedRows(result.verification));
  return (
    <table class="plain">
      <caption>Result</caption>
      <thead>
        <tr>
          <th scope="col">Objective</th>
          {reference && (
            <th scope="col" class="number">
              Reference
            </th>
          )}
          <th scope="col" class="number">
            Design
          </th>
          {reference && (
            <th scope="col" class="number">
              Lower by
            </th>
          )}
        </tr>
      </thead>
      <tbody>
        {rows.map(({ name, before, after, digits, change }) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {reference && <td class="number">{fixed(before, digits)}</td>}
            <td class="number">
              <b>{fixed(after, digits)}</b>
            </td>
            {reference && (
              <td class="number">{change === null || change === undefined ? "–" : `${fixed(change, 1)} %`}</td>
            )}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function LoadCaseTable({ design }) {
  return (
    <table class="plain">
      <caption>Load cases of the design</caption>
      <thead>
        <tr>
          {[
            "Torque, N m",
            "Peak to peak, µm",
            "Mean stiffness, N/µm",
            "Contact ratio under load",
            "Pressure, MPa",
            "Natural frequency, Hz",
            "Largest RMS, b",
            "at, rpm",
          ].map((head) => (
            <th scope="col" class="number" key={head}>
              {head}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {design.load_cases.map((one, i) => (
          <tr key={i}>
            {[
              significant(one.torque_nm),
              fixed(one.pps_um, 2),
              fixed(one.mean_mesh_stiffness_n_per_mm / 1000, 1),
              fixed(one.loaded_contact_ratio, 3),
              fixed(one.max_contact_pressure_mpa),
              fixed(one.natural_frequency_hz),
              fixed(one.max_rms, 4),
              fixed(one.max_rms_at_pinion_rpm),
            ].map((value, k) => (
              <td class="number" key={k}>
                {value}
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function figuresOf({ job, result, evaluations, document }) {
  const designs = designsOfResult(result);
  const objective = job.objective || "f_dte";
  const figures = [];
  if (designs.some(({ design }) => design.f_dte !== null)) figures.push(responseFigure(designs));
  figures.push(
    transmissionErrorFigure(designs),
    stiffnessFigure(designs),
    loadShareFigure(designs),
    pressureFigure(designs),
  );
  const roots = rootStressFigure(designs);
  if (roots) figures.push(roots);
  if (job.kind === "optimize" && evaluations.length > 1) figures.push(historyFigure(evaluations, objective));
  if (result.map)
    figures.push(
      ...["f_dte", "f_pps"]
        .filter((one) => one === "f_pps" || result.design.f_dte !== null)
        .map((one) => mapFigure(result.map, one)),
    );
  if (result.search?.pareto)
    figures.push(paretoFigure(result.search.pareto, evaluations, objectivesOf(result), chosenOf(result)));
  if (result.macro) figures.push(macroFigure(result.macro));
  const reliability = makeReliabilityFigure(result, evaluations, document);
  if (reliability) figures.push(reliability);
  return figures;
}

function Origin({ job, result }) {
  const { optimizer, reliability } = result.job;
  return (
    <p>
      quietgear {result.version} · job {job.id} · {result.job.kind}
      {optimizer && (
        <>
          {" "}
          · seed {optimizer.seed}, {fixed(optimizer.random_samples)} samples, {fixed(optimizer.simplex_iterations)}{" "}
          simplex iterations at most
        </>
      )}
      {reliability && <> · trials with seed {reliability.seed}</>} · finished {localTime(job.finished_at)} ·{" "}
      {duration(result.timing.wall_s)}. The same document and version give the same numbers to the last bit.
    </p>
  );
}

export function Report({ data }) {
  const { job, result } = data;
  const figures = useMemo(() => (result.design ? figuresOf(data) : []), [result, data.evaluations]);
  const designs = designsOfResult(result);
  const objective = OBJECTIVES[result.job.objective || "f_dte"];
  return (
    <article class="sheets">
      <p class="buttons unprinted">
        <a class="button" href={href("jobs", job.id)}>
          Back
        </a>
        <button type="button" class="primary" onClick={() => print()}>
          Print or save as PDF
        </button>
      </p>
      <header>
        <h1>{jobTitle(job)}</h1>
        <p>
          {result.job.gear_pair.name || "Spur gear pair"}, {result.job.gear_pair.pinion.teeth}/
          {result.job.gear_pair.gear.teeth} teeth, module {plain(result.job.gear_pair.module_mm)} mm, at{" "}
          {result.design?.load_cases.map((one) => torqueText(one.torque_nm)).join(", ")}
          {job.kind === "optimize" && (
            <>
              ; optimized for {objective.name}, {objective.long}
            </>
          )}
        </p>
      </header>
      {result.design && <ResultTable result={result} />}
      {result.design && <ReliefTable designs={designs} />}
      {result.design && <JobRelief job={job} hasReference={Boolean(result.reference)} />}
      {figures.slice(0, 1).map((figure) => (
        <StaticFigure figure={figure} key={figure.id} height={380} />
      ))}
      {result.design && <LoadCaseTable design={result.design} />}
      {result.design && result.iso6336 && <StandardTable iso={result.iso6336} design={result.design} />}
      {result.reliability && (
        <section>
          <h2>Reliability</h2>
          <p>
            Probability that F_DTE exceeds {plain(result.job.reliability.limit_f_dte)} b under manufacturing errors:{" "}
            <b>{percent(result.reliability.probability_of_failure, 1)}</b>, 95 % confidence{" "}
            {result.reliability.confidence_95.map((share) => percent(share, 1)).join(" to ")}.
          </p>
          <ReliabilityNumbers reliability={result.reliability} limit={result.job.reliability.limit_f_dte} />
          <VarianceShares shares={result.reliability.variance_shares} />
        </section>
      )}
      <section class="figures">
        {figures.slice(1).map((figure) => (
          <StaticFigure figure={figure} key={figure.id} />
        ))}
      </section>
      <section class="input">
        <h2>Input</h2>
        <Rows caption="Pair and analysis" rows={inputRows(result)} />
        <PairTable pair={result.job.gear_pair} geometry={result.geometry} />
      </section>
      {result.warnings.length > 0 && (
        <section>
          <h2>Warnings</h2>
          <ul>
            {result.warnings.map((warning) => (
              <li key={warning}>{warning}</li>
            ))}
          </ul>
        </section>
      )}
      <footer>
        <Origin job={job} result={result} />
      </footer>
    </article>
  );
}
