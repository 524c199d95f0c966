/* The slots that run jobs. See runner.h.
 *
 * Locks: `mutex` guards the slots' attempts and the flag `stopping`. A slot claims with the mutex held, so that a wish to
 * cancel, which is written to the store first and then looks for the slot, finds the attempt either still queued in the
 * store or already in its slot. Lock order: runner, then store.
 */
#include "server/work/runner.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "server/base/log.h"

enum { LEASE_MS = 60000, HEARTBEAT_MS = 5000, HEART_SILENCE_MS = 60000, JOB_SILENCE_MS = 600000 };

struct slot {
    struct qg_runner *runner;
    pthread_t thread;
    bool busy;
    struct qg_attempt attempt; /* while busy */
};

struct qg_runner {
    struct qg_workplace workplace;
    pthread_mutex_t mutex;
    pthread_cond_t work; /* a job came, or the end */
    pthread_cond_t tick; /* the end, for the thread of heartbeats */
    bool stopping;
    pthread_t heart;
    atomic_llong beaten; /* when the thread of heartbeats has last turned, monotonic ms */
    int started;         /* slots with a thread */
    int slot_count;
    struct slot slots[];
};

/* Waits on one of the runner's conditions, at most as long as between two heartbeats. The mutex is held. */
static void wait_a_while(struct qg_runner *runner, pthread_cond_t *condition) {
    qg_condition_wait(condition, &runner->mutex, qg_monotonic_clock() + HEARTBEAT_MS);
}

/* --- slots --- */

/* Claims a job for the slot. The mutex is held. */
static bool claim(struct slot *slot, struct qg_text *document) {
    struct qg_attempt *attempt = &slot->attempt;
    attempt->workplace = &slot->runner->workplace;
    atomic_init(&attempt->cancelled, false);
    atomic_init(&attempt->lost, false);
    atomic_init(&attempt->stopping, false);
    atomic_init(&attempt->sign, qg_monotonic_clock());
    slot->busy = qg_store_claim(attempt->workplace->store, LEASE_MS, &attempt->claim, document) == QG_STORE_OK;
    return slot->busy;
}

static void log_start(const struct qg_claim *claim) {
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO,
                                        .event = QG_EVENT_JOB_STARTED,
                                        .job = claim->id,
                                        .attempt = claim->attempt,
                                        .state = qg_state_name(QG_STATE_RUNNING)},
                 "job %s: attempt %lld", claim->id, (long long)claim->attempt);
}

static void *serve(void *self) {
    struct slot *slot = self;
    struct qg_runner *runner = slot->runner;
    pthread_mutex_lock(&runner->mutex);
    while (!runner->stopping) {
        struct qg_text document = {0};
        if (claim(slot, &document)) {
            pthread_mutex_unlock(&runner->mutex);
            log_start(&slot->attempt.claim);
            qg_board_touch(runner->workplace.board, slot->attempt.claim.id);
            qg_attempt_run(&slot->attempt, &document);
            pthread_mutex_lock(&runner->mutex);
            slot->busy = false;
        } else {
            wait_a_while(runner,
                         &runner->work); /* the store may have failed, or a lease run out: looking again is cheap */
        }
        qg_text_finish(&document);
    }
    pthread_mutex_unlock(&runner->mutex);
    return NULL;
}

/* --- heartbeats --- */

/* Renews one claim; when it is not ours any more, the attempt is told. */
static void beat(struct qg_runner *runner, struct slot *slot, const struct qg_claim *held) {
    struct qg_job_progress progress;
    bool known = qg_board_progress(runner->workplace.board, held->id, &progress);
    enum qg_store_status status = qg_store_heartbeat(runner->workplace.store, held, LEASE_MS, known ? &progress : NULL);
    if (status != QG_STORE_LOST)
        return;
    pthread_mutex_lock(&runner->mutex);
    if (slot->busy && slot->attempt.claim.attempt == held->attempt && slot->attempt.claim.sequence == held->sequence)
        atomic_store(&slot->attempt.lost, true);
    pthread_mutex_unlock(&runner->mutex);
}

