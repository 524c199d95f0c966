/* The store's part on webhooks. See webhooks.h. */
#include "server/store/webhooks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/member.h"
#include "server/store/internal.h"

static const char *text_of(sqlite3_stmt *statement, int column) {
    return (const char *)sqlite3_column_text(statement, column);
}

static void copy(char *out, size_t room, sqlite3_stmt *statement, int column) {
    const unsigned char *text = sqlite3_column_text(statement, column);
    snprintf(out, room, "%s", text ? (const char *)text : "");
}

/* --- subscriptions --- */

#define WEBHOOK_COLUMNS "id, url, events, secret, created_at, disabled_at"

static void read_webhook(sqlite3_stmt *statement, struct qg_webhook *webhook) {
    copy(webhook->id, sizeof webhook->id, statement, 0);
    copy(webhook->url, sizeof webhook->url, statement, 1);
    webhook->events = (unsigned)sqlite3_column_int(statement, 2);
    copy(webhook->secret, sizeof webhook->secret, statement, 3);
    webhook->created_at = sqlite3_column_int64(statement, 4);
    webhook->disabled_at = sqlite3_column_int64(statement, 5);
}

/* QG_STORE_QUEUE_FULL when there is no room for another one. */
static enum qg_store_status check_room(struct qg_store *store) {
    sqlite3_stmt *statement = qg_sql_prepare(store->writer, "SELECT count(*) FROM webhooks", "");
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK && sqlite3_column_int64(statement, 0) >= QG_WEBHOOKS_MAX)
        status = QG_STORE_QUEUE_FULL;
    sqlite3_finalize(statement);
    return status;
}

enum qg_store_status qg_store_webhook_add(struct qg_store *store, const struct qg_webhook *webhook,
                                          const struct qg_actor *actor) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = check_room(store);
    if (status == QG_STORE_OK)
        status = qg_sql_run(
            store->writer, "INSERT INTO webhooks (id, url, events, secret, created_at) VALUES (?, ?, ?, ?, ?)", "ssisi",
            webhook->id, webhook->url, (int64_t)webhook->events, webhook->secret, webhook->created_at);
    return qg_store_end(store, qg_store_audited(store, status, actor, "webhook.create", webhook->id));
}

enum qg_store_status qg_store_drop_deliveries(struct qg_store *store, const char *webhook) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer,
                        "DELETE FROM deliveries WHERE seq IN (SELECT seq FROM deliveries WHERE webhook = ?"
                        " ORDER BY seq LIMIT 1000)",
                        "s", webhook);
    if (status == QG_STORE_OK && sqlite3_changes(store->writer) == 0)
        status = QG_STORE_NOT_FOUND;
    return qg_store_end(store, status);
}

enum qg_store_status qg_store_webhook_remove(struct qg_store *store, const char *id, const struct qg_actor *actor) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer, "DELETE FROM webhooks WHERE id = ?", "s", id);
    if (status == QG_STORE_OK && sqlite3_changes(store->writer) == 0)
        status = QG_STORE_NOT_FOUND;
    return qg_store_end(store, qg_store_audited(store, status, actor, "webhook.delete", id));
}

enum qg_store_status qg_store_webhook(struct qg_store *store, const char *id, struct qg_webhook *out) {
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader, "SELECT " WEBHOOK_COLUMNS " FROM webhooks WHERE id = ?", "s", id);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK)
        read_webhook(statement, out);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status;
}

enum qg_store_status qg_store_webhooks(struct qg_store *store, struct qg_webhook *out, size_t *count) {
    *count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader, "SELECT " WEBHOOK_COLUMNS " FROM webhooks ORDER BY created_at, id LIMIT ?", "i",
                       (int64_t)QG_WEBHOOKS_MAX);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        read_webhook(statement, &out[(*count)++]);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

/* --- the log of deliveries --- */

static void read_delivery(sqlite3_stmt *statement, struct qg_delivery *out) {
    out->sequence = sqlite3_column_int64(statement, 0);
    copy(out->id, sizeof out->id, statement, 1);
    copy(out->event, sizeof out->event, statement, 2);
    copy(out->job, sizeof out->job, statement, 3);
    copy(out->state, sizeof out->state, statement, 4);
    out->attempts = sqlite3_column_int(statement, 5);
    out->created_at = sqlite3_column_int64(statement, 6);
    out->last_attempt_at = sqlite3_column_int64(statement, 7);
    out->next_attempt_at = strcmp(out->state, "pending") == 0 ? sqlite3_column_int64(statement, 8) : 0;
    out->last_status = sqlite3_column_int(statement, 9);
    copy(out->last_error, sizeof out->last_error, statement, 10);
}

enum qg_store_status qg_store_deliveries(struct qg_store *store, const char *webhook, int64_t before, size_t room,
                                         struct qg_delivery *out, size_t *count) {
    *count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader,
                       "SELECT seq, id, event, job, state, attempts, created_at, last_attempt_at, next_attempt_at,"
                       " last_status, last_error FROM deliveries"
                       " WHERE webhook = ? AND seq < ? ORDER BY seq DESC LIMIT ?",
                       "sii", webhook, before > 0 ? before : INT64_MAX, (int64_t)room);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        read_delivery(statement, &out[(*count)++]);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

/* --- the sender's side --- */

void qg_dispatch_finish(struct qg_dispatch *dispatch) {
    qg_secret_wipe(dispatch->secret, sizeof dispatch->secret);
    free(dispatch->body);
    dispatch->body = NULL;
}

