/* Who may do what: scopes, rates, revoking, the first token, queue limits and the audit log, on a real store. */
#include "tests/server/place.h"

#include <sys/stat.h>

#include "server/http/access.h"
#include "server/http/refusals.h"
#include "server/store/access.h"

static const struct qg_access_options guarded = {.required = true}, open_to_all = {.required = false};
static const struct qg_actor somebody = {.token = "00aa00aa00aa", .name = "somebody", .address = "192.0.2.7"};

/* Makes a token of these scopes, and the header field that shows it. */
static struct qg_token make(struct qg_access *access, unsigned scopes, char field[128]) {
    struct qg_token token = {.name = "of a test", .scopes = scopes};
    char text[QG_TOKEN_ROOM];
    assert_int_equal(qg_access_create(access, &somebody, &token, text), QG_STORE_OK);
    snprintf(field, 128, "Bearer %s", text);
    return token;
}

static enum qg_verdict judge(struct qg_access *access, const char *field, unsigned scope) {
    struct qg_actor actor;
    int wait;
    return qg_access_judge(access, field, scope, 1, &actor, &wait);
}

static void asks_for_a_token(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    static const char *const wrong[] = {
        "",
        "Bearer",
        "Bearer ",
        "Basic dXNlcjpwYXNz",
        "Bearer qg_0",
        "Bearer qg_00aa00aa00aa_0000000000000000000000000000000000000000000000000000000000000000"};
    assert_int_equal(judge(access, NULL, QG_SCOPE_READ), QG_VERDICT_NO_TOKEN);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        assert_int_equal(judge(access, wrong[i], QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
    qg_access_close(access);
}

static void grants_what_the_scopes_cover_and_nothing_else(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[128];
    for (unsigned scopes = 1; scopes <= QG_SCOPE_ALL; scopes++) {
        make(access, scopes, field);
        for (unsigned scope = 1; scope <= QG_SCOPE_ADMIN; scope *= 2)
            assert_int_equal(judge(access, field, scope), scopes & scope ? QG_VERDICT_GRANTED : QG_VERDICT_WRONG_SCOPE);
    }
    qg_access_close(access);
}

static void takes_the_scheme_in_any_case_and_a_secret_in_none_but_its_own(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[128], other[128];
    struct qg_token token = make(access, QG_SCOPE_READ, field);
    memcpy(field, "bEARER", 6);
    assert_int_equal(judge(access, field, QG_SCOPE_READ), QG_VERDICT_GRANTED);
    make(access, QG_SCOPE_READ, other);
    memcpy(other + strlen("Bearer qg_"), token.id, strlen(token.id)); /* this id with the other's secret */
    assert_int_equal(judge(access, other, QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
    char *last = field + strlen(field) - 1;
    *last = *last == '0' ? '1' : '0';
    assert_int_equal(judge(access, field, QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
    qg_access_close(access);
}

static void lets_loopback_read_and_submit(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &open_to_all);
    assert_int_equal(judge(access, NULL, QG_SCOPE_READ), QG_VERDICT_GRANTED);
    assert_int_equal(judge(access, NULL, QG_SCOPE_SUBMIT), QG_VERDICT_GRANTED);
    assert_int_equal(judge(access, NULL, QG_SCOPE_ADMIN), QG_VERDICT_NO_TOKEN);
    assert_int_equal(judge(access, "Bearer x", QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
    qg_access_close(access);
}

static void remembers_tokens_without_their_secrets(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[128], sql[256];
    struct qg_actor actor = {0};
    int wait;
    struct qg_token token = make(access, QG_SCOPE_READ, field);
    qg_access_close(access);
    reopen_place(place);
    access = qg_access_open(place->store, &guarded);
    assert_int_equal(qg_access_judge(access, field, QG_SCOPE_READ, 1, &actor, &wait), QG_VERDICT_GRANTED);
    assert_string_equal(actor.token, token.id);
    assert_string_equal(actor.name, "of a test");
    snprintf(sql, sizeof sql, "SELECT count(*) FROM tokens WHERE instr(hash, '%s') > 0", strrchr(field, '_') + 1);
    assert_int_equal(ask_sql(place, sql), 0);
    assert_int_equal(ask_sql(place, "SELECT length(hash) FROM tokens"), 64);
    qg_access_close(access);
}

static void revokes_at_once_and_for_good(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[3][128];
    struct qg_token token[3], *listed = calloc(QG_TOKENS_MAX, sizeof *listed);
    for (int i = 0; i < 3; i++)
        token[i] = make(access, QG_SCOPE_READ, field[i]);
    assert_true(qg_access_is_live(access, token[1].id) && qg_access_is_live(access, ""));
    assert_int_equal(qg_access_revoke(access, &somebody, token[1].id), QG_STORE_OK);
    assert_false(qg_access_is_live(access, token[1].id));
    assert_true(qg_access_is_live(access, token[2].id));
    assert_int_equal(qg_access_revoke(access, &somebody, token[1].id), QG_STORE_NOT_FOUND);
    for (int i = 0; i < 3; i++)
        assert_int_equal(judge(access, field[i], QG_SCOPE_READ), i == 1 ? QG_VERDICT_WRONG_TOKEN : QG_VERDICT_GRANTED);
    qg_access_close(access);
    access = qg_access_open(place->store, &guarded);
    assert_int_equal(judge(access, field[1], QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
    assert_int_equal(qg_access_list(access, listed), 2);
    free(listed);
    qg_access_close(access);
}

/* A bucket of two seconds, refilled by the rate; each token has its own. */
static void limits_the_rate_of_each_token(void **state) {
    struct place *place = *state;
    const struct qg_access_options options = {.required = true, .rate = 10};
    struct qg_access *access = qg_access_open(place->store, &options);
    char field[128], other[128];
    struct qg_actor actor;
    int wait = 0, granted = 0;
    make(access, QG_SCOPE_READ, field);
    make(access, QG_SCOPE_READ, other);
    for (int i = 0; i < 50; i++)
        granted += qg_access_judge(access, field, QG_SCOPE_READ, 1000, &actor, &wait) == QG_VERDICT_GRANTED;
    assert_int_equal(granted, 20);
    assert_int_equal(wait, 1);
    assert_int_equal(qg_access_judge(access, other, QG_SCOPE_READ, 1000, &actor, &wait), QG_VERDICT_GRANTED);
    for (int i = 0; i < 50; i++) /* refused requests cost nothing: half a second gives five */
        granted += qg_access_judge(access, field, QG_SCOPE_READ, 1500, &actor, &wait) == QG_VERDICT_GRANTED;
    assert_int_equal(granted, 25);
    for (int i = 0; i < 50; i++) /* a day gives a full bucket and no more */
        granted += qg_access_judge(access, field, QG_SCOPE_READ, 86400000, &actor, &wait) == QG_VERDICT_GRANTED;
    assert_int_equal(granted, 45);
    qg_access_close(access);
}

/* Requests of 100 that a token may make at a time. */
static int count_granted(struct qg_access *access, const char *field, int64_t now, int *wait) {
    struct qg_actor actor;
    int granted = 0;
    for (int i = 0; i < 100; i++)
        granted += qg_access_judge(access, field, QG_SCOPE_READ, now, &actor, wait) == QG_VERDICT_GRANTED;
    return granted;
}

/* Makes a token with limits or an end of its own, and the header field that shows it. */
static struct qg_token make_special(struct qg_access *access, const struct qg_token *wish, char field[128]) {
    struct qg_token token = *wish;
    char text[QG_TOKEN_ROOM];
    token.scopes |= QG_SCOPE_READ;
    assert_int_equal(qg_access_create(access, &somebody, &token, text), QG_STORE_OK);
    snprintf(field, 128, "Bearer %s", text);
    return token;
}

static void a_token_may_have_a_rate_of_its_own(void **state) {
    struct place *place = *state;
    const struct qg_access_options options = {.required = true, .rate = 10};
    static const struct {
        int rate, at_once, wait, after_a_minute;
    } cases[] = {
        {0, 20, 1, 20},  /* the daemon's */
        {3, 3, 20, 3},   /* a minute's worth, one each 20 s */
        {60, 10, 1, 10}, /* ten */
        {1800, 60, 1, 60}, {QG_TOKEN_REQUESTS_MAX, 100, 0, 100},
    };
    struct qg_access *access = qg_access_open(place->store, &options);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char field[128];
        int wait = 0;
        make_special(access, &(struct qg_token){.requests_per_minute = cases[i].rate}, field);
        assert_int_equal(count_granted(access, field, 1000, &wait), cases[i].at_once);
        assert_int_equal(wait, cases[i].wait);
        assert_int_equal(count_granted(access, field, 61000, &wait), cases[i].after_a_minute);
    }
    qg_access_close(access);
    const struct qg_access_options unlimited = {.required = true};
    access = qg_access_open(place->store, &unlimited);
    char field[128];
    int wait;
    make_special(access, &(struct qg_token){.requests_per_minute = 3}, field);
    assert_int_equal(count_granted(access, field, 1000, &wait), 3); /* also where others have no limit */
    qg_access_close(access);
}

static void a_token_may_have_a_queue_of_its_own(void **state) {
    struct place *place = *state;
    const struct qg_access_options options = {.required = true, .queue = 7};
    struct qg_access *access = qg_access_open(place->store, &options);
    char field[128];
    const struct qg_token plain = make(access, QG_SCOPE_SUBMIT, field),
                          special = make_special(access, &(struct qg_token){.queued_jobs = 2}, field);
    for (int again = 0; again < 2; again++) {
        assert_int_equal(qg_access_queue_limit(access, plain.id), 7);
        assert_int_equal(qg_access_queue_limit(access, special.id), 2);
        assert_int_equal(qg_access_queue_limit(access, ""), 7);
        qg_access_close(access);
        reopen_place(place);
        access = qg_access_open(place->store, &options);
    }
    qg_access_close(access);
}

/* Makes a token and uses it while it lives; a machine that is too slow for a brief life gives it a longer one. */
static struct qg_token use_brief_token(struct qg_access *access, char field[128]) {
    for (int64_t life = 200;; life *= 4) {
        const struct qg_token token =
            make_special(access, &(struct qg_token){.expires_at = qg_wall_clock() + life}, field);
        const enum qg_verdict verdict = judge(access, field, QG_SCOPE_READ);
        const bool is_live = qg_access_is_live(access, token.id);
        if (qg_wall_clock() < token.expires_at) {
            assert_int_equal(verdict, QG_VERDICT_GRANTED);
            assert_true(is_live);
            return token;
        }
    }
}

static void an_expired_token_opens_nothing(void **state) {
    struct place *place = *state;
    const struct timespec moment = {.tv_nsec = 5000000};
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char brief[128], lasting[128], wrong[128];
    const struct qg_token other =
        make_special(access, &(struct qg_token){.expires_at = qg_wall_clock() + 3600000}, lasting);
    const struct qg_token token = use_brief_token(access, brief);
    assert_true(qg_token_is_over(&token, token.expires_at) && !qg_token_is_over(&token, token.expires_at - 1));
    while (qg_wall_clock() < token.expires_at)
        nanosleep(&moment, NULL);
    for (int again = 0; again < 2; again++) {
        assert_int_equal(judge(access, brief, QG_SCOPE_READ), QG_VERDICT_OVER);
        assert_false(qg_access_is_live(access, token.id));
        assert_int_equal(judge(access, lasting, QG_SCOPE_READ), QG_VERDICT_GRANTED);
        assert_true(qg_access_is_live(access, other.id));
        strcpy(wrong, brief); /* who has not the secret does not learn that there was such a token */
        wrong[strlen(wrong) - 1] ^= 1;
        assert_int_equal(judge(access, wrong, QG_SCOPE_READ), QG_VERDICT_WRONG_TOKEN);
        qg_access_close(access);
        reopen_place(place);
        access = qg_access_open(place->store, &guarded);
    }
    qg_access_close(access);
}

static void long_expired_tokens_are_dropped(void **state) {
    struct place *place = *state;
    const struct qg_access_options options = {.required = true, .keep_days = 2};
    struct qg_access *access = qg_access_open(place->store, &options);
    struct qg_token *listed = calloc(QG_TOKENS_MAX, sizeof *listed);
    const int64_t now = qg_wall_clock(), day = 86400000;
    char field[128];
    make(access, QG_SCOPE_READ, field);
    make_special(access, &(struct qg_token){.expires_at = now + day}, field);
    const struct qg_token recent = make_special(access, &(struct qg_token){.expires_at = now - day}, field);
    make_special(access, &(struct qg_token){.expires_at = now - 3 * day}, field);
    qg_access_tidy(access);
    assert_int_equal(qg_access_list(access, listed), 3);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM tokens"), 3);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM audit WHERE action = 'token.expire' AND name = 'quietgeard'"),
                     1);
    qg_access_close(access);
    run_sql(place,
            "INSERT INTO tokens (id, name, scopes, created_at, hash) SELECT printf('%012x', value), '', 1, 5,"
            " hex(zeroblob(32)) FROM (WITH RECURSIVE up (value) AS (VALUES (1) UNION ALL SELECT value + 1 FROM up"
            " WHERE value < 997) SELECT value FROM up)");
    access = qg_access_open(place->store, &options);
    assert_int_equal(qg_access_list(access, listed), QG_TOKENS_MAX);
    make(access, QG_SCOPE_READ, field); /* takes the place of the one that is over */
    assert_int_equal(qg_access_list(access, listed), QG_TOKENS_MAX);
    assert_int_equal(qg_access_revoke(access, &somebody, recent.id), QG_STORE_NOT_FOUND);
    struct qg_token token = {.name = "one too many", .scopes = QG_SCOPE_READ};
    char text[QG_TOKEN_ROOM];
    assert_int_equal(qg_access_create(access, &somebody, &token, text), QG_STORE_QUEUE_FULL);
    free(listed);
    qg_access_close(access);
}

static void remembers_when_tokens_were_used(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    struct qg_token *listed = calloc(QG_TOKENS_MAX, sizeof *listed);
    char used[128], unused[128];
    const int64_t before = qg_wall_clock();
    make(access, QG_SCOPE_READ, used);
    make(access, QG_SCOPE_READ, unused);
    assert_int_equal(judge(access, used, QG_SCOPE_READ), QG_VERDICT_GRANTED);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM tokens WHERE last_used_at IS NOT NULL"), 0); /* not yet */
    qg_access_tidy(access);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM tokens WHERE last_used_at IS NOT NULL"), 1);
    run_sql(place, "UPDATE tokens SET last_used_at = NULL");
    qg_access_tidy(access);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM tokens WHERE last_used_at IS NOT NULL"), 0); /* no news */
    assert_int_equal(judge(access, used, QG_SCOPE_SUBMIT), QG_VERDICT_WRONG_SCOPE); /* is a use too */
    qg_access_close(access);
    access = qg_access_open(place->store, &guarded);
    assert_int_equal(qg_access_list(access, listed), 2);
    const struct qg_token *of_used = strstr(used, listed[0].id) ? &listed[0] : &listed[1],
                          *of_unused = strstr(used, listed[0].id) ? &listed[1] : &listed[0];
    assert_true(of_used->last_used_at >= before && of_used->last_used_at <= qg_wall_clock());
    assert_int_equal(of_unused->last_used_at, 0);
    free(listed);
    qg_access_close(access);
}

/* --- the first token --- */

/* Reads the file of the first token as a header field; its mode. */
static mode_t read_first(const struct place *place, char field[128]) {
    char path[64], text[100];
    struct stat status;
    snprintf(path, sizeof path, "%s/admin.token", place->directory);
    FILE *stream = fopen(path, "r");
    assert_non_null(stream);
    assert_non_null(fgets(text, sizeof text, stream));
    assert_int_equal(fstat(fileno(stream), &status), 0);
    fclose(stream);
    text[strcspn(text, "\n")] = '\0';
    snprintf(field, 128, "Bearer %s", text);
    return status.st_mode & 0777;
}

static void makes_the_first_token_once_and_anew_when_told(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[128], again[128];
    assert_true(qg_access_bootstrap(access, place->directory, false));
    assert_int_equal(read_first(place, field), 0600);
    assert_int_equal(judge(access, field, QG_SCOPE_ADMIN), QG_VERDICT_GRANTED);
    assert_true(qg_access_bootstrap(access, place->directory, false));
    read_first(place, again);
    assert_string_equal(field, again);
    assert_true(qg_access_bootstrap(access, place->directory, true));
    read_first(place, again);
    assert_string_not_equal(field, again);
    assert_int_equal(judge(access, field, QG_SCOPE_ADMIN), QG_VERDICT_GRANTED); /* still: revoke what is not wanted */
    assert_int_equal(judge(access, again, QG_SCOPE_ADMIN), QG_VERDICT_GRANTED);
    qg_access_close(access);
}

static void makes_one_when_all_admin_tokens_are_over(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    char field[128];
    make_special(access, &(struct qg_token){.scopes = QG_SCOPE_ALL, .expires_at = 1000}, field);
    assert_true(qg_access_bootstrap(access, place->directory, false));
    read_first(place, field);
    assert_int_equal(judge(access, field, QG_SCOPE_ADMIN), QG_VERDICT_GRANTED);
    qg_access_close(access);
}

static void does_not_keep_a_first_token_that_nobody_can_read(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    assert_false(qg_access_bootstrap(access, "/nowhere/at/all", false));
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM tokens"), 0);
    qg_access_close(access);
}

/* --- the queue, and the audit log --- */

static enum qg_store_status submit(struct place *place, const struct qg_actor *actor, char id[QG_JOB_ID_ROOM]) {
    struct qg_job_row row = {0};
    const struct qg_submission submission = {
        .name = "", .kind = "optimize", .labels = "[]", .document = "{}", .actor = actor, .queue_limit = 3};
    enum qg_store_status status = qg_store_submit(place->store, &submission, &row);
    if (status == QG_STORE_OK)
        memcpy(id, row.id, QG_JOB_ID_ROOM);
    qg_job_row_finish(&row);
    return status;
}

static void limits_the_queue_of_each_token(void **state) {
    struct place *place = *state;
    const struct qg_actor other = {.token = "0000000000ff"}, nobody = {.name = ""};
    struct qg_claim claim;
    struct qg_text document = {0};
    char id[QG_JOB_ID_ROOM];
    for (int i = 0; i < 3; i++)
        assert_int_equal(submit(place, &somebody, id), QG_STORE_OK);
    assert_int_equal(qg_store_claim(place->store, 60000, &claim, &document), QG_STORE_OK); /* running counts too */
    assert_int_equal(submit(place, &somebody, id), QG_STORE_QUEUE_FULL);
    assert_int_equal(submit(place, &other, id), QG_STORE_OK);
    for (int i = 0; i < 5; i++)
        assert_int_equal(submit(place, &nobody, id), QG_STORE_OK);
    const struct qg_ending ending = {.state = QG_STATE_SUCCEEDED};
    assert_int_equal(qg_store_finish(place->store, &claim, &ending), QG_STORE_OK);
    assert_int_equal(submit(place, &somebody, id), QG_STORE_OK);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM audit WHERE action = 'job.submit'"), 10);
    qg_text_finish(&document);
}

/* The newest entries of a filter, at most `room` (16); returns how many. */
static size_t look(struct place *place, const struct qg_audit_filter *filter, struct qg_audit_entry *entries,
                   size_t room) {
    struct qg_audit_page page = {.entry = entries, .room = room};
    assert_int_equal(qg_store_audit(place->store, filter, &page), QG_STORE_OK);
    assert_true(page.count <= room && page.next == 0);
    return page.count;
}

static void writes_down_who_did_what(void **state) {
    struct place *place = *state;
    struct qg_audit_entry entries[8];
    char id[QG_JOB_ID_ROOM];
    assert_int_equal(submit(place, &somebody, id), QG_STORE_OK);
    assert_int_equal(qg_store_cancel(place->store, id, &somebody), QG_STORE_OK);
    assert_int_equal(qg_store_delete(place->store, id, NULL), QG_STORE_OK);
    assert_int_equal(qg_store_delete(place->store, id, &somebody), QG_STORE_NOT_FOUND); /* not done: not written */
    assert_int_equal(look(place, &(struct qg_audit_filter){0}, entries, 8), 3);
    static const char *const actions[] = {"job.delete", "job.cancel", "job.submit"};
    for (size_t i = 0; i < 3; i++) {
        assert_string_equal(entries[i].action, actions[i]);
        assert_string_equal(entries[i].subject, id);
        assert_string_equal(entries[i].name, i == 0 ? "quietgeard" : "somebody");
        assert_string_equal(entries[i].token, i == 0 ? "" : "00aa00aa00aa");
        assert_string_equal(entries[i].address, i == 0 ? "" : "192.0.2.7");
        assert_true(entries[i].at > 0);
    }
    assert_int_equal(look(place, &(struct qg_audit_filter){.before = entries[0].sequence}, entries, 1), 1);
    assert_string_equal(entries[0].action, "job.cancel");
}

static size_t count_entries(struct place *place, const struct qg_audit_filter *filter) {
    struct qg_audit_entry entries[16];
    size_t count = look(place, filter, entries, 16);
    for (size_t i = 1; i < count; i++)
        assert_true(entries[i].sequence < entries[i - 1].sequence);
    return count;
}

static void finds_entries_by_what_is_asked(void **state) {
    struct place *place = *state;
    const struct qg_actor other = {.token = "0000000000ff", .name = "jobs'; --", .address = "2001:db8::1"};
    char id[2][QG_JOB_ID_ROOM];
    assert_int_equal(submit(place, &somebody, id[0]), QG_STORE_OK);
    assert_int_equal(submit(place, &other, id[1]), QG_STORE_OK);
    assert_int_equal(qg_store_cancel(place->store, id[0], &other), QG_STORE_OK);
    assert_int_equal(qg_store_delete(place->store, id[0], NULL), QG_STORE_OK);
    assert_int_equal(qg_store_note(place->store, &other, "database.backup", "quietgear.db"), QG_STORE_OK);
    run_sql(place, "UPDATE audit SET at = 1000 * seq");
    const struct {
        struct qg_audit_filter filter;
        size_t count;
    } cases[] = {
        {{0}, 5},
        {{.action = "job"}, 4},
        {{.action = "job.submit"}, 2},
        {{.action = "database"}, 1},
        {{.action = "jo"}, 0},
        {{.actor = "somebody"}, 1},
        {{.actor = "00aa00aa00aa"}, 1},
        {{.actor = "jobs'; --"}, 3},
        {{.actor = "quietgeard"}, 1},
        {{.actor = "some%"}, 0},
        {{.subject = id[0]}, 3},
        {{.subject = id[0], .action = "job.cancel", .actor = "0000000000ff", .address = "2001:db8::1"}, 1},
        {{.subject = id[0], .action = "job.cancel", .actor = "somebody"}, 0},
        {{.address = "192.0.2.7"}, 1},
        {{.since = 3000}, 3},
        {{.until = 3000}, 2},
        {{.since = 2000, .until = 4000}, 2},
        {{.since = 2000, .before = 4}, 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(count_entries(place, &cases[i].filter), cases[i].count);
}

/* One call looks at so many entries and no more, and says from where to go on. */
static void looks_at_so_many_at_once(void **state) {
    struct place *place = *state;
    struct qg_audit_entry entries[4];
    struct qg_audit_page page = {.entry = entries, .room = 4};
    struct qg_audit_filter filter = {.subject = "wanted"};
    char sql[400];
    snprintf(sql, sizeof sql,
             "INSERT INTO audit (at, token, name, address, action, subject) SELECT 5, '', '', '', 'job.submit',"
             " iif(value IN (1, 2, 3), 'wanted', '') FROM (WITH RECURSIVE up (value) AS (VALUES (1) UNION ALL"
             " SELECT value + 1 FROM up WHERE value < %d) SELECT value FROM up)",
             2 * QG_AUDIT_LOOK + 2);
    run_sql(place, sql);
    assert_int_equal(qg_store_audit(place->store, &filter, &page), QG_STORE_OK);
    assert_true(page.count == 0 && page.next == QG_AUDIT_LOOK + 3);
    filter.before = page.next;
    assert_int_equal(qg_store_audit(place->store, &filter, &page), QG_STORE_OK);
    assert_true(page.count == 1 && entries[0].sequence == 3 && page.next == 3);
    filter.before = page.next;
    assert_int_equal(qg_store_audit(place->store, &filter, &page), QG_STORE_OK);
    assert_true(page.count == 2 && entries[0].sequence == 2 && page.next == 0);
}

static void knows_actions_and_their_families(void **state) {
    (void)state;
    static const char *const known[] = {"job", "job.submit", "access", "daemon", "token.expire"},
                             *const unknown[] = {"", ".", "jobs", "job.", "job.submi", "job.submit.", "jo", "Job"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        assert_true(qg_action_is_known(known[i]));
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++)
        assert_false(qg_action_is_known(unknown[i]));
}

/* One an hour of each address and token; of those beyond 64, one an hour together. */
static void tells_which_refusals_are_news(void **state) {
    (void)state;
    const int64_t hour = 3600000;
    struct qg_refusals refusals = {0};
    struct qg_actor actor = {.address = "192.0.2.1"};
    assert_true(qg_refusal_is_news(&refusals, &actor, 1));
    assert_false(qg_refusal_is_news(&refusals, &actor, 2));
    strcpy(actor.token, "00aa00aa00aa");
    assert_true(qg_refusal_is_news(&refusals, &actor, 3)); /* with a token that is known it is another matter */
    assert_false(qg_refusal_is_news(&refusals, &actor, 4));
    strcpy(actor.token, "");
    assert_false(qg_refusal_is_news(&refusals, &actor, hour));
    assert_true(qg_refusal_is_news(&refusals, &actor, hour + 1));
    int news = 0;
    for (int i = 0; i < 1000; i++) {
        snprintf(actor.address, sizeof actor.address, "10.0.0.%d", i);
        news += qg_refusal_is_news(&refusals, &actor, 2 * hour);
        news += qg_refusal_is_news(&refusals, &actor, 2 * hour);
    }
    assert_int_equal(news, QG_REFUSALS_MAX - 1 + 1); /* 192.0.2.1 has its place until an hour after its last news */
    for (int i = 0; i < 1000; i++) {
        snprintf(actor.address, sizeof actor.address, "10.0.0.%d", i);
        news += qg_refusal_is_news(&refusals, &actor, 3 * hour + 1);
    }
    assert_int_equal(news, 2 * QG_REFUSALS_MAX + 1);
}

static void writes_refusals_down_once(void **state) {
    struct place *place = *state;
    struct qg_access *access = qg_access_open(place->store, &guarded);
    struct qg_audit_entry entry;
    for (int i = 0; i < 100; i++)
        qg_access_refused(access, &somebody, "GET /v1/tokens");
    assert_int_equal(look(place, &(struct qg_audit_filter){.action = "access"}, &entry, 1), 1);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM audit"), 1);
    assert_string_equal(entry.subject, "GET /v1/tokens");
    assert_string_equal(entry.address, "192.0.2.7");
    qg_access_close(access);
}

static void drops_old_entries_only(void **state) {
    struct place *place = *state;
    char id[QG_JOB_ID_ROOM];
    assert_int_equal(submit(place, &somebody, id), QG_STORE_OK);
    run_sql(place, "UPDATE audit SET at = 1000");
    assert_int_equal(submit(place, &somebody, id), QG_STORE_OK);
    assert_int_equal(qg_store_drop_log(place->store, 1001), QG_STORE_OK);
    assert_int_equal(ask_sql(place, "SELECT count(*) FROM audit"), 1);
    assert_int_equal(ask_sql(place, "SELECT min(at) > 1000 FROM audit"), 1);
}

/* The recipe of store/format.c, step 5: what a database of the first format becomes. */
static void takes_over_a_database_without_tokens(void **state) {
    struct place *place = *state;
    struct qg_audit_entry entry;
    struct qg_job_row row;
    char path[64];
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    qg_store_close(place->store);
    assert_int_equal(unlink(path), 0);
    sqlite3 *database;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(qg_store_migrate_to(database, 1), QG_STORE_OK);
    assert_int_equal(sqlite3_exec(database,
                                  "INSERT INTO jobs (id, name, kind, labels, state, submitted_at, document)"
                                  " VALUES ('old', 'an old job', 'optimize', '[]', 'queued', 5, '{}')",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    sqlite3_close(database);
    open_place(place);
    assert_int_equal(qg_store_job(place->store, "old", &row), QG_STORE_OK);
    assert_string_equal(row.name, "an old job");
    qg_job_row_finish(&row);
    assert_int_equal(ask_sql(place, "SELECT token IS NULL FROM jobs"), 1);
    assert_int_equal(qg_store_cancel(place->store, "old", &somebody), QG_STORE_OK);
    assert_int_equal(look(place, &(struct qg_audit_filter){0}, &entry, 1), 1);
    assert_string_equal(entry.subject, "old");
}

/* A database of format 9 had tokens that neither expire nor have limits of their own. */
static void takes_over_tokens_without_an_end(void **state) {
    struct place *place = *state;
    struct qg_token *listed = calloc(QG_TOKENS_MAX, sizeof *listed);
    char path[64];
    snprintf(path, sizeof path, "%s/quietgear.db", place->directory);
    qg_store_close(place->store);
    assert_int_equal(unlink(path), 0);
    sqlite3 *database;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    assert_int_equal(qg_store_migrate_to(database, 9), QG_STORE_OK);
    assert_int_equal(sqlite3_exec(database,
                                  "INSERT INTO tokens (id, name, scopes, created_at, hash)"
                                  " VALUES ('00aa00aa00aa', 'old', 3, 5, hex(zeroblob(32)))",
                                  NULL, NULL, NULL),
                     SQLITE_OK);
    sqlite3_close(database);
    open_place(place);
    struct qg_access *access = qg_access_open(place->store, &(struct qg_access_options){.queue = 9});
    assert_int_equal(qg_access_list(access, listed), 1);
    assert_string_equal(listed[0].name, "old");
    assert_true(listed[0].scopes == 3 && listed[0].created_at == 5 && listed[0].expires_at == 0);
    assert_true(qg_access_is_live(access, "00aa00aa00aa"));
    assert_int_equal(qg_access_queue_limit(access, "00aa00aa00aa"), 9);
    free(listed);
    qg_access_close(access);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        PLACE_TEST(asks_for_a_token),
        PLACE_TEST(grants_what_the_scopes_cover_and_nothing_else),
        PLACE_TEST(takes_the_scheme_in_any_case_and_a_secret_in_none_but_its_own),
        PLACE_TEST(lets_loopback_read_and_submit),
        PLACE_TEST(remembers_tokens_without_their_secrets),
        PLACE_TEST(revokes_at_once_and_for_good),
        PLACE_TEST(limits_the_rate_of_each_token),
        PLACE_TEST(a_token_may_have_a_rate_of_its_own),
        PLACE_TEST(a_token_may_have_a_queue_of_its_own),
        PLACE_TEST(an_expired_token_opens_nothing),
        PLACE_TEST(long_expired_tokens_are_dropped),
        PLACE_TEST(remembers_when_tokens_were_used),
        PLACE_TEST(makes_one_when_all_admin_tokens_are_over),
        PLACE_TEST(makes_the_first_token_once_and_anew_when_told),
        PLACE_TEST(does_not_keep_a_first_token_that_nobody_can_read),
        PLACE_TEST(limits_the_queue_of_each_token),
        PLACE_TEST(writes_down_who_did_what),
        PLACE_TEST(finds_entries_by_what_is_asked),
        PLACE_TEST(looks_at_so_many_at_once),
        cmocka_unit_test(knows_actions_and_their_families),
        cmocka_unit_test(tells_which_refusals_are_news),
        PLACE_TEST(writes_refusals_down_once),
        PLACE_TEST(drops_old_entries_only),
        PLACE_TEST(takes_over_a_database_without_tokens),
        PLACE_TEST(takes_over_tokens_without_an_end),
    };
    return cmocka_run_group_tests_name("access", tests, NULL, NULL);
}
