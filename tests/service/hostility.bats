#!/usr/bin/env bats
# Raw bytes that no honest client sends: everything in hostility.mjs gets an answer that its table allows, and honest requests
# are answered meanwhile. `make hostility` writes the table to docs/http_hostility.md, with 10 000 connections.

load helper

@test "hostile requests are refused in words or closed, and do no harm" {
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1
  run node "$QG_SOURCE/tests/service/hostility.mjs" "$URL"
  stop_daemon
  echo "$output" | grep -v '^|' >&2
  [ "$status" -eq 0 ]
}

@test "clients that ask in step are answered, however many there are" {
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1
  run node "$QG_SOURCE/tests/service/burst.mjs" "$URL" "$DAEMON" 126 127 128 129 256
  stop_daemon
  echo "$output" >&2
  [ "$status" -eq 0 ]
}
