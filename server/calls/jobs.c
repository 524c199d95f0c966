/* The calls under /v1/jobs. See api.h.
 *
 * GET  /healthz             200 while the daemon and its database answer: else restart it.
 * GET  /readyz             200 while it also accepts jobs: else send them elsewhere.
 * POST /v1/jobs            201 and the job; for the same Idempotency-Key and body again the same answer, with
 *                          Idempotency-Replayed, for a week and whatever became of the job; 422 for another body. There is
 *                          no "still in progress": submitting is one transaction, which requests go through in turn.
 * GET  /v1/jobs            {"jobs": [...]}, newest first; `state`, `label`, `external_id`, `limit` (1 to 500, 50),
 *                          `cursor` from Link.
 * GET  /v1/jobs/{id}       the job, with ETag; 304 for If-None-Match; `Prefer: wait=SECONDS` (60 at most) holds the answer
 *                          until the job differs from the one named by If-None-Match, or else from what it is now. A job in
 *                          a final state is answered at once: nothing will change. So is a poll too many of one client
 *                          (stream.h).
 * POST .../cancel          200 and the job when it is cancelled, 202 while a running one still stops, 409 when it is over.
 * DELETE .../{id}          204; 409 while it runs: cancel it first.
 * What a job left is in outputs.c, documents are in documents.c, events in events.c.
 */
#include "server/calls/jobs.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/log.h"
#include "server/calls/documents.h"
#include "server/calls/form.h"
#include "server/http/encode.h"
#include "server/store/expiry.h"
#include "server/work/job_text.h"

enum { LIST_LIMIT = 50, LIST_LIMIT_MAX = 500, WAIT_MAX_S = 60, KEY_LENGTH_MAX = 255 };

#define JSON "application/json"

static void reply_status(struct qg_reply *reply, const char *status) {
    reply->status = 200;
    reply->media_type = JSON;
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "status");
    qg_json_string(&reply->body, status);
    qg_json_close(&reply->body, '}');
    qg_reply_header(reply, "Cache-Control", "no-store");
}

void qg_get_health(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    (void)request;
    if (qg_store_is_alive(service->store))
        reply_status(reply, "ok");
    else
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "the database does not answer");
}

void qg_get_readiness(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    (void)request;
    enum qg_store_status status = QG_STORE_OK;
    if (qg_board_is_shut(service->board))
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "the server is stopping");
    else if ((status = qg_store_test_writing(service->store)) != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    else
        reply_status(reply, "ready");
}

/* --- one job as a reply --- */

/* Completes a reply whose body is a job. */
static void complete_job(struct qg_reply *reply, int status) {
    char etag[QG_ETAG_ROOM];
    qg_etag(etag, &reply->body);
    reply->status = status;
    reply->media_type = JSON;
    qg_reply_header(reply, "ETag", "%s", etag);
    qg_reply_header(reply, "Cache-Control", "no-cache");
}

/* Fills the reply with a job, and finishes the row. */
static void reply_job(const struct qg_service *service, struct qg_job_row *row, int status, struct qg_reply *reply) {
    qg_job_write(&reply->body, service->board, row);
    complete_job(reply, status);
    qg_job_row_finish(row);
}

/* --- submitting --- */

static bool is_valid_key(const char *key) {
    size_t length = strlen(key);
    for (const char *c = key; *c; c++)
        if (*c < 0x21 || *c > 0x7e)
            return false;
    return length > 0 && length <= KEY_LENGTH_MAX;
}

static void write_labels(struct qg_text *text, const struct qg_job *job) {
    qg_json_open(text, '[');
    for (size_t i = 0; i < job->label_count; i++)
        qg_json_string(text, job->labels[i]);
    qg_json_close(text, ']');
}

static void reply_submitted(const struct qg_service *service, enum qg_store_status status, struct qg_job_row *row,
                            struct qg_reply *reply) {
    if (status == QG_STORE_KEY_REUSED) {
        qg_reply_problem(reply, QG_PROBLEM_KEY_REUSED, "take a new key for another document");
        return;
    }
    if (status == QG_STORE_QUEUE_FULL) {
        qg_reply_problem(
            reply, QG_PROBLEM_QUEUE_FULL,
            "the access token has as many jobs queued or running as it may: submit again when one is over");
        qg_reply_header(reply, "Retry-After", "30");
        return;
    }
    if (status != QG_STORE_OK && status != QG_STORE_REPEATED) {
        qg_reply_store_problem(reply, status);
        return;
    }
    if (status == QG_STORE_OK) {
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO,
                                            .event = QG_EVENT_JOB_SUBMITTED,
                                            .job = row->id,
                                            .state = qg_state_name(row->state)},
                     "job %s: submitted, %s", row->id, row->kind);
        qg_runner_wake(service->runner);
        qg_board_touch(service->board, row->id);
    } else {
        qg_reply_header(reply, "Idempotency-Replayed", "true");
    }
    qg_reply_header(reply, "Location", "/v1/jobs/%s", row->id);
    reply_job(service, row, 201, reply);
}

