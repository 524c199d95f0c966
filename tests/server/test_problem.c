/* The table of errors, and the documents made from it. */
#include "tests/server/support.h"

#include <stdlib.h>
#include <string.h>

#include "server/http/problem.h"

static void table_is_sound(void **state) {
    (void)state;
    for (int i = 0; i < QG_PROBLEM_COUNT; i++) {
        assert_in_range(qg_problem_status((enum qg_problem_code)i), 400, 599);
        for (int j = 0; j < i; j++)
            assert_string_not_equal(qg_problem_slug((enum qg_problem_code)i), qg_problem_slug((enum qg_problem_code)j));
    }
    assert_int_equal(qg_problem_status(QG_PROBLEM_TOO_LARGE), 413);
}

static void writes_a_problem(void **state) {
    (void)state;
    struct qg_text text = {0};
    qg_problem_write(&text, QG_PROBLEM_NOT_FOUND, "there is no \"such\" job", NULL);
    assert_string_equal(text.data, "{\"type\":\"urn:quietgear:problem:not-found\",\"title\":\"There is nothing here\","
                                   "\"status\":404,\"detail\":\"there is no \\\"such\\\" job\"}");
    qg_text_finish(&text);
}

static void lists_all_faults(void **state) {
    (void)state;
    struct qg_text text = {0};
    struct qg_faults *faults = calloc(1, sizeof *faults);
    faults->count = 2;
    faults->lost = 3;
    strcpy(faults->item[0].pointer, "/kind");
    strcpy(faults->item[0].detail, "missing");
    strcpy(faults->item[1].detail, "too long");
    qg_problem_write(&text, QG_PROBLEM_INVALID_DOCUMENT, NULL, faults);
    assert_string_equal(text.data, "{\"type\":\"urn:quietgear:problem:invalid-document\","
                                   "\"title\":\"The job document is not valid\",\"status\":422,"
                                   "\"errors\":[{\"pointer\":\"/kind\",\"detail\":\"missing\"},"
                                   "{\"pointer\":\"\",\"detail\":\"too long\"}],\"errors_not_listed\":3}");
    free(faults);
    qg_text_finish(&text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_is_sound),
        cmocka_unit_test(writes_a_problem),
        cmocka_unit_test(lists_all_faults),
    };
    return cmocka_run_group_tests_name("problem", tests, NULL, NULL);
}
