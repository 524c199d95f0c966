/* The store's part on access. See access.h. */
#include "server/store/access.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "server/store/internal.h"

static void copy(char *out, size_t room, sqlite3_stmt *statement, int column) {
    const unsigned char *text = sqlite3_column_text(statement, column);
    snprintf(out, room, "%s", text ? (const char *)text : "");
}

/* --- the audit log --- */

const char *const qg_actions[] = {"job.submit",      "job.cancel",      "job.delete",       "token.create",
                                  "token.revoke",    "token.expire",    "webhook.create",   "webhook.delete",
                                  "webhook.disable", "database.backup", "database.restore", "access.refuse",
                                  "daemon.start",    "daemon.stop",     "daemon.reload",    NULL};

bool qg_action_is_known(const char *action) {
    const size_t length = strlen(action);
    for (size_t i = 0; qg_actions[i]; i++)
        if (length > 0 && strncmp(qg_actions[i], action, length) == 0 &&
            (qg_actions[i][length] == '.' || qg_actions[i][length] == '\0'))
            return true;
    return false;
}

enum qg_store_status qg_store_audited(struct qg_store *store, enum qg_store_status status, const struct qg_actor *actor,
                                      const char *action, const char *subject) {
    static const struct qg_actor daemon = {.name = "quietgeard"};
    assert(strchr(action, '.') && qg_action_is_known(action));
    if (status != QG_STORE_OK)
        return status;
    if (!actor)
        actor = &daemon;
    status = qg_sql_run(store->writer,
                        "INSERT INTO audit (at, token, name, address, action, subject) VALUES (?, ?, ?, ?, ?, ?)",
                        "isssss", qg_wall_clock(), actor->token, actor->name, actor->address, action, subject);
    struct qg_audit_entry *entry = &store->audited;
    snprintf(entry->action, sizeof entry->action, "%s", action);
    snprintf(entry->subject, sizeof entry->subject, "%s", subject);
    memcpy(entry->token, actor->token, sizeof entry->token);
    memcpy(entry->name, actor->name, sizeof entry->name);
    memcpy(entry->address, actor->address, sizeof entry->address);
    return status;
}

enum qg_store_status qg_store_note(struct qg_store *store, const struct qg_actor *actor, const char *action,
                                   const char *subject) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    return qg_store_end(store, qg_store_audited(store, QG_STORE_OK, actor, action, subject));
}

static void read_entry(sqlite3_stmt *statement, struct qg_audit_entry *entry) {
    entry->sequence = sqlite3_column_int64(statement, 0);
    entry->at = sqlite3_column_int64(statement, 1);
    copy(entry->token, sizeof entry->token, statement, 2);
    copy(entry->name, sizeof entry->name, statement, 3);
    copy(entry->address, sizeof entry->address, statement, 4);
    copy(entry->action, sizeof entry->action, statement, 5);
    copy(entry->subject, sizeof entry->subject, statement, 6);
}

/* The oldest of the sequences below `before` that one call looks at; 0 when it reaches the log's beginning. The reader's mutex
 * is held. */
static int64_t find_horizon(struct qg_store *store, int64_t before) {
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader, "SELECT seq FROM audit WHERE seq < ? ORDER BY seq DESC LIMIT 1 OFFSET ?", "ii",
                       before, (int64_t)QG_AUDIT_LOOK - 1);
    int64_t horizon = qg_sql_row(statement) == QG_STORE_OK ? sqlite3_column_int64(statement, 0) : 0;
    sqlite3_finalize(statement);
    return horizon;
}

enum qg_store_status qg_store_audit(struct qg_store *store, const struct qg_audit_filter *filter,
                                    struct qg_audit_page *page) {
    static const char sql[] =
        "SELECT seq, at, token, name, address, action, subject FROM audit WHERE seq < ?1 AND seq >= ?2"
        " AND (?3 IS NULL OR action = ?3 OR substr(action, 1, length(?3) + 1) = ?3 || '.')"
        " AND (?4 IS NULL OR token = ?4 OR name = ?4) AND (?5 IS NULL OR subject = ?5) AND (?6 IS NULL OR address = ?6)"
        " AND +at >= ?7 AND (?8 = 0 OR at < ?8) ORDER BY seq DESC LIMIT ?9";
    const int64_t before = filter->before > 0 ? filter->before : INT64_MAX;
    page->count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    page->next = find_horizon(store, before);
    sqlite3_stmt *statement =
        qg_sql_prepare(store->reader, sql, "iissssiii", before, page->next, filter->action, filter->actor,
                       filter->subject, filter->address, filter->since, filter->until, (int64_t)page->room);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        read_entry(statement, &page->entry[page->count++]);
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

enum qg_store_status qg_store_drop_log(struct qg_store *store, int64_t before) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    int changes = sqlite3_total_changes(store->writer);
    status = qg_sql_run(store->writer,
                        "DELETE FROM audit WHERE seq IN (SELECT seq FROM audit WHERE at < ? ORDER BY at LIMIT 2000)",
                        "i", before);
    if (status == QG_STORE_OK)
        status = qg_sql_run(store->writer,
                            "DELETE FROM deliveries WHERE seq IN (SELECT seq FROM deliveries"
                            " WHERE state <> 'pending' AND created_at < ? ORDER BY created_at LIMIT 2000)",
                            "i", before);
    if (status == QG_STORE_OK && sqlite3_total_changes(store->writer) == changes)
        status = QG_STORE_NOT_FOUND;
    return qg_store_end(store, status);
}

