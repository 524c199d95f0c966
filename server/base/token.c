/* Access tokens as texts. See token.h. */
#include "server/base/token.h"

#include <stdio.h>
#include <string.h>

enum { ID_BYTES = 6, SECRET_BYTES = 32, SECRET_DIGITS = 2 * SECRET_BYTES };

#define PREFIX "qg_"

const char *const qg_scope_names[] = {"read", "submit", "admin", NULL};

void qg_scopes_write(struct qg_text *text, unsigned scopes) {
    qg_json_open(text, '[');
    for (unsigned i = 0; qg_scope_names[i]; i++)
        if (scopes & 1u << i)
            qg_json_string(text, qg_scope_names[i]);
    qg_json_close(text, ']');
}

bool qg_token_is_over(const struct qg_token *token, int64_t now) {
    return token->expires_at > 0 && token->expires_at <= now;
}

bool qg_token_make(struct qg_token *token, char text[QG_TOKEN_ROOM]) {
    unsigned char id[ID_BYTES], secret[SECRET_BYTES];
    char digits[SECRET_DIGITS + 1];
    if (!qg_secret_random(id, sizeof id) || !qg_secret_random(secret, sizeof secret) ||
        !qg_secret_hash(token->hash, secret, sizeof secret))
        return false;
    qg_hex_write(token->id, id, sizeof id);
    qg_hex_write(digits, secret, sizeof secret);
    snprintf(text, QG_TOKEN_ROOM, PREFIX "%s_%s", token->id, digits);
    qg_secret_wipe(secret, sizeof secret);
    qg_secret_wipe(digits, sizeof digits);
    return true;
}

bool qg_token_read(const char *text, char id[QG_TOKEN_ID_ROOM], unsigned char hash[QG_HASH_BYTES]) {
    unsigned char bytes[ID_BYTES], secret[SECRET_BYTES];
    const size_t prefix = strlen(PREFIX), id_digits = QG_TOKEN_ID_ROOM - 1;
    if (strlen(text) != QG_TOKEN_ROOM - 1 || memcmp(text, PREFIX, prefix) != 0 || text[prefix + id_digits] != '_')
        return false;
    memcpy(id, text + prefix, id_digits);
    id[id_digits] = '\0';
    bool read = qg_hex_read(bytes, sizeof bytes, id) &&
                qg_hex_read(secret, sizeof secret, text + prefix + id_digits + 1) &&
                qg_secret_hash(hash, secret, sizeof secret);
    qg_secret_wipe(secret, sizeof secret);
    return read;
}
