#!/bin/sh
# Compares the search methods and writes docs/searches.md, tables and who wins them:
#   docs/searches.sh PROGRAM [SEEDS [SPEEDS]]      PROGRAM: tests/bench/compare_searches
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$1 seeds=${2:-10} speeds=${3:-100}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" "$here/../schema/examples" "$seeds" "$speeds" >"$work/tables"

# winners COLUMN_OF_CASE COLUMN_OF_MEDIAN SIGN: of each case the method with the smallest (or, with -1, largest) median.
winners() {
    awk -F ' *[|] *' -v sign="$1" '$2 == "case" || $2 == "case, objective" || NF < 7 || $2 ~ /^-/ {next}
        {m = sign * $5; if (!($2 in best) || m < best[$2]) {best[$2] = m; who[$2] = $3; value[$2] = $5}
         if ($3 == "random_simplex") base[$2] = $5
         if (!($2 in seen)) {seen[$2] = 1; order[++n] = $2}}
        END {for (i = 1; i <= n; i++) {c = order[i]
             printf "- %s: %s, %s", c, who[c], value[c]
             if (c in base && who[c] != "random_simplex") printf " (random_simplex %s)", base[c]
             print ""}}'
}

{
    cat <<END
# Which search

Written by \`make compare-searches\` (\`tests/bench/compare_searches.c\`): seeds 1 to $seeds, $speeds speeds instead of the
documents' own, to make it affordable; both objectives of the cases S with four parameters and H with four and eight. With every
seed each method gets exactly as many evaluations as Random-Simplex has made with it: the paper's 180, 200 or 300 random samples
and 80 simplex iterations. \`f_pps\` in µm.

$(sed '/^$/,$d' "$work/tables")

Smallest median:

$(sed '/^$/,$d' "$work/tables" | winners 1)

Two objectives at once, \`f_pps\` and \`f_dte\`: the share that the front dominates of the box between nothing and the reference, at
the same numbers of evaluations.

$(sed '1,/^$/d' "$work/tables")

Largest median:

$(sed '1,/^$/d' "$work/tables" | winners -1)

In the program are Random-Simplex, because it is the paper's, and \`multistart_simplex\`, the low-discrepancy samples being its first
part. CMA-ES, differential evolution and NSGA-II are not: they are in \`tests/bench/candidates.c\`, so that this table can be
printed again. Budgets of some hundred evaluations are short for populations; a simplex makes use of every single one.

How it works: \`core/multistart.h\`. What it is asked with: \`optimizer\` and \`objectives\` in \`schema/job.schema.json\`, for example
\`schema/examples/case_H_optimize_8_multistart.json\` and \`case_S_pareto.json\`.
END
} >"$work/page"
cp "$work/page" "$here/searches.md"
