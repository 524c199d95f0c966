/* HTTP over libmicrohttpd. See http.h.
 *
 * The life of an exchange: on_uri makes it from the raw target (before libmicrohttpd decodes it); the first call of
 * on_request, with the header complete, refuses what can be refused without the body; further calls bring the body; the last
 * one asks the handler. A handler that has to wait is asked again when its connection has been resumed. on_completed frees.
 */
#include "server/http/http.h"

#include <microhttpd.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "server/base/address.h"
#include "server/base/log.h"
#include "server/http/access_log.h"
#include "server/http/authorize.h"
#include "server/http/cors.h"
#include "server/http/encode.h"
#include "server/http/forwarded.h"
#include "server/http/guests.h"
#include "server/http/nudge.h"
#include "server/http/origin.h"
#include "server/http/routes.h"
#include "server/http/stream.h"
#include "server/http/tls.h"
#include "server/work/metrics.h"

enum {
    CONNECTIONS_MAX = 2000,
    CONNECTIONS_SPARE = 200,    /* those put out that libmicrohttpd has not seen leave yet */
    DESCRIPTORS_ELSEWHERE = 64, /* database, sockets, files */
    IDLE_TIMEOUT_S = 30,        /* without a byte in either direction */
    PATIENCE_MS = 20000,        /* for a request to be complete once it has begun, and for it to begin */
    CONNECTION_MEMORY = 32 << 10,
    FAREWELL_MS = 2000, /* for answers under way when the daemon stops */
    BODY_BYTES_MAX = QG_DOCUMENT_BYTES_MAX,
    HELD_BYTES_MAX = 256 << 20, /* of bodies and answers, all clients together (hold.h) */
    SMALL_ANSWER = 4 << 10,     /* never refused: what says that something is */
    PATIENCE_BYTES = 64 << 20   /* of a body that is too large: read and dropped, so that its sender reads the answer */
};

struct qg_http {
    struct MHD_Daemon *daemon;
    const struct qg_service *service;
    atomic_int open; /* exchanges between their request line and the end of their answer */
    struct qg_sleepers sleepers;
    struct qg_hold hold;
    struct qg_guests *guests;
    struct qg_nudge *nudge;
};

/* One connection; it goes with its socket. */
struct visit {
    struct qg_guest *guest;
    struct qg_tls_pair *pair; /* that it serves; NULL without TLS */
};

struct exchange {
    struct qg_http *http;
    struct MHD_Connection *connection;
    struct qg_guest *guest;
    const char *fault; /* what is wrong with the target, NULL */
    const struct qg_route *route;
    struct qg_request request;
    int64_t arrived; /* monotonic us */
    size_t received; /* bytes of the body */
    size_t held;     /* of them in memory, taken from the hold */
    bool is_refused; /* the rest of the body is not kept: there is no room for it */
    bool begun;
    char method[12];           /* as sent, cut */
    int status;                /* of the answer; 0 before there is one */
    int64_t sent;              /* bytes of its body */
    struct qg_sleeper sleeper; /* of a long poll, as is the next */
    struct qg_presence poll;
};

static const char *header(const struct exchange *exchange, const char *name) {
    return MHD_lookup_connection_value(exchange->connection, MHD_HEADER_KIND, name);
}

static int64_t now_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

/* --- replies --- */

