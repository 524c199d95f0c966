/* Job documents: defaults, units, the echo, and that every fault is found at its place. */
#include <cjson/cJSON.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/fields.h"
#include "tests/schema/support.h"

static struct qg_job job, again;
static struct qg_faults faults;

/* A document in which no member has its default. */
static const char everything[] =
    "{\"kind\":\"optimize\",\"name\":\"all \\\"members\\\" \\u00e9 \\ud83d\\ude00\",\"external_id\":\"PLM "
    "7\",\"labels\":[\"one\",\"two\"],"
    "\"gear_pair\":{\"name\":\"pair\",\"module_mm\":3,\"pressure_angle_deg\":20,\"center_distance_mm\":111,"
    "\"pinion\":{\"teeth\":28,\"profile_shift_mm\":1.927,\"outside_radius_mm\":46.55,\"root_radius_mm\":39.55,"
    "\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":27,\"moment_of_inertia_kg_mm2\":800.25},"
    "\"gear\":{\"teeth\":43,\"profile_shift_mm\":2.748,\"outside_radius_mm\":69.55,\"root_radius_mm\":63.1,"
    "\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":22.5,\"moment_of_inertia_kg_mm2\":3700},"
    "\"material\":{\"youngs_modulus_mpa\":206000,\"poisson_ratio\":0.3,\"density_kg_per_m3\":7850},"
    "\"damping_ratio\":0.01,\"nominal_torque_nm\":470},"
    "\"load_cases\":[{\"torque_fraction\":0.5},{\"torque_nm\":155.1}],"
    "\"relief\":{\"shape\":\"parabolic\",\"ramp\":\"roll_angle\","
    "\"pinion\":{\"tip\":{\"start_radius_mm\":44.54,\"amplitude_mm\":0.016},\"root\":{\"end_radius_mm\":42.9,"
    "\"amplitude_mm\":0.01}},\"gear\":{\"tip\":{\"start_radius_mm\":67.64,\"amplitude_mm\":0.018},"
    "\"root\":{\"end_radius_mm\":65.5,\"amplitude_mm\":0.011}}},"
    "\"analysis\":{\"mesh_positions\":28,\"mesh_refinement\":2,\"plane\":\"strain\",\"bore\":\"clamped\","
    "\"mesh_stiffness\":\"consistent\",\"harmonics\":8,\"speeds\":{\"min\":0.3,\"max\":1.3,\"count\":101},"
    "\"branch\":\"run_up\",\"initial_condition\":{\"displacement\":1.25,\"velocity\":0.5}},\"objective\":\"f_pps\","
    "\"relief_bounds\":{\"pinion\":{\"tip\":{\"start_radius_mm\":[42,46.55],\"amplitude_mm\":[0.003,0.035]},"
    "\"root\":{\"end_radius_mm\":[41,44],\"amplitude_mm\":[0.001,0.02]}},"
    "\"gear\":{\"tip\":{\"start_radius_mm\":[64,69.55],\"amplitude_mm\":[0.003,0.035]},"
    "\"root\":{\"end_radius_mm\":[64,67],\"amplitude_mm\":[0.001,0.02]}}},"
    "\"optimizer\":{\"method\":\"random_simplex\",\"random_samples\":300,\"simplex_iterations\":81,"
    "\"seed\":9007199254740991,\"verification_factor\":2},\"reliability\":{\"samples\":50,\"radius_range_mm\":0.1,"
    "\"amplitude_range_mm\":0.01,"
    "\"limit_f_dte\":0.4,\"seed\":7,\"percentile\":95,\"percentile_trials\":30}}";

static void read_good(const char *text) {
    if (read_exact(text, strlen(text), &job, &faults) != QG_DOCUMENT_OK)
        fail_msg("%s: %s", faults.item[0].pointer, faults.item[0].detail);
    assert_int_equal(faults.count + faults.lost, 0);
}

static enum qg_document_status read_text(const char *text) {
    return read_exact(text, strlen(text), &job, &faults);
}

/* Defaults */

