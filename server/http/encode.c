/* Entity tags and gzip. See encode.h.
 *
 * One thread serves all connections, and none is to hold the others up for more than about a hundredth of a second. So level 1
 * is used, and a long text is compressed in pieces while it is sent.
 */
#include "server/http/encode.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

void qg_etag(char etag[QG_ETAG_ROOM], const struct qg_text *text) {
    uint64_t hash = 14695981039346656037u; /* FNV-1a */
    for (size_t i = 0; i < text->length; i++)
        hash = (hash ^ (unsigned char)text->data[i]) * 1099511628211u;
    snprintf(etag, QG_ETAG_ROOM, "\"%016" PRIx64 "\"", hash);
}

enum {
    SHORT_BODY = 1024,
    LEVEL = 1,
    GZIP_WINDOW = 15 + 16, /* 32 KB, and gzip's framing (zlib.h, deflateInit2) */
    BLOCK = 32 << 10,
    LONG_BODY = 256 << 10, /* compressed in pieces from there on */
    PIECE = 64 << 10       /* of the text */
};

static bool is_stored(const struct qg_reply *reply) {
    const char *control = qg_reply_header_value(reply, "Cache-Control");
    return !control || !strstr(control, "no-store");
}

void qg_reply_revalidate(struct qg_reply *reply, const char *if_none_match) {
    if (reply->status != 200 || reply->stream.self || reply->body.failed || !is_stored(reply))
        return;
    if (!qg_reply_header_value(reply, "ETag")) {
        char etag[QG_ETAG_ROOM];
        qg_etag(etag, &reply->body);
        qg_reply_header(reply, "ETag", "%s", etag);
    }
    if (if_none_match && qg_etag_matches(if_none_match, qg_reply_header_value(reply, "ETag"))) {
        reply->status = 304;
        qg_text_finish(&reply->body);
    }
}

/* --- gzip --- */

/* Compresses `length` bytes to the end of a text; flush is zlib's. False when memory is short. */
static bool squeeze(z_stream *zip, const char *bytes, size_t length, int flush, struct qg_text *out) {
    unsigned char block[BLOCK];
    zip->next_in = (unsigned char *)(uintptr_t)bytes; /* zlib's input is not const, but it does not write to it */
    zip->avail_in = (uInt)length;
    do {
        zip->next_out = block;
        zip->avail_out = sizeof block;
        deflate(zip, flush);
        qg_text_add(out, (const char *)block, sizeof block - zip->avail_out);
    } while (zip->avail_out == 0);
    return !out->failed;
}

static bool begin_zip(z_stream *zip) {
    *zip = (z_stream){0};
    return deflateInit2(zip, LEVEL, Z_DEFLATED, GZIP_WINDOW, 8, Z_DEFAULT_STRATEGY) == Z_OK;
}

static bool compress_text(struct qg_reply *reply) {
    struct qg_text small = {0};
    z_stream zip;
    if (reply->body.failed || reply->body.length < SHORT_BODY || reply->body.length > UINT_MAX || !begin_zip(&zip))
        return false;
    bool done = squeeze(&zip, reply->body.data, reply->body.length, Z_FINISH, &small);
    deflateEnd(&zip);
    struct qg_text dropped = done ? reply->body : small;
    if (done)
        reply->body = small;
    qg_text_finish(&dropped);
    return done;
}

/* A stream that compresses another. */
struct zipped {
    struct qg_stream plain;
    z_stream zip;
    bool ended;
};

/* Pieces until some compressed bytes come out of them, which is not each time. */
static enum qg_stream_step next_zipped(void *self, struct qg_text *piece, struct qg_pause *pause) {
    struct zipped *zipped = self;
    while (!zipped->ended && piece->length == 0) {
        struct qg_text plain = {0};
        enum qg_stream_step step = zipped->plain.next(zipped->plain.self, &plain, pause);
        zipped->ended = step == QG_STREAM_END;
        bool squeezed = !plain.failed && (step == QG_STREAM_PIECE || step == QG_STREAM_END) &&
                        squeeze(&zipped->zip, plain.data ? plain.data : "", plain.length,
                                zipped->ended ? Z_FINISH : Z_NO_FLUSH, piece);
        qg_text_finish(&plain);
        if (!squeezed)
            return QG_STREAM_BROKEN;
    }
    return piece->length > 0 ? QG_STREAM_PIECE : QG_STREAM_END;
}

static void destroy_zipped(void *self) {
    struct zipped *zipped = self;
    zipped->plain.destroy(zipped->plain.self);
    deflateEnd(&zipped->zip);
    free(zipped);
}

static bool compress_stream(struct qg_reply *reply) {
    struct zipped *zipped = reply->stream.endless ? NULL : calloc(1, sizeof *zipped);
    if (!zipped || !begin_zip(&zipped->zip)) {
        free(zipped);
        return false;
    }
    zipped->plain = reply->stream;
    reply->stream =
        (struct qg_stream){.next = next_zipped, .destroy = destroy_zipped, .self = zipped, .kept = zipped->plain.kept};
    return true;
}

/* A text as a stream. */
struct cut {
    struct qg_text text;
    size_t sent;
};

static enum qg_stream_step next_cut(void *self, struct qg_text *piece, struct qg_pause *pause) {
    (void)pause;
    struct cut *cut = self;
    size_t length = cut->text.length - cut->sent < PIECE ? cut->text.length - cut->sent : PIECE;
    qg_text_add(piece, cut->text.data + cut->sent, length);
    cut->sent += length;
    return length > 0 ? QG_STREAM_PIECE : QG_STREAM_END;
}

static void destroy_cut(void *self) {
    struct cut *cut = self;
    qg_text_finish(&cut->text);
    free(cut);
}

/* Makes a long body a stream, so that it can be compressed in pieces. Without memory it stays as it is. */
static void cut_long_body(struct qg_reply *reply) {
    struct cut *cut =
        reply->stream.self || reply->body.failed || reply->body.length < LONG_BODY ? NULL : calloc(1, sizeof *cut);
    if (!cut)
        return;
    cut->text = reply->body;
    reply->body = (struct qg_text){0};
    reply->stream = (struct qg_stream){.next = next_cut, .destroy = destroy_cut, .self = cut, .kept = cut->text.length};
}

static void weaken_etag(struct qg_reply *reply) {
    for (size_t i = 0; i < reply->header_count; i++)
        if (strcmp(reply->header[i].name, "ETag") == 0 && reply->header[i].value[0] == '"') {
            char *value = reply->header[i].value;
            memmove(value + 2, value, strlen(value) + 1);
            memcpy(value, "W/", 2);
        }
}

void qg_reply_compress(struct qg_reply *reply) {
    cut_long_body(reply);
    if (!(reply->stream.self ? compress_stream(reply) : compress_text(reply)))
        return;
    qg_reply_header(reply, "Content-Encoding", "gzip");
    weaken_etag(reply);
}
