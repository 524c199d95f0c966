/* The strict scan: what RFC 8259 allows passes, everything else is refused at the right place, and what passes the parser
 * behind it can read. The documents of tests/schema/bad go through it in test_bad.c. */
#include <cjson/cJSON.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/scan.h"
#include "tests/schema/support.h"

static struct qg_faults faults;

/* Scans a copy of exactly that length. */
static enum qg_document_status scan(const char *bytes, size_t length) {
    char *copy = malloc(length ? length : 1);
    assert_non_null(copy);
    memcpy(copy, bytes, length);
    faults = (struct qg_faults){0};
    const enum qg_document_status status = qg_scan(copy, length, &faults);
    free(copy);
    return status;
}

static void good_texts_pass(void **state) {
    static const char *const good[] = {"{}",
                                       "[]",
                                       " \t\r\n{ \"a\" : [ 1 , 2 ] } \n",
                                       "\"\"",
                                       "0",
                                       "-0",
                                       "-0.0e-0",
                                       "1E+5",
                                       "12.5e3",
                                       "true",
                                       "false",
                                       "null",
                                       "[true,false,null]",
                                       "\"\\\"\\\\\\/\\b\\f\\n\\r\\t\\u00e9\\uD83D\\uDE00\"",
                                       "\"\xc3\xa9\xf0\x9f\x98\x80\x7f\"",
                                       "{\"a\":1,\"A\":2,\"\":3}",
                                       "[{\"a\":1},{\"a\":1}]",
                                       "{\"a\":{\"a\":{\"a\":[]}}}",
                                       "1e-999",
                                       "\"\xf4\x8f\xbf\xbf\"",
                                       "123456789012345678901234567890123456789012345678901234567890123"};
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        if (scan(good[i], strlen(good[i])) != QG_DOCUMENT_OK)
            fail_msg("%s: %s", good[i], faults.item[0].detail);
}

