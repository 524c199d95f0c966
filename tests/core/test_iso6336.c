/* ISO 6336: the tooth stiffness against a known value, the critical section against the 30 degree tangent of the fillet that
 * core/gear.h generates, the contact stress against Hertz's formula, and what rating must do when a figure changes. */
#include "core/iso6336.h"
#include "tests/core/cases.h"

static struct qg_pair_geometry derived(const struct qg_gear_pair *pair) {
    struct qg_pair_geometry g;
    assert_int_equal(qg_pair_derive(pair, &g, NULL), QG_OK);
    return g;
}

static struct qg_iso6336 rated(const struct qg_gear_pair *pair) {
    struct qg_pair_geometry g = derived(pair);
    struct qg_iso6336 iso;
    assert_int_equal(qg_iso6336_rate(pair, &g, pair->nominal_torque, &iso), QG_OK);
    return iso;
}

static void test_stiffness_of_17_and_43_teeth(void **state) {
    (void)state;
    struct qg_iso6336_tooth tooth[2] = {{.teeth = 17, .pressure_angle = 20 * CASE_DEGREE, .dedendum = 1.25},
                                        {.teeth = 43, .pressure_angle = 20 * CASE_DEGREE, .dedendum = 1.25}};
    tooth[0].contact_ratio = tooth[1].contact_ratio = 1.6211;
    struct qg_iso6336_stiffness s = qg_iso6336_stiffness((const struct qg_iso6336_tooth *)tooth, 500, 206000);
    assert_near(s.theoretical, 16.0319, 5e-5);
    assert_near(s.single, 12.5049, 5e-5);
    assert_near(s.mesh, 18.3300, 5e-5);
    struct qg_iso6336_stiffness light = qg_iso6336_stiffness((const struct qg_iso6336_tooth *)tooth, 6.25, 103000);
    assert_near(light.single, s.single / 4, 1e-12);
}

/* The fillet's point in the tooth's own axes: x along the centre line, y off it. */
static void fillet_point(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int i, double at,
                         double out[2]) {
    struct qg_polar p = qg_trochoid_point(&pair->rack, &pair->gears[i], &g->gears[i], at);
    out[0] = p.radius * cos(p.angle);
    out[1] = p.radius * sin(p.angle);
}

/* Angle of the fillet's tangent against the centre line, by central differences. */
static double slope_at(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int i, double at) {
    double below[2], above[2];
    fillet_point(pair, g, i, at - 1e-5, below);
    fillet_point(pair, g, i, at + 1e-5, above);
    return atan2(below[1] - above[1], above[0] - below[0]);
}

/* What the drawing board says of a tooth's critical section, in mm. */
struct drawing {
    double chord, fillet_radius, load_arm, load_angle;
};

static struct drawing draw(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int i) {
    double low = 1e-4, high = 1 - 1e-4, p[2];
    assert_true(slope_at(pair, g, i, low) > M_PI / 6 && slope_at(pair, g, i, high) < M_PI / 6);
    for (int k = 0; k < 60; k++) {
        double middle = (low + high) / 2;
        *(slope_at(pair, g, i, middle) > M_PI / 6 ? &low : &high) = middle;
    }
    fillet_point(pair, g, i, low, p);
    double a[2], b[2], h = 1e-3;
    fillet_point(pair, g, i, low - h, a);
    fillet_point(pair, g, i, low + h, b);
    double length = hypot(b[0] - a[0], b[1] - a[1]);
    struct drawing d = {.chord = 2 * p[1]};
    d.fillet_radius = length / (slope_at(pair, g, i, low - h) - slope_at(pair, g, i, low + h));
    /* the load: normal to the involute one base pitch times (contact ratio - 1) before the tip, tangent to the base circle */
    const struct qg_gear_geometry *gear = &g->gears[i];
    double ra = pair->gears[i].outside_radius, rb = gear->base_radius;
    double along = sqrt(ra * ra - rb * rb) - (g->contact_ratio - 1) * g->base_pitch, radius = hypot(rb, along);
    double half = qg_half_tooth_angle(&pair->rack, gear, radius);
    d.load_angle = acos(rb / radius) - half; /* of the force against the chord */
    d.load_arm = radius * cos(half) - radius * sin(half) * tan(d.load_angle) - p[0];
    return d;
}

