/* Whose name is in Host, and whose page is in Origin. */
#include "tests/server/support.h"

#include <string.h>

#include "server/http/origin.h"

static void names_that_are_ours(void **state) {
    (void)state;
    static const char *const ours[] = {"localhost",      "localhost:8080", "LocalHost.",        "a.localhost",
                                       "127.0.0.1",      "127.0.0.1:1",    "192.168.3.4:80",    "[::1]",
                                       "[fe80::1]:8080", "gears.example",  "GEARS.example.:99", "b"};
    for (size_t i = 0; i < sizeof ours / sizeof ours[0]; i++)
        assert_int_equal(qg_host_judge(ours[i], "gears.example, b"), QG_HOST_OURS);
    assert_int_equal(qg_host_judge("evil.example", "*"), QG_HOST_OURS);
}

static void names_that_are_not(void **state) {
    (void)state;
    static const char *const foreign[] = {
        "evil.example", "localhost.evil.example", "notlocalhost", "gears.example.evil",
        "ears.example", "127.0.0.1.evil",         "1.2.3",        "0x7f000001"};
    for (size_t i = 0; i < sizeof foreign / sizeof foreign[0]; i++)
        assert_int_equal(qg_host_judge(foreign[i], "gears.example"), QG_HOST_FOREIGN);
    assert_int_equal(qg_host_judge("evil.example", ""), QG_HOST_FOREIGN);
}

static void what_is_no_host(void **state) {
    (void)state;
    static const char *const bad[] = {"",     ":80",    "a b",         "u@localhost", "localhost:x", "localhost:123456",
                                      "[::1", "[::1]x", "[localhost]", "::1",         "a/b",         "127.0.0.1:80:80"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(qg_host_judge(bad[i], "*"), QG_HOST_MALFORMED);
    char endless[400];
    memset(endless, 'a', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    assert_int_equal(qg_host_judge(endless, "*"), QG_HOST_MALFORMED);
}

static void origins(void **state) {
    (void)state;
    assert_true(qg_origin_is_ours("http://localhost:8080", "localhost:8080", ""));
    assert_true(qg_origin_is_ours("https://Gears.example", "gears.example", ""));
    assert_true(qg_origin_is_ours("https://gears.example", "127.0.0.1:8080", "gears.example")); /* behind a proxy */
    assert_false(qg_origin_is_ours("http://localhost:3000", "localhost:8080", ""));
    assert_false(qg_origin_is_ours("http://evil.example", "localhost:8080", "gears.example"));
    assert_false(qg_origin_is_ours("null", "localhost:8080", ""));
    assert_false(qg_origin_is_ours("", "localhost:8080", ""));
    assert_false(qg_origin_is_ours("file://localhost:8080", "localhost:8080", ""));
}

static void lists(void **state) {
    (void)state;
    assert_true(qg_hosts_are_valid(""));
    assert_true(qg_hosts_are_valid("a.example, b.example c"));
    assert_true(qg_hosts_are_valid("*"));
    assert_false(qg_hosts_are_valid("http://a.example"));
    assert_false(qg_hosts_are_valid("*.example"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_that_are_ours),
        cmocka_unit_test(names_that_are_not),
        cmocka_unit_test(what_is_no_host),
        cmocka_unit_test(origins),
        cmocka_unit_test(lists),
    };
    return cmocka_run_group_tests_name("origin", tests, NULL, NULL);
}
