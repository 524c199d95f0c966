/* A job as its readers see it: JSON text, and the entity tag of that text.
 */
#ifndef QG_SERVER_JOB_TEXT_H
#define QG_SERVER_JOB_TEXT_H

#include "server/board.h"

/* Writes a job as one JSON object. A running job's progress comes from the board, where it has any; row->progress is
 * replaced by it. */
void qg_job_write(struct qg_text *text, struct qg_board *board, struct qg_job_row *row);

/* The entity tag of a text, with its quotes: a hash of its bytes, so equal texts have equal tags, also after a restart. */
enum { QG_ETAG_ROOM = 24 };
void qg_etag(char etag[QG_ETAG_ROOM], const struct qg_text *text);

/* Writes the member "estimate": evaluations and seconds, or null. */
void qg_estimate_write(struct qg_text *text, const struct qg_estimate *estimate);

#endif
