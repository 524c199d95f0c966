#!/bin/sh
# Writes docs/performance.md from the lines that `make bench` printed:
#   make bench >bench.jsonl && docs/render_performance.sh bench.jsonl >docs/performance.md
set -eu
[ $# = 1 ] || { echo "usage: $0 BENCH.jsonl" >&2; exit 2; }
lines=$(mktemp)
trap 'rm -f "$lines"' EXIT
grep '^{' "$1" >"$lines" # make may have said what it compiled
get() { jq -rs --arg bench "$1" "map(select(.bench == \$bench)) | $2" "$lines"; }
round() { jq -rn "$1 * $2 | round / $2"; }

# Lane-steps of the integrator's tables for 3 x 1000 speeds: steps of at most 0.2 in time and 5.3 per harmonic (6 of them).
lane_steps=$(awk 'BEGIN { for (i = 0; i < 1000; i++) { p = 0.2 + 1.2 * i / 999; n = 31.4159 / p; if (n < 31.8) n = 31.8; s += n }
    printf "%.0f", 3 * s }')
mflop=$(awk -v s="$lane_steps" 'BEGIN { printf "%.0f", s * 280 / 1e6 }') # 3 power series of order 8 by degree 7, and matching
gflops=$(awk -v m="$mflop" -v t="$(get dynamic_floor '.[0].milliseconds')" 'BEGIN { printf "%.0f", m / t }')
contact_kflop=$(awk -v n="$(get contact_floor '.[0].points')" -v k="$(get contact_floor '.[0].touching_mean')" 'BEGIN {
    printf "%.0f", (k ^ 3 / 3 + 4 * k ^ 2 + 2 * n * k) / 1e3 }')

cat <<END
# How fast, and how near to the floor

Every figure below was printed by \`make bench\` in one run and put here by \`docs/render_performance.sh\`: case S, standard relief where
nothing else is said, one core of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), medians of five. Absolute times belong to that machine; ratios
travel better.

| what | figure | goal |
|---|---|---|
| compliance, pinion ($(get compliance '.[0].sector_degrees_of_freedom') unknowns in the sector, $(get compliance '.[0].whole_gear_degrees_of_freedom') in the whole gear) | $(get compliance '.[0].seconds') s | |
| compliance, gear ($(get compliance '.[1].sector_degrees_of_freedom') / $(get compliance '.[1].whole_gear_degrees_of_freedom') unknowns) | $(get compliance '.[1].seconds') s | both 1 s |
| compliance from the cache | $(get cache '.[0].look_up_milliseconds') ms | 5 ms |
| model: both gears and the contact operators at 14 positions | $(get model '.[0].seconds') s, with the cache $(get cache '.[0].model_with_seconds') s | |
| one static candidate, 14 positions x 3 torques | $(get static_candidate '.[] | select(.relief == "standard").milliseconds') ms (no relief: $(get static_candidate '.[] | select(.relief == "none").milliseconds') ms) | 2 ms |
| one dynamic candidate, 1000 speeds x 3 torques, \`fixed\` | $(get dynamic_candidate '.[] | select(.relief == "standard").milliseconds') ms (no relief: $(get dynamic_candidate '.[] | select(.relief == "none").milliseconds') ms) | 50 ms |
| the same by CVODE marching at RMS error $(get dynamics_against_cvode '.[0].cvode_largest_rms_error') (ours: $(get dynamics_against_cvode '.[0].our_largest_rms_error')) | $(get dynamics_against_cvode '.[0].cvode_seconds_per_candidate') s, ratio $(get dynamics_against_cvode '.[0].ratio') | ratio 300 |
| optimization of case S (180 + 80, reliability 100) | $(get optimize_case_S '.[0].seconds_threads_2') s on two threads, $(get optimize_case_S '.[0].seconds_threads_1') s on one | 20 s |
| reliability, 10 000 trials of the standard relief | $(get reliability '.[0].seconds') s on two threads | a coffee break |
| peak memory, without the growth runs | $(get peak_memory '.[0].mebibytes') MiB | |

The accuracy comparison takes $(get dynamics_against_cvode '.[0].speeds_compared') speeds; $(get dynamics_against_cvode '.[0].same_branch') of them end on the same branch in both programs.

## Threads

Evaluations of many designs: $(get evaluations_per_second '.[0].threads_1') per second on one thread, $(get evaluations_per_second '.[0].threads_2') on two
(speed-up $(get evaluations_per_second '.[0].speed_up')). The whole optimization gains $(get optimize_case_S '.[0].speed_up'), its simplex phase alone
$(get optimize_case_S '.[0].simplex_speed_up'): a simplex asks for one design at a time, whose speed map is cut into 375 pieces, while its contact problems
($(get static_candidate '.[] | select(.relief == "standard").milliseconds') ms) stay on one thread. That is what the simplex loses.

## Floors

- **Dynamics.** Every speed needs the tables of the integrator (one affine map per step) before anything can be known about it. When no
  speed loses contact that is all: $lane_steps lane-steps of some 280 operations, $mflop million in all, which take
  $(get dynamic_floor '.[0].milliseconds') ms, or $gflops Gflop/s on one core without fused multiply-add. A batch's tables are six numbers per step and lane, about
  20 kB for eight speeds, and stay in the first-level cache. What remains above it are speeds
  that do lose contact and are marched for some periods, then polished by Newton's method; marching them all the way takes
  $(get dynamics_path '.[] | select(.path == "avx512" and .plain_march) // .[0] | .milliseconds' 2>/dev/null || get dynamics_path 'map(select(.plain_march)) | last.milliseconds') ms.
- **Statics.** $(get contact_floor '.[0].problems') contact problems of up to $(get contact_floor '.[0].points') points, of which $(get contact_floor '.[0].touching_mean') touch on average.
  With the touching points known, one factorization and one product each, some $contact_kflop thousand operations: $(get contact_floor '.[0].touching_known_milliseconds') ms. From scratch
  $(get contact_floor '.[0].factorizations_mean') factorizations: $(get contact_floor '.[0].from_scratch_milliseconds') ms; a candidate starts each torque from the
  touching points of the one before.
- **Compliance.** One sparse Cholesky factorization of a sector per gear, whose last block is the Schur complement, so that no solve is
  needed; the ring costs one small Hermitian inverse per circumferential order.

## Code paths

The batched integrator is one source compiled for three instruction sets without contraction; all give the same bits, and a test compares them.

| path | one dynamic candidate | marched without short cuts |
|---|---|---|
$(get dynamics_path 'group_by(.path)[] | "| \(.[0].path) | \(map(select(.plain_march | not))[0].milliseconds) ms | \(map(select(.plain_march))[0].milliseconds) ms |"')

## Growth

| with | value | static candidate, ms | dynamic candidate, ms |
|---|---|---|---|
$(get growth '.[] | select(.static_milliseconds) | "| \(.with) | \(.value) | \(.static_milliseconds) | \(.dynamic_milliseconds) |"')

| with | value | compliance of the pinion, s |
|---|---|---|
$(get growth '.[] | select(.compliance_seconds) | "| \(.with) | \(.value) | \(.compliance_seconds) |"')

## Tried or weighed, and dropped

- RK4 in SIMD lanes for the speed map, weighed: its error at the edges of the dead zone is of second order in the step; the motion
  between edges is linear, so that one affine map per step is both faster and exact to 1e-9.
- Newton's method as soon as a return error is small, tried: fast, and now and then on another branch. It is now accepted only
  where the march has shown that it can only spiral in (\`core/dynamics_steady.c\`).
- Evaluating all possible next moves of the simplex together, weighed: four designs where one or two are needed; on two cores
  no gain over cutting one design into pieces.
- Solving the sector for every flank load, weighed: hundreds of right-hand sides per gear, where the factor already holds the answer.
- An even flank mesh, tried: tip-corner contact then converges last; elements now shrink towards the tip.
END
