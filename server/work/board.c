/* The board of running jobs and waiting readers. See board.h. */
#include "server/work/board.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* One running job. */
struct notice {
    char id[QG_JOB_ID_ROOM];
    struct qg_job_progress progress;
    uint64_t version; /* of the board after its last change */
    struct notice *next;
};

struct qg_board {
    pthread_mutex_t mutex;  /* guards all that follows */
    pthread_cond_t changed; /* a waiter came, or the board ends */
    uint64_t version;
    uint64_t touched; /* the version after the last touch or retire */
    struct notice *notices;
    struct qg_waiter *waiters;
    int64_t wake_at; /* when the timekeeper looks next, monotonic ms */
    bool shut, ending;
    pthread_t timekeeper;
};

/* Unlinks and resumes the waiters that `due` picks. The mutex is held. */
static void resume_if(struct qg_board *board, bool (*due)(const struct qg_waiter *waiter, const void *key),
                      const void *key) {
    struct qg_waiter **link = &board->waiters;
    while (*link) {
        struct qg_waiter *waiter = *link;
        if (due(waiter, key)) {
            *link = waiter->next;
            waiter->resume(waiter->context); /* from here on the waiter is not ours */
        } else {
            link = &waiter->next;
        }
    }
}

static bool waits_for(const struct qg_waiter *waiter, const void *id) {
    return !*waiter->id || strcmp(waiter->id, id) == 0;
}

static bool is_overdue(const struct qg_waiter *waiter, const void *now) {
    return waiter->deadline <= *(const int64_t *)now;
}

static bool any(const struct qg_waiter *waiter, const void *nothing) {
    (void)waiter;
    (void)nothing;
    return true;
}

/* --- deadlines --- */

/* The earliest deadline; far away when nobody waits. */
static int64_t next_deadline(const struct qg_board *board) {
    int64_t earliest = INT64_MAX;
    for (const struct qg_waiter *waiter = board->waiters; waiter; waiter = waiter->next)
        if (waiter->deadline < earliest)
            earliest = waiter->deadline;
    return earliest;
}

static void *keep_time(void *self) {
    struct qg_board *board = self;
    pthread_mutex_lock(&board->mutex);
    while (!board->ending) {
        int64_t now = qg_monotonic_clock();
        resume_if(board, is_overdue, &now);
        board->wake_at = next_deadline(board);
        qg_condition_wait(&board->changed, &board->mutex, board->wake_at);
    }
    pthread_mutex_unlock(&board->mutex);
    return NULL;
}

struct qg_board *qg_board_create(void) {
    struct qg_board *board = calloc(1, sizeof *board);
    if (!board)
        return NULL;
    board->wake_at = INT64_MAX;
    qg_condition_init(&board->changed);
    pthread_mutex_init(&board->mutex, NULL);
    if (pthread_create(&board->timekeeper, NULL, keep_time, board) == 0)
        return board;
    pthread_mutex_destroy(&board->mutex);
    pthread_cond_destroy(&board->changed);
    free(board);
    return NULL;
}

void qg_board_destroy(struct qg_board *board) {
    if (!board)
        return;
    pthread_mutex_lock(&board->mutex);
    assert(!board->waiters);
    board->ending = true;
    pthread_cond_signal(&board->changed);
    pthread_mutex_unlock(&board->mutex);
    pthread_join(board->timekeeper, NULL);
    while (board->notices) {
        struct notice *next = board->notices->next;
        free(board->notices);
        board->notices = next;
    }
    pthread_mutex_destroy(&board->mutex);
    pthread_cond_destroy(&board->changed);
    free(board);
}

/* --- publishing --- */

static struct notice **find(struct qg_board *board, const char *id) {
    struct notice **link = &board->notices;
    while (*link && strcmp((*link)->id, id) != 0)
        link = &(*link)->next;
    return link;
}

/* A change of a job. The mutex is held. */
static void announce(struct qg_board *board, const char *id) {
    board->version++;
    struct notice *notice = *find(board, id);
    if (notice)
        notice->version = board->version;
    resume_if(board, waits_for, id);
}

/* A change of a job in the store. The mutex is held. */
static void announce_stored(struct qg_board *board, const char *id) {
    board->touched = board->version + 1;
    announce(board, id);
}

void qg_board_publish(struct qg_board *board, const char *id, const struct qg_job_progress *progress) {
    pthread_mutex_lock(&board->mutex);
    struct notice **link = find(board, id);
    if (!*link && (*link = calloc(1, sizeof **link)))
        strcpy((*link)->id, id);
    if (*link) /* without memory for a notice, readers see the progress in the store */
        (*link)->progress = *progress;
    announce(board, id);
    pthread_mutex_unlock(&board->mutex);
}

void qg_board_touch(struct qg_board *board, const char *id) {
    pthread_mutex_lock(&board->mutex);
    announce_stored(board, id);
    pthread_mutex_unlock(&board->mutex);
}

void qg_board_retire(struct qg_board *board, const char *id) {
    pthread_mutex_lock(&board->mutex);
    struct notice **link = find(board, id), *notice = *link;
    if (notice)
        *link = notice->next;
    free(notice);
    announce_stored(board, id);
    pthread_mutex_unlock(&board->mutex);
}

uint64_t qg_board_progress(struct qg_board *board, const char *id, struct qg_job_progress *progress) {
    pthread_mutex_lock(&board->mutex);
    const struct notice *notice = *find(board, id);
    uint64_t version = notice ? notice->version : 0;
    if (notice)
        *progress = notice->progress;
    pthread_mutex_unlock(&board->mutex);
    return version;
}

uint64_t qg_board_version(struct qg_board *board) {
    pthread_mutex_lock(&board->mutex);
    uint64_t version = board->version;
    pthread_mutex_unlock(&board->mutex);
    return version;
}

uint64_t qg_board_touched(struct qg_board *board) {
    pthread_mutex_lock(&board->mutex);
    uint64_t touched = board->touched;
    pthread_mutex_unlock(&board->mutex);
    return touched;
}

size_t qg_board_news(struct qg_board *board, uint64_t since, char (*ids)[QG_JOB_ID_ROOM], size_t room) {
    size_t count = 0;
    pthread_mutex_lock(&board->mutex);
    for (const struct notice *notice = board->notices; notice && count < room; notice = notice->next)
        if (notice->version > since)
            strcpy(ids[count++], notice->id);
    pthread_mutex_unlock(&board->mutex);
    return count;
}

/* --- waiting --- */

bool qg_board_wait(struct qg_board *board, struct qg_waiter *waiter, uint64_t version) {
    pthread_mutex_lock(&board->mutex);
    bool waits = !board->shut && board->version == version;
    if (waits) {
        waiter->suspend(waiter->context);
        waiter->next = board->waiters;
        board->waiters = waiter;
        if (waiter->deadline < board->wake_at) /* else the timekeeper looks early enough */
            pthread_cond_signal(&board->changed);
    }
    pthread_mutex_unlock(&board->mutex);
    return waits;
}

void qg_board_shut(struct qg_board *board) {
    pthread_mutex_lock(&board->mutex);
    board->shut = true;
    resume_if(board, any, NULL);
    pthread_mutex_unlock(&board->mutex);
}

bool qg_board_is_shut(struct qg_board *board) {
    pthread_mutex_lock(&board->mutex);
    bool shut = board->shut;
    pthread_mutex_unlock(&board->mutex);
    return shut;
}
