/* The store's foundation: opening, locking, transactions, statements. See store.h. */
#include "server/store/store.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include "server/base/log.h"
#include "server/store/internal.h"

enum { BUSY_TIMEOUT_MS = 5000 };

/* --- statements --- */

bool qg_store_may_recover(enum qg_store_status status) {
    return status == QG_STORE_FULL || status == QG_STORE_READ_ONLY || status == QG_STORE_UNAVAILABLE;
}

const char *qg_store_failure_text(enum qg_store_status status) {
    switch (status) {
    case QG_STORE_FULL:
        return "the disk with the database is full";
    case QG_STORE_READ_ONLY:
        return "the database cannot be written: it, its directory or its disk is read-only";
    case QG_STORE_UNAVAILABLE:
        return "the database cannot be used now: an input or output error, or memory is short";
    case QG_STORE_CORRUPT:
        return "the database is damaged: stop the server and restore a backup";
    case QG_STORE_FAILED:
        return "the database failed; the server's log says why";
    default:
        return NULL;
    }
}

/* Free bytes on the disk of a file or directory; as many as there may be when that cannot be told. */
static uint64_t free_bytes(const char *path) {
    struct statvfs disk;
    return statvfs(path, &disk) == 0 ? (uint64_t)disk.f_bavail * disk.f_frsize : UINT64_MAX;
}

/* What an input or output error comes from, asked of the disk: SQLite does not keep the errno of a failed write. */
static enum qg_store_status cause_of_error(sqlite3 *database) {
    const char *path = sqlite3_db_filename(database, "main");
    if (path && *path && access(path, W_OK) != 0 && (errno == EROFS || errno == EACCES))
        return QG_STORE_READ_ONLY;
    return path && *path && free_bytes(path) < QG_STORE_ROOM_BYTES ? QG_STORE_FULL : QG_STORE_UNAVAILABLE;
}

/* The status for the connection's last failure. */
static enum qg_store_status failure_of(sqlite3 *database) {
    switch (sqlite3_errcode(database)) {
    case SQLITE_FULL:
        return QG_STORE_FULL;
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return QG_STORE_READ_ONLY;
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
        return cause_of_error(database);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
    case SQLITE_NOMEM:
        return QG_STORE_UNAVAILABLE;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
        return QG_STORE_CORRUPT;
    default:
        return QG_STORE_FAILED;
    }
}

enum qg_store_status qg_sql_failure(sqlite3 *database, const char *doing) {
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_ERROR, .limit = doing}, "database: %s: %s (%d)", doing,
                 sqlite3_errmsg(database), sqlite3_extended_errcode(database));
    return failure_of(database);
}

static int bind_one(sqlite3_stmt *statement, int place, char type, va_list *arguments) {
    if (type == 'i')
        return sqlite3_bind_int64(statement, place, va_arg(*arguments, int64_t));
    if (type == 'd')
        return sqlite3_bind_double(statement, place, va_arg(*arguments, double)); /* NaN becomes NULL */
    const char *text = va_arg(*arguments, const char *);
    return sqlite3_bind_text(statement, place, text, -1, SQLITE_STATIC);
}

static sqlite3_stmt *prepare(sqlite3 *database, const char *sql, const char *types, va_list *arguments) {
    sqlite3_stmt *statement = NULL;
    int code = sqlite3_prepare_v2(database, sql, -1, &statement, NULL);
    for (int i = 0; code == SQLITE_OK && types[i]; i++)
        code = bind_one(statement, i + 1, types[i], arguments);
    if (code == SQLITE_OK)
        return statement;
    qg_sql_failure(database, sql);
    sqlite3_finalize(statement);
    return NULL;
}

sqlite3_stmt *qg_sql_prepare(sqlite3 *database, const char *sql, const char *types, ...) {
    va_list arguments;
    va_start(arguments, types);
    sqlite3_stmt *statement = prepare(database, sql, types, &arguments);
    va_end(arguments);
    return statement;
}

