/* Addresses, and where webhooks may go. See address.h.
 *
 * All addresses are compared as 16 bytes: an IPv4 address as its IPv4-mapped one, and, where webhooks may go, a NAT64 address
 * (64:ff9b::/96, RFC 6052) as the IPv4 address that it leads to.
 */
#include "server/base/address.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { BYTES = 16, V4_PREFIX = 96, WORD_ROOM = QG_URL_MAX + 1 };

static const char separators[] = " ,\t";

/* Copies the next word of a list; false at its end. A word that is too long becomes "". */
static bool next_word(const char **list, char word[WORD_ROOM]) {
    *list += strspn(*list, separators);
    size_t length = strcspn(*list, separators), kept = length < WORD_ROOM ? length : 0;
    memcpy(word, *list, kept);
    word[kept] = '\0';
    *list += length;
    return length > 0;
}

/* --- addresses and networks --- */

static const unsigned char mapped[12] = {[10] = 0xff, [11] = 0xff};
static const unsigned char nat64[12] = {0x00, 0x64, 0xff, 0x9b};

struct network {
    unsigned char address[BYTES];
    unsigned bits;
};

static bool parse_address(const char *text, unsigned char out[BYTES]) {
    memcpy(out, mapped, sizeof mapped);
    return inet_pton(AF_INET, text, out + sizeof mapped) == 1 || inet_pton(AF_INET6, text, out) == 1;
}

static bool parse_network(char *word, struct network *network) {
    char *slash = strchr(word, '/'), *end;
    if (!slash || slash[1] < '0' || slash[1] > '9')
        return false;
    *slash = '\0';
    bool is_v4 = !strchr(word, ':');
    errno = 0;
    unsigned long bits = strtoul(slash + 1, &end, 10);
    network->bits = (unsigned)bits + (is_v4 ? V4_PREFIX : 0);
    return !*end && !errno && bits <= (is_v4 ? 32 : 128) && parse_address(word, network->address);
}

static bool contains(const struct network *network, const unsigned char address[BYTES]) {
    size_t whole = network->bits / 8;
    unsigned rest = network->bits % 8, mask = 0xff00u >> rest & 0xff;
    return memcmp(network->address, address, whole) == 0 &&
           (rest == 0 || (network->address[whole] & mask) == (address[whole] & mask));
}

bool qg_networks_is_list(const char *networks) {
    char word[WORD_ROOM];
    struct network network;
    while (next_word(&networks, word))
        if (!parse_network(word, &network))
            return false;
    return true;
}

static bool is_in_list(const unsigned char address[BYTES], const char *networks) {
    char word[WORD_ROOM];
    struct network network;
    while (next_word(&networks, word))
        if (parse_network(word, &network) && contains(&network, address))
            return true;
    return false;
}

/* "This network", private, shared, loopback, link-local, protocol assignments, documentation, 6to4 relays, benchmarks,
 * multicast, reserved and broadcast; unspecified, loopback and IPv4-compatible, NAT64 for local use, discard, protocol
 * assignments with Teredo, documentation, 6to4, segment routing, unique local, link-local, site-local, multicast. */
static const char special[] = "0.0.0.0/8 10.0.0.0/8 100.64.0.0/10 127.0.0.0/8 169.254.0.0/16 172.16.0.0/12 "
                              "192.0.0.0/24 192.0.2.0/24 192.88.99.0/24 "
                              "192.168.0.0/16 198.18.0.0/15 198.51.100.0/24 203.0.113.0/24 224.0.0.0/4 240.0.0.0/4 "
                              "::/96 64:ff9b:1::/48 100::/64 2001::/23 2001:db8::/32 2002::/16 3fff::/20 5f00::/16 "
                              "fc00::/7 fe80::/10 fec0::/10 ff00::/8";

bool qg_address_is_own(const struct sockaddr *address) {
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } own = {.any.sa_family = address->sa_family};
    const bool is_v4 = address->sa_family == AF_INET;
    if (is_v4)
        memcpy(&own.v4.sin_addr, &((const struct sockaddr_in *)address)->sin_addr, sizeof own.v4.sin_addr);
    else
        memcpy(&own.v6.sin6_addr, &((const struct sockaddr_in6 *)address)->sin6_addr, sizeof own.v6.sin6_addr);
    int probe = socket(address->sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (probe < 0)
        return true;
    bool foreign = bind(probe, &own.any, is_v4 ? sizeof own.v4 : sizeof own.v6) != 0 && errno == EADDRNOTAVAIL;
    close(probe);
    return !foreign;
}