static void bad_texts_are_refused_where_they_are_bad(void **state) {
    static const struct {
        const char *text, *pointer, *detail;
    } bad[] = {
        {"", "", "line 1, column 1: found the end of the text, allowed a JSON value"},
        {"{\n  \"a\": 01}", "/a",
         "line 2, column 9: found a digit behind a leading zero, allowed numbers without leading zeros"},
        {"[1,\"\xc3\xa9\" x]", "", "line 1, column 8: found \"x\", allowed a comma or a closing bracket"},
        {"[0, NaN]", "/1", "line 1, column 5: found \"NaN\", allowed a JSON value"},
        {"[-Infinity]", "/0", "line 1, column 3: found \"Infinity\", allowed a digit"},
        {"[1e400]", "/0", "line 1, column 7: found 1e400, allowed numbers between -1.797e308 and 1.797e308"},
        {"{\"a/b\":{\"c~d\":tru}}", "/a~1b/c~0d", "line 1, column 15: found \"tru\", allowed a JSON value"},
        {"{\"a\":1,\"\\u0061\":2}", "/a", "found the key more than once, allowed once"},
        {"\"\\ud83dx\"", "", "line 1, column 8: found half of a surrogate pair (\\ud83d), allowed whole pairs"},
        {"\"\\ud83d\\u0041\"", "", "line 1, column 14: found half of a surrogate pair (\\ud83d), allowed whole pairs"},
        {"\"\x1f\"", "", "line 1, column 2: found the control character 0x1f in a string, allowed only as an escape"},
        {"[1]]", "", "line 1, column 4: found \"]\", allowed nothing behind the end of the document"},
        {"{\"a\":1,}", "", "line 1, column 8: found \"}\", allowed a string in double quotes"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(scan(bad[i].text, strlen(bad[i].text)), QG_DOCUMENT_NOT_JSON);
        assert_int_equal(faults.count, 1);
        assert_string_equal(faults.item[0].pointer, bad[i].pointer);
        assert_string_equal(faults.item[0].detail, bad[i].detail);
    }
}

static void depth_is_limited(void **state) {
    char text[200];
    (void)state;
    for (int depth = QG_DOCUMENT_DEPTH_MAX - 1; depth <= QG_DOCUMENT_DEPTH_MAX + 1; depth++) {
        memset(text, '[', (size_t)depth);
        memset(text + depth, ']', (size_t)depth);
        const bool allowed = depth <= QG_DOCUMENT_DEPTH_MAX;
        assert_int_equal(scan(text, 2 * (size_t)depth), allowed ? QG_DOCUMENT_OK : QG_DOCUMENT_NOT_JSON);
    }
}

static void size_is_limited(void **state) {
    (void)state;
    char *text = malloc(QG_DOCUMENT_BYTES_MAX + 1);
    assert_non_null(text);
    memset(text, ' ', QG_DOCUMENT_BYTES_MAX + 1);
    memcpy(text, "{}", 2);
    assert_int_equal(scan(text, QG_DOCUMENT_BYTES_MAX), QG_DOCUMENT_OK);
    assert_int_equal(scan(text, QG_DOCUMENT_BYTES_MAX + 1), QG_DOCUMENT_NOT_JSON);
    assert_non_null(strstr(faults.item[0].detail, "found 1048577 bytes, allowed at most 1048576"));
    free(text);
}

/* As many keys as a document can hold, most of them twice: counted, not kept, and in no time. */
static void many_duplicates_are_counted(void **state) {
    struct qg_text text = {0};
    (void)state;
    qg_json_open(&text, '{');
    for (int i = 0; i < 80000; i++) {
        char key[16];
        snprintf(key, sizeof key, "%x", (unsigned)i % 40000);
        qg_json_name(&text, key);
        qg_json_integer(&text, 1);
    }
    qg_json_close(&text, '}');
    assert_int_equal(scan(text.data, text.length), QG_DOCUMENT_NOT_JSON);
    assert_int_equal(faults.count, QG_FAULTS_ROOM);
    assert_int_equal(faults.lost, 40000 - QG_FAULTS_ROOM);
    qg_text_finish(&text);
}

/* A key of nearly the whole document: the pointer leaves it out instead of growing. */
static void long_keys_do_no_harm(void **state) {
    (void)state;
    char *text = malloc(100000);
    assert_non_null(text);
    memset(text, 'k', 100000);
    memcpy(text, "{\"", 2);
    memcpy(text + 100000 - 5, "\":x}", 5);
    assert_int_equal(scan(text, 100000 - 1), QG_DOCUMENT_NOT_JSON);
    assert_string_equal(faults.item[0].pointer, "");
    free(text);
}

static void every_prefix_is_refused(void **state) {
    size_t length;
    (void)state;
    char *text = read_source_file("schema/examples/case_S_optimize.json", &length);
    while (length > 0 && text[length - 1] != '}')
        length--;
    assert_int_equal(scan(text, length), QG_DOCUMENT_OK);
    for (size_t n = 0; n < length; n++)
        assert_int_equal(scan(text, n), QG_DOCUMENT_NOT_JSON);
    free(text);
}

/* Random damage: no crash, always an answer, and the parser takes what the scan lets through. */
static void damaged_texts_get_an_answer(void **state) {
    static const char bytes[] = "{}[]\",:0123456789.eE+-\\u/tfn \n\x01\x80\xc3\xed\xf4\xff";
    size_t length, passed = 0;
    uint64_t seed = 3;
    (void)state;
    char *text = read_source_file("schema/examples/case_S_standard.json", &length);
    char *damaged = malloc(length);
    assert_non_null(damaged);
    for (int round = 0; round < 20000; round++) {
        memcpy(damaged, text, length);
        for (uint64_t n = next_random(&seed) % 3 + 1; n > 0; n--)
            damaged[next_random(&seed) % length] = bytes[next_random(&seed) % (sizeof bytes - 1)];
        const enum qg_document_status status = scan(damaged, length);
        assert_int_equal(status == QG_DOCUMENT_OK, faults.count == 0);
        if (status != QG_DOCUMENT_OK)
            continue;
        cJSON *root = cJSON_ParseWithLengthOpts(damaged, length, NULL, false);
        assert_non_null(root);
        cJSON_Delete(root);
        passed++;
    }
    assert_in_range(passed, 1000, 19000);
    free(damaged);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_texts_pass),
        cmocka_unit_test(bad_texts_are_refused_where_they_are_bad),
        cmocka_unit_test(depth_is_limited),
        cmocka_unit_test(size_is_limited),
        cmocka_unit_test(many_duplicates_are_counted),
        cmocka_unit_test(long_keys_do_no_harm),
        cmocka_unit_test(every_prefix_is_refused),
        cmocka_unit_test(damaged_texts_get_an_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
