/* Speaking to a daemon. See daemon.h. */
#include "cli/daemon.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/files.h"
#include "cli/words.h"

/* What an environment variable says; NULL when it is not set, or empty. */
static const char *environment(const char *name) {
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

/* The address of the daemon. */
static const char *server_of(const struct qg_options *options) {
    const char *named = options->server ? options->server : environment("QUIETGEAR_SERVER");
    return named ? named : "http://127.0.0.1:8080";
}

const char *qg_string_at(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsString(item) ? item->valuestring : "";
}

double qg_number_at(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

cJSON *qg_parse(const struct qg_answer *answer) {
    return answer->body.length ? cJSON_ParseWithLength(answer->body.data, answer->body.length) : NULL;
}

/* Prints a problem document about `subject`, fault by fault. Returns the exit status. */
static int print_problem(const char *subject, const struct qg_answer *answer) {
    char status[32];
    cJSON *problem = qg_parse(answer);
    const cJSON *errors = cJSON_GetObjectItemCaseSensitive(problem, "errors"), *fault;
    snprintf(status, sizeof status, "HTTP status %ld", answer->status);
    cJSON_ArrayForEach(fault, errors) {
        qg_print_fault(subject, qg_string_at(fault, "pointer"), qg_string_at(fault, "detail"));
    }
    if (cJSON_GetArraySize(errors) == 0) {
        const char *title = qg_string_at(problem, "title"), *detail = qg_string_at(problem, "detail");
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

enum { TOKEN_BYTES_MAX = 200 };

/* Reads the first word of a file. False when there is none, said. */
static bool read_token_file(const char *file, struct qg_text *header) {
    size_t length;
    char *bytes = qg_file_read(file, TOKEN_BYTES_MAX, &length);
    if (!bytes) {
        fprintf(stderr, "%s: %s\n", file, strerror(errno));
        return false;
    }
    size_t start = 0, end;
    while (start < length && strchr(" \t\r\n", bytes[start]))
        start++;
    for (end = start; end < length && bytes[end] > ' ' && bytes[end] < 0x7f;)
        end++;
    bool found = end > start && length <= TOKEN_BYTES_MAX;
    if (found)
        qg_text_format(header, "Authorization: Bearer %.*s", (int)(end - start), bytes + start);
    else
        fprintf(stderr, "%s: holds no access token\n", file);
    free(bytes);
    return found;
}

/* Writes the Authorization line, if there is a token. False when the token cannot be had. */
static bool write_authorization(const struct qg_options *options, struct qg_text *header) {
    const char *token = environment("QUIETGEAR_TOKEN"), *file = environment("QUIETGEAR_TOKEN_FILE");
    if (options->token_file)
        return read_token_file(options->token_file, header);
    if (token) {
        bool plain = token[strcspn(token, " \t\r\n")] == '\0';
        if (!plain)
            fputs("quietgear: $QUIETGEAR_TOKEN holds a blank, which no access token does\n", stderr);
        qg_text_format(header, "Authorization: Bearer %s", token);
        return plain;
    }
    return !file || read_token_file(file, header);
}

int qg_ask(const struct qg_options *options, const char *subject, struct qg_call call, struct qg_answer *answer) {
    struct qg_text header = {0};
    call.server = server_of(options);
    call.ca_file = options->ca_file ? options->ca_file : environment("QUIETGEAR_CA_FILE");
    if (!write_authorization(options, &header)) {
        qg_text_finish(&header);
        return QG_EXIT_WRONG_INPUT;
    }
    call.authorization = header.data;
    bool answered = qg_http_call(&call, answer);
    qg_text_finish(&header);
    if (!answered) {
        fprintf(stderr, "quietgear: %s: ", call.server);
        qg_print_plain(answer->failure);
        fputc('\n', stderr);
        return QG_EXIT_FAILED;
    }
    return answer->status >= 200 && answer->status <= 304 ? QG_EXIT_DONE : print_problem(subject, answer);
}

int qg_say_strange(const char *subject) {
    fprintf(stderr, "quietgear: %s: the answer is not that of a quietgeard\n", qg_shown_name(subject));
    return QG_EXIT_FAILED;
}
