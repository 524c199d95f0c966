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

/* The number of exactly `count` digits at *text, which is moved behind them; -1 when they are not there. */
static int read_digits(const char **text, int count) {
    int number = 0;
    for (; count > 0; count--, (*text)++) {
        if (**text < '0' || **text > '9')
            return -1;
        number = 10 * number + **text - '0';
    }
    return number;
}

static bool skip(const char **text, char expected) {
    if (**text != expected)
        return false;
    ++*text;
    return true;
}

/* "YYYY-MM-DDTHH:MM:SS" as seconds. False when there is no such second. */
static bool read_second(const char **text, int64_t *seconds) {
    struct tm parts = {.tm_isdst = 0}, again;
    parts.tm_year = read_digits(text, 4) - 1900;
    bool right = skip(text, '-');
    parts.tm_mon = read_digits(text, 2) - 1;
    right = skip(text, '-') && right;
    parts.tm_mday = read_digits(text, 2);
    right = skip(text, 'T') && right;
    parts.tm_hour = read_digits(text, 2);
    right = skip(text, ':') && right;
    parts.tm_min = read_digits(text, 2);
    right = skip(text, ':') && right;
    parts.tm_sec = read_digits(text, 2);
    struct tm normal = parts;
    time_t time = timegm(&normal);
    *seconds = time;
    gmtime_r(&time, &again); /* a day too many has become one of the next month */
    return right && parts.tm_year == again.tm_year && parts.tm_mon == again.tm_mon && parts.tm_mday == again.tm_mday &&
           parts.tm_hour == again.tm_hour && parts.tm_min == again.tm_min && parts.tm_sec == again.tm_sec;
}

/* ".5" and the like, if there is a point, as milliseconds. False when no digits follow it. */
static bool read_fraction(const char **text, int64_t *milliseconds) {
    int64_t scale = 100;
    *milliseconds = 0;
    if (**text != '.')
        return true;
    const char *first = ++*text;
    for (; **text >= '0' && **text <= '9'; ++*text, scale /= 10)
        *milliseconds += scale * (**text - '0');
    return *text > first;
}

/* "Z" or "+HH:MM" as the milliseconds that local time is ahead. */
static bool read_offset(const char **text, int64_t *ahead) {
    *ahead = 0;
    if (**text == 'Z')
        return ++*text;
    int sign = **text == '+' ? 1 : **text == '-' ? -1 : 0;
    if (sign == 0)
        return false;
    ++*text;
    int hours = read_digits(text, 2);
    bool right = skip(text, ':');
    int minutes = read_digits(text, 2);
    *ahead = sign * (hours * 60 + minutes) * INT64_C(60000);
    return right && hours >= 0 && hours < 24 && minutes >= 0 && minutes < 60;
}

bool qg_time_read(const char *text, int64_t *milliseconds) {
    int64_t seconds, fraction, ahead;
    if (!read_second(&text, &seconds) || !read_fraction(&text, &fraction) || !read_offset(&text, &ahead) || *text)
        return false;
    *milliseconds = seconds * 1000 + fraction - ahead;
    return true;
}
