#!/usr/bin/env bats
# What HTTP itself promises: entity tags, compression, content encodings, hosts and origins, readiness.

load helper

setup_file() {
  start_for_file --jobs 1 --allowed-hosts gears.example
  id=$(document '.analysis.speeds.count = 300' | submit)
  wait_for "$id" '.state == "succeeded"'
  echo "$id" >"$BATS_FILE_TMPDIR/id"
}

teardown_file() {
  stop_daemon
}

setup() {
  id=$(cat "$BATS_FILE_TMPDIR/id")
}

@test "every GET of a text has an entity tag, and 304 for who has it already" {
  for path in / /assets/page.js /v1/jobs "/v1/jobs/$id" "/v1/jobs/$id/result" "/v1/jobs/$id/document" /v1/examples \
    "/v1/jobs/$id/frequency-response" /v1/examples/case_S_none /v1/schemas/job.schema.json; do
    [ "$(status_of "$path")" = 200 ]
    etag=$(header ETag)
    [ -n "$etag" ]
    [ "$(status_of "$path" -H "If-None-Match: $etag")" = 304 ]
    [ "$(body | wc -c)" = 0 ]
    [ "$(header ETag)" = "$etag" ]
    [ "$(status_of "$path" -H 'If-None-Match: "other"')" = 200 ]
    # the tag of the compressed form is good as well
    status_of "$path" -H 'Accept-Encoding: gzip'
    [ "$(status_of "$path" -H "If-None-Match: $(header ETag)")" = 304 ]
  done
}

@test "texts and streams are compressed for who takes gzip, and are the same" {
  for path in /assets/page.js /v1/schemas/job.schema.json "/v1/jobs/$id/result" "/v1/jobs/$id/frequency-response" "/v1/jobs/$id/evaluations"; do
    [ "$(status_of "$path" -H 'Accept-Encoding: gzip')" = 200 ]
    [ "$(header Content-Encoding)" = gzip ]
    [[ "$(header Vary)" == *Accept-Encoding* ]]
    gunzip <"$BATS_TEST_TMPDIR/body" >"$BATS_TEST_TMPDIR/unpacked"
    packed=$(wc -c <"$BATS_TEST_TMPDIR/body")
    [ "$(status_of "$path" -H 'Accept-Encoding: gzip;q=0')" = 200 ]
    [ -z "$(header Content-Encoding)" ]
    cmp "$BATS_TEST_TMPDIR/body" "$BATS_TEST_TMPDIR/unpacked"
    [ "$packed" -lt "$(wc -c <"$BATS_TEST_TMPDIR/body")" ]
  done
}

@test "HEAD has the header of GET and no body" {
  for path in / "/v1/jobs/$id" "/v1/jobs/$id/result" "/v1/jobs/$id/evaluations" /v1/events; do
    code=$(curl -sS -I -o "$BATS_TEST_TMPDIR/head" -w '%{http_code}' "$URL$path")
    [ "$code" = 200 ]
    grep -qi '^content-type' "$BATS_TEST_TMPDIR/head"
  done
}

@test "a compressed body is refused with what is taken" {
  [ "$(document | gzip | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Content-Encoding: gzip' --data-binary @-)" = 415 ]
  assert_problem 415 unsupported-content-encoding
  [ "$(header Accept-Encoding)" = identity ]
}

@test "a wait that makes no sense is refused with what is allowed" {
  for wait in 0 -1 x 1.5 '' 99999999; do
    [ "$(status_of "/v1/jobs/$id" -H "Prefer: wait=$wait")" = 400 ]
    assert_problem 400 bad-parameter
    body | jq -e '.detail | test("from 1 to")'
  done
  [ "$(status_of "/v1/jobs/$id" -H 'Prefer: respond-async')" = 200 ]
  [ "$(status_of "/v1/jobs/$id" -H 'Prefer: wait=500')" = 200 ]
  [ "$(header Preference-Applied)" = wait=60 ]
}

@test "only our own names are answered" {
  for host in localhost 127.0.0.1 '[::1]:99' gears.example GEARS.example:80; do
    [ "$(status_of /v1/jobs -H "Host: $host")" = 200 ]
  done
  for host in evil.example localhost.evil.example; do
    [ "$(status_of /v1/jobs -H "Host: $host")" = 421 ]
    assert_problem 421 misdirected-request
  done
}

@test "a page elsewhere cannot change anything" {
  for header in 'Origin: http://evil.example' 'Origin: null' 'Origin: http://127.0.0.1:1' 'Sec-Fetch-Site: cross-site'; do
    [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' -H "$header" --data-binary @-)" = 403 ]
    assert_problem 403 cross-origin
    [ "$(status_of "/v1/jobs/$id" -X DELETE -H "$header")" = 403 ]
    [ "$(status_of "/v1/jobs/$id/cancel" -X POST -H "$header")" = 403 ]
  done
  for header in "Origin: $URL" 'Origin: https://gears.example' 'Sec-Fetch-Site: same-origin'; do
    [ "$(document | status_of /v1/check -H 'Content-Type: application/json' -H "$header" --data-binary @-)" = 200 ]
  done
}

@test "it says when it is ready" {
  ask /readyz -f | jq -e '.status == "ready"'
}

@test "directories that are not there are refused at the start" {
  run "$QUIETGEARD" --config /dev/null --web-dir /nonexist --schema-dir "$QG_SOURCE/schema" --check-config
  [ "$status" -eq 2 ]
  [[ "$output" == *web-dir*/nonexist* ]]
  run "$QUIETGEARD" --config /dev/null --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/README.md" --check-config
  [ "$status" -eq 2 ]
  [[ "$output" == *schema-dir*README* ]]
  run "$QUIETGEARD" --config /dev/null --allowed-hosts 'http://x' --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" --check-config
  [ "$status" -eq 2 ]
  "$QUIETGEARD" --config /dev/null --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" --check-config
}
