/* Jobs rendered once for all their readers. See job_copies.h. */
#include "server/work/job_copies.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "server/work/job_text.h"

enum { COPIES = 64 };

struct copy {
    char id[QG_JOB_ID_ROOM]; /* "": none */
    uint64_t touched;        /* the board's last touch */
    uint64_t version;        /* of the job's notice; 0: it has none */
    int64_t revision;        /* the store's last */
    enum qg_state state;
    struct qg_text text;
    uint64_t asked; /* when it was last asked for: a count */
};

struct qg_job_copies {
    struct qg_store *store;
    struct qg_board *board;
    pthread_mutex_t mutex; /* guards all that follows */
    uint64_t asked, made;
    struct copy copy[COPIES];
};

struct qg_job_copies *qg_job_copies_create(struct qg_store *store, struct qg_board *board) {
    struct qg_job_copies *copies = calloc(1, sizeof *copies);
    if (!copies)
        return NULL;
    copies->store = store;
    copies->board = board;
    pthread_mutex_init(&copies->mutex, NULL);
    return copies;
}

void qg_job_copies_destroy(struct qg_job_copies *copies) {
    if (!copies)
        return;
    for (int i = 0; i < COPIES; i++)
        qg_text_finish(&copies->copy[i].text);
    pthread_mutex_destroy(&copies->mutex);
    free(copies);
}

/* The copy of a job; when there is none, the place of the one that was not asked for the longest. The mutex is held. */
static struct copy *find(struct qg_job_copies *copies, const char *id) {
    struct copy *oldest = &copies->copy[0];
    for (int i = 0; i < COPIES; i++) {
        if (strcmp(copies->copy[i].id, id) == 0)
            return &copies->copy[i];
        if (copies->copy[i].asked < oldest->asked)
            oldest = &copies->copy[i];
    }
    return oldest;
}

/* The moment at which a copy would be made now. */
static struct copy moment(struct qg_job_copies *copies, const char *id) {
    struct qg_job_progress progress;
    return (struct copy){.touched = qg_board_touched(copies->board),
                         .version = qg_board_progress(copies->board, id, &progress)};
}

/* Renders a job into a copy, which is without text when it cannot. The mutex is held; `now` was taken before. */
static enum qg_store_status render(struct qg_job_copies *copies, const char *id, const struct copy *now,
                                   struct copy *copy) {
    struct qg_job_row row;
    qg_text_finish(&copy->text);
    copy->id[0] = '\0';
    enum qg_store_status status = qg_store_job(copies->store, id, &row);
    if (status != QG_STORE_OK)
        return status;
    copies->made++;
    qg_job_write(&copy->text, copies->board, &row);
    copy->touched = now->touched;
    copy->version = now->version;
    copy->revision = row.as_of;
    copy->state = row.state;
    if (!copy->text.failed)
        memcpy(copy->id, row.id, sizeof copy->id);
    qg_job_row_finish(&row);
    return QG_STORE_OK;
}

enum qg_store_status qg_job_copy(struct qg_job_copies *copies, const char *id, int64_t since, struct qg_text *text,
                                 enum qg_state *state) {
    enum qg_store_status status = QG_STORE_OK;
    pthread_mutex_lock(&copies->mutex);
    struct copy *copy = find(copies, id);
    const struct copy now = moment(copies, id);
    if (strcmp(copy->id, id) != 0 || copy->touched != now.touched || copy->version != now.version ||
        copy->revision < since)
        status = render(copies, id, &now, copy);
    if (status == QG_STORE_OK) {
        copy->asked = ++copies->asked;
        text->failed = text->failed || copy->text.failed;
        if (!text->failed)
            qg_text_add(text, copy->text.data, copy->text.length);
        if (state)
            *state = copy->state;
    }
    pthread_mutex_unlock(&copies->mutex);
    return status;
}

uint64_t qg_job_copies_made(struct qg_job_copies *copies) {
    pthread_mutex_lock(&copies->mutex);
    uint64_t made = copies->made;
    pthread_mutex_unlock(&copies->mutex);
    return made;
}
