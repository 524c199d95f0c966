# Numbers in locales whose decimal point is none: one byte (German), two bytes (Pashto).

setup() {
    : "${QG_SOURCE:=$(cd "$BATS_TEST_DIRNAME/../.." && pwd)}" "${QG_BUILD:=$QG_SOURCE}"
}

# Makes the locale $1 and runs the writer's tests in it.
in_locale() {
    localedef -i "$1" -f UTF-8 "$BATS_TEST_TMPDIR/$1.UTF-8" || skip "the locale $1 cannot be made here"
    LOCPATH=$BATS_TEST_TMPDIR QG_LOCALE=$1.UTF-8 "$QG_BUILD/tests/schema/test_text"
}

@test "numbers have a point where people write a comma" {
    in_locale de_DE
}

@test "numbers have a point where people write a character of two bytes" {
    in_locale ps_AF
}
