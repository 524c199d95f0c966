/* Certificate and key. See tls.h. */
#include "server/http/tls.h"

#include <errno.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <string.h>

#include "server/base/secret.h"

enum { FILE_BYTES_MAX = 1 << 20 };

static bool read_file(const char *file, struct qg_text *text, struct qg_text *message) {
    char block[4096];
    size_t length;
    errno = 0;
    FILE *stream = fopen(file, "re");
    if (!stream) {
        qg_text_format(message, "%s: %s\n", file, strerror(errno));
        return false;
    }
    while ((length = fread(block, 1, sizeof block, stream)) > 0 && text->length < FILE_BYTES_MAX)
        qg_text_add(text, block, length);
    bool read = !ferror(stream) && !text->failed && text->length > 0 && text->length < FILE_BYTES_MAX;
    if (!read)
        qg_text_format(message, "%s: %s\n", file, errno ? strerror(errno) : "is empty or far too large");
    fclose(stream);
    qg_secret_wipe(block, sizeof block);
    return read;
}

/* Lets GnuTLS read the pair; it also checks that they belong together. */
static int check_pair(const struct qg_tls *tls) {
    gnutls_certificate_credentials_t credentials;
    const gnutls_datum_t certificate = {(unsigned char *)tls->certificate.data, (unsigned)tls->certificate.length};
    const gnutls_datum_t key = {(unsigned char *)tls->key.data, (unsigned)tls->key.length};
    int code = gnutls_certificate_allocate_credentials(&credentials);
    if (code != 0)
        return code;
    code = gnutls_certificate_set_x509_key_mem(credentials, &certificate, &key, GNUTLS_X509_FMT_PEM);
    gnutls_certificate_free_credentials(credentials);
    return code;
}

bool qg_tls_load(struct qg_tls *tls, const char *certificate_file, const char *key_file, struct qg_text *message) {
    *tls = (struct qg_tls){0};
    bool read = read_file(certificate_file, &tls->certificate, message);
    read = read_file(key_file, &tls->key, message) && read;
    if (!read)
        return false;
    int code = check_pair(tls);
    if (code >= 0)
        return true;
    qg_text_format(message, "%s and %s are not a certificate and its key in PEM: %s\n", certificate_file, key_file,
                   gnutls_strerror(code));
    return false;
}

void qg_tls_finish(struct qg_tls *tls) {
    if (tls->key.data)
        qg_secret_wipe(tls->key.data, tls->key.length);
    qg_text_finish(&tls->certificate);
    qg_text_finish(&tls->key);
}
