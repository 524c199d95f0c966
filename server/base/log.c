/* Where the log goes. See log.h.
 *
 * The one state of the process that no caller hands over is here: a process has one stderr, whoever writes to it. It is set by
 * qg_log_open and qg_log_close, while there is one thread, and changed in between by atomics and the limiter's mutex alone.
 */
#include "server/base/log.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/journal.h"
#include "server/base/log_entry.h"
#include "server/base/log_limit.h"

enum { PATIENCE_MS = 50 };

static struct {
    enum qg_priority level;
    bool json;
    bool prefixed; /* stderr is the journal, which reads "<N>" and knows the time */
    struct qg_journal journal;
    struct qg_limiter limiter;
    atomic_bool stuck;  /* stderr did not take the last line */
    atomic_ullong lost; /* lines since it last took one */
} sink = {.level = QG_LOG_INFO, .limiter = QG_LIMITER_INIT};

/* --- the way out --- */

/* True when a line can be written without waiting; waits for a moment when it could be so the last time. */
static bool stderr_is_ready(void) {
    struct pollfd way = {.fd = STDERR_FILENO, .events = POLLOUT};
    bool ready = poll(&way, 1, atomic_load(&sink.stuck) ? 0 : PATIENCE_MS) > 0;
    atomic_store(&sink.stuck, !ready);
    return ready;
}

/* Writes a line to stderr; false when it is lost. */
static bool write_line(const char *line, size_t length) {
    if (!stderr_is_ready())
        return false;
    ssize_t written;
    do
        written = write(STDERR_FILENO, line, length);
    while (written < 0 && errno == EINTR);
    return written == (ssize_t)length;
}

/* Writes an entry by the best way that takes it; false when none does. */
static bool send_entry(const struct qg_entry *entry) {
    char line[QG_LOG_LINE_ROOM];
    if (sink.journal.open && qg_journal_send(&sink.journal, line, qg_entry_journal(entry, line)))
        return true;
    return write_line(line, sink.json ? qg_entry_json(entry, sink.prefixed, line)
                                      : qg_entry_text(entry, sink.prefixed, line));
}

static void send_message(const struct qg_place *place, const struct qg_log_event *event, const char *message) {
    struct qg_entry entry = {.place = place, .about = event, .time = qg_wall_clock()};
    qg_log_clean(entry.message, sizeof entry.message, message);
    if (!send_entry(&entry))
        atomic_fetch_add(&sink.lost, 1);
}

/* Tells of lines that were lost, once there is a way again. */
static void tell_lost(void) {
    unsigned long long lost = atomic_load(&sink.lost);
    if (lost == 0 || !stderr_is_ready() || !atomic_compare_exchange_strong(&sink.lost, &lost, 0))
        return;
    char message[64];
    snprintf(message, sizeof message, "%llu lines of the log could not be written", lost);
    struct qg_entry entry = {
        .place = QG_PLACE, .about = &(struct qg_log_event){.priority = QG_LOG_WARNING}, .time = qg_wall_clock()};
    qg_log_clean(entry.message, sizeof entry.message, message);
    if (!send_entry(&entry))
        atomic_fetch_add(&sink.lost, lost);
}

/* Tells of messages that were dropped because they were too many. */
static void tell_dropped(int64_t until) {
    struct qg_limited dropped;
    char message[QG_LOG_MESSAGE_ROOM];
    while (qg_limiter_tell(&sink.limiter, until, &dropped)) {
        snprintf(message, sizeof message, "and %llu more like it within %lld s, the last: %s", dropped.count,
                 (long long)(qg_monotonic_clock() - dropped.since + 999) / 1000, dropped.sample);
        send_message(QG_PLACE, &(struct qg_log_event){.priority = dropped.priority, .event = dropped.event}, message);
    }
}

/* --- writing --- */

void qg_log_write(const struct qg_place *place, const struct qg_log_event *event, const char *format, ...) {
    if (event->priority > sink.level)
        return;
    int error = errno;
    char message[QG_LOG_MESSAGE_ROOM];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    qg_log_tick();
    if (!event->limit || qg_limiter_admits(&sink.limiter, event, message, qg_monotonic_clock()))
        send_message(place, event, message);
    errno = error;
}

/* --- opening and closing --- */

/* Puts /dev/null where one of the first three descriptors is closed. */
static void hold_descriptors(void) {
    int descriptor;
    do
        descriptor = open("/dev/null", O_RDWR);
    while (descriptor >= 0 && descriptor <= STDERR_FILENO);
    if (descriptor >= 0)
        close(descriptor);
}

void qg_log_open(const struct qg_log_options *options) {
    hold_descriptors();
    sink.level = options->level;
    sink.json = options->format == QG_LOG_JSON;
    sink.prefixed = qg_journal_is_behind(STDERR_FILENO);
    if (sink.prefixed && options->format == QG_LOG_AUTO &&
        !qg_journal_open(&sink.journal, options->journal_socket ? options->journal_socket : QG_JOURNAL_SOCKET))
        qg_log(QG_LOG_WARNING, "there is no way to the journal but stderr: entries have no fields");
}

void qg_log_tick(void) {
    tell_lost();
    tell_dropped(qg_monotonic_clock());
}

void qg_log_close(void) {
    tell_dropped(INT64_MAX);
    tell_lost();
    qg_journal_close(&sink.journal);
    sink.level = QG_LOG_INFO;
    sink.json = sink.prefixed = false;
}
