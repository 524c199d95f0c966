/* One HTTP call by libcurl.
 *
 * No redirects: a daemon has none. A proxy that the environment names is not used for addresses of this machine. An answer
 * may take as long as a long poll, but a connection has to come about in 10 s, and one that moves nothing for 90 s is dead.
 */
#include "cli/http.h"

#include <curl/curl.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli/files.h"

enum { CONNECT_TIMEOUT_S = 10, SILENCE_TIMEOUT_S = 90 };

/* Where a body goes. */
struct body {
    CURL *curl;
    const struct qg_call *call;
    struct qg_answer *answer;
};

/* Writes to a descriptor. False with words in the answer when that fails. */
static bool write_out(int descriptor, const char *bytes, size_t length, struct qg_answer *answer) {
    while (length > 0) {
        ssize_t written = write(descriptor, bytes, length);
        if (written < 0 && errno != EINTR) {
            snprintf(answer->failure, sizeof answer->failure, "the answer cannot be written: %s", strerror(errno));
            return false;
        }
        bytes += written > 0 ? written : 0;
        length -= written > 0 ? (size_t)written : 0;
    }
    return true;
}

static size_t take_body(char *bytes, size_t size, size_t count, void *to) {
    struct body *body = to;
    long status = 0;
    curl_easy_getinfo(body->curl, CURLINFO_RESPONSE_CODE, &status);
    if (body->call->sink && status == 200)
        return write_out(*body->call->sink, bytes, size * count, body->answer) ? size * count : 0;
    qg_text_add(&body->answer->body, bytes, size * count);
    return body->answer->body.failed ? 0 : size * count;
}

/* Keeps the value of a header line if it is the field of this name ("etag:"). Header lines are not NUL-terminated. */
static void keep_field(const char *line, size_t length, const char *name, char *out, size_t room) {
    const size_t skip = strlen(name);
    if (length <= skip || strncasecmp(line, name, skip) != 0)
        return;
    snprintf(out, room, "%.*s", (int)(length - skip), line + skip);
    out[strcspn(out, "\r\n")] = '\0';
    memmove(out, out + strspn(out, " "), strlen(out + strspn(out, " ")) + 1);
}

static size_t take_header(char *bytes, size_t size, size_t count, void *to) {
    struct qg_answer *answer = to;
    keep_field(bytes, size * count, "etag:", answer->etag, sizeof answer->etag);
    keep_field(bytes, size * count, "link:", answer->link, sizeof answer->link);
    return size * count;
}

/* Ends a long download when somebody wants the program to end. */
static int look_for_signals(void *self, curl_off_t all, curl_off_t now, curl_off_t all_up, curl_off_t now_up) {
    (void)self;
    (void)all;
    (void)now;
    (void)all_up;
    (void)now_up;
    return qg_is_to_end();
}

static bool is_here(const char *server) {
    static const char *const prefixes[] = {"http://127.",  "http://localhost",  "http://[::1]",
                                           "https://127.", "https://localhost", "https://[::1]"};
    for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++)
        if (strncmp(server, prefixes[i], strlen(prefixes[i])) == 0)
            return true;
    return false;
}

static struct curl_slist *header_list(const struct qg_call *call) {
    struct curl_slist *list = curl_slist_append(NULL, "Expect:"); /* no waiting for 100-continue */
    if (call->body)
        list = curl_slist_append(list, "Content-Type: application/json");
    if (call->authorization)
        list = curl_slist_append(list, call->authorization);
    for (size_t i = 0; i < sizeof call->headers / sizeof *call->headers; i++)
        if (call->headers[i])
            list = curl_slist_append(list, call->headers[i]);
    return list;
}

void qg_http_add_parameter(struct qg_text *path, const char *name, const char *value) {
    if (!value)
        return;
    char *escaped = curl_easy_escape(NULL, value, 0);
    if (escaped)
        qg_text_format(path, "&%s=%s", name, escaped);
    else
        path->failed = true;
    curl_free(escaped);
}

/* The whole address. False when memory is short. */
static bool write_address(CURL *curl, const struct qg_call *call, struct qg_text *address) {
    size_t length = strlen(call->server);
    while (length > 0 && call->server[length - 1] == '/')
        length--;
    qg_text_add(address, call->server, length);
    qg_text_format(address, "%s", call->path);
    if (call->id) {
        char *escaped = curl_easy_escape(curl, call->id, 0);
        address->failed = address->failed || !escaped;
        qg_text_format(address, "%s%s", escaped ? escaped : "", call->tail ? call->tail : "");
        curl_free(escaped);
    }
    return !address->failed;
}

static CURLcode perform(CURL *curl, const struct qg_call *call, struct qg_answer *answer) {
    struct qg_text address = {0};
    struct body body = {curl, call, answer};
    if (!write_address(curl, call, &address)) {
        qg_text_finish(&address);
        return CURLE_OUT_OF_MEMORY;
    }
    struct curl_slist *headers = header_list(call);
    curl_easy_setopt(curl, CURLOPT_URL, address.data);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, (long)CONNECT_TIMEOUT_S);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, call->patience ? call->patience : (long)SILENCE_TIMEOUT_S);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, take_body);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &body);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, take_header);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, answer);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, look_for_signals);
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, call->sink ? 0L : 1L);
    if (is_here(call->server))
        curl_easy_setopt(curl, CURLOPT_PROXY, "");
    if (call->ca_file)
        curl_easy_setopt(curl, CURLOPT_CAINFO, call->ca_file);
    if (call->delete)
        curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, "DELETE");
    if (call->post) {
        curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)call->body_length);
        curl_easy_setopt(curl, CURLOPT_POSTFIELDS, call->body ? call->body : "");
    }
    const CURLcode code = curl_easy_perform(curl);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &answer->status);
    curl_slist_free_all(headers);
    qg_text_finish(&address);
    return code;
}

bool qg_http_call(const struct qg_call *call, struct qg_answer *answer) {
    char words[CURL_ERROR_SIZE] = "";
    CURL *curl = curl_easy_init();
    CURLcode code = CURLE_FAILED_INIT;
    if (curl) {
        curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, words);
        code = perform(curl, call, answer);
        curl_easy_cleanup(curl);
    }
    if (code != CURLE_OK && !answer->failure[0])
        snprintf(answer->failure, sizeof answer->failure, "%s", words[0] ? words : curl_easy_strerror(code));
    return code == CURLE_OK;
}

void qg_answer_finish(struct qg_answer *answer) {
    qg_text_finish(&answer->body);
    *answer = (struct qg_answer){0};
}
