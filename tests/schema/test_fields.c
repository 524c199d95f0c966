/* The table of fields: core's names lead to the right pointers, and job.schema.json says the same as the table. */
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

static void core_names_lead_to_pointers(void **state) {
    static const char *const pairs[][2] = {
        {"", ""},
        {"module", "/gear_pair/module_mm"},
        {"pressure_angle", "/gear_pair/pressure_angle_deg"},
        {"center_distance", "/gear_pair/center_distance_mm"},
        {"damping_ratio", "/gear_pair/damping_ratio"},
        {"nominal_torque", "/gear_pair/nominal_torque_nm"},
        {"material.youngs_modulus", "/gear_pair/material/youngs_modulus_mpa"},
        {"material.poisson_ratio", "/gear_pair/material/poisson_ratio"},
        {"material.density", "/gear_pair/material/density_kg_per_m3"},
        {"pinion.teeth", "/gear_pair/pinion/teeth"},
        {"pinion.hob_tip_radius", "/gear_pair/pinion/hob_tip_radius_mm"},
        {"gear.profile_shift", "/gear_pair/gear/profile_shift_mm"},
        {"gear.outside_radius", "/gear_pair/gear/outside_radius_mm"},
        {"gear.root_radius", "/gear_pair/gear/root_radius_mm"},
        {"gear.bore_diameter", "/gear_pair/gear/bore_diameter_mm"},
        {"gear.face_width", "/gear_pair/gear/face_width_mm"},
        {"gear.moment_of_inertia", "/gear_pair/gear/moment_of_inertia_kg_mm2"},
        {"pinion", "/gear_pair/pinion"},
        {"pinion.tip.start_radius", "/relief/pinion/tip/start_radius_mm"},
        {"pinion.tip.amplitude", "/relief/pinion/tip/amplitude_mm"},
        {"gear.root.end_radius", "/relief/gear/root/end_radius_mm"},
        {"gear.root.amplitude", "/relief/gear/root/amplitude_mm"},
        {"relief", "/relief"},
        {"bounds", "/relief_bounds"},
        {"bounds.pinion.tip.start_radius", "/relief_bounds/pinion/tip/start_radius_mm"},
        {"bounds.gear.root.amplitude", "/relief_bounds/gear/root/amplitude_mm"},
        {"analysis", "/analysis"},
        {"analysis.harmonics", "/analysis/harmonics"},
        {"analysis.mesh_positions", "/analysis/mesh_positions"},
        {"analysis.mesh_stiffness", "/analysis/mesh_stiffness"},
        {"analysis.speeds", "/analysis/speeds"},
        {"analysis.speeds.min", "/analysis/speeds/min"},
        {"analysis.speeds.max", "/analysis/speeds/max"},
        {"analysis.speeds.count", "/analysis/speeds/count"},
        {"analysis.speeds.branch", "/analysis/branch"},
        {"analysis.speeds.start_displacement", "/analysis/initial_condition/displacement"},
        {"analysis.speeds.start_velocity", "/analysis/initial_condition/velocity"},
        {"analysis.torque_fraction", "/load_cases"},
        {"analysis.torque_fraction[12]", "/load_cases/12"},
        {"objective", "/objective"},
        {"objectives", "/objectives"},
        {"optimizer.method", "/optimizer/method"},
        {"grid", "/grid"},
        {"grid.1", "/grid/1"},
        {"grid.0.from", "/grid/0/from"},
        {"grid.1.parameter", "/grid/1/parameter"},
        {"grid.0.something", "/grid/0"},
        {"grid.0x", "/grid"},
        {"macro", "/macro"},
        {"macro.ranges", "/macro/ranges"},
        {"macro.ranges.module", "/macro/ranges/module_mm"},
        {"macro.ranges.pressure_angle", "/macro/ranges/pressure_angle_deg"},
        {"macro.ranges.pinion.teeth", "/macro/ranges/pinion/teeth"},
        {"macro.ranges.gear.root_radius", "/macro/ranges/gear/root_radius_mm"},
        {"macro.constraints.backlash", "/macro/constraints/backlash_mm"},
        {"optimizer.random_samples", "/optimizer/random_samples"},
        {"reliability.radius_range", "/reliability/radius_range_mm"},
        {"reliability.limit_f_dte", "/reliability/limit_f_dte"},
        {"pinion.something_new", "/gear_pair/pinion"},
        {"analysis.speeds.something", "/analysis/speeds"},
        {"modules", ""},
        {"[3]", ""},
        {"nonsense", ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(pairs[i][0], pointer);
        assert_string_equal(pointer, pairs[i][1]);
    }
}

static void parameters_have_names(void **state) {
    (void)state;
    assert_string_equal(qg_parameter_name(QG_PINION_TIP_START_RADIUS), "pinion.tip.start_radius_mm");
    assert_string_equal(qg_parameter_name(QG_GEAR_ROOT_AMPLITUDE), "gear.root.amplitude_mm");
    assert_string_equal(qg_kind_name(QG_STUDY_RELIABILITY), "reliability");
    assert_string_equal(qg_kind_name(QG_STUDY_MAP), "map");
    assert_string_equal(qg_kind_name(QG_STUDY_MACRO), "macro");
    assert_string_equal(qg_objective_name(QG_OBJECTIVE_F_DTE_PERCENTILE), "f_dte_percentile");
    assert_string_equal(qg_method_name(QG_SEARCH_RANDOM_SIMPLEX), "random_simplex");
    assert_string_equal(qg_method_name(QG_SEARCH_MULTISTART_SIMPLEX), "multistart_simplex");
}

static void a_job_has_one_objective_or_none(void **state) {
    (void)state;
    struct qg_job job = {.study = {.kind = QG_STUDY_MAP, .objective = QG_OBJECTIVE_F_PPS}};
    assert_string_equal(qg_job_objective(&job), "f_pps");
    job.study.kind = QG_STUDY_EVALUATE;
    assert_null(qg_job_objective(&job));
    job.study.kind = QG_STUDY_RELIABILITY;
    assert_null(qg_job_objective(&job));
    job.study.kind = QG_STUDY_OPTIMIZE;
    assert_string_equal(qg_job_objective(&job), "f_pps");
    job.study.objectives.count = 2;
    assert_null(qg_job_objective(&job));
}

/* Follows "#/$defs/name". */
static const cJSON *resolve(const cJSON *root, const cJSON *schema) {
    static const char prefix[] = "#/$defs/";
    const cJSON *reference = cJSON_GetObjectItemCaseSensitive(schema, "$ref");
    if (!reference)
        return schema;
    assert_int_equal(strncmp(reference->valuestring, prefix, sizeof prefix - 1), 0);
    const cJSON *found = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(root, "$defs"),
                                                          reference->valuestring + sizeof prefix - 1);
    assert_non_null(found);
    return found;
}

