/* The full field against what it must reproduce: balance of forces and moments, the static transmission error of the
 * condensed model, the stress rows of the root, the contact pressure; and its thinned view.
 */
#include "tests/core/cases.h"

#include <limits.h>
#include <stdlib.h>

#include "core/field_view.h"
#include "core/profile.h"
#include "core/statics.h"
#include "core/study.h"

struct setting {
    struct qg_gear_pair pair;
    struct qg_relief relief;
    enum qg_plane plane;
    enum qg_bore bore;
    double position, fraction;
};

static const struct setting standard = {CASE_S, CASE_S_STANDARD, QG_PLANE_STRESS, QG_BORE_TORQUE_RING, 0.5, 1};

static struct qg_model *make_model(const struct setting *s) {
    const struct qg_analysis analysis = {.case_count = 1,
                                         .torque_fraction = {s->fraction},
                                         .mesh_refinement = 1,
                                         .plane = s->plane,
                                         .bore = s->bore,
                                         .speeds = {.count = 1}};
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *model;
    assert_int_equal(qg_model_create_at(&s->pair, &analysis, s->position, &means, NULL, &model), QG_OK);
    return model;
}

static void make_field(const struct setting *s, const struct qg_model *model, struct qg_field *field) {
    const struct qg_field_state state = {.relief = &s->relief, .torque = s->fraction * s->pair.nominal_torque};
    assert_int_equal(qg_field_init(field, model, &state), QG_OK);
}

/* ---- balance ---------------------------------------------------------------------------------------------------- */

static void check_balance(const struct setting *s) {
    struct qg_model *model = make_model(s);
    struct qg_field field;
    make_field(s, model, &field);
    const struct qg_field_gear *pinion = &field.gears[QG_PINION], *gear = &field.gears[QG_GEAR];
    double torque = field.torque, force = hypot(gear->force[0], gear->force[1]);
    /* the contact turns the pinion back with the torque, and pushes both gears apart with equal forces */
    assert_near_share(pinion->contact_moment, -torque, 1e-4);
    for (int c = 0; c < 2; c++) {
        assert_near(pinion->force[c], -gear->force[c], 1e-9 * force);
        assert_near(gear->reaction[c], -gear->force[c], 1e-7 * force);
        assert_near(pinion->reaction[c], -pinion->force[c], 1e-7 * force);
    }
    assert_near_share(gear->reaction_moment, -gear->contact_moment, 1e-7);
    assert_near_share(pinion->reaction_moment, -pinion->contact_moment, 1e-7);
    /* about the pinion's axis, the gear's reactions hold the torque */
    double moment = gear->reaction_moment + s->pair.center_distance * gear->reaction[1];
    assert_near_share(moment, -torque, 1e-3);
    assert_near_share(field.approach_energy, field.approach, 1e-3);
    qg_field_finish(&field);
    qg_model_destroy(model);
}

static void balances_and_reproduces_the_transmission_error(void **state) {
    (void)state;
    const struct setting settings[] = {
        standard,
        {CASE_S, CASE_S_STANDARD, QG_PLANE_STRESS, QG_BORE_TORQUE_RING, 0.03, 1},
        {CASE_S, {0}, QG_PLANE_STRAIN, QG_BORE_CLAMPED, 0.85, 0.33},
        {CASE_H, {0}, QG_PLANE_STRESS, QG_BORE_TORQUE_RING, 0.1, 1},
    };
    for (size_t k = 0; k < sizeof settings / sizeof *settings; k++)
        check_balance(&settings[k]);
}

/* A model at one position is that of the period's position. */
static void any_position_is_the_same_as_one_of_a_period(void **state) {
    (void)state;
    struct setting s = standard;
    s.position = 3.0 / 14;
    struct qg_analysis analysis = {
        .case_count = 1, .torque_fraction = {1}, .mesh_positions = 14, .mesh_refinement = 1, .speeds = {.count = 1}};
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *one = make_model(&s), *all;
    assert_int_equal(qg_model_create(&s.pair, &analysis, &means, NULL, &all), QG_OK);
    struct qg_field at_one, at_all;
    make_field(&s, one, &at_one);
    const struct qg_field_state state_at_all = {.relief = &s.relief, .site = 3, .torque = s.pair.nominal_torque};
    assert_int_equal(qg_field_init(&at_all, all, &state_at_all), QG_OK);
    assert_near_share(at_one.approach, at_all.approach, 1e-12);
    assert_int_equal(at_one.load_count, at_all.load_count);
    qg_field_finish(&at_one);
    qg_field_finish(&at_all);
    qg_model_destroy(one);
    qg_model_destroy(all);
}

/* ---- stopping --------------------------------------------------------------------------------------------------- */

/* Says stop when it has been asked often enough, and from then on. */
struct patience {
    int asked, enough;
};

