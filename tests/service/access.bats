#!/usr/bin/env bats
# Who is let in: tokens and scopes, limits, TLS, pages of other origins, the audit log.

load helper

setup_file() {
  start_for_file --listen 0.0.0.0:0 --jobs 1 --token-jobs 3 \
    --cors-origins "https://plm.example.com http://tools.example.com:8080"
  export QUIETGEAR_SERVER=$URL QUIETGEAR=$QG_BUILD/quietgear
  ADMIN=$(cat "$STATE/admin.token")
  READER=$("$QUIETGEAR" token create reader --scopes read -f "$STATE/admin.token")
  WRITER=$("$QUIETGEAR" token create writer --scopes read,submit -f "$STATE/admin.token")
  export ADMIN READER WRITER
}

teardown_file() {
  stop_daemon
}

as() {
  echo "Authorization: Bearer $1"
}

post_token() {
  status_of /v1/tokens -H "$(as "$ADMIN")" -H 'Content-Type: application/json' -d "$1"
}

@test "without a token only the page, its parts, the schemas and /healthz are to be had" {
  for path in / /assets/page.js /healthz /v1/schemas/job.schema.json; do
    [ "$(status_of "$path")" = 200 ]
  done
  for path in /v1/jobs /v1/jobs/x /v1/jobs/x/result /v1/jobs/x/evaluations /v1/tokens /v1/audit; do
    [ "$(status_of "$path")" = 401 ]
    assert_problem 401 unauthorized
    [ "$(header WWW-Authenticate)" = 'Bearer realm="quietgear"' ]
  done
  for method in POST DELETE; do
    status_of /v1/tokens -X POST -d x
    assert_problem 401 unauthorized
  done
  [ "$(status_of /v1/jobs/x -X DELETE)" = 401 ]
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' --data-binary @-)" = 401 ]
}

@test "the first admin token is for the daemon's user alone" {
  [ "$(stat -c %a "$STATE/admin.token")" = 600 ]
  [[ "$ADMIN" =~ ^qg_[0-9a-f]{12}_[0-9a-f]{64}$ ]]
  run -1 grep -q "${ADMIN##*_}" "$STATE.log" "$STATE/quietgear.db" "$STATE/quietgear.db-wal"
}

@test "a wrong token is a 401 whatever is wrong with it; two tokens are one too many" {
  for field in 'Bearer x' 'Basic eDp5' "Bearer ${ADMIN%?}" "Bearer ${ADMIN}0" "Bearer qg_${ADMIN:3:12}_${READER:16}"; do
    [ "$(status_of /v1/jobs -H "Authorization: $field")" = 401 ]
    assert_problem 401 unauthorized
    [ "$(header WWW-Authenticate)" = 'Bearer realm="quietgear", error="invalid_token"' ]
  done
  [ "$(status_of /v1/jobs -H "$(as "$READER")" -H "$(as "$ADMIN")")" = 400 ]
  assert_problem 400 malformed-request
}

@test "a token in the address opens nothing" {
  [ "$(status_of "/v1/jobs?token=$READER")" = 401 ]
  [ "$(status_of "/v1/jobs?access_token=$READER")" = 401 ]
}

@test "a token does what its scopes cover; 403 names the one that is missing" {
  [ "$(status_of /v1/jobs -H "$(as "$READER")")" = 200 ]
  [ "$(document | status_of /v1/jobs -H "$(as "$READER")" -H 'Content-Type: application/json' --data-binary @-)" = 403 ]
  assert_problem 403 insufficient-scope
  body | jq -e '.detail == "the scope submit is missing"'
  [ "$(header WWW-Authenticate)" = 'Bearer realm="quietgear", error="insufficient_scope", scope="submit"' ]
  [ "$(status_of /v1/tokens -H "$(as "$WRITER")")" = 403 ]
  body | jq -e '.detail == "the scope admin is missing"'
  id=$(document | submit -H "$(as "$WRITER")")
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST -H "$(as "$READER")")" = 403 ]
  [ "$(status_of "/v1/jobs/$id" -X DELETE -H "$(as "$READER")")" = 403 ]
  [[ "$(status_of "/v1/jobs/$id/cancel" -X POST -H "$(as "$WRITER")")" == 20? ]]
}

