/* Which target and method find which handler, and what Allow says otherwise. */
#include "tests/server/support.h"

#include <string.h>

#include "server/calls/access.h"
#include "server/calls/drawings.h"
#include "server/calls/files.h"
#include "server/calls/jobs.h"
#include "server/calls/table.h"
#include "server/calls/webhooks.h"

static const struct qg_route *find(const char *raw, const char *method, const char **parameter, char *allow) {
    static struct qg_target target;
    assert_null(qg_target_parse(&target, raw));
    return qg_route_find(&qg_calls, &target, method, parameter, allow);
}

static void finds_every_call(void **state) {
    (void)state;
    static const struct {
        const char *method, *target;
        qg_handler *handler;
        const char *parameter;
        unsigned scope;
    } cases[] = {
        {"GET", "/", qg_get_page, NULL, QG_SCOPE_PUBLIC},
        {"HEAD", "/", qg_get_page, NULL, QG_SCOPE_PUBLIC},
        {"GET", "/assets/page.js", qg_get_asset, "page.js", QG_SCOPE_PUBLIC},
        {"GET", "/healthz", qg_get_health, NULL, QG_SCOPE_PUBLIC},
        {"GET", "/v1/schemas/job.schema.json", qg_get_schema, "job.schema.json", QG_SCOPE_PUBLIC},
        {"GET", "/v1/tokens", qg_list_tokens, NULL, QG_SCOPE_ADMIN},
        {"POST", "/v1/tokens", qg_post_token, NULL, QG_SCOPE_ADMIN},
        {"DELETE", "/v1/tokens/x1", qg_delete_token, "x1", QG_SCOPE_ADMIN},
        {"GET", "/v1/webhooks", qg_list_webhooks, NULL, QG_SCOPE_ADMIN},
        {"POST", "/v1/webhooks", qg_post_webhook, NULL, QG_SCOPE_ADMIN},
        {"GET", "/v1/webhooks/x1", qg_get_webhook, "x1", QG_SCOPE_ADMIN},
        {"DELETE", "/v1/webhooks/x1", qg_delete_webhook, "x1", QG_SCOPE_ADMIN},
        {"GET", "/v1/webhooks/x1/deliveries", qg_list_deliveries, "x1", QG_SCOPE_ADMIN},
        {"GET", "/v1/audit", qg_list_audit, NULL, QG_SCOPE_ADMIN},
        {"GET", "/v1/jobs", qg_list_jobs, NULL, QG_SCOPE_READ},
        {"HEAD", "/v1/jobs?limit=2", qg_list_jobs, NULL, QG_SCOPE_READ},
        {"POST", "/v1/jobs", qg_post_job, NULL, QG_SCOPE_SUBMIT},
        {"GET", "/v1/jobs/x1", qg_get_job, "x1", QG_SCOPE_READ},
        {"DELETE", "/v1/jobs/x1", qg_delete_job, "x1", QG_SCOPE_SUBMIT},
        {"POST", "/v1/jobs/x1/cancel", qg_cancel_job, "x1", QG_SCOPE_SUBMIT},
        {"GET", "/v1/jobs/x1/result", qg_get_result, "x1", QG_SCOPE_READ},
        {"GET", "/v1/jobs/x1/frequency-response", qg_get_frequency_response, "x1", QG_SCOPE_READ},
        {"GET", "/v1/jobs/x1/evaluations", qg_get_evaluations, "x1", QG_SCOPE_READ},
        {"GET", "/v1/jobs/x1/profile?design=reference", qg_get_job_profile, "x1", QG_SCOPE_READ},
        {"GET", "/v1/jobs/x1/field?load_case=0", qg_get_job_field, "x1", QG_SCOPE_READ},
        {"POST", "/v1/profile", qg_post_profile, NULL, QG_SCOPE_READ},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char allow[QG_ALLOW_ROOM];
        const char *parameter;
        const struct qg_route *route = find(cases[i].target, cases[i].method, &parameter, allow);
        if (!route || route->handler != cases[i].handler)
            fail_msg("%s %s went elsewhere", cases[i].method, cases[i].target);
        assert_int_equal(route->scope, cases[i].scope);
        if (cases[i].parameter)
            assert_string_equal(parameter, cases[i].parameter);
        else
            assert_null(parameter);
    }
}

static void says_what_is_allowed(void **state) {
    (void)state;
    static const struct {
        const char *method, *target, *allow;
    } cases[] = {
        {"PUT", "/v1/jobs", "GET, HEAD, POST"},
        {"POST", "/v1/jobs/x1", "GET, HEAD, DELETE"},
        {"GET", "/v1/jobs/x1/cancel", "POST"},
        {"DELETE", "/", "GET, HEAD"},
        {"get", "/healthz", "GET, HEAD"},
        {"GET", "/v1", ""},
        {"GET", "/v1/jobs/x1/y", ""},
        {"GET", "/v1/jobs/x1/result/z", ""},
        {"GET", "/healthz/x", ""},
        {"GET", "/V1/jobs", ""},
        {"GET", "/v1/{}", ""},
        {"GET", "/assets", ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char allow[QG_ALLOW_ROOM];
        const char *parameter;
        if (find(cases[i].target, cases[i].method, &parameter, allow))
            fail_msg("%s %s was answered", cases[i].method, cases[i].target);
        assert_string_equal(allow, cases[i].allow);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_every_call),
        cmocka_unit_test(says_what_is_allowed),
    };
    return cmocka_run_group_tests_name("routes", tests, NULL, NULL);
}
