#!/usr/bin/env bats
# The life of jobs as a client sees it: one small job that runs to its end, one endless job that is watched and cancelled,
# and jobs that wait behind it. The tests build on each other: run the file as a whole.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

@test "a document is accepted, run and answered" {
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' --data-binary @-)" = 201 ]
  id=$(body | jq -r .id)
  [ "$(header Location)" = "/v1/jobs/$id" ]
  body | jq -e '.kind == "optimize" and .name == "28/43 four tip parameters" and .links.self == "/v1/jobs/\(.id)"
    and (.submitted_at | test("^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}[.][0-9]{3}Z$")) and .error == null'
  wait_for "$id" '.state == "succeeded"'
  ask "/v1/jobs/$id" | jq -e '.progress.done == .progress.total and .progress.best > 0 and .started_at and .finished_at
    and .progress.eta_s == null'
  [ "$(status_of "/v1/jobs/$id/result")" = 200 ]
  [ "$(header Content-Type)" = application/json ]
  body | jq -e '.job.kind == "optimize" and (.design.load_cases | length) == 3 and .search.evaluations >= 13'
  best=$(body | jq .design.f_dte)
  ask "/v1/jobs/$id" | jq -e ".progress.best == $best"
}

@test "what a finished job left: evaluations, frequency response" {
  id=$(ask '/v1/jobs?state=succeeded' | jq -r .jobs[0].id)
  ask "/v1/jobs/$id/evaluations" >"$BATS_TEST_TMPDIR/log"
  jq -s -e '(map(.evaluation) == [range(0; length)]) and .[0].phase == "reference" and length >= 19 + 20' "$BATS_TEST_TMPDIR/log"
  [ "$(status_of "/v1/jobs/$id/evaluations" -H 'Accept: text/csv')" = 200 ]
  [ "$(header Content-Type)" = text/csv ]
  [ "$(body | wc -l)" -eq $(($(wc -l <"$BATS_TEST_TMPDIR/log") + 1)) ]
  ask "/v1/jobs/$id/frequency-response" | jq -e '(.frequency_ratio | length) == 40 and .design and .reference'
  [ "$(status_of "/v1/jobs/$id/frequency-response" -H 'Accept: text/csv')" = 200 ]
  [ "$(body | head -n 1)" = design,torque_nm,frequency_ratio,pinion_rpm,rms,period ]
  [ "$(body | wc -l)" -eq $((1 + 2 * 3 * 40)) ]
}

@test "a finished job can be neither cancelled nor waited for" {
  id=$(ask '/v1/jobs?state=succeeded' | jq -r .jobs[0].id)
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST)" = 409 ]
  assert_problem 409 wrong-state
  SECONDS=0
  [ "$(status_of "/v1/jobs/$id" -H 'Prefer: wait=60')" = 200 ]
  [ "$SECONDS" -lt 55 ]
}

@test "a running job can be watched" {
  id=$(endless '.name = "endless"' | submit)
  wait_for "$id" '.progress.best != null'
  ask "/v1/jobs/$id" | jq -e '.state == "running" and .progress.total > 1000000 and .progress.phase == "random"'
  wait_for "$id" '.progress.eta_s > 0'
  [ "$(status_of "/v1/jobs/$id/result")" = 409 ]
  assert_problem 409 not-available-yet
  ask "/v1/jobs/$id/frequency-response" -f | jq -e '(.frequency_ratio | length) == 40 and .design and .reference'
  await eval '[ "$(ask "/v1/jobs/$id/evaluations" -f | wc -l)" -gt 1 ]'
}

@test "a long poll is answered when the job changes, and at its end when it does not" {
  running=$(ask '/v1/jobs?state=running' | jq -r .jobs[0].id)
  [ "$(status_of "/v1/jobs/$running")" = 200 ]
  tag=$(header ETag)
  [ "$(status_of "/v1/jobs/$running" -H "If-None-Match: $tag" -H 'Prefer: wait=60')" = 200 ] # 304 when it does not
  [ "$(header ETag)" != "$tag" ]
  [ "$(header Preference-Applied)" = wait=60 ]
  queued=$(document | submit)
  status_of "/v1/jobs/$queued"
  tag=$(header ETag)
  SECONDS=0
  [ "$(status_of "/v1/jobs/$queued" -H "If-None-Match: $tag" -H 'Prefer: wait=2')" = 304 ]
  [ "$SECONDS" -ge 2 ]
  [ ! -s "$BATS_TEST_TMPDIR/body" ]
  SECONDS=0
  [ "$(status_of "/v1/jobs/$queued" -H 'If-None-Match: "other"' -H 'Prefer: wait=60')" = 200 ]
  open_poll "$BATS_TEST_TMPDIR/polled" "/v1/jobs/$queued" -H 'Prefer: wait=60'
  ask "/v1/jobs/$queued/cancel" -X POST -o /dev/null
  wait "$ASKED"
  [ "$(jq -r .state "$BATS_TEST_TMPDIR/polled")" = cancelled ]
  [ "$SECONDS" -lt 55 ]
}

