/* The journal's native protocol. See journal.h. */
#include "server/base/journal.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

bool qg_journal_is_behind(int descriptor) {
    const char *stream = getenv("JOURNAL_STREAM");
    struct stat status;
    char found[64];
    if (!stream || fstat(descriptor, &status) != 0)
        return false;
    snprintf(found, sizeof found, "%ju:%ju", (uintmax_t)status.st_dev, (uintmax_t)status.st_ino);
    return strcmp(stream, found) == 0;
}

bool qg_journal_open(struct qg_journal *journal, const char *path) {
    *journal = (struct qg_journal){.address = {.sun_family = AF_UNIX}};
    if (strlen(path) >= sizeof journal->address.sun_path)
        return false;
    strcpy(journal->address.sun_path, path);
    journal->channel = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const struct timeval patience = {.tv_usec = QG_JOURNAL_PATIENCE_MS * 1000};
    journal->open = journal->channel >= 0;
    if (journal->open && setsockopt(journal->channel, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience) != 0)
        qg_journal_close(journal);
    return journal->open;
}

bool qg_journal_send(struct qg_journal *journal, const char *entry, size_t length) {
    /* by address each time, not connected: a journal that was restarted is found again */
    int flags = MSG_NOSIGNAL | (atomic_load(&journal->stuck) ? MSG_DONTWAIT : 0);
    bool sent = sendto(journal->channel, entry, length, flags, (const struct sockaddr *)&journal->address,
                       sizeof journal->address) == (ssize_t)length;
    atomic_store(&journal->stuck, !sent && errno == EAGAIN);
    return sent;
}

void qg_journal_close(struct qg_journal *journal) {
    if (journal->open)
        close(journal->channel);
    journal->open = false;
}
