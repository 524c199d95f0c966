/* Fuzzer of the HTTP service: raw bytes over a socket, to a whole daemon but for its signals, in this process.
 *
 * The bytes of an input are sent as they are, except that
 *     \1 and a letter   stands for the id of a job: s succeeded, f failed, c cancelled, r running, q queued; or a: the text of
 *                       an admin token
 *     \2                sends what there is, and goes on a little later: another packet
 * After each input an honest request on another connection has to be answered, so that a daemon that hangs or spins is found
 * at once; a slow machine is no such thing, see patience.h. Of an answer is asked: that it is one of HTTP, no server's fault (5xx other than 503 and 505), and that JSON which
 * calls itself so is.
 *
 * Nothing is computed: the executor keeps its caller asleep until the service ends, so that a job runs for as long as it
 * lives; what it then does until it is told to break off is cheap, because the finite elements are in a cache that outlives
 * the service. Every LIFETIME inputs the service is stopped with whatever is going on, and begun anew on an empty directory.
 */
#include <arpa/inet.h>
#include <cjson/cJSON.h>
#include <errno.h>
#include <ftw.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "server/calls/table.h"
#include "server/http/access.h"
#include "server/http/exchange.h"
#include "server/http/http.h"
#include "server/listener.h"
#include "server/store/backup.h"
#include "server/store/store.h"
#include "server/work/board.h"
#include "server/work/field_maker.h"
#include "server/work/job_copies.h"
#include "server/work/metrics.h"
#include "server/work/runner.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/patience.h"

enum {
    LIFETIME = 300,
    SILENCE_MS = 25,
    PATIENCE_MS = 5000 /* see patience.h */,
    ANSWER_ROOM = 1 << 18,
    CACHE_BYTES = 128 << 20
};

