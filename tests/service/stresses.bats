#!/usr/bin/env bats
# Stresses in the result of a job: in their places, consistent with each other, the same with any number of threads, and the
# same whether a design was given or found.

setup() {
  : "${QG_SOURCE:=$(cd "$BATS_TEST_DIRNAME/../.." && pwd)}" "${QG_BUILD:=$QG_SOURCE}"
  quietgear=$QG_BUILD/quietgear
  examples=$QG_SOURCE/schema/examples
  cd "$BATS_TEST_TMPDIR"
}

@test "extremes are those of their curves, and stand where the pair can be stressed" {
  jq '.analysis = {mesh_positions: 20, speeds: {count: 10}}' "$examples/case_H_stresses.json" >job.json
  "$quietgear" run job.json -o result.json 2>/dev/null
  jq -e '. as $r | .design.load_cases | all(. as $c | ("pinion", "gear") | . as $g
         | $c.max_root_stress_mpa[$g] == ($c.root_stress_mpa[$g].tension | max)
           and $c.min_root_stress_mpa[$g] == ($c.root_stress_mpa[$g].compression | min)
           and ($c.root_stress_mpa[$g].tension | length) == 20
           and $c.max_root_stress_at[$g].radius_mm > $r.job.gear_pair[$g].root_radius_mm
           and $c.max_root_stress_at[$g].radius_mm < $r.geometry[$g].form_radius_mm
           and $c.max_root_stress_at[$g].angle_deg > 0 and $c.min_root_stress_at[$g].angle_deg < 0)' result.json
  jq -e '.design.load_cases | all((.contact_pressure_path.pressure_mpa | max) == .max_contact_pressure_mpa
           and (.contact_pressure_path.path_mm | . == sort)
           and (.contact_pressure_path | [.[] | length] | unique | length) == 1)' result.json
}

@test "the pressure of the parabolic optimum of case H is Hertz's, not a corner's: near the published 1400 MPa" {
  jq '.analysis.speeds = {count: 2}' "$examples/case_H_stresses.json" >job.json
  "$quietgear" run job.json -o result.json 2>/dev/null
  jq '.analysis.mesh_refinement = 2' job.json >fine.json
  "$quietgear" run fine.json -o fine_result.json 2>/dev/null
  jq -e -s '[.[].design.load_cases[2].max_contact_pressure_mpa] | .[0] / .[1] - 1 | fabs < 0.01' result.json fine_result.json
  jq -e '.design.load_cases[2].max_contact_pressure_mpa | . > 1330 and . < 1470' result.json
}

@test "ISO 6336 follows the torque" {
  jq '.analysis.speeds = {count: 2}' "$examples/case_S_none.json" >one.json
  jq '.gear_pair.nominal_torque_nm *= 2' one.json >two.json
  for job in one two; do "$quietgear" run $job.json -o ${job}_result.json 2>/dev/null; done
  jq -e -s 'map(.iso6336) | (.[1].root_stress_mpa.gear / .[0].root_stress_mpa.gear - 2 | fabs) < 1e-12
      and (.[1].contact_stress_mpa.pinion / .[0].contact_stress_mpa.pinion - (2 | sqrt) | fabs) < 1e-12
      and .[0].mesh_stiffness_n_per_mm == .[1].mesh_stiffness_n_per_mm' one_result.json two_result.json
}

@test "any number of threads, and a design found or given: the same bits" {
  jq '.optimizer |= (.random_samples = 16 | .simplex_iterations = 4) | .analysis = {speeds: {count: 20}} | del(.reliability)' \
    "$examples/case_S_optimize.json" >job.json
  "$quietgear" run --threads 1 job.json -o one.json 2>/dev/null
  "$quietgear" run --threads 3 job.json -o three.json 2>/dev/null
  stresses='.load_cases | map({max_root_stress_mpa, root_stress_mpa, contact_pressure_path})'
  for result in one three; do jq -S "[.design, .reference | $stresses]" $result.json >$result.stresses; done
  cmp one.stresses three.stresses
  jq '{kind: "evaluate", gear_pair, load_cases, analysis}' job.json >given.json
  jq --slurpfile r one.json '.relief = $r[0].design.relief' given.json >again.json
  "$quietgear" run again.json -o again_result.json 2>/dev/null
  cmp <(jq -S ".design | $stresses" one.json) <(jq -S ".design | $stresses" again_result.json)
}
