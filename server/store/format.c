/* The database's format and its history.
 *
 * How to change the format, step by step:
 *   1. Append one string to `migrations` below: the SQL that turns the format before it into the new one. It runs in one
 *      transaction together with the new user_version, so it happens as a whole or not at all.
 *      Count it in QG_STORE_FORMAT.
 *   2. Never edit a string that has been in a release: databases out there have already run it.
 *   3. Keep what users have: ALTER TABLE ... ADD COLUMN with a default, or a new table filled from the old one.
 *   4. Change the statements in store*.c that read and write it, and QG_JOB_COLUMNS if a job gains a column.
 *   5. tests/server/test_store.c brings a database of each older format up; check there what becomes of your columns.
 * user_version counts the strings that a database has run. A larger number than ours is refused: that database belongs to a
 * newer program.
 */
#include "server/store/internal.h"

#include <assert.h>
#include <stdio.h>

#include "server/base/log.h"

/* Writes a delivery for each webhook that wants to know the state that a job has come into; NEW is the job. What it will
 * say is copied, and becomes JSON in store/webhooks.c: SQLite 3.40 takes its own JSON functions for unsafe in triggers. */
#define WRITE_DELIVERIES(more_columns, more_values)                                                                    \
    " INSERT INTO deliveries (id, webhook, event, job, name, kind, labels, error, created_at, "                        \
    "next_attempt_at" more_columns ")"                                                                                 \
    " SELECT 'msg_' || lower(hex(randomblob(12))), webhooks.id, 'job.' || NEW.state, NEW.id, NEW.name, NEW.kind,"      \
    " NEW.labels, NEW.error, now.ms, now.ms" more_values                                                               \
    " FROM webhooks, (SELECT CAST(strftime('%s', 'now') AS INTEGER) * 1000"                                            \
    " + CAST(substr(strftime('%f', 'now'), 4) AS INTEGER) AS ms) AS now"                                               \
    " WHERE disabled_at IS NULL AND events & CASE NEW.state WHEN 'queued' THEN 1 WHEN 'running' THEN 2"                \
    " WHEN 'succeeded' THEN 4 WHEN 'failed' THEN 8 ELSE 16 END;"

/* The triggers that do so for each new job and each change of a state. */
#define DELIVERY_TRIGGERS(columns, values)                                                                             \
    "CREATE TRIGGER delivery_of_new_job AFTER INSERT ON jobs BEGIN" WRITE_DELIVERIES(                                  \
        columns, values) " END;"                                                                                       \
                         "CREATE TRIGGER delivery_of_change AFTER UPDATE OF state ON jobs WHEN NEW.state <> "          \
                         "OLD.state BEGIN" WRITE_DELIVERIES(columns, values) " END;"

