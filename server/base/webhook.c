/* Webhooks as values. See webhook.h. */
#include "server/base/webhook.h"

#include <stdio.h>
#include <string.h>

#include "schema/text.h"

enum { ID_BYTES = 6, KEY_BYTES = 32, KEY_BYTES_MIN = 24, KEY_BYTES_MAX = 64 };

#define PREFIX "whsec_"

const char *const qg_event_names[] = {"job.queued", "job.running",   "job.succeeded",
                                      "job.failed", "job.cancelled", NULL};

bool qg_webhook_make_id(char id[QG_WEBHOOK_ID_ROOM]) {
    unsigned char bytes[ID_BYTES];
    if (!qg_secret_random(bytes, sizeof bytes))
        return false;
    strcpy(id, "wh_");
    qg_hex_write(id + 3, bytes, sizeof bytes);
    return true;
}

bool qg_webhook_make_secret(char secret[QG_WEBHOOK_SECRET_ROOM]) {
    const size_t prefix = strlen(PREFIX);
    unsigned char key[KEY_BYTES];
    strcpy(secret, PREFIX);
    bool made = qg_secret_random(key, sizeof key) &&
                qg_base64_write(secret + prefix, QG_WEBHOOK_SECRET_ROOM - prefix, key, sizeof key);
    qg_secret_wipe(key, sizeof key);
    return made;
}

/* The key of a secret; false when it is none. */
static bool read_key(const char *secret, unsigned char key[KEY_BYTES_MAX], size_t *length) {
    const size_t prefix = strlen(PREFIX);
    *length = KEY_BYTES_MAX;
    return strncmp(secret, PREFIX, prefix) == 0 && qg_base64_read(key, length, secret + prefix) &&
           *length >= KEY_BYTES_MIN;
}

bool qg_webhook_is_secret(const char *text) {
    unsigned char key[KEY_BYTES_MAX];
    size_t length;
    bool right = read_key(text, key, &length);
    qg_secret_wipe(key, sizeof key);
    return right;
}

bool qg_webhook_sign(char out[QG_SIGNATURE_ROOM], const char *secret, const struct qg_message *message) {
    unsigned char key[KEY_BYTES_MAX], sum[QG_HASH_BYTES];
    size_t length;
    struct qg_text text = {0};
    qg_text_format(&text, "%s.%lld.%s", message->id, (long long)message->timestamp, message->body);
    strcpy(out, "v1,");
    bool made = !text.failed && read_key(secret, key, &length) &&
                qg_secret_sign(sum, key, length, text.data, text.length) &&
                qg_base64_write(out + 3, QG_SIGNATURE_ROOM - 3, sum, sizeof sum);
    qg_secret_wipe(key, sizeof key);
    qg_text_finish(&text);
    return made;
}
