/* Attractors, the branch "worst", continuation: against marching, against closed forms, and against themselves.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "core/attractors.h"
#include "core/branches.h"
#include "core/continuation.h"
#include "core/random.h"
#include "tests/core/oscillators.h"

enum { ORBITS = 100 };

static const struct qg_speed_map range = {.min = 0.2, .max = 1.4, .count = SPEEDS, .start_static = 1};

static void respond(const struct qg_oscillator *o, enum qg_branch branch, struct qg_response *out) {
    struct qg_speed_map map = range;
    map.branch = branch;
    if (branch == QG_BRANCH_WORST)
        assert_int_equal(qg_worst_response(o, &map, out), QG_OK);
    else
        for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
            qg_response_piece(o, &map, piece, out);
}

static void find(const struct qg_oscillator *o, struct qg_branches *branches) {
    assert_int_equal(qg_branches_find(o, &range, NULL, branches), QG_OK);
    assert_true(branches->complete);
}

static bool has_response(const struct qg_orbit *orbits, size_t count, const struct qg_response *r) {
    for (size_t i = 0; i < count; i++)
        if (orbits[i].floquet.stable && orbits[i].period == r->period &&
            fabs(orbits[i].rms - r->rms) < 1e-5 * r->rms + 1e-7)
            return true;
    return false;
}

/* --- the largest response --- */

/* At every speed at least as large as what the other three branches show, and one of the stable branches. */
static void worst_is_never_below_the_others(void **state) {
    (void)state;
    static struct qg_response worst[SPEEDS], other[SPEEDS];
    for (int n = 0; n < RELIEFS * CASES; n++) {
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        respond(&o, QG_BRANCH_WORST, worst);
        size_t larger = 0;
        for (int branch = QG_BRANCH_FIXED; branch < QG_BRANCH_WORST; branch++) {
            respond(&o, (enum qg_branch)branch, other);
            for (size_t i = 0; i < SPEEDS; i++) {
                assert_true(worst[i].rms >= other[i].rms * (1.0 - 2e-5));
                larger += worst[i].rms > 1.1 * other[i].rms;
            }
        }
        assert_true(larger > 300);
        for (size_t i = 0; i < SPEEDS; i++)
            assert_true(worst[i].rms < 2.0); /* no hammering on both flanks */
    }
}

/* Fewer speeds than a sweep needs: the same answers at the speeds that the maps share. */
static void worst_of_a_coarse_map_is_that_of_a_fine_one(void **state) {
    (void)state;
    static struct qg_response fine[SPEEDS];
    struct qg_response coarse[28];
    struct qg_speed_map map = range;
    struct qg_oscillator o = case_s(0, 2);
    const struct qg_exploration none = {0};
    struct qg_attractors found;
    respond(&o, QG_BRANCH_RUN_DOWN, fine);
    map.count = 28; /* every 37th of 1000 */
    map.branch = QG_BRANCH_WORST;
    assert_int_equal(qg_worst_response(&o, &map, coarse), QG_OK);
    for (size_t i = 0; i < map.count; i++)
        assert_true(coarse[i].rms >= fine[37 * i].rms * (1.0 - 2e-5));
    assert_int_equal(qg_attractors_find(&o, &map, &none, &found), QG_OK);
    assert_true(found.stride > 10 && found.fine.count == 27 * found.stride + 1);
    for (size_t i = 0; i < found.fine.count; i += found.stride)
        assert_true(found.first[i] != QG_NO_ATTRACTOR);
    qg_attractors_finish(&found);
}

/* One speed is a map too. */
static void worst_of_one_speed_exists(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    struct qg_speed_map map = {.min = 1.25, .max = 1.25, .count = 1, .start_static = 1};
    struct qg_response worst;
    assert_int_equal(qg_worst_response(&o, &map, &worst), QG_OK);
    assert_true(worst.rms > 0.3 && worst.period >= 2); /* the small one has 0.04 */
}

