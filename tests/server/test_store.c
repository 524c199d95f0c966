/* The store, on real databases in temporary directories: the queue's promises, the log's bits, what survives what. */
#include "tests/server/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/store/internal.h"
#include "server/store/webhooks.h"

enum { LEASE = 60000, EXPIRED = -1000 };

/* A store in a directory of its own. */
struct place {
    char directory[32];
    struct qg_store *store;
};

static struct qg_store *open_store(const char *directory) {
    char message[QG_STORE_MESSAGE_ROOM] = "";
    struct qg_store *store = qg_store_open(directory, message);
    if (!store)
        fail_msg("%s", message);
    return store;
}

static int make_place(void **state) {
    struct place *place = calloc(1, sizeof *place);
    strcpy(place->directory, "/tmp/quietgear-XXXXXX");
    assert_non_null(mkdtemp(place->directory));
    place->store = open_store(place->directory);
    *state = place;
    return 0;
}

static int remove_place(void **state) {
    struct place *place = *state;
    static const char *const names[] = {"quietgear.db", "quietgear.db-wal", "quietgear.db-shm", "lock"};
    qg_store_close(place->store);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char path[64];
        snprintf(path, sizeof path, "%s/%s", place->directory, names[i]);
        unlink(path);
    }
    rmdir(place->directory);
    free(place);
    return 0;
}

static void reopen(struct place *place) {
    qg_store_close(place->store);
    place->store = open_store(place->directory);
}

/* Submits a document that is only a text here, and keeps its id. */
static void submit(struct qg_store *store, const char *document, char id[QG_JOB_ID_ROOM]) {
    struct qg_job_row row;
    const struct qg_submission submission = {
        .name = "a name", .kind = "optimize", .labels = "[\"blue\",\"red\"]", .document = document};
    assert_int_equal(qg_store_submit(store, &submission, &row), QG_STORE_OK);
    memcpy(id, row.id, QG_JOB_ID_ROOM);
    qg_job_row_finish(&row);
}

static struct qg_claim claim(struct qg_store *store, int64_t lease, const char *document) {
    struct qg_claim claim;
    struct qg_text text = {0};
    assert_int_equal(qg_store_claim(store, lease, &claim, &text), QG_STORE_OK);
    assert_string_equal(text.data, document);
    qg_text_finish(&text);
    return claim;
}

static void assert_idle(struct qg_store *store) {
    struct qg_claim claim;
    struct qg_text text = {0};
    assert_int_equal(qg_store_claim(store, LEASE, &claim, &text), QG_STORE_NOT_FOUND);
    qg_text_finish(&text);
}

static enum qg_state state_of(struct qg_store *store, const char *id) {
    struct qg_job_row row;
    assert_int_equal(qg_store_job(store, id, &row), QG_STORE_OK);
    qg_job_row_finish(&row);
    return row.state;
}

static enum qg_store_status end(struct qg_store *store, const struct qg_claim *claim, enum qg_state state) {
    return qg_store_finish(store, claim, &(struct qg_ending){.state = state});
}

/* --- jobs --- */

static void keeps_what_was_submitted(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM], other[QG_JOB_ID_ROOM];
    struct qg_job_row row;
    submit(place->store, "{}", id);
    submit(place->store, "{}", other);
    assert_string_not_equal(id, other);
    assert_int_equal(strlen(id), QG_JOB_ID_LENGTH);
    reopen(place);
    assert_int_equal(qg_store_job(place->store, id, &row), QG_STORE_OK);
    assert_string_equal(row.name, "a name");
    assert_string_equal(row.kind, "optimize");
    assert_string_equal(row.labels, "[\"blue\",\"red\"]");
    assert_int_equal(row.state, QG_STATE_QUEUED);
    assert_true(row.submitted_at > 1500000000000 && row.submitted_at <= qg_wall_clock());
    assert_int_equal(row.started_at, 0);
    assert_null(row.error);
    assert_null(row.progress.phase);
    assert_true(isnan(row.progress.best));
    qg_job_row_finish(&row);
    assert_int_equal(qg_store_job(place->store, "nobody", &row), QG_STORE_NOT_FOUND);
}

static void repeats_by_key(void **state) {
    struct place *place = *state;
    struct qg_job_row first, again;
    struct qg_submission submission = {
        .name = "", .kind = "optimize", .labels = "[]", .document = "{\"a\":1}", .idempotency_key = "key"};
    assert_int_equal(qg_store_submit(place->store, &submission, &first), QG_STORE_OK);
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_REPEATED);
    assert_string_equal(first.id, again.id);
    assert_int_equal(first.submitted_at, again.submitted_at);
    qg_job_row_finish(&again);
    reopen(place);
    assert_int_equal(qg_store_delete(place->store, first.id, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_REPEATED);
    assert_string_equal(first.id, again.id);
    qg_job_row_finish(&again);
    submission.document = "{\"a\":2}";
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_KEY_REUSED);
    submission.idempotency_key = "other";
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_OK);
    assert_string_not_equal(first.id, again.id);
    qg_job_row_finish(&first);
    qg_job_row_finish(&again);
}

