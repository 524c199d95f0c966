#!/usr/bin/env bats
# libFuzzer for FUZZ_SECONDS (60) at the daemon, from the seeds: a build tree made with --enable-fuzzing only.

@test "libFuzzer finds no requests with which the daemon breaks a promise" {
    cd "$QG_BUILD"
    run sh "$QG_SOURCE/tests/fuzz/explore.sh" http "${FUZZ_SECONDS:-60}" new
    printf '%s\n' "$output" | sed 's/^/# /' >&3
    [ "$status" -eq 0 ]
}
