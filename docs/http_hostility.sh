#!/bin/sh
# Writes docs/http_hostility.md: what hostile clients sent to a quietgeard of its own and what came back, with 10 000
# connections at a time.
#   docs/http_hostility.sh          (needs quietgeard in the PATH, and node; takes two minutes)
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
daemon=
trap '[ -z "$daemon" ] || kill "$daemon"; rm -rf "$work"' EXIT
ulimit -n "$(ulimit -H -n)"

quietgeard --config /dev/null --listen 127.0.0.1:0 --port-file "$work/port" --state-dir "$work/state" --web-dir web \
    --schema-dir schema 2>"$work/log" &
daemon=$!
for _ in $(seq 100); do [ -s "$work/port" ] && break; sleep 0.1; done

status=0
node tests/service/hostility.mjs "http://127.0.0.1:$(cat "$work/port")" --connections 10000 >"$work/table" || status=$?
cat >"$work/page" <<'PAGE'
# What hostile clients get

Written by `make hostility` (`docs/http_hostility.sh`), which sends raw bytes to a daemon and asks `/healthz` after each row;
`tests/service/hostility.bats` does the same with fewer connections in every test run, and fails when something else comes back.

"In libmicrohttpd's words": refused by the library before our code sees the request, in HTML instead of a problem document;
"2 times": it then sends its header twice, and closes. A NUL in a header field is cut off by the library, unseen by us.

Why they stay: none of the options of libmicrohttpd 0.9.75 sets or intercepts those answers. Its log callback hears of each just
before it is sent, but not on which connection; our callbacks are called after the request line (with the header perhaps still
under way) and after the whole header, and the refusals happen in between, or in the middle of a chunked body. What could put
a problem document there is a second HTTP parser before the library's, and two parsers that disagree are what smuggling lives
on. Their status codes are right, and the connection is closed after each.

PAGE
cat "$work/table" >>"$work/page"
mv "$work/page" docs/http_hostility.md
exit "$status"
