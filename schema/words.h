/* Words for what is wrong in a document: what was found, what is allowed, what was probably meant.
 *
 * All functions return their words, which are in `out` or static. Threads: any, in the locale "C".
 */
#ifndef QG_SCHEMA_WORDS_H
#define QG_SCHEMA_WORDS_H

#include <cjson/cJSON.h>

#include "schema/faults.h"
#include "schema/fields.h"

enum { QG_WORDS_ROOM = 256 };

/* What an item is, for "found ...": a string in quotes, a number, "an object", ... */
const char *qg_found_words(const cJSON *item, char out[QG_QUOTE_ROOM]);

/* What a field takes, for "allowed ...": "a number from 0 to 1", "\"f_dte\" or \"f_pps\"", ... */
const char *qg_allowed_words(const struct qg_field *field, char out[QG_WORDS_ROOM]);

/* Its limits alone: "0 to 1". */
const char *qg_range_words(const struct qg_field *field, char out[QG_WORDS_ROOM]);

/* The key of the form that was probably meant by an unknown one; NULL when none is near. */
const char *qg_nearest_key(const struct qg_form *form, const char *key);

#endif
