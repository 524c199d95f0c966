/* Which addresses and URLs webhooks may have, however they are written. */
#include "tests/server/support.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <string.h>

#include "server/base/address.h"

/* Judges an address in numbers. */
static bool is_allowed(const char *text, const char *networks) {
    struct sockaddr_in v4 = {.sin_family = AF_INET, .sin_port = htons(443)};
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6, .sin6_port = htons(443)};
    if (inet_pton(AF_INET, text, &v4.sin_addr) == 1)
        return qg_address_is_allowed((const struct sockaddr *)&v4, networks);
    assert_int_equal(inet_pton(AF_INET6, text, &v6.sin6_addr), 1);
    return qg_address_is_allowed((const struct sockaddr *)&v6, networks);
}

/* The edges of the ranges, in and out. */
static void knows_special_addresses(void **state) {
    (void)state;
    static const char *const forbidden[] = {"0.0.0.0",
                                            "0.255.255.255",
                                            "10.0.0.1",
                                            "10.255.255.255",
                                            "100.64.0.0",
                                            "100.127.255.255",
                                            "127.0.0.1",
                                            "127.255.255.254",
                                            "169.254.169.254",
                                            "172.16.0.0",
                                            "172.31.255.255",
                                            "192.0.0.8",
                                            "192.0.2.1",
                                            "192.168.0.1",
                                            "198.18.0.1",
                                            "198.19.255.255",
                                            "198.51.100.7",
                                            "203.0.113.9",
                                            "224.0.0.1",
                                            "239.255.255.255",
                                            "240.0.0.1",
                                            "255.255.255.255",
                                            "::",
                                            "::1",
                                            "::7f00:1",
                                            "::ffff:127.0.0.1",
                                            "::ffff:10.0.0.1",
                                            "::ffff:0.0.0.0",
                                            "::ffff:169.254.169.254",
                                            "64:ff9b::7f00:1",
                                            "64:ff9b::10.1.2.3",
                                            "64:ff9b:1::1",
                                            "100::1",
                                            "2001::1",
                                            "2001:db8::1",
                                            "2002:7f00:1::1",
                                            "fc00::1",
                                            "fdff:ffff::1",
                                            "fe80::1",
                                            "febf::1",
                                            "fec0::1",
                                            "ff02::1"};
    static const char *const public[] = {"1.0.0.1",         "9.255.255.255",   "11.0.0.0",        "100.63.255.255",
                                         "100.128.0.0",     "126.255.255.255", "128.0.0.1",       "172.15.255.255",
                                         "172.32.0.0",      "192.167.255.255", "192.169.0.0",     "198.17.255.255",
                                         "198.20.0.0",      "223.255.255.255", "8.8.8.8",         "::ffff:8.8.8.8",
                                         "2606:4700::1111", "2a00:1450::1",    "64:ff9b::8.8.8.8"};
    for (size_t i = 0; i < sizeof forbidden / sizeof forbidden[0]; i++)
        if (is_allowed(forbidden[i], ""))
            fail_msg("%s is allowed", forbidden[i]);
    for (size_t i = 0; i < sizeof public / sizeof public[0]; i++) /* IPv6 counts as own where the machine has none */
        if (!is_allowed(public[i], "") && !strchr(public[i], ':'))
            fail_msg("%s is not allowed", public[i]);
}

static void lets_configured_networks_through(void **state) {
    (void)state;
    assert_true(is_allowed("10.1.2.3", "10.1.0.0/16"));
    assert_true(is_allowed("::ffff:10.1.2.3", "10.1.0.0/16"));
    assert_true(is_allowed("64:ff9b::10.1.2.3", "192.168.0.0/16, 10.1.0.0/16"));
    assert_false(is_allowed("10.2.2.3", "10.1.0.0/16"));
    assert_true(is_allowed("10.1.2.3", "10.0.0.0/15"));
    assert_false(is_allowed("10.2.0.0", "10.0.0.0/15"));
    assert_true(is_allowed("127.0.0.1", "127.0.0.1/32"));
    assert_false(is_allowed("127.0.0.2", "127.0.0.1/32"));
    assert_true(is_allowed("::1", "::1/128"));
    assert_false(is_allowed("::1", "127.0.0.0/8"));
    assert_true(is_allowed("fd12::1", "fd00::/8"));
    assert_true(is_allowed("192.168.7.7", "0.0.0.0/0"));
    assert_false(is_allowed("fd12::1", "0.0.0.0/0"));
}

/* Whatever addresses this machine has, none of them is to be reached, public or not. */
static void keeps_away_from_this_machine(void **state) {
    (void)state;
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(443), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    assert_true(qg_address_is_own((const struct sockaddr *)&address));
    address.sin_addr.s_addr = htonl(0x08080808);
    assert_false(qg_address_is_own((const struct sockaddr *)&address));
    struct ifaddrs *all, *each;
    assert_int_equal(getifaddrs(&all), 0);
    for (each = all; each; each = each->ifa_next)
        if (each->ifa_addr && (each->ifa_addr->sa_family == AF_INET || each->ifa_addr->sa_family == AF_INET6))
            assert_true(qg_address_is_own(each->ifa_addr) && !qg_address_is_allowed(each->ifa_addr, ""));
    freeifaddrs(all);
    const struct sockaddr other = {.sa_family = AF_UNIX};
    assert_false(qg_address_is_allowed(&other, "0.0.0.0/0 ::/0"));
}