#define OWN "Host: localhost\r\n"
#define JSON "Content-Type: application/json\r\n"
#define ADMIN OWN "Authorization: Bearer \1a\r\n"
#define SMALL "{\"kind\":\"evaluate\"}"
/* Requests; {DOCUMENT} is the example below with its length in front. */
static const char *const requests[] = {
    "GET / HTTP/1.1\r\n" OWN "Accept-Encoding: gzip\r\n\r\n",
    "HEAD /healthz HTTP/1.0\r\n\r\n",
    "GET /readyz HTTP/1.1\r\n" OWN "\r\nGET /metrics HTTP/1.1\r\n" OWN "Connection: close\r\n\r\n",
    "GET /v1/jobs?limit=2&state=queued&label=a%20b&external_id=x HTTP/1.1\r\n" OWN "\r\n",
    "GET /v1/jobs?limit=1&cursor=3 HTTP/1.1\r\n" OWN "Accept: application/json;q=0.5, */*;q=0.1\r\n\r\n",
    "POST /v1/jobs HTTP/1.1\r\n" OWN JSON "Idempotency-Key: \"k-1\"\r\nContent-Length: {DOCUMENT}",
    "POST /v1/check HTTP/1.1\r\n" OWN JSON "Content-Length: {DOCUMENT}",
    "POST /v1/profile HTTP/1.1\r\n" OWN JSON "Accept: image/vnd.dxf, application/json\r\nContent-Length: {DOCUMENT}",
    "POST /v1/jobs HTTP/1.1\r\n" OWN JSON "Content-Length: 19\r\n\r\n" SMALL,
    "POST /v1/jobs HTTP/1.1\r\n" OWN JSON "Transfer-Encoding: chunked\r\n\r\n13\r\n" SMALL "\r\n0\r\n\r\n",
    "POST /v1/jobs HTTP/1.1\r\n" OWN JSON "Expect: 100-continue\r\nContent-Length: 19\r\n\r\n\2" SMALL,
    "POST /v1/jobs HTTP/1.1\r\n" OWN JSON "Origin: http://evil.example\r\nContent-Length: 2\r\n\r\n{}",
    "GET /v1/jobs/\1s HTTP/1.1\r\n" OWN "If-None-Match: \"1\", W/\"2\", *\r\n\r\n",
    "GET /v1/jobs/\1s/result HTTP/1.1\r\n" OWN "Accept-Encoding: gzip;q=1, identity;q=0\r\n\r\n",
    "GET /v1/jobs/\1s/frequency-response HTTP/1.1\r\n" OWN "Accept: text/csv\r\n\r\n",
    "GET /v1/jobs/\1s/evaluations HTTP/1.1\r\n" OWN "Accept: application/x-ndjson\r\n\r\n",
    "GET /v1/jobs/\1s/field?position=0.5&load_case=zero HTTP/1.1\r\n" OWN "\r\n",
    "GET /v1/jobs/\1s/profile HTTP/1.1\r\n" OWN "Accept: application/json\r\n\r\n",
    "GET /v1/jobs/\1s/document HTTP/1.1\r\n" OWN "\r\nDELETE /v1/jobs/\1c HTTP/1.1\r\n" OWN "\r\n",
    "GET /v1/jobs/\1r HTTP/1.1\r\n" OWN "Prefer: wait=1\r\n\r\n",
    "GET /v1/jobs/\1f/events HTTP/1.1\r\n" OWN "Accept: text/event-stream\r\nLast-Event-ID: 1\r\n\r\n",
    "GET /v1/events HTTP/1.1\r\n" OWN "Last-Event-ID: 0\r\n\r\n\2GET /healthz HTTP/1.1\r\n" OWN "\r\n",
    "POST /v1/jobs/\1q/cancel HTTP/1.1\r\n" OWN "Content-Length: 0\r\n\r\n",
    "POST /v1/jobs/\1r/cancel HTTP/1.1\r\n" OWN "Sec-Fetch-Site: same-origin\r\nContent-Length: 0\r\n\r\n",
    "DELETE /v1/jobs/\1f HTTP/1.1\r\n" OWN "Origin: http://localhost\r\n\r\n",
    "GET /v1/schemas/job.schema.json HTTP/1.1\r\n" OWN "\r\n",
    "GET /v1/schemas/%2e%2e%2fjob HTTP/1.1\r\n" OWN "\r\n",
    "GET /assets/page.js HTTP/1.1\r\n" OWN "Range: bytes=0-9\r\n\r\n",
    "GET /openapi.json HTTP/1.1\r\n" OWN "Authorization: Bearer qg_abc_def\r\n\r\n",
    "GET /v1/tokens HTTP/1.1\r\n" OWN "Authorization: Bearer x\r\n\r\n",
    "GET /v1/tokens HTTP/1.1\r\n" ADMIN "\r\nGET /v1/webhooks HTTP/1.1\r\n" ADMIN "\r\n",
    "POST /v1/tokens HTTP/1.1\r\n" ADMIN JSON
    "Content-Length: 44\r\n\r\n{\"name\":\"fuzzed\",\"scopes\":[\"read\",\"submit\"]}",
    "POST /v1/webhooks HTTP/1.1\r\n" ADMIN JSON
    "Content-Length: 68\r\n\r\n{\"url\":\"http://hook.example/x\",\"events\":[\"job.queued\",\"job.failed\"]}",
    "GET /v1/audit?limit=3 HTTP/1.1\r\n" ADMIN "\r\nGET /v1/backup HTTP/1.1\r\n" ADMIN "\r\n",
    "DELETE /v1/tokens/x HTTP/1.1\r\n" ADMIN "\r\nGET /v1/webhooks/x/deliveries?limit=1 HTTP/1.1\r\n" ADMIN "\r\n",
    "OPTIONS /v1/jobs HTTP/1.1\r\n" OWN "Origin: http://page.example\r\nAccess-Control-Request-Method: POST\r\n\r\n",
    "GET /v1/examples HTTP/1.1\r\n" OWN "\r\nGET /v1/examples/case_S_none HTTP/1.1\r\n" OWN "\r\n",
    "GET /v1/audit HTTP/1.1\r\nHost: [::1]:80\r\nX-Folded: a\r\n b\r\n\r\n",
};

