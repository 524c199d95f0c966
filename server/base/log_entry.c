/* Entries of the log, in three formats. See log_entry.h. */
#include "server/base/log_entry.h"

#include <assert.h>
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "schema/faults.h"
#include "server/base/clock.h"

enum { SAFE_ROOM = 2 * QG_LOG_MESSAGE_ROOM };

/* --- the vocabulary --- */

/* Names never change their meaning, identifiers never change: people have written both into their alarms. A new event gets a
 * new identifier from `systemd-id128 new`, and an entry in systemd/quietgear.catalog. */
static const struct {
    const char *name, *id;
} events[QG_EVENT_COUNT] = {
    [QG_EVENT_NONE] = {"", ""},
    [QG_EVENT_DAEMON_STARTED] = {"daemon.started", "9bc2885471b1443988b6ea31eb6f065a"},
    [QG_EVENT_DAEMON_STOPPED] = {"daemon.stopped", "5a9949b26c8c47d5b7b3986696d743b8"},
    [QG_EVENT_JOB_SUBMITTED] = {"job.submitted", "6f14767d983747ebb5c3136170ebfafc"},
    [QG_EVENT_JOB_STARTED] = {"job.started", "894b6de03ad44fb18bbe3b805f57a3d6"},
    [QG_EVENT_JOB_ENDED] = {"job.ended", "b6e445894a3b45cf955f627416f08aa9"},
    [QG_EVENT_JOB_FAILED] = {"job.failed", "cfe281f8ce7446d395ff6ddf7f144108"},
    [QG_EVENT_JOB_INTERRUPTED] = {"job.interrupted", "69ecbfaac0b24ad5893d5d08353dd041"},
    [QG_EVENT_ACCESS_DENIED] = {"access.denied", "0d670b9740f541aca8f2e6e48383170c"},
    [QG_EVENT_AUDIT] = {"audit", "030a32dceaec4f06bf2aff9046b7f0b7"},
    [QG_EVENT_DATABASE_FAILED] = {"database.failed", "dfb30961fbb240cfb53a96e72bb6e84b"},
    [QG_EVENT_DATABASE_RECOVERED] = {"database.recovered", "d90762de319a4b35bb0d547af610db5c"},
    [QG_EVENT_WEBHOOK_FAILED] = {"webhook.failed", "a16b4f29398c4bfe8494fe1e9daa0b35"},
    [QG_EVENT_WEBHOOK_GIVEN_UP] = {"webhook.given_up", "92d0d514e74c40b19e3bbbba210d902d"},
    [QG_EVENT_BACKUP_MADE] = {"backup.made", "b78cfc11a94c4b5ca9dddfc4d7fcbdec"},
    [QG_EVENT_BACKUP_FAILED] = {"backup.failed", "53d1ef87327449f2b9eb5af2c227efda"},
    [QG_EVENT_DATA_DROPPED] = {"retention.dropped", "69a646f8fd124fac862f3328b890a8f1"},
    [QG_EVENT_CERTIFICATE] = {"certificate", "e90c3e57b79e49d89f1b0c5c4f992cca"},
    [QG_EVENT_WATCHDOG] = {"watchdog", "37ad87d1447b4042a516ca2fc07ad584"},
    [QG_EVENT_REQUEST] = {"request", "2e21ddf3e2fa4b0492d52732b5292cab"},
};

