/* quietgear submit, watch, result and cancel: the public calls of a daemon.
 *
 * What the daemon refuses it refuses in problem documents (RFC 9457); their faults are printed as those of `run` are, and
 * their status decides the exit status: the input is wrong (400, 404, 413, 415, 422), or else the call has failed.
 */
#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli/commands.h"
#include "cli/files.h"
#include "cli/http.h"
#include "cli/progress.h"
#include "cli/words.h"
#include "schema/document.h"

/* The address of the daemon. */
static const char *server_of(const struct qg_options *options) {
    const char *named = options->server ? options->server : getenv("QUIETGEAR_SERVER");
    return named && *named ? named : "http://127.0.0.1:8080";
}

/* The string at a key; "" when there is none. */
static const char *string_at(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsString(item) ? item->valuestring : "";
}

/* The number at a key; NaN when there is none. */
static double number_at(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static cJSON *parse(const struct qg_answer *answer) {
    return answer->body.length ? cJSON_ParseWithLength(answer->body.data, answer->body.length) : NULL;
}

/* Prints a problem document about `subject`, fault by fault. Returns the exit status. */
static int print_problem(const char *subject, const struct qg_answer *answer) {
    char status[32];
    cJSON *problem = parse(answer);
    const cJSON *errors = cJSON_GetObjectItemCaseSensitive(problem, "errors"), *fault;
    snprintf(status, sizeof status, "HTTP status %ld", answer->status);
    cJSON_ArrayForEach(fault, errors) {
        qg_print_fault(subject, string_at(fault, "pointer"), string_at(fault, "detail"));
    }
    if (cJSON_GetArraySize(errors) == 0) {
        const char *title = string_at(problem, "title"), *detail = string_at(problem, "detail");
        struct qg_text words = {0};
        qg_text_format(&words, "%s%s%s", *title ? title : status, *detail ? ": " : "", detail);
        qg_print_fault(subject, "", words.failed ? status : words.data);
        qg_text_finish(&words);
    }
    cJSON_Delete(problem);
    const long wrong[] = {400, 404, 413, 415, 422};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (answer->status == wrong[i])
            return QG_EXIT_WRONG_INPUT;
    return QG_EXIT_FAILED;
}

/* Makes a call about `subject`. Returns QG_EXIT_DONE for a status from 200 to 304, else says why not. */
static int ask(const char *subject, const struct qg_call *call, struct qg_answer *answer) {
    if (!qg_http_call(call, answer)) {
        fprintf(stderr, "quietgear: %s: ", call->server);
        qg_print_plain(answer->failure);
        fputc('\n', stderr);
        return QG_EXIT_FAILED;
    }
    return answer->status >= 200 && answer->status <= 304 ? QG_EXIT_DONE : print_problem(subject, answer);
}

static int say_strange(const char *subject) {
    fprintf(stderr, "quietgear: %s: the answer is not that of a quietgeard\n", qg_shown_name(subject));
    return QG_EXIT_FAILED;
}

/* submit */

/* Prints the id of the job in the answer. */
static int print_id(const char *subject, const struct qg_answer *answer) {
    cJSON *job = parse(answer);
    const char *id = string_at(job, "id");
    int status = QG_EXIT_DONE;
    if (!*id)
        status = say_strange(subject);
    else if (printf("%s\n", id) < 0 || fflush(stdout) != 0)
        status = QG_EXIT_FAILED;
    cJSON_Delete(job);
    return status;
}

int qg_command_submit(const struct qg_options *options) {
    struct qg_answer answer = {0};
    struct qg_text key = {0};
    struct qg_call call = {.server = server_of(options), .path = "/v1/jobs", .post = true};
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
    int status = ask(options->subject, &call, &answer);
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
    const double done = number_at(progress, "done"), total = number_at(progress, "total"),
                 best = number_at(progress, "best");
    if (!(done >= 0 && total > 0 && done <= total))
        return;
    struct qg_progress shown = {.done = (size_t)done, .total = (size_t)total, .has_best = !isnan(best), .best = best};
    for (unsigned phase = 0; phase < QG_PHASE_COUNT; phase++)
        if (strcmp(qg_phase_name(phase), string_at(progress, "phase")) == 0)
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
    cJSON *job = parse(answer);
    const char *state = string_at(job, "state"), *error = string_at(job, "error");
    int status = strcmp(state, "succeeded") == 0                                   ? QG_EXIT_DONE
                 : strcmp(state, "failed") == 0 || strcmp(state, "cancelled") == 0 ? QG_EXIT_FAILED
                                                                                   : -1;
    if (!*state)
        status = say_strange(id);
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
    struct qg_call call = {.server = server_of(options), .path = "/v1/jobs/", .id = options->subject};
    snprintf(known, sizeof known, "If-None-Match: %s", watch->etag);
    if (watch->etag[0]) {
        call.headers[0] = known;
        call.headers[1] = "Prefer: wait=30";
    }
    int status = ask(options->subject, &call, &answer);
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
    const struct qg_call call = {
        .server = server_of(options), .path = "/v1/jobs/", .id = options->subject, .tail = "/result"};
    if (!qg_output_open(&output, options->result_path)) {
        fprintf(stderr, "%s: %s\n", options->result_path, strerror(errno));
        return QG_EXIT_FAILED;
    }
    int status = ask(options->subject, &call, &answer);
    if (status == QG_EXIT_DONE)
        status = answer.body.length ? qg_deliver(&answer.body, &output) : say_strange(options->subject);
    qg_output_discard(&output);
    qg_answer_finish(&answer);
    return status;
}

int qg_command_cancel(const struct qg_options *options) {
    struct qg_answer answer = {0};
    const struct qg_call call = {
        .server = server_of(options), .path = "/v1/jobs/", .id = options->subject, .tail = "/cancel", .post = true};
    const int status = ask(options->subject, &call, &answer);
    qg_answer_finish(&answer);
    return status;
}
