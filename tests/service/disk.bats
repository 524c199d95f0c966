#!/usr/bin/env bats
# A disk that is full, read-only or broken, and a database that is damaged: clear answers, nothing lost, and a daemon that goes
# on when the disk does.

load helper

setup() {
  SHIM=$QG_BUILD/tests/faults/disk.so
  [ -e "$SHIM" ] || skip "no failing disk: make tests/faults/disk.so"
  STATE=$BATS_TEST_TMPDIR/state
  LOG=$STATE.log
  FAULT=$BATS_TEST_TMPDIR/fault
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# A daemon whose disk fails while the file $FAULT exists.
start_on_failing_disk() {
  export QG_FAULT_FILE=$FAULT ASAN_OPTIONS=verify_asan_link_order=0
  LD_PRELOAD=$SHIM start_daemon "$STATE" "$@"
  unset QG_FAULT_FILE
}

# Lets the disk fail with the errno $1.
break_disk() {
  echo "$1" >"$FAULT.new"
  mv "$FAULT.new" "$FAULT"
}

post() {
  status_of /v1/jobs -H 'Content-Type: application/json' --data-binary "$(document)"
}

wait_for_line() {
  await grep -q "$1" "$LOG" || { cat "$LOG" >&2; return 1; }
}

wait_until_ready() {
  await answers 200 /readyz
}

waits_or_ended() {
  grep -q "job $1: waits until the database can be written" "$LOG" || ask "/v1/jobs/$1" | jq -e '.finished_at != null' >/dev/null
}

# Submits a job and breaks the disk, with the errno $1, while it runs. One that ended before was too short for this machine: a
# longer one comes next. Sets id, and longer, its document.
break_disk_under_job() {
  local samples
  for samples in 150 600 2400; do
    longer=$(document ".optimizer.random_samples = $samples | .optimizer.simplex_iterations = 10")
    id=$(submit <<<"$longer")
    wait_for "$id" '.progress.done > 5'
    break_disk "$1"
    await waits_or_ended "$id"
    ! grep -q "job $id: waits" "$LOG" || return 0
    rm "$FAULT"
    wait_until_ready
  done
  return 1
}

# The whole story with the errno $1, the problem $2 and the words $3: jobs wait, submissions are refused, all goes on.
goes_on_after() {
  start_on_failing_disk --jobs 1
  break_disk_under_job "$1"
  wait_for_line "$3.*; submissions are refused and running jobs wait"
  [ "$(post)" = 503 ]
  assert_problem 503 "$2"
  [ "$(header Retry-After)" = 30 ]
  [ "$(status_of /readyz)" = 503 ]
  assert_problem 503 "$2"
  [ "$(status_of /healthz)" = 200 ]
  [ "$(status_of "/v1/jobs/$id")" = 200 ]
  body | jq -e '.state == "running"'
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST)" = 503 ]
  rm "$FAULT"
  wait_until_ready
  wait_for_line 'database: can be written again'
  [ "$(post)" = 201 ]
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" >"$BATS_TEST_TMPDIR/disturbed.json"
  stop_daemon
  [ "$(sqlite3 "$STATE/quietgear.db" 'PRAGMA integrity_check')" = ok ]
  "$QG_BUILD/quietgear" run - <<<"$longer" >"$BATS_TEST_TMPDIR/alone.json"
  diff <(essence "$BATS_TEST_TMPDIR/alone.json") <(essence "$BATS_TEST_TMPDIR/disturbed.json")
}

@test "a full disk: jobs wait, submissions get 503, and all goes on when there is room" {
  goes_on_after 28 storage-full 'the disk with the database is full'
}

@test "a disk that turned read-only" {
  goes_on_after 30 storage-read-only 'the database cannot be written'
}

@test "a disk with errors" {
  goes_on_after 5 unavailable 'the database cannot be used now'
}

@test "a daemon that is stopped on a full disk stops, and the next one goes on" {
  start_on_failing_disk --jobs 1
  id=$(endless | submit)
  wait_for "$id" '.progress.done > 5'
  break_disk 28
  wait_for_line "job $id: waits until"
  stop_at_once
  rm "$FAULT"
  start_daemon "$STATE" --jobs 1
  wait_for "$id" '.state == "running" and .progress.done > 5'
}

@test "a real disk that is really full" {
  mkdir "$BATS_TEST_TMPDIR/small"
  mount -t tmpfs -o size=32m none "$BATS_TEST_TMPDIR/small" 2>/dev/null || skip "only root may make a small disk"
  STATE=$BATS_TEST_TMPDIR/small/state
  start_daemon "$STATE" --jobs 1
  id=$(endless | submit)
  wait_for "$id" '.progress.done > 5'
  cat /dev/zero >"$BATS_TEST_TMPDIR/small/ballast" 2>/dev/null || true
  wait_for_line 'the disk with the database is full'
  [ "$(post)" = 503 ]
  assert_problem 503 storage-full
  rm "$BATS_TEST_TMPDIR/small/ballast"
  wait_until_ready
  done=$(ask "/v1/jobs/$id" | jq .progress.done)
  wait_for "$id" ".state == \"running\" and .progress.done > $done"
  stop_daemon
  [ "$(sqlite3 "$STATE/quietgear.db" 'PRAGMA integrity_check')" = ok ]
  umount "$BATS_TEST_TMPDIR/small"
}

@test "a damaged database is said so, at the start and while serving" {
  start_daemon "$STATE" --jobs 1
  for i in {1..40}; do document ".name = \"job $i\" | .optimizer.random_samples = 1000000" | submit >/dev/null; done
  stop_daemon
  size=$(stat -c %s "$STATE/quietgear.db")
  cp "$STATE/quietgear.db" "$BATS_TEST_TMPDIR/whole"
  # all but the first pages, which tell what tables there are
  dd if=/dev/urandom of="$STATE/quietgear.db" bs=4096 seek=3 count=$((size / 4096 - 3)) conv=notrunc status=none
  run -1 "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --state-dir "$STATE" --web-dir "$WEB_DIR" \
    --schema-dir "$QG_SOURCE/schema"
  echo "$output"
  [[ "$output" == *"quietgear.db: "*"the database is damaged: stop the server and restore a backup"* ]]
  head -c 8192 /dev/urandom >"$STATE/quietgear.db"
  run -1 "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --state-dir "$STATE" --web-dir "$WEB_DIR" \
    --schema-dir "$QG_SOURCE/schema"
  [[ "$output" == *"quietgear.db: file is not a database; the database is damaged"* ]]
  # while it serves, once it looks at the file again
  cp "$BATS_TEST_TMPDIR/whole" "$STATE/quietgear.db"
  start_daemon "$STATE" --jobs 1
  id=$(ask '/v1/jobs?limit=1' | jq -r '.jobs[0].id')
  dd if=/dev/urandom of="$STATE/quietgear.db" bs=4096 seek=1 count=$((size / 4096 - 1)) conv=notrunc status=none
  for i in {1..50}; do
    [ "$(status_of "/v1/jobs?limit=500")" = 503 ] && break
    post >/dev/null
  done
  assert_problem 503 storage-damaged
  grep -q 'database: .*malformed' "$LOG"
}
