/* A thread that wakes libmicrohttpd's. See nudge.h. */
#include "server/http/nudge.h"

#include <assert.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "server/base/clock.h"

enum { MANY = 120, /* of 128, some are for the listener and for what wakes libmicrohttpd */ INTERVAL_MS = 20 };

struct qg_nudge {
    int bell;              /* counts nudges; nobody reads it */
    pthread_mutex_t mutex; /* guards all that follows */
    pthread_cond_t changed;
    int connections;
    bool ending;
    pthread_t thread;
};

static void *run(void *self) {
    struct qg_nudge *nudge = self;
    pthread_mutex_lock(&nudge->mutex);
    while (!nudge->ending) {
        bool many = nudge->connections >= MANY;
        if (many)
            eventfd_write(nudge->bell, 1);
        qg_condition_wait(&nudge->changed, &nudge->mutex, many ? qg_monotonic_clock() + INTERVAL_MS : INT64_MAX);
    }
    pthread_mutex_unlock(&nudge->mutex);
    return NULL;
}

struct qg_nudge *qg_nudge_create(void) {
    struct qg_nudge *nudge = calloc(1, sizeof *nudge);
    if (!nudge)
        return NULL;
    nudge->bell = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    qg_condition_init(&nudge->changed);
    pthread_mutex_init(&nudge->mutex, NULL);
    if (nudge->bell >= 0 && pthread_create(&nudge->thread, NULL, run, nudge) == 0)
        return nudge;
    if (nudge->bell >= 0)
        close(nudge->bell);
    pthread_mutex_destroy(&nudge->mutex);
    pthread_cond_destroy(&nudge->changed);
    free(nudge);
    return NULL;
}

bool qg_nudge_join(const struct qg_nudge *nudge, int epoll) {
    struct epoll_event event = {.events = EPOLLIN | EPOLLET}; /* by edges, of which each write is one */
    return epoll_ctl(epoll, EPOLL_CTL_ADD, nudge->bell, &event) == 0;
}

void qg_nudge_count(struct qg_nudge *nudge, int change) {
    assert(change == 1 || change == -1);
    pthread_mutex_lock(&nudge->mutex);
    nudge->connections += change;
    assert(nudge->connections >= 0);
    if (change == 1 && nudge->connections == MANY)
        pthread_cond_signal(&nudge->changed);
    pthread_mutex_unlock(&nudge->mutex);
}

void qg_nudge_destroy(struct qg_nudge *nudge) {
    if (!nudge)
        return;
    pthread_mutex_lock(&nudge->mutex);
    nudge->ending = true;
    pthread_cond_signal(&nudge->changed);
    pthread_mutex_unlock(&nudge->mutex);
    pthread_join(nudge->thread, NULL);
    close(nudge->bell);
    pthread_mutex_destroy(&nudge->mutex);
    pthread_cond_destroy(&nudge->changed);
    free(nudge);
}
