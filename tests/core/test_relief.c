/* Reliefs: depth along the flank against closed forms, addressing of the eight parameters, checks. */
#include "tests/core/cases.h"

struct fixture {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
};

static struct fixture of_S(void) {
    struct fixture f = {.pair = CASE_S};
    assert_int_equal(qg_pair_derive(&f.pair, &f.geometry, NULL), QG_OK);
    return f;
}

static double depth(const struct fixture *f, const struct qg_relief *relief, int gear, double radius) {
    return qg_relief_depth(relief, &f->geometry, &f->pair, gear, radius);
}

/* ---- depth ------------------------------------------------------------------------------------------------------ */

static void no_ramp_removes_nothing(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_relief relief = {.gears = {{.tip = {false, 44, 0.01}, .root = {false, 44, 0.01}}}};
    for (double radius = 40.5; radius <= 46.55; radius += 0.05)
        assert_near(depth(&f, &relief, QG_PINION, radius), 0, 0);
}

static void tip_ramp_over_radius(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_relief relief = CASE_S_STANDARD;
    assert_near(depth(&f, &relief, QG_PINION, 40.5), 0, 0);
    assert_near(depth(&f, &relief, QG_PINION, 44.54), 0, 0);
    assert_near(depth(&f, &relief, QG_PINION, 46.55), 0.016, 1e-15);
    assert_near(depth(&f, &relief, QG_PINION, (44.54 + 46.55) / 2), 0.008, 1e-15);
    assert_near(depth(&f, &relief, QG_PINION, 44.54 + 0.25 * (46.55 - 44.54)), 0.004, 1e-15);
    assert_near(depth(&f, &relief, QG_GEAR, 67.64 + 0.25 * (69.55 - 67.64)), 0.0045, 1e-15);
    relief.shape = QG_SHAPE_PARABOLIC;
    assert_near(depth(&f, &relief, QG_PINION, 44.54), 0, 0);
    assert_near(depth(&f, &relief, QG_PINION, 46.55), 0.016, 1e-15);
    assert_near(depth(&f, &relief, QG_PINION, (44.54 + 46.55) / 2), 0.004, 1e-15);
    assert_near(depth(&f, &relief, QG_GEAR, 67.64 + 0.25 * (69.55 - 67.64)), 0.018 / 16, 1e-15);
}

static void root_ramp_over_radius(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_relief relief = {.gears = {{.root = {true, 42, 0.01}}, {.root = {true, 66, 0.02}}}};
    double form = f.geometry.gears[QG_PINION].form_radius, middle = (form + 42) / 2;
    assert_near(depth(&f, &relief, QG_PINION, 42), 0, 0);
    assert_near(depth(&f, &relief, QG_PINION, 45), 0, 0);
    assert_near(depth(&f, &relief, QG_PINION, form), 0.01, 1e-15);
    assert_near(depth(&f, &relief, QG_PINION, form - 0.3), 0.01, 1e-15);
    assert_near(depth(&f, &relief, QG_PINION, middle), 0.005, 1e-15);
    assert_near(depth(&f, &relief, QG_GEAR, (66 + f.geometry.gears[QG_GEAR].form_radius) / 2), 0.01, 1e-15);
    relief.shape = QG_SHAPE_PARABOLIC;
    assert_near(depth(&f, &relief, QG_PINION, middle), 0.0025, 1e-15);
}

/* Over roll angle the ramp is straight in sqrt(radius^2 - r_b^2) = r_b times the roll angle. */
static void ramps_over_roll_angle(void **state) {
    (void)state;
    struct fixture f = of_S();
    double rb = f.geometry.gears[QG_PINION].base_radius, form = f.geometry.gears[QG_PINION].form_radius;
    struct qg_relief relief = {.ramp = QG_RAMP_ROLL_ANGLE,
                               .gears = {{.tip = {true, 44.54, 0.016}, .root = {true, 42, 0.01}}}};
    double start = sqrt(44.54 * 44.54 - rb * rb), tip = sqrt(46.55 * 46.55 - rb * rb);
    double end = sqrt(42 * 42 - rb * rb), root = sqrt(form * form - rb * rb);
    for (int k = 0; k <= 10; k++) {
        double share = k / 10.0, at_tip = hypot(rb, start + share * (tip - start));
        double at_root = hypot(rb, end + share * (root - end));
        relief.shape = QG_SHAPE_LINEAR;
        assert_near(depth(&f, &relief, QG_PINION, at_tip), 0.016 * share, 1e-14);
        assert_near(depth(&f, &relief, QG_PINION, at_root), 0.01 * share, 1e-14);
        relief.shape = QG_SHAPE_PARABOLIC;
        assert_near(depth(&f, &relief, QG_PINION, at_tip), 0.016 * share * share, 1e-14);
        assert_near(depth(&f, &relief, QG_PINION, at_root), 0.01 * share * share, 1e-14);
    }
    /* and it is another curve than over radius: later at the tip's middle by the curvature of the square root */
    struct qg_relief over_radius = relief;
    over_radius.ramp = QG_RAMP_RADIUS;
    assert_true(fabs(depth(&f, &relief, QG_PINION, 45.5) - depth(&f, &over_radius, QG_PINION, 45.5)) > 5e-5);
}

