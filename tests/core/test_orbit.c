/* Periodic orbits by shooting: exact answers, Liouville on every orbit, periods and stability.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "core/orbit.h"
#include "core/random.h"
#include "tests/core/oscillators.h"

static bool shoot(const struct qg_oscillator *o, int period, double ratio, struct qg_state guess,
                  struct qg_orbit *orbit) {
    bool found;
    orbit->frequency_ratio = ratio;
    orbit->state[0] = guess;
    qg_orbit_shoot(o, period, 1, orbit, &found);
    return found;
}

/* The product of the multipliers, which is real. */
static double product(const struct qg_floquet *f) {
    return f->real[0] * f->real[1] - f->imaginary[0] * f->imaginary[1];
}

static void assert_liouville(const struct qg_oscillator *o, const struct qg_orbit *orbit) {
    double expected = exp(-4.0 * QG_PI * o->damping_ratio * orbit->period / orbit->frequency_ratio);
    double largest = fmax(fabs(orbit->floquet.real[0]), 1.0);
    /* of a strongly unstable orbit the smaller multiplier is a difference of large numbers */
    assert_true(fabs(product(&orbit->floquet) / expected - 1.0) < 3e-6 * largest * largest);
    if (orbit->floquet.imaginary[0] != 0.0) /* no Neimark-Sacker: a complex pair is always inside the unit circle */
        assert_true(hypot(orbit->floquet.real[0], orbit->floquet.imaginary[0]) < 1.0);
}

/* --- multipliers --- */

static void multipliers_are_the_eigenvalues(void **state) {
    (void)state;
    struct qg_floquet f = qg_floquet_of((double[4]){3.0, 1.0, 0.0, 0.5});
    assert_true(f.real[0] == 3.0 && fabs(f.real[1] - 0.5) < 1e-15 && f.imaginary[0] == 0.0 && !f.stable);
    f = qg_floquet_of((double[4]){-0.25, 0.0, 2.0, -0.5});
    assert_true(fabs(f.real[0] + 0.5) < 1e-15 && fabs(f.real[1] + 0.25) < 1e-15 && f.stable);
    f = qg_floquet_of((double[4]){0.3, -0.4, 0.4, 0.3});
    assert_true(fabs(f.real[0] - 0.3) < 1e-15 && fabs(f.imaginary[0] - 0.4) < 1e-15 &&
                f.imaginary[1] == -f.imaginary[0]);
    assert_true(f.stable);
    f = qg_floquet_of((double[4]){0.0, 1.0, 0.9, 0.0}); /* +-sqrt(0.9) */
    assert_true(fabs(fabs(f.real[0]) - sqrt(0.9)) < 1e-15 && fabs(f.real[0] + f.real[1]) < 1e-15 && f.stable);
    assert_false(qg_floquet_of((double[4]){-1.01, 0.0, 0.0, -0.5}).stable);
}

/* --- exact answers --- */

/* Constant stiffness, driven through e = E cos(p tau): one shot, from any guess on the drive flank, must do. */
static void linear_response_is_the_textbook_one(void **state) {
    (void)state;
    const double zeta = 0.03, amplitude = 0.01;
    struct qg_oscillator o = plain_oscillator(zeta, 1.0);
    o.error = (struct qg_fourier){.harmonics = 1, .cosine = {amplitude}};
    for (double p = 0.2; p < 1.41; p += 0.1) {
        struct qg_orbit orbit;
        assert_true(shoot(&o, 1, p, (struct qg_state){2.1, 0.05}, &orbit));
        double real = 1.0 - p * p, imaginary = 2.0 * zeta * p, square = real * real + imaginary * imaginary;
        assert_true(fabs(orbit.rms / (amplitude / sqrt(2.0 * square)) - 1.0) < 1e-8);
        assert_true(fabs(orbit.state[0].x - (2.0 + amplitude * real / square)) < 1e-9);
        assert_true(fabs(orbit.state[0].v - amplitude * p * imaginary / square) < 1e-9);
        assert_int_equal(orbit.drive_crossings + orbit.back_crossings, 0);
        assert_true(orbit.floquet.stable);
        /* the multipliers of constant stiffness: exp((-zeta +- i sqrt(1 - zeta^2)) T) */
        double decay = exp(-zeta * 2.0 * QG_PI / p), turn = sqrt(1.0 - zeta * zeta) * 2.0 * QG_PI / p;
        assert_true(fabs(orbit.floquet.real[0] - decay * cos(turn)) < 1e-8);
        assert_true(fabs(orbit.floquet.imaginary[0] - decay * fabs(sin(turn))) < 1e-8);
        assert_liouville(&o, &orbit);
    }
}

