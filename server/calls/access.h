/* Handlers of the calls under /v1/tokens and of /v1/audit, all for admin tokens. What each answers is in access.c beside it.
 */
#ifndef QG_SERVER_CALLS_ACCESS_H
#define QG_SERVER_CALLS_ACCESS_H

#include "server/http/exchange.h"

qg_handler qg_list_tokens;  /* GET /v1/tokens */
qg_handler qg_post_token;   /* POST /v1/tokens */
qg_handler qg_delete_token; /* DELETE /v1/tokens/{id} */
qg_handler qg_list_audit;   /* GET /v1/audit */

#endif
