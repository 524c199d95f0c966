#!/usr/bin/env bats
# GET /metrics: the figures are those of what happened.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

# The value of the metric that is written as $1.
metric() {
  ask /metrics -f | awk -v name="$1" '$1 == name {print $2}'
}

@test "jobs, evaluations and requests are counted" {
  SECONDS=0
  id=$(document | submit)
  wait_for "$id" '.state == "succeeded"'
  [ "$(metric 'quietgear_jobs{state="succeeded"}')" = 1 ]
  [ "$(metric 'quietgear_jobs{state="queued"}')" = 0 ]
  [ "$(metric quietgear_evaluations_total)" = "$(ask "/v1/jobs/$id/evaluations" | wc -l)" ]
  awk -v s="$(metric 'quietgear_job_duration_seconds_sum{state="succeeded"}')" 'BEGIN {exit !(s > 0 && s < '$((SECONDS + 1))')}'
  [ "$(metric 'quietgear_job_duration_seconds_count{state="succeeded"}')" = 1 ]
  [ "$(metric 'quietgear_job_duration_seconds_count{state="failed"}')" = 0 ]
  [ "$(metric quietgear_database_writable)" = 1 ]
  [ "$(metric quietgear_database_bytes)" -ge 4096 ]
  [ "$(metric quietgear_database_wal_bytes)" -gt 4096 ]
  for i in 1 2 3; do status_of /v1/jobs/nobody; done
  status_of /nowhere
  [ "$(metric 'quietgear_http_requests_total{method="GET",route="/v1/jobs/{}",status="404"}')" = 3 ]
  [ "$(metric 'quietgear_http_requests_total{method="",route="",status="404"}')" = 1 ]
  [ "$(metric 'quietgear_http_requests_total{method="POST",route="/v1/jobs",status="201"}')" = 1 ]
  [ "$(metric 'quietgear_http_request_duration_seconds_count{method="GET",route="/v1/jobs/{}"}')" -ge 3 ]
  [ "$(status_of /metrics)" = 200 ]
  [ "$(header Content-Type)" = 'text/plain; version=0.0.4; charset=utf-8' ]
}

@test "the text is what Prometheus reads, to the letter" {
  ask /metrics -f >"$BATS_TEST_TMPDIR/before"
  for path in /healthz /readyz /nowhere /v1/jobs; do ask "$path" >/dev/null; done
  ask /metrics -f >"$BATS_TEST_TMPDIR/after"
  run -0 node "$QG_SOURCE/tests/service/metrics.mjs" "$BATS_TEST_TMPDIR/before" "$BATS_TEST_TMPDIR/after"
  echo "$output"
  [[ "$output" == *"counters and 2 histograms"* ]]
  # the reader does object
  for fault in 's/_total{/_totals{/' '/^# TYPE quietgear_jobs /d' 's/le="+Inf"/le="9"/' 's/status="404"/status=404/' \
    's/^process_open_fds .*/process_open_fds many/' '1{h;d};${p;x}' 's/\(_bucket.*le="0.5"\).*/\1 999999/'; do
    sed -e "$fault" "$BATS_TEST_TMPDIR/after" >"$BATS_TEST_TMPDIR/wrong"
    run -1 node "$QG_SOURCE/tests/service/metrics.mjs" "$BATS_TEST_TMPDIR/before" "$BATS_TEST_TMPDIR/wrong"
  done
}

# The descriptors but for that of the connection which asks; those of connections of before may just be closed.
counts_descriptors() {
  local there
  there=$(find "/proc/$DAEMON/fd" -mindepth 1 | wc -l)
  fds=$(metric process_open_fds)
  [ "$fds" -ge "$there" ] && [ "$fds" -le $((there + 3)) ]
}

@test "memory, descriptors and the version are those of the process" {
  awk -v a="$(metric process_resident_memory_bytes)" -v b="$(awk '/VmRSS/ {print $2 * 1024}' "/proc/$DAEMON/status")" \
    'BEGIN {exit !(a > 0.5 * b && a < 2 * b)}'
  await counts_descriptors
  version=$("$QUIETGEARD" --version | cut -d' ' -f2)
  [ "$(metric "quietgear_build_info{version=\"$version\"}")" = 1 ]
}
