/* The calls about access. See access.h.
 *
 * POST /v1/tokens          {"name", "scopes": ["read", "submit", "admin"]}, and if wanted {"expires_at",
 *                          "requests_per_minute", "queued_jobs"} → 201 and the token, with its text in `token`: it is
 *                          shown this once.
 * GET  /v1/tokens          {"tokens": [...]}, oldest first, without their texts.
 * DELETE /v1/tokens/{id}   204: revoked.
 * GET  /v1/audit           {"entries": [...]}, newest first; `limit` (1 to 500, 50), `cursor` from Link. Only those of an
 *                          `action` ("job.cancel", or all of "job"), an `actor` (a token's id or name), a `subject`, an
 *                          `address`, `since` and `until` a time (RFC 3339, the latter excluded). A page
 *                          with a Link may have fewer entries than its limit, or none: older ones were not looked at yet.
 */
#include "server/calls/access.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/member.h"
#include "server/calls/form.h"
#include "server/store/access.h"

/* --- tokens --- */

/* A limit of the token's own; null when it has none. */
static void write_limit(struct qg_text *out, const char *name, int limit) {
    qg_json_name(out, name);
    if (limit > 0)
        qg_json_integer(out, limit);
    else
        qg_json_null(out);
}

static void write_token(struct qg_text *out, const struct qg_token *token, const char *text) {
    qg_json_open(out, '{');
    qg_member_text(out, "id", token->id);
    qg_member_text(out, "name", token->name);
    qg_json_name(out, "scopes");
    qg_scopes_write(out, token->scopes);
    qg_member_time(out, "created_at", token->created_at);
    qg_member_time(out, "expires_at", token->expires_at);
    qg_json_name(out, "expired");
    qg_json_bool(out, qg_token_is_over(token, qg_wall_clock()));
    qg_member_time(out, "last_used_at", token->last_used_at);
    write_limit(out, "requests_per_minute", token->requests_per_minute);
    write_limit(out, "queued_jobs", token->queued_jobs);
    if (text)
        qg_member_text(out, "token", text);
    qg_json_close(out, '}');
}

void qg_list_tokens(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    struct qg_token *tokens = calloc(QG_TOKENS_MAX, sizeof *tokens);
    if (!tokens) {
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to list the tokens");
        return;
    }
    size_t count = qg_access_list(service->access, tokens);
    qg_reply_json(reply, 200);
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "tokens");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < count; i++)
        write_token(&reply->body, &tokens[i], NULL);
    qg_json_close(&reply->body, ']');
    qg_json_close(&reply->body, '}');
    free(tokens);
}

/* Reads the body; false with a problem when it is wrong. */
static bool read_token(const struct qg_request *request, struct qg_token *token, struct qg_reply *reply) {
    static const char *const keys[] = {"name", "scopes", "expires_at", "requests_per_minute", "queued_jobs", NULL};
    struct qg_form form;
    bool right = qg_form_read(&form, request, keys, reply);
    if (right) {
        const char *name = qg_form_text(&form, "name", QG_TOKEN_NAME_MAX, true);
        token->scopes = qg_form_words(&form, "scopes", qg_scope_names);
        token->expires_at = qg_form_time(&form, "expires_at", qg_wall_clock());
        token->requests_per_minute = qg_form_count(&form, "requests_per_minute", 1, QG_TOKEN_REQUESTS_MAX);
        token->queued_jobs = qg_form_count(&form, "queued_jobs", 1, QG_TOKEN_JOBS_MAX);
        snprintf(token->name, sizeof token->name, "%s", name ? name : "");
        right = qg_form_is_right(&form, reply);
    }
    qg_form_finish(&form);
    return right;
}

void qg_post_token(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_token token = {0};
    char text[QG_TOKEN_ROOM];
    if (!qg_request_has_no_query(request, reply) || !read_token(request, &token, reply))
        return;
    enum qg_store_status status = qg_access_create(service->access, &request->actor, &token, text);
    if (status != QG_STORE_OK) {
        qg_reply_store_problem(reply, status);
        return;
    }
    qg_reply_json(reply, 201);
    write_token(&reply->body, &token, text);
    qg_secret_wipe(text, sizeof text);
}

void qg_delete_token(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    enum qg_store_status status = qg_access_revoke(service->access, &request->actor, request->parameter);
    if (status == QG_STORE_OK)
        reply->status = 204;
    else if (status == QG_STORE_NOT_FOUND)
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such token");
    else
        qg_reply_store_problem(reply, status);
}

/* --- the audit log --- */

static const char *if_any(const char *text) {
    return *text ? text : NULL;
}

