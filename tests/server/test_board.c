/* The board: what is published, and who is woken when. */
#include "tests/server/support.h"

#include <math.h>
#include <semaphore.h>
#include <string.h>
#include <time.h>

#include "server/work/board.h"

#define FIRST "01aaaaaaaaaaaaaaaaaaaaaaaa"
#define SECOND "01bbbbbbbbbbbbbbbbbbbbbbbb"

/* A waiter that counts. */
struct sleeper {
    struct qg_waiter waiter;
    int suspended;
    sem_t woken;
};

static void suspend(void *self) {
    ((struct sleeper *)self)->suspended++;
}

static void resume(void *self) {
    sem_post(&((struct sleeper *)self)->woken);
}

static void sleeper_init(struct sleeper *sleeper, const char *id, int milliseconds) {
    memset(sleeper, 0, sizeof *sleeper);
    strcpy(sleeper->waiter.id, id);
    sleeper->waiter.deadline = qg_monotonic_clock() + milliseconds;
    sleeper->waiter.suspend = suspend;
    sleeper->waiter.resume = resume;
    sleeper->waiter.context = sleeper;
    sem_init(&sleeper->woken, 0, 0);
}

static bool is_awake(struct sleeper *sleeper) {
    return sem_trywait(&sleeper->woken) == 0;
}

static void keeps_the_last_progress(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct qg_job_progress progress = {.done = 1, .total = 9, .phase = "random", .eta = NAN, .best = NAN}, got;
    assert_false(qg_board_progress(board, FIRST, &got));
    qg_board_publish(board, FIRST, &progress);
    progress.done = 2;
    qg_board_publish(board, FIRST, &progress);
    assert_false(qg_board_progress(board, SECOND, &got));
    assert_true(qg_board_progress(board, FIRST, &got));
    assert_int_equal(got.done, 2);
    qg_board_retire(board, FIRST);
    assert_false(qg_board_progress(board, FIRST, &got));
    assert_int_equal(qg_board_version(board), 3);
    qg_board_publish(board, SECOND, &progress); /* left for destroy to free */
    qg_board_destroy(board);
}

static void wakes_only_those_of_the_job(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct sleeper first, second;
    sleeper_init(&first, FIRST, 60000);
    sleeper_init(&second, SECOND, 60000);
    assert_true(qg_board_wait(board, &first.waiter, 0));
    assert_true(qg_board_wait(board, &second.waiter, 0));
    assert_int_equal(first.suspended, 1);
    qg_board_touch(board, FIRST);
    assert_true(is_awake(&first));
    assert_false(is_awake(&second));
    qg_board_touch(board, FIRST);
    assert_false(is_awake(&first));
    qg_board_shut(board);
    assert_true(is_awake(&second));
    qg_board_destroy(board);
}

static void does_not_miss_a_change(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct sleeper sleeper;
    sleeper_init(&sleeper, FIRST, 60000);
    uint64_t version = qg_board_version(board);
    qg_board_touch(board, FIRST);
    assert_false(qg_board_wait(board, &sleeper.waiter, version));
    assert_int_equal(sleeper.suspended, 0);
    qg_board_shut(board);
    assert_true(qg_board_is_shut(board));
    assert_false(qg_board_wait(board, &sleeper.waiter, qg_board_version(board)));
    assert_int_equal(sleeper.suspended, 0);
    qg_board_destroy(board);
}

static void wakes_at_the_deadline(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct sleeper later, sooner;
    sleeper_init(&later, FIRST, 3600000);
    sleeper_init(&sooner, FIRST, 50);
    assert_true(qg_board_wait(board, &later.waiter, 0));
    assert_true(qg_board_wait(board, &sooner.waiter, 0));
    struct timespec limit;
    clock_gettime(CLOCK_REALTIME, &limit);
    limit.tv_sec += 120; /* against hanging */
    assert_int_equal(sem_timedwait(&sooner.woken, &limit), 0);
    assert_true(qg_monotonic_clock() >= sooner.waiter.deadline);
    assert_false(is_awake(&later));
    qg_board_shut(board);
    qg_board_destroy(board);
}

static void tells_which_running_jobs_changed(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct qg_job_progress progress = {.done = 1, .total = 9, .phase = "random", .eta = NAN, .best = NAN};
    char ids[4][QG_JOB_ID_ROOM];
    qg_board_publish(board, FIRST, &progress);
    qg_board_publish(board, SECOND, &progress);
    uint64_t version = qg_board_version(board);
    assert_int_equal(qg_board_touched(board), 0); /* progress is not the store's */
    assert_int_equal(qg_board_news(board, 0, ids, 4), 2);
    assert_int_equal(qg_board_news(board, 0, ids, 1), 1);
    assert_int_equal(qg_board_news(board, version, ids, 4), 0);
    qg_board_touch(board, FIRST);
    assert_int_equal(qg_board_touched(board), version + 1);
    assert_int_equal(qg_board_news(board, version, ids, 4), 1);
    assert_string_equal(ids[0], FIRST);
    qg_board_retire(board, FIRST);
    assert_int_equal(qg_board_touched(board), version + 2);
    assert_int_equal(qg_board_news(board, version, ids, 4), 0);
    qg_board_destroy(board);
}

static void wakes_who_waits_for_any_job(void **state) {
    (void)state;
    struct qg_board *board = qg_board_create();
    struct sleeper sleeper;
    sleeper_init(&sleeper, "", 60000);
    assert_true(qg_board_wait(board, &sleeper.waiter, 0));
    qg_board_touch(board, SECOND);
    assert_true(is_awake(&sleeper));
    qg_board_destroy(board);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_the_last_progress),          cmocka_unit_test(wakes_only_those_of_the_job),
        cmocka_unit_test(does_not_miss_a_change),           cmocka_unit_test(wakes_at_the_deadline),
        cmocka_unit_test(tells_which_running_jobs_changed), cmocka_unit_test(wakes_who_waits_for_any_job),
    };
    return cmocka_run_group_tests_name("board", tests, NULL, NULL);
}
