#!/usr/bin/env bats
# The daemon's own TLS: what it speaks, and how its certificate is renewed.

load helper

setup() {
  cd "$BATS_TEST_TMPDIR"
  export QUIETGEAR=$QG_BUILD/quietgear
}

teardown() {
  [ -z "${DAEMON:-}" ] || stop_daemon KILL
}

# Makes a certificate for this machine by name $1, as $1.pem and $1.key, that is good for $2 ("expiration_days = 2").
certificate() {
  certtool --generate-privkey --key-type ecdsa --outfile "$1.key" 2>certtool.log
  printf 'cn = "%s"\nip_address = "127.0.0.1"\n%s\ntls_www_server\nsigning_key\nca\ncert_signing_key\n' "$1" "${2:-expiration_days = 2}" >"$1.template"
  certtool --generate-self-signed --load-privkey "$1.key" --template "$1.template" --outfile "$1.pem" 2>>certtool.log
}

@test "TLS: with a certificate the daemon speaks HTTPS, of versions 1.2 and 1.3 only" {
  certificate here
  certificate other
  start_daemon "$BATS_TEST_TMPDIR/tls" --jobs 1 --listen 127.0.0.1:0 --tls-certificate here.pem --tls-key here.key
  plain=$URL URL=https${URL#http}
  grep -q 'listening on https://127.0.0.1:' "$LOG"
  for version in 1.2 1.3; do
    curl -sS -f --cacert here.pem --tlsv$version --tls-max $version "$URL/healthz" | jq -e '.status == "ok"'
  done
  run ! curl -sS -f -k --tls-max 1.1 --ciphers 'DEFAULT@SECLEVEL=0' "$URL/healthz"
  run ! curl -sS -f "$URL/healthz"
  run ! curl -sS -f --cacert other.pem "$URL/healthz"
  run ! curl -sS -f -m "$PATIENCE" "$plain/healthz"
  document >job.json
  id=$("$QUIETGEAR" submit job.json --server "$URL" --ca-file here.pem)
  QUIETGEAR_CA_FILE=here.pem "$QUIETGEAR" watch "$id" --server "$URL"
  curl -sS -f --cacert here.pem -H 'Prefer: wait=5' "$URL/v1/jobs/$id" | jq -e '.state == "succeeded"'
  for authority in nowhere.pem ''; do # an empty variable is none
    QUIETGEAR_CA_FILE=$authority run -1 "$QUIETGEAR" submit job.json --server "$URL"
    [[ "$output" == *certificate* ]]
    [[ "$output" == *'setting certificate file'* ]] && [ -z "$authority" ] && return 1
  done
  endless >endless.json
  busy=$("$QUIETGEAR" submit endless.json --server "$URL" --ca-file here.pem)
  id=$("$QUIETGEAR" submit endless.json --server "$URL" --ca-file here.pem) # nothing happens to it
  open_stream stream /v1/events --cacert here.pem
  await grep -q "$busy" stream
  open_poll waited "/v1/jobs/$id" -f --cacert here.pem -H 'Prefer: wait=60'
  stop_daemon # with a stream and a long poll asleep
  wait "$STREAM"
  wait "$ASKED"
  jq -e --arg id "$id" '.id == $id' waited
  check=("$QUIETGEARD" --check-config --config /dev/null --state-dir "$BATS_TEST_TMPDIR/tls"
    --web-dir "$QG_SOURCE/web" --schema-dir "$QG_SOURCE/schema")
  "${check[@]}" --tls-certificate here.pem --tls-key here.key
  run -2 "${check[@]}" --tls-certificate here.pem --tls-key other.key
  [[ "$output" == 'here.pem and other.key are not a certificate and its key in PEM: '* ]]
  run -2 "${check[@]}" --tls-certificate nowhere.pem --tls-key here.key
  [ "$output" = 'nowhere.pem: No such file or directory' ]
  run -2 "${check[@]}" --tls-certificate here.pem
}

# A daemon on HTTPS with the certificate $1, which is copied to live.pem and live.key.
start_with() {
  certificate "$1"
  install_pair "$1"
  start_daemon "$BATS_TEST_TMPDIR/state" --jobs 1 --tls-certificate live.pem --tls-key live.key
  URL=https${URL#http}
}

install_pair() {
  cp "$1.pem" live.pem
  cp "$1.key" live.key
}

# Tells the daemon to read its certificate, and waits until it has said $1 in the log, $2 times in all.
reload_until() {
  kill -HUP "$DAEMON"
  await is_said "$@" || { cat "$LOG" >&2; return 1; }
}

# Whether $1 is in the log $2 times or more.
is_said() {
  [ "$(grep -c "$1" "$LOG")" -ge "$2" ]
}

# New connections are served the certificate $1, seen by two TLS libraries, and not $2.
serves() {
  curl -sS -f --cacert "$1.pem" -o /dev/null "$URL/healthz"
  gnutls-cli --x509cafile "$1.pem" --port "${URL##*:}" 127.0.0.1 </dev/null >gnutls.log 2>&1 || { cat gnutls.log; return 1; }
  run -60 curl -sS -f --cacert "$2.pem" -o /dev/null "$URL/healthz" # 60: the certificate is not that
}

@test "a renewed certificate serves new connections from SIGHUP on; those of before live on" {
  start_with old
  certificate new
  serves old new
  grep -q 'certificate: read, valid until 20..-' "$LOG"
  # a stream, and a connection that is asked again after the change
  open_stream stream /v1/events --cacert old.pem
  mkfifo more
  gnutls-cli --x509cafile old.pem --port "${URL##*:}" 127.0.0.1 <more >kept 2>&1 3>&- &
  kept=$!
  exec 4>more
  printf 'GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n' >&4
  await grep -q '"ok"' kept
  install_pair new
  serves old new # told nothing yet
  reload_until 'certificate: read again, valid until' 1
  serves new old
  id=$(document | submit --cacert new.pem)
  await grep -q "$id" stream
  printf 'GET /readyz HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n' >&4
  await eval '[ "$(grep -c "HTTP/1.1 200" kept)" = 2 ]'
  exec 4>&-
  wait "$kept" || true # it does not like that the daemon closes first
  [ "$(grep -c 'HTTP/1.1 200' kept)" = 2 ]
  expiry=$(curl -sS -f --cacert new.pem "$URL/metrics" | awk '$1 == "quietgear_tls_certificate_expiry_seconds" {print $2}')
  [ "$(date -d "$(certtool -i --infile new.pem | sed -n 's/.*Not After: //p')" +%s)" = "$(printf %.0f "$expiry")" ]
  stop_daemon
  wait "$STREAM"
}

@test "a certificate that cannot be served leaves the one of before in use" {
  start_with old
  certificate other
  certificate late 'activation_date = "2020-01-01"
expiration_date = "2021-01-01"'
  cp other.key live.key
  reload_until 'live.pem and live.key are not a certificate and its key in PEM' 1
  serves old other
  : >live.pem
  reload_until 'live.pem: is empty or far too large' 1
  rm live.pem live.key
  reload_until 'live.key: No such file or directory' 1
  install_pair late
  reload_until 'live.pem has expired: it was valid until 202[01]-' 1
  [ "$(grep -c 'reload: the certificate of before stays in use' "$LOG")" = 4 ]
  serves old other
  install_pair other
  reload_until 'certificate: read again' 1
  serves other old
  stop_daemon
}

@test "no request is lost however often the certificate is read again" {
  start_with one
  certificate two
  cat one.pem two.pem >both.pem
  for client in 1 2 3; do
    until [ -e enough ]; do
      curl -sS -f -m "$PATIENCE" --cacert both.pem -o /dev/null "$URL/healthz" || echo "lost" >>lost
      echo "$client" >>asked
    done 3>&- &
    clients+=("$!")
  done
  for ((i = 0; i < 40; i++)); do
    ((i % 2)) && install_pair one || install_pair two
    count=$(grep -c 'certificate: read again' "$LOG" || true)
    ((i % 4)) && kill -HUP "$DAEMON" || reload_until 'certificate: read again' $((count + 1)) # also while a pair is written
    sleep 0.02
  done
  await eval '[ "$(wc -l <asked)" -ge 100 ]'
  : >enough
  wait "${clients[@]}"
  [ ! -e lost ]
  [ "$(grep -c 'certificate: read again' "$LOG")" -ge 10 ]
  stop_daemon
}

@test "a signal is obeyed whichever thread it meets" {
  start_daemon "$BATS_TEST_TMPDIR/state"
  for task in "/proc/$DAEMON/task/"*; do
    count=$(grep -c 'reload: there is no certificate' "$LOG" || true)
    kill -HUP "${task##*/}" || continue # a thread that has ended
    await is_said 'reload: there is no certificate' $((count + 1))
    [ "$(grep -c 'reload: there is no certificate' "$LOG")" = $((count + 1)) ]
  done
  kill -TERM "$DAEMON"
  wait "$DAEMON"
}

@test "without a certificate SIGHUP changes nothing" {
  start_daemon "$BATS_TEST_TMPDIR/state"
  reload_until 'reload: there is no certificate to read again' 1
  [ "$(status_of /healthz)" = 200 ]
  stop_daemon
}
