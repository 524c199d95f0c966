/* Who may do what. See access.h. */
#include "server/http/access.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/http/refusals.h"
#include "server/store/access.h"

enum { BURST_S = 2, BURST_LEAST = 10 };

#define DAY_MS INT64_C(86400000)

/* A token in use. */
struct holder {
    struct qg_token token;
    double level;   /* requests that it may still make at once */
    int64_t filled; /* monotonic ms when the level was true; 0: never used */
    bool used;      /* since its last use was written down */
};

struct qg_access {
    struct qg_store *store;
    struct qg_access_options options;
    pthread_mutex_t mutex; /* guards what follows */
    struct qg_refusals refusals;
    size_t count;
    struct holder holders[QG_TOKENS_MAX];
};

/* --- opening --- */

static enum qg_store_status load(struct qg_access *access) {
    struct qg_token *tokens = calloc(QG_TOKENS_MAX, sizeof *tokens);
    if (!tokens)
        return QG_STORE_FAILED;
    enum qg_store_status status = qg_store_tokens(access->store, tokens, QG_TOKENS_MAX, &access->count);
    for (size_t i = 0; i < access->count; i++)
        access->holders[i].token = tokens[i];
    free(tokens);
    return status;
}

struct qg_access *qg_access_open(struct qg_store *store, const struct qg_access_options *options) {
    struct qg_access *access = calloc(1, sizeof *access);
    if (!access) {
        qg_log(QG_LOG_ERROR, "there is not enough memory for the tokens");
        return NULL;
    }
    access->store = store;
    access->options = *options;
    pthread_mutex_init(&access->mutex, NULL);
    if (load(access) == QG_STORE_OK)
        return access;
    qg_log(QG_LOG_ERROR, "the tokens cannot be read");
    qg_access_close(access);
    return NULL;
}

/* --- making, listing, revoking --- */

static struct holder *find(struct qg_access *access, const char *id) {
    for (size_t i = 0; i < access->count; i++)
        if (strcmp(access->holders[i].token.id, id) == 0)
            return &access->holders[i];
    return NULL;
}

int qg_access_queue_limit(struct qg_access *access, const char *id) {
    pthread_mutex_lock(&access->mutex);
    const struct holder *holder = find(access, id);
    int own = holder ? holder->token.queued_jobs : 0;
    pthread_mutex_unlock(&access->mutex);
    return own > 0 ? own : access->options.queue;
}

/* Forgets a holder: in the store, then in memory. The mutex is held. */
static enum qg_store_status forget(struct qg_access *access, const struct qg_actor *actor, struct holder *holder) {
    enum qg_store_status status = qg_store_token_remove(access->store, holder->token.id, actor);
    if (status != QG_STORE_OK)
        return status;
    size_t behind = access->count - 1 - (size_t)(holder - access->holders);
    memmove(holder, holder + 1, behind * sizeof *holder);
    access->count--;
    return QG_STORE_OK;
}

/* Of the tokens that were over at a time, the one that has been for longest; NULL when there is none. The mutex is held. */
static struct holder *find_over(struct qg_access *access, int64_t time) {
    struct holder *found = NULL;
    for (size_t i = 0; i < access->count; i++) {
        struct holder *holder = &access->holders[i];
        if (qg_token_is_over(&holder->token, time) && (!found || holder->token.expires_at < found->token.expires_at))
            found = holder;
    }
    return found;
}

/* Keeps a token that was made: in the store, then in memory. */
static enum qg_store_status keep(struct qg_access *access, const struct qg_actor *actor, struct qg_token *token) {
    token->created_at = qg_wall_clock();
    pthread_mutex_lock(&access->mutex);
    enum qg_store_status status = QG_STORE_QUEUE_FULL;
    struct holder *over = access->count == QG_TOKENS_MAX ? find_over(access, token->created_at) : NULL;
    if (over)
        forget(access, NULL, over);
    if (access->count < QG_TOKENS_MAX)
        status = qg_store_token_add(access->store, token, actor);
    if (status == QG_STORE_OK)
        access->holders[access->count++] = (struct holder){.token = *token};
    pthread_mutex_unlock(&access->mutex);
    return status;
}

enum qg_store_status qg_access_create(struct qg_access *access, const struct qg_actor *actor, struct qg_token *token,
                                      char text[QG_TOKEN_ROOM]) {
    return qg_token_make(token, text) ? keep(access, actor, token) : QG_STORE_FAILED;
}

