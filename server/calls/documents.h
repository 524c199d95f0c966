/* Documents as they come and go: reading a request's body, checking it, what a job was submitted with.
 */
#ifndef QG_SERVER_CALLS_DOCUMENTS_H
#define QG_SERVER_CALLS_DOCUMENTS_H

#include "server/http/exchange.h"

/* Reads the body as a job document. Returns a job to be freed by the caller; NULL and a problem with every fault as the
 * reply when it is none. warnings (may be NULL) is appended to. */
struct qg_job *qg_request_document(const struct qg_request *request, struct qg_notes *warnings, struct qg_reply *reply);

/* Likewise of a document that may lack its kind: a design (schema/drawing.h). */
struct qg_job *qg_request_design(const struct qg_request *request, struct qg_reply *reply);

/* Reads a text as a job document. On QG_DOCUMENT_OK *out is to be freed by the caller, else NULL. */
enum qg_document_status qg_text_document(const struct qg_text *text, struct qg_job **out);

qg_handler qg_check_document; /* POST /v1/check */
qg_handler qg_get_document;   /* GET /v1/jobs/{id}/document */

/* What a job will take on this server. */
struct qg_estimate qg_estimate_job(const struct qg_service *service, const struct qg_job *job);

/* True when the settings max-job-cost and max-job-memory allow a job of that estimate; else a problem is the reply. */
bool qg_job_is_affordable(const struct qg_service *service, const struct qg_job *job,
                          const struct qg_estimate *estimate, struct qg_reply *reply);

#endif
