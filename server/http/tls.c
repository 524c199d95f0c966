/* Certificate and key. See tls.h.
 *
 * Each pair counts those who hold it: the sessions that serve it, and struct qg_tls while it is the present one, and also the
 * one of the start, which libmicrohttpd holds as well. The last to let go frees it.
 */
#include "server/http/tls.h"

#include <assert.h>
#include <errno.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/secret.h"

enum { FILE_BYTES_MAX = 1 << 20 };

struct qg_tls_pair {
    gnutls_certificate_credentials_t credentials;
    struct qg_text certificate, key; /* PEM */
    int64_t valid_until;             /* ms since 1970 UTC */
    size_t holders;
};

struct qg_tls {
    const char *certificate_file, *key_file;
    struct qg_tls_pair *first;
    pthread_mutex_t mutex;       /* guards present, and the holders of all pairs */
    struct qg_tls_pair *present; /* never NULL */
};

/* --- a pair --- */

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

/* Lets GnuTLS read the texts; it also checks that they belong together. */
static int import(struct qg_tls_pair *pair) {
    const gnutls_datum_t certificate = {(unsigned char *)pair->certificate.data, (unsigned)pair->certificate.length};
    const gnutls_datum_t key = {(unsigned char *)pair->key.data, (unsigned)pair->key.length};
    int code = gnutls_certificate_allocate_credentials(&pair->credentials);
    if (code != 0)
        pair->credentials = NULL;
    else
        code = gnutls_certificate_set_x509_key_mem(pair->credentials, &certificate, &key, GNUTLS_X509_FMT_PEM);
    return code;
}

/* Reads when the server's certificate, the first of the chain, expires. */
static int read_expiry(struct qg_tls_pair *pair) {
    gnutls_x509_crt_t *chain;
    unsigned count;
    int code = gnutls_certificate_get_x509_crt(pair->credentials, 0, &chain, &count);
    if (code != 0)
        return code;
    pair->valid_until = (int64_t)gnutls_x509_crt_get_expiration_time(chain[0]) * 1000;
    for (unsigned i = 0; i < count; i++)
        gnutls_x509_crt_deinit(chain[i]);
    gnutls_free(chain);
    return 0;
}

static void destroy_pair(struct qg_tls_pair *pair) {
    if (pair->key.data)
        qg_secret_wipe(pair->key.data, pair->key.length);
    if (pair->credentials)
        gnutls_certificate_free_credentials(pair->credentials);
    qg_text_finish(&pair->certificate);
    qg_text_finish(&pair->key);
    free(pair);
}

/* The pair that the files hold, held by nobody; NULL and a message when it is none. */
static struct qg_tls_pair *read_pair(const struct qg_tls *tls, struct qg_text *message) {
    struct qg_tls_pair *pair = calloc(1, sizeof *pair);
    if (!pair) {
        qg_text_format(message, "there is not enough memory for a certificate\n");
        return NULL;
    }
    bool read = read_file(tls->certificate_file, &pair->certificate, message);
    read = read_file(tls->key_file, &pair->key, message) && read;
    int code = read ? import(pair) : 0;
    if (read && code >= 0)
        code = read_expiry(pair);
    if (code < 0)
        qg_text_format(message, "%s and %s are not a certificate and its key in PEM: %s\n", tls->certificate_file,
                       tls->key_file, gnutls_strerror(code));
    if (read && code >= 0)
        return pair;
    destroy_pair(pair);
    return NULL;
}

/* The mutex is held. */
static void let_go(struct qg_tls_pair *pair) {
    assert(pair->holders > 0);
    if (--pair->holders == 0)
        destroy_pair(pair);
}

/* --- the pair of the moment --- */

struct qg_tls *qg_tls_create(const char *certificate_file, const char *key_file, struct qg_text *message) {
    struct qg_tls *tls = calloc(1, sizeof *tls);
    if (!tls) {
        qg_text_format(message, "there is not enough memory for a certificate\n");
        return NULL;
    }
    tls->certificate_file = certificate_file;
    tls->key_file = key_file;
    tls->first = tls->present = read_pair(tls, message);
    if (!tls->first) {
        free(tls);
        return NULL;
    }
    tls->first->holders = 2;
    pthread_mutex_init(&tls->mutex, NULL);
    return tls;
}

void qg_tls_destroy(struct qg_tls *tls) {
    if (!tls)
        return;
    let_go(tls->present);
    let_go(tls->first);
    pthread_mutex_destroy(&tls->mutex);
    free(tls);
}

bool qg_tls_reload(struct qg_tls *tls, struct qg_text *message) {
    struct qg_tls_pair *pair = read_pair(tls, message);
    if (!pair)
        return false;
    if (pair->valid_until < qg_wall_clock()) {
        char expiry[QG_TIME_ROOM];
        qg_time_print(expiry, pair->valid_until);
        qg_text_format(message, "%s has expired: it was valid until %s\n", tls->certificate_file, expiry);
        destroy_pair(pair);
        return false;
    }
    pair->holders = 1;
    pthread_mutex_lock(&tls->mutex);
    let_go(tls->present);
    tls->present = pair;
    pthread_mutex_unlock(&tls->mutex);
    return true;
}

int64_t qg_tls_valid_until(struct qg_tls *tls) {
    pthread_mutex_lock(&tls->mutex);
    int64_t until = tls->present->valid_until;
    pthread_mutex_unlock(&tls->mutex);
    return until;
}

const char *qg_tls_certificate_text(const struct qg_tls *tls) {
    return tls->first->certificate.data;
}

const char *qg_tls_key_text(const struct qg_tls *tls) {
    return tls->first->key.data;
}

/* --- sessions --- */

struct qg_tls_pair *qg_tls_serve(struct qg_tls *tls, void *session) {
    struct qg_tls_pair *pair = NULL;
    pthread_mutex_lock(&tls->mutex);
    if (gnutls_credentials_set(session, GNUTLS_CRD_CERTIFICATE, tls->present->credentials) == 0) {
        pair = tls->present;
        pair->holders++;
    }
    pthread_mutex_unlock(&tls->mutex);
    return pair;
}

void qg_tls_release(struct qg_tls *tls, struct qg_tls_pair *pair, void *session) {
    if (!pair)
        return;
    gnutls_credentials_clear(session);
    pthread_mutex_lock(&tls->mutex);
    let_go(pair);
    pthread_mutex_unlock(&tls->mutex);
}
