/* The mesh of a tooth sector: a valid, conforming mesh of exactly the sector, for the cases and for random gears. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/elasticity.h"

enum { RANDOM_GEARS = 30 };

struct plane {
    double x, y;
};

static struct plane to_plane(struct qg_polar p) {
    return (struct plane){p.radius * cos(p.angle), p.radius * sin(p.angle)};
}

static double cross(struct plane a, struct plane b) {
    return a.x * b.y - a.y * b.x;
}

static struct qg_sector_mesh mesh_of(const struct cut_gear *g, int refinement) {
    struct qg_sector_mesh mesh;
    struct qg_notes notes = {0};
    enum qg_status status = qg_sector_mesh_init(&mesh, &g->rack, &g->gear, &g->geometry, refinement, &notes);
    if (status != QG_OK)
        fail_msg("%d teeth: %s", g->gear.teeth, notes.count ? notes.item[0].text : qg_status_text(status));
    return mesh;
}

static struct cut_gear gear_of_case(int which) {
    const struct qg_gear_pair *pair = &all_cases[which / 2].pair;
    struct cut_gear g = {.rack = pair->rack, .gear = pair->gears[which % 2]};
    assert_int_equal(qg_gear_derive(&g.rack, &g.gear, 7.85e-6, "", &g.geometry, NULL), QG_OK);
    return g;
}

/* Small gears with little rim are the hard ones. */
static struct cut_gear thin_rimmed_gear(struct dice *dice) {
    for (;;) {
        struct cut_gear g = random_gear(dice);
        g.gear.teeth = dice_integer(dice, 12, 30);
        double m = g.rack.module, shifted = m * g.gear.teeth / 2 + g.gear.profile_shift;
        g.gear.root_radius = shifted - g.geometry.hob_addendum;
        g.gear.outside_radius = shifted + dice_between(dice, 0.6, 1.4) * m;
        g.gear.bore_diameter = 2 * g.gear.root_radius - dice_between(dice, 1.0001, 1.5) * m;
        if (qg_gear_derive(&g.rack, &g.gear, 7.85e-6, "", &g.geometry, NULL) == QG_OK)
            return g;
    }
}

/* Calls check for all gears of the cases, random ones, and random ones with a thin rim. */
static void for_many_gears(void (*check)(const struct cut_gear *, const struct qg_sector_mesh *)) {
    struct dice dice = {31};
    for (int i = 0; i < 2 * CASE_COUNT + 2 * RANDOM_GEARS; i++) {
        struct cut_gear g = i < 2 * CASE_COUNT ? gear_of_case(i)
                            : i % 2 == 0       ? random_gear(&dice)
                                               : thin_rimmed_gear(&dice);
        struct qg_sector_mesh mesh = mesh_of(&g, 1);
        check(&g, &mesh);
        qg_sector_mesh_finish(&mesh);
    }
}

/* ---- elements --------------------------------------------------------------------------------------------------- */

static void check_elements(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    (void)g;
    const struct qg_plate plate = {1, 0.3, 1, 0};
    for (size_t e = 0; e < mesh->element_count; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS];
        for (int n = 0; n < QG_ELEMENT_NODES; n++) {
            assert_in_range(mesh->element[e][n], 0, mesh->node_count - 1);
            node[n] = mesh->node[mesh->element[e][n]];
        }
        if (qg_element_stiffness((const struct qg_polar *)node, &plate, k) != 0)
            fail_msg("%d teeth: element %zu is turned", g->gear.teeth, e);
    }
}

static void elements_have_positive_jacobians(void **state) {
    (void)state;
    for_many_gears(check_elements);
}

/* One element edge: its end nodes in ascending order, its midside, how often it occurs. */
struct edge {
    int low, high, middle;
};

static int compare_edges(const void *a, const void *b) {
    const struct edge *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    return (p->high > q->high) - (p->high < q->high);
}

static struct edge *edges_of(const struct qg_sector_mesh *mesh) {
    struct edge *edge = malloc(4 * mesh->element_count * sizeof *edge);
    assert_non_null(edge);
    for (size_t e = 0; e < mesh->element_count; e++)
        for (int k = 0; k < 4; k++) {
            int a = mesh->element[e][k], b = mesh->element[e][(k + 1) % 4];
            edge[4 * e + (size_t)k] = (struct edge){a < b ? a : b, a < b ? b : a, mesh->element[e][4 + k]};
        }
    qsort(edge, 4 * mesh->element_count, sizeof *edge, compare_edges);
    return edge;
}

