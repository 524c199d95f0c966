/* Whole gears out of sectors, reliefs in the mesh, and the contact model that is made of them. What an external program makes
 * of the model is tried in tests/service/export.bats.
 */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/deck.h"
#include "core/statics.h"
#include "core/study.h"

static const struct qg_relief no_relief, standard_relief = CASE_S_STANDARD;

/* ---- whole gears ------------------------------------------------------------------------------------------------ */

static struct qg_deck *make_deck(const struct qg_gear_pair *pair, const struct qg_relief *relief, double position) {
    struct qg_pair_geometry geometry;
    struct qg_deck *deck = malloc(sizeof *deck);
    assert_non_null(deck);
    assert_int_equal(qg_pair_derive(pair, &geometry, NULL), QG_OK);
    const struct qg_deck_plan plan = {.pair = pair,
                                      .geometry = &geometry,
                                      .relief = relief,
                                      .refinement = 1,
                                      .position = position,
                                      .torque = pair->nominal_torque};
    assert_int_equal(qg_deck_init(deck, &plan, NULL), QG_OK);
    return deck;
}

static void drop_deck(struct qg_deck *deck) {
    qg_deck_finish(deck);
    free(deck);
}

/* Sides of elements by the midside that names each: how often it is met. */
static void count_sides(const struct qg_gear_mesh *mesh, int *times) {
    for (size_t e = 0; e < mesh->element_count; e++)
        for (int k = 4; k < QG_ELEMENT_NODES; k++)
            times[mesh->element[e][k]]++;
}

/* A ring without gaps: no side belongs to three elements, corners - sides + elements is that of a ring (0), and the sides
 * met once are the bore's and the outline's, as many nodes as sides. */
static void check_ring(const struct qg_gear_mesh *mesh) {
    int *times = calloc(mesh->node_count, sizeof *times), *corner = calloc(mesh->node_count, sizeof *corner);
    assert_true(times && corner);
    count_sides(mesh, times);
    for (size_t e = 0; e < mesh->element_count; e++)
        for (int k = 0; k < 4; k++)
            corner[mesh->element[e][k]] = 1;
    long corners = 0, sides = 0, bore_sides = 0;
    for (size_t n = 0; n < mesh->node_count; n++) {
        assert_in_range(times[n], 0, 2);
        assert_true((times[n] > 0) != (corner[n] > 0)); /* every node is one or the other */
        sides += times[n] > 0;
        corners += corner[n];
    }
    assert_int_equal(corners - sides + (long)mesh->element_count, 0);
    for (size_t k = 0; k < mesh->bore_count; k++)
        bore_sides += times[mesh->bore[k]] == 1;
    assert_int_equal(2 * bore_sides, mesh->bore_count);
    free(times);
    free(corner);
}

/* Stiffness of every element exists: none is turned over, whatever the relief. */
static void check_elements(const struct qg_gear_mesh *mesh) {
    const struct qg_plate plate = {206000, 0.3, 1, 0};
    for (size_t e = 0; e < mesh->element_count; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS];
        for (int n = 0; n < QG_ELEMENT_NODES; n++)
            node[n] = mesh->node[mesh->element[e][n]];
        assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &plate, k), 0);
    }
}

static void check_bore(const struct qg_gear_mesh *mesh, double radius) {
    double sum = 0;
    for (size_t k = 0; k < mesh->bore_count; k++) {
        const struct qg_polar *at = &mesh->node[mesh->bore[k]],
                              *next = &mesh->node[mesh->bore[(k + 1) % mesh->bore_count]];
        assert_near_share(at->radius, radius, 1e-12);
        assert_true(remainder(at->angle - next->angle, 2 * M_PI) > 0);
        sum += mesh->bore_share[k];
    }
    assert_near(sum, 1, 1e-12);
}

