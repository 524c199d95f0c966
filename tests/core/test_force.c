/* The force that depends on amplitude: the function itself, from the contact of real gears; the back flanks against
 * teeth laid beside each other; the march under it against the linear kernel, CVODE, Liouville and itself.
 */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/dynamics_batch.h"
#include "core/executor.h"
#include "core/force.h"
#include "core/pool.h"
#include "core/statics.h"

enum { POSITIONS = 14, HARMONICS = 6, CASES = 3 };

/* Case S with the standard relief, at 14 positions, made once for all tests. */
static struct {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_relief relief;
    struct qg_statics statics;
    struct qg_statics_workspace workspace;
    double torque_load[CASES]; /* N, at 0.33, 0.66 and 1 of the torque */
    size_t levels;
    double load[QG_FORCE_LEVELS_MAX], *approach; /* N, mm */
    struct qg_force *force;                      /* half-backlashes, N */
} made = {.pair = CASE_S, .relief = CASE_S_STANDARD};

static struct qg_compliance compliance_of(int gear) {
    const struct qg_gear *g = &made.pair.gears[gear];
    const struct qg_compliance_plan plan = {{206000, 0.3, g->face_width, 0},
                                            gear == QG_PINION ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED,
                                            g->teeth,
                                            6,
                                            .stop = {0}};
    struct qg_sector_mesh mesh;
    struct qg_compliance c;
    assert_int_equal(qg_sector_mesh_init(&mesh, &made.pair.rack, g, &made.geometry.gears[gear], 1, NULL), QG_OK);
    assert_int_equal(qg_compliance_init(&c, &mesh, &plan), QG_OK);
    qg_sector_mesh_finish(&mesh);
    return c;
}

static int make_statics(void **state) {
    (void)state;
    const double fraction[CASES] = {0.33, 0.66, 1};
    assert_int_equal(qg_pair_derive(&made.pair, &made.geometry, NULL), QG_OK);
    for (int k = 0; k < CASES; k++)
        made.torque_load[k] = fraction[k] * made.pair.nominal_torque / made.geometry.gears[QG_PINION].base_radius;
    struct qg_compliance compliance[2] = {compliance_of(QG_PINION), compliance_of(QG_GEAR)};
    const struct qg_means means = {.executor = qg_serial_executor};
    assert_int_equal(qg_statics_init(&made.statics, &made.pair, &made.geometry, compliance, POSITIONS,
                                     QG_FORCE_REACH * made.torque_load[CASES - 1], &means),
                     QG_OK);
    for (int g = 0; g < 2; g++)
        qg_compliance_finish(&compliance[g]);
    assert_int_equal(qg_statics_workspace_init(&made.workspace, &made.statics), QG_OK);
    return 0;
}

static double half_backlash(void) {
    return made.geometry.backlash / 2;
}

/* A force from approaches in mm. */
static struct qg_force *force_of(size_t levels, const double *load, const double *approach) {
    double scaled[QG_FORCE_LEVELS_MAX * POSITIONS];
    for (size_t i = 0; i < levels * POSITIONS; i++)
        scaled[i] = approach[i] / half_backlash();
    const struct qg_force_samples samples = {.positions = POSITIONS,
                                             .harmonics = HARMONICS,
                                             .levels = levels,
                                             .load = load,
                                             .approach = scaled,
                                             .mirror = qg_back_flank_phase(&made.pair, &made.geometry),
                                             .steps = qg_force_steps(0.2, HARMONICS)};
    struct qg_force *force;
    assert_int_equal(qg_force_create(&samples, &force), QG_OK);
    return force;
}

static int make_all(void **state) {
    make_statics(state);
    made.levels = qg_force_ladder(made.torque_load, CASES, made.load);
    made.approach = malloc(made.levels * POSITIONS * sizeof *made.approach);
    assert_non_null(made.approach);
    assert_int_equal(
        qg_statics_ladder(&made.statics, &made.workspace, &made.relief, made.levels, made.load, made.approach), QG_OK);
    made.force = force_of(made.levels, made.load, made.approach);
    return 0;
}

static int finish_all(void **state) {
    (void)state;
    qg_force_destroy(made.force);
    free(made.approach);
    qg_statics_workspace_finish(&made.workspace);
    qg_statics_finish(&made.statics);
    return 0;
}

