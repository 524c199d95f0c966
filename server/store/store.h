/* The store: jobs, their evaluations and their outputs in one SQLite database, and the queue that jobs wait in.
 *
 * Concurrency. Two connections: one writer behind a mutex, which also does every checkpoint (two connections that write and
 * checkpoint can corrupt a database up to SQLite 3.51.2), and one read-only reader behind another. Every write is one
 * BEGIN IMMEDIATE transaction, synced to the disk before the call returns (WAL, synchronous=FULL); reads are short and
 * leave no SELECT open. One process per directory: a lock on the file "lock" keeps a second daemon out.
 *
 * The queue. A claim turns the oldest queued job into a running one, with a lease that its holder renews (heartbeat) and an
 * attempt number, new with every claim. Whoever records, renews or finishes states its attempt; when another has taken
 * over, the answer is QG_STORE_LOST and nothing is written. So a job cannot stay `running` without anybody running it, and
 * cannot be finished by two.
 *
 * Evaluations keep every bit: doubles are stored as REAL, NaN as NULL.
 *
 * Failures are logged here with SQLite's own words; callers only need the status. All functions may be called from any
 * thread, except open and close.
 */
#ifndef QG_SERVER_STORE_STORE_H
#define QG_SERVER_STORE_STORE_H

#include "core/study.h"
#include "schema/text.h"

enum qg_store_status {
    QG_STORE_OK,
    QG_STORE_NOT_FOUND,   /* no such job, or no such output of it */
    QG_STORE_WRONG_STATE, /* the job's state does not allow it */
    QG_STORE_REPEATED,    /* submit: the same key and document as before; the earlier job is the answer */
    QG_STORE_KEY_REUSED,  /* submit: the same key with another document */
    QG_STORE_QUEUE_FULL,  /* submit: the token has as many jobs waiting or running as it may; tokens: no room left */
    QG_STORE_LOST,        /* another attempt holds the job, or it was deleted */
    QG_STORE_FULL,        /* the disk or the database is full; as the next two, this may pass */
    QG_STORE_READ_ONLY,   /* the disk or the database cannot be written */
    QG_STORE_UNAVAILABLE, /* an input or output error, or memory is short */
    QG_STORE_CORRUPT,     /* the database is damaged: it has to be restored from a backup */
    QG_STORE_FAILED       /* anything else: logged */
};

/* True for the failures that pass by themselves, or by what an operator does while the daemon runs: trying again helps. */
bool qg_store_may_recover(enum qg_store_status status);

/* Words for a failure, for people: "the disk with the database is full". NULL for what is none of the database's. */
const char *qg_store_failure_text(enum qg_store_status status);

/* name, word in the database and in JSON */
#define QG_STATE_TABLE(X)                                                                                              \
    X(QG_STATE_QUEUED, "queued")                                                                                       \
    X(QG_STATE_RUNNING, "running")                                                                                     \
    X(QG_STATE_SUCCEEDED, "succeeded")                                                                                 \
    X(QG_STATE_FAILED, "failed")                                                                                       \
    X(QG_STATE_CANCELLED, "cancelled")
#define QG_STATE_NAME(name, word) name,
enum qg_state { QG_STATE_TABLE(QG_STATE_NAME) QG_STATE_COUNT };
#undef QG_STATE_NAME

/* "queued", ... */
const char *qg_state_name(enum qg_state state);
/* The state with that name, QG_STATE_COUNT when there is none. */
enum qg_state qg_state_of_name(const char *name);
/* True for the states that nothing follows. */
bool qg_state_is_final(enum qg_state state);

enum { QG_JOB_ID_LENGTH = 26, QG_JOB_ID_ROOM = QG_JOB_ID_LENGTH + 1, QG_STORE_MESSAGE_ROOM = 1400 };

/* How far a job is, as its readers see it: objective at the JSON edge, NaN where there is none yet. */
struct qg_job_progress {
    size_t done, total;
    const char *phase; /* a name of qg_phase_name, NULL before the first */
    double eta;        /* s of wall time left, NaN while unknown */
    double best;       /* best objective so far, NaN while there is none */
};

/* What a job was thought to take when it was submitted (core/cost.h); NaN when it was not asked then. */
struct qg_estimate {
    double evaluations;
    double seconds;   /* of this server, without other jobs */
    double memory_mb; /* at its peak; NaN also when it was submitted before that was asked */
};

