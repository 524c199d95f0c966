/* Every SQL statement of the store, collected while all of the store's functions are used: none searches a table that grows, and
 * none does more work when there are thousands of other jobs than when there are a hundred. No clock is asked: SQLite counts
 * the steps of its virtual machine, and explains its plans.
 *
 * That the functions used here reach all statements is seen by looking for the statements in the sources of server/store among those that
 * were run.
 */
#include "tests/server/place.h"

#include <glob.h>

#include "server/base/token.h"
#include "server/store/access.h"
#include "server/store/backup.h"
#include "server/store/expiry.h"
#include "server/store/webhooks.h"

enum { STATEMENTS_MAX = 200, FEW = 100, MANY = 3000, SLACK = 40 };

/* What was run. */
static struct {
    size_t count;
    int phase; /* -1: not counted; 0: few jobs; 1: many */
    struct {
        char *sql;
        int steps[2]; /* the largest in each phase; -1: not run in it */
    } statement[STATEMENTS_MAX];
} seen = {.phase = -1};

static int note_statement(unsigned what, void *self, void *statement, void *nanoseconds) {
    (void)self;
    (void)nanoseconds;
    const char *sql = sqlite3_sql(statement);
    int steps = sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_VM_STEP, 1);
    if (what != SQLITE_TRACE_PROFILE || seen.phase < 0 || !sql)
        return 0;
    size_t place = 0;
    while (place < seen.count && strcmp(seen.statement[place].sql, sql) != 0)
        place++;
    if (place == seen.count) {
        assert_true(seen.count++ < STATEMENTS_MAX);
        seen.statement[place].sql = strdup(sql);
        seen.statement[place].steps[0] = seen.statement[place].steps[1] = -1;
    }
    if (steps > seen.statement[place].steps[seen.phase])
        seen.statement[place].steps[seen.phase] = steps;
    return 0;
}

/* SQLite calls it for each connection that is opened. */
static int watch(sqlite3 *database, const char **error, const void *thunk) {
    (void)error;
    (void)thunk;
    return sqlite3_trace_v2(database, SQLITE_TRACE_PROFILE, note_statement, NULL);
}

/* --- other people's jobs --- */

/* So many jobs queued, finished and cancelled, with what belongs to them, as many deliveries waiting and done, deletions,
 * keys and entries of the audit log. None of them is what use_all asks for. */
static void fill(struct place *place, int n) {
    char sql[400];
    static const char *const states[] = {"queued", "succeeded", "cancelled"};
    static const char *const rest[] = {
        "INSERT INTO labels SELECT 'common', seq FROM jobs WHERE seq NOT IN (SELECT job FROM labels)",
        "INSERT INTO evaluations SELECT seq, 0, 'random', 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, NULL FROM jobs"
        " WHERE state = 'succeeded' AND log_dropped = 0 AND seq NOT IN (SELECT job FROM evaluations)",
        "INSERT OR IGNORE INTO deletions SELECT 1000000 + seq, 'gone' || seq FROM jobs",
        "INSERT OR IGNORE INTO submissions SELECT 'other', id, 9e15, id, document FROM jobs",
        "INSERT INTO audit (at, token, name, address, action, subject) SELECT 9e15, '', '', '', 'x', id FROM jobs"};
    seen.phase = -1;
    run_sql(place, "BEGIN");
    for (int i = 0; i < 3; i++) {
        snprintf(sql, sizeof sql,
                 "WITH RECURSIVE number(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM number WHERE i < %d)"
                 " INSERT INTO jobs (id, name, kind, labels, state, submitted_at, finished_at, document, token,"
                 " external_id) SELECT lower(hex(randomblob(13))), 'other', 'evaluate', '[\"common\"]', '%s', 1,"
                 " %s, '{}', 'other', 'other' || i FROM number",
                 n, states[i], i == 0 ? "NULL" : "8000000000000000 + i");
        run_sql(place, sql);
    }
    for (size_t i = 0; i < sizeof rest / sizeof *rest; i++)
        run_sql(place, rest[i]);
    run_sql(place, "COMMIT");
}

/* --- all functions of the store --- */

static const struct qg_actor actor = {.token = "mine", .name = "tester"};

