/* The example documents. See examples.h.
 *
 * GET /v1/examples         {"examples": [{"name", "kind", "title", "links": {"self"}}]}, in the order of the names. They are
 *                          read anew for each request, so what is put into the directory is offered; a file that is no
 *                          valid document is left out, and the log says so.
 * GET /v1/examples/{name}  the document as it lies there, to be edited and submitted.
 */
#include "server/calls/examples.h"

#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/log.h"
#include "server/base/member.h"
#include "server/calls/documents.h"
#include "server/calls/files.h"

#define JSON "application/json"
#define SUFFIX ".json"

static bool is_document_name(const struct dirent *entry) {
    size_t length = strlen(entry->d_name), tail = sizeof SUFFIX - 1;
    return length > tail && strcmp(entry->d_name + length - tail, SUFFIX) == 0;
}

static int by_name(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The names of a directory's documents in order, to be freed one by one and as a whole; *count of them. */
static char **list_names(const char *path, size_t *count) {
    char **names = NULL;
    struct dirent *entry;
    DIR *directory = opendir(path);
    *count = 0;
    while (directory && (entry = readdir(directory))) {
        char **grown = is_document_name(entry) ? realloc(names, (*count + 1) * sizeof *names) : NULL;
        if (!grown)
            continue;
        names = grown;
        if ((names[*count] = strdup(entry->d_name)))
            ++*count;
    }
    if (directory)
        closedir(directory);
    if (*count > 0)
        qsort(names, *count, sizeof *names, by_name);
    return names;
}

static void write_entry(struct qg_text *text, const char *file, const struct qg_job *job) {
    char name[NAME_MAX + 1], self[NAME_MAX + sizeof "/v1/examples/"];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(file) - (sizeof SUFFIX - 1)), file);
    snprintf(self, sizeof self, "/v1/examples/%s", name);
    qg_json_open(text, '{');
    qg_member_text(text, "name", name);
    qg_member_text(text, "kind", qg_kind_name(job->study.kind));
    qg_member_text(text, "title", *job->name ? job->name : name);
    qg_json_name(text, "links");
    qg_json_open(text, '{');
    qg_member_text(text, "self", self);
    qg_json_close(text, '}');
    qg_json_close(text, '}');
}

static void write_example(struct qg_text *text, const char *path, const char *file) {
    struct qg_text document = {0};
    struct qg_job *job = qg_served_file(path, file, &document) ? qg_text_document(&document) : NULL;
    if (job)
        write_entry(text, file, job);
    else
        qg_log(QG_LOG_WARNING, "an example is left out: it is no valid document, or has a strange name");
    free(job);
    qg_text_finish(&document);
}

static void directory_of(const struct qg_service *service, char path[PATH_MAX]) {
    snprintf(path, PATH_MAX, "%s/examples", service->schema_dir);
}

void qg_list_examples(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    char path[PATH_MAX];
    size_t count;
    if (!qg_request_has_no_query(request, reply))
        return;
    directory_of(service, path);
    char **names = list_names(path, &count);
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "examples");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < count; i++) {
        write_example(&reply->body, path, names[i]);
        free(names[i]);
    }
    free(names);
    qg_json_close(&reply->body, ']');
    qg_json_close(&reply->body, '}');
    reply->status = 200;
    reply->media_type = JSON;
    qg_reply_header(reply, "Cache-Control", "no-cache");
}

void qg_get_example(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    char path[PATH_MAX], file[NAME_MAX + 1];
    if (!qg_request_has_no_query(request, reply))
        return;
    directory_of(service, path);
    int length = snprintf(file, sizeof file, "%s" SUFFIX, request->parameter);
    if (length >= (int)sizeof file || !qg_served_file(path, file, &reply->body)) {
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such example");
        return;
    }
    reply->status = 200;
    reply->media_type = JSON;
    qg_reply_header(reply, "Cache-Control", "no-cache");
}