static void submit(const struct qg_service *service, struct qg_request *request, const struct qg_job *job,
                   struct qg_reply *reply) {
    struct qg_estimate estimate = qg_estimate_job(service, job);
    if (!qg_job_is_affordable(service, job, &estimate, reply))
        return;
    struct qg_text labels = {0};
    struct qg_job_row row = {0};
    write_labels(&labels, job);
    const struct qg_submission submission = {
        .name = job->name,
        .kind = qg_kind_name(job->study.kind),
        .objective = qg_job_objective(job),
        .labels = labels.data,
        .document = request->body.data,
        .idempotency_key = request->idempotency_key,
        .external_id = *job->external_id ? job->external_id : NULL,
        .estimate = estimate,
        .actor = &request->actor,
        .queue_limit = qg_access_queue_limit(service->access, request->actor.token),
    };
    enum qg_store_status status = labels.failed ? QG_STORE_FAILED : qg_store_submit(service->store, &submission, &row);
    qg_text_finish(&labels);
    reply_submitted(service, status, &row, reply);
}

void qg_post_job(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    if (qg_board_is_shut(service->board)) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "the server is stopping");
        return;
    }
    if (request->idempotency_key && !is_valid_key(request->idempotency_key)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "an Idempotency-Key has 1 to %d visible ASCII characters",
                         KEY_LENGTH_MAX);
        return;
    }
    struct qg_job *job = qg_request_document(request, NULL, reply);
    if (job)
        submit(service, request, job, reply);
    free(job);
}

/* --- listing --- */

static bool read_filter(const struct qg_request *request, struct qg_job_filter *filter, struct qg_reply *reply) {
    static const char *const names[] = {"state", "label", "external_id", "limit", "cursor", NULL};
    const char *state = qg_target_query(&request->target, "state");
    const char *limit = qg_target_query(&request->target, "limit");
    const char *cursor = qg_target_query(&request->target, "cursor");
    int64_t number = LIST_LIMIT;
    if (!qg_request_has_only(request, names, reply))
        return false;
    *filter = (struct qg_job_filter){.state = QG_STATE_COUNT,
                                     .label = qg_target_query(&request->target, "label"),
                                     .external_id = qg_target_query(&request->target, "external_id")};
    if (state && (filter->state = qg_state_of_name(state)) == QG_STATE_COUNT) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER,
                         "state: found \"%.100s\", allowed are queued, running, succeeded, failed and cancelled",
                         state);
        return false;
    }
    if (limit && !qg_read_whole_number(limit, 1, LIST_LIMIT_MAX, &number)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "limit: found \"%.100s\", allowed are whole numbers from 1 to %d",
                         limit, LIST_LIMIT_MAX);
        return false;
    }
    filter->limit = (size_t)number;
    if (cursor && !qg_read_whole_number(cursor, 1, INT64_MAX, &filter->before)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "cursor: take the address of the next page from the Link field");
        return false;
    }
    return true;
}

/* The Link field with the address of the next page. */
static void add_next_link(const struct qg_job_filter *filter, int64_t last, struct qg_reply *reply) {
    struct qg_text link = {0};
    qg_text_format(&link, "/v1/jobs?limit=%zu&cursor=%lld", filter->limit, (long long)last);
    if (filter->state != QG_STATE_COUNT)
        qg_query_add(&link, "state", qg_state_name(filter->state));
    qg_query_add(&link, "label", filter->label);
    qg_query_add(&link, "external_id", filter->external_id);
    if (!link.failed && link.length + sizeof "<>; rel=\"next\"" < QG_REPLY_HEADER_ROOM)
        qg_reply_header(reply, "Link", "<%s>; rel=\"next\"", link.data);
    qg_text_finish(&link);
}

static void write_list(const struct qg_service *service, struct qg_job_row *rows, size_t count,
                       struct qg_reply *reply) {
    reply->status = 200;
    reply->media_type = JSON;
    qg_reply_header(reply, "Cache-Control", "no-cache");
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "jobs");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < count; i++)
        qg_job_write(&reply->body, service->board, &rows[i]);
    qg_json_close(&reply->body, ']');
    qg_json_close(&reply->body, '}');
}

void qg_list_jobs(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_job_filter filter;
    if (!read_filter(request, &filter, reply))
        return;
    struct qg_job_row *rows = calloc(filter.limit, sizeof *rows);
    if (!rows) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to list the jobs");
        return;
    }
    size_t count = 0;
    int64_t next = 0;
    enum qg_store_status status = qg_store_list(service->store, &filter, rows, &count, &next);
    if (status != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    else
        write_list(service, rows, count, reply);
    if (next > 0)
        add_next_link(&filter, next, reply);
    for (size_t i = 0; i < count; i++)
        qg_job_row_finish(&rows[i]);
    free(rows);
}