@test "tokens are made, listed and revoked while the daemon runs" {
  token=$("$QUIETGEAR" token create 'for a while' --scopes read -f "$STATE/admin.token")
  [ "$(status_of /v1/jobs -H "$(as "$token")")" = 200 ]
  id=$("$QUIETGEAR" token list -f "$STATE/admin.token" | awk '/for a while/ {print $1}')
  [ "$id" = "${token:3:12}" ]
  ask /v1/tokens -H "$(as "$ADMIN")" | jq -e --arg id "$id" '.tokens[] | select(.id == $id)
    | .name == "for a while" and .scopes == ["read"] and (has("token") or has("hash") | not)'
  QUIETGEAR_TOKEN=$ADMIN "$QUIETGEAR" token revoke "$id"
  [ "$(status_of /v1/jobs -H "$(as "$token")")" = 401 ]
  run -2 env QUIETGEAR_TOKEN=$ADMIN "$QUIETGEAR" token revoke "$id"
  [ "$(post_token '{"name":"","scopes":["all"],"colour":1}')" = 422 ]
  body | jq -e '[.errors[].pointer] == ["/colour", "/name", "/scopes"]'
}

# Makes a token that lives for $1 seconds, uses it and opens a stream with it; sets token. Status 1 when the machine was too slow
# for so brief a life, which is told by its clock.
use_brief_token() {
  local soon
  rm -f "$BATS_TEST_TMPDIR/opened"
  soon=$(date -u -d "+$1 seconds" +%FT%TZ)
  if [ "$(post_token "{\"name\": \"brief\", \"scopes\": [\"read\"], \"expires_at\": \"$soon\"}")" = 201 ]; then
    token=$(body | jq -r .token)
    body | jq -e --arg soon "$soon" '.expires_at == ($soon | sub("Z"; ".000Z")) and (.expired | not) and .last_used_at == null' || exit 1
    if [ "$(status_of /v1/jobs -H "$(as "$token")")" = 200 ]; then
      curl -sS -N -m "$PATIENCE" -D "$BATS_TEST_TMPDIR/opened" -H "$(as "$token")" "$URL/v1/events" -o "$BATS_TEST_TMPDIR/stream" 3>&- &
      stream=$!
      await grep -q '^HTTP/1.1 ' "$BATS_TEST_TMPDIR/opened" 2>/dev/null
      grep -q '^HTTP/1.1 200' "$BATS_TEST_TMPDIR/opened" && return 0
    fi
  fi
  [ "$(date +%s)" -ge "$(date -d "$soon" +%s)" ] || { echo "refused before its time"; exit 1; }
  return 1
}

@test "a token expires at its time, and the list says so" {
  for life in 2 6 20 60; do
    if use_brief_token "$life"; then break; fi
  done
  grep -q '^HTTP/1.1 200' "$BATS_TEST_TMPDIR/opened"
  await answers 401 /v1/jobs -H "$(as "$token")"
  assert_problem 401 unauthorized
  body | jq -e '.detail == "the access token has expired"'
  grep -q "warning: access denied: a token that has expired, scope read, address 127.0.0.1" "$LOG"
  [ "$(header WWW-Authenticate)" = 'Bearer realm="quietgear", error="invalid_token", error_description="expired"' ]
  ask /v1/tokens -H "$(as "$ADMIN")" | jq -e --arg id "${token:3:12}" '.tokens[] | select(.id == $id)
    | .expired and .last_used_at != null and .requests_per_minute == null and .queued_jobs == null'
  "$QUIETGEAR" token list -f "$STATE/admin.token" | grep "${token:3:12}" | awk '{print $5, $NF}' | grep -qx 'expired brief'
  wait "$stream" # it has ended by itself: 28 were curl's time-out
  [ "$(post_token '{"name": "late", "scopes": ["read"], "expires_at": "2020-01-01T00:00:00Z"}')" = 422 ]
  body | jq -e '[.errors[] | .pointer + ": " + .detail] == ["/expires_at: found a time that is over, allowed is one to come"]'
  [ "$(post_token '{"name": "x", "scopes": ["read"], "expires_at": "soon", "requests_per_minute": 0, "queued_jobs": 1.5}')" = 422 ]
  body | jq -e '[.errors[].pointer] == ["/expires_at", "/requests_per_minute", "/queued_jobs"]'
}

@test "limits of a token's own go before the daemon's" {
  token=$("$QUIETGEAR" token create slow --requests-per-minute 4 --queued-jobs 1 --days 30 -f "$STATE/admin.token")
  read -r _ _ made until state used rate jobs name < <("$QUIETGEAR" token list -f "$STATE/admin.token" | grep "^${token:3:12}")
  [ "$state $used $rate $jobs $name" = 'valid - 4 1 slow' ]
  [ $(($(date -d "$until" +%s) - $(date -d "$made" +%s))) -ge $((30 * 86400 - 2)) ]
  id=$(endless | submit -H "$(as "$token")")
  [ "$(endless | status_of /v1/jobs -H "$(as "$token")" -H 'Content-Type: application/json' --data-binary @-)" = 429 ]
  assert_problem 429 queue-full
  [ "$(status_of "/v1/jobs/$id" -H "$(as "$token")")" = 200 ]
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST -H "$(as "$token")")" != 429 ]
  await answers 429 /v1/jobs -H "$(as "$token")" # at once, unless the four took 15 s
  assert_problem 429 too-many-requests
  [[ "$(header Retry-After)" =~ ^([1-9]|1[0-5])$ ]] # one each 15 s
  ask "/v1/jobs/$id/cancel" -X POST -H "$(as "$ADMIN")" -o /dev/null
  for option in '--days 0' '--days x' '--requests-per-minute 1e3' '--queued-jobs 100001' '--days=36501'; do
    run -2 "$QUIETGEAR" token create x $option -f "$STATE/admin.token"
    [[ "$output" == 'quietgear: token: --'*': found "'*'", allowed is a whole number from 1 to '* ]]
  done
  run -2 "$QUIETGEAR" token list --days 3
}

