/* Compliances of gears kept by content, so that the next job on the same gear does not compute them again.
 *
 * A compliance is a pure function of its key; handing out a kept one gives the same bits as computing it. The least
 * recently used ones that nobody holds go when the limit is reached. Threads: any, at any time.
 */
#ifndef QG_CORE_CACHE_H
#define QG_CORE_CACHE_H

#include "core/compliance.h"

/* Everything that a compliance depends on. */
struct qg_compliance_key {
    struct qg_rack rack;
    struct qg_gear gear; /* but for its moment of inertia */
    struct qg_plate plate;
    int support; /* enum qg_support */
    int refinement, reach;
};

struct qg_cache;

/* A cache of about `bytes`. NULL when memory is short. */
struct qg_cache *qg_cache_create(size_t bytes);

/* Frees the cache and what it keeps; everything taken must have been released. NULL is allowed. */
void qg_cache_destroy(struct qg_cache *cache);

/* The compliance of that key, to be released; NULL when it is not kept. */
const struct qg_compliance *qg_cache_take(struct qg_cache *cache, const struct qg_compliance_key *key);

/* Hands a computed compliance over to the cache (*compliance is emptied) and takes it at once; when another thread was
 * faster, its copy is taken instead. NULL when memory is short: *compliance then stays the caller's. */
const struct qg_compliance *qg_cache_keep(struct qg_cache *cache, const struct qg_compliance_key *key,
                                          struct qg_compliance *compliance);

void qg_cache_release(struct qg_cache *cache, const struct qg_compliance *compliance);

/* How many compliances are kept, and how many takes found what they looked for. */
struct qg_cache_counts {
    size_t kept, bytes, found, missed;
};
struct qg_cache_counts qg_cache_count(struct qg_cache *cache);

#endif