static size_t rung_of(double load) {
    size_t j = 0;
    while (made.load[j] < load)
        j++;
    assert_true(made.load[j] == load);
    return j;
}

/* ---- ladder ----------------------------------------------------------------------------------------------------- */

static void ladder_holds_all_loads_in_small_ratios(void **state) {
    (void)state;
    struct dice dice = {1};
    for (int n = 0; n < 200; n++) {
        double loads[16], ladder[QG_FORCE_LEVELS_MAX], least = HUGE_VAL, most = 0;
        size_t count = (size_t)dice_integer(&dice, 1, 16);
        for (size_t k = 0; k < count; k++) {
            loads[k] = exp(dice_between(&dice, log(100), log(20000)));
            least = fmin(least, loads[k]);
            most = fmax(most, loads[k]);
        }
        size_t levels = qg_force_ladder(loads, count, ladder), found = 0;
        assert_true(levels <= QG_FORCE_LEVELS_MAX && ladder[0] == 0);
        assert_near_share(ladder[1], 0.05 * least, 1e-15);
        assert_near_share(ladder[levels - 1], QG_FORCE_REACH * most, 1e-15);
        for (size_t j = 2; j < levels; j++)
            assert_true(ladder[j] > ladder[j - 1] && ladder[j] <= 1.3 * 1.25 * ladder[j - 1]);
        for (size_t k = 0; k < count; k++)
            for (size_t j = 0; j < levels; j++)
                found += ladder[j] == loads[k];
        assert_int_equal(found, count);
    }
    const double far[2] = {1e-3, 1e9};
    double ladder[QG_FORCE_LEVELS_MAX];
    assert_true(qg_force_ladder(far, 2, ladder) <= QG_FORCE_LEVELS_MAX);
}

/* ---- the function ----------------------------------------------------------------------------------------------- */

static void force_is_zero_below_the_unloaded_error_and_grows_above(void **state) {
    (void)state;
    assert_int_equal(made.force->damped, 0);
    for (int i = 0; i < 97; i++) {
        double phase = i / 97.0, before = 0;
        for (int flank = 0; flank < QG_FLANK_COUNT; flank++) {
            struct qg_force_section s;
            qg_force_section_init(&s, made.force, (enum qg_flank)flank, phase);
            double edge = qg_fourier_at(&made.force->approach[flank][0], phase), slope = -1;
            assert_near(s.approach[0], edge, 1e-14);
            assert_true(qg_force_section_at(&s, made.levels, edge - 1e-9, false, &slope) == 0 && slope == 0);
            assert_true(qg_force_section_at(&s, made.levels, edge - 5, false, NULL) == 0);
            before = 0;
            for (double d = edge + 1e-4; d < 1.3 * s.approach[made.levels - 1]; d += 1e-4) {
                double f = qg_force_section_at(&s, made.levels, d, false, &slope);
                assert_true(f > before && slope > 0);
                before = f;
            }
            assert_true(before > made.load[made.levels - 1]);
        }
    }
}

static void slope_is_the_derivative_and_has_no_jumps(void **state) {
    (void)state;
    for (int i = 0; i < 41; i++) {
        struct qg_force_section s;
        qg_force_section_init(&s, made.force, QG_FLANK_DRIVE, i / 41.0);
        for (size_t j = 1; j < made.levels; j++) {
            double below, above, step = 1e-6, at = s.approach[j];
            double low = qg_force_section_at(&s, made.levels, at * (1 - 1e-12), false, &below);
            double high = qg_force_section_at(&s, made.levels, at * (1 + 1e-12), false, &above);
            assert_near_share(above, below, 1e-6);
            assert_near_share(high, low, 1e-6);
            at = 0.3 * s.approach[j] + 0.7 * s.approach[j - 1];
            double slope, f = qg_force_section_at(&s, made.levels, at, false, &slope);
            double difference = (qg_force_section_at(&s, made.levels, at + step, false, NULL) -
                                 qg_force_section_at(&s, made.levels, at - step, false, NULL)) /
                                (2 * step);
            assert_near_share(slope, difference, 1e-6);
            assert_near(qg_force_section_approach(&s, made.levels, f), at, 1e-12);
        }
        double top = s.approach[made.levels - 1], slope;
        qg_force_section_at(&s, made.levels, top + 0.1, false, &slope);
        assert_near(qg_force_section_approach(&s, made.levels, made.load[made.levels - 1] + 0.1 * slope), top + 0.1,
                    1e-12);
    }
}

