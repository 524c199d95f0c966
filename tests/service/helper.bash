# What the service tests share: a daemon of their own, documents, and words for asking it.
#
# A file's daemon is started in setup_file and stopped in teardown_file; its address, process and log are exported. The
# daemon under test is $QUIETGEARD, or the one in the build tree.

bats_require_minimum_version 1.5.0

QG_SOURCE=${QG_SOURCE:-$(cd "$BATS_TEST_DIRNAME/../.." && pwd)}
QG_BUILD=${QG_BUILD:-$QG_SOURCE}
QUIETGEARD=${QUIETGEARD:-$QG_BUILD/quietgeard}
# The page as built; a release carries it among the sources.
WEB_DIR=$QG_BUILD/web/dist
[ -d "$WEB_DIR" ] || WEB_DIR=$QG_SOURCE/web/dist
export TSAN_OPTIONS=${TSAN_OPTIONS:-suppressions=$QG_SOURCE/tests/tsan.supp}
EXAMPLE=$QG_SOURCE/schema/examples/case_S_optimize.json

# Whether the build under test has AddressSanitizer, which slows all down.
sanitized() {
  grep -q __asan_init "$QG_BUILD/quietgear"
}

# Starts a daemon on the state directory $1 with further flags; sets URL, DAEMON and LOG.
start_daemon() {
  local state=$1 port_file=$1.port i
  shift
  rm -f "$port_file"
  "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --port-file "$port_file" --state-dir "$state" \
    --web-dir "$WEB_DIR" --schema-dir "$QG_SOURCE/schema" "$@" 2>>"$state.log" 3>&- &
  DAEMON=$!
  LOG=$state.log
  for ((i = 0; i < 200; i++)); do
    [ -s "$port_file" ] && break
    kill -0 "$DAEMON" 2>/dev/null || break
    sleep 0.05
  done
  [ -s "$port_file" ] || { cat "$state.log" >&2; return 1; }
  URL=http://127.0.0.1:$(cat "$port_file")
  export URL DAEMON LOG
}

# Stops the daemon with a signal (TERM) and waits until it is gone, 20 s at most. A daemon built with sanitizers must not
# have complained.
stop_daemon() {
  local i
  kill -"${1:-TERM}" "$DAEMON" 2>/dev/null || return 0
  for ((i = 0; i < 400; i++)); do
    # Gone, or a zombie of this shell that waits to be waited for.
    if [ ! -d "/proc/$DAEMON" ] || [ "$(awk '{print $3}' "/proc/$DAEMON/stat" 2>/dev/null)" = Z ]; then
      wait "$DAEMON" 2>/dev/null || true
      ! grep -A 40 -E 'Sanitizer|runtime error' "$LOG" >&2
      return
    fi
    sleep 0.05
  done
  echo "the daemon does not stop" >&2
  return 1
}

# Starts a daemon for the whole file.
start_for_file() {
  STATE=$BATS_FILE_TMPDIR/state
  export STATE
  start_daemon "$STATE" "$@"
}

# The example with small figures, changed by the jq program $1: 12 samples, 6 simplex iterations, 40 speeds.
document() {
  jq -c '.optimizer.random_samples = 12 | .optimizer.simplex_iterations = 6 | .analysis.speeds.count = 40
         | .reliability.samples = 20 | .labels = []' "$EXAMPLE" | jq -c "${1:-.}"
}

# A document that keeps the daemon busy for longer than any test.
endless() {
  document ".optimizer.random_samples = 1000000 | ${1:-.}"
}

# Posts the document on stdin with further curl arguments; prints the job's id.
submit() {
  curl -sS -f -H 'Content-Type: application/json' --data-binary @- "$@" "$URL/v1/jobs" | jq -r .id
}

# curl to a path of the daemon.
ask() {
  local path=$1
  shift
  curl -sS "$@" "$URL$path"
}

# Holds each line of the file $2, a JSON document, against the schema $1; without the validator nothing is held.
assert_schema() {
  [ -d "$QG_SOURCE/tests/node_modules/ajv" ] || return 0
  local directory=$BATS_TEST_TMPDIR/$1.documents
  rm -rf "$directory"
  mkdir "$directory"
  split -l 1 "$2" "$directory/"
  node "$QG_SOURCE/tests/schema/schemas.mjs" "$1" valid "$directory"/*
}

# The status that a request gets; its body goes to $BATS_TEST_TMPDIR/body, its header to .../header.
status_of() {
  local path=$1
  shift
  : >"$BATS_TEST_TMPDIR/body"
  curl -sS -o "$BATS_TEST_TMPDIR/body" -D "$BATS_TEST_TMPDIR/header" -w '%{http_code}' "$@" "$URL$path"
}

body() {
  cat "$BATS_TEST_TMPDIR/body"
}

# The value of a header field of the last status_of.
header() {
  sed -n "s/^$1: //Ip" "$BATS_TEST_TMPDIR/header" | tr -d '\r'
}

# Asserts that the last status_of was a problem document of this status and code.
assert_problem() {
  [ "$(header Content-Type)" = application/problem+json ]
  [ "$(body | jq -r .status)" = "$1" ]
  [ "$(body | jq -r .type)" = "urn:quietgear:problem:$2" ]
  [ -n "$(body | jq -r .title)" ]
}

# Waits until the job $1 fulfils the jq condition $2, $3 (30) seconds at most, by long polls. QG_PATIENCE makes it that many
# times longer, for daemons slowed down by a sanitizer.
wait_for() {
  local end=$((SECONDS + ${3:-30} * ${QG_PATIENCE:-1})) job
  while [ "$SECONDS" -lt "$end" ]; do
    job=$(ask "/v1/jobs/$1" -H 'Prefer: wait=1')
    jq -e "$2" <<<"$job" >/dev/null && return 0
    jq -e '.state == "failed"' <<<"$job" >/dev/null && break
  done
  echo "waited in vain for $2: $job" >&2
  return 1
}

# Cancels a job, waits for its end, and deletes it.
remove() {
  ask "/v1/jobs/$1/cancel" -X POST -o /dev/null
  wait_for "$1" '.finished_at != null'
  ask "/v1/jobs/$1" -X DELETE -f
}

# The members of a result that depend on nothing but the document.
essence() {
  jq -S 'del(.timing)' "$1"
}

# Runs a command with its output and its errors in the files out and err; its exit status is in $status.
quietly() {
  status=0
  "$@" >out 2>err || status=$?
}
