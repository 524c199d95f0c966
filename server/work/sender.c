/* The sender of webhooks. See sender.h.
 *
 * One thread owns everything here but `stopping` and the multi handle's wake-up, which are safe from others. A flight is one
 * attempt at one delivery; its outcome goes to the store before the flight is free again, so that what is written there is
 * never ahead of what has happened.
 */
#include "server/work/sender.h"

#include <config.h>
#include <curl/curl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/store/access.h"
#include "server/store/webhooks.h"

enum {
    FLIGHTS_MAX = 8,
    ATTEMPTS_MAX = 10,
    CONNECT_TIMEOUT_MS = 5000,
    TIMEOUT_MS = 15000,
    ANSWER_BYTES_MAX = 64 << 10,
    NAP_MAX_MS = 60000, /* the wall clock may be set: look again at least so often */
    PAUSE_MS = 10000,
    LOOK_AGAIN_MS = 1000, /* after what is due could not be read */
    CHORE_INTERVAL_MS = 3600000
};

#define WAIT_MAX_MS ((int64_t)12 * 3600 * 1000)
#define DAY_MS ((int64_t)24 * 3600 * 1000)

struct flight {
    struct qg_sender *sender;
    struct qg_dispatch dispatch;
    CURL *curl; /* NULL: the flight is free */
    struct curl_slist *headers, *resolve;
    char error[CURL_ERROR_SIZE];
    size_t received;
    bool refused; /* an address that it would have connected to is not allowed */
};

struct qg_sender {
    struct qg_store *store;
    struct qg_sender_options options;
    CURLM *multi;
    pthread_t thread;
    atomic_bool stopping, news;
    struct flight flights[FLIGHTS_MAX];
    int64_t next;  /* wall clock ms, when a delivery will be due */
    int64_t pause; /* wall clock ms, until when nothing is sent because the store cannot write down what came of it */
    int64_t chore; /* wall clock ms, when old log is to be dropped again */
};

int64_t qg_sender_wait(int first_wait, int attempts) {
    int64_t wait = (int64_t)first_wait * 1000;
    if (attempts >= ATTEMPTS_MAX)
        return 0;
    while (--attempts > 0 && wait < WAIT_MAX_MS)
        wait *= 4;
    return wait < WAIT_MAX_MS ? wait : WAIT_MAX_MS;
}

/* --- one attempt --- */

/* Opens the socket for one address, if it may be connected to. This is the gate that no name gets around. */
static curl_socket_t open_socket(void *self, curlsocktype purpose, struct curl_sockaddr *address) {
    struct flight *flight = self;
    if (purpose == CURLSOCKTYPE_IPCXN && qg_address_is_allowed(&address->addr, flight->sender->options.networks))
        return socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
    flight->refused = true;
    return CURL_SOCKET_BAD;
}

/* Throws the answer away; too long a one is cut. */
static size_t drop(char *bytes, size_t size, size_t count, void *self) {
    struct flight *flight = self;
    (void)bytes;
    flight->received += size * count;
    return flight->received <= ANSWER_BYTES_MAX ? size * count : 0;
}

static bool add_header(struct flight *flight, const char *name, const char *value) {
    char line[200];
    snprintf(line, sizeof line, "%s: %s", name, value);
    struct curl_slist *longer = curl_slist_append(flight->headers, line);
    if (longer)
        flight->headers = longer;
    return longer;
}

static bool add_headers(struct flight *flight, int64_t now) {
    char signature[QG_SIGNATURE_ROOM], timestamp[24];
    const struct qg_dispatch *dispatch = &flight->dispatch;
    const struct qg_message message = {.id = dispatch->id, .body = dispatch->body, .timestamp = now / 1000};
    snprintf(timestamp, sizeof timestamp, "%lld", (long long)message.timestamp);
    return qg_webhook_sign(signature, dispatch->secret, &message) && add_header(flight, "webhook-id", dispatch->id) &&
           add_header(flight, "webhook-timestamp", timestamp) && add_header(flight, "webhook-signature", signature) &&
           add_header(flight, "Content-Type", "application/json") && add_header(flight, "Expect", "");
}

static void set_options(struct flight *flight) {
    CURL *curl = flight->curl;
    curl_easy_setopt(curl, CURLOPT_PRIVATE, flight);
    curl_easy_setopt(curl, CURLOPT_URL, flight->dispatch.url);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
    curl_easy_setopt(curl, CURLOPT_PROXY, "");
    curl_easy_setopt(curl, CURLOPT_NETRC, (long)CURL_NETRC_IGNORED);
    curl_easy_setopt(curl, CURLOPT_FORBID_REUSE, 1L);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT_MS, (long)CONNECT_TIMEOUT_MS);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, (long)TIMEOUT_MS);
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "quietgear/" PACKAGE_VERSION);
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, flight->headers);
    curl_easy_setopt(curl, CURLOPT_RESOLVE, flight->resolve);
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE, (long)strlen(flight->dispatch.body));
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS, flight->dispatch.body);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, drop);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, flight);
    curl_easy_setopt(curl, CURLOPT_OPENSOCKETFUNCTION, open_socket);
    curl_easy_setopt(curl, CURLOPT_OPENSOCKETDATA, flight);
    curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, flight->error);
}

