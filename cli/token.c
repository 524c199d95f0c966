/* quietgear token: makes, lists and revokes a daemon's access tokens, by its public calls and with an admin token. */
#include <stdio.h>
#include <string.h>

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

static int create(const struct qg_options *options) {
    struct qg_answer answer = {0};
    struct qg_text body = {0};
    if (!options->argument)
        return refuse("create: the name of the token is missing");
    qg_json_open(&body, '{');
    qg_json_name(&body, "name");
    qg_json_string(&body, options->argument);
    qg_json_name(&body, "scopes");
    write_scopes(&body, options->scopes ? options->scopes : "read,submit");
    qg_json_close(&body, '}');
    const struct qg_call call = {.path = "/v1/tokens", .post = true, .body = body.data, .body_length = body.length};
    int status = body.failed ? QG_EXIT_FAILED : qg_ask(options, "token", call, &answer);
    if (status == QG_EXIT_DONE)
        status = print_token(&answer);
    qg_text_finish(&body);
    qg_answer_finish(&answer);
    return status;
}

/* token list */

/* One line of the list: id, scopes, time, name. */
static void print_row(const cJSON *token) {
    const cJSON *scopes = cJSON_GetObjectItemCaseSensitive(token, "scopes"), *scope;
    char words[64] = "";
    cJSON_ArrayForEach(scope, scopes) {
        size_t used = strlen(words);
        if (cJSON_IsString(scope))
            snprintf(words + used, sizeof words - used, "%s%s", used ? "," : "", scope->valuestring);
    }
    printf("%-12s  %-17s  %-24s  %s\n", qg_string_at(token, "id"), words, qg_string_at(token, "created_at"),
           qg_string_at(token, "name"));
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
    if (options->scopes && strcmp(deed, "create") != 0)
        return refuse("the option --scopes goes with create only");
    if (lists && options->argument)
        return refuse("list takes no further word");
    if (strcmp(deed, "create") == 0)
        return create(options);
    if (strcmp(deed, "revoke") == 0)
        return revoke(options);
    return lists ? list(options) : refuse("allowed are create NAME, list and revoke ID");
}
