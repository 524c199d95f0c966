/* quietgear: the command line. Reads a job document, checks it, runs it on the threads of this machine.
 *
 * Standard output carries documents and nothing else; words go to standard error. Exit status: 0 done, 1 the job failed or
 * was cancelled, 2 the input is wrong (the document, or the command line itself).
 *
 * An interrupt asks the study to stop at the next piece of work; a second one ends the program at once. A result file is
 * there whole or not at all.
 */
#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/files.h"
#include "cli/progress.h"
#include "config.h"
#include "core/pool.h"
#include "schema/result.h"

enum { EXIT_JOB_FAILED = 1, EXIT_BAD_INPUT = 2, THREADS_MAX = 1024 };

static const char usage[] = "usage: quietgear run JOB.json [-o RESULT.json] [--threads N]\n"
                            "       quietgear check JOB.json\n"
                            "       quietgear --help | --version\n";

static const char help[] =
    "\n"
    "Optimizes the tooth reliefs of spur gear pairs. JOB.json is a job document, \"-\" is standard input.\n"
    "\n"
    "run     computes the job and writes the result, as JSON, to standard output\n"
    "  -o, --output RESULT.json   write it to this file instead; the file appears when the result is complete\n"
    "  -t, --threads N            threads to use, 1 to 1024; default: one for each processor\n"
    "check   checks the document and prints the geometry that follows from it, as JSON\n"
    "\n"
    "Exit status: 0 done, 1 the job failed, 2 the input is wrong. Each fault is one line on standard error:\n"
    "the document, the place in it (a JSON pointer), what was found and what is allowed.\n";

/* What the command line asks for. */
struct options {
    const char *command, *job_path, *result_path;
    int threads; /* 0: as many as there are processors */
};

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

