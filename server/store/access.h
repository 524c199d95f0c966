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

enum { QG_AUDIT_SUBJECT_ROOM = 64 };

/* One line of the audit log. Entries are never changed; those older than the setting keep-log-days are dropped. */
struct qg_audit_entry {
    int64_t sequence, at; /* at: ms since 1970 UTC */
    char token[QG_TOKEN_ID_ROOM];
    char name[QG_TOKEN_NAME_ROOM];
    char address[QG_ADDRESS_ROOM];
    char action[24]; /* one of qg_actions */
    char subject
        [QG_AUDIT_SUBJECT_ROOM]; /* id of the job, token or webhook; the call that was refused; the version started */
};

/* All that is written down, NULL-ended. What stands before the dot is the family. */
extern const char *const qg_actions[];

/* Which entries are wanted. NULL and 0: any. */
struct qg_audit_filter {
    const char *action;   /* one of qg_actions, or a family of them: "job" */
    const char *actor;    /* id or name of a token; "quietgeard" is the daemon */
    const char *subject;  /* of the entry, as a whole */
    const char *address;  /* likewise */
    int64_t since, until; /* ms since 1970 UTC, the latter excluded */
    int64_t before;       /* sequences below this one */
};

/* True for one of qg_actions and for a family of them. */
bool qg_action_is_known(const char *action);

/* Writes an entry of its own, for what changes nothing in the database. actor NULL: the daemon. */
enum qg_store_status qg_store_note(struct qg_store *store, const struct qg_actor *actor, const char *action,
                                   const char *subject);

/* What a look into the log brings. */
struct qg_audit_page {
    struct qg_audit_entry *entry; /* the caller's, with room for so many */
    size_t room, count;
    int64_t next; /* the oldest sequence looked at, when there may be older ones that fit; else 0 */
};

/* How many entries one call looks at: a few milliseconds' worth, however rare what is asked for. */
enum { QG_AUDIT_LOOK = 20000 };

/* Brings the newest entries that the filter lets through, newest first. With fewer of them than there is room there may yet be
 * more: from page->next on. */
enum qg_store_status qg_store_audit(struct qg_store *store, const struct qg_audit_filter *filter,
                                    struct qg_audit_page *page);

/* Drops up to a few thousand audit entries and finished deliveries from before a time in ms since 1970 UTC.
 * QG_STORE_NOT_FOUND when there are none left. */
enum qg_store_status qg_store_drop_log(struct qg_store *store, int64_t before);

#endif
