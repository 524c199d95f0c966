#!/usr/bin/env bats
# What systemd asks of a service: hardening, readiness, a watchdog that means something, a clean end.

load helper

setup() {
  STATE=$BATS_TEST_TMPDIR/state
  LOG=$STATE.log
  UNIT=$QG_BUILD/systemd/quietgeard.service
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
  [ -z "${LISTENER:-}" ] || kill "$LISTENER" 2>/dev/null || true
}

# Plays systemd's notification socket: each message is a line of $BATS_TEST_TMPDIR/told.
listen() {
  python3 - "$BATS_TEST_TMPDIR/notify" "$BATS_TEST_TMPDIR/told" 3>&- <<'PYTHON' &
import socket, sys
channel = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
channel.bind(sys.argv[1])
with open(sys.argv[2], 'w') as told:
    while True:
        print(channel.recv(4096).decode(), file=told, flush=True)
PYTHON
  LISTENER=$!
  await test -S "$BATS_TEST_TMPDIR/notify"
  export NOTIFY_SOCKET=$BATS_TEST_TMPDIR/notify
}

# How often the message $1 was told.
told() {
  grep -cx "$1" "$BATS_TEST_TMPDIR/told" || true
}

# Waits until $1 was told at least $2 times.
wait_told() {
  await was_told "$@" || { cat "$BATS_TEST_TMPDIR/told" "$LOG" >&2; return 1; }
}

was_told() {
  [ "$(told "$1")" -ge "$2" ]
}

# Waits until all that was told so far is in the file: a message of our own comes behind it.
hear_all() {
  MARK=$((${MARK:-0} + 1))
  python3 -c 'import socket, sys; socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM).sendto(sys.argv[2].encode(), sys.argv[1])' \
    "$NOTIFY_SOCKET" "MARK=$MARK"
  wait_told "MARK=$MARK" 1
}

@test "the unit is exposed to 1.5 at most, and well-formed" {
  command -v systemd-analyze >/dev/null || skip "no systemd-analyze"
  run -0 systemd-analyze security --offline=true --threshold=15 --no-pager "$UNIT"
  run -1 systemd-analyze security --offline=true --threshold=5 --no-pager "$UNIT" # the limit is one
  # a copy whose paths exist here
  for name in quietgeard.service quietgeard.socket; do
    [ -e "$QG_BUILD/systemd/$name" ] && file=$QG_BUILD/systemd/$name || file=$QG_SOURCE/systemd/$name
    sed "s|^ExecStart=.*|ExecStart=$QUIETGEARD|" "$file" >"$BATS_TEST_TMPDIR/$name"
  done
  # connections that come through the socket go by its list of networks, and not by the service's
  for file in "$UNIT" "$QG_SOURCE/systemd/quietgeard.socket"; do
    [ "$(grep '^IPAddress' "$file" | xargs)" = 'IPAddressDeny=any IPAddressAllow=localhost' ]
  done
  run systemd-analyze verify "$BATS_TEST_TMPDIR/quietgeard.service" "$BATS_TEST_TMPDIR/quietgeard.socket"
  echo "$output"
  [[ "$output" != *quietgeard* ]]
}

@test "the user and the directories can be made" {
  command -v systemd-sysusers >/dev/null || skip "no systemd-sysusers"
  mkdir -p "$BATS_TEST_TMPDIR/root/etc"
  systemd-sysusers --root="$BATS_TEST_TMPDIR/root" "$QG_SOURCE/systemd/quietgear.sysusers" || skip "not allowed here"
  grep -q '^quietgear:.*:/var/lib/quietgear:' "$BATS_TEST_TMPDIR/root/etc/passwd"
  [ "$(id -u)" = 0 ] || skip "only root can give directories away"
  systemd-tmpfiles --root="$BATS_TEST_TMPDIR/root" --create "$QG_BUILD/systemd/quietgear.tmpfiles"
  [ "$(stat -c %a "$BATS_TEST_TMPDIR/root/var/lib/quietgear")" = 700 ]
  # where the settings are read from, whatever the prefix
  settings=$("$QUIETGEARD" --help | grep -o '[^ ]*/quietgeard.conf')
  [ "$(stat -c %a "$BATS_TEST_TMPDIR/root$(dirname "$settings")")" = 750 ]
}

