/* quietgear token: makes, lists and revokes a daemon's access tokens, by its public calls and with an admin token. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "cli/daemon.h"
#include "cli/words.h"

static int refuse(const char *words) {
    fprintf(stderr, "quietgear: token: %s\n", words);
    return QG_EXIT_WRONG_INPUT;
}

/* token create */

/* Writes "read,submit" as an array of strings. */
static void write_scopes(struct qg_text *body, const char *scopes) {
    qg_json_open(body, '[');
    for (;;) {
        char word[32];
        size_t length = strcspn(scopes, ",");
        snprintf(word, sizeof word, "%.*s", (int)length, scopes);
        qg_json_string(body, word); /* the daemon says what is wrong with it */
        if (!scopes[length])
            break;
        scopes += length + 1;
    }
    qg_json_close(body, ']');
}

/* Prints the token, the only time that it is to be seen. */
static int print_token(const struct qg_answer *answer) {
    cJSON *made = qg_parse(answer);
    const char *token = qg_string_at(made, "token");
    int status = QG_EXIT_DONE;
    if (!*token)
        status = qg_say_strange("token");
    else if (printf("%s\n", token) < 0 || fflush(stdout) != 0)
        status = QG_EXIT_FAILED;
    cJSON_Delete(made);
    return status;
}

static void write_count(struct qg_text *body, const char *name, long count) {
    if (count == 0)
        return;
    qg_json_name(body, name);
    qg_json_integer(body, count);
}

/* Writes the moment that lies so many days ahead, if any do. */
static void write_end(struct qg_text *body, long days) {
    char end[40];
    const time_t time_of_end = time(NULL) + days * 86400;
    struct tm utc;
    if (days == 0)
        return;
    gmtime_r(&time_of_end, &utc);
    strftime(end, sizeof end, "%Y-%m-%dT%H:%M:%SZ", &utc);
    qg_json_name(body, "expires_at");
    qg_json_string(body, end);
}

/* Writes the request for a token. False, and says why, when an option is wrong. */
static bool write_request(struct qg_text *body, const struct qg_options *options) {
    long days = 0, requests = 0, jobs = 0;
    if (!qg_read_count("token: --days", options->days, 36500, &days) ||
        !qg_read_count("token: --requests-per-minute", options->requests_per_minute, 6000000, &requests) ||
        !qg_read_count("token: --queued-jobs", options->queued_jobs, 100000, &jobs))
        return false;
    qg_json_open(body, '{');
    qg_json_name(body, "name");
    qg_json_string(body, options->argument);
    qg_json_name(body, "scopes");
    write_scopes(body, options->scopes ? options->scopes : "read,submit");
    write_end(body, days);
    write_count(body, "requests_per_minute", requests);
    write_count(body, "queued_jobs", jobs);
    qg_json_close(body, '}');
    return true;
}

static int create(const struct qg_options *options) {
    struct qg_answer answer = {0};
    struct qg_text body = {0};
    if (!options->argument)
        return refuse("create: the name of the token is missing");
    if (!write_request(&body, options)) {
        qg_text_finish(&body);
        return QG_EXIT_WRONG_INPUT;
    }
    const struct qg_call call = {.path = "/v1/tokens", .post = true, .body = body.data, .body_length = body.length};
    int status = body.failed ? QG_EXIT_FAILED : qg_ask(options, "token", call, &answer);
    if (status == QG_EXIT_DONE)
        status = print_token(&answer);
    qg_text_finish(&body);
    qg_answer_finish(&answer);
    return status;
}

/* token list */

/* A time of the list to the second; "-" for none. */
static void print_time(const cJSON *token, const char *key) {
    const char *time = qg_string_at(token, key);
    if (*time)
        printf("  %.19sZ", time);
    else
        printf("  %-20s", "-");
}

static void print_limit(const cJSON *token, const char *key, int width) {
    const double limit = qg_number_at(token, key);
    if (isnan(limit))
        printf("  %*s", width, "-");
    else
        printf("  %*.0f", width, limit);
}

/* One line of the list: id, scopes, made, expires, valid or expired, used, limits, name. */
static void print_row(const cJSON *token) {
    const cJSON *scopes = cJSON_GetObjectItemCaseSensitive(token, "scopes"), *scope;
    char words[64] = "";
    cJSON_ArrayForEach(scope, scopes) {
        size_t used = strlen(words);
        if (cJSON_IsString(scope))
            snprintf(words + used, sizeof words - used, "%s%s", used ? "," : "", scope->valuestring);
    }
    const bool is_over = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(token, "expired"));
    printf("%-12s  %-17s", qg_string_at(token, "id"), words);
    print_time(token, "created_at");
    print_time(token, "expires_at");
    printf("  %-7s", is_over ? "expired" : "valid");
    print_time(token, "last_used_at");
    print_limit(token, "requests_per_minute", 7);
    print_limit(token, "queued_jobs", 6);
    printf("  %s\n", qg_string_at(token, "name"));
}

static int list(const struct qg_options *options) {
    struct qg_answer answer = {0};
    const struct qg_call call = {.path = "/v1/tokens"};
    int status = qg_ask(options, "token", call, &answer);
    if (status == QG_EXIT_DONE) {
        cJSON *body = qg_parse(&answer);
        const cJSON *tokens = cJSON_GetObjectItemCaseSensitive(body, "tokens"), *token;
        cJSON_ArrayForEach(token, tokens) {
            print_row(token);
        }
        if (!cJSON_IsArray(tokens))
            status = qg_say_strange("token");
        else if (fflush(stdout) != 0)
            status = QG_EXIT_FAILED;
        cJSON_Delete(body);
    }
    qg_answer_finish(&answer);
    return status;
}

/* token revoke */

static int revoke(const struct qg_options *options) {
    struct qg_answer answer = {0};
    if (!options->argument)
        return refuse("revoke: the id of the token is missing; see quietgear token list");
    const struct qg_call call = {.path = "/v1/tokens/", .id = options->argument, .delete = true};
    const int status = qg_ask(options, options->argument, call, &answer);
    qg_answer_finish(&answer);
    return status;
}

int qg_command_token(const struct qg_options *options) {
    const char *deed = options->subject;
    const bool lists = strcmp(deed, "list") == 0;
    const bool wishes = options->scopes || options->days || options->requests_per_minute || options->queued_jobs;
    if (wishes && strcmp(deed, "create") != 0)
        return refuse("the options --scopes, --days, --requests-per-minute and --queued-jobs go with create only");
    if (lists && options->argument)
        return refuse("list takes no further word");
    if (strcmp(deed, "create") == 0)
        return create(options);
    if (strcmp(deed, "revoke") == 0)
        return revoke(options);
    return lists ? list(options) : refuse("allowed are create NAME, list and revoke ID");
}
