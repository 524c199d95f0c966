/* Figures for Prometheus: what was asked over HTTP since the start, and the state of queue and database.
 */
#ifndef QG_SERVER_METRICS_H
#define QG_SERVER_METRICS_H

#include "server/exchange.h"

struct qg_metrics;
struct qg_route;

/* Counters at zero; NULL when memory is short. */
struct qg_metrics *qg_metrics_create(void);

/* NULL is allowed. */
void qg_metrics_destroy(struct qg_metrics *metrics);

/* Counts a reply to a request for the route (NULL: none was found), and the time from the request line to the beginning of the
 * answer, in microseconds. Threads: any. */
void qg_metrics_count(struct qg_metrics *metrics, const struct qg_route *route, int status, int64_t duration);

/* Counts a job that has come to a final state, and the time since it began to run, in milliseconds. Threads: any. */
void qg_metrics_count_job(struct qg_metrics *metrics, enum qg_state state, int64_t duration);

qg_handler qg_get_metrics; /* GET /metrics */

#endif
