#!/usr/bin/env bats
# Another system at the daemon's side: docs/plm_client.py, and what docs/integration.md says.

load helper

setup() {
  cd "$BATS_TEST_TMPDIR"
  CLIENT=$QG_SOURCE/docs/plm_client.py
  STATE=$BATS_TEST_TMPDIR/state
  export QUIETGEAR_TOKEN_FILE=$BATS_TEST_TMPDIR/token QUIETGEAR_SECRET_FILE=$BATS_TEST_TMPDIR/secret
}

teardown() {
  [ -z "${RECEIVER:-}" ] || kill "$RECEIVER" 2>/dev/null || true
  [ -z "${RUN:-}" ] || kill "$RUN" 2>/dev/null || true
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# A daemon whose callers all need a token, and a token for the client with $@ further options of token create.
start() {
  start_daemon "$STATE" --jobs 1 --require-tokens always --webhook-retry 1 --webhook-networks 127.0.0.0/8 \
    --listen "127.0.0.1:$(free_port)" --webhook-allow "http://127.0.0.1:$(receiver_port)/hooks"
  export QUIETGEAR_SERVER=$URL
  "$QG_BUILD/quietgear" token create plm -f "$STATE/admin.token" "$@" >token
}

needs_python() {
  command -v python3 >/dev/null || skip "no Python"
}

# A port that nothing listens on, the same each time.
receiver_port() {
  [ -s free ] || free_port >free
  cat free
}

# Three documents, the second of which takes some seconds.
write_documents() {
  document '.labels = ["plm"]' >first.json
  document '.labels = ["plm"] | .optimizer.random_samples = 400' >second.json
  document '.labels = ["plm"] | .name = "another"' >third.json
  mkdir out
}

# Waits until file $1 has a line that matches $2.
wait_for_line() {
  await grep -q "$2" "$1" || { cat "$1" >&2; return 1; }
}

# Uses up what the token has, and lists: whether the client was told to wait, which it is not when the machine was slow meanwhile.
lists_late() {
  await answers 429 /v1/jobs -H "Authorization: Bearer $(cat token)" && "$CLIENT" list plm >listed 2>>said &&
    grep -q '429.*: again in [1-9] s' said
}

@test "the client gets every result over a kill -9, and nothing twice" {
  needs_python
  start
  write_documents
  "$CLIENT" run out first.json second.json third.json >told 2>said 3>&- &
  RUN=$!
  wait_for_line told '^first succeeded 200$'
  stop_daemon KILL
  start_daemon "$STATE" --jobs 1 --require-tokens always --listen "${URL#http://}"
  wait "$RUN"
  RUN=
  [ "$(sort told | xargs)" = 'first succeeded 200 second succeeded 200 third succeeded 200' ]
  grep -q ': again in 1 s' said
  for name in first second third; do
    "$QG_BUILD/quietgear" run "$name.json" | jq -S .design | diff - <(jq -S .design "out/$name.result.json")
  done
  # the same once more: known jobs, no result sent again; other documents are other jobs
  "$CLIENT" run out first.json second.json third.json >again 2>said
  [ "$(sort again | xargs)" = 'first succeeded 304 second succeeded 304 third succeeded 304' ]
  [ "$(grep -c ' known$' said)" = 3 ]
  echo 1 >out/last-event-id # long forgotten
  jq '.name = "changed"' first.json >changed && mv changed first.json
  "$CLIENT" run out first.json 2>said | grep -qx 'first succeeded 200'
  [ "$(grep -c ' new$' said)" = 1 ]
  [ "$("$CLIENT" list plm 1 | awk '{print $3}' | xargs)" = 'first third second first' ]
  [ "$("$CLIENT" list plm)" = "$("$CLIENT" list plm 3)" ]
}

@test "the client waits where its token has no more, and gives up where it never will have" {
  needs_python
  start --requests-per-minute 12 --queued-jobs 5 # one each 5 s, once ten are used
  write_documents
  "$CLIENT" run out first.json third.json >told 2>said 3>&-
  await lists_late
  [ "$(wc -l <listed)" = 2 ]
  "$QG_BUILD/quietgear" token create reader --scopes read -f "$STATE/admin.token" >token
  run -1 "$CLIENT" run out second.json
  [[ "$output" == 'POST /v1/jobs: 403 '*insufficient-scope* ]]
  document '.optimizer.simplex_iterations = -1' >wrong.json
  QUIETGEAR_TOKEN_FILE=$STATE/admin.token run -1 "$CLIENT" run out wrong.json
  [[ "$output" == *'422 '*'/optimizer/simplex_iterations'* ]]
  run -2 "$CLIENT" frobnicate
}

@test "the client's receiver takes what the daemon signed, once, and nothing else" {
  needs_python
  start
  ask /v1/webhooks -f -H "Authorization: Bearer $(cat "$STATE/admin.token")" -H 'Content-Type: application/json' \
    -d "{\"url\": \"http://127.0.0.1:$(receiver_port)/hooks\", \"events\": [\"job.succeeded\"]}" | jq -r .secret >secret
  "$CLIENT" receive "$(receiver_port)" >received 3>&- &
  RECEIVER=$!
  id=$(document '.external_id = "4711"' | submit -H "Authorization: Bearer $(cat token)")
  wait_for_line received "^job.succeeded 4711 $id$"
  # a message of our own, signed; then with one thing wrong at a time
  send() { # timestamp, signature's body, body
    signature=$(node -e 'const [key, content] = process.argv.slice(1);
      console.log(require("crypto").createHmac("sha256", Buffer.from(key.slice(6), "base64")).update(content).digest("base64"))' \
      "$(cat secret)" "msg_1.$1.$2")
    curl -sS -o /dev/null -w '%{http_code}' "http://127.0.0.1:$(receiver_port)/hooks" -H "webhook-id: msg_1" \
      -H "webhook-timestamp: $1" -H "webhook-signature: v1,AAAA v1,$signature" -d "$3"
  }
  body='{"type":"job.failed","data":{"id":"ours","external_id":null}}'
  now=$(date +%s)
  [ "$(send "$now" "$body" "${body/failed/succeeded}")" = 400 ]
  [ "$(send $((now - 400)) "$body" "$body")" = 400 ]
  [ "$(send soon "$body" "$body")" = 400 ]
  [ "$(curl -sS -o /dev/null -w '%{http_code}' "http://127.0.0.1:$(receiver_port)/hooks" -d "$body")" = 400 ]
  [ "$(send "$now" "$body" "$body")" = 204 ]
  [ "$(send "$now" "$body" "$body")" = 204 ]
  [ "$(sort received)" = "$(printf 'job.failed None ours\njob.succeeded 4711 %s\n' "$id" | sort)" ]
}

@test "the page on integrations has every problem with its status, and no other" {
  sed -n 's/^ *X(QG_PROBLEM_[A-Z_]*, \([0-9]*\), "\([a-z-]*\)".*/\1 \2/p' "$QG_SOURCE/server/http/problem.h" | sort >known
  sed -n 's/^| \([0-9]\{3\}\) | `\([a-z-]*\)` |.*/\1 \2/p' "$QG_SOURCE/docs/integration.md" | sort >written
  [ "$(wc -l <known)" -gt 20 ]
  diff known written
}

@test "Prometheus needs the scope read, and sends it as written" {
  start --scopes read
  grep -q 'credentials_file: ' "$QG_SOURCE/docs/operations.md"
  [ "$(status_of /metrics)" = 401 ]
  [ "$(status_of /metrics -H "Authorization: Bearer $(cat token)")" = 200 ]
}
