/* How long finished jobs are kept, and the thread that drops what is older.
 *
 * Four limits, each off unless set; what any of them does not keep goes, the oldest first by their end. Queued and running
 * jobs are never touched. Evaluations go in small transactions, so that nobody waits long for the writer; then the job, as if
 * a client had deleted it: readers of events and the audit log are told. The file does not shrink, but its pages are used
 * again.
 */
#ifndef QG_SERVER_RETENTION_H
#define QG_SERVER_RETENTION_H

#include "server/board.h"
#include "server/store.h"

/* What is kept of finished jobs; 0: without limit. */
struct qg_retention {
    int job_days;        /* since their end */
    int evaluation_days; /* the log of evaluations; the result stays */
    int jobs;            /* how many */
    int megabytes;       /* of the database, free pages not counted: the oldest go until it fits */
};

struct qg_keeper;

/* Starts the thread, which looks at once and then every ten minutes. store and board must outlive it. NULL when it cannot. */
struct qg_keeper *qg_keeper_start(struct qg_store *store, struct qg_board *board, const struct qg_retention *retention);

/* Stops and frees it, in the middle of its work if need be. NULL is allowed. */
void qg_keeper_stop(struct qg_keeper *keeper);

/* The id of the next finished job to be dropped, by its limits and the time (ms since 1970 UTC). QG_STORE_NOT_FOUND when
 * there is none. */
enum qg_store_status qg_store_expired(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                      char id[QG_JOB_ID_ROOM]);

/* The id of the next finished job whose log of evaluations is to go. QG_STORE_NOT_FOUND when there is none. */
enum qg_store_status qg_store_expired_log(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                          char id[QG_JOB_ID_ROOM]);

/* Drops up to a few thousand evaluations of a job. QG_STORE_NOT_FOUND when it has none left, QG_STORE_WRONG_STATE when it is
 * not finished. */
enum qg_store_status qg_store_drop_evaluations(struct qg_store *store, const char *id);

#endif
