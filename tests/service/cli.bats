# quietgear, the command line: exit status, what goes to which stream, files whole or not at all.

load helper

setup() {
    quietgear=$QG_BUILD/quietgear
    examples=$QG_SOURCE/schema/examples
    bad=$QG_SOURCE/tests/schema/bad
    cd "$BATS_TEST_TMPDIR"
    jq '.analysis = {"speeds": {"count": 20}}' "$examples/case_S_standard.json" >quick.json
    jq '.optimizer.random_samples = 1000000 | .name = "long"' "$examples/case_S_optimize.json" >long.json
}

@test "--help and --version" {
    quietly "$quietgear" --help
    [ "$status" -eq 0 ] && [ ! -s err ]
    grep -q 'quietgear run JOB.json' out
    quietly "$quietgear" --version
    [ "$status" -eq 0 ]
    grep -Eqx 'quietgear [0-9]+\.[0-9]+\.[0-9]+' out
}

@test "a wrong command line is status 2 and says how it goes" {
    for words in "" "run" "run a b" "dance quick.json" "--frob run quick.json" "run quick.json --threads 0" \
        "run quick.json --threads 1025" "run quick.json --threads two" "check quick.json --threads 0" "check quick.json -o x" \
        "run quick.json --key k" "watch x -o y" "run quick.json --server http://localhost"; do
        # shellcheck disable=SC2086 # words
        quietly "$quietgear" $words
        echo "$words: $status"
        [ "$status" -eq 2 ] && [ ! -s out ]
        grep -q '^usage: quietgear run' err
    done
}

@test "check prints the geometry" {
    quietly "$quietgear" check --threads 2 "$examples/case_S_standard.json"
    [ "$status" -eq 0 ]
    grep -Eqx '.*case_S_standard.json: about 1 evaluation, 0\.[0-9] s on 2 threads, at most [0-9]+ MB of memory' err
    jq -e '(.backlash_mm - 0.31208 | fabs) < 1e-5 and (.pinion.form_radius_mm - 40.4654 | fabs) < 1e-4
        and (.gear.form_radius_mm - 63.7308 | fabs) < 1e-4 and (.equivalent_mass_kg - 0.32707 | fabs) < 2e-5
        and (.contact_ratio - 1.217 | fabs) < 1e-3' out
}

@test "a document comes from standard input as -" {
    quietly "$quietgear" check - <"$examples/case_H_optimize.json"
    [ "$status" -eq 0 ]
    jq -e '(.contact_ratio - 2.006 | fabs) < 1e-3' out
    quietly "$quietgear" check - <"$bad/range_teeth_few.json"
    [ "$status" -eq 2 ]
    grep -qx 'standard input: /gear_pair/pinion/teeth: found 3, allowed 5 to 1000' err
}

@test "a fault is one line: document, place, found, allowed" {
    quietly "$quietgear" run "$bad/range_teeth_few.json"
    [ "$status" -eq 2 ] && [ ! -s out ]
    [ "$(cat err)" = "$bad/range_teeth_few.json: /gear_pair/pinion/teeth: found 3, allowed 5 to 1000" ]
}

@test "all faults come at once" {
    jq '.gear_pair.pinion.teeth = 3 | .gear_pair.module_mm = "3" | .colour = 1 | del(.load_cases[0].torque_fraction)' \
        quick.json >faults.json
    quietly "$quietgear" check faults.json
    [ "$status" -eq 2 ]
    [ "$(wc -l <err)" -eq 4 ]
    for place in /gear_pair/pinion/teeth /gear_pair/module_mm /colour /load_cases/0; do
        grep -q "^faults.json: $place: found " err
    done
}

@test "every bad document is status 2 at its place" {
    grep -v '^#' "$QG_SOURCE/tests/schema/bad.tsv" >table
    rows=0
    while IFS=$'\t' read -r file _ pointer _; do
        [ "$pointer" = '""' ] && pointer= || pointer="$pointer: "
        quietly "$quietgear" check "$bad/$file"
        echo "$file: $status $(head -n 1 err)"
        [ "$status" -eq 2 ] && [ ! -s out ]
        grep -qF "$bad/$file: $pointer" err
        rows=$((rows + 1))
    done <table
    [ "$rows" -ge 70 ]
}

@test "a document that is too long, or not there, is status 2" {
    head -c 1048577 /dev/zero | tr '\0' ' ' >large.json
    quietly "$quietgear" check large.json
    [ "$status" -eq 2 ]
    grep -q 'found 1048577 bytes, allowed at most 1048576' err
    quietly "$quietgear" check nowhere.json
    [ "$status" -eq 2 ]
    grep -qx 'nowhere.json: No such file or directory' err
    quietly "$quietgear" check .
    [ "$status" -eq 2 ]
}

@test "what a stranger wrote reaches the terminal without control characters" {
    printf '{"kind": "\\u001b[2J\\u009b", "\\u001b[31mkey": 1}' >escapes.json
    quietly "$quietgear" check escapes.json
    [ "$status" -eq 2 ]
    grep -q '^escapes.json: /\\u001b\[31mkey: found the unknown key "\\u001b\[31mkey"' err
    grep -q '^escapes.json: /kind: found "\\u001b\[2J\\u009b"' err
    [ "$(LC_ALL=C tr -d '\012\040-\176' <err | wc -c)" -eq 0 ]
}

