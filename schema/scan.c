/* A strict JSON scanner: it builds nothing, it only says whether the bytes are in order.
 *
 * Why it exists: the parser behind it (cJSON) takes trailing text, leading zeros, raw control characters, bad UTF-8 and
 * duplicate keys, cuts strings at \u0000 and follows a thousand levels of nesting on the caller's stack. What passes here,
 * the parser reads in the only way it can be read.
 *
 * Method: recursive descent with one function per rule of RFC 8259, its depth limited by QG_DOCUMENT_DEPTH_MAX. A function
 * returns false when the scan is over: a fault was added, or memory was short. Invariant: `at` never passes `length`.
 *
 * Keys: those of the objects that are open lie unescaped, one behind the other and NUL-terminated, in `arena`. A key takes
 * at least two quotes in the document, so an arena as long as the document holds them all. When an object closes, its keys
 * are sorted, equal neighbours reported, and their room given back: n log n, whatever a stranger sends.
 */
#include "schema/scan.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "schema/faults.h"

struct scanner {
    const char *bytes;
    size_t length, at;
    int depth;
    struct qg_path path;
    struct qg_faults *faults;
    bool no_memory;
    char *arena; /* unescaped keys of the open objects */
    size_t arena_used;
    const char **keys; /* into arena */
    size_t key_count, key_room;
};

static bool scan_value(struct scanner *s);

/* Adds a fault at the current place, and ends the scan. */
__attribute__((format(printf, 2, 3))) static bool refuse(struct scanner *s, const char *format, ...) {
    char words[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(words, sizeof words, format, arguments);
    va_end(arguments);
    size_t line = 1, column = 1;
    for (size_t i = 0; i < s->at; i++) {
        const unsigned char byte = (unsigned char)s->bytes[i];
        line += byte == '\n';
        column = byte == '\n' ? 1 : column + ((byte & 0xc0) != 0x80);
    }
    qg_faults_add(s->faults, s->path.text, "line %zu, column %zu: %s", line, column, words);
    return false;
}

/* Refuses what is at the current place, naming it. */
static bool refuse_found(struct scanner *s, const char *allowed) {
    char found[40] = {0}, quoted[QG_QUOTE_ROOM];
    size_t room = sizeof found - 1, n = 0;
    if (s->at == s->length)
        return refuse(s, "found the end of the text, allowed %s", allowed);
    while (n < room && s->at + n < s->length &&
           (strchr("+-._", s->bytes[s->at + n]) != NULL || n == 0 ||
            ((s->bytes[s->at + n] | 32) >= 'a' && (s->bytes[s->at + n] | 32) <= 'z')))
        n++;
    if (n == 1)
        n = qg_utf8_length(s->bytes + s->at, s->length - s->at);
    if (n == 0 || s->bytes[s->at] == '\0')
        return refuse(s, "found the byte 0x%02x, allowed %s", (unsigned char)s->bytes[s->at], allowed);
    memcpy(found, s->bytes + s->at, n);
    return refuse(s, "found %s, allowed %s", qg_quote(quoted, found), allowed);
}

static int peek(const struct scanner *s) {
    return s->at < s->length ? (unsigned char)s->bytes[s->at] : -1;
}

static bool take(struct scanner *s, char wanted) {
    if (peek(s) != (unsigned char)wanted)
        return false;
    s->at++;
    return true;
}

static void skip_space(struct scanner *s) {
    while (s->at < s->length &&
           (s->bytes[s->at] == ' ' || s->bytes[s->at] == '\t' || s->bytes[s->at] == '\n' || s->bytes[s->at] == '\r'))
        s->at++;
}

static bool is_digit(int c) {
    return c >= '0' && c <= '9';
}

/* One digit or more. */
static bool skip_digits(struct scanner *s) {
    if (!is_digit(peek(s)))
        return refuse_found(s, "a digit");
    while (is_digit(peek(s)))
        s->at++;
    return true;
}

/* -? (0 | [1-9][0-9]*) (. [0-9]+)? ([eE] [+-]? [0-9]+)? */
static bool scan_number_syntax(struct scanner *s) {
    take(s, '-');
    if (take(s, '0')) {
        if (is_digit(peek(s)))
            return refuse(s, "found a digit behind a leading zero, allowed numbers without leading zeros");
    } else if (!skip_digits(s)) {
        return false;
    }
    if (take(s, '.') && !skip_digits(s))
        return false;
    if (take(s, 'e') || take(s, 'E')) {
        if (!take(s, '+'))
            take(s, '-');
        return skip_digits(s);
    }
    return true;
}

static bool scan_number(struct scanner *s) {
    const size_t start = s->at;
    if (!scan_number_syntax(s))
        return false;
    const size_t n = s->at - start;
    char number[QG_NUMBER_LENGTH_MAX + 1];
    if (n > QG_NUMBER_LENGTH_MAX)
        return refuse(s, "found a number of %zu characters, allowed at most %d", n, QG_NUMBER_LENGTH_MAX);
    memcpy(number, s->bytes + start, n);
    number[n] = '\0';
    if (!isfinite(strtod(number, NULL)))
        return refuse(s, "found %s, allowed numbers between -1.797e308 and 1.797e308", number);
    return true;
}

/* Four hexadecimal digits, or -1 with nothing taken. */
static long take_hex4(struct scanner *s) {
    long value = 0;
    if (s->length - s->at < 4)
        return -1;
    for (size_t i = 0; i < 4; i++) {
        const int c = (unsigned char)s->bytes[s->at + i];
        if (!is_digit(c) && !((c | 32) >= 'a' && (c | 32) <= 'f'))
            return -1;
        value = value * 16 + (is_digit(c) ? c - '0' : (c | 32) - 'a' + 10);
    }
    s->at += 4;
    return value;
}

/* A code point as UTF-8. Returns the number of bytes. */
static size_t encode_utf8(char out[4], long code) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    const size_t n = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    static const int lead[] = {0, 0, 0xc0, 0xe0, 0xf0};
    for (size_t i = n - 1; i > 0; i--, code >>= 6)
        out[i] = (char)(0x80 | (code & 0x3f));
    out[0] = (char)(lead[n] | code);
    return n;
}

