/* The listening socket. See listener.h. */
#include "server/listener.h"

#include <errno.h>
#include <limits.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/settings.h"

enum { BACKLOG = 128 };

static int open_at(const struct addrinfo *address) {
    int listener = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), yes = 1;
    if (listener < 0)
        return -1;
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(listener, address->ai_addr, address->ai_addrlen) == 0 && listen(listener, BACKLOG) == 0)
        return listener;
    int error = errno;
    close(listener);
    errno = error;
    return -1;
}

int qg_listener_open(const char *where, char *message, size_t room) {
    char address[QG_SETTING_ROOM], port[QG_SETTING_ROOM];
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE | AI_NUMERICSERV}, *found = NULL;
    qg_settings_split_address(where, address, port, sizeof port);
    int error = getaddrinfo(address, port, &hints, &found);
    if (error) {
        snprintf(message, room, "%s: %s", where, gai_strerror(error));
        return -1;
    }
    int listener = open_at(found);
    if (listener < 0)
        snprintf(message, room, "%s: %s", where, strerror(errno));
    freeaddrinfo(found);
    return listener;
}

bool qg_listener_is_loopback(int listener) {
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
        struct sockaddr_storage storage;
    } address;
    socklen_t length = sizeof address;
    if (getsockname(listener, &address.any, &length) != 0)
        return false;
    if (address.any.sa_family == AF_INET)
        return ntohl(address.v4.sin_addr.s_addr) >> 24 == 127;
    return address.any.sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&address.v6.sin6_addr);
}

int qg_listener_describe(int listener, const char *scheme, char *out, size_t room) {
    struct sockaddr_storage address;
    socklen_t length = sizeof address;
    char host[NI_MAXHOST], port[NI_MAXSERV];
    if (getsockname(listener, (struct sockaddr *)&address, &length) != 0 ||
        (address.ss_family != AF_INET && address.ss_family != AF_INET6) ||
        getnameinfo((struct sockaddr *)&address, length, host, sizeof host, port, sizeof port,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
        snprintf(out, room, "the socket handed over");
        return 0;
    }
    snprintf(out, room, address.ss_family == AF_INET6 ? "%s://[%s]:%s" : "%s://%s:%s", scheme, host, port);
    return (int)strtol(port, NULL, 10);
}

int qg_listener_write_port(const char *file, int port) {
    char temporary[PATH_MAX];
    if (snprintf(temporary, sizeof temporary, "%s.new", file) >= (int)sizeof temporary)
        return ENAMETOOLONG;
    FILE *stream = fopen(temporary, "we");
    if (!stream)
        return errno;
    int written = fprintf(stream, "%d\n", port);
    if (fclose(stream) == 0 && written > 0 && rename(temporary, file) == 0)
        return 0;
    return errno;
}