static void analysis_has_its_defaults(void **state) {
    (void)state;
    read_good(least_evaluate);
    const struct qg_analysis *a = &job.study.analysis;
    assert_int_equal(job.study.kind, QG_STUDY_EVALUATE);
    assert_string_equal(job.name, "");
    assert_string_equal(job.pair_name, "");
    assert_int_equal(job.label_count, 0);
    assert_int_equal(a->case_count, 3);
    assert_true(a->torque_fraction[0] == 0.33 && a->torque_fraction[1] == 0.66 && a->torque_fraction[2] == 1);
    assert_int_equal(a->mesh_positions, 14);
    assert_int_equal(a->mesh_refinement, 1);
    assert_int_equal(a->plane, QG_PLANE_STRESS);
    assert_int_equal(a->bore, QG_BORE_TORQUE_RING);
    assert_int_equal(a->mesh_stiffness, QG_STIFFNESS_SECANT);
    assert_int_equal(a->harmonics, 6);
    assert_true(a->speeds.min == 0.2 && a->speeds.max == 1.4);
    assert_int_equal(a->speeds.count, 1000);
    assert_int_equal(a->speeds.branch, QG_BRANCH_FIXED);
    assert_int_equal(a->speeds.start_static, 1);
    assert_true(a->speeds.start_displacement == 0 && a->speeds.start_velocity == 0);
}

static void an_evaluation_without_relief_is_pure_involute(void **state) {
    (void)state;
    read_good(least_evaluate);
    assert_int_equal(job.study.relief.shape, QG_SHAPE_LINEAR);
    assert_int_equal(job.study.relief.ramp, QG_RAMP_RADIUS);
    for (int i = 0; i < 2; i++) {
        assert_false(job.study.relief.gears[i].tip.present || job.study.relief.gears[i].root.present);
        assert_true(job.study.pair.gears[i].moment_of_inertia == 0);
    }
    assert_int_equal(job.study.bounds.count, 0);
    assert_int_equal(job.study.reliability.samples, 0);
}

static void an_optimization_has_its_defaults(void **state) {
    (void)state;
    read_good(least_optimize);
    assert_int_equal(job.study.kind, QG_STUDY_OPTIMIZE);
    assert_int_equal(job.study.objective, QG_OBJECTIVE_F_DTE);
    assert_int_equal(job.study.optimizer.random_samples, 180);
    assert_int_equal(job.study.optimizer.simplex_iterations, 80);
    assert_int_equal(job.study.optimizer.seed, 1);
    assert_int_equal(job.study.reliability.samples, 0);
    assert_int_equal(job.study.bounds.count, 2); /* ascending, though the document has them the other way round */
    assert_int_equal(job.study.bounds.parameter[0], QG_GEAR_TIP_START_RADIUS);
    assert_int_equal(job.study.bounds.parameter[1], QG_GEAR_TIP_AMPLITUDE);
    assert_true(job.study.bounds.lower[0] == 64 && job.study.bounds.upper[0] == 69.55);
    assert_true(job.study.bounds.lower[1] == 0.003 && job.study.bounds.upper[1] == 0.035);
}

static void reliability_has_its_defaults(void **state) {
    (void)state;
    read_good(least_reliability);
    const struct qg_reliability *r = &job.study.reliability;
    assert_int_equal(job.study.kind, QG_STUDY_RELIABILITY);
    assert_int_equal(r->samples, 100);
    assert_true(r->radius_range == 0.2 && r->amplitude_range == 0.012 && r->limit_f_dte == 0.5);
    assert_int_equal(r->seed, 1);
    assert_true(job.study.relief.gears[QG_PINION].tip.present);
    assert_false(job.study.relief.gears[QG_PINION].root.present || job.study.relief.gears[QG_GEAR].tip.present);
}

static void a_map_has_its_defaults(void **state) {
    (void)state;
    read_good(least_map);
    const struct qg_grid *grid = &job.study.grid;
    assert_int_equal(job.study.kind, QG_STUDY_MAP);
    assert_int_equal(job.study.objective, QG_OBJECTIVE_F_DTE);
    assert_int_equal(grid->count, 2); /* in the document's order: the first one runs over the rows */
    assert_int_equal(grid->axis[0].parameter, QG_GEAR_ROOT_AMPLITUDE);
    assert_int_equal(grid->axis[1].parameter, QG_GEAR_ROOT_END_RADIUS);
    assert_true(grid->axis[0].from == 0.02 && grid->axis[0].to == 0 && grid->axis[1].to == 66.5);
    assert_int_equal(grid->axis[0].count, 15);
    assert_int_equal(grid->axis[1].count, 6);
    assert_int_equal(job.study.bounds.count, 0);
    assert_int_equal(job.study.optimizer.random_samples, 0);
    assert_int_equal(job.study.reliability.samples, 0);
    assert_false(job.study.relief.gears[QG_GEAR].root.present);
}

