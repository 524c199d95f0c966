/* Stresses of a loaded pair: which side is stretched, what mesh and mirror say, how far from ISO 6336, and that reading them
 * changes nothing. What the rows behind them are worth alone is in test_compliance.c and test_elasticity.c. */
#include "core/stress.h"

#include <stdlib.h>

#include "core/deck.h"
#include "core/iso6336.h"
#include "core/model.h"
#include "core/statics.h"
#include "core/study.h"
#include "tests/core/cases.h"

static const struct qg_relief no_relief, standard_relief = CASE_S_STANDARD;

enum { POSITIONS = 14 };

/* A pair made ready, one design judged at 0.33, 0.66 and 1 times the torque, with stresses. */
struct judged {
    struct qg_model *model;
    struct qg_evaluator evaluator;
    struct qg_design_result *result;
};

static struct judged judge(const struct qg_gear_pair *pair, const struct qg_relief *relief, int refinement,
                           enum qg_bore bore) {
    const struct qg_analysis analysis = {.case_count = 3,
                                         .torque_fraction = {0.33, 0.66, 1},
                                         .mesh_positions = POSITIONS,
                                         .mesh_refinement = refinement,
                                         .bore = bore,
                                         .harmonics = 6,
                                         .speeds = {.min = 0.5, .max = 1, .count = 1}};
    const struct qg_means means = {.executor = qg_serial_executor};
    struct judged j;
    assert_int_equal(qg_model_create(pair, &analysis, &means, NULL, &j.model), QG_OK);
    assert_int_equal(qg_evaluator_init(&j.evaluator, j.model, &means.executor), QG_OK);
    j.result = qg_design_result_create(&analysis);
    assert_non_null(j.result);
    j.result->relief = *relief;
    assert_int_equal(qg_evaluate(&j.evaluator, false, 1, &j.result), QG_OK);
    assert_null(j.result->cases[0].stresses);
    assert_int_equal(qg_evaluate_stresses(&j.evaluator, j.result), QG_OK);
    return j;
}

static void judged_finish(struct judged *j) {
    qg_design_result_destroy(j->result);
    qg_evaluator_finish(&j->evaluator);
    qg_model_destroy(j->model);
}

static const struct qg_root_stress *tension(const struct judged *j, int load_case, int gear) {
    const struct qg_stresses *s = j->result->cases[load_case].stresses;
    return &s->tension[gear][s->most_tension[gear]];
}

static const struct qg_root_stress *compression(const struct judged *j, int load_case, int gear) {
    const struct qg_stresses *s = j->result->cases[load_case].stresses;
    return &s->compression[gear][s->most_compression[gear]];
}

/* Case S without and with relief, case H without: made once. */
static struct judged S_none, S_standard, H_none;

static int judge_all(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S, h = CASE_H;
    S_none = judge(&s, &no_relief, 1, QG_BORE_TORQUE_RING);
    S_standard = judge(&s, &standard_relief, 1, QG_BORE_TORQUE_RING);
    H_none = judge(&h, &no_relief, 1, QG_BORE_TORQUE_RING);
    return 0;
}

static int forget_all(void **state) {
    (void)state;
    judged_finish(&S_none);
    judged_finish(&S_standard);
    judged_finish(&H_none);
    return 0;
}

/* ---- roots --------------------------------------------------------------------------------------------------------- */

static void the_loaded_side_is_stretched_the_other_pressed(void **state) {
    (void)state;
    const struct judged *all[] = {&S_none, &S_standard, &H_none};
    for (int a = 0; a < 3; a++)
        for (int k = 0; k < 3; k++)
            for (int g = 0; g < 2; g++) {
                const struct qg_pair_geometry *geometry = qg_model_geometry(all[a]->model);
                const struct qg_root_stress *t = tension(all[a], k, g), *c = compression(all[a], k, g);
                assert_true(t->stress > 0 && t->at.angle > 0 && t->on_contact_side);
                assert_true(c->stress < 0 && c->at.angle < 0 && !c->on_contact_side);
                /* the load's radial part presses as well */
                assert_true(-c->stress > t->stress);
                double root = qg_model_pair(all[a]->model)->gears[g].root_radius;
                assert_true(t->at.radius > root && t->at.radius < geometry->gears[g].form_radius);
            }
}

