/* Dropping what has been kept long enough. See retention.h. */
#include "server/work/retention.h"

#include <pthread.h>
#include <stdlib.h>

#include "server/base/clock.h"
#include "server/base/log.h"

enum { INTERVAL_MS = 600000 };

struct qg_keeper {
    struct qg_store *store;
    struct qg_board *board;
    struct qg_retention retention;
    struct qg_chore chore;
    pthread_t thread;
    pthread_mutex_t mutex; /* guards stopping */
    pthread_cond_t end;
    bool stopping;
};

static bool is_stopping(struct qg_keeper *keeper) {
    pthread_mutex_lock(&keeper->mutex);
    bool stopping = keeper->stopping;
    pthread_mutex_unlock(&keeper->mutex);
    return stopping;
}

/* Drops all evaluations of a job. True when they are gone. */
static bool drop_log(struct qg_keeper *keeper, const char *id) {
    enum qg_store_status status = QG_STORE_OK;
    while (status == QG_STORE_OK && !is_stopping(keeper))
        status = qg_store_drop_evaluations(keeper->store, id);
    return status == QG_STORE_NOT_FOUND;
}

static void clean_up(struct qg_keeper *keeper) {
    char id[QG_JOB_ID_ROOM];
    size_t jobs = 0, logs = 0;
    int64_t now = qg_wall_clock();
    while (!is_stopping(keeper) && qg_store_expired(keeper->store, &keeper->retention, now, id) == QG_STORE_OK &&
           drop_log(keeper, id) && qg_store_delete(keeper->store, id, NULL) == QG_STORE_OK) {
        qg_board_touch(keeper->board, id);
        jobs++;
    }
    while (!is_stopping(keeper) && qg_store_expired_log(keeper->store, &keeper->retention, now, id) == QG_STORE_OK &&
           drop_log(keeper, id))
        logs++;
    if (jobs > 0 || logs > 0)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE, .event = QG_EVENT_DATA_DROPPED},
                     "retention: %zu finished jobs and the evaluations of %zu more were dropped", jobs, logs);
}

static void *work(void *self) {
    struct qg_keeper *keeper = self;
    while (!is_stopping(keeper)) {
        clean_up(keeper);
        if (keeper->chore.run)
            keeper->chore.run(keeper->chore.self);
        pthread_mutex_lock(&keeper->mutex);
        if (!keeper->stopping)
            qg_condition_wait(&keeper->end, &keeper->mutex, qg_monotonic_clock() + INTERVAL_MS);
        pthread_mutex_unlock(&keeper->mutex);
    }
    return NULL;
}

struct qg_keeper *qg_keeper_start(struct qg_store *store, struct qg_board *board, const struct qg_retention *retention,
                                  struct qg_chore chore) {
    struct qg_keeper *keeper = calloc(1, sizeof *keeper);
    if (!keeper)
        return NULL;
    keeper->store = store;
    keeper->board = board;
    keeper->retention = *retention;
    keeper->chore = chore;
    pthread_mutex_init(&keeper->mutex, NULL);
    qg_condition_init(&keeper->end);
    if (pthread_create(&keeper->thread, NULL, work, keeper) == 0)
        return keeper;
    pthread_cond_destroy(&keeper->end);
    pthread_mutex_destroy(&keeper->mutex);
    free(keeper);
    return NULL;
}

void qg_keeper_stop(struct qg_keeper *keeper) {
    if (!keeper)
        return;
    pthread_mutex_lock(&keeper->mutex);
    keeper->stopping = true;
    pthread_cond_signal(&keeper->end);
    pthread_mutex_unlock(&keeper->mutex);
    pthread_join(keeper->thread, NULL);
    pthread_cond_destroy(&keeper->end);
    pthread_mutex_destroy(&keeper->mutex);
    free(keeper);
}
