/* Settings from flags, file and environment: what wins, and what is refused with which words. */
#include "tests/server/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/base/machine.h"
#include "server/settings.h"

enum { ARGUMENTS_MAX = 12 };

/* One reading of settings. */
struct reading {
    struct qg_settings settings;
    struct qg_text message;
};

/* Reads the flags in a NULL-ended list. */
static enum qg_settings_action read_flags(struct reading *reading, const char *const *flags) {
    char *arguments[ARGUMENTS_MAX] = {(char *)"quietgeard"};
    int count = 1;
    while (flags[count - 1]) {
        arguments[count] = (char *)flags[count - 1];
        count++;
    }
    memset(reading, 0, sizeof *reading);
    return qg_settings_load(count, arguments, &reading->settings, &reading->message);
}

#define READ(reading, ...) read_flags(reading, (const char *const[]){__VA_ARGS__, NULL})

static void assert_says(const struct reading *reading, const char *words) {
    if (!reading->message.data || !strstr(reading->message.data, words))
        fail_msg("\"%s\" is not in \"%s\"", words, reading->message.data ? reading->message.data : "");
}

/* Writes a config file for a test; the caller removes it. */
static void write_file(char path[32], const char *text) {
    strcpy(path, "/tmp/quietgeard-XXXXXX");
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
    close(file);
}

static void has_defaults(void **state) {
    (void)state;
    struct reading reading;
    setenv("STATE_DIRECTORY", "/somewhere/state", 1);
    assert_int_equal(READ(&reading, "--config=/dev/null"), QG_SETTINGS_RUN);
    assert_string_equal(reading.settings.listen, "127.0.0.1:8080");
    assert_string_equal(reading.settings.state_dir, "/somewhere/state");
    assert_int_equal(reading.settings.job_count, 2);
    assert_int_equal(reading.settings.log.format, QG_LOG_AUTO);
    assert_int_equal(reading.settings.log.level, QG_LOG_INFO);
    assert_false(reading.settings.logs_requests);
    assert_int_equal(reading.settings.thread_count, sysconf(_SC_NPROCESSORS_ONLN));
    unsetenv("STATE_DIRECTORY");
}

static void flags_win_over_the_file(void **state) {
    (void)state;
    struct reading reading;
    char path[32];
    write_file(path, "log-format = json\nlog-level = debug\naccess-log = on\n# a comment\n\n  jobs = 5  "
                     "\nthreads=3\nlisten = [::1]:0\r\n");
    assert_int_equal(READ(&reading, "--config", path, "--jobs", "7", "--state-dir=/x"), QG_SETTINGS_RUN);
    assert_int_equal(reading.settings.job_count, 7);
    assert_int_equal(reading.settings.log.format, QG_LOG_JSON);
    assert_int_equal(reading.settings.log.level, QG_LOG_DEBUG);
    assert_true(reading.settings.logs_requests);
    assert_int_equal(reading.settings.thread_count, 3);
    assert_string_equal(reading.settings.listen, "[::1]:0");
    assert_string_equal(reading.settings.state_dir, "/x");
    unlink(path);
}

/* Half of the memory, among the jobs at a time; or what is said; 0 is any. */
static void shares_the_memory_among_the_jobs(void **state) {
    (void)state;
    struct reading reading;
    assert_int_equal(READ(&reading, "--config=/dev/null", "--jobs", "4", "--state-dir=/x"), QG_SETTINGS_RUN);
    const double share = qg_machine_memory() / 8 / 1e6;
    assert_true(fabs(reading.settings.max_job_memory_mb - share) <= 1);
    assert_int_equal(READ(&reading, "--config=/dev/null", "--max-job-memory=750", "--state-dir=/x"), QG_SETTINGS_RUN);
    assert_int_equal(reading.settings.max_job_memory_mb, 750);
    assert_int_equal(READ(&reading, "--config=/dev/null", "--max-job-memory=0", "--state-dir=/x"), QG_SETTINGS_RUN);
    assert_int_equal(reading.settings.max_job_memory_mb, 0);
}

static void names_every_fault_of_a_file(void **state) {
    (void)state;
    struct reading reading;
    char path[32];
    write_file(path, "jobs = 0\ncolor = red\njust words\nthreads = 4.5\nlog-level = info\n\nlog-level = debug\n");
    assert_int_equal(READ(&reading, "--config", path), QG_SETTINGS_WRONG);
    assert_says(&reading, ":1: jobs: found \"0\", allowed is a whole number from 1 to 64");
    assert_says(&reading, ":2: unknown setting \"color\"; allowed are listen, port-file");
    assert_says(&reading, ":3: \"just words\" is not of the form");
    assert_says(&reading, ":4: threads: found \"4.5\"");
    assert_says(&reading, ":7: log-level: stands in line 5 already");
    assert_says(&reading, path);
    qg_text_finish(&reading.message);
    unlink(path);
    assert_int_equal(READ(&reading, "--config", path), QG_SETTINGS_WRONG);
    assert_says(&reading, "No such file");
    qg_text_finish(&reading.message);
}