static void attractors_are_different_stable_orbits(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    struct qg_attractors a;
    assert_int_equal(qg_attractors_find(&o, &range, &qg_worst_exploration, &a), QG_OK);
    for (size_t speed = 0; speed < a.fine.count; speed++)
        for (size_t i = a.first[speed]; i != QG_NO_ATTRACTOR; i = a.item[i].next) {
            const struct qg_orbit *one = &a.item[i].orbit;
            assert_true(fabs(one->frequency_ratio - qg_speed_at(&a.fine, speed)) < 1e-15);
            assert_true(one->period <= 0 || one->floquet.stable);
            for (size_t k = a.item[i].next; k != QG_NO_ATTRACTOR && one->period > 0; k = a.item[k].next)
                assert_false(qg_orbit_same(one, &a.item[k].orbit, 1e-6));
        }
    qg_attractors_finish(&a);
}

/* --- continuation --- */

/* Constant stiffness driven through e: one branch, no special point, the textbook's resonance. */
static void a_linear_oscillator_has_one_branch(void **state) {
    (void)state;
    const double zeta = 0.03, amplitude = 0.01;
    struct qg_oscillator o = plain_oscillator(zeta, 1.0);
    static struct qg_branches b;
    o.error = (struct qg_fourier){.harmonics = 1, .cosine = {amplitude}};
    find(&o, &b);
    assert_int_equal(b.count, 1);
    const struct qg_curve *curve = &b.curve[0];
    assert_int_equal(curve->period, 1);
    assert_true(curve->end[0] == QG_END_RANGE && curve->end[1] == QG_END_RANGE);
    assert_int_equal(curve->special_count, 0);
    assert_true(fabs(curve->point[0].frequency_ratio - 0.2) < 1e-12);
    assert_true(fabs(curve->point[curve->count - 1].frequency_ratio - 1.4) < 1e-12);
    for (size_t i = 0; i < curve->count; i++) {
        double p = curve->point[i].frequency_ratio, real = 1.0 - p * p, imaginary = 2.0 * zeta * p;
        double exact = amplitude / sqrt(2.0 * (real * real + imaginary * imaginary));
        assert_true(fabs(curve->point[i].rms / exact - 1.0) < 1e-8);
        assert_true(curve->point[i].stable);
    }
    qg_branches_finish(&b);
}

/* x'' + 2 zeta x' + (1 + 0.1 cos Omega tau) x under load: the orbit in contact doubles its period at both edges of the
 * Mathieu tongue, and the branch of period two begins there. */
static void period_doublings_are_the_edges_of_the_mathieu_tongue(void **state) {
    (void)state;
    struct qg_oscillator o = plain_oscillator(0.01, 0.5);
    struct qg_speed_map map = {.min = 1.9, .max = 2.1, .count = 81, .start_static = 1};
    static struct qg_branches b;
    o.stiffness.harmonics = 1;
    o.stiffness.cosine[0] = 0.1;
    assert_int_equal(qg_branches_find(&o, &map, NULL, &b), QG_OK);
    double edge[8], one[8];
    size_t edges = 0, ends = 0;
    for (size_t i = 0; i < b.count; i++)
        for (size_t k = 0; k < b.curve[i].special_count; k++) {
            const struct qg_special_point *s = &b.curve[i].special[k];
            if (s->kind == QG_SPECIAL_PERIOD_DOUBLING && b.curve[i].period == 1 && edges < 8)
                edge[edges++] = s->frequency_ratio;
            if (s->kind == QG_SPECIAL_PERIOD_DOUBLING && b.curve[i].period == 2 && ends < 8)
                one[ends++] = s->frequency_ratio;
        }
    assert_int_equal(edges, 2);
    assert_true(fabs(fmin(edge[0], edge[1]) - 1.95377) < 1e-5);
    assert_true(fabs(fmax(edge[0], edge[1]) - 2.04541) < 1e-5);
    assert_true(ends >= 1);
    for (size_t i = 0; i < ends && i < 2; i++)
        assert_true(fmin(fabs(one[i] - edge[0]), fabs(one[i] - edge[1])) < 1e-6);
    qg_branches_finish(&b);
}

