/* The log, against a stderr and a journal that the test reads: formats, what cannot be forged, and what happens when nobody
 * takes it. */
#include "tests/server/support.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/log_entry.h"

enum { ROOM = 1 << 17 };

/* What stands in for the outside. */
struct outside {
    int real_stderr;
    int pipe[2]; /* stderr's other end */
    char folder[32], socket[64];
    int journal; /* -1: nobody listens */
    char text[ROOM];
};

static struct outside *outside_of(void **state) {
    return *state;
}

static int come_in(void **state) {
    struct outside *outside = calloc(1, sizeof *outside);
    *state = outside;
    outside->journal = -1;
    outside->real_stderr = dup(STDERR_FILENO);
    strcpy(outside->folder, "/tmp/quietgeard-XXXXXX");
    if (pipe2(outside->pipe, O_CLOEXEC) != 0 || !mkdtemp(outside->folder))
        return -1;
    snprintf(outside->socket, sizeof outside->socket, "%s/journal", outside->folder);
    fcntl(outside->pipe[0], F_SETFL, O_NONBLOCK);
    return dup2(outside->pipe[1], STDERR_FILENO) == STDERR_FILENO ? 0 : -1;
}

static int go_out(void **state) {
    struct outside *outside = *state;
    qg_log_close();
    dup2(outside->real_stderr, STDERR_FILENO);
    close(outside->real_stderr);
    close(outside->pipe[0]);
    close(outside->pipe[1]);
    if (outside->journal >= 0)
        close(outside->journal);
    unlink(outside->socket);
    rmdir(outside->folder);
    unsetenv("JOURNAL_STREAM");
    free(outside);
    return 0;
}

/* Has a journal listen. */
static void listen_as_journal(struct outside *outside) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    strcpy(address.sun_path, outside->socket);
    outside->journal = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(outside->journal, (struct sockaddr *)&address, sizeof address), 0);
}

static void open_log(struct outside *outside, enum qg_log_format format) {
    qg_log_open(&(struct qg_log_options){.format = format, .level = QG_LOG_INFO, .journal_socket = outside->socket});
}

/* Makes stderr the journal's, as systemd says it. */
static void claim_journal(void) {
    struct stat status;
    char stream[64];
    assert_int_equal(fstat(STDERR_FILENO, &status), 0);
    snprintf(stream, sizeof stream, "%ju:%ju", (uintmax_t)status.st_dev, (uintmax_t)status.st_ino);
    setenv("JOURNAL_STREAM", stream, 1);
}

/* What has come to stderr since it was last read. */
static const char *read_stderr(struct outside *outside) {
    size_t length = 0;
    ssize_t got;
    while ((got = read(outside->pipe[0], outside->text + length, ROOM - 1 - length)) > 0)
        length += (size_t)got;
    outside->text[length] = '\0';
    return outside->text;
}

/* The next entry that has come to the journal; "" when there is none. */
static const char *read_journal(struct outside *outside) {
    ssize_t length = recv(outside->journal, outside->text, ROOM - 1, MSG_DONTWAIT);
    outside->text[length > 0 ? length : 0] = '\0';
    return outside->text;
}

static size_t count(const char *text, char wanted) {
    size_t found = 0;
    for (; *text; text++)
        found += *text == wanted;
    return found;
}

/* Asserts that an entry has the line. */
static void assert_line(const char *entry, const char *line) {
    size_t length = strlen(line);
    for (const char *at = entry; *at; at += strcspn(at, "\n") + 1)
        if (strncmp(at, line, length) == 0 && at[length] == '\n')
            return;
    fail_msg("no line \"%s\" in:\n%s", line, entry);
}

/* --- formats --- */

