/* X-Forwarded-For. See forwarded.h. */
#include "server/http/forwarded.h"

#include <netinet/in.h>
#include <stdbool.h>
#include <string.h>
#include <sys/un.h>

#include "server/base/address.h"

enum { ENTRY_ROOM = 64 }; /* an IPv6 address in brackets, with a port, has 53 characters */

static socklen_t size_of(const struct sockaddr *address) {
    return address->sa_family == AF_INET    ? sizeof(struct sockaddr_in)
           : address->sa_family == AF_INET6 ? sizeof(struct sockaddr_in6)
                                            : sizeof address->sa_family;
}

static void copy(struct sockaddr_storage *out, const struct sockaddr *address) {
    memset(out, 0, sizeof *out);
    memcpy(out, address, size_of(address));
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

/* Copies the last entry of the field's first *length bytes, without the blanks around it, and shortens *length to what stands
 * before its comma. An entry that is too long becomes "". False when nothing is left. */
static bool take_last(const char *field, size_t *length, char entry[ENTRY_ROOM]) {
    size_t end = *length, begin;
    if (end == 0)
        return false;
    for (begin = end; begin > 0 && field[begin - 1] != ','; begin--)
        ;
    *length = begin > 0 ? begin - 1 : 0;
    while (begin < end && is_blank(field[begin]))
        begin++;
    while (end > begin && is_blank(field[end - 1]))
        end--;
    size_t kept = end - begin < ENTRY_ROOM ? end - begin : 0;
    memcpy(entry, field + begin, kept);
    entry[kept] = '\0';
    return true;
}

/* Takes "[IPV6]", "[IPV6]:PORT" and "IPV4:PORT" down to the address. */
static void strip_port(char *entry) {
    char *colon = strchr(entry, ':'), *bracket = strchr(entry, ']');
    if (entry[0] == '[' && bracket) {
        *bracket = '\0';
        memmove(entry, entry + 1, strlen(entry));
    } else if (colon && !strchr(colon + 1, ':')) {
        *colon = '\0';
    }
}

void qg_forwarded_client(const struct sockaddr *peer, const char *field, const char *proxies,
                         struct sockaddr_storage *out) {
    size_t length = field ? strlen(field) : 0;
    char entry[ENTRY_ROOM];
    struct sockaddr_storage named;
    copy(out, peer);
    while (qg_address_is_listed((const struct sockaddr *)out, proxies) && take_last(field, &length, entry)) {
        strip_port(entry);
        if (!qg_address_read(entry, &named))
            break;
        *out = named;
    }
}