static bool is_enough(void *self) {
    struct patience *p = self;
    return ++p->asked > p->enough;
}

/* Wherever it is stopped, a field ends at once, and can be finished. */
static void a_field_can_be_stopped(void **state) {
    (void)state;
    const struct setting *s = &standard;
    struct qg_model *model = make_model(s);
    struct patience whole = {.enough = INT_MAX};
    struct qg_field field;
    struct qg_field_state wish = {.relief = &s->relief, .torque = s->pair.nominal_torque, .stop = {is_enough, &whole}};
    assert_int_equal(qg_field_init(&field, model, &wish), QG_OK);
    qg_field_finish(&field);
    assert_true(whole.asked >= 2 * 4); /* each gear: before its mesh, ordering, factorization and stresses */
    for (int k = 0; k < whole.asked; k++) {
        struct patience p = {.enough = k};
        wish.stop.self = &p;
        assert_int_equal(qg_field_init(&field, model, &wish), QG_CANCELLED);
        assert_int_equal(p.asked, k + 1);
        qg_field_finish(&field);
    }
    qg_model_destroy(model);
}

/* ---- displacement ----------------------------------------------------------------------------------------------- */

/* The pinion's bore turns by delta / r_b1 in the mean and stays round; the gear's does not move. */
static void the_bores_move_as_they_are_held(void **state) {
    (void)state;
    struct qg_model *model = make_model(&standard);
    struct qg_field field;
    make_field(&standard, model, &field);
    double turn[2] = {0};
    for (int g = 0; g < 2; g++) {
        const struct qg_field_gear *gear = &field.gears[g];
        for (size_t k = 0; k < gear->mesh.bore_count; k++) {
            int n = gear->mesh.bore[k];
            const struct qg_polar *at = &gear->mesh.node[n];
            double x = gear->displacement[2 * n], y = gear->displacement[2 * n + 1];
            assert_near(x * cos(at->angle) + y * sin(at->angle), 0, 1e-12);
            turn[g] += gear->mesh.bore_share[k] * (y * cos(at->angle) - x * sin(at->angle)) / at->radius;
        }
    }
    double base = qg_model_geometry(model)->gears[QG_PINION].base_radius;
    assert_near_share(turn[QG_PINION] * base, field.approach, 1e-3);
    assert_near(turn[QG_GEAR], 0, 1e-15);
    qg_field_finish(&field);
    qg_model_destroy(model);
}

/* ---- stress ----------------------------------------------------------------------------------------------------- */

/* The node of a gear nearest to a place about its axis. */
static size_t nearest(const struct qg_field_gear *gear, struct qg_polar place) {
    size_t best = 0;
    double least = INFINITY, x = place.radius * cos(place.angle), y = place.radius * sin(place.angle);
    for (size_t n = 0; n < gear->mesh.node_count; n++) {
        const struct qg_polar *at = &gear->mesh.node[n];
        double distance = hypot(at->radius * cos(at->angle) - x, at->radius * sin(at->angle) - y);
        if (distance < least) {
            least = distance;
            best = n;
        }
    }
    return best;
}

/* The largest and smallest root stresses of the rows stand in the field at the same place: two ways from the same loads. */
static void the_root_is_stressed_as_the_rows_say(void **state) {
    (void)state;
    struct qg_model *model = make_model(&standard);
    struct qg_evaluator evaluator;
    struct qg_field field;
    make_field(&standard, model, &field);
    struct qg_design_result *result = qg_design_result_create(qg_model_analysis(model));
    assert_non_null(result);
    result->relief = standard.relief;
    assert_int_equal(qg_evaluator_init(&evaluator, model, &qg_serial_executor), QG_OK);
    assert_int_equal(qg_evaluate(&evaluator, false, 1, &result), QG_OK);
    assert_int_equal(qg_evaluate_stresses(&evaluator, result), QG_OK);
    struct qg_mounted mounted;
    qg_mounted_at(qg_model_geometry(model), qg_model_pair(model), standard.position, &mounted);
    for (int g = 0; g < 2; g++) {
        const struct qg_root_stress *tension = &result->cases[0].stresses->tension[g][0];
        double pitch = 2 * M_PI / standard.pair.gears[g].teeth;
        struct qg_polar place = tension->at;
        place.angle += mounted.angle[g] + (g == QG_PINION ? pitch : -pitch) * tension->pair;
        const struct qg_field_gear *gear = &field.gears[g];
        assert_true(tension->stress > 100);
        assert_near_share(qg_max_principal(&gear->stress[nearest(gear, place)]), tension->stress, 0.03);
    }
    qg_evaluator_finish(&evaluator);
    qg_design_result_destroy(result);
    qg_field_finish(&field);
    qg_model_destroy(model);
}

