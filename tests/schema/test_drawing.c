/* Drawings: profile data that fit together, DXF whose pairs add up, designs read from documents and results. When $QG_SAMPLES
 * names a directory, the profile data are left there, for schemas.bats to hold against the JSON Schema. An independent
 * reader judges the DXF in tests/service/drawings.bats. */
#include <cjson/cJSON.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "schema/drawing.h"
#include "tests/schema/support.h"

/* An example as a job, to be freed. */
static struct qg_job *example(const char *name) {
    char path[128];
    size_t length;
    snprintf(path, sizeof path, "schema/examples/%s.json", name);
    char *bytes = read_source_file(path, &length);
    struct qg_job *job = malloc(sizeof *job);
    struct qg_faults *faults = malloc(sizeof *faults);
    assert_true(bytes && job && faults);
    assert_int_equal(qg_document_read(bytes, length, job, faults, NULL), QG_DOCUMENT_OK);
    free(faults);
    free(bytes);
    return job;
}

static cJSON *profile_of(const char *name) {
    struct qg_text text = {0};
    struct qg_job *job = example(name);
    qg_profile_write(&text, job);
    assert_false(text.failed);
    const char *samples = getenv("QG_SAMPLES");
    if (samples) {
        char path[512];
        snprintf(path, sizeof path, "%s/profile_%s.json", samples, name);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fwrite(text.data, 1, text.length, file);
        assert_int_equal(fclose(file), 0);
    }
    cJSON *root = cJSON_Parse(text.data);
    assert_non_null(root);
    qg_text_finish(&text);
    free(job);
    return root;
}

/* The member at a path of names with points between them. */
static const cJSON *at(const cJSON *item, const char *path) {
    char name[64];
    while (*path) {
        size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, path);
        item = cJSON_GetObjectItemCaseSensitive(item, name);
        if (!item)
            fail_msg("there is no %s", name);
        path += length + (path[length] == '.');
    }
    return item;
}

static double number_at(const cJSON *item, const char *path) {
    return at(item, path)->valuedouble;
}

static double item_at(const cJSON *item, const char *path, int index) {
    const cJSON *array = at(item, path);
    return cJSON_GetArrayItem(array, index < 0 ? cJSON_GetArraySize(array) + index : index)->valuedouble;
}

static void assert_close(double got, double wanted) {
    if (!(fabs(got - wanted) < 1e-9))
        fail_msg("got %.12g, wanted %.12g", got, wanted);
}

/* Case S with the paper's standard relief: known radii, and the amplitudes at the tips. */
static void profile_data_are_those_of_the_pair(void **state) {
    (void)state;
    cJSON *root = profile_of("case_S_standard");
    assert_close(number_at(root, "center_distance_mm"), 111);
    assert_close(number_at(root, "pinion.reference_radius_mm"), 42);
    assert_close(number_at(root, "pinion.pitch_radius_mm") + number_at(root, "gear.pitch_radius_mm"), 111);
    assert_close(item_at(root, "pinion.diagram.design.removed_um", -1), 16);
    assert_close(item_at(root, "gear.diagram.design.removed_um", -1), 18);
    assert_close(item_at(root, "pinion.diagram.design.removed_um", 0), 0);
    assert_close(number_at(root, "pinion.marks.end_of_active_profile.radius_mm"), 46.55);
    assert_close(number_at(root, "pinion.marks.end_of_active_profile.roll_length_mm") -
                     number_at(root, "pinion.marks.lowest_single_contact.roll_length_mm"),
                 9.42477796076938 * 0.939692620785908);
    assert_true(cJSON_IsNull(at(root, "pinion.diagram.least")) && cJSON_IsNull(at(root, "gear.diagram.most")));
    double x = item_at(root, "pinion.outline.x_mm", 0), y = item_at(root, "pinion.outline.y_mm", 0);
    assert_close(hypot(x, y), 39.55);
    assert_close(atan2(y, x), 3.14159265358979 / 28);
    assert_close(item_at(root, "pinion.outline.y_mm", -1), -y);
    assert_int_equal(cJSON_GetArraySize(at(root, "mesh.position")), cJSON_GetArraySize(at(root, "mesh.contacts")));
    assert_close(item_at(root, "mesh.pinion_angle_deg", -1) - item_at(root, "mesh.pinion_angle_deg", 0), 360.0 / 28);
    assert_close(item_at(root, "mesh.gear_angle_deg", -1) - item_at(root, "mesh.gear_angle_deg", 0), -360.0 / 43);
    cJSON_Delete(root);
}

