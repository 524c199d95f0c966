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

# How many seconds the tests wait at most for what has to happen: a bound against hanging, not a measure, for nobody knows what
# else the machine does. QG_PATIENCE makes it that many times longer, for daemons slowed down by a sanitizer.
PATIENCE=$((120 * ${QG_PATIENCE:-1}))

# Waits until a command succeeds.
await() {
  local end=$((SECONDS + PATIENCE))
  until "$@"; do
    [ "$SECONDS" -lt "$end" ] || { echo "waited in vain for: $*" >&2; return 1; }
    sleep 0.05
  done
}

# A port that nothing listens on, below those that the system gives to outgoing connections, one of which might have it soon.
free_port() {
  local port
  for port in $(shuf -i 10240-32000 -n 50); do
    (exec 9<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port"; return; }
  done
}

# Whether the process $1 has ended; one that waits to be waited for by this shell has.
is_gone() {
  [ ! -d "/proc/$1" ] || [ "$(awk '{print $3}' "/proc/$1/stat" 2>/dev/null)" = Z ]
}

# Whether all threads of the process $1 are asleep: then it is not the processor that they wait for.
is_asleep() {
  local stat line
  for stat in "/proc/$1/task"/*/stat; do
    { read -r line <"$stat"; } 2>/dev/null || continue
    line=${line##*) }
    [ "${line%% *}" = S ] || return 1
  done
}

# Whether the process $1 has a handler for the signal number $2.
catches() {
  local mask
  mask=$(awk '$1 == "SigCgt:" {print $2}' "/proc/$1/status")
  [ $((0x${mask:-0} >> ($2 - 1) & 1)) = 1 ]
}

# Whether the build under test has AddressSanitizer, which slows all down.
sanitized() {
  grep -q __asan_init "$QG_BUILD/quietgear"
}

# Starts a daemon on the state directory $1 with further flags; sets URL, DAEMON and LOG.
start_daemon() {
  local state=$1 port_file=$1.port
  shift
  rm -f "$port_file"
  "$QUIETGEARD" --config /dev/null --listen 127.0.0.1:0 --port-file "$port_file" --state-dir "$state" \
    --web-dir "$WEB_DIR" --schema-dir "$QG_SOURCE/schema" "$@" 2>>"$state.log" 3>&- &
  DAEMON=$!
  LOG=$state.log
  await is_up_or_gone "$port_file"
  [ -s "$port_file" ] || { cat "$state.log" >&2; return 1; }
  URL=http://127.0.0.1:$(cat "$port_file")
  export URL DAEMON LOG
}

is_up_or_gone() {
  [ -s "$1" ] || is_gone "$DAEMON"
}

# Stops the daemon with a signal (TERM) and waits until it is gone; STOPPED is its status. A daemon built with sanitizers must not
# have complained.
stop_daemon() {
  kill -"${1:-TERM}" "$DAEMON" 2>/dev/null || return 0
  see_end
}

see_end() {
  await is_gone "$DAEMON" || return
  STOPPED=0
  wait "$DAEMON" 2>/dev/null || STOPPED=$?
  ! grep -A 40 -E 'Sanitizer|runtime error' "$LOG" >&2
}

# The same, and it waits for nobody meanwhile: of looks at it, one each 50 ms, not 60 find all of its threads asleep. How long
# it takes to do what it has to do is the machine's affair.
stop_at_once() {
  local asleep=0
  kill -TERM "$DAEMON"
  until is_gone "$DAEMON"; do
    ! is_asleep "$DAEMON" || asleep=$((asleep + 1))
    [ "$asleep" -lt 60 ] || { echo "the daemon waits for something" >&2; return 1; }
    sleep 0.05
  done
  see_end
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

# Whether a request gets the status $1: for await.
answers() {
  [ "$(status_of "${@:2}")" = "$1" ]
}

# Follows the events of the path $2 into the file $1 with further curl arguments, in the background; returns when the stream is
# open. STREAM is the process.
open_stream() {
  local file=$1 path=$2
  shift 2
  : >"$file"
  curl -sS -N -m "$PATIENCE" "$@" "$URL$path" >"$file" 3>&- &
  STREAM=$!
  await grep -q '^retry:' "$file"
}

# Asks for a path with further curl arguments, in the background, the answer into the file $1; returns when the daemon has read
# the request, so that it waits or is answered. ASKED is the process.
open_poll() {
  local file=$1 path=$2
  shift 2
  curl -sS -v -m "$PATIENCE" "$@" "$URL$path" -o "$file" 2>"$file.talk" 3>&- &
  ASKED=$!
  await grep -q '^> GET' "$file.talk"
  # the daemon has one thread for requests and takes them as they come: two later ones are answered
  status_of /healthz "$@" >/dev/null
  status_of /healthz "$@" >/dev/null
}

# Asserts that the last status_of was a problem document of this status and code.
assert_problem() {
  [ "$(header Content-Type)" = application/problem+json ]
  [ "$(body | jq -r .status)" = "$1" ]
  [ "$(body | jq -r .type)" = "urn:quietgear:problem:$2" ]
  [ -n "$(body | jq -r .title)" ]
}

# Waits until the job $1 fulfils the jq condition $2, by long polls; fails as soon as the job has ended without.
wait_for() {
  local end=$((SECONDS + PATIENCE)) job
  while [ "$SECONDS" -lt "$end" ]; do
    job=$(ask "/v1/jobs/$1" -H 'Prefer: wait=1')
    jq -e "$2" <<<"$job" >/dev/null && return 0
    jq -e '.finished_at != null' <<<"$job" >/dev/null && break
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