static void refuses_bad_flags(void **state) {
    (void)state;
    static const struct {
        const char *flag, *value, *words;
    } cases[] = {
        {"--colour", "red", "--colour: unknown flag"},
        {"stray", NULL, "stray: unknown flag"},
        {"-j", "3", "-j: unknown flag"},
        {"--", NULL, "--: unknown flag"},
        {"--jobs", NULL, "--jobs: a value is missing"},
        {"--jobs", "", "--jobs: found \"\""},
        {"--jobs", "65", "from 1 to 64"},
        {"--jobs", "2x", "found \"2x\""},
        {"--threads", "-1", "from 0 to 1024"},
        {"--threads", "99999999999999999999", "from 0 to 1024"},
        {"--listen", "8080", "ADDRESS:PORT"},
        {"--listen", "127.0.0.1", "ADDRESS:PORT"},
        {"--listen", ":80", "ADDRESS:PORT"},
        {"--listen", "::1:80", "ADDRESS:PORT"},
        {"--listen", "127.0.0.1:65536", "ADDRESS:PORT"},
        {"--listen", "127.0.0.1:http", "ADDRESS:PORT"},
        {"--require-tokens", "never", "auto or always"},
        {"--log-format", "xml", "found \"xml\", allowed is auto, text or json"},
        {"--log-level", "loud", "allowed is error, warning, notice, info or debug"},
        {"--log-level", "3", "allowed is error, warning, notice, info or debug"},
        {"--access-log", "yes", "allowed is on or off"},
        {"--token-rate", "-1", "from 0 to 100000"},
        {"--token-jobs", "many", "from 0 to 100000"},
        {"--keep-log-days", "0", "from 1 to 36500"},
        {"--keep-jobs-days", "-1", "from 0 to 36500"},
        {"--keep-evaluations-days", "36501", "from 0 to 36500"},
        {"--keep-jobs", "1e3", "from 0 to 1000000000"},
        {"--keep-megabytes", "", "from 0 to 1000000000"},
        {"--max-job-cost", "a week", "from 0 to 1000000000"},
        {"--max-job-memory", "half", "auto, or a whole number from 0 to 1000000000"},
        {"--webhook-allow", "plm.example.com", "a list of URLs"},
        {"--webhook-networks", "10.0.0.0", "a list of networks"},
        {"--webhook-retry", "0", "from 1 to 3600"},
        {"--cors-origins", "*", "a list of origins"},
        {"--allowed-hosts", "https://gears.example", "with blanks or commas between them"},
        {"--trusted-proxies", "proxy.example.com", "a list of addresses and networks"},
        {"--client-streams", "1201", "from 0 to 1200"},
        {"--tls-certificate", "/dev/null", "one is given without the other"},
        {"--tls-key", "/dev/null", "one is given without the other"},
        {"--state-dir=", NULL, "the name of a directory"},
        {"--help=yes", NULL, "unknown flag"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct reading reading;
        assert_int_equal(READ(&reading, "--config=/dev/null", cases[i].flag, cases[i].value), QG_SETTINGS_WRONG);
        assert_says(&reading, cases[i].words);
        qg_text_finish(&reading.message);
    }
}

static void checks_certificate_and_key(void **state) {
    (void)state;
    struct reading reading;
    char path[32];
    write_file(path, "-----BEGIN CERTIFICATE-----\nnonsense\n");
    assert_int_equal(
        READ(&reading, "--check-config", "--config=/dev/null", "--tls-certificate", path, "--tls-key", path),
        QG_SETTINGS_WRONG);
    assert_says(&reading, "are not a certificate and its key in PEM");
    qg_text_finish(&reading.message);
    assert_int_equal(READ(&reading, "--config=/dev/null", "--tls-certificate=/none/at/all", "--tls-key", path),
                     QG_SETTINGS_WRONG);
    assert_says(&reading, "/none/at/all: No such file");
    qg_text_finish(&reading.message);
    unlink(path);
}

static void answers_questions(void **state) {
    (void)state;
    struct reading reading;
    assert_int_equal(READ(&reading, "--help"), QG_SETTINGS_HELP);
    assert_says(&reading, "--state-dir DIR");
    assert_says(&reading, "(default: 127.0.0.1:8080)");
    assert_says(&reading, "error, warning, notice, info or debug");
    qg_text_finish(&reading.message);
    assert_int_equal(READ(&reading, "--version"), QG_SETTINGS_VERSION);
    assert_says(&reading, "quietgeard ");
    qg_text_finish(&reading.message);
    assert_int_equal(READ(&reading, "--check-config", "--config=/dev/null", "--state-dir=/x"), QG_SETTINGS_CHECKED);
    assert_int_equal(READ(&reading, "--check-config", "--config=/dev/null", "--jobs=0"), QG_SETTINGS_WRONG);
    qg_text_finish(&reading.message);
}

static void the_example_file_is_right(void **state) {
    (void)state;
    struct reading reading;
    char path[1024];
    const char *source = getenv("QG_SOURCE");
    snprintf(path, sizeof path, "%s/server/quietgeard.conf", source ? source : ".");
    assert_int_equal(READ(&reading, "--check-config", "--config", path, "--state-dir=/x"), QG_SETTINGS_CHECKED);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(has_defaults),
        cmocka_unit_test(flags_win_over_the_file),
        cmocka_unit_test(shares_the_memory_among_the_jobs),
        cmocka_unit_test(names_every_fault_of_a_file),
        cmocka_unit_test(refuses_bad_flags),
        cmocka_unit_test(checks_certificate_and_key),
        cmocka_unit_test(answers_questions),
        cmocka_unit_test(the_example_file_is_right),
    };
    return cmocka_run_group_tests_name("settings", tests, NULL, NULL);
}
