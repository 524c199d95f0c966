/* The store as the runner sees it: claims with leases, the log of evaluations, outputs, endings. See store.h. */
#include <config.h>

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "server/base/log.h"
#include "server/store/internal.h"

/* --- claiming --- */

/* A log of another version is not to be continued: its values may differ in the last bits, or in meaning. */
static enum qg_store_status drop_foreign_log(struct qg_store *store, const struct qg_claim *claim,
                                             const char *program) {
    if (!program || strcmp(program, PACKAGE_VERSION) == 0)
        return QG_STORE_OK;
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE, .job = claim->id, .attempt = claim->attempt},
                 "job %s: begins anew, its log was written by version %s", claim->id, program);
    enum qg_store_status status =
        qg_sql_run(store->writer, "DELETE FROM evaluations WHERE job = ?", "i", claim->sequence);
    if (status != QG_STORE_OK)
        return status;
    return qg_sql_run(store->writer, "UPDATE jobs SET best = NULL WHERE seq = ?", "i", claim->sequence);
}

static enum qg_store_status take(struct qg_store *store, int64_t lease, const struct qg_claim *claim) {
    int64_t now = qg_wall_clock();
    return qg_sql_run(store->writer,
                      "UPDATE jobs SET state = 'running', attempt = ?, lease_until = ?, program = ?,"
                      " started_at = coalesce(started_at, ?) WHERE seq = ?",
                      "iisii", claim->attempt, now + lease, PACKAGE_VERSION, now, claim->sequence);
}

/* Reads the next job to be run and takes it. */
static enum qg_store_status claim_next(struct qg_store *store, int64_t lease, struct qg_claim *claim,
                                       struct qg_text *document) {
    sqlite3_stmt *statement = qg_sql_prepare(
        store->writer, /* with OR and ORDER BY, all queued jobs would be read and sorted */
        "SELECT seq, attempt, id, program, document FROM jobs WHERE seq = (SELECT min(seq) FROM"
        " (SELECT min(seq) AS seq FROM jobs WHERE state = 'queued' UNION ALL"
        " SELECT min(seq) FROM jobs WHERE state = 'running' AND lease_until < ? AND NOT cancel_requested))",
        "i", qg_wall_clock());
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK) {
        claim->sequence = sqlite3_column_int64(statement, 0);
        claim->attempt = sqlite3_column_int64(statement, 1) + 1;
        snprintf(claim->id, sizeof claim->id, "%s", (const char *)sqlite3_column_text(statement, 2));
        qg_text_add(document, (const char *)sqlite3_column_text(statement, 4),
                    (size_t)sqlite3_column_bytes(statement, 4));
        status = drop_foreign_log(store, claim, (const char *)sqlite3_column_text(statement, 3));
    }
    sqlite3_finalize(statement);
    if (status == QG_STORE_OK && document->failed)
        status = QG_STORE_FAILED;
    return status == QG_STORE_OK ? take(store, lease, claim) : status;
}

enum qg_store_status qg_store_claim(struct qg_store *store, int64_t lease, struct qg_claim *claim,
                                    struct qg_text *document) {
    enum qg_store_status status = qg_store_begin(store);
    return status == QG_STORE_OK ? qg_store_end(store, claim_next(store, lease, claim, document)) : status;
}

/* --- during an attempt --- */

/* Begins a transaction of an attempt: QG_STORE_LOST when it does not hold the job any more. */
static enum qg_store_status begin_held(struct qg_store *store, const struct qg_claim *claim) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    sqlite3_stmt *statement =
        qg_sql_prepare(store->writer, "SELECT 1 FROM jobs WHERE seq = ? AND attempt = ? AND state = 'running'", "ii",
                       claim->sequence, claim->attempt);
    status = qg_sql_row(statement);
    sqlite3_finalize(statement);
    if (status == QG_STORE_OK)
        return status;
    return qg_store_end(store, status == QG_STORE_NOT_FOUND ? QG_STORE_LOST : status);
}

static enum qg_store_status write_progress(struct qg_store *store, const struct qg_claim *claim,
                                           const struct qg_job_progress *progress) {
    return qg_sql_run(store->writer,
                      "UPDATE jobs SET done = ?, total = ?, phase = ?, eta_s = ?, best = ? WHERE seq = ?", "iisddi",
                      (int64_t)progress->done, (int64_t)progress->total, progress->phase, progress->eta, progress->best,
                      claim->sequence);
}

enum qg_store_status qg_store_heartbeat(struct qg_store *store, const struct qg_claim *claim, int64_t lease,
                                        const struct qg_job_progress *progress) {
    enum qg_store_status status = begin_held(store, claim);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer, "UPDATE jobs SET lease_until = ? WHERE seq = ?", "ii", qg_wall_clock() + lease,
                        claim->sequence);
    if (status == QG_STORE_OK && progress)
        status = write_progress(store, claim, progress);
    return qg_store_end(store, status);
}