static void forgets_keys_in_time(void **state) {
    struct place *place = *state;
    struct qg_job_row first, again;
    const struct qg_submission submission = {
        .name = "", .kind = "optimize", .labels = "[]", .document = "{}", .idempotency_key = "key"};
    assert_int_equal(qg_store_submit(place->store, &submission, &first), QG_STORE_OK);
    assert_int_equal(
        qg_sql_run(place->store->writer, "UPDATE submissions SET at = at - ?", "i", (int64_t)QG_KEY_LIFETIME_MS),
        QG_STORE_OK);
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_OK);
    assert_string_not_equal(first.id, again.id);
    qg_job_row_finish(&first);
    qg_job_row_finish(&again);
}

/* Puts an empty database of an old format in the place of the store's, and opens it: the caller fills and closes it. */
static sqlite3 *age(struct place *place, int format) {
    char path[64];
    sqlite3 *database;
    qg_store_close(place->store);
    place->store = NULL;
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    unlink(path);
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(qg_store_migrate_to(database, format), QG_STORE_OK);
    return database;
}

/* A database of format 3 kept its keys with the jobs. */
static void takes_keys_over(void **state) {
    struct place *place = *state;
    struct qg_job_row again;
    const struct qg_submission submission = {
        .name = "n", .kind = "optimize", .labels = "[]", .document = "{}", .idempotency_key = "key"};
    sqlite3 *database = age(place, 3);
    assert_int_equal(qg_sql_run(database,
                                "INSERT INTO jobs (id, name, kind, labels, state, idempotency_key, submitted_at,"
                                " document) VALUES ('old', 'n', 'optimize', '[]', 'succeeded', 'key', ?, '{}')",
                                "i", qg_wall_clock()),
                     QG_STORE_OK);
    sqlite3_close(database);
    place->store = open_store(place->directory);
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_REPEATED);
    assert_string_equal(again.id, "old");
    assert_int_equal(again.state, QG_STATE_QUEUED); /* as it was answered then */
    qg_job_row_finish(&again);
}

static void assert_objective(struct qg_store *store, const char *id, const char *objective) {
    struct qg_job_row row;
    assert_int_equal(qg_store_job(store, id, &row), QG_STORE_OK);
    assert_string_equal(row.objective, objective);
    qg_job_row_finish(&row);
}

/* A database of format 7 had the objective in the document only. */
static void takes_objectives_over(void **state) {
    static const char *const jobs[][4] = {
        {"a", "optimize", "{\"objective\":\"f_dte_percentile\"}", "f_dte_percentile"},
        {"b", "map", "{}", "f_dte"},
        {"c", "optimize", "{\"objectives\":[\"f_dte\",\"f_pps\"]}", ""},
        {"d", "evaluate", "{}", ""},
        {"e", "optimize", "no JSON", ""},
    };
    struct place *place = *state;
    sqlite3 *database = age(place, 7);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; i++)
        assert_int_equal(qg_sql_run(database,
                                    "INSERT INTO jobs (id, name, kind, labels, state, submitted_at, document)"
                                    " VALUES (?, '', ?, '[]', 'failed', 1, ?)",
                                    "sss", jobs[i][0], jobs[i][1], jobs[i][2]),
                         QG_STORE_OK);
    sqlite3_close(database);
    place->store = open_store(place->directory);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; i++)
        assert_objective(place->store, jobs[i][0], jobs[i][3]);
}

/* A database of format 12 did not say in deliveries what another system calls the job: those that wait there are sent
 * without, and what happens from now on is told with it. */
