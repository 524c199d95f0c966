/* Handlers that serve files from disk: the page, its assets, the JSON Schemas. Names are single path segments of letters,
 * digits, '.', '_' and '-' that do not begin with a dot; links are not followed.
 */
#ifndef QG_SERVER_CALLS_FILES_H
#define QG_SERVER_CALLS_FILES_H

#include "server/http/exchange.h"

qg_handler qg_get_page;    /* GET / : index.html of the web directory */
qg_handler qg_get_asset;   /* GET /assets/{file} : .css, .js and .svg of the web directory */
qg_handler qg_get_openapi; /* GET /openapi.json : of the schema directory */
qg_handler qg_get_schema;  /* GET /v1/schemas/{file} : .json of the schema directory */

/* Appends a regular file of a directory to the text. False when there is none of that name, the name has other characters
 * than letters, digits, '.', '_' and '-' or begins with a dot, the file has more than 4 MiB, or memory is short. */
bool qg_served_file(const char *directory, const char *name, struct qg_text *text);

#endif