static const char *const migrations[] = {
    /* 1: jobs with their queue, evaluations, outputs */
    "CREATE TABLE jobs ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " name TEXT NOT NULL,"
    " kind TEXT NOT NULL,"
    " labels TEXT NOT NULL," /* a JSON array */
    " state TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),"
    " cancel_requested INTEGER NOT NULL DEFAULT 0,"
    " idempotency_key TEXT UNIQUE,"
    " submitted_at INTEGER NOT NULL," /* ms since 1970 UTC, like all times */
    " started_at INTEGER,"
    " finished_at INTEGER,"
    " done INTEGER NOT NULL DEFAULT 0,"
    " total INTEGER NOT NULL DEFAULT 0,"
    " phase TEXT,"
    " eta_s REAL,"
    " best REAL,"
    " error TEXT,"
    " attempt INTEGER NOT NULL DEFAULT 0," /* grows with every claim */
    " lease_until INTEGER,"
    " program TEXT," /* version that wrote the evaluations */
    " document TEXT NOT NULL"
    ") STRICT;"
    "CREATE INDEX jobs_by_state ON jobs (state, seq);"
    "CREATE TABLE evaluations ("
    " job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,"
    " number INTEGER NOT NULL,"
    " phase TEXT NOT NULL,"
    " pinion_tip_start_radius REAL NOT NULL," /* mm, like all parameters */
    " pinion_tip_amplitude REAL NOT NULL,"
    " pinion_root_end_radius REAL NOT NULL,"
    " pinion_root_amplitude REAL NOT NULL,"
    " gear_tip_start_radius REAL NOT NULL,"
    " gear_tip_amplitude REAL NOT NULL,"
    " gear_root_end_radius REAL NOT NULL,"
    " gear_root_amplitude REAL NOT NULL,"
    " f_pps REAL," /* mm; NULL is NaN */
    " f_dte REAL," /* NULL is NaN */
    " PRIMARY KEY (job, number)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE TABLE outputs ("
    " job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,"
    " name TEXT NOT NULL,"
    " body TEXT NOT NULL,"
    " PRIMARY KEY (job, name)"
    ") STRICT;",
    /* 2: revisions, which number the changes that readers follow; deletions are kept for 10000 revisions */
    "CREATE TABLE revision (last INTEGER NOT NULL) STRICT;"
    "INSERT INTO revision VALUES (0);"
    "ALTER TABLE jobs ADD COLUMN revision INTEGER NOT NULL DEFAULT 0;"
    "CREATE INDEX jobs_by_revision ON jobs (revision);"
    "CREATE TABLE deletions (revision INTEGER PRIMARY KEY, id TEXT NOT NULL) STRICT;"
    "CREATE TRIGGER job_submitted AFTER INSERT ON jobs BEGIN"
    " UPDATE revision SET last = last + 1;"
    " UPDATE jobs SET revision = (SELECT last FROM revision) WHERE seq = NEW.seq;"
    "END;"
    "CREATE TRIGGER job_changed AFTER UPDATE OF state, cancel_requested ON jobs BEGIN"
    " UPDATE revision SET last = last + 1;"
    " UPDATE jobs SET revision = (SELECT last FROM revision) WHERE seq = NEW.seq;"
    "END;"
    "CREATE TRIGGER job_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE revision SET last = last + 1;"
    " INSERT INTO deletions SELECT last, OLD.id FROM revision;"
    " DELETE FROM deletions WHERE revision <= (SELECT last - 10000 FROM revision);"
    "END;",
    /* 3: access tokens, which of them submitted a job, and the audit log */
    "CREATE TABLE tokens ("
    " id TEXT PRIMARY KEY,"
    " name TEXT NOT NULL,"
    " scopes INTEGER NOT NULL," /* bits: 1 read, 2 submit, 4 admin */
    " created_at INTEGER NOT NULL,"
    " hash TEXT NOT NULL" /* SHA-256 of the secret, hexadecimal */
    ") STRICT, WITHOUT ROWID;"
    "ALTER TABLE jobs ADD COLUMN token TEXT;" /* id of a token; NULL: submitted without one */
    "CREATE INDEX jobs_waiting_by_token ON jobs (token) WHERE state IN ('queued', 'running');"
    "CREATE TABLE audit ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT,"
    " at INTEGER NOT NULL,"
    " token TEXT NOT NULL," /* id; '' without one */
    " name TEXT NOT NULL,"  /* the token's, kept beyond its revocation */
    " address TEXT NOT NULL,"
    " action TEXT NOT NULL,"
    " subject TEXT NOT NULL"
    ") STRICT;"
    "CREATE INDEX audit_by_time ON audit (at);",
    /* 4: webhooks, and their deliveries, written by triggers with every change of a state */
    "CREATE TABLE webhooks ("
    " id TEXT PRIMARY KEY,"
    " url TEXT NOT NULL,"
    " events INTEGER NOT NULL," /* bits: 1 job.queued, 2 running, 4 succeeded, 8 failed, 16 cancelled */
    " secret TEXT NOT NULL,"
    " created_at INTEGER NOT NULL,"
    " disabled_at INTEGER"
    ") STRICT, WITHOUT ROWID;"
    "CREATE TABLE deliveries ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " webhook TEXT NOT NULL REFERENCES webhooks (id) ON DELETE CASCADE,"
    " event TEXT NOT NULL,"
    " job TEXT NOT NULL,"  /* id; the job may be gone */
    " name TEXT NOT NULL," /* of the job when this was written, as are kind, labels and error */
    " kind TEXT NOT NULL,"
    " labels TEXT NOT NULL,"
    " error TEXT,"
    " state TEXT NOT NULL DEFAULT 'pending' CHECK (state IN ('pending', 'delivered', 'failed')),"
    " created_at INTEGER NOT NULL,"
    " attempts INTEGER NOT NULL DEFAULT 0,"
    " next_attempt_at INTEGER NOT NULL,"
    " last_attempt_at INTEGER,"
    " last_status INTEGER," /* of HTTP; 0: no answer came */
    " last_error TEXT"
    ") STRICT;"
    "CREATE INDEX deliveries_by_webhook ON deliveries (webhook, seq);"
    "CREATE INDEX deliveries_due ON deliveries (webhook, next_attempt_at) WHERE state = 'pending';" DELIVERY_TRIGGERS(
        "", ""),
    /* 5: evaluations of robust searches */
    "ALTER TABLE evaluations ADD COLUMN f_dte_percentile REAL;", /* NULL is NaN */
    /* 6: Idempotency-Keys outlive their jobs, belong to a token ('' without one), and expire */
    "CREATE TABLE submissions ("
    " token TEXT NOT NULL,"
    " key TEXT NOT NULL,"
    " at INTEGER NOT NULL,"
    " job TEXT NOT NULL," /* its id */
    " document TEXT NOT NULL,"
    " PRIMARY KEY (token, key)"
    ") STRICT;"
    "CREATE INDEX submissions_by_time ON submissions (at);"
    "INSERT INTO submissions SELECT coalesce(token, ''), idempotency_key, submitted_at, id, document FROM jobs"
    " WHERE idempotency_key IS NOT NULL;"
    "UPDATE jobs SET idempotency_key = NULL;",
    /* 7: what other systems call the job */
    "ALTER TABLE jobs ADD COLUMN external_id TEXT;"
    "CREATE INDEX jobs_by_external_id ON jobs (external_id, seq) WHERE external_id IS NOT NULL;",
    /* 8: what a job's best is a value of, which was read out of the document for every row of a list */
    "ALTER TABLE jobs ADD COLUMN objective TEXT;" /* NULL: the kind has none, or there are several */
    "UPDATE jobs SET objective = coalesce(json_extract(document, '$.objective'), 'f_dte')"
    " WHERE kind NOT IN ('evaluate', 'reliability') AND json_valid(document)"
    " AND json_type(document, '$.objectives') IS NULL;",
    /* 9: what a job was thought to cost when it was submitted, and finished jobs by age */
    "ALTER TABLE jobs ADD COLUMN estimated_evaluations REAL;"
    "ALTER TABLE jobs ADD COLUMN estimated_s REAL;" /* NULL: submitted before there were estimates */
    "CREATE INDEX jobs_by_end ON jobs (finished_at, seq) WHERE finished_at IS NOT NULL;",
    /* 10: tokens that expire, limits of their own, and when they were used */
    "ALTER TABLE tokens ADD COLUMN expires_at INTEGER;"          /* NULL: never */
    "ALTER TABLE tokens ADD COLUMN last_used_at INTEGER;"        /* NULL: not yet */
    "ALTER TABLE tokens ADD COLUMN requests_per_minute INTEGER;" /* NULL: as the daemon is set, as is the next */
    "ALTER TABLE tokens ADD COLUMN queued_jobs INTEGER;",
    /* 11: no statement's work grows with the jobs that it is not about (tests/server/test_queries.c): labels to be looked
     * up, jobs counted by state, finished jobs that still have their evaluations, wishes to be found after a crash,
     * deliveries by what is asked of them */
    "CREATE TABLE labels ("
    " label TEXT NOT NULL,"
    " job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,"
    " PRIMARY KEY (label, job)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE INDEX labels_by_job ON labels (job);"
    "INSERT OR IGNORE INTO labels SELECT value, seq FROM jobs, json_each(jobs.labels);"
    "CREATE TABLE job_counts (state TEXT PRIMARY KEY, jobs INTEGER NOT NULL) STRICT, WITHOUT ROWID;"
    "INSERT INTO job_counts VALUES ('queued', 0), ('running', 0), ('succeeded', 0), ('failed', 0), ('cancelled', 0);"
    "UPDATE job_counts SET jobs = (SELECT count(*) FROM jobs WHERE jobs.state = job_counts.state);"
    "CREATE TRIGGER count_of_new_job AFTER INSERT ON jobs BEGIN"
    " UPDATE job_counts SET jobs = jobs + 1 WHERE state = NEW.state;"
    "END;"
    "CREATE TRIGGER count_of_change AFTER UPDATE OF state ON jobs WHEN NEW.state <> OLD.state BEGIN"
    " UPDATE job_counts SET jobs = jobs + 1 WHERE state = NEW.state;"
    " UPDATE job_counts SET jobs = jobs - 1 WHERE state = OLD.state;"
    "END;"
    "CREATE TRIGGER count_of_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE job_counts SET jobs = jobs - 1 WHERE state = OLD.state;"
    "END;"
    "ALTER TABLE jobs ADD COLUMN log_dropped INTEGER NOT NULL DEFAULT 0;" /* its evaluations are gone */
    "CREATE INDEX jobs_with_log ON jobs (finished_at, seq) WHERE finished_at IS NOT NULL AND log_dropped = 0;"
    "CREATE INDEX jobs_to_cancel ON jobs (state) WHERE cancel_requested AND state IN ('running', 'queued');"
    "CREATE INDEX deletions_by_id ON deletions (id, revision);"
    "CREATE INDEX deliveries_by_age ON deliveries (created_at) WHERE state <> 'pending';"
    "CREATE INDEX deliveries_by_time ON deliveries (next_attempt_at) WHERE state = 'pending';",
    /* 12: the memory that a job was thought to take */
    "ALTER TABLE jobs ADD COLUMN estimated_memory_mb REAL;", /* NULL: submitted before that was estimated */
    /* 13: deliveries say what another system calls the job */
    "ALTER TABLE deliveries ADD COLUMN external_id TEXT;" /* NULL: the job has none, or this was written before */
    "DROP TRIGGER delivery_of_new_job;"
    "DROP TRIGGER delivery_of_change;" DELIVERY_TRIGGERS(", external_id", ", NEW.external_id"),
};
static_assert(sizeof migrations / sizeof migrations[0] == QG_STORE_FORMAT, "a migration too many, or too few");

