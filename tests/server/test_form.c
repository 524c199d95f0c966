/* Small bodies and queries: what is read, and which words the faults have. */
#include "tests/server/support.h"

#include <stdio.h>
#include <string.h>

#include "server/calls/form.h"

static const char *const keys[] = {"name", "colors", "count", "until", NULL};
static const char *const colors[] = {"red", "green", "blue", NULL};

/* One reading of a body. */
struct reading {
    struct qg_form form;
    struct qg_reply reply;
    char name[64];
    unsigned colors;
    int count;
    int64_t until;
    bool right;
};

static void read_body(struct reading *reading, const char *body, size_t length) {
    struct qg_request request = {0};
    memset(reading, 0, sizeof *reading);
    qg_text_add(&request.body, body, length);
    reading->right = qg_form_read(&reading->form, &request, keys, &reading->reply);
    if (reading->right) {
        const char *name = qg_form_text(&reading->form, "name", 10, true);
        snprintf(reading->name, sizeof reading->name, "%s", name ? name : "");
        reading->colors = qg_form_words(&reading->form, "colors", colors);
        reading->count = qg_form_count(&reading->form, "count", 1, 1000);
        reading->until = qg_form_time(&reading->form, "until", 1000);
        reading->right = qg_form_is_right(&reading->form, &reading->reply);
    }
    qg_form_finish(&reading->form);
    qg_text_finish(&request.body);
}

static void reads_texts_and_words(void **state) {
    (void)state;
    static const char body[] =
        "{\"name\":\"h\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\xc3\xa4\",\"colors\":[\"blue\","
        "\"red\"]}";
    struct reading reading;
    read_body(&reading, body, sizeof body - 1);
    assert_true(reading.right);
    assert_int_equal(strlen(reading.name), 19);
    assert_int_equal(reading.colors, 5);
    assert_true(reading.count == 0 && reading.until == 0);
}

static void reads_numbers_and_times(void **state) {
    (void)state;
    static const char body[] = "{\"name\":\"a\",\"colors\":[\"red\"],\"count\":1e3,\"until\":\"1970-01-01T00:00:02Z\"}";
    struct reading reading;
    read_body(&reading, body, sizeof body - 1);
    assert_true(reading.right);
    assert_int_equal(reading.count, 1000);
    assert_int_equal(reading.until, 2000);
}

