/* Server-Sent Events. See events.h.
 *
 * A stream consists of
 *   event: job      data: the object of GET /v1/jobs/{id}. With an id when the change is one of the store's revisions
 *                   (submitted, started, asked to stop, ended, queued again), without one when only progress or outputs did.
 *   event: deleted  data: {"id"}, with an id.
 *   event: reset    data: {}: what was missed cannot be told any more (more than QG_REVISIONS_KEPT revisions ago, or the
 *                   revision is not of this database): read the list again. The stream goes on from now.
 * and comments, ten seconds apart at most, which show the client that the server lives, and the server that the client does.
 *
 * The id is the store's revision. It survives restarts, so a client that comes back with Last-Event-ID (every EventSource
 * does) gets what changed since, in its present state, also when the daemon was stopped meanwhile. Without Last-Event-ID the
 * stream of one job begins with that job; that of all begins with the running ones, after an id: open it first, then read the
 * list, and nothing is missed.
 *
 * The latest state wins. Nothing is kept for a client but two numbers: the revision and the version of the board that it has
 * seen. What it is sent is read from the store when its connection has room, once for all who follow (job_copies.h).
 *
 * The stream of one job ends with the job. A client that comes back to hear more of a job that is over gets 204, at which an
 * EventSource stops asking.
 */
#include "server/calls/events.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/work/job_copies.h"

enum { HEARTBEAT_MS = 10000, RETRY_MS = 2000, CHANGES_PAGE = 50, RUNNING_MAX = 64 };

/* A client that follows. */
struct follower {
    const struct qg_service *service;
    char id[QG_JOB_ID_ROOM];      /* of its job; "": all */
    char token[QG_TOKEN_ID_ROOM]; /* that it came with; "": none */
    int64_t revision;             /* sent so far */
    uint64_t version;             /* the board's, sent so far */
    uint64_t touched;             /* the board's touch that the store was read after */
    int64_t heartbeat;            /* when the next comment is due, monotonic ms */
    bool begun, lost, over;       /* lost: has to be told to reset; over: its job has ended or is gone */
};

static void write_event(struct qg_text *text, const char *name, int64_t revision, const struct qg_text *data) {
    if (revision > 0)
        qg_text_format(text, "id: %lld\n", (long long)revision);
    qg_text_format(text, "event: %s\ndata: ", name);
    qg_text_add(text, data->data ? data->data : "{}", data->length ? data->length : 2);
    qg_text_format(text, "\n\n");
}

/* Writes a job's present state; revision 0 is progress only, but no older than what was sent. A job that is gone is left to
 * the event of its deletion. */
static enum qg_store_status write_job(struct follower *follower, const char *id, int64_t revision,
                                      struct qg_text *text) {
    enum qg_state state;
    struct qg_text data = {0};
    int64_t since = revision > 0 ? revision : follower->revision;
    enum qg_store_status status = qg_job_copy(follower->service->job_copies, id, since, &data, &state);
    if (status != QG_STORE_OK)
        return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
    write_event(text, "job", revision, &data);
    follower->over = *follower->id && qg_state_is_final(state);
    text->failed = text->failed || data.failed;
    qg_text_finish(&data);
    return QG_STORE_OK;
}

static void write_deleted(struct follower *follower, const struct qg_change *change, struct qg_text *text) {
    struct qg_text data = {0};
    qg_json_open(&data, '{');
    qg_json_name(&data, "id");
    qg_json_string(&data, change->id);
    qg_json_close(&data, '}');
    write_event(text, "deleted", change->revision, &data);
    follower->over = *follower->id;
    text->failed = text->failed || data.failed;
    qg_text_finish(&data);
}

/* Writes a page of what changed in the store. *full: there may be more. */
static enum qg_store_status write_changes(struct follower *follower, struct qg_text *text, bool *full) {
    struct qg_change changes[CHANGES_PAGE];
    size_t count = 0;
    uint64_t touched = qg_board_touched(follower->service->board);
    *full = false;
    if (touched == follower->touched && follower->begun && qg_monotonic_clock() < follower->heartbeat)
        return QG_STORE_OK;
    enum qg_store_status status = qg_store_changes(follower->service->store, follower->revision,
                                                   *follower->id ? follower->id : NULL, changes, CHANGES_PAGE, &count);
    for (size_t i = 0; status == QG_STORE_OK && i < count; i++) {
        if (changes[i].deleted)
            write_deleted(follower, &changes[i], text);
        else
            status = write_job(follower, changes[i].id, changes[i].revision, text);
        follower->revision = changes[i].revision;
    }
    *full = count == CHANGES_PAGE;
    if (!*full)
        follower->touched = touched;
    return status;
}

