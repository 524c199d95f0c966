/* The certificate and the key of the daemon's own TLS, checked before anything is served with them.
 */
#ifndef QG_SERVER_HTTP_TLS_H
#define QG_SERVER_HTTP_TLS_H

#include "schema/text.h"

/* TLS 1.2 and 1.3 in GnuTLS's words (gnutls_priority_init). */
#define QG_TLS_PRIORITIES "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2"

/* Both as PEM texts. */
struct qg_tls {
    struct qg_text certificate, key;
};

/* Reads the files and checks that they hold a certificate chain and the private key that belongs to it. False, with words
 * on it appended to message; the caller finishes tls in both cases. Threads: any. */
bool qg_tls_load(struct qg_tls *tls, const char *certificate_file, const char *key_file, struct qg_text *message);

/* Frees both, and overwrites the key. */
void qg_tls_finish(struct qg_tls *tls);

#endif
