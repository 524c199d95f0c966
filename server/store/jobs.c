/* The store as its readers see it: submitting, listing, cancelling and forgetting jobs, and what they left. See store.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "server/base/token.h"
#include "server/store/internal.h"

#define WORD(name, word) word,
static const char *const state_names[QG_STATE_COUNT] = {QG_STATE_TABLE(WORD)};
#undef WORD

const char *qg_state_name(enum qg_state state) {
    return state_names[state];
}

enum qg_state qg_state_of_name(const char *name) {
    int state = 0;
    while (state < QG_STATE_COUNT && strcmp(state_names[state], name) != 0)
        state++;
    return (enum qg_state)state;
}

bool qg_state_is_final(enum qg_state state) {
    return state == QG_STATE_SUCCEEDED || state == QG_STATE_FAILED || state == QG_STATE_CANCELLED;
}

/* --- rows --- */

void qg_job_row_finish(struct qg_job_row *row) {
    free(row->name);
    free(row->labels);
    free(row->error);
    free(row->external_id);
    row->name = row->labels = row->error = row->external_id = NULL;
}

static const char *phase_of_name(const char *name) {
    for (int phase = 0; name && phase < QG_PHASE_COUNT; phase++)
        if (strcmp(qg_phase_name((enum qg_phase)phase), name) == 0)
            return qg_phase_name((enum qg_phase)phase);
    return NULL;
}

static double double_or_nan(sqlite3_stmt *statement, int column) {
    return sqlite3_column_type(statement, column) == SQLITE_NULL ? (double)NAN
                                                                 : sqlite3_column_double(statement, column);
}

static const char *text_of(sqlite3_stmt *statement, int column) {
    return (const char *)sqlite3_column_text(statement, column);
}

static void copy_text(char *out, size_t room, const char *text) {
    size_t length = strnlen(text, room - 1);
    memcpy(out, text, length);
    out[length] = '\0';
}

enum qg_store_status qg_store_read_row(sqlite3_stmt *statement, struct qg_job_row *row) {
    memset(row, 0, sizeof *row);
    row->sequence = sqlite3_column_int64(statement, 0);
    copy_text(row->id, sizeof row->id, text_of(statement, 1));
    copy_text(row->kind, sizeof row->kind, text_of(statement, 2));
    row->state = qg_state_of_name(text_of(statement, 3));
    row->cancel_requested = sqlite3_column_int(statement, 4);
    row->submitted_at = sqlite3_column_int64(statement, 5);
    row->started_at = sqlite3_column_int64(statement, 6);
    row->finished_at = sqlite3_column_int64(statement, 7);
    row->progress.done = (size_t)sqlite3_column_int64(statement, 8);
    row->progress.total = (size_t)sqlite3_column_int64(statement, 9);
    row->progress.phase = phase_of_name(text_of(statement, 10));
    row->progress.eta = double_or_nan(statement, 11);
    row->progress.best = double_or_nan(statement, 12);
    const char *error = text_of(statement, 15), *external_id = text_of(statement, 16),
               *objective = text_of(statement, 17);
    row->as_of = sqlite3_column_int64(statement, 18);
    row->estimate.evaluations = double_or_nan(statement, 19);
    row->estimate.seconds = double_or_nan(statement, 20);
    row->estimate.memory_mb = double_or_nan(statement, 21);
    row->name = strdup(text_of(statement, 13));
    row->labels = strdup(text_of(statement, 14));
    row->error = error ? strdup(error) : NULL;
    row->external_id = external_id ? strdup(external_id) : NULL;
    copy_text(row->objective, sizeof row->objective, objective ? objective : "");
    if (row->name && row->labels && (row->error || !error) && (row->external_id || !external_id))
        return QG_STORE_OK;
    qg_job_row_finish(row);
    return QG_STORE_FAILED;
}

/* Reads the one row that a statement yields, and finalizes it. */
static enum qg_store_status read_one(sqlite3_stmt *statement, struct qg_job_row *row) {
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        status = qg_store_read_row(statement, row);
    sqlite3_finalize(statement);
    return status;
}

/* --- submitting --- */

