/* Words for faults of documents. See words.h. */
#include "schema/words.h"

#include <assert.h>
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "schema/text.h"

const char *qg_found_words(const cJSON *item, char out[QG_QUOTE_ROOM]) {
    if (cJSON_IsString(item))
        return qg_quote(out, item->valuestring);
    if (cJSON_IsNumber(item)) {
        char number[QG_NUMBER_ROOM];
        qg_number_print(number, item->valuedouble);
        snprintf(out, QG_QUOTE_ROOM, "%s", number);
        return out;
    }
    return cJSON_IsObject(item)  ? "an object"
           : cJSON_IsArray(item) ? "an array"
           : cJSON_IsNull(item)  ? "null"
           : cJSON_IsTrue(item)  ? "true"
                                 : "false";
}

const char *qg_range_words(const struct qg_field *field, char out[QG_WORDS_ROOM]) {
    char low[QG_NUMBER_ROOM], high[QG_NUMBER_ROOM];
    qg_number_print(low, field->low);
    qg_number_print(high, field->high);
    snprintf(out, QG_WORDS_ROOM, "%s to %s", low, high);
    return out;
}

/* "a", "b" or "c" */
static const char *choice_words(const struct qg_field *field, char out[QG_WORDS_ROOM]) {
    size_t length = 0;
    out[0] = '\0';
    for (size_t i = 0; field->choices[i]; i++) {
        const char *before = i == 0 ? "" : field->choices[i + 1] ? ", " : " or ";
        length += (size_t)snprintf(out + length, QG_WORDS_ROOM - length, "%s\"%s\"", before, field->choices[i]);
        assert(length < QG_WORDS_ROOM);
    }
    return out;
}

const char *qg_allowed_words(const struct qg_field *field, char out[QG_WORDS_ROOM]) {
    char range[QG_WORDS_ROOM];
    switch (field->type) {
    case QG_FIELD_NUMBER:
        snprintf(out, QG_WORDS_ROOM, "a number from %.100s", qg_range_words(field, range));
        return out;
    case QG_FIELD_INT:
    case QG_FIELD_SIZE:
    case QG_FIELD_SEED:
        snprintf(out, QG_WORDS_ROOM, "a whole number from %.100s", qg_range_words(field, range));
        return out;
    case QG_FIELD_RANGE:
        snprintf(out, QG_WORDS_ROOM, "[lower, upper], two numbers from %.100s", qg_range_words(field, range));
        return out;
    case QG_FIELD_INTERVAL:
    case QG_FIELD_INTERVAL_OF_WHOLES:
        snprintf(out, QG_WORDS_ROOM, "[low, high], two %snumbers from %.100s",
                 field->type == QG_FIELD_INTERVAL ? "" : "whole ", qg_range_words(field, range));
        return out;
    case QG_FIELD_WORD_OR_NUMBER:
        snprintf(out, QG_WORDS_ROOM, "\"%s\" or a number from %.100s", field->choices[0], qg_range_words(field, range));
        return out;
    case QG_FIELD_START:
        snprintf(out, QG_WORDS_ROOM, "\"static\" or a number of half-backlashes from %.100s",
                 qg_range_words(field, range));
        return out;
    case QG_FIELD_TEXT:
    case QG_FIELD_LABELS:
    case QG_FIELD_LOAD_CASES:
    case QG_FIELD_GRID:
        snprintf(out, QG_WORDS_ROOM, "%s of %s%.0f %s", field->type == QG_FIELD_TEXT ? "a string" : "an array",
                 field->type == QG_FIELD_LOAD_CASES || field->type == QG_FIELD_GRID ? "1 to " : "at most ",
                 field->type == QG_FIELD_LABELS ? QG_LABELS_MAX : field->high,
                 field->type == QG_FIELD_TEXT     ? "characters"
                 : field->type == QG_FIELD_LABELS ? "strings"
                                                  : "objects");
        return out;
    case QG_FIELD_OBJECTIVES:
        snprintf(out, QG_WORDS_ROOM, "an array of %.0f or %.0f different ones of %.100s", field->low, field->high,
                 choice_words(field, range));
        return out;
    case QG_FIELD_OBJECT:
        return "an object";
    default:
        return choice_words(field, out);
    }
}

/* Steps of editing that make b of a, both short: Levenshtein's distance, letters compared without case. */
static size_t edit_distance(const char *a, const char *b) {
    enum { LONGEST = 40 };
    const size_t n = strlen(a), m = strlen(b);
    size_t row[LONGEST + 1];
    if (n > LONGEST || m > LONGEST)
        return LONGEST;
    for (size_t j = 0; j <= m; j++)
        row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = tolower((unsigned char)a[i - 1]) == tolower((unsigned char)b[j - 1]);
            const size_t replaced = diagonal + !same, inserted = row[j - 1] + 1, removed = row[j] + 1;
            diagonal = row[j];
            row[j] = replaced < inserted ? replaced : inserted;
            row[j] = removed < row[j] ? removed : row[j];
        }
    }
    return row[m];
}

const char *qg_nearest_key(const struct qg_form *form, const char *key) {
    const size_t length = strlen(key);
    size_t least = length / 3 > 2 ? length / 3 + 1 : 3;
    const char *nearest = NULL;
    for (size_t i = 0; i < form->count; i++) {
        const char *candidate = form->fields[i].key;
        const bool unit_missing = length >= 3 && strncmp(candidate, key, length) == 0; /* "module" for "module_mm" */
        const size_t distance = unit_missing ? 0 : edit_distance(key, candidate);
        if (distance < least) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}
