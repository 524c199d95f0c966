/* One gear: derived figures, the generated root curve, and every reason to refuse. */
#include "tests/core/cases.h"

/* ---- derived figures -------------------------------------------------------------------------------------------- */

static void form_radii_match_the_reference(void **state) {
    (void)state;
    const double wanted[2][2] = {{40.4654, 63.7308}, {42.1721, 64.4210}}; /* S, H: independent prototype */
    for (int c = 0; c < 2; c++)
        for (int g = 0; g < 2; g++) {
            const struct qg_gear_pair *pair = &all_cases[c].pair;
            struct qg_gear_geometry out;
            struct qg_notes notes = {0};
            assert_int_equal(qg_gear_derive(&pair->rack, &pair->gears[g], 7.85e-6, "", &out, &notes), QG_OK);
            assert_int_equal(notes.count, 0);
            assert_near(out.form_radius, wanted[c][g], 1e-4);
        }
}

static void radii_and_pitch_follow_their_definitions(void **state) {
    (void)state;
    struct dice dice = {11};
    for (int i = 0; i < 1000; i++) {
        struct cut_gear g = random_gear(&dice);
        double m = g.rack.module, alpha = g.rack.pressure_angle, r = m * g.gear.teeth / 2;
        assert_near(g.geometry.reference_radius, r, 1e-12 * r);
        assert_near(g.geometry.base_radius, r * cos(alpha), 1e-12 * r);
        assert_near(g.geometry.base_pitch, 2 * M_PI * g.geometry.base_radius / g.gear.teeth, 1e-12 * r);
        assert_near(g.geometry.tooth_thickness, M_PI * m / 2 + 2 * g.gear.profile_shift * tan(alpha), 1e-12 * r);
        double at_reference = qg_half_tooth_angle(&g.rack, &g.geometry, r) * 2 * r;
        assert_near(at_reference, g.geometry.tooth_thickness, 1e-11 * r);
        double outside = g.gear.outside_radius;
        assert_near(g.geometry.tip_thickness, 2 * outside * qg_half_tooth_angle(&g.rack, &g.geometry, outside),
                    1e-12 * r);
        assert_true(g.geometry.tip_thickness > 0);
        assert_true(g.gear.root_radius < g.geometry.form_radius + 1e-12 * r);
        assert_true(g.geometry.base_radius <= g.geometry.form_radius && g.geometry.form_radius < outside);
    }
}

/* The involute is the path of a string's end unwound from the base circle: with the tangent length xi the point has
 * turned by xi/r_b - atan(xi/r_b) from where the string began. */
static void half_angle_is_that_of_an_unwound_string(void **state) {
    (void)state;
    struct dice dice = {12};
    for (int i = 0; i < 1000; i++) {
        struct cut_gear g = random_gear(&dice);
        double rb = g.geometry.base_radius, xi[2], psi[2];
        for (int k = 0; k < 2; k++) {
            xi[k] = dice_between(&dice, 0, g.gear.outside_radius);
            psi[k] = qg_half_tooth_angle(&g.rack, &g.geometry, hypot(rb, xi[k]));
        }
        double turned = (xi[1] - xi[0]) / rb - (atan(xi[1] / rb) - atan(xi[0] / rb));
        assert_near(psi[0] - psi[1], turned, 1e-11);
    }
}

static void inertia_is_a_hollow_disc_or_the_given_one(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    struct qg_gear_geometry out;
    assert_int_equal(qg_gear_derive(&pair.rack, &pair.gears[0], 7.85e-6, "", &out, NULL), QG_OK);
    double base = 42 * cos(20 * CASE_DEGREE), mass_per_area = 7.85e-6 * 27;
    double disc = 0;
    for (int i = 0; i < 100000; i++) { /* midpoint rule over thin rings */
        double width = (base - 20) / 100000, r = 20 + (i + 0.5) * width;
        disc += 2 * M_PI * r * width * r * r * mass_per_area;
    }
    assert_near_share(out.moment_of_inertia, disc, 1e-8);
    pair.gears[0].moment_of_inertia = 123.5;
    assert_int_equal(qg_gear_derive(&pair.rack, &pair.gears[0], 7.85e-6, "", &out, NULL), QG_OK);
    assert_near(out.moment_of_inertia, 123.5, 0);
}

