/* Random samples and simplex on functions with known minima; binomial intervals against published ones. */
#include "tests/core/cases.h"

#include "core/search.h"

/* An objective that is watched: what was asked, in order, and whether all lay inside the box. */
struct watched {
    const struct qg_box *box;
    double (*f)(const struct watched *self, const double *x);
    double center[QG_SEARCH_DIMENSIONS_MAX];
    size_t calls, points, largest_batch, outside;
    size_t fail_at; /* this call answers QG_CANCELLED; 0: none */
    double log[4096];
};

static enum qg_status values(void *self, size_t n, const double *x, double *f) {
    struct watched *w = self;
    size_t d = w->box->dimensions;
    if (++w->calls == w->fail_at)
        return QG_CANCELLED;
    w->largest_batch = n > w->largest_batch ? n : w->largest_batch;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < d; k++)
            w->outside += !(x[i * d + k] >= w->box->lower[k] && x[i * d + k] <= w->box->upper[k]);
        f[i] = w->f(w, x + i * d);
        if (w->points < 4096)
            w->log[w->points] = f[i];
        w->points++;
    }
    return QG_OK;
}

static double quadratic(const struct watched *w, const double *x) {
    double sum = 0;
    for (size_t k = 0; k < w->box->dimensions; k++) {
        double away = (x[k] - w->center[k]) / (w->box->upper[k] - w->box->lower[k]);
        sum += (double)(k + 1) * away * away;
    }
    return sum;
}

static double rosenbrock(const struct watched *w, const double *x) {
    double sum = 0;
    for (size_t k = 0; k + 1 < w->box->dimensions; k++)
        sum += 100 * pow(x[k + 1] - x[k] * x[k], 2) + pow(1 - x[k], 2);
    return sum;
}

static double constant(const struct watched *w, const double *x) {
    (void)w, (void)x;
    return 1;
}

/* Different widths, as radii and amplitudes have. */
static struct qg_box box_of(size_t dimensions) {
    struct qg_box box = {.dimensions = dimensions};
    for (size_t k = 0; k < dimensions; k++) {
        box.lower[k] = k % 2 ? 0 : 40;
        box.upper[k] = k % 2 ? 0.035 : 46;
    }
    return box;
}

static struct qg_simplex simplex_from(struct watched *w, const double *x) {
    struct qg_simplex simplex;
    struct qg_vertex start = {.f = w->f(w, x)};
    memcpy(start.x, x, w->box->dimensions * sizeof *x);
    const struct qg_objective_function objective = {w, values};
    assert_int_equal(qg_simplex_init(&simplex, w->box, &objective, &start), QG_OK);
    return simplex;
}

/* ---- simplex ---------------------------------------------------------------------------------------------------- */

static void simplex_finds_the_bottom_of_quadratics(void **state) {
    (void)state;
    struct dice dice = {71};
    for (size_t d = 1; d <= 8; d++) {
        struct qg_box box = box_of(d);
        struct watched w = {.box = &box, .f = quadratic};
        double start[QG_SEARCH_DIMENSIONS_MAX];
        for (size_t k = 0; k < d; k++) {
            w.center[k] = box.lower[k] + dice_between(&dice, 0.2, 0.8) * (box.upper[k] - box.lower[k]);
            start[k] = box.lower[k] + dice_between(&dice, 0, 1) * (box.upper[k] - box.lower[k]);
        }
        struct qg_simplex simplex = simplex_from(&w, start);
        double best = simplex.vertex[0].f;
        for (size_t i = 0; i < 300 * d; i++) {
            assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
            assert_true(simplex.vertex[0].f <= best);
            best = simplex.vertex[0].f;
            for (size_t k = 1; k <= d; k++)
                assert_true(simplex.vertex[k].f >= simplex.vertex[k - 1].f);
        }
        assert_true(best < 1e-10);
        assert_true(qg_simplex_size(&simplex) < 1e-3);
        assert_int_equal(w.outside, 0);
    }
}

static void simplex_follows_rosenbrocks_valley(void **state) {
    (void)state;
    for (size_t d = 2; d <= 4; d++) {
        struct qg_box box = {.dimensions = d};
        double start[4] = {-1.2, 1, -1.2, 1};
        for (size_t k = 0; k < d; k++) {
            box.lower[k] = -2;
            box.upper[k] = 2;
        }
        struct watched w = {.box = &box, .f = rosenbrock};
        struct qg_simplex simplex = simplex_from(&w, start);
        for (int i = 0; i < 2000; i++)
            assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
        assert_true(simplex.vertex[0].f < 1e-12 ||
                    (d == 4 && simplex.vertex[0].f < 4)); /* d = 4 has a second bottom, 3.70 */
        assert_int_equal(w.outside, 0);
    }
}