/* 48 bits of time in milliseconds and 80 random ones, in Crockford's base 32: short, and sorted by time. */
static bool make_id(char id[QG_JOB_ID_ROOM], int64_t now) {
    static const char digits[] = "0123456789abcdefghjkmnpqrstvwxyz";
    unsigned char noise[QG_JOB_ID_LENGTH];
    if (getrandom(noise, sizeof noise, 0) != (ssize_t)sizeof noise)
        return false;
    for (int i = 9; i >= 0; i--, now /= 32)
        id[i] = digits[now % 32];
    for (int i = 10; i < QG_JOB_ID_LENGTH; i++)
        id[i] = digits[noise[i] % 32];
    id[QG_JOB_ID_LENGTH] = '\0';
    return true;
}

/* The token that submits; NULL when there is none. */
static const char *token_of(const struct qg_submission *submission) {
    return submission->actor && *submission->actor->token ? submission->actor->token : NULL;
}

/* What became of an earlier submission with the same key: QG_STORE_NOT_FOUND, _REPEATED with its row, or _KEY_REUSED. The row
 * is that of the job when it was new, which its document, its id and its time determine: the same answer comes again,
 * whatever the job has become. */
static enum qg_store_status find_repeated(struct qg_store *store, const struct qg_submission *submission,
                                          struct qg_job_row *row) {
    const char *token = token_of(submission);
    sqlite3_stmt *statement = qg_sql_prepare(
        store->writer,
        "SELECT " QG_JOB_COLUMNS
        ", document FROM (SELECT 0 AS seq, job AS id, ? AS kind, ? AS objective, 'queued' AS state,"
        " 0 AS cancel_requested, at AS submitted_at, NULL AS started_at, NULL AS finished_at, 0 AS done, 0 AS total,"
        " NULL AS phase, NULL AS eta_s, NULL AS best, ? AS name, ? AS labels, NULL AS error, ? AS external_id, "
        "document,"
        " ? AS estimated_evaluations, ? AS estimated_s, ? AS estimated_memory_mb FROM submissions WHERE token = ? AND "
        "key = ? AND at > ?)",
        "sssssdddssi", submission->kind, submission->objective, submission->name, submission->labels,
        submission->external_id, submission->estimate.evaluations, submission->estimate.seconds,
        submission->estimate.memory_mb, token ? token : "", submission->idempotency_key,
        qg_wall_clock() - QG_KEY_LIFETIME_MS);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK && strcmp(text_of(statement, 22), submission->document) != 0)
        status = QG_STORE_KEY_REUSED;
    if (status == QG_STORE_OK) {
        status = qg_store_read_row(statement, row);
        if (status == QG_STORE_OK)
            status = QG_STORE_REPEATED;
    }
    sqlite3_finalize(statement);
    return status;
}

/* Remembers the key of a new job, and forgets some of those whose time is over. */
static enum qg_store_status remember_key(struct qg_store *store, const struct qg_submission *submission, const char *id,
                                         int64_t now) {
    const char *token = token_of(submission);
    if (!submission->idempotency_key)
        return QG_STORE_OK;
    enum qg_store_status status = qg_sql_run(store->writer,
                                             "DELETE FROM submissions WHERE rowid IN"
                                             " (SELECT rowid FROM submissions WHERE at <= ? ORDER BY at LIMIT 100)",
                                             "i", now - QG_KEY_LIFETIME_MS);
    if (status != QG_STORE_OK)
        return status;
    return qg_sql_run(store->writer,
                      "INSERT OR REPLACE INTO submissions (token, key, at, job, document) VALUES (?, ?, ?, ?, ?)",
                      "ssiss", token ? token : "", submission->idempotency_key, now, id, submission->document);
}

/* QG_STORE_QUEUE_FULL when the submitter's token has as many jobs as it may. */
static enum qg_store_status check_queue(struct qg_store *store, const struct qg_submission *submission) {
    if (submission->queue_limit == 0 || !token_of(submission))
        return QG_STORE_OK;
    sqlite3_stmt *statement =
        qg_sql_prepare(store->writer, "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running') AND token = ?",
                       "s", token_of(submission));
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK && sqlite3_column_int64(statement, 0) >= submission->queue_limit)
        status = QG_STORE_QUEUE_FULL;
    sqlite3_finalize(statement);
    return status;
}

