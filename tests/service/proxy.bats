#!/usr/bin/env bats
# Behind a reverse proxy: whose address is written down, who is let in, and how many event streams one client may hold.

load helper

setup() {
  STATE=$BATS_TEST_TMPDIR/state
}

teardown() {
  [ -z "${PROXY:-}" ] || kill "$PROXY" 2>/dev/null || true
  [ -z "${STREAMS:-}" ] || kill "${STREAMS[@]}" 2>/dev/null || true
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# Starts a proxy of manner $1 (see proxy.mjs) before the daemon; sets DIRECT and, to the proxy's address, URL.
start_proxy() {
  rm -f "$BATS_TEST_TMPDIR/port"
  node "$QG_SOURCE/tests/service/proxy.mjs" "${URL##*:}" "$BATS_TEST_TMPDIR/port" "$1" 3>&- &
  PROXY=$!
  await test -s "$BATS_TEST_TMPDIR/port"
  DIRECT=$URL URL=http://127.0.0.1:$(cat "$BATS_TEST_TMPDIR/port")
}

authorized() {
  echo "Authorization: Bearer $(cat "$STATE/admin.token")"
}

# The address that the audit log has for a job submitted with these curl arguments.
audited() {
  local id
  id=$(document | submit -H "$(authorized)" "$@")
  ask "/v1/audit?limit=20" -H "$(authorized)" | jq -r --arg id "$id" '.entries[] | select(.subject == $id) | .address'
}

@test "the audit log names the client, not the trusted proxy, whatever the client writes" {
  start_daemon "$STATE" --jobs 1 --trusted-proxies 127.0.0.1
  for manner in join line; do
    URL=${DIRECT:-$URL}
    start_proxy "$manner"
    [ "$(audited --interface 127.0.0.2)" = 127.0.0.2 ]
    [ "$(audited --interface 127.0.0.3 -H 'X-Forwarded-For: 192.0.2.7')" = 127.0.0.3 ]
    [ "$(audited --interface 127.0.0.3 -H 'X-Forwarded-For: 192.0.2.7' -H 'X-Forwarded-For: 127.0.0.1')" = 127.0.0.3 ]
    [ "$(audited --interface 127.0.0.3 -H 'x-forwarded-for: 192.0.2.7, 127.0.0.1, 127.0.0.1')" = 127.0.0.3 ]
    # this client comes from a trusted address, so it is a proxy too, and its word counts: the one further right
    [ "$(audited -H 'X-Forwarded-For: 198.51.100.1' -H 'X-Forwarded-For: 192.0.2.7')" = 192.0.2.7 ]
    kill "$PROXY"
  done
  # straight to the daemon, from an address that is not trusted
  URL=$DIRECT
  [ "$(audited --interface 127.0.0.4 -H 'X-Forwarded-For: 192.0.2.7')" = 127.0.0.4 ]
  stop_daemon
}

@test "without trusted proxies the field says nothing" {
  start_daemon "$STATE" --jobs 1
  start_proxy join
  [ "$(audited --interface 127.0.0.2)" = 127.0.0.1 ]
  [ "$(audited --interface 127.0.0.2 -H 'X-Forwarded-For: 192.0.2.7')" = 127.0.0.1 ]
  stop_daemon
}

@test "whom a proxy brings needs a token, though the daemon listens on loopback" {
  start_daemon "$STATE" --jobs 1 --trusted-proxies "127.0.0.1 10.0.0.0/8"
  start_proxy join
  [ "$(status_of /v1/jobs --interface 127.0.0.2)" = 401 ]
  [ "$(status_of /v1/jobs --interface 127.0.0.2 -H "$(authorized)")" = 200 ]
  [ "$(status_of / --interface 127.0.0.2)" = 200 ]
  id=$(endless | submit -H "$(authorized)")
  # what lasts passes as well: a stream, a long poll
  open_stream "$BATS_TEST_TMPDIR/stream" "/v1/jobs/$id/events" -H "$(authorized)"
  STREAMS=("$STREAM")
  await grep -q '"running"' "$BATS_TEST_TMPDIR/stream"
  ask "/v1/jobs/$id/cancel" -X POST -H "$(authorized)" -o /dev/null
  wait "${STREAMS[0]}"
  grep -q '"cancelled"' "$BATS_TEST_TMPDIR/stream"
  stop_daemon
}

# Opens $1 streams with curl arguments, one after the other, each of them open when this returns.
open_streams() {
  local count=$1 i
  shift
  for ((i = 0; i < count; i++)); do
    open_stream "$BATS_TEST_TMPDIR/stream.${#STREAMS[@]}" /v1/events "$@" 2>/dev/null
    STREAMS+=("$STREAM")
  done
}

# Submits something to write about, and asks for a stream: whether it is opened.
is_let_in() {
  document | submit >/dev/null
  : >"$BATS_TEST_TMPDIR/header"
  curl -sS -N -D "$BATS_TEST_TMPDIR/header" "$URL/v1/events" -o "$BATS_TEST_TMPDIR/stream" 3>&- &
  STREAM=$!
  await grep -q '^HTTP/1.1 ' "$BATS_TEST_TMPDIR/header"
  kill "$STREAM" 2>/dev/null || true
  grep -q '^HTTP/1.1 200' "$BATS_TEST_TMPDIR/header"
}

@test "one token, or one address without a token, holds so many event streams and no more" {
  start_daemon "$STATE" --jobs 1 --client-streams 3
  STREAMS=()
  open_streams 3
  [ "$(status_of /v1/events)" = 429 ]
  assert_problem 429 too-many-streams
  body | jq -e '.detail | startswith("3 are open already")'
  [ "$(header Retry-After)" = 10 ]
  open_streams 1 --interface 127.0.0.2      # from elsewhere
  open_streams 3 -H "$(authorized)"         # with a token, from wherever
  [ "$(status_of /v1/events -H "$(authorized)" --interface 127.0.0.3)" = 429 ]
  [ "$(status_of /v1/jobs)" = 200 ] # all else goes on
  kill "${STREAMS[0]}" # one goes, and the daemon sees it when it writes the next time
  wait "${STREAMS[0]}" || true
  await is_let_in
  kill "${STREAMS[@]}" 2>/dev/null || true
  stop_daemon
}

@test "behind a trusted proxy each client has its own share of the streams" {
  start_daemon "$STATE" --jobs 1 --client-streams 2 --trusted-proxies 127.0.0.1
  start_proxy line
  reader=$(QUIETGEAR_TOKEN=$(cat "$STATE/admin.token") "$QG_BUILD/quietgear" token create reader --scopes read --server "$URL")
  STREAMS=()
  open_streams 2 -H "Authorization: Bearer $reader" --interface 127.0.0.2
  [ "$(status_of /v1/events -H "Authorization: Bearer $reader" --interface 127.0.0.3)" = 429 ] # the same token
  open_streams 2 -H "$(authorized)" --interface 127.0.0.2
  kill "${STREAMS[@]}" 2>/dev/null || true
  stop_daemon
}

@test "long polls of one client cannot take all places" {
  ulimit -n 600 # which leaves the daemon 336 places
  start_daemon "$STATE" --jobs 1 --client-streams 200
  id=$(endless | submit)
  wait_for "$id" '.state == "running"'
  other=$(document | submit) # nothing happens to it
  node "$QG_SOURCE/tests/service/polls.mjs" "$URL" 127.0.0.2 400 200 "/v1/jobs/$other" >"$BATS_TEST_TMPDIR/polls" 3>&- &
  STREAMS=("$!")
  await test -s "$BATS_TEST_TMPDIR/polls"
  read -r waiting answered <"$BATS_TEST_TMPDIR/polls"
  [ "$waiting" = 200 ]
  [ "$answered" -gt 0 ] # the others, at once; some have made room for the rest already
  [ "$(status_of "/v1/jobs/$other" --interface 127.0.0.3)" = 200 ]
  # to wait is granted to others, and to that one no more
  [ "$(status_of "/v1/jobs/$other" --interface 127.0.0.3 -H 'Prefer: wait=1')" = 200 ]
  [ "$(header Preference-Applied)" = wait=1 ]
  [ "$(status_of "/v1/jobs/$other" --interface 127.0.0.2 -H 'Prefer: wait=60')" = 200 ]
  [ -z "$(header Preference-Applied)" ]
  kill "${STREAMS[@]}"
  stop_daemon
}
