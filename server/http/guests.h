/* The open connections, and whose turn it is to go when there are too many or one takes too long.
 *
 * A connection that is silent, or whose request does not come to its end, costs a place; with places limited, a few hundred
 * such connections would lock everybody out. So: a request has to be complete within a time that no dripping of bytes
 * prolongs; a connection between requests may be silent for the same time; and when all places are taken, a newcomer gets
 * that of the connection that has waited longest between requests or in the middle of one. Connections that are being
 * answered are never put out. An address that holds half of all places makes room among its own, unless it is that of a trusted
 * proxy, which stands for many.
 *
 * A connection is put out by shutdown(2) on its socket, which the HTTP library sees as the client's leaving; so nothing of
 * the library's is touched from outside. One that was in the middle of a request is told so first (status 408), where the
 * socket carries plain HTTP.
 *
 * Threads: any; a mutex guards all. leave() has to be called before the socket is closed, so that its number cannot have
 * become another's.
 */
#ifndef QG_SERVER_HTTP_GUESTS_H
#define QG_SERVER_HTTP_GUESTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

struct qg_guests;
struct qg_guest;

/* What a connection is doing. */
enum qg_guest_state {
    QG_GUEST_SILENT,  /* between requests */
    QG_GUEST_ASKING,  /* its request line has come, the request is not complete */
    QG_GUEST_ANSWERED /* its request is complete, the answer is not */
};

struct qg_guests_rules {
    size_t places;    /* how many may be open */
    int64_t patience; /* ms for a request to be complete, and for a silence */
    bool plain;       /* the sockets carry plain HTTP, so a few words may be written to them */
};

/* Begins with none, and a thread that looks for those who take too long. NULL when memory or the thread cannot be had. */
struct qg_guests *qg_guests_create(const struct qg_guests_rules *rules);

/* Ends it. All guests must have left. NULL is allowed. */
void qg_guests_destroy(struct qg_guests *guests);

/* A connection came from an address, NULL: from nobody in particular; puts another one out when all places are taken. NULL
 * when there is no place: the caller closes it. */
struct qg_guest *qg_guests_enter(struct qg_guests *guests, int socket, const struct sockaddr *address);

/* It goes, its socket still being open. guest may be NULL. */
void qg_guests_leave(struct qg_guests *guests, struct qg_guest *guest);

/* What it does from now on. guest may be NULL. */
void qg_guests_mark(struct qg_guests *guests, struct qg_guest *guest, enum qg_guest_state state);

/* How many are there. */
size_t qg_guests_count(struct qg_guests *guests);

#endif
