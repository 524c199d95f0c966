/* A pool of threads that serves several jobs fairly: an executor (executor.h).
 *
 * Every call of run() is a batch. Free threads take one piece at a time from the batches in turn (round robin), so that a
 * single batch gets all threads and several batches get equal shares, whatever their sizes.
 */
#ifndef QG_CORE_POOL_H
#define QG_CORE_POOL_H

#include "core/executor.h"
#include "core/status.h"

struct qg_pool;

/* Starts `threads` >= 1 threads. NULL when memory or threads cannot be had. */
struct qg_pool *qg_pool_create(int threads);

/* Waits for running batches, ends the threads and frees the pool. NULL is allowed. No run() may begin after it has been
 * called. */
void qg_pool_destroy(struct qg_pool *pool);

/* The pool as an executor; valid as long as the pool. */
struct qg_executor qg_pool_executor(struct qg_pool *pool);

#endif
