/* Full fields of finished designs, computed when somebody wants to look at one.
 *
 * A field takes some seconds and some hundred MB (core/field.h), too long for the thread that serves HTTP. So it is ordered, computed by one
 * thread of its own, one after another, and kept in memory for those who ask again: the last few, nothing on disk.
 */
#ifndef QG_SERVER_WORK_FIELD_MAKER_H
#define QG_SERVER_WORK_FIELD_MAKER_H

#include "core/model.h"
#include "schema/document.h"
#include "server/store/store.h"

/* What makes two orders the same: the job, and what of its design is asked for. */
struct qg_field_key {
    char id[QG_JOB_ID_ROOM];
    size_t load_case; /* place in the analysis */
    double position;  /* mesh periods, 0 to 1 */
};

/* The finest mesh whose field the daemon makes: finer ones take so much memory and time (core/field.h) that they would be felt
 * by all that it does else. quietgear export makes them. */
enum { QG_FIELD_REFINEMENT_MAX = 2 };

enum qg_field_answer {
    QG_FIELD_DONE,    /* the text was appended */
    QG_FIELD_PENDING, /* ordered, or being computed */
    QG_FIELD_UNKNOWN, /* never ordered, or forgotten */
    QG_FIELD_BUSY,    /* too many are waiting */
    QG_FIELD_FAILED   /* it could not be computed; asked again, it is tried again */
};

struct qg_field_maker;

/* Starts the thread. What means points to must outlive it; its executor computes, its stop does not matter. NULL when that
 * fails. */
struct qg_field_maker *qg_field_maker_start(const struct qg_means *means);

/* Gives up the field that is being computed, which takes no longer than the factorization at work, drops the others and
 * frees all. NULL is allowed. */
void qg_field_maker_stop(struct qg_field_maker *maker);

/* Looks for a field; on QG_FIELD_DONE its JSON (schema/field.h) is appended to text. Threads: any. */
enum qg_field_answer qg_field_find(struct qg_field_maker *maker, const struct qg_field_key *key, struct qg_text *text);

/* Orders the field of a job's design, whose mesh_refinement is at most QG_FIELD_REFINEMENT_MAX. The job is copied. QG_FIELD_PENDING or QG_FIELD_BUSY. Threads: any. */
enum qg_field_answer qg_field_order(struct qg_field_maker *maker, const struct qg_field_key *key,
                                    const struct qg_job *job);

#endif
