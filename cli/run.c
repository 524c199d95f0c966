/* quietgear run and check: jobs read, checked and computed here, without a daemon.
 *
 * An interrupt asks the study to stop at the next piece of work; a second one ends the program at once. A result file is
 * there whole or not at all.
 */
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/files.h"
#include "cli/job.h"
#include "cli/progress.h"
#include "cli/words.h"
#include "core/cost.h"
#include "core/memory.h"
#include "core/pool.h"
#include "schema/result.h"

/* Set by the signal handler: the one thing a handler can do is to write to such an object, so it cannot be passed around.
 * Lock-free, read by any thread. */
static atomic_int interrupted;

static void on_signal(int number) {
    atomic_store_explicit(&interrupted, number, memory_order_relaxed);
}

static bool is_cancelled(void *self) {
    (void)self;
    return atomic_load_explicit(&interrupted, memory_order_relaxed) != 0;
}

/* The first interrupt is noted, the second has its usual effect. */
static void catch_signals(void) {
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

/* Words for people */

static void print_timing(const struct qg_study_result *result, int threads) {
    fprintf(stderr, "%.1f s on %d thread%s: compliance %.1f s, statics %.1f s, dynamics %.1f s\n", result->timing.wall,
            threads, threads == 1 ? "" : "s", result->timing.compliance, result->timing.statics,
            result->timing.dynamics);
}

static int processors(void) {
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > QG_THREADS_MAX ? QG_THREADS_MAX : (int)n;
}

int qg_run_threads(const struct qg_options *options) {
    return options->threads ? options->threads : processors();
}

/* quietgear check */

/* What `quietgear run` of the job would take here. */
static void print_estimate(const struct qg_options *options, const struct qg_job *job) {
    const int threads = qg_run_threads(options);
    const struct qg_cost cost = qg_study_cost(&job->study);
    const double seconds = cost.processor_seconds / threads;
    fprintf(stderr, "%s: about %.0f evaluation%s, %.*f s on %d thread%s, at most %.0f MB of memory\n",
            qg_shown_name(options->subject), cost.evaluations, cost.evaluations == 1 ? "" : "s", seconds < 10, seconds,
            threads, threads == 1 ? "" : "s", ceil(qg_study_memory(&job->study, threads) / 1e6));
}

static int print_geometry(const struct qg_options *options, const struct qg_job *job) {
    struct qg_output output;
    struct qg_pair_geometry geometry;
    struct qg_text text = {0};
    print_estimate(options, job);
    qg_pair_derive(&job->study.pair, &geometry, NULL); /* the reader has found it possible */
    qg_geometry_write(&text, &geometry);
    qg_output_open(&output, NULL);
    const int status = qg_deliver(&text, &output);
    qg_text_finish(&text);
    return status;
}

/* quietgear run */

/* What the observer of a study carries along. */
struct watch {
    struct qg_bar bar;
    enum qg_objective objective;
};

static void on_progress(void *self, const struct qg_progress *progress) {
    struct watch *watch = self;
    qg_bar_update(&watch->bar, progress, watch->objective);
}

/* What the computation has found, behind the warnings of the check, which were printed before it. */
static void print_findings(const char *path, const struct qg_study *study, const struct qg_study_result *result) {
    struct qg_notes checked = {0};
    qg_study_check(study, NULL, NULL, &checked);
    qg_print_warnings(path, &result->warnings, checked.count);
}

/* Runs the study and delivers the result. */
static int run_study(const struct qg_options *options, const struct qg_job *job, const struct qg_means *means,
                     struct qg_output *output) {
    struct watch watch = {.objective = job->study.objective};
    const struct qg_observer observer = {
        .self = &watch, .progress = on_progress, .cancelled = is_cancelled, .clock = {.now = qg_monotonic_seconds}};
    struct qg_study_result result;
    struct qg_text text = {0};
    qg_bar_init(&watch.bar, isatty(STDERR_FILENO) ? stderr : NULL);
    const enum qg_status status = qg_study_run(&job->study, means, &observer, &result);
    qg_bar_finish(&watch.bar);
    int exit_status = QG_EXIT_FAILED;
    if (status == QG_OK) {
        qg_result_write(&text, job, &result, means->executor.workers);
        exit_status = qg_deliver(&text, output);
        print_findings(options->subject, &job->study, &result);
        print_timing(&result, means->executor.workers);
    } else {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(status));
    }
    qg_text_finish(&text);
    qg_study_result_finish(&result);
    return exit_status;
}

static int run_on_pool(const struct qg_options *options, const struct qg_job *job, struct qg_output *output) {
    struct qg_pool *pool = qg_pool_create(qg_run_threads(options));
    if (!pool) {
        fputs("quietgear: cannot start the threads: out of memory\n", stderr);
        return QG_EXIT_FAILED;
    }
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    const int status = run_study(options, job, &means, output);
    qg_pool_destroy(pool);
    return status;
}

static int compute(const struct qg_options *options, const struct qg_job *job) {
    struct qg_output output;
    if (!qg_output_open(&output, options->result_path)) {
        fprintf(stderr, "%s: %s\n", options->result_path, strerror(errno));
        return QG_EXIT_FAILED;
    }
    catch_signals();
    const int status = run_on_pool(options, job, &output);
    qg_output_discard(&output);
    return status;
}

int qg_command_run(const struct qg_options *options) {
    return qg_with_job(options, compute);
}

int qg_command_check(const struct qg_options *options) {
    return qg_with_job(options, print_geometry);
}
