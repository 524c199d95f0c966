/* quietgear run and check: jobs read, checked and computed here, without a daemon.
 *
 * An interrupt asks the study to stop at the next piece of work; a second one ends the program at once. A result file is
 * there whole or not at all.
 */
#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/files.h"
#include "cli/progress.h"
#include "cli/words.h"
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

static void print_faults(const char *path, const struct qg_faults *faults) {
    for (size_t i = 0; i < faults->count; i++)
        qg_print_fault(path, faults->item[i].pointer, faults->item[i].detail);
    if (faults->lost)
        fprintf(stderr, "%s: and %zu more\n", qg_shown_name(path), faults->lost);
}

/* The warnings from the first one on. */
static void print_warnings(const char *path, const struct qg_notes *warnings, size_t first) {
    for (size_t i = first; i < warnings->count; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(warnings->item[i].where, pointer);
        fprintf(stderr, "%s: warning: %s%s%s\n", qg_shown_name(path), pointer, pointer[0] ? ": " : "",
                warnings->item[i].text);
    }
}

static void print_timing(const struct qg_study_result *result, int threads) {
    fprintf(stderr, "%.1f s on %d thread%s: compliance %.1f s, statics %.1f s, dynamics %.1f s\n", result->timing.wall,
            threads, threads == 1 ? "" : "s", result->timing.compliance, result->timing.statics,
            result->timing.dynamics);
}

/* Reads and checks the document; says what is wrong with it. Returns an exit status. */
static int read_job(const char *path, struct qg_job *job) {
    struct qg_notes warnings = {0};
    size_t length;
    char *bytes = qg_file_read(path, QG_DOCUMENT_BYTES_MAX, &length);
    if (!bytes) {
        fprintf(stderr, "%s: %s\n", qg_shown_name(path), strerror(errno));
        return QG_EXIT_WRONG_INPUT;
    }
    struct qg_faults *faults = malloc(sizeof *faults);
    const enum qg_document_status status =
        faults ? qg_document_read(bytes, length, job, faults, &warnings) : QG_DOCUMENT_NO_MEMORY;
    free(bytes);
    if (status == QG_DOCUMENT_OK)
        print_warnings(path, &warnings, 0);
    else if (status != QG_DOCUMENT_NO_MEMORY)
        print_faults(path, faults);
    free(faults);
    if (status != QG_DOCUMENT_NO_MEMORY)
        return status == QG_DOCUMENT_OK ? QG_EXIT_DONE : QG_EXIT_WRONG_INPUT;
    fprintf(stderr, "%s: %s\n", qg_shown_name(path), qg_status_text(QG_OUT_OF_MEMORY));
    return QG_EXIT_FAILED;
}

/* quietgear check */

static int print_geometry(const struct qg_options *options, const struct qg_job *job) {
    struct qg_output output;
    struct qg_pair_geometry geometry;
    struct qg_text text = {0};
    (void)options;
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
    print_warnings(path, &result->warnings, checked.count);
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

static int processors(void) {
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > QG_THREADS_MAX ? QG_THREADS_MAX : (int)n;
}

static int run_on_pool(const struct qg_options *options, const struct qg_job *job, struct qg_output *output) {
    struct qg_pool *pool = qg_pool_create(options->threads ? options->threads : processors());
    if (!pool) {
        fputs("quietgear: cannot start the threads\n", stderr);
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

/* Reads the job and hands it on. */
static int with_job(const struct qg_options *options,
                    int (*command)(const struct qg_options *options, const struct qg_job *job)) {
    struct qg_job *job = malloc(sizeof *job);
    if (!job) {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(QG_OUT_OF_MEMORY));
        return QG_EXIT_FAILED;
    }
    int status = read_job(options->subject, job);
    if (status == QG_EXIT_DONE)
        status = command(options, job);
    free(job);
    return status;
}

int qg_command_run(const struct qg_options *options) {
    qg_numerics_init();
    return with_job(options, compute);
}

int qg_command_check(const struct qg_options *options) {
    return with_job(options, print_geometry);
}