/* One job as it is listed. Times in milliseconds since 1970 UTC, 0 where not yet. */
struct qg_job_row {
    int64_t sequence; /* ascending with submission; never used twice */
    int64_t as_of;    /* the store's last revision when the row was read */
    char id[QG_JOB_ID_ROOM];
    char kind[16];
    char objective[24]; /* what progress.best is a value of, as qg_job_objective names it; "" where that is NULL */
    enum qg_state state;
    bool cancel_requested;
    int64_t submitted_at, started_at, finished_at;
    struct qg_job_progress progress;
    struct qg_estimate estimate;
    char *name;        /* owned */
    char *labels;      /* owned; a JSON array of strings */
    char *error;       /* owned; NULL when there is none */
    char *external_id; /* owned; NULL when there is none */
};

/* Frees what the row owns. */
void qg_job_row_finish(struct qg_job_row *row);

struct qg_store;
struct qg_actor; /* token.h; where one is taken, NULL is the daemon itself */

/* Opens the database of a directory, creating both where missing, migrates it to this program's format, and puts jobs that
 * a dead process left running back into the queue (or to cancelled, when that had been asked). NULL and a message when it
 * cannot: another daemon holds the directory, the database is of a newer format, the directory cannot be written. */
struct qg_store *qg_store_open(const char *directory, char message[QG_STORE_MESSAGE_ROOM]);

/* Closes it. No other call may be going on. NULL is allowed. */
void qg_store_close(struct qg_store *store);

/* True when the database answers. */
bool qg_store_is_alive(struct qg_store *store);

/* QG_STORE_OK when a job would be accepted now. While writing works, this begins a transaction, takes it back, and looks for
 * QG_STORE_ROOM_BYTES of free disk; from a failed write on it really writes, until that succeeds. */
enum { QG_STORE_ROOM_BYTES = 1 << 20 };
enum qg_store_status qg_store_test_writing(struct qg_store *store);

/* A document to be queued. Strings are borrowed. */
struct qg_submission {
    const char *name, *kind;
    const char *objective;       /* NULL: none */
    const char *labels;          /* a JSON array of strings */
    const char *document;        /* the text as it came; it is what will be run */
    const char *idempotency_key; /* NULL: none */
    const char *external_id;     /* NULL: none */
    struct qg_estimate estimate;
    const struct qg_actor *actor; /* who submits it: goes into the audit log, as cancelling and deleting do */
    int queue_limit; /* jobs that the actor's token may have queued or running, this one included; 0: any number */
};

/* How long a key is remembered: a week, longer than a client goes on trying. */
#define QG_KEY_LIFETIME_MS (INT64_C(7) * 24 * 3600 * 1000)

/* Queues a document. QG_STORE_QUEUE_FULL when the limit is reached. On QG_STORE_OK (new) and QG_STORE_REPEATED *row is the
 * job as it was submitted, to be finished by the caller. A key belongs to the actor's token, outlives its job, and is
 * forgotten after QG_KEY_LIFETIME_MS. */
enum qg_store_status qg_store_submit(struct qg_store *store, const struct qg_submission *submission,
                                     struct qg_job_row *row);

/* One job; the row is to be finished by the caller on QG_STORE_OK. */
enum qg_store_status qg_store_job(struct qg_store *store, const char *id, struct qg_job_row *row);

/* Appends the document that a job was submitted with, as it came. */
enum qg_store_status qg_store_document(struct qg_store *store, const char *id, struct qg_text *text);

/* Which jobs to list, newest first. */
struct qg_job_filter {
    enum qg_state state;     /* QG_STATE_COUNT: any */
    const char *label;       /* NULL: any */
    const char *external_id; /* NULL: any */
    int64_t before;          /* only jobs with a smaller sequence; 0: from the newest on */
    size_t limit;            /* at most so many */
};

/* One page of jobs. rows has room for filter->limit; each of the *count rows is to be finished by the caller. *next is what
 * `before` has to be for the page after it, 0 when nothing follows. A page that looks for a state among the jobs of a label
 * gives up after QG_LIST_LOOKS of them: it may hold fewer than limit rows, even none, and still have a next one. On any
 * status but QG_STORE_OK *count is 0. */
enum { QG_LIST_LOOKS = 5000 };
enum qg_store_status qg_store_list(struct qg_store *store, const struct qg_job_filter *filter, struct qg_job_row *rows,
                                   size_t *count, int64_t *next);

/* A change that readers follow: a job was submitted, changed its state, was asked to stop, or was deleted. Revisions number
 * them, ascending over restarts, from 1 on. Progress is not among them. */
struct qg_change {
    int64_t revision;
    char id[QG_JOB_ID_ROOM];
    bool deleted;
};