/* What a search or a map may reach: bounds of the example, 3 to 35 micrometres at the tip; a ramp that starts at the tip itself,
 * as its bounds allow, removes nothing. */
static void bounds_become_bands(void **state) {
    (void)state;
    cJSON *search = profile_of("case_S_optimize"), *map = profile_of("case_S_map_amplitudes");
    assert_close(item_at(search, "gear.diagram.least.removed_um", -1), 0);
    assert_close(item_at(search, "gear.diagram.design.removed_um", -1), 18);
    assert_close(item_at(search, "gear.diagram.most.removed_um", -1), 35);
    assert_true(item_at(map, "pinion.diagram.least.removed_um", -1) <
                item_at(map, "pinion.diagram.most.removed_um", -1));
    cJSON_Delete(search);
    cJSON_Delete(map);
}

/* Walks the pairs of a DXF: whole lines, a code that is a number, sections opened and closed, handles used once. */
static size_t walk_dxf(char *text, const char *entity) {
    size_t found = 0, open = 0, handles = 0;
    static bool seen[0x1000];
    memset(seen, 0, sizeof seen);
    char *end, *value;
    for (char *line = text; *line; line = strchr(value, '\n') + 1) {
        long code = strtol(line, &end, 10);
        assert_true(end > line && *end == '\n' && code >= 0 && code < 1000);
        value = end + 1;
        size_t length = strcspn(value, "\n");
        found += code == 0 && strlen(entity) == length && strncmp(value, entity, length) == 0;
        open += code == 0 && strncmp(value, "SECTION\n", 8) == 0;
        open -= code == 0 && strncmp(value, "ENDSEC\n", 7) == 0;
        if (code == 5 && strncmp(value, "FFFF", 4) != 0) {
            long handle = strtol(value, NULL, 16);
            assert_true(handle > 0 && handle < 0x1000 && !seen[handle]);
            seen[handle] = true;
            handles++;
        }
        assert_true(open <= 1);
    }
    assert_int_equal(open, 0);
    assert_true(handles > 20);
    return found;
}

static void dxf_is_well_formed(void **state) {
    (void)state;
    static const char *const names[] = {"case_S_standard", "case_S_none", "case_H_optimize", "case_B_branches"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        struct qg_job *job = example(names[i]);
        struct qg_text gears = {0}, spaces = {0};
        qg_dxf_write(&gears, job, QG_EXTENT_GEARS, 0.25);
        qg_dxf_write(&spaces, job, QG_EXTENT_SPACES, 0);
        assert_int_equal(walk_dxf(gears.data, "LWPOLYLINE"), 2);
        assert_int_equal(walk_dxf(gears.data, "CIRCLE"), 8);
        assert_int_equal(walk_dxf(spaces.data, "LWPOLYLINE"), 2);
        assert_int_equal(walk_dxf(spaces.data, "CIRCLE"), 0);
        assert_true(spaces.length < 10000);
        qg_text_finish(&gears);
        qg_text_finish(&spaces);
        free(job);
    }
}

static enum qg_document_status read_design(const char *text, struct qg_job *job, struct qg_faults *faults) {
    return qg_design_read(text, strlen(text), job, faults, NULL);
}

