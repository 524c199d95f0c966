/* The certificate and the key of the daemon's own TLS: checked before anything is served with them, and renewed while the
 * daemon runs.
 *
 * A certificate is renewed every few weeks, by a program that replaces the files and tells the daemon (SIGHUP). libmicrohttpd
 * reads its pair once, at start, and gives it to the TLS session of each connection; here the session gets that of the moment
 * instead, after libmicrohttpd has made the session and before the handshake. A connection keeps the pair that it began with,
 * so a renewal breaks nothing off; a pair is freed when nothing serves it any more. What cannot be served leaves the old pair
 * in its place.
 *
 * Threads: all functions from any, except create and destroy.
 */
#ifndef QG_SERVER_HTTP_TLS_H
#define QG_SERVER_HTTP_TLS_H

#include <stdbool.h>
#include <stdint.h>

#include "schema/text.h"

/* TLS 1.2 and 1.3 in GnuTLS's words (gnutls_priority_init). */
#define QG_TLS_PRIORITIES "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2"

struct qg_tls;
struct qg_tls_pair;

/* Reads the files, and checks that they hold a certificate chain and the private key that belongs to it. The names are
 * borrowed for as long as it lives. NULL, with words on it appended to message, when they do not. */
struct qg_tls *qg_tls_create(const char *certificate_file, const char *key_file, struct qg_text *message);

/* Frees it; no connection serves its pairs any more. NULL is allowed. */
void qg_tls_destroy(struct qg_tls *tls);

/* Reads the files again; what they hold serves the connections that begin from now on. False, with words appended to message,
 * when it is no certificate with its key, or one that has expired: then all stays as it was. */
bool qg_tls_reload(struct qg_tls *tls, struct qg_text *message);

/* When the certificate that is served now expires, ms since 1970 UTC. */
int64_t qg_tls_valid_until(struct qg_tls *tls);

/* Certificate chain and key of the start as PEM texts, which live as long as tls does. */
const char *qg_tls_certificate_text(const struct qg_tls *tls);
const char *qg_tls_key_text(const struct qg_tls *tls);

/* Makes a TLS session (a gnutls_session_t before its handshake) serve the present pair. Returns that pair, for
 * qg_tls_release; NULL when the session cannot take it: then it serves the pair of the start. */
struct qg_tls_pair *qg_tls_serve(struct qg_tls *tls, void *session);

/* The session is about to end. pair NULL is allowed. */
void qg_tls_release(struct qg_tls *tls, struct qg_tls_pair *pair, void *session);

#endif
