/* Executors: every piece once, worker numbers that may index workspaces, several callers at once, fair shares. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>
#include <time.h>

#include "core/pool.h"

enum { PIECES = 2000, THREADS = 4, CALLERS = 6 };

/* What one batch saw. */
struct tally {
    int workers;
    atomic_int times[PIECES]; /* each piece was run */
    atomic_int busy[THREADS]; /* a piece is running under this worker number */
    atomic_int faults;        /* worker numbers out of range, or used twice at once */
    size_t order[PIECES];     /* item run n-th; serial executor only */
    atomic_size_t run;
};

static void count_piece(void *context, size_t item, int worker) {
    struct tally *tally = context;
    if (worker < 0 || worker >= tally->workers || atomic_fetch_add(&tally->busy[worker], 1) != 0)
        atomic_fetch_add(&tally->faults, 1);
    atomic_fetch_add(&tally->times[item], 1);
    size_t n = atomic_fetch_add(&tally->run, 1);
    tally->order[n] = item;
    if (worker >= 0 && worker < tally->workers)
        atomic_fetch_sub(&tally->busy[worker], 1);
}

static void run_and_check(const struct qg_executor *executor, struct tally *tally, size_t n) {
    memset(tally, 0, sizeof *tally);
    tally->workers = executor->workers;
    executor->run(executor->self, n, count_piece, tally);
    for (size_t i = 0; i < PIECES; i++)
        assert_int_equal(tally->times[i], i < n);
    assert_int_equal(tally->faults, 0);
}

static void serial_executor_runs_in_order(void **state) {
    (void)state;
    static struct tally tally;
    run_and_check(&qg_serial_executor, &tally, PIECES);
    for (size_t i = 0; i < PIECES; i++)
        assert_int_equal(tally.order[i], i);
    run_and_check(&qg_serial_executor, &tally, 0);
}

static void pool_runs_every_piece_once(void **state) {
    (void)state;
    static struct tally tally;
    const int threads[] = {1, 2, THREADS};
    for (size_t k = 0; k < sizeof threads / sizeof *threads; k++) {
        struct qg_pool *pool = qg_pool_create(threads[k]);
        assert_non_null(pool);
        struct qg_executor executor = qg_pool_executor(pool);
        assert_int_equal(executor.workers, threads[k]);
        const size_t sizes[] = {0, 1, 3, PIECES};
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
            run_and_check(&executor, &tally, sizes[i]);
        qg_pool_destroy(pool);
    }
    qg_pool_destroy(NULL);
}

struct caller {
    struct qg_executor executor;
    struct tally tally;
    pthread_t thread;
};

static void *call(void *argument) {
    struct caller *caller = argument;
    for (int i = 0; i < 20; i++) {
        memset(&caller->tally, 0, sizeof caller->tally);
        caller->tally.workers = caller->executor.workers;
        caller->executor.run(caller->executor.self, 100, count_piece, &caller->tally);
        for (size_t k = 0; k < 100; k++)
            if (caller->tally.times[k] != 1)
                atomic_fetch_add(&caller->tally.faults, 1);
        if (caller->tally.faults)
            break;
    }
    return NULL;
}

static void several_callers_share_a_pool(void **state) {
    (void)state;
    static struct caller callers[CALLERS];
    struct qg_pool *pool = qg_pool_create(THREADS);
    assert_non_null(pool);
    for (int i = 0; i < CALLERS; i++) {
        callers[i].executor = qg_pool_executor(pool);
        assert_int_equal(pthread_create(&callers[i].thread, NULL, call, &callers[i]), 0);
    }
    for (int i = 0; i < CALLERS; i++) {
        pthread_join(callers[i].thread, NULL);
        assert_int_equal(callers[i].tally.faults, 0);
    }
    qg_pool_destroy(pool);
}

/* Two batches on one thread, and in which order their pieces ran. */
enum { LONG_BATCH = 20000, SHORT_BATCH = 50 };

struct turns {
    struct qg_executor executor;
    atomic_bool long_started, short_started;
    size_t run;
    unsigned char sequence[LONG_BATCH + SHORT_BATCH]; /* touched by the pool's only thread */
};

static void long_piece(void *context, size_t item, int worker) {
    (void)item, (void)worker;
    struct turns *turns = context;
    turns->sequence[turns->run++] = 'L';
    atomic_store(&turns->long_started, true);
    if (!atomic_load(&turns->short_started))
        nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
}

static void short_piece(void *context, size_t item, int worker) {
    (void)item, (void)worker;
    struct turns *turns = context;
    turns->sequence[turns->run++] = 'S';
    atomic_store(&turns->short_started, true);
}

static void *run_long_batch(void *argument) {
    struct turns *turns = argument;
    turns->executor.run(turns->executor.self, LONG_BATCH, long_piece, turns);
    return NULL;
}

static void batches_take_turns(void **state) {
    (void)state;
    static struct turns turns;
    struct qg_pool *pool = qg_pool_create(1);
    assert_non_null(pool);
    turns.executor = qg_pool_executor(pool);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, run_long_batch, &turns), 0);
    while (!atomic_load(&turns.long_started))
        nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
    turns.executor.run(turns.executor.self, SHORT_BATCH, short_piece, &turns);
    pthread_join(thread, NULL);
    assert_int_equal(turns.run, LONG_BATCH + SHORT_BATCH);
    const unsigned char *first = memchr(turns.sequence, 'S', turns.run);
    assert_non_null(first);
    /* The long batch was handed in first and has pieces left: every second piece is of the short one until it ends. */
    for (int i = 0; i < 2 * SHORT_BATCH - 1; i++)
        assert_int_equal(first[i], i % 2 == 0 ? 'S' : 'L');
    qg_pool_destroy(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(serial_executor_runs_in_order),
        cmocka_unit_test(pool_runs_every_piece_once),
        cmocka_unit_test(several_callers_share_a_pool),
        cmocka_unit_test(batches_take_turns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
