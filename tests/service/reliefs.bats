#!/usr/bin/env bats
# Reliefs beyond four linear tip parameters: eight parameters, parabolic ones, and those that do nothing. Small versions of
# the examples, so that the searches take a second.

setup() {
  : "${QG_SOURCE:=$(cd "$BATS_TEST_DIRNAME/../.." && pwd)}" "${QG_BUILD:=$QG_SOURCE}"
  quietgear=$QG_BUILD/quietgear
  examples=$QG_SOURCE/schema/examples
  cd "$BATS_TEST_TMPDIR"
}

# small EXAMPLE [JQ]: the example with few samples and speeds; the result goes to result.json.
small() {
  jq ".optimizer |= (.random_samples = 48 | .simplex_iterations = 24) | .analysis.speeds = {min: 0.3, max: 1.3, count: 60}
      | del(.reliability) | ${2:-.}" "$examples/$1.json" >job.json
  "$quietgear" run job.json -o result.json 2>/dev/null
}

@test "eight parameters of case H: all move, within their bounds, and it becomes quieter" {
  small case_H_optimize_8
  jq -e '.improvement.f_dte_percent > 20 and .search.evaluations >= 48 + 24' result.json
  jq -e '[.job.relief_bounds | paths(arrays)] as $paths | ($paths | length) == 8 and (. as $r | $paths
         | all(. as $p | $r.job.relief_bounds | getpath($p) as $b | $r.design.relief | getpath($p) | . >= $b[0] and . <= $b[1]))' \
    result.json
  jq -e '[.warnings[] | select(contains("removes nothing"))] == []' result.json
}

@test "a root relief that ends below the form radius is warned of, whether found or given" {
  small case_H_optimize_8 '.relief_bounds.pinion.root.end_radius_mm = [41.5, 42.1]'
  jq -e '[.warnings[] | select(startswith("/relief_bounds/pinion/root/end_radius_mm: design: the root relief ends at 4")
         and endswith("below the form radius 42.1721 mm: it removes nothing"))] | length == 1' result.json
  jq '.relief.pinion.root = {end_radius_mm: 40.2, amplitude_mm: 0.01} | .analysis.speeds.count = 20' \
    "$examples/case_S_standard.json" >given.json
  "$quietgear" run given.json -o result.json 2>/dev/null
  jq -e '[.warnings[] | select(startswith("/relief/pinion/root/end_radius_mm: the root relief ends at 40.2000 mm"))] | length == 1' \
    result.json
}

@test "a root relief that ends below the form radius changes no bit" {
  jq '.analysis.speeds.count = 20' "$examples/case_S_standard.json" >without.json
  jq '.relief.pinion.root = {end_radius_mm: 40.2, amplitude_mm: 0.01}' without.json >with.json
  for job in with without; do
    "$quietgear" run $job.json -o result.json 2>/dev/null
    jq -eS '.design | {f_pps_um, f_dte, load_cases}' result.json >$job
  done
  cmp with without
}

@test "parabolic reliefs are optimized for both objectives" {
  for objective in "" _f_pps; do
    small "case_S_optimize_parabolic$objective" '.optimizer |= (.random_samples = 180 | .simplex_iterations = 60)'
    jq -e '.design.relief.shape == "parabolic" and .reference.relief.shape == "parabolic"' result.json
    jq -e '.improvement[.job.objective + "_percent"] > 3' result.json
    jq -e '[.search.history[].best] | . == (sort | reverse)' result.json
  done
}

@test "a parabolic relief takes away less than a linear one of the same ends" {
  for shape in linear parabolic; do
    jq ".relief.shape = \"$shape\" | .analysis.speeds.count = 20" "$examples/case_S_standard.json" >$shape.json
    "$quietgear" run $shape.json -o $shape.result 2>/dev/null
  done
  # Full torque: with less removed the teeth come nearer.
  jq -ne --slurpfile l linear.result --slurpfile p parabolic.result \
    'def mean: .[0].design.load_cases[2].static_transmission_error_um | add / length; ($p | mean) < 0.99 * ($l | mean)'
}