static bool read_bytes(const struct sockaddr *address, unsigned char out[BYTES]) {
    memcpy(out, mapped, sizeof mapped);
    if (address->sa_family == AF_INET)
        memcpy(out + sizeof mapped, &((const struct sockaddr_in *)address)->sin_addr, 4);
    else if (address->sa_family == AF_INET6)
        memcpy(out, &((const struct sockaddr_in6 *)address)->sin6_addr, BYTES);
    else
        return false;
    return true;
}

/* --- lists with single addresses in them --- */

static const char by_file[] = "unix";

bool qg_address_read(const char *text, struct sockaddr_storage *out) {
    struct sockaddr_in v4 = {.sin_family = AF_INET};
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6};
    memset(out, 0, sizeof *out);
    if (inet_pton(AF_INET, text, &v4.sin_addr) == 1)
        memcpy(out, &v4, sizeof v4);
    else if (inet_pton(AF_INET6, text, &v6.sin6_addr) == 1)
        memcpy(out, &v6, sizeof v6);
    else
        return false;
    return true;
}

/* A network, or one address as the network of itself. */
static bool parse_place(char *word, struct network *network) {
    network->bits = 8 * BYTES;
    return strchr(word, '/') ? parse_network(word, network) : parse_address(word, network->address);
}

bool qg_addresses_is_list(const char *list) {
    char word[WORD_ROOM];
    struct network network;
    while (next_word(&list, word))
        if (strcmp(word, by_file) != 0 && !parse_place(word, &network))
            return false;
    return true;
}

bool qg_address_is_listed(const struct sockaddr *address, const char *list) {
    char word[WORD_ROOM];
    struct network network;
    unsigned char bytes[BYTES];
    const bool has_bytes = read_bytes(address, bytes);
    while (next_word(&list, word)) {
        if (strcmp(word, by_file) == 0 && address->sa_family == AF_UNIX)
            return true;
        if (has_bytes && parse_place(word, &network) && contains(&network, bytes))
            return true;
    }
    return false;
}

bool qg_address_is_allowed(const struct sockaddr *address, const char *networks) {
    unsigned char bytes[BYTES];
    if (!read_bytes(address, bytes))
        return false;
    if (memcmp(bytes, nat64, sizeof nat64) == 0)
        memcpy(bytes, mapped, sizeof mapped);
    return is_in_list(bytes, networks) || (!is_in_list(bytes, special) && !qg_address_is_own(address));
}

/* --- URLs --- */

/* The parts of a URL that rules look at, to be freed by curl_free. NULL where there is none. */
struct parts {
    char *scheme, *host, *port, *path, *query, *user, *password, *fragment;
};

static void free_parts(struct parts *parts) {
    char *all[] = {parts->scheme, parts->host, parts->port,     parts->path,
                   parts->query,  parts->user, parts->password, parts->fragment};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        curl_free(all[i]);
}

const char qg_url_no_memory[] = "there is not enough memory to look at it";

/* A part that a URL need not have. */
static CURLUcode get_optional(CURLU *handle, CURLUPart what, char **part) {
    CURLUcode code = curl_url_get(handle, what, part, 0);
    return code == CURLUE_OUT_OF_MEMORY ? code : CURLUE_OK;
}

static CURLUcode get_parts(CURLU *handle, struct parts *parts) {
    CURLUcode code = curl_url_get(handle, CURLUPART_SCHEME, &parts->scheme, 0);
    if (code == CURLUE_OK)
        code = curl_url_get(handle, CURLUPART_HOST, &parts->host, 0);
    if (code == CURLUE_OK)
        code = curl_url_get(handle, CURLUPART_PORT, &parts->port, CURLU_DEFAULT_PORT);
    if (code == CURLUE_OK)
        code = curl_url_get(handle, CURLUPART_PATH, &parts->path, 0);
    if (code == CURLUE_OK)
        code = get_optional(handle, CURLUPART_QUERY, &parts->query);
    if (code == CURLUE_OK)
        code = get_optional(handle, CURLUPART_USER, &parts->user);
    if (code == CURLUE_OK)
        code = get_optional(handle, CURLUPART_PASSWORD, &parts->password);
    return code == CURLUE_OK ? get_optional(handle, CURLUPART_FRAGMENT, &parts->fragment) : code;
}

/* Takes a URL apart; hosts come in lower case, IPv4 addresses in four decimal numbers, paths without dots. False when it is
 * none, and with errno ENOMEM when memory is short, else 0. */
static bool split(const char *url, struct parts *parts) {
    CURLU *handle = curl_url();
    *parts = (struct parts){0};
    CURLUcode code = handle ? curl_url_set(handle, CURLUPART_URL, url, 0) : CURLUE_OUT_OF_MEMORY;
    if (code == CURLUE_OK)
        code = get_parts(handle, parts);
    for (char *c = parts->host; code == CURLUE_OK && *c; c++)
        *c = *c >= 'A' && *c <= 'Z' ? (char)(*c + 'a' - 'A') : *c;
    curl_url_cleanup(handle);
    if (code != CURLUE_OK)
        free_parts(parts);
    errno = code == CURLUE_OUT_OF_MEMORY ? ENOMEM : 0;
    return code == CURLUE_OK;
}

