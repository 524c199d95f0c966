/* The journal's native protocol: an entry is one datagram of lines NAME=value.
 *
 * Source: systemd.io, "Native Journal Protocol", which promises to keep it. libsystemd's sd_journal_send speaks it too, but
 * waits without limit for a journal that does not read and reports success where there is none (both seen with systemd 252);
 * the daemon must do neither. Entries here are too small for the protocol's other half, files passed by descriptor.
 */
#ifndef QG_SERVER_BASE_JOURNAL_H
#define QG_SERVER_BASE_JOURNAL_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/un.h>

#define QG_JOURNAL_SOCKET "/run/systemd/journal/socket"

/* A way to the journal; zeroed is none. */
struct qg_journal {
    bool open;
    int channel;
    atomic_bool stuck; /* it was waited for in vain */
    struct sockaddr_un address;
};

/* True when $JOURNAL_STREAM names the device and inode of this descriptor: whoever writes to it writes to the journal. */
bool qg_journal_is_behind(int descriptor);

/* Opens a way to the journal at a path. Nobody has to listen there yet. False when there is no socket to be had, or the path
 * is too long. */
bool qg_journal_open(struct qg_journal *journal, const char *path);

/* Sends one entry. False when the journal does not take it: gone, full, refused. A full one is waited for, as it is full after
 * every burst, but for QG_JOURNAL_PATIENCE_MS and, when that was in vain, not again before it has taken something.
 * Threads: any. */
enum { QG_JOURNAL_PATIENCE_MS = 200 };
bool qg_journal_send(struct qg_journal *journal, const char *entry, size_t length);

void qg_journal_close(struct qg_journal *journal);

#endif
