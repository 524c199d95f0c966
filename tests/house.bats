#!/usr/bin/env bats
# The walls that ARCHITECTURE.md draws: who may include whom.

# Prints the #includes of ROOM's files that name another room than those listed.
strays() { # strays ROOM ALLOWED-ROOM...
    local room=$1 allowed
    shift
    allowed=$(printf '|%s' "$room" "$@")
    grep -rnE '^#include "(core|schema|server|cli|web|tests)/' "$QG_SOURCE/$room" --include='*.[ch]' |
        grep -vE "#include \"(${allowed#|})/[a-z_0-9]+\.h\"" || true
}

no_strays() {
    run strays "$@"
    [ "$status" -eq 0 ]
    [ -z "$output" ] || { echo "$output"; false; }
}

@test "core knows nobody, schema knows core" {
    [ -f "$QG_SOURCE/core/pair.h" ]
    no_strays core
    no_strays schema core
    no_strays cli core schema
}

@test "within the server arrows point down: calls, http, work, store, base" {
    [ -f "$QG_SOURCE/server/base/log.h" ]
    no_strays server/base core schema
    no_strays server/store core schema server/base
    no_strays server/work core schema server/base server/store
    no_strays server/http core schema server/base server/store server/work
    no_strays server/calls core schema server/base server/store server/work server/http
}

@test "two headers know libmicrohttpd, two know GnuTLS, the store alone SQLite" {
    cd "$QG_SOURCE"
    [ "$(grep -rl '<microhttpd.h>' server | sort | xargs)" = "server/http/internal.h server/http/stream.h" ]
    [ "$(grep -rl '<gnutls/' server | sort | xargs)" = "server/base/secret.c server/http/tls.c" ]
    [ "$(grep -rl '<sqlite3.h>' server core schema cli | grep -v '^server/store/')" = "" ]
}

@test "a release carries the script that quickstart and run-tests begin with" {
    for script in quickstart run-tests; do
        grep -q '^build-aux/install-packages ' "$QG_SOURCE/$script"
    done
    [ -x "$QG_SOURCE/build-aux/install-packages" ]
}
