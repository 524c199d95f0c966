/* Members of JSON objects as the server's answers have them: texts and times that may be null.
 */
#ifndef QG_SERVER_BASE_MEMBER_H
#define QG_SERVER_BASE_MEMBER_H

#include "schema/text.h"

/* Writes a string; NULL becomes null. */
void qg_member_text(struct qg_text *text, const char *name, const char *value);

/* Writes a time in ms since 1970 UTC as RFC 3339; 0 becomes null. */
void qg_member_time(struct qg_text *text, const char *name, int64_t milliseconds);

#endif
