/* Sleeping connections, and what is on its way out: texts and streams. See stream.h. */
#include "server/http/stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 32 << 10 };

/* --- sleeping --- */

/* Called with the board's mutex held, as is wake. */
static void fall_asleep(void *self) {
    struct qg_sleeper *sleeper = self;
    sleeper->asleep = true;
    atomic_fetch_add(&sleeper->sleepers->asleep, 1);
    MHD_suspend_connection(sleeper->connection);
}

static void wake(void *self) {
    struct qg_sleeper *sleeper = self;
    MHD_resume_connection(sleeper->connection);
}

bool qg_sleep(struct qg_sleepers *sleepers, struct qg_sleeper *sleeper, struct MHD_Connection *connection,
              const struct qg_pause *pause) {
    sleeper->sleepers = sleepers;
    sleeper->connection = connection;
    sleeper->waiter =
        (struct qg_waiter){.deadline = pause->deadline, .suspend = fall_asleep, .resume = wake, .context = sleeper};
    memcpy(sleeper->waiter.id, pause->id, sizeof sleeper->waiter.id);
    return qg_board_wait(sleepers->board, &sleeper->waiter, pause->version);
}

void qg_awake(struct qg_sleepers *sleepers, struct qg_sleeper *sleeper) {
    if (sleeper->asleep)
        atomic_fetch_sub(&sleepers->asleep, 1);
    sleeper->asleep = false;
}

/* --- texts --- */

size_t qg_reply_bytes(const struct qg_reply *reply) {
    if (reply->stream.self)
        return reply->stream.endless ? 0 : QG_STREAM_BYTES + reply->stream.kept;
    return reply->body.data ? reply->body.length : 0;
}

/* A text on its way out. */
struct parcel {
    struct qg_hold *hold;
    struct qg_text text;
};

static void free_parcel(void *self) {
    struct parcel *parcel = self;
    qg_hold_give(parcel->hold, parcel->text.length);
    qg_text_finish(&parcel->text);
    free(parcel);
}

struct MHD_Response *qg_text_response(struct qg_hold *hold, struct qg_text *text) {
    static char nothing[1];
    if (!text->data)
        return MHD_create_response_from_buffer(0, nothing, MHD_RESPMEM_PERSISTENT);
    struct parcel *parcel = malloc(sizeof *parcel);
    if (!parcel)
        return NULL;
    *parcel = (struct parcel){hold, *text};
    struct MHD_Response *response =
        MHD_create_response_from_buffer_with_free_callback_cls(text->length, text->data, free_parcel, parcel);
    if (response)
        *text = (struct qg_text){0}; /* the response's from here on */
    else
        free(parcel);
    return response;
}

/* --- who is here --- */

static const char *client_of(const struct qg_actor *actor) {
    return *actor->token ? actor->token : actor->address;
}

static void enter(struct qg_sleepers *sleepers, struct qg_presence *presence, const struct qg_actor *actor) {
    snprintf(presence->client, sizeof presence->client, "%s", client_of(actor));
    presence->is_here = true;
    presence->next = sleepers->first;
    if (presence->next)
        presence->next->previous = presence;
    sleepers->first = presence;
    sleepers->streams += presence->is_stream;
}

static void leave(struct qg_sleepers *sleepers, struct qg_presence *presence) {
    if (presence->previous)
        presence->previous->next = presence->next;
    else
        sleepers->first = presence->next;
    if (presence->next)
        presence->next->previous = presence->previous;
    presence->is_here = false;
    sleepers->streams -= presence->is_stream;
}

/* True when a client holds as many streams, or polls, as it may. */
static bool has_its_share(const struct qg_sleepers *sleepers, const struct qg_actor *actor, bool of_streams) {
    const char *client = client_of(actor);
    int own = 0;
    for (const struct qg_presence *other = sleepers->first; other && *client; other = other->next)
        own += other->is_stream == of_streams && strcmp(other->client, client) == 0;
    return sleepers->client_max > 0 && own >= sleepers->client_max;
}

