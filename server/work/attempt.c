/* One attempt at one job. See attempt.h. */
#include "server/work/attempt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/design_copy.h"
#include "schema/result.h"
#include "server/base/log.h"
#include "server/work/metrics.h"

enum { LOG_PAGE = 1000, PUBLISH_INTERVAL_MS = 200, PAUSE_MOMENTS = 10 };

/* An attempt while its study runs. */
struct run {
    struct qg_attempt *attempt;
    struct qg_store *store;
    struct qg_board *board;
    struct qg_job job;
    struct qg_pair_geometry geometry;
    struct qg_design_result *reference; /* a copy; NULL before it was computed */
    struct {
        struct qg_evaluation *item; /* the log as it stood at the start: numbers 0, 1, 2, ... */
        size_t count;
        bool ended; /* the study has gone past it */
    } log;
    struct qg_job_progress progress;
    int64_t started_at;   /* of the job's first attempt, ms since 1970 UTC */
    int64_t published_at; /* monotonic ms */
    struct {
        const char *phase; /* what the rate is measured in */
        int64_t since;     /* monotonic ms */
        size_t done;       /* at that time */
    } pace;
    bool waits;                   /* it has met a store that failed, and says so once */
    enum qg_store_status failure; /* why the log could not be written */
};

/* What an entry of the log on this attempt is about. The macro's value lives as long as the block around it. */
#define ABOUT(run_, priority_)                                                                                         \
    (&(struct qg_log_event){                                                                                           \
        .priority = (priority_), .job = (run_)->attempt->claim.id, .attempt = (run_)->attempt->claim.attempt})

/* --- a store that fails for a while --- */

static bool is_cancelled(void *self) {
    struct run *run = self;
    atomic_store_explicit(&run->attempt->sign, qg_monotonic_clock(), memory_order_relaxed);
    return atomic_load_explicit(&run->attempt->cancelled, memory_order_relaxed) ||
           atomic_load_explicit(&run->attempt->stopping, memory_order_relaxed) ||
           atomic_load_explicit(&run->attempt->lost, memory_order_relaxed);
}

/* True when the failed call is to be made again, after a pause: the disk may have room by then. What has been computed is
 * kept, and nothing has to be begun anew. False when the failure does not pass, or the attempt is to end. */
static bool try_again(struct run *run, enum qg_store_status status) {
    const struct timespec moment = {.tv_nsec = 100000000};
    if (!qg_store_may_recover(status))
        return false;
    if (!run->waits)
        qg_log_event(ABOUT(run, QG_LOG_WARNING), "job %s: waits until the database can be written",
                     run->attempt->claim.id);
    run->waits = true;
    for (int i = 0; i < PAUSE_MOMENTS && !is_cancelled(run); i++)
        nanosleep(&moment, NULL);
    return !is_cancelled(run);
}

/* --- the log --- */

/* Reads the log, up to the first gap if there should be one. */
static enum qg_store_status load_log(struct run *run) {
    for (;;) {
        size_t got = 0;
        void *grown = realloc(run->log.item, (run->log.count + LOG_PAGE) * sizeof *run->log.item);
        if (!grown)
            return QG_STORE_UNAVAILABLE;
        run->log.item = grown;
        enum qg_store_status status = qg_store_evaluations(run->store, run->attempt->claim.sequence, run->log.count,
                                                           LOG_PAGE, run->log.item + run->log.count, &got);
        if (status != QG_STORE_OK)
            return status;
        for (size_t i = 0; i < got; i++) {
            if (run->log.item[run->log.count].number != run->log.count)
                return QG_STORE_OK;
            run->log.count++;
        }
        if (got < LOG_PAGE)
            return QG_STORE_OK;
    }
}

static bool is_same_design(const struct qg_evaluation *a, const struct qg_evaluation *b) {
    return a->phase == b->phase && memcmp(a->parameter, b->parameter, sizeof a->parameter) == 0;
}

static bool recall(void *self, struct qg_evaluation *evaluation) {
    struct run *run = self;
    if (run->log.ended)
        return false;
    if (evaluation->number < run->log.count && is_same_design(evaluation, &run->log.item[evaluation->number])) {
        evaluation->f_pps = run->log.item[evaluation->number].f_pps;
        evaluation->f_dte = run->log.item[evaluation->number].f_dte;
        evaluation->f_dte_percentile = run->log.item[evaluation->number].f_dte_percentile;
        return true;
    }
    run->log.ended = true;
    run->pace.phase = NULL; /* what was recalled says nothing about the time that computing takes */
    if (evaluation->number < run->log.count)
        qg_log_event(ABOUT(run, QG_LOG_WARNING),
                     "job %s: its log departs from the search at evaluation %zu; it is computed anew from there",
                     run->attempt->claim.id, evaluation->number);
    enum qg_store_status status;
    do
        status = qg_store_forget_evaluations(run->store, &run->attempt->claim, evaluation->number);
    while (try_again(run, status));
    return false;
}

