/* A store in a temporary directory of its own, for tests that need a real one. */
#ifndef QG_TESTS_SERVER_PLACE_H
#define QG_TESTS_SERVER_PLACE_H

#include "tests/server/support.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/store/internal.h"

struct place {
    char directory[32];
    struct qg_store *store;
};

static inline void open_place(struct place *place) {
    char message[QG_STORE_MESSAGE_ROOM] = "";
    place->store = qg_store_open(place->directory, message);
    if (!place->store)
        fail_msg("%s", message);
}

static inline int make_place(void **state) {
    struct place *place = calloc(1, sizeof *place);
    strcpy(place->directory, "/tmp/quietgear-XXXXXX");
    assert_non_null(mkdtemp(place->directory));
    open_place(place);
    *state = place;
    return 0;
}

static inline int remove_place(void **state) {
    struct place *place = *state;
    qg_store_close(place->store);
    DIR *directory = opendir(place->directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        if (entry->d_name[0] != '.')
            unlinkat(dirfd(directory), entry->d_name, 0);
    closedir(directory);
    rmdir(place->directory);
    free(place);
    return 0;
}

static inline void reopen_place(struct place *place) {
    qg_store_close(place->store);
    open_place(place);
}

/* Runs SQL that has to succeed. */
static inline void run_sql(struct place *place, const char *sql) {
    assert_int_equal(sqlite3_exec(place->store->writer, sql, NULL, NULL, NULL), SQLITE_OK);
}

/* The whole number that a query yields. */
static inline int64_t ask_sql(struct place *place, const char *sql) {
    sqlite3_stmt *statement = NULL;
    assert_int_equal(sqlite3_prepare_v2(place->store->writer, sql, -1, &statement, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    int64_t number = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return number;
}

#define PLACE_TEST(function) cmocka_unit_test_setup_teardown(function, make_place, remove_place)

#endif