/* True for points of the sector's outline: bore, sides, root, tip, or either flank. */
static bool on_outline(const struct cut_gear *g, struct qg_polar p) {
    const double close = 1e-9 * g->gear.outside_radius;
    double angle = fabs(p.angle);
    if (fabs(p.radius - g->gear.bore_diameter / 2) < close || fabs(angle - M_PI / g->gear.teeth) < 1e-10)
        return true;
    if (fabs(p.radius - g->gear.root_radius) < close || fabs(p.radius - g->gear.outside_radius) < close)
        return true;
    if (p.radius >= g->geometry.form_radius)
        return fabs(angle - qg_half_tooth_angle(&g->rack, &g->geometry, p.radius)) * p.radius < close;
    double low = 0, high = 1; /* the trochoid's point at this radius */
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (qg_trochoid_point(&g->rack, &g->gear, &g->geometry, middle).radius < p.radius)
            low = middle;
        else
            high = middle;
    }
    return fabs(angle - qg_trochoid_point(&g->rack, &g->gear, &g->geometry, low).angle) * p.radius < 1e3 * close;
}

/* Every edge is shared by two elements that agree on its midside, or lies on the outline of the sector. */
static void check_conformity(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    struct edge *edge = edges_of(mesh);
    size_t count = 4 * mesh->element_count;
    for (size_t i = 0; i < count;) {
        size_t same = 1;
        while (i + same < count && compare_edges(&edge[i], &edge[i + same]) == 0)
            same++;
        assert_true(same <= 2);
        if (same == 2) {
            assert_int_equal(edge[i].middle, edge[i + 1].middle);
        } else {
            assert_true(on_outline(g, mesh->node[edge[i].low]));
            assert_true(on_outline(g, mesh->node[edge[i].high]));
            assert_true(on_outline(g, mesh->node[edge[i].middle]));
        }
        i += same;
    }
    free(edge);
}

static void elements_conform(void **state) {
    (void)state;
    for_many_gears(check_conformity);
}

static int compare_nodes(const void *a, const void *b) {
    const struct qg_polar *p = a, *q = b;
    if (p->radius != q->radius)
        return p->radius < q->radius ? -1 : 1;
    return (p->angle > q->angle) - (p->angle < q->angle);
}

/* Every node belongs to an element, and no two lie in one place. */
static void check_nodes(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    unsigned char *used = calloc(mesh->node_count, 1);
    struct qg_polar *sorted = malloc(mesh->node_count * sizeof *sorted);
    assert_true(used && sorted);
    for (size_t e = 0; e < mesh->element_count; e++)
        for (int n = 0; n < QG_ELEMENT_NODES; n++)
            used[mesh->element[e][n]] = 1;
    for (size_t n = 0; n < mesh->node_count; n++)
        assert_true(used[n]);
    memcpy(sorted, mesh->node, mesh->node_count * sizeof *sorted);
    qsort(sorted, mesh->node_count, sizeof *sorted, compare_nodes);
    double close = 1e-7 * g->rack.module;
    for (size_t n = 0; n < mesh->node_count; n++)
        for (size_t k = n + 1; k < mesh->node_count && sorted[k].radius - sorted[n].radius < close; k++)
            assert_true(fabs(sorted[k].angle - sorted[n].angle) * sorted[n].radius > close);
    free(used);
    free(sorted);
}

static void nodes_are_used_and_distinct(void **state) {
    (void)state;
    for_many_gears(check_nodes);
}

/* ---- area ------------------------------------------------------------------------------------------------------- */

/* Area of a mesh of elements with parabolic sides: along a side from a to c through b, half the integral of x dy - y
 * dx is (a x c)/2 - 2/3 (c - a) x (b - (a + c)/2). */
static double mesh_area(const struct qg_sector_mesh *mesh) {
    double area = 0;
    for (size_t e = 0; e < mesh->element_count; e++)
        for (int k = 0; k < 4; k++) {
            struct plane a = to_plane(mesh->node[mesh->element[e][k]]);
            struct plane c = to_plane(mesh->node[mesh->element[e][(k + 1) % 4]]);
            struct plane b = to_plane(mesh->node[mesh->element[e][4 + k]]);
            struct plane chord = {c.x - a.x, c.y - a.y}, bulge = {b.x - (a.x + c.x) / 2, b.y - (a.y + c.y) / 2};
            area += cross(a, c) / 2 - 2 * cross(chord, bulge) / 3;
        }
    return area;
}

