/* The thread that computes fields, and the few it keeps. See field_maker.h.
 *
 * All entries are guarded by one mutex, which is never held while something is computed. An entry that is being computed is
 * not given to anybody else. When an order needs room, the entry that was asked for longest ago goes, never one that waits
 * or is at work.
 */
#include "server/work/field_maker.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "core/field.h"
#include "schema/field.h"

enum { ENTRIES = 12, WAITING_MOST = 4 };

enum state { EMPTY, WAITING, AT_WORK, DONE, FAILED };

struct entry {
    enum state state;
    struct qg_field_key key;
    uint64_t asked;     /* by the maker's count */
    struct qg_job *job; /* while waiting or at work */
    struct qg_text text;
};

struct qg_field_maker {
    struct qg_means means;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t ordered;
    atomic_bool stopping; /* set under the mutex; read without it by what is being computed */
    uint64_t count;
    struct entry entry[ENTRIES];
};

static bool is_same(const struct qg_field_key *a, const struct qg_field_key *b) {
    return strcmp(a->id, b->id) == 0 && a->load_case == b->load_case && a->position == b->position;
}

static void empty(struct entry *entry) {
    free(entry->job);
    qg_text_finish(&entry->text);
    *entry = (struct entry){0};
}

/* A field under way is given up when the maker is told to stop. */
static bool is_stopping(void *self) {
    struct qg_field_maker *maker = self;
    return atomic_load_explicit(&maker->stopping, memory_order_relaxed);
}

/* ---- computing -------------------------------------------------------------------------------------------------- */

/* Appends the field's JSON; a failed text means that it could not be computed. */
static void compute(const struct qg_means *means, const struct qg_field_key *key, const struct qg_job *job,
                    struct qg_text *text) {
    const struct qg_study *study = &job->study;
    const struct qg_field_plan plan = {.pair = &study->pair,
                                       .analysis = &study->analysis,
                                       .relief = &study->relief,
                                       .position = key->position,
                                       .torque_fraction = study->analysis.torque_fraction[key->load_case]};
    struct qg_field field;
    if (qg_field_compute(&field, &plan, means, NULL) == QG_OK)
        qg_field_write(text, &field);
    else
        text->failed = true;
    qg_field_finish(&field);
}

/* The order that waits longest; NULL when none does. */
static struct entry *next_order(struct qg_field_maker *maker) {
    struct entry *first = NULL;
    for (int i = 0; i < ENTRIES; i++)
        if (maker->entry[i].state == WAITING && (!first || maker->entry[i].asked < first->asked))
            first = &maker->entry[i];
    return first;
}

static void *work(void *self) {
    struct qg_field_maker *maker = self;
    pthread_mutex_lock(&maker->mutex);
    while (!maker->stopping) {
        struct entry *entry = next_order(maker);
        if (!entry) {
            pthread_cond_wait(&maker->ordered, &maker->mutex);
            continue;
        }
        entry->state = AT_WORK;
        const struct qg_field_key key = entry->key;
        const struct qg_job *job = entry->job;
        struct qg_text text = {0};
        pthread_mutex_unlock(&maker->mutex);
        compute(&maker->means, &key, job, &text);
        pthread_mutex_lock(&maker->mutex);
        entry->state = text.failed ? FAILED : DONE;
        entry->text = text;
        free(entry->job);
        entry->job = NULL;
    }
    pthread_mutex_unlock(&maker->mutex);
    return NULL;
}

/* ---- the calls -------------------------------------------------------------------------------------------------- */

struct qg_field_maker *qg_field_maker_start(const struct qg_means *means) {
    struct qg_field_maker *maker = calloc(1, sizeof *maker);
    if (!maker)
        return NULL;
    maker->means = *means;
    maker->means.stop = (struct qg_stop){is_stopping, maker};
    pthread_mutex_init(&maker->mutex, NULL);
    pthread_cond_init(&maker->ordered, NULL);
    if (pthread_create(&maker->thread, NULL, work, maker) == 0)
        return maker;
    pthread_cond_destroy(&maker->ordered);
    pthread_mutex_destroy(&maker->mutex);
    free(maker);
    return NULL;
}

void qg_field_maker_stop(struct qg_field_maker *maker) {
    if (!maker)
        return;
    pthread_mutex_lock(&maker->mutex);
    maker->stopping = true;
    pthread_cond_signal(&maker->ordered);
    pthread_mutex_unlock(&maker->mutex);
    pthread_join(maker->thread, NULL);
    for (int i = 0; i < ENTRIES; i++)
        empty(&maker->entry[i]);
    pthread_cond_destroy(&maker->ordered);
    pthread_mutex_destroy(&maker->mutex);
    free(maker);
}

static struct entry *find(struct qg_field_maker *maker, const struct qg_field_key *key) {
    for (int i = 0; i < ENTRIES; i++)
        if (maker->entry[i].state != EMPTY && is_same(&maker->entry[i].key, key))
            return &maker->entry[i];
    return NULL;
}

enum qg_field_answer qg_field_find(struct qg_field_maker *maker, const struct qg_field_key *key, struct qg_text *text) {
    enum qg_field_answer answer = QG_FIELD_UNKNOWN;
    pthread_mutex_lock(&maker->mutex);
    struct entry *entry = find(maker, key);
    if (entry && entry->state == FAILED) {
        empty(entry);
        answer = QG_FIELD_FAILED;
    } else if (entry && entry->state == DONE) {
        entry->asked = ++maker->count;
        qg_text_add(text, entry->text.data, entry->text.length);
        answer = QG_FIELD_DONE;
    } else if (entry) {
        answer = QG_FIELD_PENDING;
    }
    pthread_mutex_unlock(&maker->mutex);
    return answer;
}

/* A place for an order: an empty one, else that of the result asked for longest ago; NULL when too many wait. */
static struct entry *make_room(struct qg_field_maker *maker) {
    struct entry *oldest = NULL;
    int waiting = 0;
    for (int i = 0; i < ENTRIES; i++) {
        struct entry *entry = &maker->entry[i];
        bool is_taken = entry->state == WAITING || entry->state == AT_WORK;
        waiting += entry->state == WAITING;
        if (!is_taken && (!oldest || entry->asked < oldest->asked)) /* an empty one was never asked for: 0 */
            oldest = entry;
    }
    assert(oldest || waiting >= WAITING_MOST);
    return waiting < WAITING_MOST ? oldest : NULL;
}

enum qg_field_answer qg_field_order(struct qg_field_maker *maker, const struct qg_field_key *key,
                                    const struct qg_job *job) {
    assert(key->load_case < job->study.analysis.case_count);
    assert(job->study.analysis.mesh_refinement <= QG_FIELD_REFINEMENT_MAX);
    struct qg_job *copy = malloc(sizeof *copy);
    if (!copy)
        return QG_FIELD_BUSY;
    *copy = *job;
    enum qg_field_answer answer = QG_FIELD_PENDING;
    pthread_mutex_lock(&maker->mutex);
    struct entry *entry = find(maker, key) ? NULL : make_room(maker);
    if (entry) {
        empty(entry);
        *entry = (struct entry){.state = WAITING, .key = *key, .asked = ++maker->count, .job = copy};
        copy = NULL;
        pthread_cond_signal(&maker->ordered);
    } else if (!find(maker, key)) {
        answer = QG_FIELD_BUSY;
    }
    pthread_mutex_unlock(&maker->mutex);
    free(copy);
    return answer;
}