static void overlapping_ramps_add_up(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_relief tip = {.gears = {{.tip = {true, 42, 0.01}}}}, root = {.gears = {{.root = {true, 45, 0.02}}}};
    struct qg_relief both = {.gears = {{.tip = {true, 42, 0.01}, .root = {true, 45, 0.02}}}};
    for (double radius = 40.5; radius < 46.5; radius += 0.1)
        assert_near(depth(&f, &both, QG_PINION, radius),
                    depth(&f, &tip, QG_PINION, radius) + depth(&f, &root, QG_PINION, radius), 1e-16);
    assert_true(depth(&f, &both, QG_PINION, 43.5) > depth(&f, &root, QG_PINION, 43.5));
}

/* Contact points compute their radii with rounding: a ramp of no length must not depend on it. */
static void ramp_without_length_removes_nothing(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_relief relief = {.gears = {{.tip = {true, 46.55, 0.016}}}};
    for (int ramp = QG_RAMP_RADIUS; ramp <= QG_RAMP_ROLL_ANGLE; ramp++) {
        relief.ramp = (enum qg_relief_ramp)ramp;
        assert_near(depth(&f, &relief, QG_PINION, 46), 0, 0);
        assert_near(depth(&f, &relief, QG_PINION, 46.55), 0, 0);
        assert_near(depth(&f, &relief, QG_PINION, nextafter(46.55, 50)), 0, 0);
    }
}

/* ---- parameters ------------------------------------------------------------------------------------------------- */

static void parameters_address_their_places(void **state) {
    (void)state;
    struct qg_relief r;
    const struct {
        enum qg_parameter parameter;
        double *place;
        struct qg_ramp *ramp;
    } wanted[QG_PARAMETER_COUNT] = {
        {QG_PINION_TIP_START_RADIUS, &r.gears[0].tip.radius, &r.gears[0].tip},
        {QG_PINION_TIP_AMPLITUDE, &r.gears[0].tip.amplitude, &r.gears[0].tip},
        {QG_PINION_ROOT_END_RADIUS, &r.gears[0].root.radius, &r.gears[0].root},
        {QG_PINION_ROOT_AMPLITUDE, &r.gears[0].root.amplitude, &r.gears[0].root},
        {QG_GEAR_TIP_START_RADIUS, &r.gears[1].tip.radius, &r.gears[1].tip},
        {QG_GEAR_TIP_AMPLITUDE, &r.gears[1].tip.amplitude, &r.gears[1].tip},
        {QG_GEAR_ROOT_END_RADIUS, &r.gears[1].root.radius, &r.gears[1].root},
        {QG_GEAR_ROOT_AMPLITUDE, &r.gears[1].root.amplitude, &r.gears[1].root},
    };
    for (int i = 0; i < QG_PARAMETER_COUNT; i++) {
        assert_int_equal(wanted[i].parameter, i);
        assert_ptr_equal(qg_relief_parameter(&r, wanted[i].parameter), wanted[i].place);
        assert_ptr_equal(qg_relief_ramp_of(&r, wanted[i].parameter), wanted[i].ramp);
        assert_int_equal(qg_parameter_is_radius(wanted[i].parameter), wanted[i].place == &wanted[i].ramp->radius);
    }
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

static void deepest_is_the_lesser_of_two_bounds(void **state) {
    (void)state;
    struct fixture f = of_S();
    assert_true(f.geometry.gears[QG_PINION].tip_thickness > 0.24);
    assert_near(qg_relief_deepest(&f.pair, &f.geometry, QG_PINION), 0.12, 1e-15);
    f.geometry.gears[QG_PINION].tip_thickness = 0.1;
    assert_near(qg_relief_deepest(&f.pair, &f.geometry, QG_PINION), 0.05, 1e-15);
    assert_near(qg_relief_deepest(&f.pair, &f.geometry, QG_GEAR), 0.12, 1e-15);
}

static void sound_reliefs_pass(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_notes errors = {0}, warnings = {0};
    struct qg_relief relief = CASE_S_STANDARD;
    relief.gears[0].root = (struct qg_ramp){true, 42, 0};
    assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, &errors, &warnings), QG_OK);
    relief.gears[0].tip = (struct qg_ramp){true, 46.55, 0.12};
    assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, &errors, &warnings), QG_OK);
    relief = (struct qg_relief){.gears = {{.tip = {false, -1, NAN}}}};
    assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, &errors, &warnings), QG_OK);
    assert_int_equal(errors.count + warnings.count, 0);
    assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, NULL, NULL), QG_OK);
}