static void submit(struct place *place, const char *key, const char *external_id, char id[QG_JOB_ID_ROOM]) {
    const struct qg_submission submission = {.name = "name",
                                             .kind = "evaluate",
                                             .labels = "[\"rare\", \"common\"]",
                                             .document = "{}",
                                             .idempotency_key = key,
                                             .external_id = external_id,
                                             .actor = &actor,
                                             .queue_limit = 1000000};
    struct qg_job_row row;
    enum qg_store_status status = qg_store_submit(place->store, &submission, &row);
    assert_true(status == QG_STORE_OK || status == QG_STORE_REPEATED);
    strcpy(id, row.id);
    qg_job_row_finish(&row);
}

static void list(struct place *place, struct qg_job_filter filter) {
    struct qg_job_row rows[10];
    size_t count;
    int64_t next;
    filter.limit = 10;
    assert_int_equal(qg_store_list(place->store, &filter, rows, &count, &next), QG_STORE_OK);
    for (size_t i = 0; i < count; i++)
        qg_job_row_finish(&rows[i]);
}

static void list_all_ways(struct place *place) {
    for (int64_t before = 0; before <= 150; before += 150) {
        list(place, (struct qg_job_filter){.state = QG_STATE_COUNT, .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_FAILED, .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_QUEUED, .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_COUNT, .label = "common", .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_COUNT, .label = "rare", .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_FAILED, .label = "rare", .before = before});
        list(place, (struct qg_job_filter){
                        .state = QG_STATE_FAILED, .label = "rare", .external_id = "mine", .before = before});
        list(place, (struct qg_job_filter){.state = QG_STATE_COUNT, .external_id = "other1", .before = before});
    }
}

static void read_job(struct place *place, const char *id) {
    struct qg_job_row row;
    struct qg_text text = {0};
    struct qg_change change[3];
    struct qg_evaluation evaluation[3];
    size_t count, end;
    int64_t revision;
    assert_int_equal(qg_store_job(place->store, id, &row), QG_STORE_OK);
    assert_int_equal(qg_store_document(place->store, id, &text), QG_STORE_OK);
    assert_int_equal(qg_store_output(place->store, id, "result", &text), QG_STORE_OK);
    assert_int_equal(qg_store_evaluations(place->store, row.sequence, 1, 3, evaluation, &count), QG_STORE_OK);
    assert_int_equal(qg_store_evaluation_end(place->store, row.sequence, &end), QG_STORE_OK);
    assert_int_equal(qg_store_revision(place->store, &revision), QG_STORE_OK);
    assert_int_equal(qg_store_changes(place->store, 0, id, change, 3, &count), QG_STORE_OK);
    assert_int_equal(qg_store_changes(place->store, 0, NULL, change, 3, &count), QG_STORE_OK);
    qg_text_finish(&text);
    qg_job_row_finish(&row);
}

/* Takes my job before all others, and works at it as an attempt does. */
static struct qg_claim work_at(struct place *place) {
    const struct qg_job_progress progress = {.done = 1, .total = 2, .eta = 3, .best = 4};
    const struct qg_evaluation evaluations[] = {{.number = 0}, {.number = 1}, {.number = 2}};
    const struct qg_output output = {"result", "{}"};
    struct qg_claim claim;
    struct qg_text document = {0};
    assert_int_equal(qg_store_claim(place->store, 60000, &claim, &document), QG_STORE_OK);
    assert_int_equal(qg_store_heartbeat(place->store, &claim, 60000, &progress), QG_STORE_OK);
    assert_int_equal(qg_store_forget_evaluations(place->store, &claim, 0), QG_STORE_OK);
    assert_int_equal(qg_store_record(place->store, &claim, evaluations, 3), QG_STORE_OK);
    assert_int_equal(qg_store_forget_evaluations(place->store, &claim, 2), QG_STORE_OK);
    assert_int_equal(qg_store_put_outputs(place->store, &claim, &output, 1), QG_STORE_OK);
    qg_text_finish(&document);
    return claim;
}

