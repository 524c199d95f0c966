/* Making backups and handing them out. See backup.h.
 *
 * One mutex guards the state; it is not held while the copy is made. The thread of a copy is joined when the next one begins,
 * or at the end.
 */
#include "server/store/backup.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "server/base/log.h"
#include "server/store/access.h"
#include "server/store/internal.h"

enum { PAGES_AT_ONCE = 500 };

struct qg_backups {
    char source[PATH_MAX], copy[PATH_MAX];
    atomic_bool stopping;
    pthread_mutex_t mutex; /* guards what follows */
    pthread_t thread;
    bool has_thread;
    uint64_t number; /* of the last copy that was begun */
    enum qg_backup_state state;
    enum qg_store_status reason; /* when it failed */
    int descriptor;              /* when it is ready and not collected; else -1 */
};

/* --- making one --- */

static sqlite3 *open_database(const char *path, int flags, const char *setup) {
    sqlite3 *database = NULL;
    if (sqlite3_open_v2(path, &database, flags, NULL) == SQLITE_OK &&
        sqlite3_exec(database, setup, NULL, NULL, NULL) == SQLITE_OK)
        return database;
    qg_sql_failure(database, "opening a database for a backup");
    sqlite3_close(database);
    return NULL;
}

/* Copies page by page; the source's connection holds its read transaction all the time. */
static enum qg_store_status copy_pages(struct qg_backups *backups, sqlite3 *source, sqlite3 *copy) {
    sqlite3_backup *backup = sqlite3_backup_init(copy, "main", source, "main");
    int code = SQLITE_OK;
    while (backup && code == SQLITE_OK && !atomic_load(&backups->stopping))
        code = sqlite3_backup_step(backup, PAGES_AT_ONCE);
    sqlite3_backup_finish(backup);
    if (code == SQLITE_OK) /* broken off */
        return backup ? QG_STORE_LOST : qg_sql_failure(copy, "beginning a backup");
    return code == SQLITE_DONE ? QG_STORE_OK : qg_sql_failure(copy, "copying the database");
}

/* Makes the copy a file of its own, without a write-ahead log, and checks it. */
static enum qg_store_status complete(sqlite3 *copy) {
    enum qg_store_status status = qg_sql_run(copy, "PRAGMA journal_mode = DELETE", "");
    return status == QG_STORE_OK ? qg_store_check(copy) : status;
}

static enum qg_store_status make_copy(struct qg_backups *backups) {
    enum qg_store_status status = QG_STORE_UNAVAILABLE;
    sqlite3 *source = open_database(backups->source, SQLITE_OPEN_READONLY,
                                    "PRAGMA wal_autocheckpoint = 0; BEGIN; SELECT count(*) FROM sqlite_schema;");
    sqlite3 *copy = open_database(backups->copy, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                                  "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;");
    if (source && copy)
        status = copy_pages(backups, source, copy);
    sqlite3_close(source);
    if (status == QG_STORE_OK)
        status = complete(copy);
    sqlite3_close(copy);
    return status;
}

static void *work(void *self) {
    struct qg_backups *backups = self;
    unlink(backups->copy);
    enum qg_store_status status = make_copy(backups);
    int descriptor = status == QG_STORE_OK ? open(backups->copy, O_RDONLY | O_CLOEXEC) : -1;
    if (status == QG_STORE_OK && descriptor < 0)
        status = QG_STORE_UNAVAILABLE;
    unlink(backups->copy);
    bool made = status == QG_STORE_OK;
    qg_log_event(&(struct qg_log_event){.priority = made ? QG_LOG_NOTICE : QG_LOG_WARNING,
                                        .event = made ? QG_EVENT_BACKUP_MADE : QG_EVENT_BACKUP_FAILED},
                 "backup: %s",
                 made                      ? "made and checked"
                 : status == QG_STORE_LOST ? "broken off, the daemon stops"
                                           : "failed; the line above says why");
    pthread_mutex_lock(&backups->mutex);
    backups->descriptor = descriptor;
    backups->reason = status == QG_STORE_LOST ? QG_STORE_UNAVAILABLE : status;
    backups->state = status == QG_STORE_OK ? QG_BACKUP_READY : QG_BACKUP_FAILED;
    pthread_mutex_unlock(&backups->mutex);
    return NULL;
}

/* Drops what nobody has collected. The mutex is held, and nothing is being made. */
static void drop(struct qg_backups *backups) {
    if (backups->has_thread)
        pthread_join(backups->thread, NULL);
    if (backups->descriptor >= 0)
        close(backups->descriptor);
    backups->has_thread = false;
    backups->descriptor = -1;
}

struct qg_backups *qg_backups_create(const char *directory) {
    struct qg_backups *backups = calloc(1, sizeof *backups);
    if (!backups)
        return NULL;
    snprintf(backups->source, sizeof backups->source, "%s/quietgear.db", directory);
    snprintf(backups->copy, sizeof backups->copy, "%s/backup.tmp", directory);
    unlink(backups->copy);
    backups->descriptor = -1;
    backups->state = QG_BACKUP_FAILED;
    pthread_mutex_init(&backups->mutex, NULL);
    return backups;
}

void qg_backups_destroy(struct qg_backups *backups) {
    if (!backups)
        return;
    atomic_store(&backups->stopping, true);
    drop(backups);
    pthread_mutex_destroy(&backups->mutex);
    free(backups);
}

uint64_t qg_backup_begin(struct qg_backups *backups) {
    uint64_t number = 0;
    pthread_mutex_lock(&backups->mutex);
    if (backups->state != QG_BACKUP_PENDING) {
        drop(backups);
        backups->has_thread = pthread_create(&backups->thread, NULL, work, backups) == 0;
        backups->state = backups->has_thread ? QG_BACKUP_PENDING : QG_BACKUP_FAILED;
        backups->reason = QG_STORE_UNAVAILABLE;
        number = backups->has_thread ? ++backups->number : 0;
    }
    pthread_mutex_unlock(&backups->mutex);
    return number;
}

enum qg_backup_state qg_backup_collect(struct qg_backups *backups, uint64_t number, int *descriptor,
                                       enum qg_store_status *reason) {
    pthread_mutex_lock(&backups->mutex);
    enum qg_backup_state state = number == backups->number ? backups->state : QG_BACKUP_FAILED;
    *reason = number == backups->number ? backups->reason : QG_STORE_UNAVAILABLE;
    if (state == QG_BACKUP_READY) {
        *descriptor = backups->descriptor;
        backups->descriptor = -1;
        backups->state = QG_BACKUP_FAILED;
        backups->reason = QG_STORE_UNAVAILABLE;
    }
    pthread_mutex_unlock(&backups->mutex);
    return state;
}