/* Does one of the curve's special points lie between two points, ends included? */
static bool special_between(const struct qg_curve *c, size_t i) {
    double low = fmin(c->point[i].frequency_ratio, c->point[i + 1].frequency_ratio) - 1e-6;
    double high = fmax(c->point[i].frequency_ratio, c->point[i + 1].frequency_ratio) + 1e-6;
    for (size_t k = 0; k < c->special_count; k++)
        if (c->special[k].kind <= QG_SPECIAL_PERIOD_DOUBLING && c->special[k].frequency_ratio >= low &&
            c->special[k].frequency_ratio <= high)
            return true;
    return false;
}

/* Liouville at every point; stable parts end at folds and period doublings; the speed turns around at folds only; no
 * complex multiplier is ever outside the unit circle. */
static void check_curve(const struct qg_oscillator *o, const struct qg_curve *c) {
    for (size_t i = 0; i < c->count; i++) {
        const struct qg_branch_point *point = &c->point[i];
        const double *re = point->multiplier_real, *im = point->multiplier_imaginary;
        double expected = exp(-4.0 * QG_PI * o->damping_ratio * c->period / point->frequency_ratio);
        bool parent = i == 0 || i + 1 == c->count; /* of a period doubling: its own, shorter period */
        double largest = fmax(fabs(re[0]), 1.0);
        assert_true(parent || fabs((re[0] * re[1] - im[0] * im[1]) / expected - 1.0) < 3e-6 * largest * largest);
        assert_true(im[0] == 0.0 || hypot(re[0], im[0]) < 1.0);
        if (i + 1 < c->count && c->point[i].stable != c->point[i + 1].stable)
            assert_true(special_between(c, i));
        if (i > 0 && i + 1 < c->count &&
            (c->point[i + 1].frequency_ratio - point->frequency_ratio) *
                    (point->frequency_ratio - c->point[i - 1].frequency_ratio) <
                0.0)
            assert_true(special_between(c, i - 1) || special_between(c, i));
    }
    for (size_t k = 0; k < c->special_count; k++)
        assert_true(c->special[k].frequency_ratio >= 0.2 - 1e-9 && c->special[k].frequency_ratio <= 1.4 + 1e-9);
    assert_true(c->end[0] != QG_END_LOST && c->end[1] != QG_END_LOST);
}

static bool same_curve(const struct qg_branches *b, size_t i) {
    const struct qg_curve *c = &b->curve[i];
    size_t middle = c->count / 2;
    struct qg_orbit orbit = {.frequency_ratio = c->point[middle].frequency_ratio, .period = c->period};
    for (int n = 0; n < c->period; n++) {
        const double *z = c->state + (middle * (size_t)c->period + (size_t)n) * 2;
        orbit.state[n] = (struct qg_state){z[0], z[1]};
    }
    for (size_t k = 0; k < b->count; k++)
        if (k != i && qg_curve_has(&b->curve[k], &orbit)) {
            print_message("# branches %zu and %zu of period %d share p = %.9f\n", i, k, c->period,
                          orbit.frequency_ratio);
            return true;
        }
    return false;
}

/* run_up and run_down differ between folds and nowhere else: wherever a stretch of different responses begins or ends,
 * a fold is within one speed step. */
