/* The access log: an entry for each request that was answered, when the setting access-log is on.
 *
 * Logged are the route, not the target as it was sent, and the id of the job that it names: what strangers write into targets
 * (and people by mistake: a token in a query) stays out.
 */
#ifndef QG_SERVER_HTTP_ACCESS_LOG_H
#define QG_SERVER_HTTP_ACCESS_LOG_H

#include "server/http/exchange.h"
#include "server/http/routes.h"

/* A request that is over. */
struct qg_visit {
    const struct qg_request *request; /* its actor has the address */
    const struct qg_route *route;     /* NULL: none was found */
    const char *method;               /* as sent, perhaps cut */
    int status;                       /* 0: its client left before there was an answer */
    bool whole;                       /* the answer was sent to its end */
    int64_t bytes;                    /* of the answer's body */
    int64_t duration_us;              /* from the request line to the end of the answer */
};

/* Logs it. Threads: any. */
void qg_log_visit(const struct qg_visit *visit);

#endif
