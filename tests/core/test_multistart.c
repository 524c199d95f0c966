/* Multi-start simplex on functions with known minima: budgets to the letter, batches, restarts, several objectives. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/front.h"
#include "core/multistart.h"

enum { LOG_ROOM = 20000 };

/* An objective that is watched. */
struct watched {
    const struct qg_box *box;
    void (*f)(const struct watched *self, const double *x, double *f);
    size_t objectives;
    size_t points, calls, outside, largest_batch;
    size_t fail_at; /* this call answers QG_CANCELLED; 0: none */
    double best[QG_SEARCH_OBJECTIVES_MAX];
    double log[LOG_ROOM];
    struct qg_front front;
};

static enum qg_status values(void *self, size_t n, const double *x, double *f) {
    struct watched *w = self;
    size_t d = w->box->dimensions;
    if (++w->calls == w->fail_at)
        return QG_CANCELLED;
    w->largest_batch = n > w->largest_batch ? n : w->largest_batch;
    for (size_t i = 0; i < n; i++) {
        double *value = f + i * w->objectives;
        struct qg_front_member member = {.evaluation = w->points};
        for (size_t k = 0; k < d; k++)
            w->outside += !(x[i * d + k] >= w->box->lower[k] && x[i * d + k] <= w->box->upper[k]);
        w->f(w, x + i * d, value);
        for (size_t k = 0; k < w->objectives; k++) {
            w->best[k] = fmin(w->best[k], value[k]);
            member.value[k] = value[k];
        }
        if (w->points < LOG_ROOM)
            w->log[w->points++] = value[0];
        assert_int_equal(qg_front_add(&w->front, &member, NULL), QG_OK);
    }
    return QG_OK;
}

static double share(const struct watched *w, const double *x, size_t k) {
    return (x[k] - w->box->lower[k]) / (w->box->upper[k] - w->box->lower[k]);
}

static void sphere(const struct watched *w, const double *x, double *f) {
    *f = 0;
    for (size_t k = 0; k < w->box->dimensions; k++)
        *f += pow(share(w, x, k) - 0.3, 2);
}

static void rosenbrock(const struct watched *w, const double *x, double *f) {
    *f = 0;
    for (size_t k = 0; k + 1 < w->box->dimensions; k++)
        *f += 100 * pow(x[k + 1] - x[k] * x[k], 2) + pow(1 - x[k], 2);
}

/* Rastrigin over the box as -2 .. 3, some 5 valleys a side; smallest at 0. */
static void rastrigin(const struct watched *w, const double *x, double *f) {
    *f = 0;
    for (size_t k = 0; k < w->box->dimensions; k++) {
        double t = 5 * share(w, x, k) - 2;
        *f += t * t + 10 * (1 - cos(2 * M_PI * t));
    }
}

/* Schaffer's pair in several dimensions: the front is the straight line between two points, sqrt f1 + sqrt f2 = 1. */
static void schaffer(const struct watched *w, const double *x, double *f) {
    f[0] = f[1] = 0;
    for (size_t k = 0; k < w->box->dimensions; k++) {
        f[0] += pow(share(w, x, k) - 0.2, 2);
        f[1] += pow(share(w, x, k) - 0.8, 2);
    }
    f[0] /= 0.36 * (double)w->box->dimensions;
    f[1] /= 0.36 * (double)w->box->dimensions;
}

/* Fonseca and Fleming: a front that weighted sums cannot find but at its ends, because it is not convex. */
static void fonseca(const struct watched *w, const double *x, double *f) {
    double a = 0, b = 0, d = (double)w->box->dimensions;
    for (size_t k = 0; k < w->box->dimensions; k++) {
        double t = 8 * share(w, x, k) - 4;
        a += pow(t - 1 / sqrt(d), 2);
        b += pow(t + 1 / sqrt(d), 2);
    }
    f[0] = 1 - exp(-a);
    f[1] = 1 - exp(-b);
}

/* Squared distances to three points: the front is the triangle between them. */
static void three_points(const struct watched *w, const double *x, double *f) {
    static const double corner[3][2] = {{0.2, 0.2}, {0.8, 0.2}, {0.5, 0.8}};
    for (int i = 0; i < 3; i++)
        f[i] = 0.01 + pow(share(w, x, 0) - corner[i][0], 2) + pow(share(w, x, 1) - corner[i][1], 2);
}