static void names_every_fault(void **state) {
    (void)state;
    static const struct {
        const char *body;
        int status;
        const char *words;
    } cases[] = {
        {"", 400, "not-json"},
        {"{", 400, "not-json"},
        {"{\"name\":\"a\",\"name\":\"b\"}", 400, "not-json"},
        {"{\"name\":\"a\\u0000b\",\"colors\":[\"red\"]}", 400, "not-json"},
        {"[]", 422, "allowed is an object"},
        {"{}", 422, "\"pointer\":\"/name\",\"detail\":\"is missing\""},
        {"{}", 422, "\"pointer\":\"/colors\",\"detail\":\"is missing"},
        {"{\"name\":\"\",\"colors\":[\"red\"]}", 422, "/name"},
        {"{\"name\":\"12345678901\",\"colors\":[\"red\"]}", 422, "1 to 10 characters"},
        {"{\"name\":\"a\\nb\",\"colors\":[\"red\"]}", 422, "/name"},
        {"{\"name\":\"a\\u0085b\",\"colors\":[\"red\"]}", 422, "/name"},
        {"{\"name\":7,\"colors\":[\"red\"]}", 422, "/name"},
        {"{\"name\":\"a\",\"colors\":[]}", 422, "red, green and blue"},
        {"{\"name\":\"a\",\"colors\":\"red\"}", 422, "/colors"},
        {"{\"name\":\"a\",\"colors\":[\"red\",\"red\"]}", 422, "found \\\"red\\\" twice, needed is an array"},
        {"{\"name\":\"a\",\"colors\":[\"red\",\"gr\\u00fcn\"]}", 422, "found \\\"gr\u00fcn\\\", needed is an array"},
        {"{\"name\":\"a\",\"colors\":[]}", 422, "found an empty array"},
        {"{\"name\":\"a\",\"colors\":[7]}", 422, "found something else"},
        {"{\"name\":\"a\",\"colors\":{\"red\":\"red\"}}", 422, "found something else"},
        {"{\"name\":\"a\",\"colors\":[\"pink\"]}", 422, "/colors"},
        {"{\"name\":\"a\",\"colors\":[1]}", 422, "/colors"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":0}", 422, "from 1 to 1000"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":1001}", 422, "/count"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":1.5}", 422, "/count"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":-1e300}", 422, "/count"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":\"7\"}", 422, "/count"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"count\":null}", 422, "/count"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"until\":7}", 422, "RFC 3339"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"until\":\"tomorrow\"}", 422, "/until"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"until\":\"1970-01-01T00:00:01Z\"}", 422, "one to come"},
        {"{\"name\":\"a\",\"colors\":[\"red\"],\"a/b\":1}", 422,
         "\"pointer\":\"/a~1b\",\"detail\":\"unknown key, allowed are name, colors, count and until"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct reading reading;
        read_body(&reading, cases[i].body, strlen(cases[i].body));
        assert_false(reading.right);
        if (reading.reply.status != cases[i].status || !strstr(reading.reply.body.data, cases[i].words))
            fail_msg("%s: %d %s", cases[i].body, reading.reply.status, reading.reply.body.data);
        qg_reply_finish(&reading.reply);
    }
}

static void writes_links_that_are_read_again(void **state) {
    (void)state;
    static struct qg_request request;
    const struct qg_page page = {.limit = 7};
    struct qg_reply reply = {0};
    struct qg_text more = {0};
    char link[QG_REPLY_HEADER_ROOM];
    qg_query_add(&more, "since", "a b&c=d/\xc3\xa4%+");
    qg_query_add(&more, "until", NULL);
    qg_page_link("/v1/audit", &page, 12, more.data, &reply);
    assert_int_equal(sscanf(qg_reply_header_value(&reply, "Link"), "<%1000[^>]>; rel=\"next\"", link), 1);
    assert_null(qg_target_parse(&request.target, link));
    assert_string_equal(qg_target_query(&request.target, "since"), "a b&c=d/\xc3\xa4%+");
    assert_string_equal(qg_target_query(&request.target, "cursor"), "12");
    assert_null(qg_target_query(&request.target, "until"));
    qg_text_finish(&more);
    qg_reply_finish(&reply);
}

static void reads_pages(void **state) {
    (void)state;
    static const char *const filters[] = {"since", NULL};
    static const struct {
        const char *target;
        bool right;
        size_t limit;
        int64_t before;
    } cases[] = {
        {"/v1/audit", true, QG_PAGE_LIMIT, 0},      {"/v1/audit?limit=7&cursor=12", true, 7, 12},
        {"/v1/audit?limit=500", true, 500, 0},      {"/v1/audit?limit=501", false, 0, 0},
        {"/v1/audit?limit=0", false, 0, 0},         {"/v1/audit?limit=", false, 0, 0},
        {"/v1/audit?cursor=-1", false, 0, 0},       {"/v1/audit?token=qg_0", false, 0, 0},
        {"/v1/audit?limit=1&limit=2", false, 0, 0}, {"/v1/audit?since=x&limit=2", true, 2, 0},
        {"/v1/audit?since=x&since=y", false, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        static struct qg_request request;
        struct qg_reply reply = {0};
        struct qg_page page;
        assert_null(qg_target_parse(&request.target, cases[i].target));
        if (qg_page_read(&request, filters, &page, &reply) != cases[i].right)
            fail_msg("%s", cases[i].target);
        if (cases[i].right) {
            assert_int_equal(page.limit, cases[i].limit);
            assert_int_equal(page.before, cases[i].before);
        } else {
            assert_int_equal(reply.status, 400);
        }
        qg_reply_finish(&reply);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_texts_and_words),
        cmocka_unit_test(reads_numbers_and_times),
        cmocka_unit_test(names_every_fault),
        cmocka_unit_test(reads_pages),
        cmocka_unit_test(writes_links_that_are_read_again),
    };
    return cmocka_run_group_tests_name("form", tests, NULL, NULL);
}
