/* Request targets and header fields. See target.h. */
#include "server/http/target.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "schema/faults.h"

static int hexadecimal(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

static bool is_utf8(const char *text) {
    size_t left = strlen(text);
    while (left > 0) {
        size_t length = qg_utf8_length(text, left);
        if (length == 0)
            return false;
        text += length;
        left -= length;
    }
    return true;
}

/* Decodes percent escapes in place, and '+' as a blank where plus_is_blank. */
static const char *decode(char *text, bool plus_is_blank) {
    char *out = text;
    for (const char *in = text; *in; in++) {
        unsigned char c = (unsigned char)*in;
        if (c == '%') {
            int high = hexadecimal(in[1]);
            int low = high < 0 ? -1 : hexadecimal(in[2]);
            if (low < 0)
                return "a percent sign in the address is not followed by two hexadecimal digits";
            c = (unsigned char)(high * 16 + low);
            in += 2;
        } else if (c == '+' && plus_is_blank) {
            c = ' ';
        }
        if (c < 0x20 || c == 0x7f)
            return "the address holds a control character";
        *out++ = (char)c;
    }
    *out = '\0';
    return is_utf8(text) ? NULL : "the address is not UTF-8";
}

static const char *add_segment(struct qg_target *target, char *segment) {
    const char *fault = decode(segment, false);
    if (fault)
        return fault;
    if (!*segment)
        return "the path holds an empty segment";
    if (strcmp(segment, ".") == 0 || strcmp(segment, "..") == 0)
        return "the path holds a . or .. segment";
    if (strchr(segment, '/') || strchr(segment, '\\'))
        return "the path holds an encoded slash or a backslash";
    if (target->segment_count == QG_SEGMENTS_MAX)
        return "the path has too many segments";
    target->segment[target->segment_count++] = segment;
    return NULL;
}

static const char *parse_path(struct qg_target *target, char *path) {
    while (path) {
        char *next = strchr(path, '/');
        if (next)
            *next++ = '\0';
        const char *fault = add_segment(target, path);
        if (fault)
            return fault;
        path = next;
    }
    return NULL;
}

static const char *parse_query(struct qg_target *target, char *query) {
    while (query) {
        char *next = strchr(query, '&');
        if (next)
            *next++ = '\0';
        char *value = strchr(query, '=');
        if (value)
            *value++ = '\0';
        else
            value = query + strlen(query);
        const char *fault = decode(query, true);
        if (!fault)
            fault = decode(value, true);
        if (fault)
            return fault;
        if (target->query_count == QG_QUERY_MAX)
            return "the query has too many parameters";
        target->query[target->query_count].name = query;
        target->query[target->query_count++].value = value;
        query = next;
    }
    return NULL;
}

const char *qg_target_parse(struct qg_target *target, const char *raw) {
    target->segment_count = target->query_count = 0;
    size_t length = strlen(raw);
    if (raw[0] != '/')
        return "the request target does not begin with a slash";
    if (length >= sizeof target->storage)
        return "the address is too long";
    memcpy(target->storage, raw, length + 1);
    char *query = strchr(target->storage, '?');
    if (query)
        *query++ = '\0';
    const char *fault = target->storage[1] ? parse_path(target, target->storage + 1) : NULL;
    if (!fault && query && *query)
        fault = parse_query(target, query);
    return fault;
}

const char *qg_target_query(const struct qg_target *target, const char *name) {
    for (size_t i = 0; i < target->query_count; i++)
        if (strcmp(target->query[i].name, name) == 0)
            return target->query[i].value;
    return NULL;
}

static bool is_among(const char *name, const char *const *names) {
    while (*names && strcmp(*names, name) != 0)
        names++;
    return *names;
}

bool qg_target_query_is_among(const struct qg_target *target, const char *const *names, const char **offender) {
    for (size_t i = 0; i < target->query_count; i++) {
        *offender = target->query[i].name;
        if (!is_among(*offender, names))
            return false;
        for (size_t j = 0; j < i; j++)
            if (strcmp(target->query[j].name, *offender) == 0)
                return false;
    }
    return true;
}

/* A stretch of a header field. */
struct span {
    const char *start;
    size_t length;
};

/* The next item of a list separated by `separator`, blanks trimmed; false at the end. *rest moves on. */
static bool next_item(const char **rest, char separator, struct span *item) {
    if (!*rest)
        return false;
    const char *end = strchr(*rest, separator);
    const char *start = *rest;
    *rest = end ? end + 1 : NULL;
    if (!end)
        end = start + strlen(start);
    while (start < end && (*start == ' ' || *start == '\t'))
        start++;
    while (end > start && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    *item = (struct span){start, (size_t)(end - start)};
    return true;
}

static bool span_is(struct span span, const char *text) {
    return span.length == strlen(text) && strncasecmp(span.start, text, span.length) == 0;
}

/* How closely a media range names a type: 3 exactly, 2 "type/" and star, 1 star and star, 0 not at all. */
static int range_fits(struct span range, const char *type) {
    if (span_is(range, type))
        return 3;
    size_t major = (size_t)(strchr(type, '/') - type) + 1;
    if (range.length == major + 1 && strncasecmp(range.start, type, major) == 0 && range.start[major] == '*')
        return 2;
    return span_is(range, "*/*") ? 1 : 0;
}

/* Copies a span into a NUL-ended buffer; what does not fit is cut. */
static void span_copy(char *out, size_t room, struct span span) {
    size_t length = span.length < room - 1 ? span.length : room - 1;
    memcpy(out, span.start, length);
    out[length] = '\0';
}

/* The quality (0..1) that the parameters of a media range state; 1 when they state none. */
static double quality(const char *parameters) {
    struct span item;
    while (next_item(&parameters, ';', &item)) {
        if (item.length < 3 || strncasecmp(item.start, "q=", 2) != 0)
            continue;
        char number[16];
        span_copy(number, sizeof number, (struct span){item.start + 2, item.length - 2});
        double value = strtod(number, NULL);
        return value >= 0 && value <= 1 ? value : 0;
    }
    return 1;
}

/* The quality of one type under an Accept field: that of the range that names it most closely. */
static double quality_of(const char *accept, const char *type) {
    int closest = 0;
    double best = 0;
    struct span item;
    while (next_item(&accept, ',', &item)) {
        char text[256];
        span_copy(text, sizeof text, item);
        const char *rest = text;
        struct span range;
        next_item(&rest, ';', &range);
        int fit = range_fits(range, type);
        if (fit > closest) {
            closest = fit;
            best = quality(rest);
        }
    }
    return best;
}

int qg_negotiate(const char *accept, const char *const *offers) {
    if (!accept)
        return 0;
    int chosen = -1;
    double best = 0;
    for (int i = 0; offers[i]; i++) {
        double q = quality_of(accept, offers[i]);
        if (q > best) {
            best = q;
            chosen = i;
        }
    }
    return chosen;
}

bool qg_etag_matches(const char *if_none_match, const char *etag) {
    struct span item;
    while (next_item(&if_none_match, ',', &item)) {
        if (span_is(item, "*"))
            return true;
        if (item.length > 2 && strncmp(item.start, "W/", 2) == 0)
            item = (struct span){item.start + 2, item.length - 2};
        if (item.length == strlen(etag) && memcmp(item.start, etag, item.length) == 0)
            return true;
    }
    return false;
}

int qg_prefer_wait(const char *prefer) {
    struct span item;
    while (next_item(&prefer, ',', &item)) {
        if (item.length < 4 || strncasecmp(item.start, "wait", 4) != 0 || (item.length > 4 && item.start[4] != '='))
            continue;
        char number[16], *end;
        span_copy(number, sizeof number, (struct span){item.start + 5, item.length > 5 ? item.length - 5 : 0});
        long seconds = strtol(number, &end, 10);
        bool is_number = number[0] >= '0' && number[0] <= '9' && (*end == '\0' || *end == ';');
        return is_number && seconds > 0 && seconds <= QG_WAIT_MAX_S ? (int)seconds : -1;
    }
    return 0;
}

bool qg_accepts_gzip(const char *accept_encoding) {
    struct span item;
    double gzip = -1, any = 0;
    while (next_item(&accept_encoding, ',', &item)) {
        char text[64];
        span_copy(text, sizeof text, item);
        const char *rest = text;
        struct span coding;
        next_item(&rest, ';', &coding);
        if (span_is(coding, "gzip") || span_is(coding, "x-gzip"))
            gzip = quality(rest);
        else if (span_is(coding, "*"))
            any = quality(rest);
    }
    return (gzip >= 0 ? gzip : any) > 0;
}

bool qg_media_type_is(const char *content_type, const char *type) {
    struct span item;
    return next_item(&content_type, ';', &item) && span_is(item, type);
}