/* Ranges come from the initial pair, in core (core/macro.h). */
static void a_macro_search_has_its_defaults(void **state) {
    (void)state;
    read_good(least_macro);
    const struct qg_macro *m = &job.study.macro;
    assert_int_equal(job.study.kind, QG_STUDY_MACRO);
    assert_int_equal(job.study.objective, QG_OBJECTIVE_F_DTE);
    assert_true(m->samples == 1000000000 && m->seed == 1 && m->keep == 10);
    assert_true(m->ranges.module.low == 1.5 && m->ranges.gears[QG_GEAR].teeth.high == 77);
    assert_true(m->ranges.gears[QG_PINION].hob_tip_radius < 0 && m->ranges.gears[QG_GEAR].hob_tip_radius < 0);
    assert_float_equal(m->limits.backlash.high, 1.2 * 0.312080643966965, 1e-9);
    assert_true(m->limits.ratio_percent == 1 && m->limits.tip_thickness == 0.4 && m->limits.tip_clearance == 0.25);
    assert_true(m->limits.contact_stress_factor == 1 && m->limits.root_stress_factor == 1);
    assert_false(job.study.relief.gears[QG_PINION].tip.present);
    assert_int_equal(job.study.optimizer.random_samples, 0);
}

static void a_macro_search_is_read(void **state) {
    static const char members[] =
        ",\"objective\":\"f_pps\",\"macro\":{\"samples\":100000000000,\"seed\":7,\"keep\":3,\"ranges\":{"
        "\"gear\":{\"profile_shift_mm\":[0,0],\"hob_tip_radius_mm\":0},\"pinion\":{\"teeth\":[30,40]}},"
        "\"constraints\":{\"backlash_mm\":[0,0.5],\"root_stress_factor\":1.25}}}";
    char document[4096];
    (void)state;
    snprintf(document, sizeof document, "%.*s%s", (int)strlen(least_macro) - 1, least_macro, members);
    read_good(document);
    const struct qg_macro *m = &job.study.macro;
    assert_true(m->samples == 100000000000 && m->seed == 7 && m->keep == 3);
    assert_int_equal(job.study.objective, QG_OBJECTIVE_F_PPS);
    assert_true(m->ranges.gears[QG_GEAR].profile_shift.low == 0 && m->ranges.gears[QG_GEAR].profile_shift.high == 0);
    assert_true(m->ranges.gears[QG_GEAR].hob_tip_radius == 0 && m->ranges.gears[QG_PINION].hob_tip_radius < 0);
    assert_true(m->ranges.gears[QG_PINION].teeth.low == 30 && m->ranges.gears[QG_PINION].teeth.high == 40);
    assert_true(m->limits.backlash.low == 0 && m->limits.backlash.high == 0.5 && m->limits.root_stress_factor == 1.25);
}

/* A pair drawn in degrees and written into a document is read as the very same pair. */
static void a_written_pair_is_the_same_pair(void **state) {
    static struct qg_job initial;
    (void)state;
    read_good(least_macro);
    initial = job;
    uint64_t seed = 11;
    for (int i = 0; i < 300; i++) {
        struct qg_gear_pair pair = initial.study.pair;
        const double share = (double)(next_random(&seed) >> 11) * 0x1p-53, degrees = 19.99 + share / 50;
        struct qg_text text = {0};
        pair.rack.pressure_angle = degrees * (M_PI / 180);
        pair.gears[QG_PINION].hob_tip_radius -= share / 3;
        pair.gears[QG_GEAR].outside_radius -= share / 7;
        qg_text_format(&text, "{\"kind\":\"evaluate\",\"gear_pair\":");
        qg_pair_write(&text, &initial, &pair, degrees, "another");
        qg_text_format(&text, "}");
        assert_false(text.failed);
        read_good(text.data);
        assert_memory_equal(&job.study.pair, &pair, sizeof pair);
        assert_string_equal(job.pair_name, "another");
        qg_text_finish(&text);
    }
}