static enum qg_store_status insert_job(struct qg_store *store, const struct qg_submission *submission,
                                       struct qg_job_row *row) {
    char id[QG_JOB_ID_ROOM];
    int64_t now = qg_wall_clock();
    if (!make_id(id, now))
        return QG_STORE_FAILED;
    enum qg_store_status status = qg_sql_run(
        store->writer,
        "INSERT INTO jobs (id, name, kind, objective, labels, state, submitted_at, document, token, external_id,"
        " estimated_evaluations, estimated_s, estimated_memory_mb)"
        " VALUES (?, ?, ?, ?, ?, 'queued', ?, ?, ?, ?, ?, ?, ?)",
        "sssssisssddd", id, submission->name, submission->kind, submission->objective, submission->labels, now,
        submission->document, token_of(submission), submission->external_id, submission->estimate.evaluations,
        submission->estimate.seconds, submission->estimate.memory_mb);
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer, "INSERT OR IGNORE INTO labels SELECT value, ?1 FROM json_each(?2)", "is",
                            (int64_t)sqlite3_last_insert_rowid(store->writer), submission->labels);
    if (status == QG_STORE_OK)
        status = remember_key(store, submission, id, now);
    status = qg_store_audited(store, status, submission->actor, "job.submit", id);
    if (status != QG_STORE_OK)
        return status;
    return read_one(qg_sql_prepare(store->writer, "SELECT " QG_JOB_COLUMNS " FROM jobs WHERE id = ?", "s", id), row);
}

enum qg_store_status qg_store_submit(struct qg_store *store, const struct qg_submission *submission,
                                     struct qg_job_row *row) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = submission->idempotency_key ? find_repeated(store, submission, row) : QG_STORE_NOT_FOUND;
    bool inserted = status == QG_STORE_NOT_FOUND;
    if (inserted)
        status = check_queue(store, submission);
    if (inserted && status == QG_STORE_OK)
        status = insert_job(store, submission, row);
    bool readable = status == QG_STORE_OK;
    status = qg_store_end(store, status);
    if (readable && status != QG_STORE_OK)
        qg_job_row_finish(row);
    return status;
}

/* --- reading --- */