enum qg_store_status qg_sql_run(sqlite3 *database, const char *sql, const char *types, ...) {
    va_list arguments;
    va_start(arguments, types);
    sqlite3_stmt *statement = prepare(database, sql, types, &arguments);
    va_end(arguments);
    if (!statement)
        return failure_of(database);
    int code;
    do
        code = sqlite3_step(statement);
    while (code == SQLITE_ROW);
    enum qg_store_status status = code == SQLITE_DONE ? QG_STORE_OK : qg_sql_failure(database, sql);
    sqlite3_finalize(statement);
    return status;
}

enum qg_store_status qg_sql_row(sqlite3_stmt *statement) {
    if (!statement)
        return QG_STORE_FAILED;
    int code = sqlite3_step(statement);
    if (code == SQLITE_ROW)
        return QG_STORE_OK;
    if (code == SQLITE_DONE)
        return QG_STORE_NOT_FOUND;
    return qg_sql_failure(sqlite3_db_handle(statement), sqlite3_sql(statement));
}

/* --- transactions --- */

/* Remembers whether writing works, and logs when that changes. The writer's mutex is held. */
static void note_outcome(struct qg_store *store, enum qg_store_status status) {
    bool wrote = status == QG_STORE_OK && sqlite3_total_changes(store->writer) != store->changes;
    bool troubled = qg_store_may_recover(status) || status == QG_STORE_CORRUPT;
    int before = atomic_load(&store->trouble);
    if (!wrote && !troubled)
        return;
    atomic_store(&store->trouble, (int)status);
    if (troubled && before != (int)status)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_ERROR, .event = QG_EVENT_DATABASE_FAILED},
                     "database: %s; submissions are refused and running jobs wait", qg_store_failure_text(status));
    else if (wrote && before != QG_STORE_OK)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE, .event = QG_EVENT_DATABASE_RECOVERED},
                     "database: can be written again");
}

enum qg_store_status qg_store_begin(struct qg_store *store) {
    pthread_mutex_lock(&store->writer_mutex);
    enum qg_store_status status = qg_sql_run(store->writer, "BEGIN IMMEDIATE", "");
    store->changes = sqlite3_total_changes(store->writer);
    if (status != QG_STORE_OK) {
        note_outcome(store, status);
        pthread_mutex_unlock(&store->writer_mutex);
    }
    return status;
}

static const char *or_none(const char *text) {
    return *text ? text : "-";
}

static void log_audited(const struct qg_audit_entry *entry) {
    bool of_job = strncmp(entry->action, "job.", 4) == 0;
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE,
                                        .event = QG_EVENT_AUDIT,
                                        .action = entry->action,
                                        .subject = entry->subject,
                                        .job = of_job ? entry->subject : NULL,
                                        .token = entry->token,
                                        .remote = entry->address},
                 "audit: %s %s by %s, token %s, address %s", entry->action, entry->subject, or_none(entry->name),
                 or_none(entry->token), or_none(entry->address));
}

enum qg_store_status qg_store_end(struct qg_store *store, enum qg_store_status status) {
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer, "COMMIT", "");
    if (status != QG_STORE_OK && !sqlite3_get_autocommit(store->writer))
        qg_sql_run(store->writer, "ROLLBACK", "");
    note_outcome(store, status);
    if (status == QG_STORE_OK && *store->audited.action)
        log_audited(&store->audited);
    store->audited.action[0] = '\0';
    if (status == QG_STORE_OK && store->has_deliveries && store->on_deliveries)
        store->on_deliveries(store->on_deliveries_self);
    store->has_deliveries = false;
    pthread_mutex_unlock(&store->writer_mutex);
    return status;
}

/* --- opening and closing --- */