static void check_hysteresis(const struct qg_oscillator *o, const struct qg_branches *b, size_t *stretches) {
    static struct qg_response up[SPEEDS], down[SPEEDS];
    const double step = 1.2 / (SPEEDS - 1);
    respond(o, QG_BRANCH_RUN_UP, up);
    respond(o, QG_BRANCH_RUN_DOWN, down);
    bool before = false;
    for (size_t i = 0; i < SPEEDS; i++) {
        bool now = fabs(up[i].rms - down[i].rms) > 1e-5 * down[i].rms + 1e-7, fold = false;
        double p = qg_speed_at(&range, i);
        for (size_t n = 0; n < b->count; n++)
            for (size_t k = 0; k < b->curve[n].special_count; k++) {
                const struct qg_special_point *s = &b->curve[n].special[k];
                fold = fold || (s->kind == QG_SPECIAL_FOLD && s->frequency_ratio > p - 2.0 * step &&
                                s->frequency_ratio < p + step);
            }
        assert_true(now == before || fold);
        *stretches += now && !before;
        before = now;
    }
    assert_false(before);
}

/* What 40 random starts per speed reach at ten speeds is among the stable branches. */
static void check_containment(const struct qg_oscillator *o, const struct qg_branches *b) {
    for (size_t speed = 0; speed < 10; speed++) {
        struct qg_orbit orbits[ORBITS];
        double ratio[QG_LANES], p = 0.23 + 0.12 * (double)speed;
        size_t count = qg_branches_at(b, o, p, ORBITS, orbits);
        for (size_t first = 0; first < 40; first += QG_LANES) {
            struct qg_state start[QG_LANES];
            struct qg_response out[QG_LANES];
            for (size_t i = 0; i < QG_LANES; i++) {
                ratio[i] = p;
                start[i] = qg_random_start(QG_STREAM_TESTS, speed, first + i);
            }
            qg_batch_settle(o, QG_LANES, ratio, start, out);
            for (size_t i = 0; i < QG_LANES; i++)
                assert_true(out[i].period < 1 || has_response(orbits, count, &out[i]));
        }
    }
}

static void branches_of_case_s(void **state) {
    (void)state;
    static struct qg_branches b;
    size_t stretches = 0;
    for (int n = 0; n < RELIEFS * CASES; n++) {
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        find(&o, &b);
        for (size_t i = 0; i < b.count; i++) {
            check_curve(&o, &b.curve[i]);
            assert_false(same_curve(&b, i));
        }
        check_hysteresis(&o, &b, &stretches);
        check_containment(&o, &b);
        qg_branches_finish(&b);
    }
    assert_int_equal(stretches, 13);
}

/* Standard relief, a third of the torque: the period-two branches above p = 1.2, stable through the range's end. */
static void the_period_two_tongue_is_found(void **state) {
    (void)state;
    static struct qg_branches b;
    struct qg_oscillator o = case_s(1, 0);
    find(&o, &b);
    for (double p = 1.21; p < 1.4; p += 0.03) {
        struct qg_orbit orbits[ORBITS];
        size_t count = qg_branches_at(&b, &o, p, ORBITS, orbits), two = 0, one = 0;
        for (size_t i = 0; i < count; i++) {
            two += orbits[i].period == 2 && orbits[i].floquet.stable && orbits[i].rms > 0.2;
            one += orbits[i].period == 1 && orbits[i].floquet.stable && orbits[i].rms < 0.06;
        }
        assert_true(two >= 1 && one == 1);
    }
    qg_branches_finish(&b);
}

/* Those of period one at a speed that stay clear of the back flank. */
static size_t orbits_on_the_drive_flank(const struct qg_branches *b, const struct qg_oscillator *o, double p,
                                        struct qg_orbit *out) {
    size_t all = qg_branches_at(b, o, p, ORBITS, out), count = 0;
    for (size_t i = 0; i < all; i++)
        if (out[i].period == 1 && out[i].back_crossings == 0)
            out[count++] = out[i];
    return count;
}