@test "the event stream of a revoked token ends" {
  token=$("$QUIETGEAR" token create stream --scopes read -f "$STATE/admin.token")
  [ "$(status_of /v1/events)" = 401 ]
  open_stream "$BATS_TEST_TMPDIR/stream" /v1/events -H "$(as "$token")"
  QUIETGEAR_TOKEN=$ADMIN "$QUIETGEAR" token revoke "${token:3:12}"
  id=$(document | submit -H "$(as "$WRITER")") # something happens, and is not told
  wait "$STREAM" # by itself: 28 were curl's time-out
  run ! grep -q "$id" "$BATS_TEST_TMPDIR/stream"
}

@test "the command line takes its token from a file or the environment, and none from its arguments" {
  cd "$BATS_TEST_TMPDIR"
  document >job.json
  run -1 "$QUIETGEAR" submit job.json
  [[ "$output" == 'job.json: A valid access token is needed: '* ]]
  echo "$WRITER" >token
  id=$("$QUIETGEAR" submit job.json --token-file token)
  QUIETGEAR_TOKEN=$WRITER "$QUIETGEAR" watch "$id"
  QUIETGEAR_TOKEN_FILE=token "$QUIETGEAR" result "$id" -o result.json
  jq -e .design result.json
  run -1 env QUIETGEAR_TOKEN="$READER" "$QUIETGEAR" cancel "$id"
  [[ "$output" == *'the scope submit is missing' ]]
  run -2 "$QUIETGEAR" submit job.json --token-file nowhere
  : >empty
  run -2 "$QUIETGEAR" submit job.json --token-file empty
  [ "$output" = 'empty: holds no access token' ]
  run -2 "$QUIETGEAR" token frobnicate
  run -2 "$QUIETGEAR" token create
  run -2 "$QUIETGEAR" submit job.json --scopes read
}

