/* The low-discrepancy sequence: even in every coordinate and in the whole, other for other seeds. */
#include "tests/core/cases.h"

#include "core/sequence.h"

enum { POINTS = 256 };

/* Largest distance of n values' distribution from the uniform one (Kolmogorov's; in one dimension the star discrepancy). */
static double discrepancy(double *values, size_t n) {
    double largest = 0;
    for (size_t i = 1; i < n; i++)
        for (size_t k = i; k > 0 && values[k] < values[k - 1]; k--) {
            double t = values[k];
            values[k] = values[k - 1];
            values[k - 1] = t;
        }
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, fmax((double)(i + 1) / (double)n - values[i], values[i] - (double)i / (double)n));
    return largest;
}

/* Independent points have a discrepancy of about 0.87 / sqrt(n), 0.054 here; these stay below half of that. */
static void every_coordinate_is_even(void **state) {
    (void)state;
    for (size_t d = 1; d <= QG_SEQUENCE_DIMENSIONS_MAX; d++)
        for (uint64_t seed = 0; seed < 3; seed++) {
            const struct qg_sequence sequence = qg_sequence_of(seed, d);
            double u[POINTS][QG_SEQUENCE_DIMENSIONS_MAX], column[POINTS];
            for (size_t i = 0; i < POINTS; i++)
                qg_sequence_point(&sequence, i, u[i]);
            for (size_t k = 0; k < d; k++) {
                for (size_t i = 0; i < POINTS; i++) {
                    assert_true(u[i][k] >= 0 && u[i][k] < 1);
                    column[i] = u[i][k];
                }
                assert_true(discrepancy(column, POINTS) < 0.027);
            }
        }
}

/* Square of the centred L2 discrepancy of n points (Hickernell 1998, Math. Comp. 67, equation 1.4 there). */
static double centred_discrepancy(double (*u)[QG_SEQUENCE_DIMENSIONS_MAX], size_t n, size_t d) {
    double once = 0, twice = 0;
    for (size_t i = 0; i < n; i++) {
        double product = 1;
        for (size_t k = 0; k < d; k++) {
            double z = fabs(u[i][k] - 0.5);
            product *= 1 + z / 2 - z * z / 2;
        }
        once += product;
        for (size_t j = 0; j < n; j++) {
            product = 1;
            for (size_t k = 0; k < d; k++)
                product *= 1 + fabs(u[i][k] - 0.5) / 2 + fabs(u[j][k] - 0.5) / 2 - fabs(u[i][k] - u[j][k]) / 2;
            twice += product;
        }
    }
    return pow(13.0 / 12, (double)d) - 2 * once / (double)n + twice / (double)(n * n);
}

/* Independent points have ((5/4)^d - (13/12)^d) / n on average. */
static void the_cube_is_filled_more_evenly_than_by_chance(void **state) {
    (void)state;
    for (size_t d = 1; d <= 8; d++) {
        double chance = (pow(1.25, (double)d) - pow(13.0 / 12, (double)d)) / POINTS;
        for (uint64_t seed = 0; seed < 3; seed++) {
            const struct qg_sequence sequence = qg_sequence_of(seed, d);
            double u[POINTS][QG_SEQUENCE_DIMENSIONS_MAX];
            for (size_t i = 0; i < POINTS; i++)
                qg_sequence_point(&sequence, i, u[i]);
            assert_true(centred_discrepancy(u, POINTS, d) < (d < 6 ? 0.25 : 0.5) * chance);
        }
    }
}

static void seeds_shift_and_nothing_else(void **state) {
    (void)state;
    const struct qg_sequence a = qg_sequence_of(1, 4), b = qg_sequence_of(2, 4), again = qg_sequence_of(1, 4);
    double x[4], y[4], z[4];
    assert_memory_equal(a.step, b.step, 4 * sizeof(double));
    assert_memory_equal(a.shift, again.shift, 4 * sizeof(double));
    qg_sequence_point(&a, 77, x);
    qg_sequence_point(&b, 77, y);
    qg_sequence_point(&again, 77, z);
    assert_memory_equal(x, z, sizeof x);
    for (size_t k = 0; k < 4; k++)
        assert_true(x[k] != y[k]);
    assert_true(a.step[0] == sqrt(2) - 1 && a.step[3] == sqrt(7) - 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_coordinate_is_even),
        cmocka_unit_test(the_cube_is_filled_more_evenly_than_by_chance),
        cmocka_unit_test(seeds_shift_and_nothing_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
