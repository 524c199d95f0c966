# The JSON Schemas against the documents: examples, bad documents, results. The validator comes from the npm registry
# (tests/package.json); without it these tests are skipped.

setup() {
    : "${QG_SOURCE:=$(cd "$BATS_TEST_DIRNAME/../.." && pwd)}" "${QG_BUILD:=$QG_SOURCE}"
    [ -d "$QG_SOURCE/tests/node_modules/ajv" ] || skip "no validator: run npm ci in tests/"
}

schemas() { node "$QG_SOURCE/tests/schema/schemas.mjs" "$@"; }

# Prints the bad documents of which the schema says $1.
bad() { awk -F '\t' -v want="$1" -v dir="$QG_SOURCE/tests/schema/bad/" '!/^#/ && $4 == want {print dir $1}' \
    "$QG_SOURCE/tests/schema/bad.tsv"; }

@test "every example is a valid job" {
    schemas job valid "$QG_SOURCE"/schema/examples/*.json
}

@test "bad documents are invalid where a schema can say so" {
    mapfile -t files < <(bad invalid)
    [ "${#files[@]}" -ge 70 ]
    schemas job invalid "${files[@]}"
}

@test "bad documents of which a schema cannot say so are valid" {
    mapfile -t files < <(bad valid)
    [ "${#files[@]}" -ge 15 ]
    schemas job valid "${files[@]}"
}

@test "what the writers write is valid" {
    QG_SAMPLES=$BATS_TEST_TMPDIR "$QG_BUILD/tests/schema/test_result"
    QG_SAMPLES=$BATS_TEST_TMPDIR "$QG_BUILD/tests/schema/test_drawing"
    schemas result valid "$BATS_TEST_TMPDIR"/result_*.json
    schemas profile valid "$BATS_TEST_TMPDIR"/profile_*.json
    schemas evaluation valid "$BATS_TEST_TMPDIR"/evaluation*.json
    schemas frequency-response valid "$BATS_TEST_TMPDIR/frequency-response.json"
}

@test "a computed result is valid, and its job is a valid job" {
    jq '.analysis = {"speeds": {"count": 10}}' "$QG_SOURCE/schema/examples/case_S_standard.json" >"$BATS_TEST_TMPDIR/job.json"
    "$QG_BUILD/quietgear" run "$BATS_TEST_TMPDIR/job.json" -o "$BATS_TEST_TMPDIR/result.json"
    jq .job "$BATS_TEST_TMPDIR/result.json" >"$BATS_TEST_TMPDIR/echo.json"
    schemas result valid "$BATS_TEST_TMPDIR/result.json"
    schemas job valid "$BATS_TEST_TMPDIR/echo.json"
}

@test "a full field is valid" {
    for case in S_standard H_optimize; do
        "$QG_BUILD/quietgear" export --format json "$QG_SOURCE/schema/examples/case_$case.json" --position 0.1 \
            -o "$BATS_TEST_TMPDIR/field_$case.json"
    done
    schemas field valid "$BATS_TEST_TMPDIR"/field_*.json
    jq 'del(.gear.quads)' "$BATS_TEST_TMPDIR/field_S_standard.json" >"$BATS_TEST_TMPDIR/less.json"
    schemas field invalid "$BATS_TEST_TMPDIR/less.json"
}

@test "a result with a member too many or too few is invalid" {
    QG_SAMPLES=$BATS_TEST_TMPDIR "$QG_BUILD/tests/schema/test_result"
    jq '.design.load_cases[0].extra = 1' "$BATS_TEST_TMPDIR/result_optimize.json" >"$BATS_TEST_TMPDIR/more.json"
    jq 'del(.geometry.gear.base_radius_mm)' "$BATS_TEST_TMPDIR/result_optimize.json" >"$BATS_TEST_TMPDIR/less.json"
    schemas result invalid "$BATS_TEST_TMPDIR/more.json" "$BATS_TEST_TMPDIR/less.json"
}
