/* One HTTP call to a daemon, by libcurl. */
#ifndef QG_CLI_HTTP_H
#define QG_CLI_HTTP_H

#include <stdbool.h>
#include <stddef.h>

#include "schema/text.h"

/* What to ask. */
struct qg_call {
    const char *server; /* "http://127.0.0.1:8080" */
    const char *path;   /* "/v1/jobs/" and the like; what stands in `id` and `tail` is put behind it, the id escaped */
    const char *id, *tail; /* NULL: nothing */
    bool post, delete;
    const char *authorization; /* a whole header line; NULL: none */
    const char *ca_file;       /* PEM; NULL: the system's authorities */
    const char *body;          /* of a POST; sent as application/json */
    size_t body_length;
    const char *headers[3]; /* whole header lines; NULL where there is none */
    const int *sink;        /* descriptor that the body of a 200 is written to instead of the answer; NULL: none */
    long patience;          /* s without a byte after which the connection is dead; 0: 90 */
};

/* What came back; a zeroed struct is ready. */
struct qg_answer {
    long status;
    struct qg_text body;
    char etag[128];    /* "" when there was none */
    char link[2048];   /* the Link field, likewise */
    char failure[320]; /* why there is no answer */
};

/* Makes the call and waits for its end. False with `failure` set when no answer came. Threads: one at a time. */
bool qg_http_call(const struct qg_call *call, struct qg_answer *answer);

/* Appends "&name=value" to a path with a query, with the value escaped; nothing when it is NULL. */
void qg_http_add_parameter(struct qg_text *path, const char *name, const char *value);

/* Frees what the answer holds, and zeroes it. */
void qg_answer_finish(struct qg_answer *answer);

#endif
