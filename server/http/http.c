/* HTTP over libmicrohttpd. See http.h.
 *
 * The life of an exchange: on_uri makes it from the raw target (before libmicrohttpd decodes it); the first call of
 * on_request, with the header complete, refuses what can be refused without the body; further calls bring the body; the last
 * one asks the handler. A handler that has to wait is asked again when its connection has been resumed. on_completed frees.
 */
#include "server/http/http.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "server/base/address.h"
#include "server/base/log.h"
#include "server/http/access_log.h"
#include "server/http/encode.h"
#include "server/http/internal.h"
#include "server/http/tls.h"

enum {
    CONNECTIONS_MAX = 2000,
    CONNECTIONS_SPARE = 200,    /* those put out that libmicrohttpd has not seen leave yet */
    DESCRIPTORS_ELSEWHERE = 64, /* database, sockets, files */
    IDLE_TIMEOUT_S = 30,        /* without a byte in either direction */
    PATIENCE_MS = 20000,        /* for a request to be complete once it has begun, and for it to begin */
    CONNECTION_MEMORY = 32 << 10,
    FAREWELL_MS = 2000,         /* for answers under way when the daemon stops */
    HELD_BYTES_MAX = 256 << 20, /* of bodies and answers, all clients together (hold.h) */
};

/* One connection; it goes with its socket. */
struct visit {
    struct qg_guest *guest;
    struct qg_tls_pair *pair; /* that it serves; NULL without TLS */
};

/* --- the header --- */

/* The header is complete. */
static enum MHD_Result begin(struct qg_exchange *exchange, const char *method, const char *version) {
    struct qg_reply reply = {0};
    exchange->begun = true;
    snprintf(exchange->method, sizeof exchange->method, "%s", method);
    if (!qg_exchange_admit(exchange, method, version, &reply)) {
        qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_ANSWERED);
        return qg_exchange_reply(exchange, &reply, reply.status == 400 || qg_exchange_has_body(exchange));
    }
    exchange->request.if_none_match = qg_exchange_header(exchange, "If-None-Match");
    exchange->request.prefer = qg_exchange_header(exchange, "Prefer");
    exchange->request.idempotency_key = qg_exchange_header(exchange, "Idempotency-Key");
    exchange->request.last_event_id = qg_exchange_header(exchange, "Last-Event-ID");
    return MHD_YES;
}

/* --- the body, and the answer --- */

/* Frees the body and gives back what it held. */
static void drop_body(struct qg_exchange *exchange) {
    qg_text_finish(&exchange->request.body);
    qg_hold_give(&exchange->http->hold, exchange->held);
    exchange->held = 0;
}

/* Keeps a part of the body while there is room for it, and for nothing of one that is refused. */
static void keep_body(struct qg_exchange *exchange, const char *data, size_t length) {
    if (exchange->received > QG_BODY_BYTES_MAX || !qg_hold_take(&exchange->http->hold, length)) {
        drop_body(exchange);
        exchange->is_refused = true;
        return;
    }
    exchange->held += length;
    qg_text_add(&exchange->request.body, data, length);
}

static enum MHD_Result collect(struct qg_exchange *exchange, const char *data, size_t length) {
    exchange->received += length;
    if (exchange->received > QG_PATIENCE_BYTES)
        return MHD_NO;
    if (exchange->route->takes_document && !exchange->is_refused)
        keep_body(exchange, data, length);
    return MHD_YES;
}

/* Counts a long poll. False when the client holds as many as it may: then it is to be answered now. */
static bool stay(struct qg_exchange *exchange) {
    bool stays = qg_poll_enter(&exchange->http->sleepers, &exchange->poll, &exchange->request.actor);
    exchange->request.wait.refused = !stays;
    return stays;
}

static enum MHD_Result answer(struct qg_exchange *exchange) {
    struct qg_reply reply = {0};
    qg_guests_mark(exchange->http->guests, exchange->guest, QG_GUEST_ANSWERED);
    if (exchange->received > QG_BODY_BYTES_MAX) {
        qg_refuse_size(&reply);
        return qg_exchange_reply(exchange, &reply, true);
    }
    if (exchange->is_refused || exchange->request.body.failed) {
        qg_reply_problem(&reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to take the body");
        return qg_exchange_reply(exchange, &reply, true);
    }
    for (;;) {
        exchange->route->handler(exchange->http->service, &exchange->request, &reply);
        if (!reply.wait) {
            drop_body(exchange);
            if (exchange->route->method == QG_GET)
                qg_reply_revalidate(&reply, exchange->request.if_none_match);
            return qg_exchange_reply(exchange, &reply, false);
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
    const struct sockaddr *peer = qg_peer(connection);
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
    struct qg_exchange *exchange = calloc(1, sizeof *exchange);
    if (!exchange)
        return NULL;
    exchange->http = self;
    exchange->arrived = qg_now_us();
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
    struct qg_exchange *exchange = *context;
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

static void log_request(struct qg_exchange *exchange, bool whole) {
    if (!*exchange->request.actor.address)
        qg_exchange_name_client(exchange, exchange->request.actor.address);
    qg_log_visit(&(struct qg_visit){.request = &exchange->request,
                                    .route = exchange->route,
                                    .method = exchange->method,
                                    .status = exchange->status,
                                    .whole = whole,
                                    .bytes = exchange->sent,
                                    .duration_us = qg_now_us() - exchange->arrived});
}

static void on_completed(void *self, struct MHD_Connection *connection, void **context,
                         enum MHD_RequestTerminationCode reason) {
    (void)self;
    (void)connection;
    struct qg_exchange *exchange = *context;
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
