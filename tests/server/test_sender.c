/* Deliveries: written with the change of state and not otherwise, sent until they are taken, never where they must not go.
 *
 * The receiver is a thread of the test with a listening socket on loopback, which answers each request with the next status
 * of a list and keeps what it was sent.
 */
#include "tests/server/place.h"

#include <arpa/inet.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <time.h>

#include "server/base/clock.h"
#include "server/store/access.h"
#include "server/store/webhooks.h"
#include "server/work/sender.h"

enum { REQUESTS_MAX = 8, PATIENCE_MS = 120000 };

static const char secret[] = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";

/* --- the receiver --- */

struct receiver {
    int listener, port;
    const char *const *answers; /* status lines and header fields; the last one is repeated */
    pthread_t thread;
    atomic_int count;
    char request[REQUESTS_MAX][4096];
};

/* Reads one request with its body, which is announced by Content-Length. */
static void read_request(int connection, char request[4096]) {
    size_t length = 0;
    request[0] = '\0';
    for (ssize_t got; length < 4095 && (got = read(connection, request + length, 4095 - length)) > 0;) {
        length += (size_t)got;
        request[length] = '\0';
        const char *end = strstr(request, "\r\n\r\n"), *announced = strcasestr(request, "content-length:");
        if (end && announced && length >= (size_t)(end + 4 - request) + strtoul(announced + 15, NULL, 10))
            return;
    }
}

static void *receive(void *self) {
    struct receiver *receiver = self;
    const char *const *answer = receiver->answers;
    for (int connection; (connection = accept(receiver->listener, NULL, NULL)) >= 0; close(connection)) {
        int number = atomic_load(&receiver->count);
        char text[512];
        if (number == REQUESTS_MAX)
            continue;
        read_request(connection, receiver->request[number]);
        int length =
            snprintf(text, sizeof text, "HTTP/1.1 %s\r\nContent-Length: 0\r\nConnection: close\r\n\r\n", *answer);
        assert_int_equal(write(connection, text, (size_t)length), length);
        if (answer[1])
            answer++;
        atomic_fetch_add(&receiver->count, 1);
    }
    return NULL;
}

static void start_receiver(struct receiver *receiver, const char *const *answers) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t length = sizeof address;
    memset(receiver, 0, sizeof *receiver);
    receiver->answers = answers;
    receiver->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(receiver->listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(receiver->listener, 8), 0);
    assert_int_equal(getsockname(receiver->listener, (struct sockaddr *)&address, &length), 0);
    receiver->port = ntohs(address.sin_port);
    assert_int_equal(pthread_create(&receiver->thread, NULL, receive, receiver), 0);
}

static void stop_receiver(struct receiver *receiver) {
    shutdown(receiver->listener, SHUT_RDWR);
    pthread_join(receiver->thread, NULL);
    close(receiver->listener);
}

/* The value of a header field of a request. */
static void field(const char *request, const char *name, char out[200]) {
    const char *at = strcasestr(request, name);
    assert_non_null(at);
    at += strlen(name);
    at += strspn(at, ": ");
    snprintf(out, 200, "%.*s", (int)strcspn(at, "\r\n"), at);
}

/* --- store and sender --- */

static void subscribe(struct place *place, const char *url, unsigned events) {
    struct qg_webhook webhook = {.id = "wh_0123456789ab", .events = events, .created_at = 1};
    snprintf(webhook.url, sizeof webhook.url, "%s", url);
    strcpy(webhook.secret, secret);
    assert_int_equal(qg_store_webhook_add(place->store, &webhook, NULL), QG_STORE_OK);
}

static void submit(struct place *place, char id[QG_JOB_ID_ROOM]) {
    struct qg_job_row row;
    const struct qg_submission submission = {
        .name = "a \"name\"", .kind = "optimize", .labels = "[\"blue\"]", .document = "{}"};
    assert_int_equal(qg_store_submit(place->store, &submission, &row), QG_STORE_OK);
    memcpy(id, row.id, QG_JOB_ID_ROOM);
    qg_job_row_finish(&row);
}

/* Waits until the newest delivery is in a state. */
static struct qg_delivery wait_for(struct place *place, const char *state, int attempts) {
    struct qg_delivery delivery = {0};
    const struct timespec moment = {.tv_nsec = 10000000};
    size_t count;
    for (int waited = 0; waited < PATIENCE_MS; waited += 10) {
        assert_int_equal(qg_store_deliveries(place->store, "wh_0123456789ab", 0, 1, &delivery, &count), QG_STORE_OK);
        if (count == 1 && strcmp(delivery.state, state) == 0 && delivery.attempts >= attempts)
            return delivery;
        nanosleep(&moment, NULL);
    }
    fail_msg("waited in vain for %s: %s after %d attempts, %s", state, delivery.state, delivery.attempts,
             delivery.last_error);
    return delivery;
}

