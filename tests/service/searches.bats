#!/usr/bin/env bats
# Searches beyond Random-Simplex: budgets, fronts and percentiles in the result; threads, the daemon and kill -9 change nothing.

load helper

setup_file() {
  small="(.analysis.speeds = {min: 0.4, max: 1.2, count: 24}) | (.optimizer.evaluations = 60)"
  jq -c "$small | del(.reliability)" "$QG_SOURCE/schema/examples/case_H_optimize_8_multistart.json" >"$BATS_FILE_TMPDIR/eight.json"
  # Two objectives, one of them robust.
  jq -c "$small | .objectives = [\"f_dte_percentile\", \"f_pps\"]
         | .reliability = {samples: 5, percentile: 80, percentile_trials: 5}" \
    "$QG_SOURCE/schema/examples/case_S_pareto.json" >"$BATS_FILE_TMPDIR/robust_front.json"
  for job in eight robust_front; do
    "$QG_BUILD/quietgear" run "$BATS_FILE_TMPDIR/$job.json" --threads 2 -o "$BATS_FILE_TMPDIR/$job.result.json"
  done
}

setup() {
  cd "$BATS_FILE_TMPDIR"
  STATE=$BATS_TEST_TMPDIR/state
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

@test "a multi-start search keeps its budget and improves" {
  jq -e '.search.evaluations == 60 and .search.method == "multistart_simplex" and .search.simplex_iterations == null
         and .search.pareto == null and .improvement.f_dte_percent > 0 and .design.f_dte_percentile == null' eight.result.json
}

@test "a front has no member that another one beats, and its design is the evenest" {
  jq -e '.search.pareto as $all | ($all | length) >= 2 and ([$all[] as $a | $all[] | . == $a or .f_pps_um > $a.f_pps_um
         or .f_dte_percentile > $a.f_dte_percentile] | all)' robust_front.result.json
  jq -e '.reference as $r | .design as $d | [.search.pareto[] | select(.evaluation > 0)
         | [.f_pps_um / $r.f_pps_um, .f_dte_percentile / $r.f_dte_percentile] | max] | min
         | . - ([$d.f_pps_um / $r.f_pps_um, $d.f_dte_percentile / $r.f_dte_percentile] | max) | . < 1e-12 and . > -1e-12' \
    robust_front.result.json
  jq -e '.search.history[-1].best < 1 and .search.hypervolume > 0 and .reliability.samples == 5' robust_front.result.json
}

@test "a member of the front is what an evaluation of its relief gives" {
  jq '.search.pareto[1].relief as $relief | .job | .kind = "evaluate" | .relief = $relief
      | del(.objectives, .relief_bounds, .optimizer, .reliability)' robust_front.result.json >one.json
  "$QG_BUILD/quietgear" run one.json --threads 1 -o one.result.json
  [ "$(jq -c '.search.pareto[1] | [.f_pps_um, .f_dte]' robust_front.result.json)" = \
    "$(jq -c '.design | [.f_pps_um, .f_dte]' one.result.json)" ]
}

@test "one thread gives the same bits" {
  for job in eight robust_front; do
    "$QG_BUILD/quietgear" run "$job.json" --threads 1 -o "$job.serial.json"
    diff <(essence "$job.result.json") <(essence "$job.serial.json")
  done
}

has_grown_or_ended() {
  [ "$(ask "/v1/jobs/$id/evaluations" | wc -l)" -gt "$1" ] || ask "/v1/jobs/$id" | jq -e '.finished_at != null'
}

@test "a daemon that is killed on the way gives the same bits" {
  start_daemon "$STATE" --threads 2
  id=$(submit <robust_front.json)
  for kill in 1 2; do
    length=$(ask "/v1/jobs/$id/evaluations" | wc -l)
    await has_grown_or_ended "$length"
    stop_daemon KILL
    start_daemon "$STATE" --threads 2
  done
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" >killed.json
  diff <(essence robust_front.result.json) <(essence killed.json)
  ask "/v1/jobs/$id/evaluations" | jq -se 'length == 66 and (.[1:61] | all(.phase == "multistart" and .f_dte_percentile > 0))
         and (.[61:] | all(.phase == "reliability" and .f_dte_percentile == null))'
  ask "/v1/jobs/$id/evaluations" -H 'Accept: text/csv' | head -n 1 | grep -q ',f_dte_percentile$'
}