/* Takes what the reply holds; one that does not fit becomes a problem. Returns what was taken. */
static size_t hold_reply(struct exchange *exchange, struct qg_reply *reply) {
    struct qg_hold *hold = &exchange->http->hold;
    size_t bytes = qg_reply_bytes(reply);
    if (bytes > SMALL_ANSWER && qg_hold_take(hold, bytes))
        return bytes;
    if (bytes > SMALL_ANSWER) {
        qg_reply_finish(reply);
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
static bool add_cors_headers(struct MHD_Response *response, const struct exchange *exchange) {
    const char *origins = exchange->http->service->cors_origins, *origin = header(exchange, "Origin");
    if (*origins)
        MHD_add_response_header(response, "Vary", "Origin");
    if (!qg_cors_allows(origins, origin))
        return false;
    MHD_add_response_header(response, "Access-Control-Allow-Origin", origin);
    MHD_add_response_header(response, "Access-Control-Expose-Headers", "ETag, Link, Location, Retry-After");
    return true;
}

static void add_headers(struct MHD_Response *response, const struct exchange *exchange, const struct qg_reply *reply) {
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
static void refuse_crowd(const struct exchange *exchange, struct qg_reply *reply) {
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

/* Sends a reply and frees it; last: the connection is closed after it, because its rest cannot be trusted or read. */
static enum MHD_Result send_reply(struct exchange *exchange, struct qg_reply *reply, bool last) {
    if (reply->body.failed)
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory for the answer");
    if (reply->stream.self && reply->stream.endless)
        refuse_crowd(exchange, reply);
    if (qg_accepts_gzip(header(exchange, "Accept-Encoding")))
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
    qg_metrics_count(exchange->http->service->metrics, place, reply->status, now_us() - exchange->arrived);
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

/* --- what can be refused by the header alone --- */

/* How often the fields that frame a message occur, and what two programs may see differently in a field. */
struct framing {
    int hosts, lengths, encodings, authorizations;
    const char *fault;
};

/* True for a name that is another with something behind it: what libmicrohttpd 0.9.75 makes of "Name:", a line end, a blank
 * and a value (a folded line, which RFC 9112 forbids), while others read a value. */
static bool is_folded(const char *name, const char *known) {
    size_t length = strlen(known);
    return strncasecmp(name, known, length) == 0 && name[length];
}

static enum MHD_Result count_field(void *self, enum MHD_ValueKind kind, const char *name, size_t name_length,
                                   const char *value, size_t value_length) {
    (void)kind;
    struct framing *framing = self;
    framing->hosts += strcasecmp(name, "Host") == 0;
    framing->lengths += strcasecmp(name, "Content-Length") == 0;
    framing->encodings += strcasecmp(name, "Transfer-Encoding") == 0;
    framing->authorizations += strcasecmp(name, "Authorization") == 0;
    if (name[strcspn(name, " \t\r\n")] || strlen(name) != name_length)
        framing->fault = "the name of a header field holds a blank or a control character";
    else if (is_folded(name, "Host") || is_folded(name, "Content-Length") || is_folded(name, "Transfer-Encoding"))
        framing->fault = "a header field is folded, or has almost the name of one that frames the message";
    else if (value && (strlen(value) != value_length || value[strcspn(value, "\r\n")]))
        framing->fault = "the value of a header field holds a control character";
    return MHD_YES;
}

/* Refuses what two programs in a row could read differently. */
static bool check_framing(struct exchange *exchange, struct qg_reply *reply) {
    struct framing framing = {0};
    MHD_get_connection_values_n(exchange->connection, MHD_HEADER_KIND, count_field, &framing);
    const char *fault = exchange->fault;
    if (framing.fault)
        fault = framing.fault;
    else if (framing.hosts > 1)
        fault = "the Host field is given twice";
    else if (framing.authorizations > 1)
        fault = "the Authorization field is given twice";
    else if (framing.lengths > 1)
        fault = "the Content-Length field is given twice";
    else if (framing.lengths > 0 && framing.encodings > 0)
        fault = "Content-Length and Transfer-Encoding are given together";
    else if (framing.encodings > 1 ||
             (framing.encodings && strcasecmp(header(exchange, "Transfer-Encoding"), "chunked")))
        fault = "the only Transfer-Encoding understood is chunked";
    if (fault)
        qg_reply_problem(reply, QG_PROBLEM_MALFORMED, "%s", fault);
    return !fault;
}

/* Refuses a request that was meant for another server; see origin.h. HTTP/1.0, which no browser speaks, need not say. */
static bool check_host(struct exchange *exchange, const char *version, struct qg_reply *reply) {
    const char *host = header(exchange, "Host");
    if (!host && strcmp(version, "HTTP/1.0") == 0)
        return true;
    enum qg_host_verdict verdict =
        host ? qg_host_judge(host, exchange->http->service->allowed_hosts) : QG_HOST_MALFORMED;
    if (verdict == QG_HOST_MALFORMED)
        qg_reply_problem(reply, QG_PROBLEM_MALFORMED, "the Host field is missing, or is no name and port");
    else if (verdict == QG_HOST_FOREIGN)
        qg_reply_problem(reply, QG_PROBLEM_MISDIRECTED,
                         "found Host \"%.100s\"; numeric addresses, localhost and the names of the setting "
                         "allowed-hosts are served",
                         host);
    return verdict == QG_HOST_OURS;
}

/* Refuses what a page elsewhere makes its visitor's browser send. */
static bool check_origin(struct exchange *exchange, struct qg_reply *reply) {
    const char *origin = header(exchange, "Origin"), *site = header(exchange, "Sec-Fetch-Site");
    if (exchange->route->method == QG_GET)
        return true;
    const struct qg_service *service = exchange->http->service;
    bool ours = origin ? qg_origin_is_ours(origin, header(exchange, "Host"), service->allowed_hosts) ||
                             qg_cors_allows(service->cors_origins, origin)
                       : !site || strcasecmp(site, "same-origin") == 0 || strcasecmp(site, "none") == 0;
    if (!ours)
        qg_reply_problem(reply, QG_PROBLEM_CROSS_ORIGIN, "found %s \"%.100s\"; allowed is this server's own origin",
                         origin ? "Origin" : "Sec-Fetch-Site", origin ? origin : site);
    return ours;
}

static bool find_route(struct exchange *exchange, const char *method, struct qg_reply *reply) {
    char allow[QG_ALLOW_ROOM];
    exchange->route = qg_route_find(exchange->http->service->routes, &exchange->request.target, method,
                                    &exchange->request.parameter, allow);
    if (exchange->route)
        return true;
    if (*allow) {
        qg_reply_problem(reply, QG_PROBLEM_METHOD, "allowed are %s", allow);
        qg_reply_header(reply, "Allow", "%s", allow);
    } else {
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "nothing answers at this address");
    }
    return false;
}

static void refuse_size(struct qg_reply *reply) {
    qg_reply_problem(reply, QG_PROBLEM_TOO_LARGE, "a body may have up to %d bytes", (int)BODY_BYTES_MAX);
}

/* True for a body that is too large to be looked at: so large that it is not worth dropping, or not yet on its way. One that
 * is on its way is read and dropped first: a connection closed while its client still writes may lose the answer. */
static bool is_refused_at_once(const struct exchange *exchange) {
    const char *length = header(exchange, "Content-Length");
    const unsigned long long announced = length ? strtoull(length, NULL, 10) : 0;
    return announced > PATIENCE_BYTES || (announced > BODY_BYTES_MAX && header(exchange, "Expect"));
}

static bool check_body(struct exchange *exchange, struct qg_reply *reply) {
    if (is_refused_at_once(exchange)) {
        refuse_size(reply);
        return false;
    }
    const char *encoding = header(exchange, "Content-Encoding");
    if (encoding && strcasecmp(encoding, "identity") != 0) {
        qg_reply_problem(reply, QG_PROBLEM_ENCODING, "found Content-Encoding \"%.100s\"; send the body as it is",
                         encoding);
        qg_reply_header(reply, "Accept-Encoding", "identity");
        return false;
    }
    const char *type = header(exchange, "Content-Type");
    if (exchange->route->takes_document && !(type && qg_media_type_is(type, "application/json"))) {
        qg_reply_problem(reply, QG_PROBLEM_MEDIA_TYPE, "found \"%.100s\", needed is Content-Type: application/json",
                         type ? type : "");
        qg_reply_header(reply, "Accept-Post", "application/json");
        return false;
    }
    return true;
}

static bool negotiate(struct exchange *exchange, struct qg_reply *reply) {
    const char *const *offers = exchange->route->offers;
    if (!offers[0])
        return true;
    int offer = qg_negotiate(header(exchange, "Accept"), offers);
    if (offer < 0) {
        qg_reply_problem(reply, QG_PROBLEM_NOT_ACCEPTABLE, "to be had are %s%s%s", offers[0], offers[1] ? " and " : "",
                         offers[1] ? offers[1] : "");
        return false;
    }
    exchange->request.offer = offer;
    exchange->request.media_type = offers[offer];
    return true;
}

static bool has_body(const struct exchange *exchange) {
    return header(exchange, "Content-Length") || header(exchange, "Transfer-Encoding");
}

/* Answers a browser that asks whether a page of another origin may send a request: yes, when the origin is listed and the
 * address exists. False when it is no such question. */
static bool answer_preflight(struct exchange *exchange, const char *method, struct qg_reply *reply) {
    char allow[QG_ALLOW_ROOM];
    const char *wanted = header(exchange, "Access-Control-Request-Method");
    if (strcmp(method, "OPTIONS") != 0 || !wanted ||
        !qg_cors_allows(exchange->http->service->cors_origins, header(exchange, "Origin")))
        return false;
    qg_route_find(exchange->http->service->routes, &exchange->request.target, "", &exchange->request.parameter, allow);
    if (!*allow)
        return false;
    reply->status = 204;
    qg_reply_header(reply, "Access-Control-Allow-Methods", "%s", allow);
    qg_reply_header(reply, "Access-Control-Allow-Headers",
                    "Authorization, Content-Type, Idempotency-Key, If-None-Match, Last-Event-ID, Prefer");
    qg_reply_header(reply, "Access-Control-Max-Age", "600");
    return true;
}

/* The address that a connection comes from; NULL when it has none. */
static const struct sockaddr *peer_of(struct MHD_Connection *connection) {
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    return info ? info->client_addr : NULL;
}

/* Prints an address in numbers; "" for a family that has none. */
static void print_address(const struct sockaddr *address, char out[QG_ADDRESS_ROOM]) {
    socklen_t length = address->sa_family == AF_INET    ? sizeof(struct sockaddr_in)
                       : address->sa_family == AF_INET6 ? sizeof(struct sockaddr_in6)
                                                        : 0;
    if (length == 0 || getnameinfo(address, length, out, QG_ADDRESS_ROOM, NULL, 0, NI_NUMERICHOST) != 0)
        out[0] = '\0';
}

static enum MHD_Result add_forwarded(void *self, enum MHD_ValueKind kind, const char *name, const char *value) {
    (void)kind;
    if (strcasecmp(name, "X-Forwarded-For") == 0)
        qg_text_format(self, ", %s", value ? value : "");
    return MHD_YES;
}

/* Names who asks: the peer, or whom it asks for when it is a trusted proxy. */
static void name_client(const struct exchange *exchange, char out[QG_ADDRESS_ROOM]) {
    const char *proxies = exchange->http->service->trusted_proxies;
    const struct sockaddr *peer = peer_of(exchange->connection);
    struct sockaddr_storage client;
    struct qg_text forwarded = {0};
    out[0] = '\0';
    if (!peer)
        return;
    if (*proxies)
        MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, add_forwarded, &forwarded);
    qg_forwarded_client(peer, forwarded.data, proxies, &client);
    print_address((const struct sockaddr *)&client, out);
    qg_text_finish(&forwarded);
}

static bool authorize(struct exchange *exchange, struct qg_reply *reply) {
    name_client(exchange, exchange->request.actor.address);
    return qg_authorize(exchange->http->service, header(exchange, "Authorization"), exchange->route, &exchange->request,
                        reply);
}

/* The header is complete. */
static enum MHD_Result begin(struct exchange *exchange, const char *method, const char *version) {
    struct qg_reply reply = {0};
    exchange->begun = true;
    snprintf(exchange->method, sizeof exchange->method, "%s", method);
    if (!check_framing(exchange, &reply) || !check_host(exchange, version, &reply) ||
        answer_preflight(exchange, method, &reply) || !find_route(exchange, method, &reply) ||
        !check_origin(exchange, &reply) || !authorize(exchange, &reply) || !check_body(exchange, &reply) ||
        !negotiate(exchange, &reply)) {
        qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_ANSWERED);
        return send_reply(exchange, &reply, reply.status == 400 || has_body(exchange));
    }
    exchange->request.if_none_match = header(exchange, "If-None-Match");
    exchange->request.prefer = header(exchange, "Prefer");
    exchange->request.idempotency_key = header(exchange, "Idempotency-Key");
    exchange->request.last_event_id = header(exchange, "Last-Event-ID");
    return MHD_YES;
}

/* --- the body, and the answer --- */

/* Frees the body and gives back what it held. */
static void drop_body(struct exchange *exchange) {
    qg_text_finish(&exchange->request.body);
    qg_hold_give(&exchange->http->hold, exchange->held);
    exchange->held = 0;
}

/* Keeps a part of the body while there is room for it, and for nothing of one that is refused. */
static void keep_body(struct exchange *exchange, const char *data, size_t length) {
    if (exchange->received > BODY_BYTES_MAX || !qg_hold_take(&exchange->http->hold, length)) {
        drop_body(exchange);
        exchange->is_refused = true;
        return;
    }
    exchange->held += length;
    qg_text_add(&exchange->request.body, data, length);
}

static enum MHD_Result collect(struct exchange *exchange, const char *data, size_t length) {
    exchange->received += length;
    if (exchange->received > PATIENCE_BYTES)
        return MHD_NO;
    if (exchange->route->takes_document && !exchange->is_refused)
        keep_body(exchange, data, length);
    return MHD_YES;
}

/* Counts a long poll. False when the client holds as many as it may: then it is to be answered now. */
static bool stay(struct exchange *exchange) {
    bool stays = qg_poll_enter(&exchange->http->sleepers, &exchange->poll, &exchange->request.actor);
    exchange->request.wait.refused = !stays;
    return stays;
}

static enum MHD_Result answer(struct exchange *exchange) {
    struct qg_reply reply = {0};
    qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_ANSWERED);
    if (exchange->received > BODY_BYTES_MAX) {
        refuse_size(&reply);
        return send_reply(exchange, &reply, true);
    }
    if (exchange->is_refused || exchange->request.body.failed) {
        qg_reply_problem(&reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to take the body");
        return send_reply(exchange, &reply, true);
    }
    for (;;) {
        exchange->route->handler(exchange->http->service, &exchange->request, &reply);
        if (!reply.wait) {
            drop_body(exchange);
            if (exchange->route->method == QG_GET)
                qg_reply_revalidate(&reply, exchange->request.if_none_match);
            return send_reply(exchange, &reply, false);
        }
        bool may_wait = !reply.polls || stay(exchange),
             sleeps = may_wait &&
                      qg_sleep(&exchange->http->sleepers, &exchange->sleeper, exchange->connection, &reply.pause);
        qg_reply_finish(&reply);
        if (sleeps)
            return MHD_YES;
        reply = (struct qg_reply){0};
    }
}

/* --- libmicrohttpd's side --- */

/* The connection's TLS session. */
static void *session_of(struct MHD_Connection *connection) {
    return MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION)->tls_session;
}

/* NULL when there is no place, or no memory, for one more. */
static struct visit *arrive(struct qg_http *http, struct MHD_Connection *connection, int socket) {
    const struct sockaddr *peer = peer_of(connection);
    const bool is_proxy = peer && qg_address_is_listed(peer, http->service->trusted_proxies);
    struct visit *visit = calloc(1, sizeof *visit);
    if (visit)
        visit->guest = qg_guests_enter(http->guests, socket, is_proxy ? NULL : peer);
    if (!visit || !visit->guest) {
        free(visit);
        return NULL;
    }
    if (http->service->tls)
        visit->pair = qg_tls_serve(http->service->tls, session_of(connection));
    return visit;
}

static void leave(struct qg_http *http, struct MHD_Connection *connection, struct visit *visit) {
    if (!visit)
        return;
    qg_guests_leave(http->guests, visit->guest);
    if (visit->pair)
        qg_tls_release(http->service->tls, visit->pair, session_of(connection));
    free(visit);
}

static void on_connection(void *self, struct MHD_Connection *connection, void **visit,
                          enum MHD_ConnectionNotificationCode what) {
    struct qg_http *http = self;
    qg_nudge_count(http->nudge, what == MHD_CONNECTION_NOTIFY_CLOSED ? -1 : 1);
    if (what == MHD_CONNECTION_NOTIFY_CLOSED) {
        leave(http, connection, *visit);
        return;
    }
    int socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    *visit = arrive(http, connection, socket);
    if (!*visit)
        shutdown(socket, SHUT_RDWR);
}

/* libmicrohttpd takes the query apart after this call, for nobody, into memory of which it may not have enough; then it
 * closes the connection without a word. It gets an empty query to work on: the text is its own buffer. */
static void hide_query(const char *uri) {
    char *query = (char *)(uintptr_t)strchr(uri, '?');
    if (query)
        query[1] = '\0';
}

static void *on_uri(void *self, const char *uri, struct MHD_Connection *connection) {
    struct exchange *exchange = calloc(1, sizeof *exchange);
    if (!exchange)
        return NULL;
    exchange->http = self;
    exchange->arrived = now_us();
    const struct visit *visit = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context;
    exchange->guest = visit ? visit->guest : NULL;
    qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_ASKING);
    atomic_fetch_add(&exchange->http->open, 1);
    exchange->connection = connection;
    exchange->fault = qg_target_parse(&exchange->request.target, uri);
    hide_query(uri);
    return exchange;
}