static size_t seed(size_t index, uint8_t *out) {
    static uint8_t document[FUZZ_BYTES_MAX];
    if (index >= sizeof requests / sizeof *requests)
        return 0;
    const char *request = requests[index], *place = strstr(request, "{DOCUMENT}");
    size_t head = place ? (size_t)(place - request) : strlen(request);
    memcpy(out, request, head);
    if (!place)
        return head;
    size_t length = fuzz_read_source("schema/examples/case_S_none.json", document);
    if (length == 0)
        fuzz_fail("the example cannot be read: set QG_SOURCE to the sources");
    head += (size_t)sprintf((char *)out + head, "%zu\r\n\r\n", length);
    memcpy(out + head, document, length);
    return head + length;
}

static const char *const words[] = {"\r\n",
                                    "\r\n\r\n",
                                    "\2",
                                    "\1s",
                                    "\1q",
                                    "\1r",
                                    "\1a",
                                    "Authorization: Bearer \1a\r\n",
                                    "%00",
                                    "%2e%2e",
                                    "//",
                                    "/../",
                                    "?",
                                    "&limit=",
                                    "&cursor=",
                                    "HTTP/1.0",
                                    "HTTP/1.1",
                                    "GET ",
                                    "HEAD ",
                                    "POST ",
                                    "DELETE ",
                                    "OPTIONS ",
                                    "PUT ",
                                    "Content-Length: 0\r\n",
                                    "Content-Length: 5\r\n",
                                    "Transfer-Encoding: chunked\r\n",
                                    "Host: localhost\r\n",
                                    "Connection: close\r\n",
                                    "Connection: keep-alive\r\n",
                                    "Expect: 100-continue\r\n",
                                    "Prefer: wait=1\r\n",
                                    "Last-Event-ID: 1\r\n",
                                    "If-None-Match: *\r\n",
                                    "Accept: text/event-stream\r\n",
                                    "Accept-Encoding: gzip\r\n",
                                    "Idempotency-Key: \"k-1\"\r\n",
                                    "Content-Encoding: gzip\r\n",
                                    "0\r\n\r\n",
                                    "ffffffffffffffff\r\n",
                                    "Range: bytes=0-\r\n",
                                    NULL};

struct fuzz_harness fuzz_harness = {"http", seed, words, 600, "answered with 2xx", 0};

/* ---- the service ------------------------------------------------------------------------------------------------ */

struct place {
    char directory[64];
    struct qg_service service;
    struct qg_http *http;
    int port;
    struct qg_cache *cache;
    atomic_bool ending;
    char word[256][QG_TOKEN_ROOM]; /* by letter: ids of jobs, and the admin token */
    size_t inputs;
};

/* Keeps its caller asleep until the end, then works on its thread. */
static void run_at_the_end(void *self, size_t n, qg_piece *piece, void *context) {
    struct place *place = self;
    const struct timespec moment = {.tv_nsec = 2000000};
    while (!atomic_load(&place->ending))
        nanosleep(&moment, NULL);
    for (size_t i = 0; i < n; i++)
        piece(context, i, 0);
}

static void submit(struct place *place, char letter) {
    static uint8_t document[FUZZ_BYTES_MAX + 1];
    struct qg_job_row row = {0};
    document[fuzz_read_source("schema/examples/case_S_none.json", document)] = '\0';
    const struct qg_submission submission = {.name = "fuzzed",
                                             .kind = "evaluate",
                                             .labels = "[\"a b\"]",
                                             .document = (const char *)document,
                                             .external_id = "x"};
    fuzz_require(qg_store_submit(place->service.store, &submission, &row) == QG_STORE_OK);
    strcpy(place->word[(unsigned char)letter], row.id);
    qg_job_row_finish(&row);
}

