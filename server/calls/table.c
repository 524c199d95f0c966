/* The table of calls. See table.h. */
#include "server/calls/table.h"

#include "server/calls/access.h"
#include "server/calls/backup.h"
#include "server/calls/documents.h"
#include "server/calls/drawings.h"
#include "server/calls/events.h"
#include "server/calls/examples.h"
#include "server/calls/files.h"
#include "server/calls/jobs.h"
#include "server/calls/metrics.h"
#include "server/calls/webhooks.h"

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

const struct qg_routes qg_calls = {.route = routes, .count = sizeof routes / sizeof routes[0]};
