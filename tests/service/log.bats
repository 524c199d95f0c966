#!/usr/bin/env bats
# The daemon's log: what an operator reads in a file, a log shipper in JSON, and journalctl in the journal.

load helper

setup() {
  STATE=$BATS_TEST_TMPDIR/state
  LOG=$STATE.log
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# The entries of a JSON log that fulfil the jq condition $1, as the jq expression $2 shows them.
entries() {
  jq -c "select($1) | ${2:-.}" "$LOG"
}

has_entry() {
  [ -n "$(entries "$1")" ]
}

# Waits until an entry fulfils the condition $1.
wait_entry() {
  await has_entry "$1" || { cat "$LOG" >&2; return 1; }
}

@test "in a file each line has its time and level, and requests are not logged unless asked for" {
  start_daemon "$STATE"
  ask /healthz -o /dev/null
  remove "$(document | submit)"
  stop_daemon
  run ! grep -vE '^20[0-9]{2}-[0-9]{2}-[0-9]{2}T[0-9:]{8}\.[0-9]{3}Z (error|warning|notice|info): ' "$LOG"
  grep -qE ' notice: listening on http://127.0.0.1:[0-9]+, ' "$LOG"
  grep -qE ' notice: stopped$' "$LOG"
  run ! grep -E 'GET|POST' "$LOG"
}

@test "a job's id finds its whole story, over a restart" {
  start_daemon "$STATE" --jobs 1 --log-format json
  id=$(endless | submit)
  wait_for "$id" '.progress.done > 5'
  stop_daemon
  start_daemon "$STATE" --jobs 1 --log-format json
  wait_for "$id" '.state == "running" and .progress.done > 5'
  remove "$id"
  stop_daemon
  jq -e . "$LOG" >"$BATS_TEST_TMPDIR/all"
  [ "$(entries ".job_id == \"$id\" and .event" '[.event, .action // .attempt // .state]' | sort)" = "$(sort <<'STORY'
["audit","job.submit"]
["job.submitted","queued"]
["job.started",1]
["job.interrupted",1]
["job.started",2]
["audit","job.cancel"]
["job.ended",2]
["audit","job.delete"]
STORY
)" ]
  [ "$(entries '.event == "job.ended"' '[.level, .state, .duration_ms > 0, .code_file, .code_func]')" = \
    '["info","cancelled",true,"server/work/attempt.c","log_ending"]' ]
  [ "$(entries '.event == "audit" and .action == "job.submit"' '[.level, .remote]')" = '["notice","127.0.0.1"]' ]
  [ "$(entries '.event == "daemon.started" or .event == "daemon.stopped"' .event | xargs)" = \
    'daemon.started daemon.stopped daemon.started daemon.stopped' ]
}

@test "a job that fails, a disk that fills up and a backup are events" {
  [ -e "$QG_BUILD/tests/faults/disk.so" ] || skip "no failing disk: make tests/faults/disk.so"
  export QG_FAULT_FILE=$BATS_TEST_TMPDIR/fault ASAN_OPTIONS=verify_asan_link_order=0
  LD_PRELOAD=$QG_BUILD/tests/faults/disk.so start_daemon "$STATE" --log-format json
  echo 28 >"$QG_FAULT_FILE"
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' --data-binary @-)" = 503 ]
  wait_entry '.event == "database.failed"'
  [ "$(entries '.event == "database.failed"' .level)" = '"error"' ]
  rm "$QG_FAULT_FILE"
  document | submit
  wait_entry '.event == "database.recovered"'
  [ "$(entries '.event == "database.recovered"' .level)" = '"notice"' ]
  ask /v1/backup -f -o "$BATS_TEST_TMPDIR/copy" -H "Authorization: Bearer $(cat "$STATE/admin.token")"
  wait_entry '.event == "backup.made"'
  [ "$(entries '.event == "backup.made"' .level)" = '"notice"' ]
  [ "$(entries '.event == "audit" and .action == "database.backup"' '[.token_id, .remote]')" = \
    "[\"$(cut -c 4-15 "$STATE/admin.token")\",\"127.0.0.1\"]" ]
  token=$("$QG_BUILD/quietgear" token create plm -s "$URL" -f "$STATE/admin.token")
  "$QG_BUILD/quietgear" token revoke "${token:3:12}" -s "$URL" -f "$STATE/admin.token"
  [ "$(entries '.event == "audit" and .action == "token.revoke"' .subject)" = "\"${token:3:12}\"" ]
}

@test "the access log tells of each request, and of no target" {
  start_daemon "$STATE" --log-format json --access-log on
  id=$(document | submit)
  ask "/v1/jobs/$id" -o "$BATS_TEST_TMPDIR/job"
  ask "/v1/jobs/$id/result?secret=in-a-query" -o /dev/null
  ask '/v1/jobs/secret-in-a-path' -o /dev/null -H "Authorization: Bearer $(cat "$STATE/admin.token")"
  ask /secret-address -o /dev/null -X BREW
  SECONDS=0
  open_stream "$BATS_TEST_TMPDIR/events" /v1/events
  sleep 0.5
  kill "$STREAM"
  wait_entry '.route == "/v1/events"'
  run ! grep secret "$LOG"
  show='[.method, .route, .status, .token_id, .remote, .job_id]'
  [ "$(entries '.event == "request"' "$show")" = "$(cat <<REQUESTS
["POST","/v1/jobs",201,null,"127.0.0.1",null]
["GET","/v1/jobs/{}",200,null,"127.0.0.1","$id"]
["GET","/v1/jobs/{}/result",400,null,"127.0.0.1","$id"]
["GET","/v1/jobs/{}",404,"$(cut -c 4-15 "$STATE/admin.token")","127.0.0.1",null]
["BREW","-",404,null,"127.0.0.1",null]
["GET","/v1/events",200,null,"127.0.0.1",null]
REQUESTS
)" ]
  [ "$(entries '.route == "/v1/jobs/{}" and .status == 200' .bytes)" = "$(stat -c %s "$BATS_TEST_TMPDIR/job")" ]
  [ "$(entries '.route == "/v1/events"' .bytes)" -ge "$(stat -c %s "$BATS_TEST_TMPDIR/events")" ] # what was on its way is lost
  entries '.route == "/v1/events"' .duration_ms | jq -e ". >= 400 and . < 1000 * ($SECONDS + 1)"
  entries '.route == "/v1/events"' .message | grep -q 'broken off'
}

@test "secrets are in no format's log" {
  port=$(node -e 'const s = require("net").createServer().listen(0, "127.0.0.1", () => { console.log(s.address().port); s.close(); })')
  start_daemon "$STATE" --log-format json --log-level debug --access-log on --webhook-allow "http://127.0.0.1:$port" \
    --webhook-networks 127.0.0.0/8
  token=$(cat "$STATE/admin.token")
  made=$(curl -sS -f -H "Authorization: Bearer $token" -H 'Content-Type: application/json' "$URL/v1/tokens" \
    -d '{"name": "a reader", "scopes": ["read"]}')
  hook=$(curl -sS -f -H "Authorization: Bearer $token" -H 'Content-Type: application/json' "$URL/v1/webhooks" \
    -d "{\"url\": \"http://127.0.0.1:$port/hooks/confidential-path\", \"events\": [\"job.queued\"]}")
  remove "$(document '.name = "confidential-name" | .external_id = "confidential-id"' | submit -H "Authorization: Bearer $token" \
    -H 'Idempotency-Key: confidential-key')"
  wait_entry '.event == "webhook.failed"' # nobody listens there
  ask /v1/jobs -o /dev/null -H 'Authorization: Bearer confidential-token'
  ask /v1/jobs -o /dev/null -H "Authorization: Bearer ${token%?}x"
  wait_entry '.event == "access.denied"'
  stop_daemon
  [ "$(jq -r .secret <<<"$hook" | wc -c)" -gt 20 ]
  for secret in "${token:16}" "$(jq -r .token <<<"$made" | cut -c 17-)" "$(jq -r .secret <<<"$hook")" confidential; do
    [ -n "$secret" ]
    run ! grep -F -- "$secret" "$LOG"
  done
}

@test "a flood is a few lines and a count" {
  start_daemon "$STATE" --log-format json
  node - "${URL##*:}" <<'NODE'
const net = require("net");
const ask = (bytes) => new Promise((done) => {
  const socket = net.connect(process.argv[2], "127.0.0.1", () => socket.write(bytes));
  socket.on("data", () => socket.destroy()).on("error", done).on("close", done);
});
const wrong = "GET /v1/jobs HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer x\r\n\r\n";
const torn = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: abc\r\n\r\n";
(async () => {
  for (let i = 0; i < 40; i++) // not so many that they might take the limit's minute
    await Promise.all([ask(wrong), ask(torn)]);
})();
NODE
  [ "$(entries '.event == "access.denied"' .status | sort | uniq -c | xargs)" = '10 401' ]
  [ "$(grep -c 'Failed to parse .Content-Length' "$LOG")" = 10 ]
  stop_daemon
  [ "$(entries '.event == "access.denied" and .status == null' .message | grep -c '"and 30 more like it within ')" = 1 ]
  [ "$(grep -c 'and 30 more like it within .*Failed to parse .Content-Length' "$LOG")" = 1 ]
  [ "$(wc -l <"$LOG")" -lt 60 ]
}

@test "each event has its entry in the catalog of messages" {
  sed -nE 's/.*= \{"([a-z._]+)", "([0-9a-f]{32})"\}.*/\2 \1/p' "$QG_SOURCE/server/base/log_entry.c" | sort >"$BATS_TEST_TMPDIR/events"
  [ "$(wc -l <"$BATS_TEST_TMPDIR/events")" -ge 18 ]
  sed -nE 's/^-- ([0-9a-f]{32})$/\1/p' "$QG_SOURCE/systemd/quietgear.catalog" | sort >"$BATS_TEST_TMPDIR/told"
  diff <(cut -d ' ' -f 1 "$BATS_TEST_TMPDIR/events") "$BATS_TEST_TMPDIR/told"
  while read -r id name; do
    grep -q "^| \`$name\` .*\`$id\`" "$QG_SOURCE/docs/operations.md" || { echo "$name is not in docs/operations.md"; false; }
  done <"$BATS_TEST_TMPDIR/events"
}

# Runs the script on stdin where /run is empty and a journal of its own listens. Skips the test where that is not allowed.
under_journald() {
  journald=/usr/lib/systemd/systemd-journald
  [ -x "$journald" ] && [ "$(id -u)" = 0 ] && command -v journalctl systemd-cat >/dev/null || skip "no journal, or not root"
  cat >"$BATS_TEST_TMPDIR/script"
  unshare --mount sh -c 'mount -t tmpfs none /run' || skip "no mount namespaces here"
  unshare --mount bash -euc '
    mount -t tmpfs none /run
    mkdir -p /run/systemd/journal /run/systemd/journald.conf.d
    printf "[Journal]\nStorage=volatile\nReadKMsg=no\nAudit=no\n" >/run/systemd/journald.conf.d/alone.conf
    "$1" 3>&- &
    trap "kill $!" EXIT
    for i in {1..1200}; do [ -S /run/systemd/journal/stdout ] && break; sleep 0.05; done
    [ -S /run/systemd/journal/stdout ] || exit 77
    . "$2"' bash "$journald" "$BATS_TEST_TMPDIR/script"
}

@test "under systemd's journal: journalctl finds a job's story by its fields" {
  document >"$BATS_TEST_TMPDIR/document"
  export QG_SOURCE QUIETGEARD WEB_DIR BATS_TEST_TMPDIR
  under_journald <<'SCRIPT'
    cd "$BATS_TEST_TMPDIR"
    systemd-cat -t quietgeard sh -c 'export JOURNAL_STREAM=$(stat -L -c %d:%i /proc/self/fd/2); exec "$@"' sh \
      "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --port-file /run/port --state-dir /run/state \
      --web-dir "$WEB_DIR" --schema-dir "$QG_SOURCE/schema" 3>&- &
    daemon=$!
    for i in {1..1200}; do [ -s /run/port ] && break; sleep 0.05; done
    url=http://127.0.0.1:$(cat /run/port)
    id=$(curl -sS -f -H 'Content-Type: application/json' --data-binary @document "$url/v1/jobs" | jq -r .id)
    for i in {1..60}; do
      curl -sS -H 'Prefer: wait=5' "$url/v1/jobs/$id" | jq -e '.state == "succeeded"' && break
    done
    curl -sS -o /dev/null -H 'Authorization: Bearer x' "$url/v1/jobs"
    kill "$daemon"
    wait "$daemon" || true
    journalctl --sync || sleep 1
    journal=$(echo /run/log/journal/*)
    journalctl --no-pager -D "$journal" -o json QG_JOB_ID="$id" | jq -r '[.QG_EVENT, .PRIORITY, ._TRANSPORT] | @tsv' | sort >story
    journalctl --no-pager -D "$journal" -o cat MESSAGE_ID=9bc2885471b1443988b6ea31eb6f065a >started
    journalctl --no-pager -D "$journal" -o json QG_EVENT=access.denied | jq -c '[.QG_STATUS, .QG_REMOTE, .CODE_FILE]' >denied
    journalctl --no-pager -D "$journal" -o cat -p warning -t quietgeard >warnings
SCRIPT
  cd "$BATS_TEST_TMPDIR"
  printf '%s\t%s\tjournal\n' audit 5 job.ended 6 job.started 6 job.submitted 6 | diff - story
  grep -q '^listening on http://127.0.0.1:' started
  [ "$(cat denied)" = '["401","127.0.0.1","server/http/authorize.c"]' ]
  [ "$(wc -l <warnings)" = 1 ]
}
