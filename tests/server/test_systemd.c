/* The protocols of systemd, against a socket that plays systemd. */
#include "tests/server/support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/base/systemd.h"

static void tells_its_state(void **state) {
    (void)state;
    char folder[] = "/tmp/quietgeard-XXXXXX", got[32] = "";
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    assert_non_null(mkdtemp(folder));
    snprintf(address.sun_path, sizeof address.sun_path, "%s/notify", folder);
    int channel = socket(AF_UNIX, SOCK_DGRAM, 0);
    assert_int_equal(bind(channel, (struct sockaddr *)&address, sizeof address), 0);
    setenv("NOTIFY_SOCKET", address.sun_path, 1);
    qg_systemd_notify("READY=1");
    assert_int_equal(recv(channel, got, sizeof got - 1, MSG_DONTWAIT), 7);
    assert_string_equal(got, "READY=1");
    unsetenv("NOTIFY_SOCKET");
    qg_systemd_notify("STOPPING=1");
    assert_int_equal(recv(channel, got, sizeof got - 1, MSG_DONTWAIT), -1);
    close(channel);
    unlink(address.sun_path);
    rmdir(folder);
}

static void set(const char *process, const char *count) {
    setenv("LISTEN_PID", process, 1);
    setenv("LISTEN_FDS", count, 1);
}

static void takes_only_its_own_socket(void **state) {
    (void)state;
    char self[32];
    snprintf(self, sizeof self, "%ld", (long)getpid());
    unsetenv("LISTEN_PID");
    unsetenv("LISTEN_FDS");
    assert_int_equal(qg_systemd_socket(), -1);
    set("1", "1");
    assert_int_equal(qg_systemd_socket(), -1);
    set(self, "0");
    assert_int_equal(qg_systemd_socket(), -1);
    set(self, "1");
    assert_int_equal(qg_systemd_socket(), 3);
    set(self, "2");
    assert_int_equal(qg_systemd_socket(), -2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tells_its_state),
        cmocka_unit_test(takes_only_its_own_socket),
    };
    return cmocka_run_group_tests_name("systemd", tests, NULL, NULL);
}