/* ---- the root curve --------------------------------------------------------------------------------------------- */

struct plane {
    double x, y;
};

static struct plane trochoid_at(const struct cut_gear *g, double parameter) {
    struct qg_polar p = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, parameter);
    return (struct plane){p.radius * cos(p.angle), p.radius * sin(p.angle)};
}

/* Sine of the angle between the root curve's tangent at the form point (one-sided difference of third order) and the
 * involute's, which makes the pressure angle with the radius. */
static double tangent_mismatch(const struct cut_gear *g) {
    const double h = 1e-3;
    struct plane p0 = trochoid_at(g, 1), p1 = trochoid_at(g, 1 - h), p2 = trochoid_at(g, 1 - 2 * h),
                 p3 = trochoid_at(g, 1 - 3 * h);
    double tx = 11 * p0.x - 18 * p1.x + 9 * p2.x - 2 * p3.x, ty = 11 * p0.y - 18 * p1.y + 9 * p2.y - 2 * p3.y;
    double radius = g->geometry.form_radius, pressure_angle = acos(g->geometry.base_radius / radius);
    double direction = qg_half_tooth_angle(&g->rack, &g->geometry, radius) - pressure_angle;
    return (tx * sin(direction) - ty * cos(direction)) / hypot(tx, ty);
}

static void check_form_point(const struct cut_gear *g) {
    struct qg_polar end = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, 1);
    assert_near(end.radius, g->geometry.form_radius, 1e-9);
    double psi = qg_half_tooth_angle(&g->rack, &g->geometry, g->geometry.form_radius);
    assert_near(end.angle * end.radius, psi * end.radius, 1e-9);
    assert_near(tangent_mismatch(g), 0, 2e-6);
}

static void check_root_point(const struct cut_gear *g) {
    struct qg_polar start = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, 0);
    assert_near(start.radius, g->gear.root_radius, 1e-9);
    double flat = g->geometry.hob_tip_center_offset / g->geometry.reference_radius;
    assert_near(start.angle, M_PI / g->gear.teeth - flat, 1e-12);
    double last = start.radius;
    for (int k = 1; k <= 50; k++) {
        double radius = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, k / 50.0).radius;
        assert_true(radius >= last);
        last = radius;
    }
}

/* Squared distance between a point of the root curve, fixed to the gear, and the centre of the hob's rounding, when
 * the gear has turned by `turned` and the hob has moved on with it. Axis x through the middle of the space, gear at
 * the origin. */
static double to_hob_tip(const struct cut_gear *g, struct qg_polar point, double turned) {
    double angle = M_PI / g->gear.teeth - point.angle + turned;
    double center_x = g->gear.root_radius + g->gear.hob_tip_radius;
    double center_y = g->geometry.hob_tip_center_offset + g->geometry.reference_radius * turned;
    double dx = point.radius * cos(angle) - center_x, dy = point.radius * sin(angle) - center_y;
    return dx * dx + dy * dy;
}

/* Half its derivative with respect to `turned`. */
static double to_hob_tip_slope(const struct cut_gear *g, struct qg_polar point, double turned) {
    double angle = M_PI / g->gear.teeth - point.angle + turned, r = g->geometry.reference_radius;
    double dx = point.radius * cos(angle) - g->gear.root_radius - g->gear.hob_tip_radius;
    double dy = point.radius * sin(angle) - g->geometry.hob_tip_center_offset - r * turned;
    return -dx * point.radius * sin(angle) + dy * (point.radius * cos(angle) - r);
}