/* Writes the jobs whose progress or outputs changed. */
static enum qg_store_status write_running(struct follower *follower, uint64_t version, struct qg_text *text) {
    char ids[RUNNING_MAX][QG_JOB_ID_ROOM];
    size_t count = qg_board_news(follower->service->board, follower->version, ids, RUNNING_MAX);
    enum qg_store_status status = QG_STORE_OK;
    for (size_t i = 0; status == QG_STORE_OK && i < count; i++)
        if (!*follower->id || strcmp(ids[i], follower->id) == 0)
            status = write_job(follower, ids[i], 0, text);
    follower->version = version;
    return status;
}

/* The first lines: how soon to come back, and from where. */
static void begin(struct follower *follower, struct qg_text *text) {
    qg_text_format(text, "retry: %d\nid: %lld\n\n", RETRY_MS, (long long)follower->revision);
    if (follower->lost)
        write_event(text, "reset", follower->revision, &(struct qg_text){0});
}

/* Fills the pause, or writes a heartbeat when it is time for one. */
static enum qg_stream_step rest(struct follower *follower, uint64_t version, struct qg_text *text,
                                struct qg_pause *pause) {
    int64_t now = qg_monotonic_clock();
    if (text->length == 0 && now < follower->heartbeat) {
        pause->version = version;
        pause->deadline = follower->heartbeat;
        memcpy(pause->id, follower->id, sizeof pause->id);
        return QG_STREAM_PAUSE;
    }
    if (text->length == 0)
        qg_text_format(text, ":\n\n");
    follower->heartbeat = now + HEARTBEAT_MS;
    return QG_STREAM_PIECE;
}

static enum qg_stream_step next(void *self, struct qg_text *text, struct qg_pause *pause) {
    struct follower *follower = self;
    uint64_t version = qg_board_version(follower->service->board); /* before reading: what comes later wakes us */
    bool full = false;
    if (follower->over || qg_board_is_shut(follower->service->board) ||
        !qg_access_is_live(follower->service->access, follower->token))
        return QG_STREAM_END;
    if (!follower->begun)
        begin(follower, text);
    enum qg_store_status status = write_changes(follower, text, &full);
    follower->begun = true;
    if (status == QG_STORE_OK && !full && !follower->over)
        status = write_running(follower, version, text);
    if (status != QG_STORE_OK)
        return QG_STREAM_BROKEN; /* the client comes back and goes on from its last id */
    return rest(follower, version, text, pause);
}

/* Sets where the stream begins. False and a problem when the client's revision is no number. */
static bool find_start(struct follower *follower, const struct qg_request *request, struct qg_reply *reply) {
    int64_t last = 0, seen = 0;
    enum qg_store_status status = qg_store_revision(follower->service->store, &last);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return false;
    }
    if (request->last_event_id && !qg_read_whole_number(request->last_event_id, 0, INT64_MAX, &seen)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "Last-Event-ID: found \"%.40s\", allowed is the id of an event",
                         request->last_event_id);
        return false;
    }
    follower->lost = request->last_event_id && (seen > last || seen < last - QG_REVISIONS_KEPT);
    follower->revision = request->last_event_id && !follower->lost ? seen : last;
    return true;
}

/* One job's stream begins before the job's last change, so that its state comes first. 204 when there is no more to come. */
static bool find_job(struct follower *follower, const struct qg_request *request, struct qg_reply *reply) {
    struct qg_job_row row;
    struct qg_change change;
    size_t count = 0;
    enum qg_store_status status = qg_store_job(follower->service->store, request->parameter, &row);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return false;
    }
    memcpy(follower->id, row.id, sizeof follower->id);
    bool is_final = qg_state_is_final(row.state);
    qg_job_row_finish(&row);
    if (!request->last_event_id || follower->lost)
        follower->revision = 0;
    follower->lost = false;
    status = qg_store_changes(follower->service->store, follower->revision, follower->id, &change, 1, &count);
    if (status != QG_STORE_OK)
        qg_reply_store_problem(reply, status);
    else if (is_final && count == 0)
        reply->status = 204;
    return reply->status == 0;
}

static void follow(const struct qg_service *service, const struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    struct follower *follower = calloc(1, sizeof *follower);
    if (!follower) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory for a stream");
        return;
    }
    follower->service = service;
    memcpy(follower->token, request->actor.token, sizeof follower->token);
    if (!find_start(follower, request, reply) || (request->parameter && !find_job(follower, request, reply))) {
        free(follower);
        return;
    }
    reply->status = 200;
    reply->media_type = request->media_type;
    reply->stream = (struct qg_stream){.next = next, .destroy = free, .self = follower, .endless = true};
    qg_reply_header(reply, "Cache-Control", "no-store");
}

void qg_follow_job(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    follow(service, request, reply);
}

void qg_follow_jobs(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    follow(service, request, reply);
}
