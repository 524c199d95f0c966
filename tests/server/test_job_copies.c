/* Job copies: one rendering for all readers, never older than what they know. */
#include "tests/server/place.h"

#include <math.h>

#include "server/work/job_copies.h"

/* A store with one job, a board, and copies of it. */
struct desk {
    struct place *place;
    struct qg_board *board;
    struct qg_job_copies *copies;
    struct qg_claim claim; /* the job's */
};

static void open_desk(void **state, struct desk *desk) {
    struct qg_job_row row;
    struct qg_text document = {0};
    const struct qg_submission submission = {.name = "", .kind = "optimize", .labels = "[]", .document = "{}"};
    desk->place = *state;
    desk->board = qg_board_create();
    desk->copies = qg_job_copies_create(desk->place->store, desk->board);
    assert_int_equal(qg_store_submit(desk->place->store, &submission, &row), QG_STORE_OK);
    qg_job_row_finish(&row);
    assert_int_equal(qg_store_claim(desk->place->store, 60000, &desk->claim, &document), QG_STORE_OK);
    qg_text_finish(&document);
}

static void close_desk(struct desk *desk) {
    qg_job_copies_destroy(desk->copies);
    qg_board_destroy(desk->board);
}

static void publish(struct desk *desk, size_t done) {
    const struct qg_job_progress progress = {.done = done, .total = 9, .phase = "random", .eta = NAN, .best = NAN};
    qg_board_publish(desk->board, desk->claim.id, &progress);
}

static void finish(struct desk *desk) {
    const struct qg_ending ending = {.state = QG_STATE_SUCCEEDED};
    assert_int_equal(qg_store_finish(desk->place->store, &desk->claim, &ending), QG_STORE_OK);
}

/* The copy has to hold `wanted`. */
static enum qg_state read_copy(struct desk *desk, int64_t since, const char *wanted) {
    struct qg_text text = {0};
    enum qg_state state = QG_STATE_COUNT;
    assert_int_equal(qg_job_copy(desk->copies, desk->claim.id, since, &text, &state), QG_STORE_OK);
    assert_non_null(strstr(text.data, wanted));
    qg_text_finish(&text);
    return state;
}

static void renders_once_for_all(void **state) {
    struct desk desk;
    open_desk(state, &desk);
    publish(&desk, 3);
    for (int i = 0; i < 5; i++)
        assert_int_equal(read_copy(&desk, 0, "\"done\":3"), QG_STATE_RUNNING);
    assert_int_equal(qg_job_copies_made(desk.copies), 1);
    publish(&desk, 4);
    for (int i = 0; i < 5; i++)
        read_copy(&desk, 0, "\"done\":4");
    assert_int_equal(qg_job_copies_made(desk.copies), 2);
    close_desk(&desk);
}

static void another_jobs_progress_leaves_a_copy_alone(void **state) {
    const struct qg_job_progress progress = {.done = 1};
    struct desk desk;
    open_desk(state, &desk);
    publish(&desk, 3);
    read_copy(&desk, 0, "\"done\":3");
    qg_board_publish(desk.board, "another", &progress);
    read_copy(&desk, 0, "\"done\":3");
    assert_int_equal(qg_job_copies_made(desk.copies), 1);
    close_desk(&desk);
}

static void tells_what_was_announced(void **state) {
    struct desk desk;
    open_desk(state, &desk);
    publish(&desk, 3);
    read_copy(&desk, 0, "\"cancel_requested\":false");
    assert_int_equal(qg_store_cancel(desk.place->store, desk.claim.id, NULL), QG_STORE_OK);
    qg_board_touch(desk.board, desk.claim.id);
    read_copy(&desk, 0, "\"cancel_requested\":true");
    finish(&desk);
    qg_board_retire(desk.board, desk.claim.id);
    assert_int_equal(read_copy(&desk, 0, "succeeded"), QG_STATE_SUCCEEDED);
    close_desk(&desk);
}

/* A change that is committed, and not announced yet. */
static void is_no_older_than_its_reader(void **state) {
    struct desk desk;
    int64_t revision;
    open_desk(state, &desk);
    publish(&desk, 3);
    read_copy(&desk, 0, "running");
    finish(&desk);
    assert_int_equal(qg_store_revision(desk.place->store, &revision), QG_STORE_OK);
    assert_int_equal(read_copy(&desk, revision - 1, "running"), QG_STATE_RUNNING);
    assert_int_equal(read_copy(&desk, revision, "succeeded"), QG_STATE_SUCCEEDED);
    close_desk(&desk);
}

static void forgets_the_deleted(void **state) {
    struct desk desk;
    struct qg_text text = {0};
    open_desk(state, &desk);
    finish(&desk);
    read_copy(&desk, 0, "succeeded");
    assert_int_equal(qg_store_delete(desk.place->store, desk.claim.id, NULL), QG_STORE_OK);
    qg_board_touch(desk.board, desk.claim.id);
    assert_int_equal(qg_job_copy(desk.copies, desk.claim.id, 0, &text, NULL), QG_STORE_NOT_FOUND);
    assert_int_equal(text.length, 0);
    close_desk(&desk);
}

/* More jobs than there is room for. */
static void serves_more_jobs_than_it_keeps(void **state) {
    enum { JOBS = 100 };
    const struct qg_submission submission = {.name = "", .kind = "optimize", .labels = "[]", .document = "{}"};
    struct desk desk;
    struct qg_job_row row[JOBS];
    open_desk(state, &desk);
    for (int i = 0; i < JOBS; i++)
        assert_int_equal(qg_store_submit(desk.place->store, &submission, &row[i]), QG_STORE_OK);
    for (int i = 0; i < 2 * JOBS; i++) {
        struct qg_text text = {0};
        assert_int_equal(qg_job_copy(desk.copies, row[i / 2].id, 0, &text, NULL), QG_STORE_OK);
        assert_non_null(strstr(text.data, row[i / 2].id));
        qg_text_finish(&text);
    }
    assert_int_equal(qg_job_copies_made(desk.copies), JOBS);
    for (int i = 0; i < JOBS; i++)
        qg_job_row_finish(&row[i]);
    close_desk(&desk);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        PLACE_TEST(renders_once_for_all),     PLACE_TEST(another_jobs_progress_leaves_a_copy_alone),
        PLACE_TEST(tells_what_was_announced), PLACE_TEST(is_no_older_than_its_reader),
        PLACE_TEST(forgets_the_deleted),      PLACE_TEST(serves_more_jobs_than_it_keeps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
