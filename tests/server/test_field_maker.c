/* Fields to order: computed once, kept, refused when too many wait, dropped when the maker stops. */
#include "tests/server/support.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "schema/text.h"
#include "server/work/field_maker.h"

static const char document[] =
    "{\"kind\": \"evaluate\", \"gear_pair\": {\"module_mm\": 3, \"pressure_angle_deg\": 20, \"center_distance_mm\": "
    "111,"
    "\"pinion\": {\"teeth\": 28, \"profile_shift_mm\": 1.927, \"outside_radius_mm\": 46.55, \"root_radius_mm\": 39.55,"
    "\"hob_tip_radius_mm\": 0.9, \"bore_diameter_mm\": 40, \"face_width_mm\": 27},"
    "\"gear\": {\"teeth\": 43, \"profile_shift_mm\": 2.748, \"outside_radius_mm\": 69.55, \"root_radius_mm\": 63.1,"
    "\"hob_tip_radius_mm\": 0.9, \"bore_diameter_mm\": 40, \"face_width_mm\": 22.5},"
    "\"material\": {\"youngs_modulus_mpa\": 206000, \"poisson_ratio\": 0.3, \"density_kg_per_m3\": 7850},"
    "\"damping_ratio\": 0.01, \"nominal_torque_nm\": 470}}";

static struct qg_job job;

static struct qg_field_key key_of(const char *id, double position) {
    struct qg_field_key key = {.load_case = 0, .position = position};
    strcpy(key.id, id);
    return key;
}

static const struct timespec moment = {.tv_nsec = 20000000};

/* Asks until there is an answer, two minutes at most. */
static enum qg_field_answer await(struct qg_field_maker *maker, const struct qg_field_key *key, struct qg_text *text) {
    enum qg_field_answer answer = QG_FIELD_PENDING;
    for (int i = 0; i < 6000 && answer == QG_FIELD_PENDING; i++) {
        answer = qg_field_find(maker, key, text);
        if (answer == QG_FIELD_PENDING)
            nanosleep(&moment, NULL);
    }
    return answer;
}

static void a_field_is_made_once_and_kept(void **state) {
    (void)state;
    struct qg_field_maker *maker = qg_field_maker_start(&(struct qg_means){.executor = qg_serial_executor});
    assert_non_null(maker);
    const struct qg_field_key key = key_of("a", 0.5), other = key_of("a", 0.25), others = key_of("b", 0.5);
    struct qg_text first = {0}, again = {0};
    assert_int_equal(qg_field_find(maker, &key, &first), QG_FIELD_UNKNOWN);
    assert_int_equal(qg_field_order(maker, &key, &job), QG_FIELD_PENDING);
    assert_int_equal(qg_field_order(maker, &key, &job), QG_FIELD_PENDING); /* the same order: no second one */
    assert_int_equal(await(maker, &key, &first), QG_FIELD_DONE);
    assert_int_equal(qg_field_find(maker, &key, &again), QG_FIELD_DONE);
    assert_true(first.length > 10000 && strcmp(first.data, again.data) == 0);
    assert_non_null(strstr(first.data, "\"mesh_position\":0.5"));
    assert_int_equal(qg_field_find(maker, &other, &again), QG_FIELD_UNKNOWN);
    assert_int_equal(qg_field_find(maker, &others, &again), QG_FIELD_UNKNOWN);
    qg_text_finish(&first);
    qg_text_finish(&again);
    qg_field_maker_stop(maker);
}

/* An executor whose first call lasts until it is let go. */
struct gate {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int calls;
    bool open;
    pid_t stopper;        /* the thread that stops the maker */
    atomic_bool stopping; /* it is about to */
};

static void wait_at_gate(void *self, size_t n, qg_piece *piece, void *context) {
    struct gate *gate = self;
    pthread_mutex_lock(&gate->mutex);
    gate->calls++;
    pthread_cond_broadcast(&gate->changed);
    while (!gate->open)
        pthread_cond_wait(&gate->changed, &gate->mutex);
    pthread_mutex_unlock(&gate->mutex);
    qg_serial_executor.run(NULL, n, piece, context);
}

static bool is_asleep(pid_t thread) {
    char path[64], line[512] = "";
    snprintf(path, sizeof path, "/proc/self/task/%d/stat", (int)thread);
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    fclose(file);
    return strncmp(strrchr(line, ')'), ") S", 3) == 0;
}

/* Opens the gate when the maker has been told to stop: he who stops it waits for its thread, the only thing to sleep for. */
static void *open_later(void *self) {
    struct gate *gate = self;
    while (!atomic_load(&gate->stopping) || !is_asleep(gate->stopper))
        nanosleep(&moment, NULL);
    pthread_mutex_lock(&gate->mutex);
    gate->open = true;
    pthread_cond_broadcast(&gate->changed);
    pthread_mutex_unlock(&gate->mutex);
    return NULL;
}

/* A maker with one field at work, which is held at the gate. */
static struct qg_field_maker *start_at_gate(struct gate *gate) {
    *gate = (struct gate){.mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};
    const struct qg_means means = {.executor = {.self = gate, .workers = 1, .run = wait_at_gate}};
    struct qg_field_maker *maker = qg_field_maker_start(&means);
    assert_non_null(maker);
    const struct qg_field_key key = key_of("a", 0.5);
    assert_int_equal(qg_field_order(maker, &key, &job), QG_FIELD_PENDING);
    pthread_mutex_lock(&gate->mutex);
    while (gate->calls == 0)
        pthread_cond_wait(&gate->changed, &gate->mutex);
    pthread_mutex_unlock(&gate->mutex);
    return maker;
}

static void stop_at_gate(struct qg_field_maker *maker, struct gate *gate) {
    pthread_t opener;
    gate->stopper = gettid();
    assert_int_equal(pthread_create(&opener, NULL, open_later, gate), 0);
    atomic_store(&gate->stopping, true);
    qg_field_maker_stop(maker);
    pthread_join(opener, NULL);
}

/* One at work and four that wait, at most; stopping drops those that wait. */
static void too_many_orders_are_refused(void **state) {
    (void)state;
    struct gate gate;
    struct qg_field_maker *maker = start_at_gate(&gate);
    for (int i = 0; i < 8; i++) {
        const struct qg_field_key key = key_of("many", i / 8.0);
        assert_int_equal(qg_field_order(maker, &key, &job), i < 4 ? QG_FIELD_PENDING : QG_FIELD_BUSY);
    }
    stop_at_gate(maker, &gate);
    assert_int_equal(gate.calls, 1);
    qg_field_maker_stop(NULL);
}

/* A field that is at its gears' compliances when the maker stops does not come to the contact operators. */
static void stopping_gives_up_the_field_at_work(void **state) {
    (void)state;
    struct gate gate;
    stop_at_gate(start_at_gate(&gate), &gate);
    assert_int_equal(gate.calls, 1);
}

static int read_job(void **state) {
    (void)state;
    static struct qg_faults faults;
    return qg_document_read(document, sizeof document - 1, &job, &faults, NULL) == QG_DOCUMENT_OK ? 0 : -1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_field_is_made_once_and_kept),
        cmocka_unit_test(too_many_orders_are_refused),
        cmocka_unit_test(stopping_gives_up_the_field_at_work),
    };
    return cmocka_run_group_tests(tests, read_job, NULL);
}
