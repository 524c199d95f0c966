/* Figures for Prometheus: what was asked over HTTP since the start, and the state of queue and database.
 *
 * GET /metrics             text format 0.0.4. Counters (_total) begin with the daemon; what is read from the database is of
 *                          the jobs that are in it, so it goes down when jobs are deleted.
 */
#ifndef QG_SERVER_CALLS_METRICS_H
#define QG_SERVER_CALLS_METRICS_H

#include "server/http/exchange.h"

qg_handler qg_get_metrics; /* GET /metrics */

#endif
