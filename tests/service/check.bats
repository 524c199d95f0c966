#!/usr/bin/env bats
# POST /v1/check: the daemon's word on a document before it is submitted.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

check() {
  status_of /v1/check -H 'Content-Type: application/json' --data-binary "$@"
}

@test "a good document comes back whole, with its geometry, and is not queued" {
  [ "$(document 'del(.analysis)' | check @-)" = 200 ]
  [ "$(header Content-Type)" = application/json ]
  body | jq -e '.valid == true and .document.analysis.mesh_positions > 0 and .geometry.contact_ratio > 1 and .warnings == []'
  # the completed document is a document, and complete
  body | jq .document >"$BATS_TEST_TMPDIR/complete"
  [ "$(check "@$BATS_TEST_TMPDIR/complete")" = 200 ]
  diff <(body | jq .document) "$BATS_TEST_TMPDIR/complete"
  ask /v1/jobs | jq -e '.jobs == []'
}

@test "it agrees with quietgear check" {
  for example in case_S_none case_H_optimize; do
    file=$QG_SOURCE/schema/examples/$example.json
    [ "$(check "@$file")" = 200 ]
    diff <(body | jq -S .geometry) <("$QG_BUILD/quietgear" check "$file" | jq -S .)
  done
}

@test "what is doubtful is said with its place" {
  document | check @-
  form=$(body | jq .geometry.pinion.form_radius_mm)
  [ "$(document ".relief.pinion.root = {end_radius_mm: ($form - 0.02), amplitude_mm: 0.01}" | check @-)" = 200 ]
  body | jq -e '.warnings | length == 1 and (.[0].pointer | startswith("/relief/pinion/root")) and .[0].detail != ""'
}

@test "a bad one is refused as POST /v1/jobs refuses it, with every fault" {
  bad=$(document '.gear_pair.pinion.teeth = 0 | .objective = "beauty" | .color = "red"')
  [ "$(check "$bad")" = 422 ]
  assert_problem 422 invalid-document
  body >"$BATS_TEST_TMPDIR/check"
  [ "$(status_of /v1/jobs -H 'Content-Type: application/json' --data-binary "$bad")" = 422 ]
  diff "$BATS_TEST_TMPDIR/check" "$BATS_TEST_TMPDIR/body"
  [ "$(check '{')" = 400 ]
  assert_problem 400 not-json
  [ "$(status_of /v1/check)" = 405 ]
  [ "$(header Allow)" = POST ]
}

# The seconds that a job took, at the edge.
run_time() {
  jq '.timing.wall_s' <(ask "/v1/jobs/$1/result")
}

# Processor time that the daemon has used, in clock ticks.
processor_ticks() {
  awk '{sub(/.*\) /, ""); print $12 + $13}' "/proc/$DAEMON/stat"
}

@test "what a job will take is announced, about as it turns out" {
  document | check @-
  announced=$(body | jq -c .estimate)
  jq -e '.evaluations == 12 + 4 + 2 * 6 + 20 + 1 and .seconds > 0 and .memory_mb > 20 and .memory_mb < 500' <<<"$announced"
  before=$(processor_ticks)
  id=$(document | submit)
  [ "$(ask "/v1/jobs/$id" | jq -c .estimate)" = "$announced" ]
  wait_for "$id" '.state == "succeeded"'
  [ "$(ask "/v1/jobs/$id" | jq -c .estimate)" = "$announced" ]
  used=$(($(processor_ticks) - before))
  # evaluations within a third; seconds say only that they are not of another order: the machine of a test does other things, so
  # that all may take as long as it likes, but not use as much of the processors
  ask "/v1/jobs/$id/evaluations" | wc -l | jq -e --argjson e "$announced" '. > 0.67 * $e.evaluations and . < 1.33 * $e.evaluations'
  jq -e --argjson t "$(run_time "$id")" --argjson used "$used" --argjson hertz "$(getconf CLK_TCK)" --argjson processors "$(nproc)" \
    '.seconds < 30 * $t and .seconds * $processors > $used / $hertz / 100' <<<"$announced"
}

@test "a job that would take too long is refused, when checked and when submitted, with the figures" {
  start_daemon "$BATS_TEST_TMPDIR/state" --max-job-cost 60
  dear=$(document '.optimizer.random_samples = 1000000')
  for path in /v1/check /v1/jobs; do
    [ "$(status_of "$path" -H 'Content-Type: application/json' --data-binary "$dear")" = 422 ]
    assert_problem 422 too-costly
    body | jq -e '.detail | test("found a job of an estimated [0-9]+ s .[0-9]+ evaluations., allowed are 60 s .max-job-cost.")'
  done
  ask /v1/jobs | jq -e '.jobs == []'
  [ "$(document | check @-)" = 200 ]
  stop_daemon
}

@test "a job that would take too much memory is refused, with the members that make it so and what they may be" {
  start_daemon "$BATS_TEST_TMPDIR/state" --max-job-memory 200 --threads 1
  large=$(document '.analysis.mesh_positions = 400 | .optimizer.verification_factor = 0')
  for path in /v1/check /v1/jobs; do
    [ "$(status_of "$path" -H 'Content-Type: application/json' --data-binary "$large")" = 422 ]
    assert_problem 422 too-much-memory
    body | jq -e '.detail | test("^found a job of an estimated [0-9]+ MB, allowed are 200 MB .max-job-memory.")'
    body | jq -e '.errors | length == 1 and .[0].pointer == "/analysis/mesh_positions"
      and (.[0].detail | test("^found 400; up to [0-9]+ would do$"))'
  done
  ask /v1/jobs | jq -e '.jobs == []'
  # the advice is right, and as far as it goes
  up_to=$(body | jq -r '.errors[0].detail | capture("up to (?<n>[0-9]+)").n | tonumber')
  [ "$(jq ".analysis.mesh_positions = $up_to" <<<"$large" | check @-)" = 200 ]
  body | jq -e '.estimate.memory_mb <= 200'
  [ "$(jq ".analysis.mesh_positions = $up_to + 1" <<<"$large" | check @-)" = 422 ]
  stop_daemon
}
