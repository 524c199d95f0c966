#!/usr/bin/env bats
# Backups made while jobs run, and what becomes of one that is restored.

load helper

setup() {
  STATE=$BATS_TEST_TMPDIR/state
  LOG=$STATE.log
  BACKUP=$BATS_TEST_TMPDIR/backup.db
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

backup() {
  "$QG_BUILD/quietgear" backup "${1:-$BACKUP}" --server "$URL" --token-file "$STATE/admin.token"
}

restore() {
  "$QUIETGEARD" --config /dev/null --state-dir "$STATE" --web-dir "$WEB_DIR" --schema-dir "$QG_SOURCE/schema" --restore "$1"
}

@test "a backup made while jobs run and are submitted is whole, and a job in it goes on to the same bits" {
  longer=$(document '.optimizer.random_samples = 150 | .optimizer.simplex_iterations = 10')
  start_daemon "$STATE" --jobs 2
  done_before=$(document | submit)
  wait_for "$done_before" '.state == "succeeded"'
  ask "/v1/jobs/$done_before/result" >"$BATS_TEST_TMPDIR/early.json"
  id=$(submit <<<"$longer")
  wait_for "$id" '.progress.done > 10'
  (for i in {1..30}; do document ".name = \"crowd $i\"" | submit; done >/dev/null) 3>&- &
  crowd=$!
  for i in 1 2 3; do backup; done
  wait "$crowd"
  [ "$(stat -c %a "$BACKUP")" = 600 ]
  ls -A "$BATS_TEST_TMPDIR" | grep -q 'backup.db.' && return 1 # nothing half made stays
  [ ! -e "$STATE/backup.tmp" ]
  [ "$(sqlite3 "$BACKUP" 'PRAGMA integrity_check')" = ok ]
  logged=$(sqlite3 "$BACKUP" "SELECT count(*) FROM evaluations JOIN jobs ON seq = job WHERE id = '$id'")
  [ "$logged" -gt 5 ]
  ask /v1/audit -H "Authorization: Bearer $(cat "$STATE/admin.token")" | jq -e '[.entries[] | select(.action == "database.backup")] | length == 3'
  stop_daemon
  rm -r "$STATE"
  run -0 restore "$BACKUP"
  [[ "$output" == *"is restored; no database was there"* ]]
  [ "$(sqlite3 "$STATE/quietgear.db" "SELECT name FROM audit WHERE action = 'database.restore'")" = quietgeard ]
  start_daemon "$STATE" --jobs 2
  ask "/v1/jobs/$done_before/result" -f | cmp - "$BATS_TEST_TMPDIR/early.json"
  [ "$(ask "/v1/jobs/$id/evaluations" | wc -l)" -ge "$logged" ]
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id/result" >"$BATS_TEST_TMPDIR/restored.json"
  "$QG_BUILD/quietgear" run - <<<"$longer" >"$BATS_TEST_TMPDIR/alone.json"
  diff <(essence "$BATS_TEST_TMPDIR/alone.json") <(essence "$BATS_TEST_TMPDIR/restored.json")
}

@test "restoring keeps what was there, and refuses what is no backup" {
  start_daemon "$STATE"
  first=$(document | submit)
  wait_for "$first" '.state == "succeeded"'
  backup
  second=$(document | submit)
  run -1 restore "$BACKUP"
  [[ "$output" == *"in use by another quietgeard"* ]]
  stop_daemon KILL # what was written last is in the write-ahead log still
  [ -s "$STATE/quietgear.db-wal" ]
  echo "no database" >"$BATS_TEST_TMPDIR/text"
  run -1 restore "$BATS_TEST_TMPDIR/text"
  [[ "$output" == *"text: is no database, or a damaged one"* ]]
  run -1 restore "$BATS_TEST_TMPDIR/nothing"
  [[ "$output" == *"nothing: unable to open database file"* ]]
  sqlite3 "$BATS_TEST_TMPDIR/foreign" 'CREATE TABLE t (x)'
  run -1 restore "$BATS_TEST_TMPDIR/foreign"
  [[ "$output" == *"foreign: is no database of this program"* ]]
  size=$(stat -c %s "$BACKUP")
  cp "$BACKUP" "$BATS_TEST_TMPDIR/damaged"
  dd if=/dev/urandom of="$BATS_TEST_TMPDIR/damaged" bs=4096 seek=2 count=$((size / 4096 - 2)) conv=notrunc status=none
  run -1 restore "$BATS_TEST_TMPDIR/damaged"
  [[ "$output" == *"a damaged one"* ]]
  [ -s "$STATE/quietgear.db-wal" ]
  run -0 restore "$BACKUP"
  [[ "$output" == *"what was there is quietgear.db.before-restore"* ]]
  [ "$(sqlite3 "$STATE/quietgear.db.before-restore" 'SELECT count(*) FROM jobs')" = 2 ]
  start_daemon "$STATE"
  ask /v1/jobs | jq -e --arg id "$first" '.jobs | length == 1 and .[0].id == $id and .[0].state == "succeeded"'
  [ "$(status_of "/v1/jobs/$second")" = 404 ]
}

# What the stream of all events begins with after the event $1.
beginning_after() {
  open_stream "$BATS_TEST_TMPDIR/stream" /v1/events -H "Last-Event-ID: $1"
  await grep -q '^id: ' "$BATS_TEST_TMPDIR/stream"
  sleep 0.5 # for what might come with it
  kill "$STREAM"
  cat "$BATS_TEST_TMPDIR/stream"
}

@test "who follows events over a restoring is told to read the list again, however much has happened since" {
  start_daemon "$STATE"
  wait_for "$(document | submit)" '.state == "succeeded"'
  backup
  for round in 1 2; do
    wait_for "$(document | submit)" '.state == "succeeded"'
    seen=$(beginning_after 99999999999999999 | sed -n 's/^id: //p' | head -n 1)
    [ "$seen" -gt 3 ]
    run ! grep -q 'event: reset' <(beginning_after "$seen")
    stop_daemon
    restore "$BACKUP"
    start_daemon "$STATE"
    for i in 1 2 3 4; do wait_for "$(document | submit)" '.state == "succeeded"'; done
    await eval 'beginning_after "$seen" | grep "event: reset"'
  done
}

@test "a backup needs an admin token, and an answer that breaks off leaves no file" {
  start_daemon "$STATE"
  [ "$(status_of /v1/backup)" = 401 ]
  run -1 "$QG_BUILD/quietgear" backup "$BACKUP" --server "$URL"
  [ ! -e "$BACKUP" ]
  run -1 backup /nowhere/backup.db
  [[ "$output" == *"/nowhere/backup.db: No such file or directory"* ]]
  printf old >"$BACKUP"
  # a server that promises more than it sends
  node -e 'require("net").createServer((s) => s.on("data", () => {
    s.write("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nSQLit\r\n"); s.destroySoon(); }))
    .listen(0, "127.0.0.1", function () { console.log(this.address().port); })' >"$BATS_TEST_TMPDIR/port" 3>&- &
  liar=$!
  await test -s "$BATS_TEST_TMPDIR/port"
  run -1 "$QG_BUILD/quietgear" backup "$BACKUP" --server "http://127.0.0.1:$(cat "$BATS_TEST_TMPDIR/port")"
  kill "$liar"
  [ "$(cat "$BACKUP")" = old ]
}

@test "a backup that is interrupted ends, and leaves no file" {
  # a server that does not get to an end
  node -e 'require("net").createServer((s) => s.on("data", () => {
    s.write("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nSQLit\r\n"); }))
    .listen(0, "127.0.0.1", function () { console.log(this.address().port); })' >"$BATS_TEST_TMPDIR/port" 3>&- &
  slow=$!
  await test -s "$BATS_TEST_TMPDIR/port"
  "$QG_BUILD/quietgear" backup "$BACKUP" --server "http://127.0.0.1:$(cat "$BATS_TEST_TMPDIR/port")" 3>&- &
  fetcher=$!
  await eval 'ls "$BACKUP".?????? 2>/dev/null'
  kill -TERM "$fetcher"
  wait "$fetcher" || true
  kill "$slow"
  run ! ls "$BACKUP"*
}
