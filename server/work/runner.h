/* The runner: a few slots, each a thread that claims jobs from the store and runs them, one after another, on the shared
 * executor; and a thread that renews the claims of all slots and writes their progress down.
 */
#ifndef QG_SERVER_WORK_RUNNER_H
#define QG_SERVER_WORK_RUNNER_H

#include "server/work/attempt.h"

struct qg_runner;

/* Starts `slots` >= 1 slots. NULL when memory or threads cannot be had. The workplace is copied; what it points to must
 * outlive the runner. */
struct qg_runner *qg_runner_start(const struct qg_workplace *workplace, int slots);

/* A job was queued. Threads: any. */
void qg_runner_wake(struct qg_runner *runner);

/* A user wants this job stopped, which the store already knows. Nothing happens when it does not run. Threads: any. */
void qg_runner_cancel(struct qg_runner *runner, const char *id);

/* What hangs: words when the thread of heartbeats has not turned for a minute, or a running job has given no sign from within
 * its computation for ten; NULL when nothing does. Threads: any. */
const char *qg_runner_stuck(struct qg_runner *runner);

/* Asks all running studies to stop at their next piece and no job to be claimed any more. Returns at once. */
void qg_runner_interrupt(struct qg_runner *runner);

/* Interrupts, waits until all jobs are back in the queue, and frees the runner. NULL is allowed. */
void qg_runner_stop(struct qg_runner *runner);

#endif