static enum MHD_Result on_request(void *self, struct MHD_Connection *connection, const char *url, const char *method,
                                  const char *version, const char *data, size_t *length, void **context) {
    (void)self;
    (void)connection;
    (void)url;
    struct exchange *exchange = *context;
    if (!exchange)
        return MHD_NO;
    qg_awake(&exchange->http->sleepers, &exchange->sleeper);
    if (!exchange->begun)
        return begin(exchange, method, version);
    if (*length == 0)
        return answer(exchange);
    enum MHD_Result taken = collect(exchange, data, *length);
    *length = 0;
    return taken;
}

static void log_request(struct exchange *exchange, bool whole) {
    if (!*exchange->request.actor.address)
        name_client(exchange, exchange->request.actor.address);
    qg_log_visit(&(struct qg_visit){.request = &exchange->request,
                                    .route = exchange->route,
                                    .method = exchange->method,
                                    .status = exchange->status,
                                    .whole = whole,
                                    .bytes = exchange->sent,
                                    .duration_us = now_us() - exchange->arrived});
}

static void on_completed(void *self, struct MHD_Connection *connection, void **context,
                         enum MHD_RequestTerminationCode reason) {
    (void)self;
    (void)connection;
    struct exchange *exchange = *context;
    if (!exchange)
        return;
    if (exchange->http->service->logs_requests)
        log_request(exchange, reason == MHD_REQUEST_TERMINATED_COMPLETED_OK);
    qg_awake(&exchange->http->sleepers, &exchange->sleeper);
    qg_poll_leave(&exchange->http->sleepers, &exchange->poll);
    qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_SILENT);
    atomic_fetch_sub(&exchange->http->open, 1);
    drop_body(exchange);
    free(exchange);
    *context = NULL;
}

