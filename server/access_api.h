/* Handlers of the calls under /v1/tokens and of /v1/audit, all for admin tokens; and of the step before every handler, that
 * asks who may pass. What each answers is in access_api.c beside it.
 */
#ifndef QG_SERVER_ACCESS_API_H
#define QG_SERVER_ACCESS_API_H

#include "server/exchange.h"

qg_handler qg_list_tokens;  /* GET /v1/tokens */
qg_handler qg_post_token;   /* POST /v1/tokens */
qg_handler qg_delete_token; /* DELETE /v1/tokens/{id} */
qg_handler qg_list_audit;   /* GET /v1/audit */

/* Lets a request pass that may use a route of this scope (0 counts as admin), and fills in request->actor's token, name and
 * scopes; else false, and the reply says why: 401, 403 or 429. authorization is the request's field, NULL without one. */
bool qg_authorize(const struct qg_service *service, const char *authorization, unsigned scope,
                  struct qg_request *request, struct qg_reply *reply);

#endif
