/* quietgear submit, watch, result and cancel: the public calls of a daemon. */
#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/daemon.h"
#include "cli/files.h"
#include "cli/http.h"
#include "cli/progress.h"
#include "cli/words.h"
#include "schema/document.h"

/* submit */

/* Prints the id of the job in the answer. */
static int print_id(const char *subject, const struct qg_answer *answer) {
    cJSON *job = qg_parse(answer);
    const char *id = qg_string_at(job, "id");
    int status = QG_EXIT_DONE;
    if (!*id)
        status = qg_say_strange(subject);
    else if (printf("%s\n", id) < 0 || fflush(stdout) != 0)
        status = QG_EXIT_FAILED;
    cJSON_Delete(job);
    return status;
}

int qg_command_submit(const struct qg_options *options) {
    struct qg_answer answer = {0};
    struct qg_text key = {0};
    struct qg_call call = {.path = "/v1/jobs", .post = true};
    char *document = qg_file_read(options->subject, QG_DOCUMENT_BYTES_MAX, &call.body_length);
    if (!document) {
        fprintf(stderr, "%s: %s\n", qg_shown_name(options->subject), strerror(errno));
        return QG_EXIT_WRONG_INPUT;
    }
    call.body = document;
    if (options->key) {
        qg_text_format(&key, "Idempotency-Key: %s", options->key);
        call.headers[0] = key.data;
    }
    int status = qg_ask(options, options->subject, call, &answer);
    if (status == QG_EXIT_DONE)
        status = print_id(options->subject, &answer);
    free(document);
    qg_text_finish(&key);
    qg_answer_finish(&answer);
    return status;
}

/* watch */

/* Draws what the daemon says of the job's progress. */
static void show_progress(struct qg_bar *bar, const cJSON *job) {
    const cJSON *progress = cJSON_GetObjectItemCaseSensitive(job, "progress");
    const double done = qg_number_at(progress, "done"), total = qg_number_at(progress, "total"),
                 best = qg_number_at(progress, "best");
    if (!(done >= 0 && total > 0 && done <= total))
        return;
    struct qg_progress shown = {.done = (size_t)done, .total = (size_t)total, .has_best = !isnan(best), .best = best};
    for (unsigned phase = 0; phase < QG_PHASE_COUNT; phase++)
        if (strcmp(qg_phase_name(phase), qg_string_at(progress, "phase")) == 0)
            shown.phase = phase;
    qg_bar_update(bar, &shown, QG_OBJECTIVE_F_DTE); /* the daemon's figures have their unit already */
}

/* What is known of a job between two calls. */
struct watch {
    struct qg_bar bar;
    char etag[128], state[24];
};

/* Takes in one answer. Returns -1 while the job goes on, else the exit status. */
static int take_job(struct watch *watch, const char *id, const struct qg_answer *answer) {
    cJSON *job = qg_parse(answer);
    const char *state = qg_string_at(job, "state"), *error = qg_string_at(job, "error");
    int status = strcmp(state, "succeeded") == 0                                   ? QG_EXIT_DONE
                 : strcmp(state, "failed") == 0 || strcmp(state, "cancelled") == 0 ? QG_EXIT_FAILED
                                                                                   : -1;
    if (!*state)
        status = qg_say_strange(id);
    snprintf(watch->etag, sizeof watch->etag, "%s", answer->etag);
    show_progress(&watch->bar, job);
    if (*state && strcmp(state, watch->state) != 0) {
        qg_bar_finish(&watch->bar);
        snprintf(watch->state, sizeof watch->state, "%s", state);
        qg_print_fault(id, "", state);
        if (*error)
            qg_print_fault(id, "", error);
    }
    cJSON_Delete(job);
    return status;
}

/* Asks once, for what differs from the last answer. Returns as take_job. */
static int watch_once(struct watch *watch, const struct qg_options *options) {
    struct qg_answer answer = {0};
    char known[160];
    struct qg_call call = {.path = "/v1/jobs/", .id = options->subject};
    snprintf(known, sizeof known, "If-None-Match: %s", watch->etag);
    if (watch->etag[0]) {
        call.headers[0] = known;
        call.headers[1] = "Prefer: wait=30";
    }
    int status = qg_ask(options, options->subject, call, &answer);
    if (status == QG_EXIT_DONE)
        status = answer.status == 304 ? -1 : take_job(watch, options->subject, &answer);
    qg_answer_finish(&answer);
    return status;
}

int qg_command_watch(const struct qg_options *options) {
    const struct timespec pause = {.tv_nsec = 200000000}; /* a job at work changes all the time */
    struct watch watch = {0};
    int status;
    qg_bar_init(&watch.bar, isatty(STDERR_FILENO) ? stderr : NULL);
    while ((status = watch_once(&watch, options)) < 0)
        nanosleep(&pause, NULL);
    qg_bar_finish(&watch.bar);
    return status;
}

/* result, cancel */

int qg_command_result(const struct qg_options *options) {
    struct qg_output output;
    struct qg_answer answer = {0};
    const struct qg_call call = {.path = "/v1/jobs/", .id = options->subject, .tail = "/result"};
    if (!qg_output_open(&output, options->result_path)) {
        fprintf(stderr, "%s: %s\n", options->result_path, strerror(errno));
        return QG_EXIT_FAILED;
    }
    int status = qg_ask(options, options->subject, call, &answer);
    if (status == QG_EXIT_DONE)
        status = answer.body.length ? qg_deliver(&answer.body, &output) : qg_say_strange(options->subject);
    qg_output_discard(&output);
    qg_answer_finish(&answer);
    return status;
}

int qg_command_cancel(const struct qg_options *options) {
    struct qg_answer answer = {0};
    const struct qg_call call = {.path = "/v1/jobs/", .id = options->subject, .tail = "/cancel", .post = true};
    const int status = qg_ask(options, options->subject, call, &answer);
    qg_answer_finish(&answer);
    return status;
}