/* The document of `least_evaluate` with more members behind the kind. The caller frees it. */
static char *evaluate_with(const char *members) {
    const size_t length = strlen(least_evaluate), room = length + strlen(members) + 2;
    char *text = malloc(room);
    assert_non_null(text);
    snprintf(text, room, "%.*s,%s}", (int)length - 1, least_evaluate, members);
    return text;
}

static void few_positions_take_fewer_harmonics(void **state) {
    (void)state;
    for (int n = 4; n <= 16; n++) {
        char members[80];
        snprintf(members, sizeof members, "\"analysis\":{\"mesh_positions\":%d}", n);
        char *text = evaluate_with(members);
        read_good(text);
        assert_int_equal(job.study.analysis.harmonics, n < 13 ? (n - 1) / 2 : 6);
        free(text);
    }
}

/* Units and values */

static void units_become_those_of_core(void **state) {
    (void)state;
    read_good(everything);
    const struct qg_gear_pair *pair = &job.study.pair;
    assert_float_equal(pair->rack.pressure_angle, 0.3490658503988659, 1e-15);
    assert_float_equal(pair->material.density, 7.85e-6, 1e-20);
    assert_float_equal(pair->nominal_torque, 470000, 1e-9);
    assert_float_equal(job.study.analysis.torque_fraction[1], 0.33, 1e-15);
    assert_true(job.study.analysis.torque_fraction[0] == 0.5);
    assert_true(pair->gears[QG_PINION].moment_of_inertia == 800.25);
}

static void every_member_is_stored(void **state) {
    (void)state;
    read_good(everything);
    const struct qg_study *s = &job.study;
    assert_string_equal(job.name, "all \"members\" \xc3\xa9 \xf0\x9f\x98\x80");
    assert_string_equal(job.labels[1], "two");
    assert_int_equal(s->pair.gears[QG_PINION].teeth, 28);
    assert_true(s->pair.gears[QG_GEAR].profile_shift == 2.748 && s->pair.gears[QG_GEAR].face_width == 22.5);
    assert_int_equal(s->relief.shape, QG_SHAPE_PARABOLIC);
    assert_int_equal(s->relief.ramp, QG_RAMP_ROLL_ANGLE);
    assert_true(s->relief.gears[QG_GEAR].root.radius == 65.5 && s->relief.gears[QG_GEAR].root.amplitude == 0.011);
    assert_int_equal(s->analysis.plane, QG_PLANE_STRAIN);
    assert_int_equal(s->analysis.bore, QG_BORE_CLAMPED);
    assert_int_equal(s->analysis.mesh_stiffness, QG_STIFFNESS_CONSISTENT);
    assert_int_equal(s->analysis.speeds.branch, QG_BRANCH_RUN_UP);
    assert_int_equal(s->analysis.speeds.start_static, 0);
    assert_true(s->analysis.speeds.start_displacement == 1.25 && s->analysis.speeds.start_velocity == 0.5);
    assert_int_equal(s->objective, QG_OBJECTIVE_F_PPS);
    assert_int_equal(s->bounds.count, QG_PARAMETER_COUNT);
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        assert_int_equal(s->bounds.parameter[i], i);
    assert_true(s->optimizer.seed == 9007199254740991);
    assert_int_equal(s->reliability.samples, 50);
}

static void every_definition_of_the_mesh_stiffness_is_read(void **state) {
    (void)state;
    const char *const names[] = {"secant", "consistent", "load_dependent"};
    for (int i = 0; i < 3; i++) {
        char text[4096];
        size_t length = strlen(least_evaluate);
        assert_int_equal(least_evaluate[length - 1], '}');
        snprintf(text, sizeof text, "%.*s,\"analysis\":{\"mesh_stiffness\":\"%s\"}}", (int)(length - 1), least_evaluate,
                 names[i]);
        read_good(text);
        assert_int_equal(job.study.analysis.mesh_stiffness, i);
    }
}

static void whole_numbers_may_be_written_in_any_way(void **state) {
    (void)state;
    char *text = evaluate_with("\"analysis\":{\"mesh_positions\":1.6e1,\"harmonics\":5.0}");
    read_good(text);
    assert_int_equal(job.study.analysis.mesh_positions, 16);
    assert_int_equal(job.study.analysis.harmonics, 5);
    free(text);
}

/* The echo */

