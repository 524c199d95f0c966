/* The table of routes. See routes.h. */
#include "server/routes.h"

#include <string.h>

#include "server/access_api.h"
#include "server/api.h"
#include "server/backup.h"
#include "server/documents.h"
#include "server/drawings.h"
#include "server/events.h"
#include "server/examples.h"
#include "server/files.h"
#include "server/metrics.h"
#include "server/webhook_api.h"

#define JSON "application/json"
#define EVENTS "text/event-stream"

static const struct qg_route routes[] = {
    {"", QG_GET, {"text/html"}, qg_get_page, false, QG_SCOPE_PUBLIC},
    {"assets/{}", QG_GET, {NULL}, qg_get_asset, false, QG_SCOPE_PUBLIC},
    {"healthz", QG_GET, {JSON}, qg_get_health, false, QG_SCOPE_PUBLIC},
    {"readyz", QG_GET, {JSON}, qg_get_readiness, false, QG_SCOPE_PUBLIC},
    {"metrics", QG_GET, {NULL}, qg_get_metrics, false, QG_SCOPE_READ},
    {"openapi.json", QG_GET, {JSON}, qg_get_openapi, false, QG_SCOPE_PUBLIC},
    {"v1/schemas/{}", QG_GET, {"application/schema+json", JSON}, qg_get_schema, false, QG_SCOPE_PUBLIC},
    {"v1/tokens", QG_GET, {JSON}, qg_list_tokens, false, QG_SCOPE_ADMIN},
    {"v1/tokens", QG_POST, {JSON}, qg_post_token, true, QG_SCOPE_ADMIN},
    {"v1/tokens/{}", QG_DELETE, {NULL}, qg_delete_token, false, QG_SCOPE_ADMIN},
    {"v1/webhooks", QG_GET, {JSON}, qg_list_webhooks, false, QG_SCOPE_ADMIN},
    {"v1/webhooks", QG_POST, {JSON}, qg_post_webhook, true, QG_SCOPE_ADMIN},
    {"v1/webhooks/{}", QG_GET, {JSON}, qg_get_webhook, false, QG_SCOPE_ADMIN},
    {"v1/webhooks/{}", QG_DELETE, {NULL}, qg_delete_webhook, false, QG_SCOPE_ADMIN},
    {"v1/webhooks/{}/deliveries", QG_GET, {JSON}, qg_list_deliveries, false, QG_SCOPE_ADMIN},
    {"v1/audit", QG_GET, {JSON}, qg_list_audit, false, QG_SCOPE_ADMIN},
    {"v1/backup", QG_GET, {NULL}, qg_get_backup, false, QG_SCOPE_ADMIN},
    {"v1/check", QG_POST, {JSON}, qg_check_document, true, QG_SCOPE_READ},
    {"v1/events", QG_GET, {EVENTS}, qg_follow_jobs, false, QG_SCOPE_READ},
    {"v1/jobs", QG_GET, {JSON}, qg_list_jobs, false, QG_SCOPE_READ},
    {"v1/jobs", QG_POST, {JSON}, qg_post_job, true, QG_SCOPE_SUBMIT},
    {"v1/jobs/{}", QG_GET, {JSON}, qg_get_job, false, QG_SCOPE_READ},
    {"v1/jobs/{}", QG_DELETE, {NULL}, qg_delete_job, false, QG_SCOPE_SUBMIT},
    {"v1/jobs/{}/cancel", QG_POST, {JSON}, qg_cancel_job, false, QG_SCOPE_SUBMIT},
    {"v1/jobs/{}/events", QG_GET, {EVENTS}, qg_follow_job, false, QG_SCOPE_READ},
    {"v1/jobs/{}/result", QG_GET, {JSON}, qg_get_result, false, QG_SCOPE_READ},
    {"v1/jobs/{}/frequency-response", QG_GET, {JSON, "text/csv"}, qg_get_frequency_response, false, QG_SCOPE_READ},
    {"v1/jobs/{}/evaluations", QG_GET, {"application/x-ndjson", "text/csv"}, qg_get_evaluations, false, QG_SCOPE_READ},
    {"v1/examples", QG_GET, {JSON}, qg_list_examples, false, QG_SCOPE_READ},
    {"v1/examples/{}", QG_GET, {JSON}, qg_get_example, false, QG_SCOPE_READ},
    {"v1/profile", QG_POST, {JSON, QG_DXF}, qg_post_profile, true, QG_SCOPE_READ},
    {"v1/jobs/{}/document", QG_GET, {JSON}, qg_get_document, false, QG_SCOPE_READ},
    {"v1/jobs/{}/field", QG_GET, {JSON}, qg_get_job_field, false, QG_SCOPE_READ},
    {"v1/jobs/{}/profile", QG_GET, {JSON, QG_DXF}, qg_get_job_profile, false, QG_SCOPE_READ},
};
enum { ROUTE_COUNT = sizeof routes / sizeof routes[0] };

size_t qg_route_count(void) {
    return ROUTE_COUNT;
}

const struct qg_route *qg_route_at(size_t index) {
    return &routes[index];
}

size_t qg_route_index(const struct qg_route *route) {
    return (size_t)(route - routes);
}

/* True when the target has the pattern's segments; *parameter is the one at {}. */
static bool fits(const char *pattern, const struct qg_target *target, const char **parameter) {
    *parameter = NULL;
    for (size_t i = 0; i < target->segment_count; i++) {
        size_t length = strcspn(pattern, "/");
        if (length == 2 && memcmp(pattern, "{}", 2) == 0)
            *parameter = target->segment[i];
        else if (length == 0 || strlen(target->segment[i]) != length ||
                 memcmp(pattern, target->segment[i], length) != 0)
            return false;
        pattern += length;
        pattern += *pattern == '/';
    }
    return !*pattern;
}

static const char *const method_names[QG_METHOD_COUNT] = {"GET, HEAD", "POST", "DELETE"};

static bool is_method(enum qg_method method, const char *name) {
    switch (method) {
    case QG_GET:
        return strcmp(name, "GET") == 0 || strcmp(name, "HEAD") == 0;
    default:
        return strcmp(name, method_names[method]) == 0;
    }
}

const struct qg_route *qg_route_find(const struct qg_target *target, const char *method, const char **parameter,
                                     char allow[QG_ALLOW_ROOM]) {
    allow[0] = '\0';
    for (size_t i = 0; i < ROUTE_COUNT; i++) {
        if (!fits(routes[i].pattern, target, parameter))
            continue;
        if (is_method(routes[i].method, method))
            return &routes[i];
        if (*allow)
            strcat(allow, ", ");
        strcat(allow, method_names[routes[i].method]);
    }
    return NULL;
}