/* Behind "\u": a code point, surrogate pairs joined; or -1 with a fault added. */
static long scan_unicode_escape(struct scanner *s) {
    const long first = take_hex4(s);
    if (first < 0) {
        refuse_found(s, "four hexadecimal digits behind \\u");
        return -1;
    }
    if (first == 0) {
        refuse(s, "found \\u0000, allowed any character but that");
        return -1;
    }
    if (first < 0xd800 || first > 0xdfff)
        return first;
    long second = -1;
    if (first < 0xdc00 && s->length - s->at >= 6 && take(s, '\\') && take(s, 'u'))
        second = take_hex4(s);
    if (second < 0xdc00 || second > 0xdfff) {
        refuse(s, "found half of a surrogate pair (\\u%04lx), allowed whole pairs", first);
        return -1;
    }
    return 0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00);
}

/* Behind a backslash. Writes the character meant to out; 0 when refused. */
static size_t scan_escape(struct scanner *s, char out[4]) {
    static const char escapes[] = "\"\\/bfnrt", meant[] = "\"\\/\b\f\n\r\t";
    if (take(s, 'u')) {
        const long code = scan_unicode_escape(s);
        return code < 0 ? 0 : encode_utf8(out, code);
    }
    const int c = peek(s);
    const char *found = c > 0 ? strchr(escapes, c) : NULL;
    if (!found) {
        refuse_found(s, "one of \" \\ / b f n r t u behind a backslash");
        return 0;
    }
    s->at++;
    out[0] = meant[found - escapes];
    return 1;
}

/* A plain character of a string. Copies it to out; 0 when refused. */
static size_t scan_plain(struct scanner *s, char out[4]) {
    const int c = peek(s);
    if (c >= 0 && c < 0x20) {
        refuse(s, "found the control character 0x%02x in a string, allowed only as an escape", (unsigned)c);
        return 0;
    }
    const size_t n = qg_utf8_length(s->bytes + s->at, s->length - s->at);
    if (n == 0) {
        refuse_found(s, "valid UTF-8");
        return 0;
    }
    memcpy(out, s->bytes + s->at, n);
    s->at += n;
    return n;
}

/* A string; unescaped and NUL-terminated to out unless that is NULL. */
static bool scan_string(struct scanner *s, char *out) {
    char character[4];
    if (!take(s, '"'))
        return refuse_found(s, "a string in double quotes");
    while (!take(s, '"')) {
        if (s->at == s->length)
            return refuse(s, "found the end of the text inside a string, allowed a closing quote");
        const size_t n = take(s, '\\') ? scan_escape(s, character) : scan_plain(s, character);
        if (n == 0)
            return false;
        if (out) {
            memcpy(out, character, n);
            out += n;
        }
    }
    if (out)
        *out = '\0';
    return true;
}

/* Remembers the key that lies at the end of the arena. */
static bool keep_key(struct scanner *s) {
    if (s->key_count == s->key_room) {
        const size_t room = s->key_room ? 2 * s->key_room : 64;
        const char **keys = realloc(s->keys, room * sizeof *keys);
        if (!keys) {
            s->no_memory = true;
            return false;
        }
        s->keys = keys;
        s->key_room = room;
    }
    const char *key = s->arena + s->arena_used;
    s->keys[s->key_count++] = key;
    s->arena_used += strlen(key) + 1;
    assert(s->arena_used <= s->length);
    return true;
}