enum qg_store_status qg_store_job(struct qg_store *store, const char *id, struct qg_job_row *row) {
    pthread_mutex_lock(&store->reader_mutex);
    enum qg_store_status status =
        read_one(qg_sql_prepare(store->reader, "SELECT " QG_JOB_COLUMNS " FROM jobs WHERE id = ?", "s", id), row);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

/* Reads up to filter->limit rows of a list that asks for one more; *next is then where that begins. */
static enum qg_store_status read_page(sqlite3_stmt *statement, const struct qg_job_filter *filter,
                                      struct qg_job_row *rows, size_t *count, int64_t *next) {
    enum qg_store_status status = qg_sql_row(statement);
    while (status == QG_STORE_OK && *count < filter->limit) {
        status = qg_store_read_row(statement, &rows[*count]);
        if (status != QG_STORE_OK)
            break;
        ++*count;
        status = qg_sql_row(statement);
    }
    if (status == QG_STORE_OK)
        *next = rows[*count - 1].sequence;
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

/* The statement for a filter. Each is written so that SQLite goes along the one index that leaves the fewest rows and is in
 * the list's order: a condition that may be absent ("?2 IS NULL OR ...") would make it read all jobs. */
static const char *list_sql(const struct qg_job_filter *filter) {
#define LIST(rest) "SELECT " QG_JOB_COLUMNS " FROM " rest " LIMIT ?6"
    if (filter->external_id)
        return LIST("jobs WHERE external_id = ?4 AND seq < ?1 AND (?2 IS NULL OR +state = ?2)"
                    " AND (?3 IS NULL OR EXISTS (SELECT 1 FROM labels WHERE label = ?3 AND job = seq))"
                    " ORDER BY seq DESC");
    if (filter->label)
        return LIST("labels CROSS JOIN jobs ON seq = job WHERE label = ?3 AND job < ?1 AND job > ?5"
                    " AND (?2 IS NULL OR +state = ?2) ORDER BY job DESC");
    if (filter->state != QG_STATE_COUNT)
        return LIST("jobs WHERE state = ?2 AND seq < ?1 ORDER BY seq DESC");
    return LIST("jobs WHERE seq < ?1 ORDER BY seq DESC");
#undef LIST
}

/* Where a page that looks for a state among the jobs of a label gives up: the sequence of the last job that it does not look
 * at, 0 when it looks at all. The reader's mutex is held. */
static enum qg_store_status find_floor(struct qg_store *store, const struct qg_job_filter *filter, int64_t before,
                                       int64_t *floor) {
    *floor = 0;
    if (!filter->label || filter->external_id || filter->state == QG_STATE_COUNT)
        return QG_STORE_OK;
    sqlite3_stmt *statement = qg_sql_prepare(
        store->reader, "SELECT job FROM labels WHERE label = ? AND job < ? ORDER BY job DESC LIMIT 1 OFFSET ?", "sii",
        filter->label, before, (int64_t)QG_LIST_LOOKS);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        *floor = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

enum qg_store_status qg_store_list(struct qg_store *store, const struct qg_job_filter *filter, struct qg_job_row *rows,
                                   size_t *count, int64_t *next) {
    int64_t before = filter->before > 0 ? filter->before : INT64_MAX, floor;
    *count = 0;
    *next = 0;
    pthread_mutex_lock(&store->reader_mutex);
    enum qg_store_status status = find_floor(store, filter, before, &floor);
    if (status == QG_STORE_OK) {
        sqlite3_stmt *statement = qg_sql_prepare(store->reader, list_sql(filter), "isssii", before,
                                                 filter->state == QG_STATE_COUNT ? NULL : qg_state_name(filter->state),
                                                 filter->label, filter->external_id, floor, (int64_t)filter->limit + 1);
        status = read_page(statement, filter, rows, count, next);
        sqlite3_finalize(statement);
    }
    pthread_mutex_unlock(&store->reader_mutex);
    if (status == QG_STORE_OK && *next == 0 && floor > 0)
        *next = floor + 1;
    while (status != QG_STORE_OK && *count > 0)
        qg_job_row_finish(&rows[--*count]);
    return status;
}

enum qg_store_status qg_store_revision(struct qg_store *store, int64_t *revision) {
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement = qg_sql_prepare(store->reader, "SELECT last FROM revision", "");
    enum qg_store_status status = qg_sql_row(statement);
    *revision = status == QG_STORE_OK ? sqlite3_column_int64(statement, 0) : 0;
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

static void read_change(sqlite3_stmt *statement, struct qg_change *out) {
    out->revision = sqlite3_column_int64(statement, 0);
    copy_text(out->id, sizeof out->id, text_of(statement, 1));
    out->deleted = sqlite3_column_int(statement, 2);
}

enum qg_store_status qg_store_changes(struct qg_store *store, int64_t since, const char *id, struct qg_change *out,
                                      size_t room, size_t *count) {
    *count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader,
                       id ? "SELECT revision, id, 0 FROM jobs WHERE id = ?2 AND revision > ?1"
                            " UNION ALL SELECT revision, id, 1 FROM deletions WHERE id = ?2 AND revision > ?1"
                            " ORDER BY revision LIMIT ?3"
                          : "SELECT revision, id, 0 FROM jobs WHERE revision > ?1"
                            " UNION ALL SELECT revision, id, 1 FROM deletions WHERE revision > ?1"
                            " ORDER BY revision LIMIT ?3",
                       "isi", since, id, (int64_t)room);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        read_change(statement, &out[(*count)++]);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

/* Appends the text that a statement of the reader yields, and finalizes it. The reader's mutex is held. */
static enum qg_store_status read_text(sqlite3_stmt *statement, struct qg_text *text) {
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        qg_text_add(text, text_of(statement, 0), (size_t)sqlite3_column_bytes(statement, 0));
    sqlite3_finalize(statement);
    return status == QG_STORE_OK && text->failed ? QG_STORE_FAILED : status;
}

enum qg_store_status qg_store_output(struct qg_store *store, const char *id, const char *name, struct qg_text *text) {
    pthread_mutex_lock(&store->reader_mutex);
    enum qg_store_status status =
        read_text(qg_sql_prepare(store->reader,
                                 "SELECT body FROM outputs JOIN jobs ON seq = job WHERE id = ? AND outputs.name = ?",
                                 "ss", id, name),
                  text);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

enum qg_store_status qg_store_document(struct qg_store *store, const char *id, struct qg_text *text) {
    pthread_mutex_lock(&store->reader_mutex);
    enum qg_store_status status =
        read_text(qg_sql_prepare(store->reader, "SELECT document FROM jobs WHERE id = ?", "s", id), text);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

static void read_evaluation(sqlite3_stmt *statement, struct qg_evaluation *out) {
    out->number = (size_t)sqlite3_column_int64(statement, 0);
    const char *phase = phase_of_name(text_of(statement, 1));
    for (int i = 0; i < QG_PHASE_COUNT; i++)
        if (phase == qg_phase_name((enum qg_phase)i))
            out->phase = (enum qg_phase)i;
    for (int i = 0; i < QG_PARAMETER_COUNT; i++)
        out->parameter[i] = sqlite3_column_double(statement, 2 + i);
    out->f_pps = double_or_nan(statement, 2 + QG_PARAMETER_COUNT);
    out->f_dte = double_or_nan(statement, 3 + QG_PARAMETER_COUNT);
    out->f_dte_percentile = double_or_nan(statement, 4 + QG_PARAMETER_COUNT);
}

enum qg_store_status qg_store_evaluations(struct qg_store *store, int64_t sequence, size_t first, size_t room,
                                          struct qg_evaluation *out, size_t *count) {
    *count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader,
                       "SELECT number, phase, pinion_tip_start_radius, pinion_tip_amplitude, pinion_root_end_radius,"
                       " pinion_root_amplitude, gear_tip_start_radius, gear_tip_amplitude, gear_root_end_radius,"
                       " gear_root_amplitude, f_pps, f_dte, f_dte_percentile"
                       " FROM evaluations WHERE job = ? AND number >= ? ORDER BY number LIMIT ?",
                       "iii", sequence, (int64_t)first, (int64_t)room);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        read_evaluation(statement, &out[(*count)++]);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

enum qg_store_status qg_store_evaluation_end(struct qg_store *store, int64_t sequence, size_t *end) {
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement = qg_sql_prepare(
        store->reader,
        "SELECT coalesce((SELECT max(number) + 1 FROM evaluations WHERE job = seq), 0) FROM jobs WHERE seq = ?", "i",
        sequence);
    enum qg_store_status status = qg_sql_row(statement);
    *end = status == QG_STORE_OK ? (size_t)sqlite3_column_int64(statement, 0) : 0;
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

/* --- cancelling and forgetting --- */

/* The state of a job inside the writer's transaction. */
static enum qg_store_status state_of(struct qg_store *store, const char *id, enum qg_state *state) {
    sqlite3_stmt *statement = qg_sql_prepare(store->writer, "SELECT state FROM jobs WHERE id = ?", "s", id);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        *state = qg_state_of_name(text_of(statement, 0));
    sqlite3_finalize(statement);
    return status;
}

static enum qg_store_status cancel(struct qg_store *store, const char *id, enum qg_state state) {
    switch (state) {
    case QG_STATE_QUEUED:
        return qg_sql_run(store->writer,
                          "UPDATE jobs SET state = 'cancelled', finished_at = ?, eta_s = NULL WHERE id = ?", "is",
                          qg_wall_clock(), id);
    case QG_STATE_RUNNING:
        return qg_sql_run(store->writer, "UPDATE jobs SET cancel_requested = 1 WHERE id = ?", "s", id);
    case QG_STATE_CANCELLED:
        return QG_STORE_OK;
    default:
        return QG_STORE_WRONG_STATE;
    }
}

enum qg_store_status qg_store_cancel(struct qg_store *store, const char *id, const struct qg_actor *actor) {
    enum qg_state state = QG_STATE_COUNT;
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = state_of(store, id, &state);
    if (status == QG_STORE_OK)
        status = cancel(store, id, state);
    return qg_store_end(store, qg_store_audited(store, status, actor, "job.cancel", id));
}

enum qg_store_status qg_store_delete(struct qg_store *store, const char *id, const struct qg_actor *actor) {
    enum qg_state state = QG_STATE_COUNT;
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = state_of(store, id, &state);
    if (status == QG_STORE_OK && state == QG_STATE_RUNNING)
        status = QG_STORE_WRONG_STATE;
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer, "DELETE FROM jobs WHERE id = ?", "s", id);
    return qg_store_end(store, qg_store_audited(store, status, actor, "job.delete", id));
}
