/* Results: units, names, null where nothing was computed. When $QG_SAMPLES names a directory, one document of each sort is
 * left there, for schemas.bats to hold against the JSON Schemas. */
#include <cjson/cJSON.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/drawing.h"
#include "schema/result.h"
#include "tests/schema/support.h"

enum { POSITIONS = 4, SPEEDS = 3 };

/* A result made up by hand: what core would hand over, in core's units. */
struct made_up {
    struct qg_job job;
    struct qg_study_result result;
    struct qg_design_result design, reference;
    struct qg_response response[SPEEDS];
    struct qg_history_entry history[2];
    double positions[POSITIONS], share[POSITIONS * QG_PAIR_COUNT];
};

static struct made_up made_up;

static void make_case(struct qg_case_result *one) {
    *one = (struct qg_case_result){.torque = 470000,
                                   .normal_force = 11908.5,
                                   .static_transmission_error = made_up.positions,
                                   .unloaded_transmission_error = made_up.positions,
                                   .mesh_stiffness = made_up.positions,
                                   .load_share = made_up.share,
                                   .contact_pressure = made_up.positions,
                                   .mean_mesh_stiffness = 305572,
                                   .pps = 0.00975,
                                   .loaded_contact_ratio = 1.5,
                                   .max_contact_pressure = 1200,
                                   .complementarity_residual = 1e-12,
                                   .natural_frequency = 4865,
                                   .max_rms = 0.402,
                                   .max_rms_at = 0.8,
                                   .response = made_up.response};
}

static void make_design(struct qg_design_result *design, double f_dte) {
    *design = (struct qg_design_result){.pair = made_up.job.study.pair,
                                        .backlash = 0.3,
                                        .relief = made_up.job.study.relief,
                                        .f_pps = 0.008,
                                        .f_dte = f_dte,
                                        .f_dte_percentile = NAN,
                                        .positions = POSITIONS,
                                        .speeds = SPEEDS,
                                        .case_count = 2};
    make_case(&design->cases[0]);
    make_case(&design->cases[1]);
}

static int make_up(void **state) {
    static struct qg_faults faults;
    size_t length;
    (void)state;
    char *text = read_source_file("schema/examples/case_S_optimize.json", &length);
    assert_int_equal(qg_document_read(text, length, &made_up.job, &faults, NULL), QG_DOCUMENT_OK);
    free(text);
    made_up.job.study.analysis.speeds.count = SPEEDS;
    for (int i = 0; i < POSITIONS; i++) {
        made_up.positions[i] = 0.03 + i * 0.001;
        made_up.share[i * QG_PAIR_COUNT + QG_PAIR_REACH] = 0.75;
        made_up.share[i * QG_PAIR_COUNT + QG_PAIR_REACH + 1] = 0.25;
    }
    for (int i = 0; i < SPEEDS; i++)
        made_up.response[i] = (struct qg_response){.rms = 0.1 * (i + 1), .period = i};
    make_design(&made_up.design, 0.1);
    make_design(&made_up.reference, 0.25);
    struct qg_study_result *r = &made_up.result;
    assert_int_equal(qg_pair_derive(&made_up.job.study.pair, &r->geometry, NULL), QG_OK);
    made_up.history[0] = (struct qg_history_entry){.evaluation = 1, .best = 0.2};
    made_up.history[1] = (struct qg_history_entry){.evaluation = 7, .best = 0.1};
    r->design = &made_up.design;
    r->reference = &made_up.reference;
    r->evaluations = 260;
    r->history_count = 2;
    r->history = made_up.history;
    r->reliability.samples = 100;
    r->reliability.confidence_high = 0.0362;
    qg_notes_add(&r->warnings, "pinion.root.end_radius", "it removes nothing");
    qg_notes_add(&r->warnings, "", "about everything");
    return 0;
}

