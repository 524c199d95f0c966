/* Profiles: pieces that fit together, arcs and chords within their tolerance of the exact profile, the relief on the
 * flank, and teeth of the mounted pair that touch where the theory says. */
#include "tests/core/cases.h"

#include "core/profile.h"

static const double exact = 1e-9;

/* Reliefs of every sort on case S and others: scaled to the gear, tip and root. */
static struct qg_relief relief_on(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int sort) {
    struct qg_relief relief = {.shape = sort & 1 ? QG_SHAPE_PARABOLIC : QG_SHAPE_LINEAR,
                               .ramp = sort & 2 ? QG_RAMP_ROLL_ANGLE : QG_RAMP_RADIUS};
    for (int i = 0; i < 2 && sort < 8; i++) {
        double form = g->gears[i].form_radius, height = pair->gears[i].outside_radius - form;
        relief.gears[i].tip = (struct qg_ramp){true, form + 0.7 * height, 0.011 * pair->rack.module};
        relief.gears[i].root = (struct qg_ramp){(sort & 4) != 0, form + 0.2 * height, 0.006 * pair->rack.module};
    }
    return relief;
}

struct subject {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_relief relief;
    struct qg_profile profile[2];
};

/* Sorts 0 to 7 are reliefs, 8 is none. */
static void make(struct subject *s, const struct qg_gear_pair *pair, int sort) {
    s->pair = *pair;
    assert_int_equal(qg_pair_derive(&s->pair, &s->geometry, NULL), QG_OK);
    s->relief = relief_on(&s->pair, &s->geometry, sort);
    assert_int_equal(qg_relief_check(&s->relief, &s->pair, &s->geometry, NULL, NULL), QG_OK);
    for (int i = 0; i < 2; i++)
        qg_profile_init(&s->profile[i], &(struct qg_made_gear){&s->pair, &s->geometry, &s->relief, i});
}

typedef void visit(const struct subject *s, int gear);

static void for_all(visit *check) {
    for (int c = 0; c < CASE_COUNT; c++)
        for (int sort = 0; sort <= 8; sort++) {
            struct subject s;
            make(&s, &all_cases[c].pair, sort);
            check(&s, QG_PINION);
            check(&s, QG_GEAR);
        }
}

static void check_joints(const struct subject *s, int gear) {
    const struct qg_profile *p = &s->profile[gear];
    for (size_t i = 0; i + 1 < p->count; i++) {
        struct qg_point end = qg_profile_at(p, i, 1), next = qg_profile_at(p, i + 1, 0);
        assert_near(hypot(end.x - next.x, end.y - next.y), 0, exact);
    }
    struct qg_point first = qg_profile_at(p, 0, 0), last = qg_profile_at(p, p->count - 1, 1);
    assert_near(hypot(first.x, first.y), s->pair.gears[gear].root_radius, exact);
    assert_near(atan2(first.y, first.x), M_PI / s->pair.gears[gear].teeth, exact);
    assert_near(hypot(last.x, last.y), s->pair.gears[gear].outside_radius, exact);
    assert_near(last.y, 0, exact);
}

static void pieces_join(void **state) {
    (void)state;
    for_all(check_joints);
}

/* The removed amount, measured: the involute's own tangent line to the base circle through the relieved point meets the
 * involute further out by the relief. The involute is made here from the half tooth angle alone. */
static void check_depths(const struct subject *s, int gear) {
    const struct qg_gear_geometry *g = &s->geometry.gears[gear];
    for (size_t i = 0; i < s->profile[gear].count; i++)
        for (int k = 0; k <= 20 && s->profile[gear].piece[i].kind == QG_PIECE_FLANK; k++) {
            struct qg_point p = qg_profile_at(&s->profile[gear], i, k / 20.0);
            double roll = qg_roll_length(g, hypot(p.x, p.y)), tangent = atan2(p.y, p.x) - atan2(roll, g->base_radius);
            double base_angle = qg_half_tooth_angle(&s->pair.rack, g, g->base_radius);
            double involute_roll =
                (base_angle - tangent) * g->base_radius; /* of the string that ends on this tangent */
            double wanted =
                qg_relief_depth(&s->relief, &s->geometry, &s->pair, gear, hypot(g->base_radius, involute_roll));
            assert_near(involute_roll - roll, wanted, exact);
        }
}

static void flank_is_the_involute_less_the_relief(void **state) {
    (void)state;
    for_all(check_depths);
}

/* Largest distance of the exact profile from an outline, 400 places on each piece. */
static double worst_distance(const struct qg_profile *p, const struct qg_outline *outline) {
    double worst = 0;
    for (size_t i = 0; i < p->count; i++)
        for (int k = 0; k <= 400; k++) {
            struct qg_point at = qg_profile_at(p, i, k / 400.0);
            double nearest = INFINITY;
            for (size_t e = 0; e + 1 < outline->count; e++)
                nearest = fmin(nearest, qg_edge_distance(&outline->corner[e], &outline->corner[e + 1], at));
            worst = fmax(worst, nearest);
        }
    return worst;
}