/* Independent of how the curve is generated: a hob that rolls past touches each of its points once and enters none. */
static void check_envelope(const struct cut_gear *g, double parameter) {
    enum { STEPS = 400 };
    struct qg_polar point = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, parameter);
    double range = 6 * g->rack.module / g->geometry.reference_radius, step = 2 * range / STEPS, nearest = 0;
    for (int i = 0; i <= STEPS; i++) {
        double turned = -range + i * step;
        if (i == 0 || to_hob_tip(g, point, turned) < to_hob_tip(g, point, nearest))
            nearest = turned;
    }
    double low = nearest - step, high = nearest + step;
    for (int i = 0; i < 80; i++) {
        double middle = (low + high) / 2;
        if (to_hob_tip_slope(g, point, middle) < 0)
            low = middle;
        else
            high = middle;
    }
    assert_near(sqrt(to_hob_tip(g, point, low)), g->gear.hob_tip_radius, 1e-9 * g->geometry.reference_radius);
}

static void root_curve_meets_the_involute(void **state) {
    (void)state;
    struct dice dice = {1};
    for (int i = 0; i < 4000; i++) {
        struct cut_gear g = random_gear(&dice);
        check_form_point(&g);
        check_root_point(&g);
    }
}

static void root_curve_is_the_hobs_envelope(void **state) {
    (void)state;
    struct dice dice = {2};
    for (int i = 0; i < 300; i++) {
        struct cut_gear g = random_gear(&dice);
        for (int k = 0; k < 4; k++)
            check_envelope(&g, dice_between(&dice, 0, 1));
    }
}

/* Sharp hob tips, fully rounded ones, and shifts so large that the reference circle lies below the root. */
static void root_curve_holds_at_the_extremes(void **state) {
    (void)state;
    struct dice dice = {3};
    int above = 0;
    for (int i = 0; i < 3000; i++) {
        struct cut_gear g = random_gear(&dice);
        double m = g.rack.module, sine = sin(g.rack.pressure_angle);
        if (i % 3 == 0) {
            g.gear.hob_tip_radius = 0;
        } else if (i % 3 == 1) {
            g.gear.hob_tip_radius = (M_PI * m / 4 - g.geometry.hob_addendum * tan(g.rack.pressure_angle)) *
                                    cos(g.rack.pressure_angle) / (1 - sine) * (1 - 1e-14);
        } else {
            double shift = dice_between(&dice, 1.2, 1.8) * m, addendum = dice_between(&dice, 0.6, 1.1) * m;
            g.gear.teeth = dice_integer(&dice, 40, 150);
            g.gear.profile_shift = shift;
            g.gear.root_radius = m * g.gear.teeth / 2 + shift - addendum;
            g.gear.outside_radius = g.gear.root_radius + 1.2 * m;
            g.gear.bore_diameter = g.gear.root_radius;
            g.gear.hob_tip_radius = 0.1 * m;
        }
        if (qg_gear_derive(&g.rack, &g.gear, 7.85e-6, "", &g.geometry, NULL) != QG_OK)
            continue;
        above += g.gear.root_radius > g.geometry.reference_radius;
        check_form_point(&g);
        check_root_point(&g);
        check_envelope(&g, dice_between(&dice, 0, 1));
    }
    assert_true(above > 300);
}

/* ---- refusals --------------------------------------------------------------------------------------------------- */

/* Derives and returns the note about `where`, which must be there. */
static const struct qg_note *refused(const struct qg_gear *gear, const char *where, struct qg_notes *notes) {
    const struct qg_rack rack = {3, 20 * CASE_DEGREE};
    struct qg_gear_geometry out;
    *notes = (struct qg_notes){0};
    assert_int_equal(qg_gear_derive(&rack, gear, 7.85e-6, "pinion.", &out, notes), QG_IMPOSSIBLE_GEAR);
    const struct qg_note *note = note_about(notes, where);
    if (!note)
        fail_msg("no note about %s; the first is about %s: %s", where, notes->item[0].where, notes->item[0].text);
    assert_int_equal(qg_gear_derive(&rack, gear, 7.85e-6, "pinion.", &out, NULL), QG_IMPOSSIBLE_GEAR);
    return note;
}