static enum qg_store_status insert_evaluation(sqlite3_stmt *statement, const struct qg_evaluation *evaluation) {
    sqlite3_bind_int64(statement, 2, (sqlite3_int64)evaluation->number);
    sqlite3_bind_text(statement, 3, qg_phase_name(evaluation->phase), -1, SQLITE_STATIC);
    for (int i = 0; i < QG_PARAMETER_COUNT; i++)
        sqlite3_bind_double(statement, 4 + i, evaluation->parameter[i]);
    sqlite3_bind_double(statement, 4 + QG_PARAMETER_COUNT, evaluation->f_pps); /* NaN becomes NULL */
    sqlite3_bind_double(statement, 5 + QG_PARAMETER_COUNT, evaluation->f_dte);
    sqlite3_bind_double(statement, 6 + QG_PARAMETER_COUNT, evaluation->f_dte_percentile);
    int code = sqlite3_step(statement);
    enum qg_store_status status = QG_STORE_OK;
    if (code != SQLITE_DONE)
        status = qg_sql_failure(sqlite3_db_handle(statement), "writing an evaluation");
    sqlite3_reset(statement);
    return status;
}

enum qg_store_status qg_store_record(struct qg_store *store, const struct qg_claim *claim,
                                     const struct qg_evaluation *evaluations, size_t n) {
    enum qg_store_status status = begin_held(store, claim);
    if (status != QG_STORE_OK)
        return status;
    sqlite3_stmt *statement =
        qg_sql_prepare(store->writer, "INSERT INTO evaluations VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", "i",
                       claim->sequence);
    status = statement ? QG_STORE_OK : QG_STORE_FAILED;
    for (size_t i = 0; status == QG_STORE_OK && i < n; i++)
        status = insert_evaluation(statement, &evaluations[i]);
    sqlite3_finalize(statement);
    status = qg_store_end(store, status);
    if (status == QG_STORE_OK)
        atomic_fetch_add_explicit(&store->recorded, n, memory_order_relaxed);
    return status;
}

enum qg_store_status qg_store_forget_evaluations(struct qg_store *store, const struct qg_claim *claim, size_t first) {
    enum qg_store_status status = begin_held(store, claim);
    if (status != QG_STORE_OK)
        return status;
    return qg_store_end(store, qg_sql_run(store->writer, "DELETE FROM evaluations WHERE job = ? AND number >= ?", "ii",
                                          claim->sequence, (int64_t)first));
}

static enum qg_store_status write_outputs(struct qg_store *store, const struct qg_claim *claim,
                                          const struct qg_output *outputs, size_t n) {
    enum qg_store_status status = QG_STORE_OK;
    for (size_t i = 0; status == QG_STORE_OK && i < n; i++)
        status = qg_sql_run(store->writer, "INSERT OR REPLACE INTO outputs (job, name, body) VALUES (?, ?, ?)", "iss",
                            claim->sequence, outputs[i].name, outputs[i].body);
    return status;
}

enum qg_store_status qg_store_put_outputs(struct qg_store *store, const struct qg_claim *claim,
                                          const struct qg_output *outputs, size_t n) {
    enum qg_store_status status = begin_held(store, claim);
    return status == QG_STORE_OK ? qg_store_end(store, write_outputs(store, claim, outputs, n)) : status;
}

/* --- the end of an attempt --- */

static enum qg_store_status write_ending(struct qg_store *store, const struct qg_claim *claim,
                                         const struct qg_ending *ending) {
    enum qg_store_status status = write_outputs(store, claim, ending->outputs, ending->output_count);
    if (status == QG_STORE_OK && ending->progress)
        status = write_progress(store, claim, ending->progress);
    if (status != QG_STORE_OK)
        return status;
    if (ending->state == QG_STATE_QUEUED)
        return qg_sql_run(store->writer,
                          "UPDATE jobs SET state = 'queued', lease_until = NULL, eta_s = NULL WHERE seq = ?", "i",
                          claim->sequence);
    return qg_sql_run(store->writer,
                      "UPDATE jobs SET state = ?, error = ?, finished_at = ?, lease_until = NULL, eta_s = NULL"
                      " WHERE seq = ?",
                      "ssii", qg_state_name(ending->state), ending->error, qg_wall_clock(), claim->sequence);
}

enum qg_store_status qg_store_finish(struct qg_store *store, const struct qg_claim *claim,
                                     const struct qg_ending *ending) {
    assert(ending->state != QG_STATE_RUNNING);
    enum qg_store_status status = begin_held(store, claim);
    return status == QG_STORE_OK ? qg_store_end(store, write_ending(store, claim, ending)) : status;
}
