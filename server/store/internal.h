/* What the store's files share: the connections, transactions, and statements with their arguments in one call.
 *
 * Argument types are given as letters: 'i' int64_t, 's' const char * (NULL becomes NULL; borrowed for the call), 'd' double
 * (NaN becomes NULL). Failures are logged where they happen and returned as a status.
 */
#ifndef QG_SERVER_STORE_INTERNAL_H
#define QG_SERVER_STORE_INTERNAL_H

#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>

#include "server/base/clock.h"
#include "server/store/access.h"
#include "server/store/store.h"

struct qg_store {
    sqlite3 *writer, *reader;
    pthread_mutex_t writer_mutex, reader_mutex; /* never both at once */
    atomic_ullong recorded;                     /* evaluations */
    struct qg_audit_entry audited; /* to be logged when the transaction is committed; action "": nothing. Guarded by
                                      writer_mutex */
    bool has_deliveries;           /* the transaction has written some; guarded by writer_mutex, as the next two are */
    void (*on_deliveries)(void *self); /* see store/webhooks.h */
    void *on_deliveries_self;
    int lock;           /* file descriptor that holds the directory's lock; -1 */
    int changes;        /* the writer's count of changes when the transaction began; guarded by writer_mutex */
    atomic_int trouble; /* status of the last write that failed; QG_STORE_OK from the next one that succeeds */
};

/* Logs what SQLite says about the connection's last failure, and returns the status for it. */
enum qg_store_status qg_sql_failure(sqlite3 *database, const char *doing);

/* A statement with its arguments bound, NULL on failure (logged). The caller finalizes it; strings must live until then. */
sqlite3_stmt *qg_sql_prepare(sqlite3 *database, const char *sql, const char *types, ...);

/* Prepares, runs to the end and finalizes a statement whose rows, if any, do not matter. */
enum qg_store_status qg_sql_run(sqlite3 *database, const char *sql, const char *types, ...);

/* Steps a statement of which at most one row is wanted: QG_STORE_OK with a row, QG_STORE_NOT_FOUND without. */
enum qg_store_status qg_sql_row(sqlite3_stmt *statement);

/* Takes the writer and begins a transaction. On any status but QG_STORE_OK the writer is not held. */
enum qg_store_status qg_store_begin(struct qg_store *store);

/* Commits when status is QG_STORE_OK, else rolls back; releases the writer. Returns status, or why the commit failed. */
enum qg_store_status qg_store_end(struct qg_store *store, enum qg_store_status status);

/* Writes into the audit log, inside the writer's transaction and its mutex, that `actor` (NULL: the daemon) has done
 * `action` to `subject`, and has it logged once that is committed; only when status is QG_STORE_OK. Returns status, or why
 * it cannot be written. */
enum qg_store_status qg_store_audited(struct qg_store *store, enum qg_store_status status, const struct qg_actor *actor,
                                      const char *action, const char *subject);

/* This program's format: how many migrations there are. */
enum { QG_STORE_FORMAT = 13 };

/* Brings a database to this program's format. QG_STORE_WRONG_STATE when its format is newer. */
enum qg_store_status qg_store_migrate(sqlite3 *database);

/* The same, but stops at a format: for tests that need a database of an old one. */
enum qg_store_status qg_store_migrate_to(sqlite3 *database, int last);

/* Whether the database's format is one that migrations lead to, up to this program's. */
bool qg_store_is_known_format(sqlite3 *database);

/* Whether the database's format has an audit log yet. */
bool qg_store_has_audit(sqlite3 *database);

/* QG_STORE_CORRUPT, or what else is wrong, unless SQLite's own check of the whole database finds nothing. */
enum qg_store_status qg_store_check(sqlite3 *database);

/* Makes the directory, if it is not there, and takes its lock. Returns the descriptor that holds it until it is closed; -1
 * and a message when another process has it, or the directory cannot be used. */
int qg_store_lock(const char *directory, char message[QG_STORE_MESSAGE_ROOM]);

/* Columns of jobs in the order in which qg_store_read_row expects them. */
#define QG_JOB_COLUMNS                                                                                                 \
    "seq, id, kind, state, cancel_requested, submitted_at, started_at, finished_at, done, total, phase, eta_s, best, " \
    "name, labels, error, external_id, objective, (SELECT last FROM revision) AS as_of, estimated_evaluations, "       \
    "estimated_s, estimated_memory_mb"

/* Reads the current row of a statement over QG_JOB_COLUMNS. QG_STORE_FAILED when memory is short. */
enum qg_store_status qg_store_read_row(sqlite3_stmt *statement, struct qg_job_row *row);

#endif
