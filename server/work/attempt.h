/* One attempt at one job: from the claimed document to an ending in the store.
 *
 * The log is the checkpoint: evaluations already logged are handed back to the study as it asks for them, new ones are
 * logged batch by batch. The amplitude-frequency data of the reference and of the best design so far are written down as
 * they come, so they are there while the job runs and after a restart.
 *
 * How it ends: QG_OK is `succeeded` with a result; a user's wish `cancelled`; a stopping daemon puts the job back into the
 * queue; an attempt that lost its claim writes nothing; anything else is `failed` with the reason. When even the ending
 * cannot be written the job stays claimed and is taken up again when its lease has run out.
 *
 * While the disk is full, read-only or failing, the attempt pauses at the first thing that it cannot write, tries again every
 * second, and goes on as if nothing had been when that succeeds. A damaged database fails the job.
 */
#ifndef QG_SERVER_WORK_ATTEMPT_H
#define QG_SERVER_WORK_ATTEMPT_H

#include <stdatomic.h>

#include "server/store/store.h"
#include "server/work/board.h"

struct qg_metrics;

/* What every attempt works with. */
struct qg_workplace {
    struct qg_store *store;
    struct qg_board *board;
    struct qg_means means;      /* shared by all running jobs */
    struct qg_metrics *metrics; /* NULL: nothing is counted */
};

/* An attempt as the runner holds it; the flags may be set from any thread while it runs. */
struct qg_attempt {
    const struct qg_workplace *workplace;
    struct qg_claim claim;
    atomic_bool cancelled; /* a user wants the job stopped */
    atomic_bool lost;      /* the claim is not ours any more */
    atomic_bool stopping;  /* the daemon is about to end */
    atomic_llong sign;     /* when the study has last given a sign of life, monotonic ms; the attempt sets it */
};

/* Runs the claimed job to an ending. document is the stored text. Threads: any, one per attempt. */
void qg_attempt_run(struct qg_attempt *attempt, const struct qg_text *document);

#endif