/* What the receiver reads, from columns 6 to 13: event, time, job, name, kind, labels, error, external_id. */
static char *write_body(sqlite3_stmt *statement) {
    const char *event = text_of(statement, 6);
    struct qg_text text = {0};
    char link[64];
    snprintf(link, sizeof link, "/v1/jobs/%s", text_of(statement, 8));
    qg_json_open(&text, '{');
    qg_member_text(&text, "type", event);
    qg_member_time(&text, "timestamp", sqlite3_column_int64(statement, 7));
    qg_json_name(&text, "data");
    qg_json_open(&text, '{');
    qg_member_text(&text, "id", text_of(statement, 8));
    qg_member_text(&text, "name", text_of(statement, 9));
    qg_member_text(&text, "kind", text_of(statement, 10));
    qg_member_text(&text, "external_id", text_of(statement, 13));
    qg_json_name(&text, "labels");
    qg_json_raw(&text, text_of(statement, 11));
    qg_member_text(&text, "state", event + strlen("job."));
    qg_member_text(&text, "error", text_of(statement, 12));
    qg_json_name(&text, "links");
    qg_json_open(&text, '{');
    qg_member_text(&text, "self", link);
    for (int level = 0; level < 3; level++)
        qg_json_close(&text, '}');
    if (text.failed)
        qg_text_finish(&text);
    return text.data;
}

static bool read_dispatch(sqlite3_stmt *statement, struct qg_dispatch *out) {
    out->sequence = sqlite3_column_int64(statement, 0);
    copy(out->id, sizeof out->id, statement, 1);
    copy(out->webhook, sizeof out->webhook, statement, 2);
    copy(out->url, sizeof out->url, statement, 3);
    copy(out->secret, sizeof out->secret, statement, 4);
    out->attempts = sqlite3_column_int(statement, 5);
    out->body = write_body(statement);
    return out->body;
}

/* When the next delivery will be due that is not due now. The reader's mutex is held. */
static enum qg_store_status read_next(struct qg_store *store, int64_t now, int64_t *next) {
    sqlite3_stmt *statement = qg_sql_prepare(
        store->reader, "SELECT min(next_attempt_at) FROM deliveries WHERE state = 'pending' AND next_attempt_at > ?",
        "i", now);
    enum qg_store_status status = qg_sql_row(statement);
    if (status == QG_STORE_OK && sqlite3_column_type(statement, 0) != SQLITE_NULL)
        *next = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return status;
}

enum qg_store_status qg_store_due(struct qg_store *store, int64_t now, struct qg_dispatch *out, size_t *count,
                                  int64_t *next) {
    *count = 0;
    *next = INT64_MAX;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader,
                       "SELECT seq, deliveries.id, webhook, url, secret, attempts, event,"
                       " deliveries.created_at, job, name, kind, labels, error, external_id FROM deliveries"
                       " JOIN webhooks ON webhooks.id = webhook WHERE seq IN (SELECT (SELECT seq FROM deliveries"
                       " WHERE webhook = webhooks.id AND state = 'pending' AND next_attempt_at <= ?"
                       " ORDER BY next_attempt_at, seq LIMIT 1) FROM webhooks) ORDER BY seq LIMIT ?",
                       "ii", now, (int64_t)QG_WEBHOOKS_MAX);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK && read_dispatch(statement, &out[*count]))
        ++*count;
    sqlite3_finalize(statement);
    if (status == QG_STORE_NOT_FOUND)
        status = read_next(store, now, next);
    else if (status == QG_STORE_OK)
        status = QG_STORE_FAILED; /* no memory for a body */
    pthread_mutex_unlock(&store->reader_mutex);
    while (status != QG_STORE_OK && *count > 0)
        qg_dispatch_finish(&out[--*count]);
    return status;
}

/* The receiver has answered 410: it is not asked again. */
static enum qg_store_status disable(struct qg_store *store, const char *webhook, int64_t now) {
    enum qg_store_status status =
        qg_sql_run(store->writer, "UPDATE webhooks SET disabled_at = ? WHERE id = ?", "is", now, webhook);
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer,
                            "UPDATE deliveries SET state = 'failed', last_error = 'the webhook was disabled'"
                            " WHERE webhook = ? AND state = 'pending'",
                            "s", webhook);
    return qg_store_audited(store, status, NULL, "webhook.disable", webhook);
}

enum qg_store_status qg_store_attempted(struct qg_store *store, const struct qg_dispatch *dispatch,
                                        const struct qg_outcome *outcome) {
    const char *state = outcome->delivered ? "delivered" : outcome->retry_at && !outcome->gone ? "pending" : "failed";
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer,
                        "UPDATE deliveries SET state = ?, attempts = attempts + 1, last_attempt_at = ?,"
                        " next_attempt_at = ?, last_status = ?, last_error = ? WHERE seq = ? AND state = 'pending'",
                        "siiisi", state, outcome->at, outcome->retry_at, (int64_t)outcome->status, outcome->error,
                        dispatch->sequence);
    if (status == QG_STORE_OK && outcome->gone && sqlite3_changes(store->writer) > 0)
        status = disable(store, dispatch->webhook, outcome->at);
    return qg_store_end(store, status);
}

/* --- news --- */

static void note_change(void *self, int operation, const char *database, const char *table, sqlite3_int64 row) {
    struct qg_store *store = self;
    (void)database;
    (void)row;
    if (operation == SQLITE_INSERT && strcmp(table, "deliveries") == 0)
        store->has_deliveries = true;
}

void qg_store_on_deliveries(struct qg_store *store, void (*call)(void *self), void *self) {
    pthread_mutex_lock(&store->writer_mutex);
    store->on_deliveries = call;
    store->on_deliveries_self = self;
    sqlite3_update_hook(store->writer, call ? note_change : NULL, store);
    pthread_mutex_unlock(&store->writer_mutex);
}
