/* Drawings. See drawings.h.
 *
 * POST /v1/profile         of the design in the body: a job document, or one without "kind" (schema/drawing.h). A bad one is
 *                          refused as POST /v1/jobs refuses it. Nothing is queued.
 * GET .../{id}/profile     of a job: `design=design` (the default) is the one of its result, 409 while there is none;
 *                          `design=reference` is the relief of its document, there from the beginning.
 * GET .../{id}/field       displacement and stress of the result's design, at `position` (0.5) and `load_case` (its place in
 *                          /load_cases; the largest torque). It is computed when it is asked for first: until then
 *                          202 {"state": "pending"} with Retry-After; 409 while there is no result.
 * Both answer 409 for a result without a design, which a macro job has when nothing passed.
 * The first two take `extent` (gears or spaces) and `position` (0 to 1, mesh periods), which only matter to a DXF.
 */
#include "server/calls/drawings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "schema/drawing.h"
#include "server/calls/documents.h"
#include "server/work/field_maker.h"

/* What is asked for. */
struct wish {
    enum qg_extent extent;
    double position;
    bool reference;
};

/* Digits with at most one point between or behind them; a number from 0 to 1 in any locale. */
static bool read_position(const char *text, double *out) {
    double value = 0, unit = 1;
    bool behind = false, digits = false;
    for (const char *c = text; *c; c++) {
        if (*c == '.' && !behind) {
            behind = true;
            continue;
        }
        if (*c < '0' || *c > '9')
            return false;
        digits = true;
        if (behind)
            unit /= 10;
        value = behind ? value + (*c - '0') * unit : 10 * value + (*c - '0');
    }
    *out = value;
    return digits && strlen(text) <= 20 && value <= 1;
}

/* The parameter `position`, 0.5 where it is absent. */
static bool take_position(const struct qg_request *request, double *out, struct qg_reply *reply) {
    const char *position = qg_target_query(&request->target, "position");
    *out = 0.5;
    if (!position || read_position(position, out))
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "position: found \"%.100s\", allowed are numbers from 0 to 1",
                     position);
    return false;
}

static bool read_extent(const struct qg_request *request, struct wish *wish, struct qg_reply *reply) {
    const char *extent = qg_target_query(&request->target, "extent");
    const int found = extent ? qg_extent_of_name(extent) : QG_EXTENT_GEARS;
    *wish = (struct wish){.extent = found < 0 ? QG_EXTENT_GEARS : (enum qg_extent)found};
    if (found < 0) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "extent: found \"%.100s\", allowed are gears and spaces", extent);
        return false;
    }
    return take_position(request, &wish->position, reply);
}

static void reply_drawing(const struct qg_request *request, const struct wish *wish, const struct qg_job *job,
                          struct qg_reply *reply) {
    const bool dxf = strcmp(request->media_type, QG_DXF) == 0;
    reply->status = 200;
    reply->media_type = request->media_type;
    qg_reply_header(reply, "Cache-Control", "no-cache");
    if (dxf)
        qg_dxf_write(&reply->body, job, wish->extent, wish->position);
    else
        qg_profile_write(&reply->body, job);
    if (dxf)
        qg_reply_header(reply, "Content-Disposition", "attachment; filename=\"%s.dxf\"",
                        wish->extent == QG_EXTENT_GEARS ? "gears" : "tooth-spaces");
}

void qg_post_profile(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    static const char *const names[] = {"extent", "position", NULL};
    struct wish wish;
    (void)service;
    if (!qg_request_has_only(request, names, reply) || !read_extent(request, &wish, reply))
        return;
    struct qg_job *job = qg_request_design(request, reply);
    if (job)
        reply_drawing(request, &wish, job, reply);
    free(job);
}

static bool read_design(const struct qg_request *request, struct wish *wish, struct qg_reply *reply) {
    const char *design = qg_target_query(&request->target, "design");
    wish->reference = design && strcmp(design, "reference") == 0;
    if (!design || wish->reference || strcmp(design, "design") == 0)
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "design: found \"%.100s\", allowed are design and reference", design);
    return false;
}

/* Fetches the text that holds the design: the job's document, or the small part of its result; the whole of it, which takes
 * the one thread that serves HTTP a second to read, for jobs that were done before there was such a part. */
static enum qg_store_status fetch(const struct qg_service *service, const char *id, bool reference,
                                  struct qg_text *text) {
    if (reference)
        return qg_store_document(service->store, id, text);
    const enum qg_store_status status = qg_store_output(service->store, id, QG_OUTPUT_DESIGN, text);
    return status == QG_STORE_NOT_FOUND ? qg_store_output(service->store, id, QG_OUTPUT_RESULT, text) : status;
}

/* Says why there is no result: no such job, or not yet. */
static void reply_no_result(const struct qg_service *service, const char *id, struct qg_reply *reply) {
    struct qg_job_row row;
    enum qg_store_status status = qg_store_job(service->store, id, &row);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return;
    }
    qg_reply_problem(reply, QG_PROBLEM_NOT_YET, "the job is %s and has no result", qg_state_name(row.state));
    qg_job_row_finish(&row);
}

