/* Pages of other origins: which of them a browser may let read our answers (the CORS protocol of the Fetch standard).
 *
 * Off unless origins are listed. Tokens come in the Authorization field, never in cookies, so credentials in the sense of
 * the standard are not allowed.
 */
#ifndef QG_SERVER_HTTP_CORS_H
#define QG_SERVER_HTTP_CORS_H

#include <stdbool.h>

/* True for a list of origins as browsers send them ("https://plm.example.com https://tools.example.com:8443"), with blanks
 * or commas between; "" is none. No paths, no wildcards. */
bool qg_cors_is_list(const char *origins);

/* True when the value of an Origin field (NULL: absent) is in the list. */
bool qg_cors_allows(const char *origins, const char *origin);

#endif
