/* Limits messages that strangers can cause as often as they like.
 *
 * Messages of one kind, named by a key, share a place. In the minute that begins with the first of them QG_LIMIT_BURST are
 * admitted, the others counted; when the minute is over, the count is handed out with the last one's words, to be told. There
 * are QG_LIMIT_PLACES places; while all are taken, further kinds share one more. So a stranger who varies the key, too,
 * causes at most (QG_LIMIT_PLACES + 1) * QG_LIMIT_BURST lines a minute.
 *
 * A key is kept as a hash (FNV-1a, 64 bits): two kinds that collide share a place, which loses no count.
 * Threads: any. Time is monotonic milliseconds.
 */
#ifndef QG_SERVER_BASE_LOG_LIMIT_H
#define QG_SERVER_BASE_LOG_LIMIT_H

#include <pthread.h>
#include <stdatomic.h>

#include "server/base/log.h"

enum { QG_LIMIT_BURST = 10, QG_LIMIT_MS = 60000, QG_LIMIT_PLACES = 64, QG_LIMIT_SAMPLE_ROOM = 160 };

/* Messages that were not written. */
struct qg_limited {
    unsigned long long count;
    int64_t since; /* when the first message of this kind came, one that was written */
    enum qg_priority priority;
    enum qg_event event;
    char sample[QG_LIMIT_SAMPLE_ROOM]; /* the words of the last one, or their beginning */
};

/* One kind of message. */
struct qg_limit_place {
    bool taken;
    uint64_t kind;
    int64_t since;
    int admitted;
    struct qg_limited dropped;
};

/* QG_LIMITER_INIT before its first use. */
struct qg_limiter {
    pthread_mutex_t mutex;
    atomic_int owing;                                 /* places with a count that is to be told */
    struct qg_limit_place place[QG_LIMIT_PLACES + 1]; /* the last one is shared */
};
#define QG_LIMITER_INIT                                                                                                \
    { .mutex = PTHREAD_MUTEX_INITIALIZER }

/* True when a message of the event's kind (its `limit`, which is not NULL) may be written now; else it is counted. */
bool qg_limiter_admits(struct qg_limiter *limiter, const struct qg_log_event *event, const char *message, int64_t now);

/* Hands out one count whose minute is over (INT64_MAX as time: whose ever); false when there is none. Cheap when nothing was dropped. */
bool qg_limiter_tell(struct qg_limiter *limiter, int64_t now, struct qg_limited *out);

#endif