static void takes_deliveries_over(void **state) {
    static const char *const told[][2] = {{"\"job.queued\"", "\"external_id\":null"},
                                          {"\"job.cancelled\"", "\"external_id\":\"4711\""}};
    struct place *place = *state;
    static struct qg_dispatch due[QG_WEBHOOKS_MAX];
    size_t count;
    int64_t next;
    sqlite3 *database = age(place, 12);
    assert_int_equal(
        sqlite3_exec(database,
                     "INSERT INTO webhooks (id, url, events, secret, created_at) VALUES ('w1', '', 1, '', 1),"
                     " ('w2', '', 16, '', 1); INSERT INTO jobs (id, name, kind, labels, state, external_id,"
                     " submitted_at, document) VALUES ('old', '', 'map', '[]', 'queued', '4711', 1, '{}')",
                     NULL, NULL, NULL),
        SQLITE_OK);
    sqlite3_close(database);
    place->store = open_store(place->directory);
    assert_int_equal(qg_store_cancel(place->store, "old", NULL), QG_STORE_OK);
    assert_int_equal(qg_store_due(place->store, INT64_MAX, due, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 2);
    for (size_t i = 0; i < count; i++) {
        assert_non_null(strstr(due[i].body, told[i][0]));
        assert_non_null(strstr(due[i].body, told[i][1]));
        qg_dispatch_finish(&due[i]);
    }
}

static void keeps_the_objective(void **state) {
    struct place *place = *state;
    struct qg_job_row first, again;
    const struct qg_submission submission = {.name = "",
                                             .kind = "optimize",
                                             .objective = "f_dte_percentile",
                                             .labels = "[]",
                                             .document = "{}",
                                             .idempotency_key = "key"};
    assert_int_equal(qg_store_submit(place->store, &submission, &first), QG_STORE_OK);
    assert_int_equal(qg_store_submit(place->store, &submission, &again), QG_STORE_REPEATED);
    assert_string_equal(first.objective, "f_dte_percentile");
    assert_string_equal(again.objective, "f_dte_percentile");
    assert_objective(place->store, first.id, "f_dte_percentile");
    qg_job_row_finish(&first);
    qg_job_row_finish(&again);
}

static void lists_newest_first(void **state) {
    struct place *place = *state;
    char ids[5][QG_JOB_ID_ROOM];
    struct qg_job_row rows[3];
    size_t count;
    int64_t next;
    for (int i = 0; i < 5; i++)
        submit(place->store, "{}", ids[i]);
    assert_int_equal(qg_store_cancel(place->store, ids[1], NULL), QG_STORE_OK);
    struct qg_job_filter filter = {.state = QG_STATE_COUNT, .limit = 3};
    assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 3);
    assert_int_equal(next, rows[2].sequence);
    filter.before = next;
    for (int i = 0; i < 3; i++) {
        assert_string_equal(rows[i].id, ids[4 - i]);
        qg_job_row_finish(&rows[i]);
    }
    assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 2);
    assert_int_equal(next, 0);
    qg_job_row_finish(&rows[0]);
    qg_job_row_finish(&rows[1]);
    filter = (struct qg_job_filter){.state = QG_STATE_CANCELLED, .label = "red", .limit = 3};
    assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 1);
    assert_string_equal(rows[0].id, ids[1]);
    qg_job_row_finish(&rows[0]);
    filter.label = "re";
    assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 0);
}