/* Leaves a document for the schema validator. */
static void leave_sample(const char *name, const char *text) {
    const char *directory = getenv("QG_SAMPLES");
    char path[4096];
    if (!directory)
        return;
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* The item at a pointer; fails when it is not there. */
static const cJSON *at(const cJSON *root, const char *pointer) {
    char copy[200], *rest = NULL;
    const cJSON *item = root;
    snprintf(copy, sizeof copy, "%s", pointer);
    for (char *step = strtok_r(copy, "/", &rest); step; step = strtok_r(NULL, "/", &rest)) {
        item =
            cJSON_IsArray(item) ? cJSON_GetArrayItem(item, atoi(step)) : cJSON_GetObjectItemCaseSensitive(item, step);
        if (!item)
            fail_msg("nothing at %s", pointer);
    }
    return item;
}

static void assert_number_at(const cJSON *root, const char *pointer, double expected) {
    const cJSON *item = at(root, pointer);
    if (!cJSON_IsNumber(item) || fabs(item->valuedouble - expected) > 1e-12 * fabs(expected))
        fail_msg("%s is %.17g, not %.17g", pointer, item->valuedouble, expected);
}

static cJSON *write_result(const char *sample) {
    struct qg_text text = {0};
    qg_result_write(&text, &made_up.job, &made_up.result, 2);
    assert_false(text.failed);
    cJSON *root = cJSON_Parse(text.data);
    assert_non_null(root);
    leave_sample(sample, text.data);
    qg_text_finish(&text);
    return root;
}

/* Two objectives, one of them a percentile: a front of two, in the document's units. */
static void a_front_is_written_with_its_reliefs(void **state) {
    static struct qg_front_member member[2] = {
        {.evaluation = 0, .f_pps = 0.008, .f_dte = 0.25, .f_dte_percentile = 0.5},
        {.evaluation = 7, .f_pps = 0.004, .f_dte = 0.3, .f_dte_percentile = 0.75}};
    (void)state;
    member[0].relief = member[1].relief = made_up.job.study.relief;
    member[1].relief.gears[QG_PINION].tip.amplitude = 0.02;
    const struct qg_objectives one = made_up.job.study.objectives;
    made_up.job.study.objectives = (struct qg_objectives){2, {QG_OBJECTIVE_F_DTE_PERCENTILE, QG_OBJECTIVE_F_PPS}};
    made_up.job.study.optimizer.method = QG_SEARCH_MULTISTART_SIMPLEX;
    made_up.result.front = (struct qg_front){.objectives = 2, .count = 2, .member = member};
    made_up.result.hypervolume = 0.25;
    made_up.design.f_dte_percentile = 0.75;
    made_up.reference.f_dte_percentile = 0.5;
    cJSON *root = write_result("result_front.json");
    assert_true(cJSON_IsNull(at(root, "/search/simplex_iterations")));
    assert_string_equal(at(root, "/search/method")->valuestring, "multistart_simplex");
    assert_number_at(root, "/search/hypervolume", 0.25);
    assert_int_equal(cJSON_GetArraySize(at(root, "/search/pareto")), 2);
    assert_number_at(root, "/search/pareto/1/evaluation", 7);
    assert_number_at(root, "/search/pareto/1/f_pps_um", 4);
    assert_number_at(root, "/search/pareto/1/f_dte", 0.3);
    assert_number_at(root, "/search/pareto/1/f_dte_percentile", 0.75);
    assert_number_at(root, "/search/pareto/1/relief/pinion/tip/amplitude_mm", 0.02);
    assert_number_at(root, "/design/f_dte_percentile", 0.75);
    assert_number_at(root, "/improvement/f_dte_percentile_percent", -50);
    cJSON_Delete(root);
    made_up.job.study.objectives = one;
    made_up.job.study.optimizer.method = QG_SEARCH_RANDOM_SIMPLEX;
    made_up.result.front = (struct qg_front){0};
    made_up.design.f_dte_percentile = made_up.reference.f_dte_percentile = NAN;
}

/* What a verification leaves of the improvement. */
static void a_verification_is_written(void **state) {
    (void)state;
    made_up.result.verification = (struct qg_verification){56, {0.008, 0.006}, {0.25, 0.15}};
    cJSON *root = write_result("result_verification.json");
    assert_number_at(root, "/verification/mesh_positions", 56);
    assert_number_at(root, "/verification/reference/f_pps_um", 8);
    assert_number_at(root, "/verification/design/f_dte", 0.15);
    assert_number_at(root, "/verification/improvement/f_pps_percent", 25);
    assert_number_at(root, "/verification/improvement/f_dte_percent", 40);
    cJSON_Delete(root);
    made_up.result.verification = (struct qg_verification){0};
    root = write_result("result_unverified.json");
    assert_true(cJSON_IsNull(at(root, "/verification")));
    cJSON_Delete(root);
}

/* A branch of two points for the first load case; nothing for the second. */
static void branches_are_written_when_there_are_some(void **state) {
    static struct qg_branch_point point[2] = {{.frequency_ratio = 0.9, .rms = 0.5, .mean = 1.1, .stable = true},
                                              {.frequency_ratio = 0.8, .rms = 0.25, .mean = 1.2}};
    static struct qg_special_point special = {QG_SPECIAL_GRAZING_BACK, 0.85, 0.375};
    static struct qg_branches branches;
    (void)state;
    point[0].multiplier_imaginary[0] = 0.5;
    point[0].multiplier_imaginary[1] = -0.5;
    branches.count = 1;
    branches.curve[0] = (struct qg_curve){.period = 2,
                                          .end = {QG_END_RANGE, QG_END_PERIOD_DOUBLING},
                                          .count = 2,
                                          .point = point,
                                          .special_count = 1,
                                          .special = &special};
    made_up.design.cases[0].branches = &branches;
    cJSON *root = write_result("result_branches.json");
    made_up.design.cases[0].branches = NULL;
    assert_number_at(root, "/design/load_cases/0/branches/0/period", 2);
    assert_string_equal(at(root, "/design/load_cases/0/branches/0/ends/1")->valuestring, "period_doubling");
    assert_number_at(root, "/design/load_cases/0/branches/0/frequency_ratio/1", 0.8);
    assert_number_at(root, "/design/load_cases/0/branches/0/rms/0", 0.5);
    assert_number_at(root, "/design/load_cases/0/branches/0/mean/1", 1.2);
    assert_true(cJSON_IsTrue(at(root, "/design/load_cases/0/branches/0/stable/0")));
    assert_true(cJSON_IsFalse(at(root, "/design/load_cases/0/branches/0/stable/1")));
    assert_number_at(root, "/design/load_cases/0/branches/0/multipliers/0/1/1", -0.5);
    assert_string_equal(at(root, "/design/load_cases/0/branches/0/special_points/0/type")->valuestring,
                        "grazing_back_flank");
    assert_number_at(root, "/design/load_cases/0/branches/0/special_points/0/frequency_ratio", 0.85);
    assert_null(cJSON_GetObjectItemCaseSensitive(at(root, "/design/load_cases/1"), "branches"));
    cJSON_Delete(root);
}

/* Stresses of four positions for the first load case; nothing for the second. */
static struct qg_stresses *made_up_stresses(void) {
    struct qg_stresses *s = qg_stresses_create(POSITIONS, QG_PAIR_COUNT);
    assert_non_null(s);
    for (size_t i = 0; i < POSITIONS; i++) {
        for (int g = 0; g < 2; g++) {
            s->tension[g][i] = (struct qg_root_stress){100 * (g + 1) + (double)i, {40.5, 0.1}, 0, 1};
            s->compression[g][i] = (struct qg_root_stress){-200 - (double)i, {40.25, -0.1}, -1, 0};
        }
        /* pair 0 all the time, pair 1 at the first two positions */
        for (size_t p = QG_PAIR_REACH; p < QG_PAIR_REACH + (i < 2 ? 2 : 1); p++)
            s->pressure[i * QG_PAIR_COUNT + p] =
                (struct qg_pair_pressure){1000 + 10 * (double)i, 9 * ((double)p - QG_PAIR_REACH) + (double)i, {42, 68}};
    }
    qg_stresses_summarize(s);
    return s;
}

static void stresses_are_written_with_their_places(void **state) {
    (void)state;
    struct qg_study_result *r = &made_up.result;
    const struct qg_gear_pair *pair = &made_up.job.study.pair;
    made_up.design.cases[0].stresses = made_up_stresses();
    r->is_rated = qg_iso6336_rate(pair, &r->geometry, pair->nominal_torque, &r->iso6336) == QG_OK;
    assert_true(r->is_rated);
    cJSON *root = write_result("result_stresses.json");
    const cJSON *one = at(root, "/design/load_cases/0");
    assert_number_at(one, "/max_root_stress_mpa/gear", 203);
    assert_number_at(one, "/max_root_stress_at/gear/mesh_position", 0.75);
    assert_number_at(one, "/max_root_stress_at/pinion/radius_mm", 40.5);
    assert_number_at(one, "/max_root_stress_at/pinion/angle_deg", 0.1 * 180 / M_PI);
    assert_number_at(one, "/min_root_stress_mpa/pinion", -203);
    assert_number_at(one, "/min_root_stress_at/pinion/pair", -1);
    assert_number_at(one, "/root_stress_mpa/gear/tension/1", 201);
    assert_number_at(one, "/root_stress_mpa/pinion/compression/2", -202);
    assert_int_equal(cJSON_GetArraySize(at(one, "/contact_pressure_path/path_mm")), 6);
    assert_number_at(one, "/contact_pressure_path/path_mm/4", 9); /* ascending: pair 0 first, then pair 1 */
    assert_number_at(one, "/contact_pressure_path/pressure_mpa/5", 1010);
    assert_number_at(one, "/max_contact_pressure_at/mesh_position", 0.75);
    assert_number_at(one, "/max_contact_pressure_at/pair", 0);
    assert_true(cJSON_IsNull(at(root, "/design/load_cases/1/max_root_stress_mpa")));
    assert_true(cJSON_IsNull(at(root, "/design/load_cases/1/contact_pressure_path")));
    assert_number_at(root, "/iso6336/torque_nm", 470);
    assert_number_at(root, "/iso6336/root_stress_mpa/gear", r->iso6336.root_stress[QG_GEAR]);
    assert_number_at(root, "/iso6336/mesh_stiffness_n_per_mm", r->iso6336.stiffness.mesh * 1000 * 22.5);
    assert_int_equal(cJSON_GetArraySize(at(root, "/iso6336/outside_of_range")), 1);
    assert_string_equal(at(root, "/iso6336/outside_of_range/0/range")->valuestring, "profile_shifts");
    assert_number_at(root, "/iso6336/factors/pinion/y_s", r->iso6336.root[QG_PINION].stress_correction_factor);
    cJSON_Delete(root);
    qg_stresses_destroy(made_up.design.cases[0].stresses);
    made_up.design.cases[0].stresses = NULL;
    r->is_rated = false;
    root = write_result("result_unrated.json");
    assert_true(cJSON_IsNull(at(root, "/iso6336")));
    cJSON_Delete(root);
}

static void a_result_has_the_units_of_its_names(void **state) {
    (void)state;
    cJSON *root = write_result("result_optimize.json");
    assert_number_at(root, "/job/gear_pair/pinion/teeth", 28);
    assert_number_at(root, "/geometry/backlash_mm", made_up.result.geometry.backlash);
    assert_number_at(root, "/geometry/working_pressure_angle_deg", 25.6312171603689);
    assert_number_at(root, "/geometry/gear/form_radius_mm", made_up.result.geometry.gears[1].form_radius);
    assert_number_at(root, "/design/f_pps_um", 8);
    assert_number_at(root, "/design/f_dte", 0.1);
    assert_number_at(root, "/design/load_cases/1/torque_nm", 470);
    assert_number_at(root, "/design/load_cases/0/static_transmission_error_um/2", 32);
    assert_number_at(root, "/design/load_cases/0/pps_um", 9.75);
    assert_number_at(root, "/design/load_cases/0/load_share/pair/0", -3);
    assert_number_at(root, "/design/load_cases/0/load_share/share/3/3", 0.75);
    assert_number_at(root, "/design/load_cases/0/max_rms_at_pinion_rpm", 0.8 * 4865 * 60 / 28);
    assert_number_at(root, "/design/load_cases/0/frequency_response/frequency_ratio/1", 0.8);
    assert_number_at(root, "/design/load_cases/0/frequency_response/rms/2", 0.3);
    assert_number_at(root, "/design/load_cases/0/frequency_response/period/0", 0);
    assert_number_at(root, "/improvement/f_dte_percent", 60);
    assert_number_at(root, "/improvement/f_pps_percent", 0);
    assert_number_at(root, "/search/history/1/best", 0.1);
    assert_number_at(root, "/reliability/confidence_95/1", 0.0362);
    assert_number_at(root, "/timing/threads", 2);
    assert_string_equal(at(root, "/warnings/0")->valuestring, "/relief/pinion/root/end_radius_mm: it removes nothing");
    assert_string_equal(at(root, "/warnings/1")->valuestring, "about everything");
    cJSON_Delete(root);
}

/* Search for F_PPS: no dynamics. The objective is in micrometres, what was not computed is null. */
static void what_was_not_computed_is_null(void **state) {
    (void)state;
    make_up(NULL);
    made_up.job.study.objective = QG_OBJECTIVE_F_PPS;
    made_up.design.f_dte = NAN;
    made_up.design.cases[0].max_rms = made_up.design.cases[1].max_rms = NAN;
    made_up.history[1].best = 0.008;
    made_up.result.reliability.samples = 0;
    cJSON *root = write_result("result_statics.json");
    assert_true(cJSON_IsNull(at(root, "/design/f_dte")));
    assert_true(cJSON_IsNull(at(root, "/design/load_cases/0/max_rms")));
    assert_true(cJSON_IsNull(at(root, "/design/load_cases/0/max_rms_at")));
    assert_true(cJSON_IsNull(at(root, "/design/load_cases/1/frequency_response")));
    assert_true(cJSON_IsNull(at(root, "/improvement/f_dte_percent")));
    assert_true(cJSON_IsNull(at(root, "/reliability")));
    assert_number_at(root, "/search/history/1/best", 8);
    cJSON_Delete(root);
    make_up(NULL);
}

static void an_evaluation_has_no_search(void **state) {
    static struct qg_faults faults;
    (void)state;
    assert_int_equal(read_exact(least_evaluate, strlen(least_evaluate), &made_up.job, &faults), QG_DOCUMENT_OK);
    made_up.job.study.analysis.speeds.count = SPEEDS;
    made_up.result.reference = NULL;
    made_up.result.reliability.samples = 0;
    cJSON *root = write_result("result_evaluate.json");
    assert_true(cJSON_IsNull(at(root, "/reference")));
    assert_true(cJSON_IsNull(at(root, "/improvement")));
    assert_true(cJSON_IsNull(at(root, "/search")));
    assert_true(cJSON_IsNull(at(root, "/map")));
    cJSON_Delete(root);
    make_up(NULL);
}

/* A map job of the given text, with the values in its cells. */
static cJSON *write_map(const char *document, double *f_pps, double *f_dte, const char *sample) {
    static struct qg_faults faults;
    assert_int_equal(read_exact(document, strlen(document), &made_up.job, &faults), QG_DOCUMENT_OK);
    made_up.job.study.analysis.speeds.count = SPEEDS;
    made_up.result.reliability.samples = 0;
    made_up.result.map = (struct qg_map){qg_grid_cells(&made_up.job.study.grid), {f_dte, f_pps}};
    cJSON *root = write_result(sample);
    made_up.result.map = (struct qg_map){0};
    make_up(NULL);
    return root;
}

static void a_map_has_rows_and_its_minima(void **state) {
    double f_pps[90], f_dte[90];
    (void)state;
    for (int i = 0; i < 90; i++) { /* 15 rows of 6 */
        f_pps[i] = 0.005 + 0.001 * i;
        f_dte[i] = 0.5 + 0.001 * i;
    }
    f_pps[7 * 6 + 2] = 0.004;
    f_dte[14 * 6 + 5] = 0.25;
    cJSON *root = write_map(least_map, f_pps, f_dte, "result_map.json");
    assert_string_equal(at(root, "/map/axes/0/parameter")->valuestring, "gear.root.amplitude_mm");
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/axes/0/values")), 15);
    assert_number_at(root, "/map/axes/0/values/7", 0.01);
    assert_number_at(root, "/map/axes/1/values/1", 64.5);
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/f_pps_um")), 15);
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/f_pps_um/3")), 6);
    assert_number_at(root, "/map/f_pps_um/3/1", 5 + 19);
    assert_number_at(root, "/map/f_dte/14/4", 0.588);
    assert_number_at(root, "/map/minima/f_pps/cell/0", 7);
    assert_number_at(root, "/map/minima/f_pps/values/1", 65);
    assert_number_at(root, "/map/minima/f_pps/f_pps_um", 4);
    assert_number_at(root, "/map/minima/f_pps/f_dte", 0.544);
    assert_number_at(root, "/map/minima/f_dte/cell/1", 5);
    assert_number_at(root, "/map/minima/f_dte/f_dte", 0.25);
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/local_minima/f_pps")), 2); /* and the first corner */
    assert_number_at(root, "/map/local_minima/f_pps/0/f_pps_um", 5);
    assert_number_at(root, "/map/local_minima/f_dte/1/cell/0", 14);
    assert_number_at(root, "/improvement/f_dte_percent", 60);
    assert_true(cJSON_IsNull(at(root, "/search")));
    cJSON_Delete(root);
}

static void a_map_over_one_axis_is_flat(void **state) {
    double f_pps[6] = {0.009, 0.008, 0.007, 0.008, 0.009, NAN}, f_dte[6] = {0.4, 0.4, 0.4, 0.4, 0.4, 0.4};
    char document[4096];
    (void)state;
    const char *rest = strstr(least_map, "{\"parameter\":\"gear.root.end");
    snprintf(document, sizeof document,
             "%.*s,\"relief\":{\"gear\":{\"root\":{\"end_radius_mm\":65,\"amplitude_mm\":0.01}}},"
             "\"grid\":[%s",
             (int)(strstr(least_map, ",\"grid\"") - least_map), least_map, rest);
    cJSON *root = write_map(document, f_pps, f_dte, "result_map_line.json");
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/axes")), 1);
    assert_number_at(root, "/map/f_pps_um/1", 8);
    assert_true(cJSON_IsNull(at(root, "/map/f_pps_um/5")));
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/minima/f_pps/cell")), 1);
    assert_number_at(root, "/map/minima/f_pps/values/0", 65);
    assert_number_at(root, "/map/minima/f_dte/values/0", 64); /* the first of equals */
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/local_minima/f_dte")), 0);
    assert_int_equal(cJSON_GetArraySize(at(root, "/map/local_minima/f_pps")), 1);
    cJSON_Delete(root);
}

/* Two candidates, of which the second could not be judged; the job's units, and a pair that can be posted. */
static void a_macro_result_has_its_candidates(void **state) {
    static struct qg_faults faults;
    (void)state;
    assert_int_equal(read_exact(least_macro, strlen(least_macro), &made_up.job, &faults), QG_DOCUMENT_OK);
    made_up.job.study.analysis.speeds.count = SPEEDS;
    made_up.result.reliability.samples = 0;
    struct qg_macro_candidate candidate[2] = {{.point = {123456789012, 2.25, 0.9, 0.8},
                                               .on_front = true,
                                               .pair = made_up.job.study.pair,
                                               .pressure_angle_deg = 18.5,
                                               .geometry = {.backlash = 0.3},
                                               .is_possible = true,
                                               .evaluation = 1,
                                               .judged = true,
                                               .f_pps = 0.005,
                                               .f_dte = 0.2,
                                               .max_contact_pressure = 1100,
                                               .max_root_stress = 480,
                                               .loaded_contact_ratio = 2.5,
                                               .mean_mesh_stiffness = 300000},
                                              {.pressure_angle_deg = 20, .f_pps = NAN, .f_dte = NAN}};
    candidate[0].pair.gears[QG_PINION].teeth = 41;
    candidate[1].pair = candidate[0].pair;
    made_up.design.pair = candidate[0].pair;
    made_up.result.macro = (struct qg_macro_result){.samples = 1000000000,
                                                    .passed = 2,
                                                    .rejected = {[QG_MACRO_RATIO] = 999999997, [QG_MACRO_HOB] = 1},
                                                    .initial = {1291, 558},
                                                    .front_count = 1,
                                                    .count = 2,
                                                    .candidate = candidate};
    cJSON *root = write_result("result_macro.json");
    assert_number_at(root, "/macro/samples", 1e9);
    assert_string_equal(at(root, "/macro/rejected/4/constraint")->valuestring, "hob");
    assert_number_at(root, "/macro/rejected/0/count", 999999997);
    assert_number_at(root, "/macro/rejected/4/count", 1);
    assert_number_at(root, "/macro/initial/iso_root_stress_mpa", 558);
    assert_number_at(root, "/macro/best", 0);
    assert_number_at(root, "/macro/candidates/0/sample", 123456789012);
    assert_number_at(root, "/macro/candidates/0/f_pps_um", 5);
    assert_number_at(root, "/macro/candidates/0/root_stress_factor", 0.8);
    assert_number_at(root, "/macro/candidates/0/max_root_stress_mpa", 480);
    assert_number_at(root, "/macro/candidates/0/gear_pair/pressure_angle_deg", 18.5);
    assert_number_at(root, "/macro/candidates/0/gear_pair/pinion/teeth", 41);
    assert_number_at(root, "/macro/candidates/0/gear_pair/nominal_torque_nm", 470);
    assert_number_at(root, "/macro/candidates/0/geometry/backlash_mm", 0.3);
    assert_true(cJSON_IsNull(at(root, "/macro/candidates/1/f_dte")));
    assert_true(cJSON_IsNull(at(root, "/macro/candidates/1/geometry")));
    assert_number_at(root, "/design/load_cases/0/max_rms_at_pinion_rpm", 0.8 * 4865 * 60 / 41);
    cJSON_Delete(root);
    made_up.result.macro = (struct qg_macro_result){0};
    make_up(NULL);
}

static void a_macro_result_without_candidates_says_so(void **state) {
    static struct qg_faults faults;
    (void)state;
    assert_int_equal(read_exact(least_macro, strlen(least_macro), &made_up.job, &faults), QG_DOCUMENT_OK);
    made_up.job.study.analysis.speeds.count = SPEEDS;
    made_up.result.reliability.samples = 0;
    made_up.result.design = NULL;
    made_up.result.macro = (struct qg_macro_result){.samples = 1000, .rejected = {[QG_MACRO_RATIO] = 1000}};
    cJSON *root = write_result("result_macro_none.json");
    assert_true(cJSON_IsNull(at(root, "/design")) && cJSON_IsNull(at(root, "/macro/best")));
    assert_true(cJSON_IsNull(at(root, "/improvement")));
    cJSON_Delete(root);
    made_up.result.macro = (struct qg_macro_result){0};
    make_up(NULL);
}

/* A candidate's only parameter is the number of its sample. */
static void an_evaluation_of_a_candidate_has_its_sample(void **state) {
    struct qg_text text = {0};
    const struct qg_evaluation evaluation = {.number = 3,
                                             .phase = QG_PHASE_CANDIDATES,
                                             .parameter = {123456789012},
                                             .f_pps = 0.006,
                                             .f_dte = 0.25,
                                             .f_dte_percentile = NAN};
    (void)state;
    qg_evaluation_write(&text, &evaluation);
    leave_sample("evaluation_candidate.json", text.data);
    assert_string_equal(text.data, "{\"evaluation\":3,\"phase\":\"candidates\",\"sample\":123456789012,"
                                   "\"parameters\":{},\"f_pps_um\":6,\"f_dte\":0.25,\"f_dte_percentile\":null}\n");
    qg_text_finish(&text);
    qg_evaluation_write_csv(&text, &evaluation);
    assert_string_equal(text.data, "3,candidates,,,,,,,,,6,0.25,\n");
    qg_text_finish(&text);
}

static void frequency_response_is_written(void **state) {
    struct qg_text text = {0};
    (void)state;
    qg_frequency_response_write(&text, &made_up.job, &made_up.result.geometry, &made_up.design, NULL);
    leave_sample("frequency-response.json", text.data);
    cJSON *root = cJSON_Parse(text.data);
    assert_number_at(root, "/half_backlash_um", 500 * made_up.result.geometry.backlash);
    assert_number_at(root, "/design/half_backlash_um", 150);
    assert_number_at(root, "/frequency_ratio/2", 1.4);
    assert_number_at(root, "/design/load_cases/0/pinion_rpm/0", 0.2 * 4865 * 60 / 28);
    assert_number_at(root, "/design/load_cases/1/rms/1", 0.2);
    assert_true(cJSON_IsNull(at(root, "/reference")));
    cJSON_Delete(root);
    qg_text_finish(&text);
}

static void frequency_response_is_written_as_csv(void **state) {
    struct qg_text text = {0};
    size_t lines = 0;
    (void)state;
    qg_frequency_response_write_csv(&text, &made_up.job, &made_up.design, &made_up.reference);
    for (const char *byte = text.data; *byte; byte++)
        lines += *byte == '\n';
    assert_int_equal(lines, 1 + 2 * 2 * SPEEDS);
    static const char start[] = "design,torque_nm,frequency_ratio,pinion_rpm,rms,period\ndesign,470,0.2,2085,0.1,0\n";
    assert_memory_equal(text.data, start, sizeof start - 1);
    assert_non_null(strstr(text.data, "\nreference,470,0.2,2085,0.1,0\n"));
    qg_text_finish(&text);
}

static void evaluations_are_written(void **state) {
    struct qg_text text = {0};
    const struct qg_evaluation evaluation = {.number = 12,
                                             .phase = QG_PHASE_RANDOM,
                                             .parameter = {44.5, 0.016, 0, 0, 67.5, 0},
                                             .f_pps = 0.006,
                                             .f_dte = NAN,
                                             .f_dte_percentile = NAN};
    (void)state;
    qg_evaluation_write(&text, &evaluation);
    leave_sample("evaluation.json", text.data);
    qg_evaluation_write(&text, &evaluation);
    static const char line[] =
        "{\"evaluation\":12,\"phase\":\"random\",\"parameters\":{\"pinion.tip.start_radius_mm\":44.5,"
        "\"pinion.tip.amplitude_mm\":0.016,\"gear.tip.start_radius_mm\":67.5,\"gear.tip.amplitude_mm\":0},"
        "\"f_pps_um\":6,\"f_dte\":null,\"f_dte_percentile\":null}\n";
    assert_memory_equal(text.data, line, sizeof line - 1);
    assert_string_equal(text.data + sizeof line - 1, line);
    qg_text_finish(&text);
    qg_evaluation_write_csv_header(&text);
    qg_evaluation_write_csv(&text, &evaluation);
    assert_string_equal(text.data,
                        "evaluation,phase,pinion.tip.start_radius_mm,pinion.tip.amplitude_mm,"
                        "pinion.root.end_radius_mm,pinion.root.amplitude_mm,gear.tip.start_radius_mm,"
                        "gear.tip.amplitude_mm,gear.root.end_radius_mm,gear.root.amplitude_mm,f_pps_um,f_dte,"
                        "f_dte_percentile\n"
                        "12,random,44.5,0.016,,,67.5,0,,,6,,\n");
    qg_text_finish(&text);
}

static void a_relief_reads_as_in_the_document(void **state) {
    struct qg_text text = {0};
    (void)state;
    qg_relief_write(&text, &made_up.job.study.relief);
    assert_string_equal(text.data,
                        "{\"shape\":\"linear\",\"ramp\":\"radius\",\"pinion\":{\"tip\":{\"start_radius_mm\":44.54,"
                        "\"amplitude_mm\":0.016}},\"gear\":{\"tip\":{\"start_radius_mm\":67.64,\"amplitude_mm\":"
                        "0.018}}}");
    qg_text_finish(&text);
}

/* The small part of a result reads as the whole of it does; without a design it is no design. */
static void the_design_alone_reads_like_the_result(void **state) {
    struct qg_text whole = {0}, part = {0}, none = {0};
    struct qg_job *job = malloc(sizeof *job);
    (void)state;
    assert_non_null(job);
    struct qg_study_result result = made_up.result;
    qg_result_write(&whole, &made_up.job, &result, 2);
    qg_result_design_write(&part, &made_up.job, &result);
    assert_true(part.length < whole.length / 2);
    for (int i = 0; i < 2; i++) {
        const struct qg_text *text = i ? &part : &whole;
        memset(job, 0, sizeof *job);
        assert_int_equal(qg_result_design_read(text->data, text->length, job), QG_DOCUMENT_OK);
        assert_true(job->study.relief.gears[QG_PINION].tip.amplitude ==
                    result.design->relief.gears[QG_PINION].tip.amplitude);
        assert_true(job->study.pair.nominal_torque == made_up.job.study.pair.nominal_torque);
    }
    result.design = NULL;
    qg_result_design_write(&none, &made_up.job, &result);
    assert_int_equal(qg_result_design_read(none.data, none.length, job), QG_DOCUMENT_INVALID);
    qg_text_finish(&whole);
    qg_text_finish(&part);
    qg_text_finish(&none);
    free(job);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(branches_are_written_when_there_are_some),
        cmocka_unit_test(stresses_are_written_with_their_places),
        cmocka_unit_test(a_result_has_the_units_of_its_names),
        cmocka_unit_test(what_was_not_computed_is_null),
        cmocka_unit_test(a_front_is_written_with_its_reliefs),
        cmocka_unit_test(a_verification_is_written),
        cmocka_unit_test(an_evaluation_has_no_search),
        cmocka_unit_test(a_map_has_rows_and_its_minima),
        cmocka_unit_test(a_map_over_one_axis_is_flat),
        cmocka_unit_test(a_macro_result_has_its_candidates),
        cmocka_unit_test(a_macro_result_without_candidates_says_so),
        cmocka_unit_test(an_evaluation_of_a_candidate_has_its_sample),
        cmocka_unit_test(frequency_response_is_written),
        cmocka_unit_test(frequency_response_is_written_as_csv),
        cmocka_unit_test(evaluations_are_written),
        cmocka_unit_test(a_relief_reads_as_in_the_document),
        cmocka_unit_test(the_design_alone_reads_like_the_result),
    };
    return cmocka_run_group_tests(tests, make_up, NULL);
}