/* Makes a directory and those above it, for this user only. */
static bool make_directory(const char *path) {
    char partial[PATH_MAX];
    if (strlen(path) >= sizeof partial)
        return false;
    strcpy(partial, path);
    for (char *slash = strchr(partial + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(partial, 0755);
        *slash = '/';
    }
    struct stat status;
    return mkdir(partial, 0700) == 0 || (stat(partial, &status) == 0 && S_ISDIR(status.st_mode));
}

int qg_store_lock(const char *directory, char message[QG_STORE_MESSAGE_ROOM]) {
    char path[PATH_MAX], holder[32] = "";
    if (!make_directory(directory)) {
        snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s: cannot be made a directory: %s", directory, strerror(errno));
        return -1;
    }
    snprintf(path, sizeof path, "%s/lock", directory);
    int lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (lock < 0) {
        snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s: %s", path, strerror(errno));
        return -1;
    }
    if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
        ssize_t length = read(lock, holder, sizeof holder - 1);
        snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s is in use by another quietgeard (process %.*s)", directory,
                 length > 0 ? (int)strcspn(holder, "\n") : 1, length > 0 ? holder : "?");
        close(lock);
        return -1;
    }
    int length = snprintf(holder, sizeof holder, "%ld\n", (long)getpid());
    if (ftruncate(lock, 0) != 0 || pwrite(lock, holder, (size_t)length, 0) != length)
        qg_log(QG_LOG_WARNING, "%s: the process number cannot be written: %s", path, strerror(errno));
    return lock;
}

static sqlite3 *open_connection(const char *path, bool writer, char *message) {
    /* While somebody reads for long (a backup), the write-ahead log cannot begin anew and grows; then it is cut. */
    static const char writer_setup[] = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;"
                                       "PRAGMA journal_size_limit = 16777216; PRAGMA trusted_schema = OFF;";
    static const char reader_setup[] = "PRAGMA query_only = ON; PRAGMA wal_autocheckpoint = 0;"
                                       "PRAGMA trusted_schema = OFF;";
    sqlite3 *database = NULL;
    int flags = writer ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
    if (sqlite3_open_v2(path, &database, flags, NULL) == SQLITE_OK &&
        sqlite3_busy_timeout(database, BUSY_TIMEOUT_MS) == SQLITE_OK &&
        sqlite3_exec(database, writer ? writer_setup : reader_setup, NULL, NULL, NULL) == SQLITE_OK)
        return database;
    const char *hint = database ? qg_store_failure_text(failure_of(database)) : NULL;
    snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s: %s%s%s", path,
             database ? sqlite3_errmsg(database) : "out of memory", hint ? "; " : "", hint ? hint : "");
    sqlite3_close(database);
    return NULL;
}

/* Nobody can hold a claim on a database that we have just locked: what is `running` was left behind. */
static enum qg_store_status recover(struct qg_store *store) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer,
                        "UPDATE jobs SET state = 'cancelled', finished_at = ?, lease_until = NULL, eta_s = NULL"
                        " WHERE cancel_requested AND state IN ('running', 'queued')",
                        "i", qg_wall_clock());
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer,
                            "UPDATE jobs SET state = 'queued', lease_until = NULL, eta_s = NULL"
                            " WHERE state = 'running'",
                            "");
    int requeued = sqlite3_changes(store->writer);
    if (status == QG_STORE_OK && requeued > 0)
        qg_log(QG_LOG_NOTICE, "%d unfinished jobs go on where their logs end", requeued);
    return qg_store_end(store, status);
}

static bool open_database(struct qg_store *store, const char *directory, char *message) {
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/quietgear.db", directory);
    store->writer = open_connection(path, true, message);
    if (!store->writer)
        return false;
    enum qg_store_status status = qg_store_migrate(store->writer);
    if (status == QG_STORE_OK)
        status = recover(store);
    if (status != QG_STORE_OK) {
        snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s: %s", path,
                 status == QG_STORE_WRONG_STATE ? "made by a newer version of this program"
                                                : qg_store_failure_text(status));
        return false;
    }
    store->reader = open_connection(path, false, message);
    return store->reader;
}

