/* What a request asks for: the request target taken apart, and the small languages of a few header fields.
 *
 * libmicrohttpd decodes "%00" to an end of string and leaves ".." alone, so the raw target is read here instead, strictly:
 * a path of decoded segments and a query of decoded names and values, or a word on what is wrong.
 */
#ifndef QG_SERVER_HTTP_TARGET_H
#define QG_SERVER_HTTP_TARGET_H

#include <stdbool.h>
#include <stddef.h>

enum { QG_TARGET_ROOM = 2048, QG_SEGMENTS_MAX = 8, QG_QUERY_MAX = 16 };

/* A request target. The strings live in `storage`. */
struct qg_target {
    size_t segment_count; /* 0: the root "/" */
    const char *segment[QG_SEGMENTS_MAX];
    size_t query_count;
    struct {
        const char *name, *value;
    } query[QG_QUERY_MAX];
    char storage[QG_TARGET_ROOM];
};

/* Reads a raw target ("/v1/jobs?limit=5"). Refused: no leading slash, longer than the room, bad or NUL percent escapes,
 * control characters, what is no UTF-8, "." and ".." segments, encoded slashes, empty segments, too many segments or parameters.
 * Returns NULL, or what is wrong. Threads: any. */
const char *qg_target_parse(struct qg_target *target, const char *raw);

/* The value of a query parameter, NULL when absent. */
const char *qg_target_query(const struct qg_target *target, const char *name);

/* True when the query has only the named parameters, each at most once; otherwise *offender is the first other one. */
bool qg_target_query_is_among(const struct qg_target *target, const char *const *names, const char **offender);

/* Content negotiation (RFC 9110 12.5.1): the index of the best of the NULL-ended `offers` for an Accept field, the first
 * of equals; -1 when none is accepted. accept NULL takes everything. */
int qg_negotiate(const char *accept, const char *const *offers);

/* True when an If-None-Match field names the entity tag (given with its quotes; weak comparison), or is "*". */
bool qg_etag_matches(const char *if_none_match, const char *etag);

/* Seconds of "wait=N" in a Prefer field (RFC 7240): 1 to 86400; 0 when there is none, -1 when it is anything else. */
enum { QG_WAIT_MAX_S = 86400 };
int qg_prefer_wait(const char *prefer);

/* True when an Accept-Encoding field takes gzip; NULL does not. */
bool qg_accepts_gzip(const char *accept_encoding);

/* True when a Content-Type field's media type is `type`, whatever its parameters. */
bool qg_media_type_is(const char *content_type, const char *type);

#endif