@test "run prints the result on standard output and where the time went on standard error" {
    quietly "$quietgear" run quick.json
    [ "$status" -eq 0 ]
    jq -e '.design.f_pps_um > 5 and .design.f_dte > 0 and (.design.load_cases | length) == 3
        and (.design.load_cases[0].frequency_response.rms | length) == 20 and .search == null' out
    [ "$(wc -l <err)" -eq 1 ]
    grep -Eq '^[0-9.]+ s on [0-9]+ threads?: compliance [0-9.]+ s, statics [0-9.]+ s, dynamics [0-9.]+ s$' err
}

@test "the result does not depend on the number of threads" {
    "$quietgear" run quick.json --threads 1 | jq -S 'del(.timing)' >one
    "$quietgear" run quick.json --threads 3 | jq -S 'del(.timing)' >three
    cmp one three
    "$quietgear" run quick.json -t 3 | jq -e '.timing.threads == 3 and .timing.wall_s > 0'
}

@test "the job in a result runs again to the same result" {
    "$quietgear" run quick.json -o first.json
    jq .job first.json >again.json
    "$quietgear" run again.json -o second.json
    cmp <(jq 'del(.timing)' first.json) <(jq 'del(.timing)' second.json)
}

@test "an optimization is better than its reference" {
    jq '.optimizer.random_samples = 12 | .optimizer.simplex_iterations = 4 | .reliability.samples = 5
        | .analysis.speeds.count = 60' "$examples/case_S_optimize.json" >small.json
    quietly "$quietgear" run small.json -o result.json
    [ "$status" -eq 0 ] && [ ! -s out ]
    jq -e '.design.f_dte < .reference.f_dte and .improvement.f_dte_percent > 0 and .search.evaluations >= 12
        and (.search.history | length) > 0 and .reliability.samples == 5
        and .search.history[-1].best == .design.f_dte' result.json
}

@test "a result file has the usual permissions and leaves nothing beside it" {
    umask 027
    "$quietgear" run quick.json -o result.json
    [ "$(stat -c %a result.json)" = 640 ]
    [ "$(ls | grep -c result)" -eq 1 ]
    jq -e .design result.json >/dev/null
}

@test "a result goes into what is no plain file, and through symbolic links" {
    mkfifo pipe
    cat pipe >got &
    "$quietgear" run quick.json -o pipe
    wait $!
    [ -p pipe ]
    jq -e .design got >/dev/null
    "$quietgear" run quick.json -o /dev/stdout | jq -e .design >/dev/null

    echo old >result.json
    ln -s result.json latest.json
    "$quietgear" run quick.json -o latest.json
    [ -L latest.json ]
    jq -e .design result.json >/dev/null
    rm pipe got
    [ "$(ls | grep -Ec '^(pipe|result|latest)')" -eq 2 ]
}

@test "a result that cannot be written is status 1" {
    quietly "$quietgear" run quick.json -o nowhere/result.json
    [ "$status" -eq 1 ]
    grep -q '^nowhere/result.json: No such file or directory$' err
    quietly "$quietgear" run quick.json -o /
    [ "$status" -eq 1 ]
    grep -q '^/: Is a directory$' err
    status=0
    "$quietgear" run quick.json >/dev/full 2>err || status=$?
    [ "$status" -eq 1 ]
    grep -q '^standard output: No space left on device$' err
}

@test "an interrupt cancels cleanly and leaves an older result alone" {
    echo old >result.json
    for signal in INT TERM; do
        "$quietgear" run long.json -o result.json 2>err &
        pid=$!
        await catches "$pid" "$(kill -l "$signal")"
        sleep 0.5 # somewhere in the middle
        kill -s "$signal" "$pid"
        status=0
        wait "$pid" || status=$?
        [ "$status" -eq 1 ]
        grep -qx 'quietgear: cancelled' err
        [ "$(cat result.json)" = old ]
        [ "$(ls | grep -c result)" -eq 1 ]
    done
}

@test "warnings go to standard error and into the result" {
    jq '.relief.pinion.root = {"end_radius_mm": 40, "amplitude_mm": 0.01}' quick.json >warned.json
    quietly "$quietgear" check warned.json
    [ "$status" -eq 0 ]
    grep -q '^warned.json: warning: /relief/pinion/root/end_radius_mm: ' err
    jq -e . out >/dev/null
    quietly "$quietgear" run warned.json
    [ "$status" -eq 0 ]
    jq -e '.warnings | length == 1 and (.[0] | startswith("/relief/pinion/root/end_radius_mm: "))' out
    [ "$(grep -c warning err)" -eq 1 ]
}

@test "displacements that are not small are warned of" {
    jq '.gear_pair.pinion.bore_diameter_mm = 1 | .load_cases = [{"torque_fraction": 0.001}, {"torque_fraction": 1}]' \
        quick.json >thin.json
    quietly "$quietgear" run thin.json
    [ "$status" -eq 0 ]
    grep -q '^thin.json: warning: /gear_pair/nominal_torque_nm: design at 470 N m: ' err
    jq -e '.warnings | map(select(startswith("/gear_pair/nominal_torque_nm: "))) | length == 1' out
    jq -e '.warnings | any(contains("design at 470 N m") and contains("a tenth of the module"))' out
    "$quietgear" run quick.json | jq -e '.warnings == []'
}

@test "a terminal gets a progress bar" {
    script -qec true /dev/null >/dev/null 2>&1 || skip "no pseudo-terminal here"
    script -qec "'$quietgear' run quick.json -o result.json" typescript >/dev/null
    grep -aq 'compliance' typescript
    grep -aEq '\[[#.]{24}\] +[0-9]+ %' typescript
    jq -e .design result.json >/dev/null
}
