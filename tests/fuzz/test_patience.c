/* Patience: a hang and a spin are found, a stopped process and a thread that waits for a processor are not blamed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "tests/fuzz/patience.h"

enum { SHORT_MS = 300 };

static const struct patience patience = {SHORT_MS, SHORT_MS};

/* One who may answer through a pipe. */
struct debtor {
    pthread_t thread;
    int pipe[2];
    atomic_bool ending;
    int delay_ms;
};

static void nap(int ms) {
    nanosleep(&(const struct timespec){ms / 1000, ms % 1000 * 1000000L}, NULL);
}

static void *sleep_on(void *self) {
    while (!atomic_load(&((struct debtor *)self)->ending))
        nap(5);
    return NULL;
}

static void *spin(void *self) {
    while (!atomic_load(&((struct debtor *)self)->ending))
        ;
    return NULL;
}

static void *answer(void *self) {
    struct debtor *debtor = self;
    nap(debtor->delay_ms);
    assert_int_equal(write(debtor->pipe[1], "x", 1), 1);
    return NULL;
}

/* Lets a debtor do `work`, and judges it. */
static enum verdict judge(void *(*work)(void *), int delay_ms) {
    struct debtor debtor = {.delay_ms = delay_ms};
    assert_int_equal(pipe(debtor.pipe), 0);
    assert_int_equal(pthread_create(&debtor.thread, NULL, work, &debtor), 0);
    enum verdict verdict = patience_wait(debtor.pipe[0], &patience);
    atomic_store(&debtor.ending, true);
    pthread_join(debtor.thread, NULL);
    close(debtor.pipe[0]);
    close(debtor.pipe[1]);
    return verdict;
}

static void test_verdicts(void **state) {
    (void)state;
    assert_int_equal(judge(sleep_on, 0), PATIENCE_HANGS);
    assert_int_equal(judge(spin, 0), PATIENCE_SPINS);
    assert_int_equal(judge(answer, SHORT_MS / 3), PATIENCE_READY);
}

/* A child is stopped for longer than its patience while its debtor sleeps: a clock on the wall would find that it hangs. */
static void test_a_stopped_process_is_not_blamed(void **state) {
    (void)state;
    pid_t child = fork();
    if (child == 0)
        _exit((int)judge(answer, SHORT_MS / 2));
    nap(SHORT_MS / 6);
    assert_int_equal(kill(child, SIGSTOP), 0);
    nap(2 * SHORT_MS);
    assert_int_equal(kill(child, SIGCONT), 0);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), PATIENCE_READY);
}

/* Answers when it has been given the processor often enough, each time after all others. */
static void *answer_when_idle(void *self) {
    const struct sched_param none = {0};
    if (pthread_setschedparam(pthread_self(), SCHED_IDLE, &none) != 0)
        return answer(self);
    struct timespec used;
    do
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    while (used.tv_sec == 0 && used.tv_nsec < 20000000);
    return answer(self);
}

/* Another process keeps the one processor busy for a second, so that 20 ms of work take longer than the patience. */
static void test_a_starved_thread_is_not_blamed(void **state) {
    (void)state;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(sched_getcpu(), &one);
    pid_t child = fork(), busy = -1;
    if (child == 0) {
        sched_setaffinity(0, sizeof one, &one);
        busy = fork();
        if (busy == 0) {
            alarm(1);
            for (;;)
                ;
        }
        enum verdict verdict = judge(answer_when_idle, 0);
        kill(busy, SIGKILL);
        _exit((int)verdict);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), PATIENCE_READY);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_verdicts),
        cmocka_unit_test(test_a_stopped_process_is_not_blamed),
        cmocka_unit_test(test_a_starved_thread_is_not_blamed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
