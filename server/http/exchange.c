/* Building replies. See exchange.h. */
#include "server/http/exchange.h"

#include <assert.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void qg_reply_finish(struct qg_reply *reply) {
    qg_text_finish(&reply->body);
    if (reply->stream.self)
        reply->stream.destroy(reply->stream.self);
    reply->stream.self = NULL;
}

void qg_reply_header(struct qg_reply *reply, const char *name, const char *format, ...) {
    assert(reply->header_count < QG_REPLY_HEADERS_MAX);
    va_list arguments;
    va_start(arguments, format);
    reply->header[reply->header_count].name = name;
    vsnprintf(reply->header[reply->header_count++].value, QG_REPLY_HEADER_ROOM, format, arguments);
    va_end(arguments);
}

const char *qg_reply_header_value(const struct qg_reply *reply, const char *name) {
    for (size_t i = 0; i < reply->header_count; i++)
        if (strcmp(reply->header[i].name, name) == 0)
            return reply->header[i].value;
    return NULL;
}

void qg_reply_later(struct qg_reply *reply, struct qg_board *board, int ms) {
    reply->wait = true;
    reply->pause = (struct qg_pause){.id = "nobody", /* no job's id: only the deadline ends the pause */
                                     .version = qg_board_version(board),
                                     .deadline = qg_monotonic_clock() + ms};
}

void qg_reply_problem(struct qg_reply *reply, enum qg_problem_code code, const char *detail, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, detail);
    vsnprintf(text, sizeof text, detail, arguments);
    va_end(arguments);
    qg_text_finish(&reply->body);
    qg_problem_write(&reply->body, code, text, NULL);
    reply->status = qg_problem_status(code);
    reply->media_type = "application/problem+json";
}

/* Refuses for a reason that somebody has to mend first. */
static void refuse_storage(struct qg_reply *reply, enum qg_problem_code code, enum qg_store_status status) {
    qg_reply_problem(reply, code, "%s", qg_store_failure_text(status));
    qg_reply_header(reply, "Retry-After", "30");
}

void qg_reply_store_problem(struct qg_reply *reply, enum qg_store_status status) {
    switch (status) {
    case QG_STORE_NOT_FOUND:
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such job");
        break;
    case QG_STORE_FULL:
        refuse_storage(reply, QG_PROBLEM_STORAGE_FULL, status);
        break;
    case QG_STORE_READ_ONLY:
        refuse_storage(reply, QG_PROBLEM_STORAGE_READ_ONLY, status);
        break;
    case QG_STORE_CORRUPT:
        refuse_storage(reply, QG_PROBLEM_STORAGE_DAMAGED, status);
        break;
    case QG_STORE_UNAVAILABLE:
        refuse_storage(reply, QG_PROBLEM_UNAVAILABLE, status);
        break;
    case QG_STORE_QUEUE_FULL:
        qg_reply_problem(reply, QG_PROBLEM_QUEUE_FULL, "ask again when some are done or gone");
        qg_reply_header(reply, "Retry-After", "30");
        break;
    default:
        qg_reply_problem(reply, QG_PROBLEM_INTERNAL, "%s", qg_store_failure_text(QG_STORE_FAILED));
        break;
    }
}

bool qg_request_has_only(const struct qg_request *request, const char *const *names, struct qg_reply *reply) {
    const char *offender;
    if (qg_target_query_is_among(&request->target, names, &offender))
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "the query parameter \"%.100s\" is unknown here, or given twice",
                     offender);
    return false;
}

bool qg_request_has_no_query(const struct qg_request *request, struct qg_reply *reply) {
    static const char *const none[] = {NULL};
    return qg_request_has_only(request, none, reply);
}

bool qg_read_whole_number(const char *text, int64_t least, int64_t most, int64_t *out) {
    char *end;
    errno = 0;
    long long value = strtoll(text, &end, 10);
    *out = value;
    return *text >= '0' && *text <= '9' && !*end && !errno && value >= least && value <= most;
}
