/* Who is put out when all places are taken or somebody takes too long; on real sockets. */
#include "tests/server/support.h"

#include <netinet/in.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/http/guests.h"

/* A connection: our end, and the client's. */
struct connection {
    int server, client;
    struct qg_guest *guest;
};

static void connect_pair(struct connection *connection) {
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
    *connection = (struct connection){.server = ends[0], .client = ends[1]};
}

/* Comes from 10.0.0.`from`. */
static bool enter(struct qg_guests *guests, struct connection *connection, int from) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(0x0a000000u + (unsigned)from)};
    connect_pair(connection);
    connection->guest = qg_guests_enter(guests, connection->server, (const struct sockaddr *)&address);
    return connection->guest;
}

static void leave(struct qg_guests *guests, struct connection *connection) {
    qg_guests_leave(guests, connection->guest);
    close(connection->server);
    close(connection->client);
}

/* What the client can read; -1 while the connection is open and silent. */
static ssize_t heard(const struct connection *connection, char *out, size_t room) {
    return recv(connection->client, out, room, MSG_DONTWAIT);
}

static bool is_open(const struct connection *connection) {
    char byte;
    return heard(connection, &byte, 1) < 0;
}

static void the_longest_silent_makes_room(void **state) {
    (void)state;
    const struct qg_guests_rules rules = {.places = 3, .patience = 60000, .plain = true};
    struct qg_guests *guests = qg_guests_create(&rules);
    const struct timespec moment = {.tv_nsec = 3000000};
    struct connection c[5];
    for (int i = 0; i < 3; i++) {
        assert_true(enter(guests, &c[i], i));
        nanosleep(&moment, NULL);
    }
    qg_guests_mark(guests, c[0].guest, QG_GUEST_ANSWERED);
    qg_guests_mark(guests, c[1].guest, QG_GUEST_ASKING);
    assert_true(enter(guests, &c[3], 3));
    assert_true(is_open(&c[0]) && is_open(&c[1]) && !is_open(&c[2]) && is_open(&c[3]));
    assert_int_equal(qg_guests_count(guests), 3);
    qg_guests_mark(guests, c[3].guest, QG_GUEST_ANSWERED);
    assert_true(enter(guests, &c[4], 4)); /* only the asking one is left to go, and is told */
    char words[512] = "";
    assert_true(heard(&c[1], words, sizeof words - 1) > 0);
    assert_non_null(strstr(words, "HTTP/1.1 408 "));
    assert_non_null(strstr(words, "application/problem+json"));
    for (int i = 0; i < 5; i++)
        leave(guests, &c[i]);
    assert_int_equal(qg_guests_count(guests), 0);
    qg_guests_destroy(guests);
}

static void those_who_are_answered_stay(void **state) {
    (void)state;
    const struct qg_guests_rules rules = {.places = 2, .patience = 60000};
    struct qg_guests *guests = qg_guests_create(&rules);
    struct connection c[3];
    for (int i = 0; i < 2; i++) {
        assert_true(enter(guests, &c[i], i));
        qg_guests_mark(guests, c[i].guest, QG_GUEST_ANSWERED);
    }
    assert_false(enter(guests, &c[2], 2));
    assert_true(is_open(&c[0]) && is_open(&c[1]));
    for (int i = 0; i < 3; i++)
        leave(guests, &c[i]);
    qg_guests_destroy(guests);
}

static void a_greedy_address_makes_room_among_its_own(void **state) {
    (void)state;
    const struct qg_guests_rules rules = {.places = 4, .patience = 60000};
    struct qg_guests *guests = qg_guests_create(&rules);
    const struct timespec moment = {.tv_nsec = 3000000};
    struct connection c[6];
    for (int i = 0; i < 5; i++) {
        assert_true(enter(guests, &c[i], i < 2 ? 1 : 2)); /* the fifth is the third of address 2 */
        nanosleep(&moment, NULL);
    }
    assert_true(is_open(&c[0]) && is_open(&c[1]) && !is_open(&c[2]) && is_open(&c[3]) && is_open(&c[4]));
    assert_true(enter(guests, &c[5], 3)); /* another address takes the place of the longest silent of all */
    assert_false(is_open(&c[0]));
    for (int i = 0; i < 6; i++)
        leave(guests, &c[i]);
    qg_guests_destroy(guests);
}

/* Those of a trusted proxy, or of a socket of the file system, stand for many: they are no greedy address. */
static void nobody_in_particular_is_not_greedy(void **state) {
    (void)state;
    const struct qg_guests_rules rules = {.places = 4, .patience = 60000};
    struct qg_guests *guests = qg_guests_create(&rules);
    const struct timespec moment = {.tv_nsec = 3000000};
    struct connection c[5];
    for (int i = 0; i < 5; i++) {
        if (i == 0) {
            assert_true(enter(guests, &c[i], 1));
        } else {
            connect_pair(&c[i]);
            c[i].guest = qg_guests_enter(guests, c[i].server, NULL);
            assert_non_null(c[i].guest);
        }
        nanosleep(&moment, NULL);
    }
    assert_true(!is_open(&c[0]) && is_open(&c[1]) && is_open(&c[4])); /* the longest silent of all went */
    for (int i = 0; i < 5; i++)
        leave(guests, &c[i]);
    qg_guests_destroy(guests);
}

/* Three guests: a silent one, one that asks, one that is answered; of a host whose patience is as short as it can be for the
 * machine to get so far within it. */
static struct qg_guests *receive_three(struct connection three[3]) {
    for (int patience = 200;; patience *= 4) {
        const struct qg_guests_rules rules = {.places = 9, .patience = patience, .plain = true};
        struct qg_guests *guests = qg_guests_create(&rules);
        const int64_t begin = qg_monotonic_clock();
        for (int i = 0; i < 3; i++)
            assert_true(enter(guests, &three[i], 1));
        qg_guests_mark(guests, three[1].guest, QG_GUEST_ASKING);
        qg_guests_mark(guests, three[2].guest, QG_GUEST_ANSWERED);
        if (qg_monotonic_clock() - begin < patience)
            return guests;
        for (int i = 0; i < 3; i++)
            leave(guests, &three[i]);
        qg_guests_destroy(guests);
    }
}

static void who_takes_too_long_goes(void **state) {
    (void)state;
    struct connection three[3];
    struct qg_guests *guests = receive_three(three);
    struct connection silent = three[0], asking = three[1], answered = three[2];
    char words[512];
    const struct timespec moment = {.tv_nsec = 20000000};
    for (int i = 0; i < 6000 && qg_guests_count(guests) > 1; i++) /* two minutes: against hanging */
        nanosleep(&moment, NULL);
    assert_int_equal(heard(&silent, words, sizeof words), 0); /* closed without a word */
    assert_true(heard(&asking, words, sizeof words) > 0);
    assert_true(is_open(&answered));
    leave(guests, &silent);
    leave(guests, &asking);
    leave(guests, &answered);
    qg_guests_destroy(guests);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_longest_silent_makes_room),
        cmocka_unit_test(those_who_are_answered_stay),
        cmocka_unit_test(a_greedy_address_makes_room_among_its_own),
        cmocka_unit_test(nobody_in_particular_is_not_greedy),
        cmocka_unit_test(who_takes_too_long_goes),
    };
    return cmocka_run_group_tests_name("guests", tests, NULL, NULL);
}
