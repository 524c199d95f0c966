#!/bin/sh
# Draws all branches of a design, torque by torque: stable parts solid, unstable parts dashed, a colour for each period,
# folds as dots, and the jumps of a run-up and a run-down as arrows.
#   docs/plot_branches.sh BRANCHES.json RUN_UP.json RUN_DOWN.json OUT.svg [TOP]        (needs jq and gnuplot)
# BRANCHES.json is the result of a job with "analysis": {"branches": "all"}, RUN_UP.json and RUN_DOWN.json those of the
# same design with "branch": "run_up" and "run_down". TOP is the largest RMS shown (1.3); what lies above is cut off.
set -eu
[ $# = 4 ] || [ $# = 5 ] || { echo "usage: $0 BRANCHES.json RUN_UP.json RUN_DOWN.json OUT.svg [TOP]" >&2; exit 2; }
result=$1 up=$2 down=$3 out=$4 top=${5:-1.3}
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
cases=$(jq '.design.load_cases | length' "$result")

# The segments of a class of periods that are stable, or are not; an empty line wherever the line breaks.
segments() { # segments CASE STABLE TEST-OF-PERIOD
    jq -r --argjson k "$1" --argjson stable "$2" --argjson top "$top" ".design.load_cases[\$k].branches[] | select($3)
        | [.frequency_ratio, .rms, .stable] | transpose as \$p | (range(1; \$p | length) as \$i
        | if (\$p[\$i - 1][2] and \$p[\$i][2]) == \$stable and \$p[\$i][1] < 1.2 * \$top
          then \$p[\$i - 1], \$p[\$i], \"\" else empty end)
        | if . == \"\" then . else \"\(.[0] * 1e5 | round / 1e5) \(.[1] * 1e4 | round / 1e4)\" end" "$result" |
        awk '/^$/ { next }
             n++ % 2 == 0 { if ($0 != held) { if (held != "") print held "\n"; print; x = $1; y = $2 }; next }
             { held = $0; if (($1 - x) ^ 2 + (($2 - y) / 2) ^ 2 > 1e-5) { print; x = $1; y = $2 } }
             END { if (held != "") print held }'
}

# Where the response of a run leaps by more than its neighbourhood explains: p, from, leap.
jumps() { # jumps RESULT CASE DIRECTION
    jq -r --argjson k "$2" --argjson up "$3" '.design.load_cases[$k].frequency_response
        | [.frequency_ratio, .rms] | transpose | if $up then . else reverse end | . as $p
        | range(2; length - 1) as $i | ($p[$i][1] - $p[$i - 1][1] | fabs) as $leap
        | select($leap > 0.02 and $leap > 4 * ($p[$i - 1][1] - $p[$i - 2][1] | fabs)
                              and $leap > 4 * ($p[$i + 1][1] - $p[$i][1] | fabs))
        | "\($p[$i][0]) \($p[$i - 1][1]) 0 \($p[$i][1] - $p[$i - 1][1])"' "$1"
}

for k in $(seq 0 $((cases - 1))); do
    for class in "1:.period == 1" "2:.period == 2" "3:.period == 3" "4:.period > 3"; do
        segments "$k" true "${class#*:}" >"$data/stable$k-${class%%:*}"
        segments "$k" false "${class#*:}" >"$data/unstable$k-${class%%:*}"
    done
    jq -r --argjson k "$k" --argjson top "$top" '.design.load_cases[$k].branches[].special_points[]
        | select(.type == "fold" and .rms < $top) | "\(.frequency_ratio) \(.rms)"' "$result" >"$data/fold$k"
    jumps "$up" "$k" true >"$data/up$k"
    jumps "$down" "$k" false >"$data/down$k"
done
torques=$(jq -r '[.design.load_cases[].torque_nm | . * 10 | round / 10 | tostring] | join(" ")' "$result")
name=$(jq -r '.job.name' "$result")

# gnuplot draws nothing from an empty file, and says so
for file in "$data"/*; do [ -s "$file" ] || echo "NaN NaN 0 0" >"$file"; done

gnuplot <<END
set terminal svg size 900,$((60 + 290 * cases)) font 'sans,12' background rgb 'white'
set output '$out'
set multiplot layout $cases,1 title '$name' noenhanced
set xrange [0.2:1.4]
set yrange [0:$top]
set xlabel 'mesh frequency / natural frequency'
set ylabel 'RMS of DTE / half-backlash'
set key outside right top samplen 2
set grid lc rgb '#e0e0e0'
colors = '#0072b2 #d55e00 #009e73 #888888'
label(n) = n == 1 ? 'period 1' : n == 2 ? 'period 2' : n == 3 ? 'period 3' : 'period 4 to 8'
do for [k=0:$((cases - 1))] {
    set title word('$torques', k + 1).' N m'
    plot for [n=1:4] '$data/unstable'.k.'-'.n using 1:2 with lines lw 1 dt (6,4) lc rgb word(colors, n) notitle, \\
         for [n=1:4] '$data/stable'.k.'-'.n using 1:2 with lines lw 2 lc rgb word(colors, n) title label(n), \\
         NaN with lines lw 1 dt (6,4) lc rgb '#444444' title 'unstable', \\
         '$data/up'.k using 1:2:3:4 with vectors filled head size screen 0.008,18 fixed lw 1 lc rgb '#cc0000' title 'jump, run-up', \\
         '$data/down'.k using 1:2:3:4 with vectors filled head size screen 0.008,18 fixed lw 1 lc rgb '#7a3db8' title 'jump, run-down', \\
         '$data/fold'.k using 1:2 with points pt 7 ps 0.35 lc rgb 'black' title 'fold'
}
END