static void write_entry(struct qg_text *text, const struct qg_audit_entry *entry) {
    qg_json_open(text, '{');
    qg_json_name(text, "sequence");
    qg_json_integer(text, entry->sequence);
    qg_member_time(text, "at", entry->at);
    qg_member_text(text, "action", entry->action);
    qg_member_text(text, "subject", entry->subject);
    qg_member_text(text, "token", if_any(entry->token));
    qg_member_text(text, "name", if_any(entry->name));
    qg_member_text(text, "address", if_any(entry->address));
    qg_json_close(text, '}');
}

/* What the query asks for. */
struct wish {
    struct qg_page page;
    struct qg_audit_filter filter;
};

static const char *const filters[] = {"action", "actor", "subject", "address", "since", "until", NULL};

/* The time of a parameter, of 40 bytes at most; 0 when it is absent. False, with a problem in the reply, when it is none. */
static bool read_time(const struct qg_request *request, const char *name, int64_t *time, struct qg_reply *reply) {
    const char *text = qg_target_query(&request->target, name);
    *time = 0;
    if (!text || (strlen(text) < QG_TIME_ROOM && qg_time_read(text, time)))
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER,
                     "%s: found \"%.100s\", allowed is a time such as 2030-12-31T23:59:59Z (RFC 3339)", name, text);
    return false;
}

static void refuse_action(const char *action, struct qg_reply *reply) {
    struct qg_text allowed = {0};
    for (size_t i = 0; qg_actions[i]; i++)
        qg_text_format(&allowed, "%s%s", i ? ", " : "", qg_actions[i]);
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER,
                     "action: found \"%.60s\", allowed are %s, and what stands before a dot", action,
                     allowed.data ? allowed.data : "");
    qg_text_finish(&allowed);
}

/* A parameter that may have so many bytes; NULL when it is absent. Longer ones are refused: nothing has such a name. */
static bool read_text(const struct qg_request *request, const char *name, size_t room, const char **text,
                      struct qg_reply *reply) {
    *text = qg_target_query(&request->target, name);
    if (!*text || strlen(*text) < room)
        return true;
    qg_reply_problem(reply, QG_PROBLEM_PARAMETER, "%s: found %zu bytes, allowed are %zu", name, strlen(*text),
                     room - 1);
    return false;
}

static bool read_wish(const struct qg_request *request, struct wish *wish, struct qg_reply *reply) {
    struct qg_audit_filter *filter = &wish->filter;
    if (!qg_page_read(request, filters, &wish->page, reply))
        return false;
    filter->before = wish->page.before;
    filter->action = qg_target_query(&request->target, "action");
    if (filter->action && !qg_action_is_known(filter->action)) {
        refuse_action(filter->action, reply);
        return false;
    }
    return read_text(request, "actor", QG_TOKEN_NAME_ROOM, &filter->actor, reply) &&
           read_text(request, "subject", QG_AUDIT_SUBJECT_ROOM, &filter->subject, reply) &&
           read_text(request, "address", QG_ADDRESS_ROOM, &filter->address, reply) &&
           read_time(request, "since", &filter->since, reply) && read_time(request, "until", &filter->until, reply);
}

/* Writes the entries but for the one beyond the limit, which shows that there are more. */
static void write_entries(const struct qg_request *request, const struct qg_audit_page *found,
                          const struct qg_page *page, struct qg_reply *reply) {
    const size_t count = found->count < page->limit ? found->count : page->limit;
    const int64_t next = found->count > count ? found->entry[count - 1].sequence : found->next;
    struct qg_text more = {0};
    qg_reply_json(reply, 200);
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "entries");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < count; i++)
        write_entry(&reply->body, &found->entry[i]);
    qg_json_close(&reply->body, ']');
    qg_json_close(&reply->body, '}');
    for (size_t i = 0; filters[i]; i++)
        qg_query_add(&more, filters[i], qg_target_query(&request->target, filters[i]));
    if (next > 0)
        qg_page_link("/v1/audit", page, next, more.data, reply);
    reply->body.failed = reply->body.failed || more.failed;
    qg_text_finish(&more);
}

void qg_list_audit(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct wish wish;
    if (!read_wish(request, &wish, reply))
        return;
    struct qg_audit_page found = {.room = wish.page.limit + 1};
    found.entry = calloc(found.room, sizeof *found.entry);
    enum qg_store_status status = found.entry ? qg_store_audit(service->store, &wish.filter, &found) : QG_STORE_FAILED;
    if (status == QG_STORE_OK)
        write_entries(request, &found, &wish.page, reply);
    else
        qg_reply_store_problem(reply, status);
    free(found.entry);
}