static struct qg_box box_of(size_t dimensions) {
    struct qg_box box = {.dimensions = dimensions};
    for (size_t k = 0; k < dimensions; k++) {
        box.lower[k] = k % 2 ? 0 : 40;
        box.upper[k] = k % 2 ? 0.035 : 46;
    }
    return box;
}

static struct watched *watch(const struct qg_box *box,
                             void (*f)(const struct watched *self, const double *x, double *f), size_t objectives) {
    struct watched *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->box = box;
    w->f = f;
    w->objectives = w->front.objectives = objectives;
    for (size_t k = 0; k < QG_SEARCH_OBJECTIVES_MAX; k++)
        w->best[k] = INFINITY;
    return w;
}

static void unwatch(struct watched *w) {
    qg_front_finish(&w->front);
    free(w);
}

static enum qg_status search(struct watched *w, size_t evaluations, size_t starts, uint64_t seed) {
    const struct qg_multistart plan = {evaluations, starts, w->objectives, seed};
    const struct qg_objective_function objective = {w, values};
    return qg_multistart_search(&plan, w->box, &objective);
}

static void the_budget_is_kept_to_the_letter(void **state) {
    (void)state;
    static const size_t budgets[] = {1, 2, 3, 7, 16, 33, 100, 1000};
    for (size_t d = 1; d <= QG_SEARCH_DIMENSIONS_MAX; d += 3)
        for (size_t starts = 1; starts <= QG_STARTS_MAX; starts += 5)
            for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++) {
                const struct qg_box box = box_of(d);
                struct watched *w = watch(&box, sphere, 1);
                assert_int_equal(search(w, budgets[i], starts, 4), QG_OK);
                assert_int_equal(w->points, budgets[i]);
                assert_int_equal(w->outside, 0);
                assert_true(w->largest_batch <= QG_SEARCH_BATCH);
                unwatch(w);
            }
}

static void it_finds_the_bottom_of_a_bowl_and_of_a_valley(void **state) {
    (void)state;
    for (size_t d = 1; d <= 8; d++) {
        const struct qg_box box = box_of(d);
        struct watched *w = watch(&box, sphere, 1);
        assert_int_equal(search(w, 300 * d, 4, d), QG_OK);
        assert_true(w->best[0] < 1e-4);
        unwatch(w);
    }
    struct qg_box box = {.dimensions = 2, .lower = {-2, -2}, .upper = {2, 2}};
    for (uint64_t seed = 1; seed <= 5; seed++) {
        struct watched *w = watch(&box, rosenbrock, 1);
        assert_int_equal(search(w, 600, 3, seed), QG_OK);
        assert_true(w->best[0] < 1e-5);
        unwatch(w);
    }
}

/* 25 valleys: the deepest one is found from most seeds. */
static void it_leaves_wrong_valleys(void **state) {
    (void)state;
    const struct qg_box box = box_of(2);
    int found = 0;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        struct watched *w = watch(&box, rastrigin, 1);
        assert_int_equal(search(w, 1500, 4, seed), QG_OK);
        found += w->best[0] < 1e-3;
        unwatch(w);
    }
    assert_true(found >= 8);
}

static void a_seed_gives_one_sequence(void **state) {
    (void)state;
    const struct qg_box box = box_of(4);
    struct watched *a = watch(&box, rastrigin, 1), *b = watch(&box, rastrigin, 1), *c = watch(&box, rastrigin, 1);
    assert_int_equal(search(a, 500, 4, 7), QG_OK);
    assert_int_equal(search(b, 500, 4, 7), QG_OK);
    assert_int_equal(search(c, 500, 4, 8), QG_OK);
    assert_memory_equal(a->log, b->log, 500 * sizeof(double));
    assert_memory_not_equal(a->log, c->log, 500 * sizeof(double));
    unwatch(a);
    unwatch(b);
    unwatch(c);
}

/* Only order counts: a monotone function of the objective leads through the same points. */
static void exponential_of_rastrigin(const struct watched *w, const double *x, double *f) {
    rastrigin(w, x, f);
    *f = exp(*f / 50) - 3;
}

