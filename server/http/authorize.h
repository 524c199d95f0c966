/* The step before every handler: who may pass.
 */
#ifndef QG_SERVER_HTTP_AUTHORIZE_H
#define QG_SERVER_HTTP_AUTHORIZE_H

#include "server/http/routes.h"

/* Lets a request pass that may use the route, and fills in request->actor's token, name and scopes; else false, and the reply
 * says why: 401, 403 or 429. A token that does not open the route is also a matter for the audit log. authorization is the
 * request's field, NULL without one. */
bool qg_authorize(const struct qg_service *service, const char *authorization, const struct qg_route *route,
                  struct qg_request *request, struct qg_reply *reply);

#endif
