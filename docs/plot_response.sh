#!/bin/sh
# Draws amplitude against frequency of an optimization, before and after, from its result document.
#   docs/plot_response.sh RESULT.json OUT.svg        (needs jq and gnuplot)
set -eu
[ $# = 2 ] || { echo "usage: $0 RESULT.json OUT.svg" >&2; exit 2; }
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT

cases=$(jq '.design.load_cases | length' "$1")
for part in reference design; do
    for k in $(seq 0 $((cases - 1))); do
        jq -r --arg part $part --argjson k "$k" '
            .[$part].load_cases[$k].frequency_response | [.frequency_ratio, .rms] | transpose[] | @tsv' "$1" >"$data/$part$k"
    done
done
torque() { jq -r --argjson k "$1" '.design.load_cases[$k].torque_nm | round' "$result"; }
result=$1
titles=
for k in $(seq 0 $((cases - 1))); do titles="$titles $(torque "$k")"; done
before=$(jq -r '.reference.f_dte * 1000 | round / 1000' "$1")
after=$(jq -r '.design.f_dte * 1000 | round / 1000' "$1")
top=$(jq '[.reference.f_dte, .design.f_dte] | max * 1.2' "$1")

gnuplot <<END
set terminal svg size 960,400 font 'sans,12' background rgb 'white'
set output '$2'
set multiplot layout 1,2
set xlabel 'mesh frequency / natural frequency'
set ylabel 'RMS of DTE / half-backlash'
set yrange [0:$top]
set key top center horizontal
set grid lc rgb '#dddddd'
colors = '#0072b2 #e69f00 #009e73 #cc79a7 #56b4e9 #d55e00'
do for [part in 'reference design'] {
    limit = part eq 'reference' ? $before : $after
    set title part eq 'reference' ? 'before: F_{DTE} = $before' : 'after: F_{DTE} = $after'
    set arrow 1 from graph 0,first limit to graph 1,first limit nohead dt 2 lc rgb '#888888'
    plot for [k=0:$((cases - 1))] '$data/'.part.k using 1:2 with lines lw 1.5 lc rgb word(colors, k+1) title word('$titles', k+1).' Nm'
}
END