/* Area between profile and bore: the tip's and root's arcs exactly, trochoid and involute as polygons so fine that
 * their error is below 1e-7. */
static double sector_area(const struct cut_gear *g) {
    enum { STEPS = 4000 };
    double outside = g->gear.outside_radius, root = g->gear.root_radius, bore = g->gear.bore_diameter / 2;
    double form = g->geometry.form_radius;
    double half = outside * outside * qg_half_tooth_angle(&g->rack, &g->geometry, outside) / 2;
    double flat = M_PI / g->gear.teeth - qg_trochoid_point(&g->rack, &g->gear, &g->geometry, 0).angle;
    half += root * root * flat / 2 - bore * bore * M_PI / g->gear.teeth / 2;
    struct plane last = {0, 0};
    for (int i = 0; i <= 2 * STEPS; i++) {
        struct qg_polar p = {.radius = form + (outside - form) * (i - STEPS) / STEPS};
        if (i <= STEPS)
            p = qg_trochoid_point(&g->rack, &g->gear, &g->geometry, (double)i / STEPS);
        else
            p.angle = qg_half_tooth_angle(&g->rack, &g->geometry, p.radius);
        struct plane next = to_plane(p);
        half += i > 0 ? cross(next, last) / 2 : 0;
        last = next;
    }
    return 2 * half;
}

static void check_area(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    double exact = sector_area(g);
    assert_near(mesh_area(mesh), exact, 1e-5 * exact);
}

static void area_is_that_of_the_sector(void **state) {
    (void)state;
    for_many_gears(check_area);
}

static void area_converges(void **state) {
    (void)state;
    for (int i = 0; i < 2 * CASE_COUNT; i++) {
        struct cut_gear g = gear_of_case(i);
        double exact = sector_area(&g), error[2];
        for (int r = 1; r <= 2; r++) {
            struct qg_sector_mesh mesh = mesh_of(&g, r);
            error[r - 1] = fabs(mesh_area(&mesh) - exact) / exact;
            qg_sector_mesh_finish(&mesh);
        }
        assert_true(error[0] < 2e-6);
        assert_true(error[1] < fmax(error[0] / 6, 2e-8));
    }
}

/* ---- lists of nodes --------------------------------------------------------------------------------------------- */

static bool is_edge(const struct edge *edges, size_t count, const int *nodes) {
    struct edge wanted = {nodes[0] < nodes[2] ? nodes[0] : nodes[2], nodes[0] < nodes[2] ? nodes[2] : nodes[0], 0};
    const struct edge *found = bsearch(&wanted, edges, count, sizeof *edges, compare_edges);
    return found && found->middle == nodes[1];
}

/* Corner, midside, corner, ...: the list runs along element edges. */
static void check_list(const struct qg_sector_mesh *mesh, const int *list, size_t count) {
    struct edge *edge = edges_of(mesh);
    assert_int_equal(count % 2, 1);
    for (size_t k = 0; k + 2 < count; k += 2)
        assert_true(is_edge(edge, 4 * mesh->element_count, list + k));
    free(edge);
}

static void check_flank(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    check_list(mesh, mesh->flank, mesh->flank_count);
    double rb = g->geometry.base_radius;
    for (size_t k = 0; k < mesh->flank_count; k++) {
        struct qg_polar p = mesh->node[mesh->flank[k]];
        assert_near(p.angle * p.radius, qg_half_tooth_angle(&g->rack, &g->geometry, p.radius) * p.radius, 1e-9);
        assert_near(mesh->flank_arc[k], (p.radius * p.radius - rb * rb) / (2 * rb), 1e-9);
        if (k > 0)
            assert_true(mesh->flank_arc[k] > mesh->flank_arc[k - 1]);
        if (k % 2 == 1) { /* statics.c interpolates over the arc: midsides must halve it */
            double from = mesh->flank_arc[k - 1], to = mesh->flank_arc[k + 1];
            assert_near(mesh->flank_arc[k], (from + to) / 2, 1e-4 * (to - from));
        }
    }
    assert_near(mesh->node[mesh->flank[0]].radius, g->geometry.form_radius, 1e-9);
    assert_near(mesh->node[mesh->flank[mesh->flank_count - 1]].radius, g->gear.outside_radius, 1e-9);
}

