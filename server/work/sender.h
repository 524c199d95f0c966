/* The sender: one thread that delivers webhooks by libcurl, several at a time, one at a time to each receiver.
 *
 * It is woken by the store when a transaction has written deliveries, and by the clock when one is to be tried again. A
 * receiver takes a delivery by answering with a status from 200 to 299 within 15 s. Anything else is tried again after
 * first_wait seconds, then four times as long each time, 12 h at most, at least as long as Retry-After asks for; after 10
 * attempts, some 32 h with the default of 5 s, it is given up. 410 disables the webhook. Redirects are not followed, proxies
 * of the environment not used, and 64 KB of an answer at most are read and thrown away. Where a delivery may go is judged
 * anew for each attempt (address.h).
 *
 * Once an hour the thread also drops what the audit log and the finished deliveries have kept for too long.
 */
#ifndef QG_SERVER_WORK_SENDER_H
#define QG_SERVER_WORK_SENDER_H

#include "server/store/store.h"
#include "server/work/metrics.h"

struct qg_sender;

struct qg_sender_options {
    const char *rules, *networks; /* see address.h; borrowed for the sender's life */
    int first_wait;               /* s, >= 1 */
    int keep_log_days;            /* 0: forever */
    struct qg_metrics *metrics;   /* where attempts are counted, borrowed for the sender's life; NULL: nowhere */
    const char
        *resolve; /* NULL, or for tests the answer of a resolver, as CURLOPT_RESOLVE takes it: HOST:PORT:ADDRESS */
};

/* Starts the thread. The store must outlive the sender. NULL when it cannot. */
struct qg_sender *qg_sender_start(struct qg_store *store, const struct qg_sender_options *options);

/* Breaks off what is under way (it will be sent again), ends the thread and frees. NULL is allowed. */
void qg_sender_stop(struct qg_sender *sender);

/* Milliseconds to wait after the n-th attempt (from 1) has failed; 0: no further one. */
int64_t qg_sender_wait(int first_wait, int attempts);

#endif
