/* Entity tags and gzip on replies: what is unpacked is what was packed. */
#include "tests/server/support.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "server/http/encode.h"

enum { ROOM = 1 << 20 };

static void make_text(struct qg_text *text, int lines) {
    for (int i = 0; i < lines; i++)
        qg_text_format(text, "line %d of something that repeats\n", i);
}

/* Unpacks gzip; the result is to be freed. */
static char *unpack(const struct qg_text *packed, size_t *length) {
    char *out = malloc(ROOM);
    z_stream zip = {.next_in = (unsigned char *)packed->data,
                    .avail_in = (uInt)packed->length,
                    .next_out = (unsigned char *)out,
                    .avail_out = ROOM};
    assert_int_equal(inflateInit2(&zip, 15 + 16), Z_OK);
    assert_int_equal(inflate(&zip, Z_FINISH), Z_STREAM_END);
    *length = zip.total_out;
    inflateEnd(&zip);
    return out;
}

static void assert_unpacks(const struct qg_text *packed, const struct qg_text *plain) {
    size_t length;
    char *unpacked = unpack(packed, &length);
    assert_int_equal(length, plain->length);
    assert_memory_equal(unpacked, plain->data, length);
    free(unpacked);
}

static void compresses_a_text(void **state) {
    (void)state;
    struct qg_reply reply = {.status = 200};
    struct qg_text plain = {0};
    make_text(&reply.body, 3000);
    make_text(&plain, 3000);
    qg_reply_revalidate(&reply, NULL);
    assert_int_equal(qg_reply_header_value(&reply, "ETag")[0], '"');
    qg_reply_compress(&reply);
    assert_string_equal(qg_reply_header_value(&reply, "Content-Encoding"), "gzip");
    assert_memory_equal(qg_reply_header_value(&reply, "ETag"), "W/\"", 3);
    assert_true(reply.body.length < plain.length / 4);
    assert_unpacks(&reply.body, &plain);
    qg_text_finish(&plain);
    qg_reply_finish(&reply);
}

/* A long text becomes a stream, so that it is compressed in pieces. */
static void compresses_a_long_text_in_pieces(void **state) {
    (void)state;
    struct qg_reply reply = {.status = 200};
    struct qg_text plain = {0}, packed = {0};
    struct qg_pause pause;
    int pieces = 0;
    make_text(&reply.body, 20000);
    make_text(&plain, 20000);
    qg_reply_revalidate(&reply, NULL);
    qg_reply_compress(&reply);
    assert_non_null(reply.stream.self);
    assert_true(reply.stream.kept >= 256 << 10); /* it counts as the text that it is */
    assert_string_equal(qg_reply_header_value(&reply, "Content-Encoding"), "gzip");
    assert_memory_equal(qg_reply_header_value(&reply, "ETag"), "W/\"", 3);
    for (struct qg_text piece = {0}; reply.stream.next(reply.stream.self, &piece, &pause) == QG_STREAM_PIECE;
         pieces++) {
        qg_text_add(&packed, piece.data, piece.length);
        qg_text_finish(&piece);
    }
    assert_in_range(pieces, 3, 20);
    assert_unpacks(&packed, &plain);
    qg_text_finish(&plain);
    qg_text_finish(&packed);
    qg_reply_finish(&reply);
}

static void leaves_what_is_short(void **state) {
    (void)state;
    struct qg_reply reply = {.status = 200};
    make_text(&reply.body, 3);
    qg_reply_compress(&reply);
    assert_null(qg_reply_header_value(&reply, "Content-Encoding"));
    qg_reply_finish(&reply);
}

/* A stream of so many pieces. */
struct pieces {
    int left;
    bool breaks;
};

static enum qg_stream_step next_piece(void *self, struct qg_text *piece, struct qg_pause *pause) {
    (void)pause;
    struct pieces *pieces = self;
    if (pieces->left == 0)
        return pieces->breaks ? QG_STREAM_BROKEN : QG_STREAM_END;
    qg_text_format(piece, "piece %d and some words to make it longer\n", pieces->left--);
    return QG_STREAM_PIECE;
}

