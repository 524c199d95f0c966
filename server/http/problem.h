/* What can be wrong with a request: the one table of errors, and the RFC 9457 documents they become.
 *
 * `type` is "urn:quietgear:problem:" and the code; `title` and `status` come from the table; `detail` says what was found
 * and what to do about it; `errors` lists the faults of a job document, each with its JSON pointer.
 */
#ifndef QG_SERVER_HTTP_PROBLEM_H
#define QG_SERVER_HTTP_PROBLEM_H

#include "schema/document.h"
#include "schema/text.h"

/* name, HTTP status, code, title */
#define QG_PROBLEM_TABLE(X)                                                                                            \
    X(QG_PROBLEM_MALFORMED, 400, "malformed-request", "The request is malformed")                                      \
    X(QG_PROBLEM_NOT_JSON, 400, "not-json", "The body is not a well-formed JSON document")                             \
    X(QG_PROBLEM_PARAMETER, 400, "bad-parameter", "A query parameter or header field is wrong")                        \
    X(QG_PROBLEM_UNAUTHORIZED, 401, "unauthorized", "A valid access token is needed")                                  \
    X(QG_PROBLEM_FORBIDDEN, 403, "insufficient-scope", "The access token does not cover this")                         \
    X(QG_PROBLEM_CROSS_ORIGIN, 403, "cross-origin", "A page of another origin may not do this")                        \
    X(QG_PROBLEM_NOT_FOUND, 404, "not-found", "There is nothing here")                                                 \
    X(QG_PROBLEM_METHOD, 405, "method-not-allowed", "This cannot be done here")                                        \
    X(QG_PROBLEM_NOT_ACCEPTABLE, 406, "not-acceptable", "None of the accepted media types is to be had")               \
    X(QG_PROBLEM_TIMEOUT, 408, "request-timeout", "The request took too long to come")                                 \
    X(QG_PROBLEM_NOT_YET, 409, "not-available-yet", "There is none yet")                                               \
    X(QG_PROBLEM_WRONG_STATE, 409, "wrong-state", "The job's state does not allow this")                               \
    X(QG_PROBLEM_TOO_LARGE, 413, "too-large", "The body is too large")                                                 \
    X(QG_PROBLEM_MEDIA_TYPE, 415, "unsupported-media-type", "The body's media type is not supported")                  \
    X(QG_PROBLEM_ENCODING, 415, "unsupported-content-encoding", "The body's encoding is not supported")                \
    X(QG_PROBLEM_MISDIRECTED, 421, "misdirected-request", "This server does not go by that name")                      \
    X(QG_PROBLEM_INVALID_DOCUMENT, 422, "invalid-document", "The job document is not valid")                           \
    X(QG_PROBLEM_TOO_COSTLY, 422, "too-costly", "The job would take longer than this server allows")                   \
    X(QG_PROBLEM_TOO_MUCH_MEMORY, 422, "too-much-memory", "The job would take more memory than this server allows")    \
    X(QG_PROBLEM_KEY_REUSED, 422, "idempotency-key-reused", "This Idempotency-Key was used with another body")         \
    X(QG_PROBLEM_INVALID_BODY, 422, "invalid-body", "The body is not valid")                                           \
    X(QG_PROBLEM_TOO_MANY_REQUESTS, 429, "too-many-requests", "The access token makes too many requests")              \
    X(QG_PROBLEM_TOO_MANY_STREAMS, 429, "too-many-streams", "The client has too many event streams open")              \
    X(QG_PROBLEM_QUEUE_FULL, 429, "queue-full", "There are as many as there may be")                                   \
    X(QG_PROBLEM_INTERNAL, 500, "internal-error", "Something is wrong inside the server")                              \
    X(QG_PROBLEM_UNAVAILABLE, 503, "unavailable", "The server cannot do this now")                                     \
    X(QG_PROBLEM_STORAGE_FULL, 503, "storage-full", "There is no room left to store this")                             \
    X(QG_PROBLEM_STORAGE_READ_ONLY, 503, "storage-read-only", "Nothing can be stored now")                             \
    X(QG_PROBLEM_STORAGE_DAMAGED, 503, "storage-damaged", "The database is damaged")

#define QG_PROBLEM_NAME(name, status, code, title) name,
enum qg_problem_code { QG_PROBLEM_TABLE(QG_PROBLEM_NAME) QG_PROBLEM_COUNT };
#undef QG_PROBLEM_NAME

/* The table's columns for one problem. */
int qg_problem_status(enum qg_problem_code code);
const char *qg_problem_slug(enum qg_problem_code code);
const char *qg_problem_title(enum qg_problem_code code);

/* Writes the problem document. detail may be NULL: then there is none. faults (may be NULL) become `errors`. Threads: any. */
void qg_problem_write(struct qg_text *text, enum qg_problem_code code, const char *detail,
                      const struct qg_faults *faults);

#endif
