/* The open connections. See guests.h. */
#include "server/http/guests.h"

#include <assert.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/http/problem.h"

enum { LOOK_MS = 1000 };

struct qg_guest {
    int socket;
    bool put_out;
    enum qg_guest_state state;
    int64_t since;             /* of the state, monotonic ms */
    unsigned char address[16]; /* IPv6, or IPv4 mapped into it; zeros: of nobody in particular */
    struct qg_guest *next, *previous;
};

struct qg_guests {
    struct qg_guests_rules rules;
    pthread_mutex_t mutex; /* guards all that follows */
    pthread_cond_t end;
    bool ending;
    size_t count;           /* those not put out */
    struct qg_guest *first; /* in no order */
    pthread_t watch;
};

/* --- putting out --- */

static void tell_timeout(int socket) {
    struct qg_text body = {0}, answer = {0};
    qg_problem_write(&body, QG_PROBLEM_TIMEOUT, "the request was not complete in time", NULL);
    qg_text_format(&answer,
                   "HTTP/1.1 %d Request Timeout\r\nContent-Type: application/problem+json\r\nConnection: close\r\n"
                   "Content-Length: %zu\r\n\r\n%s",
                   qg_problem_status(QG_PROBLEM_TIMEOUT), body.length, body.data ? body.data : "");
    if (!answer.failed && !body.failed && send(socket, answer.data, answer.length, MSG_DONTWAIT | MSG_NOSIGNAL) < 0)
        answer.failed = true; /* then it goes without a word */
    qg_text_finish(&body);
    qg_text_finish(&answer);
}

/* The mutex is held. */
static void put_out(struct qg_guests *guests, struct qg_guest *guest) {
    if (guests->rules.plain && guest->state == QG_GUEST_ASKING)
        tell_timeout(guest->socket);
    shutdown(guest->socket, SHUT_RDWR);
    guest->put_out = true;
    guests->count--;
}

/* True when a is to go before b. */
static bool goes_before(const struct qg_guest *a, const struct qg_guest *b) {
    return !b || a->state < b->state || (a->state == b->state && a->since < b->since);
}

/* Who makes room for one from `address`; NULL when nobody can. The mutex is held. */
static struct qg_guest *find_leaver(struct qg_guests *guests, const unsigned char address[16]) {
    static const unsigned char nobody[16];
    const bool is_someone = memcmp(address, nobody, sizeof nobody) != 0;
    struct qg_guest *any = NULL, *own = NULL;
    size_t owned = 0;
    for (struct qg_guest *guest = guests->first; guest; guest = guest->next) {
        bool is_own = is_someone && memcmp(guest->address, address, sizeof guest->address) == 0;
        owned += is_own && !guest->put_out;
        if (guest->put_out || guest->state == QG_GUEST_ANSWERED)
            continue;
        if (goes_before(guest, any))
            any = guest;
        if (is_own && goes_before(guest, own))
            own = guest;
    }
    return owned >= guests->rules.places / 2 ? own : any;
}

/* --- who takes too long --- */

static void look_around(struct qg_guests *guests) {
    int64_t now = qg_monotonic_clock();
    for (struct qg_guest *guest = guests->first; guest; guest = guest->next)
        if (!guest->put_out && guest->state != QG_GUEST_ANSWERED && now - guest->since > guests->rules.patience)
            put_out(guests, guest);
}

static void *watch(void *self) {
    struct qg_guests *guests = self;
    pthread_mutex_lock(&guests->mutex);
    while (!guests->ending) {
        look_around(guests);
        qg_condition_wait(&guests->end, &guests->mutex, qg_monotonic_clock() + LOOK_MS);
    }
    pthread_mutex_unlock(&guests->mutex);
    return NULL;
}

/* --- coming and going --- */

struct qg_guests *qg_guests_create(const struct qg_guests_rules *rules) {
    struct qg_guests *guests = calloc(1, sizeof *guests);
    if (!guests)
        return NULL;
    guests->rules = *rules;
    qg_condition_init(&guests->end);
    pthread_mutex_init(&guests->mutex, NULL);
    if (pthread_create(&guests->watch, NULL, watch, guests) == 0)
        return guests;
    pthread_mutex_destroy(&guests->mutex);
    pthread_cond_destroy(&guests->end);
    free(guests);
    return NULL;
}

void qg_guests_destroy(struct qg_guests *guests) {
    if (!guests)
        return;
    pthread_mutex_lock(&guests->mutex);
    assert(!guests->first);
    guests->ending = true;
    pthread_cond_signal(&guests->end);
    pthread_mutex_unlock(&guests->mutex);
    pthread_join(guests->watch, NULL);
    pthread_mutex_destroy(&guests->mutex);
    pthread_cond_destroy(&guests->end);
    free(guests);
}

static void copy_address(unsigned char out[16], const struct sockaddr *address) {
    memset(out, 0, 16);
    if (address && address->sa_family == AF_INET6) {
        memcpy(out, &((const struct sockaddr_in6 *)(const void *)address)->sin6_addr, 16);
    } else if (address && address->sa_family == AF_INET) {
        memset(out + 10, 0xff, 2);
        memcpy(out + 12, &((const struct sockaddr_in *)(const void *)address)->sin_addr, 4);
    }
}

/* Makes a place when there is none. The mutex is held. */
static bool make_room(struct qg_guests *guests, const unsigned char address[16]) {
    if (guests->count < guests->rules.places)
        return true;
    struct qg_guest *leaver = find_leaver(guests, address);
    if (leaver)
        put_out(guests, leaver);
    return leaver;
}

struct qg_guest *qg_guests_enter(struct qg_guests *guests, int socket, const struct sockaddr *address) {
    struct qg_guest *guest = calloc(1, sizeof *guest);
    if (!guest)
        return NULL;
    guest->socket = socket;
    guest->since = qg_monotonic_clock();
    copy_address(guest->address, address);
    pthread_mutex_lock(&guests->mutex);
    bool enters = make_room(guests, guest->address);
    if (enters) {
        guest->next = guests->first;
        if (guest->next)
            guest->next->previous = guest;
        guests->first = guest;
        guests->count++;
    }
    pthread_mutex_unlock(&guests->mutex);
    if (enters)
        return guest;
    free(guest);
    return NULL;
}

void qg_guests_leave(struct qg_guests *guests, struct qg_guest *guest) {
    if (!guest)
        return;
    pthread_mutex_lock(&guests->mutex);
    if (guest->previous)
        guest->previous->next = guest->next;
    else
        guests->first = guest->next;
    if (guest->next)
        guest->next->previous = guest->previous;
    guests->count -= !guest->put_out;
    pthread_mutex_unlock(&guests->mutex);
    free(guest);
}

void qg_guests_mark(struct qg_guests *guests, struct qg_guest *guest, enum qg_guest_state state) {
    if (!guest)
        return;
    pthread_mutex_lock(&guests->mutex);
    guest->state = state;
    guest->since = qg_monotonic_clock();
    pthread_mutex_unlock(&guests->mutex);
}

size_t qg_guests_count(struct qg_guests *guests) {
    pthread_mutex_lock(&guests->mutex);
    size_t count = guests->count;
    pthread_mutex_unlock(&guests->mutex);
    return count;
}
