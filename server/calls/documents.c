/* Documents. See documents.h.
 *
 * POST /v1/check           200 {"valid": true, "document": the document with its defaults, "geometry": the derived figures,
 *                          "warnings": [{"pointer", "detail"}], "estimate": {"evaluations", "seconds", "memory_mb"}}; a bad document is refused as POST /v1/jobs refuses it.
 *                          Nothing is queued.
 * GET  /v1/jobs/{id}/document  what the job was submitted with, with its defaults; 409 when this version of the program does
 *                          not take the document any more.
 */
#include "server/calls/documents.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/cost.h"
#include "core/memory.h"
#include "schema/drawing.h"
#include "schema/faults.h"
#include "schema/result.h"
#include "server/work/job_text.h"

#define JSON "application/json"

/* A problem with what a document's faults are. */
static void reply_with_faults(struct qg_reply *reply, enum qg_problem_code code, const char *detail,
                              const struct qg_faults *faults) {
    qg_problem_write(&reply->body, code, detail, faults);
    reply->status = qg_problem_status(code);
    reply->media_type = "application/problem+json";
}

/* A document's faults as a problem. */
static void reply_faults(struct qg_reply *reply, enum qg_document_status status, const struct qg_faults *faults) {
    enum qg_problem_code code = status == QG_DOCUMENT_NOT_JSON ? QG_PROBLEM_NOT_JSON : QG_PROBLEM_INVALID_DOCUMENT;
    char detail[64];
    snprintf(detail, sizeof detail, "%zu fault%s found", faults->count + faults->lost,
             faults->count + faults->lost == 1 ? "" : "s");
    reply_with_faults(reply, code, detail, faults);
}

/* The two ways of reading a body. */
typedef enum qg_document_status document_reader(const char *bytes, size_t length, struct qg_job *job,
                                                struct qg_faults *faults, struct qg_notes *warnings);

static struct qg_job *read_body(const struct qg_request *request, document_reader *reader, struct qg_notes *warnings,
                                struct qg_reply *reply) {
    struct qg_job *job = calloc(1, sizeof *job);
    struct qg_faults *faults = calloc(1, sizeof *faults);
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    if (job && faults)
        status = reader(request->body.data ? request->body.data : "", request->body.length, job, faults, warnings);
    if (status == QG_DOCUMENT_NO_MEMORY)
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the document");
    else if (status != QG_DOCUMENT_OK)
        reply_faults(reply, status, faults);
    free(faults);
    if (status == QG_DOCUMENT_OK)
        return job;
    free(job);
    return NULL;
}

struct qg_job *qg_request_document(const struct qg_request *request, struct qg_notes *warnings,
                                   struct qg_reply *reply) {
    return read_body(request, qg_document_read, warnings, reply);
}

struct qg_job *qg_request_design(const struct qg_request *request, struct qg_reply *reply) {
    return read_body(request, qg_design_read, NULL, reply);
}

enum qg_document_status qg_text_document(const struct qg_text *text, struct qg_job **out) {
    struct qg_job *job = calloc(1, sizeof *job);
    struct qg_faults *faults = calloc(1, sizeof *faults);
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    if (job && faults && !text->failed)
        status = qg_document_read(text->data ? text->data : "", text->length, job, faults, NULL);
    free(faults);
    if (status != QG_DOCUMENT_OK)
        free(job);
    *out = status == QG_DOCUMENT_OK ? job : NULL;
    return status;
}

/* --- what a job will take --- */

struct qg_estimate qg_estimate_job(const struct qg_service *service, const struct qg_job *job) {
    struct qg_cost cost = qg_study_cost(&job->study);
    double seconds = cost.processor_seconds / service->thread_count;
    double steps = seconds < 10 ? 10 : 1; /* a second; more digits would promise more than is known */
    double memory = qg_study_memory(&job->study, service->thread_count);
    return (struct qg_estimate){cost.evaluations, ceil(seconds * steps) / steps, ceil(memory / 1e6)};
}