static void assert_keyword(const cJSON *schema, const char *keyword, double expected, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(schema, keyword);
    if (!item || item->valuedouble != expected)
        fail_msg("%s: %s is not %g", key, keyword, expected);
}

static const char *type_name(const struct qg_field *field) {
    switch (field->type) {
    case QG_FIELD_NUMBER:
        return "number";
    case QG_FIELD_INT:
    case QG_FIELD_SIZE:
    case QG_FIELD_SEED:
        return "integer";
    case QG_FIELD_TEXT:
        return "string";
    case QG_FIELD_RANGE:
    case QG_FIELD_INTERVAL:
    case QG_FIELD_INTERVAL_OF_WHOLES:
    case QG_FIELD_LABELS:
    case QG_FIELD_LOAD_CASES:
    case QG_FIELD_GRID:
    case QG_FIELD_OBJECTIVES:
        return "array";
    case QG_FIELD_OBJECT:
        return "object";
    default:
        return NULL;
    }
}

static void compare_choices(const struct qg_field *field, const cJSON *schema) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(schema, "enum")->child;
    for (size_t i = 0; field->choices[i]; i++, item = item->next) {
        assert_non_null(item);
        assert_string_equal(item->valuestring, field->choices[i]);
    }
    assert_null(item);
    if (field->need == QG_NEED_DEFAULT)
        assert_string_equal(cJSON_GetObjectItemCaseSensitive(schema, "default")->valuestring,
                            field->choices[(int)field->fallback]);
}

static void compare_numbers(const struct qg_field *field, const cJSON *schema) {
    const cJSON *ranged = field->type == QG_FIELD_RANGE ? cJSON_GetObjectItemCaseSensitive(schema, "items") : schema;
    assert_keyword(ranged, "minimum", field->low, field->key);
    assert_keyword(ranged, "maximum", field->high, field->key);
    const cJSON *fallback = cJSON_GetObjectItemCaseSensitive(schema, "default");
    assert_int_equal(fallback != NULL, field->need == QG_NEED_DEFAULT);
    if (fallback)
        assert_true(fallback->valuedouble == field->fallback);
}

/* Two ends, each within the field's range. */
static void compare_interval(const struct qg_field *field, const cJSON *schema) {
    const cJSON *items = cJSON_GetObjectItemCaseSensitive(schema, "items");
    assert_keyword(schema, "minItems", 2, field->key);
    assert_keyword(schema, "maxItems", 2, field->key);
    assert_keyword(items, "minimum", field->low, field->key);
    assert_keyword(items, "maximum", field->high, field->key);
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(items, "type")->valuestring,
                        field->type == QG_FIELD_INTERVAL ? "number" : "integer");
}