enum qg_store_status qg_access_revoke(struct qg_access *access, const struct qg_actor *actor, const char *id) {
    pthread_mutex_lock(&access->mutex);
    struct holder *holder = find(access, id);
    enum qg_store_status status = QG_STORE_NOT_FOUND;
    if (holder)
        status = forget(access, actor, holder);
    pthread_mutex_unlock(&access->mutex);
    return status;
}

bool qg_access_is_live(struct qg_access *access, const char *id) {
    pthread_mutex_lock(&access->mutex);
    const struct holder *holder = *id ? find(access, id) : NULL;
    bool live = !*id || (holder && !qg_token_is_over(&holder->token, qg_wall_clock()));
    pthread_mutex_unlock(&access->mutex);
    return live;
}

size_t qg_access_list(struct qg_access *access, struct qg_token *out) {
    pthread_mutex_lock(&access->mutex);
    size_t count = access->count;
    for (size_t i = 0; i < count; i++)
        out[i] = access->holders[i].token;
    pthread_mutex_unlock(&access->mutex);
    return count;
}

/* --- tidying --- */

/* Copies the tokens that were used since this was asked last; returns how many. */
static size_t take_used(struct qg_access *access, struct qg_token *out) {
    size_t count = 0;
    pthread_mutex_lock(&access->mutex);
    for (size_t i = 0; i < access->count; i++) {
        if (access->holders[i].used)
            out[count++] = access->holders[i].token;
        access->holders[i].used = false;
    }
    pthread_mutex_unlock(&access->mutex);
    return count;
}

/* Without the mutex while it writes: a slow disk delays no request. What cannot be written is told with the next use. */
static void save_uses(struct qg_access *access) {
    struct qg_token *tokens = calloc(QG_TOKENS_MAX, sizeof *tokens);
    size_t count = tokens ? take_used(access, tokens) : 0;
    if (count > 0)
        qg_store_tokens_used(access->store, tokens, count);
    free(tokens);
}

void qg_access_tidy(struct qg_access *access) {
    const int64_t before = qg_wall_clock() - access->options.keep_days * DAY_MS;
    struct holder *over;
    save_uses(access);
    pthread_mutex_lock(&access->mutex);
    while (access->options.keep_days > 0 && (over = find_over(access, before)))
        if (forget(access, NULL, over) != QG_STORE_OK)
            break;
    pthread_mutex_unlock(&access->mutex);
}

void qg_access_close(struct qg_access *access) {
    if (!access)
        return;
    save_uses(access);
    pthread_mutex_destroy(&access->mutex);
    free(access);
}

/* --- the first admin token --- */

static bool write_all(int file, const char *text) {
    size_t length = strlen(text);
    return write(file, text, length) == (ssize_t)length && fsync(file) == 0;
}

/* Puts the token into a file of its own, there as a whole or not at all, for this user only. */
static bool write_token_file(const char *path, const char *text) {
    char temporary[PATH_MAX], line[QG_TOKEN_ROOM + 1];
    if (snprintf(temporary, sizeof temporary, "%s.new", path) >= (int)sizeof temporary)
        return false;
    unlink(temporary);
    int file = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0)
        return false;
    snprintf(line, sizeof line, "%s\n", text);
    bool written = write_all(file, line);
    written = close(file) == 0 && written && rename(temporary, path) == 0;
    qg_secret_wipe(line, sizeof line);
    return written;
}

static bool has_admin(const struct qg_access *access) {
    for (size_t i = 0; i < access->count; i++)
        if (access->holders[i].token.scopes & QG_SCOPE_ADMIN &&
            !qg_token_is_over(&access->holders[i].token, qg_wall_clock()))
            return true;
    return false;
}

bool qg_access_bootstrap(struct qg_access *access, const char *directory, bool anew) {
    char path[PATH_MAX], text[QG_TOKEN_ROOM];
    struct qg_token token = {.name = "admin, made at start", .scopes = QG_SCOPE_ALL};
    if (has_admin(access) && !anew)
        return true;
    snprintf(path, sizeof path, "%s/admin.token", directory);
    /* The file first: killed in between, the next start finds no admin token yet and tries again. */
    bool written = qg_token_make(&token, text) && write_token_file(path, text);
    qg_secret_wipe(text, sizeof text);
    if (!written)
        qg_log(QG_LOG_ERROR, "%s: the first admin token cannot be written: %s", path, strerror(errno));
    if (!written || keep(access, NULL, &token) != QG_STORE_OK)
        return false;
    qg_log(QG_LOG_NOTICE, "an admin token was made: %s", path);
    return true;
}