/* The deepest reliefs there may be, tip and root, on random pairs and at random positions. */
static void gears_are_whole_whatever_the_relief(void **state) {
    (void)state;
    struct dice dice = {.state = 7};
    for (int round = 0; round < 12; round++) {
        struct qg_pair_geometry geometry;
        struct qg_gear_pair pair = random_pair(&dice, &geometry);
        struct qg_relief relief = {.shape = round % 2 ? QG_SHAPE_PARABOLIC : QG_SHAPE_LINEAR};
        for (int g = 0; g < 2; g++) {
            double form = geometry.gears[g].form_radius, outside = pair.gears[g].outside_radius;
            double deepest = qg_relief_deepest(&pair, &geometry, g);
            relief.gears[g].tip = (struct qg_ramp){true, form + 0.6 * (outside - form), deepest};
            relief.gears[g].root = (struct qg_ramp){true, form + 0.3 * (outside - form), deepest};
        }
        struct qg_deck *deck = make_deck(&pair, &relief, dice_between(&dice, 0, 1));
        for (int g = 0; g < 2; g++) {
            check_ring(&deck->mesh[g]);
            check_elements(&deck->mesh[g]);
            check_bore(&deck->mesh[g], pair.gears[g].bore_diameter / 2);
        }
        drop_deck(deck);
    }
}

/* ---- reliefs in the mesh ---------------------------------------------------------------------------------------- */

/* Every node of a relieved flank lies its relief's depth inside the bare involute, along the normal of the latter. */
static void the_flank_lies_as_deep_as_the_relief(void **state) {
    (void)state;
    const struct qg_gear_pair pair = CASE_S;
    struct qg_relief relief = standard_relief;
    relief.gears[QG_PINION].root = (struct qg_ramp){true, 42, 0.01};
    struct qg_pair_geometry geometry;
    assert_int_equal(qg_pair_derive(&pair, &geometry, NULL), QG_OK);
    struct qg_deck *bare = make_deck(&pair, &no_relief, 0.5), *deck = make_deck(&pair, &relief, 0.5);
    for (int g = 0; g < 2; g++) {
        const struct qg_gear_mesh *mesh = &deck->mesh[g];
        double base = geometry.gears[g].base_radius, deepest = 0;
        for (size_t k = 0; k < mesh->flank_count; k++) {
            const struct qg_polar *from = &bare->mesh[g].node[bare->mesh[g].flank[k]],
                                  *to = &mesh->node[mesh->flank[k]];
            double dx = to->radius * cos(to->angle) - from->radius * cos(from->angle);
            double dy = to->radius * sin(to->angle) - from->radius * sin(from->angle);
            double normal = from->angle + M_PI_2 - acos(base / from->radius);
            double depth = qg_relief_depth(&relief, &geometry, &pair, g, from->radius);
            assert_near(-(dx * cos(normal) + dy * sin(normal)), depth, 1e-12);
            assert_near(dy * cos(normal) - dx * sin(normal), 0, 1e-12);
            deepest = fmax(deepest, depth);
        }
        assert_near_share(deepest, relief.gears[g].tip.amplitude, 1e-9);
        for (size_t k = 0; k < mesh->bore_count; k++)
            assert_true(mesh->node[mesh->bore[k]].radius == bare->mesh[g].node[bare->mesh[g].bore[k]].radius);
    }
    drop_deck(bare);
    drop_deck(deck);
}

/* ---- the model -------------------------------------------------------------------------------------------------- */

/* The turn at which the drawn flanks first touch is the unloaded transmission error of the gaps, at every position: relief in
 * the mesh here, as a gap there. */
