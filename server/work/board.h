/* The board: how far the running jobs are, in memory, and who waits for a job to change.
 *
 * The runner publishes; HTTP reads and waits. A reader that wants to wait reads the version first, then the job, and waits
 * with that version: when anything changed in between, it is told to look again instead of being put to sleep. A waiter is
 * resumed once, by a change of its job, at its deadline, or when the board is shut; always through its resume function,
 * called with the board's mutex held (so it must not call the board).
 *
 * Lock order: board before whatever suspend and resume take. Threads: all functions but create and destroy from any.
 */
#ifndef QG_SERVER_WORK_BOARD_H
#define QG_SERVER_WORK_BOARD_H

#include "server/base/clock.h"
#include "server/store/store.h"

struct qg_board;

/* Starts the board and its thread, which wakes waiters at their deadlines. NULL when memory or a thread cannot be had. */
struct qg_board *qg_board_create(void);

/* Ends it. No waiter may be left (qg_board_shut) and no call may be going on. NULL is allowed. */
void qg_board_destroy(struct qg_board *board);

/* The progress of a running job: replaces the earlier one and wakes the job's waiters. */
void qg_board_publish(struct qg_board *board, const char *id, const struct qg_job_progress *progress);

/* The job changed in the store (state, outputs, gone): wakes its waiters. */
void qg_board_touch(struct qg_board *board, const char *id);

/* The job does not run any more: drops its progress and wakes its waiters. */
void qg_board_retire(struct qg_board *board, const char *id);

/* The progress of a running job. Returns the board's version after the last change of that job; 0 when no progress of it was
 * published. */
uint64_t qg_board_progress(struct qg_board *board, const char *id, struct qg_job_progress *progress);

/* A number that grows with every publish, touch and retire; and what it was after the last touch or retire, which is when
 * the store may have changed. */
uint64_t qg_board_version(struct qg_board *board);
uint64_t qg_board_touched(struct qg_board *board);

/* Copies the ids of at most `room` running jobs whose progress or outputs changed after the version `since`, in no particular
 * order. Returns how many. Threads: any. */
size_t qg_board_news(struct qg_board *board, uint64_t since, char (*ids)[QG_JOB_ID_ROOM], size_t room);

/* One who waits. The caller owns it and keeps it until it is resumed. */
struct qg_waiter {
    char id[QG_JOB_ID_ROOM]; /* of the job; "": any */
    int64_t deadline;        /* ms of qg_monotonic_clock */
    void (*suspend)(void *context);
    void (*resume)(void *context);
    void *context;
    struct qg_waiter *next; /* the board's */
};

/* Suspends the waiter until its job (or any, when it names none) changes or its deadline comes: calls its suspend function and returns true. Returns
 * false, without a call, when the board's version is not `version` any more, or it is shut. */
bool qg_board_wait(struct qg_board *board, struct qg_waiter *waiter, uint64_t version);

/* Resumes all waiters and lets none wait again. */
void qg_board_shut(struct qg_board *board);
bool qg_board_is_shut(struct qg_board *board);

#endif
