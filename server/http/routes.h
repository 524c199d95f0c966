/* Routes: which pattern and method lead to which handler.
 */
#ifndef QG_SERVER_HTTP_ROUTES_H
#define QG_SERVER_HTTP_ROUTES_H

#include "server/http/exchange.h"

enum { QG_OFFERS_MAX = 3 };

struct qg_route {
    const char *pattern; /* segments; {} stands for any one of them */
    enum qg_method method;
    const char
        *offers[QG_OFFERS_MAX]; /* media types of the answer, the preferred first, NULL-ended; empty: not negotiated */
    qg_handler *handler;
    bool takes_document; /* the request has a JSON document as its body */
    unsigned scope;      /* QG_SCOPE_..., the one that a token needs; 0, forgotten, is admin */
};

/* A table of routes; the rows are static. */
struct qg_routes {
    const struct qg_route *route;
    size_t count;
};

/* Looks a target up. On success *parameter is the segment that stands for {} (or NULL). NULL when nothing answers: then
 * `allow` lists the methods of the path ("GET, HEAD, POST") or is empty when there is no such path. */
enum { QG_ALLOW_ROOM = 40 };
const struct qg_route *qg_route_find(const struct qg_routes *routes, const struct qg_target *target, const char *method,
                                     const char **parameter, char allow[QG_ALLOW_ROOM]);

#endif
