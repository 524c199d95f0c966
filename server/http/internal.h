/* What the parts of HTTP share: the server, and a request under way. For http.c, admit.c and send.c alone; they and stream.c are
 * the only files that know libmicrohttpd.
 */
#ifndef QG_SERVER_HTTP_INTERNAL_H
#define QG_SERVER_HTTP_INTERNAL_H

#include <microhttpd.h>

#include "server/http/guests.h"
#include "server/http/hold.h"
#include "server/http/nudge.h"
#include "server/http/routes.h"
#include "server/http/stream.h"

enum {
    QG_BODY_BYTES_MAX = QG_DOCUMENT_BYTES_MAX,
    QG_PATIENCE_BYTES =
        64 << 20 /* of a body that is too large: read and dropped, so that its sender reads the answer */
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

/* A request under way, from its request line to the end of its answer. */
struct qg_exchange {
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

/* A field of the request's header; NULL when it is absent. */
const char *qg_exchange_header(const struct qg_exchange *exchange, const char *name);

/* The clock of `arrived`. */
int64_t qg_now_us(void);

/* The address that a connection comes from; NULL when it has none. */
const struct sockaddr *qg_peer(struct MHD_Connection *connection);

/* Names who asks: the peer, or whom it asks for when it is a trusted proxy (forwarded.h). "" when that cannot be told. */
void qg_exchange_name_client(const struct qg_exchange *exchange, char out[QG_ADDRESS_ROOM]);

/* Refuses what can be refused by the header alone (admit.c): what two programs in a row could read differently, what was meant
 * for another server or comes from another site's page, what has no route, no right, a body that is not taken, or wants what
 * is not offered. True when the request may go on; else the reply says why. A preflight is answered by it as well. Fills in
 * the exchange's route and actor. */
bool qg_exchange_admit(struct qg_exchange *exchange, const char *method, const char *version, struct qg_reply *reply);

/* True when a body comes behind the header. */
bool qg_exchange_has_body(const struct qg_exchange *exchange);

/* Makes the reply the refusal of a body that is too large. */
void qg_refuse_size(struct qg_reply *reply);

/* Sends a reply and frees it (send.c); last: the connection is closed after it, because its rest cannot be trusted or read. */
enum MHD_Result qg_exchange_reply(struct qg_exchange *exchange, struct qg_reply *reply, bool last);

#endif