/* Reads the design out of the text. NULL and a reply when that fails: memory is short, or there is no design in it. */
static struct qg_job *read_text(const struct qg_text *text, bool reference, struct qg_reply *reply) {
    struct qg_job *job = calloc(1, sizeof *job);
    struct qg_faults *faults = calloc(1, sizeof *faults);
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    if (job && faults && text->data)
        status = reference ? qg_document_read(text->data, text->length, job, faults, NULL)
                           : qg_result_design_read(text->data, text->length, job);
    free(faults);
    if (status == QG_DOCUMENT_OK)
        return job;
    free(job);
    if (status == QG_DOCUMENT_NO_MEMORY)
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the design");
    else
        qg_reply_problem(reply, QG_PROBLEM_WRONG_STATE,
                         reference ? "the document is of another version and not taken any more"
                                   : "the result has no design: no macro-geometry passed, or it is of another version");
    return NULL;
}

void qg_get_job_profile(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    static const char *const names[] = {"design", "extent", "position", NULL};
    struct wish wish;
    struct qg_text text = {0};
    if (!qg_request_has_only(request, names, reply) || !read_extent(request, &wish, reply) ||
        !read_design(request, &wish, reply))
        return;
    enum qg_store_status status = fetch(service, request->parameter, wish.reference, &text);
    struct qg_job *job = status == QG_STORE_OK ? read_text(&text, wish.reference, reply) : NULL;
    if (job)
        reply_drawing(request, &wish, job, reply);
    else if (status == QG_STORE_NOT_FOUND)
        reply_no_result(service, request->parameter, reply);
    else if (status != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    free(job);
    qg_text_finish(&text);
}

/* ---- fields ----------------------------------------------------------------------------------------------------- */

/* The place of the largest torque. */
static size_t largest_case(const struct qg_analysis *analysis) {
    size_t largest = 0;
    for (size_t i = 1; i < analysis->case_count; i++)
        if (analysis->torque_fraction[i] > analysis->torque_fraction[largest])
            largest = i;
    return largest;
}

/* The load case that is asked for. */
static bool take_load_case(const struct qg_request *request, const struct qg_analysis *analysis, size_t *out,
                           struct qg_reply *reply) {
    const char *wanted = qg_target_query(&request->target, "load_case");
    int64_t number = (int64_t)largest_case(analysis);
    if (wanted && !qg_read_whole_number(wanted, 0, (int64_t)analysis->case_count - 1, &number)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "load_case: found \"%.100s\", allowed are 0 to %zu", wanted,
                         analysis->case_count - 1);
        return false;
    }
    *out = (size_t)number;
    return true;
}

static void reply_pending(struct qg_reply *reply) {
    reply->status = 202;
    reply->media_type = "application/json";
    qg_reply_header(reply, "Retry-After", "1");
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "state");
    qg_json_string(&reply->body, "pending");
    qg_json_close(&reply->body, '}');
}

/* Refuses the field of a mesh that is too fine. */
static bool is_makeable(const struct qg_job *job, struct qg_reply *reply) {
    const int refinement = job->study.analysis.mesh_refinement;
    if (refinement <= QG_FIELD_REFINEMENT_MAX)
        return true;
    qg_reply_problem(
        reply, QG_PROBLEM_WRONG_STATE,
        "analysis.mesh_refinement: the job's is %d, fields are made here up to %d: quietgear export makes it",
        refinement, QG_FIELD_REFINEMENT_MAX);
    return false;
}

static void reply_field(const struct qg_service *service, const struct qg_field_key *key, const struct qg_job *job,
                        struct qg_reply *reply) {
    enum qg_field_answer answer = qg_field_find(service->field_maker, key, &reply->body);
    if (answer == QG_FIELD_UNKNOWN)
        answer = qg_field_order(service->field_maker, key, job);
    if (answer == QG_FIELD_PENDING) {
        reply_pending(reply);
    } else if (answer == QG_FIELD_DONE) {
        reply->status = 200;
        reply->media_type = "application/json";
    } else {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE,
                         answer == QG_FIELD_BUSY ? "too many fields are waiting to be computed"
                                                 : "the field could not be computed");
    }
}

void qg_get_job_field(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    static const char *const names[] = {"load_case", "position", NULL};
    struct qg_field_key key = {0};
    struct qg_text text = {0};
    if (!qg_request_has_only(request, names, reply) || !take_position(request, &key.position, reply))
        return;
    enum qg_store_status status = fetch(service, request->parameter, false, &text);
    struct qg_job *job = status == QG_STORE_OK ? read_text(&text, false, reply) : NULL;
    snprintf(key.id, sizeof key.id, "%s", request->parameter);
    if (job && is_makeable(job, reply) && take_load_case(request, &job->study.analysis, &key.load_case, reply))
        reply_field(service, &key, job, reply);
    else if (status == QG_STORE_NOT_FOUND)
        reply_no_result(service, request->parameter, reply);
    else if (status != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    free(job);
    qg_text_finish(&text);
}
