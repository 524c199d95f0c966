/* The oscillator: gates with exact answers, the batched integrator against CVODE, branches, and equal bits.
 *
 * The comparison with CVODE takes a share of the speeds; with QG_LONG_TESTS set (make check-long) it takes all of them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics.h"
#include "core/dynamics_batch.h"
#include "core/pool.h"
#include "tests/core/oscillators.h"

static struct qg_speed_map static_start(double min, double max, size_t count) {
    return (struct qg_speed_map){.min = min, .max = max, .count = count, .branch = QG_BRANCH_FIXED, .start_static = 1};
}

static void respond(const struct qg_oscillator *oscillator, const struct qg_speed_map *map, struct qg_response *out) {
    for (size_t piece = 0; piece < qg_response_pieces(map); piece++)
        qg_response_piece(oscillator, map, piece, out);
}

static struct qg_response respond_at(const struct qg_oscillator *oscillator, double frequency_ratio) {
    struct qg_speed_map map = static_start(frequency_ratio, frequency_ratio, 1);
    struct qg_response out;
    respond(oscillator, &map, &out);
    return out;
}

/* --- series and speeds --- */

static void turn_agrees_with_libm(void **state) {
    (void)state;
    for (int i = -3000; i <= 3000; i++) {
        double phase = i / 977.0, c, s;
        qg_turn(phase, &c, &s);
        assert_true(fabs(c - cos(2.0 * QG_PI * phase)) < 4e-15);
        assert_true(fabs(s - sin(2.0 * QG_PI * phase)) < 4e-15);
    }
    double c, s;
    qg_turn(0.25, &c, &s);
    assert_true(c == 0.0 && s == 1.0);
    qg_turn(0.5, &c, &s);
    assert_true(c == -1.0 && s == 0.0);
}

static void fourier_series_comes_back_from_its_samples(void **state) {
    (void)state;
    struct qg_fourier series = {.harmonics = 6, .mean = 1.25}, back;
    for (int j = 0; j < 6; j++) {
        series.cosine[j] = 0.1 / (j + 1);
        series.sine[j] = 0.03 * (j - 2);
    }
    double samples[SAMPLES];
    for (int i = 0; i < SAMPLES; i++)
        samples[i] = qg_fourier_at(&series, (double)i / SAMPLES);
    qg_fourier_from_samples(&back, samples, SAMPLES, 6);
    assert_true(fabs(back.mean - series.mean) < 1e-15);
    for (int j = 0; j < 6; j++) {
        assert_true(fabs(back.cosine[j] - series.cosine[j]) < 1e-15);
        assert_true(fabs(back.sine[j] - series.sine[j]) < 1e-15);
    }
    struct qg_fourier one = {.harmonics = 1, .mean = 2.0, .cosine = {3.0}, .sine = {5.0}};
    assert_true(fabs(qg_fourier_at(&one, 1.0 / 3) - (2.0 - 1.5 + 5.0 * sqrt(0.75))) < 1e-14);
}

static void static_equilibrium_balances_the_load(void **state) {
    (void)state;
    struct qg_oscillator s = case_s(1, 0);
    s.error = (struct qg_fourier){.harmonics = 1, .mean = 0.02, .cosine = {0.05}};
    double x = qg_static_displacement(&s);
    double force = qg_fourier_at(&s.stiffness, 0.0) * (x - qg_fourier_at(&s.error, 0.0) - 1.0);
    assert_true(fabs(force - s.load) < 1e-15);
}

static void speeds_are_equidistant(void **state) {
    (void)state;
    struct qg_speed_map map = static_start(0.2, 1.4, 7);
    for (size_t i = 0; i < 7; i++)
        assert_true(fabs(qg_speed_at(&map, i) - (0.2 + 0.2 * (double)i)) < 1e-15);
    map.count = 1;
    assert_true(qg_speed_at(&map, 0) == 0.2);
    assert_int_equal(qg_response_pieces(&map), 1);
    map.count = 1000;
    assert_int_equal(qg_response_pieces(&map), 125);
    map.branch = QG_BRANCH_RUN_DOWN;
    assert_int_equal(qg_response_pieces(&map), 1);
}