static void check_arcs(const struct subject *s, int gear) {
    struct qg_outline arcs = {0}, chords = {0};
    assert_int_equal(qg_profile_arcs(&s->profile[gear], 1e-4, &arcs), QG_OK);
    assert_int_equal(qg_profile_chords(&s->profile[gear], 1e-3, &chords), QG_OK);
    assert_in_range(arcs.count, 8, 40);
    assert_in_range(chords.count, 20, 80);
    assert_true(worst_distance(&s->profile[gear], &arcs) <= 1e-4);
    assert_true(worst_distance(&s->profile[gear], &chords) <= 1e-3);
    qg_outline_finish(&arcs);
    qg_outline_finish(&chords);
}

static void few_arcs_hold_a_tenth_of_a_micrometre(void **state) {
    (void)state;
    for_all(check_arcs);
}

/* Tangent directions at both ends of an edge: the chord's, less and plus half of the arc's angle. */
static double direction(const struct qg_corner *from, const struct qg_corner *to, double side) {
    return atan2(to->y - from->y, to->x - from->x) + side * 2 * atan(from->bulge);
}

static void arcs_have_no_kinks_of_their_own(void **state) {
    (void)state;
    struct subject s;
    make(&s, &all_cases[0].pair,
         8); /* without a relief only the tip corner is a kink, and the root circle's end is none */
    struct qg_outline arcs = {0};
    assert_int_equal(qg_profile_arcs(&s.profile[0], 1e-4, &arcs), QG_OK);
    int kinks = 0;
    for (size_t i = 0; i + 2 < arcs.count; i++) {
        double turn = direction(&arcs.corner[i + 1], &arcs.corner[i + 2], -1) -
                      direction(&arcs.corner[i], &arcs.corner[i + 1], 1);
        kinks += fabs(remainder(turn, 2 * M_PI)) > 1e-6;
    }
    assert_int_equal(kinks, 1);
    qg_outline_finish(&arcs);
}

/* Area within a closed chain of arcs: polygon and circular segments. */
static double area(const struct qg_outline *o) {
    double sum = 0;
    for (size_t i = 0; i < o->count; i++) {
        const struct qg_corner *a = &o->corner[i], *b = &o->corner[(i + 1) % o->count];
        double angle = 4 * atan(a->bulge), half = hypot(b->x - a->x, b->y - a->y) / 2;
        sum += (a->x * b->y - b->x * a->y) / 2;
        if (a->bulge != 0)
            sum += half * half / (sin(angle / 2) * sin(angle / 2)) * (angle - sin(angle)) / 2;
    }
    return sum;
}

static void check_ring(const struct subject *s, int gear) {
    struct qg_outline tooth = {0}, fine = {0}, ring = {0};
    int z = s->pair.gears[gear].teeth;
    assert_int_equal(qg_profile_arcs(&s->profile[gear], 1e-6, &tooth), QG_OK);
    size_t half = tooth.count;
    assert_int_equal(qg_outline_mirror(&tooth), QG_OK);
    assert_int_equal(tooth.count, 2 * half - 2);
    assert_int_equal(qg_outline_ring(&tooth, z, &ring), QG_OK);
    assert_int_equal(ring.count, (size_t)z * (2 * half - 4));
    assert_int_equal(qg_profile_chords(&s->profile[gear], 1e-6, &fine), QG_OK);
    assert_int_equal(qg_outline_mirror(&fine), QG_OK);
    double one = 0; /* twice the area between the axis and one tooth, by fine chords */
    for (size_t i = 0; i + 1 < fine.count; i++)
        one += fine.corner[i].x * fine.corner[i + 1].y - fine.corner[i + 1].x * fine.corner[i].y;
    assert_true(area(&ring) < 0); /* clockwise */
    assert_near_share(area(&ring), one / 2 * z, 1e-6);
    qg_outline_finish(&tooth);
    qg_outline_finish(&fine);
    qg_outline_finish(&ring);
}

static void a_ring_is_z_teeth(void **state) {
    (void)state;
    for_all(check_ring);
}

static void reversed_twice_is_the_same(void **state) {
    (void)state;
    struct subject s;
    make(&s, &all_cases[1].pair, 5);
    struct qg_outline there = {0}, back = {0};
    assert_int_equal(qg_profile_arcs(&s.profile[1], 1e-4, &there), QG_OK);
    assert_int_equal(qg_profile_arcs(&s.profile[1], 1e-4, &back), QG_OK);
    qg_outline_reverse(&back);
    assert_true(back.corner[0].x == there.corner[there.count - 1].x);
    assert_true(worst_distance(&s.profile[1], &back) <= 1e-4);
    qg_outline_reverse(&back);
    assert_memory_equal(there.corner, back.corner, there.count * sizeof *there.corner);
    qg_outline_finish(&there);
    qg_outline_finish(&back);
}

