/* The example documents. See examples.h.
 *
 * GET /v1/examples         {"examples": [{"name", "kind", "title", "links": {"self"}}]}, in the order of the names. They are
 *                          read anew for each request, so what is put into the directory is offered; a file that is no
 *                          valid document is left out, and the log says so.
 * GET /v1/examples/{name}  the document as it lies there, to be edited and submitted.
 */
#include "server/calls/examples.h"

#include <dirent.h>
#include <errno.h>
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

/* Names of documents, to be freed one by one and as a whole. */
struct names {
    char **item;
    size_t count;
    bool failed; /* memory was short */
};

static bool add_name(struct names *names, const char *name) {
    char **grown = realloc(names->item, (names->count + 1) * sizeof *names->item);
    if (!grown)
        return false;
    names->item = grown;
    grown[names->count] = strdup(name);
    return grown[names->count] && ++names->count;
}

/* The names of a directory's documents in order. */
static struct names list_names(const char *path) {
    struct names names = {0};
    struct dirent *entry;
    DIR *directory = opendir(path);
    if (!directory)
        names.failed = errno == ENOMEM;
    while (directory && (entry = readdir(directory)))
        if (is_document_name(entry) && !add_name(&names, entry->d_name))
            names.failed = true;
    if (directory)
        closedir(directory);
    if (names.count > 0)
        qsort(names.item, names.count, sizeof *names.item, by_name);
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
    struct qg_job *job = NULL;
    if (!qg_served_file(path, file, &document))
        text->failed |= document.failed;
    else
        text->failed |= qg_text_document(&document, &job) == QG_DOCUMENT_NO_MEMORY;
    if (job)
        write_entry(text, file, job);
    else if (!text->failed)
        qg_log(QG_LOG_WARNING, "an example is left out: it is no valid document, or has a strange name");
    free(job);
    qg_text_finish(&document);
}

static void directory_of(const struct qg_service *service, char path[PATH_MAX]) {
    snprintf(path, PATH_MAX, "%s/examples", service->schema_dir);
}

void qg_list_examples(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    char path[PATH_MAX];
    if (!qg_request_has_no_query(request, reply))
        return;
    directory_of(service, path);
    struct names names = list_names(path);
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "examples");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < names.count; i++) {
        write_example(&reply->body, path, names.item[i]);
        free(names.item[i]);
    }
    free(names.item);
    reply->body.failed |= names.failed; /* and then it is answered so */
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
    if (length >= (int)sizeof file || (!qg_served_file(path, file, &reply->body) && !reply->body.failed)) {
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such example");
        return;
    }
    reply->status = 200;
    reply->media_type = JSON;
    qg_reply_header(reply, "Cache-Control", "no-cache");
}
