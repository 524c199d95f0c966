/* Handing out a copy of the database. See backup.h. */
#include "server/calls/backup.h"

#include <stdlib.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/store/access.h"
#include "server/store/backup.h"

enum { LOOK_MS = 200, PIECE = 1 << 16 };

static enum qg_stream_step next_piece(void *self, struct qg_text *piece, struct qg_pause *pause) {
    (void)pause;
    char *block = malloc(PIECE);
    ssize_t length = block ? read(*(int *)self, block, PIECE) : -1;
    if (length > 0)
        qg_text_add(piece, block, (size_t)length);
    free(block);
    if (length < 0)
        return QG_STREAM_BROKEN;
    return length > 0 ? QG_STREAM_PIECE : QG_STREAM_END;
}

static void close_file(void *self) {
    close(*(int *)self);
    free(self);
}

/* Makes the file the reply's body. */
static void reply_file(struct qg_reply *reply, int descriptor) {
    int *kept = malloc(sizeof *kept);
    if (!kept) {
        close(descriptor);
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory for the answer");
        return;
    }
    *kept = descriptor;
    reply->status = 200;
    reply->media_type = "application/vnd.sqlite3";
    reply->stream = (struct qg_stream){.next = next_piece, .destroy = close_file, .self = kept};
    qg_reply_header(reply, "Cache-Control", "no-store");
    qg_reply_header(reply, "Content-Disposition", "attachment; filename=\"quietgear.db\"");
}

void qg_get_backup(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    int descriptor = -1;
    enum qg_store_status reason;
    if (!qg_request_has_no_query(request, reply))
        return;
    if (!request->wait.begun) {
        if (qg_store_note(service->store, &request->actor, "database.backup", "quietgear.db") != QG_STORE_OK)
            qg_log(QG_LOG_WARNING, "backup: the audit log cannot be written; the backup is made all the same");
        request->wait.begun = true;
        request->wait.number = qg_backup_begin(service->backups);
        if (!request->wait.number) {
            qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "another backup is being made; ask again when it is done");
            return;
        }
    }
    switch (qg_backup_collect(service->backups, request->wait.number, &descriptor, &reason)) {
    case QG_BACKUP_READY:
        reply_file(reply, descriptor);
        break;
    case QG_BACKUP_FAILED:
        qg_reply_store_problem(reply, reason);
        break;
    case QG_BACKUP_PENDING:
        if (qg_board_is_shut(service->board))
            qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "the server is stopping");
        else
            qg_reply_later(reply, service->board, LOOK_MS);
        break;
    }
}