/* x'' + 2 zeta x' + (1 + 0.1 cos Omega tau) x = const: the limits of stability are those of the orbit that stays in
 * contact, where a multiplier passes -1. */
static double multiplier_at(double omega) {
    struct qg_oscillator o = plain_oscillator(0.01, 5.0);
    o.stiffness.harmonics = 1;
    o.stiffness.cosine[0] = 0.1;
    struct qg_orbit orbit;
    assert_true(shoot(&o, 1, omega, (struct qg_state){qg_static_displacement(&o), 0.0}, &orbit));
    assert_int_equal(orbit.drive_crossings, 0);
    assert_liouville(&o, &orbit);
    return orbit.floquet.imaginary[0] == 0.0 ? orbit.floquet.real[0] : 0.0;
}

static double limit(double stable, double unstable) {
    for (int i = 0; i < 40; i++) {
        double middle = 0.5 * (stable + unstable);
        if (multiplier_at(middle) < -1.0)
            unstable = middle;
        else
            stable = middle;
    }
    return stable;
}

static void mathieu_tongue_has_its_known_edges(void **state) {
    (void)state;
    assert_true(multiplier_at(2.0) < -1.0);
    assert_true(fabs(limit(1.9, 2.0) - 1.95377) < 1e-5);
    assert_true(fabs(limit(2.1, 2.0) - 2.04541) < 1e-5);
}

/* Free flight between the flanks under the load, v' = load - 2 zeta v, is met by a shot of whole periods: the tangent
 * of the free flow is known in closed form. */
static void free_flight_has_the_tangent_of_its_closed_form(void **state) {
    (void)state;
    const double zeta = 0.2, ratio = 3.0, time = 2.0 * QG_PI / ratio, decay = exp(-2.0 * zeta * time);
    struct qg_oscillator o = plain_oscillator(zeta, 0.1);
    struct qg_shot shot = {.frequency_ratio = ratio, .start = {-0.8, 0.4}};
    qg_batch_shoot(&o, 1, 1, &shot);
    const double expected[4] = {1.0, (1.0 - decay) / (2.0 * zeta), 0.0, decay};
    for (int i = 0; i < 4; i++)
        assert_true(fabs(shot.tangent[i] - expected[i]) < 1e-13);
    assert_int_equal(shot.drive_crossings + shot.back_crossings, 0);
    assert_true(fabs(shot.visited[0].x - shot.end.x) + fabs(shot.visited[0].v - shot.end.v) == 0.0);
}

/* --- orbits of case S --- */

/* What marching finds, shooting confirms: the same orbit, the same period, stable, Liouville. */
static void marched_orbits_are_roots_of_the_poincare_map(void **state) {
    (void)state;
    size_t seen[QG_PERIOD_MAX + 1] = {0};
    for (int n = 0; n < RELIEFS * CASES; n++) {
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        for (size_t i = 0; i < 24; i++) {
            double ratio[QG_LANES];
            struct qg_state start[QG_LANES];
            struct qg_response out[QG_LANES];
            for (size_t k = 0; k < QG_LANES; k++) {
                ratio[k] = 0.2 + 0.05 * (double)i + 0.003 * (double)k;
                start[k].x = 6.0 * qg_random_uniform(7, QG_STREAM_TESTS, 100 * i + k, 0) - 3.0;
                start[k].v = 6.0 * qg_random_uniform(7, QG_STREAM_TESTS, 100 * i + k, 1) - 3.0;
            }
            qg_batch_settle(&o, QG_LANES, ratio, start, out);
            for (size_t k = 0; k < QG_LANES; k++) {
                struct qg_orbit orbit;
                if (out[k].period < 1)
                    continue;
                assert_true(shoot(&o, out[k].period, ratio[k], (struct qg_state){out[k].x, out[k].v}, &orbit));
                assert_int_equal(orbit.period, out[k].period);
                assert_true(orbit.floquet.stable);
                assert_true(fabs(orbit.rms / out[k].rms - 1.0) < 2e-5);
                assert_liouville(&o, &orbit);
                seen[orbit.period]++;
            }
        }
    }
    assert_true(seen[1] > 500 && seen[2] > 50 && seen[3] > 10);
}