/* A point of the world in the frame of a tooth of the mounted pair. */
static struct qg_point in_tooth(const struct subject *s, const struct qg_mounted *m, int gear, struct qg_point p) {
    double x = p.x - (gear == QG_GEAR ? s->pair.center_distance : 0), angle = -m->angle[gear];
    return (struct qg_point){x * cos(angle) - p.y * sin(angle), x * sin(angle) + p.y * cos(angle)};
}

/* At every position the reference pair's contact lies on both bare flanks, with the same normal. */
static void mounted_teeth_touch(void **state) {
    (void)state;
    for (int c = 0; c < CASE_COUNT; c++) {
        struct subject s;
        make(&s, &all_cases[c].pair, 8);
        for (int k = 0; k <= 12; k++) {
            struct qg_mounted m;
            qg_mounted_at(&s.geometry, &s.pair, k / 12.0, &m);
            assert_in_range(m.count, (int)s.geometry.contact_ratio, (int)s.geometry.contact_ratio + 1);
            for (size_t t = 0; t < m.count; t++)
                for (int gear = 0; gear < 2; gear++) {
                    const struct qg_gear_geometry *g = &s.geometry.gears[gear];
                    double pitch = 2 * M_PI / s.pair.gears[gear].teeth * (gear == QG_PINION ? -1 : 1);
                    struct qg_point p = in_tooth(&s, &m, gear, m.touch[t].at);
                    double radius = hypot(p.x, p.y), angle = atan2(p.y, p.x) + m.touch[t].pair * pitch;
                    assert_near(radius, hypot(g->base_radius, m.touch[t].roll[gear]), exact);
                    assert_near(remainder(angle - qg_half_tooth_angle(&s.pair.rack, g, radius), 2 * M_PI), 0, exact);
                }
        }
    }
}

/* One mesh period turns each gear by one tooth, against each other. */
static void a_period_is_one_tooth(void **state) {
    (void)state;
    struct subject s;
    struct qg_mounted from, to;
    make(&s, &all_cases[0].pair, 0);
    qg_mounted_at(&s.geometry, &s.pair, 0, &from);
    qg_mounted_at(&s.geometry, &s.pair, 1, &to);
    assert_near(to.angle[0] - from.angle[0], 2 * M_PI / 28, 1e-12);
    assert_near(to.angle[1] - from.angle[1], -2 * M_PI / 43, 1e-12);
}

/* The marks of case S by hand: tips 46.55 and 69.55 mm, base radii 39.4671 and 60.6102, distance 111 mm. */
static void marks_are_those_of_the_path(void **state) {
    (void)state;
    struct subject s;
    struct qg_marks pinion, gear;
    make(&s, &all_cases[0].pair, 0);
    qg_profile_marks(&s.geometry, QG_PINION, &pinion);
    qg_profile_marks(&s.geometry, QG_GEAR, &gear);
    double line = sqrt(111 * 111 - pow(s.geometry.gears[0].base_radius + s.geometry.gears[1].base_radius, 2));
    assert_near(pinion.end, sqrt(46.55 * 46.55 - pow(42 * cos(20 * CASE_DEGREE), 2)), exact);
    assert_near(gear.end, sqrt(69.55 * 69.55 - pow(64.5 * cos(20 * CASE_DEGREE), 2)), exact);
    assert_near(pinion.start + gear.end, line, exact);
    assert_near(gear.start + pinion.end, line, exact);
    assert_near(pinion.pitch + gear.pitch, line, exact);
    assert_true(pinion.form < pinion.start && pinion.start < pinion.pitch && pinion.pitch < pinion.end);
    /* one pair leaves when the next is at its lowest point of single contact; so both gears share these moments */
    double pitch = M_PI * 3 * cos(20 * CASE_DEGREE);
    assert_near(pinion.end - pinion.lowest_single, pitch, exact);
    assert_near(pinion.highest_single - pinion.start, pitch, exact);
    assert_near(pinion.lowest_single + gear.highest_single, line, exact);
    assert_near(pinion.highest_single + gear.lowest_single, line, exact);
    assert_true(pinion.start < pinion.lowest_single && pinion.lowest_single < pinion.highest_single);
    make(&s, &all_cases[1].pair, 0); /* case H: contact ratio 2.006 */
    qg_profile_marks(&s.geometry, QG_PINION, &pinion);
    assert_true(isnan(pinion.lowest_single) && isnan(pinion.highest_single));
}