static int64_t pending(struct place *place) {
    return ask_sql(place, "SELECT count(*) FROM deliveries WHERE state = 'pending'");
}

/* --- what is written --- */

static void writes_a_delivery_with_each_change_that_is_wanted(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    struct qg_claim claim;
    struct qg_text document = {0};
    struct qg_delivery deliveries[8];
    size_t count;
    submit(place, id); /* nobody wants to know */
    assert_int_equal(qg_store_cancel(place->store, id, NULL), QG_STORE_OK);
    assert_int_equal(pending(place), 0);
    subscribe(place, "https://plm.example.com/", 1 | 2 | 4 | 16);
    submit(place, id);
    assert_int_equal(qg_store_claim(place->store, -1, &claim, &document), QG_STORE_OK);
    assert_int_equal(qg_store_claim(place->store, 60000, &claim, &document), QG_STORE_OK); /* running already */
    reopen_place(place);                                                                   /* back into the queue */
    assert_int_equal(qg_store_claim(place->store, 60000, &claim, &document), QG_STORE_OK);
    const struct qg_ending failed = {.state = QG_STATE_FAILED, .error = "no"}; /* not wanted */
    assert_int_equal(qg_store_finish(place->store, &claim, &failed), QG_STORE_OK);
    submit(place, id);
    assert_int_equal(qg_store_cancel(place->store, id, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_cancel(place->store, id, NULL), QG_STORE_OK); /* no change any more */
    assert_int_equal(qg_store_deliveries(place->store, "wh_0123456789ab", 0, 8, deliveries, &count), QG_STORE_OK);
    static const char *const events[] = {"job.cancelled", "job.queued",  "job.running",
                                         "job.queued",    "job.running", "job.queued"};
    assert_int_equal(count, 6);
    for (size_t i = 0; i < count; i++)
        assert_string_equal(deliveries[i].event, events[i]);
    qg_text_finish(&document);
}

static void writes_nothing_when_the_change_is_rolled_back(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    subscribe(place, "https://plm.example.com/", 31);
    submit(place, id);
    assert_int_equal(qg_store_begin(place->store), QG_STORE_OK);
    assert_int_equal(qg_sql_run(place->store->writer, "UPDATE jobs SET state = 'running'", ""), QG_STORE_OK);
    assert_int_equal(qg_store_end(place->store, QG_STORE_FAILED), QG_STORE_FAILED);
    assert_int_equal(pending(place), 1);
}

static void forgets_deliveries_with_their_webhook(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    subscribe(place, "https://plm.example.com/", 31);
    submit(place, id);
    assert_int_equal(qg_store_webhook_remove(place->store, "wh_0123456789ab", NULL), QG_STORE_OK);
    assert_int_equal(pending(place), 0);
    assert_int_equal(qg_store_webhook_remove(place->store, "wh_0123456789ab", NULL), QG_STORE_NOT_FOUND);
}

static void takes_so_many_webhooks(void **state) {
    struct place *place = *state;
    struct qg_webhook webhook = {.url = "https://a.example/", .events = 1, .created_at = 1};
    for (int i = 0; i <= QG_WEBHOOKS_MAX; i++) {
        snprintf(webhook.id, sizeof webhook.id, "wh_%012d", i);
        assert_int_equal(qg_store_webhook_add(place->store, &webhook, NULL),
                         i < QG_WEBHOOKS_MAX ? QG_STORE_OK : QG_STORE_QUEUE_FULL);
    }
}

/* --- what is sent --- */

/* A receiver, a webhook that goes to it as "http://HOST:PORT/hook", and a sender that may send there. */
struct route {
    struct receiver receiver;
    struct qg_sender *sender;
    char rule[64], url[80], resolve[64];
};

static void open_route(struct place *place, struct route *route, const char *host, const char *const *answers) {
    start_receiver(&route->receiver, answers);
    snprintf(route->rule, sizeof route->rule, "http://%s:%d", host, route->receiver.port);
    snprintf(route->url, sizeof route->url, "%s/hook", route->rule);
    snprintf(route->resolve, sizeof route->resolve, "%s:%d:127.0.0.1", host, route->receiver.port);
    subscribe(place, route->url, 1);
}

/* networks: what the sender may reach beyond public addresses. */
static void start(struct place *place, struct route *route, const char *networks) {
    const struct qg_sender_options options = {
        .rules = route->rule, .networks = networks, .first_wait = 1, .resolve = route->resolve};
    route->sender = qg_sender_start(place->store, &options);
    assert_non_null(route->sender);
}

static void close_route(struct route *route) {
    qg_sender_stop(route->sender);
    stop_receiver(&route->receiver);
}

/* Checks that a request is the delivery, and signed. */
static void assert_signed(const char *request, const struct qg_delivery *delivery) {
    char id[200], timestamp[200], given[200], expected[QG_SIGNATURE_ROOM];
    field(request, "webhook-id", id);
    field(request, "webhook-timestamp", timestamp);
    field(request, "webhook-signature", given);
    assert_string_equal(id, delivery->id);
    const struct qg_message message = {
        .id = id, .timestamp = strtoll(timestamp, NULL, 10), .body = strstr(request, "\r\n\r\n") + 4};
    assert_true(message.timestamp >= delivery->created_at / 1000 && message.timestamp <= qg_wall_clock() / 1000);
    assert_true(qg_webhook_sign(expected, secret, &message));
    assert_string_equal(given, expected);
}

static void delivers_what_happens_while_it_runs(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"204 No Content", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM], job[64];
    open_route(place, route, "127.0.0.1", answers);
    start(place, route, "127.0.0.0/8");
    submit(place, id);
    struct qg_delivery delivery = wait_for(place, "delivered", 1);
    assert_int_equal(delivery.last_status, 204);
    assert_string_equal(delivery.last_error, "");
    assert_string_equal(delivery.job, id);
    const char *request = route->receiver.request[0];
    assert_int_equal(strncmp(request, "POST /hook HTTP/1.1\r\n", 21), 0);
    assert_signed(request, &delivery);
    snprintf(job, sizeof job, "\"id\":\"%s\"", id);
    assert_non_null(strstr(request, job));
    assert_non_null(strstr(request, "\"type\":\"job.queued\""));
    assert_non_null(strstr(request, "\"name\":\"a \\\"name\\\"\""));
    close_route(route);
    free(route);
}

