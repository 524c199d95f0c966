/* Hosts and origins. See origin.h. */
#include "server/http/origin.h"

#include <arpa/inet.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

enum { HOST_ROOM = 256 };

static const char separators[] = ", \t";
static const char name_characters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_";

static bool is_port(const char *text) {
    return strspn(text, "0123456789") == strlen(text) && strlen(text) <= 5;
}

/* Takes the port and brackets off a Host field. False when it is none. */
static bool read_name(const char *host, char name[HOST_ROOM], bool *bracketed) {
    const char *end = host + strcspn(host, ":");
    *bracketed = host[0] == '[';
    if (*bracketed) {
        host++;
        end = host + strcspn(host, "]");
        if (*end != ']')
            return false;
    }
    size_t length = (size_t)(end - host);
    if (length == 0 || length >= HOST_ROOM)
        return false;
    memcpy(name, host, length);
    name[length] = '\0';
    end += *bracketed;
    return *end == '\0' || (*end == ':' && is_port(end + 1));
}

static bool is_numeric(const char *name, bool bracketed) {
    unsigned char address[16];
    return inet_pton(bracketed ? AF_INET6 : AF_INET, name, address) == 1;
}

/* Names are the same whatever the case and with a dot at the end. */
static bool is_same(const char *name, size_t length, const char *other, size_t other_length) {
    length -= length > 0 && name[length - 1] == '.';
    other_length -= other_length > 0 && other[other_length - 1] == '.';
    return length == other_length && strncasecmp(name, other, length) == 0;
}

static bool is_localhost(const char *name) {
    static const char localhost[] = "localhost";
    size_t length = strlen(name), tail = sizeof localhost - 1;
    length -= name[length - 1] == '.';
    return length >= tail && strncasecmp(name + length - tail, localhost, tail) == 0 &&
           (length == tail || name[length - tail - 1] == '.');
}

/* True when the list has the name. */
static bool is_listed(const char *name, const char *allowed) {
    while (*allowed) {
        allowed += strspn(allowed, separators);
        size_t length = strcspn(allowed, separators);
        if ((length == 1 && *allowed == '*') || (length > 0 && is_same(name, strlen(name), allowed, length)))
            return true;
        allowed += length;
    }
    return false;
}

bool qg_hosts_are_valid(const char *allowed) {
    while (*allowed) {
        allowed += strspn(allowed, separators);
        size_t length = strcspn(allowed, separators);
        bool any = length == 1 && *allowed == '*';
        if (length > 0 && !any && strspn(allowed, name_characters) < length)
            return false;
        allowed += length;
    }
    return true;
}

enum qg_host_verdict qg_host_judge(const char *host, const char *allowed) {
    char name[HOST_ROOM];
    bool bracketed;
    if (!read_name(host, name, &bracketed))
        return QG_HOST_MALFORMED;
    if (is_numeric(name, bracketed))
        return QG_HOST_OURS;
    if (bracketed || name[strspn(name, name_characters)])
        return QG_HOST_MALFORMED;
    return is_localhost(name) || is_listed(name, allowed) ? QG_HOST_OURS : QG_HOST_FOREIGN;
}

bool qg_origin_is_ours(const char *origin, const char *host, const char *allowed) {
    char name[HOST_ROOM];
    bool bracketed;
    if (strncasecmp(origin, "http://", 7) == 0)
        origin += 7;
    else if (strncasecmp(origin, "https://", 8) == 0)
        origin += 8;
    else
        return false;
    if (host && strcasecmp(origin, host) == 0)
        return true;
    return read_name(origin, name, &bracketed) && !bracketed && is_listed(name, allowed);
}