/* At the ladder's loads the approach is the series of the static transmission error, and of the unloaded one at no
 * load: exactly, at any phase. */
static void static_limit_is_the_transmission_error_at_every_rung(void **state) {
    (void)state;
    for (size_t j = 0; j < made.levels; j++) {
        struct qg_fourier series;
        double sample[POSITIONS];
        for (int i = 0; i < POSITIONS; i++)
            sample[i] = made.approach[j * POSITIONS + (size_t)i] / half_backlash();
        qg_fourier_from_samples(&series, sample, POSITIONS, HARMONICS);
        for (int i = 0; i < 53; i++) {
            struct qg_force_section s;
            qg_force_section_init(&s, made.force, QG_FLANK_DRIVE, i / 53.0);
            double approach = qg_fourier_at(&series, i / 53.0);
            assert_near(s.approach[j], approach, 1e-13);
            if (j > 0)
                assert_near(qg_force_section_approach(&s, made.levels, made.load[j]), approach, 1e-12);
        }
    }
}

/* The largest difference from the approaches wanted at one load, in mm. */
static double difference_of_approaches(const struct qg_fourier *wanted, double load) {
    double worst = 0;
    for (int i = 0; i < 53; i++) {
        struct qg_force_section s;
        qg_force_section_init(&s, made.force, QG_FLANK_DRIVE, i / 53.0);
        double approach = qg_fourier_at(wanted, i / 53.0);
        worst = fmax(worst, fabs(qg_force_section_approach(&s, made.levels, load) - approach));
    }
    return worst * half_backlash();
}

/* Halfway between the rungs the contact is solved anew. The series of the transmission error are met within 0.1 um up
 * to the largest load case, and within 0.2 um up to the end of the ladder, where the approach is 140 um. */
static void static_limit_holds_between_the_rungs(void **state) {
    (void)state;
    double load[QG_FORCE_LEVELS_MAX] = {0}, approach[QG_FORCE_LEVELS_MAX * POSITIONS], worst[2] = {0};
    for (size_t j = 1; j < made.levels; j++)
        load[j] = j == 1 ? 0.5 * made.load[1] : sqrt(made.load[j - 1] * made.load[j]);
    assert_int_equal(qg_statics_ladder(&made.statics, &made.workspace, &made.relief, made.levels, load, approach),
                     QG_OK);
    struct qg_force *between = force_of(made.levels, load, approach);
    for (size_t j = 1; j < made.levels; j++) {
        int above = load[j] > made.torque_load[CASES - 1];
        worst[above] = fmax(worst[above], difference_of_approaches(&between->approach[QG_FLANK_DRIVE][j], load[j]));
    }
    qg_force_destroy(between);
    print_message("# between the rungs: within %.4f um up to the largest load, within %.4f um above\n", 1e3 * worst[0],
                  1e3 * worst[1]);
    assert_true(worst[0] < 0.1e-3);
    assert_true(worst[1] < 0.2e-3);
}

static void tangent_stiffness_is_the_slope_at_the_rung(void **state) {
    (void)state;
    for (int i = 0; i < 7; i++) {
        struct qg_force_section s;
        qg_force_section_init(&s, made.force, QG_FLANK_DRIVE, i / 7.0);
        for (int k = 0; k < CASES; k++) {
            double slope;
            size_t j = rung_of(made.torque_load[k]);
            qg_force_section_at(&s, made.levels, s.approach[j], false, &slope);
            assert_near_share(qg_force_tangent(made.load, s.approach, made.levels, j), slope, 1e-12);
        }
    }
}

/* Samples whose truncated series cross are pulled apart, and counted. */
static void rungs_that_would_cross_are_kept_apart(void **state) {
    (void)state;
    double approach[3 * POSITIONS], load[3] = {0, 1, 2};
    for (int i = 0; i < POSITIONS; i++) {
        approach[i] = i == 5 ? 0.0 : 0.1;
        approach[POSITIONS + i] = i == 5 ? 0.3 : 0.1001;
        approach[2 * POSITIONS + i] = approach[POSITIONS + i] + 0.1;
    }
    struct qg_force *force = force_of(3, load, approach);
    assert_int_equal(force->damped, 1);
    for (int i = 0; i < 500; i++) {
        struct qg_force_section s;
        qg_force_section_init(&s, force, QG_FLANK_DRIVE, i / 500.0);
        assert_true(s.approach[1] > s.approach[0] && s.approach[2] > s.approach[1]);
    }
    qg_force_destroy(force);
}

