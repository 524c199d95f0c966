/* Server-Sent Events: jobs as they change, pushed.
 */
#ifndef QG_SERVER_CALLS_EVENTS_H
#define QG_SERVER_CALLS_EVENTS_H

#include "server/http/exchange.h"

qg_handler qg_follow_job;  /* GET /v1/jobs/{id}/events */
qg_handler qg_follow_jobs; /* GET /v1/events */

#endif
