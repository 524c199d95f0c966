/* Handlers of the calls under /v1/webhooks, all for admin tokens. What each answers is in webhooks.c beside it.
 */
#ifndef QG_SERVER_CALLS_WEBHOOKS_H
#define QG_SERVER_CALLS_WEBHOOKS_H

#include "server/http/exchange.h"

qg_handler qg_list_webhooks;   /* GET /v1/webhooks */
qg_handler qg_post_webhook;    /* POST /v1/webhooks */
qg_handler qg_get_webhook;     /* GET /v1/webhooks/{id} */
qg_handler qg_delete_webhook;  /* DELETE /v1/webhooks/{id} */
qg_handler qg_list_deliveries; /* GET /v1/webhooks/{id}/deliveries */

#endif
