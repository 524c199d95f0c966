/* The memory that clients hold: bodies that are on their way in, answers on their way out.
 *
 * A client that sends slowly, or does not read what it has asked for, keeps a body or an answer in memory for as long as it is
 * allowed to stay. There are thousands of connections and answers of many megabytes, so all of them together have one
 * allowance; what does not fit is refused (status 503, Retry-After), and the connection is free for the next request.
 * One body or answer larger than what is left is let in all the same while the others hold no more than an eighth of the
 * allowance, so that each answer can be had, the large ones one at a time.
 *
 * Threads: any.
 */
#ifndef QG_SERVER_HTTP_HOLD_H
#define QG_SERVER_HTTP_HOLD_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

struct qg_hold {
    size_t allowance;   /* bytes, set once */
    atomic_size_t held; /* bytes */
};

/* Takes so many bytes of the allowance, to be given back; false when they do not fit. */
bool qg_hold_take(struct qg_hold *hold, size_t bytes);

/* Takes them whether they fit or not: for what is too small to be worth refusing. */
void qg_hold_force(struct qg_hold *hold, size_t bytes);

void qg_hold_give(struct qg_hold *hold, size_t bytes);

#endif