/* A failure of the store ends the study; its reason is kept. */
static enum qg_status stop_on_failure(struct run *run, enum qg_store_status status) {
    if (status == QG_STORE_OK)
        return QG_OK;
    if (status == QG_STORE_LOST)
        atomic_store(&run->attempt->lost, true);
    else
        run->failure = status;
    return QG_CANCELLED;
}

static enum qg_status record(void *self, const struct qg_evaluation *evaluations, size_t n) {
    struct run *run = self;
    enum qg_store_status status;
    do
        status = qg_store_record(run->store, &run->attempt->claim, evaluations, n);
    while (try_again(run, status));
    return stop_on_failure(run, status);
}

/* --- amplitude-frequency data --- */

/* Writes both forms of the amplitude-frequency data down. */
static void write_response(struct run *run, const struct qg_design_result *design,
                           const struct qg_design_result *reference) {
    struct qg_text json = {0}, csv = {0};
    qg_frequency_response_write(&json, &run->job, &run->geometry, design, reference);
    qg_frequency_response_write_csv(&csv, &run->job, design, reference);
    if (!json.failed && !csv.failed) {
        const struct qg_output outputs[] = {{QG_OUTPUT_RESPONSE, json.data}, {QG_OUTPUT_RESPONSE_CSV, csv.data}};
        enum qg_store_status status;
        do
            status = qg_store_put_outputs(run->store, &run->attempt->claim, outputs, 2);
        while (try_again(run, status));
        stop_on_failure(run, status);
        qg_board_touch(run->board, run->attempt->claim.id);
    }
    qg_text_finish(&json);
    qg_text_finish(&csv);
}

static void reference_known(void *self, const struct qg_design_result *result) {
    struct run *run = self;
    qg_design_result_destroy(run->reference);
    run->reference = qg_design_result_copy(&run->job.study.analysis, result);
    write_response(run, NULL, result);
}

static void improved(void *self, const struct qg_design_result *result) {
    struct run *run = self;
    write_response(run, result, run->reference);
}

/* --- progress --- */

/* Seconds left, from the pace in the present phase: a step of a later one may take longer or shorter. Unknown while the
 * model is made ready, whose two steps say nothing about the others. */
static double time_left(struct run *run, const struct qg_progress *progress, int64_t now) {
    const char *phase = qg_phase_name(progress->phase);
    if (run->pace.phase != phase) {
        run->pace.phase = phase;
        run->pace.since = now;
        run->pace.done = progress->done;
    }
    if (progress->phase <= QG_PHASE_REFERENCE || progress->done <= run->pace.done || now <= run->pace.since)
        return (double)NAN;
    double per_step = (double)(now - run->pace.since) / (double)(progress->done - run->pace.done);
    return round(per_step * (double)(progress->total - progress->done)) / 1000;
}

static bool is_news(const struct qg_job_progress *before, const struct qg_job_progress *after) {
    bool better = !isnan(after->best) && !(after->best == before->best);
    return before->phase != after->phase || better;
}

static void progressed(void *self, const struct qg_progress *progress) {
    struct run *run = self;
    int64_t now = qg_monotonic_clock();
    struct qg_job_progress next = {
        .done = progress->done,
        .total = progress->total,
        .phase = qg_phase_name(progress->phase),
        .eta = time_left(run, progress, now),
        .best = progress->has_best ? qg_objective_at_the_edge(run->job.study.objective, progress->best)
                                   : run->progress.best, /* an earlier attempt's, until this one has come as far */
    };
    bool publish = is_news(&run->progress, &next) || now - run->published_at >= PUBLISH_INTERVAL_MS;
    run->progress = next;
    if (!publish)
        return;
    run->published_at = now;
    qg_board_publish(run->board, run->attempt->claim.id, &run->progress);
}

static double seconds(void *self) {
    (void)self;
    return (double)qg_monotonic_clock() / 1000;
}

/* --- the ending --- */

/* Logs an ending that was written down. */
static void log_ending(const struct run *run, const struct qg_ending *ending) {
    bool failed = ending->state == QG_STATE_FAILED;
    const int64_t duration = qg_wall_clock() - run->started_at;
    struct qg_log_event event = *ABOUT(run, failed ? QG_LOG_WARNING : QG_LOG_INFO);
    event.event = failed                             ? QG_EVENT_JOB_FAILED
                  : qg_state_is_final(ending->state) ? QG_EVENT_JOB_ENDED
                                                     : QG_EVENT_JOB_INTERRUPTED;
    event.state = qg_state_name(ending->state);
    event.duration_ms = &duration;
    qg_log_event(&event, "job %s: %s%s%s", event.job, event.state, ending->error ? ": " : "",
                 ending->error ? ending->error : "");
}

