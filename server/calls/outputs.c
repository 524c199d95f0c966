/* What a job left. See api.h.
 *
 * GET .../result           409 while there is none.
 * GET .../frequency-response  likewise, there from the time when the reference design is known.
 * GET .../evaluations      those logged when the request came; the log is read in pages, so that no query is left open
 *                          however slow the client is.
 */
#include <stdlib.h>
#include <string.h>

#include "schema/result.h"
#include "server/calls/jobs.h"

enum { EVALUATION_PAGE = 200 };

/* Says why a job has no such output. */
static void reply_missing(const struct qg_service *service, const char *id, const char *what, struct qg_reply *reply) {
    struct qg_job_row row;
    enum qg_store_status status = qg_store_job(service->store, id, &row);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return;
    }
    qg_reply_problem(reply, QG_PROBLEM_NOT_YET, "the job is %s and has no %s%s", qg_state_name(row.state), what,
                     qg_state_is_final(row.state) ? "" : " yet");
    qg_job_row_finish(&row);
}

static void reply_output(const struct qg_service *service, const struct qg_request *request, const char *name,
                         struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    enum qg_store_status status = qg_store_output(service->store, request->parameter, name, &reply->body);
    if (status == QG_STORE_NOT_FOUND) {
        reply_missing(service, request->parameter,
                      strcmp(name, QG_OUTPUT_RESULT) == 0 ? "result" : "frequency response", reply);
    } else if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
    } else {
        reply->status = 200;
        reply->media_type = request->media_type;
        qg_reply_header(reply, "Cache-Control", "no-cache");
    }
}

void qg_get_result(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    reply_output(service, request, QG_OUTPUT_RESULT, reply);
}

void qg_get_frequency_response(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    reply_output(service, request, request->offer == 0 ? QG_OUTPUT_RESPONSE : QG_OUTPUT_RESPONSE_CSV, reply);
}

/* The log of evaluations on its way to a client. */
struct log_stream {
    struct qg_store *store;
    int64_t sequence;
    size_t next, end; /* numbers */
    bool csv, headed;
    struct qg_evaluation page[EVALUATION_PAGE];
};

static enum qg_stream_step next_page(void *self, struct qg_text *piece, struct qg_pause *pause) {
    (void)pause;
    struct log_stream *stream = self;
    if (stream->csv && !stream->headed)
        qg_evaluation_write_csv_header(piece);
    stream->headed = true;
    if (stream->next >= stream->end)
        return piece->length > 0 ? QG_STREAM_PIECE : QG_STREAM_END;
    size_t count = 0,
           room = stream->end - stream->next < EVALUATION_PAGE ? stream->end - stream->next : EVALUATION_PAGE;
    if (qg_store_evaluations(stream->store, stream->sequence, stream->next, room, stream->page, &count) !=
            QG_STORE_OK ||
        count == 0) /* the job was deleted meanwhile: the client must not take this for the end */
        return QG_STREAM_BROKEN;
    for (size_t i = 0; i < count; i++)
        (stream->csv ? qg_evaluation_write_csv : qg_evaluation_write)(piece, &stream->page[i]);
    stream->next = stream->page[count - 1].number + 1;
    return QG_STREAM_PIECE;
}

void qg_get_evaluations(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    struct qg_job_row row = {0};
    struct log_stream *stream = calloc(1, sizeof *stream);
    enum qg_store_status status = stream ? qg_store_job(service->store, request->parameter, &row) : QG_STORE_FAILED;
    if (status == QG_STORE_OK)
        status = qg_store_evaluation_end(service->store, row.sequence, &stream->end);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        free(stream);
    } else {
        stream->store = service->store;
        stream->sequence = row.sequence;
        stream->csv = request->offer == 1;
        reply->stream = (struct qg_stream){.next = next_page, .destroy = free, .self = stream};
        reply->status = 200;
        reply->media_type = request->media_type;
        qg_reply_header(reply, "Cache-Control", "no-cache");
    }
    qg_job_row_finish(&row);
}
