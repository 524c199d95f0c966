#!/bin/sh
# Lets libFuzzer explore with one harness: explore.sh NAME SECONDS, in a build tree made with --enable-fuzzing.
#
# The corpus is fuzz-corpus/NAME, begun with the harness's seeds and kept small: what adds nothing is left out at the end.
# One JSON line about the run goes to reliability/fuzzing-NAME.jsonl. Whatever breaks a promise is left as crash-*, leak-* or
# timeout-* in fuzz-findings/, and the exit status is 1; tests/fuzz/fuzz_NAME --file shows it again.
set -eu
name=$1 seconds=$2
corpus=fuzz-corpus/$name findings=fuzz-findings seeds=$(mktemp -d) merged=$(mktemp -d)
trap 'rm -rf "$seeds" "$merged"' EXIT
mkdir -p "$corpus" "$findings" reliability
"tests/fuzz/fuzz_$name" --write-corpus "$seeds"
"tests/fuzz/fuzz_$name" --write-words "$seeds.words"
mv "$seeds.words" "fuzz-corpus/$name.words"
log=fuzz-corpus/$name.log
# Leaks are looked for at the end only: daemons and BLAS keep what they have until then.
options="-max_len=16384 -timeout=60 -rss_limit_mb=3000 -print_final_stats=1 -artifact_prefix=$findings/ -detect_leaks=1"
[ ! -s "fuzz-corpus/$name.words" ] || options="$options -dict=fuzz-corpus/$name.words"
status=0
# shellcheck disable=SC2086 # a list of options
"tests/fuzz/explore_$name" $options -max_total_time="$seconds" "$corpus" "$seeds" >"$log" 2>&1 || status=$?
inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -n 1)
covered=$(grep -oE 'cov: [0-9]+ ft: [0-9]+' "$log" | tail -n 1)
if [ "$status" = 0 ]; then
    "tests/fuzz/explore_$name" -merge=1 -max_len=16384 -timeout=60 "$merged" "$corpus" "$seeds" >"$log.merge" 2>&1 &&
        rm -rf "$corpus" && cp -r "$merged" "$corpus"
else
    tail -n 60 "$log" >&2
fi
kept=$(find "$corpus" -type f | wc -l)
cat >reliability/fuzzing-about.jsonl <<'TEXT'
{"text":"`make fuzz`: libFuzzer under AddressSanitizer and UndefinedBehaviorSanitizer, one harness after another. Harnesses check promises, not only that nothing crashes: `tests/fuzz/fuzz_*.c` say which. `document` is the reader of job documents, `core` goes from a gear pair to its vibration, `http` sends raw bytes to a whole daemon."}
TEXT
# shellcheck disable=SC2086 # three words and a number
set -- $covered
printf '{"row":{"fuzzer":"%s","seconds":%s,"inputs":%s,"edges covered":%s,"features":%s,"inputs kept":%s,"findings":%s}}\n' \
    "$name" "$seconds" "${inputs:-0}" "${2:-0}" "${4:-0}" "$kept" "$([ "$status" = 0 ] && echo 0 || echo 1)" |
    tee "reliability/fuzzing-$name.jsonl"
exit "$status"