/* ---- back flanks ------------------------------------------------------------------------------------------------- */

/* How far round the gear's tooth is held by a pinion tooth at an angle: side +1 for the pinion's leading flank, which
 * the gear tooth ahead rests on, -1 for its trailing flank. The pinion turns counter-clockwise about the origin; angles
 * of the gear are taken clockwise from the direction of the pinion. The touching radius on the pinion is also found. */
struct touch {
    double gear_angle, pinion_radius;
};

static double gear_angle_at(const struct qg_gear_pair *p, const struct qg_pair_geometry *g, double angle, int side,
                            double radius) {
    double at = angle + side * qg_half_tooth_angle(&p->rack, &g->gears[QG_PINION], radius);
    double x = radius * cos(at), y = radius * sin(at), rho = hypot(p->center_distance - x, y);
    if (rho <= g->gears[QG_GEAR].base_radius)
        return -HUGE_VAL;
    return atan2(y, p->center_distance - x) + side * qg_half_tooth_angle(&p->rack, &g->gears[QG_GEAR], rho);
}

static struct touch touch_of(const struct qg_gear_pair *p, const struct qg_pair_geometry *g, double angle, int side) {
    double low = g->gears[QG_PINION].form_radius, high = p->gears[QG_PINION].outside_radius;
    double best = low, step = (high - low) / 400;
    for (double r = low; r <= high; r += step)
        if (side * gear_angle_at(p, g, angle, side, r) > side * gear_angle_at(p, g, angle, side, best))
            best = r;
    low = best - step, high = best + step;
    for (int i = 0; i < 100; i++) { /* golden section */
        double third = 0.381966011250105 * (high - low), a = low + third, b = high - third;
        if (side * gear_angle_at(p, g, angle, side, a) > side * gear_angle_at(p, g, angle, side, b))
            high = b;
        else
            low = a;
    }
    return (struct touch){gear_angle_at(p, g, angle, side, low), low};
}

/* The phase that a touching radius of the pinion belongs to. */
static double phase_of(const struct qg_pair_geometry *g, double radius) {
    double base = g->gears[QG_PINION].base_radius, xi = sqrt(radius * radius - base * base);
    double phase = 0.5 + (xi - 0.5 * (g->path_start + g->path_end)) / g->base_pitch;
    return phase - floor(phase);
}

static double to_whole(double a) {
    return fabs(a - nearbyint(a));
}

/* At both ends of the backlash the teeth are laid beside each other: the drive flanks at phase phi; then pinion and
 * gear are turned by their shares of the backlash, and the trailing flanks must touch, at the place that belongs to S -
 * phi. */
static void back_flanks_mirror_the_drive_flanks(void **state) {
    (void)state;
    struct dice dice = {7};
    int compared = 0;
    for (int n = 0; n < 20; n++) {
        struct qg_pair_geometry g;
        struct qg_gear_pair p = n < CASE_COUNT ? all_cases[n].pair : random_pair(&dice, &g);
        assert_int_equal(qg_pair_derive(&p, &g, NULL), QG_OK);
        double r1 = g.gears[QG_PINION].base_radius, r2 = g.gears[QG_GEAR].base_radius;
        double share = g.equivalent_mass * r1 * r1 / g.gears[QG_PINION].moment_of_inertia;
        double pitch1 = 2 * M_PI / p.gears[QG_PINION].teeth, pitch2 = 2 * M_PI / p.gears[QG_GEAR].teeth;
        double middle = hypot(r1, 0.5 * (g.path_start + g.path_end));
        double angle = 0;
        for (int i = 0; i < 40; i++) /* a tooth whose leading flank touches in the middle of the path */
            angle += (sqrt(middle * middle - r1 * r1) -
                      sqrt(fmax(0, pow(touch_of(&p, &g, angle, 1).pinion_radius, 2) - r1 * r1))) /
                     r1;
        angle += dice_between(&dice, -0.4, 0.4) * pitch1 * fmin(1, g.contact_ratio - 1);
        struct touch drive = touch_of(&p, &g, angle, 1);
        double phi = phase_of(&g, drive.pinion_radius);
        double fallen = angle - share * g.backlash / r1, gear = drive.gear_angle + (1 - share) * g.backlash / r2;
        for (int k = -2; k <= 2; k++) {
            struct touch back = touch_of(&p, &g, fallen + k * pitch1, -1);
            double xi = sqrt(back.pinion_radius * back.pinion_radius - r1 * r1);
            if (xi < g.path_start + 0.01 * g.base_pitch || xi > g.path_end - 0.01 * g.base_pitch)
                continue;
            assert_near(to_whole((back.gear_angle - gear) / pitch2), 0, 1e-6);
            assert_near(to_whole(qg_back_flank_phase(&p, &g) - phi - phase_of(&g, back.pinion_radius)), 0, 1e-5);
            compared++;
        }
    }
    assert_true(compared >= 20);
}

