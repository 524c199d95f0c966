/* Counting for Prometheus. See metrics.h. */
#include "server/work/metrics.h"

#include <assert.h>
#include <stdlib.h>

#include "server/base/clock.h"

const double qg_reply_bounds[QG_BUCKETS] = {0.001, 0.0025, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2, 10};
const double qg_job_bounds[QG_BUCKETS] = {0.5, 1, 2, 5, 15, 60, 300, 1800, 10800, 86400};

static void observe(struct qg_histogram *histogram, const double *bounds, double seconds, int64_t duration) {
    int place = 0;
    while (place < QG_BUCKETS && seconds > bounds[place])
        place++;
    atomic_fetch_add_explicit(&histogram->count[place], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&histogram->sum, (unsigned long long)duration, memory_order_relaxed);
}

struct qg_metrics *qg_metrics_create(size_t routes) {
    size_t rows = routes + 1;
    struct qg_metrics *metrics = calloc(1, sizeof *metrics + rows * sizeof metrics->row[0]);
    if (!metrics)
        return NULL;
    metrics->rows = rows;
    metrics->started = (double)qg_wall_clock() / 1000;
    return metrics;
}

void qg_metrics_destroy(struct qg_metrics *metrics) {
    free(metrics);
}

void qg_metrics_count(struct qg_metrics *metrics, size_t route, int status, int64_t duration) {
    assert(status >= QG_STATUS_MIN && status <= QG_STATUS_MAX && route < metrics->rows);
    struct qg_route_count *row = &metrics->row[route];
    atomic_fetch_add_explicit(&row->replies[status - QG_STATUS_MIN], 1, memory_order_relaxed);
    observe(&row->durations, qg_reply_bounds, (double)duration / 1e6, duration);
}

void qg_metrics_count_job(struct qg_metrics *metrics, enum qg_state state, int64_t duration) {
    assert(qg_state_is_final(state));
    duration = duration > 0 ? duration : 0; /* clocks are set back at times */
    observe(&metrics->jobs[state], qg_job_bounds, (double)duration / 1000, duration);
}

void qg_metrics_count_attempt(struct qg_metrics *metrics, enum qg_attempt_end end) {
    atomic_fetch_add_explicit(&metrics->attempts[end], 1, memory_order_relaxed);
}