/* --- exact answers --- */

/* x'' + 2 zeta x' + x - 1 - e = load with e = E cos(p tau): damping acts on x', so e drives like a force. */
static void linear_response_is_the_textbook_one(void **state) {
    (void)state;
    struct qg_oscillator o = plain_oscillator(0.03, 1.0);
    o.error = (struct qg_fourier){.harmonics = 2, .cosine = {0.01, 0.0}, .sine = {0.0, 0.0}};
    struct qg_speed_map map = static_start(0.2, 1.4, 121);
    struct qg_response out[121];
    respond(&o, &map, out);
    for (size_t i = 0; i < map.count; i++) {
        double p = qg_speed_at(&map, i);
        double amplitude = 0.01 / sqrt((1.0 - p * p) * (1.0 - p * p) + 4.0 * 0.03 * 0.03 * p * p);
        assert_int_equal(out[i].period, 1);
        assert_true(fabs(out[i].rms / (amplitude / sqrt(2.0)) - 1.0) < 1e-8);
        assert_true(fabs(out[i].mean - 2.0) < 1e-9);
    }
}

/* Free oscillation in contact with constant stiffness, against its closed form. */
static void constant_stiffness_follows_the_exact_flow(void **state) {
    (void)state;
    const double zeta = 0.05, load = 2.0, ratio = 0.37, omega = sqrt(1.0 - zeta * zeta);
    struct qg_oscillator o = plain_oscillator(zeta, load);
    const double x0 = 3.4, v0 = -0.3, time = 3.0 * 2.0 * QG_PI / ratio;
    double end[2] = {x0, v0}, a = x0 - 1.0 - load, b = (v0 + zeta * a) / omega, decay = exp(-zeta * time);
    double c = cos(omega * time), s = sin(omega * time);
    qg_batch_march(&o, ratio, 3, end, NULL);
    assert_true(fabs(end[0] - (1.0 + load + decay * (a * c + b * s))) < 1e-10);
    assert_true(fabs(end[1] - decay * ((b * omega - zeta * a) * c - (a * omega + zeta * b) * s)) < 1e-10);
}

static void free_flight_follows_its_closed_form(void **state) {
    (void)state;
    const double zeta = 0.2, load = 0.1, ratio = 3.0, time = 2.0 * QG_PI / ratio;
    struct qg_oscillator o = plain_oscillator(zeta, load);
    o.error = (struct qg_fourier){.harmonics = 1, .cosine = {0.02}}; /* is nowhere met */
    const double x0 = -0.8, v0 = 0.4, limit = load / (2.0 * zeta), decay = exp(-2.0 * zeta * time);
    double end[2] = {x0, v0};
    qg_batch_march(&o, ratio, 1, end, NULL);
    assert_true(fabs(end[1] - (limit + (v0 - limit) * decay)) < 1e-13);
    assert_true(fabs(end[0] - (x0 + limit * time + (v0 - limit) * (1.0 - decay) / (2.0 * zeta))) < 1e-13);
}

/* Elastic energy of both flanks, kinetic energy, and that of the load. */
static double energy(const double z[2], double load) {
    double stretch = fmax(fabs(z[0]) - 1.0, 0.0);
    return 0.5 * z[1] * z[1] + 0.5 * stretch * stretch - load * z[0];
}

/* Nearly without damping, between both flanks, over 40 mesh periods and some hundred edges. */
static void energy_is_kept_across_the_dead_zone(void **state) {
    (void)state;
    const double ratios[] = {0.3, 0.7, 1.1};
    for (int i = 0; i < 3; i++) {
        struct qg_oscillator o = plain_oscillator(1e-13, 0.1);
        double z[2] = {2.5 + 0.2 * i, 0.1}, before = energy(z, o.load);
        qg_batch_march(&o, ratios[i], 40, z, NULL);
        assert_true(fabs(energy(z, o.load) - before) < 1e-8);
    }
}