static void back_force_is_the_drive_force_at_the_mirrored_phase(void **state) {
    (void)state;
    double mirror = qg_back_flank_phase(&made.pair, &made.geometry);
    for (int i = 0; i < 61; i++) {
        struct qg_force_section drive, back;
        qg_force_section_init(&drive, made.force, QG_FLANK_DRIVE, mirror - i / 61.0);
        qg_force_section_init(&back, made.force, QG_FLANK_BACK, i / 61.0);
        for (size_t j = 0; j < made.levels; j++)
            assert_near(back.approach[j], drive.approach[j], 1e-13);
    }
}

/* ---- the march: a force that is exactly linear
 * -------------------------------------------------------------------- */

enum { FINE = 97 };

/* F = kappa(phi) (delta - e(phi)) on the drive flanks, with the dead zone of width 2 moved by e as dynamics.h has
 * it. */
static struct qg_force *linear_force(const struct qg_oscillator *o) {
    double load[2] = {0, 3}, approach[2 * FINE];
    for (int i = 0; i < FINE; i++) {
        approach[i] = qg_fourier_at(&o->error, (double)i / FINE);
        approach[FINE + i] = approach[i] + load[1] / qg_fourier_at(&o->stiffness, (double)i / FINE);
    }
    const struct qg_force_samples samples = {
        .positions = FINE, .harmonics = 32, .levels = 2, .load = load, .approach = approach, .steps = 2880};
    struct qg_force *force;
    assert_int_equal(qg_force_create(&samples, &force), QG_OK);
    struct qg_fourier back[2] = {force->approach[QG_FLANK_DRIVE][0], force->approach[QG_FLANK_DRIVE][1]};
    back[1].mean -= 2 * back[0].mean;
    back[0].mean = -back[0].mean;
    for (int j = 0; j < 32; j++) {
        back[1].cosine[j] -= 2 * back[0].cosine[j], back[1].sine[j] -= 2 * back[0].sine[j];
        back[0].cosine[j] = -back[0].cosine[j], back[0].sine[j] = -back[0].sine[j];
    }
    qg_force_set_back(force, back);
    return force;
}

/* Secant (e = 0) or consistent, of case S's size. */
static struct qg_oscillator linear_oscillator(bool consistent) {
    struct qg_oscillator o = {.damping_ratio = 0.01, .load = 0.12, .force_scale = 1};
    o.stiffness =
        (struct qg_fourier){.harmonics = 3, .mean = 1, .cosine = {-0.16, 0.03, 0.01}, .sine = {0.02, 0.03, -0.01}};
    if (consistent)
        o.error = (struct qg_fourier){.harmonics = 2, .mean = 0.03, .cosine = {0.02, 0.005}, .sine = {0.01, 0}};
    return o;
}

static struct qg_speed_map map_of(double min, double max, size_t count) {
    return (struct qg_speed_map){.min = min, .max = max, .count = count, .branch = QG_BRANCH_FIXED, .start_static = 1};
}

static void respond(const struct qg_oscillator *o, const struct qg_speed_map *map, struct qg_response *out) {
    for (size_t piece = 0; piece < qg_response_pieces(map); piece++)
        qg_response_piece(o, map, piece, out);
}

