// The few figures of a result that matter most, before and after.
import { torqueText } from "../figures/curves.js";
import { fixed, percent, significant } from "../format.js";

function Change({ percent: change }) {
  if (change === null || change === undefined) return null;
  const isBetter = change >= 0;
  return (
    <small class={isBetter ? "good" : "bad"}>
      {isBetter ? "▼" : "▲"} {fixed(Math.abs(change), 1)} %
    </small>
  );
}

function KeyFigure({ name, unit, before, value, change, title }) {
  return (
    <div class="key" title={title}>
      <dt>{name}</dt>
      <dd class="number">
        {before !== undefined && <span class="before">{before} → </span>}
        <b>{value}</b> <small>{unit}</small>
        {change !== undefined && <Change percent={change} />}
      </dd>
    </div>
  );
}

// The objective judged again at more mesh positions, which flatter an optimized design less.
function Verified({ job, verification }) {
  const { mesh_positions: positions, reference, design, improvement } = verification;
  const isStatic = job.objective === "f_pps" || design.f_dte === null;
  const [key, digits] = isStatic ? ["f_pps_um", 2] : ["f_dte", 4];
  return (
    <KeyFigure
      name={`${isStatic ? "F_PPS" : "F_DTE"} at ${positions} positions`}
      title={`Reference and design judged once more at ${positions} mesh positions instead of ${job.analysis.mesh_positions}`}
      unit={isStatic ? "µm" : "b"}
      before={fixed(reference[key], digits)}
      value={fixed(design[key], digits)}
      change={isStatic ? improvement.f_pps_percent : improvement.f_dte_percent}
    />
  );
}

export function KeyFigures({ result }) {
  const { design, reference, improvement, reliability } = result;
  if (!design) return null;
  const worst = design.load_cases.reduce((most, one) => ((one.max_rms ?? -1) > (most.max_rms ?? -1) ? one : most));
  const pressure = Math.max(...design.load_cases.map((one) => one.max_contact_pressure_mpa));
  return (
    <dl class="keys">
      {design.f_dte !== null && (
        <KeyFigure
          name="F_DTE"
          title="Largest RMS of the dynamic transmission error over all load cases and speeds, in half-backlashes"
          unit="b"
          before={reference ? fixed(reference.f_dte, 4) : undefined}
          value={fixed(design.f_dte, 4)}
          change={improvement?.f_dte_percent}
        />
      )}
      <KeyFigure
        name="F_PPS"
        title="Largest peak to peak of the static transmission error over all load cases"
        unit="µm"
        before={reference ? fixed(reference.f_pps_um, 2) : undefined}
        value={fixed(design.f_pps_um, 2)}
        change={improvement?.f_pps_percent}
      />
      {result.verification && <Verified job={result.job} verification={result.verification} />}
      {design.f_dte_percentile != null && (
        <KeyFigure
          name={`F_DTE, ${result.job.reliability.percentile} % of trials`}
          title="What F_DTE stays below in this share of trials under manufacturing errors"
          unit="b"
          before={reference ? fixed(reference.f_dte_percentile, 4) : undefined}
          value={fixed(design.f_dte_percentile, 4)}
          change={improvement?.f_dte_percentile_percent}
        />
      )}
      {reliability && (
        <KeyFigure
          name="Failures"
          title="Probability that F_DTE is above the limit under manufacturing errors, with its 95 % confidence interval"
          unit={`95 %: ${fixed(100 * reliability.confidence_95[0], 1)} to ${fixed(100 * reliability.confidence_95[1], 1)} %`}
          value={percent(reliability.probability_of_failure, 1)}
        />
      )}
      {worst.max_rms_at !== null && (
        <KeyFigure
          name="Worst speed"
          title={`At ${torqueText(worst.torque_nm)}, frequency ratio ${significant(worst.max_rms_at)}`}
          unit={`rpm at ${torqueText(worst.torque_nm)}`}
          value={fixed(worst.max_rms_at_pinion_rpm)}
        />
      )}
      <KeyFigure name="Contact pressure" unit="MPa" value={fixed(pressure)} />
      {design.load_cases[0].max_root_stress_mpa && (
        <KeyFigure
          name="Root stress"
          title="Largest tension in the tooth roots of pinion and gear over all load cases"
          unit="MPa"
          value={["pinion", "gear"]
            .map((gear) => fixed(Math.max(...design.load_cases.map((one) => one.max_root_stress_mpa[gear]))))
            .join(" / ")}
        />
      )}
    </dl>
  );
}
