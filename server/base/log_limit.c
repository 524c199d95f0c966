/* Limits repeated messages. See log_limit.h. */
#include "server/base/log_limit.h"

#include <stdio.h>
#include <string.h>

static uint64_t hash(const char *key) {
    uint64_t value = UINT64_C(14695981039346656037);
    for (; *key; key++)
        value = (value ^ (unsigned char)*key) * UINT64_C(1099511628211);
    return value;
}

static bool is_over(const struct qg_limit_place *place, int64_t now) {
    return now - place->since >= QG_LIMIT_MS;
}

/* The place of a kind: its own, one that is free, or the shared one. The mutex is held. */
static struct qg_limit_place *find_place(struct qg_limiter *limiter, uint64_t kind, int64_t now) {
    struct qg_limit_place *vacant = NULL;
    for (int i = 0; i < QG_LIMIT_PLACES; i++) {
        struct qg_limit_place *place = &limiter->place[i];
        if (place->taken && place->kind == kind)
            return place;
        if (!vacant && (!place->taken || (is_over(place, now) && place->dropped.count == 0)))
            vacant = place;
    }
    if (!vacant)
        return &limiter->place[QG_LIMIT_PLACES];
    *vacant = (struct qg_limit_place){.kind = kind};
    return vacant;
}

/* Counts a message that is not written. The mutex is held. */
static void drop(struct qg_limiter *limiter, struct qg_limit_place *place, const struct qg_log_event *event,
                 const char *message) {
    struct qg_limited *dropped = &place->dropped;
    if (dropped->count++ == 0)
        atomic_fetch_add(&limiter->owing, 1);
    dropped->priority = event->priority;
    dropped->event = event->event;
    snprintf(dropped->sample, sizeof dropped->sample, "%s", message);
}

bool qg_limiter_admits(struct qg_limiter *limiter, const struct qg_log_event *event, const char *message, int64_t now) {
    pthread_mutex_lock(&limiter->mutex);
    struct qg_limit_place *place = find_place(limiter, hash(event->limit), now);
    if (!place->taken || (is_over(place, now) && place->dropped.count == 0)) {
        place->taken = true;
        place->since = now;
        place->admitted = 0;
    }
    bool admitted = place->admitted < QG_LIMIT_BURST;
    if (admitted)
        place->admitted++;
    else
        drop(limiter, place, event, message);
    pthread_mutex_unlock(&limiter->mutex);
    return admitted;
}

bool qg_limiter_tell(struct qg_limiter *limiter, int64_t now, struct qg_limited *out) {
    if (atomic_load_explicit(&limiter->owing, memory_order_relaxed) == 0)
        return false;
    bool found = false;
    pthread_mutex_lock(&limiter->mutex);
    for (int i = 0; i <= QG_LIMIT_PLACES && !found; i++) {
        struct qg_limit_place *place = &limiter->place[i];
        found = place->dropped.count > 0 && is_over(place, now);
        if (!found)
            continue;
        *out = place->dropped;
        out->since = place->since;
        *place = (struct qg_limit_place){0};
        atomic_fetch_sub(&limiter->owing, 1);
    }
    pthread_mutex_unlock(&limiter->mutex);
    return found;
}
