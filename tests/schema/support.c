/* What the tests of the schema share. */
#include "tests/schema/support.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define GEAR_PAIR                                                                                                      \
    "\"gear_pair\":{\"module_mm\":3,\"pressure_angle_deg\":20,\"center_distance_mm\":111,"                             \
    "\"pinion\":{\"teeth\":28,\"profile_shift_mm\":1.927,\"outside_radius_mm\":46.55,\"root_radius_mm\":39.55,"        \
    "\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":27},"                                         \
    "\"gear\":{\"teeth\":43,\"profile_shift_mm\":2.748,\"outside_radius_mm\":69.55,\"root_radius_mm\":63.1,"           \
    "\"hob_tip_radius_mm\":0.9,\"bore_diameter_mm\":40,\"face_width_mm\":22.5},"                                       \
    "\"material\":{\"youngs_modulus_mpa\":206000,\"poisson_ratio\":0.3,\"density_kg_per_m3\":7850},"                   \
    "\"damping_ratio\":0.01,\"nominal_torque_nm\":470}"

const char least_evaluate[] = "{\"kind\":\"evaluate\"," GEAR_PAIR "}";
const char least_optimize[] =
    "{\"kind\":\"optimize\"," GEAR_PAIR ",\"relief_bounds\":{\"gear\":{\"tip\":{\"amplitude_mm\":[0.003,0.035],"
    "\"start_radius_mm\":[64,69.55]}}}}";
const char least_reliability[] =
    "{\"kind\":\"reliability\"," GEAR_PAIR
    ",\"relief\":{\"pinion\":{\"tip\":{\"start_radius_mm\":44.54,\"amplitude_mm\":0.016}}},\"reliability\":{}}";
const char least_map[] =
    "{\"kind\":\"map\"," GEAR_PAIR ",\"grid\":[{\"parameter\":\"gear.root.amplitude_mm\",\"from\":0.02,\"to\":0},"
    "{\"parameter\":\"gear.root.end_radius_mm\",\"from\":64,\"to\":66.5,\"count\":6}]}";

const char least_macro[] = "{\"kind\":\"macro\"," GEAR_PAIR "}";

char *read_source_file(const char *name, size_t *length) {
    const char *root = getenv("QG_SOURCE");
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", root ? root : ".", name);
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("cannot open %s", path);
    fseek(file, 0, SEEK_END);
    *length = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*length ? *length : 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *length, file), *length);
    fclose(file);
    return bytes;
}

enum qg_document_status read_exact(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults) {
    char *copy = malloc(length ? length : 1);
    assert_non_null(copy);
    memcpy(copy, bytes, length);
    const enum qg_document_status status = qg_document_read(copy, length, job, faults, NULL);
    free(copy);
    return status;
}

int has_fault_at(const struct qg_faults *faults, const char *pointer) {
    for (size_t i = 0; i < faults->count; i++)
        if (strcmp(faults->item[i].pointer, pointer) == 0)
            return 1;
    return 0;
}

uint64_t next_random(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
}
