/* The step before every handler. See authorize.h. */
#include "server/http/authorize.h"

#include "server/base/clock.h"

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

bool qg_authorize(const struct qg_service *service, const char *authorization, unsigned scope,
                  struct qg_request *request, struct qg_reply *reply) {
    int retry_after_s = 0;
    if (scope == QG_SCOPE_PUBLIC)
        return true;
    if (scope == 0)
        scope = QG_SCOPE_ADMIN;
    enum qg_verdict verdict =
        qg_access_judge(service->access, authorization, scope, qg_monotonic_clock(), &request->actor, &retry_after_s);
    if (verdict != QG_VERDICT_GRANTED)
        reply_verdict(verdict, scope, retry_after_s, reply);
    return verdict == QG_VERDICT_GRANTED;
}
