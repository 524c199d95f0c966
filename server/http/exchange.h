/* One request and its reply, as the handlers see them: no sockets, no libmicrohttpd.
 *
 * http.c fills the request and sends the reply; routes.c finds the handler; the handlers are in calls/.
 */
#ifndef QG_SERVER_HTTP_EXCHANGE_H
#define QG_SERVER_HTTP_EXCHANGE_H

#include "server/http/access.h"
#include "server/http/problem.h"
#include "server/http/target.h"
#include "server/work/board.h"
#include "server/work/job_copies.h"
#include "server/work/runner.h"

/* What the handlers work with; everything in it is safe to use from any thread. */
struct qg_service {
    const struct qg_routes *routes; /* what can be asked for */
    struct qg_store *store;
    struct qg_board *board;
    struct qg_job_copies *job_copies;
    struct qg_runner *runner;
    struct qg_access *access;
    struct qg_field_maker *field_maker;
    struct qg_metrics *metrics;
    struct qg_backups *backups;
    const char *cors_origins;                     /* see cors.h */
    const char *webhook_rules, *webhook_networks; /* see address.h */
    struct qg_tls *tls;                           /* NULL: plain HTTP */
    const char *trusted_proxies;                  /* see forwarded.h */
    int client_stream_max;                        /* event streams, long polls of one client; 0: any */
    const char *web_dir, *schema_dir;
    int thread_count;          /* of the executor */
    double job_cost_max;       /* s of an estimate; 0: any */
    double job_memory_max;     /* MB of an estimate; 0: any */
    const char *allowed_hosts; /* see origin.h */
    bool logs_requests;        /* see access_log.h */
};

enum qg_method { QG_GET, QG_POST, QG_DELETE, QG_METHOD_COUNT };

/* A request, complete with its body. Header fields are NULL when absent. */
struct qg_request {
    struct qg_actor actor; /* who asks */
    struct qg_target target;
    const char *parameter;  /* the segment that stands for the route's {}; NULL */
    int offer;              /* index of the chosen media type among the route's */
    const char *media_type; /* that type */
    const char *if_none_match, *prefer, *idempotency_key, *last_event_id;
    struct qg_text body;
    struct {
        bool begun;
        bool refused;     /* the client holds as many long polls as it may: answer now */
        int64_t deadline; /* monotonic ms */
        char seen[24];    /* the entity tag that the client has */
        uint64_t number;  /* of the backup that is being made */
    } wait;               /* of a long poll or a backup, kept while it sleeps */
};

/* Open event streams of all clients together. */
enum { QG_STREAMS_MAX = 1200 };

enum { QG_REPLY_HEADERS_MAX = 10, QG_REPLY_HEADER_ROOM = 1536 };

/* What somebody waits for who has nothing to say: a change of the board. */
struct qg_pause {
    char id[QG_JOB_ID_ROOM]; /* of the job; "": any */
    uint64_t version;        /* the board's before anything was read */
    int64_t deadline;        /* monotonic ms; looks again at the latest then */
};

/* How a stream goes on. */
enum qg_stream_step {
    QG_STREAM_PIECE, /* something was appended */
    QG_STREAM_PAUSE, /* nothing yet: ask again when the pause is over */
    QG_STREAM_END,
    QG_STREAM_BROKEN /* it breaks off; the client must not take it for the end */
};

/* A body that is made piece by piece while it is sent: the next one when the client has taken the last. */
struct qg_stream {
    /* Appends the next piece, or fills the pause. Called from the server's thread. */
    enum qg_stream_step (*next)(void *self, struct qg_text *piece, struct qg_pause *pause);
    void (*destroy)(void *self);
    void *self;   /* NULL: the body is the text */
    bool endless; /* it pauses, and lasts as long as its client: such streams are limited in number */
    size_t kept;  /* bytes of a text that it keeps until it ends; 0: it makes its pieces when they are asked for */
};

/* A reply, zeroed before a handler fills it. */
struct qg_reply {
    int status;
    const char *media_type; /* static */
    struct qg_text body;
    struct qg_stream stream;
    size_t header_count;
    struct {
        const char *name; /* static */
        char value[QG_REPLY_HEADER_ROOM];
    } header[QG_REPLY_HEADERS_MAX];
    bool wait;  /* nothing to say yet: ask again after the pause */
    bool polls; /* ... and only because the client wishes to wait: a long poll */
    struct qg_pause pause;
};

/* Frees what the reply owns. */
void qg_reply_finish(struct qg_reply *reply);

/* Adds a header field, printf-like. */
void qg_reply_header(struct qg_reply *reply, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The value of a header field that was added; NULL when it was not. */
const char *qg_reply_header_value(const struct qg_reply *reply, const char *name);

/* Has the handler asked again in some ms; changes of jobs meanwhile do not matter. */
void qg_reply_later(struct qg_reply *reply, struct qg_board *board, int ms);

/* Makes the reply a problem document; detail is printf-like. What was in the body is dropped. */
void qg_reply_problem(struct qg_reply *reply, enum qg_problem_code code, const char *detail, ...)
    __attribute__((format(printf, 3, 4)));

/* Makes the reply the problem that a store's status stands for. */
void qg_reply_store_problem(struct qg_reply *reply, enum qg_store_status status);

/* False, and a problem as the reply, when the query has parameters other than the NULL-ended names, or any at all. */
bool qg_request_has_only(const struct qg_request *request, const char *const *names, struct qg_reply *reply);
bool qg_request_has_no_query(const struct qg_request *request, struct qg_reply *reply);

/* Reads digits and nothing else as a number from `least` (>= 0) to `most`. False when the text is none. */
bool qg_read_whole_number(const char *text, int64_t least, int64_t most, int64_t *out);

/* Answers a request. Called again with the same request after a wait. */
typedef void qg_handler(const struct qg_service *service, struct qg_request *request, struct qg_reply *reply);

#endif
