/* One entry of the log, and how it is written in each format.
 *
 * An entry's strings are clean (log.h, invariants), so that no format has to care: the journal's needs no length in front of a
 * value, JSON escapes quotes and backslashes only. The formats' names of a field are one word: "job_id" in JSON is QG_JOB_ID in
 * the journal. The room of a line follows from the rooms of its parts, and is asserted.
 */
#ifndef QG_SERVER_BASE_LOG_ENTRY_H
#define QG_SERVER_BASE_LOG_ENTRY_H

#include <stddef.h>

#include "server/base/log.h"

/* An entry; what it points to outlives it. */
struct qg_entry {
    const struct qg_place *place;
    const struct qg_log_event *about;
    int64_t time;                      /* ms since 1970 UTC */
    char message[QG_LOG_MESSAGE_ROOM]; /* clean */
};

/* Copies text as far as it fits and cleans it: what could end a line, or is no UTF-8, becomes '?'. Line ends at its end are
 * dropped. room > 0. */
void qg_log_clean(char *out, size_t room, const char *text);

/* The name of a priority ("notice"), and of an event ("job.started"; "" for QG_EVENT_NONE). */
const char *qg_log_level_name(enum qg_priority priority);
const char *qg_log_event_name(enum qg_event event);

/* The event's MESSAGE_ID: 32 hexadecimal digits; "" for QG_EVENT_NONE. */
const char *qg_log_event_id(enum qg_event event);

/* Each writes the entry as a line, with its line end and without a NUL, and returns its length: words with time and level; a
 * JSON object; a datagram for the journal, of several lines. prefixed: the line is for the journal's stream, begins with its
 * priority as "<N>", and words need neither time nor level. */
size_t qg_entry_text(const struct qg_entry *entry, bool prefixed, char out[QG_LOG_LINE_ROOM]);
size_t qg_entry_json(const struct qg_entry *entry, bool prefixed, char out[QG_LOG_LINE_ROOM]);
size_t qg_entry_journal(const struct qg_entry *entry, char out[QG_LOG_LINE_ROOM]);

#endif