/* Leaves escapes as they are: target.c has read them, and libmicrohttpd would cut a string at %00. */
static size_t leave_escaped(void *self, struct MHD_Connection *connection, char *text) {
    (void)self;
    (void)connection;
    return strlen(text);
}

/* What libmicrohttpd has to say. That a client has left is no event: each tab that is closed leaves its stream. */
__attribute__((format(printf, 2, 0))) static void log_message(void *self, const char *format, va_list arguments) {
    static const char *const of_leaving[] = {"Failed to send ", "Connection socket is closed "};
    (void)self;
    struct qg_log_event event = {.priority = QG_LOG_INFO, .limit = format}; /* clients cause them at will */
    for (size_t i = 0; i < sizeof of_leaving / sizeof *of_leaving; i++)
        if (strncmp(format, of_leaving[i], strlen(of_leaving[i])) == 0)
            event.priority = QG_LOG_DEBUG;
    char words[QG_LOG_MESSAGE_ROOM];
    vsnprintf(words, sizeof words, format, arguments);
    qg_log_event(&event, "http: %s", words);
}

/* How many connections the process may have: fewer than we like when the limit of open files says so. */
static size_t count_places(void) {
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return CONNECTIONS_MAX / 4;
    if (limit.rlim_cur < limit.rlim_max) {
        limit.rlim_cur = limit.rlim_max;
        setrlimit(RLIMIT_NOFILE, &limit);
        getrlimit(RLIMIT_NOFILE, &limit);
    }
    rlim_t others = CONNECTIONS_SPARE + DESCRIPTORS_ELSEWHERE;
    if (limit.rlim_cur >= CONNECTIONS_MAX + others)
        return CONNECTIONS_MAX;
    return limit.rlim_cur > 2 * others ? (size_t)(limit.rlim_cur - others) : (size_t)limit.rlim_cur / 4;
}