@test "a token has so many jobs waiting at a time" {
  token=$("$QUIETGEAR" token create queue -f "$STATE/admin.token")
  for i in 1 2 3; do
    ids+=("$(endless | submit -H "$(as "$token")")")
  done
  [ "$(endless | status_of /v1/jobs -H "$(as "$token")" -H 'Content-Type: application/json' --data-binary @-)" = 429 ]
  assert_problem 429 queue-full
  body | jq -e '.detail | startswith("the access token has as many jobs queued or running as it may")'
  [ "$(header Retry-After)" = 30 ]
  id=$(document | submit -H "$(as "$WRITER")") # another's queue is not affected
  for i in "${ids[@]}"; do
    ask "/v1/jobs/$i/cancel" -X POST -H "$(as "$token")" -f -o /dev/null
  done
  await eval 'ask "/v1/jobs/${ids[0]}" -H "$(as "$token")" | jq -e ".state == \"cancelled\""'
  id=$(document | submit -H "$(as "$token")")
  [ "$id" != null ]
}

@test "a token makes so many requests a second" {
  start_daemon "$BATS_TEST_TMPDIR/own" --token-rate 1 # a second, and ten at once after a rest
  admin=$(cat "$BATS_TEST_TMPDIR/own/admin.token")
  token=$("$QUIETGEAR" token create hasty --scopes read -f "$BATS_TEST_TMPDIR/own/admin.token" --server "$URL")
  # each second that the machine takes for these earns another, so it would have to take minutes to be refused none
  for ((i = 0; i < 300; i++)); do
    printf 'url = "%s/v1/jobs?limit=1"\noutput = /dev/null\n' "$URL"
  done >"$BATS_TEST_TMPDIR/requests"
  curl -sS -H "$(as "$token")" -K "$BATS_TEST_TMPDIR/requests" -w '%{http_code} %header{retry-after}\n' >"$BATS_TEST_TMPDIR/codes"
  sort "$BATS_TEST_TMPDIR/codes" | uniq -c
  [ "$(head -n 10 "$BATS_TEST_TMPDIR/codes" | grep -c '^200')" = 10 ]
  grep -q '^429 1$' "$BATS_TEST_TMPDIR/codes"
  [ "$(status_of /v1/jobs -H "$(as "$admin")")" = 200 ]
  stop_daemon
}

@test "the audit log says who did what, newest first, to an admin" {
  id=$(endless | submit -H "$(as "$WRITER")")
  ask "/v1/jobs/$id/cancel" -X POST -H "$(as "$ADMIN")" -o /dev/null
  await answers 204 "/v1/jobs/$id" -X DELETE -H "$(as "$WRITER")"
  ask '/v1/audit?limit=3' -H "$(as "$ADMIN")" >"$BATS_TEST_TMPDIR/audit"
  jq -e --arg id "$id" --arg token "${WRITER:3:12}" '[.entries[].action] == ["job.delete", "job.cancel", "job.submit"]
    and all(.entries[]; .subject == $id and .address == "127.0.0.1")
    and [.entries[].name] == ["writer", "admin, made at start", "writer"] and .entries[0].token == $token' \
    "$BATS_TEST_TMPDIR/audit"
  status_of '/v1/audit?limit=2' -H "$(as "$ADMIN")"
  next=$(header Link | sed 's/.*<\(.*\)>.*/\1/')
  ask "$next" -H "$(as "$ADMIN")" | jq -e --slurpfile all "$BATS_TEST_TMPDIR/audit" '.entries[0] == $all[0].entries[2]'
  [ "$(status_of /v1/audit -H "$(as "$WRITER")")" = 403 ]
  grep -q "audit: job.delete $id by writer, token ${WRITER:3:12}, address 127.0.0.1" "$STATE.log"
}