/* --- tokens --- */

static bool read_token(sqlite3_stmt *statement, struct qg_token *token) {
    memset(token, 0, sizeof *token);
    copy(token->id, sizeof token->id, statement, 0);
    copy(token->name, sizeof token->name, statement, 1);
    token->scopes = (unsigned)sqlite3_column_int(statement, 2);
    token->created_at = sqlite3_column_int64(statement, 3);
    token->expires_at = sqlite3_column_int64(statement, 5); /* NULL is 0 */
    token->last_used_at = sqlite3_column_int64(statement, 6);
    token->requests_per_minute = sqlite3_column_int(statement, 7);
    token->queued_jobs = sqlite3_column_int(statement, 8);
    const unsigned char *hash = sqlite3_column_text(statement, 4);
    return hash && qg_hex_read(token->hash, sizeof token->hash, (const char *)hash);
}

enum qg_store_status qg_store_tokens(struct qg_store *store, struct qg_token *out, size_t room, size_t *count) {
    *count = 0;
    pthread_mutex_lock(&store->reader_mutex);
    sqlite3_stmt *statement = qg_sql_prepare(
        store->reader,
        "SELECT id, name, scopes, created_at, hash, expires_at, last_used_at, requests_per_minute, queued_jobs"
        " FROM tokens ORDER BY created_at, id LIMIT ?",
        "i", (int64_t)room);
    enum qg_store_status status;
    while ((status = qg_sql_row(statement)) == QG_STORE_OK)
        if (read_token(statement, &out[*count]))
            ++*count;
    sqlite3_finalize(statement);
    pthread_mutex_unlock(&store->reader_mutex);
    return status == QG_STORE_NOT_FOUND ? QG_STORE_OK : status;
}

enum qg_store_status qg_store_token_add(struct qg_store *store, const struct qg_token *token,
                                        const struct qg_actor *actor) {
    char hash[2 * QG_HASH_BYTES + 1];
    qg_hex_write(hash, token->hash, sizeof token->hash);
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(
        store->writer,
        "INSERT INTO tokens (id, name, scopes, created_at, hash, expires_at, requests_per_minute, queued_jobs)"
        " VALUES (?, ?, ?, ?, ?, nullif(?, 0), nullif(?, 0), nullif(?, 0))",
        "ssiisiii", token->id, token->name, (int64_t)token->scopes, token->created_at, hash, token->expires_at,
        (int64_t)token->requests_per_minute, (int64_t)token->queued_jobs);
    return qg_store_end(store, qg_store_audited(store, status, actor, "token.create", token->id));
}

enum qg_store_status qg_store_token_remove(struct qg_store *store, const char *id, const struct qg_actor *actor) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    status = qg_sql_run(store->writer, "DELETE FROM tokens WHERE id = ?", "s", id);
    if (status == QG_STORE_OK && sqlite3_changes(store->writer) == 0)
        status = QG_STORE_NOT_FOUND;
    return qg_store_end(store, qg_store_audited(store, status, actor, actor ? "token.revoke" : "token.expire", id));
}

enum qg_store_status qg_store_tokens_used(struct qg_store *store, const struct qg_token *tokens, size_t count) {
    enum qg_store_status status = qg_store_begin(store);
    if (status != QG_STORE_OK)
        return status;
    for (size_t i = 0; i < count && status == QG_STORE_OK; i++)
        status = qg_sql_run(store->writer, "UPDATE tokens SET last_used_at = ? WHERE id = ?", "is",
                            tokens[i].last_used_at, tokens[i].id);
    return qg_store_end(store, status);
}