static void takes_lists_of_networks_only(void **state) {
    (void)state;
    static const char *const wrong[] = {"10.0.0.0",    "10.0.0.0/",   "10.0.0.0/33", "10.0.0/8",   "::1/129",
                                        "localhost/8", "10.0.0.0/-1", "10.0.0.0/8x", "1.2.3.4/8 x"};
    assert_true(qg_networks_is_list(""));
    assert_true(qg_networks_is_list(" 10.0.0.0/8,fd00::/8 0.0.0.0/0 ::/0 "));
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (qg_networks_is_list(wrong[i]))
            fail_msg("%s was taken", wrong[i]);
}

static void takes_lists_of_rules_only(void **state) {
    (void)state;
    static const char *const right[] = {"", "https://a.example",
                                        "http://a.example:8080/x https://*.b.example, https://[2001:db8::1]/"};
    static const char *const wrong[] = {"a.example",
                                        "*",
                                        "https://*",
                                        "ftp://a.example",
                                        "https://a.example?x",
                                        "https://u@a.example",
                                        "https://a.*.example",
                                        "https://a.example#f",
                                        "https://"};
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++)
        if (!qg_url_rules_is_list(right[i]))
            fail_msg("%s was not taken", right[i]);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (qg_url_rules_is_list(wrong[i]))
            fail_msg("%s was taken", wrong[i]);
}

static const char rules[] =
    "https://plm.example.com/hooks https://*.tools.example.com http://127.0.0.1:9000 http://8.8.8.8";

static void judges_urls(void **state) {
    (void)state;
    static const char *const right[] = {
        "https://plm.example.com/hooks",           "https://plm.example.com:443/hooks/a?b=c",
        "https://PLM.example.com/hooks/",          "https://a.tools.example.com/",
        "https://a.b.tools.example.com/any/where", "http://8.8.8.8/x",
        "https://plm.example.com/hooks/a/../b"};
    static const struct {
        const char *url, *words;
    } wrong[] = {
        {"", "not a URL"},
        {"plm.example.com/hooks", "not a URL"},
        {"https:///hooks", "webhook-allow"},
        {"ftp://plm.example.com/hooks", "http or https"},
        {"file:///etc/passwd", "http or https"},
        {"gopher://plm.example.com/hooks", "http or https"},
        {"https://u:p@plm.example.com/hooks", "without a user"},
        {"https://plm.example.com@evil.example/hooks", "without a user"},
        {"https://plm.example.com/hooks#x", "fragment"},
        {"http://plm.example.com/hooks", "webhook-allow"},
        {"https://plm.example.com:8443/hooks", "webhook-allow"},
        {"https://plm.example.com/", "webhook-allow"},
        {"https://plm.example.com/hooksx", "webhook-allow"},
        {"https://plm.example.com/hooks/../admin", "webhook-allow"},
        {"https://plm.example.com/hooks/%2e%2e/admin", "escaped"},
        {"https://plm.example.com/hooks/..%2Fadmin", "escaped"},
        {"https://plm.example.com/hooks\\..\\admin", "escaped"},
        {"https://plm.example.com.evil.example/hooks", "webhook-allow"},
        {"https://tools.example.com/", "webhook-allow"},
        {"https://eviltools.example.com/", "webhook-allow"},
        {"https://plm.example.com./hooks", "webhook-allow"},
        /* this machine, as it can be written */
        {"http://127.0.0.1:9000/", "webhook-networks"},
        {"http://2130706433:9000/", "webhook-networks"},
        {"http://0x7f000001:9000/", "webhook-networks"},
        {"http://0177.0.0.1:9000/", "webhook-networks"},
        {"http://127.1:9000/", "webhook-networks"},
        {"http://[::ffff:127.0.0.1]:9000/", "webhook-allow"},
    };
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++)
        if (qg_url_refusal(right[i], rules, ""))
            fail_msg("%s: %s", right[i], qg_url_refusal(right[i], rules, ""));
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const char *words = qg_url_refusal(wrong[i].url, rules, "");
        if (!words || !strstr(words, wrong[i].words))
            fail_msg("%s: %s", wrong[i].url, words ? words : "allowed");
    }
    assert_null(qg_url_refusal("http://2130706433:9000/", rules, "127.0.0.0/8"));
    assert_non_null(qg_url_refusal("https://plm.example.com/hooks", "", ""));
}

/* Addresses that a rule names are judged all the same. */
static void rules_do_not_open_networks(void **state) {
    (void)state;
    static const char *const urls[] = {"http://0.0.0.0/",        "http://[::]/",
                                       "http://[::1]/",          "http://[::ffff:127.0.0.1]/",
                                       "http://[fe80::1]/",      "http://169.254.169.254/",
                                       "http://[::ffff:7f00:1]/"};
    for (size_t i = 0; i < sizeof urls / sizeof urls[0]; i++) {
        assert_true(qg_url_rules_is_list(urls[i]));
        const char *words = qg_url_refusal(urls[i], urls[i], "");
        if (!words || !strstr(words, "webhook-networks"))
            fail_msg("%s: %s", urls[i], words ? words : "allowed");
    }
    char url[QG_URL_MAX + 64] = "https://plm.example.com/hooks/";
    memset(url + strlen(url), 'a', QG_URL_MAX);
    url[QG_URL_MAX + 1] = '\0';
    assert_non_null(qg_url_refusal(url, rules, ""));
    url[QG_URL_MAX] = '\0';
    assert_null(qg_url_refusal(url, rules, ""));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(knows_special_addresses),      cmocka_unit_test(lets_configured_networks_through),
        cmocka_unit_test(keeps_away_from_this_machine), cmocka_unit_test(takes_lists_of_networks_only),
        cmocka_unit_test(takes_lists_of_rules_only),    cmocka_unit_test(judges_urls),
        cmocka_unit_test(rules_do_not_open_networks),
    };
    return cmocka_run_group_tests_name("address", tests, NULL, NULL);
}
