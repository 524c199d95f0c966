/* Refused attempts: which of them are news.
 *
 * Who tries doors is what an auditor wants to read; that somebody tries one a thousand times a second is not, and must not fill
 * the disk. So of each address and token one refusal an hour is news, of up to 64 of them; from whoever comes beyond those, one
 * an hour together. That is 1560 a day at the very most, whatever is thrown at the daemon.
 *
 * Nobody is locked out for guessing. A token's secret has 256 random bits, so guesses are hopeless at any rate; one costs the
 * daemon a SHA-256 of 32 bytes, less than to read the request; and a lock would also shut out those who share the address of
 * the one who guesses. How many requests were refused is in /metrics, by route and status.
 *
 * Threads: one at a time.
 */
#ifndef QG_SERVER_HTTP_REFUSALS_H
#define QG_SERVER_HTTP_REFUSALS_H

#include <stdbool.h>
#include <stdint.h>

#include "server/base/token.h"

enum { QG_REFUSALS_MAX = 64 };

/* Zeroed before use. */
struct qg_refusals {
    struct {
        char who[QG_ADDRESS_ROOM + QG_TOKEN_ID_ROOM];
        int64_t until; /* monotonic ms from which on this one is news again */
    } seen[QG_REFUSALS_MAX];
    int64_t others_until; /* likewise, for all whom there is no place for */
};

/* True when a refusal of the actor, of whom address and token count, is news at a time in monotonic ms. */
bool qg_refusal_is_news(struct qg_refusals *refusals, const struct qg_actor *actor, int64_t now);

#endif
