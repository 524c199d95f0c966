/* The store's part on webhooks: subscriptions, and deliveries. See store.h for what holds for all of the store.
 *
 * A delivery is written by triggers of the database (store/format.c) in the very transaction that changes a job's state, one
 * for each webhook that wants to know; what it says is fixed then. So no change goes untold, whatever kills the daemon, and no
 * code that changes a state can forget it. What becomes of the attempts is written down after each; killed between the
 * receiver's answer and that note, the daemon sends again, with the same id: at least once.
 */
#ifndef QG_SERVER_STORE_WEBHOOKS_H
#define QG_SERVER_STORE_WEBHOOKS_H

#include "server/base/webhook.h"
#include "server/store/store.h"

/* Keeps a webhook, and who made it. QG_STORE_QUEUE_FULL when there are QG_WEBHOOKS_MAX. */
enum qg_store_status qg_store_webhook_add(struct qg_store *store, const struct qg_webhook *webhook,
                                          const struct qg_actor *actor);

/* Drops up to a few thousand deliveries of a webhook. QG_STORE_NOT_FOUND when it has none. */
enum qg_store_status qg_store_drop_deliveries(struct qg_store *store, const char *webhook);

/* Forgets a webhook with its deliveries. QG_STORE_NOT_FOUND when there is none of that id. */
enum qg_store_status qg_store_webhook_remove(struct qg_store *store, const char *id, const struct qg_actor *actor);

/* One webhook. */
enum qg_store_status qg_store_webhook(struct qg_store *store, const char *id, struct qg_webhook *out);

/* Copies the webhooks, oldest first, into out, room for QG_WEBHOOKS_MAX. */
enum qg_store_status qg_store_webhooks(struct qg_store *store, struct qg_webhook *out, size_t *count);

/* One delivery as its readers see it. Times in ms since 1970 UTC, 0 where there is none. */
struct qg_delivery {
    int64_t sequence;
    char id[QG_MESSAGE_ID_ROOM]; /* webhook-id, the same in all attempts */
    char event[24];
    char job[QG_JOB_ID_ROOM];
    char state[12]; /* "pending", "delivered", "failed" */
    int attempts;
    int64_t created_at, last_attempt_at, next_attempt_at;
    int last_status;      /* HTTP status of the last attempt, 0 when there was none */
    char last_error[200]; /* "" when there was none */
};

/* Up to `room` deliveries of a webhook, newest first, with a sequence below `before` (0: from the newest on). */
enum qg_store_status qg_store_deliveries(struct qg_store *store, const char *webhook, int64_t before, size_t room,
                                         struct qg_delivery *out, size_t *count);

/* --- the sender's side --- */

/* A delivery that is due. */
struct qg_dispatch {
    int64_t sequence;
    char id[QG_MESSAGE_ID_ROOM];
    char webhook[QG_WEBHOOK_ID_ROOM];
    char url[QG_URL_MAX + 1];
    char secret[QG_WEBHOOK_SECRET_ROOM];
    int attempts; /* before this one */
    char *body;   /* owned */
};

/* Frees what a dispatch owns. */
void qg_dispatch_finish(struct qg_dispatch *dispatch);

/* The oldest delivery that is due by `now`, of each webhook that has one: out has room for QG_WEBHOOKS_MAX, each of the
 * *count is to be finished by the caller. *next is when the next one will be due, INT64_MAX when none is waiting. */
enum qg_store_status qg_store_due(struct qg_store *store, int64_t now, struct qg_dispatch *out, size_t *count,
                                  int64_t *next);

/* How an attempt went. */
struct qg_outcome {
    int64_t at;        /* ms since 1970 UTC */
    bool delivered;    /* the receiver has taken it */
    bool gone;         /* the receiver wants no more: the webhook is disabled, what waits for it has failed */
    int64_t retry_at;  /* when neither: the next attempt; 0: given up */
    int status;        /* HTTP status, 0 without an answer */
    const char *error; /* words for people, NULL */
};

/* Writes down how an attempt at a delivery went. Nothing happens when the webhook is gone meanwhile. */
enum qg_store_status qg_store_attempted(struct qg_store *store, const struct qg_dispatch *dispatch,
                                        const struct qg_outcome *outcome);

/* Sets what is called after each commit that has written new deliveries, from the thread that committed and with the
 * writer's mutex held: it must not call the store. NULL: nothing. */
void qg_store_on_deliveries(struct qg_store *store, void (*call)(void *self), void *self);

#endif
