/* Access tokens as texts, the scopes that they carry, and who is behind a request.
 *
 * A token is "qg_ID_SECRET": ID has 12 hexadecimal digits and is no secret (it names the token in lists and in the audit
 * log), SECRET has 64 of them, 256 random bits. The server keeps SHA-256 of the secret only. A plain fast hash is enough:
 * slow, salted hashes such as Argon2 protect passwords, which people choose from a small set; a secret of 256 random bits
 * cannot be guessed however fast a guess is, and no two are alike, so a salt would add nothing.
 */
#ifndef QG_SERVER_BASE_TOKEN_H
#define QG_SERVER_BASE_TOKEN_H

#include <stdbool.h>
#include <stdint.h>

#include "schema/text.h"
#include "server/base/secret.h"

/* What a token may be used for, as bits. None includes another. */
enum {
    QG_SCOPE_READ = 1,   /* look at jobs and what they left */
    QG_SCOPE_SUBMIT = 2, /* submit, cancel and delete jobs */
    QG_SCOPE_ADMIN = 4,  /* tokens, webhooks, the audit log */
    QG_SCOPE_ALL = 7,
    QG_SCOPE_PUBLIC = 8 /* of a route: no token is needed; never of a token */
};

/* Names of the scopes, in the order of their bits, NULL-ended. */
extern const char *const qg_scope_names[];

/* Appends the scopes as a JSON array of names. */
void qg_scopes_write(struct qg_text *text, unsigned scopes);

enum {
    QG_TOKEN_ID_ROOM = 13,
    QG_TOKEN_ROOM = 3 + 12 + 1 + 64 + 1,
    QG_TOKEN_NAME_MAX = 60, /* characters */
    QG_TOKEN_NAME_ROOM = 4 * QG_TOKEN_NAME_MAX + 1,
    QG_ADDRESS_ROOM = 64,
    QG_TOKEN_REQUESTS_MAX = 6000000, /* a minute */
    QG_TOKEN_JOBS_MAX = 100000
};

/* A token as it is kept: everything but its secret. */
struct qg_token {
    char id[QG_TOKEN_ID_ROOM];
    char name[QG_TOKEN_NAME_ROOM]; /* what people call it */
    unsigned scopes;
    int64_t created_at;                   /* ms since 1970 UTC, as are the next two */
    int64_t expires_at;                   /* from then on it opens nothing; 0: never */
    int64_t last_used_at;                 /* 0: not yet */
    int requests_per_minute, queued_jobs; /* its own limits; 0: the daemon's settings hold for it */
    unsigned char hash[QG_HASH_BYTES];
};

/* Who asks. */
struct qg_actor {
    char token[QG_TOKEN_ID_ROOM];  /* "" without one */
    char name[QG_TOKEN_NAME_ROOM]; /* the token's; "" without one */
    char address[QG_ADDRESS_ROOM]; /* numeric, of the connection; "" when there is none (a local socket, the daemon) */
    unsigned scopes;
};

/* True when a token has expired at a time in ms since 1970 UTC. */
bool qg_token_is_over(const struct qg_token *token, int64_t now);

/* Makes a new token: fills in token->id and token->hash, and writes the text. False when there are no random bytes. */
bool qg_token_make(struct qg_token *token, char text[QG_TOKEN_ROOM]);

/* Takes a token's text apart: its id, and the hash of its secret. False when it is not of a token's form. */
bool qg_token_read(const char *text, char id[QG_TOKEN_ID_ROOM], unsigned char hash[QG_HASH_BYTES]);

#endif