/* The note must hold every one of the texts. */
static void assert_says(const struct qg_note *note, const char *const *texts, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!strstr(note->text, texts[i]))
            fail_msg("\"%s\" does not say \"%s\"", note->text, texts[i]);
}
#define SAYS(note, ...)                                                                                                \
    assert_says(note, (const char *const[]){__VA_ARGS__}, sizeof(const char *[]){__VA_ARGS__} / sizeof(char *))

static struct qg_gear pinion_of_S(void) {
    const struct qg_gear_pair pair = CASE_S;
    return pair.gears[QG_PINION];
}

static void undercut_is_refused(void **state) {
    (void)state;
    struct qg_notes notes;
    struct qg_gear gear = {.teeth = 10,
                           .outside_radius = 18,
                           .root_radius = 11.25,
                           .hob_tip_radius = 0.9,
                           .bore_diameter = 10,
                           .face_width = 10};
    /* the flank ends 3.75 - 0.9 (1 - sin 20) = 3.1578 mm deep, r sin^2 20 = 1.7547 mm */
    SAYS(refused(&gear, "pinion.root_radius", &notes), "undercut", "3.1578", "1.7547");
    assert_int_equal(notes.count, 1);
    /* just at the limit by shift: depth = 1.7547 needs a shift of 1.4031 mm */
    gear.profile_shift = 1.4032;
    gear.root_radius = 11.25 + gear.profile_shift;
    struct qg_gear_geometry out;
    const struct qg_rack rack = {3, 20 * CASE_DEGREE};
    assert_int_equal(qg_gear_derive(&rack, &gear, 7.85e-6, "", &out, NULL), QG_OK);
    assert_near(out.form_radius, out.base_radius, 1e-3);
    gear.profile_shift = 1.4030;
    gear.root_radius = 11.25 + gear.profile_shift;
    refused(&gear, "pinion.root_radius", &notes);
}

static void pointed_tooth_is_refused(void **state) {
    (void)state;
    struct qg_notes notes;
    struct qg_gear gear = pinion_of_S();
    gear.outside_radius = 49;
    SAYS(refused(&gear, "pinion.outside_radius", &notes), "pointed", "49.0000", "-");
    assert_int_equal(notes.count, 1);
}

static void radii_out_of_order_are_refused(void **state) {
    (void)state;
    struct qg_notes notes;
    struct qg_gear gear = pinion_of_S();
    gear.outside_radius = 40.3; /* between root and form radius */
    SAYS(refused(&gear, "pinion.outside_radius", &notes), "40.3000", "40.4654", "39.5500");
    gear = pinion_of_S();
    gear.root_radius = 44; /* above reference radius plus shift: 43.927 */
    SAYS(refused(&gear, "pinion.root_radius", &notes), "43.9270", "44.0000");
}

static void hob_tip_too_large_is_refused(void **state) {
    (void)state;
    struct qg_notes notes;
    struct qg_gear gear = pinion_of_S();
    gear.hob_tip_radius = 2;
    /* (3 pi/4 - 4.377 tan 20) cos 20 / (1 - sin 20) = 1.0898 */
    SAYS(refused(&gear, "pinion.hob_tip_radius", &notes), "2.0000", "4.3770", "1.0898");
    gear.hob_tip_radius = 1.0898;
    struct qg_gear_geometry out;
    const struct qg_rack rack = {3, 20 * CASE_DEGREE};
    assert_int_equal(qg_gear_derive(&rack, &gear, 7.85e-6, "", &out, NULL), QG_OK);
    gear.hob_tip_radius = 1.0899;
    refused(&gear, "pinion.hob_tip_radius", &notes);
}