/* Writes the ending down and tells everybody. */
static void end(struct run *run, const struct qg_ending *ending) {
    const char *id = run->attempt->claim.id;
    enum qg_store_status status;
    do
        status = qg_store_finish(run->store, &run->attempt->claim, ending);
    while (try_again(run, status));
    if (status == QG_STORE_LOST)
        qg_log_event(ABOUT(run, QG_LOG_WARNING), "job %s: attempt %lld was superseded", id,
                     (long long)run->attempt->claim.attempt);
    else if (status != QG_STORE_OK)
        qg_log_event(ABOUT(run, QG_LOG_ERROR),
                     "job %s: its ending cannot be written; it is taken up again when its lease is over", id);
    else
        log_ending(run, ending);
    if (status == QG_STORE_OK && qg_state_is_final(ending->state) && run->attempt->workplace->metrics)
        qg_metrics_count_job(run->attempt->workplace->metrics, ending->state, qg_wall_clock() - run->started_at);
    qg_board_retire(run->board, id);
}

static void end_without_result(struct run *run, enum qg_state state, const char *error) {
    end(run,
        &(struct qg_ending){.state = state, .error = error, .progress = run->progress.phase ? &run->progress : NULL});
}

static void end_with_result(struct run *run, const struct qg_study_result *result) {
    write_response(run, result->design, result->reference);
    struct qg_text text = {0}, design = {0};
    qg_result_write(&text, &run->job, result, run->attempt->workplace->means.executor.workers);
    qg_result_design_write(&design, &run->job, result);
    const struct qg_output outputs[] = {{QG_OUTPUT_RESULT, text.data}, {QG_OUTPUT_DESIGN, design.data}};
    if (text.failed || design.failed)
        end_without_result(run, QG_STATE_FAILED, qg_status_text(QG_OUT_OF_MEMORY));
    else
        end(run, &(struct qg_ending){
                     .state = QG_STATE_SUCCEEDED, .progress = &run->progress, .outputs = outputs, .output_count = 2});
    qg_text_finish(&text);
    qg_text_finish(&design);
}

static void end_study(struct run *run, enum qg_status status, const struct qg_study_result *result) {
    if (status == QG_OK)
        end_with_result(run, result);
    else if (run->failure != QG_STORE_OK)
        end_without_result(run, qg_store_may_recover(run->failure) ? QG_STATE_QUEUED : QG_STATE_FAILED,
                           qg_store_failure_text(run->failure));
    else if (status != QG_CANCELLED)
        end_without_result(run, QG_STATE_FAILED, qg_status_text(status));
    else if (atomic_load(&run->attempt->cancelled))
        end_without_result(run, QG_STATE_CANCELLED, NULL);
    else
        end_without_result(run, QG_STATE_QUEUED, NULL);
}

/* --- the whole --- */

static void run_study(struct run *run) {
    const struct qg_observer observer = {
        .self = run,
        .recall = recall,
        .record = record,
        .progress = progressed,
        .reference = reference_known,
        .improved = improved,
        .cancelled = is_cancelled,
        .clock = {.now = seconds},
    };
    struct qg_study_result result;
    enum qg_status status = qg_study_run(&run->job.study, &run->attempt->workplace->means, &observer, &result);
    end_study(run, status, &result);
    qg_study_result_finish(&result);
}

/* Goes on from a log that was read, or could not be. */
static void end_or_run(struct run *run, enum qg_store_status status) {
    if (status == QG_STORE_OK)
        run_study(run);
    else
        end_without_result(run, is_cancelled(run) ? QG_STATE_QUEUED : QG_STATE_FAILED, qg_store_failure_text(status));
}

/* Reads the stored document again. It was checked when it came, but perhaps by another version of this program. */
static bool read_document(struct run *run, const struct qg_text *document) {
    struct qg_faults *faults = calloc(1, sizeof *faults);
    char error[sizeof faults->item[0] + 64] = "out of memory";
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    if (faults)
        status = qg_document_read(document->data, document->length, &run->job, faults, NULL);
    if (status != QG_DOCUMENT_OK && faults && faults->count > 0)
        snprintf(error, sizeof error, "the document is not valid any more: %s: %s", faults->item[0].pointer,
                 faults->item[0].detail);
    free(faults);
    if (status == QG_DOCUMENT_OK && qg_pair_derive(&run->job.study.pair, &run->geometry, NULL) == QG_OK)
        return true;
    end_without_result(run, QG_STATE_FAILED, error);
    return false;
}

/* Begins with the best of earlier attempts, so that it does not vanish for a reader while this one catches up. */
static void begin_progress(struct run *run) {
    struct qg_job_row row;
    run->progress.eta = run->progress.best = (double)NAN;
    run->started_at = qg_wall_clock();
    if (qg_store_job(run->store, run->attempt->claim.id, &row) != QG_STORE_OK)
        return;
    run->progress.best = row.progress.best;
    run->started_at = row.started_at;
    qg_job_row_finish(&row);
}

void qg_attempt_run(struct qg_attempt *attempt, const struct qg_text *document) {
    /* on the stack: a claimed job that could not even begin would wait for its lease to run out */
    struct run run = {.attempt = attempt, .store = attempt->workplace->store, .board = attempt->workplace->board};
    begin_progress(&run);
    if (read_document(&run, document)) {
        enum qg_store_status status;
        do
            status = load_log(&run);
        while (try_again(&run, status));
        end_or_run(&run, status);
    }
    qg_design_result_destroy(run.reference);
    free(run.log.item);
}