static void test_critical_section_is_the_30_degree_tangent(void **state) {
    (void)state;
    for (size_t k = 0; k < CASE_COUNT; k++) {
        struct qg_pair_geometry g = derived(&all_cases[k].pair);
        struct qg_iso6336 iso = rated(&all_cases[k].pair);
        double m = all_cases[k].pair.rack.module;
        for (int i = 0; i < 2; i++) {
            struct drawing d = draw(&all_cases[k].pair, &g, i);
            assert_near_share(iso.root[i].chord * m, d.chord, 1e-6);
            assert_near_share(iso.root[i].fillet_radius * m, d.fillet_radius, 1e-4);
            assert_near_share(iso.root[i].load_arm * m, d.load_arm, 1e-6);
            assert_near(iso.root[i].load_angle, d.load_angle, 1e-9);
            /* stress of the bent cantilever, without the notch */
            double force = all_cases[k].pair.nominal_torque / g.gears[QG_PINION].base_radius;
            double nominal = 6 * force * cos(d.load_angle) * d.load_arm / (d.chord * d.chord * iso.root_face_width[i]);
            double notch = iso.root[i].stress_correction_factor;
            assert_near_share(iso.root_stress[i], nominal * notch * iso.deep_tooth_factor, 1e-6);
            assert_true(notch > 1 && iso.root[i].notch_parameter >= 1 && iso.root[i].notch_parameter < 8);
        }
    }
}

/* Hertz: line contact of two cylinders of the flanks' radii of curvature at the pitch point, under the share Z_eps^2. */
static void test_contact_stress_is_hertz_at_the_pitch_point(void **state) {
    (void)state;
    for (size_t k = 0; k < CASE_COUNT; k++) {
        const struct qg_gear_pair *pair = &all_cases[k].pair;
        struct qg_pair_geometry g = derived(pair);
        struct qg_iso6336 iso = rated(pair);
        double load = pair->nominal_torque / g.gears[QG_PINION].base_radius / g.face_width;
        double sum = 0, point = 0;
        for (int i = 0; i < 2; i++)
            sum += 1 / (g.gears[i].base_radius * tan(g.working_pressure_angle));
        double modulus = pair->material.youngs_modulus / (1 - 0.09) / 2;
        double share = iso.contact_ratio_factor * iso.contact_ratio_factor;
        assert_near_share(iso.nominal_contact_stress, sqrt(share * load * modulus / M_PI * sum), 1e-12);
        /* on the pinion at the inner point of single (double) contact */
        double pitches = g.contact_ratio >= 2 ? 2 : 1, xi = g.path_end - pitches * g.base_pitch;
        point = 1 / xi + 1 / (g.line_length - xi);
        double there = sqrt(share * load * modulus / M_PI * point);
        assert_near_share(iso.contact_stress[QG_PINION], fmax(there, iso.nominal_contact_stress), 1e-12);
    }
}

static void test_rating_follows_torque_width_and_material(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    struct qg_iso6336 one = rated(&pair);
    assert_near(one.elasticity_factor, 189.8, 0.05); /* the standard's own figure for steel */
    assert_near(one.deep_tooth_factor, 1, 0);
    assert_near(one.root_face_width[QG_PINION], 27, 0);
    pair.nominal_torque *= 2;
    struct qg_iso6336 two = rated(&pair);
    assert_near_share(two.contact_stress[QG_GEAR], sqrt(2) * one.contact_stress[QG_GEAR], 1e-12);
    assert_near_share(two.root_stress[QG_GEAR], 2 * one.root_stress[QG_GEAR], 1e-12);
    pair.gears[QG_PINION].face_width = 40; /* only a module on each side helps */
    assert_near(rated(&pair).root_face_width[QG_PINION], 22.5 + 6, 1e-12);
    pair.gears[QG_PINION].bore_diameter = 2 * (39.55 - 5.6);
    assert_near(rated(&pair).rim_factor[QG_PINION], 1.6 * log(2.242 * 7 / 5.6), 1e-12);
}

