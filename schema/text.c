/* Growing text and the JSON writer on it.
 *
 * Numbers: the shortest of %.15g, %.16g and %.17g that reads back to the same double. 17 digits always do, so the search
 * ends; most numbers that people type need 15. The C library prints the decimal point of the current locale; it is put
 * right afterwards, so the text is the same in any locale.
 */
#include "schema/text.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void qg_text_finish(struct qg_text *text) {
    free(text->data);
    *text = (struct qg_text){0};
}

/* Makes room for `more` bytes and the NUL behind them. */
static bool reserve(struct qg_text *text, size_t more) {
    if (text->failed)
        return false;
    if (more < text->room - text->length)
        return true;
    if (more >= SIZE_MAX / 4 || text->length >= SIZE_MAX / 4) {
        text->failed = true;
        return false;
    }
    size_t room = text->room ? text->room : 256;
    while (room <= text->length + more)
        room *= 2;
    char *data = realloc(text->data, room);
    if (!data) {
        text->failed = true;
        return false;
    }
    text->data = data;
    text->room = room;
    return true;
}

void qg_text_add(struct qg_text *text, const char *bytes, size_t length) {
    if (!reserve(text, length))
        return;
    if (length)
        memcpy(text->data + text->length, bytes, length);
    text->length += length;
    text->data[text->length] = '\0';
}

void qg_text_format(struct qg_text *text, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    assert(length >= 0);
    if (reserve(text, (size_t)length)) {
        vsnprintf(text->data + text->length, (size_t)length + 1, format, again);
        text->length += (size_t)length;
    }
    va_end(again);
    va_end(arguments);
}

/* The comma that is owed, before the next item. */
static void before_item(struct qg_text *text) {
    if (text->comma)
        qg_text_add(text, ",", 1);
    text->comma = false;
}

void qg_json_open(struct qg_text *text, char bracket) {
    assert(bracket == '{' || bracket == '[');
    before_item(text);
    qg_text_add(text, &bracket, 1);
}

void qg_json_close(struct qg_text *text, char bracket) {
    assert(bracket == '}' || bracket == ']');
    qg_text_add(text, &bracket, 1);
    text->comma = true;
}

/* A string in quotes. Bytes from 0x80 up pass as they are: strings are UTF-8. */
static void add_quoted(struct qg_text *text, const char *utf8) {
    qg_text_add(text, "\"", 1);
    const char *plain = utf8; /* start of the bytes not yet written */
    const char *at = utf8;
    for (; *at; at++) {
        const unsigned char byte = (unsigned char)*at;
        if (byte >= 0x20 && byte != '"' && byte != '\\')
            continue;
        qg_text_add(text, plain, (size_t)(at - plain));
        plain = at + 1;
        if (byte < 0x20)
            qg_text_format(text, "\\u%04x", byte);
        else
            qg_text_format(text, "\\%c", byte);
    }
    qg_text_add(text, plain, (size_t)(at - plain));
    qg_text_add(text, "\"", 1);
}

void qg_json_name(struct qg_text *text, const char *name) {
    before_item(text);
    add_quoted(text, name);
    qg_text_add(text, ":", 1);
}

void qg_json_raw(struct qg_text *text, const char *json) {
    before_item(text);
    qg_text_add(text, json, strlen(json));
    text->comma = true;
}

void qg_json_string(struct qg_text *text, const char *utf8) {
    before_item(text);
    add_quoted(text, utf8);
    text->comma = true;
}

void qg_json_number(struct qg_text *text, double value) {
    char number[QG_NUMBER_ROOM];
    qg_number_print(number, value);
    qg_json_raw(text, number);
}

void qg_json_integer(struct qg_text *text, int64_t value) {
    char number[QG_NUMBER_ROOM];
    snprintf(number, sizeof number, "%" PRId64, value);
    qg_json_raw(text, number);
}

void qg_json_bool(struct qg_text *text, bool value) {
    qg_json_raw(text, value ? "true" : "false");
}

void qg_json_null(struct qg_text *text) {
    qg_json_raw(text, "null");
}

/* Replaces whatever the locale put for the decimal point (one byte or more) by a point. */
static int with_decimal_point(char *number) {
    static const char usual[] = "+-0123456789e";
    const size_t before = strspn(number, usual);
    if (number[before] != '\0') {
        const size_t point = strcspn(number + before, usual);
        memmove(number + before + 1, number + before + point, strlen(number + before + point) + 1);
        number[before] = '.';
    }
    return (int)strlen(number);
}

int qg_number_print(char out[QG_NUMBER_ROOM], double value) {
    if (!isfinite(value))
        return snprintf(out, QG_NUMBER_ROOM, "null");
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, QG_NUMBER_ROOM, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return with_decimal_point(out);
}