static void *keep_claims(void *self) {
    struct qg_runner *runner = self;
    pthread_mutex_lock(&runner->mutex);
    while (!runner->stopping) {
        wait_a_while(runner, &runner->tick);
        qg_log_tick();
        atomic_store(&runner->beaten, qg_monotonic_clock());
        for (int i = 0; i < runner->slot_count; i++) {
            struct slot *slot = &runner->slots[i];
            if (!slot->busy)
                continue;
            struct qg_claim held = slot->attempt.claim;
            pthread_mutex_unlock(&runner->mutex);
            beat(runner, slot, &held);
            pthread_mutex_lock(&runner->mutex);
        }
    }
    pthread_mutex_unlock(&runner->mutex);
    return NULL;
}

/* --- the whole --- */

static void free_runner(struct qg_runner *runner) {
    pthread_mutex_destroy(&runner->mutex);
    pthread_cond_destroy(&runner->work);
    pthread_cond_destroy(&runner->tick);
    free(runner);
}

/* A runner without threads. */
static struct qg_runner *make_runner(const struct qg_workplace *workplace, int slots) {
    struct qg_runner *runner = calloc(1, sizeof *runner + (size_t)slots * sizeof runner->slots[0]);
    if (!runner)
        return NULL;
    runner->workplace = *workplace;
    runner->slot_count = slots;
    atomic_init(&runner->beaten, qg_monotonic_clock());
    pthread_mutex_init(&runner->mutex, NULL);
    qg_condition_init(&runner->work);
    qg_condition_init(&runner->tick);
    return runner;
}

struct qg_runner *qg_runner_start(const struct qg_workplace *workplace, int slots) {
    struct qg_runner *runner = make_runner(workplace, slots);
    if (!runner)
        return NULL;
    if (pthread_create(&runner->heart, NULL, keep_claims, runner) != 0) {
        free_runner(runner);
        return NULL;
    }
    for (; runner->started < slots; runner->started++) {
        struct slot *slot = &runner->slots[runner->started];
        slot->runner = runner;
        if (pthread_create(&slot->thread, NULL, serve, slot) != 0) {
            qg_runner_stop(runner);
            return NULL;
        }
    }
    return runner;
}

void qg_runner_wake(struct qg_runner *runner) {
    pthread_mutex_lock(&runner->mutex);
    pthread_cond_broadcast(&runner->work);
    pthread_mutex_unlock(&runner->mutex);
}

void qg_runner_cancel(struct qg_runner *runner, const char *id) {
    pthread_mutex_lock(&runner->mutex);
    for (int i = 0; i < runner->slot_count; i++)
        if (runner->slots[i].busy && strcmp(runner->slots[i].attempt.claim.id, id) == 0)
            atomic_store(&runner->slots[i].attempt.cancelled, true);
    pthread_mutex_unlock(&runner->mutex);
}

const char *qg_runner_stuck(struct qg_runner *runner) {
    int64_t now = qg_monotonic_clock();
    if (now - atomic_load(&runner->beaten) > HEART_SILENCE_MS) /* before the mutex: who holds it may hang */
        return "the heartbeats of running jobs have stopped";
    const char *stuck = NULL;
    pthread_mutex_lock(&runner->mutex);
    for (int i = 0; i < runner->slot_count; i++) {
        struct slot *slot = &runner->slots[i];
        if (slot->busy && now - atomic_load(&slot->attempt.sign) > JOB_SILENCE_MS)
            stuck = "a running job has given no sign for ten minutes";
    }
    pthread_mutex_unlock(&runner->mutex);
    return stuck;
}

void qg_runner_interrupt(struct qg_runner *runner) {
    pthread_mutex_lock(&runner->mutex);
    runner->stopping = true;
    for (int i = 0; i < runner->slot_count; i++)
        if (runner->slots[i].busy)
            atomic_store(&runner->slots[i].attempt.stopping, true);
    pthread_cond_broadcast(&runner->work);
    pthread_cond_signal(&runner->tick);
    pthread_mutex_unlock(&runner->mutex);
}

void qg_runner_stop(struct qg_runner *runner) {
    if (!runner)
        return;
    qg_runner_interrupt(runner);
    for (int i = 0; i < runner->started; i++)
        pthread_join(runner->slots[i].thread, NULL);
    pthread_join(runner->heart, NULL);
    free_runner(runner);
}
