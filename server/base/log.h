/* The daemon's log: what happened, in words for people and in fields for programs.
 *
 * Where it goes is decided once, by qg_log_open:
 *   - stderr is the journal ($JOURNAL_STREAM names it) and the format is auto: each entry is one datagram of the journal's
 *     native protocol (journal.h), with all its fields;
 *   - json: one JSON object a line on stderr, for containers and log shippers;
 *   - text, or auto anywhere else: a readable line on stderr, with the time, or, when stderr is the journal, with its
 *     priority prefix "<N>" in the time's place.
 *
 * Invariants. An entry is one line: in every text, whoever sent it, control characters, line separators, marks that turn
 * the direction of writing and bytes that are no UTF-8 become '?', so nobody can forge a second one. No secrets, no bodies
 * of requests and no URLs of webhooks are ever handed to it. It allocates nothing, and an entry has at most
 * QG_LOG_LINE_ROOM bytes, which a pipe takes as a whole. errno is left as it was.
 *
 * Failures. A journal that is gone or does not read is passed over: the line goes to stderr. Neither is waited for, but for
 * a moment when that begins (a fifth of a second for the journal, a twentieth for stderr), since bursts fill both. What stderr
 * does not take is lost, counted, and told when lines go again.
 *
 * Floods. What a stranger can cause again and again names in `limit` what such messages have in common: of those, ten a
 * minute are written, the rest is counted and told in a line (log_limit.h).
 *
 * Threads: all functions from any, but for qg_log_open and qg_log_close.
 */
#ifndef QG_SERVER_BASE_LOG_H
#define QG_SERVER_BASE_LOG_H

#include <stdbool.h>
#include <stdint.h>

/* The priorities in use, numbered as in syslog(3). */
enum qg_priority { QG_LOG_ERROR = 3, QG_LOG_WARNING = 4, QG_LOG_NOTICE = 5, QG_LOG_INFO = 6, QG_LOG_DEBUG = 7 };

/* What people search for; names and identifiers are in log_entry.c, and systemd/quietgear.catalog says what to do. */
enum qg_event {
    QG_EVENT_NONE,
    QG_EVENT_DAEMON_STARTED,
    QG_EVENT_DAEMON_STOPPED,
    QG_EVENT_JOB_SUBMITTED,
    QG_EVENT_JOB_STARTED,     /* an attempt */
    QG_EVENT_JOB_ENDED,       /* succeeded or cancelled */
    QG_EVENT_JOB_FAILED,      /* for good */
    QG_EVENT_JOB_INTERRUPTED, /* back in the queue, to go on where its log ends */
    QG_EVENT_ACCESS_DENIED,
    QG_EVENT_AUDIT,              /* somebody changed something */
    QG_EVENT_DATABASE_FAILED,    /* full, read-only, damaged, broken */
    QG_EVENT_DATABASE_RECOVERED, /* can be written again */
    QG_EVENT_WEBHOOK_FAILED,     /* one attempt; there will be others */
    QG_EVENT_WEBHOOK_GIVEN_UP,   /* the last */
    QG_EVENT_BACKUP_MADE,
    QG_EVENT_BACKUP_FAILED,
    QG_EVENT_DATA_DROPPED, /* retention */
    QG_EVENT_CERTIFICATE,  /* read, kept, or over */
    QG_EVENT_WATCHDOG,     /* the daemon hangs */
    QG_EVENT_REQUEST,      /* a line of the access log */
    QG_EVENT_COUNT
};

/* What an entry is about. All but the priority may be left out (0, NULL); strings are read during the call only, and cut
 * after QG_LOG_FIELD_ROOM - 1 bytes. */
struct qg_log_event {
    enum qg_priority priority;
    enum qg_event event;
    const char *limit; /* what messages like this one have in common: few of them are written; NULL: all are */
    const char *job;
    const char *state;          /* of the job */
    const char *token;          /* id of the access token that was used */
    const char *remote;         /* address that a request came from */
    const char *action;         /* of the audit log: "job.cancel" */
    const char *subject;        /* of the audit log: what it was done to, an id mostly */
    const char *webhook;        /* id */
    const char *delivery;       /* id of a webhook's message */
    const char *method, *route; /* of a request: "GET", "/v1/jobs/{}" */
    int64_t attempt;            /* at the job or the delivery, from 1 */
    int64_t status;             /* of HTTP */
    const int64_t *duration_ms; /* of a job's run, of a request */
    const int64_t *bytes;       /* of an answer's body */
};

/* Where in the source an entry comes from. */
struct qg_place {
    const char *file;
    int line;
    const char *function;
};
#define QG_PLACE (&(const struct qg_place){__FILE__, __LINE__, __func__})

enum {
    QG_LOG_MESSAGE_ROOM = 1024, /* of the words; what is beyond is cut */
    QG_LOG_FIELD_ROOM = 65,     /* of a string among the fields */
    QG_LOG_LINE_ROOM = 4096     /* of a whole entry, in any format */
};

/* qg_log(priority, format, ...): writes an entry without fields, printf-like. A line end at the end is dropped. */
#define qg_log(priority_, ...)                                                                                         \
    qg_log_write(QG_PLACE, &(const struct qg_log_event){.priority = (priority_)}, __VA_ARGS__)

/* qg_log_event(const struct qg_log_event *event, format, ...): writes an entry with the event's fields, printf-like. */
#define qg_log_event(...) qg_log_write(QG_PLACE, __VA_ARGS__)

/* What the two macros call: the entry's place in the source, and what it is about. */
void qg_log_write(const struct qg_place *place, const struct qg_log_event *event, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

enum qg_log_format { QG_LOG_AUTO, QG_LOG_TEXT, QG_LOG_JSON, QG_LOG_FORMAT_COUNT };

struct qg_log_options {
    enum qg_log_format format;
    enum qg_priority level;     /* entries of higher numbers are dropped */
    const char *journal_socket; /* NULL: systemd's; another for tests */
};

/* Reads "auto", "text" or "json"; "error", "warning", "notice", "info" or "debug". False when the word is none of these. */
bool qg_log_format_read(const char *word, enum qg_log_format *out);
bool qg_log_level_read(const char *word, enum qg_priority *out);

/* Decides where the log goes; before it is called that is text on stderr, from info up. Call it while there is one thread.
 * The descriptors 0 to 2 are taken after it, so that no file is opened as stderr by chance. */
void qg_log_open(const struct qg_log_options *options);

/* Writes the lines that tell of dropped messages as soon as their minute is over: to be called now and then. */
void qg_log_tick(void);

/* Writes them at once, and goes back to text on stderr. Call it while there is one thread. */
void qg_log_close(void);

#endif