static void test_deep_teeth(void **state) {
    (void)state;
    assert_near(qg_iso6336_deep_tooth_factor(2.05), 1, 0);
    assert_near(qg_iso6336_deep_tooth_factor(2.3), 2.366 - 0.666 * 2.3, 1e-15);
    assert_near(qg_iso6336_deep_tooth_factor(2.5), 0.701, 1e-12);
    assert_near(qg_iso6336_deep_tooth_factor(2.6), 0.7, 0);
    struct qg_gear_pair pair = CASE_H;
    struct qg_iso6336 iso = rated(&pair);
    assert_near(iso.contact_ratio_factor, sqrt((4 - derived(&pair).contact_ratio) / 3), 1e-15);
    assert_true(iso.single_contact_factor[QG_PINION] > 1);
}

static bool is_beyond(const struct qg_gear_pair *pair, enum qg_iso6336_range range) {
    struct qg_iso6336 iso = rated(pair);
    for (int i = 0; i < QG_ISO6336_RANGES; i++)
        if (i != (int)range && i != QG_ISO6336_SHIFTS)
            assert_false(iso.is_beyond[i]);
    return iso.is_beyond[range];
}

/* Case S has x1 = 0.642 < x2 = 0.916; each other limit is crossed by one change. */
static void test_ranges_of_the_standard_are_told(void **state) {
    (void)state;
    struct qg_gear_pair s = CASE_S, h = CASE_H, b = CASE_B, deep = CASE_H;
    assert_true(is_beyond(&s, QG_ISO6336_SHIFTS));
    assert_false(is_beyond(&h, QG_ISO6336_SHIFTS));
    assert_false(is_beyond(&b, QG_ISO6336_SHIFTS)); /* x1 = x2 */
    b.gears[QG_PINION].profile_shift = -0.1 - 1e-6;
    assert_true(is_beyond(&b, QG_ISO6336_SHIFTS));
    assert_false(is_beyond(&s, QG_ISO6336_SHORT_CONTACT));
    s.gears[QG_PINION].outside_radius -= 0.1;
    assert_true(derived(&s).contact_ratio < 1.2 && is_beyond(&s, QG_ISO6336_SHORT_CONTACT));
    s.gears[QG_PINION].outside_radius += 0.1;
    s.gears[QG_PINION].bore_diameter = 2 * (39.55 - 3.6); /* tooth depth 7 */
    assert_false(is_beyond(&s, QG_ISO6336_THIN_RIM));
    s.gears[QG_PINION].bore_diameter = 2 * (39.55 - 3.4);
    assert_true(is_beyond(&s, QG_ISO6336_THIN_RIM));
    s.gears[QG_PINION].bore_diameter = 40;
    s.gears[QG_GEAR].hob_tip_radius = 0.1;
    assert_true(rated(&s).root[QG_GEAR].notch_parameter >= 8 && is_beyond(&s, QG_ISO6336_NOTCH));
    for (int i = 0; i < 2; i++) {
        deep.gears[i].root_radius -= 0.72;
        deep.gears[i].outside_radius += 0.72;
        deep.gears[i].hob_tip_radius = 0.3;
    }
    assert_true(derived(&deep).contact_ratio >= 2.5);
    assert_true(is_beyond(&deep, QG_ISO6336_LONG_CONTACT));
}

static void test_teeth_without_a_value_are_refused(void **state) {
    (void)state;
    struct qg_iso6336_root root;
    struct qg_iso6336_tooth tooth = {20, 20 * CASE_DEGREE, 0, 1.25, 0.38, 11, 1.5};
    assert_int_equal(qg_iso6336_root_factors(&tooth, &root), QG_OK);
    tooth.outside_radius = 9.2; /* below the base circle */
    assert_int_equal(qg_iso6336_root_factors(&tooth, &root), QG_NO_CONVERGENCE);
    tooth.outside_radius = 11;
    tooth.contact_ratio = 4; /* the load would act below the critical section */
    assert_int_equal(qg_iso6336_root_factors(&tooth, &root), QG_NO_CONVERGENCE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stiffness_of_17_and_43_teeth),
        cmocka_unit_test(test_critical_section_is_the_30_degree_tangent),
        cmocka_unit_test(test_contact_stress_is_hertz_at_the_pitch_point),
        cmocka_unit_test(test_rating_follows_torque_width_and_material),
        cmocka_unit_test(test_deep_teeth),
        cmocka_unit_test(test_ranges_of_the_standard_are_told),
        cmocka_unit_test(test_teeth_without_a_value_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
