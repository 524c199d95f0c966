/* Two gears in mesh: known figures of the cases, backlash by moving flanks, and every reason to refuse. */
#include "tests/core/cases.h"

/* ---- known figures ---------------------------------------------------------------------------------------------- */

static void cases_have_the_known_figures(void **state) {
    (void)state;
    struct qg_pair_geometry g;
    struct qg_notes notes = {0};
    assert_int_equal(qg_pair_derive(&all_cases[0].pair, &g, &notes), QG_OK);
    assert_near(g.backlash, 0.31208, 5e-6);
    assert_near(g.contact_ratio, 1.2171, 5e-5);
    assert_near_share(g.equivalent_mass, 0.32707, 1e-4);
    assert_int_equal(qg_pair_derive(&all_cases[1].pair, &g, &notes), QG_OK);
    assert_near(g.backlash, 0.3136, 5e-5);
    assert_near(g.contact_ratio, 2.0063, 5e-5);
    assert_int_equal(qg_pair_derive(&all_cases[2].pair, &g, &notes), QG_OK);
    assert_int_equal(notes.count, 0);
}

/* The paper's natural frequency: 305 572 N/mm over the equivalent mass gives 4865 Hz. */
static void equivalent_mass_gives_the_papers_frequency(void **state) {
    (void)state;
    struct qg_pair_geometry g;
    assert_int_equal(qg_pair_derive(&all_cases[0].pair, &g, NULL), QG_OK);
    assert_near(sqrt(305572e3 / g.equivalent_mass) / (2 * M_PI), 4864.7, 0.5);
}

/* Where the tips cut the line of action, found on the circles themselves: |O + xi e - O_gear| = tip radius. */
static void path_of_contact_ends_at_the_tips(void **state) {
    (void)state;
    struct dice dice = {21};
    for (int i = 0; i < 300; i++) {
        struct qg_pair_geometry g;
        struct qg_gear_pair p = random_pair(&dice, &g);
        double rb1 = g.gears[0].base_radius, w = g.working_pressure_angle, a = p.center_distance;
        /* the line touches the pinion's base circle at rb1 (cos w, sin w) and runs along (sin w, -cos w) */
        for (int k = 0; k < 2; k++) {
            double xi = k == 0 ? g.path_end : g.path_start;
            double x = rb1 * cos(w) + xi * sin(w), y = rb1 * sin(w) - xi * cos(w);
            double radius = k == 0 ? hypot(x, y) : hypot(x - a, y);
            assert_near(radius, p.gears[k].outside_radius, 1e-10 * a);
        }
        double x = rb1 * cos(w) + g.line_length * sin(w), y = rb1 * sin(w) - g.line_length * cos(w);
        assert_near(hypot(x - a, y), g.gears[1].base_radius, 1e-10 * a);
        assert_near(g.contact_ratio * g.base_pitch, g.path_end - g.path_start, 1e-10);
        assert_near(g.tip_clearance[0], 0.25 * p.rack.module, 1e-10 * a);
        assert_near(g.tip_clearance[1], 0.25 * p.rack.module, 1e-10 * a);
        assert_near(g.face_width, fmin(p.gears[0].face_width, p.gears[1].face_width), 0);
        double mass = g.gears[0].moment_of_inertia / (rb1 * rb1);
        double other = g.gears[1].moment_of_inertia / (g.gears[1].base_radius * g.gears[1].base_radius);
        assert_near_share(g.equivalent_mass, mass * other / (mass + other), 1e-12);
    }
}

/* ---- backlash by moving flanks ---------------------------------------------------------------------------------- */

/* The involute's half tooth angle, written down once more. */
static double half_angle(const struct qg_gear_pair *p, int gear, double radius) {
    double r = p->rack.module * p->gears[gear].teeth / 2, alpha = p->rack.pressure_angle;
    double thickness = M_PI * p->rack.module / 2 + 2 * p->gears[gear].profile_shift * tan(alpha);
    double at = acos(r * cos(alpha) / radius);
    return thickness / (2 * r) + tan(alpha) - alpha - tan(at) + at;
}

/* A pinion's tooth points at the gear, which shows it the middle of a space and is then turned by `turned`. Angle by
 * which the gear's flank point at `radius` clears the pinion's flank. */
static double clearance(const struct qg_gear_pair *p, double turned, double radius) {
    double angle = M_PI - M_PI / p->gears[1].teeth + half_angle(p, 1, radius) + turned;
    double x = p->center_distance + radius * cos(angle), y = radius * sin(angle), from_pinion = hypot(x, y);
    return atan2(y, x) - half_angle(p, 0, from_pinion);
}

