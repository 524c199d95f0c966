/* What the daemon counts for Prometheus: replies, jobs that ended, and attempts at telling webhooks. Written out by calls/metrics.c.
 */
#ifndef QG_SERVER_WORK_METRICS_H
#define QG_SERVER_WORK_METRICS_H

#include <stdatomic.h>

#include "server/store/store.h"

enum { QG_STATUS_MIN = 100, QG_STATUS_MAX = 599, QG_STATUSES = QG_STATUS_MAX - QG_STATUS_MIN + 1, QG_BUCKETS = 10 };

/* Durations, counted by size: those up to each bound, and, last, those beyond all. */
struct qg_histogram {
    atomic_ullong count[QG_BUCKETS + 1];
    atomic_ullong sum; /* in the unit of the durations */
};

/* Upper bounds in seconds, of replies and of jobs. */
extern const double qg_reply_bounds[QG_BUCKETS], qg_job_bounds[QG_BUCKETS];

/* What is counted for one route. */
struct qg_route_count {
    atomic_ullong replies[QG_STATUSES];
    struct qg_histogram durations; /* us */
};

/* How an attempt to deliver a webhook's message can end. */
enum qg_attempt_end {
    QG_ATTEMPT_DELIVERED,
    QG_ATTEMPT_FAILED,   /* there will be another one */
    QG_ATTEMPT_GIVEN_UP, /* there will be none */
    QG_ATTEMPT_ENDS
};

struct qg_metrics {
    double started;                           /* s since 1970 UTC */
    struct qg_histogram jobs[QG_STATE_COUNT]; /* ms; of the final states */
    atomic_ullong attempts[QG_ATTEMPT_ENDS];
    size_t rows; /* routes and one, which stands for no route */
    struct qg_route_count row[];
};

/* Counters at zero for so many routes; NULL when memory is short. */
struct qg_metrics *qg_metrics_create(size_t routes);

/* NULL is allowed. */
void qg_metrics_destroy(struct qg_metrics *metrics);

/* Counts a reply to a request for the route at this place in its table (the table's length: none was found), and the time from
 * the request line to the beginning of the answer, in microseconds. Threads: any. */
void qg_metrics_count(struct qg_metrics *metrics, size_t route, int status, int64_t duration);

/* Counts a job that has come to a final state, and the time since it began to run, in milliseconds. Threads: any. */
void qg_metrics_count_job(struct qg_metrics *metrics, enum qg_state state, int64_t duration);

/* Counts an attempt to deliver a webhook's message. Threads: any. */
void qg_metrics_count_attempt(struct qg_metrics *metrics, enum qg_attempt_end end);

#endif
