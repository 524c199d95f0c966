/* Handlers of the calls under /v1/jobs, and of /healthz. What each answers is in jobs.c beside it.
 */
#ifndef QG_SERVER_CALLS_JOBS_H
#define QG_SERVER_CALLS_JOBS_H

#include "server/http/exchange.h"

qg_handler qg_get_health;             /* GET /healthz */
qg_handler qg_get_readiness;          /* GET /readyz */
qg_handler qg_post_job;               /* POST /v1/jobs */
qg_handler qg_list_jobs;              /* GET /v1/jobs */
qg_handler qg_get_job;                /* GET /v1/jobs/{id} */
qg_handler qg_delete_job;             /* DELETE /v1/jobs/{id} */
qg_handler qg_cancel_job;             /* POST /v1/jobs/{id}/cancel */
qg_handler qg_get_result;             /* GET /v1/jobs/{id}/result */
qg_handler qg_get_frequency_response; /* GET /v1/jobs/{id}/frequency-response */
qg_handler qg_get_evaluations;        /* GET /v1/jobs/{id}/evaluations */

#endif
