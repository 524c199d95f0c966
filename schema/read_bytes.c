/* Reading documents, designs and results from bytes.
 *
 * Three passes: the strict scan of the bytes (scan.c), which a result of our own does without; the parser; then the walk over
 * the parsed objects (read.c). The locale of the calling thread is "C" meanwhile: parser and scan read numbers with strtod.
 */
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "schema/drawing.h"
#include "schema/read.h"
#include "schema/scan.h"

/* What the bytes are, and what becomes of them once they are parsed. */
struct source {
    const char *bytes;
    size_t length;
    bool trusted; /* written by ourselves, and larger than documents may be */
    /* makes the document of what was parsed, in its place; NULL: it is one */
    enum qg_document_status (*take)(cJSON *root, cJSON **document);
};

/* Scan, parse, walk. */
static enum qg_document_status read_source(const struct source *source, struct qg_job *job, struct qg_faults *faults,
                                           struct qg_notes *warnings) {
    const enum qg_document_status scanned =
        source->trusted ? QG_DOCUMENT_OK : qg_scan(source->bytes, source->length, faults);
    if (scanned != QG_DOCUMENT_OK)
        return scanned;
    cJSON *root = cJSON_ParseWithLengthOpts(source->bytes, source->length, NULL, false);
    if (!root)
        return QG_DOCUMENT_NO_MEMORY; /* the scan has seen to everything else */
    cJSON *document = root;
    enum qg_document_status status = source->take ? source->take(root, &document) : QG_DOCUMENT_OK;
    if (status == QG_DOCUMENT_OK) {
        qg_tree_read(document, job, faults, warnings);
        status = faults->count + faults->lost == 0 ? QG_DOCUMENT_OK : QG_DOCUMENT_INVALID;
    }
    cJSON_Delete(root);
    return status;
}

/* Reads in the "C" locale. */
static enum qg_document_status read_plainly(const struct source *source, struct qg_job *job, struct qg_faults *faults,
                                            struct qg_notes *warnings) {
    memset(job, 0, sizeof *job); /* padding too: equal documents give equal bytes */
    *faults = (struct qg_faults){0};
    const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return QG_DOCUMENT_NO_MEMORY;
    const locale_t usual = uselocale(plain);
    const enum qg_document_status status = read_source(source, job, faults, warnings);
    uselocale(usual);
    freelocale(plain);
    return status;
}

enum qg_document_status qg_document_read(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults,
                                         struct qg_notes *warnings) {
    return read_plainly(&(struct source){.bytes = bytes, .length = length}, job, faults, warnings);
}

/* A document without a kind is a design. */
static enum qg_document_status take_design(cJSON *root, cJSON **document) {
    (void)document;
    if (!cJSON_IsObject(root) || cJSON_GetObjectItemCaseSensitive(root, "kind"))
        return QG_DOCUMENT_OK;
    return cJSON_AddStringToObject(root, "kind", "evaluate") ? QG_DOCUMENT_OK : QG_DOCUMENT_NO_MEMORY;
}

enum qg_document_status qg_design_read(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults,
                                       struct qg_notes *warnings) {
    return read_plainly(&(struct source){.bytes = bytes, .length = length, .take = take_design}, job, faults, warnings);
}

/* Takes the item over, into the object. False when memory is short; the item is gone then. */
static bool add(cJSON *object, const char *key, cJSON *item) {
    const bool added = cJSON_AddItemToObject(object, key, item);
    if (!added)
        cJSON_Delete(item);
    return added;
}

/* The best candidate of a macro search takes the place of the job's pair, and the job becomes an evaluation of it. False
 * when memory is short. */
static bool take_best_candidate(cJSON *job, const cJSON *macro) {
    static const char *const unused[] = {"kind", "gear_pair", "objective", "macro"};
    const cJSON *best = cJSON_GetObjectItemCaseSensitive(macro, "best");
    cJSON *candidate = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(macro, "candidates"),
                                          cJSON_IsNumber(best) ? best->valueint : -1);
    cJSON *pair = cJSON_DetachItemFromObjectCaseSensitive(candidate, "gear_pair");
    if (!pair)
        return true;
    for (size_t i = 0; i < sizeof unused / sizeof *unused; i++)
        cJSON_DeleteItemFromObjectCaseSensitive(job, unused[i]);
    return add(job, "gear_pair", pair) && cJSON_AddStringToObject(job, "kind", "evaluate");
}

/* The job of a result, with the relief of its design. */
static enum qg_document_status take_result_design(cJSON *root, cJSON **document) {
    cJSON *job = cJSON_GetObjectItemCaseSensitive(root, "job");
    cJSON *design = cJSON_GetObjectItemCaseSensitive(root, "design");
    if (!cJSON_IsObject(job) || !cJSON_IsObject(design))
        return QG_DOCUMENT_INVALID;
    *document = job;
    if (!take_best_candidate(job, cJSON_GetObjectItemCaseSensitive(root, "macro")))
        return QG_DOCUMENT_NO_MEMORY;
    cJSON *relief = cJSON_DetachItemFromObjectCaseSensitive(design, "relief");
    cJSON_DeleteItemFromObjectCaseSensitive(job, "relief");
    if (cJSON_IsObject(relief))
        return add(job, "relief", relief) ? QG_DOCUMENT_OK : QG_DOCUMENT_NO_MEMORY;
    cJSON_Delete(relief);
    return QG_DOCUMENT_OK;
}

enum qg_document_status qg_result_design_read(const char *bytes, size_t length, struct qg_job *job) {
    struct qg_faults *faults = malloc(sizeof *faults);
    if (!faults)
        return QG_DOCUMENT_NO_MEMORY;
    const struct source source = {.bytes = bytes, .length = length, .trusted = true, .take = take_result_design};
    const enum qg_document_status status = read_plainly(&source, job, faults, NULL);
    free(faults);
    return status;
}
