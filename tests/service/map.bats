#!/usr/bin/env bats
# Maps: the cells agree with single evaluations, the design is the smallest cell, threads and the daemon change nothing.

load helper

setup_file() {
  start_for_file --threads 2
  # 3 start radii of the pinion, downwards, by 4 of the gear.
  jq -c '.grid[0] += {from: 46, to: 44, count: 3} | .grid[1] += {from: 67, to: 69, count: 4}
         | .analysis.speeds = {min: 0.4, max: 1.2, count: 40}' \
    "$QG_SOURCE/schema/examples/case_S_map_radii.json" >"$BATS_FILE_TMPDIR/map.json"
  "$QG_BUILD/quietgear" run "$BATS_FILE_TMPDIR/map.json" -o "$BATS_FILE_TMPDIR/result.json"
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

@test "a map has all its cells, and its design is the quietest" {
  jq -e '.map | (.f_dte | length) == 3 and (.f_pps_um | map(length)) == [4, 4, 4]
         and .axes[0].values == [46, 45, 44] and .axes[1].parameter == "gear.tip.start_radius_mm"' result.json
  jq -e '.design.f_dte == ([.map.f_dte[][]] | min) and .map.minima.f_dte.f_dte == .design.f_dte
         and .map.minima.f_pps.f_pps_um == ([.map.f_pps_um[][]] | min)' result.json
  jq -e '.map.minima.f_dte.values == [.design.relief.pinion.tip.start_radius_mm, .design.relief.gear.tip.start_radius_mm]' \
    result.json
  jq -e '.improvement.f_dte_percent == 100 * (.reference.f_dte - .design.f_dte) / .reference.f_dte' result.json
}

@test "a cell of a map is what an evaluation of its relief gives" {
  jq '.kind = "evaluate" | del(.grid, .objective) | .relief.pinion.tip.start_radius_mm = 45
      | .relief.gear.tip.start_radius_mm = 69' map.json >cell.json
  "$QG_BUILD/quietgear" run cell.json -o cell_result.json
  jq -e --slurpfile cell cell_result.json \
    '.map.f_dte[1][3] == $cell[0].design.f_dte and .map.f_pps_um[1][3] == $cell[0].design.f_pps_um' result.json
}

@test "the static objective chooses another cell of the same map" {
  jq '.objective = "f_pps"' map.json >static.json
  "$QG_BUILD/quietgear" run static.json -o static_result.json
  jq -e --slurpfile other static_result.json '.map == $other[0].map' result.json
  jq -e '.design.f_pps_um == .map.minima.f_pps.f_pps_um and .design.f_dte == .map.minima.f_pps.f_dte' static_result.json
}

@test "threads and the daemon give the same map to the last bit" {
  jq -S '{map, design, reference}' result.json >expected
  for threads in 1 3; do
    "$QG_BUILD/quietgear" run --threads "$threads" map.json | jq -S '{map, design, reference}' >other
    cmp expected other
  done
  id=$(submit <map.json)
  wait_for "$id" '.state == "succeeded" and .kind == "map" and .progress.done == 14 and .progress.total == 14'
  ask "/v1/jobs/$id/result" | jq -S '{map, design, reference}' >other
  cmp expected other
  ask "/v1/jobs/$id/evaluations" | jq -se 'length == 13 and (.[1:] | all(.phase == "map" and .f_dte > 0 and .f_pps_um > 0))'
}

@test "a map that is killed goes on with the same bits" {
  local side=40 # long enough for a kill in the middle
  if sanitized; then side=20; fi
  OWN_DAEMON=yes
  for side in $side $((2 * side)); do # one that ends before it is killed was too short for this machine
    jq -c ".grid[0].count = $side | .grid[1].count = $side | .analysis.speeds.count = 100" map.json >large.json
    start_daemon "$BATS_TEST_TMPDIR/state.$side" --threads 2
    id=$(submit <large.json)
    wait_for "$id" '(.progress.phase == "map" and .progress.done > 30) or .finished_at != null'
    stop_daemon KILL
    start_daemon "$BATS_TEST_TMPDIR/state.$side" --threads 2
    wait_for "$id" '.state == "succeeded"'
    ! grep -q 'attempt 2' "$LOG" || break
    stop_daemon
  done
  ask "/v1/jobs/$id/result" | jq -S '{map, design, reference}' >resumed
  grep -q 'attempt 2' "$LOG"
  "$QG_BUILD/quietgear" run large.json | jq -S '{map, design, reference}' >whole
  cmp whole resumed
}

@test "what is wrong with a grid is told at its place" {
  jq '.grid[0].to = 46.6' map.json >wrong.json
  run -2 --separate-stderr "$QG_BUILD/quietgear" run wrong.json
  [[ $stderr == "wrong.json: /grid/0/to: found 46.6 mm, allowed: within "*" to 46.5500 mm" ]]
  [ "$(status_of /v1/jobs -H 'Content-Type: application/json' --data-binary @wrong.json)" = 422 ]
  body | jq -e '.errors[0].pointer == "/grid/0/to"'
}