/* The fields of an event: where each is kept, and how. */
static const struct field {
    const char *name;
    enum { STRING, NUMBER, OPTIONAL_NUMBER } kind;
    size_t offset;
} fields[] = {
    {"job_id", STRING, offsetof(struct qg_log_event, job)},
    {"attempt", NUMBER, offsetof(struct qg_log_event, attempt)},
    {"state", STRING, offsetof(struct qg_log_event, state)},
    {"token_id", STRING, offsetof(struct qg_log_event, token)},
    {"remote", STRING, offsetof(struct qg_log_event, remote)},
    {"action", STRING, offsetof(struct qg_log_event, action)},
    {"subject", STRING, offsetof(struct qg_log_event, subject)},
    {"webhook_id", STRING, offsetof(struct qg_log_event, webhook)},
    {"delivery_id", STRING, offsetof(struct qg_log_event, delivery)},
    {"method", STRING, offsetof(struct qg_log_event, method)},
    {"route", STRING, offsetof(struct qg_log_event, route)},
    {"status", NUMBER, offsetof(struct qg_log_event, status)},
    {"duration_ms", OPTIONAL_NUMBER, offsetof(struct qg_log_event, duration_ms)},
    {"bytes", OPTIONAL_NUMBER, offsetof(struct qg_log_event, bytes)},
};
enum { FIELD_COUNT = sizeof fields / sizeof fields[0] };

static const char *const levels[] = {"emergency", "alert", "critical", "error", "warning", "notice", "info", "debug"};

const char *qg_log_level_name(enum qg_priority priority) {
    return levels[priority];
}

const char *qg_log_event_name(enum qg_event event) {
    return events[event].name;
}

const char *qg_log_event_id(enum qg_event event) {
    return events[event].id;
}

bool qg_log_level_read(const char *word, enum qg_priority *out) {
    for (int i = QG_LOG_ERROR; i <= QG_LOG_DEBUG; i++)
        if (strcmp(word, levels[i]) == 0) {
            *out = (enum qg_priority)i;
            return true;
        }
    return false;
}

bool qg_log_format_read(const char *word, enum qg_log_format *out) {
    static const char *const formats[QG_LOG_FORMAT_COUNT] = {"auto", "text", "json"};
    for (int i = 0; i < QG_LOG_FORMAT_COUNT; i++)
        if (strcmp(word, formats[i]) == 0) {
            *out = (enum qg_log_format)i;
            return true;
        }
    return false;
}

/* --- cleaning --- */

/* True for a character that a line must not hold: C0 and C1 controls, DEL, line and paragraph separator, and the marks that
 * turn the direction of writing (U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069). */
static bool is_treacherous(const char *at, size_t length) {
    const unsigned char *b = (const unsigned char *)at;
    if (length == 1)
        return b[0] < 0x20 || b[0] == 0x7f;
    if (length == 2)
        return b[0] == 0xc2 && b[1] < 0xa0;
    if (length != 3 || b[0] != 0xe2)
        return false;
    return (b[1] == 0x80 && (b[2] == 0x8e || b[2] == 0x8f || (b[2] >= 0xa8 && b[2] <= 0xae))) ||
           (b[1] == 0x81 && b[2] >= 0xa6 && b[2] <= 0xa9);
}

void qg_log_clean(char *out, size_t room, const char *text) {
    size_t length = strlen(text), done = 0;
    while (length > 0 && (text[length - 1] == '\n' || text[length - 1] == '\r'))
        length--;
    while (length > 0) {
        size_t size = qg_utf8_length(text, length), taken = size ? size : 1;
        bool clean = size && !is_treacherous(text, size);
        if (done + (clean ? size : 1) >= room)
            break;
        if (clean)
            memcpy(out + done, text, size);
        else
            out[done] = '?';
        done += clean ? size : 1;
        text += taken;
        length -= taken;
    }
    out[done] = '\0';
}

/* --- writing --- */

/* A line while it is written. */
struct line {
    char *text;
    size_t length;
};

__attribute__((format(printf, 2, 3))) static void add(struct line *line, const char *format, ...) {
    size_t room = QG_LOG_LINE_ROOM - line->length;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line->text + line->length, room, format, arguments);
    va_end(arguments);
    assert(length >= 0 && (size_t)length < room); /* see log_entry.h */
    line->length += (size_t)length;
}

/* Doubles what JSON escapes by a backslash in front. */
static const char *escape(char out[SAFE_ROOM], const char *clean) {
    size_t done = 0;
    for (; *clean; clean++) {
        if (*clean == '"' || *clean == '\\')
            out[done++] = '\\';
        out[done++] = *clean;
    }
    out[done] = '\0';
    return out;
}