/* A state that is rare among the jobs of a label is found by going on from pages that hold nothing. */
static void gives_up_a_page_and_goes_on(void **state) {
    struct place *place = *state;
    struct qg_job_row rows[3];
    struct qg_job_filter filter = {.state = QG_STATE_CANCELLED, .label = "red", .limit = 3};
    char id[QG_JOB_ID_ROOM], sql[400];
    size_t count = 0, pages = 0;
    submit(place->store, "{}", id);
    assert_int_equal(qg_store_cancel(place->store, id, NULL), QG_STORE_OK);
    snprintf(sql, sizeof sql,
             "WITH RECURSIVE number(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM number WHERE i < %d)"
             " INSERT INTO jobs (id, name, kind, labels, state, submitted_at, document)"
             " SELECT 'job' || i, '', 'evaluate', '[\"red\"]', 'queued', 1, '{}' FROM number",
             2 * QG_LIST_LOOKS);
    assert_int_equal(sqlite3_exec(place->store->writer, sql, NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_exec(place->store->writer, "INSERT OR IGNORE INTO labels SELECT 'red', seq FROM jobs",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    do {
        assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &filter.before), QG_STORE_OK);
        pages++;
    } while (count == 0 && filter.before > 0);
    assert_int_equal(pages, 3);
    assert_int_equal(count, 1);
    assert_string_equal(rows[0].id, id);
    qg_job_row_finish(&rows[0]);
}

/* --- the queue --- */

static void claims_the_oldest_once(void **state) {
    struct place *place = *state;
    char first[QG_JOB_ID_ROOM], second[QG_JOB_ID_ROOM];
    submit(place->store, "one", first);
    submit(place->store, "two", second);
    struct qg_claim one = claim(place->store, LEASE, "one"), two = claim(place->store, LEASE, "two");
    assert_string_equal(one.id, first);
    assert_string_equal(two.id, second);
    assert_idle(place->store);
    assert_int_equal(state_of(place->store, first), QG_STATE_RUNNING);
    assert_int_equal(end(place->store, &one, QG_STATE_SUCCEEDED), QG_STORE_OK);
    assert_int_equal(state_of(place->store, first), QG_STATE_SUCCEEDED);
    assert_int_equal(end(place->store, &one, QG_STATE_FAILED), QG_STORE_LOST);
    assert_int_equal(end(place->store, &two, QG_STATE_QUEUED), QG_STORE_OK);
    assert_int_equal(claim(place->store, LEASE, "two").attempt, 2);
}

static void a_stale_attempt_writes_nothing(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    size_t end_of_log;
    const struct qg_evaluation evaluation = {.number = 0, .phase = QG_PHASE_REFERENCE};
    const struct qg_output output = {QG_OUTPUT_RESULT, "{}"};
    submit(place->store, "{}", id);
    struct qg_claim stale = claim(place->store, EXPIRED, "{}");
    struct qg_claim fresh = claim(place->store, LEASE, "{}");
    assert_int_equal(fresh.attempt, stale.attempt + 1);
    assert_int_equal(qg_store_heartbeat(place->store, &stale, LEASE, NULL), QG_STORE_LOST);
    assert_int_equal(qg_store_record(place->store, &stale, &evaluation, 1), QG_STORE_LOST);
    assert_int_equal(qg_store_put_outputs(place->store, &stale, &output, 1), QG_STORE_LOST);
    assert_int_equal(qg_store_forget_evaluations(place->store, &stale, 0), QG_STORE_LOST);
    assert_int_equal(end(place->store, &stale, QG_STATE_FAILED), QG_STORE_LOST);
    assert_int_equal(qg_store_evaluation_end(place->store, fresh.sequence, &end_of_log), QG_STORE_OK);
    assert_int_equal(end_of_log, 0);
    assert_int_equal(qg_store_record(place->store, &fresh, &evaluation, 1), QG_STORE_OK);
    assert_int_equal(end(place->store, &fresh, QG_STATE_SUCCEEDED), QG_STORE_OK);
}

static void a_heartbeat_keeps_the_claim(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    struct qg_job_row row;
    const struct qg_job_progress progress = {
        .done = 3, .total = 8, .phase = qg_phase_name(QG_PHASE_RANDOM), .eta = 1.5, .best = 0.1 + 0.2};
    submit(place->store, "{}", id);
    struct qg_claim held = claim(place->store, EXPIRED, "{}");
    assert_int_equal(qg_store_heartbeat(place->store, &held, LEASE, &progress), QG_STORE_OK);
    assert_idle(place->store);
    assert_int_equal(qg_store_job(place->store, id, &row), QG_STORE_OK);
    assert_int_equal(row.progress.done, 3);
    assert_int_equal(row.progress.total, 8);
    assert_string_equal(row.progress.phase, "random");
    assert_true(row.progress.best == 0.1 + 0.2);
    qg_job_row_finish(&row);
}

static void cancels_and_deletes(void **state) {
    struct place *place = *state;
    char queued[QG_JOB_ID_ROOM], running[QG_JOB_ID_ROOM];
    size_t end_of_log;
    struct qg_text text = {0};
    const struct qg_evaluation evaluation = {.number = 0};
    const struct qg_output output = {QG_OUTPUT_RESULT, "{}"};
    submit(place->store, "{}", running);
    struct qg_claim held = claim(place->store, LEASE, "{}");
    submit(place->store, "{}", queued);
    assert_int_equal(qg_store_cancel(place->store, queued, NULL), QG_STORE_OK);
    assert_int_equal(state_of(place->store, queued), QG_STATE_CANCELLED);
    assert_int_equal(qg_store_cancel(place->store, queued, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_delete(place->store, queued, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_delete(place->store, queued, NULL), QG_STORE_NOT_FOUND);
    assert_int_equal(qg_store_cancel(place->store, running, NULL), QG_STORE_OK);
    assert_int_equal(state_of(place->store, running), QG_STATE_RUNNING);
    assert_int_equal(qg_store_delete(place->store, running, NULL), QG_STORE_WRONG_STATE);
    assert_int_equal(qg_store_record(place->store, &held, &evaluation, 1), QG_STORE_OK);
    assert_int_equal(qg_store_put_outputs(place->store, &held, &output, 1), QG_STORE_OK);
    assert_int_equal(end(place->store, &held, QG_STATE_SUCCEEDED), QG_STORE_OK);
    assert_int_equal(qg_store_cancel(place->store, running, NULL), QG_STORE_WRONG_STATE);
    assert_int_equal(qg_store_delete(place->store, running, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_evaluation_end(place->store, held.sequence, &end_of_log), QG_STORE_NOT_FOUND);
    assert_int_equal(qg_store_output(place->store, running, QG_OUTPUT_RESULT, &text), QG_STORE_NOT_FOUND);
}

static void takes_up_what_a_dead_process_left(void **state) {
    struct place *place = *state;
    char left[QG_JOB_ID_ROOM], unwanted[QG_JOB_ID_ROOM];
    submit(place->store, "left", left);
    submit(place->store, "unwanted", unwanted);
    claim(place->store, LEASE, "left");
    claim(place->store, LEASE, "unwanted");
    qg_store_cancel(place->store, unwanted, NULL);
    reopen(place);
    assert_int_equal(state_of(place->store, left), QG_STATE_QUEUED);
    assert_int_equal(state_of(place->store, unwanted), QG_STATE_CANCELLED);
    assert_int_equal(claim(place->store, LEASE, "left").attempt, 2);
    assert_idle(place->store);
}

/* --- the log --- */

/* Doubles that a careless store would change. */
static double difficult(uint64_t *seed) {
    static const double values[] = {0.1 + 0.2, 1.0 / 3, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308,
                                    42.0,      1e15,    -7.0,   9007199254740993.0,      0.0};
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    if (*seed >> 62 == 0)
        return values[(*seed >> 32) % (sizeof values / sizeof values[0])];
    return ldexp((double)(*seed >> 11), -40 - (int)(*seed % 60));
}

static void keeps_every_bit(void **state) {
    struct place *place = *state;
    enum { COUNT = 500 };
    struct qg_evaluation *written = calloc(COUNT, sizeof *written), *read = calloc(COUNT, sizeof *read);
    char id[QG_JOB_ID_ROOM];
    uint64_t seed = 1;
    size_t count;
    for (size_t i = 0; i < COUNT; i++) {
        written[i].number = i;
        written[i].phase = (enum qg_phase)(i % QG_PHASE_COUNT);
        for (int j = 0; j < QG_PARAMETER_COUNT; j++)
            written[i].parameter[j] = difficult(&seed);
        written[i].f_pps = difficult(&seed);
        written[i].f_dte = i % 7 == 0 ? (double)NAN : difficult(&seed);
        written[i].f_dte_percentile = i % 5 == 0 ? (double)NAN : difficult(&seed);
    }
    submit(place->store, "{}", id);
    struct qg_claim held = claim(place->store, LEASE, "{}");
    assert_int_equal(qg_store_record(place->store, &held, written, 200), QG_STORE_OK);
    assert_int_equal(qg_store_record(place->store, &held, written + 200, COUNT - 200), QG_STORE_OK);
    reopen(place);
    assert_int_equal(qg_store_evaluations(place->store, held.sequence, 0, COUNT, read, &count), QG_STORE_OK);
    assert_int_equal(count, COUNT);
    for (size_t i = 0; i < COUNT; i++) {
        assert_int_equal(read[i].number, i);
        assert_int_equal(read[i].phase, written[i].phase);
        assert_memory_equal(read[i].parameter, written[i].parameter, sizeof written[i].parameter);
        assert_memory_equal(&read[i].f_pps, &written[i].f_pps, sizeof(double));
        if (isnan(written[i].f_dte))
            assert_true(isnan(read[i].f_dte));
        else
            assert_memory_equal(&read[i].f_dte, &written[i].f_dte, sizeof(double));
        if (isnan(written[i].f_dte_percentile))
            assert_true(isnan(read[i].f_dte_percentile));
        else
            assert_memory_equal(&read[i].f_dte_percentile, &written[i].f_dte_percentile, sizeof(double));
    }
    assert_int_equal(qg_store_evaluations(place->store, held.sequence, 490, 5, read, &count), QG_STORE_OK);
    assert_int_equal(count, 5);
    assert_int_equal(read[4].number, 494);
    free(written);
    free(read);
}

static void records_all_or_none(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    size_t end_of_log;
    const struct qg_evaluation batch[] = {{.number = 1}, {.number = 2}, {.number = 0}}, earlier = {.number = 0};
    submit(place->store, "{}", id);
    struct qg_claim held = claim(place->store, LEASE, "{}");
    assert_int_equal(qg_store_record(place->store, &held, &earlier, 1), QG_STORE_OK);
    assert_int_equal(qg_store_record(place->store, &held, batch, 3), QG_STORE_FAILED); /* number 0 is there already */
    qg_store_evaluation_end(place->store, held.sequence, &end_of_log);
    assert_int_equal(end_of_log, 1);
    assert_int_equal(qg_store_record(place->store, &held, batch, 2), QG_STORE_OK);
    assert_int_equal(qg_store_forget_evaluations(place->store, &held, 2), QG_STORE_OK);
    qg_store_evaluation_end(place->store, held.sequence, &end_of_log);
    assert_int_equal(end_of_log, 2);
}

static void drops_the_log_of_another_version(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    size_t end_of_log;
    const struct qg_evaluation evaluation = {.number = 0};
    submit(place->store, "{}", id);
    struct qg_claim held = claim(place->store, EXPIRED, "{}");
    assert_int_equal(qg_store_record(place->store, &held, &evaluation, 1), QG_STORE_OK);
    held = claim(place->store, EXPIRED, "{}");
    qg_store_evaluation_end(place->store, held.sequence, &end_of_log);
    assert_int_equal(end_of_log, 1);
    assert_int_equal(qg_sql_run(place->store->writer, "UPDATE jobs SET program = '0.0.0'", ""), QG_STORE_OK);
    held = claim(place->store, LEASE, "{}");
    qg_store_evaluation_end(place->store, held.sequence, &end_of_log);
    assert_int_equal(end_of_log, 0);
}

/* --- the database --- */

static void survives_a_full_disk(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    struct qg_job_row row;
    char *large = malloc(1 << 20);
    memset(large, 'x', (1 << 20) - 1);
    large[(1 << 20) - 1] = '\0';
    submit(place->store, "{}", id);
    assert_int_equal(qg_sql_run(place->store->writer, "PRAGMA max_page_count = 40", ""), QG_STORE_OK);
    const struct qg_submission submission = {.name = "", .kind = "optimize", .labels = "[]", .document = large};
    assert_int_equal(qg_store_submit(place->store, &submission, &row), QG_STORE_FULL);
    assert_int_equal(state_of(place->store, id), QG_STATE_QUEUED);
    assert_int_equal(qg_store_cancel(place->store, id, NULL), QG_STORE_OK);
    assert_int_equal(qg_sql_run(place->store->writer, "PRAGMA max_page_count = 100000", ""), QG_STORE_OK);
    assert_int_equal(qg_store_submit(place->store, &submission, &row), QG_STORE_OK);
    qg_job_row_finish(&row);
    free(large);
}

static void keeps_a_second_daemon_out(void **state) {
    struct place *place = *state;
    char message[QG_STORE_MESSAGE_ROOM] = "", self[64];
    snprintf(self, sizeof self, "in use by another quietgeard (process %ld)", (long)getpid());
    assert_null(qg_store_open(place->directory, message));
    assert_non_null(strstr(message, self));
}

/* Reads the changes after a revision; they are in order. Returns how many. */
static size_t changes_after(struct place *place, int64_t since, struct qg_change *out) {
    size_t count;
    assert_int_equal(qg_store_changes(place->store, since, NULL, out, 8, &count), QG_STORE_OK);
    for (size_t i = 0; i < count; i++)
        assert_true(out[i].revision > (i ? out[i - 1].revision : since));
    return count;
}

static void numbers_what_changes(void **state) {
    struct place *place = *state;
    char first[QG_JOB_ID_ROOM], second[QG_JOB_ID_ROOM];
    struct qg_change changes[8];
    struct qg_claim claim;
    struct qg_text document = {0};
    int64_t revision;
    assert_int_equal(qg_store_revision(place->store, &revision), QG_STORE_OK);
    assert_int_equal(revision, 0);
    submit(place->store, "one", first);
    submit(place->store, "two", second);
    assert_int_equal(changes_after(place, 0, changes), 2);
    assert_string_equal(changes[0].id, first);
    int64_t seen = changes[1].revision;
    assert_int_equal(qg_store_claim(place->store, LEASE, &claim, &document), QG_STORE_OK);
    qg_text_finish(&document);
    assert_int_equal(qg_store_delete(place->store, second, NULL), QG_STORE_OK);
    assert_int_equal(changes_after(place, seen, changes), 2);
    assert_string_equal(changes[0].id, first);
    assert_false(changes[0].deleted);
    assert_string_equal(changes[1].id, second);
    assert_true(changes[1].deleted);
    assert_int_equal(qg_store_heartbeat(place->store, &claim, LEASE, NULL), QG_STORE_OK);
    assert_int_equal(changes_after(place, changes[1].revision, changes), 0); /* a heartbeat is no change */
    reopen(place);                                                           /* puts the job back into the queue */
    assert_int_equal(changes_after(place, seen, changes), 2);
    assert_true(changes[0].deleted);
    assert_string_equal(changes[1].id, first);
}

/* A reader that does not end, as a backup of a large database does not for a while, lets the write-ahead log grow; when it has
 * ended, the log gets small again. */
static void log_shrinks_after_a_long_reader(void **state) {
    enum { MEGABYTES = 24, LIMIT = 17 << 20 };
    struct place *place = *state;
    char path[80];
    struct qg_statistics statistics;
    sqlite3 *reader = NULL, *writer = place->store->writer;
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    assert_int_equal(sqlite3_open_v2(path, &reader, SQLITE_OPEN_READONLY, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_exec(reader, "BEGIN; SELECT count(*) FROM jobs", NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_exec(writer, "CREATE TABLE ballast (bytes BLOB)", NULL, NULL, NULL), SQLITE_OK);
    for (int i = 0; i < MEGABYTES; i++)
        assert_int_equal(sqlite3_exec(writer, "INSERT INTO ballast VALUES (zeroblob(1048576))", NULL, NULL, NULL),
                         SQLITE_OK);
    assert_int_equal(qg_store_statistics(place->store, &statistics), QG_STORE_OK);
    assert_true(statistics.wal_bytes > LIMIT);
    sqlite3_close(reader);
    for (int i = 0; i < 3; i++) /* the first write after the reader copies the log back, the next begins it anew */
        assert_int_equal(sqlite3_exec(writer, "INSERT INTO ballast VALUES (NULL)", NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(qg_store_statistics(place->store, &statistics), QG_STORE_OK);
    assert_in_range(statistics.wal_bytes, 1, LIMIT);
}

static void refuses_a_newer_format(void **state) {
    struct place *place = *state;
    char message[QG_STORE_MESSAGE_ROOM] = "";
    assert_int_equal(qg_sql_run(place->store->writer, "PRAGMA user_version = 99", ""), QG_STORE_OK);
    qg_store_close(place->store);
    place->store = qg_store_open(place->directory, message);
    assert_null(place->store);
    assert_non_null(strstr(message, "newer version"));
}

/* A database of format 1, made by the string of that format, with a job and an evaluation. */
static const char format_1[] =
    "CREATE TABLE jobs ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " name TEXT NOT NULL,"
    " kind TEXT NOT NULL,"
    " labels TEXT NOT NULL,"
    " state TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),"
    " cancel_requested INTEGER NOT NULL DEFAULT 0,"
    " idempotency_key TEXT UNIQUE,"
    " submitted_at INTEGER NOT NULL,"
    " started_at INTEGER,"
    " finished_at INTEGER,"
    " done INTEGER NOT NULL DEFAULT 0,"
    " total INTEGER NOT NULL DEFAULT 0,"
    " phase TEXT,"
    " eta_s REAL,"
    " best REAL,"
    " error TEXT,"
    " attempt INTEGER NOT NULL DEFAULT 0,"
    " lease_until INTEGER,"
    " program TEXT,"
    " document TEXT NOT NULL"
    ") STRICT;"
    "CREATE INDEX jobs_by_state ON jobs (state, seq);"
    "CREATE TABLE evaluations ("
    " job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,"
    " number INTEGER NOT NULL,"
    " phase TEXT NOT NULL,"
    " pinion_tip_start_radius REAL NOT NULL,"
    " pinion_tip_amplitude REAL NOT NULL,"
    " pinion_root_end_radius REAL NOT NULL,"
    " pinion_root_amplitude REAL NOT NULL,"
    " gear_tip_start_radius REAL NOT NULL,"
    " gear_tip_amplitude REAL NOT NULL,"
    " gear_root_end_radius REAL NOT NULL,"
    " gear_root_amplitude REAL NOT NULL,"
    " f_pps REAL,"
    " f_dte REAL,"
    " PRIMARY KEY (job, number)"
    ") STRICT, WITHOUT ROWID;"
    "CREATE TABLE outputs ("
    " job INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,"
    " name TEXT NOT NULL,"
    " body TEXT NOT NULL,"
    " PRIMARY KEY (job, name)"
    ") STRICT;"
    "INSERT INTO jobs (seq, id, name, kind, labels, state, submitted_at, document)"
    " VALUES (1, 'old', 'a name', 'optimize', '[]', 'queued', 0, '{}');"
    "INSERT INTO evaluations VALUES (1, 0, 'random', 44, 0.01, 0, 0, 67, 0.02, 0, 0, 0.005, 0.25);"
    "PRAGMA user_version = 1;";

/* What an older version wrote is still there, and there is room for what this one writes. */
static void an_older_format_is_brought_up_to_date(void **state) {
    struct place *place = *state;
    char path[64];
    sqlite3 *database;
    struct qg_evaluation read, written = {.number = 1, .f_pps = 0.004, .f_dte = 0.2, .f_dte_percentile = 0.3};
    size_t count;
    qg_store_close(place->store);
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(sqlite3_exec(database, format_1, NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_close(database), SQLITE_OK);
    place->store = open_store(place->directory);
    assert_int_equal(qg_store_evaluations(place->store, 1, 0, 1, &read, &count), QG_STORE_OK);
    assert_int_equal(count, 1);
    assert_int_equal(read.phase, QG_PHASE_RANDOM);
    assert_true(read.parameter[QG_GEAR_TIP_AMPLITUDE] == 0.02 && read.f_pps == 0.005 && read.f_dte == 0.25);
    assert_true(isnan(read.f_dte_percentile));
    struct qg_claim held = claim(place->store, LEASE, "{}");
    assert_string_equal(held.id, "old");
    assert_int_equal(qg_store_record(place->store, &held, &written, 1), QG_STORE_OK);
    assert_int_equal(qg_store_evaluations(place->store, 1, 1, 1, &read, &count), QG_STORE_OK);
    assert_int_equal(count, 1);
    assert_true(read.f_dte_percentile == 0.3);
}

/* All that the database holds of tables, indexes and triggers, in the order of their names. */
static char *schema_of(sqlite3 *database) {
    sqlite3_stmt *statement = NULL;
    assert_int_equal(sqlite3_prepare_v2(database,
                                        "SELECT group_concat(sql, char(10)) FROM (SELECT sql FROM sqlite_schema"
                                        " WHERE sql IS NOT NULL ORDER BY type, name)",
                                        -1, &statement, NULL),
                     SQLITE_OK);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    char *schema = strdup((const char *)sqlite3_column_text(statement, 0));
    sqlite3_finalize(statement);
    return schema;
}

/* A database of a format from 1 on, with a running job, a finished one with a result, and a key. */
static void make_old_database(const char *path, int format) {
    static const char content[] =
        "UPDATE jobs SET state = 'running', attempt = 3, lease_until = 1, program = '0.0.1' WHERE seq = 1;"
        "INSERT INTO jobs (seq, id, name, kind, labels, state, submitted_at, started_at, finished_at, document)"
        " VALUES (2, 'finished', 'b', 'evaluate', '[\"x\"]', 'succeeded', 10, 20, 30, '{}');"
        "INSERT INTO outputs VALUES (2, 'result', '{\"old\":true}');";
    sqlite3 *database;
    unlink(path);
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(sqlite3_exec(database, format_1, NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(qg_store_migrate_to(database, format), QG_STORE_OK);
    assert_int_equal(sqlite3_exec(database, content, NULL, NULL, NULL), SQLITE_OK);
    if (format >= 11) /* from which on the store writes labels down with a job */
        assert_int_equal(sqlite3_exec(database, "INSERT INTO labels VALUES ('x', 2)", NULL, NULL, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_close(database), SQLITE_OK);
}

/* What format 11 keeps beside the jobs is made from those of an older database. */
static void assert_counts_and_labels(struct qg_store *store) {
    const struct qg_job_filter filter = {.state = QG_STATE_COUNT, .label = "x", .limit = 1};
    struct qg_statistics statistics;
    struct qg_job_row row;
    size_t count;
    int64_t next;
    assert_int_equal(qg_store_statistics(store, &statistics), QG_STORE_OK);
    assert_true(statistics.jobs[QG_STATE_QUEUED] == 1 && statistics.jobs[QG_STATE_RUNNING] == 0);
    assert_true(statistics.jobs[QG_STATE_SUCCEEDED] == 1 && statistics.jobs[QG_STATE_FAILED] == 0);
    assert_int_equal(qg_store_list(store, &filter, &row, &count, &next), QG_STORE_OK);
    assert_true(count == 1 && next == 0);
    assert_string_equal(row.id, "finished");
    qg_job_row_finish(&row);
}

/* Each older format leads to the database that a new one is, and what it held is there. */
static void every_older_format_is_brought_up_to_date(void **state) {
    struct place *place = *state;
    char path[64], *fresh = schema_of(place->store->writer);
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    for (int format = 1; format < QG_STORE_FORMAT; format++) {
        struct qg_job_row row;
        struct qg_text output = {0};
        qg_store_close(place->store);
        make_old_database(path, format);
        place->store = open_store(place->directory);
        char *schema = schema_of(place->store->writer);
        assert_string_equal(schema, fresh);
        free(schema);
        assert_int_equal(qg_store_check(place->store->writer), QG_STORE_OK);
        assert_int_equal(qg_store_job(place->store, "finished", &row), QG_STORE_OK);
        assert_true(row.state == QG_STATE_SUCCEEDED && row.finished_at == 30 && isnan(row.estimate.seconds));
        qg_job_row_finish(&row);
        assert_int_equal(qg_store_output(place->store, "finished", QG_OUTPUT_RESULT, &output), QG_STORE_OK);
        assert_string_equal(output.data, "{\"old\":true}");
        qg_text_finish(&output);
        assert_counts_and_labels(place->store);
        struct qg_claim held = claim(place->store, LEASE, "{}"); /* put back into the queue, and taken from it */
        assert_string_equal(held.id, "old");
        assert_int_equal(held.attempt, 4);
        assert_int_equal(qg_store_finish(place->store, &held, &(struct qg_ending){.state = QG_STATE_FAILED}),
                         QG_STORE_OK);
    }
    free(fresh);
}

static void says_why_it_cannot_open(void **state) {
    (void)state;
    char message[QG_STORE_MESSAGE_ROOM] = "";
    assert_null(qg_store_open("/dev/null/state", message));
    assert_non_null(strstr(message, "/dev/null/state"));
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, make_place, remove_place)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(keeps_what_was_submitted),
        TEST(repeats_by_key),
        TEST(forgets_keys_in_time),
        TEST(takes_keys_over),
        TEST(takes_objectives_over),
        TEST(takes_deliveries_over),
        TEST(keeps_the_objective),
        TEST(lists_newest_first),
        TEST(gives_up_a_page_and_goes_on),
        TEST(claims_the_oldest_once),
        TEST(a_stale_attempt_writes_nothing),
        TEST(a_heartbeat_keeps_the_claim),
        TEST(cancels_and_deletes),
        TEST(takes_up_what_a_dead_process_left),
        TEST(keeps_every_bit),
        TEST(records_all_or_none),
        TEST(drops_the_log_of_another_version),
        TEST(survives_a_full_disk),
        TEST(numbers_what_changes),
        TEST(keeps_a_second_daemon_out),
        TEST(log_shrinks_after_a_long_reader),
        TEST(refuses_a_newer_format),
        TEST(an_older_format_is_brought_up_to_date),
        TEST(every_older_format_is_brought_up_to_date),
        cmocka_unit_test(says_why_it_cannot_open),
    };
    return cmocka_run_group_tests_name("store", tests, NULL, NULL);
}
