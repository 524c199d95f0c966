/* A growing piece of text, and a JSON writer on it whose numbers survive a round trip.
 *
 * The writer puts commas by itself: open, name, value, close in the order of the document. Names and strings are escaped.
 * A failed allocation makes the text `failed`; everything after that does nothing, so one check at the end is enough.
 */
#ifndef QG_SCHEMA_TEXT_H
#define QG_SCHEMA_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct qg_text {
    char *data; /* NUL-terminated once anything was written; NULL before */
    size_t length, room;
    bool failed;
    bool comma; /* the writer owes a comma before the next item */
};

/* A zeroed struct qg_text is empty and ready; the struct belongs to one thread at a time. Frees what it holds and zeroes
 * it. */
void qg_text_finish(struct qg_text *text);

/* Appends `length` bytes as they are, or printf-like (in the current locale: no %f or %g here). Neither minds commas. */
void qg_text_add(struct qg_text *text, const char *bytes, size_t length);
void qg_text_format(struct qg_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The JSON writer. Names and strings are NUL-terminated, valid UTF-8; they are copied. */
void qg_json_open(struct qg_text *text, char bracket);  /* '{' or '[' */
void qg_json_close(struct qg_text *text, char bracket); /* '}' or ']' */
void qg_json_name(struct qg_text *text, const char *name);
void qg_json_string(struct qg_text *text, const char *utf8);
void qg_json_number(struct qg_text *text, double value); /* as qg_number_print */
void qg_json_integer(struct qg_text *text, int64_t value);
void qg_json_bool(struct qg_text *text, bool value);
void qg_json_null(struct qg_text *text);
void qg_json_raw(struct qg_text *text, const char *json); /* a finished JSON value */

/* The number as the writer prints it, for CSV and messages: the first of 15, 16 or 17 significant digits that reads back
 * to the same bits, with a point whatever the locale; "null" for NaN and infinity. Returns the length. Threads: any. */
enum { QG_NUMBER_ROOM = 32 };
int qg_number_print(char out[QG_NUMBER_ROOM], double value);

#endif