static void tries_again_with_the_same_id_and_a_fresh_time(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"500 No", "302 Elsewhere\r\nLocation: /other", "200 OK", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    submit(place, id);
    start(place, route, "127.0.0.0/8");
    struct qg_delivery delivery = wait_for(place, "pending", 1);
    assert_int_equal(delivery.last_status, 500);
    assert_int_equal(delivery.next_attempt_at - delivery.last_attempt_at, 1000);
    assert_string_equal(delivery.last_error, "answered with status 500");
    delivery = wait_for(place, "pending", 2);
    assert_int_equal(delivery.last_status, 302);
    assert_int_equal(delivery.next_attempt_at - delivery.last_attempt_at, 4000);
    delivery = wait_for(place, "delivered", 3);
    assert_int_equal(atomic_load(&route->receiver.count), 3); /* the redirect was not followed */
    for (int i = 0; i < 3; i++) {
        assert_int_equal(strncmp(route->receiver.request[i], "POST /hook ", 11), 0);
        assert_signed(route->receiver.request[i], &delivery);
    }
    close_route(route);
    free(route);
}

static void goes_on_after_a_restart(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"503 Later\r\nRetry-After: 2", "200 OK", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    submit(place, id);
    start(place, route, "127.0.0.0/8");
    struct qg_delivery delivery = wait_for(place, "pending", 1);
    assert_int_equal(delivery.next_attempt_at - delivery.last_attempt_at, 2000); /* as Retry-After wishes */
    qg_sender_stop(route->sender);
    reopen_place(place);
    start(place, route, "127.0.0.0/8");
    delivery = wait_for(place, "delivered", 2);
    assert_true(delivery.last_attempt_at - delivery.created_at >= 2000);
    assert_signed(route->receiver.request[1], &delivery);
    close_route(route);
    free(route);
}

static void stops_when_told_that_nobody_is_there(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"410 Gone", NULL};
    struct route *route = calloc(1, sizeof *route);
    struct qg_webhook webhook;
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    submit(place, id);
    submit(place, id);
    start(place, route, "127.0.0.0/8");
    wait_for(place, "failed", 0);
    assert_int_equal(pending(place), 0);
    assert_int_equal(qg_store_webhook(place->store, "wh_0123456789ab", &webhook), QG_STORE_OK);
    assert_true(webhook.disabled_at > 0);
    submit(place, id);
    assert_int_equal(pending(place), 0);
    assert_int_equal(atomic_load(&route->receiver.count), 1);
    close_route(route);
    free(route);
}