static void a_design_needs_no_kind(void **state) {
    (void)state;
    size_t length;
    char *bytes = read_source_file("schema/examples/case_S_standard.json", &length);
    cJSON *root = cJSON_ParseWithLength(bytes, length);
    struct qg_job *job = malloc(sizeof *job);
    struct qg_faults *faults = malloc(sizeof *faults);
    assert_true(root && job && faults);
    cJSON_DeleteItemFromObjectCaseSensitive(root, "kind");
    char *text = cJSON_PrintUnformatted(root);
    assert_int_equal(read_design(text, job, faults), QG_DOCUMENT_OK);
    assert_true(job->study.relief.gears[QG_GEAR].tip.amplitude == 0.018);
    assert_int_equal(qg_document_read(text, strlen(text), job, faults, NULL), QG_DOCUMENT_INVALID);
    assert_int_equal(read_design("{}", job, faults), QG_DOCUMENT_INVALID);
    assert_true(has_fault_at(faults, "/gear_pair"));
    assert_int_equal(read_design("[1]", job, faults), QG_DOCUMENT_INVALID);
    assert_int_equal(read_design("{", job, faults), QG_DOCUMENT_NOT_JSON);
    cJSON_Delete(root);
    free(text);
    free(bytes);
    free(job);
    free(faults);
}

/* A result is a document "job" and a "design" with a relief: the rest does not matter. */
static void a_result_gives_its_design(void **state) {
    (void)state;
    struct qg_job *job = example("case_S_optimize");
    struct qg_text document = {0}, result = {0};
    qg_document_write(&document, job);
    qg_text_format(&result, "{\"job\":%s,\"design\":{\"relief\":", document.data);
    job->study.relief.gears[QG_PINION].tip.amplitude = 0.1 + 0.2 - 0.279;
    job->study.relief.gears[QG_GEAR].root = (struct qg_ramp){true, 65, 0.004};
    qg_relief_write(&result, &job->study.relief);
    qg_text_format(&result, "}}");
    struct qg_job *back = malloc(sizeof *back);
    assert_non_null(back);
    assert_int_equal(qg_result_design_read(result.data, result.length, back), QG_DOCUMENT_OK);
    assert_memory_equal(&back->study.relief, &job->study.relief, sizeof job->study.relief);
    assert_int_equal(back->study.bounds.count, 4);
    assert_int_equal(qg_result_design_read("{\"job\":{}}", 10, back), QG_DOCUMENT_INVALID);
    assert_int_equal(qg_result_design_read("[]", 2, back), QG_DOCUMENT_INVALID);
    qg_text_finish(&document);
    qg_text_finish(&result);
    free(back);
    free(job);
}

/* The pair of the best candidate, not the initial one. */
static void a_macro_result_gives_its_best_candidate(void **state) {
    struct qg_job *job = malloc(sizeof *job), *back = malloc(sizeof *back);
    struct qg_faults *faults = malloc(sizeof *faults);
    struct qg_text result = {0};
    (void)state;
    assert_true(job && back && faults);
    assert_int_equal(read_exact(least_macro, strlen(least_macro), job, faults), QG_DOCUMENT_OK);
    qg_text_format(&result, "{\"job\":");
    qg_document_write(&result, job);
    qg_text_format(&result, ",\"design\":{\"relief\":{}},\"macro\":{\"best\":1,\"candidates\":[{},{\"gear_pair\":");
    struct qg_gear_pair pair = job->study.pair;
    pair.gears[QG_GEAR].hob_tip_radius = 0.75;
    result.comma = false; /* what was formatted by hand owes none */
    qg_pair_write(&result, job, &pair, job->given.pressure_angle_deg, "best");
    qg_text_format(&result, "}]}}");
    assert_int_equal(qg_result_design_read(result.data, result.length, back), QG_DOCUMENT_OK);
    assert_memory_equal(&back->study.pair, &pair, sizeof pair);
    assert_int_equal(back->study.kind, QG_STUDY_EVALUATE);
    qg_text_finish(&result);
    free(job);
    free(back);
    free(faults);
}

static void extents_have_names(void **state) {
    (void)state;
    assert_int_equal(qg_extent_of_name("gears"), QG_EXTENT_GEARS);
    assert_int_equal(qg_extent_of_name("spaces"), QG_EXTENT_SPACES);
    assert_int_equal(qg_extent_of_name("space"), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(profile_data_are_those_of_the_pair),
        cmocka_unit_test(bounds_become_bands),
        cmocka_unit_test(dxf_is_well_formed),
        cmocka_unit_test(a_design_needs_no_kind),
        cmocka_unit_test(a_result_gives_its_design),
        cmocka_unit_test(a_macro_result_gives_its_best_candidate),
        cmocka_unit_test(extents_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
