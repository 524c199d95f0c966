/* HTTP: the one place that knows libmicrohttpd.
 *
 * One internal thread with epoll serves all connections; handlers therefore never block for long, and long polls are
 * suspended (board.h). What libmicrohttpd 0.9.75 lets pass although RFC 9112 forbids it is refused here: a chunked body
 * together with a Content-Length, two Content-Length or Host fields, folded fields, NUL and dots in the path. Too large a body
 * is refused by its announced length, before a byte of it is read; a chunked one is read and dropped, up to 64 MiB, so that
 * its sender comes to read the answer. Requests meant for another server or sent by another site's page are refused
 * (origin.h). Connections are limited, and none can lock others out (guests.h). Malformed request lines and header lines,
 * lengths that are no numbers, and headers beyond 32 KiB are answered by libmicrohttpd itself, in its own words and not with
 * a problem document: it has no hook for that (docs/http_hostility.md lists them).
 *
 * Stopping: libmicrohttpd aborts the process when it is stopped with suspended connections. So the order is
 * qg_http_quiesce (no new connections), qg_board_shut (all sleepers wake and answer), qg_http_stop.
 */
#ifndef QG_SERVER_HTTP_HTTP_H
#define QG_SERVER_HTTP_HTTP_H

#include "server/http/exchange.h"

struct qg_http;

/* Serves on a listening socket, which it takes over. The service must outlive it. NULL when it cannot. */
struct qg_http *qg_http_start(const struct qg_service *service, int listen_socket);

/* Closes the listening socket; open connections live on. NULL is allowed. */
void qg_http_quiesce(struct qg_http *http);

/* Waits for suspended connections to wake (the board is shut) and, for two seconds at most, for answers under way; closes
 * all and frees. NULL is allowed. */
void qg_http_stop(struct qg_http *http);

#endif
