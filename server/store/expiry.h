/* Which finished jobs are kept no longer, and dropping what they left.
 */
#ifndef QG_SERVER_STORE_EXPIRY_H
#define QG_SERVER_STORE_EXPIRY_H

#include "server/store/store.h"

/* What is kept of finished jobs; 0: without limit. */
struct qg_retention {
    int job_days;        /* since their end */
    int evaluation_days; /* the log of evaluations; the result stays */
    int jobs;            /* how many */
    int megabytes;       /* of the database, free pages not counted: the oldest go until it fits */
};

/* The id of the next finished job to be dropped, by its limits and the time (ms since 1970 UTC). QG_STORE_NOT_FOUND when
 * there is none. */
enum qg_store_status qg_store_expired(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                      char id[QG_JOB_ID_ROOM]);

/* The id of the next finished job whose log of evaluations is to go. QG_STORE_NOT_FOUND when there is none. */
enum qg_store_status qg_store_expired_log(struct qg_store *store, const struct qg_retention *retention, int64_t now,
                                          char id[QG_JOB_ID_ROOM]);

/* Drops up to so many evaluations of a job. QG_STORE_NOT_FOUND when it has none left, QG_STORE_WRONG_STATE when it is not
 * finished. */
enum { QG_EVALUATIONS_AT_ONCE = 2000 };
enum qg_store_status qg_store_drop_evaluations(struct qg_store *store, const char *id);

#endif
