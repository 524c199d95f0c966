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

static void reads_times(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int64_t time;
    } times[] = {
        {"1970-01-01T00:00:00.001Z", 1},
        {"2000-02-29T00:00:00Z", 951782400000},
        {"2011-02-06T13:46:40.789Z", 1297000000789},
        {"2011-02-06T13:46:40.7899999999999999999Z", 1297000000789},
        {"2011-02-06T14:46:40.7+01:00", 1297000000700},
        {"2011-02-05T22:01:40-15:45", 1297000000000},
        {"9999-12-31T23:59:59.999Z", 253402300799999},
        {"0000-01-01T00:00:00Z", -62167219200000},
    };
    static const char *const wrong[] = {
        "",
        "now",
        "2011",
        "2011-02-06",
        "2011-02-06 13:46:40Z",
        "2011-02-06T13:46:40",
        "2011-02-06T13:46Z",
        "2011-02-06T13:46:40.Z",
        "2011-02-06T13:46:40z",
        "2011-02-06T13:46:40Z ",
        "2011-02-06T13:46:40+1:00",
        "2011-02-06T13:46:40+24:00",
        "2011-02-06T13:46:40+01:60",
        "2011-02-06T13:46:40+01",
        "2011-02-30T00:00:00Z",
        "2011-00-01T00:00:00Z",
        "2011-13-01T00:00:00Z",
        "2011-02-00T00:00:00Z",
        "2011-02-06T24:00:00Z",
        "2011-02-06T23:60:00Z",
        "2016-12-31T23:59:60Z",
        "-011-02-06T13:46:40Z",
        "2011-+2-06T13:46:40Z",
        " 2011-02-06T13:46:40Z",
        "12011-02-06T13:46:40Z",
    };
    int64_t time;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        assert_true(qg_time_read(times[i].text, &time));
        assert_int_equal(time, times[i].time);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (qg_time_read(wrong[i], &time))
            fail_msg("%s was read", wrong[i]);
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
    assert_true(qg_monotonic_clock() >= until);
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
        cmocka_unit_test(prints_times),           cmocka_unit_test(reads_times),
        cmocka_unit_test(waits_until_the_moment), cmocka_unit_test(waits_for_ever_until_it_is_signalled),
        cmocka_unit_test(tells_the_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
