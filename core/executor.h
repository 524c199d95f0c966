/* The seam for computing power inside one process: "run these n independent pieces of work, in any order, on any threads".
 *
 * Core never starts threads by itself; it hands pieces to an executor. pool.h is one, serial execution another. Because
 * pieces are independent and their cut does not depend on the executor, results are the same bits for any of them.
 */
#ifndef QG_CORE_EXECUTOR_H
#define QG_CORE_EXECUTOR_H

#include <stddef.h>

/* One piece of work. worker is in 0..workers-1 of the executor: no two pieces run at once under the same worker number
 * for the same call, so it may index workspaces. */
typedef void qg_piece(void *context, size_t item, int worker);

struct qg_executor {
    void *self;
    int workers;
    /* Returns when all n pieces are done; n may be 0. May be called from several threads at once, but not from inside a
     * piece. */
    void (*run)(void *self, size_t n, qg_piece *piece, void *context);
};

/* Runs everything on the calling thread, in order. */
extern const struct qg_executor qg_serial_executor;

#endif
