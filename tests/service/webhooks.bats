#!/usr/bin/env bats
# Webhooks from end to end: a receiver in Node.js checks the signatures by itself.

load helper

setup_file() {
  command -v node >/dev/null || skip "no Node.js"
  cd "$BATS_FILE_TMPDIR"
  touch secret log
  start_receiver
  echo "$(cat port)" >kept_port
  start_for_file "${FLAGS[@]}" --webhook-allow "http://127.0.0.1:$(cat port)/hooks http://169.254.169.254 http://10.0.0.1"
  ADMIN="Authorization: Bearer $(cat "$STATE/admin.token")"
  export ADMIN
}

FLAGS=(--jobs 1 --webhook-retry 1 --webhook-networks 127.0.0.0/8)

start_receiver() {
  node "$QG_SOURCE/tests/service/receiver.mjs" port log secret deaf 3>&- &
  echo $! >receiver.pid
  await test -s port
}

teardown_file() {
  cd "$BATS_FILE_TMPDIR"
  kill "$(cat receiver.pid)"
  stop_daemon
}

setup() {
  cd "$BATS_FILE_TMPDIR"
}

post() {
  status_of /v1/webhooks -H "$ADMIN" -H 'Content-Type: application/json' -d "$1"
}

# Makes a webhook for the events of the JSON array $1; its id in $hook, its secret in the file.
subscribe() {
  [ "$(post "{\"url\": \"http://127.0.0.1:$(cat kept_port)/hooks/plm\", \"events\": $1}")" = 201 ]
  hook=$(body | jq -r .id)
  body | jq -r .secret >secret
  body | jq -c . >made
  assert_schema webhook made
}

deliveries() {
  ask "/v1/webhooks/$hook/deliveries" -H "$ADMIN"
}

have_deliveries() {
  deliveries | jq -e "$1" >/dev/null
}

# Waits until the deliveries fulfil the jq condition $1.
wait_for_deliveries() {
  await have_deliveries "$1" || { deliveries >&2; return 1; }
}

@test "every change is told, signed, and told again with the same id when it was not taken" {
  : >log
  subscribe '["job.queued", "job.running", "job.succeeded"]'
  id=$(document '.name = "a \"näme\"" | .labels = ["blue"] | .external_id = "4711"' | submit)
  wait_for "$id" '.state == "succeeded"'
  wait_for_deliveries '[.deliveries[] | select(.state == "delivered")] | length == 3'
  jq -es 'all(.[]; .signed and .fresh and .path == "/hooks/plm")' log
  jq -es --arg id "$id" '[.[] | select(.status == 200).message | .type] | sort == ["job.queued", "job.running", "job.succeeded"]' log
  jq -es --arg id "$id" 'all(.[].message; .data.id == $id and .data.name == "a \"näme\"" and .data.labels == ["blue"]
    and .data.external_id == "4711"
    and .data.kind == "optimize" and .type == "job." + .data.state and .data.links.self == "/v1/jobs/" + $id)' log
  jq -es '[.[] | select(.message.type == "job.queued")] | length == 2 and .[0].status == 500 and .[1].status == 200
    and .[0].id == .[1].id' log
  deliveries | jq -e '.deliveries[] | select(.event == "job.queued") | .attempts == 2 and .last_status == 200'
  [ "$(ask /metrics | sed -n 's/^quietgear_webhook_attempts_total{outcome="\(.*\)"}/\1/p' | xargs)" = 'delivered 3 failed 1 given_up 0' ]
  deliveries | jq -e '[.deliveries[].event] == ["job.succeeded", "job.running", "job.queued"]'
  deliveries | jq -c '.deliveries[]' >log.deliveries
  assert_schema delivery log.deliveries
  jq -c .message log >log.messages
  assert_schema webhook-message log.messages
  ask /v1/webhooks -H "$ADMIN" | jq -c '.webhooks[]' >log.webhooks
  assert_schema webhook log.webhooks
  ask "/v1/webhooks/$hook" -X DELETE -H "$ADMIN" -f
}