/* The smallest clearance over the gear's flank: dense search, then ternary search about the best. */
static double least_clearance(const struct qg_gear_pair *p, const struct qg_pair_geometry *g, double turned) {
    enum { STEPS = 200 };
    double low = g->gears[1].form_radius, high = p->gears[1].outside_radius, step = (high - low) / STEPS;
    double best = INFINITY, at = low;
    for (int i = 0; i <= STEPS; i++) {
        double radius = low + i * step;
        double angle = M_PI - M_PI / p->gears[1].teeth + half_angle(p, 1, radius) + turned;
        double from_pinion = hypot(p->center_distance + radius * cos(angle), radius * sin(angle));
        if (from_pinion < g->gears[0].form_radius || from_pinion > p->gears[0].outside_radius)
            continue;
        double value = clearance(p, turned, radius);
        if (value < best) {
            best = value;
            at = radius;
        }
    }
    double a = at - step, b = at + step;
    for (int i = 0; i < 60; i++) {
        double left = a + (b - a) / 3, right = b - (b - a) / 3;
        if (clearance(p, turned, left) < clearance(p, turned, right))
            b = right;
        else
            a = left;
    }
    return fmin(best, clearance(p, turned, (a + b) / 2));
}

/* The gear turns until the flanks touch; by symmetry it may turn as far the other way. */
static double backlash_by_turning(const struct qg_gear_pair *p, const struct qg_pair_geometry *g) {
    double low = 0, high = p->rack.module / p->gears[1].outside_radius;
    for (int i = 0; i < 45; i++) {
        double middle = (low + high) / 2;
        if (least_clearance(p, g, middle) > 0)
            low = middle;
        else
            high = middle;
    }
    return 2 * low * g->gears[1].base_radius;
}

static void backlash_is_what_the_gear_can_turn(void **state) {
    (void)state;
    struct dice dice = {22};
    for (int i = 0; i < 30 + CASE_COUNT; i++) {
        struct qg_pair_geometry g;
        struct qg_gear_pair p;
        if (i < CASE_COUNT) {
            p = all_cases[i].pair;
            assert_int_equal(qg_pair_derive(&p, &g, NULL), QG_OK);
        } else {
            p = random_pair(&dice, &g);
        }
        assert_near(backlash_by_turning(&p, &g), g.backlash, 1e-7);
    }
}

/* ---- refusals --------------------------------------------------------------------------------------------------- */

/* Derives, and returns the note about `where` that holds all of the texts (ended by NULL); it must be there. */
static void refused(const struct qg_gear_pair *pair, const char *where, const char *const *texts) {
    struct qg_pair_geometry out;
    struct qg_notes notes = {0};
    assert_int_equal(qg_pair_derive(pair, &out, &notes), QG_IMPOSSIBLE_GEAR);
    assert_int_equal(qg_pair_derive(pair, &out, NULL), QG_IMPOSSIBLE_GEAR);
    for (size_t i = 0; i < notes.count; i++) {
        size_t k = 0;
        while (texts[k] && strstr(notes.item[i].text, texts[k]))
            k++;
        if (strcmp(notes.item[i].where, where) == 0 && !texts[k])
            return;
    }
    for (size_t i = 0; i < notes.count; i++)
        print_message("%s: %s\n", notes.item[i].where, notes.item[i].text);
    fail_msg("none of the notes above is about %s and says %s ...", where, texts[0]);
}
#define REFUSED(pair, where, ...) refused(pair, where, (const char *const[]){__VA_ARGS__, NULL})

static void negative_backlash_is_refused(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    struct qg_pair_geometry g;
    pair.center_distance = 110.6;
    assert_int_equal(qg_pair_derive(&pair, &g, NULL), QG_IMPOSSIBLE_GEAR);
    assert_true(g.backlash < 0);
    char overlap[32];
    snprintf(overlap, sizeof overlap, "%.4f", -g.backlash);
    REFUSED(&pair, "center_distance", "negative backlash", overlap, "110.6000");
}

/* The sign that print lost: with +0.766 the teeth overlap by 0.633 mm, and the hob tip no longer fits the deeper
 * space. Both are said, whichever comes first. */
static void case_H_with_the_sign_lost_is_refused(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_H;
    pair.gears[QG_GEAR].profile_shift = 0.766;
    REFUSED(&pair, "gear.hob_tip_radius", "0.6000", "4.8660", "0.2021");
    REFUSED(&pair, "center_distance", "negative backlash", "0.6332");
    pair.gears[QG_GEAR].hob_tip_radius = 0.2;
    REFUSED(&pair, "center_distance", "negative backlash", "0.6332");
}

/* The outside radius that just reaches the mate's form point passes, a little more digs in. Of random pairs those
 * are used where the tip gets there before it meets the mate's root circle or ends in a point. */
