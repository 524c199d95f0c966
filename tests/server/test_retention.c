/* What is dropped of finished jobs, and what never is. */
#include "tests/server/place.h"

#include <math.h>
#include <time.h>

#include "server/work/retention.h"

#define DAY INT64_C(86400000)
#define NOW (1000 * DAY)

/* A job with a number for its id, that ended `days` before NOW (queued when days < 0), with evaluations. */
static void add_job(struct place *place, int number, double days, int evaluations) {
    char sql[1024];
    if (days < 0)
        snprintf(sql, sizeof sql,
                 "INSERT INTO jobs (seq, id, name, kind, labels, state, submitted_at, document)"
                 " VALUES (%d, 'job%d', '', 'optimize', '[]', 'queued', 0, '{}')",
                 number, number);
    else
        snprintf(sql, sizeof sql,
                 "INSERT INTO jobs (seq, id, name, kind, labels, state, submitted_at, finished_at, document)"
                 " VALUES (%d, 'job%d', '', 'optimize', '[]', 'succeeded', 0, %.0f, '{}');"
                 "WITH RECURSIVE n(i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i + 1 < %d)"
                 " INSERT INTO evaluations SELECT %d, i, 'random', 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, NULL FROM n;"
                 "INSERT INTO outputs VALUES (%d, 'result', '{}');",
                 number, number, (double)NOW - days * (double)DAY, evaluations, number, number);
    run_sql(place, sql);
}

static void assert_next(struct place *place, const struct qg_retention *retention, const char *expected) {
    char id[QG_JOB_ID_ROOM] = "";
    enum qg_store_status status = qg_store_expired(place->store, retention, NOW, id);
    if (!expected) {
        assert_int_equal(status, QG_STORE_NOT_FOUND);
        return;
    }
    assert_int_equal(status, QG_STORE_OK);
    assert_string_equal(id, expected);
    assert_int_equal(qg_store_delete(place->store, id, NULL), QG_STORE_OK);
}

/* Job 1 waits; 3 ended before 2, and 4 last. */
static void add_four(struct place *place) {
    add_job(place, 1, -1, 0);
    add_job(place, 2, 20, 3);
    add_job(place, 3, 30, 3);
    add_job(place, 4, 1, 3);
}

static void without_limits_all_stays(void **state) {
    add_four(*state);
    assert_next(*state, &(struct qg_retention){0}, NULL);
}

static void by_age_the_oldest_end_first(void **state) {
    const struct qg_retention retention = {.job_days = 10};
    add_four(*state);
    assert_next(*state, &retention, "job3");
    assert_next(*state, &retention, "job2");
    assert_next(*state, &retention, NULL);
    assert_int_equal(ask_sql(*state, "SELECT count(*) FROM jobs"), 2);
    assert_int_equal(ask_sql(*state, "SELECT count(*) FROM evaluations"), 3);
}

static void by_count_queued_ones_do_not_count(void **state) {
    const struct qg_retention retention = {.jobs = 1};
    char id[QG_JOB_ID_ROOM];
    add_four(*state);
    for (int i = 0; i < 2; i++) {
        struct place *place = *state;
        assert_int_equal(qg_store_expired(place->store, &retention, NOW, id), QG_STORE_OK);
        assert_string_not_equal(id, "job1");
        assert_string_not_equal(id, "job4");
        assert_int_equal(qg_store_delete(place->store, id, NULL), QG_STORE_OK);
    }
    assert_next(*state, &retention, NULL);
    assert_int_equal(ask_sql(*state, "SELECT count(*) FROM jobs WHERE id IN ('job1', 'job4')"), 2);
}