static void a_linear_force_gives_the_linear_response(void **state) {
    (void)state;
    enum { SPEEDS = 121 };
    for (int consistent = 0; consistent < 2; consistent++) {
        struct qg_oscillator exact = linear_oscillator(consistent), o = exact;
        struct qg_force *force = linear_force(&exact);
        o.force = force;
        struct qg_speed_map map = map_of(0.2, 1.4, SPEEDS);
        map.start_static = 0, map.start_displacement = 1;
        static struct qg_response wanted[SPEEDS], got[SPEEDS];
        respond(&exact, &map, wanted);
        respond(&o, &map, got);
        double worst = 0;
        int contact_lost = 0;
        for (int i = 0; i < SPEEDS; i++) {
            worst = fmax(worst, fabs(got[i].rms / wanted[i].rms - 1));
            contact_lost += wanted[i].rms > exact.load;
            assert_int_equal(got[i].period, wanted[i].period);
        }
        print_message("# %s: largest difference of RMS %.1e; contact lost at %d speeds\n",
                      consistent ? "consistent" : "secant", worst, contact_lost);
        assert_true(worst < 1e-6);
        assert_true(contact_lost > 10);
        qg_force_destroy(force);
    }
}

/* ---- the march: case S ------------------------------------------------------------------------------------------- */

/* The oscillator of a load case, made dimensionless as the model does it. */
static struct qg_oscillator case_s(int k) {
    double mean = 0, load = made.torque_load[k];
    for (int i = 0; i < POSITIONS; i++)
        mean += load / made.approach[rung_of(load) * POSITIONS + (size_t)i] / POSITIONS;
    return (struct qg_oscillator){.damping_ratio = 0.01,
                                  .load = load / (mean * half_backlash()),
                                  .force = made.force,
                                  .force_scale = 1 / (mean * half_backlash())};
}

static void static_displacement_balances_the_load(void **state) {
    (void)state;
    for (int k = 0; k < CASES; k++) {
        struct qg_oscillator o = case_s(k);
        double x = qg_static_displacement(&o),
               wanted = qg_fourier_at(&made.force->approach[QG_FLANK_DRIVE][rung_of(made.torque_load[k])], 0);
        assert_near(x, 1 + wanted, 1e-12);
    }
}

/* 7 speeds of each load from the static start. CVODE meets the knots between the pieces unwarned; where its noise there
 * keeps it from calling the response settled, its RMS over the long window stands. */
static void batch_agrees_with_cvode(void **state) {
    (void)state;
    enum { SPEEDS = 7 };
    double worst = 0;
    int other_period = 0;
    for (int k = 0; k < CASES; k++) {
        struct qg_oscillator o = case_s(k);
        struct qg_speed_map map = map_of(0.22 + 0.03 * k, 1.35, SPEEDS);
        struct qg_response out[SPEEDS], reference;
        double x = qg_static_displacement(&o);
        respond(&o, &map, out);
        for (size_t i = 0; i < SPEEDS; i++) {
            assert_int_equal(qg_response_reference(&o, qg_speed_at(&map, i), x, 0, 1e-9, &reference), QG_OK);
            worst = fmax(worst, fabs(out[i].rms / reference.rms - 1));
            other_period += reference.period != 0 && out[i].period != reference.period;
        }
    }
    print_message("# %d speeds: largest difference of RMS %.1e\n", CASES * SPEEDS, worst);
    assert_true(worst < 1e-4);
    assert_int_equal(other_period, 0);
}

/* The acceleration, from the sections of both flanks at a phase. */
struct pulls {
    struct qg_force_section flank[QG_FLANK_COUNT];
};

static double acceleration(const struct qg_oscillator *o, const struct pulls *at, double x, double v) {
    double drive = qg_force_section_at(&at->flank[QG_FLANK_DRIVE], o->force->levels, x - 1, false, NULL);
    double back = qg_force_section_at(&at->flank[QG_FLANK_BACK], o->force->levels, -x - 1, false, NULL);
    return o->load - 2 * o->damping_ratio * v - o->force_scale * (drive - back);
}

static void pulls_at(const struct qg_oscillator *o, struct pulls *at, double phase) {
    for (int flank = 0; flank < QG_FLANK_COUNT; flank++)
        qg_force_section_init(&at->flank[flank], o->force, (enum qg_flank)flank, phase);
}

