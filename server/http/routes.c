/* Finding the route of a request. See routes.h. */
#include "server/http/routes.h"

#include <string.h>

/* True when the target has the pattern's segments; *parameter is the one at {}. */
static bool fits(const char *pattern, const struct qg_target *target, const char **parameter) {
    *parameter = NULL;
    for (size_t i = 0; i < target->segment_count; i++) {
        size_t length = strcspn(pattern, "/");
        if (length == 2 && memcmp(pattern, "{}", 2) == 0)
            *parameter = target->segment[i];
        else if (length == 0 || strlen(target->segment[i]) != length ||
                 memcmp(pattern, target->segment[i], length) != 0)
            return false;
        pattern += length;
        pattern += *pattern == '/';
    }
    return !*pattern;
}

static const char *const method_names[QG_METHOD_COUNT] = {"GET, HEAD", "POST", "DELETE"};

static bool is_method(enum qg_method method, const char *name) {
    switch (method) {
    case QG_GET:
        return strcmp(name, "GET") == 0 || strcmp(name, "HEAD") == 0;
    default:
        return strcmp(name, method_names[method]) == 0;
    }
}

const struct qg_route *qg_route_find(const struct qg_routes *routes, const struct qg_target *target, const char *method,
                                     const char **parameter, char allow[QG_ALLOW_ROOM]) {
    allow[0] = '\0';
    for (size_t i = 0; i < routes->count; i++) {
        if (!fits(routes->route[i].pattern, target, parameter))
            continue;
        if (is_method(routes->route[i].method, method))
            return &routes->route[i];
        if (*allow)
            strcat(allow, ", ");
        strcat(allow, method_names[routes->route[i].method]);
    }
    return NULL;
}
