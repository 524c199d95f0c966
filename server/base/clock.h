/* Time: the clocks, conditions that are waited for until a moment, and times as text.
 *
 * Moments that are waited for are milliseconds of CLOCK_MONOTONIC, which nobody sets; times that are told and stored are
 * milliseconds since 1970 UTC. Threads: any.
 */
#ifndef QG_SERVER_BASE_CLOCK_H
#define QG_SERVER_BASE_CLOCK_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* Milliseconds of CLOCK_MONOTONIC. */
int64_t qg_monotonic_clock(void);

/* Milliseconds since 1970 UTC. */
int64_t qg_wall_clock(void);

/* Makes a condition for qg_condition_wait; pthread_cond_destroy ends it. */
void qg_condition_init(pthread_cond_t *condition);

/* Waits until the condition is signalled, or until a moment of qg_monotonic_clock, INT64_MAX being never. May return sooner, as
 * any wait for a condition. The mutex is held, before and after. */
void qg_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until);

/* Prints a time (ms since 1970 UTC) as RFC 3339 with milliseconds: 2011-02-03T04:05:06.789Z. */
enum { QG_TIME_ROOM = 40 };
void qg_time_print(char out[QG_TIME_ROOM], int64_t milliseconds);

/* Reads an RFC 3339 time, "T" and "Z" in capitals, as ms since 1970 UTC; digits beyond the millisecond are cut off. False when
 * the text is none, or names a second that is not (February 30th, 24:00, a leap second). */
bool qg_time_read(const char *text, int64_t *milliseconds);

#endif
