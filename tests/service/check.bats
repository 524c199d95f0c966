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
