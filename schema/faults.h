/* Saying what is wrong with a document: pointers to places in it, and words with what was found there.
 *
 * Strings from the document are printed only through qg_quote, which escapes control characters and cuts: what a stranger
 * wrote cannot move a terminal's cursor, break a log line or flood an answer.
 */
#ifndef QG_SCHEMA_FAULTS_H
#define QG_SCHEMA_FAULTS_H

#include "schema/document.h"

/* The way from the document's root to a place, as an RFC 6901 pointer. A zeroed struct is the root. A way too long for
 * the room ends with the last member that fits. */
struct qg_path {
    char text[QG_POINTER_ROOM];
    size_t length;
};

/* Goes one member or array item deeper. Returns what qg_path_pop needs to come back. */
size_t qg_path_push(struct qg_path *path, const char *key);
size_t qg_path_push_index(struct qg_path *path, size_t index);
void qg_path_pop(struct qg_path *path, size_t mark);

/* Appends a fault at `pointer`, printf-like; counts it as lost when there is no room. */
void qg_faults_add(struct qg_faults *faults, const char *pointer, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A string of the document in quotes, control characters, quotes and backslashes escaped, cut after some forty characters.
 * Returns out. */
enum { QG_QUOTE_ROOM = 80 };
const char *qg_quote(char out[QG_QUOTE_ROOM], const char *utf8);

/* The bytes of the UTF-8 character that starts at bytes: 1 to 4, or 0 when it is none (overlong, surrogate, beyond
 * U+10FFFF, cut off by the length). */
size_t qg_utf8_length(const char *bytes, size_t length);

#endif
