/* The step before every handler. See authorize.h. */
#include "server/http/authorize.h"

#include <stdio.h>

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/store/access.h"

static const char *name_of(unsigned scope) {
    return scope & QG_SCOPE_READ ? "read" : scope & QG_SCOPE_SUBMIT ? "submit" : "admin";
}

static void reply_verdict(enum qg_verdict verdict, unsigned scope, int retry_after_s, struct qg_reply *reply) {
    switch (verdict) {
    case QG_VERDICT_NO_TOKEN:
        qg_reply_problem(reply, QG_PROBLEM_UNAUTHORIZED, "send Authorization: Bearer TOKEN with a token for %s",
                         name_of(scope));
        qg_reply_header(reply, "WWW-Authenticate", "Bearer realm=\"quietgear\"");
        break;
    case QG_VERDICT_WRONG_TOKEN:
        qg_reply_problem(reply, QG_PROBLEM_UNAUTHORIZED, "the access token is malformed, unknown or revoked");
        qg_reply_header(reply, "WWW-Authenticate", "Bearer realm=\"quietgear\", error=\"invalid_token\"");
        break;
    case QG_VERDICT_OVER:
        qg_reply_problem(reply, QG_PROBLEM_UNAUTHORIZED, "the access token has expired");
        qg_reply_header(reply, "WWW-Authenticate",
                        "Bearer realm=\"quietgear\", error=\"invalid_token\", error_description=\"expired\"");
        break;
    case QG_VERDICT_WRONG_SCOPE:
        qg_reply_problem(reply, QG_PROBLEM_FORBIDDEN, "the scope %s is missing", name_of(scope));
        qg_reply_header(reply, "WWW-Authenticate",
                        "Bearer realm=\"quietgear\", error=\"insufficient_scope\", scope=\"%s\"", name_of(scope));
        break;
    default:
        qg_reply_problem(reply, QG_PROBLEM_TOO_MANY_REQUESTS, "ask again in %d s", retry_after_s);
        qg_reply_header(reply, "Retry-After", "%d", retry_after_s);
        break;
    }
}

static const char *reason_of(enum qg_verdict verdict) {
    switch (verdict) {
    case QG_VERDICT_GRANTED:
        break;
    case QG_VERDICT_NO_TOKEN:
        return "without a token";
    case QG_VERDICT_WRONG_TOKEN:
        return "a token that is malformed, unknown or revoked";
    case QG_VERDICT_OVER:
        return "a token that has expired";
    case QG_VERDICT_WRONG_SCOPE:
        return "the token is not for that";
    case QG_VERDICT_TOO_MANY:
        return "too many requests of one token";
    }
    return "-";
}

/* Logs a refusal. Anybody can cause them: few of each address are written, and of all addresses together no more than the
 * log's places for repeated messages hold. */
static void log_denial(enum qg_verdict verdict, unsigned scope, const struct qg_actor *actor, int status) {
    char kind[QG_ADDRESS_ROOM + QG_TOKEN_ID_ROOM + 32];
    snprintf(kind, sizeof kind, "denied %d %s %s", (int)verdict, actor->address, actor->token);
    qg_log_event(&(struct qg_log_event){.priority = verdict == QG_VERDICT_NO_TOKEN ? QG_LOG_INFO : QG_LOG_WARNING,
                                        .event = QG_EVENT_ACCESS_DENIED,
                                        .limit = kind,
                                        .token = actor->token,
                                        .remote = actor->address,
                                        .status = status},
                 "access denied: %s, scope %s, address %s", reason_of(verdict), name_of(scope),
                 *actor->address ? actor->address : "-");
}

/* Has it written down that somebody came with a token that does not open the route. */
static void note_refusal(const struct qg_service *service, const struct qg_route *route, const struct qg_actor *actor) {
    static const char *const methods[QG_METHOD_COUNT] = {[QG_GET] = "GET", [QG_POST] = "POST", [QG_DELETE] = "DELETE"};
    char what[QG_AUDIT_SUBJECT_ROOM];
    snprintf(what, sizeof what, "%s /%s", methods[route->method], route->pattern);
    qg_access_refused(service->access, actor, what);
}

bool qg_authorize(const struct qg_service *service, const char *authorization, const struct qg_route *route,
                  struct qg_request *request, struct qg_reply *reply) {
    int retry_after_s = 0;
    const unsigned scope = route->scope ? route->scope : QG_SCOPE_ADMIN; /* forgotten is admin */
    if (scope == QG_SCOPE_PUBLIC)
        return true;
    enum qg_verdict verdict =
        qg_access_judge(service->access, authorization, scope, qg_monotonic_clock(), &request->actor, &retry_after_s);
    if (verdict == QG_VERDICT_GRANTED)
        return true;
    reply_verdict(verdict, scope, retry_after_s, reply);
    log_denial(verdict, scope, &request->actor, reply->status);
    if (verdict == QG_VERDICT_WRONG_TOKEN || verdict == QG_VERDICT_OVER || verdict == QG_VERDICT_WRONG_SCOPE)
        note_refusal(service, route, &request->actor);
    return false;
}