static void words_have_time_and_level(void **state) {
    struct outside *outside = outside_of(state);
    int year;
    char level[16], words[64];
    open_log(outside, QG_LOG_AUTO);
    qg_log(QG_LOG_NOTICE, "gear %d of %s\n", 2, "a pair");
    const char *line = read_stderr(outside);
    assert_int_equal(sscanf(line, "%4d-%*2d-%*2dT%*2d:%*2d:%*2d.%*3dZ %15[a-z]: %63[^\n]", &year, level, words), 3);
    assert_true(year >= 2024);
    assert_string_equal(level, "notice");
    assert_string_equal(words, "gear 2 of a pair");
    assert_int_equal(count(line, '\n'), 1);
}

/* Writes an event with all fields; returns the line of the source on which it is written. */
static int write_full_event(void) {
    const int64_t duration = 0, bytes = 5000000000;
    int line = __LINE__ + 1;
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_WARNING,
                                        .event = QG_EVENT_JOB_FAILED,
                                        .job = "01m8",
                                        .attempt = 3,
                                        .state = "failed",
                                        .token = "986019fa9cc1",
                                        .remote = "::1",
                                        .action = "job.submit",
                                        .subject = "01m9",
                                        .webhook = "wh_1",
                                        .delivery = "msg_1",
                                        .method = "GET",
                                        .route = "/v1/jobs/{}",
                                        .status = 503,
                                        .duration_ms = &duration,
                                        .bytes = &bytes},
                 "job \"%s\": C:\\", "01m8");
    return line;
}

static void json_has_fields(void **state) {
    struct outside *outside = outside_of(state);
    open_log(outside, QG_LOG_JSON);
    write_full_event();
    cJSON *entry = cJSON_Parse(read_stderr(outside));
    assert_non_null(entry);
    assert_int_equal(count(outside->text, '\n'), 1);
    static const char *const expected[][2] = {
        {"level", "warning"},     {"message", "job \"01m8\": C:\\"},
        {"event", "job.failed"},  {"job_id", "01m8"},
        {"state", "failed"},      {"token_id", "986019fa9cc1"},
        {"remote", "::1"},        {"action", "job.submit"},
        {"subject", "01m9"},      {"webhook_id", "wh_1"},
        {"delivery_id", "msg_1"}, {"method", "GET"},
        {"route", "/v1/jobs/{}"}, {"code_func", "write_full_event"},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(entry, expected[i][0])), expected[i][1]);
    assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(entry, "attempt")) == 3);
    assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(entry, "status")) == 503);
    assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(entry, "duration_ms")) == 0);
    assert_true(cJSON_GetNumberValue(cJSON_GetObjectItem(entry, "bytes")) == 5e9);
    cJSON_Delete(entry);
    qg_log(QG_LOG_INFO, "plain");
    entry = cJSON_Parse(read_stderr(outside));
    assert_int_equal(cJSON_GetArraySize(entry), 6); /* time, level, message, three of the place */
    cJSON_Delete(entry);
}

static void the_journal_gets_fields(void **state) {
    struct outside *outside = outside_of(state);
    char place[32];
    listen_as_journal(outside);
    claim_journal();
    open_log(outside, QG_LOG_AUTO);
    snprintf(place, sizeof place, "CODE_LINE=%d", write_full_event());
    const char *entry = read_journal(outside);
    static const char *const expected[] = {"MESSAGE=job \"01m8\": C:\\",
                                           "PRIORITY=4",
                                           "SYSLOG_IDENTIFIER=quietgeard",
                                           "QG_EVENT=job.failed",
                                           "QG_JOB_ID=01m8",
                                           "QG_ATTEMPT=3",
                                           "QG_STATE=failed",
                                           "QG_TOKEN_ID=986019fa9cc1",
                                           "QG_REMOTE=::1",
                                           "QG_ACTION=job.submit",
                                           "QG_SUBJECT=01m9",
                                           "QG_WEBHOOK_ID=wh_1",
                                           "QG_DELIVERY_ID=msg_1",
                                           "QG_METHOD=GET",
                                           "QG_ROUTE=/v1/jobs/{}",
                                           "QG_STATUS=503",
                                           "QG_DURATION_MS=0",
                                           "QG_BYTES=5000000000",
                                           "CODE_FUNC=write_full_event"};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        assert_line(entry, expected[i]);
    assert_line(entry, place);
    snprintf(place, sizeof place, "MESSAGE_ID=%s", qg_log_event_id(QG_EVENT_JOB_FAILED));
    assert_int_equal(count(entry, '\n'),
                     sizeof expected / sizeof *expected + 3); /* these, CODE_FILE, and what follows */
    assert_non_null(strstr(entry, place));
    assert_string_equal(read_stderr(outside), "");
}