/* --- one job --- */

/* Begins a long poll: what the client has seen, and how long it wants to wait. */
static void begin_wait(struct qg_request *request, const char *etag) {
    int seconds = qg_prefer_wait(request->prefer);
    bool knows_another = request->if_none_match && !qg_etag_matches(request->if_none_match, etag);
    request->wait.begun = true;
    request->wait.deadline = qg_monotonic_clock() + 1000 * (seconds < WAIT_MAX_S ? seconds : WAIT_MAX_S);
    snprintf(request->wait.seen, sizeof request->wait.seen, "%s", knows_another ? "" : etag);
}

/* True when the request is to sleep until the job differs from what the client has seen. */
static bool must_wait(const struct qg_service *service, struct qg_request *request, const char *etag, bool is_final) {
    if (!request->wait.begun)
        begin_wait(request, etag);
    return !is_final && !request->wait.refused && strcmp(etag, request->wait.seen) == 0 &&
           qg_monotonic_clock() < request->wait.deadline && !qg_board_is_shut(service->board);
}

void qg_get_job(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    int seconds = qg_prefer_wait(request->prefer);
    if (!qg_request_has_no_query(request, reply))
        return;
    if (seconds < 0) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "Prefer: found \"%.100s\", allowed is wait=SECONDS from 1 to %d",
                         request->prefer, QG_WAIT_MAX_S);
        return;
    }
    uint64_t version = qg_board_version(service->board); /* before reading: what changes from here on is not missed */
    enum qg_state state;
    enum qg_store_status status = qg_job_copy(service->job_copies, request->parameter, 0, &reply->body, &state);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return;
    }
    complete_job(reply, 200);
    const char *etag = qg_reply_header_value(reply, "ETag");
    if (seconds > 0) {
        reply->wait = must_wait(service, request, etag, qg_state_is_final(state));
        reply->polls = true;
        reply->pause = (struct qg_pause){.version = version, .deadline = request->wait.deadline};
        snprintf(reply->pause.id, sizeof reply->pause.id, "%s", request->parameter);
        if (!request->wait.refused)
            qg_reply_header(reply, "Preference-Applied", "wait=%d", seconds < WAIT_MAX_S ? seconds : WAIT_MAX_S);
    }
}

/* Whether a job has more evaluations than one deletion should drop. */
static bool has_long_log(const struct qg_service *service, const char *id) {
    struct qg_job_row row;
    size_t end = 0;
    if (qg_store_job(service->store, id, &row) != QG_STORE_OK)
        return false;
    bool known = qg_store_evaluation_end(service->store, row.sequence, &end) == QG_STORE_OK;
    qg_job_row_finish(&row);
    return known && end > QG_EVALUATIONS_AT_ONCE;
}

/* Drops a part of a finished job's long log, so that a hundred thousand evaluations do not keep the thread for half a second.
 * True when there may be more: then the handler is asked again in a moment. */
static bool drop_part(const struct qg_service *service, const char *id, struct qg_reply *reply) {
    if (!has_long_log(service, id) || qg_store_drop_evaluations(service->store, id) != QG_STORE_OK)
        return false;
    qg_reply_later(reply, service->board, 1);
    return true;
}

void qg_delete_job(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply) || drop_part(service, request->parameter, reply))
        return;
    enum qg_store_status status = qg_store_delete(service->store, request->parameter, &request->actor);
    if (status == QG_STORE_WRONG_STATE)
        qg_reply_problem(reply, QG_PROBLEM_WRONG_STATE, "the job is running: cancel it first");
    else if (status != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    if (status != QG_STORE_OK)
        return;
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO, .job = request->parameter}, "job %s: deleted",
                 request->parameter);
    qg_board_touch(service->board, request->parameter);
    reply->status = 204;
}

void qg_cancel_job(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    const char *id = request->parameter;
    struct qg_job_row row;
    enum qg_store_status status = qg_store_cancel(service->store, id, &request->actor);
    if (status == QG_STORE_OK) {
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO, .job = id}, "job %s: to be cancelled", id);
        qg_runner_cancel(service->runner, id);
        qg_board_touch(service->board, id);
        status = qg_store_job(service->store, id, &row);
    }
    if (status == QG_STORE_OK)
        reply_job(service, &row, row.state == QG_STATE_CANCELLED ? 200 : 202, reply);
    else if (status == QG_STORE_WRONG_STATE)
        qg_reply_problem(reply, QG_PROBLEM_WRONG_STATE, "the job is over: there is nothing left to cancel");
    else
        qg_reply_store_problem(reply, status);
}
