# quietgear submit, watch, result, cancel: the command line against a daemon.
load helper

setup_file() { start_for_file --jobs 1; }
teardown_file() { stop_daemon; }

setup() {
    quietgear=$QG_BUILD/quietgear
    export QUIETGEAR_SERVER=$URL
    cd "$BATS_TEST_TMPDIR"
    document >job.json
}

@test "submit prints an id, watch waits for the end, result is that of run" {
    quietly "$quietgear" submit job.json
    [ "$status" -eq 0 ] && [ ! -s err ]
    [ "$(wc -l <out)" -eq 1 ]
    id=$(cat out)
    quietly "$quietgear" watch "$id"
    [ "$status" -eq 0 ] && [ ! -s out ]
    [ "$(tail -n 1 err)" = "$id: succeeded" ]
    quietly "$quietgear" result "$id" -o result.json
    [ "$status" -eq 0 ] && [ ! -s out ]
    "$quietgear" run job.json -o here.json
    cmp <(jq -S 'del(.timing)' result.json) <(jq -S 'del(.timing)' here.json)
    "$quietgear" result "$id" | cmp - result.json
}

@test "submit takes a document from standard input, and a key makes one job of two" {
    id=$("$quietgear" submit - --key twice <job.json)
    [ "$("$quietgear" submit job.json --key twice)" = "$id" ]
    [ "$("$quietgear" submit job.json)" != "$id" ]
}

@test "a bad document is status 2, its faults those of run" {
    for file in range_teeth_few syntax_truncated unknown_key_escapes; do
        cp "$QG_SOURCE/tests/schema/bad/$file.json" bad.json
        quietly "$quietgear" submit bad.json
        [ "$status" -eq 2 ] && [ ! -s out ]
        cp err submitted
        quietly "$quietgear" check bad.json
        cmp err submitted
    done
}

# How often the daemon was asked for a job.
looks() {
    ask /metrics | awk '$1 == "quietgear_http_requests_total{method=\"GET\",route=\"/v1/jobs/{}\",status=\"200\"}" {n = $2} END {print n + 0}'
}

@test "cancel stops a job: watch ends with status 1, there is no result" {
    endless >endless.json
    id=$("$quietgear" submit endless.json)
    count=$(looks)
    "$quietgear" watch "$id" 2>watched &
    pid=$!
    await eval '[ "$(looks)" -gt "$count" ]'
    quietly "$quietgear" cancel "$id"
    [ "$status" -eq 0 ]
    status=0
    wait "$pid" || status=$?
    [ "$status" -eq 1 ]
    [ "$(tail -n 1 watched)" = "$id: cancelled" ]
    quietly "$quietgear" result "$id" -o result.json
    [ "$status" -eq 1 ] && [ -s err ]
    [ ! -e result.json ]
}

@test "an unknown job is status 2, no daemon status 1" {
    for command in watch result cancel; do
        quietly "$quietgear" "$command" no/such-job
        echo "$command: $status $(cat err)"
        [ "$status" -eq 2 ] && [ ! -s out ]
        quietly "$quietgear" "$command" x --server http://127.0.0.1:1
        [ "$status" -eq 1 ] && [ ! -s out ]
        grep -q '^quietgear: http://127.0.0.1:1: ' err
    done
}

@test "what is not a quietgeard is told apart" {
    quietly "$quietgear" submit job.json --server "$URL/healthz?"
    [ "$status" -eq 1 ] && [ ! -s out ]
}