static void only_the_journal_is_taken_for_the_journal(void **state) {
    struct outside *outside = outside_of(state);
    listen_as_journal(outside);
    setenv("JOURNAL_STREAM", "1:2", 1);
    open_log(outside, QG_LOG_AUTO);
    qg_log(QG_LOG_INFO, "a terminal's");
    assert_string_equal(read_journal(outside), "");
    assert_non_null(strstr(read_stderr(outside), " info: a terminal's\n"));
    qg_log_close();
    claim_journal();
    open_log(outside, QG_LOG_TEXT);
    qg_log(QG_LOG_INFO, "as text");
    assert_string_equal(read_journal(outside), "");
    assert_string_equal(read_stderr(outside), "<6>as text\n");
    qg_log_close();
    open_log(outside, QG_LOG_JSON);
    qg_log(QG_LOG_ERROR, "as JSON");
    assert_int_equal(strncmp(read_stderr(outside), "<3>{\"time\":\"", 12), 0);
}

static void closed_descriptors_are_taken(void **state) {
    struct outside *outside = outside_of(state);
    int input = dup(STDIN_FILENO);
    close(STDIN_FILENO);
    open_log(outside, QG_LOG_TEXT);
    assert_int_equal(fcntl(STDIN_FILENO, F_GETFD), 0);
    dup2(input, STDIN_FILENO);
    close(input);
}

static void levels_are_kept_out(void **state) {
    struct outside *outside = outside_of(state);
    enum qg_priority level;
    assert_true(qg_log_level_read("warning", &level));
    qg_log_open(&(struct qg_log_options){.level = level});
    qg_log(QG_LOG_NOTICE, "no");
    qg_log(QG_LOG_WARNING, "yes");
    qg_log(QG_LOG_ERROR, "yes");
    assert_int_equal(count(read_stderr(outside), '\n'), 2);
    assert_null(strstr(outside->text, "no\n"));
    assert_false(qg_log_level_read("loud", &level));
    assert_false(qg_log_level_read("emergency", &level));
}

static void events_have_names_of_their_own(void **state) {
    (void)state;
    for (int i = QG_EVENT_NONE + 1; i < QG_EVENT_COUNT; i++) {
        const char *id = qg_log_event_id((enum qg_event)i);
        assert_int_equal(strspn(id, "0123456789abcdef"), 32);
        assert_int_equal(strlen(id), 32);
        for (int j = QG_EVENT_NONE; j < i; j++) {
            assert_string_not_equal(id, qg_log_event_id((enum qg_event)j));
            assert_string_not_equal(qg_log_event_name((enum qg_event)i), qg_log_event_name((enum qg_event)j));
        }
    }
}

/* --- what strangers send --- */