/* Largest modulus of the multipliers of x'' + 2 zeta x' + (1 + 0.1 cos Omega tau) x = const. */
static double mathieu_growth(double omega) {
    struct qg_oscillator o = plain_oscillator(0.01, 5.0);
    o.stiffness.harmonics = 1;
    o.stiffness.cosine[0] = 0.1;
    double z[2] = {qg_static_displacement(&o), 0.0}, m[4];
    qg_batch_march(&o, omega, 1, z, m);
    double half = 0.5 * (m[0] + m[3]), determinant = m[0] * m[3] - m[1] * m[2];
    double discriminant = half * half - determinant;
    return discriminant > 0.0 ? fabs(half) + sqrt(discriminant) : sqrt(determinant);
}

static double stability_limit(double stable, double unstable) {
    for (int i = 0; i < 50; i++) {
        double middle = 0.5 * (stable + unstable);
        if (mathieu_growth(middle) > 1.0)
            unstable = middle;
        else
            stable = middle;
    }
    return stable;
}

static void mathieu_tongue_has_its_known_edges(void **state) {
    (void)state;
    assert_true(fabs(stability_limit(1.9, 2.0) - 1.95377) < 1e-5);
    assert_true(fabs(stability_limit(2.1, 2.0) - 2.04541) < 1e-5);
}

/* Within the tongue the motion grows until the dead zone bends it into period two; outside it decays. */
static void parametric_resonance_ends_in_period_two(void **state) {
    (void)state;
    struct qg_oscillator o = plain_oscillator(0.01, 0.2);
    o.stiffness.harmonics = 1;
    o.stiffness.cosine[0] = 0.1;
    struct qg_response inside = respond_at(&o, 1.97), outside = respond_at(&o, 2.10), reference;
    assert_int_equal(outside.period, 1);
    assert_true(outside.rms < 0.01);
    assert_int_equal(inside.period, 2);
    assert_true(inside.rms > 0.1);
    double x = qg_static_displacement(&o);
    assert_int_equal(qg_response_reference(&o, 1.97, x, 0.0, 1e-9, &reference), QG_OK);
    assert_int_equal(reference.period, 2);
    assert_true(fabs(inside.rms / reference.rms - 1.0) < 1e-4);
}

/* Far outside of the dead zone its tongue is that of the linear equation, and there is no end. */
static void growth_without_bound_is_named(void **state) {
    (void)state;
    const double modulation[] = {0.08, 0.0506}; /* growth ends before the long window, and within it */
    for (int i = 0; i < 2; i++) {
        struct qg_oscillator o = plain_oscillator(0.01, 0.2);
        o.stiffness.harmonics = 1;
        o.stiffness.cosine[0] = modulation[i];
        struct qg_speed_map map = {.min = 2.0, .max = 2.0, .count = 1, .start_displacement = 1000.0};
        struct qg_response out;
        respond(&o, &map, &out);
        assert_int_equal(out.period, QG_PERIOD_UNBOUNDED);
        assert_true(out.rms > 1e5 && out.rms < 1e7);
    }
}

/* A backlash that is next to nothing makes displacements large in its unit. */
static void a_large_load_is_not_growth(void **state) {
    (void)state;
    struct qg_oscillator o = plain_oscillator(0.05, 1e8), one = plain_oscillator(0.05, 1e3);
    o.stiffness.harmonics = one.stiffness.harmonics = 1;
    o.stiffness.cosine[0] = one.stiffness.cosine[0] = 0.1;
    struct qg_speed_map map = static_start(0.3, 1.4, 23);
    struct qg_response large[23], small[23];
    respond(&o, &map, large);
    respond(&one, &map, small);
    for (size_t i = 0; i < map.count; i++) {
        assert_int_equal(large[i].period, 1);
        assert_true(fabs(large[i].rms / small[i].rms / 1e5 - 1.0) < 1e-6);
    }
}

