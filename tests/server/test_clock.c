/* Times as text, and waiting for a condition until a moment. */
#include "tests/server/support.h"

#include <string.h>

#include "server/base/clock.h"

static void prints_times(void **state) {
    (void)state;
    static const struct {
        int64_t time;
        const char *text;
    } times[] = {
        {1, "1970-01-01T00:00:00.001Z"},
        {951782400000, "2000-02-29T00:00:00.000Z"},
        {1297000000789, "2011-02-06T13:46:40.789Z"},
        {253402300799999, "9999-12-31T23:59:59.999Z"},
    };
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        char out[QG_TIME_ROOM];
        qg_time_print(out, times[i].time);
        assert_string_equal(out, times[i].text);
    }
}

static void waits_until_the_moment(void **state) {
    (void)state;
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_cond_t never;
    qg_condition_init(&never);
    pthread_mutex_lock(&mutex);
    const int64_t begin = qg_monotonic_clock(), until = begin + 30;
    while (qg_monotonic_clock() < until)
        qg_condition_wait(&never, &mutex, until);
    assert_in_range(qg_monotonic_clock() - begin, 30, 10000);
    qg_condition_wait(&never, &mutex, begin); /* it is past: returns at once */
    pthread_mutex_unlock(&mutex);
    pthread_cond_destroy(&never);
}

static void *signal_soon(void *self) {
    void **shared = self;
    pthread_mutex_lock(shared[0]);
    *(int *)shared[2] = 1;
    pthread_cond_signal(shared[1]);
    pthread_mutex_unlock(shared[0]);
    return NULL;
}

static void waits_for_ever_until_it_is_signalled(void **state) {
    (void)state;
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_cond_t condition;
    pthread_t thread;
    int signalled = 0;
    void *shared[] = {&mutex, &condition, &signalled};
    qg_condition_init(&condition);
    pthread_mutex_lock(&mutex);
    assert_int_equal(pthread_create(&thread, NULL, signal_soon, shared), 0);
    while (!signalled)
        qg_condition_wait(&condition, &mutex, INT64_MAX);
    pthread_mutex_unlock(&mutex);
    pthread_join(thread, NULL);
    pthread_cond_destroy(&condition);
}

static void tells_the_time(void **state) {
    (void)state;
    char out[QG_TIME_ROOM];
    qg_time_print(out, qg_wall_clock());
    assert_true(strcmp(out, "2025-01-01") > 0 && strlen(out) == strlen("2011-02-06T13:46:40.789Z"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(prints_times),
        cmocka_unit_test(waits_until_the_moment),
        cmocka_unit_test(waits_for_ever_until_it_is_signalled),
        cmocka_unit_test(tells_the_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