static void run_and_forget(struct place *place) {
    const struct qg_ending put_back = {.state = QG_STATE_QUEUED}, succeeded = {.state = QG_STATE_SUCCEEDED};
    char id[QG_JOB_ID_ROOM], again[QG_JOB_ID_ROOM];
    const char *key = seen.phase == 0 ? "few" : "many";
    submit(place, key, "mine", id);
    submit(place, key, "mine", again);
    assert_string_equal(id, again);
    struct qg_claim claim = work_at(place);
    assert_int_equal(qg_store_finish(place->store, &claim, &put_back), QG_STORE_OK);
    int phase = seen.phase;
    seen.phase = -1;
    run_sql(place, "UPDATE jobs SET program = 'another' WHERE program IS NOT NULL");
    seen.phase = phase;
    claim = work_at(place);
    read_job(place, claim.id);
    assert_int_equal(qg_store_cancel(place->store, claim.id, &actor), QG_STORE_OK);
    assert_int_equal(qg_store_finish(place->store, &claim, &succeeded), QG_STORE_OK);
    while (qg_store_drop_evaluations(place->store, claim.id) == QG_STORE_OK)
        ;
    assert_int_equal(qg_store_delete(place->store, claim.id, &actor), QG_STORE_OK);
    if (strcmp(claim.id, id) != 0) {
        assert_int_equal(qg_store_cancel(place->store, id, &actor), QG_STORE_OK);
        assert_int_equal(qg_store_delete(place->store, id, &actor), QG_STORE_OK);
    }
}

static void administer(struct place *place) {
    struct qg_token token = {.name = "n", .id = "t1"}, tokens[3];
    struct qg_audit_entry entries[3];
    struct qg_audit_page page = {.entry = entries, .room = 3};
    struct qg_statistics statistics;
    size_t count;
    assert_int_equal(qg_store_token_add(place->store, &token, &actor), QG_STORE_OK);
    assert_int_equal(qg_store_tokens(place->store, tokens, 3, &count), QG_STORE_OK);
    assert_int_equal(qg_store_tokens_used(place->store, &token, 1), QG_STORE_OK);
    assert_int_equal(qg_store_token_remove(place->store, "t1", &actor), QG_STORE_OK);
    assert_int_equal(qg_store_note(place->store, &actor, "database.backup", "b"), QG_STORE_OK);
    const struct qg_audit_filter filters[] = {
        {0}, {.before = 50}, {.action = "job", .actor = "n", .subject = "b", .address = "::1", .since = 1, .until = 2}};
    for (size_t i = 0; i < sizeof filters / sizeof *filters; i++)
        assert_int_equal(qg_store_audit(place->store, &filters[i], &page), QG_STORE_OK);
    assert_int_equal(qg_store_drop_log(place->store, 1000), QG_STORE_NOT_FOUND);
    assert_int_equal(qg_store_statistics(place->store, &statistics), QG_STORE_OK);
    assert_int_equal(qg_store_test_writing(place->store), QG_STORE_OK);
    assert_true(qg_store_is_alive(place->store));
}

static void expire(struct place *place) {
    char id[QG_JOB_ID_ROOM];
    const struct qg_retention kinds[] = {
        {.job_days = 1}, {.jobs = 50}, {.megabytes = 1}, {.evaluation_days = 1}, {.evaluation_days = 90000000}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        qg_store_expired(place->store, &kinds[i], INT64_C(9000000000000000), id);
        qg_store_expired_log(place->store, &kinds[i], INT64_C(9000000000000000), id);
    }
}

