/* The step before every handler: who may pass.
 */
#ifndef QG_SERVER_HTTP_AUTHORIZE_H
#define QG_SERVER_HTTP_AUTHORIZE_H

#include "server/http/exchange.h"

/* Lets a request pass that may use a route of this scope (0 counts as admin), and fills in request->actor's token, name and
 * scopes; else false, and the reply says why: 401, 403 or 429. authorization is the request's field, NULL without one. */
bool qg_authorize(const struct qg_service *service, const char *authorization, unsigned scope,
                  struct qg_request *request, struct qg_reply *reply);

#endif
