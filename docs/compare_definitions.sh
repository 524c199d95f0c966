#!/bin/sh
# Compares the definitions of the mesh stiffness: runs a design up and down through its speeds under each of them, prints
# peaks and jumps, and draws the curves.
#   docs/compare_definitions.sh JOB.json [OUT.svg]                       (needs jq, gnuplot, and quietgear in the PATH)
# JOB.json is an evaluate job; its analysis.mesh_stiffness and branch are replaced, and branches left out. Frequencies are
# divided by the secant definition's natural frequency, so that all curves have one axis.
set -eu
[ $# = 1 ] || [ $# = 2 ] || { echo "usage: $0 JOB.json [OUT.svg]" >&2; exit 2; }
job=$1 out=${2:-}
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT

for definition in secant consistent load_dependent; do
    for run in run_up run_down; do
        jq --arg d "$definition" --arg run "$run" \
            'del(.analysis.branches) | .analysis.mesh_stiffness = $d | .analysis.branch = $run' "$job" >"$data/job"
        quietgear run "$data/job" -o "$data/$definition-$run" 2>/dev/null
    done
done
cases=$(jq '.design.load_cases | length' "$data/secant-run_up")

# f/f_n(secant) and RMS of a load case.
curve() { # curve CASE DEFINITION RUN
    natural=$(jq --argjson k "$1" '.design.load_cases[$k].natural_frequency_hz' "$data/secant-run_up")
    jq -r --argjson k "$1" --argjson f "$natural" '.design.load_cases[$k] | (.natural_frequency_hz / $f) as $s
        | .frequency_response | [.frequency_ratio, .rms] | transpose[] | "\(.[0] * $s * 1e5 | round / 1e5) \(.[1] * 1e5 | round / 1e5)"' "$data/$2-$3"
}

# The largest leap up of a run-up in the main resonance (above 0.75), or down of a run-down: where, from, to.
leap() { # leap RUN < curve
    if [ "$1" = run_up ]; then awk '$1 > 0.75'; else tac; fi |
        awk -v up="$([ "$1" = run_up ] && echo 1 || echo -1)" '
             { d = NR > 1 ? up * ($2 - y) : 0; if (d > most) { most = d; at = $1; from = y; to = $2 }; y = $2 }
             END { if (most > 0.02) printf "%.3f (%.3f to %.3f)", at, from, to; else printf "none" }'
}

# The largest amplitude above 0.75 in a run-up, of all in a run-down.
peak() { # peak RUN < curve
    awk -v least="$([ "$1" = run_up ] && echo 0.75 || echo 0)" '
        $1 > least && $2 > y { y = $2; x = $1 } END { printf "%.4f at %.3f", y, x }'
}

printf '%8s  %-14s  %-16s  %-26s  %-16s  %-26s\n' torque definition 'run-up: peak' 'leap' 'run-down: peak' 'leap'
for k in $(seq 0 $((cases - 1))); do
    torque=$(jq --argjson k "$k" '.design.load_cases[$k].torque_nm * 10 | round / 10' "$data/secant-run_up")
    for definition in secant consistent load_dependent; do
        for run in run_up run_down; do
            curve "$k" "$definition" "$run" >"$data/$k-$definition-$run.xy"
        done
        printf '%8s  %-14s  %-16s  %-26s  %-16s  %-26s\n' "$torque" "$definition" \
            "$(peak run_up <"$data/$k-$definition-run_up.xy")" "$(leap run_up <"$data/$k-$definition-run_up.xy")" \
            "$(peak run_down <"$data/$k-$definition-run_down.xy")" "$(leap run_down <"$data/$k-$definition-run_down.xy")"
    done
done
[ -n "$out" ] || exit 0

torques=$(jq -r '[.design.load_cases[].torque_nm | . * 10 | round / 10 | tostring] | join(" ")' "$data/secant-run_up")
name=$(jq -r '.job.name' "$data/secant-run_up")
gnuplot <<END
set terminal svg size 900,$((60 + 250 * cases)) font 'sans,12' background rgb 'white'
set output '$out'
set multiplot layout $cases,1 title '$name' noenhanced
set xlabel 'mesh frequency / natural frequency of the secant definition'
set ylabel 'RMS of DTE / half-backlash'
set key outside right top samplen 2 noenhanced
set grid lc rgb '#e0e0e0'
set yrange [0:*]
names = 'secant consistent load_dependent'
colors = '#0072b2 #d55e00 #009e73'
do for [k=0:$((cases - 1))] {
    set title word('$torques', k + 1).' N m'
    plot for [n=1:3] '$data/'.k.'-'.word(names, n).'-run_up.xy' using 1:2 with lines lw (n == 1 ? 4 : 1.5) \\
             lc rgb word(colors, n) title word(names, n).', up', \\
         for [n=1:3] '$data/'.k.'-'.word(names, n).'-run_down.xy' using 1:2 with lines lw (n == 1 ? 4 : 1.5) dt (6,3) \\
             lc rgb word(colors, n) title word(names, n).', down'
}
END
