#!/usr/bin/env bats
# Server-Sent Events: what a client that follows one job or all of them is told, and how it comes back.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

# Follows $1 with further curl arguments into $BATS_TEST_TMPDIR/stream, in the background; sets STREAM.
follow() {
  local path=$1
  shift
  curl -sSN "$@" "$URL$path" >"$BATS_TEST_TMPDIR/stream" 3>&- &
  STREAM=$!
}

# Waits until the stream has a line that matches $1.
until_stream() {
  await grep -q "$1" "$BATS_TEST_TMPDIR/stream" || { cat "$BATS_TEST_TMPDIR/stream" >&2; return 1; }
}

# Waits until the stream has ended by itself.
until_end() {
  await is_gone "$STREAM"
}

has_progress() {
  [ "$(data_of job | jq -s '[.[].progress.done] | unique | length')" -ge 3 ]
}

# The data of the stream's events called $1, one a line.
data_of() {
  awk -v name="event: $1" '/^event: / {on = $0 == name} /^data: / && on {print substr($0, 7)} /^$/ {on = 0}' \
    "$BATS_TEST_TMPDIR/stream"
}

# The last id of the stream.
last_id() {
  sed -n 's/^id: //p' "$BATS_TEST_TMPDIR/stream" | tail -n 1
}

@test "one job is followed from its state now to its end, and then there is no more" {
  busy=$(endless | submit)
  wait_for "$busy" '.progress.best != null'
  follow "/v1/jobs/$busy/events"
  until_stream '"state":"running"'
  head -n 1 "$BATS_TEST_TMPDIR/stream" | grep -qx 'retry: 2000'
  # progress comes by itself
  await has_progress
  data_of job | jq -s -e '[.[].progress.done] | unique | length >= 3 and . == sort'
  ask "/v1/jobs/$busy/cancel" -X POST -o /dev/null
  until_stream '"state":"cancelled"'
  until_end
  data_of job | tail -n 1 >"$BATS_TEST_TMPDIR/last"
  diff <(jq -S . "$BATS_TEST_TMPDIR/last") <(ask "/v1/jobs/$busy" | jq -S .)
  [ "$(status_of "/v1/jobs/$busy/events" -H "Last-Event-ID: $(last_id)")" = 204 ]
  # who comes without an id is told the end
  follow "/v1/jobs/$busy/events"
  until_end
  data_of job | jq -s -e 'length == 1 and .[0].state == "cancelled"'
  ask "/v1/jobs/$busy" -X DELETE -f
  [ "$(status_of "/v1/jobs/$busy/events")" = 404 ]
  assert_problem 404 not-found
}

@test "all jobs are followed: submitted, started, ended, deleted" {
  follow /v1/events
  until_stream '^id: '
  busy=$(endless | submit)
  until_stream "\"id\":\"$busy\".*\"state\":\"running\""
  id=$(document | submit)
  until_stream "\"id\":\"$id\".*\"state\":\"queued\""
  ask "/v1/jobs/$busy/cancel" -X POST -f -o /dev/null
  until_stream "\"id\":\"$id\".*\"state\":\"succeeded\""
  other=$(document '.optimizer.random_samples = 500000' | submit)
  remove "$id"
  until_stream '^event: deleted'
  data_of deleted | jq -e --arg id "$id" '. == {$id}'
  # a state is the present one whenever it is told: one that did not last may be missing
  data_of job | jq -r --arg id "$busy" 'select(.id == $id).state' | uniq | paste -sd ' ' | grep -qx '\(queued \)*running cancelled'
  data_of job | jq -r --arg id "$id" 'select(.id == $id).state' | uniq | paste -sd ' ' | grep -qx 'queued \(running \)*succeeded'
  # ids grow
  sed -n 's/^id: //p' "$BATS_TEST_TMPDIR/stream" | sort -n -c
  kill "$STREAM"
  remove "$busy"
  remove "$other"
}

@test "a client that comes back hears what it missed, once, in its present state" {
  follow /v1/events
  until_stream '^id: '
  kill "$STREAM"
  seen=$(last_id)
  busy=$(endless | submit)
  wait_for "$busy" '.state == "running"'
  first=$(document '.name = "first"' | submit)
  second=$(document '.name = "second"' | submit)
  ask "/v1/jobs/$first/cancel" -X POST -f -o /dev/null
  ask "/v1/jobs/$second" -X DELETE -f
  follow /v1/events -H "Last-Event-ID: $seen"
  until_stream '^event: deleted'
  data_of job | jq -s -e --arg first "$first" '[.[] | select(.id == $first).state] == ["cancelled"]'
  data_of deleted | jq -s -e --arg second "$second" '. == [{id: $second}]'
  [ -z "$(data_of job | grep "$second")" ]
  kill "$STREAM"
  remove "$first"
  remove "$busy"
}

@test "also over restarts of the daemon, after a stop and after a kill" {
  own=$BATS_TEST_TMPDIR/own
  start_daemon "$own" --jobs 1
  busy=$(endless | submit)
  wait_for "$busy" '.state == "running"'
  doomed=$(document '.name = "doomed"' | submit)
  follow /v1/events
  until_stream '"state":"running"'
  seen=$(last_id)
  stop_daemon
  until_end # a daemon that stops ends its streams
  start_daemon "$own" --jobs 1
  ask "/v1/jobs/$doomed" -X DELETE -f
  stop_daemon KILL
  start_daemon "$own" --jobs 1
  follow /v1/events -H "Last-Event-ID: $seen"
  until_stream '^event: deleted'
  data_of deleted | jq -s -e --arg id "$doomed" '. == [{$id}]'
  until_stream "\"id\":\"$busy\".*\"state\":\"running\""
  run ! grep '^event: reset' "$BATS_TEST_TMPDIR/stream"
  stop_daemon
}

@test "who is too far behind, or has another database's id, is told to read the list again" {
  follow /v1/events -H 'Last-Event-ID: 999999999'
  until_stream '^event: reset'
  kill "$STREAM"
  [ "$(status_of /v1/events -H 'Last-Event-ID: yesterday')" = 400 ]
  assert_problem 400 bad-parameter
  [ "$(status_of '/v1/events?color=red')" = 400 ]
  [ "$(status_of /v1/events -H 'Accept: application/json')" = 406 ]
}

@test "a reader that does not read costs nothing, and finds the latest state when it does" {
  busy=$(endless | submit)
  wait_for "$busy" '.state == "running"'
  exec 8<>"/dev/tcp/127.0.0.1/${URL##*:}"
  printf 'GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n' >&8
  sleep 2
  rss=$(awk '/VmRSS/ {print $2}' "/proc/$DAEMON/status")
  ask "/v1/jobs/$busy/cancel" -X POST -f -o /dev/null
  wait_for "$busy" '.finished_at != null'
  timeout "$PATIENCE" grep -a -m 1 '"state":"cancelled"' <&8
  exec 8>&-
  [ "$rss" -lt 400000 ]
  remove "$busy"
}

@test "the daemon stops at once with a hundred streams open" {
  start_daemon "$BATS_TEST_TMPDIR/own" --jobs 1
  for i in {1..100}; do
    curl -sSN "$URL/v1/events" -o "$BATS_TEST_TMPDIR/stream.$i" 3>&- &
    curls[i]=$!
  done
  await eval '[ "$(cat "$BATS_TEST_TMPDIR"/stream.* | grep -c "^retry:")" = 100 ]'
  busy=$(endless | submit)
  wait_for "$busy" '.progress.best != null'
  stop_at_once
  for pid in "${curls[@]}"; do wait "$pid"; done # each saw a clean end
}