/* An objective that answers from a list and remembers the points. */
struct scripted {
    double answer[8], x[8][2];
    size_t points;
};

static enum qg_status answer(void *self, size_t n, const double *x, double *f) {
    struct scripted *s = self;
    for (size_t i = 0; i < n; i++, s->points++) {
        assert_true(s->points < 8);
        memcpy(s->x[s->points], x + 2 * i, sizeof s->x[0]);
        f[i] = s->answer[s->points];
    }
    return QG_OK;
}

/* Every move of the method: from (4,4), (5,4), (4,5) with values 1, 2, 3 the worst is reflected at (4.5,4) to (5,3). */
static void simplex_moves_by_the_book(void **state) {
    (void)state;
    static const struct {
        double answer[4], x[4][2];
        size_t points;
        double best, worst; /* values after the move */
    } moves[] = {
        {{1.5}, {{5, 3}}, 1, 1, 2},                                                     /* reflection */
        {{0.5, 0.4}, {{5, 3}, {5.5, 2}}, 2, 0.4, 2},                                    /* expansion */
        {{0.5, 0.6}, {{5, 3}, {5.5, 2}}, 2, 0.5, 2},                                    /* expansion in vain */
        {{2.5, 2.4}, {{5, 3}, {4.75, 3.5}}, 2, 1, 2.4},                                 /* contraction outside */
        {{2.5, 2.6, 1.1, 1.2}, {{5, 3}, {4.75, 3.5}, {4.5, 4}, {4, 4.5}}, 4, 1, 1.2},   /* then shrinkage */
        {{3.5, 2.9}, {{5, 3}, {4.25, 4.5}}, 2, 1, 2.9},                                 /* contraction inside */
        {{3.5, 3.1, 0.9, 1.2}, {{5, 3}, {4.25, 4.5}, {4.5, 4}, {4, 4.5}}, 4, 0.9, 1.2}, /* then shrinkage */
    };
    for (size_t m = 0; m < sizeof moves / sizeof *moves; m++) {
        struct scripted script = {.answer = {2, 3}};
        memcpy(script.answer + 2, moves[m].answer, sizeof moves[m].answer);
        const struct qg_box box = {.dimensions = 2, .upper = {10, 10}};
        const struct qg_objective_function objective = {&script, answer};
        const struct qg_vertex start = {.x = {4, 4}, .f = 1};
        struct qg_simplex simplex;
        assert_int_equal(qg_simplex_init(&simplex, &box, &objective, &start), QG_OK);
        assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
        assert_int_equal(script.points, 2 + moves[m].points);
        for (size_t i = 0; i < moves[m].points; i++)
            for (int k = 0; k < 2; k++)
                assert_near(script.x[2 + i][k], moves[m].x[i][k], 1e-14);
        assert_near(simplex.vertex[0].f, moves[m].best, 0);
        assert_near(simplex.vertex[2].f, moves[m].worst, 0);
    }
}

/* The centre lies beyond a face or a corner of the box: the nearest point on it is the answer. */
static void simplex_stops_at_the_edge(void **state) {
    (void)state;
    for (int corner = 0; corner < 2; corner++) {
        struct qg_box box = box_of(3);
        struct watched w = {.box = &box, .f = quadratic, .center = {43, 0.05, 42}};
        double start[3] = {45, 0.01, 44};
        w.center[2] = corner ? 30 : 42;
        struct qg_simplex simplex = simplex_from(&w, start);
        for (int i = 0; i < 400; i++)
            assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
        assert_near(simplex.vertex[0].x[0], 43, 1e-3);
        assert_near(simplex.vertex[0].x[1], 0.035, 1e-6);
        assert_near(simplex.vertex[0].x[2], corner ? 40 : 42, 1e-3);
        assert_int_equal(w.outside, 0);
    }
}

static void first_simplex_turns_inwards_at_the_end_of_the_box(void **state) {
    (void)state;
    struct qg_box box = box_of(2);
    struct watched w = {.box = &box, .f = quadratic, .center = {40, 0}};
    double start[2] = {46, 0.0349};
    struct qg_simplex simplex = simplex_from(&w, start);
    assert_int_equal(w.points, 2);
    assert_int_equal(w.calls, 1); /* one batch */
    assert_int_equal(w.outside, 0);
    assert_near(qg_simplex_size(&simplex), 0.1, 0.11); /* measured from the best vertex, which is a moved one */
    bool moved[2] = {false, false};
    for (int i = 0; i < 3; i++) {
        moved[0] |= fabs(simplex.vertex[i].x[0] - 45.4) < 1e-9;
        moved[1] |= fabs(simplex.vertex[i].x[1] - 0.0314) < 1e-12;
    }
    assert_true(moved[0] && moved[1]);
}

