/* Replies on their way out. See internal.h. */
#include <time.h>

#include "server/http/cors.h"
#include "server/http/encode.h"
#include "server/http/internal.h"
#include "server/work/metrics.h"

enum { SMALL_ANSWER = 4 << 10 }; /* bytes; never refused: what says that something is */

int64_t qg_now_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

/* Takes what the reply holds; one that does not fit becomes a problem. Returns what was taken. */
static size_t hold_reply(struct qg_exchange *exchange, struct qg_reply *reply) {
    struct qg_hold *hold = &exchange->http->hold;
    size_t bytes = qg_reply_bytes(reply);
    if (bytes > SMALL_ANSWER && qg_hold_take(hold, bytes))
        return bytes;
    if (bytes > SMALL_ANSWER) {
        qg_reply_finish(reply);
        reply->header_count = 0; /* they described the answer */
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE,
                         "other clients hold the memory that there is for answers: they have not read theirs yet");
        bytes = qg_reply_bytes(reply);
    }
    qg_hold_force(hold, bytes);
    return bytes;
}

/* What a browser is told of every answer: to trust its media type alone, to show it in no frame, to run nothing in it, and
 * to name its address to nobody. The page brings a policy of its own (files.c). */
static void add_security_headers(struct MHD_Response *response, const struct qg_reply *reply, bool shared) {
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    MHD_add_response_header(response, "Referrer-Policy", "no-referrer");
    MHD_add_response_header(response, "X-Frame-Options", "DENY");
    MHD_add_response_header(response, "Cross-Origin-Opener-Policy", "same-origin");
    MHD_add_response_header(response, "Cross-Origin-Resource-Policy", shared ? "cross-origin" : "same-origin");
    if (!qg_reply_header_value(reply, "Content-Security-Policy"))
        MHD_add_response_header(response, "Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
}

/* Lets a page of a listed origin read the answer. True when it is one. */
static bool add_cors_headers(struct MHD_Response *response, const struct qg_exchange *exchange) {
    const char *origins = exchange->http->service->cors_origins, *origin = qg_exchange_header(exchange, "Origin");
    if (*origins)
        MHD_add_response_header(response, "Vary", "Origin");
    if (!qg_cors_allows(origins, origin))
        return false;
    MHD_add_response_header(response, "Access-Control-Allow-Origin", origin);
    MHD_add_response_header(response, "Access-Control-Expose-Headers", "ETag, Link, Location, Retry-After");
    return true;
}

static void add_headers(struct MHD_Response *response, const struct qg_exchange *exchange,
                        const struct qg_reply *reply) {
    if (reply->media_type && reply->status != 304)
        MHD_add_response_header(response, "Content-Type", reply->media_type);
    add_security_headers(response, reply, add_cors_headers(response, exchange));
    bool varies = exchange->route && exchange->route->offers[0] && exchange->route->offers[1];
    MHD_add_response_header(response, "Vary", varies ? "Accept, Accept-Encoding" : "Accept-Encoding");
    if (reply->status == 503 && !qg_reply_header_value(reply, "Retry-After"))
        MHD_add_response_header(response, "Retry-After", "5");
    for (size_t i = 0; i < reply->header_count; i++)
        MHD_add_response_header(response, reply->header[i].name, reply->header[i].value);
}

/* Refuses an event stream when there are too many, of this client or of all. */
static void refuse_crowd(const struct qg_exchange *exchange, struct qg_reply *reply) {
    const struct qg_sleepers *sleepers = &exchange->http->sleepers;
    enum qg_stream_room room = qg_stream_room(sleepers, &exchange->request.actor);
    if (room == QG_STREAM_ROOM)
        return;
    qg_reply_finish(reply);
    if (room == QG_STREAM_NONE) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "%d event streams are open already: there is no room for more",
                         QG_STREAMS_MAX);
        return;
    }
    qg_reply_problem(reply, QG_PROBLEM_TOO_MANY_STREAMS,
                     "%d are open already, the most that one token, or one address without a token, may have",
                     sleepers->client_max);
    qg_reply_header(reply, "Retry-After", "10");
}

enum MHD_Result qg_exchange_reply(struct qg_exchange *exchange, struct qg_reply *reply, bool last) {
    if (reply->body.failed)
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory for the answer");
    if (reply->stream.self && reply->stream.endless)
        refuse_crowd(exchange, reply);
    if (qg_accepts_gzip(qg_exchange_header(exchange, "Accept-Encoding")))
        qg_reply_compress(reply);
    size_t held = hold_reply(exchange, reply);
    exchange->status = reply->status;
    exchange->sent = (int64_t)reply->body.length;
    struct MHD_Response *response = reply->stream.self
                                        ? qg_stream_response(&exchange->http->sleepers, exchange->connection,
                                                             &exchange->request.actor, &reply->stream, &exchange->sent)
                                        : qg_text_response(&exchange->http->hold, &reply->body);
    enum MHD_Result sent = MHD_NO;
    const struct qg_routes *routes = exchange->http->service->routes;
    size_t place = exchange->route ? (size_t)(exchange->route - routes->route) : routes->count;
    qg_metrics_count(exchange->http->service->metrics, place, reply->status, qg_now_us() - exchange->arrived);
    if (response) {
        add_headers(response, exchange, reply);
        if (last)
            MHD_add_response_header(response, "Connection", "close");
        sent = MHD_queue_response(exchange->connection, (unsigned)reply->status, response);
        MHD_destroy_response(response);
    } else {
        qg_hold_give(&exchange->http->hold, held);
    }
    qg_reply_finish(reply);
    return sent;
}
