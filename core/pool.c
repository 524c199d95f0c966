/* A pool of threads that serves several batches of pieces fairly.
 *
 * Batches with pieces still to be given out form a ring; `turn` points into it. A free thread takes one piece of the
 * batch whose turn it is and passes the turn on: round robin, so that k batches get each 1/k of the threads' attention
 * however many pieces they hold, and a batch alone gets all. The batch of which the last piece has been given out
 * leaves the ring; its caller sleeps until the last piece has come back.
 *
 * Ownership   a batch lives on the stack of its caller, inside run(); nothing is allocated after qg_pool_create
 * Threads     everything in struct qg_pool and in batches is guarded by the one mutex; pieces run outside of it. That
 *             costs two lockings per piece (some 100 ns), against pieces of tens of microseconds and more.
 * Invariants  turn is NULL or points to a batch of the ring; every batch of the ring has next < count
 * Failures    only qg_pool_create can fail. A piece that itself calls run() of the same pool would wait for a thread
 *             while holding one, and with all threads doing so nobody would be left: it must not.
 */
#include "core/pool.h"

#include <assert.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

/* One call of run(). */
struct batch {
    qg_piece *piece;
    void *context;
    size_t count;    /* pieces */
    size_t next;     /* the first not yet given out */
    size_t finished; /* pieces that have come back */
    pthread_cond_t done;
    struct batch *before, *after; /* the ring */
};

struct worker {
    struct qg_pool *pool;
    pthread_t thread;
    int number;
};

struct qg_pool {
    pthread_mutex_t mutex;
    pthread_cond_t work; /* a batch came, or the end */
    pthread_cond_t idle; /* the last caller has left run() */
    struct batch *turn;  /* whose piece is given out next; NULL: nothing to do */
    size_t callers;      /* inside run() */
    bool ending;
    int threads;
    struct worker worker[];
};

/* Enters a batch just behind the one whose turn it is, where its turn comes last. */
static void ring_insert(struct qg_pool *pool, struct batch *batch) {
    struct batch *turn = pool->turn;
    if (!turn) {
        batch->before = batch->after = batch;
        pool->turn = batch;
        return;
    }
    batch->before = turn->before;
    batch->after = turn;
    batch->before->after = batch;
    turn->before = batch;
}

/* Takes out the batch whose turn it is. */
static void ring_remove_turn(struct qg_pool *pool) {
    struct batch *batch = pool->turn;
    batch->before->after = batch->after;
    batch->after->before = batch->before;
    pool->turn = batch->after == batch ? NULL : batch->after;
}

/* Gives out one piece of the batch whose turn it is and passes the turn on. */
static struct batch *take_piece(struct qg_pool *pool, size_t *item) {
    struct batch *batch = pool->turn;
    assert(batch->next < batch->count);
    *item = batch->next++;
    if (batch->next == batch->count)
        ring_remove_turn(pool);
    else
        pool->turn = batch->after;
    return batch;
}

static void *work(void *argument) {
    const struct worker *self = argument;
    struct qg_pool *pool = self->pool;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (!pool->turn && !pool->ending)
            pthread_cond_wait(&pool->work, &pool->mutex);
        if (!pool->turn)
            break;
        size_t item;
        struct batch *batch = take_piece(pool, &item);
        pthread_mutex_unlock(&pool->mutex);
        batch->piece(batch->context, item, self->number);
        pthread_mutex_lock(&pool->mutex);
        if (++batch->finished == batch->count)
            pthread_cond_signal(&batch->done);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

static void run(void *self, size_t n, qg_piece *piece, void *context) {
    if (n == 0)
        return;
    struct qg_pool *pool = self;
    struct batch batch = {.piece = piece, .context = context, .count = n};
    pthread_cond_init(&batch.done, NULL);
    pthread_mutex_lock(&pool->mutex);
    pool->callers++;
    ring_insert(pool, &batch);
    pthread_cond_broadcast(&pool->work);
    while (batch.finished < batch.count)
        pthread_cond_wait(&batch.done, &pool->mutex);
    if (--pool->callers == 0)
        pthread_cond_signal(&pool->idle);
    pthread_mutex_unlock(&pool->mutex);
    pthread_cond_destroy(&batch.done);
}

/* Starts the threads; returns how many of them could be started. */
static int start_threads(struct qg_pool *pool, int threads) {
    for (int i = 0; i < threads; i++) {
        struct worker *worker = &pool->worker[i];
        *worker = (struct worker){.pool = pool, .number = i};
        if (pthread_create(&worker->thread, NULL, work, worker) != 0)
            return i;
    }
    return threads;
}

struct qg_pool *qg_pool_create(int threads) {
    assert(threads >= 1);
    struct qg_pool *pool = calloc(1, sizeof *pool + (size_t)threads * sizeof pool->worker[0]);
    if (!pool)
        return NULL;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->idle, NULL);
    pool->threads = start_threads(pool, threads);
    if (pool->threads < threads) {
        qg_pool_destroy(pool);
        return NULL;
    }
    return pool;
}

void qg_pool_destroy(struct qg_pool *pool) {
    if (!pool)
        return;
    pthread_mutex_lock(&pool->mutex);
    while (pool->callers > 0)
        pthread_cond_wait(&pool->idle, &pool->mutex);
    pool->ending = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 0; i < pool->threads; i++)
        pthread_join(pool->worker[i].thread, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}

struct qg_executor qg_pool_executor(struct qg_pool *pool) {
    return (struct qg_executor){.self = pool, .workers = pool->threads, .run = run};
}