struct qg_store *qg_store_open(const char *directory, char message[QG_STORE_MESSAGE_ROOM]) {
    struct qg_store *store = calloc(1, sizeof *store);
    if (!store) {
        snprintf(message, QG_STORE_MESSAGE_ROOM, "out of memory");
        return NULL;
    }
    store->lock = -1;
    pthread_mutex_init(&store->writer_mutex, NULL);
    pthread_mutex_init(&store->reader_mutex, NULL);
    store->lock = qg_store_lock(directory, message);
    if (store->lock >= 0 && open_database(store, directory, message))
        return store;
    qg_store_close(store);
    return NULL;
}

void qg_store_close(struct qg_store *store) {
    if (!store)
        return;
    sqlite3_close(store->reader); /* the reader first: the last to close does the final checkpoint */
    sqlite3_close(store->writer);
    if (store->lock >= 0)
        close(store->lock);
    pthread_mutex_destroy(&store->writer_mutex);
    pthread_mutex_destroy(&store->reader_mutex);
    free(store);
}

bool qg_store_is_alive(struct qg_store *store) {
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement = qg_sql_prepare(store->reader, "SELECT count(*) FROM sqlite_schema", "");
    bool alive = qg_sql_row(statement) == QG_STORE_OK;
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return alive;
}

enum qg_store_status qg_store_test_writing(struct qg_store *store) {
    bool really = atomic_load(&store->trouble) != QG_STORE_OK;
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer, "UPDATE revision SET last = last + 1", "");
    if (status == QG_STORE_OK) /* there and back: an update that changes nothing would write nothing */
        status = qg_sql_run(store->writer, "UPDATE revision SET last = last - 1", "");
    if (status != QG_STORE_OK || really)
        return qg_store_end(store, status);
    qg_store_end(store, QG_STORE_LOST); /* any status but QG_STORE_OK rolls back */
    return free_bytes(sqlite3_db_filename(store->reader, "main")) < QG_STORE_ROOM_BYTES ? QG_STORE_FULL : QG_STORE_OK;
}

enum qg_store_status qg_store_check(sqlite3 *database) {
    sqlite3_stmt *statement = qg_sql_prepare(database, "PRAGMA integrity_check(1)", "");
    enum qg_store_status status = statement ? qg_sql_row(statement) : failure_of(database);
    const char *verdict = status == QG_STORE_OK ? (const char *)sqlite3_column_text(statement, 0) : NULL;
    if (status == QG_STORE_OK && (!verdict || strcmp(verdict, "ok") != 0)) {
        qg_log(QG_LOG_ERROR, "database: integrity check: %s", verdict ? verdict : "no verdict");
        status = QG_STORE_CORRUPT;
    }
    sqlite3_finalize(statement);
    return status;
}

static int64_t size_of(const char *path) {
    struct stat status;
    return path && *path && stat(path, &status) == 0 ? (int64_t)status.st_size : 0;
}

enum qg_store_status qg_store_statistics(struct qg_store *store, struct qg_statistics *out) {
    *out = (struct qg_statistics){.evaluations = atomic_load_explicit(&store->recorded, memory_order_relaxed)};
    out->writable = atomic_load(&store->trouble) == QG_STORE_OK;
    pthread_mutex_lock(&store->reader_mutex);
    const char *path = sqlite3_db_filename(store->reader, "main");
    out->database_bytes = size_of(path);
    out->wal_bytes = size_of(sqlite3_filename_wal(path));
    sqlite3_stmt *statement = qg_sql_prepare(store->reader, "SELECT state, jobs FROM job_counts", "");
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK) {
        enum qg_state state = qg_state_of_name((const char *)sqlite3_column_text(statement, 0));
        out->jobs[state] = sqlite3_column_int64(statement, 1);
    }
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}
