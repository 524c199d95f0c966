/* Files from disk. See files.h. */
#include "server/calls/files.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILE_BYTES_MAX = 4 << 20 };

static bool is_plain_name(const char *name) {
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
    return *name && *name != '.' && name[strspn(name, allowed)] == '\0';
}

static bool read_all(int file, struct qg_text *text) {
    char block[16384];
    ssize_t length;
    while ((length = read(file, block, sizeof block)) > 0 && text->length < FILE_BYTES_MAX)
        qg_text_add(text, block, (size_t)length);
    return length == 0 && !text->failed;
}

/* Reads a regular file of a directory. */
static bool read_file(const char *directory, const char *name, struct qg_text *text) {
    int folder = open(directory, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0)
        return false;
    int file = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    close(folder);
    if (file < 0)
        return false;
    struct stat status;
    bool read = fstat(file, &status) == 0 && S_ISREG(status.st_mode) && read_all(file, text);
    close(file);
    return read;
}

bool qg_served_file(const char *directory, const char *name, struct qg_text *text) {
    return is_plain_name(name) && read_file(directory, name, text);
}

static void reply_file(struct qg_reply *reply, const char *directory, const char *name, const char *media_type) {
    if (!media_type || (!qg_served_file(directory, name, &reply->body) && !reply->body.failed)) {
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such file");
        return;
    }
    reply->status = 200;
    reply->media_type = media_type;
    qg_reply_header(reply, "Cache-Control", "no-cache");
}

static bool ends_in(const char *name, const char *suffix) {
    size_t length = strlen(name), tail = strlen(suffix);
    return length > tail && strcmp(name + length - tail, suffix) == 0;
}

void qg_get_page(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    (void)request;
    reply_file(reply, service->web_dir, "index.html", "text/html; charset=utf-8");
    qg_reply_header(
        reply, "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
        "img-src 'self' data: blob:; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
}

void qg_get_asset(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    const char *media_type = ends_in(request->parameter, ".css")   ? "text/css; charset=utf-8"
                             : ends_in(request->parameter, ".js")  ? "text/javascript; charset=utf-8"
                             : ends_in(request->parameter, ".svg") ? "image/svg+xml"
                                                                   : NULL;
    reply_file(reply, service->web_dir, request->parameter, media_type);
}

void qg_get_schema(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    const char *media_type = ends_in(request->parameter, ".json") ? request->media_type : NULL;
    reply_file(reply, service->schema_dir, request->parameter, media_type);
}

void qg_get_openapi(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    reply_file(reply, service->schema_dir, "openapi.json", request->media_type);
}