static void interference_names_the_tip_that_digs_in(void **state) {
    (void)state;
    struct dice dice = {23};
    int tried = 0;
    for (int i = 0; i < 200; i++) {
        struct qg_pair_geometry g;
        struct qg_gear_pair pair = random_pair(&dice, &g);
        int k = i % 2;
        const struct qg_gear_geometry *mate = &g.gears[1 - k], *own = &g.gears[k];
        double needed = sqrt(mate->form_radius * mate->form_radius - mate->base_radius * mate->base_radius);
        double most = hypot(own->base_radius, g.line_length - needed);
        pair.gears[k].outside_radius = most + 0.01;
        bool pointed = qg_half_tooth_angle(&pair.rack, own, most + 0.01) <= 0;
        if (pointed || most + 0.01 >= pair.center_distance - pair.gears[1 - k].root_radius)
            continue;
        tried++;
        char form[32], outside[32];
        snprintf(form, sizeof form, "%.4f", mate->form_radius);
        snprintf(outside, sizeof outside, "%.4f", most + 0.01);
        REFUSED(&pair, k == 0 ? "pinion.outside_radius" : "gear.outside_radius", "interference", form, outside);
        pair.gears[k].outside_radius = most - 1e-9;
        assert_int_equal(qg_pair_derive(&pair, &g, NULL), QG_OK);
    }
    assert_true(tried >= 20);
}

static void tip_in_the_mates_root_is_refused(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    pair.gears[QG_GEAR].outside_radius = 111 - 39.55 + 0.0123;
    REFUSED(&pair, "gear.outside_radius", "root of its mate", "0.0123");
    pair = (struct qg_gear_pair)CASE_S;
    pair.gears[QG_PINION].outside_radius = 111 - 63.1 + 0.0123;
    REFUSED(&pair, "pinion.outside_radius", "root of its mate", "0.0123");
}

static void lost_contact_is_refused(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    pair.gears[QG_PINION].outside_radius = 45.5;
    struct qg_pair_geometry g;
    assert_int_equal(qg_pair_derive(&pair, &g, NULL), QG_IMPOSSIBLE_GEAR);
    char ratio[32];
    snprintf(ratio, sizeof ratio, "contact ratio %.4f", g.contact_ratio);
    assert_true(g.contact_ratio < 1);
    REFUSED(&pair, "center_distance", ratio, "111.0000");
}

static void center_distance_below_the_base_circles_is_refused(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    pair.center_distance = 100; /* (42 + 64.5) cos 20 = 100.0773 */
    REFUSED(&pair, "center_distance", "100.0000", "100.0773");
}

static void faults_of_both_gears_are_named(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    pair.gears[QG_PINION].face_width = -1;
    pair.gears[QG_GEAR].bore_diameter = 125;
    REFUSED(&pair, "pinion.face_width", "-1");
    REFUSED(&pair, "gear.bore_diameter", "125.0000", "123.2000");
}

static void senseless_common_figures_are_refused(void **state) {
    (void)state;
    const struct {
        size_t offset;
        const char *where;
        double bad[5];
    } members[] = {
        {offsetof(struct qg_gear_pair, rack.module), "module", {0, -1, NAN, INFINITY, -INFINITY}},
        {offsetof(struct qg_gear_pair, rack.pressure_angle), "pressure_angle", {0, -0.1, NAN, M_PI_4, 2}},
        {offsetof(struct qg_gear_pair, center_distance), "center_distance", {0, -1, NAN, INFINITY, -INFINITY}},
        {offsetof(struct qg_gear_pair, material.youngs_modulus), "material.youngs_modulus", {0, -1, NAN, INFINITY, -5}},
        {offsetof(struct qg_gear_pair, material.poisson_ratio), "material.poisson_ratio", {-0.1, 0.5, NAN, 0.6, -1e-9}},
        {offsetof(struct qg_gear_pair, material.density), "material.density", {0, -1, NAN, INFINITY, -5}},
        {offsetof(struct qg_gear_pair, damping_ratio), "damping_ratio", {0, 1, NAN, -1, 2}},
        {offsetof(struct qg_gear_pair, nominal_torque), "nominal_torque", {0, -1, NAN, INFINITY, -5}},
    };
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        for (int k = 0; k < 5; k++) {
            struct qg_gear_pair pair = CASE_S;
            memcpy((char *)&pair + members[i].offset, &members[i].bad[k], sizeof(double));
            REFUSED(&pair, members[i].where, "found", "allowed");
        }
    struct qg_gear_pair pair = CASE_S;
    struct qg_pair_geometry g;
    pair.material.poisson_ratio = 0;
    assert_int_equal(qg_pair_derive(&pair, &g, NULL), QG_OK);
    pair.material.poisson_ratio = -1;
    REFUSED(&pair, "material.poisson_ratio", "0 or more");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cases_have_the_known_figures),
        cmocka_unit_test(equivalent_mass_gives_the_papers_frequency),
        cmocka_unit_test(path_of_contact_ends_at_the_tips),
        cmocka_unit_test(backlash_is_what_the_gear_can_turn),
        cmocka_unit_test(negative_backlash_is_refused),
        cmocka_unit_test(case_H_with_the_sign_lost_is_refused),
        cmocka_unit_test(interference_names_the_tip_that_digs_in),
        cmocka_unit_test(tip_in_the_mates_root_is_refused),
        cmocka_unit_test(lost_contact_is_refused),
        cmocka_unit_test(center_distance_below_the_base_circles_is_refused),
        cmocka_unit_test(faults_of_both_gears_are_named),
        cmocka_unit_test(senseless_common_figures_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