static const char *shown_name(const char *path) {
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

/* A pointer is exact, so a stranger's key in it may hold anything; a terminal gets control characters as escapes only. */
static void print_pointer(const char *pointer) {
    for (const unsigned char *at = (const unsigned char *)pointer; *at; at++) {
        const bool c1 = at[0] == 0xc2 && at[1] >= 0x80 && at[1] < 0xa0; /* U+0080 to U+009F in UTF-8 */
        if (c1)
            at++;
        if (c1 || *at < 0x20 || *at == 0x7f)
            fprintf(stderr, "\\u%04x", *at);
        else
            fputc(*at, stderr);
    }
    if (pointer[0])
        fputs(": ", stderr);
}

static void print_faults(const char *path, const struct qg_faults *faults) {
    for (size_t i = 0; i < faults->count; i++) {
        fprintf(stderr, "%s: ", shown_name(path));
        print_pointer(faults->item[i].pointer);
        fprintf(stderr, "%s\n", faults->item[i].detail);
    }
    if (faults->lost)
        fprintf(stderr, "%s: and %zu more\n", shown_name(path), faults->lost);
}

static void print_warnings(const char *path, const struct qg_notes *warnings) {
    for (size_t i = 0; i < warnings->count; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(warnings->item[i].where, pointer);
        fprintf(stderr, "%s: warning: %s%s%s\n", shown_name(path), pointer, pointer[0] ? ": " : "",
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
        fprintf(stderr, "%s: %s\n", shown_name(path), strerror(errno));
        return EXIT_BAD_INPUT;
    }
    struct qg_faults *faults = malloc(sizeof *faults);
    const enum qg_document_status status =
        faults ? qg_document_read(bytes, length, job, faults, &warnings) : QG_DOCUMENT_NO_MEMORY;
    free(bytes);
    if (status == QG_DOCUMENT_OK)
        print_warnings(path, &warnings);
    else if (status != QG_DOCUMENT_NO_MEMORY)
        print_faults(path, faults);
    free(faults);
    if (status != QG_DOCUMENT_NO_MEMORY)
        return status == QG_DOCUMENT_OK ? EXIT_SUCCESS : EXIT_BAD_INPUT;
    fprintf(stderr, "%s: %s\n", shown_name(path), qg_status_text(QG_OUT_OF_MEMORY));
    return EXIT_JOB_FAILED;
}

/* Ends the text with a line feed and puts it where it belongs. Returns an exit status. */
static int deliver(struct qg_text *text, struct qg_output *output) {
    qg_text_add(text, "\n", 1);
    if (text->failed) {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(QG_OUT_OF_MEMORY));
        return EXIT_JOB_FAILED;
    }
    if (qg_output_commit(output, text->data, text->length))
        return EXIT_SUCCESS;
    fprintf(stderr, "%s: %s\n", output->path ? output->path : "standard output", strerror(errno));
    return EXIT_JOB_FAILED;
}

/* quietgear check */

static int check_job(const struct options *options, const struct qg_job *job) {
    struct qg_output output;
    struct qg_pair_geometry geometry;
    struct qg_text text = {0};
    (void)options;
    qg_pair_derive(&job->study.pair, &geometry, NULL); /* the reader has found it possible */
    qg_geometry_write(&text, &geometry);
    qg_output_open(&output, NULL);
    const int status = deliver(&text, &output);
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

/* Runs the study and delivers the result. */
static int run_study(const struct qg_job *job, const struct qg_means *means, struct qg_output *output) {
    struct watch watch = {.objective = job->study.objective};
    const struct qg_observer observer = {
        .self = &watch, .progress = on_progress, .cancelled = is_cancelled, .clock = {.now = qg_monotonic_seconds}};
    struct qg_study_result result;
    struct qg_text text = {0};
    qg_bar_init(&watch.bar, isatty(STDERR_FILENO) ? stderr : NULL);
    const enum qg_status status = qg_study_run(&job->study, means, &observer, &result);
    qg_bar_finish(&watch.bar);
    int exit_status = EXIT_JOB_FAILED;
    if (status == QG_OK) {
        qg_result_write(&text, job, &result, means->executor.workers);
        exit_status = deliver(&text, output);
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
    return n < 1 ? 1 : n > THREADS_MAX ? THREADS_MAX : (int)n;
}

static int run_on_pool(const struct options *options, const struct qg_job *job, struct qg_output *output) {
    struct qg_pool *pool = qg_pool_create(options->threads ? options->threads : processors());
    if (!pool) {
        fputs("quietgear: cannot start the threads\n", stderr);
        return EXIT_JOB_FAILED;
    }
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    const int status = run_study(job, &means, output);
    qg_pool_destroy(pool);
    return status;
}

static int run_job(const struct options *options, const struct qg_job *job) {
    struct qg_output output;
    if (!qg_output_open(&output, options->result_path)) {
        fprintf(stderr, "%s: %s\n", options->result_path, strerror(errno));
        return EXIT_JOB_FAILED;
    }
    catch_signals();
    const int status = run_on_pool(options, job, &output);
    qg_output_discard(&output);
    return status;
}

/* The command line */

__attribute__((format(printf, 1, 2))) static int refuse_usage(const char *format, ...) {
    va_list arguments;
    fputs("quietgear: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\n%s", usage);
    return EXIT_BAD_INPUT;
}

/* A whole number from 1 to THREADS_MAX; 0 when it is none. */
static int parse_threads(const char *text) {
    char *end;
    errno = 0;
    const long n = strtol(text, &end, 10);
    return end == text || *end || errno || n < 1 || n > THREADS_MAX ? 0 : (int)n;
}

/* Fills in the options. Returns -1 to go on, or the exit status to end with. */
static int parse_options(int count, char **words, struct options *options) {
    static const struct option names[] = {{"output", required_argument, NULL, 'o'},
                                          {"threads", required_argument, NULL, 't'},
                                          {"help", no_argument, NULL, 'h'},
                                          {"version", no_argument, NULL, 'V'},
                                          {0}};
    for (int option; (option = getopt_long(count, words, "o:t:hV", names, NULL)) != -1;) {
        if (option == 'h') {
            printf("%s%s", usage, help);
            return EXIT_SUCCESS;
        }
        if (option == 'V') {
            puts("quietgear " PACKAGE_VERSION);
            return EXIT_SUCCESS;
        }
        if (option == 'o')
            options->result_path = optarg;
        else if (option != 't')
            return refuse_usage("see --help");
        else if ((options->threads = parse_threads(optarg)) == 0)
            return refuse_usage("--threads: found %s, allowed 1 to 1024", optarg);
    }
    if (count - optind != 2)
        return refuse_usage("found %d words, allowed a command and a job document", count - optind);
    options->command = words[optind];
    options->job_path = words[optind + 1];
    return -1;
}

typedef int command_function(const struct options *options, const struct qg_job *job);

static command_function *find_command(const char *name) {
    return strcmp(name, "run") == 0 ? run_job : strcmp(name, "check") == 0 ? check_job : NULL;
}

int main(int count, char **words) {
    struct options options = {0};
    const int parsed = parse_options(count, words, &options);
    if (parsed >= 0)
        return parsed;
    command_function *command = find_command(options.command);
    if (!command)
        return refuse_usage("found the command \"%s\", allowed run or check", options.command);
    if (command != run_job && (options.result_path || options.threads))
        return refuse_usage("--output and --threads go with run, not with %s", options.command);
    qg_numerics_init();
    struct qg_job *job = malloc(sizeof *job);
    if (!job) {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(QG_OUT_OF_MEMORY));
        return EXIT_JOB_FAILED;
    }
    int status = read_job(options.job_path, job);
    if (status == EXIT_SUCCESS)
        status = command(&options, job);
    free(job);
    return status;
}
