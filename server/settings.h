/* The daemon's settings: one table gives the flags, the config file's keys, the defaults and the help text.
 *
 * Precedence: flags, then the config file, then defaults. The file has lines "name = value", blank lines and comments
 * from '#' at the start of a line; names are those of the flags. Anything unknown or malformed is an error that names the
 * place and says what is allowed.
 */
#ifndef QG_SERVER_SETTINGS_H
#define QG_SERVER_SETTINGS_H

#include <stdbool.h>

#include "schema/text.h"
#include "server/base/log.h"
#include "server/work/retention.h"

enum { QG_SETTING_ROOM = 1024, QG_THREADS_MAX = 1024, QG_JOBS_MAX = 64 };

struct qg_settings {
    char listen[QG_SETTING_ROOM];           /* ADDRESS:PORT, port 0 is any; default 127.0.0.1:8080 */
    char port_file[QG_SETTING_ROOM];        /* file that the real port is written to; default none ("") */
    char state_dir[QG_SETTING_ROOM];        /* the database's directory; see qg_settings_load */
    char threads[QG_SETTING_ROOM];          /* computing threads, "0": one per processor; default 0 */
    char jobs[QG_SETTING_ROOM];             /* jobs computed at the same time; default 2 */
    char web_dir[QG_SETTING_ROOM];          /* the page's files; default as installed */
    char schema_dir[QG_SETTING_ROOM];       /* the JSON Schemas; default as installed */
    char require_tokens[QG_SETTING_ROOM];   /* "auto": unless bound to loopback; "always"; default auto */
    char token_rate[QG_SETTING_ROOM];       /* requests a second and token, "0": any number; default 50 */
    char token_jobs[QG_SETTING_ROOM];       /* jobs queued or running and token, "0": any number; default 1000 */
    char tls_certificate[QG_SETTING_ROOM];  /* PEM file; default none (""): plain HTTP */
    char tls_key[QG_SETTING_ROOM];          /* PEM file; given when and only when the certificate is */
    char trusted_proxies[QG_SETTING_ROOM];  /* see address.h: qg_addresses_is_list; default none ("") */
    char client_streams[QG_SETTING_ROOM];   /* event streams, long polls of one client, "0": any number; default 300 */
    char cors_origins[QG_SETTING_ROOM];     /* see cors.h; default none ("") */
    char webhook_allow[QG_SETTING_ROOM];    /* see address.h; default none (""): no webhooks */
    char webhook_networks[QG_SETTING_ROOM]; /* see address.h; default none ("") */
    char webhook_retry[QG_SETTING_ROOM];    /* s, see sender.h; default 5 */
    char keep_log_days[QG_SETTING_ROOM];    /* how long the audit log and finished deliveries are kept; default 365 */
    char keep_jobs_days[QG_SETTING_ROOM];   /* retention.h, "0": forever; default 0; likewise the next three */
    char keep_evaluations_days[QG_SETTING_ROOM];
    char keep_jobs[QG_SETTING_ROOM];
    char keep_megabytes[QG_SETTING_ROOM];
    char max_job_cost[QG_SETTING_ROOM]; /* s of a job's estimate, "0": any; default a week */
    char max_job_memory
        [QG_SETTING_ROOM]; /* MB of a job's estimate, "0": any, "auto": half of this process's memory (machine.h)
                                             divided by the jobs; default auto */
    char allowed_hosts[QG_SETTING_ROOM]; /* names this server goes by (origin.h); default none */
    char log_format[QG_SETTING_ROOM];    /* see log.h; default auto */
    char log_level[QG_SETTING_ROOM];     /* see log.h; default info */
    char access_log[QG_SETTING_ROOM];    /* "on": an entry for each request; default off */
    const char *restore_file;            /* of --restore; NULL */
    bool listen_given;                   /* `listen` is not the default but what a flag or the file says */
    bool new_admin_token;                /* --new-admin-token: make one at this start */
    int thread_count;                    /* >= 1, from `threads` */
    int job_count;                       /* >= 1, from `jobs` */
    int token_rate_count, token_jobs_count, client_stream_count, keep_log_day_count, webhook_retry_s, max_job_cost_s,
        max_job_memory_mb;         /* >= 0, from the settings of these names */
    struct qg_retention retention; /* likewise */
    struct qg_log_options log;     /* likewise */
    bool logs_requests;            /* likewise */
};

/* What the program is to do. */
enum qg_settings_action {
    QG_SETTINGS_RUN,     /* serve */
    QG_SETTINGS_RESTORE, /* --restore: put a backup in the database's place, and exit */
    QG_SETTINGS_CHECKED, /* --check-config, and all is well: exit 0 */
    QG_SETTINGS_HELP,    /* message holds the help: print it, exit 0 */
    QG_SETTINGS_VERSION, /* message holds the version: print it, exit 0 */
    QG_SETTINGS_WRONG    /* message says what is wrong: exit 2 */
};

/* Reads flags, config file and environment. The state directory's default is $STATE_DIRECTORY (set by systemd), else
 * LOCALSTATEDIR/lib/quietgear for root, else $XDG_STATE_HOME/quietgear, else ~/.local/state/quietgear. The config file is
 * --config FILE, else SYSCONFDIR/quietgear/quietgeard.conf if that exists. message is appended to; the caller finishes it. */
enum qg_settings_action qg_settings_load(int argc, char *const *argv, struct qg_settings *config,
                                         struct qg_text *message);

/* True when what the settings name is there: the directories of the page and the schemas. Else says what is missing. */
bool qg_settings_exist(const struct qg_settings *config, struct qg_text *message);

/* Splits "ADDRESS:PORT" or "[ADDRESS]:PORT" into two strings of at most `room` bytes. False when it is neither. */
bool qg_settings_split_address(const char *listen, char *address, char *port, size_t room);

#endif