/* --- tangent --- */

static void multipliers_obey_liouville_across_edges(void **state) {
    (void)state;
    for (int i = 0; i < 60; i++) {
        struct qg_oscillator o = case_s(i % 2, i % 3);
        double ratio = 0.2 + 0.02 * i, m[4], z[2] = {1.0 + 0.03 * i, 0.4 - 0.02 * i};
        qg_batch_march(&o, ratio, 3, z, m);
        double expected = exp(-2.0 * o.damping_ratio * 3.0 * 2.0 * QG_PI / ratio);
        assert_true(fabs((m[0] * m[3] - m[1] * m[2]) / expected - 1.0) < 2e-6);
    }
}

static void tangent_is_the_derivative_of_the_march(void **state) {
    (void)state;
    const double step = 1e-5;
    struct qg_oscillator o = case_s(1, 1);
    o.error = (struct qg_fourier){.harmonics = 1, .mean = 0.01, .sine = {0.03}};
    for (int i = 0; i < 20; i++) {
        double ratio = 0.3 + 0.05 * i, z0[2] = {1.2, 0.05 * i}, z[2], m[4];
        memcpy(z, z0, sizeof z);
        qg_batch_march(&o, ratio, 2, z, m);
        for (int column = 0; column < 2; column++) {
            double up[2] = {z0[0], z0[1]}, down[2] = {z0[0], z0[1]};
            up[column] += step;
            down[column] -= step;
            qg_batch_march(&o, ratio, 2, up, NULL);
            qg_batch_march(&o, ratio, 2, down, NULL);
            assert_true(fabs((up[0] - down[0]) / (2.0 * step) - m[column]) < 1e-4);
            assert_true(fabs((up[1] - down[1]) / (2.0 * step) - m[2 + column]) < 1e-4);
        }
    }
}

/* --- against CVODE --- */

/* How batch and reference compared over many speeds. */
struct comparison {
    int speeds, undecided, other_branch;
    double worst;
};

static void compare(struct comparison *c, const struct qg_oscillator *o, double ratio,
                    const struct qg_response *batch) {
    struct qg_response reference;
    double x = qg_static_displacement(o);
    assert_int_equal(qg_response_reference(o, ratio, x, 0.0, 1e-10, &reference), QG_OK);
    double error = fabs(batch->rms / reference.rms - 1.0);
    c->speeds++;
    if (error > 1e-4) {
        c->other_branch++;
        print_message("# p = %.6f: batch %.6f (period %d), CVODE %.6f (period %d)\n", ratio, batch->rms, batch->period,
                      reference.rms, reference.period);
        return;
    }
    c->worst = fmax(c->worst, error);
    c->undecided += batch->period != reference.period;
}

/* 60 speeds of all six oscillators of case S, or every sixth of them. A transient that ends within rounding of a basin
 * boundary could fall on different branches: at most 1 % may. Periods may differ where a multiplier is so near to 1
 * that the plain march of the reference has not settled in its time. */
static void batch_agrees_with_cvode(void **state) {
    (void)state;
    const bool all = getenv("QG_LONG_TESTS") != NULL;
    struct qg_speed_map map = static_start(0.2, 1.4, 60);
    struct comparison c = {0};
    for (int n = 0; n < RELIEFS * CASES; n++) {
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        struct qg_response out[60];
        respond(&o, &map, out);
        for (size_t i = all ? 0 : (size_t)n; i < map.count; i += all ? 1 : 6)
            compare(&c, &o, qg_speed_at(&map, i), &out[i]);
    }
    print_message("# %d speeds: largest difference of RMS %.1e, other branch %d, other period %d\n", c.speeds, c.worst,
                  c.other_branch, c.undecided);
    assert_int_equal(c.speeds, all ? 360 : 60);
    assert_true(c.worst < 1e-4);
    assert_true(c.other_branch * 100 <= c.speeds);
    assert_true(c.undecided * 50 <= c.speeds);
}

