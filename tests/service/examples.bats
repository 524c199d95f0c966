#!/usr/bin/env bats
# Documents that the daemon hands out: the examples, and what a job was submitted with.

load helper

setup_file() {
  start_for_file --jobs 1
}

teardown_file() {
  stop_daemon
}

@test "every example is listed with its kind and title, and served as it lies there" {
  [ "$(status_of /v1/examples)" = 200 ]
  body >"$BATS_TEST_TMPDIR/list"
  diff <(jq -r '.examples[].name' "$BATS_TEST_TMPDIR/list") <(cd "$QG_SOURCE/schema/examples" && LC_ALL=C ls | sed 's/[.]json$//')
  jq -r '.examples[] | [.name, .kind, .title, .links.self] | @tsv' "$BATS_TEST_TMPDIR/list" >"$BATS_TEST_TMPDIR/lines"
  while IFS=$'\t' read -r name kind title self; do
    [ "$(status_of "$self")" = 200 ]
    cmp "$BATS_TEST_TMPDIR/body" "$QG_SOURCE/schema/examples/$name.json"
    [ "$(body | jq -r .kind)" = "$kind" ]
    [ "$(body | jq -r --arg name "$name" '.name // $name')" = "$title" ]
  done <"$BATS_TEST_TMPDIR/lines"
  for name in none case_S_none.json ..%2fjob.schema .hidden; do
    [[ "$(status_of "/v1/examples/$name")" == 40[04] ]]
  done
}

@test "the examples are installed with the program" {
  grep -q "^dist_example_DATA" "$QG_SOURCE/schema/local.mk"
  for file in "$QG_SOURCE"/schema/examples/*.json; do
    grep -q "schema/examples/${file##*/}" "$QG_SOURCE/schema/local.mk"
  done
}

@test "a job gives its document back, with the defaults" {
  busy=$(endless | submit)
  id=$(document 'del(.analysis) | .name = "back"' | submit)
  [ "$(status_of "/v1/jobs/$id/document")" = 200 ]
  body | jq -e '.name == "back" and .analysis.mesh_positions > 0'
  body >"$BATS_TEST_TMPDIR/document"
  status_of /v1/check -H 'Content-Type: application/json' --data-binary "@$BATS_TEST_TMPDIR/document"
  diff <(body | jq .document) <(jq . "$BATS_TEST_TMPDIR/document")
  ask "/v1/jobs/$id" | jq -e '.links.document == "/v1/jobs/\(.id)/document" and .links.events == "/v1/jobs/\(.id)/events"'
  [ "$(status_of /v1/jobs/nobody/document)" = 404 ]
  assert_problem 404 not-found
  remove "$id"
  remove "$busy"
}
