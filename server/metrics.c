/* Figures for Prometheus. See metrics.h.
 *
 * GET /metrics             text format 0.0.4. Counters (_total) begin with the daemon; what is read from the database is of
 *                          the jobs that are in it, so it goes down when jobs are deleted.
 */
#include "server/metrics.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "server/routes.h"

enum { STATUS_MIN = 100, STATUS_MAX = 599, STATUSES = STATUS_MAX - STATUS_MIN + 1 };

struct qg_metrics {
    size_t rows;                       /* routes and one */
    atomic_ullong replies[][STATUSES]; /* by route, the last one for no route, and status */
};

struct qg_metrics *qg_metrics_create(void) {
    size_t rows = qg_route_count() + 1;
    struct qg_metrics *metrics = calloc(1, sizeof *metrics + rows * sizeof metrics->replies[0]);
    if (metrics)
        metrics->rows = rows;
    return metrics;
}

void qg_metrics_destroy(struct qg_metrics *metrics) {
    free(metrics);
}

void qg_metrics_count(struct qg_metrics *metrics, const struct qg_route *route, int status) {
    assert(status >= STATUS_MIN && status <= STATUS_MAX);
    size_t place = route ? qg_route_index(route) : metrics->rows - 1;
    atomic_fetch_add_explicit(&metrics->replies[place][status - STATUS_MIN], 1, memory_order_relaxed);
}

static void write_head(struct qg_text *text, const char *name, const char *type, const char *help) {
    qg_text_format(text, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void write_value(struct qg_text *text, const char *name, double value) {
    char number[QG_NUMBER_ROOM];
    qg_number_print(number, value);
    qg_text_format(text, "%s %s\n", name, number);
}

static void write_requests(struct qg_text *text, struct qg_metrics *metrics) {
    static const char *const methods[QG_METHOD_COUNT] = {"GET", "POST", "DELETE"};
    write_head(text, "quietgear_http_requests_total", "counter", "Requests answered, by route and status.");
    for (size_t i = 0; i < metrics->rows; i++)
        for (int status = 0; status < STATUSES; status++) {
            unsigned long long count = atomic_load_explicit(&metrics->replies[i][status], memory_order_relaxed);
            const struct qg_route *route = i + 1 < metrics->rows ? qg_route_at(i) : NULL;
            if (count > 0)
                qg_text_format(text, "quietgear_http_requests_total{method=\"%s\",route=\"%s%s\",status=\"%d\"} %llu\n",
                               route ? methods[route->method] : "", route ? "/" : "", route ? route->pattern : "",
                               status + STATUS_MIN, count);
        }
}

static void write_jobs(struct qg_text *text, const struct qg_statistics *statistics) {
    write_head(text, "quietgear_jobs", "gauge", "Jobs in the database, by state; queued is the queue's depth.");
    for (int i = 0; i < QG_STATE_COUNT; i++)
        qg_text_format(text, "quietgear_jobs{state=\"%s\"} %lld\n", qg_state_name((enum qg_state)i),
                       (long long)statistics->jobs[i]);
    write_head(text, "quietgear_job_duration_seconds", "gauge",
               "Mean time from start to end of the jobs in the database, by state.");
    for (int i = QG_STATE_SUCCEEDED; i < QG_STATE_COUNT; i++)
        if (statistics->started[i] > 0) {
            char number[QG_NUMBER_ROOM];
            qg_number_print(number, (double)statistics->run_ms[i] / 1000 / (double)statistics->started[i]);
            qg_text_format(text, "quietgear_job_duration_seconds{state=\"%s\"} %s\n", qg_state_name((enum qg_state)i),
                           number);
        }
}

static void write_database(struct qg_text *text, const struct qg_statistics *statistics) {
    write_head(text, "quietgear_evaluations_total", "counter", "Evaluations computed and logged since the start.");
    write_value(text, "quietgear_evaluations_total", (double)statistics->evaluations);
    write_head(text, "quietgear_database_bytes", "gauge", "Size of the database file.");
    write_value(text, "quietgear_database_bytes", (double)statistics->database_bytes);
    write_head(text, "quietgear_database_wal_bytes", "gauge", "Size of the database's write-ahead log.");
    write_value(text, "quietgear_database_wal_bytes", (double)statistics->wal_bytes);
}

void qg_get_metrics(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_statistics statistics;
    if (!qg_request_has_no_query(request, reply))
        return;
    enum qg_store_status status = qg_store_statistics(service->store, &statistics);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return;
    }
    write_jobs(&reply->body, &statistics);
    write_database(&reply->body, &statistics);
    write_requests(&reply->body, service->metrics);
    reply->status = 200;
    reply->media_type = "text/plain; version=0.0.4; charset=utf-8";
    qg_reply_header(reply, "Cache-Control", "no-store");
}