static void root_stress_grows_with_the_torque(void **state) {
    (void)state;
    for (int g = 0; g < 2; g++)
        for (int k = 0; k < 2; k++) {
            /* more torque, more teeth in contact: less than in proportion */
            double ratio = tension(&S_none, k + 1, g)->stress / tension(&S_none, k, g)->stress;
            double torque = S_none.result->cases[k + 1].torque / S_none.result->cases[k].torque;
            assert_true(ratio > 1.2 && ratio < torque * 1.005);
        }
}

/* With the standard relief one pair carries everything for a while: then force and stress are in proportion, but for where on
 * the flank the load lies: its middle moves by some hundredths of a millimetre. */
static void a_pair_alone_is_stressed_in_proportion(void **state) {
    (void)state;
    for (int g = 0; g < 2; g++) {
        size_t middle = POSITIONS / 2;
        for (int k = 0; k < 3; k++)
            assert_near(S_standard.result->cases[k].load_share[middle * QG_PAIR_COUNT + QG_PAIR_REACH], 1, 1e-12);
        const struct qg_case_result *low = &S_standard.result->cases[0], *full = &S_standard.result->cases[2];
        assert_near_share(full->stresses->tension[g][middle].stress / low->stresses->tension[g][middle].stress,
                          full->torque / low->torque, 3e-3);
    }
}

static void root_stress_is_mesh_converged(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S, h = CASE_H;
    struct judged fine_S = judge(&s, &no_relief, 2, QG_BORE_TORQUE_RING);
    struct judged fine_H = judge(&h, &no_relief, 2, QG_BORE_TORQUE_RING);
    const struct judged *coarse[] = {&S_none, &H_none}, *fine[] = {&fine_S, &fine_H};
    for (int a = 0; a < 2; a++)
        for (int k = 0; k < 3; k++)
            for (int g = 0; g < 2; g++) {
                assert_near_share(tension(coarse[a], k, g)->stress, tension(fine[a], k, g)->stress, 0.011);
                assert_near_share(compression(coarse[a], k, g)->stress, compression(fine[a], k, g)->stress, 0.011);
            }
    judged_finish(&fine_S);
    judged_finish(&fine_H);
}

/* Two equal gears with equal bores: turning back is turning on with the gears exchanged, but for the contact points, which
 * are laid on the gear's flank in approach and on the pinion's in recess. */
static void twins_mirror_each_other(void **state) {
    (void)state;
    const struct qg_gear_pair pair = CASE_B;
    struct judged b = judge(&pair, &no_relief, 1, QG_BORE_CLAMPED);
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < POSITIONS; i++) {
            const struct qg_stresses *s = b.result->cases[k].stresses;
            size_t back = (POSITIONS - i) % POSITIONS;
            double most = tension(&b, k, QG_PINION)->stress;
            assert_near(s->tension[QG_PINION][i].stress, s->tension[QG_GEAR][back].stress, 0.01 * most);
            assert_near(s->compression[QG_PINION][i].stress, s->compression[QG_GEAR][back].stress, 0.01 * most);
        }
    judged_finish(&b);
}

/* ---- one force ------------------------------------------------------------------------------------------------------ */

/* One force on the flank of one tooth, against it. */
struct one_load {
    int gear;
    double face_width, radius, force; /* mm, mm, N */
};

