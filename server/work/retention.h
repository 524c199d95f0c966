/* How long finished jobs are kept, and the thread that drops what is older.
 *
 * Four limits, each off unless set; what any of them does not keep goes, the oldest first by their end. Queued and running
 * jobs are never touched. Evaluations go in small transactions, so that nobody waits long for the writer; then the job, as if
 * a client had deleted it: readers of events and the audit log are told. The file does not shrink, but its pages are used
 * again.
 */
#ifndef QG_SERVER_WORK_RETENTION_H
#define QG_SERVER_WORK_RETENTION_H

#include "server/store/expiry.h"
#include "server/work/board.h"

struct qg_keeper;

/* What else is to be done now and then, by the same thread. */
struct qg_chore {
    void (*run)(void *self); /* NULL: nothing */
    void *self;
};

/* Starts the thread, which looks at once and then every ten minutes. store, board and the chore's self must outlive it. NULL
 * when it cannot. */
struct qg_keeper *qg_keeper_start(struct qg_store *store, struct qg_board *board, const struct qg_retention *retention,
                                  struct qg_chore chore);

/* Stops and frees it, in the middle of its work if need be. NULL is allowed. */
void qg_keeper_stop(struct qg_keeper *keeper);

#endif