/* Newton's method asked for a multiple of the period answers with the smallest. */
static void the_smallest_period_is_found(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    struct qg_orbit one, many;
    assert_true(shoot(&o, 1, 1.25, (struct qg_state){qg_static_displacement(&o), 0.0}, &one));
    for (int period = 2; period <= QG_PERIOD_MAX; period++) {
        assert_true(shoot(&o, period, 1.25, one.state[0], &many));
        assert_int_equal(many.period, 1);
        assert_true(fabs(many.floquet.real[0] - one.floquet.real[0]) < 1e-7);
    }
}

/* A period-two orbit met at its second mesh period is the same orbit. */
static void orbits_shifted_by_a_mesh_period_are_the_same(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    double ratio = 1.25;
    struct qg_state start = {-2.0, -2.0};
    struct qg_response large;
    qg_batch_settle(&o, 1, &ratio, &start, &large);
    assert_int_equal(large.period, 2);
    struct qg_orbit a, b, small;
    assert_true(shoot(&o, 2, ratio, (struct qg_state){large.x, large.v}, &a));
    assert_true(shoot(&o, 2, ratio, a.state[1], &b));
    assert_true(fabs(a.state[0].x - b.state[0].x) > 0.1);
    assert_true(qg_orbit_same(&a, &b, 1e-8));
    assert_true(shoot(&o, 1, ratio, (struct qg_state){qg_static_displacement(&o), 0.0}, &small));
    assert_false(qg_orbit_same(&a, &small, 1e-3));
    assert_true(a.drive_crossings >= 2);
}

/* Lanes do not see each other, and a guess that leads nowhere says so. */
static void guesses_side_by_side_do_not_mix(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    struct qg_orbit together[QG_LANES], alone;
    bool found[QG_LANES];
    for (size_t i = 0; i < QG_LANES; i++) {
        together[i].frequency_ratio = 0.9;
        together[i].state[0] = (struct qg_state){1.1 + 0.02 * (double)i, 0.0};
    }
    together[3].state[0] = (struct qg_state){1e9, 1e9};
    qg_orbit_shoot(&o, 1, QG_LANES, together, found);
    assert_false(found[3] && fabs(together[3].state[0].x) > 1e3);
    for (size_t i = 0; i < QG_LANES; i++) {
        if (i == 3)
            continue;
        assert_int_equal(shoot(&o, 1, 0.9, (struct qg_state){1.1 + 0.02 * (double)i, 0.0}, &alone), found[i]);
        if (found[i])
            assert_memory_equal(&alone.state[0], &together[i].state[0], sizeof alone.state[0]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(multipliers_are_the_eigenvalues),
        cmocka_unit_test(linear_response_is_the_textbook_one),
        cmocka_unit_test(mathieu_tongue_has_its_known_edges),
        cmocka_unit_test(free_flight_has_the_tangent_of_its_closed_form),
        cmocka_unit_test(marched_orbits_are_roots_of_the_poincare_map),
        cmocka_unit_test(the_smallest_period_is_found),
        cmocka_unit_test(orbits_shifted_by_a_mesh_period_are_the_same),
        cmocka_unit_test(guesses_side_by_side_do_not_mix),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
