/* Words to people, on standard error, and documents to where they belong. */
#ifndef QG_CLI_WORDS_H
#define QG_CLI_WORDS_H

#include <stdbool.h>

#include "cli/files.h"
#include "schema/text.h"

/* The document's name in messages: "-" is standard input. */
const char *qg_shown_name(const char *path);

/* Prints text that a stranger may have written: control characters only as \uXXXX. */
void qg_print_plain(const char *utf8);

/* One fault on one line: document, pointer, words. */
void qg_print_fault(const char *document, const char *pointer, const char *detail);

/* Reads a whole number from 1 to most; NULL leaves *out as it is. False, and says so of the place ("token: --days"), when it is
 * something else. */
bool qg_read_count(const char *place, const char *text, long most, long *out);

/* Ends the text with a line feed and commits it to the output; says what went wrong. Returns an exit status. */
int qg_deliver(struct qg_text *text, struct qg_output *output);

#endif
