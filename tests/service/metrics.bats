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
  id=$(document | submit)
  wait_for "$id" '.state == "succeeded"'
  [ "$(metric 'quietgear_jobs{state="succeeded"}')" = 1 ]
  [ "$(metric 'quietgear_jobs{state="queued"}')" = 0 ]
  [ "$(metric quietgear_evaluations_total)" = "$(ask "/v1/jobs/$id/evaluations" | wc -l)" ]
  awk -v s="$(metric 'quietgear_job_duration_seconds{state="succeeded"}')" 'BEGIN {exit !(s > 0 && s < 60)}'
  [ "$(metric quietgear_database_bytes)" -ge 4096 ]
  [ "$(metric quietgear_database_wal_bytes)" -gt 4096 ]
  for i in 1 2 3; do status_of /v1/jobs/nobody; done
  status_of /nowhere
  [ "$(metric 'quietgear_http_requests_total{method="GET",route="/v1/jobs/{}",status="404"}')" = 3 ]
  [ "$(metric 'quietgear_http_requests_total{method="",route="",status="404"}')" = 1 ]
  [ "$(metric 'quietgear_http_requests_total{method="POST",route="/v1/jobs",status="201"}')" = 1 ]
  # each metric has its help and type, once
  ask /metrics >"$BATS_TEST_TMPDIR/metrics"
  diff <(sed -n 's/^# TYPE \([a-z_]*\) .*/\1/p' "$BATS_TEST_TMPDIR/metrics") \
    <(grep -v '^#' "$BATS_TEST_TMPDIR/metrics" | sed 's/[{ ].*//' | uniq)
  [ "$(status_of /metrics)" = 200 ]
  [ "$(header Content-Type)" = 'text/plain; version=0.0.4; charset=utf-8' ]
}
