/* The Pareto front against its definition, and its hypervolume against closed forms and counted points. */
#include "tests/core/cases.h"

#include "core/front.h"

static void add(struct qg_front *front, size_t evaluation, double a, double b, double c) {
    const struct qg_front_member member = {.evaluation = evaluation, .value = {a, b, c}};
    assert_int_equal(qg_front_add(front, &member, NULL), QG_OK);
}

static bool dominates(const double *a, const double *b, size_t n) {
    bool better = false;
    for (size_t k = 0; k < n; k++) {
        if (a[k] > b[k])
            return false;
        better = better || a[k] < b[k];
    }
    return better;
}

/* 400 designs on a coarse raster, so that there are many equals: the front is what the definition says. */
static void the_front_is_what_no_other_design_dominates(void **state) {
    (void)state;
    enum { N = 400 };
    struct dice dice = {9};
    for (size_t objectives = 1; objectives <= QG_FRONT_OBJECTIVES_MAX; objectives++) {
        struct qg_front front = {.objectives = objectives};
        double value[N][QG_FRONT_OBJECTIVES_MAX];
        size_t expected = 0;
        for (size_t i = 0; i < N; i++) {
            for (size_t k = 0; k < QG_FRONT_OBJECTIVES_MAX; k++)
                value[i][k] = floor(dice_between(&dice, 0, 20));
            add(&front, i, value[i][0], value[i][1], value[i][2]);
        }
        for (size_t i = 0; i < N; i++) {
            bool beaten = false, on_front = false;
            for (size_t j = 0; j < N; j++)
                beaten = beaten || dominates(value[j], value[i], objectives) ||
                         (j < i && memcmp(value[j], value[i], objectives * sizeof(double)) == 0);
            for (size_t m = 0; m < front.count; m++)
                on_front = on_front || front.member[m].evaluation == i;
            assert_true(on_front != beaten);
            expected += !beaten;
        }
        assert_int_equal(front.count, expected);
        for (size_t m = 1; m < front.count; m++)
            assert_true(front.member[m - 1].value[0] <= front.member[m].value[0]);
        qg_front_finish(&front);
        assert_int_equal(front.count, 0);
    }
}

static void what_is_not_a_number_stays_out(void **state) {
    (void)state;
    struct qg_front front = {.objectives = 2};
    bool joined = true;
    const struct qg_front_member bad = {.value = {0, NAN}};
    assert_int_equal(qg_front_add(&front, &bad, &joined), QG_OK);
    assert_false(joined);
    assert_int_equal(front.count, 0);
    add(&front, 1, 1, 1, NAN); /* beyond the objectives it does not matter */
    assert_int_equal(front.count, 1);
    qg_front_finish(&front);
}

static void hypervolumes_of_boxes(void **state) {
    (void)state;
    static const double unit[] = {1, 1, 1}, wide[] = {2, 4, 1};
    struct qg_front front = {.objectives = 2};
    assert_true(qg_front_hypervolume(&front, unit) == 0);
    add(&front, 0, 0.5, 0.5, 0);
    assert_true(qg_front_hypervolume(&front, unit) == 0.25);
    add(&front, 1, 0.25, 0.75, 0); /* a quarter by a quarter more */
    assert_true(qg_front_hypervolume(&front, unit) == 0.25 + 0.0625);
    add(&front, 2, 0.1, 1.5, 0); /* beyond the corner: nothing */
    assert_true(qg_front_hypervolume(&front, unit) == 0.3125);
    qg_front_finish(&front);
    add(&front, 0, 1, 1, 0); /* half of one side, three quarters of the other */
    assert_true(qg_front_hypervolume(&front, wide) == 0.375);
    qg_front_finish(&front);
    front.objectives = 3;
    add(&front, 0, 0.5, 0.5, 0.5);
    assert_true(qg_front_hypervolume(&front, unit) == 0.125);
    add(&front, 1, 0.25, 0.75, 0.5); /* 1/4 * 1/4 * 1/2 more */
    assert_true(qg_front_hypervolume(&front, unit) == 0.125 + 0.03125);
    add(&front, 2, 0.75, 0.75, 0); /* 1/4 * 1/4 * 1/2 below both */
    assert_true(qg_front_hypervolume(&front, unit) == 0.15625 + 0.03125);
    qg_front_finish(&front);
    front.objectives = 1;
    add(&front, 0, 0.25, 0, 0);
    assert_true(qg_front_hypervolume(&front, unit) == 0.75);
    qg_front_finish(&front);
}

/* Random fronts of three objectives, against the share of 80^3 raster points that they dominate. */
static void hypervolumes_agree_with_counted_points(void **state) {
    (void)state;
    enum { RASTER = 80 };
    static const double unit[] = {1, 1, 1};
    struct dice dice = {31};
    for (int turn = 0; turn < 5; turn++) {
        struct qg_front front = {.objectives = 3};
        size_t count = 0;
        for (size_t i = 0; i < 60; i++)
            add(&front, i, dice_between(&dice, 0, 1), dice_between(&dice, 0, 1), dice_between(&dice, 0, 1));
        for (size_t p = 0; p < RASTER * RASTER * RASTER; p++) {
            const double x[] = {((double)(p % RASTER) + 0.5) / RASTER, ((double)(p / RASTER % RASTER) + 0.5) / RASTER,
                                ((double)(p / RASTER / RASTER) + 0.5) / RASTER};
            bool dominated = false;
            for (size_t m = 0; m < front.count && !dominated; m++)
                dominated = dominates(front.member[m].value, x, 3);
            count += dominated;
        }
        assert_true(front.count > 5);
        assert_true(fabs(qg_front_hypervolume(&front, unit) - (double)count / (RASTER * RASTER * RASTER)) < 0.008);
        qg_front_finish(&front);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_front_is_what_no_other_design_dominates),
        cmocka_unit_test(what_is_not_a_number_stays_out),
        cmocka_unit_test(hypervolumes_of_boxes),
        cmocka_unit_test(hypervolumes_agree_with_counted_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
