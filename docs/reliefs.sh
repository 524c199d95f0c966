#!/bin/sh
# Prints the figures of docs/reliefs.md: searches over seeds, their best designs judged more finely, and both maps.
#   docs/reliefs.sh           (needs quietgear in the PATH, and jq; some four minutes on two cores)
set -eu
cd "$(dirname "$0")/../schema/examples"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

run() { quietgear run "$1" -o "$2" 2>"$work/errors" || { cat "$work/errors" >&2; exit 1; }; }
short() { jq -r "$1 | . * 1000 | round / 1000" "$2"; }

# search NAME DOCUMENT FIGURE SEEDS JQ: best, median and worst of the design's figure; the best one again at 56 positions, and
# at 56 positions with twice finer elements.
search() {
    for seed in $(seq "$4"); do
        jq "$5 | .optimizer.seed = $seed | del(.reliability)" "$2" >"$work/job"
        run "$work/job" "$work/seed$seed"
    done
    figures=$(for seed in $(seq "$4"); do printf '%s %s\n' "$(jq ".design.$3" "$work/seed$seed")" "$seed"; done | sort -g)
    best=$(printf '%s\n' "$figures" | head -n 1 | cut -d' ' -f2)
    for refinement in 1 2; do
        jq --argjson r "$refinement" '.design.relief as $design | .job | .kind = "evaluate" | .relief = $design
            | .analysis.mesh_positions = 56 | .analysis.mesh_refinement = $r
            | del(.relief_bounds, .objective, .optimizer, .reliability)' "$work/seed$best" >"$work/job"
        run "$work/job" "$work/fine$refinement"
    done
    printf '%s\n' "$figures" | awk -v name="$1" -v fine="$(short ".design.$3" "$work/fine1")" \
        -v finer="$(short ".design.$3" "$work/fine2")" -v pps="$(short .design.f_pps_um "$work/seed$best")" \
        -v dte="$(short .design.f_dte "$work/seed$best")" '{ v[NR] = $1 }
        END { m = NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2
              printf "| %s | %.3g | %.3g | %.3g | %s | %s | %s, %s |\n", name, v[1], m, v[NR], fine, finer, pps, dte }'
}

given() { # given NAME DOCUMENT JQ
    jq "$3" "$2" >"$work/job"
    run "$work/job" "$work/out"
    echo "| $1 | $(short .design.f_pps_um "$work/out") | $(short .design.f_dte "$work/out") |"
}

map() { # map NAME DOCUMENT
    run "$2" "$work/out"
    jq -r --arg name "$1" '.map | (.f_pps_um | flatten) as $s | (.f_dte | flatten) as $d | ($s | add / length) as $a
        | ($d | add / length) as $b | [range($s | length) | ($s[.] - $a) * ($d[.] - $b)] as $c
        | (($c | add) / ((($s | map(. - $a | . * .) | add) * ($d | map(. - $b | . * .) | add)) | sqrt)) as $r
        | def f: . * 1000 | round / 1000;
        "| \($name) | \($s | min | f) to \($s | max | f) | \($d | min | f) to \($d | max | f) | \(.local_minima.f_pps | length), \(.local_minima.f_dte | length) | \($r | f) |",
        "smallest: f_pps at \(.minima.f_pps.values | map(f)), f_dte at \(.minima.f_dte.values | map(f))"' "$work/out"
}

s=case_S_optimize.json p=case_S_optimize_parabolic.json
echo '| given design | f_pps | f_dte |'
given 'linear, standard relief' case_S_standard.json .
given 'parabolic, standard relief' case_S_standard.json '.relief.shape = "parabolic"'
given 'H, pure involutes' case_H_optimize.json '.kind = "evaluate" | del(.relief, .relief_bounds, .objective, .optimizer, .reliability)'
echo '| search | best | median | worst | best at 56 positions | with finer elements | its f_pps, f_dte |'
search 'linear, f_dte' $s f_dte 10 .
search 'parabolic, f_dte' $p f_dte 10 .
search 'linear, f_pps' $s f_pps_um 10 '.objective = "f_pps"'
search 'parabolic, f_pps' $p f_pps_um 10 '.objective = "f_pps"'
search 'H, four' case_H_optimize.json f_dte 10 .
search 'H, eight' case_H_optimize_8.json f_dte 10 .
search 'linear, f_dte, searched at 56' $s f_dte 5 '.analysis.mesh_positions = 56'
search 'parabolic, f_dte, searched at 56' $p f_dte 5 '.analysis.mesh_positions = 56'
search 'linear, f_pps, searched at 56' $s f_pps_um 5 '.objective = "f_pps" | .analysis.mesh_positions = 56'
search 'parabolic, f_pps, searched at 56' $p f_pps_um 5 '.objective = "f_pps" | .analysis.mesh_positions = 56'
echo '| map | range of f_pps | range of f_dte | local minima | correlation |'
map 'start radii' case_S_map_radii.json
map amplitudes case_S_map_amplitudes.json
