/* The store's part on access: tokens and the audit log. See store.h for what holds for all of the store.
 */
#ifndef QG_SERVER_STORE_ACCESS_H
#define QG_SERVER_STORE_ACCESS_H

#include "server/base/token.h"
#include "server/store/store.h"

/* Copies the tokens, oldest first, into out, at most `room`. */
enum qg_store_status qg_store_tokens(struct qg_store *store, struct qg_token *out, size_t room, size_t *count);

/* Keeps a token, and who made it. */
enum qg_store_status qg_store_token_add(struct qg_store *store, const struct qg_token *token,
                                        const struct qg_actor *actor);

/* Forgets a token. QG_STORE_NOT_FOUND when there is none of that id. actor NULL: the daemon, because it expired long ago. */
enum qg_store_status qg_store_token_remove(struct qg_store *store, const char *id, const struct qg_actor *actor);

/* Keeps when tokens were used last, all in one transaction; of each the id and last_used_at are looked at. */
enum qg_store_status qg_store_tokens_used(struct qg_store *store, const struct qg_token *tokens, size_t count);

/* One line of the audit log. Entries are never changed; those older than the setting keep-log-days are dropped. */
struct qg_audit_entry {
    int64_t sequence, at; /* at: ms since 1970 UTC */
    char token[QG_TOKEN_ID_ROOM];
    char name[QG_TOKEN_NAME_ROOM];
    char address[QG_ADDRESS_ROOM];
    char action[24];  /* "job.submit", "job.cancel", "job.delete", "token.create", ... */
    char subject[64]; /* id of the job, the token or the webhook */
};

/* Writes an entry of its own, for what changes nothing in the database. actor NULL: the daemon. */
enum qg_store_status qg_store_note(struct qg_store *store, const struct qg_actor *actor, const char *action,
                                   const char *subject);

/* Up to `room` entries, newest first, with a sequence below `before` (0: from the newest on). */
enum qg_store_status qg_store_audit(struct qg_store *store, int64_t before, size_t room, struct qg_audit_entry *out,
                                    size_t *count);

/* Drops audit entries and finished deliveries from before a time in ms since 1970 UTC. */
enum qg_store_status qg_store_drop_log(struct qg_store *store, int64_t before);

#endif