/* Frees what a flight holds, and the flight. */
static void land(struct flight *flight) {
    if (flight->curl)
        curl_multi_remove_handle(flight->sender->multi, flight->curl);
    curl_easy_cleanup(flight->curl);
    curl_slist_free_all(flight->headers);
    curl_slist_free_all(flight->resolve);
    qg_dispatch_finish(&flight->dispatch);
    *flight = (struct flight){.sender = flight->sender};
}

/* Starts an attempt; false when memory is short. */
static bool take_off(struct flight *flight, int64_t now) {
    const char *resolve = flight->sender->options.resolve;
    if (resolve)
        flight->resolve = curl_slist_append(NULL, resolve);
    flight->curl = curl_easy_init();
    if (!flight->curl || !add_headers(flight, now))
        return false;
    set_options(flight);
    return curl_multi_add_handle(flight->sender->multi, flight->curl) == CURLM_OK;
}

/* --- how it went --- */

static bool is_last(const struct qg_outcome *outcome) {
    return outcome->gone || outcome->retry_at == 0;
}

static void log_failure(const struct qg_dispatch *dispatch, const struct qg_outcome *outcome) {
    bool last = is_last(outcome);
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_WARNING,
                                        .event = last ? QG_EVENT_WEBHOOK_GIVEN_UP : QG_EVENT_WEBHOOK_FAILED,
                                        .webhook = dispatch->webhook,
                                        .delivery = dispatch->id,
                                        .attempt = dispatch->attempts + 1,
                                        .status = outcome->status},
                 "webhook %s: %s, attempt %d: %s%s", dispatch->webhook, dispatch->id, dispatch->attempts + 1,
                 outcome->error, last ? "; given up" : "");
}

/* Writes an outcome down; words on failures go to the log as well. */
static void record(struct qg_sender *sender, const struct qg_dispatch *dispatch, struct qg_outcome *outcome,
                   int64_t least_wait) {
    int64_t wait = qg_sender_wait(sender->options.first_wait, dispatch->attempts + 1);
    if (wait > 0)
        outcome->retry_at = outcome->at + (wait > least_wait ? wait : least_wait);
    if (!outcome->delivered)
        log_failure(dispatch, outcome);
    if (sender->options.metrics)
        qg_metrics_count_attempt(sender->options.metrics, outcome->delivered ? QG_ATTEMPT_DELIVERED
                                                          : is_last(outcome) ? QG_ATTEMPT_GIVEN_UP
                                                                             : QG_ATTEMPT_FAILED);
    if (qg_store_attempted(sender->store, dispatch, outcome) != QG_STORE_OK)
        sender->pause = qg_wall_clock() + PAUSE_MS;
}

/* Judges a finished transfer. */
static void judge(struct flight *flight, CURLcode code) {
    struct qg_outcome outcome = {.at = qg_wall_clock()};
    char words[200];
    long status = 0;
    curl_off_t retry_after = 0;
    curl_easy_getinfo(flight->curl, CURLINFO_RESPONSE_CODE, &status);
    curl_easy_getinfo(flight->curl, CURLINFO_RETRY_AFTER, &retry_after);
    bool answered = code == CURLE_OK || (code == CURLE_WRITE_ERROR && flight->received > ANSWER_BYTES_MAX);
    outcome.status = answered ? (int)status : 0;
    outcome.delivered = outcome.status >= 200 && outcome.status < 300;
    outcome.gone = outcome.status == 410;
    if (answered)
        snprintf(words, sizeof words, "answered with status %ld", status);
    else if (flight->refused)
        snprintf(words, sizeof words, "its address is private or of this machine, and not in webhook-networks");
    else
        snprintf(words, sizeof words, "%.180s", flight->error[0] ? flight->error : curl_easy_strerror(code));
    outcome.error = outcome.delivered ? NULL : words;
    int64_t least = retry_after > 0 ? (int64_t)retry_after * 1000 : 0;
    record(flight->sender, &flight->dispatch, &outcome, least < WAIT_MAX_MS ? least : WAIT_MAX_MS);
}

/* Takes in what has finished; true when anything has. */
static bool collect(struct qg_sender *sender) {
    bool any = false;
    int left;
    for (CURLMsg *message; (message = curl_multi_info_read(sender->multi, &left));) {
        struct flight *flight = NULL;
        if (message->msg != CURLMSG_DONE)
            continue;
        CURLcode code = message->data.result;
        curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, (char **)&flight);
        judge(flight, code);
        land(flight);
        any = true;
    }
    return any;
}

