/* Clocks and waiting. See clock.h. */
#include "server/base/clock.h"

#include <stdio.h>
#include <time.h>

static int64_t read_clock(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

int64_t qg_monotonic_clock(void) {
    return read_clock(CLOCK_MONOTONIC);
}

int64_t qg_wall_clock(void) {
    return read_clock(CLOCK_REALTIME);
}

void qg_condition_init(pthread_cond_t *condition) {
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &attributes);
    pthread_condattr_destroy(&attributes);
}

void qg_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until) {
    const struct timespec time = {.tv_sec = until / 1000, .tv_nsec = until % 1000 * 1000000};
    if (until == INT64_MAX)
        pthread_cond_wait(condition, mutex);
    else
        pthread_cond_timedwait(condition, mutex, &time);
}

void qg_time_print(char out[QG_TIME_ROOM], int64_t milliseconds) {
    time_t seconds = (time_t)(milliseconds / 1000);
    struct tm utc;
    gmtime_r(&seconds, &utc);
    size_t length = strftime(out, QG_TIME_ROOM, "%Y-%m-%dT%H:%M:%S", &utc);
    snprintf(out + length, QG_TIME_ROOM - length, ".%03dZ", (int)(milliseconds % 1000));
}
