/* Texts of the status table, and the list of notes. */
#include "core/status.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>

const char *qg_status_text(enum qg_status status) {
#define QG_STATUS_TEXT(name, text) text,
    static const char *const texts[] = {QG_STATUS_TABLE(QG_STATUS_TEXT)};
#undef QG_STATUS_TEXT
    assert((unsigned)status < QG_STATUS_COUNT);
    return texts[status];
}

bool qg_is_stopped(const struct qg_stop *stop) {
    return stop->asked && stop->asked(stop->self);
}

void qg_notes_add(struct qg_notes *notes, const char *where, const char *format, ...) {
    if (!notes)
        return;
    if (notes->count == QG_NOTES_ROOM) {
        notes->lost++;
        return;
    }
    struct qg_note *note = &notes->item[notes->count++];
    snprintf(note->where, sizeof note->where, "%s", where);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note->text, sizeof note->text, format, arguments);
    va_end(arguments);
}
