#!/usr/bin/env bats
# Macro-geometry searches: from case S to pairs of a contact ratio above 2 with no more stress, which can be posted as
# optimizations; the same bits for any threads, through the daemon, and after being killed.

load helper

setup_file() {
  start_for_file --threads 2
  # Ranges about what a billion samples of the example find, and few speeds.
  jq -c '.macro.samples = 40000000 | .macro.keep = 3 | .analysis.speeds = {min: 0.4, max: 1.2, count: 40}
         | .macro.ranges.module_mm = [1.8, 2.4] | .macro.ranges.pressure_angle_deg = [14, 20]
         | .macro.ranges.pinion.teeth = [38, 47] | .macro.ranges.gear.teeth = [58, 72]' \
    "$QG_SOURCE/schema/examples/case_S_macro.json" >"$BATS_FILE_TMPDIR/macro.json"
  "$QG_BUILD/quietgear" run "$BATS_FILE_TMPDIR/macro.json" -o "$BATS_FILE_TMPDIR/result.json"
}

teardown_file() {
  stop_daemon
}

setup() {
  cd "$BATS_FILE_TMPDIR"
}

# A test that kills has a daemon of its own.
teardown() {
  [ -z "${OWN_DAEMON:-}" ] || stop_daemon KILL
}

@test "case S leads to contact ratios of 2 and more with no more stress" {
  jq -e '.macro | .samples == 40000000 and .samples == .passed + ([.rejected[].count] | add) and .passed >= 3
         and .initial.contact_ratio < 1.22' result.json
  jq -e '[.macro.candidates[] | select(.among_best)] | length == 3 and
         all(.contact_ratio >= 2 and .contact_stress_factor <= 1 and .root_stress_factor <= 1
             and .judged and .f_pps_um > 0 and .f_dte > 0 and .max_root_stress_mpa > 0 and .loaded_contact_ratio >= 2)' \
    result.json
  jq -e '.macro as $m | $m.candidates[$m.best] | .f_dte == ([$m.candidates[].f_dte] | min)' result.json
  jq -e '.design.f_dte == .macro.candidates[.macro.best].f_dte and .design.load_cases[0].max_root_stress_mpa != null' result.json
  jq -e '.improvement.f_dte_percent == 100 * (.reference.f_dte - .design.f_dte) / .reference.f_dte' result.json
}

@test "a candidate is a pair that check accepts and evaluate judges the same" {
  jq -c '.macro.candidates[1] as $c | .job | .kind = "evaluate" | .gear_pair = $c.gear_pair | del(.macro, .objective)' \
    result.json >candidate.json
  "$QG_BUILD/quietgear" check candidate.json >geometry.json
  "$QG_BUILD/quietgear" run candidate.json -o candidate_result.json
  jq -e --slurpfile one candidate_result.json --slurpfile geometry geometry.json \
    '.macro.candidates[1] | .f_dte == $one[0].design.f_dte and .f_pps_um == $one[0].design.f_pps_um
     and .contact_ratio == $one[0].geometry.contact_ratio and .contact_ratio == $geometry[0].contact_ratio' result.json
  jq -e --slurpfile one candidate_result.json '.macro.candidates[1].geometry == $one[0].geometry' result.json
  # the factors, from both pairs' ratings
  jq -e --slurpfile one candidate_result.json '.macro.candidates[1].contact_stress_factor as $factor
     | ([$one[0].iso6336.contact_stress_mpa[]] | max) / ([.iso6336.contact_stress_mpa[]] | max) - $factor | fabs < 1e-12' \
    result.json
}

@test "a candidate can be posted as an optimization" {
  jq -c '.macro.candidates[0].gear_pair | {kind: "optimize", gear_pair: .,
         relief_bounds: {pinion: {tip: {start_radius_mm: [.pinion.outside_radius_mm - 2, .pinion.outside_radius_mm - 0.1],
                                        amplitude_mm: [0.003, 0.02]}}},
         analysis: {speeds: {count: 20}}, optimizer: {random_samples: 4, simplex_iterations: 2}}' result.json >optimize.json
  id=$(submit <optimize.json)
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" | jq -e '.reference.f_dte > 0 and .design.f_dte > 0'
}

@test "threads and the daemon give the same candidates to the last bit" {
  jq -S '{macro, design, reference}' result.json >expected
  "$QG_BUILD/quietgear" run --threads 1 macro.json | jq -S '{macro, design, reference}' >other
  cmp expected other
  id=$(submit <macro.json)
  wait_for "$id" '.state == "succeeded" and .kind == "macro" and .progress.done == .progress.total
                  and .progress.total == 2 + 39 + 6' 60
  ask "/v1/jobs/$id/result" | jq -S '{macro, design, reference}' >other
  cmp expected other
  ask "/v1/jobs/$id/evaluations" | jq -se --slurpfile result result.json \
    '[.[1:][] | {evaluation, sample, f_dte}] == [$result[0].macro.candidates[] | {evaluation, sample, f_dte}]
     and all(.[1:][]; .phase == "candidates" and .parameters == {})'
  ask "/v1/jobs/$id/frequency-response" | jq -e --slurpfile result result.json \
    '.design.half_backlash_um != .reference.half_backlash_um and .design.f_dte == $result[0].design.f_dte
     and .reference.half_backlash_um == .half_backlash_um'
  ask "/v1/jobs/$id/profile" | jq -e --slurpfile result result.json \
    '.pinion.teeth == ($result[0] | .macro.candidates[.macro.best].gear_pair.pinion.teeth)'
}

@test "a search that is killed goes on with the same bits" {
  OWN_DAEMON=yes
  for keep in 4 8 16; do # one that ends before it is killed was too short for this machine
    jq -c ".macro.keep = $keep" macro.json >long.json
    start_daemon "$BATS_TEST_TMPDIR/state.$keep" --threads 2
    id=$(submit <long.json)
    wait_for "$id" '(.progress.phase == "candidates" and .progress.done > 41) or .finished_at != null'
    stop_daemon KILL
    start_daemon "$BATS_TEST_TMPDIR/state.$keep" --threads 2
    wait_for "$id" '.state == "succeeded"'
    ! grep -q 'attempt 2' "$LOG" || break
    stop_daemon
  done
  ask "/v1/jobs/$id/result" | jq -S '{macro, design, reference}' >resumed
  grep -q 'attempt 2' "$LOG"
  "$QG_BUILD/quietgear" run long.json | jq -S '{macro, design, reference}' >whole
  cmp whole resumed
}

@test "a search that finds nothing says so" {
  jq '.macro.constraints.root_stress_factor = 0.05 | .macro.samples = 1000000' macro.json >none.json
  run -0 --separate-stderr "$QG_BUILD/quietgear" run none.json -o none_result.json
  [[ $stderr == *"none of 1000000 samples passed"* ]]
  jq -e '.design == null and .improvement == null and .macro.best == null and .macro.candidates == []
         and .reference.f_dte > 0 and (.warnings | length) == 1' none_result.json
}

@test "what is wrong with the ranges is told at its place" {
  jq '.macro.ranges.pinion.teeth = [20, 22] | .macro.ranges.gear.teeth = [40, 44]' macro.json >wrong.json
  run -2 --separate-stderr "$QG_BUILD/quietgear" run wrong.json
  [[ $stderr == "wrong.json: /macro/ranges: no tooth numbers within the ranges keep the ratio 1.53571 to 1 %; the nearest are "* ]]
  [ "$(status_of /v1/jobs -H 'Content-Type: application/json' --data-binary @wrong.json)" = 422 ]
  body | jq -e '.errors[0].pointer == "/macro/ranges"'
}
