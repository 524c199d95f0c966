/* Small requests and answers. See form.h. */
#include "server/calls/form.h"

#include <assert.h>
#include <cjson/cJSON.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "schema/faults.h"
#include "schema/scan.h"
#include "server/base/clock.h"

/* --- bodies --- */

static bool is_among(const char *word, const char *const *names) {
    while (*names && strcmp(*names, word) != 0)
        names++;
    return *names;
}

/* Appends the names as "a, b and c". */
static void list(struct qg_text *text, const char *const *names) {
    for (size_t i = 0; names[i]; i++)
        qg_text_format(text, "%s%s", i == 0 ? "" : names[i + 1] ? ", " : " and ", names[i]);
}

void qg_form_fault(struct qg_form *form, const char *key, const char *format, ...) {
    struct qg_path path = {0};
    char words[300];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(words, sizeof words, format, arguments);
    va_end(arguments);
    qg_path_push(&path, key);
    qg_faults_add(form->faults, path.text, "%s", words);
}

static void check_keys(struct qg_form *form, const char *const *keys) {
    const cJSON *member;
    struct qg_text allowed = {0};
    list(&allowed, keys);
    cJSON_ArrayForEach(member, form->object) {
        if (!is_among(member->string, keys))
            qg_form_fault(form, member->string, "unknown key, allowed are %s", allowed.data ? allowed.data : "");
    }
    qg_text_finish(&allowed);
}

/* The faults as a problem. */
static void reply_faults(const struct qg_form *form, enum qg_problem_code code, struct qg_reply *reply) {
    qg_text_finish(&reply->body);
    qg_problem_write(&reply->body, code, NULL, form->faults);
    reply->status = qg_problem_status(code);
    reply->media_type = "application/problem+json";
}

bool qg_form_read(struct qg_form *form, const struct qg_request *request, const char *const *keys,
                  struct qg_reply *reply) {
    const char *bytes = request->body.data ? request->body.data : "";
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    form->object = NULL;
    form->faults = calloc(1, sizeof *form->faults);
    if (form->faults)
        status = qg_scan(bytes, request->body.length, form->faults);
    if (status == QG_DOCUMENT_OK)
        form->object = cJSON_ParseWithLength(bytes, request->body.length);
    if (status == QG_DOCUMENT_NOT_JSON) {
        reply_faults(form, QG_PROBLEM_NOT_JSON, reply);
    } else if (!form->object) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the body");
    } else if (!cJSON_IsObject(form->object)) {
        qg_faults_add(form->faults, "", "found something else, allowed is an object");
        reply_faults(form, QG_PROBLEM_INVALID_BODY, reply);
    } else {
        check_keys(form, keys);
        return true;
    }
    return false;
}

/* Characters of a text; 0 when one of them is a control character. */
static size_t count_characters(const char *utf8) {
    size_t count = 0;
    for (const unsigned char *at = (const unsigned char *)utf8; *at; at++) {
        if (*at < 0x20 || *at == 0x7f || (at[0] == 0xc2 && at[1] < 0xa0))
            return 0;
        count += (*at & 0xc0) != 0x80;
    }
    return count;
}

const char *qg_form_text(struct qg_form *form, const char *key, size_t most, bool required) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(form->object, key);
    if (!item) {
        if (required)
            qg_form_fault(form, key, "is missing");
        return NULL;
    }
    size_t count = cJSON_IsString(item) ? count_characters(item->valuestring) : 0;
    if (count > 0 && count <= most)
        return item->valuestring;
    qg_form_fault(form, key, "allowed is a text of 1 to %zu characters, none of them a control character", most);
    return NULL;
}

static unsigned bit_of(const cJSON *item, const char *const *names) {
    for (unsigned i = 0; names[i]; i++)
        if (cJSON_IsString(item) && strcmp(names[i], item->valuestring) == 0)
            return 1u << i;
    return 0;
}

/* Says what is wrong with an array of words; `wrong` is the first item that is no word or a repeated one, NULL without. */
static void refuse_words(struct qg_form *form, const char *key, const char *const *names, const cJSON *wrong) {
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(form->object, key);
    const char *found = !array                           ? "is missing"
                        : cJSON_IsArray(array) && !wrong ? "found an empty array"
                                                         : "found something else";
    char quoted[QG_QUOTE_ROOM], named[QG_QUOTE_ROOM + 16];
    struct qg_text allowed = {0};
    if (cJSON_IsArray(array) && cJSON_IsString(wrong)) {
        snprintf(named, sizeof named, "found %s%s", qg_quote(quoted, wrong->valuestring),
                 bit_of(wrong, names) ? " twice" : "");
        found = named;
    }
    list(&allowed, names);
    qg_form_fault(form, key, "%s, needed is an array of one or more of %s, none twice", found,
                  allowed.data ? allowed.data : "");
    qg_text_finish(&allowed);
}