/* The largest and the smallest stress in the tooth's root (MPa), bore fixed, on a mesh of a given density. */
static void stress_on_mesh(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g,
                           const struct one_load *load, const struct qg_mesh_density *density, double out[2]) {
    const struct qg_compliance_plan plan = {
        {pair->material.youngs_modulus, pair->material.poisson_ratio, load->face_width, 0},
        QG_SUPPORT_FIXED,
        pair->gears[load->gear].teeth,
        1,
        .stop = {0}};
    const struct qg_gear_geometry *gear = &g->gears[load->gear];
    struct qg_sector_mesh mesh;
    struct qg_compliance c;
    assert_int_equal(qg_sector_mesh_init_with(&mesh, &pair->rack, &pair->gears[load->gear], gear, density, 1, NULL),
                     QG_OK);
    assert_int_equal(qg_compliance_init(&c, &mesh, &plan), QG_OK);
    double *influence = malloc(c.root_count * 2 * c.flank_count * sizeof *influence);
    assert_non_null(influence);
    assert_int_equal(qg_compliance_stress(&c, 0, influence), QG_OK);
    double radius = load->radius, base = gear->base_radius;
    struct qg_spread spread = {0};
    /* the normal points away from the tooth; the load against it */
    double normal = qg_half_tooth_angle(&pair->rack, gear, radius) + M_PI_2 - acos(base / radius);
    qg_spread_add(&spread, &c, (radius * radius - base * base) / (2 * base), normal, -load->force);
    out[0] = out[1] = 0;
    for (size_t i = 0; i < c.root_count; i++) {
        double stress = 0;
        for (size_t j = 0; j < 2 * spread.count; j++)
            stress += spread.weight[j] * influence[i + c.root_count * (2 * spread.first + j)];
        out[0] = fmax(out[0], stress);
        out[1] = fmin(out[1], stress);
    }
    free(influence);
    qg_compliance_finish(&c);
    qg_sector_mesh_finish(&mesh);
}

/* The same on the mesh of the analysis. */
static void stress_under_one_load(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g,
                                  const struct one_load *load, double out[2]) {
    stress_on_mesh(pair, g, load, &qg_density_analysis, out);
}

/* The mesh of exported decks, three times coarser, shows both fillets: how a solver's picture of it will look. */
static void decks_show_the_stress_of_both_fillets(void **state) {
    (void)state;
    for (size_t k = 0; k < CASE_COUNT; k++)
        for (int gear = 0; gear < 2; gear++) {
            const struct qg_gear_pair *pair = &all_cases[k].pair;
            struct qg_pair_geometry g;
            assert_int_equal(qg_pair_derive(pair, &g, NULL), QG_OK);
            const struct one_load load = {gear, 20, g.gears[gear].reference_radius, 1e4};
            double coarse[2], fine[2];
            stress_on_mesh(pair, &g, &load, &qg_density_deck, coarse);
            stress_on_mesh(pair, &g, &load, &qg_density_analysis, fine);
            assert_near_share(coarse[0], fine[0], 0.035);
            assert_near_share(coarse[1], fine[1], 0.035);
        }
}

/* The pinion of case S as a whole, by CalculiX 2.20 on 42 118 quadratic triangles drawn by Gmsh (0.04 mm in the fillet; with
 * 0.08 mm 281.2 and -281.3): a force of 11908.5 N on a node of the flank at radius 42 mm, bore fixed, plane stress. */
static void one_loaded_tooth_matches_calculix(void **state) {
    (void)state;
    const struct qg_gear_pair pair = CASE_S;
    struct qg_pair_geometry g;
    assert_int_equal(qg_pair_derive(&pair, &g, NULL), QG_OK);
    const struct one_load load = {QG_PINION, 27, 42, 11908.5};
    double stress[2];
    stress_under_one_load(&pair, &g, &load, stress);
    assert_near_share(stress[0], 281.3, 0.005);
    assert_near_share(stress[1], -281.8, 0.005);
}

/* Under the very load that the standard supposes, finite elements and its formulas are two independent ways to the same
 * stress: they find 0.85 to 1.02 of it, least where the fillet is large against the tooth (case S). */
static void one_tooth_under_isos_load_is_near_isos_stress(void **state) {
    (void)state;
    for (size_t k = 0; k < CASE_COUNT; k++) {
        struct qg_pair_geometry g;
        struct qg_iso6336 iso;
        assert_int_equal(qg_pair_derive(&all_cases[k].pair, &g, NULL), QG_OK);
        assert_int_equal(qg_iso6336_rate(&all_cases[k].pair, &g, all_cases[k].pair.nominal_torque, &iso), QG_OK);
        for (int gear = 0; gear < 2; gear++) {
            const struct one_load load = {gear, iso.root_face_width[gear],
                                          iso.root[gear].load_radius * all_cases[k].pair.rack.module,
                                          all_cases[k].pair.nominal_torque / g.gears[QG_PINION].base_radius};
            double stress[2];
            stress_under_one_load(&all_cases[k].pair, &g, &load, stress);
            double ratio = stress[0] * iso.deep_tooth_factor / iso.root_stress[gear];
            if (!(ratio > 0.85 && ratio < 1.03))
                fail_msg("%s, gear %d: %.3f of ISO's stress", all_cases[k].name, gear, ratio);
        }
    }
}

