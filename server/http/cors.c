/* Pages of other origins. See cors.h. */
#include "server/http/cors.h"

#include <stddef.h>
#include <string.h>

static const char separators[] = " ,\t";

/* "http://" or "https://", then a host with nothing behind it but a port, all in lower case. */
static bool is_origin(const char *text, size_t length) {
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyz0123456789.-:[]";
    size_t scheme = strncmp(text, "https://", 8) == 0 ? 8 : strncmp(text, "http://", 7) == 0 ? 7 : 0;
    return scheme > 0 && length > scheme && strspn(text + scheme, allowed) >= length - scheme;
}

bool qg_cors_is_list(const char *origins) {
    for (origins += strspn(origins, separators); *origins; origins += strspn(origins, separators)) {
        size_t length = strcspn(origins, separators);
        if (!is_origin(origins, length))
            return false;
        origins += length;
    }
    return true;
}

bool qg_cors_allows(const char *origins, const char *origin) {
    for (origins += strspn(origins, separators); origin && *origins; origins += strspn(origins, separators)) {
        size_t length = strcspn(origins, separators);
        if (strlen(origin) == length && memcmp(origins, origin, length) == 0)
            return true;
        origins += length;
    }
    return false;
}
