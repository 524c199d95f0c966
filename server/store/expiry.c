/* What is no longer kept. See expiry.h. */
#include "server/store/expiry.h"

#include <stdio.h>

#include "server/store/internal.h"

#define DAY_MS INT64_C(86400000)
#define MEGABYTE INT64_C(1000000)

/* The id in the one row that a statement yields. */
static enum qg_store_status read_id(struct qg_store *store, const char *sql, int64_t argument,
                                    char id[QG_JOB_ID_ROOM]) {
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement = qg_sql_prepare(store->reader, sql, "i", argument);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        snprintf(id, QG_JOB_ID_ROOM, "%s", (const char *)sqlite3_column_text(statement, 0));
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

enum qg_store_status qg_store_expired(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                      char id[QG_JOB_ID_ROOM]) {
    static const char by_age[] = "SELECT id FROM jobs WHERE finished_at < ? ORDER BY finished_at, seq LIMIT 1";
    static const char by_count[] =
        "SELECT id FROM jobs WHERE finished_at IS NOT NULL AND (SELECT sum(jobs) FROM job_counts"
        " WHERE state NOT IN ('queued', 'running')) > ? ORDER BY finished_at, seq LIMIT 1";
    static const char by_size[] =
        "SELECT id FROM jobs WHERE finished_at IS NOT NULL AND (SELECT (page_count - freelist_count) * page_size > ?"
        " FROM pragma_page_count, pragma_freelist_count, pragma_page_size) ORDER BY finished_at, seq LIMIT 1";
    enum qg_store_status status = QG_STORE_NOT_FOUND;
    if (retention->job_days > 0)
        status = read_id(store, by_age, now - retention->job_days * DAY_MS, id);
    if (status == QG_STORE_NOT_FOUND && retention->jobs > 0)
        status = read_id(store, by_count, retention->jobs, id);
    if (status == QG_STORE_NOT_FOUND && retention->megabytes > 0)
        status = read_id(store, by_size, retention->megabytes * MEGABYTE, id);
    return status;
}

enum qg_store_status qg_store_expired_log(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                          char id[QG_JOB_ID_ROOM]) {
    static const char sql[] =
        "SELECT id FROM jobs WHERE finished_at < ? AND log_dropped = 0 ORDER BY finished_at, seq LIMIT 1";
    if (retention->evaluation_days == 0)
        return QG_STORE_NOT_FOUND;
    return read_id(store, sql, now - retention->evaluation_days * DAY_MS, id);
}

enum qg_store_status qg_store_drop_evaluations(struct qg_store *store, const char *id) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    sqlite3_stmt *statement =
        qg_sql_prepare(store->writer, "SELECT seq, finished_at IS NOT NULL FROM jobs WHERE id = ?", "s", id);
    status = qg_sql_row(statement);
    int64_t sequence = status == QG_STORE_OK ? sqlite3_column_int64(statement, 0) : 0;
    if (status == QG_STORE_OK && !sqlite3_column_int(statement, 1))
        status = QG_STORE_WRONG_STATE;
    sqlite3_finalize(statement);
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer,
                            "DELETE FROM evaluations WHERE job = ?1 AND number <"
                            " ?2 + (SELECT min(number) FROM evaluations WHERE job = ?1)",
                            "ii", sequence, (int64_t)QG_EVALUATIONS_AT_ONCE);
    bool none = status == QG_STORE_OK && sqlite3_changes(store->writer) == 0;
    if (none)
        status = qg_sql_run(store->writer, "UPDATE jobs SET log_dropped = 1 WHERE seq = ?", "i", sequence);
    status = qg_store_end(store, status);
    return status == QG_STORE_OK && none ? QG_STORE_NOT_FOUND : status;
}
