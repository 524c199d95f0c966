#!/usr/bin/env bats
# libFuzzer for FUZZ_SECONDS (60) at the numerical core, from the seeds: a build tree made with --enable-fuzzing only.

@test "libFuzzer finds no gears with which the numerical core breaks a promise" {
    cd "$QG_BUILD"
    run sh "$QG_SOURCE/tests/fuzz/explore.sh" core "${FUZZ_SECONDS:-60}" new
    printf '%s\n' "$output" | sed 's/^/# /' >&3
    [ "$status" -eq 0 ]
}
