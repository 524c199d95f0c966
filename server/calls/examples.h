/* The example documents that are installed beside the schemas.
 */
#ifndef QG_SERVER_CALLS_EXAMPLES_H
#define QG_SERVER_CALLS_EXAMPLES_H

#include "server/http/exchange.h"

qg_handler qg_list_examples; /* GET /v1/examples */
qg_handler qg_get_example;   /* GET /v1/examples/{name} */

#endif
