/* Members of JSON objects, name and value in one call, and the units of the documents: for schema's writers.
 */
#ifndef QG_SCHEMA_MEMBERS_H
#define QG_SCHEMA_MEMBERS_H

#include "schema/text.h"

static const double um_per_mm = 1e3, nmm_per_nm = 1e3;

/* NaN becomes null. */
static inline void number(struct qg_text *text, const char *name, double value) {
    qg_json_name(text, name);
    qg_json_number(text, value);
}

static inline void integer(struct qg_text *text, const char *name, uint64_t value) {
    qg_json_name(text, name);
    qg_json_integer(text, (int64_t)value);
}

static inline void boolean(struct qg_text *text, const char *name, bool value) {
    qg_json_name(text, name);
    qg_json_bool(text, value);
}

/* Begins a member that is an object '{' or an array '['; qg_json_close ends it. */
static inline void open_member(struct qg_text *text, const char *name, char bracket) {
    qg_json_name(text, name);
    qg_json_open(text, bracket);
}

#endif
