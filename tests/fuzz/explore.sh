#!/bin/sh
# Lets libFuzzer explore with one harness, in a build tree made with --enable-fuzzing:
#   explore.sh NAME SECONDS       from the corpus of former runs, which is kept
#   explore.sh NAME SECONDS new   from the harness's seeds alone; nothing is kept but findings
#
# The corpus is fuzz-corpus/NAME, begun with the harness's seeds and kept small: what adds nothing is left out at the end.
# One JSON line about the run is printed, and goes to reliability/fuzzing-NAME.jsonl unless nothing is kept. Whatever breaks a
# promise is left as crash-*, leak-*, oom-* or timeout-* in fuzz-findings/; the exit status is 1, and the last lines say where the
# input is and how to see it again.
set -eu
name=$1 seconds=$2 keep=${3:-keep}
findings=fuzz-findings work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
seeds=$work/seeds merged=$work/merged corpus=fuzz-corpus/$name
[ "$keep" = keep ] || corpus=$work/corpus
mkdir -p "$corpus" "$seeds" "$merged" "$findings" fuzz-corpus
"tests/fuzz/fuzz_$name" --write-corpus "$seeds"
"tests/fuzz/fuzz_$name" --write-words "fuzz-corpus/$name.words"
log=fuzz-corpus/$name.log

explore() {
    # Leaks are looked for at the end only: daemons and BLAS keep what they have until then.
    set -- -max_len=16384 -timeout=60 -rss_limit_mb=3000 -print_final_stats=1 "-artifact_prefix=$findings/" -detect_leaks=1 \
        "-max_total_time=$seconds"
    [ ! -s "fuzz-corpus/$name.words" ] || set -- "$@" "-dict=fuzz-corpus/$name.words"
    "tests/fuzz/explore_$name" "$@" "$corpus" "$seeds" >"$log" 2>&1
}

# Leaves out of the corpus what adds nothing.
shrink() {
    "tests/fuzz/explore_$name" -merge=1 -max_len=16384 -timeout=60 "$merged" "$corpus" "$seeds" >"$log.merge" 2>&1 &&
        rm -rf "$corpus" && cp -r "$merged" "$corpus"
}

row() { # row FINDINGS
    inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -n 1)
    covered=$(grep -oE 'cov: [0-9]+ ft: [0-9]+' "$log" | tail -n 1)
    kept=$(find "$corpus" -type f | wc -l)
    # shellcheck disable=SC2086 # cov: N ft: N
    set -- "$1" ${covered:-cov: 0 ft: 0}
    printf '{"row":{"fuzzer":"%s","seconds":%s,"inputs":%s,"edges covered":%s,"features":%s,"inputs kept":%s,"findings":%s}}\n' \
        "$name" "$seconds" "${inputs:-0}" "$3" "$5" "$kept" "$1"
}

about() {
    cat <<'TEXT'
{"text":"`make fuzz`: libFuzzer under AddressSanitizer and UndefinedBehaviorSanitizer, one harness after another. Harnesses check promises, not only that nothing crashes: `tests/fuzz/fuzz_*.c` say which. `document` is the reader of job documents, `core` goes from a gear pair to its vibration, `http` sends raw bytes to a whole daemon."}
TEXT
}

# The end of the log, the input's path, and the command that judges it again.
say_finding() {
    tail -n 60 "$log" | cut -c 1-2000
    input=$(sed -n 's/.*Test unit written to \(.*\/\(crash\|leak\|oom\|timeout\)-\)/\1/p' "$log" | tail -n 1)
    if [ -n "$input" ]; then
        echo "The input is $PWD/$input. Again:"
        echo "  cd $PWD && QG_SOURCE='${QG_SOURCE:-.}' tests/fuzz/fuzz_$name --file $input"
    else
        echo "No input was kept: it came to light at the end of the run. The whole log is $PWD/$log."
    fi
} >&2

status=0
explore || status=$?
if [ "$status" = 0 ] && [ "$keep" = keep ]; then
    shrink || echo "$corpus cannot be made smaller: see $log.merge" >&2
fi
line=$(row "$([ "$status" = 0 ] && echo 0 || echo 1)")
printf '%s\n' "$line"
if [ "$keep" = keep ]; then
    mkdir -p reliability
    about >reliability/fuzzing-about.jsonl
    printf '%s\n' "$line" >"reliability/fuzzing-$name.jsonl"
fi
[ "$status" = 0 ] || say_finding
exit "$status"
