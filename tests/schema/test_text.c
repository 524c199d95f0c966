/* The JSON writer: numbers come back to the last bit, commas and escapes are right. */
#include <float.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/text.h"
#include "tests/schema/support.h"

static void assert_prints(double value, const char *expected) {
    char out[QG_NUMBER_ROOM];
    assert_int_equal(qg_number_print(out, value), strlen(expected));
    assert_string_equal(out, expected);
}

static void known_numbers_print_as_people_write_them(void **state) {
    (void)state;
    assert_prints(0, "0");
    assert_prints(-0.0, "-0");
    assert_prints(7850, "7850");
    assert_prints(0.1, "0.1");
    assert_prints(44.54, "44.54");
    assert_prints(0.1 + 0.2, "0.30000000000000004");
    assert_prints(1e22, "1e+22");
    assert_prints(9007199254740991, "9007199254740991");
    assert_prints(5e-324, "4.94065645841247e-324");
    assert_prints(DBL_MAX, "1.7976931348623157e+308");
    assert_prints(-DBL_MAX, "-1.7976931348623157e+308");
    assert_prints(NAN, "null");
    assert_prints(INFINITY, "null");
    assert_prints(-INFINITY, "null");
}

/* The text reads back to the same bits, and no shorter number of digits from 15 on does. */
static void assert_round_trip(double value) {
    char out[QG_NUMBER_ROOM], shorter[400];
    const int length = qg_number_print(out, value);
    const double back = strtod(out, NULL);
    if (memcmp(&back, &value, sizeof value) != 0 || length >= QG_NUMBER_ROOM)
        fail_msg("%.17g printed as %s", value, out);
    int digits = 0;
    for (const char *at = out; *at && *at != 'e'; at++)
        digits += *at >= '0' && *at <= '9' && (digits > 0 || *at != '0');
    if (digits > 15) {
        snprintf(shorter, sizeof shorter, "%.*g", digits - 1, value);
        assert_true(strtod(shorter, NULL) != value);
    }
}

static void random_bits_survive(void **state) {
    uint64_t seed = 1;
    (void)state;
    for (int i = 0; i < 1000000; i++) {
        const uint64_t bits = next_random(&seed);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value))
            assert_round_trip(value);
    }
}

/* Numbers as gears have them: uniform in [0, 1000), and decimals of few digits, which must print as they were written. */
static void everyday_numbers_survive(void **state) {
    uint64_t seed = 2;
    (void)state;
    for (int i = 0; i < 200000; i++) {
        assert_round_trip((double)(next_random(&seed) >> 11) * 0x1p-53 * 1000);
        char written[40], out[QG_NUMBER_ROOM];
        snprintf(written, sizeof written, "%d.%d", (int)(next_random(&seed) % 1000), (int)(next_random(&seed) % 9) + 1);
        qg_number_print(out, strtod(written, NULL));
        assert_string_equal(out, written);
    }
}

/* In the locale that $QG_LOCALE names, "C" without it; locale.bats names one with a decimal comma. */
static void numbers_have_a_point_in_any_locale(void **state) {
    const char *name = getenv("QG_LOCALE");
    static struct qg_job job;
    static struct qg_faults faults;
    (void)state;
    assert_non_null(setlocale(LC_NUMERIC, name ? name : "C"));
    if (name)
        assert_string_not_equal(localeconv()->decimal_point, ".");
    assert_prints(0.5, "0.5");
    assert_prints(-1.25e-300, "-1.25e-300");
    assert_prints(0.1 + 0.2, "0.30000000000000004");
    assert_prints(3, "3");
    assert_int_equal(read_exact(least_evaluate, strlen(least_evaluate), &job, &faults), QG_DOCUMENT_OK);
    assert_true(job.study.pair.gears[0].outside_radius == 46.55);
    setlocale(LC_NUMERIC, "C");
}

static void commas_and_escapes(void **state) {
    struct qg_text text = {0};
    (void)state;
    qg_json_open(&text, '{');
    qg_json_name(&text, "empty");
    qg_json_open(&text, '[');
    qg_json_close(&text, ']');
    qg_json_name(&text, "a\"b\\c");
    qg_json_string(&text, "line\nbell\a \x7f \xc3\xa9 \xf0\x9f\x98\x80 \"q\" \\");
    qg_json_name(&text, "list");
    qg_json_open(&text, '[');
    qg_json_number(&text, 1.5);
    qg_json_integer(&text, INT64_MIN);
    qg_json_bool(&text, true);
    qg_json_bool(&text, false);
    qg_json_null(&text);
    qg_json_raw(&text, "{}");
    qg_json_open(&text, '{');
    qg_json_close(&text, '}');
    qg_json_close(&text, ']');
    qg_json_close(&text, '}');
    assert_false(text.failed);
    assert_string_equal(text.data,
                        "{\"empty\":[],\"a\\\"b\\\\c\":\"line\\u000abell\\u0007 \x7f \xc3\xa9 \xf0\x9f\x98\x80 "
                        "\\\"q\\\" \\\\\",\"list\":[1.5,-9223372036854775808,true,false,null,{},{}]}");
    assert_int_equal(text.length, strlen(text.data));
    qg_text_finish(&text);
    assert_null(text.data);
}

static void text_grows(void **state) {
    struct qg_text text = {0};
    (void)state;
    for (int i = 0; i < 10000; i++)
        qg_text_format(&text, "%06d;", i);
    assert_int_equal(text.length, 70000);
    assert_memory_equal(text.data + 7 * 9999, "009999;", 8);
    qg_text_finish(&text);
}

/* After a failed allocation nothing is written any more, and nothing breaks. */
static void a_failed_text_stays_failed(void **state) {
    struct qg_text text = {0};
    (void)state;
    qg_text_add(&text, "x", SIZE_MAX / 2);
    assert_true(text.failed);
    qg_json_open(&text, '{');
    qg_json_string(&text, "more");
    assert_int_equal(text.length, 0);
    qg_text_finish(&text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_numbers_print_as_people_write_them),
        cmocka_unit_test(random_bits_survive),
        cmocka_unit_test(everyday_numbers_survive),
        cmocka_unit_test(numbers_have_a_point_in_any_locale),
        cmocka_unit_test(commas_and_escapes),
        cmocka_unit_test(text_grows),
        cmocka_unit_test(a_failed_text_stays_failed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