static void deliver(struct place *place) {
    struct qg_webhook webhook = {.id = "w2", .url = "http://a.example", .events = 2}, webhooks[QG_WEBHOOKS_MAX];
    struct qg_dispatch due[QG_WEBHOOKS_MAX];
    struct qg_delivery deliveries[3];
    size_t count;
    int64_t next;
    assert_int_equal(qg_store_webhook_add(place->store, &webhook, &actor), QG_STORE_OK);
    assert_int_equal(qg_store_webhooks(place->store, webhooks, &count), QG_STORE_OK);
    assert_int_equal(qg_store_webhook(place->store, "w2", &webhook), QG_STORE_OK);
    struct qg_claim claim = work_at(place); /* for which both want a delivery */
    assert_int_equal(qg_store_finish(place->store, &claim, &(struct qg_ending){.state = QG_STATE_FAILED}), QG_STORE_OK);
    assert_int_equal(qg_store_due(place->store, INT64_MAX, due, &count, &next), QG_STORE_OK);
    assert_int_equal(count, 2);
    for (size_t i = 0; i < count; i++) {
        bool second = strcmp(due[i].webhook, "w2") == 0;
        const struct qg_outcome outcome = {.at = INT64_C(9000000000000), .delivered = !second, .gone = second};
        assert_int_equal(qg_store_attempted(place->store, &due[i], &outcome), QG_STORE_OK);
        qg_dispatch_finish(&due[i]);
    }
    assert_int_equal(qg_store_due(place->store, 5, due, &count, &next), QG_STORE_OK);
    assert_int_equal(qg_store_deliveries(place->store, "w1", 0, 3, deliveries, &count), QG_STORE_OK);
    assert_int_equal(qg_store_deliveries(place->store, "w1", 60, 3, deliveries, &count), QG_STORE_OK);
    assert_int_equal(qg_store_drop_deliveries(place->store, "w2"), QG_STORE_OK);
    assert_int_equal(qg_store_drop_deliveries(place->store, "w2"), QG_STORE_NOT_FOUND);
    assert_int_equal(qg_store_webhook_remove(place->store, "w2", &actor), QG_STORE_OK);
}

/* No function leaves a statement or a transaction behind: a client that takes a byte a second keeps no snapshot open, between
 * the pages that a stream reads for it, and the write-ahead log can begin anew. */
static void require_nothing_open(struct place *place) {
    assert_null(sqlite3_next_stmt(place->store->reader, NULL));
    assert_null(sqlite3_next_stmt(place->store->writer, NULL));
    assert_int_equal(sqlite3_txn_state(place->store->reader, NULL), SQLITE_TXN_NONE);
    assert_int_equal(sqlite3_txn_state(place->store->writer, NULL), SQLITE_TXN_NONE);
}

/* Each statement once at least, while so many jobs of others are there. */
static void use_all(struct place *place, int phase, int others) {
    fill(place, others);
    seen.phase = phase;
    list_all_ways(place);
    run_and_forget(place);
    deliver(place);
    administer(place);
    expire(place);
    require_nothing_open(place);
    reopen_place(place);
    seen.phase = -1;
}

static int use_twice(void **state) {
    sqlite3_auto_extension((void (*)(void))watch);
    if (make_place(state) != 0)
        return -1;
    struct qg_webhook webhook = {.id = "w1", .url = "http://a.example", .events = 31};
    assert_int_equal(qg_store_webhook_add(((struct place *)*state)->store, &webhook, &actor), QG_STORE_OK);
    use_all(*state, 0, FEW);
    use_all(*state, 1, MANY);
    return 0;
}

static int clean_up(void **state) {
    sqlite3_reset_auto_extension();
    while (seen.count > 0)
        free(seen.statement[--seen.count].sql);
    return remove_place(state);
}

/* --- what has to be true --- */

/* So that one run shows all that is wrong. */
static int complaints;