/* Both excitations at once, and so low a speed that the tables do not hold a whole mesh period. */
static void batch_agrees_with_cvode_on_other_oscillators(void **state) {
    (void)state;
    struct comparison c = {0};
    struct qg_oscillator o = case_s(1, 1);
    o.error =
        (struct qg_fourier){.harmonics = 3, .mean = 0.03, .cosine = {0.02, -0.01, 0.004}, .sine = {0.01, 0.005, 0.0}};
    const double ratios[] = {0.05, 0.31, 0.5, 0.93, 1.02};
    for (int i = 0; i < 5; i++) {
        struct qg_response batch = respond_at(&o, ratios[i]);
        compare(&c, &o, ratios[i], &batch);
    }
    o = case_s(0, 2);
    o.damping_ratio = 0.08;
    o.stiffness.harmonics = QG_HARMONICS_MAX;
    o.stiffness.sine[QG_HARMONICS_MAX - 1] = 0.01;
    struct qg_response batch = respond_at(&o, 0.3);
    compare(&c, &o, 0.3, &batch);
    assert_int_equal(c.other_branch, 0);
    assert_int_equal(c.undecided, 0);
    assert_true(c.worst < 1e-5);
}

/* --- branches --- */

/* Above p = 1.2 case S with the standard relief has a large period-two orbit at a third of the torque. */
static void coexisting_orbits_are_told_apart(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 0);
    struct qg_speed_map map = {
        .min = 1.25, .max = 1.25, .count = 1, .start_displacement = -2.0, .start_velocity = -2.0};
    struct qg_response large, reference, small = respond_at(&o, 1.25);
    respond(&o, &map, &large);
    assert_int_equal(small.period, 1);
    assert_int_equal(large.period, 2);
    assert_true(large.rms > 5.0 * small.rms);
    assert_int_equal(qg_response_reference(&o, 1.25, large.x, large.v, 1e-10, &reference), QG_OK);
    assert_int_equal(reference.period, 2);
    assert_true(fabs(large.rms / reference.rms - 1.0) < 1e-4);
}

static void run_up_and_run_down_differ_across_the_softening_jump(void **state) {
    (void)state;
    static struct qg_response up[SPEEDS], down[SPEEDS];
    struct qg_oscillator o = case_s(0, 2);
    struct qg_speed_map map = static_start(0.2, 1.4, SPEEDS);
    map.branch = QG_BRANCH_RUN_UP;
    respond(&o, &map, up);
    map.branch = QG_BRANCH_RUN_DOWN;
    respond(&o, &map, down);
    size_t different = 0, jumps[2] = {0, 0}, widest = 0;
    for (size_t i = 0; i < SPEEDS; i++) {
        different += fabs(up[i].rms - down[i].rms) > 1e-6;
        if (down[i].rms - up[i].rms > down[widest].rms - up[widest].rms)
            widest = i;
        if (i > 0) {
            jumps[0] += fabs(up[i].rms - up[i - 1].rms) > 0.05;
            jumps[1] += fabs(down[i].rms - down[i - 1].rms) > 0.05;
        }
    }
    assert_true(different > 50 && different < SPEEDS - 300);
    assert_true(jumps[0] >= 1 && jumps[1] >= 1);
    assert_true(down[widest].rms > up[widest].rms + 0.5);
    struct qg_response reference;
    double p = qg_speed_at(&map, widest);
    assert_int_equal(qg_response_reference(&o, p, down[widest].x, down[widest].v, 1e-10, &reference), QG_OK);
    assert_true(fabs(down[widest].rms / reference.rms - 1.0) < 1e-4);
}

