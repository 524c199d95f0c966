/* Jobs as JSON text, rendered once for all who read them.
 *
 * A thousand event streams or long polls of one running job wake at each of its changes, and all want the same bytes. The
 * first to ask reads the row and renders it; the others get a copy.
 *
 * A copy stands for a moment: the board's touch before the row was read, the version of the job's notice, and the store's
 * last revision in the same snapshot as the row. It is handed out while touch and version are still the board's, so that it
 * is never older than the last change that was announced: who has been answered that a job was cancelled sees it cancelled.
 * Changes are announced after they are committed, so a reader may know of a revision that the board does not know yet: it
 * says so, and gets no copy that is older than that.
 *
 * Few copies are kept; the one that was not asked for the longest goes first. A copy of a job that was deleted meanwhile is
 * not found any more, because deleting touches the board.
 *
 * Lock order: job copies before store and board. Threads: any, but create and destroy.
 */
#ifndef QG_SERVER_WORK_JOB_COPIES_H
#define QG_SERVER_WORK_JOB_COPIES_H

#include "server/work/board.h"

struct qg_job_copies;

/* Store and board are borrowed. NULL when memory is short. */
struct qg_job_copies *qg_job_copies_create(struct qg_store *store, struct qg_board *board);

/* No call may be going on. NULL is allowed. */
void qg_job_copies_destroy(struct qg_job_copies *copies);

/* Appends a job as one JSON object (job_text.h), in a state that is no older than the store's revision `since` (0: any) and
 * than what was announced. *state, which may be NULL, becomes the state that the text tells. On any status but QG_STORE_OK
 * nothing is appended; memory that is short shows as text->failed. */
enum qg_store_status qg_job_copy(struct qg_job_copies *copies, const char *id, int64_t since, struct qg_text *text,
                                 enum qg_state *state);

/* How many jobs were rendered so far. */
uint64_t qg_job_copies_made(struct qg_job_copies *copies);

#endif