/* Reads, writes, reads and writes: the same struct to the byte, and the same text. */
static void assert_echo(const char *text, size_t length) {
    struct qg_text first = {0}, second = {0};
    assert_int_equal(read_exact(text, length, &job, &faults), QG_DOCUMENT_OK);
    qg_document_write(&first, &job);
    assert_false(first.failed);
    if (read_exact(first.data, first.length, &again, &faults) != QG_DOCUMENT_OK)
        fail_msg("%s: %s in %s", faults.item[0].pointer, faults.item[0].detail, first.data);
    qg_document_write(&second, &again);
    assert_string_equal(first.data, second.data);
    assert_memory_equal(&job, &again, sizeof job);
    qg_text_finish(&first);
    qg_text_finish(&second);
}

static void documents_echo(void **state) {
    static const char *const examples[] = {"case_H_optimize",
                                           "case_S_clamped",
                                           "case_S_none",
                                           "case_S_optimize",
                                           "case_S_reliability",
                                           "case_S_standard",
                                           "case_S_map_radii",
                                           "case_S_map_amplitudes",
                                           "case_S_macro",
                                           "case_H_optimize_8",
                                           "case_H_stresses",
                                           "case_H_optimize_8_multistart",
                                           "case_S_pareto",
                                           "case_S_robust",
                                           "case_S_optimize_parabolic",
                                           "case_S_optimize_parabolic_f_pps"};
    (void)state;
    assert_echo(everything, sizeof everything - 1);
    assert_echo(least_evaluate, strlen(least_evaluate));
    assert_echo(least_optimize, strlen(least_optimize));
    assert_echo(least_reliability, strlen(least_reliability));
    assert_echo(least_map, strlen(least_map));
    assert_echo(least_macro, strlen(least_macro));
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
        char name[100];
        size_t length;
        snprintf(name, sizeof name, "schema/examples/%s.json", examples[i]);
        char *text = read_source_file(name, &length);
        assert_echo(text, length);
        free(text);
    }
}

/* Each search method has its own parameters in the echo, and one objective or several. */
static void the_echo_names_what_the_search_uses(void **state) {
    static const struct {
        const char *document, *there[3], *absent[3];
    } rows[] = {
        {"case_S_optimize",
         {"\"random_samples\"", "\"objective\"", "\"f_dte\""},
         {"\"evaluations\"", "\"objectives\"", "\"starts\""}},
        {"case_H_optimize_8_multistart",
         {"\"evaluations\"", "\"starts\"", "\"objective\""},
         {"\"random_samples\"", "\"simplex_iterations\"", "\"percentile\""}},
        {"case_S_pareto",
         {"\"objectives\"", "\"f_pps\"", "\"evaluations\""},
         {"\"objective\"", "\"f_dte_percentile\"", "\"random_samples\""}},
        {"case_S_robust",
         {"\"f_dte_percentile\"", "\"percentile\"", "\"percentile_trials\""},
         {"\"objectives\"", "\"random_samples\"", "\"grid\""}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct qg_text text = {0};
        char name[100];
        size_t length;
        snprintf(name, sizeof name, "schema/examples/%s.json", rows[i].document);
        char *document = read_source_file(name, &length);
        assert_int_equal(read_exact(document, length, &job, &faults), QG_DOCUMENT_OK);
        qg_document_write(&text, &job);
        for (int k = 0; k < 3; k++) {
            assert_non_null(strstr(text.data, rows[i].there[k]));
            assert_null(strstr(text.data, rows[i].absent[k]));
        }
        qg_text_finish(&text);
        free(document);
    }
}

/* A document that gives everything is its own echo, member for member (escapes apart). */
static void the_full_document_is_its_own_echo(void **state) {
    struct qg_text text = {0};
    (void)state;
    read_good(everything);
    qg_document_write(&text, &job);
    cJSON *given = cJSON_Parse(everything), *written = cJSON_Parse(text.data);
    assert_true(cJSON_Compare(given, written, true));
    cJSON_Delete(given);
    cJSON_Delete(written);
    qg_text_finish(&text);
}

/* The number at a member of gear_pair in the echo. */
static double echoed(const char *object, const char *key) {
    struct qg_text text = {0};
    qg_document_write(&text, &job);
    cJSON *root = cJSON_Parse(text.data);
    const cJSON *pair = cJSON_GetObjectItemCaseSensitive(root, "gear_pair");
    const cJSON *item =
        cJSON_GetObjectItemCaseSensitive(object ? cJSON_GetObjectItemCaseSensitive(pair, object) : pair, key);
    assert_non_null(item);
    const double value = item->valuedouble;
    cJSON_Delete(root);
    qg_text_finish(&text);
    return value;
}

/* Figures with another unit in core come back to the last bit, whatever they are. */
static void converted_numbers_come_back_exactly(void **state) {
    uint64_t seed = 4;
    (void)state;
    cJSON *root = cJSON_Parse(least_evaluate);
    cJSON *pair = cJSON_GetObjectItemCaseSensitive(root, "gear_pair");
    cJSON *density =
        cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(pair, "material"), "density_kg_per_m3");
    for (int i = 0; i < 2000; i++) {
        const double share = (double)(next_random(&seed) >> 11) * 0x1p-53;
        const double angle = i ? 19.95 + share / 10 : 20, rho = i ? 100 + share * 29000 : 7850,
                     torque = i ? 0.1 + 900 * share : 470;
        cJSON_SetNumberValue(cJSON_GetObjectItemCaseSensitive(pair, "pressure_angle_deg"), angle);
        cJSON_SetNumberValue(cJSON_GetObjectItemCaseSensitive(pair, "nominal_torque_nm"), torque);
        cJSON_SetNumberValue(density, rho);
        char *text = cJSON_PrintUnformatted(root);
        cJSON *read_back = cJSON_Parse(text); /* what cJSON really wrote: it drops bits of one number in eight */
        read_good(text);
        const cJSON *p = cJSON_GetObjectItemCaseSensitive(read_back, "gear_pair");
        assert_true(echoed(NULL, "pressure_angle_deg") ==
                    cJSON_GetObjectItemCaseSensitive(p, "pressure_angle_deg")->valuedouble);
        assert_true(echoed(NULL, "nominal_torque_nm") ==
                    cJSON_GetObjectItemCaseSensitive(p, "nominal_torque_nm")->valuedouble);
        assert_true(
            echoed("material", "density_kg_per_m3") ==
            cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(p, "material"), "density_kg_per_m3")
                ->valuedouble);
        cJSON_Delete(read_back);
        cJSON_free(text);
    }
    cJSON_Delete(root);
}

