/* Everything that can be asked for: pattern, method, what it answers in, who answers, and the scope that it takes.
 */
#ifndef QG_SERVER_CALLS_TABLE_H
#define QG_SERVER_CALLS_TABLE_H

#include "server/http/routes.h"

/* All calls of the daemon. */
extern const struct qg_routes qg_calls;

#endif