/* Claims the oldest job and ends it in a state. */
static void end_job(struct place *place, enum qg_state state) {
    struct qg_claim claim;
    struct qg_text document = {0};
    const struct qg_output outputs[] = {{QG_OUTPUT_RESULT, "{\"design\":{}}"},
                                        {QG_OUTPUT_RESPONSE, "{}"},
                                        {QG_OUTPUT_RESPONSE_CSV, "frequency_ratio\r\n1\r\n"}};
    const struct qg_evaluation evaluations[] = {{.number = 0, .f_pps = 0.001}, {.number = 1, .f_pps = 0.002}};
    const struct qg_ending ending = {state, state == QG_STATE_FAILED ? "out of memory" : NULL, NULL, outputs, 3};
    fuzz_require(qg_store_claim(place->service.store, 60000, &claim, &document) == QG_STORE_OK);
    fuzz_require(qg_store_record(place->service.store, &claim, evaluations, 2) == QG_STORE_OK);
    fuzz_require(qg_store_finish(place->service.store, &claim, &ending) == QG_STORE_OK);
    qg_text_finish(&document);
}

/* One job in each state; the runner takes the fourth. */
static void fill_store(struct place *place) {
    submit(place, 's');
    end_job(place, QG_STATE_SUCCEEDED);
    submit(place, 'f');
    end_job(place, QG_STATE_FAILED);
    submit(place, 'c');
    fuzz_require(qg_store_cancel(place->service.store, place->word['c'], NULL) == QG_STORE_OK);
    submit(place, 'r');
    submit(place, 'q');
}

static void start_workers(struct place *place) {
    struct qg_service *service = &place->service;
    const struct qg_workplace workplace = {service->store,
                                           service->board,
                                           {.executor = {place, 1, run_at_the_end}, .cache = place->cache},
                                           service->metrics};
    const struct qg_access_options access = {0};
    service->runner = qg_runner_start(&workplace, 1);
    service->field_maker = qg_field_maker_start(&workplace.means);
    service->access = qg_access_open(service->store, &access);
    fuzz_require(service->runner && service->field_maker && service->access);
    struct qg_token token = {.name = "fuzzer", .scopes = QG_SCOPE_READ | QG_SCOPE_SUBMIT | QG_SCOPE_ADMIN};
    fuzz_require(qg_access_create(service->access, NULL, &token, place->word['a']) == QG_STORE_OK);
}

static void start(struct place *place) {
    char message[QG_STORE_MESSAGE_ROOM];
    static char schemas[4096];
    const char *source = getenv("QG_SOURCE");
    snprintf(schemas, sizeof schemas, "%s/schema", source ? source : ".");
    strcpy(place->directory, "/tmp/fuzz_http-XXXXXX");
    fuzz_require(mkdtemp(place->directory));
    place->service = (struct qg_service){.web_dir = schemas,
                                         .schema_dir = schemas,
                                         .allowed_hosts = "",
                                         .cors_origins = "http://page.example",
                                         .trusted_proxies = "127.0.0.0/8 10.0.0.0/8",
                                         .webhook_rules = "http://hook.example",
                                         .webhook_networks = "",
                                         .store = qg_store_open(place->directory, message),
                                         .board = qg_board_create(),
                                         .routes = &qg_calls,
                                         .metrics = qg_metrics_create(qg_calls.count),
                                         .thread_count = 1};
    place->service.job_copies = qg_job_copies_create(place->service.store, place->service.board);
    place->service.backups = qg_backups_create(place->directory);
    fuzz_require(place->service.job_copies && place->service.metrics && place->service.backups);
    atomic_store(&place->ending, false);
    fill_store(place);
    start_workers(place);
    int listener = qg_listener_open("127.0.0.1:0", message, sizeof message);
    fuzz_require(listener >= 0);
    place->port = qg_listener_describe(listener, "http", message, sizeof message);
    place->http = qg_http_start(&place->service, listener);
    fuzz_require(place->http);
}

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *ftw) {
    (void)status;
    (void)type;
    (void)ftw;
    return remove(path);
}