static void by_size_until_it_fits(void **state) {
    struct place *place = *state;
    const struct qg_retention retention = {.megabytes = 2};
    int64_t used;
    for (int i = 1; i <= 10; i++)
        add_job(place, i, 100 - i, 9000);
    while (used = ask_sql(place, "SELECT (page_count - freelist_count) * page_size FROM pragma_page_count,"
                                 " pragma_freelist_count, pragma_page_size"),
           used > 2000000) {
        char next[QG_JOB_ID_ROOM];
        snprintf(next, sizeof next, "job%d", 1 + (int)(10 - ask_sql(place, "SELECT count(*) FROM jobs")));
        assert_next(place, &retention, next);
    }
    assert_next(place, &retention, NULL);
    assert_true(ask_sql(place, "SELECT count(*) FROM jobs") > 2);
    assert_true(ask_sql(place, "SELECT count(*) FROM jobs") < 8);
}

static void evaluations_go_and_results_stay(void **state) {
    struct place *place = *state;
    const struct qg_retention retention = {.evaluation_days = 10};
    char id[QG_JOB_ID_ROOM];
    add_job(place, 1, 20, 12000);
    add_job(place, 2, 5, 10);
    assert_int_equal(qg_store_expired_log(place->store, &retention, NOW, id), QG_STORE_OK);
    assert_string_equal(id, "job1");
    int transactions = 0;
    while (qg_store_drop_evaluations(place->store, id) == QG_STORE_OK)
        transactions++;
    assert_int_equal(transactions, 12000 / QG_EVALUATIONS_AT_ONCE);
    assert_int_equal(qg_store_expired_log(place->store, &retention, NOW, id), QG_STORE_NOT_FOUND);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM evaluations"), 10);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM outputs"), 2);
    assert_next(place, &retention, NULL);
}

static void the_log_of_an_unfinished_job_is_not_touched(void **state) {
    struct place *place = *state;
    add_job(place, 1, -1, 0);
    run_sql(place, "INSERT INTO evaluations VALUES (1, 0, 'random', 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, NULL)");
    assert_int_equal(qg_store_drop_evaluations(place->store, "job1"), QG_STORE_WRONG_STATE);
    assert_int_equal(qg_store_drop_evaluations(place->store, "nobody"), QG_STORE_NOT_FOUND);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM evaluations"), 1);
}

static void count_run(void *self) {
    atomic_fetch_add((atomic_int *)self, 1);
}

/* Moments in two minutes: against hanging. */
enum { PATIENCE = 12000 };

/* The thread does all of it, and writes it down. */
static void the_thread_cleans_up_at_once(void **state) {
    struct place *place = *state;
    const struct qg_retention retention = {.jobs = 1, .evaluation_days = 1};
    const struct timespec moment = {.tv_nsec = 10000000};
    struct qg_board *board = qg_board_create();
    add_four(place); /* they ended in 1972 */
    uint64_t version = qg_board_version(board);
    atomic_int runs = 0;
    const struct qg_chore chore = {.run = count_run, .self = &runs};
    struct qg_keeper *keeper = qg_keeper_start(place->store, board, &retention, chore);
    for (int i = 0; i < PATIENCE && qg_board_version(board) < version + 2; i++)
        nanosleep(&moment, NULL);
    for (int i = 0; i < PATIENCE && ask_sql(place, "SELECT count(*) FROM evaluations") > 0; i++)
        nanosleep(&moment, NULL);
    for (int i = 0; i < PATIENCE && runs == 0; i++)
        nanosleep(&moment, NULL);
    qg_keeper_stop(keeper);
    assert_int_equal(runs, 1);
    qg_board_destroy(board);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM jobs WHERE id IN ('job1', 'job4')"), 2);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM jobs"), 2);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM evaluations"), 0);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM audit WHERE action = 'job.delete' AND name = 'quietgeard'"),
                     2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        PLACE_TEST(without_limits_all_stays),          PLACE_TEST(by_age_the_oldest_end_first),
        PLACE_TEST(by_count_queued_ones_do_not_count), PLACE_TEST(by_size_until_it_fits),
        PLACE_TEST(evaluations_go_and_results_stay),   PLACE_TEST(the_log_of_an_unfinished_job_is_not_touched),
        PLACE_TEST(the_thread_cleans_up_at_once),
    };
    return cmocka_run_group_tests_name("retention", tests, NULL, NULL);
}