/* The main fold, where run_up jumps, by another way: the largest p at which shooting still finds the lower branch. */
static void folds_are_where_shooting_ends(void **state) {
    (void)state;
    static struct qg_branches b;
    struct qg_oscillator o = case_s(0, 2);
    find(&o, &b);
    double fold = 0.0;
    for (size_t k = 0; k < b.curve[0].special_count; k++)
        if (b.curve[0].special[k].kind == QG_SPECIAL_FOLD)
            fold = fmax(fold, b.curve[0].special[k].frequency_ratio);
    double low = fold - 0.01, high = fold + 0.01, p = low;
    struct qg_orbit orbits[ORBITS], at;
    size_t beyond = orbits_on_the_drive_flank(&b, &o, high, orbits);
    assert_int_equal(orbits_on_the_drive_flank(&b, &o, low, orbits), beyond + 2);
    at = orbits[0];
    for (size_t i = 0; i < beyond + 2; i++) /* the lower of the two that end in the fold */
        if (orbits[i].floquet.stable && orbits[i].rms < at.rms)
            at = orbits[i];
    for (double step = 1e-3; step > 1e-8; p += step) {
        struct qg_orbit next = at;
        bool found;
        next.frequency_ratio = p + step;
        qg_orbit_shoot(&o, 1, 1, &next, &found);
        bool on = found && next.floquet.stable && fabs(next.rms - at.rms) < 0.05 * at.rms + 1.0 * sqrt(step);
        if (on)
            at = next;
        else
            p -= step, step *= 0.5;
    }
    assert_true(fabs(p - fold) < 2e-6);
    qg_branches_finish(&b);
}

/* --- stopping, equal bits --- */

static bool at_once(void *self) {
    ++*(int *)self;
    return *(int *)self > 3;
}

static void a_stop_is_obeyed(void **state) {
    (void)state;
    static struct qg_branches b;
    int asked = 0;
    const struct qg_stop stop = {at_once, &asked};
    struct qg_oscillator o = case_s(1, 1);
    assert_int_equal(qg_branches_find(&o, &range, &stop, &b), QG_CANCELLED);
    assert_int_equal(asked, 4);
    qg_branches_finish(&b);
}

static void equal_questions_have_equal_answers(void **state) {
    (void)state;
    static struct qg_branches a, b;
    struct qg_oscillator o = case_s(1, 0);
    find(&o, &a);
    find(&o, &b);
    assert_int_equal(a.count, b.count);
    for (size_t i = 0; i < a.count; i++) {
        assert_int_equal(a.curve[i].count, b.curve[i].count);
        for (size_t k = 0; k < a.curve[i].count; k++) {
            assert_true(a.curve[i].point[k].frequency_ratio == b.curve[i].point[k].frequency_ratio);
            assert_true(a.curve[i].point[k].rms == b.curve[i].point[k].rms);
        }
    }
    qg_branches_finish(&a);
    qg_branches_finish(&b);
}

static void names_are_those_of_the_schema(void **state) {
    (void)state;
    assert_string_equal(qg_special_name(QG_SPECIAL_PERIOD_DOUBLING), "period_doubling");
    assert_string_equal(qg_special_name(QG_SPECIAL_GRAZING_BACK), "grazing_back_flank");
    assert_string_equal(qg_branch_end_name(QG_END_LOST), "lost");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worst_is_never_below_the_others),
        cmocka_unit_test(worst_of_a_coarse_map_is_that_of_a_fine_one),
        cmocka_unit_test(worst_of_one_speed_exists),
        cmocka_unit_test(attractors_are_different_stable_orbits),
        cmocka_unit_test(a_linear_oscillator_has_one_branch),
        cmocka_unit_test(period_doublings_are_the_edges_of_the_mathieu_tongue),
        cmocka_unit_test(branches_of_case_s),
        cmocka_unit_test(the_period_two_tongue_is_found),
        cmocka_unit_test(folds_are_where_shooting_ends),
        cmocka_unit_test(a_stop_is_obeyed),
        cmocka_unit_test(equal_questions_have_equal_answers),
        cmocka_unit_test(names_are_those_of_the_schema),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