@test "what happened before a kill -9 is told after it" {
  : >log
  flags=("${FLAGS[@]}" --webhook-allow "http://127.0.0.1:$(cat kept_port)/hooks")
  start_daemon "$BATS_TEST_TMPDIR/killed" "${flags[@]}"
  ADMIN="Authorization: Bearer $(cat "$BATS_TEST_TMPDIR/killed/admin.token")"
  subscribe '["job.queued", "job.running", "job.cancelled"]'
  : >deaf
  first=$(endless | submit) # without an external_id
  wait_for "$first" '.state == "running"'
  second=$(endless | submit)
  ask "/v1/jobs/$second/cancel" -X POST -o /dev/null
  stop_daemon KILL
  [ ! -s log ]
  rm deaf
  start_daemon "$BATS_TEST_TMPDIR/killed" "${flags[@]}"
  remove "$first"
  wait_for_deliveries 'all(.deliveries[]; .state == "delivered")'
  jq -es 'all(.[]; .signed and .fresh)' log
  jq -es 'all(.[]; .message.data | has("external_id") and .external_id == null)' log
  # The second job: queued, cancelled. The first: queued, running, back in the queue, running again, cancelled.
  told=$(jq -s --arg id "$second" '[.[] | select(.status == 200 and .message.data.id == $id).message.type] | sort' log)
  jq -e '. == ["job.cancelled", "job.queued"]' <<<"$told"
  told=$(jq -s --arg id "$first" '[.[] | select(.status == 200 and .message.data.id == $id).message.type] | sort' log)
  jq -e '. == ["job.cancelled", "job.queued", "job.queued", "job.running", "job.running"]' <<<"$told"
  jq -es '[.[] | select(.status == 200).id] | length == (unique | length)' log
  stop_daemon
}

@test "webhooks are made, listed and deleted by admins; their secrets are shown once" {
  subscribe '["job.failed"]'
  [[ "$(cat secret)" =~ ^whsec_[A-Za-z0-9+/]{43}=$ ]]
  [ "$(header Location)" = "/v1/webhooks/$hook" ]
  ask /v1/webhooks -H "$ADMIN" | jq -e --arg id "$hook" '.webhooks | length == 1 and .[0].id == $id
    and .[0].events == ["job.failed"] and (.[0] | has("secret") | not)'
  ask "/v1/webhooks/$hook" -H "$ADMIN" | jq -e '.disabled_at == null and (has("secret") | not)'
  for path in /v1/webhooks "/v1/webhooks/$hook" "/v1/webhooks/$hook/deliveries"; do
    [ "$(status_of "$path")" = 401 ]
  done
  [ "$(status_of "/v1/webhooks/$hook" -X DELETE)" = 401 ]
  [ "$(status_of "/v1/webhooks/$hook" -X DELETE -H "$ADMIN")" = 204 ]
  for path in "/v1/webhooks/$hook" "/v1/webhooks/$hook/deliveries"; do
    [ "$(status_of "$path" -H "$ADMIN")" = 404 ]
    assert_problem 404 not-found
  done
  [ "$(status_of "/v1/webhooks/$hook" -X DELETE -H "$ADMIN")" = 404 ]
  ask '/v1/audit?limit=2' -H "$ADMIN" | jq -e --arg id "$hook" '[.entries[] | [.action, .subject]]
    == [["webhook.delete", $id], ["webhook.create", $id]]'
}

@test "a URL that the settings do not allow is refused, with its reason" {
  port=$(cat kept_port)
  for url in "https://127.0.0.1:$port/hooks" "http://127.0.0.1:$port/" "http://localhost:$port/hooks" \
    "http://user@127.0.0.1:$port/hooks" "http://127.0.0.1:$port/hooks/../x" "file:///etc/passwd" "nonsense" \
    "http://169.254.169.254/latest/meta-data" "http://10.0.0.1/" "http://[::1]:$port/hooks"; do
    [ "$(post "{\"url\": \"$url\", \"events\": [\"job.failed\"]}")" = 422 ]
    assert_problem 422 invalid-body
    body | jq -e '.errors | length == 1 and .[0].pointer == "/url" and .[0].detail != ""'
  done
  [ "$(post '{"url": 1, "events": ["job.exploded"], "secret": "x", "more": true}')" = 422 ]
  body | jq -e '[.errors[].pointer] == ["/more", "/url", "/secret", "/events"]'
}

@test "without the settings there are no webhooks" {
  start_daemon "$BATS_TEST_TMPDIR/none" --jobs 1
  token=$(cat "$BATS_TEST_TMPDIR/none/admin.token")
  [ "$(status_of /v1/webhooks -H "Authorization: Bearer $token" -H 'Content-Type: application/json' \
    -d '{"url": "https://plm.example.com/", "events": ["job.failed"]}')" = 422 ]
  body | jq -e '.errors[0].detail == "the setting webhook-allow lists none"'
  stop_daemon
}