static int format_of(sqlite3 *database) {
    sqlite3_stmt *statement = qg_sql_prepare(database, "PRAGMA user_version", "");
    int format = statement && sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_int(statement, 0) : -1;
    sqlite3_finalize(statement);
    return format;
}

bool qg_store_is_known_format(sqlite3 *database) {
    int format = format_of(database);
    return format >= 1 && format <= QG_STORE_FORMAT;
}

bool qg_store_has_audit(sqlite3 *database) {
    return format_of(database) >= 3;
}

static enum qg_store_status run_migration(sqlite3 *database, int from) {
    char version[48];
    snprintf(version, sizeof version, "PRAGMA user_version = %d", from + 1);
    if (sqlite3_exec(database, "BEGIN IMMEDIATE", NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(database, migrations[from], NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(database, version, NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(database, "COMMIT", NULL, NULL, NULL) != SQLITE_OK) {
        enum qg_store_status status = qg_sql_failure(database, "changing the database's format");
        sqlite3_exec(database, "ROLLBACK", NULL, NULL, NULL);
        return status;
    }
    qg_log(QG_LOG_NOTICE, "database: format %d", from + 1);
    return QG_STORE_OK;
}

enum qg_store_status qg_store_migrate_to(sqlite3 *database, int last) {
    int format = format_of(database);
    if (format < 0)
        return qg_sql_failure(database, "reading the database's format");
    if (format > QG_STORE_FORMAT)
        return QG_STORE_WRONG_STATE;
    enum qg_store_status status = QG_STORE_OK;
    while (status == QG_STORE_OK && format < last)
        status = run_migration(database, format++);
    return status;
}

enum qg_store_status qg_store_migrate(sqlite3 *database) {
    return qg_store_migrate_to(database, QG_STORE_FORMAT);
}