/* --- judging --- */

/* The credentials of "Bearer CREDENTIALS"; NULL when it is another scheme. */
static const char *bearer(const char *authorization) {
    static const char scheme[] = "Bearer ";
    const size_t length = sizeof scheme - 1;
    if (strncasecmp(authorization, scheme, length) != 0)
        return NULL;
    return authorization + length + strspn(authorization + length, " ");
}

/* The holder whose token this is. The mutex is held. */
static struct holder *recognize(struct qg_access *access, const char *authorization) {
    char id[QG_TOKEN_ID_ROOM];
    unsigned char hash[QG_HASH_BYTES];
    const char *text = bearer(authorization);
    if (!text || !qg_token_read(text, id, hash))
        return NULL;
    struct holder *holder = find(access, id);
    return holder && qg_secret_equal(holder->token.hash, hash) ? holder : NULL;
}

/* Requests that a token of a rate (a second) may make at once after a rest. */
static double room_of(double rate) {
    double least = 60 * rate < BURST_LEAST ? 60 * rate : BURST_LEAST;
    return rate * BURST_S > least ? rate * BURST_S : least;
}

/* Takes one request out of the bucket; 0, or the seconds after which there is one. The mutex is held. */
static int draw(struct holder *holder, int standard, int64_t now) {
    const int own = holder->token.requests_per_minute;
    if (own == 0 && standard == 0)
        return 0;
    const double rate = own > 0 ? own / 60.0 : standard, room = room_of(rate);
    double level = holder->filled ? holder->level + (double)(now - holder->filled) * rate / 1000 : room;
    holder->filled = now;
    holder->level = level < room ? level : room;
    if (holder->level < 1)
        return (int)ceil((1 - holder->level) / rate);
    holder->level -= 1;
    return 0;
}

/* Judges the request of a known token. The mutex is held. */
static enum qg_verdict judge_holder(struct qg_access *access, struct holder *holder, unsigned scope, int64_t now,
                                    int *retry_after_s) {
    const int64_t time = qg_wall_clock();
    if (qg_token_is_over(&holder->token, time))
        return QG_VERDICT_OVER;
    holder->token.last_used_at = time;
    holder->used = true;
    *retry_after_s = draw(holder, access->options.rate, now);
    if (*retry_after_s > 0)
        return QG_VERDICT_TOO_MANY;
    return holder->token.scopes & scope ? QG_VERDICT_GRANTED : QG_VERDICT_WRONG_SCOPE;
}

static enum qg_verdict judge_anonymous(const struct qg_access *access, unsigned scope, struct qg_actor *actor) {
    actor->scopes = access->options.required ? 0 : QG_SCOPE_READ | QG_SCOPE_SUBMIT;
    return actor->scopes & scope ? QG_VERDICT_GRANTED : QG_VERDICT_NO_TOKEN;
}

enum qg_verdict qg_access_judge(struct qg_access *access, const char *authorization, unsigned scope, int64_t now,
                                struct qg_actor *actor, int *retry_after_s) {
    actor->token[0] = actor->name[0] = '\0';
    if (!authorization)
        return judge_anonymous(access, scope, actor);
    enum qg_verdict verdict = QG_VERDICT_WRONG_TOKEN;
    pthread_mutex_lock(&access->mutex);
    struct holder *holder = recognize(access, authorization);
    if (holder) {
        memcpy(actor->token, holder->token.id, sizeof actor->token);
        memcpy(actor->name, holder->token.name, sizeof actor->name);
        actor->scopes = holder->token.scopes;
        verdict = judge_holder(access, holder, scope, now, retry_after_s);
    }
    pthread_mutex_unlock(&access->mutex);
    return verdict;
}

void qg_access_refused(struct qg_access *access, const struct qg_actor *actor, const char *what) {
    pthread_mutex_lock(&access->mutex);
    bool is_news = qg_refusal_is_news(&access->refusals, actor, qg_monotonic_clock());
    pthread_mutex_unlock(&access->mutex);
    if (is_news)
        qg_store_note(access->store, actor, "access.refuse", what); /* what cannot be written is in the server's log */
}
