/* Who may do what: tokens in memory, their scopes and their rates. tokens live in the store as well (store/access.h); the
 * daemon alone changes them, so memory and store agree.
 *
 * Without a token a request from a daemon on loopback may read and submit, unless tokens are required there too; tokens,
 * webhooks and the audit log are for admin tokens always. The first one is made by the daemon itself and written to the
 * file admin.token of the state directory, readable by the daemon's user alone.
 *
 * Rates: a bucket per token that holds two seconds' worth of requests, but ten at least (or a minute's worth, where that is
 * less). A token that has expired opens nothing; it stays in the list, so that who wonders can see why, and is dropped when it
 * has been over for as long as the audit log is kept, or when its place is needed. When a token was last used is known to the
 * millisecond in memory, and in the store as of the last qg_access_tidy or close: no request waits for that. Threads: all functions from any, except open and
 * close. Lock order: access before store.
 */
#ifndef QG_SERVER_HTTP_ACCESS_H
#define QG_SERVER_HTTP_ACCESS_H

#include "server/base/token.h"
#include "server/store/store.h"

enum { QG_TOKENS_MAX = 1000 };

struct qg_access;

/* How access is guarded. */
struct qg_access_options {
    bool required; /* nothing but what is public without a token */
    int rate;      /* requests a second and token that has no limit of its own; 0: any number */
    int queue;     /* jobs queued or running at a time, likewise; 0: any number */
    int keep_days; /* how long expired tokens are kept; 0: for ever */
};

/* Reads the tokens from the store, which must outlive it. NULL when it cannot (logged). */
struct qg_access *qg_access_open(struct qg_store *store, const struct qg_access_options *options);

/* Keeps when tokens were last used, and frees it. NULL is allowed. */
void qg_access_close(struct qg_access *access);

/* Writes down when tokens were last used, and drops those that expired long ago: to be called now and then. */
void qg_access_tidy(struct qg_access *access);

/* Makes an admin token and writes it to the file admin.token in `directory`, when there is no admin token yet or `anew` is
 * set. False and a logged word when that fails. */
bool qg_access_bootstrap(struct qg_access *access, const char *directory, bool anew);

enum qg_verdict {
    QG_VERDICT_GRANTED,
    QG_VERDICT_NO_TOKEN,    /* none was sent, and one is needed */
    QG_VERDICT_WRONG_TOKEN, /* malformed, unknown or revoked */
    QG_VERDICT_OVER,        /* it has expired */
    QG_VERDICT_WRONG_SCOPE, /* known, but not for this */
    QG_VERDICT_TOO_MANY     /* its rate is used up */
};

/* Judges a request for one scope by its Authorization field (NULL: none) at a time in monotonic milliseconds. Fills in the
 * actor's token, name and scopes, except for QG_VERDICT_WRONG_TOKEN. *retry_after_s is set for QG_VERDICT_TOO_MANY. */
enum qg_verdict qg_access_judge(struct qg_access *access, const char *authorization, unsigned scope, int64_t now,
                                struct qg_actor *actor, int *retry_after_s);

/* Writes into the audit log, when it is news (refusals.h), that the actor was refused something: "GET /v1/tokens". */
void qg_access_refused(struct qg_access *access, const struct qg_actor *actor, const char *what);

/* Jobs that the token of an id may have queued or running at a time; 0: any number. */
int qg_access_queue_limit(struct qg_access *access, const char *id);

/* Makes a token with the name, scopes, limits and end given in it, fills in the rest and writes its text: the only time it
 * is to be had. QG_STORE_QUEUE_FULL when there are QG_TOKENS_MAX already. */
enum qg_store_status qg_access_create(struct qg_access *access, const struct qg_actor *actor, struct qg_token *token,
                                      char text[QG_TOKEN_ROOM]);

/* Revokes a token: from now on it opens nothing, and event streams that it has
 * opened end with their next event or heartbeat. */
enum qg_store_status qg_access_revoke(struct qg_access *access, const struct qg_actor *actor, const char *id);

/* True for "", no token, and for the id of one that is neither revoked nor over: for what goes on for long after its request. */
bool qg_access_is_live(struct qg_access *access, const char *id);

/* Copies the tokens, oldest first, into out (room for QG_TOKENS_MAX); returns how many. */
size_t qg_access_list(struct qg_access *access, struct qg_token *out);

#endif