@test "it says when it is ready, that it lives, and that it stops; running jobs go on after the next start" {
  listen
  export WATCHDOG_USEC=600000
  start_daemon "$STATE" --jobs 1
  wait_told READY=1 1
  id=$(endless | submit)
  wait_for "$id" '.progress.done > 5'
  wait_told WATCHDOG=1 5
  [ "$(told STOPPING=1)" = 0 ]
  kill -TERM "$DAEMON"
  status=0
  wait "$DAEMON" || status=$?
  [ "$status" = 0 ]
  hear_all
  [ "$(told STOPPING=1)" = 1 ]
  unset WATCHDOG_USEC
  count=$(told WATCHDOG=1)
  start_daemon "$STATE" --jobs 1
  wait_told READY=1 2
  wait_for "$id" '.state == "running" and .progress.done > 5'
  hear_all
  [ "$(told WATCHDOG=1)" = "$count" ] # nobody wanted to hear
}

# Starts the daemon as systemd does with a socket unit: the socket is descriptor 3, at the port in $BATS_TEST_TMPDIR/port.
start_with_socket() {
  python3 - "$BATS_TEST_TMPDIR/port" "$QUIETGEARD" --config /dev/null --state-dir "$STATE" --web-dir "$WEB_DIR" \
    --schema-dir "$QG_SOURCE/schema" "$@" 2>>"$LOG" 3>&- <<'PYTHON' &
import os, socket, sys
listener = socket.create_server(('127.0.0.1', 0))
port = listener.getsockname()[1]
if listener.fileno() != 3:
    os.dup2(listener.fileno(), 3)
os.set_inheritable(3, True)
os.environ.update(LISTEN_FDS='1', LISTEN_PID=str(os.getpid()))
with open(sys.argv[1], 'w') as file:
    print(port, file=file)
os.execv(sys.argv[2], [argument.replace('PORT', str(port)) for argument in sys.argv[2:]])
PYTHON
  DAEMON=$!
  await grep -q 'listening on' "$LOG"
  URL=http://127.0.0.1:$(cat "$BATS_TEST_TMPDIR/port")
}

@test "a socket that is handed over goes before the setting, and the log says so where they differ" {
  start_with_socket --listen 127.0.0.1:1
  [ "$(status_of /healthz)" = 200 ]
  grep -q "warning: listen = 127.0.0.1:1 has no effect.*ListenStream=" "$LOG"
  stop_daemon
  for flags in '' '--listen 127.0.0.1:PORT'; do
    : >"$LOG"
    start_with_socket $flags
    [ "$(status_of /healthz)" = 200 ]
    stop_daemon
    run ! grep -q "has no effect" "$LOG"
  done
}

@test "a daemon that hangs while its other threads live does not say that it lives" {
  [ -e "$QG_BUILD/tests/faults/disk.so" ] || skip "no failing disk: make tests/faults/disk.so"
  listen
  export WATCHDOG_USEC=900000 QG_FAULT_FILE=$BATS_TEST_TMPDIR/fault ASAN_OPTIONS=verify_asan_link_order=0
  LD_PRELOAD=$QG_BUILD/tests/faults/disk.so start_daemon "$STATE" --jobs 1
  wait_told WATCHDOG=1 2
  echo -1 >"$QG_FAULT_FILE" # writes do not come back
  document | curl -sS -m "$PATIENCE" -o /dev/null -H 'Content-Type: application/json' --data-binary @- "$URL/v1/jobs" 3>&- &
  client=$!
  await grep -q 'watchdog: http.*does not answer' "$LOG"
  hear_all
  count=$(told WATCHDOG=1)
  sleep 1.5
  hear_all
  [ "$(told WATCHDOG=1)" = "$count" ]
  rm "$QG_FAULT_FILE"
  wait "$client"
  wait_told WATCHDOG=1 $((count + 2))
}