/* Faults */

static void all_faults_come_at_once(void **state) {
    static const char *const expected[] = {"/name",           "/gear_pair/module_mm", "/gear_pair/pinion/teeth",
                                           "/gear_pair/gear", "/analysis/plane",      "/colour"};
    (void)state;
    assert_int_equal(
        read_text("{\"kind\":\"evaluate\",\"name\":1,\"gear_pair\":{\"module_mm\":-3,\"pressure_angle_deg\":20,"
                  "\"center_distance_mm\":111,\"pinion\":{\"teeth\":3,\"profile_shift_mm\":1.927,"
                  "\"outside_radius_mm\":46.55,\"root_radius_mm\":39.55,\"hob_tip_radius_mm\":0.9,"
                  "\"bore_diameter_mm\":40,\"face_width_mm\":27},\"material\":{\"youngs_modulus_mpa\":206000,"
                  "\"poisson_ratio\":0.3,\"density_kg_per_m3\":7850},\"damping_ratio\":0.01,"
                  "\"nominal_torque_nm\":470},\"analysis\":{\"plane\":\"stres\"},\"colour\":1}"),
        QG_DOCUMENT_INVALID);
    assert_int_equal(faults.count, sizeof expected / sizeof *expected);
    for (size_t i = 0; i < faults.count; i++)
        assert_string_equal(faults.item[i].pointer, expected[i]);
}