/* A word, which is the default, or a number. */
static void compare_word_or_number(const struct qg_field *field, const cJSON *schema) {
    const cJSON *either = cJSON_GetObjectItemCaseSensitive(schema, "anyOf");
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(schema, "default")->valuestring, field->choices[0]);
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(cJSON_GetArrayItem(either, 0), "const")->valuestring,
                        field->choices[0]);
    assert_keyword(cJSON_GetArrayItem(either, 1), "minimum", field->low, field->key);
    assert_keyword(cJSON_GetArrayItem(either, 1), "maximum", field->high, field->key);
}

static void compare_objectives(const struct qg_field *field, const cJSON *schema) {
    compare_choices(field, cJSON_GetObjectItemCaseSensitive(schema, "items"));
    assert_keyword(schema, "minItems", field->low, field->key);
    assert_keyword(schema, "maxItems", field->high, field->key);
}

static void compare_form(const cJSON *root, const struct qg_form *form, const cJSON *schema, size_t *count);

static void compare_field(const cJSON *root, const struct qg_field *field, const cJSON *schema, size_t *count) {
    const char *type = type_name(field);
    if (!cJSON_GetObjectItemCaseSensitive(schema, "description"))
        fail_msg("%s has no description", field->key);
    if (type)
        assert_string_equal(cJSON_GetObjectItemCaseSensitive(schema, "type")->valuestring, type);
    if (field->type == QG_FIELD_WORD_OR_NUMBER)
        compare_word_or_number(field, schema);
    else if (field->type == QG_FIELD_INTERVAL || field->type == QG_FIELD_INTERVAL_OF_WHOLES)
        compare_interval(field, schema);
    else if (field->type == QG_FIELD_OBJECTIVES)
        compare_objectives(field, schema);
    else if (field->choices)
        compare_choices(field, schema);
    else if (field->type <= QG_FIELD_SEED || field->type == QG_FIELD_RANGE)
        compare_numbers(field, schema);
    else if (field->type == QG_FIELD_TEXT)
        assert_keyword(schema, "maxLength", field->high, field->key);
    else if (field->type == QG_FIELD_LOAD_CASES)
        assert_keyword(schema, "maxItems", QG_CASES_MAX, field->key);
    else if (field->type == QG_FIELD_LABELS)
        assert_keyword(schema, "maxItems", QG_LABELS_MAX, field->key);
    else if (field->type == QG_FIELD_GRID)
        assert_keyword(schema, "maxItems", QG_AXES_MAX, field->key);
    if (field->type == QG_FIELD_GRID)
        compare_form(root, field->form, resolve(root, cJSON_GetObjectItemCaseSensitive(schema, "items")), count);
    else if (field->form)
        compare_form(root, field->form, schema, count);
    ++*count;
}

static bool is_required(const cJSON *schema, const char *key) {
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(schema, "required")) {
        if (strcmp(item->valuestring, key) == 0)
            return true;
    }
    return false;
}

/* The same keys, and for each the same type, range, default and need. */
static void compare_form(const cJSON *root, const struct qg_form *form, const cJSON *schema, size_t *count) {
    const cJSON *properties = cJSON_GetObjectItemCaseSensitive(schema, "properties");
    assert_int_equal(cJSON_GetArraySize(properties), form->count);
    assert_true(cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(schema, "additionalProperties")));
    for (size_t i = 0; i < form->count; i++) {
        const struct qg_field *field = &form->fields[i];
        const cJSON *property = cJSON_GetObjectItemCaseSensitive(properties, field->key);
        if (!property)
            fail_msg("%s is not in the schema", field->key);
        if (is_required(schema, field->key) != (field->need == QG_NEED_REQUIRED))
            fail_msg("%s: required in one and not in the other", field->key);
        compare_field(root, field, resolve(root, property), count);
    }
}

static void the_json_schema_says_what_the_table_says(void **state) {
    size_t length, count = 0;
    (void)state;
    char *text = read_source_file("schema/job.schema.json", &length);
    cJSON *root = cJSON_ParseWithLength(text, length);
    assert_non_null(root);
    compare_form(root, &qg_document_form, root, &count);
    const cJSON *load_case =
        cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(root, "$defs"), "load_case");
    compare_form(root, &qg_load_case_form, load_case, &count);
    assert_true(count > 90);
    cJSON_Delete(root);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(core_names_lead_to_pointers),
        cmocka_unit_test(parameters_have_names),
        cmocka_unit_test(a_job_has_one_objective_or_none),
        cmocka_unit_test(the_json_schema_says_what_the_table_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
