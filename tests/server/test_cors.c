/* Which origins a list names. */
#include "tests/server/support.h"

#include "server/http/cors.h"

static void takes_lists_of_origins_only(void **state) {
    (void)state;
    static const char *const right[] = {"", "https://a.example", "http://a.example:8080, https://b.example",
                                        " https://[2001:db8::1]:8443 "};
    static const char *const wrong[] = {"*",
                                        "null",
                                        "a.example",
                                        "https://",
                                        "ftp://x.org",
                                        "https://a/b",
                                        "https://*.a.org",
                                        "https://A.example",
                                        "https://a.example https://b.example/",
                                        "https://u@a.example"};
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++)
        assert_true(qg_cors_is_list(right[i]));
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (qg_cors_is_list(wrong[i]))
            fail_msg("%s was taken", wrong[i]);
}

static void allows_listed_origins_only(void **state) {
    (void)state;
    static const char list[] = "https://plm.example.com, http://tools.example.com:8080";
    assert_true(qg_cors_allows(list, "https://plm.example.com"));
    assert_true(qg_cors_allows(list, "http://tools.example.com:8080"));
    static const char *const others[] = {NULL,
                                         "",
                                         "null",
                                         "https://plm.example.co",
                                         "https://plm.example.com.evil.org",
                                         "http://plm.example.com",
                                         "http://tools.example.com",
                                         "example.com"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_false(qg_cors_allows(list, others[i]));
    assert_false(qg_cors_allows("", "https://plm.example.com"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_lists_of_origins_only),
        cmocka_unit_test(allows_listed_origins_only),
    };
    return cmocka_run_group_tests_name("cors", tests, NULL, NULL);
}
