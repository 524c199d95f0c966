/* How much memory is ours: limits of control groups, in directories laid out like the kernel's. */
#include "tests/server/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/base/machine.h"

struct groups {
    char root[32], membership[48], middle[48], leaf[64];
};

static void put(const char *directory, const char *name, const char *text) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *stream = fopen(path, "w");
    assert_non_null(stream);
    assert_true(fputs(text, stream) >= 0);
    assert_int_equal(fclose(stream), 0);
}

/* A group in a group, the leaf ours. */
static int make_groups(void **state) {
    struct groups *g = calloc(1, sizeof *g);
    snprintf(g->root, sizeof g->root, "/tmp/quietgear-XXXXXX");
    assert_non_null(mkdtemp(g->root));
    snprintf(g->membership, sizeof g->membership, "%s/membership", g->root);
    snprintf(g->middle, sizeof g->middle, "%s/middle.slice", g->root);
    snprintf(g->leaf, sizeof g->leaf, "%s/leaf.service", g->middle);
    assert_int_equal(mkdir(g->middle, 0700), 0);
    assert_int_equal(mkdir(g->leaf, 0700), 0);
    put(g->root, "membership", "12:pids:/other\n0::/middle.slice/leaf.service\n");
    *state = g;
    return 0;
}

static int remove_groups(void **state) {
    struct groups *g = *state;
    const char *const directories[] = {g->leaf, g->middle, g->root};
    for (size_t i = 0; i < 3; i++) {
        static const char *const names[] = {"memory.max", "memory.high", "membership"};
        for (size_t k = 0; k < 3; k++) {
            char path[128];
            snprintf(path, sizeof path, "%s/%s", directories[i], names[k]);
            unlink(path);
        }
        rmdir(directories[i]);
    }
    free(g);
    return 0;
}

static void the_smallest_limit_on_the_way_counts(void **state) {
    struct groups *g = *state;
    assert_true(isinf(qg_cgroup_memory(g->root, g->membership)));
    put(g->leaf, "memory.max", "max\n");
    assert_true(isinf(qg_cgroup_memory(g->root, g->membership)));
    put(g->middle, "memory.max", "2000000000\n");
    assert_true(qg_cgroup_memory(g->root, g->membership) == 2e9);
    put(g->leaf, "memory.high", "1000000000\n");
    assert_true(qg_cgroup_memory(g->root, g->membership) == 1e9);
    put(g->root, "memory.max", "500000000\n"); /* as a container sees its own limit */
    assert_true(qg_cgroup_memory(g->root, g->membership) == 5e8);
}

static void without_groups_there_is_no_limit(void **state) {
    struct groups *g = *state;
    put(g->leaf, "memory.max", "1000000000\n");
    assert_true(isinf(qg_cgroup_memory(g->root, "/nonexistent")));
    assert_true(isinf(qg_cgroup_memory("/nonexistent", g->membership)));
    put(g->root, "membership", "1:memory:/middle.slice/leaf.service\n"); /* version 1 */
    assert_true(isinf(qg_cgroup_memory(g->root, g->membership)));
}

static void the_limit_on_the_address_space_counts(void **state) {
    (void)state;
    struct rlimit before, less;
    const double bytes = qg_machine_memory();
    assert_true(bytes >= 64e6 && isfinite(bytes));
    assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
    less = before;
    less.rlim_cur = (rlim_t)1 << 24;
    assert_int_equal(setrlimit(RLIMIT_AS, &less), 0);
    const double limited = qg_machine_memory();
    assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
    assert_true(limited == 16777216);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_smallest_limit_on_the_way_counts, make_groups, remove_groups),
        cmocka_unit_test_setup_teardown(without_groups_there_is_no_limit, make_groups, remove_groups),
        cmocka_unit_test(the_limit_on_the_address_space_counts),
    };
    return cmocka_run_group_tests_name("machine", tests, NULL, NULL);
}
