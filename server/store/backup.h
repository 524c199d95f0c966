/* Copies of the database, made while the daemon goes on working.
 *
 * A thread copies the database by SQLite's online backup from a connection of its own that holds one read transaction, so
 * that the copy is of one moment, however long it takes; writers go on meanwhile, and the write-ahead log grows by what they
 * write. The copy is made beside the database, so the disk needs room for it, checked (PRAGMA integrity_check), and then
 * belongs to the answer alone: a file without a name, gone with the connection. What it holds is worth protecting: hashes of
 * access tokens, secrets of webhooks.
 */
#ifndef QG_SERVER_STORE_BACKUP_H
#define QG_SERVER_STORE_BACKUP_H

#include "server/store/store.h"

struct qg_backups;

/* A maker of backups of the store in a directory, which has to be open and outlive it; NULL when memory is short. A copy that
 * a killed process left half made is removed. */
struct qg_backups *qg_backups_create(const char *directory);

/* Breaks off what is being made and frees all. NULL is allowed. */
void qg_backups_destroy(struct qg_backups *backups);

/* Begins a copy and gives it a number (> 0); 0 when one is being made already, or no thread can be had. Threads: any. */
uint64_t qg_backup_begin(struct qg_backups *backups);

enum qg_backup_state { QG_BACKUP_PENDING, QG_BACKUP_READY, QG_BACKUP_FAILED };

/* How far a copy is. On QG_BACKUP_READY *descriptor is the open file, at its beginning, the caller's to close, and the number
 * is spent; on QG_BACKUP_FAILED *reason says why. Threads: any. */
enum qg_backup_state qg_backup_collect(struct qg_backups *backups, uint64_t number, int *descriptor,
                                       enum qg_store_status *reason);

/* Puts a backup in the place of a state directory's database, while no daemon works there: checks it, copies it, and keeps
 * what was there, and only that, as quietgear.db.before-restore. False and a message when that cannot be; then nothing has changed, unless
 * the message says so. Jobs that ran when the backup was made go on from their logs at the next start. */
bool qg_backup_restore(const char *directory, const char *file, char message[QG_STORE_MESSAGE_ROOM]);

#endif