unsigned qg_form_words(struct qg_form *form, const char *key, const char *const *names) {
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(form->object, key), *item;
    unsigned bits = 0;
    const cJSON *wrong = NULL;
    cJSON_ArrayForEach(item, array) {
        unsigned bit = bit_of(item, names);
        if (!wrong && (!bit || (bits & bit)))
            wrong = item;
        bits |= bit;
    }
    if (cJSON_IsArray(array) && bits && !wrong)
        return bits;
    refuse_words(form, key, names, wrong);
    return 0;
}

int qg_form_count(struct qg_form *form, const char *key, int least, int most) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(form->object, key);
    if (!item)
        return 0;
    if (cJSON_IsNumber(item) && item->valuedouble >= least && item->valuedouble <= most &&
        item->valuedouble == floor(item->valuedouble))
        return (int)item->valuedouble;
    qg_form_fault(form, key, "allowed is a whole number from %d to %d", least, most);
    return 0;
}

int64_t qg_form_time(struct qg_form *form, const char *key, int64_t after) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(form->object, key);
    int64_t time;
    if (!item)
        return 0;
    if (!cJSON_IsString(item) || !qg_time_read(item->valuestring, &time))
        qg_form_fault(form, key, "allowed is a time such as 2030-12-31T23:59:59Z (RFC 3339)");
    else if (time <= after)
        qg_form_fault(form, key, "found a time that is over, allowed is one to come");
    else
        return time;
    return 0;
}

bool qg_form_is_right(const struct qg_form *form, struct qg_reply *reply) {
    if (form->faults->count + form->faults->lost == 0)
        return true;
    reply_faults(form, QG_PROBLEM_INVALID_BODY, reply);
    return false;
}

void qg_form_finish(struct qg_form *form) {
    cJSON *item;
    cJSON_ArrayForEach(item, form->object) {
        if (cJSON_IsString(item))
            qg_secret_wipe(item->valuestring, strlen(item->valuestring));
    }
    cJSON_Delete(form->object);
    free(form->faults);
    *form = (struct qg_form){0};
}

/* --- queries --- */

enum { PARAMETERS_MAX = 16 };

bool qg_page_read(const struct qg_request *request, const char *const *filters, struct qg_page *page,
                  struct qg_reply *reply) {
    const char *names[PARAMETERS_MAX + 1] = {"limit", "cursor", NULL};
    for (size_t i = 0; filters && filters[i]; i++) {
        assert(i + 2 < PARAMETERS_MAX);
        names[i + 2] = filters[i];
    }
    const char *limit = qg_target_query(&request->target, "limit");
    const char *cursor = qg_target_query(&request->target, "cursor");
    int64_t number = QG_PAGE_LIMIT;
    page->before = 0;
    if (!qg_request_has_only(request, names, reply))
        return false;
    if (limit && !qg_read_whole_number(limit, 1, QG_PAGE_LIMIT_MAX, &number)) {
        qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "limit: found \"%.100s\", allowed are whole numbers from 1 to %d",
                         limit, QG_PAGE_LIMIT_MAX);
        return false;
    }
    page->limit = (size_t)number;
    if (!cursor || qg_read_whole_number(cursor, 1, INT64_MAX, &page->before))
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "cursor: take the address of the next page from the Link field");
    return false;
}

void qg_query_add(struct qg_text *text, const char *name, const char *value) {
    if (!value)
        return;
    qg_text_format(text, "&%s=", name);
    for (const char *c = value; *c; c++) {
        bool plain = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9') || *c == '-';
        qg_text_format(text, plain ? "%c" : "%%%02X", (unsigned char)*c);
    }
}

void qg_page_link(const char *path, const struct qg_page *page, int64_t before, const char *more,
                  struct qg_reply *reply) {
    qg_reply_header(reply, "Link", "<%s?limit=%zu&cursor=%lld%s>; rel=\"next\"", path, page->limit, (long long)before,
                    more ? more : "");
}

/* --- answers --- */

void qg_reply_json(struct qg_reply *reply, int status) {
    reply->status = status;
    reply->media_type = "application/json";
    qg_reply_header(reply, "Cache-Control", "no-store");
}
