/* Small requests and answers: a body that is one flat JSON object, a query with few parameters.
 *
 * Job documents have a reader of their own (schema/document.h); this one serves calls such as POST /v1/tokens. It is as
 * strict: the bytes pass qg_scan, unknown keys are faults, and all faults are reported at once, each with its pointer.
 */
#ifndef QG_SERVER_CALLS_FORM_H
#define QG_SERVER_CALLS_FORM_H

#include "server/http/exchange.h"

struct cJSON;

/* A body that is being read. */
struct qg_form {
    struct cJSON *object;
    struct qg_faults *faults;
};

/* Reads the body of a request. Keys other than those in the NULL-ended list become faults. False with a problem in the
 * reply when it is no JSON object at all. The caller finishes the form in both cases. */
bool qg_form_read(struct qg_form *form, const struct qg_request *request, const char *const *keys,
                  struct qg_reply *reply);

/* The text at a key, of 1 to `most` characters, none of them a control character; it lives as long as the form. NULL when
 * it is absent (a fault if required) or a fault. */
const char *qg_form_text(struct qg_form *form, const char *key, size_t most, bool required);

/* The array of one or more words at a key as bits, in the order of the NULL-ended names (32 at most). 0 when it is absent
 * or a fault. */
unsigned qg_form_words(struct qg_form *form, const char *key, const char *const *names);

/* The whole number from `least` (> 0) to `most` at a key. 0 when it is absent or a fault. */
int qg_form_count(struct qg_form *form, const char *key, int least, int most);

/* The RFC 3339 time at a key, ms since 1970 UTC, which has to lie after `after`. 0 when it is absent or a fault. */
int64_t qg_form_time(struct qg_form *form, const char *key, int64_t after);

/* Adds a fault of the value at a key, printf-like. */
void qg_form_fault(struct qg_form *form, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* True when no fault was found; else makes the reply a 422 with all of them. */
bool qg_form_is_right(const struct qg_form *form, struct qg_reply *reply);

/* Frees what the form holds, and overwrites its texts: some are secrets. */
void qg_form_finish(struct qg_form *form);

/* A page of a list: the query's `limit` and `cursor`. */
struct qg_page {
    size_t limit;
    int64_t before; /* a sequence; 0: from the newest on */
};

enum { QG_PAGE_LIMIT = 50, QG_PAGE_LIMIT_MAX = 500 };

/* Reads the query as that of a list; false with a problem in the reply when it is not. filters: what else the query may have,
 * NULL-ended; NULL is nothing. */
bool qg_page_read(const struct qg_request *request, const char *const *filters, struct qg_page *page,
                  struct qg_reply *reply);

/* Appends "&name=value" with the value percent-encoded; nothing for NULL. */
void qg_query_add(struct qg_text *text, const char *name, const char *value);

/* Adds the Link field of the next page of the list at `path`; more: further parameters by qg_query_add, NULL is none. */
void qg_page_link(const char *path, const struct qg_page *page, int64_t before, const char *more,
                  struct qg_reply *reply);

/* Makes the reply a JSON document of this status that nobody is to keep; the handler writes it. */
void qg_reply_json(struct qg_reply *reply, int status);

#endif
