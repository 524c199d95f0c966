/* A short list of compliances under one lock. A gear's compliance is some megabytes, so that the list never grows long and
 * a linear search costs nothing beside what it saves. */
#include "core/cache.h"

#include <assert.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

struct entry {
    struct qg_compliance_key key;
    struct qg_compliance value;
    size_t bytes, holders;
    unsigned long last_use;
    struct entry *next;
};

struct qg_cache {
    pthread_mutex_t mutex; /* guards everything below */
    size_t limit;
    struct entry *first;
    unsigned long uses;
    struct qg_cache_counts counts;
};

struct qg_cache *qg_cache_create(size_t bytes) {
    struct qg_cache *cache = calloc(1, sizeof *cache);
    if (!cache)
        return NULL;
    cache->limit = bytes;
    if (pthread_mutex_init(&cache->mutex, NULL) != 0) {
        free(cache);
        return NULL;
    }
    return cache;
}

static void entry_destroy(struct entry *entry) {
    qg_compliance_finish(&entry->value);
    free(entry);
}

void qg_cache_destroy(struct qg_cache *cache) {
    if (!cache)
        return;
    for (struct entry *e = cache->first, *next; e; e = next) {
        next = e->next;
        assert(e->holders == 0);
        entry_destroy(e);
    }
    pthread_mutex_destroy(&cache->mutex);
    free(cache);
}

static size_t bytes_of(const struct qg_compliance *c) {
    size_t n = 2 * c->flank_count, m = c->boundary;
    return sizeof(double) *
           (n * n + n * m + (size_t)(c->reach + 1) * m * m + 3 * c->flank_count + c->root_count * (n + m + 2));
}

static bool same_gear(const struct qg_gear *a, const struct qg_gear *b) {
    return a->teeth == b->teeth && a->profile_shift == b->profile_shift && a->outside_radius == b->outside_radius &&
           a->root_radius == b->root_radius && a->hob_tip_radius == b->hob_tip_radius &&
           a->bore_diameter == b->bore_diameter && a->face_width == b->face_width;
}

static bool same_plate(const struct qg_plate *a, const struct qg_plate *b) {
    return a->youngs_modulus == b->youngs_modulus && a->poisson_ratio == b->poisson_ratio &&
           a->thickness == b->thickness && a->plane_strain == b->plane_strain;
}

static bool same_key(const struct qg_compliance_key *a, const struct qg_compliance_key *b) {
    return a->rack.module == b->rack.module && a->rack.pressure_angle == b->rack.pressure_angle &&
           same_gear(&a->gear, &b->gear) && same_plate(&a->plate, &b->plate) && a->support == b->support &&
           a->refinement == b->refinement && a->reach == b->reach;
}

static struct entry *find(struct qg_cache *cache, const struct qg_compliance_key *key) {
    for (struct entry *e = cache->first; e; e = e->next)
        if (same_key(&e->key, key))
            return e;
    return NULL;
}

static const struct qg_compliance *hold(struct qg_cache *cache, struct entry *entry) {
    entry->holders++;
    entry->last_use = ++cache->uses;
    return &entry->value;
}

/* Drops the least recently used ones that nobody holds until the limit is kept, or none is left to drop. */
static void make_room(struct qg_cache *cache) {
    while (cache->counts.bytes > cache->limit) {
        struct entry **oldest = NULL;
        for (struct entry **at = &cache->first; *at; at = &(*at)->next)
            if ((*at)->holders == 0 && (!oldest || (*at)->last_use < (*oldest)->last_use))
                oldest = at;
        if (!oldest)
            return;
        struct entry *gone = *oldest;
        *oldest = gone->next;
        cache->counts.bytes -= gone->bytes;
        cache->counts.kept--;
        entry_destroy(gone);
    }
}

const struct qg_compliance *qg_cache_take(struct qg_cache *cache, const struct qg_compliance_key *key) {
    pthread_mutex_lock(&cache->mutex);
    struct entry *entry = find(cache, key);
    const struct qg_compliance *value = entry ? hold(cache, entry) : NULL;
    if (entry)
        cache->counts.found++;
    else
        cache->counts.missed++;
    pthread_mutex_unlock(&cache->mutex);
    return value;
}

const struct qg_compliance *qg_cache_keep(struct qg_cache *cache, const struct qg_compliance_key *key,
                                          struct qg_compliance *compliance) {
    struct entry *fresh = calloc(1, sizeof *fresh);
    if (!fresh)
        return NULL;
    pthread_mutex_lock(&cache->mutex);
    struct entry *entry = find(cache, key);
    if (!entry) {
        entry = fresh;
        fresh = NULL;
        entry->key = *key;
        entry->value = *compliance;
        entry->bytes = bytes_of(compliance);
        entry->next = cache->first;
        cache->first = entry;
        cache->counts.bytes += entry->bytes;
        cache->counts.kept++;
        *compliance = (struct qg_compliance){0};
    }
    const struct qg_compliance *value = hold(cache, entry);
    make_room(cache);
    pthread_mutex_unlock(&cache->mutex);
    free(fresh);
    qg_compliance_finish(compliance);
    return value;
}

void qg_cache_release(struct qg_cache *cache, const struct qg_compliance *compliance) {
    pthread_mutex_lock(&cache->mutex);
    for (struct entry *e = cache->first; e; e = e->next)
        if (&e->value == compliance) {
            assert(e->holders > 0);
            e->holders--;
        }
    make_room(cache);
    pthread_mutex_unlock(&cache->mutex);
}

struct qg_cache_counts qg_cache_count(struct qg_cache *cache) {
    pthread_mutex_lock(&cache->mutex);
    struct qg_cache_counts counts = cache->counts;
    pthread_mutex_unlock(&cache->mutex);
    return counts;
}
