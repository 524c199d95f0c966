/* Socket activation and readiness messages. See systemd.h. */
#include "server/base/systemd.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/base/log.h"

enum { FIRST_SOCKET = 3 };

int qg_systemd_socket(void) {
    const char *process = getenv("LISTEN_PID"), *count = getenv("LISTEN_FDS");
    if (!process || !count || strtol(process, NULL, 10) != (long)getpid())
        return -1;
    if (strcmp(count, "1") != 0)
        return strcmp(count, "0") == 0 ? -1 : -2;
    fcntl(FIRST_SOCKET, F_SETFD, FD_CLOEXEC);
    return FIRST_SOCKET;
}

/* The address of $NOTIFY_SOCKET: a path, or an abstract name after '@'. Returns its length, 0 when it does not fit. */
static socklen_t notify_address(const char *name, struct sockaddr_un *address) {
    size_t length = strlen(name);
    if (length < 2 || length >= sizeof address->sun_path || (*name != '/' && *name != '@'))
        return 0;
    address->sun_family = AF_UNIX;
    memcpy(address->sun_path, name, length);
    if (*name == '@')
        address->sun_path[0] = '\0';
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length);
}

void qg_systemd_notify(const char *state) {
    const char *name = getenv("NOTIFY_SOCKET");
    if (!name || !*name)
        return;
    struct sockaddr_un address = {0};
    socklen_t length = notify_address(name, &address);
    int channel = length ? socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0) : -1;
    if (channel < 0 || sendto(channel, state, strlen(state), MSG_NOSIGNAL, (struct sockaddr *)&address, length) < 0)
        qg_log(QG_LOG_WARNING, "%s cannot be sent to $NOTIFY_SOCKET: %s", state,
               length ? strerror(errno) : "not an address");
    if (channel >= 0)
        close(channel);
}