/* Says which figures of the document make the job so large, and what they may be. */
static void refuse_memory(const struct qg_service *service, const struct qg_job *job, double memory_mb,
                          struct qg_reply *reply) {
    char detail[160];
    struct qg_notes notes = {0};
    struct qg_faults *faults = calloc(1, sizeof *faults);
    qg_memory_advise(&job->study, service->thread_count, service->job_memory_max * 1e6, &notes);
    for (size_t i = 0; i < notes.count && faults; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(notes.item[i].where, pointer);
        qg_faults_add(faults, pointer, "%s", notes.item[i].text);
    }
    snprintf(detail, sizeof detail, "found a job of an estimated %.0f MB, allowed are %.0f MB (max-job-memory)%s",
             memory_mb, service->job_memory_max, notes.count > 1 ? ": one of these is enough" : "");
    reply_with_faults(reply, QG_PROBLEM_TOO_MUCH_MEMORY, detail, faults);
    free(faults);
}

bool qg_job_is_affordable(const struct qg_service *service, const struct qg_job *job,
                          const struct qg_estimate *estimate, struct qg_reply *reply) {
    if (service->job_memory_max > 0 && estimate->memory_mb > service->job_memory_max) {
        refuse_memory(service, job, estimate->memory_mb, reply);
        return false;
    }
    if (service->job_cost_max == 0 || estimate->seconds <= service->job_cost_max)
        return true;
    qg_reply_problem(reply, QG_PROBLEM_TOO_COSTLY,
                     "found a job of an estimated %.0f s (%.0f evaluations), allowed are %.0f s (max-job-cost): fewer "
                     "samples, cells or speeds, or several jobs",
                     estimate->seconds, estimate->evaluations, service->job_cost_max);
    return false;
}

/* --- checking --- */

static void write_warnings(struct qg_text *text, const struct qg_notes *warnings) {
    qg_json_open(text, '[');
    for (size_t i = 0; i < warnings->count; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(warnings->item[i].where, pointer);
        qg_json_open(text, '{');
        qg_json_name(text, "pointer");
        qg_json_string(text, pointer);
        qg_json_name(text, "detail");
        qg_json_string(text, warnings->item[i].text);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

static void reply_checked(const struct qg_job *job, const struct qg_estimate *estimate, const struct qg_notes *warnings,
                          struct qg_reply *reply) {
    struct qg_pair_geometry geometry;
    struct qg_text *text = &reply->body;
    qg_pair_derive(&job->study.pair, &geometry, NULL); /* the reader has found it possible */
    qg_json_open(text, '{');
    qg_json_name(text, "valid");
    qg_json_bool(text, true);
    qg_json_name(text, "document");
    qg_document_write(text, job);
    qg_json_name(text, "geometry");
    qg_geometry_write(text, &geometry);
    qg_json_name(text, "warnings");
    write_warnings(text, warnings);
    qg_estimate_write(text, estimate);
    qg_json_close(text, '}');
    reply->status = 200;
    reply->media_type = JSON;
}

void qg_check_document(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    struct qg_notes warnings = {0};
    struct qg_job *job = qg_request_document(request, &warnings, reply);
    struct qg_estimate estimate = {0};
    if (job)
        estimate = qg_estimate_job(service, job);
    if (job && qg_job_is_affordable(service, job, &estimate, reply))
        reply_checked(job, &estimate, &warnings, reply);
    free(job);
}

/* --- the document of a job --- */

void qg_get_document(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_text text = {0};
    if (!qg_request_has_no_query(request, reply))
        return;
    enum qg_store_status status = qg_store_document(service->store, request->parameter, &text);
    struct qg_job *job = NULL;
    enum qg_document_status read = status == QG_STORE_OK ? qg_text_document(&text, &job) : QG_DOCUMENT_INVALID;
    if (job) {
        qg_document_write(&reply->body, job);
        reply->status = 200;
        reply->media_type = JSON;
        qg_reply_header(reply, "Cache-Control", "no-cache");
    } else if (read == QG_DOCUMENT_NO_MEMORY) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the document");
    } else if (status == QG_STORE_OK) {
        qg_reply_problem(reply, QG_PROBLEM_WRONG_STATE, "the document is of another version and not taken any more");
    } else {
        qg_reply_store_problem(reply, status);
    }
    free(job);
    qg_text_finish(&text);
}