enum qg_stream_room qg_stream_room(const struct qg_sleepers *sleepers, const struct qg_actor *actor) {
    if (has_its_share(sleepers, actor, true))
        return QG_STREAM_NONE_FOR_CLIENT;
    return sleepers->streams < QG_STREAMS_MAX ? QG_STREAM_ROOM : QG_STREAM_NONE;
}

bool qg_poll_enter(struct qg_sleepers *sleepers, struct qg_presence *presence, const struct qg_actor *actor) {
    if (presence->is_here)
        return true;
    if (has_its_share(sleepers, actor, false))
        return false;
    enter(sleepers, presence, actor);
    return true;
}

void qg_poll_leave(struct qg_sleepers *sleepers, struct qg_presence *presence) {
    if (presence->is_here)
        leave(sleepers, presence);
}

/* --- streams --- */

/* A stream on its way out. */
struct reader {
    struct qg_presence presence;
    struct qg_sleepers *sleepers;
    struct MHD_Connection *connection;
    struct qg_sleeper sleeper;
    struct qg_stream stream;
    struct qg_text piece;
    size_t sent;    /* of the piece */
    int64_t *bytes; /* sent of the whole */
};

/* Makes the next piece, or falls asleep. */
static enum qg_stream_step advance(struct reader *reader) {
    for (;;) {
        struct qg_pause pause = {0};
        qg_text_finish(&reader->piece);
        reader->sent = 0;
        enum qg_stream_step step = reader->stream.next(reader->stream.self, &reader->piece, &pause);
        if (reader->piece.failed)
            return QG_STREAM_BROKEN;
        if (step != QG_STREAM_PAUSE || qg_sleep(reader->sleepers, &reader->sleeper, reader->connection, &pause))
            return step;
    }
}

static ssize_t read_stream(void *self, uint64_t position, char *out, size_t room) {
    (void)position;
    struct reader *reader = self;
    qg_awake(reader->sleepers, &reader->sleeper);
    if (reader->sent == reader->piece.length) {
        switch (advance(reader)) {
        case QG_STREAM_PIECE:
            break;
        case QG_STREAM_PAUSE:
            return 0;
        case QG_STREAM_END:
            return MHD_CONTENT_READER_END_OF_STREAM;
        case QG_STREAM_BROKEN:
            return MHD_CONTENT_READER_END_WITH_ERROR;
        }
    }
    size_t length = reader->piece.length - reader->sent;
    if (length > room)
        length = room;
    memcpy(out, reader->piece.data + reader->sent, length);
    reader->sent += length;
    *reader->bytes += (int64_t)length;
    return (ssize_t)length;
}

static void free_stream(void *self) {
    struct reader *reader = self;
    qg_awake(reader->sleepers, &reader->sleeper);
    if (reader->stream.endless)
        leave(reader->sleepers, &reader->presence);
    else
        qg_hold_give(reader->sleepers->hold, QG_STREAM_BYTES + reader->stream.kept);
    qg_text_finish(&reader->piece);
    reader->stream.destroy(reader->stream.self);
    free(reader);
}

struct MHD_Response *qg_stream_response(struct qg_sleepers *sleepers, struct MHD_Connection *connection,
                                        const struct qg_actor *actor, struct qg_stream *stream, int64_t *bytes) {
    struct reader *reader = calloc(1, sizeof *reader);
    if (!reader)
        return NULL;
    reader->sleepers = sleepers;
    reader->connection = connection;
    reader->stream = *stream;
    reader->bytes = bytes;
    struct MHD_Response *response =
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK, read_stream, reader, free_stream);
    if (!response) {
        free(reader);
        return NULL;
    }
    reader->presence.is_stream = stream->endless;
    if (stream->endless)
        enter(sleepers, &reader->presence, actor);
    stream->self = NULL; /* the response's from here on */
    return response;
}
