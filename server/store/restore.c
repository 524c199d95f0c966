/* Putting a backup in the database's place. See backup.h.
 *
 * The order is such that a machine that dies in the middle leaves a database that opens: first a complete copy on the disk,
 * under another name; then a second name for what is there; then the old write-ahead log is removed (a new database must
 * never meet it); then the copy takes the database's name.
 */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/base/log.h"
#include "server/store/backup.h"
#include "server/store/internal.h"

/* Where the files are. */
struct places {
    char database[PATH_MAX], copy[PATH_MAX], before[PATH_MAX];
};

static bool say(char *message, const char *place, const char *words) {
    snprintf(message, QG_STORE_MESSAGE_ROOM, "%.1000s: %s", place, words);
    return false;
}

/* Opens the backup, and sees whether it is one that this program can use. NULL and a message when not. */
static sqlite3 *open_backup(const char *file, char *message) {
    sqlite3 *backup = NULL;
    const char *fault = NULL;
    if (sqlite3_open_v2(file, &backup, SQLITE_OPEN_READONLY, NULL) != SQLITE_OK)
        fault = backup ? sqlite3_errmsg(backup) : "out of memory";
    else if (qg_store_check(backup) != QG_STORE_OK)
        fault = "is no database, or a damaged one";
    else if (!qg_store_is_known_format(backup))
        fault = "is no database of this program, or one of a newer version";
    if (!fault)
        return backup;
    say(message, file, fault);
    sqlite3_close(backup);
    return NULL;
}

/* Writes into the copy's audit log that it was restored, in the name of the daemon: what else that log says is as of the
 * backup. */
static bool note_restoring(sqlite3 *copy) {
    return qg_sql_run(copy,
                      "INSERT INTO audit (at, token, name, address, action, subject)"
                      " VALUES (?, '', 'quietgeard', '', 'database.restore', 'quietgear.db')",
                      "i", qg_wall_clock()) == QG_STORE_OK;
}

/* Sets the revision beyond all that were ever told to who follows events, those after the backup included: with any of them
 * as Last-Event-ID a client is too far behind then, and reads its list again, as it has to. Microseconds since 1970 are:
 * changes are fewer. */
static bool outdate_followers(sqlite3 *copy) {
    return qg_sql_run(copy, "UPDATE revision SET last = max(last + ?, ?)", "ii", (int64_t)QG_REVISIONS_KEPT + 1,
                      qg_wall_clock() * 1000) == QG_STORE_OK;
}

/* Copies the whole backup to a new file, on the disk when this returns. */
static bool write_copy(sqlite3 *backup, const char *path, char *message) {
    sqlite3 *copy = NULL;
    unlink(path);
    bool right = sqlite3_open_v2(path, &copy, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL) == SQLITE_OK;
    sqlite3_backup *job = right ? sqlite3_backup_init(copy, "main", backup, "main") : NULL;
    right = job && sqlite3_backup_step(job, -1) == SQLITE_DONE;
    sqlite3_backup_finish(job);
    right =
        right && qg_store_check(copy) == QG_STORE_OK &&
        (!qg_store_has_audit(copy) || (note_restoring(copy) && outdate_followers(copy))); /* from the third format on */
    if (!right)
        say(message, path, copy ? sqlite3_errmsg(copy) : "out of memory");
    sqlite3_close(copy);
    if (!right)
        unlink(path);
    return right;
}

/* Gives the copy to whom the directory belongs: root restores what another user's daemon will use. */
static bool give_away(const char *directory, const char *path, char *message) {
    struct stat owner;
    if (stat(directory, &owner) != 0 || (geteuid() == 0 && chown(path, owner.st_uid, owner.st_gid) != 0))
        return say(message, path, strerror(errno));
    return true;
}

/* Gives the database and its log second names. */
static bool keep_what_was(const struct places *places, char *message) {
    char from[PATH_MAX], to[PATH_MAX];
    static const char *const tails[] = {"", "-wal"};
    for (size_t i = 0; i < 2; i++) {
        snprintf(from, sizeof from, "%.4000s%s", places->database, tails[i]);
        snprintf(to, sizeof to, "%.4000s%s", places->before, tails[i]);
        unlink(to);
        if (link(from, to) != 0 && errno != ENOENT)
            return say(message, to, strerror(errno));
    }
    return true;
}

/* The copy takes the database's place. */
static bool exchange_files(const struct places *places, char *message) {
    char log[PATH_MAX], index[PATH_MAX];
    snprintf(log, sizeof log, "%.4000s-wal", places->database);
    snprintf(index, sizeof index, "%.4000s-shm", places->database);
    if ((unlink(log) != 0 && errno != ENOENT) || (unlink(index) != 0 && errno != ENOENT))
        return say(message, log, strerror(errno));
    if (rename(places->copy, places->database) == 0)
        return true;
    snprintf(message, QG_STORE_MESSAGE_ROOM,
             "%.600s: %s; the old database lacks its log now, which is quietgear.db.before-restore-wal: restore again",
             places->database, strerror(errno));
    return false;
}

static void sync_directory(const char *directory) {
    int descriptor = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0 || fsync(descriptor) != 0)
        qg_log(QG_LOG_WARNING, "%s: cannot be synced to the disk: %s", directory, strerror(errno));
    if (descriptor >= 0)
        close(descriptor);
}

bool qg_backup_restore(const char *directory, const char *file, char message[QG_STORE_MESSAGE_ROOM]) {
    struct places places;
    snprintf(places.database, sizeof places.database, "%.4000s/quietgear.db", directory);
    snprintf(places.copy, sizeof places.copy, "%.4000s/restore.tmp", directory);
    snprintf(places.before, sizeof places.before, "%.4000s/quietgear.db.before-restore", directory);
    int lock = qg_store_lock(directory, message);
    if (lock < 0)
        return false;
    sqlite3 *backup = open_backup(file, message);
    bool done = backup && write_copy(backup, places.copy, message) && give_away(directory, places.copy, message) &&
                keep_what_was(&places, message) && exchange_files(&places, message);
    sqlite3_close(backup);
    unlink(places.copy);
    sync_directory(directory);
    close(lock);
    return done;
}