/* Closed form and Newton steps must end where the plain march ends, at every speed at which that ends at all. */
static void shortcuts_stay_on_the_branch_of_the_march(void **state) {
    (void)state;
    static struct qg_response quick[SPEEDS], plain[SPEEDS];
    struct qg_speed_map map = static_start(0.2, 1.4, SPEEDS);
    struct qg_batch_options options = {.path = QG_PATH_BASELINE, .plain = true};
    size_t undecided = 0;
    for (int n = 0; n < RELIEFS * CASES; n += 5) { /* no relief at a third, standard relief at full torque */
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        respond(&o, &map, quick);
        for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
            qg_response_piece_with(&options, &o, &map, piece, plain);
        for (size_t i = 0; i < SPEEDS; i++) {
            undecided += plain[i].period == 0;
            assert_true(fabs(quick[i].rms / plain[i].rms - 1.0) < 2e-5);
            assert_true(plain[i].period == 0 || plain[i].period == quick[i].period);
        }
    }
    assert_true(undecided < 20);
}

/* Three times the variation of stiffness: nothing periodic everywhere, and no number that is not one. */
static void wild_motion_is_named(void **state) {
    (void)state;
    static struct qg_response out[SPEEDS];
    struct qg_oscillator o = case_s(1, 0);
    for (int j = 0; j < o.stiffness.harmonics; j++) {
        o.stiffness.cosine[j] *= 3.0;
        o.stiffness.sine[j] *= 3.0;
    }
    o.load *= 0.5;
    struct qg_speed_map map = {.min = 0.2, .max = 1.4, .count = SPEEDS, .start_displacement = 1.0};
    respond(&o, &map, out);
    size_t seen[QG_PERIOD_MAX + 1] = {0}, chaotic = 0;
    for (size_t i = 0; i < SPEEDS; i++) {
        assert_true(isfinite(out[i].rms) && isfinite(out[i].mean));
        chaotic += out[i].period == QG_PERIOD_CHAOTIC;
        seen[out[i].period > 0 ? out[i].period : 0]++;
    }
    print_message("# %zu speeds without a period up to %d, of which %zu chaotic\n", seen[0], QG_PERIOD_MAX, chaotic);
    assert_true(chaotic > 50 && chaotic < seen[0]);
    assert_true(seen[0] > 20 && seen[1] > 500 && seen[2] > 20 && seen[4] > 5);
}

/* Case S without relief at a third of the torque: a start that ends on an orbit of period nine, which is not chaos, and
 * one in the tongue of its second harmonic so far out that the dead zone holds nothing back. */
static void responses_without_a_period_are_told_apart(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(0, 0);
    const double ratio[2] = {11.0 / 13.0, 1.0};
    const struct qg_state start[2] = {{2.568921, 2.214308}, {100.0, 0.0}};
    struct qg_response out[2];
    qg_batch_settle(&o, 2, ratio, start, out);
    assert_int_equal(out[0].period, QG_PERIOD_LONG);
    double z[2] = {out[0].x, out[0].v};
    qg_batch_march(&o, ratio[0], 9000, z, NULL);
    double later[2] = {z[0], z[1]};
    qg_batch_march(&o, ratio[0], 9, later, NULL);
    assert_true(fabs(later[0] - z[0]) + fabs(later[1] - z[1]) < 1e-9);
    qg_batch_march(&o, ratio[0], 1, later, NULL);
    assert_true(fabs(later[0] - z[0]) + fabs(later[1] - z[1]) > 0.1);
    assert_int_equal(out[1].period, QG_PERIOD_UNBOUNDED);
    assert_true(isfinite(out[1].rms) && out[1].rms > 1e4);
}

/* --- equal bits --- */

static void every_path_gives_the_same_bits(void **state) {
    (void)state;
    static struct qg_response first[SPEEDS], other[SPEEDS];
    struct qg_oscillator o = case_s(1, 0);
    o.error = (struct qg_fourier){.harmonics = 2, .sine = {0.01, 0.005}};
    struct qg_speed_map map = {.min = 0.2, .max = 1.4, .count = SPEEDS, .start_displacement = 1.0};
    struct qg_batch_options options = {.path = QG_PATH_BASELINE};
    memset(first, 0, sizeof first);
    for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
        qg_response_piece_with(&options, &o, &map, piece, first);
    for (options.path = QG_PATH_BASELINE + 1; options.path < QG_PATH_COUNT; options.path++) {
        if (!qg_batch_path_available(options.path))
            continue;
        memset(other, 0, sizeof other);
        for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
            qg_response_piece_with(&options, &o, &map, piece, other);
        assert_memory_equal(first, other, sizeof first);
    }
}

