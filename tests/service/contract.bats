#!/usr/bin/env bats
# The OpenAPI document and the schemas say what the daemon does: every call and refusal is held against the one, documents
# mutated from the examples against the other.

load helper

setup() {
  [ -d "$QG_SOURCE/tests/node_modules/ajv" ] || skip "no validator: run npm ci in tests/"
}

@test "every response is one that the OpenAPI document promises, and it lists every call" {
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1 --webhook-allow http://127.0.0.1:9/hooks --webhook-networks 127.0.0.0/8
  run node "$QG_SOURCE/tests/service/contract.mjs" "$URL" "$(cat "$BATS_TEST_TMPDIR/state/admin.token")" "$QG_SOURCE"
  stop_daemon
  echo "$output"
  [ "$status" -eq 0 ]
}

@test "the daemon and the JSON Schema judge mutated documents alike, but for what a schema cannot say" {
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1
  run node "$QG_SOURCE/tests/service/agreement.mjs" "$URL" "$QG_SOURCE"
  stop_daemon
  echo "$output"
  [ "$status" -eq 0 ]
}
