/* Sleeping connections, and bodies that are made while they are sent.
 *
 * A connection that has nothing to say is suspended and put on the board, which resumes it (board.h): a long poll before its
 * answer has begun, an event stream in the middle of it. Suspended connections have no time-out in libmicrohttpd, and a
 * client that is gone is noticed only by writing to it: so a stream's pauses have deadlines, and it writes at each. A stream
 * is asked for its next piece only when the client has taken the last: a slow client costs one piece of memory and no more,
 * and one that takes nothing at all is closed by the connection's time-out.
 *
 * Of libmicrohttpd's traps: a reader that returns 0 without having been suspended would be asked again at once, for ever; and
 * the daemon must not be stopped while connections are suspended, so those are counted, from their suspension until they were
 * asked again or closed.
 */
#ifndef QG_SERVER_HTTP_STREAM_H
#define QG_SERVER_HTTP_STREAM_H

#include <microhttpd.h>
#include <stdatomic.h>

#include "server/http/exchange.h"
#include "server/http/hold.h"

/* The sleepers of one HTTP server. */
struct qg_sleepers {
    struct qg_board *board;
    atomic_int asleep;         /* suspended connections, and resumed ones that were not asked again yet */
    int client_max;            /* endless streams, and as many long polls, that one client may hold; 0: any number */
    int streams;               /* open endless streams; of the server's thread, as is the next */
    struct qg_presence *first; /* those streams, and the long polls, in no order */
    struct qg_hold *hold;      /* streams with an end take QG_STREAM_BYTES each */
};

/* Somebody who stays: an endless stream, or a long poll. */
struct qg_presence {
    char client[QG_ADDRESS_ROOM]; /* the token's id, or the address; "": nobody in particular */
    bool is_stream, is_here;
    struct qg_presence *next, *previous;
};

/* A connection's part; zeroed before its first sleep, and at the same address while it sleeps. */
struct qg_sleeper {
    struct qg_sleepers *sleepers;
    struct MHD_Connection *connection;
    bool asleep;
    struct qg_waiter waiter;
};

/* Suspends the connection for the pause; false when something has changed already and it has to look again instead. Called
 * from a callback of the connection's. */
bool qg_sleep(struct qg_sleepers *sleepers, struct qg_sleeper *sleeper, struct MHD_Connection *connection,
              const struct qg_pause *pause);

/* To be called whenever the connection is asked again, or is closed. */
void qg_awake(struct qg_sleepers *sleepers, struct qg_sleeper *sleeper);

/* What a stream with an end may hold on its way out: its reader's own state, a piece, and what gzip needs. */
enum { QG_STREAM_BYTES = 400 << 10 };

/* What a reply holds until its client has read it: the length of its text; of a stream with an end QG_STREAM_BYTES and what it
 * keeps; nothing of an endless one, which makes its pieces when they are taken. */
size_t qg_reply_bytes(const struct qg_reply *reply);

/* A response that sends the text, which it takes over (*text is emptied) and whose length, taken by the caller, it gives back
 * when it has been sent; NULL when memory is short: then both stay the caller's. */
struct MHD_Response *qg_text_response(struct qg_hold *hold, struct qg_text *text);

/* Whether one more endless stream may be opened. */
enum qg_stream_room { QG_STREAM_ROOM, QG_STREAM_NONE, QG_STREAM_NONE_FOR_CLIENT };

/* The same for an actor's: a client is a token, or an address without one. Called from the server's thread, as is the next. */
enum qg_stream_room qg_stream_room(const struct qg_sleepers *sleepers, const struct qg_actor *actor);

/* Counts a long poll of an actor's until it leaves; presence is zeroed before. False when the client holds as many as it may:
 * connections that wait for an answer are never put out, so those of one client must not fill all places. From the server's
 * thread, as is the next, which does nothing to who is not here. */
bool qg_poll_enter(struct qg_sleepers *sleepers, struct qg_presence *presence, const struct qg_actor *actor);
void qg_poll_leave(struct qg_sleepers *sleepers, struct qg_presence *presence);

/* A response that sends the stream of an actor, which it takes over (stream->self becomes NULL); NULL when memory is short:
 * then the stream stays the caller's. One with an end gives its bytes (qg_reply_bytes) back, which the caller has taken, when
 * it is done. What it sends is added to *bytes, until the request is completed. */
struct MHD_Response *qg_stream_response(struct qg_sleepers *sleepers, struct MHD_Connection *connection,
                                        const struct qg_actor *actor, struct qg_stream *stream, int64_t *bytes);

#endif