@test "many long polls at once are all answered" {
  queued=$(document | submit)
  for i in {1..50}; do
    ask "/v1/jobs/$queued" -v -H 'Prefer: wait=60' -o "$BATS_TEST_TMPDIR/poll.$i" 2>"$BATS_TEST_TMPDIR/talk.$i" 3>&- &
  done
  await eval '[ "$(cat "$BATS_TEST_TMPDIR"/talk.* | grep -c "^> GET")" = 50 ]'
  SECONDS=0
  ask /healthz -f
  ask "/v1/jobs/$queued/cancel" -X POST -f -o /dev/null
  wait
  [ "$SECONDS" -lt 55 ]
  remove "$queued"
  for i in {1..50}; do
    jq -e '.state == "cancelled"' "$BATS_TEST_TMPDIR/poll.$i"
  done
}

@test "an entity tag that still fits is answered with 304" {
  id=$(ask '/v1/jobs?state=succeeded' | jq -r .jobs[0].id)
  status_of "/v1/jobs/$id"
  [ "$(status_of "/v1/jobs/$id" -H "If-None-Match: W/$(header ETag)")" = 304 ]
  [ "$(status_of "/v1/jobs/$id" -H 'If-None-Match: "0"')" = 200 ]
}

@test "HEAD answers like GET, without a body" {
  id=$(ask '/v1/jobs?state=succeeded' | jq -r .jobs[0].id)
  for path in "/v1/jobs/$id" "/v1/jobs/$id/result" "/v1/jobs/$id/evaluations" /v1/jobs / /healthz; do
    [ "$(status_of "$path" -I)" = 200 ]
  done
  status_of "/v1/jobs/$id" -I
  head_length=$(header Content-Length)
  status_of "/v1/jobs/$id"
  [ "$head_length" = "$(header Content-Length)" ]
}

@test "a running job is not deleted, and ends when it is cancelled" {
  id=$(ask '/v1/jobs?state=running' | jq -r .jobs[0].id)
  [ "$(status_of "/v1/jobs/$id" -X DELETE)" = 409 ]
  assert_problem 409 wrong-state
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST)" = 202 ]
  wait_for "$id" '.state == "cancelled"'
  [ "$(status_of "/v1/jobs/$id/cancel" -X POST)" = 200 ]
  [ "$(status_of "/v1/jobs/$id/result")" = 409 ]
  ask "/v1/jobs/$id/frequency-response" -f -o /dev/null
  [ "$(status_of "/v1/jobs/$id" -X DELETE)" = 204 ]
  for path in "" /result /evaluations /frequency-response; do
    [ "$(status_of "/v1/jobs/$id$path")" = 404 ]
    assert_problem 404 not-found
  done
}

@test "the same key and document is the same job and answer, another document a problem" {
  busy=$(endless | submit)
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: k-1' --data-binary @-)" = 201 ]
  [ -z "$(header Idempotency-Replayed)" ]
  first=$(body | jq -r .id)
  answer=$(body)
  ask "/v1/jobs/$first/cancel" -X POST -f -o /dev/null
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: k-1' --data-binary @-)" = 201 ]
  [ "$(header Idempotency-Replayed)" = true ]
  [ "$(body)" = "$answer" ]
  [ "$(header Location)" = "/v1/jobs/$first" ]
  [ "$(document '.optimizer.seed = 9' | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: k-1' --data-binary @-)" = 422 ]
  assert_problem 422 idempotency-key-reused
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: a b' --data-binary @-)" = 400 ]
  remove "$first"
  # a retry that comes late does not bring a deleted job back
  [ "$(document | status_of /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: k-1' --data-binary @-)" = 201 ]
  [ "$(body)" = "$answer" ]
  [ "$(status_of "/v1/jobs/$first")" = 404 ]
  remove "$busy"
}

@test "twenty at once with the same key are one job" {
  busy=$(endless | submit)
  document >"$BATS_TEST_TMPDIR/document"
  for i in {1..20}; do
    curl -sS -H 'Content-Type: application/json' -H 'Idempotency-Key: k-20' --data-binary "@$BATS_TEST_TMPDIR/document" \
      "$URL/v1/jobs" -o "$BATS_TEST_TMPDIR/answer$i" 3>&- &
    curls[i]=$!
  done
  for pid in "${curls[@]}"; do wait "$pid"; done
  [ "$(cat "$BATS_TEST_TMPDIR"/answer* | sort -u | wc -l)" = 1 ]
  remove "$(jq -r .id "$BATS_TEST_TMPDIR/answer1")"
  remove "$busy"
}

@test "jobs are found by what another system calls them" {
  busy=$(endless | submit)
  wait_for "$busy" '.state == "running"'
  first=$(document '.external_id = "PLM 7/ü&"' | submit)
  second=$(document '.external_id = "PLM 7/ü&"' | submit)
  other=$(document '.external_id = "PLM 8"' | submit)
  ask "/v1/jobs/$first" | jq -e '.external_id == "PLM 7/ü&"'
  ask "/v1/jobs/$busy" | jq -e '.external_id == null'
  [ "$(status_of '/v1/jobs?external_id=PLM+7%2F%C3%BC%26&limit=1')" = 200 ]
  body | jq -e --arg id "$second" '[.jobs[].id] == [$id]'
  [ "$(status_of "$(header Link | sed -n 's/^<\(.*\)>; rel="next"$/\1/p')")" = 200 ]
  body | jq -e --arg id "$first" '[.jobs[].id] == [$id]'
  ask '/v1/jobs?external_id=nothing' | jq -e '.jobs == []'
  ask "/v1/jobs/$first/document" | jq -e '.external_id == "PLM 7/ü&"'
  for id in $first $second $other $busy; do remove "$id"; done
}