static struct MHD_Daemon *start_daemon(struct qg_http *http, int listen_socket, size_t places) {
    const struct qg_tls *tls = http->service->tls;
    const struct MHD_OptionItem plain[] = {{MHD_OPTION_END, 0, NULL}},
                                secured[] = {
                                    {MHD_OPTION_HTTPS_MEM_CERT, 0,
                                     tls ? (void *)(uintptr_t)qg_tls_certificate_text(tls) : NULL},
                                    {MHD_OPTION_HTTPS_MEM_KEY, 0, tls ? (void *)(uintptr_t)qg_tls_key_text(tls) : NULL},
                                    {MHD_OPTION_HTTPS_PRIORITIES, 0, (void *)QG_TLS_PRIORITIES},
                                    {MHD_OPTION_END, 0, NULL}};
    return MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG | (tls ? MHD_USE_TLS : 0), 0, NULL,
        NULL, on_request, http, MHD_OPTION_EXTERNAL_LOGGER, log_message, NULL, MHD_OPTION_ARRAY, tls ? secured : plain,
        MHD_OPTION_LISTEN_SOCKET, listen_socket, MHD_OPTION_URI_LOG_CALLBACK, on_uri, http, MHD_OPTION_NOTIFY_COMPLETED,
        on_completed, http, MHD_OPTION_NOTIFY_CONNECTION, on_connection, http, MHD_OPTION_UNESCAPE_CALLBACK,
        leave_escaped, NULL, MHD_OPTION_STRICT_FOR_CLIENT, 0, /* it would refuse a missing Host in HTML: we do */
        MHD_OPTION_CONNECTION_LIMIT, (unsigned)(places + CONNECTIONS_SPARE), MHD_OPTION_CONNECTION_TIMEOUT,
        (unsigned)IDLE_TIMEOUT_S, MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CONNECTION_MEMORY, MHD_OPTION_END);
}