/* On a plain nothing improves: every iteration shrinks towards the best, and the simplex never leaves the box or
 * breaks. */
static void simplex_shrinks_on_a_plain(void **state) {
    (void)state;
    struct qg_box box = box_of(4);
    struct watched w = {.box = &box, .f = constant};
    double start[4] = {46, 0, 40, 0.035};
    struct qg_simplex simplex = simplex_from(&w, start);
    double size = qg_simplex_size(&simplex);
    for (int i = 0; i < 20; i++)
        assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
    assert_true(qg_simplex_size(&simplex) < size * 1e-3);
    assert_int_equal(w.outside, 0);
}

static void a_parameter_without_room_stays(void **state) {
    (void)state;
    struct qg_box box = box_of(2);
    box.lower[1] = box.upper[1] = 0.01;
    struct watched w = {.box = &box, .f = constant};
    double start[2] = {43, 0.01};
    struct qg_simplex simplex = simplex_from(&w, start);
    for (int i = 0; i < 10; i++)
        assert_int_equal(qg_simplex_iterate(&simplex), QG_OK);
    for (int i = 0; i < 3; i++)
        assert_near(simplex.vertex[i].x[1], 0.01, 0);
    assert_int_equal(w.outside, 0);
}

static void an_objective_that_stops_ends_the_search(void **state) {
    (void)state;
    struct qg_box box = box_of(2);
    double start[2] = {43, 0.01};
    for (size_t at = 1; at < 12; at++) {
        struct watched w = {.box = &box, .f = quadratic, .center = {41, 0.02}, .fail_at = at};
        const struct qg_objective_function objective = {&w, values};
        struct qg_vertex first = {.f = INFINITY};
        struct qg_simplex simplex;
        memcpy(first.x, start, sizeof start);
        enum qg_status status = qg_simplex_init(&simplex, &box, &objective, &first);
        for (int i = 0; i < 20 && status == QG_OK; i++)
            status = qg_simplex_iterate(&simplex);
        assert_int_equal(status, QG_CANCELLED);
        assert_int_equal(w.calls, at);
    }
    struct watched w = {.box = &box, .f = quadratic, .fail_at = 2};
    const struct qg_objective_function objective = {&w, values};
    struct qg_vertex best = {.f = INFINITY};
    assert_int_equal(qg_random_samples(&box, 1, 0, 100, &objective, &best), QG_CANCELLED);
    assert_true(best.f < INFINITY); /* what the first batch found is kept */
}

/* ---- random samples --------------------------------------------------------------------------------------------- */

static void samples_fill_the_box_and_the_best_is_kept(void **state) {
    (void)state;
    struct qg_box box = box_of(8);
    struct watched w = {.box = &box, .f = quadratic, .center = {43, 0.01, 41, 0.02, 42, 0.03, 45, 0.005}};
    const struct qg_objective_function objective = {&w, values};
    struct qg_vertex best = {.f = INFINITY};
    assert_int_equal(qg_random_samples(&box, 5, 0, 4000, &objective, &best), QG_OK);
    assert_int_equal(w.points, 4000);
    assert_int_equal(w.outside, 0);
    assert_true(w.largest_batch <= QG_SEARCH_BATCH);
    double least = INFINITY;
    for (size_t i = 0; i < w.points; i++)
        least = fmin(least, w.log[i]);
    assert_near(best.f, least, 0);
    assert_near(w.f(&w, best.x), best.f, 0);
    struct qg_vertex unbeaten = {.f = least / 2, .x = {1, 2}};
    assert_int_equal(qg_random_samples(&box, 5, 0, 4000, &objective, &unbeaten), QG_OK);
    assert_near(unbeaten.f, least / 2, 0);
    assert_near(unbeaten.x[1], 2, 0);
}

