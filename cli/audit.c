/* quietgear audit: prints what a daemon's audit log says of who did what, for its administrator.
 *
 * One line an entry, newest first: time, action, id of the token, address, subject, name of the token; "-" for what
 * there is none of. The
 * daemon looks at so many entries in one call and says where to go on; this goes on until there are enough.
 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/daemon.h"
#include "cli/words.h"

enum { LIMIT = 50, LIMIT_MAX = 1000000, PAGE = 500 };

/* A date stands for its beginning, in UTC. */
static void add_time(struct qg_text *path, const char *name, const char *value) {
    char whole[64];
    const bool is_date = value && strlen(value) == strlen("2030-12-31");
    snprintf(whole, sizeof whole, "%.40s%s", value ? value : "", is_date ? "T00:00:00Z" : "");
    qg_http_add_parameter(path, name, value ? whole : NULL);
}

static void write_path(struct qg_text *path, const struct qg_options *options, double cursor) {
    qg_text_format(path, "/v1/audit?limit=%d", PAGE);
    qg_http_add_parameter(path, "action", options->action);
    qg_http_add_parameter(path, "actor", options->actor);
    qg_http_add_parameter(path, "subject", options->about);
    qg_http_add_parameter(path, "address", options->address);
    add_time(path, "since", options->since);
    add_time(path, "until", options->until);
    if (cursor > 0)
        qg_text_format(path, "&cursor=%.0f", cursor);
}

static void print_word(const cJSON *entry, const char *key, int width) {
    const char *word = qg_string_at(entry, key);
    printf("%-*s  ", width, *word ? word : "-");
}

static void print_entry(const cJSON *entry) {
    print_word(entry, "at", 24);
    print_word(entry, "action", 16);
    print_word(entry, "token", 12);
    print_word(entry, "address", 15);
    print_word(entry, "subject", 26);
    printf("%s\n", *qg_string_at(entry, "name") ? qg_string_at(entry, "name") : "-");
}

/* Prints the page's entries, as many as are still wanted, which *wanted counts down. Returns an exit status. */
static int print_page(const struct qg_answer *answer, long *wanted) {
    cJSON *page = qg_parse(answer);
    const cJSON *entries = cJSON_GetObjectItemCaseSensitive(page, "entries"), *entry;
    int status = cJSON_IsArray(entries) ? QG_EXIT_DONE : qg_say_strange("audit");
    cJSON_ArrayForEach(entry, entries) {
        if (*wanted > 0) {
            print_entry(entry);
            --*wanted;
        }
    }
    cJSON_Delete(page);
    return status == QG_EXIT_DONE && fflush(stdout) != 0 ? QG_EXIT_FAILED : status;
}

/* Asks for one page; *cursor is where the next one begins, 0 when there is none. Returns an exit status. */
static int ask_page(const struct qg_options *options, long long *cursor, long *wanted) {
    struct qg_answer answer = {0};
    struct qg_text path = {0};
    write_path(&path, options, (double)*cursor);
    const struct qg_call call = {.path = path.data};
    int status = path.failed ? QG_EXIT_FAILED : qg_ask(options, "audit", call, &answer);
    if (status == QG_EXIT_DONE)
        status = print_page(&answer, wanted);
    const char *at = strstr(answer.link, "cursor=");
    *cursor = at ? strtoll(at + strlen("cursor="), NULL, 10) : 0;
    qg_text_finish(&path);
    qg_answer_finish(&answer);
    return status;
}

int qg_command_audit(const struct qg_options *options) {
    long wanted = LIMIT;
    long long cursor = 0;
    if (!qg_read_count("audit: --limit", options->limit, LIMIT_MAX, &wanted))
        return QG_EXIT_WRONG_INPUT;
    int status;
    do
        status = ask_page(options, &cursor, &wanted);
    while (status == QG_EXIT_DONE && wanted > 0 && cursor > 0);
    return status;
}