/* The name is allowed, and was harmless when the webhook was made; now a resolver says that it is this machine. */
static void is_not_led_home_by_a_name(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"200 OK", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "rebind.example", answers);
    submit(place, id);
    start(place, route, "");
    struct qg_delivery delivery = wait_for(place, "pending", 1);
    assert_non_null(strstr(delivery.last_error, "private or of this machine"));
    assert_int_equal(atomic_load(&route->receiver.count), 0);
    qg_sender_stop(route->sender);
    start(place, route, "10.0.0.0/8 127.0.0.1/32"); /* the same way, opened by a setting */
    wait_for(place, "delivered", 2);
    assert_int_equal(atomic_load(&route->receiver.count), 1);
    close_route(route);
    free(route);
}

/* An administrator may take a rule back after the webhook was made. */
static void judges_the_url_anew_for_each_attempt(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"200 OK", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    strcpy(route->rule, "https://elsewhere.example");
    submit(place, id);
    start(place, route, "127.0.0.0/8");
    struct qg_delivery delivery = wait_for(place, "pending", 1);
    assert_non_null(strstr(delivery.last_error, "webhook-allow"));
    assert_int_equal(atomic_load(&route->receiver.count), 0);
    close_route(route);
    free(route);
}

static void waits_longer_each_time_and_gives_up(void **state) {
    (void)state;
    static const int64_t seconds[] = {5, 20, 80, 320, 1280, 5120, 20480, 43200, 43200, 0, 0};
    for (int i = 0; i < 11; i++)
        assert_int_equal(qg_sender_wait(5, i + 1), 1000 * seconds[i]);
    assert_int_equal(qg_sender_wait(3600, 9), 43200000);
}

static void gives_up_for_good(void **state) {
    struct place *place = *state;
    static const char *const answers[] = {"500 No", NULL};
    struct route *route = calloc(1, sizeof *route);
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    submit(place, id);
    run_sql(place, "UPDATE deliveries SET attempts = 9");
    start(place, route, "127.0.0.0/8");
    struct qg_delivery delivery = wait_for(place, "failed", 10);
    assert_int_equal(delivery.next_attempt_at, 0);
    assert_int_equal(qg_store_drop_log(place->store, INT64_MAX), QG_STORE_OK);
    assert_int_equal(qg_store_drop_log(place->store, INT64_MAX), QG_STORE_NOT_FOUND);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM deliveries"), 0);
    close_route(route);
    free(route);
}

/* How many statements of the reader are still to fail. */
static atomic_int failures;

static int fail_some(void *nothing) {
    (void)nothing;
    return atomic_load(&failures) > 0 && atomic_fetch_sub(&failures, 1) > 0;
}

static void looks_again_when_it_could_not_read_what_is_due(void **state) {
    struct place *place = *state;
    struct route *route = malloc(sizeof *route);
    static const char *const answers[] = {"204 No Content", NULL};
    const struct timespec moment = {.tv_nsec = 10000000};
    char id[QG_JOB_ID_ROOM];
    open_route(place, route, "127.0.0.1", answers);
    submit(place, id);
    atomic_store(&failures, 2);
    sqlite3_progress_handler(place->store->reader, 1, fail_some, NULL);
    start(place, route, "127.0.0.0/8");
    for (int waited = 0; waited < PATIENCE_MS && atomic_load(&failures) > 0; waited += 10)
        nanosleep(&moment, NULL);
    wait_for(place, "delivered", 1);
    close_route(route);
    free(route);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        PLACE_TEST(writes_a_delivery_with_each_change_that_is_wanted),
        PLACE_TEST(writes_nothing_when_the_change_is_rolled_back),
        PLACE_TEST(forgets_deliveries_with_their_webhook),
        PLACE_TEST(takes_so_many_webhooks),
        PLACE_TEST(delivers_what_happens_while_it_runs),
        PLACE_TEST(tries_again_with_the_same_id_and_a_fresh_time),
        PLACE_TEST(goes_on_after_a_restart),
        PLACE_TEST(stops_when_told_that_nobody_is_there),
        PLACE_TEST(is_not_led_home_by_a_name),
        PLACE_TEST(judges_the_url_anew_for_each_attempt),
        cmocka_unit_test(waits_longer_each_time_and_gives_up),
        PLACE_TEST(gives_up_for_good),
        PLACE_TEST(looks_again_when_it_could_not_read_what_is_due),
    };
    return cmocka_run_group_tests_name("sender", tests, NULL, NULL);
}