static enum qg_stream_step read_whole(struct qg_stream *stream, struct qg_text *out) {
    struct qg_pause pause;
    for (;;) {
        struct qg_text piece = {0};
        enum qg_stream_step step = stream->next(stream->self, &piece, &pause);
        qg_text_add(out, piece.data ? piece.data : "", piece.length);
        qg_text_finish(&piece);
        if (step != QG_STREAM_PIECE)
            return step;
    }
}

static void nothing(void *self) {
    (void)self;
}

static void compresses_a_stream(void **state) {
    (void)state;
    struct pieces first = {.left = 5000}, second = {.left = 5000};
    struct qg_stream plain_stream = {.next = next_piece, .self = &second};
    struct qg_reply reply = {.status = 200, .stream = {.next = next_piece, .destroy = nothing, .self = &first}};
    struct qg_text packed = {0}, plain = {0};
    qg_reply_compress(&reply);
    assert_string_equal(qg_reply_header_value(&reply, "Content-Encoding"), "gzip");
    assert_int_equal(read_whole(&reply.stream, &packed), QG_STREAM_END);
    assert_int_equal(read_whole(&plain_stream, &plain), QG_STREAM_END);
    assert_unpacks(&packed, &plain);
    qg_text_finish(&packed);
    qg_text_finish(&plain);
    qg_reply_finish(&reply);
}

static void a_broken_stream_stays_broken(void **state) {
    (void)state;
    struct pieces pieces = {.left = 3, .breaks = true};
    struct qg_reply reply = {.status = 200, .stream = {.next = next_piece, .destroy = nothing, .self = &pieces}};
    struct qg_text packed = {0};
    qg_reply_compress(&reply);
    assert_int_equal(read_whole(&reply.stream, &packed), QG_STREAM_BROKEN);
    qg_text_finish(&packed);
    qg_reply_finish(&reply);
}

static void leaves_event_streams(void **state) {
    (void)state;
    struct pieces pieces = {.left = 3};
    struct qg_reply reply = {.status = 200,
                             .stream = {.next = next_piece, .destroy = nothing, .self = &pieces, .endless = true}};
    qg_reply_compress(&reply);
    assert_null(qg_reply_header_value(&reply, "Content-Encoding"));
    qg_reply_finish(&reply);
}

static void revalidates(void **state) {
    (void)state;
    struct qg_reply first = {.status = 200}, again = {.status = 200}, other = {.status = 200}, failed = {.status = 404};
    make_text(&first.body, 3);
    make_text(&again.body, 3);
    make_text(&other.body, 4);
    make_text(&failed.body, 3);
    qg_reply_revalidate(&first, NULL);
    const char *etag = qg_reply_header_value(&first, "ETag");
    qg_reply_revalidate(&again, etag);
    assert_int_equal(again.status, 304);
    assert_int_equal(again.body.length, 0);
    assert_string_equal(qg_reply_header_value(&again, "ETag"), etag);
    qg_reply_revalidate(&other, etag);
    assert_int_equal(other.status, 200);
    qg_reply_revalidate(&failed, etag);
    assert_int_equal(failed.status, 404);
    assert_null(qg_reply_header_value(&failed, "ETag"));
    struct qg_reply secret = {.status = 200};
    make_text(&secret.body, 3);
    qg_reply_header(&secret, "Cache-Control", "no-store");
    qg_reply_revalidate(&secret, "*");
    assert_int_equal(secret.status, 200);
    qg_reply_finish(&first);
    qg_reply_finish(&other);
    qg_reply_finish(&failed);
    qg_reply_finish(&secret);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compresses_a_text),
        cmocka_unit_test(compresses_a_long_text_in_pieces),
        cmocka_unit_test(leaves_what_is_short),
        cmocka_unit_test(compresses_a_stream),
        cmocka_unit_test(a_broken_stream_stays_broken),
        cmocka_unit_test(leaves_event_streams),
        cmocka_unit_test(revalidates),
    };
    return cmocka_run_group_tests_name("encode", tests, NULL, NULL);
}
