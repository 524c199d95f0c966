/* The access log. See access_log.h. */
#include "server/http/access_log.h"

#include <stdio.h>
#include <string.h>

#include "server/base/log.h"

enum { ROUTE_ROOM = 64 };

/* True for what could be a job's id (store/jobs.c makes them), and is no place to write in. */
static bool is_id(const char *text) {
    size_t length = strspn(text, "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ");
    return length == QG_JOB_ID_LENGTH && !text[length];
}

/* The job's id in a request for one; NULL for others, and for what cannot be an id. */
static const char *job_of(const struct qg_visit *visit) {
    const char *id = visit->request->parameter;
    bool of_job = visit->route && id && strncmp(visit->route->pattern, "v1/jobs/{}", 10) == 0;
    return of_job && is_id(id) ? id : NULL;
}

static const char *ending_of(const struct qg_visit *visit) {
    if (visit->status == 0)
        return "left without an answer";
    return visit->whole ? "answered" : "broken off";
}

void qg_log_visit(const struct qg_visit *visit) {
    char route[ROUTE_ROOM];
    const struct qg_actor *actor = &visit->request->actor;
    const int64_t duration_ms = visit->duration_us / 1000;
    snprintf(route, sizeof route, "%s%s", visit->route ? "/" : "-", visit->route ? visit->route->pattern : "");
    const struct qg_log_event event = {
        .priority = QG_LOG_INFO,
        .event = QG_EVENT_REQUEST,
        .job = job_of(visit),
        .token = actor->token,
        .remote = actor->address,
        .method = visit->method,
        .route = route,
        .status = visit->status,
        .duration_ms = &duration_ms,
        .bytes = &visit->bytes,
    };
    qg_log_event(&event, "%s %s%s%s: %s, status %d, %lld bytes, %lld ms, token %s, address %s", visit->method, route,
                 event.job ? " " : "", event.job ? event.job : "", ending_of(visit), visit->status,
                 (long long)visit->bytes, (long long)duration_ms, *actor->token ? actor->token : "-",
                 *actor->address ? actor->address : "-");
}