static void a_monotone_change_of_the_objective_changes_nothing(void **state) {
    (void)state;
    const struct qg_box box = box_of(3);
    struct watched *a = watch(&box, rastrigin, 1), *b = watch(&box, exponential_of_rastrigin, 1);
    assert_int_equal(search(a, 400, 4, 3), QG_OK);
    assert_int_equal(search(b, 400, 4, 3), QG_OK);
    for (size_t i = 0; i < 400; i++)
        assert_true(fabs(exp(a->log[i] / 50) - 3 - b->log[i]) < 1e-9);
    unwatch(a);
    unwatch(b);
}

static void batches_are_wide(void **state) {
    (void)state;
    const struct qg_box box = box_of(4);
    struct watched *w = watch(&box, rastrigin, 1);
    assert_int_equal(search(w, 320, 4, 1), QG_OK);
    assert_true(w->calls < 320 / 1.8);
    unwatch(w);
}

static void an_objective_that_fails_ends_the_search(void **state) {
    (void)state;
    const struct qg_box box = box_of(4);
    for (size_t at = 1; at < 60; at += 7) {
        struct watched *w = watch(&box, rastrigin, 1);
        w->fail_at = at;
        assert_int_equal(search(w, 320, 4, 1), QG_CANCELLED);
        assert_int_equal(w->calls, at);
        unwatch(w);
    }
}

/* Hypervolume of Schaffer's front towards (1, 1): 1 - the integral of (1 - sqrt t)^2 = 5/6. */
static void the_front_of_two_bowls_is_found(void **state) {
    (void)state;
    static const double corner[] = {1, 1, 1};
    for (size_t d = 1; d <= 4; d++) {
        const struct qg_box box = box_of(d);
        struct watched *w = watch(&box, schaffer, 2);
        assert_int_equal(search(w, 600, 6, 2), QG_OK);
        double volume = qg_front_hypervolume(&w->front, corner);
        assert_true(volume < 5.0 / 6 && volume > 0.77);
        assert_int_equal(w->points, 600);
        unwatch(w);
    }
}

/* The middle of a front that is not convex, where f1 = f2 = 1 - exp(-1) = 0.632. */
static void the_middle_of_a_concave_front_is_found(void **state) {
    (void)state;
    const struct qg_box box = box_of(3);
    struct watched *w = watch(&box, fonseca, 2);
    double nearest = INFINITY;
    assert_int_equal(search(w, 900, 3, 5), QG_OK);
    for (size_t i = 0; i < w->front.count; i++)
        nearest = fmin(nearest, fmax(w->front.member[i].value[0], w->front.member[i].value[1]));
    assert_true(nearest > 1 - exp(-1) - 1e-9 && nearest < 0.66);
    unwatch(w);
}

/* Three objectives: something near each corner and near the middle of the triangle. */
static void three_objectives_are_traded_off(void **state) {
    (void)state;
    const struct qg_box box = box_of(2);
    struct watched *w = watch(&box, three_points, 3);
    assert_int_equal(search(w, 900, 9, 1), QG_OK);
    double middle = INFINITY;
    for (size_t i = 0; i < w->front.count; i++)
        middle = fmin(
            middle, fmax(w->front.member[i].value[2], fmax(w->front.member[i].value[0], w->front.member[i].value[1])));
    for (size_t k = 0; k < 3; k++)
        assert_true(w->best[k] < 0.03);
    /* the circumcentre (0.5, 0.425) is 0.375 away from all three */
    assert_true(middle >= 0.01 + 0.375 * 0.375 - 1e-9 && middle < 0.18);
    assert_true(w->front.count > 50);
    unwatch(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_budget_is_kept_to_the_letter),
        cmocka_unit_test(it_finds_the_bottom_of_a_bowl_and_of_a_valley),
        cmocka_unit_test(it_leaves_wrong_valleys),
        cmocka_unit_test(a_seed_gives_one_sequence),
        cmocka_unit_test(a_monotone_change_of_the_objective_changes_nothing),
        cmocka_unit_test(batches_are_wide),
        cmocka_unit_test(an_objective_that_fails_ends_the_search),
        cmocka_unit_test(the_front_of_two_bowls_is_found),
        cmocka_unit_test(the_middle_of_a_concave_front_is_found),
        cmocka_unit_test(three_objectives_are_traded_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
