/* Secrets: random bytes, hashes, signatures, comparison in constant time. The one place that knows GnuTLS's cryptography.
 *
 * Nothing here is of our own making: random bytes are those of gnutls_rnd at its strongest level, hashes and signatures are
 * FIPS 180-4 SHA-256 and RFC 2104 HMAC, Base64 is RFC 4648 with padding. Threads: any.
 */
#ifndef QG_SERVER_BASE_SECRET_H
#define QG_SERVER_BASE_SECRET_H

#include <stdbool.h>
#include <stddef.h>

enum { QG_HASH_BYTES = 32 };

/* Fills out with random bytes fit for keys. False when the system has none to give. */
bool qg_secret_random(void *out, size_t length);

/* SHA-256 of some bytes. False when GnuTLS cannot (out of memory). */
bool qg_secret_hash(unsigned char out[QG_HASH_BYTES], const void *bytes, size_t length);

/* HMAC-SHA256 of some bytes under a key. False when GnuTLS cannot (out of memory). */
bool qg_secret_sign(unsigned char out[QG_HASH_BYTES], const void *key, size_t key_length, const void *bytes,
                    size_t length);

/* True when two hashes are equal; takes as long whether they are or not, and wherever they differ. */
bool qg_secret_equal(const unsigned char a[QG_HASH_BYTES], const unsigned char b[QG_HASH_BYTES]);

/* Overwrites memory that held a secret, in a way that no compiler leaves out. */
void qg_secret_wipe(void *bytes, size_t length);

/* Lower-case hexadecimal digits of some bytes: 2 * length of them and a NUL. */
void qg_hex_write(char *out, const unsigned char *bytes, size_t length);

/* Bytes of exactly 2 * length lower-case hexadecimal digits. False when the text is anything else. */
bool qg_hex_read(unsigned char *out, size_t length, const char *text);

/* Base64 of some bytes and a NUL. False when it does not fit into the room, or memory is short. */
bool qg_base64_write(char *out, size_t room, const void *bytes, size_t length);

/* Bytes of a Base64 text; *length is the room before, the bytes after. False when it is not Base64 or does not fit. */
bool qg_base64_read(unsigned char *out, size_t *length, const char *text);

#endif