/* Frees what is there; the daemon, if any, is stopped first. */
static void finish(struct qg_http *http) {
    if (http->daemon)
        MHD_stop_daemon(http->daemon);
    qg_nudge_destroy(http->nudge);
    qg_guests_destroy(http->guests);
    free(http);
}

static bool start(struct qg_http *http, int listen_socket) {
    const struct qg_guests_rules rules = {
        .places = count_places(), .patience = PATIENCE_MS, .plain = !http->service->tls};
    http->guests = qg_guests_create(&rules);
    http->nudge = qg_nudge_create();
    if (!http->guests || !http->nudge)
        return false;
    http->daemon = start_daemon(http, listen_socket, rules.places);
    if (!http->daemon)
        return false;
    if (qg_nudge_join(http->nudge, MHD_get_daemon_info(http->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd))
        return true;
    MHD_quiesce_daemon(http->daemon); /* the socket stays the caller's */
    return false;
}

struct qg_http *qg_http_start(const struct qg_service *service, int listen_socket) {
    struct qg_http *http = calloc(1, sizeof *http);
    if (!http)
        return NULL;
    http->service = service;
    http->sleepers.board = service->board;
    http->sleepers.client_max = service->client_stream_max;
    http->sleepers.hold = &http->hold;
    http->hold.allowance = HELD_BYTES_MAX;
    if (start(http, listen_socket))
        return http;
    finish(http);
    return NULL;
}

void qg_http_quiesce(struct qg_http *http) {
    if (!http)
        return;
    MHD_socket listen_socket = MHD_quiesce_daemon(http->daemon);
    if (listen_socket != MHD_INVALID_SOCKET)
        close(listen_socket);
}

void qg_http_stop(struct qg_http *http) {
    if (!http)
        return;
    const struct timespec moment = {.tv_nsec = 5000000};
    int64_t patience = qg_monotonic_clock() + FAREWELL_MS;
    while (atomic_load(&http->sleepers.asleep) > 0 || (atomic_load(&http->open) > 0 && qg_monotonic_clock() < patience))
        nanosleep(&moment, NULL);
    finish(http);
}
