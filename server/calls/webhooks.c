/* The calls about webhooks. See webhooks.h.
 *
 * POST /v1/webhooks         {"url", "events": ["job.succeeded", ...], "secret"?} → 201 and the webhook with its secret, which
 *                           is shown this once; without one given, the daemon makes it. 422 when the URL may not be used.
 * GET  /v1/webhooks         {"webhooks": [...]}, oldest first, without their secrets.
 * GET  /v1/webhooks/{id}    one of them.
 * DELETE /v1/webhooks/{id}  204: nothing more is sent.
 * GET  .../{id}/deliveries  {"deliveries": [...]}, newest first; `limit` (1 to 500, 50), `cursor` from Link.
 */
#include "server/calls/webhooks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/member.h"
#include "server/calls/form.h"
#include "server/store/webhooks.h"

static void write_events(struct qg_text *text, unsigned events) {
    qg_json_name(text, "events");
    qg_json_open(text, '[');
    for (unsigned i = 0; qg_event_names[i]; i++)
        if (events & 1u << i)
            qg_json_string(text, qg_event_names[i]);
    qg_json_close(text, ']');
}

static void write_webhook(struct qg_text *text, const struct qg_webhook *webhook, bool with_secret) {
    qg_json_open(text, '{');
    qg_member_text(text, "id", webhook->id);
    qg_member_text(text, "url", webhook->url);
    write_events(text, webhook->events);
    qg_member_time(text, "created_at", webhook->created_at);
    qg_member_time(text, "disabled_at", webhook->disabled_at);
    if (with_secret)
        qg_member_text(text, "secret", webhook->secret);
    qg_json_close(text, '}');
}

/* A problem of the store, where QG_STORE_NOT_FOUND is a webhook. */
static void reply_store_problem(struct qg_reply *reply, enum qg_store_status status) {
    if (status == QG_STORE_NOT_FOUND)
        qg_reply_problem(reply, QG_PROBLEM_NOT_FOUND, "there is no such webhook");
    else
        qg_reply_store_problem(reply, status);
}

/* --- making --- */

/* Reads the body's members into the webhook; faults stay in the form. False when memory is short. */
static bool read_members(const struct qg_service *service, struct qg_form *form, struct qg_webhook *webhook) {
    const char *url = qg_form_text(form, "url", QG_URL_MAX, true);
    const char *refusal = url ? qg_url_refusal(url, service->webhook_rules, service->webhook_networks) : NULL;
    const char *secret = qg_form_text(form, "secret", QG_WEBHOOK_SECRET_ROOM - 1, false);
    if (refusal)
        qg_form_fault(form, "url", "%s", refusal);
    if (secret && !qg_webhook_is_secret(secret))
        qg_form_fault(form, "secret", "allowed is whsec_ and the Base64 of 24 to 64 random bytes");
    webhook->events = qg_form_words(form, "events", qg_event_names);
    snprintf(webhook->url, sizeof webhook->url, "%s", url ? url : "");
    snprintf(webhook->secret, sizeof webhook->secret, "%s", secret ? secret : "");
    return refusal != qg_url_no_memory;
}

static bool read_body(const struct qg_service *service, const struct qg_request *request, struct qg_webhook *webhook,
                      struct qg_reply *reply) {
    static const char *const keys[] = {"url", "events", "secret", NULL};
    struct qg_form form;
    bool right = qg_form_read(&form, request, keys, reply);
    if (right) {
        right = read_members(service, &form, webhook);
        if (right)
            right = qg_form_is_right(&form, reply);
        else
            qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the body");
    }
    qg_form_finish(&form);
    return right;
}

void qg_post_webhook(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_webhook webhook = {.created_at = qg_wall_clock()};
    if (!qg_request_has_no_query(request, reply) || !read_body(service, request, &webhook, reply))
        return;
    bool made = qg_webhook_make_id(webhook.id) && (*webhook.secret || qg_webhook_make_secret(webhook.secret));
    enum qg_store_status status =
        made ? qg_store_webhook_add(service->store, &webhook, &request->actor) : QG_STORE_FAILED;
    if (status == QG_STORE_OK) {
        qg_reply_json(reply, 201);
        qg_reply_header(reply, "Location", "/v1/webhooks/%s", webhook.id);
        write_webhook(&reply->body, &webhook, true);
    } else {
        reply_store_problem(reply, status);
    }
    qg_secret_wipe(webhook.secret, sizeof webhook.secret);
}