static void words_say_what_was_found_and_what_is_allowed(void **state) {
    static const struct {
        const char *members, *pointer, *detail;
    } cases[] = {
        {"\"analysis\":{\"mesh_positions\":3}", "/analysis/mesh_positions", "found 3, allowed 4 to 512"},
        {"\"analysis\":{\"mesh_positions\":\"x\\ny\"}", "/analysis/mesh_positions",
         "found \"x\\u000ay\", allowed a whole number from 4 to 512"},
        {"\"analysis\":{\"plane\":\"stres\"}", "/analysis/plane", "found \"stres\", allowed \"stress\" or \"strain\""},
        {"\"analysis\":{\"branch\":\"best\"}", "/analysis/branch",
         "found \"best\", allowed \"fixed\", \"run_up\", \"run_down\" or \"worst\""},
        {"\"analysis\":{\"harmonic\":6}", "/analysis/harmonic",
         "found the unknown key \"harmonic\", did you mean \"harmonics\"?"},
        {"\"Relief\":{}", "/Relief", "found the unknown key \"Relief\", did you mean \"relief\"?"},
        {"\"objective\":\"f_dte\"", "/objective",
         "found a key that kind \"evaluate\" does not use, allowed with \"optimize\" or \"map\" or \"macro\" only"},
        {"\"grid\":[]", "/grid", "found a key that kind \"evaluate\" does not use, allowed with \"map\" only"},
        {"\"reliability\":{}", "/reliability",
         "found a key that kind \"evaluate\" does not use, allowed with \"optimize\" or \"reliability\" only"},
        {"\"load_cases\":[]", "/load_cases", "found 0 load cases, allowed 1 to 16"},
        {"\"load_cases\":[{}]", "/load_cases/0",
         "found neither torque_fraction nor torque_nm, allowed exactly one of them"},
        {"\"relief\":{\"gear\":{\"tip\":{\"amplitude_mm\":0.01}}}", "/relief/gear/tip/start_radius_mm",
         "found nothing, allowed a number from 0.1 to 20000"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = evaluate_with(cases[i].members);
        assert_int_equal(read_text(text), QG_DOCUMENT_INVALID);
        assert_int_equal(faults.count, 1);
        assert_string_equal(faults.item[0].pointer, cases[i].pointer);
        assert_string_equal(faults.item[0].detail, cases[i].detail);
        free(text);
    }
}

static void faults_beyond_the_room_are_counted(void **state) {
    struct qg_text members = {0};
    (void)state;
    for (int i = 0; i < 150; i++)
        qg_text_format(&members, "%s\"zz%d\":0", i ? "," : "", i);
    char *text = evaluate_with(members.data);
    assert_int_equal(read_text(text), QG_DOCUMENT_INVALID);
    assert_int_equal(faults.count, QG_FAULTS_ROOM);
    assert_int_equal(faults.lost, 150 - QG_FAULTS_ROOM);
    free(text);
    qg_text_finish(&members);
}

/* Every member of the full document, replaced by something impossible, gives a fault at exactly its pointer. */
struct spoiled {
    const cJSON *root;
    size_t count;
};

static void assert_refused_at(const cJSON *root, const char *pointer) {
    char *text = cJSON_PrintUnformatted(root);
    assert_non_null(text);
    assert_int_equal(read_text(text), QG_DOCUMENT_INVALID);
    if (!has_fault_at(&faults, pointer))
        fail_msg("no fault at %s but at %s: %s", pointer, faults.item[0].pointer, faults.item[0].detail);
    cJSON_free(text);
}

static void spoil_members(struct spoiled *spoiled, cJSON *object, const char *pointer) {
    static const double too_large = 1e300;
    for (cJSON *item = object->child; item; item = item->next) {
        char place[QG_POINTER_ROOM];
        if (cJSON_IsObject(object))
            snprintf(place, sizeof place, "%.120s/%s", pointer, item->string);
        else
            snprintf(place, sizeof place, "%.120s/%d", pointer, item == object->child ? 0 : 1);
        const int type = item->type;
        const double number = item->valuedouble;
        item->type = cJSON_True; /* no member is a boolean */
        assert_refused_at(spoiled->root, place);
        item->type = type;
        if (cJSON_IsNumber(item)) {
            item->valuedouble = too_large;
            assert_refused_at(spoiled->root, place);
            item->valuedouble = -too_large;
            assert_refused_at(spoiled->root, place);
            item->valuedouble = number;
        } else if (cJSON_IsObject(item) || cJSON_IsArray(item)) {
            spoil_members(spoiled, item, place);
        }
        spoiled->count++;
    }
}

static void every_member_is_refused_at_its_pointer(void **state) {
    (void)state;
    cJSON *root = cJSON_Parse(everything);
    struct spoiled spoiled = {.root = root};
    spoil_members(&spoiled, root, "");
    assert_in_range(spoiled.count, 100, 200);
    cJSON_Delete(root);
    root = cJSON_Parse(least_map);
    spoiled = (struct spoiled){.root = root};
    spoil_members(&spoiled, root, "");
    assert_in_range(spoiled.count, 30, 60);
    cJSON_Delete(root);
    size_t length;
    char *text = read_source_file("schema/examples/case_S_macro.json", &length);
    root = cJSON_ParseWithLength(text, length);
    cJSON_DeleteItemFromObjectCaseSensitive(root, "load_cases"); /* three: spoil_members counts to two */
    spoiled = (struct spoiled){.root = root};
    spoil_members(&spoiled, root, "");
    assert_in_range(spoiled.count, 60, 100);
    cJSON_Delete(root);
    free(text);
}

/* The gear pair is judged even when something else is wrong. */
static void an_impossible_pair_is_found_beside_other_faults(void **state) {
    (void)state;
    char *text = evaluate_with("\"colour\":1");
    char *distance = strstr(text, "111");
    memcpy(distance, "110", 3);
    assert_int_equal(read_text(text), QG_DOCUMENT_INVALID);
    assert_true(has_fault_at(&faults, "/colour"));
    assert_true(has_fault_at(&faults, "/gear_pair/center_distance_mm"));
    free(text);
}

static void what_does_nothing_is_a_warning(void **state) {
    struct qg_notes warnings = {0};
    char pointer[QG_POINTER_ROOM];
    (void)state;
    char *text = evaluate_with("\"relief\":{\"pinion\":{\"root\":{\"end_radius_mm\":40,\"amplitude_mm\":0.01}}}");
    assert_int_equal(qg_document_read(text, strlen(text), &job, &faults, &warnings), QG_DOCUMENT_OK);
    assert_int_equal(warnings.count, 1);
    qg_document_pointer(warnings.item[0].where, pointer);
    assert_string_equal(pointer, "/relief/pinion/root/end_radius_mm");
    free(text);
}

/* Random damage to the bytes: no crash, and an answer with words whenever it is refused. */
static void damaged_documents_get_an_answer(void **state) {
    static const char bytes[] = "{}[]\",:0123456789.eE+-\\ \xc3\xa9";
    uint64_t seed = 5;
    (void)state;
    for (int round = 0; round < 4000; round++) {
        char damaged[sizeof everything];
        memcpy(damaged, everything, sizeof everything);
        for (uint64_t n = next_random(&seed) % 2 + 1; n > 0; n--)
            damaged[next_random(&seed) % (sizeof everything - 1)] = bytes[next_random(&seed) % (sizeof bytes - 1)];
        const enum qg_document_status status = read_exact(damaged, sizeof everything - 1, &job, &faults);
        assert_int_equal(status == QG_DOCUMENT_OK, faults.count == 0);
        for (size_t i = 0; i < faults.count; i++)
            assert_true(faults.item[i].detail[0] != '\0');
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(analysis_has_its_defaults),
        cmocka_unit_test(an_evaluation_without_relief_is_pure_involute),
        cmocka_unit_test(an_optimization_has_its_defaults),
        cmocka_unit_test(reliability_has_its_defaults),
        cmocka_unit_test(a_map_has_its_defaults),
        cmocka_unit_test(a_macro_search_has_its_defaults),
        cmocka_unit_test(a_macro_search_is_read),
        cmocka_unit_test(a_written_pair_is_the_same_pair),
        cmocka_unit_test(few_positions_take_fewer_harmonics),
        cmocka_unit_test(units_become_those_of_core),
        cmocka_unit_test(every_member_is_stored),
        cmocka_unit_test(every_definition_of_the_mesh_stiffness_is_read),
        cmocka_unit_test(whole_numbers_may_be_written_in_any_way),
        cmocka_unit_test(documents_echo),
        cmocka_unit_test(the_echo_names_what_the_search_uses),
        cmocka_unit_test(the_full_document_is_its_own_echo),
        cmocka_unit_test(converted_numbers_come_back_exactly),
        cmocka_unit_test(all_faults_come_at_once),
        cmocka_unit_test(words_say_what_was_found_and_what_is_allowed),
        cmocka_unit_test(faults_beyond_the_room_are_counted),
        cmocka_unit_test(every_member_is_refused_at_its_pointer),
        cmocka_unit_test(an_impossible_pair_is_found_beside_other_faults),
        cmocka_unit_test(what_does_nothing_is_a_warning),
        cmocka_unit_test(damaged_documents_get_an_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
