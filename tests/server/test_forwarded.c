/* Who is behind trusted proxies, whatever clients write into X-Forwarded-For. */
#include "tests/server/support.h"

#include <netdb.h>
#include <string.h>
#include <sys/un.h>

#include "server/base/address.h"
#include "server/http/forwarded.h"

struct hop {
    const char *peer, *field, *proxies, *client;
};

static void check(const struct hop *hop) {
    struct sockaddr_storage peer, client, expected;
    assert_true(qg_address_read(hop->peer, &peer));
    assert_true(qg_address_read(hop->client, &expected));
    qg_forwarded_client((const struct sockaddr *)&peer, hop->field, hop->proxies, &client);
    if (memcmp(&client, &expected, sizeof client) != 0)
        fail_msg("%s behind %s by \"%s\" is not %s", hop->field ? hop->field : "nothing", hop->peer, hop->proxies,
                 hop->client);
}

static void believes_proxies_and_nobody_else(void **state) {
    (void)state;
    static const char inside[] = "127.0.0.1 10.1.0.0/16,2001:db8::/32";
    static const struct hop hops[] = {
        /* nobody is trusted, or the peer is not */
        {"127.0.0.1", "192.0.2.7", "", "127.0.0.1"},
        {"192.0.2.1", "192.0.2.7", inside, "192.0.2.1"},
        {"127.0.0.2", "192.0.2.7", inside, "127.0.0.2"},
        /* a proxy that says nothing, something, or is the client itself */
        {"127.0.0.1", NULL, inside, "127.0.0.1"},
        {"127.0.0.1", "", inside, "127.0.0.1"},
        {"127.0.0.1", "192.0.2.7", inside, "192.0.2.7"},
        {"127.0.0.1", "2001:db9::7", inside, "2001:db9::7"},
        {"2001:db8::1", " \t192.0.2.7\t ", inside, "192.0.2.7"},
        /* what the client wrote itself stands left of what the proxy saw */
        {"127.0.0.1", "10.1.2.3, 192.0.2.7", inside, "192.0.2.7"},
        {"127.0.0.1", "127.0.0.1,127.0.0.1,192.0.2.7", inside, "192.0.2.7"},
        {"127.0.0.1", "198.51.100.1,192.0.2.7", inside, "192.0.2.7"},
        {"127.0.0.1", "garbage, 192.0.2.7", inside, "192.0.2.7"},
        /* proxies behind proxies */
        {"127.0.0.1", "192.0.2.7, 10.1.2.3", inside, "192.0.2.7"},
        {"127.0.0.1", "198.51.100.1, 192.0.2.7, 10.1.2.3, 2001:db8::5", inside, "192.0.2.7"},
        {"127.0.0.1", "10.1.2.4, 10.1.2.3", inside, "10.1.2.4"},
        {"127.0.0.1", ", 10.1.2.3", inside, "10.1.2.3"},
        /* ports */
        {"127.0.0.1", "192.0.2.7:4711", inside, "192.0.2.7"},
        {"127.0.0.1", "[2001:db9::7]", inside, "2001:db9::7"},
        {"127.0.0.1", "[2001:db9::7]:4711", inside, "2001:db9::7"},
        /* what is no address ends it: the host that said so is all that is known */
        {"127.0.0.1", "unknown", inside, "127.0.0.1"},
        {"127.0.0.1", "192.0.2.7, unknown", inside, "127.0.0.1"},
        {"127.0.0.1", "192.0.2.7, unknown, 10.1.2.3", inside, "10.1.2.3"},
        {"127.0.0.1", "192.0.2.7,", inside, "127.0.0.1"},
        {"127.0.0.1", "localhost", inside, "127.0.0.1"},
        {"127.0.0.1", "[2001:db9::7", inside, "127.0.0.1"},
        {"127.0.0.1", "192.0.2.7 192.0.2.8", inside, "127.0.0.1"},
        {"127.0.0.1", "0300.0.0.2.7", inside, "127.0.0.1"},
        {"127.0.0.1", "192.0.2.7/32", inside, "127.0.0.1"},
        {"127.0.0.1", "1111111111111111111111111111111111111111111111111111111111111111111111192.0.2.7", inside,
         "127.0.0.1"},
        /* an address in another dress */
        {"::ffff:127.0.0.1", "192.0.2.7", inside, "192.0.2.7"},
        {"127.0.0.1", "192.0.2.7, ::ffff:10.1.2.3", inside, "192.0.2.7"},
        {"64:ff9b::7f00:1", "192.0.2.7", inside, "64:ff9b::7f00:1"},
        /* all the world */
        {"198.51.100.1", "192.0.2.7", "0.0.0.0/0", "192.0.2.7"},
        {"2001:db8::1", "192.0.2.7", "0.0.0.0/0", "2001:db8::1"},
    };
    for (size_t i = 0; i < sizeof hops / sizeof *hops; i++)
        check(&hops[i]);
}

static void a_socket_of_the_file_system_is_a_place_too(void **state) {
    (void)state;
    struct sockaddr_storage client;
    char name[64];
    struct sockaddr_un peer = {.sun_family = AF_UNIX};
    qg_forwarded_client((const struct sockaddr *)&peer, "192.0.2.7", "127.0.0.1 ::/0", &client);
    assert_int_equal(client.ss_family, AF_UNIX);
    qg_forwarded_client((const struct sockaddr *)&peer, "192.0.2.7", "127.0.0.1 unix", &client);
    assert_int_equal(getnameinfo((const struct sockaddr *)&client, sizeof(struct sockaddr_in), name, sizeof name, NULL,
                                 0, NI_NUMERICHOST),
                     0);
    assert_string_equal(name, "192.0.2.7");
}

static void lists_name_networks_addresses_and_unix(void **state) {
    (void)state;
    static const char *const right[] = {"",          "127.0.0.1",         "10.0.0.0/8 10.1.2.3", "fd00::/8,::1",
                                        "0.0.0.0/0", "unix, 192.0.2.7/32"},
                             *const wrong[] = {"localhost",   "10.0.0.0/33", "10.0.0/8",          "10.0.0.0/",
                                               "10.0.0.0/8x", "UNIX",        "10.0.0.1:80",       "[::1]",
                                               "*",           "::/129",      "127.0.0.1;10.0.0.1"};
    for (size_t i = 0; i < sizeof right / sizeof *right; i++)
        assert_true(qg_addresses_is_list(right[i]));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (qg_addresses_is_list(wrong[i]))
            fail_msg("%s is taken for a list", wrong[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(believes_proxies_and_nobody_else),
        cmocka_unit_test(a_socket_of_the_file_system_is_a_place_too),
        cmocka_unit_test(lists_name_networks_addresses_and_unix),
    };
    return cmocka_run_group_tests_name("forwarded", tests, NULL, NULL);
}