/* ---- pressure ------------------------------------------------------------------------------------------------------ */

static void pressures_are_those_of_the_statics(void **state) {
    (void)state;
    const struct judged *all[] = {&S_none, &S_standard, &H_none};
    for (int a = 0; a < 3; a++)
        for (int k = 0; k < 3; k++) {
            const struct qg_case_result *c = &all[a]->result->cases[k];
            const struct qg_pair_geometry *g = qg_model_geometry(all[a]->model);
            for (size_t i = 0; i < POSITIONS; i++) {
                double most = 0;
                for (int p = 0; p < QG_PAIR_COUNT; p++) {
                    const struct qg_pair_pressure *here = &c->stresses->pressure[i * QG_PAIR_COUNT + (size_t)p];
                    most = fmax(most, here->pressure);
                    if (c->load_share[i * QG_PAIR_COUNT + (size_t)p] == 0)
                        assert_true(here->pressure == 0);
                    if (here->pressure == 0)
                        continue;
                    double middle = (g->path_start + g->path_end) / 2;
                    double path = middle + ((double)i / POSITIONS - 0.5 + p - QG_PAIR_REACH) * g->base_pitch;
                    assert_near(here->path, path, 1e-12);
                    /* touching points look at each other, near the line of action */
                    for (int gear = 0; gear < 2; gear++)
                        assert_true(here->radius[gear] > g->gears[gear].form_radius &&
                                    here->radius[gear] <= qg_model_pair(all[a]->model)->gears[gear].outside_radius);
                }
                assert_true(most == c->contact_pressure[i]);
            }
            assert_true(c->stresses->pressure[c->stresses->most_pressure].pressure == c->max_contact_pressure);
        }
}

/* ---- purity -------------------------------------------------------------------------------------------------------- */

static void stresses_leave_the_design_as_it_is(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    struct judged again = judge(&s, &standard_relief, 1, QG_BORE_TORQUE_RING);
    assert_int_equal(qg_evaluate_stresses(&again.evaluator, again.result), QG_OK); /* twice into the same room */
    for (int k = 0; k < 3; k++) {
        const struct qg_case_result *a = &again.result->cases[k], *b = &S_standard.result->cases[k];
        assert_memory_equal(a->static_transmission_error, b->static_transmission_error, POSITIONS * sizeof(double));
        assert_memory_equal(a->contact_pressure, b->contact_pressure, POSITIONS * sizeof(double));
        for (int g = 0; g < 2; g++)
            for (size_t i = 0; i < POSITIONS; i++) {
                assert_true(a->stresses->tension[g][i].stress == b->stresses->tension[g][i].stress);
                assert_true(a->stresses->compression[g][i].stress == b->stresses->compression[g][i].stress);
            }
    }
    judged_finish(&again);
}

static bool always(void *self) {
    (void)self;
    return true;
}

static void a_cancelled_evaluator_finds_none(void **state) {
    (void)state;
    S_none.evaluator.cancelled = always;
    assert_int_equal(qg_evaluate_stresses(&S_none.evaluator, S_none.result), QG_CANCELLED);
    S_none.evaluator.cancelled = NULL;
    assert_int_equal(qg_evaluate_stresses(&S_none.evaluator, S_none.result), QG_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_loaded_side_is_stretched_the_other_pressed),
        cmocka_unit_test(root_stress_grows_with_the_torque),
        cmocka_unit_test(a_pair_alone_is_stressed_in_proportion),
        cmocka_unit_test(root_stress_is_mesh_converged),
        cmocka_unit_test(twins_mirror_each_other),
        cmocka_unit_test(decks_show_the_stress_of_both_fillets),
        cmocka_unit_test(one_loaded_tooth_matches_calculix),
        cmocka_unit_test(one_tooth_under_isos_load_is_near_isos_stress),
        cmocka_unit_test(pressures_are_those_of_the_statics),
        cmocka_unit_test(stresses_leave_the_design_as_it_is),
        cmocka_unit_test(a_cancelled_evaluator_finds_none),
    };
    qg_numerics_init(1);
    return cmocka_run_group_tests(tests, judge_all, forget_all);
}
