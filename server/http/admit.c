/* What can be refused by a request's header alone. See internal.h. */
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "server/base/address.h"
#include "server/http/authorize.h"
#include "server/http/cors.h"
#include "server/http/forwarded.h"
#include "server/http/internal.h"
#include "server/http/origin.h"

const char *qg_exchange_header(const struct qg_exchange *exchange, const char *name) {
    return MHD_lookup_connection_value(exchange->connection, MHD_HEADER_KIND, name);
}

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
static bool check_framing(struct qg_exchange *exchange, struct qg_reply *reply) {
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
             (framing.encodings && strcasecmp(qg_exchange_header(exchange, "Transfer-Encoding"), "chunked")))
        fault = "the only Transfer-Encoding understood is chunked";
    if (fault)
        qg_reply_problem(reply, QG_PROBLEM_MALFORMED, "%s", fault);
    return !fault;
}

/* Refuses a request that was meant for another server; see origin.h. HTTP/1.0, which no browser speaks, need not say. */
static bool check_host(struct qg_exchange *exchange, const char *version, struct qg_reply *reply) {
    const char *host = qg_exchange_header(exchange, "Host");
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
static bool check_origin(struct qg_exchange *exchange, struct qg_reply *reply) {
    const char *origin = qg_exchange_header(exchange, "Origin"), *site = qg_exchange_header(exchange, "Sec-Fetch-Site");
    if (exchange->route->method == QG_GET)
        return true;
    const struct qg_service *service = exchange->http->service;
    bool ours = origin ? qg_origin_is_ours(origin, qg_exchange_header(exchange, "Host"), service->allowed_hosts) ||
                             qg_cors_allows(service->cors_origins, origin)
                       : !site || strcasecmp(site, "same-origin") == 0 || strcasecmp(site, "none") == 0;
    if (!ours)
        qg_reply_problem(reply, QG_PROBLEM_CROSS_ORIGIN, "found %s \"%.100s\"; allowed is this server's own origin",
                         origin ? "Origin" : "Sec-Fetch-Site", origin ? origin : site);
    return ours;
}

static bool find_route(struct qg_exchange *exchange, const char *method, struct qg_reply *reply) {
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

void qg_refuse_size(struct qg_reply *reply) {
    qg_reply_problem(reply, QG_PROBLEM_TOO_LARGE, "a body may have up to %d bytes", (int)QG_BODY_BYTES_MAX);
}

/* True for a body that is too large to be looked at: so large that it is not worth dropping, or not yet on its way. One that
 * is on its way is read and dropped first: a connection closed while its client still writes may lose the answer. */
static bool is_refused_at_once(const struct qg_exchange *exchange) {
    const char *length = qg_exchange_header(exchange, "Content-Length");
    const unsigned long long announced = length ? strtoull(length, NULL, 10) : 0;
    return announced > QG_PATIENCE_BYTES || (announced > QG_BODY_BYTES_MAX && qg_exchange_header(exchange, "Expect"));
}

static bool check_body(struct qg_exchange *exchange, struct qg_reply *reply) {
    if (is_refused_at_once(exchange)) {
        qg_refuse_size(reply);
        return false;
    }
    const char *encoding = qg_exchange_header(exchange, "Content-Encoding");
    if (encoding && strcasecmp(encoding, "identity") != 0) {
        qg_reply_problem(reply, QG_PROBLEM_ENCODING, "found Content-Encoding \"%.100s\"; send the body as it is",
                         encoding);
        qg_reply_header(reply, "Accept-Encoding", "identity");
        return false;
    }
    const char *type = qg_exchange_header(exchange, "Content-Type");
    if (exchange->route->takes_document && !(type && qg_media_type_is(type, "application/json"))) {
        qg_reply_problem(reply, QG_PROBLEM_MEDIA_TYPE, "found \"%.100s\", needed is Content-Type: application/json",
                         type ? type : "");
        qg_reply_header(reply, "Accept-Post", "application/json");
        return false;
    }
    return true;
}

static bool negotiate(struct qg_exchange *exchange, struct qg_reply *reply) {
    const char *const *offers = exchange->route->offers;
    if (!offers[0])
        return true;
    int offer = qg_negotiate(qg_exchange_header(exchange, "Accept"), offers);
    if (offer < 0) {
        qg_reply_problem(reply, QG_PROBLEM_NOT_ACCEPTABLE, "to be had are %s%s%s", offers[0], offers[1] ? " and " : "",
                         offers[1] ? offers[1] : "");
        return false;
    }
    exchange->request.offer = offer;
    exchange->request.media_type = offers[offer];
    return true;
}

bool qg_exchange_has_body(const struct qg_exchange *exchange) {
    return qg_exchange_header(exchange, "Content-Length") || qg_exchange_header(exchange, "Transfer-Encoding");
}

/* Answers a browser that asks whether a page of another origin may send a request: yes, when the origin is listed and the
 * address exists. False when it is no such question. */
static bool answer_preflight(struct qg_exchange *exchange, const char *method, struct qg_reply *reply) {
    char allow[QG_ALLOW_ROOM];
    const char *wanted = qg_exchange_header(exchange, "Access-Control-Request-Method");
    if (strcmp(method, "OPTIONS") != 0 || !wanted ||
        !qg_cors_allows(exchange->http->service->cors_origins, qg_exchange_header(exchange, "Origin")))
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

const struct sockaddr *qg_peer(struct MHD_Connection *connection) {
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

void qg_exchange_name_client(const struct qg_exchange *exchange, char out[QG_ADDRESS_ROOM]) {
    const char *proxies = exchange->http->service->trusted_proxies;
    const struct sockaddr *peer = qg_peer(exchange->connection);
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

static bool authorize(struct qg_exchange *exchange, struct qg_reply *reply) {
    qg_exchange_name_client(exchange, exchange->request.actor.address);
    return qg_authorize(exchange->http->service, qg_exchange_header(exchange, "Authorization"), exchange->route,
                        &exchange->request, reply);
}

bool qg_exchange_admit(struct qg_exchange *exchange, const char *method, const char *version, struct qg_reply *reply) {
    return check_framing(exchange, reply) && check_host(exchange, version, reply) &&
           !answer_preflight(exchange, method, reply) && find_route(exchange, method, reply) &&
           check_origin(exchange, reply) && authorize(exchange, reply) && check_body(exchange, reply) &&
           negotiate(exchange, reply);
}