static bool is_web(const struct parts *parts) {
    return (strcmp(parts->scheme, "https") == 0 || strcmp(parts->scheme, "http") == 0) && !parts->user &&
           !parts->password && !parts->fragment;
}

/* Takes a rule apart; *below says whether it stands for the hosts below its host. */
static bool split_rule(const char *rule, struct parts *parts, bool *below) {
    char plain[WORD_ROOM];
    const char *star = strstr(rule, "://*.");
    *below = star;
    strcpy(plain, rule);
    if (star)
        strcpy(plain + (star - rule) + 3, star + 5);
    errno = 0;
    if (!strstr(plain, "://") || strchr(plain, '*') || !split(plain, parts))
        return false;
    if (is_web(parts) && !parts->query)
        return true;
    free_parts(parts);
    return false;
}

bool qg_url_rules_is_list(const char *rules) {
    char rule[WORD_ROOM];
    struct parts parts;
    bool below;
    while (next_word(&rules, rule)) {
        if (!split_rule(rule, &parts, &below))
            return false;
        free_parts(&parts);
    }
    return true;
}

static bool host_fits(const char *host, const char *rule, bool below) {
    size_t length = strlen(host), tail = strlen(rule);
    if (!below)
        return strcmp(host, rule) == 0;
    return length > tail + 1 && host[length - tail - 1] == '.' && strcmp(host + length - tail, rule) == 0;
}

/* The rule's path is a beginning of the other, in whole segments. */
static bool path_fits(const char *path, const char *rule) {
    size_t length = strlen(rule);
    return strncmp(path, rule, length) == 0 && (rule[length - 1] == '/' || !path[length] || path[length] == '/');
}

/* False with errno ENOMEM: memory is short. */
static bool fits(const struct parts *url, const char *rules) {
    char rule[WORD_ROOM];
    struct parts parts;
    bool below, found = false;
    errno = 0;
    while (!found && errno != ENOMEM && next_word(&rules, rule)) {
        if (!split_rule(rule, &parts, &below))
            continue;
        found = strcmp(url->scheme, parts.scheme) == 0 && strcmp(url->port, parts.port) == 0 &&
                host_fits(url->host, parts.host, below) && path_fits(url->path, parts.path);
        free_parts(&parts);
    }
    return found;
}

/* True when the host is an address that must not be connected to. */
static bool is_forbidden_address(const char *host, const char *networks) {
    char plain[INET6_ADDRSTRLEN] = "";
    struct sockaddr_in v4 = {.sin_family = AF_INET};
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6};
    size_t length = strlen(host);
    if (inet_pton(AF_INET, host, &v4.sin_addr) == 1)
        return !qg_address_is_allowed((const struct sockaddr *)&v4, networks);
    if (host[0] != '[')
        return false;
    if (length < 2 || length - 2 >= sizeof plain)
        return true;
    memcpy(plain, host + 1, length - 2);
    return inet_pton(AF_INET6, plain, &v6.sin6_addr) != 1 ||
           !qg_address_is_allowed((const struct sockaddr *)&v6, networks);
}

/* Escapes of dots and slashes: what is behind the URL may see another path than we do. */
static bool hides_dots(const char *path) {
    for (const char *c = path; (c = strchr(c, '%')); c++)
        if (strncasecmp(c, "%2e", 3) == 0 || strncasecmp(c, "%2f", 3) == 0 || strncasecmp(c, "%5c", 3) == 0)
            return true;
    return strchr(path, '\\');
}

const char *qg_url_refusal(const char *url, const char *rules, const char *networks) {
    struct parts parts;
    const char *words = NULL;
    if (strlen(url) > QG_URL_MAX || !strstr(url, "://"))
        return "it is not a URL of http or https";
    if (!split(url, &parts))
        return errno == ENOMEM ? qg_url_no_memory : "it is not a URL of http or https";
    if (!is_web(&parts))
        words = "needed is a URL of http or https without a user, a password or a fragment";
    else if (hides_dots(parts.path))
        words = "its path holds escaped dots or slashes";
    else if (!fits(&parts, rules))
        words = errno == ENOMEM ? qg_url_no_memory
                : *rules        ? "it matches none of the setting webhook-allow"
                                : "the setting webhook-allow lists none";
    else if (is_forbidden_address(parts.host, networks))
        words = "its address is private or of this machine, and not in the setting webhook-networks";
    free_parts(&parts);
    return words;
}