/* "job_id" as "JOB_ID". */
static const char *raise_letters(char out[32], const char *name) {
    size_t i = 0;
    for (; name[i]; i++)
        out[i] = (char)toupper((unsigned char)name[i]);
    out[i] = '\0';
    return out;
}

/* One field's value as text, "" when the event has none. */
static void read_field(char out[QG_LOG_FIELD_ROOM], const struct field *field, const struct qg_log_event *event) {
    const void *place = (const char *)event + field->offset;
    const int64_t *number = NULL;
    out[0] = '\0';
    if (field->kind == STRING) {
        const char *text = *(const char *const *)place;
        if (text)
            qg_log_clean(out, QG_LOG_FIELD_ROOM, text);
    } else {
        number = field->kind == NUMBER ? place : *(const int64_t *const *)place;
    }
    if (number && (field->kind == OPTIONAL_NUMBER || *number != 0))
        snprintf(out, QG_LOG_FIELD_ROOM, "%lld", (long long)*number);
}

static void add_prefix(struct line *line, const struct qg_entry *entry) {
    add(line, "<%d>", (int)entry->about->priority);
}

size_t qg_entry_text(const struct qg_entry *entry, bool prefixed, char out[QG_LOG_LINE_ROOM]) {
    struct line line = {.text = out};
    char time[QG_TIME_ROOM];
    qg_time_print(time, entry->time);
    if (prefixed)
        add_prefix(&line, entry);
    else
        add(&line, "%s %s: ", time, levels[entry->about->priority]);
    add(&line, "%s\n", entry->message);
    return line.length;
}

size_t qg_entry_json(const struct qg_entry *entry, bool prefixed, char out[QG_LOG_LINE_ROOM]) {
    struct line line = {.text = out};
    char safe[SAFE_ROOM], value[QG_LOG_FIELD_ROOM], time[QG_TIME_ROOM];
    const struct qg_log_event *event = entry->about;
    qg_time_print(time, entry->time);
    if (prefixed)
        add_prefix(&line, entry);
    add(&line, "{\"time\":\"%s\",\"level\":\"%s\",\"message\":\"%s\"", time, levels[event->priority],
        escape(safe, entry->message));
    if (event->event != QG_EVENT_NONE)
        add(&line, ",\"event\":\"%s\"", events[event->event].name);
    for (size_t i = 0; i < FIELD_COUNT; i++) {
        const char *quote = fields[i].kind == STRING ? "\"" : "";
        read_field(value, &fields[i], event);
        if (*value)
            add(&line, ",\"%s\":%s%s%s", fields[i].name, quote, escape(safe, value), quote);
    }
    add(&line, ",\"code_file\":\"%.80s\",\"code_line\":%d,\"code_func\":\"%.60s\"}\n", entry->place->file,
        entry->place->line, entry->place->function);
    return line.length;
}

size_t qg_entry_journal(const struct qg_entry *entry, char out[QG_LOG_LINE_ROOM]) {
    struct line line = {.text = out};
    char value[QG_LOG_FIELD_ROOM], name[32];
    const struct qg_log_event *event = entry->about;
    add(&line, "MESSAGE=%s\nPRIORITY=%d\nSYSLOG_IDENTIFIER=quietgeard\n", entry->message, (int)event->priority);
    if (event->event != QG_EVENT_NONE)
        add(&line, "MESSAGE_ID=%s\nQG_EVENT=%s\n", events[event->event].id, events[event->event].name);
    for (size_t i = 0; i < FIELD_COUNT; i++) {
        read_field(value, &fields[i], event);
        if (*value)
            add(&line, "QG_%s=%s\n", raise_letters(name, fields[i].name), value);
    }
    add(&line, "CODE_FILE=%.80s\nCODE_LINE=%d\nCODE_FUNC=%.60s\n", entry->place->file, entry->place->line,
        entry->place->function);
    return line.length;
}
