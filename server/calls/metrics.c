/* Figures for Prometheus. See metrics.h. */
#include "server/calls/metrics.h"

#include <config.h>
#include <dirent.h>
#include <stdio.h>
#include <unistd.h>

#include "server/http/routes.h"
#include "server/http/tls.h"
#include "server/work/metrics.h"

static void write_head(struct qg_text *text, const char *name, const char *type, const char *help) {
    qg_text_format(text, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void write_value(struct qg_text *text, const char *name, double value) {
    char number[QG_NUMBER_ROOM];
    qg_number_print(number, value);
    qg_text_format(text, "%s %s\n", name, number);
}

/* Writes the samples of one histogram; labels ("route=\"/x\"") may be empty. scale: durations a second. */
static void write_histogram(struct qg_text *text, const char *name, const char *labels, struct qg_histogram *histogram,
                            const double *bounds, double scale) {
    unsigned long long total = 0;
    char number[QG_NUMBER_ROOM];
    const char *comma = *labels ? "," : "";
    for (int i = 0; i <= QG_BUCKETS; i++) {
        total += atomic_load_explicit(&histogram->count[i], memory_order_relaxed);
        if (i < QG_BUCKETS)
            qg_number_print(number, bounds[i]);
        qg_text_format(text, "%s_bucket{%s%sle=\"%s\"} %llu\n", name, labels, comma, i < QG_BUCKETS ? number : "+Inf",
                       total);
    }
    qg_number_print(number, (double)atomic_load_explicit(&histogram->sum, memory_order_relaxed) / scale);
    qg_text_format(text, "%s_sum{%s} %s\n%s_count{%s} %llu\n", name, labels, number, name, labels, total);
}

static bool is_empty(struct qg_histogram *histogram) {
    for (int i = 0; i <= QG_BUCKETS; i++)
        if (atomic_load_explicit(&histogram->count[i], memory_order_relaxed) > 0)
            return false;
    return true;
}

/* The labels of a row; room for 160 bytes. */
static void label_row(const struct qg_routes *routes, size_t place, char *out) {
    static const char *const methods[QG_METHOD_COUNT] = {"GET", "POST", "DELETE"};
    const struct qg_route *route = place < routes->count ? &routes->route[place] : NULL;
    snprintf(out, 160, "method=\"%s\",route=\"%s%s\"", route ? methods[route->method] : "", route ? "/" : "",
             route ? route->pattern : "");
}

static void write_requests(struct qg_text *text, struct qg_metrics *metrics, const struct qg_routes *routes) {
    static const char name[] = "quietgear_http_request_duration_seconds";
    char labels[160];
    write_head(text, "quietgear_http_requests_total", "counter", "Requests answered, by route and status.");
    for (size_t i = 0; i < metrics->rows; i++)
        for (int status = 0; status < QG_STATUSES; status++) {
            unsigned long long count = atomic_load_explicit(&metrics->row[i].replies[status], memory_order_relaxed);
            label_row(routes, i, labels);
            if (count > 0)
                qg_text_format(text, "quietgear_http_requests_total{%s,status=\"%d\"} %llu\n", labels,
                               status + QG_STATUS_MIN, count);
        }
    write_head(text, name, "histogram", "From the request line to the beginning of the answer; long polls included.");
    for (size_t i = 0; i < metrics->rows; i++) {
        label_row(routes, i, labels);
        if (!is_empty(&metrics->row[i].durations))
            write_histogram(text, name, labels, &metrics->row[i].durations, qg_reply_bounds, 1e6);
    }
}

static void write_jobs(struct qg_text *text, struct qg_metrics *metrics, const struct qg_statistics *statistics) {
    static const char name[] = "quietgear_job_duration_seconds";
    write_head(text, "quietgear_jobs", "gauge", "Jobs in the database, by state; queued is the queue's depth.");
    for (int i = 0; i < QG_STATE_COUNT; i++)
        qg_text_format(text, "quietgear_jobs{state=\"%s\"} %lld\n", qg_state_name((enum qg_state)i),
                       (long long)statistics->jobs[i]);
    write_head(text, name, "histogram",
               "From the first start of jobs that have ended since the daemon's start, by state.");
    for (int i = QG_STATE_SUCCEEDED; i < QG_STATE_COUNT; i++) {
        char label[40];
        snprintf(label, sizeof label, "state=\"%s\"", qg_state_name((enum qg_state)i));
        write_histogram(text, name, label, &metrics->jobs[i], qg_job_bounds, 1000);
    }
}

static void write_attempts(struct qg_text *text, struct qg_metrics *metrics) {
    static const char *const ends[QG_ATTEMPT_ENDS] = {"delivered", "failed", "given_up"};
    static const char name[] = "quietgear_webhook_attempts_total";
    write_head(text, name, "counter",
               "Attempts to deliver a webhook's message, by outcome: delivered, failed (repeated later), given_up.");
    for (size_t i = 0; i < QG_ATTEMPT_ENDS; i++)
        qg_text_format(text, "%s{outcome=\"%s\"} %llu\n", name, ends[i],
                       atomic_load_explicit(&metrics->attempts[i], memory_order_relaxed));
}

/* A metric of one sample. */
static void write_metric(struct qg_text *text, const char *name, const char *type, const char *help, double value) {
    write_head(text, name, type, help);
    write_value(text, name, value);
}

static void write_database(struct qg_text *text, const struct qg_statistics *statistics) {
    write_metric(text, "quietgear_evaluations_total", "counter", "Evaluations computed and logged since the start.",
                 (double)statistics->evaluations);
    write_metric(text, "quietgear_database_bytes", "gauge", "Size of the database file.",
                 (double)statistics->database_bytes);
    write_metric(text, "quietgear_database_wal_bytes", "gauge", "Size of the database's write-ahead log.",
                 (double)statistics->wal_bytes);
    write_metric(text, "quietgear_database_writable", "gauge",
                 "0 from a failed write to the next that succeeds, else 1.", statistics->writable);
}

static double resident_bytes(void) {
    long pages = 0;
    FILE *stream = fopen("/proc/self/statm", "re");
    if (stream && fscanf(stream, "%*d %ld", &pages) != 1)
        pages = 0;
    if (stream)
        fclose(stream);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static double open_descriptors(void) {
    int count = 0;
    DIR *directory = opendir("/proc/self/fd");
    for (; directory && readdir(directory); count++)
        ;
    if (directory)
        closedir(directory);
    return count > 3 ? count - 3 : 0; /* . and .. and the directory itself */
}

static void write_process(struct qg_text *text, const struct qg_metrics *metrics, struct qg_tls *tls) {
    write_head(text, "quietgear_build_info", "gauge", "What runs; always 1.");
    qg_text_format(text, "quietgear_build_info{version=\"%s\"} 1\n", PACKAGE_VERSION);
    write_metric(text, "process_start_time_seconds", "gauge", "When the daemon started, since 1970 UTC.",
                 metrics->started);
    write_metric(text, "process_resident_memory_bytes", "gauge", "Memory in use.", resident_bytes());
    if (tls)
        write_metric(text, "quietgear_tls_certificate_expiry_seconds", "gauge",
                     "When the TLS certificate in use expires, since 1970 UTC.",
                     (double)qg_tls_valid_until(tls) / 1000);
    write_metric(text, "process_open_fds", "gauge", "Open files and connections.", open_descriptors());
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
    write_process(&reply->body, service->metrics, service->tls);
    write_jobs(&reply->body, service->metrics, &statistics);
    write_database(&reply->body, &statistics);
    write_attempts(&reply->body, service->metrics);
    write_requests(&reply->body, service->metrics, service->routes);
    reply->status = 200;
    reply->media_type = "text/plain; version=0.0.4; charset=utf-8";
    qg_reply_header(reply, "Cache-Control", "no-store");
}