static void texts_are_cleaned(void **state) {
    (void)state;
    static const struct {
        const char *text, *clean;
    } cases[] = {
        {"plain, \xc3\xbc \xe2\x82\xac \xf0\x9f\x98\x80", "plain, \xc3\xbc \xe2\x82\xac \xf0\x9f\x98\x80"},
        {"a\nPRIORITY=0\n", "a?PRIORITY=0"},
        {"a\r\nb\tc\x7f\x1b[2J", "a??b?c??[2J"},
        {"\xc2\x9b"
         "2J",
         "?2J"}, /* CSI in one character */
        {"a\xe2\x80\xa8"
         "b\xe2\x80\xa9"
         "c",
         "a?b?c"}, /* line and paragraph separator */
        {"\xe2\x80\xae"
         "gnp\xe2\x81\xa9",
         "?gnp?"},                              /* writing from right to left */
        {"\xff\xfe\xc0\xaf\xe2\x82", "??????"}, /* no UTF-8 */
        {"ends\n\r\n", "ends"},
        {"\n", ""},
    };
    char clean[64];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        qg_log_clean(clean, sizeof clean, cases[i].text);
        assert_string_equal(clean, cases[i].clean);
    }
    qg_log_clean(clean, 5, "abc\xe2\x82\xac"); /* no half of a character */
    assert_string_equal(clean, "abc");
}

#define EVIL "x\nMESSAGE=forged\r\n<0>forged\",\"level\":\"\\\xe2\x80\xa8\x1b[2J\xff"

static void write_evil_event(void) {
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO,
                                        .event = QG_EVENT_AUDIT,
                                        .job = EVIL,
                                        .state = EVIL,
                                        .token = EVIL,
                                        .remote = EVIL,
                                        .action = EVIL,
                                        .webhook = EVIL,
                                        .delivery = EVIL,
                                        .method = EVIL,
                                        .route = EVIL},
                 "%s", EVIL);
}

static void nobody_forges_a_line(void **state) {
    struct outside *outside = outside_of(state);
    listen_as_journal(outside);
    open_log(outside, QG_LOG_TEXT);
    write_evil_event();
    assert_int_equal(count(read_stderr(outside), '\n'), 1);
    open_log(outside, QG_LOG_JSON);
    write_evil_event();
    cJSON *entry = cJSON_Parse(read_stderr(outside));
    assert_int_equal(count(outside->text, '\n'), 1);
    assert_int_equal(cJSON_GetArraySize(entry), 4 + 9 + 3);
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(entry, "level")), "info");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(entry, "job_id")),
                        "x?MESSAGE=forged?"
                        "?<0>forged\",\"level\":\"\\??[2J?");
    cJSON_Delete(entry);
    qg_log_close();
    claim_journal();
    open_log(outside, QG_LOG_AUTO);
    write_evil_event();
    const char *lines = read_journal(outside);
    assert_int_equal(count(lines, '\n'), 3 + 2 + 9 + 3);
    assert_null(strstr(lines, "\nMESSAGE=forged"));
    assert_int_equal(count(lines, '\x1b'), 0);
}

static void the_largest_entry_fits(void **state) {
    struct outside *outside = outside_of(state);
    static char quotes[3 * QG_LOG_MESSAGE_ROOM];
    const int64_t least = INT64_MIN;
    memset(quotes, '"', sizeof quotes - 1);
    const struct qg_log_event event = {.priority = QG_LOG_WARNING,
                                       .event = QG_EVENT_DATABASE_RECOVERED,
                                       .job = quotes,
                                       .state = quotes,
                                       .token = quotes,
                                       .remote = quotes,
                                       .action = quotes,
                                       .webhook = quotes,
                                       .delivery = quotes,
                                       .method = quotes,
                                       .route = quotes,
                                       .attempt = least,
                                       .status = least,
                                       .duration_ms = &least,
                                       .bytes = &least};
    char name[201] = "";
    memset(name, 'n', sizeof name - 1);
    const struct qg_place place = {.file = name, .line = 1000000, .function = name};
    open_log(outside, QG_LOG_JSON);
    qg_log_write(&place, &event, "%s", quotes);
    const char *line = read_stderr(outside);
    assert_true(strlen(line) > 3500 && strlen(line) < QG_LOG_LINE_ROOM);
    cJSON *entry = cJSON_Parse(line);
    assert_non_null(entry);
    assert_int_equal(strlen(cJSON_GetStringValue(cJSON_GetObjectItem(entry, "message"))), QG_LOG_MESSAGE_ROOM - 1);
    assert_int_equal(strlen(cJSON_GetStringValue(cJSON_GetObjectItem(entry, "job_id"))), QG_LOG_FIELD_ROOM - 1);
    cJSON_Delete(entry);
}

