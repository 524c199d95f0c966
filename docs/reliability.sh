#!/bin/sh
# Writes docs/reliability.md from what the campaigns left in a build tree:
#   docs/reliability.sh BUILD           (make reliability; needs jq)
#
# A campaign leaves BUILD/reliability/SECTION.jsonl, SECTION being kill, faults, fuzzing, load, memory or soak. Each line is an object:
#   {"text": "..."}   a paragraph
#   {"row": {...}}    a row of a table, whose heads are the keys; rows with the same keys in sequence are one table
# Sections whose file is not there are kept as they stand in docs/reliability.md.
set -eu
cd "$(dirname "$0")/.."
build=$1
page=docs/reliability.md
new=$(mktemp)
trap 'rm -f "$new"' EXIT

# The paragraphs and tables of a section's file.
render() {
    jq -rs '
        def cells: map(tostring | gsub("\\|"; "\\|")) | "| " + join(" | ") + " |";
        reduce .[] as $line ({out: [], heads: null};
            if $line.text then .out += ["", $line.text] | .heads = null
            else ($line.row | keys_unsorted) as $heads
                | if .heads == $heads then . else .out += ["", ($heads | cells), ($heads | map("---") | cells)] | .heads = $heads end
                | .out += [[$line.row[]] | cells]
            end) | .out[]' "$1"
}

# What stands below a heading of the page now.
keep() {
    [ -f "$page" ] || return 0
    awk -v heading="## $1" '/^## / {on = $0 == heading; next} on' "$page" | sed -e :a -e '/^\n*$/{$d;N;ba' -e '}'
}

section() { # section NAME HEADING
    printf '\n## %s\n' "$2"
    if [ -f "$build/reliability/$1.jsonl" ]; then
        render "$build/reliability/$1.jsonl"
    else
        keep "$2"
    fi
}

{
    cat <<'PAGE'
# What the daemon was put through

Written by `make reliability` (`docs/reliability.sh`) from the figures that the campaigns leave in the build tree. Each campaign
is one command, and has a short form in `make check`.
PAGE
    section kill 'kill -9'
    section faults 'Faults'
    section fuzzing 'Fuzzing'
    printf '\n## HTTP hostility\n\nSee [what hostile clients get](http_hostility.md).\n'
    section load 'Load'
    section memory 'Memory'
    section soak 'Soak'
} >"$new"
cat "$new" >"$page"