@test "refused attempts are in the audit log, once an hour for each address and token" {
  for i in 1 2 3; do
    status_of /v1/jobs --interface 127.0.0.5 -H "$(as qg_none)"
    status_of /v1/tokens --interface 127.0.0.6 -H "$(as "$READER")"
    status_of /v1/jobs --interface 127.0.0.7 # without a token: nothing was tried
  done
  refused() {
    ask "/v1/audit?action=access.refuse&address=$1" -H "$(as "$ADMIN")" | jq -c '[.entries[] | [.subject, .token, .name]]'
  }
  [ "$(refused 127.0.0.5)" = '[["GET /v1/jobs",null,null]]' ]
  [ "$(refused 127.0.0.6)" = "[[\"GET /v1/tokens\",\"${READER:3:12}\",\"reader\"]]" ]
  [ "$(refused 127.0.0.7)" = '[]' ]
}

@test "the audit log is searched, by the API and by the command line" {
  since=$(date -u +%FT%T.%3NZ)
  token=$("$QUIETGEAR" token create 'ä searcher' -f "$STATE/admin.token")
  id=$(endless | submit -H "$(as "$token")")
  ask "/v1/jobs/$id/cancel" -X POST -H "$(as "$WRITER")" -o /dev/null
  found() {
    ask "/v1/audit?$1" -H "$(as "$ADMIN")" | jq -c '[.entries[].action]'
  }
  [ "$(found "subject=$id")" = '["job.cancel","job.submit"]' ]
  [ "$(found "subject=$id&actor=${token:3:12}")" = '["job.submit"]' ]
  [ "$(found "actor=%C3%A4%20searcher")" = '["job.submit"]' ]
  [ "$(found "since=$since")" = '["job.cancel","job.submit","token.create"]' ]
  [ "$(found "since=$since&action=token")" = '["token.create"]' ]
  [ "$(found "until=$since&action=daemon")" = '["daemon.start"]' ]
  status_of "/v1/audit?limit=1&since=$since&action=job" -H "$(as "$ADMIN")"
  next=$(header Link | sed 's/.*<\(.*\)>.*/\1/') # the next page of the same search
  ask "$next" -H "$(as "$ADMIN")" | jq -e '[.entries[].action] == ["job.submit"]'
  [ "$(status_of '/v1/audit?action=job.fly' -H "$(as "$ADMIN")")" = 400 ]
  body | jq -e '.detail | startswith("action: found \"job.fly\", allowed are job.submit, job.cancel, ")'
  [ "$(status_of '/v1/audit?since=today' -H "$(as "$ADMIN")")" = 400 ]
  export QUIETGEAR_TOKEN=$ADMIN
  "$QUIETGEAR" audit --about "$id" | awk '{print $2, $3, $4, $5, $6, $7}' >lines
  diff lines - <<END
job.cancel ${WRITER:3:12} 127.0.0.1 $id writer 
job.submit ${token:3:12} 127.0.0.1 $id ä searcher
END
  [ "$("$QUIETGEAR" audit --actor 'ä searcher' --since "${since%%T*}" --until 2100-01-01 --action job --address 127.0.0.1 | wc -l)" = 1 ]
  [ "$("$QUIETGEAR" audit --limit 2 | wc -l)" = 2 ]
  [ -z "$("$QUIETGEAR" audit --actor nobody)" ]
  run -2 "$QUIETGEAR" audit --action fly
  [[ "$output" == *'allowed are job.submit'* ]]
  run -2 "$QUIETGEAR" audit --limit 0
  run -2 "$QUIETGEAR" audit everything
  run -1 env QUIETGEAR_TOKEN="$READER" "$QUIETGEAR" audit
}

@test "tokens and audit entries are as their schemas say" {
  cd "$BATS_TEST_TMPDIR"
  [ "$(post_token '{"name": "a schema", "scopes": ["read"]}')" = 201 ]
  body | jq -c . >made
  assert_schema token made
  ask /v1/tokens -H "$(as "$ADMIN")" | jq -c '.tokens[]' >listed
  [ "$(wc -l <listed)" -ge 4 ]
  assert_schema token listed
  ask '/v1/audit?limit=500' -H "$(as "$ADMIN")" | jq -c '.entries[]' >entries
  [ "$(wc -l <entries)" -ge 4 ]
  assert_schema audit-entry entries
  echo '{"name": "a schema", "scopes": ["read"]}' >request
  echo '{"name": "a schema", "scopes": ["read"], "expires_at": "2030-01-01T00:00:00Z", "requests_per_minute": 5, "queued_jobs": 3}' >>request
  assert_schema token-request request
}