static void flank_lies_on_the_involute(void **state) {
    (void)state;
    for_many_gears(check_flank);
}

static void check_sides(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    for (int s = 0; s < 2; s++)
        check_list(mesh, mesh->side[s], mesh->side_count);
    for (size_t k = 0; k < mesh->side_count; k++) {
        struct qg_polar plus = mesh->node[mesh->side[0][k]], minus = mesh->node[mesh->side[1][k]];
        assert_near(plus.radius, minus.radius, 1e-12 * plus.radius);
        assert_near(plus.angle, M_PI / g->gear.teeth, 1e-13);
        assert_near(minus.angle, -M_PI / g->gear.teeth, 1e-13);
        if (k > 0)
            assert_true(plus.radius > mesh->node[mesh->side[0][k - 1]].radius);
    }
    assert_near(mesh->node[mesh->side[0][0]].radius, g->gear.bore_diameter / 2, 1e-12 * g->gear.bore_diameter);
    assert_near(mesh->node[mesh->side[0][mesh->side_count - 1]].radius, g->gear.root_radius, 1e-9);
}

static void sides_match_under_rotation(void **state) {
    (void)state;
    for_many_gears(check_sides);
}

static void check_bore(const struct cut_gear *g, const struct qg_sector_mesh *mesh) {
    check_list(mesh, mesh->bore, mesh->bore_count);
    for (size_t k = 0; k < mesh->bore_count; k++) {
        assert_near(mesh->node[mesh->bore[k]].radius, g->gear.bore_diameter / 2, 1e-12 * g->gear.bore_diameter);
        if (k > 0)
            assert_true(mesh->node[mesh->bore[k]].angle < mesh->node[mesh->bore[k - 1]].angle);
    }
    assert_int_equal(mesh->bore[0], mesh->side[0][0]);
    assert_int_equal(mesh->bore[mesh->bore_count - 1], mesh->side[1][0]);
}

static void bore_runs_from_side_to_side(void **state) {
    (void)state;
    for_many_gears(check_bore);
}

/* ---- refinement ------------------------------------------------------------------------------------------------- */

static void refinement_divides_every_edge(void **state) {
    (void)state;
    struct dice dice = {33};
    for (int i = 0; i < 6; i++) {
        struct cut_gear g = i < 2 ? gear_of_case(i) : i < 4 ? random_gear(&dice) : thin_rimmed_gear(&dice);
        struct qg_sector_mesh coarse = mesh_of(&g, 1);
        for (int r = 2; r <= 3; r++) {
            struct qg_sector_mesh fine = mesh_of(&g, r);
            size_t times = (size_t)r;
            assert_int_equal(fine.element_count, times * times * coarse.element_count);
            assert_int_equal(fine.flank_count, times * (coarse.flank_count - 1) + 1);
            assert_int_equal(fine.bore_count, times * (coarse.bore_count - 1) + 1);
            assert_int_equal(fine.side_count, times * (coarse.side_count - 1) + 1);
            for (size_t k = 0; k < coarse.flank_count; k += 2) /* coarse corners are corners of the finer mesh */
                assert_near(fine.flank_arc[times * k], coarse.flank_arc[k], 1e-6);
            check_elements(&g, &fine);
            check_conformity(&g, &fine);
            check_nodes(&g, &fine);
            check_flank(&g, &fine);
            check_sides(&g, &fine);
            qg_sector_mesh_finish(&fine);
        }
        qg_sector_mesh_finish(&coarse);
    }
}

static void finish_accepts_nothing(void **state) {
    (void)state;
    struct qg_sector_mesh mesh = {0};
    qg_sector_mesh_finish(&mesh);
    qg_sector_mesh_finish(&mesh);
    assert_null(mesh.node);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_have_positive_jacobians),
        cmocka_unit_test(elements_conform),
        cmocka_unit_test(nodes_are_used_and_distinct),
        cmocka_unit_test(area_is_that_of_the_sector),
        cmocka_unit_test(area_converges),
        cmocka_unit_test(flank_lies_on_the_involute),
        cmocka_unit_test(sides_match_under_rotation),
        cmocka_unit_test(bore_runs_from_side_to_side),
        cmocka_unit_test(refinement_divides_every_edge),
        cmocka_unit_test(finish_accepts_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
