/* Pointers and words for faults. */
#include "schema/faults.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Appends a character to the path, "~" and "/" escaped. False when it does not fit. */
static bool push_bytes(struct qg_path *path, const char *bytes, size_t length) {
    if (length >= sizeof path->text - path->length)
        return false;
    memcpy(path->text + path->length, bytes, length);
    path->length += length;
    path->text[path->length] = '\0';
    return true;
}

size_t qg_path_push(struct qg_path *path, const char *key) {
    const size_t mark = path->length;
    bool fits = push_bytes(path, "/", 1);
    for (const char *at = key; fits && *at;) {
        const size_t step = qg_utf8_length(at, strlen(at));
        if (*at == '~')
            fits = push_bytes(path, "~0", 2);
        else if (*at == '/')
            fits = push_bytes(path, "~1", 2);
        else
            fits = step && push_bytes(path, at, step);
        at += step ? step : 1;
    }
    if (!fits)
        qg_path_pop(path, mark);
    return mark;
}

size_t qg_path_push_index(struct qg_path *path, size_t index) {
    char number[24];
    snprintf(number, sizeof number, "%zu", index);
    return qg_path_push(path, number);
}

void qg_path_pop(struct qg_path *path, size_t mark) {
    path->length = mark;
    path->text[mark] = '\0';
}

void qg_faults_add(struct qg_faults *faults, const char *pointer, const char *format, ...) {
    if (faults->count == QG_FAULTS_ROOM) {
        faults->lost++;
        return;
    }
    struct qg_fault *fault = &faults->item[faults->count++];
    snprintf(fault->pointer, sizeof fault->pointer, "%s", pointer);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(fault->detail, sizeof fault->detail, format, arguments);
    va_end(arguments);
}

/* One character of a quoted string: itself, or escaped. Returns the bytes written (at most 6, and a NUL behind them). */
static size_t quote_character(char *out, const char *at, size_t step) {
    const unsigned char byte = (unsigned char)*at;
    if (step == 0 || byte < 0x20 || byte == 0x7f)
        return (size_t)sprintf(out, "\\u%04x", byte);
    if (byte == '"' || byte == '\\')
        return (size_t)sprintf(out, "\\%c", byte);
    if (byte == 0xc2 && (unsigned char)at[1] < 0xa0) /* U+0080 to U+009F: the terminals' other control characters */
        return (size_t)sprintf(out, "\\u%04x", (unsigned char)at[1]);
    memcpy(out, at, step);
    return step;
}

const char *qg_quote(char out[QG_QUOTE_ROOM], const char *utf8) {
    static const char ellipsis[] = "...";
    size_t length = 0;
    out[length++] = '"';
    const char *at = utf8;
    while (*at && length < QG_QUOTE_ROOM - 6 - sizeof ellipsis - 1) {
        const size_t step = qg_utf8_length(at, strlen(at));
        length += quote_character(out + length, at, step);
        at += step ? step : 1;
    }
    out[length++] = '"';
    memcpy(out + length, *at ? ellipsis : "", *at ? sizeof ellipsis : 1);
    return out;
}

size_t qg_utf8_length(const char *bytes, size_t length) {
    const unsigned char *b = (const unsigned char *)bytes;
    if (length == 0)
        return 0;
    if (b[0] < 0x80)
        return 1;
    const size_t n = b[0] >= 0xf0 ? 4 : b[0] >= 0xe0 ? 3 : 2;
    if (b[0] < 0xc2 || b[0] > 0xf4 || length < n)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((b[i] & 0xc0) != 0x80)
            return 0;
    if ((b[0] == 0xe0 && b[1] < 0xa0) || (b[0] == 0xed && b[1] > 0x9f)) /* overlong; surrogates */
        return 0;
    if ((b[0] == 0xf0 && b[1] < 0x90) || (b[0] == 0xf4 && b[1] > 0x8f)) /* overlong; beyond U+10FFFF */
        return 0;
    return n;
}