@test "answers carry what keeps a browser safe" {
  for path in / /healthz /v1/jobs /nothing; do
    status_of "$path"
    [ "$(header X-Content-Type-Options)" = nosniff ]
    [ "$(header Referrer-Policy)" = no-referrer ]
    [ "$(header X-Frame-Options)" = DENY ]
    [ "$(header Cross-Origin-Resource-Policy)" = same-origin ]
    [ "$(header Cross-Origin-Opener-Policy)" = same-origin ]
    [[ "$(header Content-Security-Policy)" == "default-src 'none'; "*"frame-ancestors 'none'" ]]
    [ "$(header Content-Security-Policy | wc -l)" = 1 ]
    [ -z "$(header Content-Security-Policy | grep unsafe)" ]
  done
  run -1 grep -qE '<script>|<style|style=|onclick=' "$WEB_DIR/index.html"
}

@test "pages of listed origins may use the API, others not" {
  status_of /v1/jobs -H "$(as "$READER")" -H 'Origin: https://plm.example.com'
  [ "$(header Access-Control-Allow-Origin)" = https://plm.example.com ]
  [ "$(header Cross-Origin-Resource-Policy)" = cross-origin ]
  [[ "$(header Vary)" == *Origin* ]]
  status_of /v1/jobs -H "$(as "$READER")" -H 'Origin: https://evil.example.com'
  [ -z "$(header Access-Control-Allow-Origin)" ]
  [ "$(status_of /v1/jobs -X OPTIONS -H 'Origin: http://tools.example.com:8080' -H 'Access-Control-Request-Method: POST')" = 204 ]
  [ "$(header Access-Control-Allow-Origin)" = http://tools.example.com:8080 ]
  [ "$(header Access-Control-Allow-Methods)" = 'GET, HEAD, POST' ]
  [[ "$(header Access-Control-Allow-Headers)" == *Authorization* ]]
  [ -z "$(header Access-Control-Allow-Credentials)" ]
  [ "$(status_of /v1/jobs -X OPTIONS -H 'Origin: https://evil.example.com' -H 'Access-Control-Request-Method: POST')" = 405 ]
  [ -z "$(header Access-Control-Allow-Origin)" ]
  [ "$(status_of /nothing -X OPTIONS -H 'Origin: https://plm.example.com' -H 'Access-Control-Request-Method: GET')" = 404 ]
}

@test "on loopback anyone may read and submit, but not administer; unless tokens are required there too" {
  start_daemon "$BATS_TEST_TMPDIR/here" --jobs 1
  [ "$(status_of /v1/jobs)" = 200 ]
  [ "$(status_of /v1/tokens)" = 401 ]
  [ "$(status_of /v1/tokens -H "$(as "$(cat "$BATS_TEST_TMPDIR/here/admin.token")")")" = 200 ]
  [ "$(status_of /v1/jobs -H 'Origin: https://plm.example.com')" = 200 ]
  [ -z "$(header Access-Control-Allow-Origin)" ]
  [[ "$(header Vary)" != *Origin* ]]
  stop_daemon
  first=$(cat "$BATS_TEST_TMPDIR/here/admin.token")
  start_daemon "$BATS_TEST_TMPDIR/here" --require-tokens always
  [ "$(status_of /v1/jobs)" = 401 ]
  [ "$(status_of /v1/jobs -H "$(as "$first")")" = 200 ]
  stop_daemon
  start_daemon "$BATS_TEST_TMPDIR/here" --require-tokens always --new-admin-token
  second=$(cat "$BATS_TEST_TMPDIR/here/admin.token")
  [ "$second" != "$first" ]
  [ "$(status_of /v1/tokens/"${first:3:12}" -X DELETE -H "$(as "$second")")" = 204 ]
  [ "$(status_of /v1/jobs -H "$(as "$first")")" = 401 ]
  stop_daemon
}