enum { QG_REVISIONS_KEPT = 10000 }; /* so far back deletions are remembered (migration 2 has the same number) */

/* The last revision; 0 when nothing was ever submitted. */
enum qg_store_status qg_store_revision(struct qg_store *store, int64_t *revision);

/* Up to `room` changes after the revision `since`, of the job `id` or of all (NULL), in their order: of a job that still
 * exists the last one only, and those deletions that are remembered. */
enum qg_store_status qg_store_changes(struct qg_store *store, int64_t since, const char *id, struct qg_change *out,
                                      size_t room, size_t *count);

/* Asks for a job to be stopped: a queued one is cancelled at once, for a running one the wish is written down and the
 * caller tells the runner. QG_STORE_OK also when it was cancelled before; QG_STORE_WRONG_STATE when it has succeeded or
 * failed. */
enum qg_store_status qg_store_cancel(struct qg_store *store, const char *id, const struct qg_actor *actor);

/* Forgets a job with its evaluations and outputs. QG_STORE_WRONG_STATE while it runs. */
enum qg_store_status qg_store_delete(struct qg_store *store, const char *id, const struct qg_actor *actor);

/* Names of outputs. */
#define QG_OUTPUT_RESULT "result"
#define QG_OUTPUT_DESIGN "design" /* the result less its curves (qg_result_design_write) */
#define QG_OUTPUT_RESPONSE "frequency-response.json"
#define QG_OUTPUT_RESPONSE_CSV "frequency-response.csv"

/* Appends an output's text. QG_STORE_NOT_FOUND when the job or the output does not exist. */
enum qg_store_status qg_store_output(struct qg_store *store, const char *id, const char *name, struct qg_text *text);

/* Copies up to `room` evaluations of a job, by its sequence, from number `first` on, in order, into out. */
enum qg_store_status qg_store_evaluations(struct qg_store *store, int64_t sequence, size_t first, size_t room,
                                          struct qg_evaluation *out, size_t *count);

/* One more than the last evaluation's number, 0 when there is none. QG_STORE_NOT_FOUND when there is no such job. */
enum qg_store_status qg_store_evaluation_end(struct qg_store *store, int64_t sequence, size_t *end);

/* What there is and was. */
struct qg_statistics {
    int64_t jobs[QG_STATE_COUNT]; /* in each state */
    bool writable;                /* the last write that had something to write succeeded */
    uint64_t evaluations;         /* recorded since the store was opened */
    int64_t database_bytes, wal_bytes;
};
enum qg_store_status qg_store_statistics(struct qg_store *store, struct qg_statistics *out);

/* --- the runner's side --- */

/* A job held by one attempt. */
struct qg_claim {
    int64_t sequence, attempt;
    char id[QG_JOB_ID_ROOM];
};

/* Claims the oldest job that is queued, or running with a lease that has run out. A log written by another version of the
 * program is dropped: its values may differ. QG_STORE_NOT_FOUND when there is nothing to do. On QG_STORE_OK the document is
 * appended to `document`. lease in milliseconds. */
enum qg_store_status qg_store_claim(struct qg_store *store, int64_t lease, struct qg_claim *claim,
                                    struct qg_text *document);

/* Renews the lease and writes the progress (may be NULL) down. */
enum qg_store_status qg_store_heartbeat(struct qg_store *store, const struct qg_claim *claim, int64_t lease,
                                        const struct qg_job_progress *progress);

/* Appends n evaluations to the log: all or none. */
enum qg_store_status qg_store_record(struct qg_store *store, const struct qg_claim *claim,
                                     const struct qg_evaluation *evaluations, size_t n);

/* Drops the evaluations from number `first` on. */
enum qg_store_status qg_store_forget_evaluations(struct qg_store *store, const struct qg_claim *claim, size_t first);

/* One output to be written. */
struct qg_output {
    const char *name, *body;
};

/* Writes n outputs, replacing earlier ones of the same names. */
enum qg_store_status qg_store_put_outputs(struct qg_store *store, const struct qg_claim *claim,
                                          const struct qg_output *outputs, size_t n);

/* How an attempt ends. */
struct qg_ending {
    enum qg_state state;                    /* a final one, or QG_STATE_QUEUED: to be continued later */
    const char *error;                      /* NULL: none */
    const struct qg_job_progress *progress; /* NULL: as it was */
    const struct qg_output *outputs;
    size_t output_count;
};

/* Ends an attempt: outputs, progress, state and time in one transaction. */
enum qg_store_status qg_store_finish(struct qg_store *store, const struct qg_claim *claim,
                                     const struct qg_ending *ending);

#endif
