#!/usr/bin/env bats
# Drawings over HTTP: profile data, and DXF judged by an independent reader (Debian's python3-ezdxf).

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

setup() {
  standard=$QG_SOURCE/schema/examples/case_S_standard.json
  cd "$BATS_TEST_TMPDIR"
}

# Posts a document on stdin to /v1/profile with further curl arguments; prints the status.
draw() {
  status_of "/v1/profile$1" -H 'Content-Type: application/json' --data-binary @- "${@:2}"
}

# Reads the DXF in a file with ezdxf, which must find nothing wrong with it, and holds it against the job document $2.
judge_dxf() {
  [ -x /usr/bin/python3 ] && /usr/bin/python3 -c 'import ezdxf' 2>/dev/null || skip "no python3-ezdxf"
  /usr/bin/python3 "$QG_SOURCE/tests/service/judge_dxf.py" "$@"
}

@test "profile data of a document, with and without its kind" {
  [ "$(draw "" <"$standard")" = 200 ]
  [ "$(header Content-Type)" = application/json ]
  body | jq -e '.center_distance_mm == 111 and .pinion.teeth == 28 and (.pinion.diagram.design.removed_um | last) == 16'
  body >with
  [ "$(jq '{gear_pair, relief}' "$standard" | draw "")" = 200 ]
  body | cmp - with
}

@test "a bad design is refused with the place of every fault" {
  [ "$(jq '{gear_pair, relief} | .relief.gear.tip.amplitude_mm = 9 | .gear_pair.module_mm = -1' "$standard" | draw "")" = 422 ]
  assert_problem 422 invalid-document
  body | jq -e '[.errors[].pointer] == ["/gear_pair/module_mm", "/relief/gear/tip/amplitude_mm"]'
  [ "$(echo '{' | draw "")" = 400 ]
  assert_problem 400 not-json
}

@test "parameters are looked at" {
  for query in extent=half position=1.5 position=-0 position=. position= position=1e-1 position=nan frob=1; do
    [ "$(draw "?$query" <"$standard")" = 400 ] || { echo "$query" && false; }
    assert_problem 400 bad-parameter
  done
  [ "$(draw '?position=0.25&extent=gears' -H 'Accept: image/vnd.dxf' <"$standard")" = 200 ]
  [ "$(draw "" -H 'Accept: image/png' <"$standard")" = 406 ]
}

@test "both gears as DXF: an independent reader finds them whole and true" {
  [ "$(draw '?position=0.3' -H 'Accept: image/vnd.dxf' <"$standard")" = 200 ]
  [ "$(header Content-Type)" = image/vnd.dxf ]
  [[ "$(header Content-Disposition)" = *'filename="gears.dxf"'* ]]
  body >gears.dxf
  judge_dxf gears gears.dxf 111 28 46.55 43 69.55
}

@test "one space of each gear as DXF" {
  [ "$(draw '?extent=spaces' -H 'Accept: image/vnd.dxf' <"$standard")" = 200 ]
  body >spaces.dxf
  judge_dxf spaces spaces.dxf 111 28 46.55 43 69.55
}

@test "the command line writes the same DXF" {
  quietgear=$QG_BUILD/quietgear
  draw '?position=0.3' -H 'Accept: image/vnd.dxf' <"$standard" >/dev/null
  "$quietgear" export --format dxf --position 0.3 "$standard" | cmp - "$BATS_TEST_TMPDIR/body"
  draw '?extent=spaces' -H 'Accept: image/vnd.dxf' <"$standard" >/dev/null
  "$quietgear" export --format dxf-spaces "$standard" -o spaces.dxf
  cmp spaces.dxf "$BATS_TEST_TMPDIR/body"
  for words in "dxf --load-case 0" "dxf --torque-fraction 1" "dxf-spaces --position 0.5" "dxf --position 2" dwg; do
    # shellcheck disable=SC2086 # words
    run -2 --separate-stderr "$quietgear" export --format $words "$standard"
    [[ $stderr = *allowed* ]] && [ -z "$output" ]
  done
}

@test "the drawings of a job: reference from the beginning, design when it is done" {
  id=$(document '.analysis.speeds.count = 20' | submit)
  [ "$(status_of "/v1/jobs/$id/profile?design=reference")" = 200 ]
  body | jq -e '(.pinion.diagram.design.removed_um | last) == 16 and (.pinion.diagram.most.removed_um | last) == 35'
  wait_for "$id" '.state == "succeeded"'
  [ "$(status_of "/v1/jobs/$id/profile")" = 200 ]
  best=$(ask "/v1/jobs/$id/result" | jq .design.relief.pinion.tip.amplitude_mm)
  body | jq -e "(.pinion.diagram.design.removed_um | last) - 1000 * $best | fabs < 1e-9"
  [ "$(status_of "/v1/jobs/$id/profile?design=design&extent=spaces" -H 'Accept: image/vnd.dxf')" = 200 ]
  [ "$(body | head -n 1)" = 999 ]
}

@test "the field of a design is computed when it is asked for" {
  id=$(jq '.analysis.speeds.count = 20' "$standard" | submit)
  wait_for "$id" '.state == "succeeded"'
  [ "$(status_of "/v1/jobs/$id/field?load_case=2&position=0.5")" = 202 ]
  [ "$(header Retry-After)" = 1 ]
  await answers 200 "/v1/jobs/$id/field?load_case=2&position=0.5"
  body >field.json
  "$QG_BUILD/quietgear" export --format json --position 0.5 --load-case 2 "$standard" | cmp - <(cat field.json; echo)
  [ "$(status_of "/v1/jobs/$id/field")" = 200 ] # the largest torque, the middle of the path
  [ "$(status_of "/v1/jobs/$id/field?load_case=3")" = 400 ]
  assert_problem 400 bad-parameter
  [ "$(status_of "/v1/jobs/$id/field?position=2")" = 400 ]
  [ "$(status_of "/v1/jobs/nothing/field")" = 404 ]
}

@test "the field of a very fine mesh is refused" {
  id=$(jq '.load_cases = [{"torque_fraction": 1}] | .analysis.speeds.count = 2 | .analysis.mesh_positions = 6
           | .analysis.harmonics = 2 | .analysis.mesh_refinement = 3' "$standard" | submit)
  wait_for "$id" '.state == "succeeded"'
  [ "$(status_of "/v1/jobs/$id/field")" = 409 ]
  assert_problem 409 wrong-state
  [[ $(body) = *"mesh_refinement: the job's is 3"*"up to 2"* ]]
}

@test "what has no drawing says so" {
  [ "$(status_of /v1/jobs/nothing/profile)" = 404 ]
  [ "$(status_of '/v1/jobs/nothing/profile?design=reference')" = 404 ]
  id=$(endless | submit)
  [ "$(status_of "/v1/jobs/$id/profile")" = 409 ]
  assert_problem 409 not-available-yet
  [ "$(status_of "/v1/jobs/$id/profile?design=best")" = 400 ]
  ask "/v1/jobs/$id/cancel" -X POST >/dev/null
}

@test "a macro job in which nothing passed has no design to draw, and says so" {
  id=$(jq -c '.macro.samples = 1000 | .analysis.speeds.count = 20' "$QG_SOURCE/schema/examples/case_S_macro.json" | submit)
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" | jq -e '.design == null and (.warnings | length) == 1'
  for what in profile field; do
    [ "$(status_of "/v1/jobs/$id/$what")" = 409 ]
    assert_problem 409 wrong-state
    [[ $(body) = *"has no design"* ]]
  done
  [ "$(status_of "/v1/jobs/$id/profile?design=reference")" = 200 ]
}