__attribute__((format(printf, 1, 2))) static void complain(const char *format, ...) {
    char text[2000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    print_error("%s\n", text);
    complaints++;
}

/* Statements whose work may grow, and why that is bounded. */
static const char *const growing[] = {
    "SELECT 1 FROM labels WHERE label = ?3", /* jobs of one external id, which the caller gave them */
    "SELECT seq FROM audit WHERE seq < ? ORDER BY seq DESC LIMIT 1 OFFSET", /* QG_AUDIT_LOOK entries at most */
    "FROM audit WHERE seq < ?1 AND seq >= ?2",                              /* likewise */
};

static bool may_grow(const char *sql) {
    for (size_t i = 0; i < sizeof growing / sizeof *growing; i++)
        if (strstr(sql, growing[i]))
            return true;
    return false;
}

static void no_statement_does_more_when_there_are_more_jobs(void **state) {
    (void)state;
    size_t compared = 0;
    complaints = 0;
    for (size_t i = 0; i < seen.count; i++) {
        const int *steps = seen.statement[i].steps;
        compared += steps[0] >= 0 && steps[1] >= 0;
        if (steps[0] >= 0 && steps[1] > steps[0] + SLACK && !may_grow(seen.statement[i].sql))
            complain("%d steps with few jobs, %d with many: %s", steps[0], steps[1], seen.statement[i].sql);
    }
    assert_true(compared > 50);
    assert_int_equal(complaints, 0);
}

/* What may be searched from one end to the other: tables of few rows, and what is no table. */
static bool is_small(const char *scanned) {
    static const char *const small[] = {"CONSTANT ROW", "job_counts",    "json_each",  "now",      "number", "pragma_",
                                        "revision",     "sqlite_master", "(subquery-", "webhooks", "tokens"};
    for (size_t i = 0; i < sizeof small / sizeof *small; i++)
        if (strncmp(scanned, small[i], strlen(small[i])) == 0)
            return true;
    return false;
}

/* A step of a plan. Sorting is fine where few rows come in. */
static void judge(const char *sql, const char *step) {
    if (strncmp(step, "SCAN ", 5) == 0 && !is_small(step + 5))
        complain("%s\n  in %s", step, sql);
    if (strstr(step, "TEMP B-TREE") && !strstr(sql, "FROM webhooks") && !strstr(sql, "FROM tokens"))
        complain("%s\n  in %s", step, sql);
}

static void no_statement_searches_a_table_that_grows(void **state) {
    struct place *place = *state;
    sqlite3 *database = place->store->writer;
    size_t judged = 0;
    complaints = 0;
    assert_int_equal(sqlite3_db_config(database, SQLITE_DBCONFIG_TRIGGER_EQP, 1, NULL), SQLITE_OK);
    for (size_t i = 0; i < seen.count; i++) {
        const char *sql = seen.statement[i].sql;
        if (!strchr("SIUD", *sql))
            continue;
        sqlite3_stmt *plan = NULL;
        char *explained = sqlite3_mprintf("EXPLAIN QUERY PLAN %s", sql);
        assert_int_equal(sqlite3_prepare_v2(database, explained, -1, &plan, NULL), SQLITE_OK);
        while (sqlite3_step(plan) == SQLITE_ROW)
            if (sqlite3_column_type(plan, 3) == SQLITE_TEXT) /* else it names a trigger's program */
                judge(sql, (const char *)sqlite3_column_text(plan, 3));
        sqlite3_finalize(plan);
        sqlite3_free(explained);
        judged++;
    }
    assert_true(judged > 50);
    assert_int_equal(complaints, 0);
}

static bool was_run(const char *beginning, size_t length) {
    char text[512];
    snprintf(text, sizeof text, "%.*s", (int)length, beginning);
    for (size_t i = 0; i < seen.count; i++)
        if (strstr(seen.statement[i].sql, text))
            return true;
    return false;
}

/* Looks in one file for literals that begin a statement. Returns how many there are. */
static size_t look_for_statements(const char *path) {
    static char source[1 << 17];
    static const char *const verbs[] = {"\"SELECT ", "\"INSERT ", "\"UPDATE ", "\"DELETE "};
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    size_t length = fread(source, 1, sizeof source - 1, file), count = 0;
    fclose(file);
    assert_true(length < sizeof source - 1);
    source[length] = '\0';
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++)
        for (const char *at = source; (at = strstr(at, verbs[i])); at++, count++)
            if (!was_run(at + 1, strcspn(at + 1, "\"")))
                complain("%s: was not run: %.*s", path, (int)strcspn(at, "\n"), at);
    return count;
}

static void all_statements_of_the_sources_were_run(void **state) {
    (void)state;
    char pattern[4096];
    const char *source = getenv("QG_SOURCE");
    glob_t files;
    size_t count = 0;
    complaints = 0;
    snprintf(pattern, sizeof pattern, "%s/server/store/*.c", source ? source : ".");
    assert_int_equal(glob(pattern, 0, NULL, &files), 0);
    for (size_t i = 0; i < files.gl_pathc; i++)
        if (!strstr(files.gl_pathv[i], "/format.c") &&
            !strstr(files.gl_pathv[i], "/restore.c")) /* not while it serves */
            count += look_for_statements(files.gl_pathv[i]);
    globfree(&files);
    assert_true(count > 50);
    assert_int_equal(complaints, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_statement_does_more_when_there_are_more_jobs),
        cmocka_unit_test(no_statement_searches_a_table_that_grows),
        cmocka_unit_test(all_statements_of_the_sources_were_run),
    };
    return cmocka_run_group_tests_name("queries", tests, use_twice, clean_up);
}
