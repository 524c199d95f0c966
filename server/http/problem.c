/* The table of errors and their documents. See problem.h. */
#include "server/http/problem.h"

#include <assert.h>
#include <stdio.h>

#include "server/base/member.h"

struct entry {
    int status;
    const char *slug, *title;
};

#define ENTRY(name, status, code, title) {status, code, title},
static const struct entry problems[QG_PROBLEM_COUNT] = {QG_PROBLEM_TABLE(ENTRY)};
#undef ENTRY

static const struct entry *entry_of(enum qg_problem_code code) {
    assert(code >= 0 && code < QG_PROBLEM_COUNT);
    return &problems[code];
}

int qg_problem_status(enum qg_problem_code code) {
    return entry_of(code)->status;
}

const char *qg_problem_slug(enum qg_problem_code code) {
    return entry_of(code)->slug;
}

const char *qg_problem_title(enum qg_problem_code code) {
    return entry_of(code)->title;
}

static void write_faults(struct qg_text *text, const struct qg_faults *faults) {
    qg_json_name(text, "errors");
    qg_json_open(text, '[');
    for (size_t i = 0; i < faults->count; i++) {
        qg_json_open(text, '{');
        qg_member_text(text, "pointer", faults->item[i].pointer);
        qg_member_text(text, "detail", faults->item[i].detail);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
    if (faults->lost > 0) {
        qg_json_name(text, "errors_not_listed");
        qg_json_integer(text, (int64_t)faults->lost);
    }
}

void qg_problem_write(struct qg_text *text, enum qg_problem_code code, const char *detail,
                      const struct qg_faults *faults) {
    const struct entry *entry = entry_of(code);
    char type[96];
    snprintf(type, sizeof type, "urn:quietgear:problem:%s", entry->slug);
    qg_json_open(text, '{');
    qg_member_text(text, "type", type);
    qg_member_text(text, "title", entry->title);
    qg_json_name(text, "status");
    qg_json_integer(text, entry->status);
    if (detail)
        qg_member_text(text, "detail", detail);
    if (faults)
        write_faults(text, faults);
    qg_json_close(text, '}');
}
