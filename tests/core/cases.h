/* What the tests of core share: the three gear pairs of the physics, reliefs on them, random numbers of their own, and
 * random gears that can be cut.
 *
 * S is the 28/43 pair of an agricultural gearbox, H its high-contact-ratio equivalent, B the 50/50 benchmark rig.
 */
#ifndef QG_TESTS_CORE_CASES_H
#define QG_TESTS_CORE_CASES_H

/* cmocka wants these before it, in this order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "core/relief.h"
#include "core/study.h"

#define CASE_DEGREE (M_PI / 180)
#define CASE_STEEL                                                                                                     \
    { .youngs_modulus = 206000, .poisson_ratio = 0.3, .density = 7.85e-6 }

#define CASE_S                                                                                                         \
    {                                                                                                                  \
        .rack = {3, 20 * CASE_DEGREE}, .center_distance = 111,                                                         \
        .gears = {{.teeth = 28,                                                                                        \
                   .profile_shift = 1.927,                                                                             \
                   .outside_radius = 46.55,                                                                            \
                   .root_radius = 39.55,                                                                               \
                   .hob_tip_radius = 0.9,                                                                              \
                   .bore_diameter = 40,                                                                                \
                   .face_width = 27},                                                                                  \
                  {.teeth = 43,                                                                                        \
                   .profile_shift = 2.748,                                                                             \
                   .outside_radius = 69.55,                                                                            \
                   .root_radius = 63.1,                                                                                \
                   .hob_tip_radius = 0.9,                                                                              \
                   .bore_diameter = 40,                                                                                \
                   .face_width = 22.5}},                                                                               \
        .material = CASE_STEEL, .damping_ratio = 0.01, .nominal_torque = 470e3                                         \
    }

#define CASE_H                                                                                                         \
    {                                                                                                                  \
        .rack = {2.2, 18 * CASE_DEGREE}, .center_distance = 111,                                                       \
        .gears = {{.teeth = 40,                                                                                        \
                   .profile_shift = 0.159,                                                                             \
                   .outside_radius = 46.8,                                                                             \
                   .root_radius = 41,                                                                                  \
                   .hob_tip_radius = 0.6,                                                                              \
                   .bore_diameter = 40,                                                                                \
                   .face_width = 27},                                                                                  \
                  {.teeth = 61,                                                                                        \
                   .profile_shift = -0.766,                                                                            \
                   .outside_radius = 69,                                                                               \
                   .root_radius = 63,                                                                                  \
                   .hob_tip_radius = 0.6,                                                                              \
                   .bore_diameter = 40,                                                                                \
                   .face_width = 22.5}},                                                                               \
        .material = CASE_STEEL, .damping_ratio = 0.01, .nominal_torque = 470e3                                         \
    }

#define CASE_B                                                                                                         \
    {                                                                                                                  \
        .rack = {3, 20 * CASE_DEGREE}, .center_distance = 150,                                                         \
        .gears = {{.teeth = 50,                                                                                        \
                   .profile_shift = -0.1,                                                                              \
                   .outside_radius = 78,                                                                               \
                   .root_radius = 70.34,                                                                               \
                   .hob_tip_radius = 0.9,                                                                              \
                   .bore_diameter = 50,                                                                                \
                   .face_width = 20},                                                                                  \
                  {.teeth = 50,                                                                                        \
                   .profile_shift = -0.1,                                                                              \
                   .outside_radius = 78,                                                                               \
                   .root_radius = 70.34,                                                                               \
                   .hob_tip_radius = 0.9,                                                                              \
                   .bore_diameter = 50,                                                                                \
                   .face_width = 20}},                                                                                 \
        .material = CASE_STEEL, .damping_ratio = 0.01, .nominal_torque = 340e3                                         \
    }

/* The 2011 paper's standard relief of case S: tips of both gears, linear over the radius. */
#define CASE_S_STANDARD                                                                                                \
    {                                                                                                                  \
        .gears = { {.tip = {true, 44.54, 0.016}}, {.tip = {true, 67.64, 0.018}} }                                      \
    }

/* The same case three times, by name: for tests that go through all. */
static const struct named_case {
    const char *name;
    struct qg_gear_pair pair;
} all_cases[] = {{"S", CASE_S}, {"H", CASE_H}, {"B", CASE_B}};
enum { CASE_COUNT = sizeof all_cases / sizeof *all_cases };

/* Fails the test unless |got - wanted| <= tolerance; NaN fails. */
#define assert_near(got, wanted, tolerance)                                                                            \
    do {                                                                                                               \
        double near_got = (got), near_wanted = (wanted), near_tolerance = (tolerance);                                 \
        if (!(fabs(near_got - near_wanted) <= near_tolerance))                                                         \
            fail_msg("%s is %.12g, wanted %.12g to %g (off by %g)", #got, near_got, near_wanted, near_tolerance,       \
                     near_got - near_wanted);                                                                          \
    } while (0)

/* Likewise, relative to the wanted value. */
#define assert_near_share(got, wanted, share)                                                                          \
    do {                                                                                                               \
        double share_wanted = (wanted);                                                                                \
        assert_near(got, share_wanted, (share)*fabs(share_wanted));                                                    \
    } while (0)

/* A 64-bit linear congruential generator (Knuth's MMIX constants): the tests' own randomness, the same everywhere. */
struct dice {
    uint64_t state;
};

/* Uniform in [low, high). */
static inline double dice_between(struct dice *dice, double low, double high) {
    dice->state = dice->state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return low + (high - low) * (double)(dice->state >> 11) * 0x1p-53;
}

/* One of low .. high. */
static inline int dice_integer(struct dice *dice, int low, int high) {
    return low + (int)dice_between(dice, 0, high - low + 1);
}