/* As main.c does it. */
static void stop(struct place *place) {
    struct qg_service *service = &place->service;
    qg_http_quiesce(place->http);
    qg_runner_interrupt(service->runner);
    qg_board_shut(service->board);
    atomic_store(&place->ending, true);
    qg_http_stop(place->http);
    qg_runner_stop(service->runner);
    qg_field_maker_stop(service->field_maker);
    qg_backups_destroy(service->backups);
    qg_job_copies_destroy(service->job_copies);
    qg_board_destroy(service->board);
    qg_metrics_destroy(service->metrics);
    qg_access_close(service->access);
    qg_store_close(service->store);
    nftw(place->directory, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    place->http = NULL;
}

/* ---- the client ------------------------------------------------------------------------------------------------- */

/* libFuzzer's alarm may come while a connection is being made; that goes on in the background then. */
static void finish_dialing(int connection) {
    struct pollfd ready = {.fd = connection, .events = POLLOUT};
    int fault = EINTR;
    socklen_t size = sizeof fault;
    while (poll(&ready, 1, -1) < 0)
        fuzz_require(errno == EINTR);
    getsockopt(connection, SOL_SOCKET, SO_ERROR, &fault, &size);
    if (fault != 0)
        fuzz_fail("no connection: %s", strerror(fault));
}

static int dial(const struct place *place) {
    const struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)place->port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    fuzz_require(connection >= 0);
    if (connect(connection, (const struct sockaddr *)&address, sizeof address) == 0)
        return connection;
    if (errno != EINTR)
        fuzz_fail("no connection: %s", strerror(errno));
    finish_dialing(connection);
    return connection;
}

/* Sends what the daemon takes. */
static void send_bytes(int connection, const void *bytes, size_t size) {
    const char *at = bytes;
    while (size > 0) {
        ssize_t sent = send(connection, at, size, MSG_NOSIGNAL);
        if (sent <= 0)
            return;
        at += sent;
        size -= (size_t)sent;
    }
}

/* Sends an input, with ids and pauses put in. */
static void send_input(const struct place *place, int connection, const uint8_t *data, size_t size) {
    const struct timespec moment = {.tv_nsec = 300000};
    size_t begin = 0;
    for (size_t i = 0; i < size; i++) {
        if (data[i] > 2 || data[i] < 1)
            continue;
        send_bytes(connection, data + begin, i - begin);
        if (data[i] == 2)
            nanosleep(&moment, NULL);
        else if (++i < size)
            send_bytes(connection, place->word[data[i]], strlen(place->word[data[i]]));
        begin = i + 1;
    }
    if (begin < size)
        send_bytes(connection, data + begin, size - begin);
    shutdown(connection, SHUT_WR);
}

/* Reads what has come to out, behind the `length` bytes that are there, and returns the new length. *closed: the daemon has
 * closed. */
static size_t receive_more(int connection, char *out, size_t length, bool *closed) {
    ssize_t got = recv(connection, out + length, ANSWER_ROOM - 1 - length, 0);
    *closed = got <= 0;
    length += got > 0 ? (size_t)got : 0;
    out[length] = '\0';
    return length;
}

/* Reads until the daemon closes, or says nothing for a while. */
static size_t receive(int connection, char *out) {
    size_t length = 0;
    struct pollfd ready = {.fd = connection, .events = POLLIN};
    bool closed = false;
    out[0] = '\0';
    while (!closed && length < ANSWER_ROOM - 1 && poll(&ready, 1, SILENCE_MS) == 1)
        length = receive_more(connection, out, length, &closed);
    return length;
}