/* Stress across the flank, compression positive, at node k of the flank of the tooth of pair 0. */
static double pressing(const struct qg_field_gear *gear, int tooth, size_t k, double base_radius) {
    int n = gear->mesh.flank[(size_t)tooth * gear->mesh.flank_count + k];
    const struct qg_polar *at = &gear->mesh.node[n];
    double normal = at->angle + M_PI_2 - acos(base_radius / at->radius), c = cos(normal), s = sin(normal);
    const struct qg_plane_stress *stress = &gear->stress[n];
    return -(c * c * stress->xx + 2 * c * s * stress->xy + s * s * stress->yy);
}

/* Pressure at the surface: what the field says across the flank is the contact's pressure, in its largest value and summed up,
 * and nothing where nothing touches. */
static void the_flank_is_pressed_by_the_contact(void **state) {
    (void)state;
    struct qg_model *model = make_model(&standard);
    struct qg_field field;
    make_field(&standard, model, &field);
    double force = field.torque / qg_model_geometry(model)->gears[QG_PINION].base_radius, pressure = 0;
    double width = qg_model_geometry(model)->face_width;
    for (size_t i = 0; i < field.load_count; i++)
        pressure = fmax(pressure, field.load[i].pressure);
    for (int g = 0; g < 2; g++) {
        const struct qg_field_gear *gear = &field.gears[g];
        double base = qg_model_geometry(model)->gears[g].base_radius, most = 0, sum = 0;
        int tooth = 0 - gear->mesh.first_tooth;
        for (size_t k = 0; k + 2 < gear->mesh.flank_count; k += 2) { /* Simpson over every edge */
            double at[3];
            for (size_t j = 0; j < 3; j++) {
                at[j] = pressing(gear, tooth, k + j, base);
                most = fmax(most, at[j]);
            }
            sum += (at[0] + 4 * at[1] + at[2]) / 6 * (gear->mesh.flank_arc[k + 2] - gear->mesh.flank_arc[k]);
        }
        /* the field's gear takes the load over its own width */
        double own = standard.pair.gears[g].face_width;
        assert_near_share(sum * own, force, 0.02);
        assert_near_share(most * own, pressure * width, 0.08);
    }
    qg_field_finish(&field);
    qg_model_destroy(model);
}

/* ---- thinned ---------------------------------------------------------------------------------------------------- */

static double area_of(const struct qg_field *field, int gear, const struct qg_field_view *view, size_t q) {
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        double a[2], b[2];
        qg_field_node(field, gear, (size_t)view->node[view->quad[q][k]], a);
        qg_field_node(field, gear, (size_t)view->node[view->quad[q][(k + 1) % 4]], b);
        sum += (a[0] * b[1] - b[0] * a[1]) / 2;
    }
    return sum;
}

/* The view covers the fine sectors once: its area is the sectors', every quadrilateral is turned the right way. */
static void the_view_covers_the_fine_teeth(void **state) {
    (void)state;
    struct qg_model *model = make_model(&standard);
    struct qg_field field;
    make_field(&standard, model, &field);
    for (int g = 0; g < 2; g++) {
        const struct qg_gear_mesh *mesh = &field.gears[g].mesh;
        struct qg_field_view view;
        assert_int_equal(qg_field_view_init(&view, mesh), QG_OK);
        double thin = 0, whole = 0;
        for (size_t q = 0; q < view.quad_count; q++) {
            double area = area_of(&field, g, &view, q);
            assert_true(area > 0);
            thin += area;
        }
        for (size_t e = 0; e < (size_t)mesh->fine_teeth * mesh->fine_elements; e++) {
            double polygon = 0;
            static const int around[8] = {0, 4, 1, 5, 2, 6, 3, 7};
            for (int k = 0; k < 8; k++) {
                double a[2], b[2];
                qg_field_node(&field, g, (size_t)mesh->element[e][around[k]], a);
                qg_field_node(&field, g, (size_t)mesh->element[e][around[(k + 1) % 8]], b);
                polygon += (a[0] * b[1] - b[0] * a[1]) / 2;
            }
            whole += polygon;
        }
        assert_near_share(thin, whole, 2e-3);
        assert_int_equal(view.quad_count, 444 * mesh->fine_teeth);
        qg_field_view_finish(&view);
    }
    qg_field_finish(&field);
    qg_model_destroy(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(balances_and_reproduces_the_transmission_error),
        cmocka_unit_test(any_position_is_the_same_as_one_of_a_period),
        cmocka_unit_test(a_field_can_be_stopped),
        cmocka_unit_test(the_bores_move_as_they_are_held),
        cmocka_unit_test(the_root_is_stressed_as_the_rows_say),
        cmocka_unit_test(the_flank_is_pressed_by_the_contact),
        cmocka_unit_test(the_view_covers_the_fine_teeth),
    };
    qg_numerics_init(1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