static void diagrams_hold_the_kinks(void **state) {
    (void)state;
    struct subject s;
    double roll[64];
    make(&s, &all_cases[0].pair, 4);
    qg_diagram_rolls(&(struct qg_made_gear){&s.pair, &s.geometry, &s.relief, 0}, 64, roll);
    int kinks = 0;
    for (int i = 0; i < 64; i++) {
        assert_true(i == 0 || roll[i] > roll[i - 1]);
        double radius = qg_radius_of_roll(&s.geometry.gears[0], roll[i]);
        kinks +=
            fabs(radius - s.relief.gears[0].tip.radius) < exact || fabs(radius - s.relief.gears[0].root.radius) < exact;
    }
    assert_int_equal(kinks, 2);
    assert_near(qg_radius_of_roll(&s.geometry.gears[0], roll[63]), 46.55, exact);
}

/* Random designs of the box lie between the two extremes, at every radius. */
static void extremes_enclose_the_box(void **state) {
    (void)state;
    struct subject s;
    make(&s, &all_cases[0].pair, 6);
    struct qg_study study = {.kind = QG_STUDY_OPTIMIZE, .pair = s.pair, .relief = s.relief, .bounds = {.count = 4}};
    const struct qg_bounds box = {.count = 4,
                                  .parameter = {QG_PINION_TIP_START_RADIUS, QG_PINION_TIP_AMPLITUDE,
                                                QG_PINION_ROOT_END_RADIUS, QG_GEAR_TIP_AMPLITUDE},
                                  .lower = {42, 0.003, 41, 0},
                                  .upper = {46, 0.03, 44, 0.02}};
    struct qg_relief least, most, design = s.relief;
    study.bounds = box;
    qg_study_extremes(&study, &least, &most);
    struct dice dice = {7};
    for (int n = 0; n < 200; n++) {
        for (size_t i = 0; i < box.count; i++)
            *qg_relief_parameter(&design, box.parameter[i]) = dice_between(&dice, box.lower[i], box.upper[i]);
        for (int gear = 0; gear < 2; gear++)
            for (int k = 0; k <= 50; k++) {
                double low = s.geometry.gears[gear].form_radius, high = s.pair.gears[gear].outside_radius;
                double radius = low + (high - low) * k / 50, depth[3];
                const struct qg_relief *three[3] = {&least, &design, &most};
                for (int j = 0; j < 3; j++)
                    depth[j] = qg_relief_depth(three[j], &s.geometry, &s.pair, gear, radius);
                assert_true(depth[0] <= depth[1] + 1e-15 && depth[1] <= depth[2] + 1e-15);
            }
    }
    study.kind = QG_STUDY_EVALUATE;
    qg_study_extremes(&study, &least, &most);
    assert_memory_equal(&least, &most, sizeof least);
}

/* Any pair that can be cut: pieces join, arcs hold their tolerance, the ring has its area. */
static void random_pairs_are_drawn_too(void **state) {
    (void)state;
    struct dice dice = {2026};
    for (int n = 0; n < 40; n++) {
        struct qg_pair_geometry geometry;
        struct qg_gear_pair pair = random_pair(&dice, &geometry);
        struct subject s = {.pair = pair, .geometry = geometry};
        for (int i = 0; i < 2; i++) {
            double form = geometry.gears[i].form_radius, outside = pair.gears[i].outside_radius;
            double deepest = qg_relief_deepest(&pair, &geometry, i);
            s.relief.gears[i].tip = (struct qg_ramp){true, dice_between(&dice, form, outside), deepest};
            s.relief.gears[i].root = (struct qg_ramp){true, dice_between(&dice, form, outside), deepest / 2};
        }
        for (int i = 0; i < 2; i++) {
            struct qg_outline arcs = {0};
            qg_profile_init(&s.profile[i], &(struct qg_made_gear){&s.pair, &s.geometry, &s.relief, i});
            check_joints(&s, i);
            check_depths(&s, i);
            assert_int_equal(qg_profile_arcs(&s.profile[i], 1e-4, &arcs), QG_OK);
            assert_true(worst_distance(&s.profile[i], &arcs) <= 1e-4);
            assert_true(arcs.count < 60);
            qg_outline_finish(&arcs);
            check_ring(&s, i);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_join),
        cmocka_unit_test(flank_is_the_involute_less_the_relief),
        cmocka_unit_test(few_arcs_hold_a_tenth_of_a_micrometre),
        cmocka_unit_test(arcs_have_no_kinks_of_their_own),
        cmocka_unit_test(a_ring_is_z_teeth),
        cmocka_unit_test(reversed_twice_is_the_same),
        cmocka_unit_test(mounted_teeth_touch),
        cmocka_unit_test(a_period_is_one_tooth),
        cmocka_unit_test(marks_are_those_of_the_path),
        cmocka_unit_test(diagrams_hold_the_kinks),
        cmocka_unit_test(extremes_enclose_the_box),
        cmocka_unit_test(random_pairs_are_drawn_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
