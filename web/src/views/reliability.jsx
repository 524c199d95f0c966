// How a design stands manufacturing errors: trials against the limit, and which tolerance costs what.
import { useMemo } from "preact/hooks";
import { histogramOf, reliabilityFigure } from "../figures/search.js";
import { fixed, nameAndUnit, percent, plain, significant } from "../format.js";
import { Panel } from "../parts/parts.jsx";
import { Plot } from "../plots/plot.jsx";

// The figure from the result, or from the trials so far; null when there are none.
export function makeReliabilityFigure(result, evaluations, document) {
  const limit = document?.reliability?.limit_f_dte;
  const reliability = result?.reliability;
  if (limit === undefined || limit === null) return null;
  if (reliability)
    return reliabilityFigure({ histogram: reliability.histogram, reliability, limit, trials: reliability.samples });
  const trials = evaluations.filter((one) => one.phase === "reliability" && one.f_dte !== null).map((one) => one.f_dte);
  return trials.length ? reliabilityFigure({ histogram: histogramOf(trials), limit, trials: trials.length }) : null;
}

export function ReliabilityNumbers({ reliability, limit }) {
  const rows = [
    ["Trials", fixed(reliability.samples)],
    [`F_DTE above the limit of ${plain(limit)} b`, fixed(reliability.failures)],
    ["Probability of failure", percent(reliability.probability_of_failure, 1)],
    ["95 % confidence interval", reliability.confidence_95.map((share) => percent(share, 1)).join(" to ")],
    [
      "Mean, standard deviation, b",
      `${significant(reliability.mean_f_dte)}, ${significant(reliability.standard_deviation_f_dte, 3)}`,
    ],
    ["Least, greatest, b", `${significant(reliability.min_f_dte)}, ${significant(reliability.max_f_dte)}`],
  ];
  return (
    <table class="plain">
      <caption class="unseen">Reliability in numbers</caption>
      <tbody>
        {rows.map(([name, value]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            <td class="number">{value}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function VarianceShares({ shares }) {
  const entries = Object.entries(shares);
  if (entries.length === 0) return null;
  return (
    <table class="plain bars">
      <caption>Which tolerance costs what: share of the variance of F_DTE</caption>
      <tbody>
        {entries.map(([parameter, share]) => (
          <tr key={parameter}>
            <th scope="row">{nameAndUnit(parameter).text}</th>
            <td class="meter">
              <meter
                min="0"
                max="1"
                value={Math.max(0, share)}
                aria-label={`${nameAndUnit(parameter).text}: ${percent(share, 1)}`}
              />
            </td>
            <td class="number">{percent(share, 1)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function ReliabilityPanel({ result, evaluations, document, name }) {
  const figure = useMemo(() => makeReliabilityFigure(result, evaluations, document), [result, evaluations, document]);
  if (!figure) return null;
  return (
    <>
      <Panel title={figure.title}>
        <Plot figure={figure} name={name} height={300} />
      </Panel>
      {result?.reliability && (
        <Panel title="Tolerances">
          <ReliabilityNumbers reliability={result.reliability} limit={document.reliability.limit_f_dte} />
          <VarianceShares shares={result.reliability.variance_shares} />
        </Panel>
      )}
    </>
  );
}
