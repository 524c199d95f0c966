/* Documents as they come and go: reading a request's body, checking it.
 */
#ifndef QG_SERVER_DOCUMENTS_H
#define QG_SERVER_DOCUMENTS_H

#include "server/exchange.h"

/* Reads the body as a job document. Returns a job to be freed by the caller; NULL and a problem with every fault as the
 * reply when it is none. warnings (may be NULL) is appended to. */
struct qg_job *qg_request_document(const struct qg_request *request, struct qg_notes *warnings, struct qg_reply *reply);

qg_handler qg_check_document; /* POST /v1/check */

#endif