/* One mesh period by the classical Runge-Kutta method in a great many steps. Answers how often a back flank was hit. */
static int small_steps(const struct qg_oscillator *o, double ratio, double z[2]) {
    enum { STEPS = 8000 };
    double h = 2 * M_PI / ratio / STEPS;
    int hits = 0;
    struct pulls begin, middle, end;
    pulls_at(o, &begin, 0);
    for (int k = 0; k < STEPS; k++, begin = end) {
        pulls_at(o, &middle, (k + 0.5) / STEPS);
        pulls_at(o, &end, (k + 1.0) / STEPS);
        double x = z[0], v = z[1], a1 = acceleration(o, &begin, x, v);
        double v2 = v + h / 2 * a1, a2 = acceleration(o, &middle, x + h / 2 * v, v2);
        double v3 = v + h / 2 * a2, a3 = acceleration(o, &middle, x + h / 2 * v2, v3);
        double v4 = v + h * a3, a4 = acceleration(o, &end, x + h * v3, v4);
        z[0] += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
        z[1] += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        hits += -x - 1 < begin.flank[QG_FLANK_BACK].approach[0] && -z[0] - 1 >= end.flank[QG_FLANK_BACK].approach[0];
    }
    return hits;
}

/* Violent motions of case S from many states, where both edges are met: state after a mesh period against small
 * steps. */
static void march_agrees_with_small_steps_through_both_edges(void **state) {
    (void)state;
    double worst = 0;
    int hits = 0;
    struct dice dice = {3};
    for (int i = 0; i < 30; i++) {
        struct qg_oscillator o = case_s(i % CASES);
        double ratio = dice_between(&dice, 0.4, 1.4), z[2], wanted[2];
        z[0] = wanted[0] = dice_between(&dice, -1.3, 1.5);
        z[1] = wanted[1] = dice_between(&dice, -1.5, 1.5);
        qg_batch_march(&o, ratio, 1, z, NULL);
        hits += small_steps(&o, ratio, wanted);
        worst = fmax(worst, hypot(z[0] - wanted[0], z[1] - wanted[1]));
    }
    print_message("# states after a mesh period: within %.1e; back flanks hit %d times\n", worst, hits);
    assert_true(hits >= 10);
    assert_true(worst < 1e-4);
}

/* Through both edges: the tangent against differences of the march, and Liouville's determinant. */
static void tangent_is_the_derivative_of_the_march(void **state) {
    (void)state;
    const double step = 1e-5;
    struct qg_oscillator o = case_s(1);
    int edges = 0;
    for (int i = 0; i < 24; i++) {
        double ratio = 0.3 + 0.05 * i, z0[2] = {i % 3 == 2 ? -1.15 : 1.2, 0.06 * (i % 12)}, z[2], m[4];
        memcpy(z, z0, sizeof z);
        qg_batch_march(&o, ratio, 2, z, m);
        edges += z[0] < 1 || z0[0] < 0;
        assert_near_share(m[0] * m[3] - m[1] * m[2], exp(-8 * M_PI * o.damping_ratio / ratio), 2e-4);
        for (int column = 0; column < 2; column++) {
            double up[2] = {z0[0], z0[1]}, down[2] = {z0[0], z0[1]};
            up[column] += step;
            down[column] -= step;
            qg_batch_march(&o, ratio, 2, up, NULL);
            qg_batch_march(&o, ratio, 2, down, NULL);
            assert_near((up[0] - down[0]) / (2 * step), m[column], 2e-3);
            assert_near((up[1] - down[1]) / (2 * step), m[2 + column], 2e-3);
        }
    }
    assert_true(edges > 8);
}

/* An orbit that leaves the ladder says so. */
static void orbits_beyond_the_ladder_are_named(void **state) {
    (void)state;
    struct qg_oscillator o = case_s(2);
    struct qg_speed_map map = map_of(0.3, 0.3, 1);
    struct qg_response out;
    respond(&o, &map, &out);
    assert_int_equal(out.beyond, 0);
    o.load *= 5;
    respond(&o, &map, &out);
    assert_int_equal(out.beyond, 1);
}

/* ---- equal bits -------------------------------------------------------------------------------------------------- */

enum { BIT_SPEEDS = 96 };

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