/* Reads until the daemon closes, which it has to. */
static size_t receive_whole(int connection, char *out) {
    static const struct patience patience = {PATIENCE_MS, PATIENCE_MS};
    size_t length = 0;
    for (bool closed = false; !closed;) {
        enum verdict verdict = patience_wait(connection, &patience);
        if (verdict != PATIENCE_READY) {
            patience_print_threads();
            fuzz_fail("an honest request got %zu bytes and no end: the daemon %s", length,
                      verdict == PATIENCE_HANGS ? "hangs" : "spins");
        }
        length = receive_more(connection, out, length, &closed);
    }
    return length;
}

/* The first answer, apart: status, whether it calls itself JSON, and its body where that came whole. */
struct answer {
    int status;
    bool is_json;
    const char *body; /* NULL unless it has a length and came whole */
    size_t length;
};

static struct answer read_answer(const char *text, size_t size) {
    struct answer answer = {0};
    const char *body = strstr(text, "\r\n\r\n"), *length;
    fuzz_require(strncmp(text, "HTTP/1.", 7) == 0 && (text[7] == '0' || text[7] == '1') && text[8] == ' ');
    answer.status = atoi(text + 9);
    fuzz_require(answer.status >= 100 && answer.status < 600);
    if (!body)
        return answer;
    length = strstr(text, "\r\nContent-Length: ");
    const char *type = strstr(text, "\r\nContent-Type: application/");
    answer.is_json = type && type < body &&
                     (strncmp(type + 28, "json\r\n", 6) == 0 || strncmp(type + 28, "problem+json\r\n", 14) == 0) &&
                     !strstr(text, "\r\nContent-Encoding: gzip");
    answer.length = length && length < body ? strtoul(length + 18, NULL, 10) : 0;
    if (answer.length && (size_t)(body + 4 - text) + answer.length <= size)
        answer.body = body + 4;
    return answer;
}

static bool is_json(const char *text, size_t length) {
    cJSON *json = cJSON_ParseWithLength(text, length);
    bool is = json != NULL;
    cJSON_Delete(json);
    return is;
}

/* What has to be true of whatever came back to an input. */
static void require_answer(const char *text, size_t size, bool is_head) {
    if (size == 0)
        return;
    struct answer answer = read_answer(text, size);
    fuzz_harness.accepted += answer.status >= 200 && answer.status < 300;
    if (answer.status >= 500 && answer.status != 503 && answer.status != 505)
        fuzz_fail("answered %.*s", 600, text);
    if (!is_head && answer.is_json && answer.body && answer.status != 304 && !is_json(answer.body, answer.length))
        fuzz_fail("no JSON: %.*s", 2000, text);
}

static void require_health(const struct place *place, char *room) {
    static const char honest[] = "GET /healthz HTTP/1.1\r\n" OWN "Connection: close\r\n\r\n";
    int connection = dial(place);
    send_bytes(connection, honest, sizeof honest - 1);
    size_t size = receive_whole(connection, room);
    close(connection);
    if (size == 0)
        fuzz_fail("an honest request got nothing but an end");
    struct answer answer = read_answer(room, size);
    fuzz_require(answer.status == 200 && answer.body && is_json(answer.body, answer.length));
}

static struct place place;

static void stop_at_exit(void) {
    if (place.http)
        stop(&place);
}

static void finish_at_exit(void) {
    stop_at_exit();
    qg_cache_destroy(place.cache);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static char room[ANSWER_ROOM];
    if (place.inputs == 0) {
        qg_numerics_init(1);
        place.cache = qg_cache_create(CACHE_BYTES);
        fuzz_require(place.cache);
        signal(SIGPIPE, SIG_IGN);
        atexit(finish_at_exit);
    }
    if (place.inputs++ % LIFETIME == 0) {
        stop_at_exit();
        start(&place);
    }
    int connection = dial(&place);
    send_input(&place, connection, data, size);
    size_t length = receive(connection, room);
    close(connection);
    require_answer(room, length, size >= 4 && memcmp(data, "HEAD", 4) == 0);
    require_health(&place, room);
    return 0;
}