struct task {
    const struct qg_oscillator *oscillator;
    const struct qg_speed_map *map;
    struct qg_response *out;
};

static void run_piece(void *context, size_t item, int worker) {
    (void)worker;
    const struct task *task = context;
    qg_response_piece(task->oscillator, task->map, item, task->out);
}

static void order_and_threads_do_not_matter(void **state) {
    (void)state;
    static struct qg_response forward[300], backward[300], pooled[300];
    memset(forward, 0, sizeof forward);
    memset(backward, 0, sizeof backward);
    memset(pooled, 0, sizeof pooled);
    struct qg_oscillator o = case_s(0, 2);
    struct qg_speed_map map = static_start(0.4, 1.1, 300);
    respond(&o, &map, forward);
    for (size_t piece = qg_response_pieces(&map); piece-- > 0;)
        qg_response_piece(&o, &map, piece, backward);
    assert_memory_equal(forward, backward, sizeof forward);
    struct qg_pool *pool = qg_pool_create(3);
    assert_non_null(pool);
    struct qg_executor executor = qg_pool_executor(pool);
    struct task task = {&o, &map, pooled};
    executor.run(executor.self, qg_response_pieces(&map), run_piece, &task);
    qg_pool_destroy(pool);
    assert_memory_equal(forward, pooled, sizeof forward);
}

/* The first lane of a block does not see what runs beside it. */
static void lanes_do_not_see_their_neighbours(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(1, 1);
    for (int i = 0; i < 40; i++) {
        double p = 0.25 + 0.03 * i;
        struct qg_speed_map map = static_start(p, 1.5 * p, QG_LANES);
        struct qg_response block[QG_LANES], alone = respond_at(&o, p);
        respond(&o, &map, block);
        assert_true(alone.rms == block[0].rms && alone.mean == block[0].mean && alone.period == block[0].period);
        assert_true(alone.x == block[0].x && alone.v == block[0].v);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turn_agrees_with_libm),
        cmocka_unit_test(fourier_series_comes_back_from_its_samples),
        cmocka_unit_test(static_equilibrium_balances_the_load),
        cmocka_unit_test(speeds_are_equidistant),
        cmocka_unit_test(linear_response_is_the_textbook_one),
        cmocka_unit_test(constant_stiffness_follows_the_exact_flow),
        cmocka_unit_test(free_flight_follows_its_closed_form),
        cmocka_unit_test(energy_is_kept_across_the_dead_zone),
        cmocka_unit_test(mathieu_tongue_has_its_known_edges),
        cmocka_unit_test(parametric_resonance_ends_in_period_two),
        cmocka_unit_test(growth_without_bound_is_named),
        cmocka_unit_test(a_large_load_is_not_growth),
        cmocka_unit_test(multipliers_obey_liouville_across_edges),
        cmocka_unit_test(tangent_is_the_derivative_of_the_march),
        cmocka_unit_test(batch_agrees_with_cvode),
        cmocka_unit_test(batch_agrees_with_cvode_on_other_oscillators),
        cmocka_unit_test(coexisting_orbits_are_told_apart),
        cmocka_unit_test(run_up_and_run_down_differ_across_the_softening_jump),
        cmocka_unit_test(shortcuts_stay_on_the_branch_of_the_march),
        cmocka_unit_test(wild_motion_is_named),
        cmocka_unit_test(responses_without_a_period_are_told_apart),
        cmocka_unit_test(every_path_gives_the_same_bits),
        cmocka_unit_test(order_and_threads_do_not_matter),
        cmocka_unit_test(lanes_do_not_see_their_neighbours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
