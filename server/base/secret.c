/* Secrets. See secret.h. */
#include "server/base/secret.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <string.h>

bool qg_secret_random(void *out, size_t length) {
    return gnutls_rnd(GNUTLS_RND_KEY, out, length) == 0;
}

bool qg_secret_hash(unsigned char out[QG_HASH_BYTES], const void *bytes, size_t length) {
    return gnutls_hash_fast(GNUTLS_DIG_SHA256, bytes, length, out) == 0;
}

bool qg_secret_sign(unsigned char out[QG_HASH_BYTES], const void *key, size_t key_length, const void *bytes,
                    size_t length) {
    return gnutls_hmac_fast(GNUTLS_MAC_SHA256, key, key_length, bytes, length, out) == 0;
}

bool qg_secret_equal(const unsigned char a[QG_HASH_BYTES], const unsigned char b[QG_HASH_BYTES]) {
    return gnutls_memcmp(a, b, QG_HASH_BYTES) == 0;
}

void qg_secret_wipe(void *bytes, size_t length) {
    gnutls_memset(bytes, 0, length);
}

static const char digits[] = "0123456789abcdef";

void qg_hex_write(char *out, const unsigned char *bytes, size_t length) {
    for (size_t i = 0; i < length; i++) {
        *out++ = digits[bytes[i] >> 4];
        *out++ = digits[bytes[i] & 15];
    }
    *out = '\0';
}

bool qg_hex_read(unsigned char *out, size_t length, const char *text) {
    if (strlen(text) != 2 * length || strspn(text, digits) != 2 * length)
        return false;
    for (size_t i = 0; i < length; i++)
        out[i] =
            (unsigned char)((strchr(digits, text[2 * i]) - digits) * 16 + (strchr(digits, text[2 * i + 1]) - digits));
    return true;
}

bool qg_base64_write(char *out, size_t room, const void *bytes, size_t length) {
    gnutls_datum_t plain = {(unsigned char *)bytes, (unsigned)length}, coded = {0};
    if (gnutls_base64_encode2(&plain, &coded) != 0)
        return false;
    bool fits = coded.size < room;
    if (fits) {
        memcpy(out, coded.data, coded.size);
        out[coded.size] = '\0';
    }
    gnutls_free(coded.data);
    return fits;
}

/* True for what RFC 4648 calls canonical in shape: the alphabet, a whole number of fours, padding at the end only. GnuTLS
 * skips over line feeds, which a secret does not have. */
static bool is_base64(const char *text) {
    size_t letters = strspn(text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"),
           length = strlen(text);
    return length > 0 && length % 4 == 0 && length - letters <= 2 && strspn(text + letters, "=") == length - letters;
}

bool qg_base64_read(unsigned char *out, size_t *length, const char *text) {
    gnutls_datum_t coded = {(unsigned char *)text, (unsigned)strlen(text)}, plain = {0};
    if (!is_base64(text) || gnutls_base64_decode2(&coded, &plain) != 0)
        return false;
    bool fits = plain.size <= *length;
    if (fits)
        memcpy(out, plain.data, plain.size);
    *length = plain.size;
    gnutls_memset(plain.data, 0, plain.size);
    gnutls_free(plain.data);
    return fits;
}
