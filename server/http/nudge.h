/* Nudges libmicrohttpd's thread, which else may fall asleep with work in its hands.
 *
 * libmicrohttpd 0.9.75 collects events by epoll_wait(2), 128 at once, and collects again before it acts on any when it has got
 * 128. That second call waits as long as the first would have. So when exactly 128 connections (or 256, ...) have something to
 * say at once, none of them is answered until something else happens or a connection times out, half a minute later; clients
 * that ask in step get there easily. So while there are that many connections, a thread makes something happen every 20 ms: it
 * writes to a descriptor in libmicrohttpd's own epoll set, whose event carries the pointer NULL, which libmicrohttpd passes
 * over.
 *
 * (To drive libmicrohttpd by MHD_run from a thread of ours, which never waits in there, was tried: then it spins on a connection
 * whose buffer is full of something that it cannot use, a chunk's extension after a long header, instead of refusing it.)
 *
 * Threads: any; a mutex guards all.
 */
#ifndef QG_SERVER_HTTP_NUDGE_H
#define QG_SERVER_HTTP_NUDGE_H

#include <stdbool.h>

struct qg_nudge;

/* Begins without connections, and its thread asleep. NULL when memory, a descriptor or the thread cannot be had. */
struct qg_nudge *qg_nudge_create(void);

/* Puts the descriptor into an epoll set. False when that fails. */
bool qg_nudge_join(const struct qg_nudge *nudge, int epoll);

/* A connection came (1) or went (-1). */
void qg_nudge_count(struct qg_nudge *nudge, int change);

/* Ends it. NULL is allowed. */
void qg_nudge_destroy(struct qg_nudge *nudge);

#endif
