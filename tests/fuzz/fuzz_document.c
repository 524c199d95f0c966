/* Fuzzer of the document reader: any bytes are read or refused in words, and what was read comes back by way of its text. */
#include <stdio.h>
#include <string.h>

#include "schema/document.h"
#include "schema/faults.h"
#include "tests/fuzz/fuzz.h"

/* The examples are the seeds, and a few documents that no example has the like of. */
static size_t seed(size_t index, uint8_t *out) {
    static const char *const examples[] = {
        "case_S_none",           "case_S_standard",          "case_S_optimize",       "case_S_pareto",
        "case_S_robust",         "case_S_reliability",       "case_S_macro",          "case_S_map_radii",
        "case_S_map_amplitudes", "case_S_branches",          "case_B_load_dependent", "case_H_optimize_8_multistart",
        "case_H_stresses",       "case_S_optimize_parabolic"};
    static const char *const texts[] = {"{}", "[[[[]]]]", "{\"kind\":\"optimize\",\"kind\":\"map\"}",
                                        "{\"name\":\"\\ud83d\\ude00\\u00e4\",\"kind\":1e5}"};
    enum { EXAMPLES = sizeof examples / sizeof *examples, TEXTS = sizeof texts / sizeof *texts };
    char path[128];
    if (index < EXAMPLES) {
        snprintf(path, sizeof path, "schema/examples/%s.json", examples[index]);
        size_t size = fuzz_read_source(path, out);
        if (size == 0)
            fuzz_fail("%s cannot be read: set QG_SOURCE to the sources", path);
        return size;
    }
    if (index - EXAMPLES >= TEXTS)
        return 0;
    size_t size = strlen(texts[index - EXAMPLES]);
    memcpy(out, texts[index - EXAMPLES], size);
    return size;
}

static const char *const words[] = {"null",
                                    "true",
                                    "false",
                                    "{}",
                                    "[]",
                                    "\"\"",
                                    "\\u0000",
                                    "\\ud800",
                                    "\\udc00",
                                    "1e999",
                                    "-",
                                    "\xef\xbb\xbf",
                                    "\xc0\x80",
                                    "\"kind\":",
                                    "\"evaluate\"",
                                    "\"optimize\"",
                                    "\"map\"",
                                    "\"macro\"",
                                    "\"reliability\"",
                                    "\"f_pps\"",
                                    "\"f_dte\"",
                                    "\"f_dte_percentile\"",
                                    "\"objectives\":",
                                    "\"relief\":",
                                    "\"relief_bounds\":",
                                    "\"analysis\":",
                                    "\"grid\":",
                                    "\"parameter\":",
                                    "\"labels\":",
                                    "\"load_cases\":",
                                    "\"torque_nm\":",
                                    "\"torque_fraction\":",
                                    "\"amplitude_mm\":",
                                    "\"branch\":\"worst\"",
                                    "\"branch\":\"run_up\"",
                                    "\"mesh_stiffness\":\"load_dependent\"",
                                    "\"mesh_positions\":",
                                    "\"external_id\":",
                                    "\"name\":",
                                    "\"method\":\"multistart_simplex\"",
                                    "\"starts\":",
                                    "\"shape\":\"parabolic\"",
                                    "\"ramp\":\"roll_angle\"",
                                    "\"root\":",
                                    "\"end_radius_mm\":",
                                    "\"displacement\":\"static\"",
                                    NULL};

struct fuzz_harness fuzz_harness = {"document", seed, words, 20000, "whole documents", 0};

static void require_utf8(const char *text) {
    for (size_t left = strlen(text), step; left > 0; text += step, left -= step) {
        step = qg_utf8_length(text, left);
        fuzz_require(step > 0);
    }
}

/* As document.h promises: a pointer, and words without control characters. */
static void require_faults(const struct qg_faults *faults) {
    fuzz_require(faults->count > 0 && faults->count <= QG_FAULTS_ROOM);
    for (size_t i = 0; i < faults->count; i++) {
        const struct qg_fault *fault = &faults->item[i];
        fuzz_require(!*fault->pointer || *fault->pointer == '/');
        fuzz_require(*fault->detail);
        require_utf8(fault->pointer);
        require_utf8(fault->detail);
        for (const char *at = fault->detail; *at; at++)
            fuzz_require((unsigned char)*at >= ' ' && *at != 0x7f);
    }
}

/* Every warning is about a place in the document. */
static void require_warnings(const struct qg_notes *warnings) {
    char pointer[QG_POINTER_ROOM];
    for (size_t i = 0; i < warnings->count; i++) {
        qg_document_pointer(warnings->item[i].where, pointer);
        fuzz_require(!*pointer || *pointer == '/');
        fuzz_require(*warnings->item[i].text);
    }
}

/* Its text reads as the same job, and writes as the same text. */
static void require_round_trip(const struct qg_job *job) {
    static struct qg_job again;
    static struct qg_faults faults;
    struct qg_text text = {0}, twice = {0};
    qg_document_write(&text, job);
    fuzz_require(!text.failed);
    if (qg_document_read(text.data, text.length, &again, &faults, NULL) != QG_DOCUMENT_OK)
        fuzz_fail("%s\nis refused: %s: %s", text.data, faults.item[0].pointer, faults.item[0].detail);
    qg_document_write(&twice, &again);
    fuzz_require(!twice.failed);
    if (strcmp(text.data, twice.data) != 0)
        fuzz_fail("%s\nbecame\n%s", text.data, twice.data);
    fuzz_require(memcmp(&job->study.pair, &again.study.pair, sizeof again.study.pair) == 0);
    fuzz_require(strcmp(job->name, again.name) == 0 && strcmp(job->external_id, again.external_id) == 0);
    qg_text_finish(&text);
    qg_text_finish(&twice);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static struct qg_job job;
    static struct qg_faults faults;
    struct qg_notes warnings = {0};
    enum qg_document_status status = qg_document_read((const char *)data, size, &job, &faults, &warnings);
    if (status == QG_DOCUMENT_OK) {
        fuzz_harness.accepted++;
        fuzz_require(faults.count == 0 && faults.lost == 0);
        require_warnings(&warnings);
        require_round_trip(&job);
    } else {
        fuzz_require(status == QG_DOCUMENT_NOT_JSON || status == QG_DOCUMENT_INVALID);
        require_faults(&faults);
    }
    return 0;
}
