#!/usr/bin/env bats
# Stopping and dying: what was accepted is neither lost nor changed.

load helper

setup() {
  STATE=$BATS_TEST_TMPDIR/state
  LOG=$STATE.log
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# A search of some hundred evaluations, $1 (1) times as long.
longer() {
  document ".optimizer.random_samples = 400 * ${1:-1} | .optimizer.simplex_iterations = 20 | .reliability.samples = 100"
}

log_length() {
  ask "/v1/jobs/$1/evaluations" | wc -l
}

has_grown_or_ended() {
  [ "$(log_length "$id")" -gt "$1" ] || ask "/v1/jobs/$id" | jq -e '.finished_at != null' >/dev/null
}

# Kills the daemon five times, each time after the log of the job $id has grown; stops before when the job has ended. Sets kills.
kill_five_times() {
  local length
  for ((kills = 0; kills < 5; kills++)); do
    length=$(log_length "$id")
    await has_grown_or_ended "$length"
    stop_daemon KILL
    start_daemon "$STATE"
    ! ask "/v1/jobs/$id" | jq -e '.finished_at != null' || return 0
    [ "$(log_length "$id")" -gt "$length" ]
    ask "/v1/jobs/$id/frequency-response" -f | jq -e .reference >/dev/null
  done
}

@test "a job that is killed five times ends with the same bits" {
  for times in 1 4 16; do # a job that ends before was too short for this machine
    start_daemon "$STATE"
    id=$(longer "$times" | submit)
    kill_five_times
    [ "$kills" -lt 5 ] || break
    stop_daemon
  done
  [ "$kills" = 5 ]
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" >"$BATS_TEST_TMPDIR/killed.json"
  ask "/v1/jobs/$id/evaluations" >"$BATS_TEST_TMPDIR/killed.log.json"
  grep -q 'attempt 6' "$STATE.log"
  stop_daemon
  start_daemon "$BATS_TEST_TMPDIR/undisturbed"
  id=$(longer "$times" | submit)
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" >"$BATS_TEST_TMPDIR/undisturbed.json"
  ask "/v1/jobs/$id/evaluations" >"$BATS_TEST_TMPDIR/undisturbed.log.json"
  diff <(essence "$BATS_TEST_TMPDIR/undisturbed.json") <(essence "$BATS_TEST_TMPDIR/killed.json")
  cmp "$BATS_TEST_TMPDIR/undisturbed.log.json" "$BATS_TEST_TMPDIR/killed.log.json"
  stop_daemon

  [ -x "$QG_BUILD/quietgear" ] || skip "the bits are the same; there is no quietgear to compare with"
  longer "$times" >"$BATS_TEST_TMPDIR/job.json"
  "$QG_BUILD/quietgear" run "$BATS_TEST_TMPDIR/job.json" -o "$BATS_TEST_TMPDIR/alone.json"
  diff <(essence "$BATS_TEST_TMPDIR/alone.json") <(essence "$BATS_TEST_TMPDIR/killed.json")
}

@test "SIGTERM stops at once, with running jobs and sleeping clients, and loses neither" {
  start_daemon "$STATE" --jobs 1
  running=$(endless | submit)
  queued=$(document | submit)
  wait_for "$running" '.progress.best != null'
  open_poll "$BATS_TEST_TMPDIR/poll" "/v1/jobs/$queued" -H 'Prefer: wait=60'
  stop_at_once
  [ "$STOPPED" -eq 0 ]
  wait "$ASKED"
  jq -e '.state == "queued"' "$BATS_TEST_TMPDIR/poll"
  [ ! -e "$STATE.port" ]
  grep -q "job $running: queued" "$STATE.log"
  start_daemon "$STATE" --jobs 1
  wait_for "$running" '.state == "running"'
  ask "/v1/jobs/$running" | jq -e '.progress.best != null'
  sleep 0.5
  ask "/v1/jobs/$running" | jq -e '.progress.best != null'
  ask "/v1/jobs/$queued" | jq -e '.state == "queued"'
  ask "/v1/jobs/$running/cancel" -X POST -f
  wait_for "$queued" '.state == "succeeded"'
}

@test "a wish to cancel outlives the daemon" {
  start_daemon "$STATE" --jobs 1
  id=$(endless | submit)
  wait_for "$id" '.state == "running"'
  stop_daemon KILL
  # As if the daemon had died between writing the wish down and obeying it.
  sqlite3 "$STATE/quietgear.db" "UPDATE jobs SET cancel_requested = 1 WHERE state = 'running'"
  start_daemon "$STATE"
  ask "/v1/jobs/$id" | jq -e '.state == "cancelled" and .finished_at != null'
}

@test "a second daemon on the same directory is kept out" {
  start_daemon "$STATE"
  run -1 "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --state-dir "$STATE" \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" 3>&-
  [[ "$output" == *"in use by another quietgeard (process $DAEMON)"* ]]
  ask /healthz -f
}

@test "an address that is taken, and a directory that cannot be made, are said so" {
  start_daemon "$STATE"
  run -1 "$QUIETGEARD" --config /dev/null --listen "${URL#http://}" --state-dir "$BATS_TEST_TMPDIR/other" \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" 3>&-
  [[ "$output" == *"cannot listen: ${URL#http://}: Address already in use"* ]]
  run -1 "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --state-dir /dev/null/x \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" 3>&-
  [[ "$output" == *"/dev/null/x"* ]]
}

@test "wrong settings are refused with status 2" {
  printf 'jobs = many\n' >"$BATS_TEST_TMPDIR/conf"
  run -2 "$QUIETGEARD" --check-config --config "$BATS_TEST_TMPDIR/conf" \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema"
  [[ "$output" == *'conf:1: jobs: found "many", allowed is a whole number from 1 to 64'* ]]
  printf 'jobs = 3\nlisten = [::1]:0\n' >"$BATS_TEST_TMPDIR/conf"
  run -0 "$QUIETGEARD" --check-config --config "$BATS_TEST_TMPDIR/conf" \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema"
  run -2 "$QUIETGEARD" --colour red
  run -0 "$QUIETGEARD" --help
  run -0 "$QUIETGEARD" --version
}

@test "a socket handed over is served, and readiness is told" {
  command -v systemd-socket-activate >/dev/null || skip "no systemd-socket-activate"
  port=$(free_port)
  systemd-socket-activate -l "127.0.0.1:$port" --setenv=QG_TEST=1 "$QUIETGEARD" --config /dev/null \
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema" --state-dir "$STATE" \
    2>"$STATE.log" 3>&- &
  DAEMON=$!
  URL=http://127.0.0.1:$port
  await curl -s -f "$URL/healthz" || { cat "$STATE.log" >&2; return 1; }
  await grep -q "listening on http://127.0.0.1:$port" "$STATE.log" # the socket was there before
  stop_daemon
}
