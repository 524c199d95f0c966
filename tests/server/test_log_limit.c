/* The limiter of repeated messages, on a clock of the test's own. */
#include "tests/server/support.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "server/base/log_limit.h"

static bool admits(struct qg_limiter *limiter, const char *kind, int64_t now) {
    const struct qg_log_event event = {.priority = QG_LOG_WARNING, .event = QG_EVENT_ACCESS_DENIED, .limit = kind};
    return qg_limiter_admits(limiter, &event, kind, now);
}

/* How many of `count` messages of a kind are admitted at one time. */
static int admitted(struct qg_limiter *limiter, const char *kind, int count, int64_t now) {
    int sum = 0;
    for (int i = 0; i < count; i++)
        sum += admits(limiter, kind, now);
    return sum;
}

static void admits_a_few_and_counts_the_rest(void **state) {
    (void)state;
    struct qg_limiter limiter = QG_LIMITER_INIT;
    struct qg_limited dropped;
    assert_int_equal(admitted(&limiter, "a", 100, 5000), QG_LIMIT_BURST);
    assert_int_equal(admitted(&limiter, "b", 3, 5000), 3);
    assert_false(qg_limiter_tell(&limiter, 5000 + QG_LIMIT_MS - 1, &dropped));
    assert_int_equal(admitted(&limiter, "a", 1, 5000 + QG_LIMIT_MS - 1), 0);
    assert_true(qg_limiter_tell(&limiter, 5000 + QG_LIMIT_MS, &dropped));
    assert_int_equal(dropped.count, 101 - QG_LIMIT_BURST);
    assert_int_equal(dropped.since, 5000);
    assert_int_equal(dropped.priority, QG_LOG_WARNING);
    assert_int_equal(dropped.event, QG_EVENT_ACCESS_DENIED);
    assert_string_equal(dropped.sample, "a");
    assert_false(qg_limiter_tell(&limiter, INT64_MAX, &dropped));
    assert_int_equal(admitted(&limiter, "a", 100, 6000 + QG_LIMIT_MS), QG_LIMIT_BURST);
}

static void what_is_rare_is_never_dropped(void **state) {
    (void)state;
    struct qg_limiter limiter = QG_LIMITER_INIT;
    struct qg_limited dropped;
    for (int minute = 0; minute < 50; minute++)
        assert_int_equal(admitted(&limiter, "a", QG_LIMIT_BURST, (int64_t)minute * QG_LIMIT_MS), QG_LIMIT_BURST);
    assert_false(qg_limiter_tell(&limiter, INT64_MAX, &dropped));
}

static void a_count_that_nobody_has_asked_for_goes_on(void **state) {
    (void)state;
    struct qg_limiter limiter = QG_LIMITER_INIT;
    struct qg_limited dropped;
    admitted(&limiter, "a", 20, 0);
    assert_int_equal(admitted(&limiter, "a", 20, 10 * QG_LIMIT_MS), 0);
    assert_true(qg_limiter_tell(&limiter, 10 * QG_LIMIT_MS, &dropped));
    assert_int_equal(dropped.count, 40 - QG_LIMIT_BURST);
}

static void kinds_without_number_cost_lines_in_number(void **state) {
    (void)state;
    struct qg_limiter limiter = QG_LIMITER_INIT;
    struct qg_limited dropped;
    int sum = 0;
    unsigned long long counted = 0;
    char kind[32];
    for (int i = 0; i < 20000; i++) {
        snprintf(kind, sizeof kind, "from %d", i % 2000);
        sum += admits(&limiter, kind, 7);
    }
    assert_int_equal(sum, (QG_LIMIT_PLACES + 1) * QG_LIMIT_BURST);
    while (qg_limiter_tell(&limiter, INT64_MAX, &dropped))
        counted += dropped.count;
    assert_int_equal(counted, 20000 - sum);
    assert_int_equal(admitted(&limiter, "another", 5, 8), 5); /* there is room again */
}

static void places_are_used_again(void **state) {
    (void)state;
    struct qg_limiter limiter = QG_LIMITER_INIT;
    char kind[32];
    for (int i = 0; i < 50 * QG_LIMIT_PLACES; i++) {
        snprintf(kind, sizeof kind, "%d", i);
        assert_true(admits(&limiter, kind, (int64_t)i * QG_LIMIT_MS / QG_LIMIT_PLACES));
    }
}

enum { THREADS = 4, EACH = 20000 };

static void *flood(void *self) {
    struct qg_limiter *limiter = self;
    struct qg_limited dropped;
    intptr_t seen = 0;
    for (int i = 0; i < EACH; i++) {
        seen += admits(limiter, "a", (int64_t)i * 10);
        if (qg_limiter_tell(limiter, (int64_t)i * 10, &dropped))
            seen += (intptr_t)dropped.count;
    }
    return (void *)seen;
}

static void threads_lose_no_count(void **state) {
    (void)state;
    static struct qg_limiter limiter = QG_LIMITER_INIT;
    struct qg_limited dropped;
    pthread_t threads[THREADS];
    long long sum = 0;
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, flood, &limiter), 0);
    for (int i = 0; i < THREADS; i++) {
        void *seen;
        pthread_join(threads[i], &seen);
        sum += (intptr_t)seen;
    }
    while (qg_limiter_tell(&limiter, INT64_MAX, &dropped))
        sum += (long long)dropped.count;
    assert_int_equal(sum, (long long)THREADS * EACH);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(admits_a_few_and_counts_the_rest),
        cmocka_unit_test(what_is_rare_is_never_dropped),
        cmocka_unit_test(a_count_that_nobody_has_asked_for_goes_on),
        cmocka_unit_test(kinds_without_number_cost_lines_in_number),
        cmocka_unit_test(places_are_used_again),
        cmocka_unit_test(threads_lose_no_count),
    };
    return cmocka_run_group_tests_name("log_limit", tests, NULL, NULL);
}