/* However the sequence is cut into calls, the samples are the same; another seed gives others. */
static void samples_do_not_depend_on_the_cut(void **state) {
    (void)state;
    struct qg_box box = box_of(3);
    static struct watched whole, cut, other;
    whole = cut = other = (struct watched){.box = &box, .f = quadratic, .center = {43, 0.01, 41}};
    struct qg_vertex best[3] = {{.f = INFINITY}, {.f = INFINITY}, {.f = INFINITY}};
    const struct qg_objective_function objective[3] = {{&whole, values}, {&cut, values}, {&other, values}};
    assert_int_equal(qg_random_samples(&box, 12345, 0, 200, &objective[0], &best[0]), QG_OK);
    for (size_t first = 0, n = 1; first < 200; first += n, n = n * 2 + 1)
        assert_int_equal(
            qg_random_samples(&box, 12345, first, n < 200 - first ? n : 200 - first, &objective[1], &best[1]), QG_OK);
    assert_int_equal(qg_random_samples(&box, 12346, 0, 200, &objective[2], &best[2]), QG_OK);
    assert_int_equal(cut.points, 200);
    assert_memory_equal(whole.log, cut.log, 200 * sizeof *whole.log);
    assert_memory_equal(&best[0], &best[1], sizeof best[0]);
    for (size_t i = 0; i < 200; i++)
        assert_true(whole.log[i] != other.log[i]);
}

/* ---- confidence ------------------------------------------------------------------------------------------------- */

static void confidence_matches_published_intervals(void **state) {
    (void)state;
    static const struct {
        size_t failures, samples;
        double low, high;
    } known[] = {
        {0, 100, 0, 0.0362167},
        {5, 100, 0.0164319, 0.1128349},
        {100, 100, 0.9637833, 1},
        {1, 2, 0.0125791, 0.9874209},
        {0, 1, 0, 0.975},
        {1, 1, 0.025, 1},
        {5, 10, 0.1870860, 0.8129140},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        double low, high;
        qg_binomial_confidence(known[i].failures, known[i].samples, &low, &high);
        assert_near(low, known[i].low, 1e-6);
        assert_near(high, known[i].high, 1e-6);
    }
}

/* Probability of at most k of n, summed by the ratio of neighbouring terms; the first would underflow a double. */
static double at_most(size_t k, size_t n, double p) {
    long double term = powl(1 - (long double)p, (long double)n), sum = term;
    for (size_t i = 1; i <= k; i++) {
        term *= (long double)(n - i + 1) / (long double)i * p / (1 - (long double)p);
        sum += term;
    }
    return (double)sum;
}

static void confidence_leaves_two_and_a_half_percent_on_each_side(void **state) {
    (void)state;
    for (size_t n = 1; n <= 200; n += 13) {
        double last_low = -1, last_high = -1;
        for (size_t k = 0; k <= n; k++) {
            double low, high;
            qg_binomial_confidence(k, n, &low, &high);
            assert_true(low <= (double)k / (double)n && (double)k / (double)n <= high);
            assert_true(low > last_low && high > last_high);
            if (k > 0)
                assert_near(1 - at_most(k - 1, n, low), 0.025, 1e-9);
            if (k < n)
                assert_near(at_most(k, n, high), 0.025, 1e-9);
            last_low = low;
            last_high = high;
        }
    }
}

static void confidence_bears_many_samples(void **state) {
    (void)state;
    double low, high;
    qg_binomial_confidence(10000, 100000, &low, &high);
    double normal = 1.959964 * sqrt(0.1 * 0.9 / 100000); /* half the width, up to terms of 1/n */
    assert_near(low, 0.1 - normal, 3e-5);
    assert_near(high, 0.1 + normal, 3e-5);
    qg_binomial_confidence(0, 100000, &low, &high);
    assert_near(low, 0, 0);
    assert_near(high, 3.68881e-5, 1e-9); /* 1 - 0.025^(1/n) */
    qg_binomial_confidence(99999, 100000, &low, &high);
    assert_near(high, 1 - 2.53178e-7, 1e-11);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(simplex_finds_the_bottom_of_quadratics),
        cmocka_unit_test(simplex_follows_rosenbrocks_valley),
        cmocka_unit_test(simplex_moves_by_the_book),
        cmocka_unit_test(simplex_stops_at_the_edge),
        cmocka_unit_test(first_simplex_turns_inwards_at_the_end_of_the_box),
        cmocka_unit_test(simplex_shrinks_on_a_plain),
        cmocka_unit_test(a_parameter_without_room_stays),
        cmocka_unit_test(an_objective_that_stops_ends_the_search),
        cmocka_unit_test(samples_fill_the_box_and_the_best_is_kept),
        cmocka_unit_test(samples_do_not_depend_on_the_cut),
        cmocka_unit_test(confidence_matches_published_intervals),
        cmocka_unit_test(confidence_leaves_two_and_a_half_percent_on_each_side),
        cmocka_unit_test(confidence_bears_many_samples),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