static void faulty_ramps_are_named(void **state) {
    (void)state;
    struct fixture f = of_S();
    const double form = f.geometry.gears[QG_PINION].form_radius;
    const struct {
        int gear;
        bool tip;
        struct qg_ramp ramp;
        const char *where;
    } faults[] = {
        {0, true, {true, form - 0.001, 0.01}, "pinion.tip.start_radius"},
        {0, true, {true, 46.551, 0.01}, "pinion.tip.start_radius"},
        {0, true, {true, NAN, 0.01}, "pinion.tip.start_radius"},
        {0, true, {true, 45, -1e-9}, "pinion.tip.amplitude"},
        {0, true, {true, 45, 0.1201}, "pinion.tip.amplitude"},
        {1, true, {true, 68, NAN}, "gear.tip.amplitude"},
        {1, true, {true, 46, 0.01}, "gear.tip.start_radius"},
        {0, false, {true, 39.54, 0.01}, "pinion.root.end_radius"},
        {1, false, {true, 69.56, 0.01}, "gear.root.end_radius"},
        {1, false, {true, 66, INFINITY}, "gear.root.amplitude"},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        struct qg_relief relief = {0};
        struct qg_notes errors = {0};
        if (faults[i].tip)
            relief.gears[faults[i].gear].tip = faults[i].ramp;
        else
            relief.gears[faults[i].gear].root = faults[i].ramp;
        assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, &errors, NULL), QG_IMPOSSIBLE_GEAR);
        assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, NULL, NULL), QG_IMPOSSIBLE_GEAR);
        assert_int_equal(errors.count, 1);
        assert_string_equal(errors.item[0].where, faults[i].where);
    }
}

static void root_relief_below_the_form_radius_warns_and_does_nothing(void **state) {
    (void)state;
    struct fixture f = of_S();
    struct qg_notes errors = {0}, warnings = {0};
    struct qg_relief relief = {.gears = {{.root = {true, 40, 0.02}}}};
    assert_int_equal(qg_relief_check(&relief, &f.pair, &f.geometry, &errors, &warnings), QG_OK);
    assert_int_equal(errors.count, 0);
    assert_int_equal(warnings.count, 1);
    assert_string_equal(warnings.item[0].where, "pinion.root.end_radius");
    assert_non_null(strstr(warnings.item[0].text, "40.4654"));
    for (double radius = 39.6; radius <= 46.55; radius += 0.05)
        assert_near(depth(&f, &relief, QG_PINION, radius), 0, 0);
    /* a hair above the form radius it begins to work */
    relief.gears[0].root.radius = f.geometry.gears[0].form_radius + 1e-6;
    assert_near(depth(&f, &relief, QG_PINION, f.geometry.gears[0].form_radius), 0.02, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_ramp_removes_nothing),
        cmocka_unit_test(tip_ramp_over_radius),
        cmocka_unit_test(root_ramp_over_radius),
        cmocka_unit_test(ramps_over_roll_angle),
        cmocka_unit_test(overlapping_ramps_add_up),
        cmocka_unit_test(ramp_without_length_removes_nothing),
        cmocka_unit_test(parameters_address_their_places),
        cmocka_unit_test(deepest_is_the_lesser_of_two_bounds),
        cmocka_unit_test(sound_reliefs_pass),
        cmocka_unit_test(faulty_ramps_are_named),
        cmocka_unit_test(root_relief_below_the_form_radius_warns_and_does_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