static int compare_keys(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Reports the keys from `first` on that are there twice, each once, and forgets all of them. */
static void close_keys(struct scanner *s, size_t first, size_t arena_used) {
    const size_t n = s->key_count - first;
    const char **keys = s->keys + first;
    if (n > 1)
        qsort(keys, n, sizeof *keys, compare_keys);
    for (size_t i = 1; i < n; i++) {
        if (strcmp(keys[i], keys[i - 1]) != 0 || (i > 1 && strcmp(keys[i], keys[i - 2]) == 0))
            continue;
        const size_t mark = qg_path_push(&s->path, keys[i]);
        qg_faults_add(s->faults, s->path.text, "found the key more than once, allowed once");
        qg_path_pop(&s->path, mark);
    }
    s->key_count = first;
    s->arena_used = arena_used;
}

/* One "key": value. */
static bool scan_member(struct scanner *s) {
    char *key = s->arena + s->arena_used;
    if (!scan_string(s, key) || !keep_key(s))
        return false;
    const size_t mark = qg_path_push(&s->path, key);
    skip_space(s);
    if (!take(s, ':'))
        return refuse_found(s, "a colon behind the key");
    if (!scan_value(s))
        return false;
    qg_path_pop(&s->path, mark);
    return true;
}

static bool scan_object(struct scanner *s) {
    const size_t first = s->key_count, arena_used = s->arena_used;
    skip_space(s);
    if (take(s, '}'))
        return true;
    do {
        skip_space(s);
        if (!scan_member(s))
            return false;
        skip_space(s);
    } while (take(s, ','));
    if (!take(s, '}'))
        return refuse_found(s, "a comma or a closing brace");
    close_keys(s, first, arena_used);
    return true;
}

static bool scan_array(struct scanner *s) {
    skip_space(s);
    if (take(s, ']'))
        return true;
    size_t index = 0;
    do {
        const size_t mark = qg_path_push_index(&s->path, index++);
        if (!scan_value(s))
            return false;
        qg_path_pop(&s->path, mark);
        skip_space(s);
    } while (take(s, ','));
    return take(s, ']') || refuse_found(s, "a comma or a closing bracket");
}

static bool scan_nested(struct scanner *s) {
    if (s->depth == QG_DOCUMENT_DEPTH_MAX)
        return refuse(s, "found more than %d levels of nesting, allowed at most %d", QG_DOCUMENT_DEPTH_MAX,
                      QG_DOCUMENT_DEPTH_MAX);
    s->depth++;
    const bool object = take(s, '{');
    const bool good = object ? scan_object(s) : take(s, '[') && scan_array(s);
    s->depth--;
    return good;
}

static bool scan_word(struct scanner *s) {
    static const char *const words[] = {"true", "false", "null"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const size_t n = strlen(words[i]);
        if (s->length - s->at >= n && memcmp(s->bytes + s->at, words[i], n) == 0) {
            s->at += n;
            return true;
        }
    }
    return refuse_found(s, "a JSON value");
}

static bool scan_value(struct scanner *s) {
    skip_space(s);
    const int c = peek(s);
    if (c == '{' || c == '[')
        return scan_nested(s);
    if (c == '"')
        return scan_string(s, NULL);
    return c == '-' || is_digit(c) ? scan_number(s) : scan_word(s);
}

static bool scan_text(struct scanner *s) {
    if (s->length > QG_DOCUMENT_BYTES_MAX)
        return refuse(s, "found %zu bytes, allowed at most %d", s->length, QG_DOCUMENT_BYTES_MAX);
    if (s->length >= 3 && memcmp(s->bytes, "\xef\xbb\xbf", 3) == 0)
        return refuse(s, "found a byte order mark, allowed UTF-8 without one");
    if (!scan_value(s))
        return false;
    skip_space(s);
    return s->at == s->length || refuse_found(s, "nothing behind the end of the document");
}

enum qg_document_status qg_scan(const char *bytes, size_t length, struct qg_faults *faults) {
    struct scanner s = {.bytes = bytes, .length = length, .faults = faults};
    const size_t before = faults->count + faults->lost;
    s.arena = malloc(length && length <= QG_DOCUMENT_BYTES_MAX ? length : 1);
    if (!s.arena)
        return QG_DOCUMENT_NO_MEMORY;
    const bool good = scan_text(&s);
    free(s.arena);
    free(s.keys);
    if (s.no_memory)
        return QG_DOCUMENT_NO_MEMORY;
    assert(good || faults->count + faults->lost > before);
    return good && faults->count + faults->lost == before ? QG_DOCUMENT_OK : QG_DOCUMENT_NOT_JSON;
}