/* --- looking and forgetting --- */

static void write_webhooks(struct qg_text *text, const struct qg_webhook *webhooks, size_t count) {
    qg_json_open(text, '{');
    qg_json_name(text, "webhooks");
    qg_json_open(text, '[');
    for (size_t i = 0; i < count; i++)
        write_webhook(text, &webhooks[i], false);
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

void qg_list_webhooks(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    size_t count = 0;
    if (!qg_request_has_no_query(request, reply))
        return;
    struct qg_webhook *webhooks = calloc(QG_WEBHOOKS_MAX, sizeof *webhooks);
    enum qg_store_status status = webhooks ? qg_store_webhooks(service->store, webhooks, &count) : QG_STORE_FAILED;
    if (status == QG_STORE_OK) {
        qg_reply_json(reply, 200);
        write_webhooks(&reply->body, webhooks, count);
    } else {
        reply_store_problem(reply, status);
    }
    free(webhooks);
}

void qg_get_webhook(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_webhook webhook;
    if (!qg_request_has_no_query(request, reply))
        return;
    enum qg_store_status status = qg_store_webhook(service->store, request->parameter, &webhook);
    if (status != QG_STORE_OK) {
        reply_store_problem(reply, status);
        return;
    }
    qg_reply_json(reply, 200);
    write_webhook(&reply->body, &webhook, false);
}

void qg_delete_webhook(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    if (!qg_request_has_no_query(request, reply))
        return;
    if (qg_store_drop_deliveries(service->store, request->parameter) == QG_STORE_OK) {
        qg_reply_later(reply, service->board, 1); /* until none are left: all at once may take a second */
        return;
    }
    enum qg_store_status status = qg_store_webhook_remove(service->store, request->parameter, &request->actor);
    if (status == QG_STORE_OK)
        reply->status = 204;
    else
        reply_store_problem(reply, status);
}

/* --- deliveries --- */

static void write_delivery(struct qg_text *text, const struct qg_delivery *delivery) {
    qg_json_open(text, '{');
    qg_member_text(text, "id", delivery->id);
    qg_member_text(text, "event", delivery->event);
    qg_member_text(text, "job", delivery->job);
    qg_member_text(text, "state", delivery->state);
    qg_json_name(text, "attempts");
    qg_json_integer(text, delivery->attempts);
    qg_member_time(text, "created_at", delivery->created_at);
    qg_member_time(text, "last_attempt_at", delivery->last_attempt_at);
    qg_member_time(text, "next_attempt_at", delivery->next_attempt_at);
    qg_json_name(text, "last_status");
    if (delivery->last_status)
        qg_json_integer(text, delivery->last_status);
    else
        qg_json_null(text);
    qg_member_text(text, "last_error", *delivery->last_error ? delivery->last_error : NULL);
    qg_json_close(text, '}');
}

static void write_deliveries(const struct qg_request *request, const struct qg_delivery *deliveries, size_t count,
                             const struct qg_page *page, struct qg_reply *reply) {
    qg_reply_json(reply, 200);
    qg_json_open(&reply->body, '{');
    qg_json_name(&reply->body, "deliveries");
    qg_json_open(&reply->body, '[');
    for (size_t i = 0; i < count && i < page->limit; i++)
        write_delivery(&reply->body, &deliveries[i]);
    qg_json_close(&reply->body, ']');
    qg_json_close(&reply->body, '}');
    if (count <= page->limit)
        return;
    char path[64];
    snprintf(path, sizeof path, "/v1/webhooks/%.*s/deliveries", QG_WEBHOOK_ID_ROOM, request->parameter);
    qg_page_link(path, page, deliveries[page->limit - 1].sequence, NULL, reply);
}

void qg_list_deliveries(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply) {
    struct qg_webhook webhook;
    struct qg_page page;
    size_t count;
    if (!qg_page_read(request, NULL, &page, reply))
        return;
    struct qg_delivery *deliveries = calloc(page.limit + 1, sizeof *deliveries);
    enum qg_store_status status =
        deliveries ? qg_store_webhook(service->store, request->parameter, &webhook) : QG_STORE_FAILED;
    if (status == QG_STORE_OK)
        status = qg_store_deliveries(service->store, webhook.id, page.before, page.limit + 1, deliveries, &count);
    if (status == QG_STORE_OK)
        write_deliveries(request, deliveries, count, &page, reply);
    else
        reply_store_problem(reply, status);
    free(deliveries);
}