/* --- what is due --- */

static bool is_under_way(const struct qg_sender *sender, const char *webhook) {
    for (int i = 0; i < FLIGHTS_MAX; i++)
        if (sender->flights[i].curl && strcmp(sender->flights[i].dispatch.webhook, webhook) == 0)
            return true;
    return false;
}

static struct flight *free_flight(struct qg_sender *sender) {
    for (int i = 0; i < FLIGHTS_MAX; i++)
        if (!sender->flights[i].curl)
            return &sender->flights[i];
    return NULL;
}

/* Sends one delivery, or refuses to. Takes the dispatch over. */
static void send_one(struct qg_sender *sender, struct qg_dispatch *dispatch, int64_t now) {
    const char *refusal = qg_url_refusal(dispatch->url, sender->options.rules, sender->options.networks);
    struct flight *flight = free_flight(sender);
    struct qg_outcome outcome = {.at = now, .error = refusal ? refusal : "there is not enough memory to send it"};
    if (!refusal && flight) {
        flight->dispatch = *dispatch;
        *dispatch = (struct qg_dispatch){0};
        if (take_off(flight, now))
            return;
        record(sender, &flight->dispatch, &outcome, 0);
        land(flight);
    } else if (refusal) {
        record(sender, dispatch, &outcome, 0);
    }
    qg_dispatch_finish(dispatch);
    atomic_store(&sender->news, true); /* when this one is due again; the next one of this webhook may be already */
}

/* Looks up what is due and sends it, as far as there are free flights. */
static void look(struct qg_sender *sender) {
    size_t count;
    int64_t now = qg_wall_clock();
    struct qg_dispatch *due = calloc(QG_WEBHOOKS_MAX, sizeof *due);
    sender->next = now + NAP_MAX_MS;
    if (!due || qg_store_due(sender->store, now, due, &count, &sender->next) != QG_STORE_OK) {
        sender->next = now + LOOK_AGAIN_MS;
        free(due);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        if (free_flight(sender) && !is_under_way(sender, due[i].webhook))
            send_one(sender, &due[i], now);
        else
            qg_dispatch_finish(&due[i]);
    }
    free(due);
}

static void do_chores(struct qg_sender *sender, int64_t now) {
    while (sender->options.keep_log_days > 0 && !atomic_load(&sender->stopping) &&
           qg_store_drop_log(sender->store, now - sender->options.keep_log_days * DAY_MS) == QG_STORE_OK)
        ;
    sender->chore = now + CHORE_INTERVAL_MS;
}

/* Milliseconds until there may be something to do. */
static int nap(struct qg_sender *sender) {
    int64_t now = qg_wall_clock(), until = atomic_load(&sender->news) ? now : sender->next;
    if (until < sender->pause)
        until = sender->pause;
    int64_t length = until - now;
    return length < 0 ? 0 : length < NAP_MAX_MS ? (int)length : NAP_MAX_MS;
}

static void *run(void *self) {
    struct qg_sender *sender = self;
    while (!atomic_load(&sender->stopping)) {
        int running;
        int64_t now = qg_wall_clock();
        if (now >= sender->chore)
            do_chores(sender, now);
        if (now >= sender->pause && (atomic_exchange(&sender->news, false) || now >= sender->next))
            look(sender);
        curl_multi_perform(sender->multi, &running);
        if (collect(sender))
            atomic_store(&sender->news, true); /* there is a free flight */
        curl_multi_poll(sender->multi, NULL, 0, nap(sender), NULL);
    }
    return NULL;
}

/* --- the whole --- */

/* Called by the store. */
static void wake(void *self) {
    struct qg_sender *sender = self;
    atomic_store(&sender->news, true);
    curl_multi_wakeup(sender->multi);
}

struct qg_sender *qg_sender_start(struct qg_store *store, const struct qg_sender_options *options) {
    struct qg_sender *sender = calloc(1, sizeof *sender);
    if (!sender)
        return NULL;
    sender->store = store;
    sender->options = *options;
    for (int i = 0; i < FLIGHTS_MAX; i++)
        sender->flights[i].sender = sender;
    atomic_init(&sender->news, true);
    sender->multi = curl_multi_init();
    if (sender->multi && pthread_create(&sender->thread, NULL, run, sender) == 0) {
        qg_store_on_deliveries(store, wake, sender);
        return sender;
    }
    curl_multi_cleanup(sender->multi);
    free(sender);
    return NULL;
}

void qg_sender_stop(struct qg_sender *sender) {
    if (!sender)
        return;
    qg_store_on_deliveries(sender->store, NULL, NULL);
    atomic_store(&sender->stopping, true);
    curl_multi_wakeup(sender->multi);
    pthread_join(sender->thread, NULL);
    for (int i = 0; i < FLIGHTS_MAX; i++)
        land(&sender->flights[i]);
    curl_multi_cleanup(sender->multi);
    free(sender);
}