/* --- when nobody takes it --- */

static void a_journal_that_is_gone_is_passed_over(void **state) {
    struct outside *outside = outside_of(state);
    claim_journal();
    open_log(outside, QG_LOG_AUTO); /* nobody listens yet */
    qg_log(QG_LOG_WARNING, "first");
    assert_string_equal(read_stderr(outside), "<4>first\n");
    listen_as_journal(outside);
    qg_log(QG_LOG_WARNING, "second");
    assert_line(read_journal(outside), "MESSAGE=second");
    assert_string_equal(read_stderr(outside), "");
    close(outside->journal); /* its socket refuses from now on */
    qg_log(QG_LOG_WARNING, "third");
    assert_string_equal(read_stderr(outside), "<4>third\n");
    unlink(outside->socket);
    listen_as_journal(outside);
    qg_log(QG_LOG_WARNING, "fourth");
    assert_line(read_journal(outside), "MESSAGE=fourth");
}

/* How often this thread has gone to sleep: who waits for a reader does, who waits for the processor does not. */
static long sleeps(void) {
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_THREAD, &usage), 0);
    return usage.ru_nvcsw;
}

static void a_journal_that_does_not_read_is_not_waited_for(void **state) {
    enum { MESSAGES = 600 }; /* a pipe holds as many */
    struct outside *outside = outside_of(state);
    listen_as_journal(outside);
    claim_journal();
    open_log(outside, QG_LOG_AUTO);
    const long begin = sleeps();
    for (int i = 0; i < MESSAGES; i++)
        qg_log(QG_LOG_INFO, "message %d", i);
    assert_in_range(sleeps() - begin, 0, 20);
    size_t lines = count(read_stderr(outside), '\n'), entries = 0;
    while (*read_journal(outside))
        entries++;
    assert_true(lines > 0 && entries > 0);
    assert_int_equal(lines + entries, MESSAGES);
    qg_log(QG_LOG_INFO, "and again");
    assert_line(read_journal(outside), "MESSAGE=and again");
}

static void a_stderr_that_is_full_costs_no_time_and_is_told(void **state) {
    enum { MESSAGES = 5000 };
    struct outside *outside = outside_of(state);
    open_log(outside, QG_LOG_TEXT);
    const long begin = sleeps();
    for (int i = 0; i < MESSAGES; i++)
        qg_log(QG_LOG_INFO, "message %d", i);
    assert_in_range(sleeps() - begin, 0, 20);
    size_t lines = count(read_stderr(outside), '\n');
    assert_in_range(lines, 1, MESSAGES - 1);
    char words[96];
    snprintf(words, sizeof words, " warning: %zu lines of the log could not be written\n", MESSAGES - lines);
    qg_log(QG_LOG_INFO, "again");
    const char *text = read_stderr(outside);
    assert_int_equal(count(text, '\n'), 2);
    assert_non_null(strstr(text, words));
    assert_non_null(strstr(text, "info: again\n"));
}

static void a_reader_who_left_is_told_of_nothing_lost_twice(void **state) {
    struct outside *outside = outside_of(state);
    signal(SIGPIPE, SIG_IGN);
    open_log(outside, QG_LOG_TEXT);
    int reader = dup(outside->pipe[0]);
    close(outside->pipe[0]);
    close(reader);
    qg_log(QG_LOG_INFO, "to nobody");
    qg_log(QG_LOG_INFO, "to nobody");
    close(outside->pipe[1]);
    assert_int_equal(pipe2(outside->pipe, O_CLOEXEC | O_NONBLOCK), 0);
    dup2(outside->pipe[1], STDERR_FILENO);
    qg_log(QG_LOG_INFO, "to somebody");
    const char *text = read_stderr(outside);
    assert_non_null(strstr(text, "warning: 2 lines of the log could not be written\n"));
    assert_int_equal(count(text, '\n'), 2);
}