static void bore_too_large_is_refused(void **state) {
    (void)state;
    struct qg_notes notes;
    struct qg_gear gear = pinion_of_S();
    gear.bore_diameter = 76.2; /* 2 * 39.55 - 3 = 76.1 */
    SAYS(refused(&gear, "pinion.bore_diameter", &notes), "76.2000", "76.1000");
    gear.bore_diameter = 76.09;
    struct qg_gear_geometry out;
    const struct qg_rack rack = {3, 20 * CASE_DEGREE};
    assert_int_equal(qg_gear_derive(&rack, &gear, 7.85e-6, "", &out, NULL), QG_OK);
    /* a root far above the base circle lets the bore pass it */
    gear = (struct qg_gear){.teeth = 60,
                            .profile_shift = 3,
                            .outside_radius = 96,
                            .root_radius = 90,
                            .hob_tip_radius = 0.5,
                            .bore_diameter = 172,
                            .face_width = 10};
    SAYS(refused(&gear, "pinion.bore_diameter", &notes), "84.5723", "moment_of_inertia");
    gear.moment_of_inertia = 100;
    assert_int_equal(qg_gear_derive(&rack, &gear, 7.85e-6, "", &out, NULL), QG_OK);
}

static void senseless_figures_are_refused(void **state) {
    (void)state;
    const struct {
        size_t offset;
        const char *where;
        bool may_be_zero;
    } members[] = {
        {offsetof(struct qg_gear, outside_radius), "pinion.outside_radius", false},
        {offsetof(struct qg_gear, root_radius), "pinion.root_radius", false},
        {offsetof(struct qg_gear, hob_tip_radius), "pinion.hob_tip_radius", true},
        {offsetof(struct qg_gear, bore_diameter), "pinion.bore_diameter", false},
        {offsetof(struct qg_gear, face_width), "pinion.face_width", false},
        {offsetof(struct qg_gear, moment_of_inertia), "pinion.moment_of_inertia", true},
    };
    struct qg_notes notes;
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        const double bad[] = {NAN, INFINITY, -INFINITY, -1, 0};
        for (int k = 0; k < (members[i].may_be_zero ? 4 : 5); k++) {
            struct qg_gear gear = pinion_of_S();
            memcpy((char *)&gear + members[i].offset, &bad[k], sizeof bad[k]);
            refused(&gear, members[i].where, &notes);
            assert_int_equal(notes.count, 1);
        }
    }
    struct qg_gear gear = pinion_of_S();
    gear.profile_shift = NAN;
    refused(&gear, "pinion.profile_shift", &notes);
    gear = pinion_of_S();
    gear.teeth = 4;
    SAYS(refused(&gear, "pinion.teeth", &notes), "4", "5");
}

static void notes_beyond_the_room_are_counted(void **state) {
    (void)state;
    struct qg_notes notes = {0};
    char longest[1000];
    memset(longest, 'x', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    for (int i = 0; i < QG_NOTES_ROOM + 3; i++)
        qg_notes_add(&notes, longest, "%s %d", longest, i);
    assert_int_equal(notes.count, QG_NOTES_ROOM);
    assert_int_equal(notes.lost, 3);
    assert_int_equal(strlen(notes.item[0].where), sizeof notes.item[0].where - 1);
    assert_int_equal(strlen(notes.item[0].text), sizeof notes.item[0].text - 1);
    qg_notes_add(NULL, "", "nothing");
    for (int s = 0; s < QG_STATUS_COUNT; s++)
        assert_true(strlen(qg_status_text((enum qg_status)s)) > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(form_radii_match_the_reference),
        cmocka_unit_test(radii_and_pitch_follow_their_definitions),
        cmocka_unit_test(half_angle_is_that_of_an_unwound_string),
        cmocka_unit_test(inertia_is_a_hollow_disc_or_the_given_one),
        cmocka_unit_test(root_curve_meets_the_involute),
        cmocka_unit_test(root_curve_is_the_hobs_envelope),
        cmocka_unit_test(root_curve_holds_at_the_extremes),
        cmocka_unit_test(undercut_is_refused),
        cmocka_unit_test(pointed_tooth_is_refused),
        cmocka_unit_test(radii_out_of_order_are_refused),
        cmocka_unit_test(hob_tip_too_large_is_refused),
        cmocka_unit_test(bore_too_large_is_refused),
        cmocka_unit_test(senseless_figures_are_refused),
        cmocka_unit_test(notes_beyond_the_room_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
