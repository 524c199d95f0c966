/* Members of JSON objects. See member.h. */
#include "server/base/member.h"

#include "server/base/clock.h"

void qg_member_text(struct qg_text *text, const char *name, const char *value) {
    qg_json_name(text, name);
    if (value)
        qg_json_string(text, value);
    else
        qg_json_null(text);
}

void qg_member_time(struct qg_text *text, const char *name, int64_t milliseconds) {
    char out[QG_TIME_ROOM];
    qg_time_print(out, milliseconds);
    qg_member_text(text, name, milliseconds ? out : NULL);
}
