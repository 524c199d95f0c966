/* Webhooks as values: what they are told, their secrets, and the signature of a message by the Standard Webhooks scheme
 * (https://www.standardwebhooks.com, version 1): HMAC-SHA256 over "ID.TIMESTAMP.BODY", in Base64 behind "v1,".
 *
 * A secret is "whsec_" and the Base64 of 24 to 64 random bytes. To sign it has to be known, so the database holds it as it
 * is, in a directory that is the daemon's alone. Threads: any.
 */
#ifndef QG_SERVER_BASE_WEBHOOK_H
#define QG_SERVER_BASE_WEBHOOK_H

#include "server/base/address.h"
#include "server/base/secret.h"
#include <stdint.h>

enum {
    QG_WEBHOOKS_MAX = 100,
    QG_WEBHOOK_ID_ROOM = 16,
    QG_WEBHOOK_SECRET_ROOM = 6 + 88 + 1, /* "whsec_", 64 bytes in Base64 */
    QG_MESSAGE_ID_ROOM = 32,
    QG_SIGNATURE_ROOM = 3 + 44 + 1
};

/* One who is told of changes. */
struct qg_webhook {
    char id[QG_WEBHOOK_ID_ROOM];
    char url[QG_URL_MAX + 1];
    unsigned events; /* bits in the order of qg_event_names */
    char secret[QG_WEBHOOK_SECRET_ROOM];
    int64_t created_at, disabled_at; /* ms since 1970 UTC; disabled_at 0: it is not */
};

/* "job.queued" and so on, in the order of their bits, NULL-ended: "job." and the state that a job has come into. */
extern const char *const qg_event_names[];

/* Makes an id. False when there are no random bytes. */
bool qg_webhook_make_id(char id[QG_WEBHOOK_ID_ROOM]);

/* Makes a secret of 32 random bytes. False when there are none. */
bool qg_webhook_make_secret(char secret[QG_WEBHOOK_SECRET_ROOM]);

/* True for a text that is a secret. */
bool qg_webhook_is_secret(const char *text);

/* A message to be signed. timestamp: seconds since 1970 UTC. */
struct qg_message {
    const char *id, *body;
    int64_t timestamp;
};

/* Writes the signature of a message. False when the secret is none, or memory is short. */
bool qg_webhook_sign(char out[QG_SIGNATURE_ROOM], const char *secret, const struct qg_message *message);

#endif
