// Designs as the figures take them, out of a result or out of the response of a running job:
//   {key, name, role, design: as in a result, halfBacklash: µm, pinionTeeth}

// The frequency response of a running job in the form that designs have in a result.
function designOfResponse(response, which) {
  const side = response[which];
  if (!side) return null;
  const load_cases = side.load_cases.map((loadCase) => ({
    torque_nm: loadCase.torque_nm,
    natural_frequency_hz: loadCase.natural_frequency_hz,
    frequency_response: { frequency_ratio: response.frequency_ratio, rms: loadCase.rms, period: loadCase.period },
  }));
  return { f_dte: side.f_dte, load_cases };
}

function teethOfResponse(response, which) {
  const [first] = response[which].load_cases;
  return Math.round((first.natural_frequency_hz * 60 * response.frequency_ratio[0]) / first.pinion_rpm[0]);
}

// What a design's figures are to be read by: half-backlash in µm, and the pinion's teeth. A macro search's design is another
// pair than the reference, of a backlash that older results do not tell.
export function scalesOf(result, which) {
  const found = which === "design" ? result.macro?.candidates[result.macro.best] : null;
  const { geometry, gear_pair } = found || { geometry: result.geometry, gear_pair: result.job.gear_pair };
  return { halfBacklash: geometry ? geometry.backlash_mm * 500 : null, pinionTeeth: gear_pair.pinion.teeth };
}

// The designs on show of a result: the design, and the reference where it is another one.
export function designsOfResult(result) {
  const designs = [];
  if (result.reference)
    designs.push({
      key: "reference",
      name: "reference",
      role: "reference",
      design: result.reference,
      ...scalesOf(result, "reference"),
    });
  if (result.design)
    designs.push({
      key: "design",
      name: result.reference ? "best" : "design",
      role: "design",
      design: result.design,
      ...scalesOf(result, "design"),
    });
  return designs;
}

// The same while the job still runs.
export function designsOfResponse(response) {
  if (!response || !(response.design || response.reference)) return [];
  const scales = (which) => ({
    halfBacklash: response[which].half_backlash_um,
    pinionTeeth: teethOfResponse(response, which),
  });
  return ["reference", "design"].flatMap((which) => {
    const design = designOfResponse(response, which);
    return design
      ? [{ key: which, name: which === "design" ? "best so far" : "reference", role: which, design, ...scales(which) }]
      : [];
  });
}
