#!/usr/bin/env bats
# What the daemon refuses, and how it says so; and that it stays well meanwhile.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

teardown() {
  ask /healthz -f | jq -e '.status == "ok"'
}

# Sends raw bytes, in one piece, on a connection of its own and prints what comes back.
raw() {
  local port=${URL##*:}
  exec 9<>"/dev/tcp/127.0.0.1/$port"
  printf "$1" | cat >&9 || true
  timeout "$PATIENCE" cat <&9 || true
  exec 9>&-
}

post() {
  status_of /v1/jobs -H 'Content-Type: application/json' --data-binary "$@"
}

@test "every document of the table is refused with its status and pointer" {
  while IFS=$'\t' read -r file status pointer schema; do
    case $file in '' | \#*) continue ;; esac
    [ "$pointer" = '""' ] && pointer=
    got=$(post "@$QG_SOURCE/tests/schema/bad/$file")
    [ "$got" = "$status" ] || { echo "$file: $got instead of $status" >&2; return 1; }
    body | jq -e --arg pointer "$pointer" '.errors | any(.pointer == $pointer)' || { echo "$file: $(body)" >&2; return 1; }
  done <"$QG_SOURCE/tests/schema/bad.tsv"
}

@test "all faults of a document come at once" {
  [ "$(document '.gear_pair.pinion.teeth = 0 | .objective = "beauty" | .color = "red"' | post @-)" = 422 ]
  assert_problem 422 invalid-document
  body | jq -e '[.errors[].pointer] | contains(["/gear_pair/pinion/teeth", "/objective", "/color"])'
  body | jq -e 'all(.errors[]; .detail != "")'
}

@test "what is not JSON is a 400" {
  [ "$(post '{"kind":')" = 400 ]
  assert_problem 400 not-json
  [ "$(post '')" = 400 ]
  assert_problem 400 not-json
}

@test "a body must say that it is JSON" {
  [ "$(document | status_of /v1/jobs --data-binary @-)" = 415 ]
  assert_problem 415 unsupported-media-type
  [ "$(document | status_of /v1/jobs -H 'Content-Type:' --data-binary @-)" = 415 ]
}

@test "too large a body is refused, by its announcement before a byte of it is read" {
  answer=$(raw 'POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 2147483648\r\n\r\n')
  [[ "$answer" == 'HTTP/1.1 413 '* ]]
  head -c 1048577 /dev/zero | tr '\0' ' ' >"$BATS_TEST_TMPDIR/large"
  [ "$(post "@$BATS_TEST_TMPDIR/large")" = 413 ]
  head -c 20000000 /dev/zero | tr '\0' ' ' >"$BATS_TEST_TMPDIR/larger" # sent without asking: its sender reads the answer all the same
  for _ in 1 2 3; do
    [ "$(post "@$BATS_TEST_TMPDIR/larger" -H 'Expect:')" = 413 ]
  done
  [ "$(post "@$BATS_TEST_TMPDIR/large" -H 'Transfer-Encoding: chunked')" = 413 ]
  assert_problem 413 too-large
  head -c 1048576 "$BATS_TEST_TMPDIR/large" >"$BATS_TEST_TMPDIR/largest"
  [ "$(post "@$BATS_TEST_TMPDIR/largest")" = 400 ]
}

@test "a chunked document is as good as any" {
  id=$(document | submit -H 'Transfer-Encoding: chunked')
  remove "$id"
}

@test "nothing is where nothing is" {
  for path in /v1 /v1/job /v1/jobs/ /v1/jobs/nobody /v1/jobs/nobody/result /nothing /assets/none.css /assets/local.mk; do
    status_of "$path"
    grep -qE '^HTTP/1.1 40[04]' "$BATS_TEST_TMPDIR/header"
    [ "$(header Content-Type)" = application/problem+json ]
  done
  [ "$(status_of /v1/jobs/nobody/cancel -X POST)" = 404 ]
  [ "$(status_of /v1/jobs/nobody -X DELETE)" = 404 ]
}

@test "a method that a path does not know gets 405 and the ones that it does" {
  [ "$(status_of /v1/jobs -X PUT -d x)" = 405 ]
  assert_problem 405 method-not-allowed
  [ "$(header Allow)" = 'GET, HEAD, POST' ]
  [ "$(status_of /v1/jobs/x -X PATCH)" = 405 ]
  [ "$(header Allow)" = 'GET, HEAD, DELETE' ]
  [ "$(status_of /v1/jobs/x/cancel)" = 405 ]
  [ "$(header Allow)" = POST ]
}

@test "a media type that is not to be had gets 406" {
  for path in /v1/jobs /v1/jobs/x /v1/jobs/x/result /v1/jobs/x/evaluations /; do
    [ "$(status_of "$path" -H 'Accept: image/png')" = 406 ]
    assert_problem 406 not-acceptable
  done
}

@test "no path leads out of the served directories" {
  for path in '/../etc/passwd' '/assets/../local.mk' '/assets/..%2flocal.mk' '/assets/%2e%2e/x' '/v1/schemas/..' \
    '/assets/%00' '/v1/jobs%00' '/assets/page.js%00.css' '/v1/schemas/.' '//etc/passwd' '/assets/a%5cb'; do
    [ "$(status_of "$path" --path-as-is)" = 400 ]
    assert_problem 400 malformed-request
  done
}

@test "requests that two programs could read differently are refused, and their rest is not another request" {
  smuggled='GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n'
  for header in 'Content-Length: 4\r\nTransfer-Encoding: chunked' 'Content-Length: 0\r\nContent-Length: 4' \
    'Host: 127.0.0.1' 'Transfer-Encoding: gzip, chunked' 'Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked' \
    'Content-Length: 4\r\nTransfer-Encoding : chunked'; do
    answer=$(raw "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n$header\r\n\r\n0\r\n\r\n$smuggled")
    [[ "$answer" == 'HTTP/1.1 400 '* ]]
    [ "$(grep -c '^HTTP/1.1' <<<"$answer")" = 1 ]
  done
}

@test "garbage does no harm" {
  raw 'GET\r\n\r\n' || true
  raw '\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03' || true
  raw 'GET / HTTP/1.1\r\n\r\n' | grep -q '^HTTP/1.1 400'
  for i in {1..40}; do
    head -c 2000 /dev/urandom >"/dev/tcp/127.0.0.1/${URL##*:}" || true
  done
}

@test "a client that goes away in the middle of its body or its wait does no harm" {
  printf 'POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n{' \
    >"/dev/tcp/127.0.0.1/${URL##*:}"
  busy=$(endless | submit)
  queued=$(document | submit)
  for i in {1..10}; do
    timeout 0.2 curl -sS -H 'Prefer: wait=30' "$URL/v1/jobs/$queued" -o /dev/null 3>&- &
  done
  wait
  remove "$queued"
  remove "$busy"
}

@test "the log has no line that a client wrote" {
  status_of '/v1/jobs/%0a<1>forged' --path-as-is
  ask '/v1/jobs/x' -X DELETE -o /dev/null
  run ! grep -vE '^[0-9-]{10}T[0-9:.]{12}Z [a-z]+: ' "$STATE.log"
  run ! grep forged "$STATE.log"
}
