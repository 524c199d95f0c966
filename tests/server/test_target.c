/* Request targets and header fields: what is taken apart how, and what is refused. */
#include "tests/server/support.h"

#include <string.h>

#include "server/http/target.h"

static void takes_targets_apart(void **state) {
    (void)state;
    struct qg_target target;
    assert_null(qg_target_parse(&target, "/"));
    assert_int_equal(target.segment_count, 0);
    assert_null(qg_target_parse(&target, "/v1/jobs?state=queued&label=a%26b+c&empty=&bare"));
    assert_int_equal(target.segment_count, 2);
    assert_string_equal(target.segment[0], "v1");
    assert_string_equal(target.segment[1], "jobs");
    assert_string_equal(qg_target_query(&target, "state"), "queued");
    assert_string_equal(qg_target_query(&target, "label"), "a&b c");
    assert_string_equal(qg_target_query(&target, "empty"), "");
    assert_string_equal(qg_target_query(&target, "bare"), "");
    assert_null(qg_target_query(&target, "limit"));
    assert_null(qg_target_parse(&target, "/a+b/%C3%A9?"));
    assert_string_equal(target.segment[0], "a+b");
    assert_string_equal(target.segment[1], "\xc3\xa9");
    assert_int_equal(target.query_count, 0);
}

static void refuses_bad_targets(void **state) {
    (void)state;
    static const char *const bad[] = {
        "",
        "v1/jobs",
        "http://host/v1/jobs",
        "*",
        "//",
        "/v1//jobs",
        "/v1/jobs/",
        "/..",
        "/v1/../",
        "/v1/%2e%2e/jobs",
        "/v1/%2E",
        "/v1/a%2fb",
        "/v1/a%5Cb",
        "/v1/jobs%00",
        "/v1/%0a",
        "/v1/%7f",
        "/v1/%zz",
        "/v1/%ff",
        "/v1/\xc0\x80",
        "/v1?a=%c3",
        "/v1/%4",
        "/v1/%",
        "/v1?a=%00",
        "/v1?a%0d=1",
        "/v1?a=%",
        "/1/2/3/4/5/6/7/8/9",
        "/?a&b&c&d&e&f&g&h&i&j&k&l&m&n&o&p&q",
    };
    struct qg_target target;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        if (!qg_target_parse(&target, bad[i]))
            fail_msg("\"%s\" was taken", bad[i]);
    char longest[QG_TARGET_ROOM + 1];
    memset(longest, 'a', sizeof longest);
    longest[0] = '/';
    longest[QG_TARGET_ROOM] = '\0';
    assert_non_null(qg_target_parse(&target, longest));
    longest[QG_TARGET_ROOM - 1] = '\0';
    assert_null(qg_target_parse(&target, longest));
}

static void names_the_offending_parameter(void **state) {
    (void)state;
    static const char *const names[] = {"limit", "state", NULL};
    struct qg_target target;
    const char *offender = NULL;
    qg_target_parse(&target, "/?limit=1&state=queued");
    assert_true(qg_target_query_is_among(&target, names, &offender));
    qg_target_parse(&target, "/?limit=1&color=red");
    assert_false(qg_target_query_is_among(&target, names, &offender));
    assert_string_equal(offender, "color");
    qg_target_parse(&target, "/?limit=1&limit=2");
    assert_false(qg_target_query_is_among(&target, names, &offender));
    assert_string_equal(offender, "limit");
}

static void negotiates(void **state) {
    (void)state;
    static const char *const offers[] = {"application/json", "text/csv", NULL};
    static const struct {
        const char *accept;
        int chosen;
    } cases[] = {
        {NULL, 0},
        {"*/*", 0},
        {"text/csv", 1},
        {"TEXT/CSV;charset=utf-8", 1},
        {"text/*", 1},
        {"text/csv;q=0.5, application/json;q=0.4", 1},
        {"text/csv;q=0.5,application/json", 0},
        {"application/*;q=0.1, text/csv;q=0.2", 1},
        {"*/*, application/json;q=0", 1},
        {"application/json;q=0, text/csv;q=0", -1},
        {"text/html, image/*", -1},
        {"application/jso", -1},
        {"text/csv;q=2", -1},
        {"text/html,application/xhtml+xml,*/*;q=0.8", 0},
        {"", -1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        if (qg_negotiate(cases[i].accept, offers) != cases[i].chosen)
            fail_msg("\"%s\" chose %d", cases[i].accept, qg_negotiate(cases[i].accept, offers));
}

static void matches_entity_tags(void **state) {
    (void)state;
    assert_true(qg_etag_matches("\"a1\"", "\"a1\""));
    assert_true(qg_etag_matches("\"b\", W/\"a1\"", "\"a1\""));
    assert_true(qg_etag_matches("*", "\"a1\""));
    assert_false(qg_etag_matches("\"a\"", "\"a1\""));
    assert_false(qg_etag_matches("a1", "\"a1\""));
    assert_false(qg_etag_matches("", "\"a1\""));
    assert_false(qg_etag_matches(NULL, "\"a1\""));
}

static void reads_prefer_and_content_type(void **state) {
    (void)state;
    assert_int_equal(qg_prefer_wait("wait=10"), 10);
    assert_int_equal(qg_prefer_wait("respond-async, Wait=3"), 3);
    assert_int_equal(qg_prefer_wait("wait=-1"), -1);
    assert_int_equal(qg_prefer_wait("wait=1x"), -1);
    assert_int_equal(qg_prefer_wait("wait=99999999999999999999"), -1);
    assert_int_equal(qg_prefer_wait("wait="), -1);
    assert_int_equal(qg_prefer_wait(NULL), 0);
    assert_true(qg_media_type_is("application/json", "application/json"));
    assert_true(qg_media_type_is("Application/JSON ; charset=utf-8", "application/json"));
    assert_false(qg_media_type_is("application/json5", "application/json"));
    assert_false(qg_media_type_is("", "application/json"));
}

static void reads_accept_encoding(void **state) {
    (void)state;
    static const char *const yes[] = {"gzip", "deflate, gzip;q=1.0, *;q=0.5", "GZIP", "*", "x-gzip", "br, * ; q=0.1"};
    static const char *const no[] = {"", "identity", "br", "gzip;q=0", "gzip;q=0, *", "*;q=0"};
    for (size_t i = 0; i < sizeof yes / sizeof yes[0]; i++)
        assert_true(qg_accepts_gzip(yes[i]));
    for (size_t i = 0; i < sizeof no / sizeof no[0]; i++)
        assert_false(qg_accepts_gzip(no[i]));
    assert_false(qg_accepts_gzip(NULL));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_targets_apart),           cmocka_unit_test(refuses_bad_targets),
        cmocka_unit_test(names_the_offending_parameter), cmocka_unit_test(negotiates),
        cmocka_unit_test(matches_entity_tags),           cmocka_unit_test(reads_prefer_and_content_type),
        cmocka_unit_test(reads_accept_encoding),
    };
    return cmocka_run_group_tests_name("target", tests, NULL, NULL);
}