static void order_threads_and_paths_do_not_matter(void **state) {
    (void)state;
    static struct qg_response forward[BIT_SPEEDS], other[BIT_SPEEDS];
    struct qg_oscillator o = case_s(0);
    struct qg_speed_map map = map_of(0.4, 1.3, BIT_SPEEDS);
    map.start_static = 0, map.start_displacement = 1;
    respond(&o, &map, forward);
    for (size_t piece = qg_response_pieces(&map); piece-- > 0;)
        qg_response_piece(&o, &map, piece, other);
    assert_memory_equal(forward, other, sizeof forward);
    memset(other, 0, sizeof other);
    struct qg_pool *pool = qg_pool_create(3);
    assert_non_null(pool);
    struct qg_executor executor = qg_pool_executor(pool);
    struct task task = {&o, &map, other};
    executor.run(executor.self, qg_response_pieces(&map), run_piece, &task);
    qg_pool_destroy(pool);
    assert_memory_equal(forward, other, sizeof forward);
    for (int path = 0; path < QG_PATH_COUNT; path++) {
        struct qg_batch_options options = {.path = (enum qg_batch_path)path};
        if (!qg_batch_path_available(options.path))
            continue;
        memset(other, 0, sizeof other);
        for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
            qg_response_piece_with(&options, &o, &map, piece, other);
        assert_memory_equal(forward, other, sizeof forward);
    }
}

/* ---- the model --------------------------------------------------------------------------------------------------- */

/* A design judged by the model: time is measured by the mean secant, the stiffness reported is the tangent, which the
 * approaches of two loads close by confirm. */
static void the_model_reports_secant_mean_and_tangent(void **state) {
    (void)state;
    struct qg_analysis analysis = {.case_count = 3,
                                   .torque_fraction = {0.97, 1, 1.03},
                                   .mesh_positions = POSITIONS,
                                   .mesh_refinement = 1,
                                   .mesh_stiffness = QG_STIFFNESS_LOAD_DEPENDENT,
                                   .harmonics = HARMONICS,
                                   .speeds = map_of(0.3, 1.3, 9)};
    struct qg_model *model;
    struct qg_evaluator evaluator;
    struct qg_design_result *r = qg_design_result_create(&analysis);
    assert_non_null(r);
    r->relief = made.relief;
    const struct qg_means means = {.executor = qg_serial_executor};
    assert_int_equal(qg_model_create(&made.pair, &analysis, &means, NULL, &model), QG_OK);
    assert_int_equal(qg_evaluator_init(&evaluator, model, &qg_serial_executor), QG_OK);
    assert_int_equal(qg_evaluate(&evaluator, true, 1, &r), QG_OK);
    const struct qg_case_result *below = &r->cases[0], *at = &r->cases[1], *above = &r->cases[2];
    double secant = 0;
    for (int i = 0; i < POSITIONS; i++) {
        secant += at->normal_force / at->static_transmission_error[i] / POSITIONS;
        double chord = (above->normal_force - below->normal_force) /
                       (above->static_transmission_error[i] - below->static_transmission_error[i]);
        assert_near_share(at->mesh_stiffness[i], chord, 0.05);
    }
    assert_near_share(at->mean_mesh_stiffness, secant, 1e-12);
    assert_near_share(at->natural_frequency, sqrt(1000 * secant / made.geometry.equivalent_mass) / (2 * M_PI), 1e-12);
    assert_true(at->max_rms > 0.01 && at->max_rms < 0.3 && at->speeds_beyond == 0);
    qg_evaluator_finish(&evaluator);
    qg_model_destroy(model);
    qg_design_result_destroy(r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ladder_holds_all_loads_in_small_ratios),
        cmocka_unit_test(force_is_zero_below_the_unloaded_error_and_grows_above),
        cmocka_unit_test(slope_is_the_derivative_and_has_no_jumps),
        cmocka_unit_test(static_limit_is_the_transmission_error_at_every_rung),
        cmocka_unit_test(static_limit_holds_between_the_rungs),
        cmocka_unit_test(tangent_stiffness_is_the_slope_at_the_rung),
        cmocka_unit_test(rungs_that_would_cross_are_kept_apart),
        cmocka_unit_test(back_flanks_mirror_the_drive_flanks),
        cmocka_unit_test(back_force_is_the_drive_force_at_the_mirrored_phase),
        cmocka_unit_test(static_displacement_balances_the_load),
        cmocka_unit_test(a_linear_force_gives_the_linear_response),
        cmocka_unit_test(batch_agrees_with_cvode),
        cmocka_unit_test(march_agrees_with_small_steps_through_both_edges),
        cmocka_unit_test(tangent_is_the_derivative_of_the_march),
        cmocka_unit_test(orbits_beyond_the_ladder_are_named),
        cmocka_unit_test(order_threads_and_paths_do_not_matter),
        cmocka_unit_test(the_model_reports_secant_mean_and_tangent),
    };
    return cmocka_run_group_tests_name("force", tests, make_all, finish_all);
}
