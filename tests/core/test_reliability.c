/* Reliability: errors within their ranges and common to all designs, and shares that a known function confirms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/reliability.h"

enum { TRIALS = 4000 };

static const struct qg_reliability asked = {
    .samples = TRIALS, .radius_range = 0.2, .amplitude_range = 0.012, .limit_f_dte = 0.5, .seed = 7};

static struct qg_relief two_tips(void) {
    struct qg_relief relief = {0};
    relief.gears[QG_PINION].tip = (struct qg_ramp){true, 44.54, 0.016};
    relief.gears[QG_GEAR].tip = (struct qg_ramp){true, 67.64, 0.018};
    return relief;
}

static const struct qg_gear_pair pair = {
    .rack = {3, 0.3490658503988659},
    .center_distance = 111,
    .gears = {{28, 1.927, 46.55, 39.55, 0.9, 40, 27, 0}, {43, 2.748, 69.55, 63.1, 0.9, 40, 22.5, 0}},
    .material = {206000, 0.3, 7850e-9},
    .damping_ratio = 0.01,
    .nominal_torque = 470e3};

static void errors_fill_their_range(void **state) {
    (void)state;
    double sum = 0, squares = 0, most = 0;
    for (size_t i = 0; i < TRIALS; i++) {
        double e = qg_reliability_error(&asked, QG_GEAR_TIP_AMPLITUDE, i);
        sum += e;
        squares += e * e;
        most = fmax(most, fabs(e));
    }
    double sigma = sqrt(squares / TRIALS);
    assert_true(most <= 0.006 && most > 0.005);
    assert_true(fabs(sum / TRIALS) < 4 * 0.002 / sqrt(TRIALS));
    /* a Gaussian cut at three sigma has 0.9867 of its standard deviation */
    assert_true(fabs(sigma / (0.002 * 0.98658) - 1) < 0.04);
}

static void trials_disturb_present_ramps_only(void **state) {
    (void)state;
    struct qg_pair_geometry geometry;
    assert_int_equal(qg_pair_derive(&pair, &geometry, NULL), QG_OK);
    struct qg_relief design = two_tips(), other = design;
    other.gears[QG_PINION].tip.amplitude = 0.03;
    struct qg_relief a = qg_reliability_trial(&asked, &pair, &geometry, &design, 5);
    struct qg_relief b = qg_reliability_trial(&asked, &pair, &geometry, &other, 5);
    double error = qg_reliability_error(&asked, QG_PINION_TIP_AMPLITUDE, 5);
    assert_true(fabs(a.gears[QG_PINION].tip.amplitude - 0.016 - error) < 1e-15);
    assert_true(fabs(b.gears[QG_PINION].tip.amplitude - 0.03 - error) < 1e-15);
    assert_true(a.gears[QG_GEAR].tip.radius == b.gears[QG_GEAR].tip.radius);
    assert_false(a.gears[QG_PINION].root.present);
    assert_true(a.gears[QG_PINION].root.radius == 0);
}

static void trials_stay_on_the_tooth(void **state) {
    (void)state;
    struct qg_pair_geometry geometry;
    assert_int_equal(qg_pair_derive(&pair, &geometry, NULL), QG_OK);
    struct qg_relief design = two_tips();
    design.gears[QG_PINION].tip = (struct qg_ramp){true, 46.55, 0};
    for (size_t i = 0; i < 200; i++) {
        struct qg_relief trial = qg_reliability_trial(&asked, &pair, &geometry, &design, i);
        assert_true(trial.gears[QG_PINION].tip.radius <= 46.55);
        assert_true(trial.gears[QG_PINION].tip.amplitude >= 0);
    }
}

/* F = 1 + 3 u_a + 2 (u_b^2 - E u^2) + u_a u_c: variances 9, 4 var(u^2) and 1 (all but for the cut at three sigma). */
static void shares_of_a_known_function(void **state) {
    (void)state;
    struct qg_relief design = two_tips();
    double *f = malloc(TRIALS * sizeof *f);
    assert_non_null(f);
    for (size_t i = 0; i < TRIALS; i++) {
        double a = qg_reliability_error(&asked, QG_PINION_TIP_START_RADIUS, i) / (0.2 / 6);
        double b = qg_reliability_error(&asked, QG_PINION_TIP_AMPLITUDE, i) / (0.012 / 6);
        double c = qg_reliability_error(&asked, QG_GEAR_TIP_AMPLITUDE, i) / (0.012 / 6);
        f[i] = 1 + 3 * a + 2 * b * b + a * c;
    }
    struct qg_reliability_result result;
    qg_reliability_summarize(&asked, &design, f, &result);
    free(f);
    double square = 0.97334, square_variance = 1.73266; /* E u^2 and var u^2 of the Gaussian cut at 3 */
    double parts[3] = {9 * square, 4 * square_variance, square * square}, whole = parts[0] + parts[1] + parts[2];
    assert_true(fabs(result.share[QG_PINION_TIP_START_RADIUS] - parts[0] / whole) < 0.03);
    assert_true(fabs(result.share[QG_PINION_TIP_AMPLITUDE] - parts[1] / whole) < 0.03);
    assert_true(result.share[QG_GEAR_TIP_AMPLITUDE] < 0.01);
    assert_true(result.share[QG_GEAR_TIP_START_RADIUS] < 0.01);
    assert_true(fabs(result.unexplained - parts[2] / whole) < 0.03);
    assert_false(result.has_share[QG_PINION_ROOT_AMPLITUDE]);
}

static void summary_counts_and_quantiles(void **state) {
    (void)state;
    struct qg_reliability few = asked;
    few.samples = 101;
    double f[101];
    for (size_t i = 0; i < 101; i++)
        f[i] = (double)((i * 37) % 101) / 100; /* 0, 0.01 .. 1 in another order */
    struct qg_relief design = two_tips();
    struct qg_reliability_result result;
    qg_reliability_summarize(&few, &design, f, &result);
    assert_int_equal(result.failures, 50);
    assert_true(fabs(result.mean_f_dte - 0.5) < 1e-12);
    assert_true(fabs(result.standard_deviation - sqrt(101 * 102 / 12.0) / 100) < 1e-12);
    assert_true(result.min_f_dte == 0 && result.max_f_dte == 1);
    for (int k = 0; k < QG_QUANTILES; k++)
        assert_true(fabs(result.quantile[k] - qg_quantile_levels[k]) < 1e-12);
    size_t sum = 0;
    for (int k = 0; k < QG_HISTOGRAM_BINS; k++)
        sum += result.histogram[k];
    assert_int_equal(sum, 101);
    assert_true(result.confidence_low < 50.0 / 101 && result.confidence_high > 50.0 / 101);
}

static void too_few_trials_give_no_shares(void **state) {
    (void)state;
    struct qg_reliability few = asked;
    few.samples = 10;
    double f[10] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    struct qg_relief design = two_tips();
    struct qg_reliability_result result;
    qg_reliability_summarize(&few, &design, f, &result);
    for (int k = 0; k < QG_PARAMETER_COUNT; k++)
        assert_false(result.has_share[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_fill_their_range),      cmocka_unit_test(trials_disturb_present_ramps_only),
        cmocka_unit_test(trials_stay_on_the_tooth),     cmocka_unit_test(shares_of_a_known_function),
        cmocka_unit_test(summary_counts_and_quantiles), cmocka_unit_test(too_few_trials_give_no_shares),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