static void errno_is_left_alone(void **state) {
    struct outside *outside = outside_of(state);
    claim_journal();
    open_log(outside, QG_LOG_AUTO); /* the journal is not there: sending fails */
    errno = ENOSPC;
    qg_log(QG_LOG_ERROR, "%s", "a disk");
    assert_int_equal(errno, ENOSPC);
}

/* --- threads and floods --- */

enum { WRITERS = 4, EACH = 100 }; /* a pipe holds as many lines */

static void *write_lines(void *self) {
    for (int i = 0; i < EACH; i++) {
        qg_log(QG_LOG_INFO, "writer %d writes number %d", *(int *)self, i);
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_INFO, .limit = "flood"}, "flood");
    }
    return NULL;
}

static void lines_of_threads_stay_whole(void **state) {
    struct outside *outside = outside_of(state);
    pthread_t threads[WRITERS];
    int self[WRITERS], next[WRITERS] = {0}, writer, number, floods = 0;
    open_log(outside, QG_LOG_TEXT);
    for (int i = 0; i < WRITERS; i++) {
        self[i] = i;
        assert_int_equal(pthread_create(&threads[i], NULL, write_lines, &self[i]), 0);
    }
    for (int i = 0; i < WRITERS; i++)
        pthread_join(threads[i], NULL);
    qg_log_close();
    for (const char *at = read_stderr(outside); *at; at += strcspn(at, "\n") + 1) {
        if (sscanf(at, "%*s info: writer %d writes number %d\n", &writer, &number) == 2)
            assert_int_equal(number, next[writer]++);
        else
            floods++;
    }
    for (int i = 0; i < WRITERS; i++)
        assert_int_equal(next[i], EACH);
    assert_int_equal(floods, 11);
    assert_non_null(strstr(outside->text, "and 390 more like it"));
}

static void a_flood_is_ten_lines_and_a_count(void **state) {
    struct outside *outside = outside_of(state);
    open_log(outside, QG_LOG_TEXT);
    const struct qg_log_event denied = {.priority = QG_LOG_WARNING, .event = QG_EVENT_ACCESS_DENIED, .limit = "denied"};
    for (int i = 0; i < 5000; i++)
        qg_log_event(&denied, "denied %d", i);
    qg_log(QG_LOG_INFO, "something else");
    assert_int_equal(count(read_stderr(outside), '\n'), 11);
    assert_non_null(strstr(outside->text, "denied 9\n"));
    assert_null(strstr(outside->text, "denied 10\n"));
    qg_log_close();
    const char *text = read_stderr(outside);
    assert_int_equal(count(text, '\n'), 1);
    assert_non_null(strstr(text, " warning: and 4990 more like it within "));
    assert_non_null(strstr(text, "s, the last: denied 4999\n"));
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, come_in, go_out)
    const struct CMUnitTest tests[] = {
        TEST(words_have_time_and_level),
        TEST(json_has_fields),
        TEST(the_journal_gets_fields),
        TEST(only_the_journal_is_taken_for_the_journal),
        TEST(closed_descriptors_are_taken),
        TEST(levels_are_kept_out),
        TEST(events_have_names_of_their_own),
        TEST(texts_are_cleaned),
        TEST(nobody_forges_a_line),
        TEST(the_largest_entry_fits),
        TEST(a_journal_that_is_gone_is_passed_over),
        TEST(a_journal_that_does_not_read_is_not_waited_for),
        TEST(a_stderr_that_is_full_costs_no_time_and_is_told),
        TEST(a_reader_who_left_is_told_of_nothing_lost_twice),
        TEST(errno_is_left_alone),
        TEST(lines_of_threads_stay_whole),
        TEST(a_flood_is_ten_lines_and_a_count),
    };
    return cmocka_run_group_tests_name("log", tests, NULL, NULL);
}
