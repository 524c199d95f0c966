/* The memory that clients hold together. */
#include "tests/server/support.h"

#include "server/http/hold.h"

static void what_fits_is_taken(void **state) {
    (void)state;
    struct qg_hold hold = {.allowance = 800};
    assert_true(qg_hold_take(&hold, 700));
    assert_true(qg_hold_take(&hold, 100));
    assert_false(qg_hold_take(&hold, 1));
    qg_hold_give(&hold, 100);
    assert_false(qg_hold_take(&hold, 101));
    assert_true(qg_hold_take(&hold, 100));
    assert_int_equal(hold.held, 800);
}

static void what_is_larger_than_all_comes_alone(void **state) {
    (void)state;
    struct qg_hold hold = {.allowance = 800};
    assert_true(qg_hold_take(&hold, 100)); /* an eighth */
    assert_true(qg_hold_take(&hold, 5000));
    assert_false(qg_hold_take(&hold, 5000));
    assert_false(qg_hold_take(&hold, 1));
    qg_hold_give(&hold, 5000);
    assert_true(qg_hold_take(&hold, 1));
    assert_false(qg_hold_take(&hold, 5000));
}

static void small_things_are_taken_in_any_case(void **state) {
    (void)state;
    struct qg_hold hold = {.allowance = 800};
    assert_true(qg_hold_take(&hold, 800));
    qg_hold_force(&hold, 10);
    assert_int_equal(hold.held, 810);
    assert_false(qg_hold_take(&hold, 1));
    qg_hold_give(&hold, 810);
    assert_int_equal(hold.held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_fits_is_taken),
        cmocka_unit_test(what_is_larger_than_all_comes_alone),
        cmocka_unit_test(small_things_are_taken_in_any_case),
    };
    return cmocka_run_group_tests_name("hold", tests, NULL, NULL);
}