@test "jobs are listed newest first, by state and label, in pages" {
  busy=$(endless '.name = "busy"' | submit)
  wait_for "$busy" '.state == "running"'
  for i in {1..5}; do
    ids[i]=$(document ".name = \"n$i\" | .labels = [\"all\", \"a&b \($i % 2)\"]" | submit)
  done
  ask '/v1/jobs?label=all' | jq -e '[.jobs[].name] == ["n5", "n4", "n3", "n2", "n1"]'
  ask '/v1/jobs?state=queued&label=a%26b+1' | jq -e '[.jobs[].name] == ["n5", "n3", "n1"]'
  ask '/v1/jobs?state=running' | jq -e '[.jobs[].name] == ["busy"]'
  next='/v1/jobs?label=all&limit=2'
  names=
  while [ -n "$next" ]; do
    [ "$(status_of "$next")" = 200 ]
    names+=$(body | jq -r '[.jobs[].name] | join(" ")')/
    next=$(header Link | sed -n 's/^<\(.*\)>; rel="next"$/\1/p')
  done
  [ "$names" = 'n5 n4/n3 n2/n1/' ]
  for query in state=sleeping limit=0 limit=501 limit=x cursor=x color=red 'limit=1&limit=2'; do
    [ "$(status_of "/v1/jobs?$query")" = 400 ]
    assert_problem 400 bad-parameter
  done
  for i in {1..5}; do remove "${ids[i]}"; done
  remove "$busy"
}

@test "two jobs can run at the same time" {
  start_daemon "$BATS_TEST_TMPDIR/two" --jobs 2
  first=$(endless | submit)
  second=$(endless '.optimizer.seed = 2' | submit)
  wait_for "$first" '.progress.best != null'
  wait_for "$second" '.progress.best != null'
  ask "/v1/jobs/$first" | jq -e '.state == "running"'
  stop_daemon
}

@test "a job names its objective, by which its best is to be read" {
  first=$(document 'del(.objective)' | submit)
  second=$(document '.objective = "f_pps"' | submit)
  third=$(document '{kind: "evaluate", gear_pair, relief}' | submit)
  fourth=$(document '.objective = "f_dte_percentile"' | submit)
  ask "/v1/jobs/$first" | jq -e '.objective == "f_dte"'
  ask "/v1/jobs/$second" | jq -e '.objective == "f_pps"'
  ask "/v1/jobs?limit=4" | jq -e '[.jobs[].objective] == ["f_dte_percentile", null, "f_pps", "f_dte"]'
  remove "$fourth"
  wait_for "$third" '.state == "succeeded"'
}

@test "the page and its files are served, under a strict policy" {
  [ "$(status_of /)" = 200 ]
  [ "$(header Content-Type)" = 'text/html; charset=utf-8' ]
  [[ "$(header Content-Security-Policy)" == "default-src 'none'; script-src 'self';"* ]]
  [ "$(header X-Content-Type-Options)" = nosniff ]
  for file in $(body | grep -o '/assets/[a-z.]*'); do
    [ "$(status_of "$file")" = 200 ]
    cmp "$BATS_TEST_TMPDIR/body" "$WEB_DIR/${file#/assets/}"
  done
  [ "$(status_of /assets/icon.svg)" = 200 ]
  [ "$(header Content-Type)" = image/svg+xml ]
  run ! grep -E 'https?://|style=|onclick=' "$WEB_DIR/index.html"
}

@test "the schemas are served" {
  for file in "$QG_SOURCE"/schema/*.schema.json; do
    [ "$(status_of "/v1/schemas/${file##*/}")" = 200 ]
    [ "$(header Content-Type)" = application/schema+json ]
    cmp "$BATS_TEST_TMPDIR/body" "$file"
  done
  [ "$(status_of /v1/schemas/none.json)" = 404 ]
  [ "$(status_of /v1/schemas/local.mk)" = 404 ]
}

@test "finished jobs go when they are not to be kept, waiting ones stay" {
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1
  for i in 1 2 3; do id=$(document | submit); wait_for "$id" '.state == "succeeded"'; done
  endless | submit
  last=$(document | submit)
  stop_daemon
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1 --keep-jobs 1
  await eval '[ "$(ask /v1/jobs | jq ".jobs | length")" = 3 ]'
  ask /v1/jobs | jq -e --arg last "$last" --arg id "$id" '[.jobs[] | select(.state == "succeeded") | .id] == [$id] and .jobs[0].id == $last'
  await grep -q 'retention: 2 finished jobs' "$LOG"
  stop_daemon
}