static void flanks_touch_where_the_gaps_say(void **state) {
    (void)state;
    const struct qg_gear_pair pair = CASE_S;
    const struct qg_analysis analysis = {
        .case_count = 1, .torque_fraction = {1}, .mesh_positions = 14, .mesh_refinement = 1, .speeds = {.count = 1}};
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *model;
    struct qg_evaluator evaluator;
    assert_int_equal(qg_model_create(&pair, &analysis, &means, NULL, &model), QG_OK);
    assert_int_equal(qg_evaluator_init(&evaluator, model, &qg_serial_executor), QG_OK);
    struct qg_design_result *result = qg_design_result_create(&analysis);
    assert_non_null(result);
    result->relief = standard_relief;
    assert_int_equal(qg_evaluate(&evaluator, false, 1, &result), QG_OK);
    for (int i = 0; i < 14; i++) {
        struct qg_deck *deck = make_deck(&pair, &standard_relief, i / 14.0);
        assert_near(1e3 * deck->touch, 1e3 * result->cases[0].unloaded_transmission_error[i], 0.06);
        assert_true(deck->seat > deck->touch && deck->seat < deck->touch + 5e-3);
        drop_deck(deck);
    }
    qg_design_result_destroy(result);
    qg_evaluator_finish(&evaluator);
    qg_model_destroy(model);
}

/* Contact pairs: all that lie on the path, the slave the one whose tip may engage, teeth that face each other. */
static void contact_pairs_are_those_that_may_touch(void **state) {
    (void)state;
    for (int c = 0; c < CASE_COUNT; c++)
        for (int i = 0; i < 7; i++) {
            struct qg_pair_geometry geometry;
            qg_pair_derive(&all_cases[c].pair, &geometry, NULL);
            double position = i / 7.0;
            struct qg_deck *deck = make_deck(&all_cases[c].pair, &no_relief, position);
            size_t on_path = 0;
            for (size_t k = 0; k < deck->contact_count; k++) {
                const struct qg_deck_contact *contact = &deck->contact[k];
                double xi = qg_path_position(&geometry, position, contact->pair);
                on_path += xi > geometry.path_start && xi < geometry.path_end;
                assert_int_equal(contact->slave, qg_tip_gear(&geometry, position, contact->pair));
                /* the nodes of both flanks nearest to the theoretical contact lie on each other */
                if (xi < geometry.path_start || xi > geometry.path_end)
                    continue;
                for (int g = 0; g < 2; g++) {
                    const struct qg_gear_mesh *mesh = &deck->mesh[g];
                    const int *flank = mesh->flank + (size_t)contact->tooth[g] * mesh->flank_count;
                    double roll = g == QG_PINION ? xi : geometry.line_length - xi, least = INFINITY;
                    double working = geometry.working_pressure_angle, base = geometry.gears[QG_PINION].base_radius;
                    double x = base * cos(working) + xi * sin(working), y = xi * cos(working) - base * sin(working);
                    for (size_t n = 0; n < mesh->flank_count; n++) {
                        double xy[2];
                        qg_deck_node(deck, g, (size_t)flank[n], xy);
                        least = fmin(least, hypot(xy[0] - x, xy[1] - y));
                    }
                    assert_true(roll > 0 && least < 0.1);
                }
            }
            assert_in_range(deck->contact_count, 1, 4);
            assert_true(on_path >= (size_t)geometry.contact_ratio);
            drop_deck(deck);
        }
}

/* Plane-strain constants that are plane stress: the same axial and shear moduli in the plane. */
static void plane_strain_constants_are_plane_stress(void **state) {
    (void)state;
    const struct qg_gear_pair pair = CASE_S;
    struct qg_deck *deck = make_deck(&pair, &no_relief, 0.5);
    double e = deck->youngs_modulus, nu = deck->poisson_ratio;
    assert_near_share(e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), 206000 / (1 - 0.09), 1e-12);
    assert_near_share(e / (2 * (1 + nu)), 206000 / 2.6, 1e-12);
    drop_deck(deck);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gears_are_whole_whatever_the_relief),
        cmocka_unit_test(the_flank_lies_as_deep_as_the_relief),
        cmocka_unit_test(flanks_touch_where_the_gaps_say),
        cmocka_unit_test(contact_pairs_are_those_that_may_touch),
        cmocka_unit_test(plane_strain_constants_are_plane_stress),
    };
    qg_numerics_init(1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