/* The note about `where`, or NULL. */
static inline const struct qg_note *note_about(const struct qg_notes *notes, const char *where) {
    for (size_t i = 0; i < notes->count; i++)
        if (strcmp(notes->item[i].where, where) == 0)
            return &notes->item[i];
    return NULL;
}

/* A gear and its rack with everything derived. */
struct cut_gear {
    struct qg_rack rack;
    struct qg_gear gear;
    struct qg_gear_geometry geometry;
};

/* Throws dice until a gear comes up that qg_gear_derive accepts: teeth 12 to 150, any usual rack, shifts from -0.5 to 1
 * module, hob tips from sharp to full, bores from a tenth of the root radius to half a module of rim. */
static inline struct cut_gear random_gear(struct dice *dice) {
    for (;;) {
        struct cut_gear g = {.rack = {dice_between(dice, 0.5, 8), dice_between(dice, 14.5, 28) * CASE_DEGREE}};
        double m = g.rack.module, x = dice_between(dice, -0.5, 1), addendum = dice_between(dice, 1, 1.6);
        g.gear.teeth = dice_integer(dice, 12, 150);
        g.gear.profile_shift = x * m;
        double shifted = m * g.gear.teeth / 2 + x * m;
        g.gear.root_radius = shifted - addendum * m;
        g.gear.outside_radius = shifted + dice_between(dice, 0.6, 1.4) * m;
        double fits = (M_PI / 4 - addendum * tan(g.rack.pressure_angle)) * cos(g.rack.pressure_angle) /
                      (1 - sin(g.rack.pressure_angle));
        g.gear.hob_tip_radius = fmax(0, dice_between(dice, 0, fits)) * m;
        g.gear.bore_diameter = 2 * dice_between(dice, 0.1 * g.gear.root_radius, g.gear.root_radius - m / 2);
        g.gear.face_width = dice_between(dice, 5, 40);
        g.gear.moment_of_inertia = 1000;
        if (qg_gear_derive(&g.rack, &g.gear, 7.85e-6, "", &g.geometry, NULL) == QG_OK)
            return g;
    }
}

/* inv of the angle whose involute function is given, by Newton's method from above. */
static inline double inverse_involute(double value) {
    double angle = cbrt(3 * value);
    for (int i = 0; i < 60; i++)
        angle -= (qg_involute(angle) - value) / (tan(angle) * tan(angle));
    return angle;
}

/* One of the two gears of random_pair: usual proportions; the tip is cut later, when the centre distance is known. */
static inline struct qg_gear random_half(struct dice *dice, const struct qg_rack *rack) {
    double m = rack->module, addendum = dice_between(dice, 1.15, 1.35);
    struct qg_gear g = {.teeth = dice_integer(dice, 14, 90), .profile_shift = dice_between(dice, -0.3, 0.8) * m};
    g.root_radius = m * g.teeth / 2 + g.profile_shift - addendum * m;
    double fits =
        (M_PI / 4 - addendum * tan(rack->pressure_angle)) * cos(rack->pressure_angle) / (1 - sin(rack->pressure_angle));
    g.hob_tip_radius = fmax(0, dice_between(dice, 0, fits)) * m;
    g.bore_diameter = 2 * g.root_radius - dice_between(dice, 3, 12) * m;
    g.face_width = dice_between(dice, 5, 40);
    return g;
}

/* Throws dice until a pair comes up that qg_pair_derive accepts. */
static inline struct qg_gear_pair random_pair(struct dice *dice, struct qg_pair_geometry *geometry) {
    for (;;) {
        struct qg_gear_pair p = {.rack = {dice_between(dice, 1, 5), dice_between(dice, 17, 25) * CASE_DEGREE},
                                 .material = CASE_STEEL,
                                 .damping_ratio = 0.01,
                                 .nominal_torque = 1e5};
        double m = p.rack.module, alpha = p.rack.pressure_angle;
        for (int i = 0; i < 2; i++)
            p.gears[i] = random_half(dice, &p.rack);
        double teeth = p.gears[0].teeth + p.gears[1].teeth;
        double shifts = (p.gears[0].profile_shift + p.gears[1].profile_shift) / m;
        double working = inverse_involute(qg_involute(alpha) + 2 * shifts * tan(alpha) / teeth);
        if (!(working > 0.1))
            continue;
        p.center_distance = m * teeth / 2 * cos(alpha) / cos(working) + dice_between(dice, 0.01, 0.15) * m;
        for (int i = 0; i < 2; i++)
            p.gears[i].outside_radius = p.center_distance - p.gears[1 - i].root_radius - 0.25 * m;
        if (qg_pair_derive(&p, geometry, NULL) == QG_OK)
            return p;
    }
}

/* A small optimization of case S: few speeds, samples and trials. */
static inline struct qg_study small_study(void) {
    return (struct qg_study){
        .kind = QG_STUDY_OPTIMIZE,
        .pair = CASE_S,
        .analysis = {.case_count = 2,
                     .torque_fraction = {0.5, 1},
                     .mesh_positions = 14,
                     .mesh_refinement = 1,
                     .harmonics = 6,
                     .speeds = {.min = 0.4, .max = 1.2, .count = 24, .start_static = 1}},
        .relief = CASE_S_STANDARD,
        .bounds = {.count = 3,
                   .parameter = {QG_PINION_TIP_START_RADIUS, QG_PINION_TIP_AMPLITUDE, QG_GEAR_TIP_AMPLITUDE},
                   .lower = {42, 0.003, 0.003},
                   .upper = {46.55, 0.035, 0.035}},
        .optimizer = {.random_samples = 20, .simplex_iterations = 10, .seed = 3, .evaluations = 60, .starts = 3},
        .reliability = {20, 0.2, 0.012, 0.2, 1, 90, 5},
    };
}

#endif
