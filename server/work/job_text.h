/* A job as its readers see it: JSON text, and the entity tag of that text.
 */
#ifndef QG_SERVER_WORK_JOB_TEXT_H
#define QG_SERVER_WORK_JOB_TEXT_H

#include "server/work/board.h"

/* Writes a job as one JSON object. A running job's progress comes from the board, where it has any; row->progress is
 * replaced by it. */
void qg_job_write(struct qg_text *text, struct qg_board *board, struct qg_job_row *row);

/* Writes the member "estimate": evaluations, seconds and megabytes, or null. */
void qg_estimate_write(struct qg_text *text, const struct qg_estimate *estimate);

#endif
