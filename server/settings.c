/* The daemon's settings. See settings.h. */
#include "server/settings.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <config.h>

#include "server/base/address.h"
#include "server/base/machine.h"
#include "server/http/cors.h"
#include "server/http/exchange.h"
#include "server/http/origin.h"
#include "server/http/tls.h"

/* One setting: where it lives, its default, and how its value is judged. */
struct setting {
    const char *name, *argument, *standard, *help, *allowed;
    size_t offset;
    bool (*valid)(const char *value);
};

static bool is_count(const char *value, long least, long most) {
    char *end;
    errno = 0;
    long number = strtol(value, &end, 10);
    return value[0] >= '0' && value[0] <= '9' && !*end && !errno && number >= least && number <= most;
}

static bool valid_threads(const char *value) {
    return is_count(value, 0, QG_THREADS_MAX);
}

static bool valid_jobs(const char *value) {
    return is_count(value, 1, QG_JOBS_MAX);
}

static bool valid_path(const char *value) {
    return *value;
}

static bool valid_rate(const char *value) {
    return is_count(value, 0, 100000);
}

static bool valid_streams(const char *value) {
    return is_count(value, 0, QG_STREAMS_MAX);
}

static bool valid_wait(const char *value) {
    return is_count(value, 1, 3600);
}

static bool valid_days(const char *value) {
    return is_count(value, 1, 36500);
}

static bool valid_amount(const char *value) {
    return is_count(value, 0, 1000000000);
}

static bool valid_memory(const char *value) {
    return strcmp(value, "auto") == 0 || valid_amount(value);
}

static bool valid_days_or_none(const char *value) {
    return is_count(value, 0, 36500);
}

static bool valid_requirement(const char *value) {
    return strcmp(value, "auto") == 0 || strcmp(value, "always") == 0;
}

static bool valid_log_format(const char *value) {
    enum qg_log_format format;
    return qg_log_format_read(value, &format);
}

static bool valid_log_level(const char *value) {
    enum qg_priority level;
    return qg_log_level_read(value, &level);
}

static bool valid_switch(const char *value) {
    return strcmp(value, "on") == 0 || strcmp(value, "off") == 0;
}

static bool valid_listen(const char *value) {
    char address[QG_SETTING_ROOM], port[QG_SETTING_ROOM];
    return qg_settings_split_address(value, address, port, sizeof port) && is_count(port, 0, 65535);
}

#define SETTING(name, member, argument, standard, valid, allowed, help)                                                \
    { name, argument, standard, help, allowed, offsetof(struct qg_settings, member), valid }
static const struct setting settings[] = {
    SETTING("listen", listen, "ADDRESS:PORT", "127.0.0.1:8080", valid_listen,
            "ADDRESS:PORT or [IPV6ADDRESS]:PORT with a port from 0 to 65535",
            "where to listen; port 0 takes any free one"),
    SETTING("port-file", port_file, "FILE", "", valid_path, "the name of a file", "write the port in use to FILE"),
    SETTING("state-dir", state_dir, "DIR", "", valid_path, "the name of a directory", "where the database is kept"),
    SETTING("allowed-hosts", allowed_hosts, "NAMES", "", qg_hosts_are_valid,
            "a list of host names, with blanks or commas between them, or *",
            "names by which browsers may call this server, beside localhost and numeric addresses; * is any"),
    SETTING("threads", threads, "N", "0", valid_threads, "a whole number from 0 to 1024",
            "threads that compute; 0: one per processor"),
    SETTING("jobs", jobs, "N", "2", valid_jobs, "a whole number from 1 to 64", "jobs computed at the same time"),
    SETTING("web-dir", web_dir, "DIR", QG_WEB_DIR, valid_path, "the name of a directory", "the page's files"),
    SETTING("schema-dir", schema_dir, "DIR", QG_SCHEMA_DIR, valid_path, "the name of a directory", "the JSON Schemas"),
    SETTING("require-tokens", require_tokens, "WHEN", "auto", valid_requirement, "auto or always",
            "who needs an access token: auto, all but those on loopback; always, all"),
    SETTING("token-rate", token_rate, "N", "50", valid_rate, "a whole number from 0 to 100000",
            "requests a second that a token without a limit of its own may make; 0: any number"),
    SETTING("token-jobs", token_jobs, "N", "1000", valid_rate, "a whole number from 0 to 100000",
            "jobs that a token without a limit of its own may have queued or running; 0: any"),
    SETTING("tls-certificate", tls_certificate, "FILE", "", valid_path, "the name of a file",
            "PEM file with the certificate chain: HTTPS instead of HTTP"),
    SETTING("tls-key", tls_key, "FILE", "", valid_path, "the name of a file", "PEM file with the certificate's key"),
    SETTING("trusted-proxies", trusted_proxies, "LIST", "", qg_addresses_is_list,
            "a list of addresses and networks such as 127.0.0.1 10.1.0.0/16, and the word unix",
            "reverse proxies whose X-Forwarded-For is believed; with any, tokens are required"),
    SETTING("client-streams", client_streams, "N", "300", valid_streams, "a whole number from 0 to 1200",
            "event streams, and long polls, that a token, or an address without one, may hold; 0: any number"),
    SETTING("cors-origins", cors_origins, "LIST", "", qg_cors_is_list,
            "a list of origins such as https://plm.example.com", "origins whose pages may use the API"),
    SETTING("webhook-allow", webhook_allow, "LIST", "", qg_url_rules_is_list,
            "a list of URLs such as https://plm.example.com/hooks or https://*.example.com",
            "beginnings of the URLs that webhooks may have"),
    SETTING("webhook-networks", webhook_networks, "LIST", "", qg_networks_is_list,
            "a list of networks such as 10.1.0.0/16, of one address 10.1.0.7/32",
            "private networks that webhooks may reach"),
    SETTING("webhook-retry", webhook_retry, "SECONDS", "5", valid_wait, "a whole number from 1 to 3600",
            "when a webhook is first tried again; four times as long each time after"),
    SETTING("keep-log-days", keep_log_days, "N", "365", valid_days, "a whole number from 1 to 36500",
            "days that the audit log and finished deliveries are kept"),
    SETTING("keep-jobs-days", keep_jobs_days, "N", "0", valid_days_or_none, "a whole number from 0 to 36500",
            "days that finished jobs are kept; 0: forever"),
    SETTING("keep-evaluations-days", keep_evaluations_days, "N", "0", valid_days_or_none,
            "a whole number from 0 to 36500", "days that the evaluations of finished jobs are kept; 0: forever"),
    SETTING("keep-jobs", keep_jobs, "N", "0", valid_amount, "a whole number from 0 to 1000000000",
            "finished jobs that are kept; 0: any number"),
    SETTING("keep-megabytes", keep_megabytes, "N", "0", valid_amount, "a whole number from 0 to 1000000000",
            "size of the database from which on the oldest finished jobs are dropped; 0: any"),
    SETTING("max-job-cost", max_job_cost, "SECONDS", "604800", valid_amount, "a whole number from 0 to 1000000000",
            "estimated time from which on a job is refused; 0: any"),
    SETTING(
        "max-job-memory", max_job_memory, "MEGABYTES", "auto", valid_memory,
        "auto, or a whole number from 0 to 1000000000",
        "estimated memory from which on a job is refused; auto: half of what there is, shared among the jobs computed "
        "at the same time; 0: any"),
    SETTING(
        "log-format", log_format, "FORMAT", "auto", valid_log_format, "auto, text or json",
        "how stderr is written: auto, entries for the journal where it is that, else text; text, lines; json, a JSON "
        "object a line"),
    SETTING("log-level", log_level, "LEVEL", "info", valid_log_level, "error, warning, notice, info or debug",
            "what is logged: error, warning, notice, info or debug, and what is worse"),
    SETTING("access-log", access_log, "SWITCH", "off", valid_switch, "on or off", "on: log each request"),
};
enum { SETTING_COUNT = sizeof settings / sizeof settings[0] };

/* What is being put together. */
struct loading {
    struct qg_settings *config;
    struct qg_text *message;
    bool given[SETTING_COUNT]; /* by a flag: the file does not change it */
    int line[SETTING_COUNT];   /* of the file that the setting stands in; 0 */
    const char *file;          /* of --config */
    bool check_only;
    enum qg_settings_action action;
};

static const struct setting *find_setting(const char *name) {
    for (size_t i = 0; i < SETTING_COUNT; i++)
        if (strcmp(settings[i].name, name) == 0)
            return &settings[i];
    return NULL;
}

static char *value_of(struct qg_settings *config, const struct setting *setting) {
    return (char *)config + setting->offset;
}

/* Sets one setting; place says where the value stands ("--jobs", "FILE:3: jobs"). False and a message when it is wrong. */
static bool set(struct loading *loading, const struct setting *setting, const char *place, const char *value) {
    errno = 0;
    if (strlen(value) >= QG_SETTING_ROOM || !setting->valid(value)) {
        loading->message->failed |= errno == ENOMEM;
        qg_text_format(loading->message, "%s: found \"%.100s\", allowed is %s\n", place, value, setting->allowed);
        return false;
    }
    strcpy(value_of(loading->config, setting), value);
    return true;
}

bool qg_settings_split_address(const char *listen, char *address, char *port, size_t room) {
    const char *colon = strrchr(listen, ':');
    if (!colon || strlen(listen) >= room)
        return false;
    size_t length = (size_t)(colon - listen);
    if (length > 2 && listen[0] == '[' && colon[-1] == ']') {
        listen++;
        length -= 2;
    } else if (memchr(listen, ':', length)) {
        return false;
    }
    memcpy(address, listen, length);
    address[length] = '\0';
    strcpy(port, colon + 1);
    return length > 0 && *port;
}

static void list_names(struct qg_text *message) {
    for (size_t i = 0; i < SETTING_COUNT; i++)
        qg_text_format(message, "%s%s", i ? ", " : "", settings[i].name);
}

static char *trim(char *text) {
    while (*text == ' ' || *text == '\t')
        text++;
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t\r\n", text[length - 1]))
        text[--length] = '\0';
    return text;
}

static bool read_line(struct loading *loading, const char *file, int number, char *line) {
    line = trim(line);
    if (!*line || *line == '#')
        return true;
    char *value = strchr(line, '=');
    if (!value) {
        qg_text_format(loading->message, "%s:%d: \"%.100s\" is not of the form \"name = value\"\n", file, number, line);
        return false;
    }
    *value++ = '\0';
    const char *name = trim(line);
    const struct setting *setting = find_setting(name);
    if (!setting) {
        qg_text_format(loading->message, "%s:%d: unknown setting \"%.100s\"; allowed are ", file, number, name);
        list_names(loading->message);
        qg_text_format(loading->message, "\n");
        return false;
    }
    int *first = &loading->line[setting - settings];
    if (*first) {
        qg_text_format(loading->message, "%s:%d: %s: stands in line %d already, allowed is one line for each setting\n",
                       file, number, name, *first);
        return false;
    }
    *first = number;
    if (loading->given[setting - settings])
        return true;
    char place[QG_SETTING_ROOM + 64];
    snprintf(place, sizeof place, "%s:%d: %s", file, number, name);
    return set(loading, setting, place, trim(value));
}

static bool read_lines(struct loading *loading, const char *file, FILE *stream) {
    bool right = true;
    char *line = NULL;
    size_t room = 0;
    for (int number = 1; getline(&line, &room, stream) >= 0; number++)
        right = read_line(loading, file, number, line) && right;
    if (ferror(stream)) {
        qg_text_format(loading->message, "%s: cannot be read\n", file);
        right = false;
    }
    free(line);
    return right;
}

/* The config file: the one named by --config has to exist, the installed one need not. */
static bool read_file(struct loading *loading) {
    const char *file = loading->file ? loading->file : QG_CONFIG_FILE;
    FILE *stream = fopen(file, "re");
    if (!stream && errno == ENOENT && !loading->file)
        return true;
    if (!stream) {
        loading->message->failed |= errno == ENOMEM; /* not the file's fault: exit status 1 */
        qg_text_format(loading->message, "%s: %s\n", file, strerror(errno));
        return false;
    }
    bool right = read_lines(loading, file, stream);
    fclose(stream);
    return right;
}

static void write_help(struct qg_text *message) {
    qg_text_format(message, "Usage: quietgeard [--SETTING VALUE]... [--config FILE] [--check-config]\n\n"
                            "Serves gear pair optimization over HTTP.\n\n");
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        char flag[64];
        snprintf(flag, sizeof flag, "--%s %s", settings[i].name, settings[i].argument);
        qg_text_format(message, "  %-24s %s", flag, settings[i].help);
        if (*settings[i].standard)
            qg_text_format(message, " (default: %s)", settings[i].standard);
        qg_text_format(message, "\n");
    }
    qg_text_format(
        message,
        "  --config FILE            read settings from FILE, one \"name = value\" a line, names as above\n"
        "                           (default: %s, if it exists)\n"
        "  --new-admin-token        make an admin token at this start and write it to STATE-DIR/admin.token;\n"
        "                           without it that happens when there is no admin token yet\n"
        "  --restore FILE           put a backup (quietgear backup FILE) in the place of the state directory's\n"
        "                           database, while no daemon works there; keep that one beside it; exit\n"
        "  --check-config           check flags and config file, say what is wrong, and exit\n"
        "  --help, --version        this text; the version\n\n"
        "The state directory is $STATE_DIRECTORY, %s for root, or else\n"
        "${XDG_STATE_HOME:-~/.local/state}/quietgear.\n",
        QG_CONFIG_FILE, QG_STATE_DIR);
}

/* A flag without a value. True when it was one; the first of --help and --version decides. */
static bool plain_flag(struct loading *loading, const char *name) {
    if (strcmp(name, "help") == 0)
        loading->action = QG_SETTINGS_HELP;
    else if (strcmp(name, "version") == 0)
        loading->action = QG_SETTINGS_VERSION;
    else if (strcmp(name, "check-config") == 0)
        loading->check_only = true;
    else if (strcmp(name, "new-admin-token") == 0)
        loading->config->new_admin_token = true;
    else
        return false;
    return true;
}

static bool take_flag(struct loading *loading, const char *name, const char *value) {
    if (strcmp(name, "config") == 0) {
        loading->file = value;
        return true;
    }
    if (strcmp(name, "restore") == 0) {
        loading->config->restore_file = value;
        return true;
    }
    const struct setting *setting = find_setting(name);
    loading->given[setting - settings] = true;
    char place[64];
    snprintf(place, sizeof place, "--%s", name);
    return set(loading, setting, place, value);
}

/* One flag at argv[*i], with its value behind '=' or in the next argument. */
static bool read_flag(struct loading *loading, int argc, char *const *argv, int *i) {
    char name[32];
    const char *argument = argv[*i];
    const char *equals = strchr(argument, '=');
    size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
    if (length < 3 || length - 2 >= sizeof name || strncmp(argument, "--", 2) != 0)
        length = 2;
    snprintf(name, sizeof name, "%.*s", (int)(length - 2), argument + (length > 2 ? 2 : 0));
    if (!equals && plain_flag(loading, name))
        return true;
    if (strcmp(name, "config") != 0 && strcmp(name, "restore") != 0 && !find_setting(name)) {
        qg_text_format(loading->message, "%.100s: unknown flag; see --help\n", argument);
        return false;
    }
    if (!equals && *i + 1 == argc) {
        qg_text_format(loading->message, "--%s: a value is missing\n", name);
        return false;
    }
    return take_flag(loading, name, equals ? equals + 1 : argv[++*i]);
}

static bool read_flags(struct loading *loading, int argc, char *const *argv) {
    bool right = true;
    for (int i = 1; i < argc && loading->action == QG_SETTINGS_RUN; i++)
        right = read_flag(loading, argc, argv, &i) && right;
    return right;
}

static bool default_state_dir(struct loading *loading) {
    char *directory = loading->config->state_dir;
    const char *given = getenv("STATE_DIRECTORY"), *state_home = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    int length = -1;
    if (given && *given)
        length = snprintf(directory, QG_SETTING_ROOM, "%s", given);
    else if (geteuid() == 0)
        length = snprintf(directory, QG_SETTING_ROOM, "%s", QG_STATE_DIR);
    else if (state_home && *state_home == '/')
        length = snprintf(directory, QG_SETTING_ROOM, "%s/quietgear", state_home);
    else if (home && *home == '/')
        length = snprintf(directory, QG_SETTING_ROOM, "%s/.local/state/quietgear", home);
    if (length < 0 || length >= QG_SETTING_ROOM)
        qg_text_format(loading->message, "state-dir: not given, and there is no usable $HOME to put it under\n");
    return length >= 0 && length < QG_SETTING_ROOM;
}

/* Certificate and key come together, and belong together. */
static bool check_tls(struct loading *loading) {
    const struct qg_settings *config = loading->config;
    if (!*config->tls_certificate && !*config->tls_key)
        return true;
    if (!*config->tls_certificate || !*config->tls_key) {
        qg_text_format(loading->message, "tls-certificate and tls-key: one is given without the other\n");
        return false;
    }
    struct qg_tls *tls = qg_tls_create(config->tls_certificate, config->tls_key, loading->message);
    bool right = tls;
    qg_tls_destroy(tls);
    return right;
}

/* What a job may take by default, MB: half of what there is, for each of the jobs at a time. The other half is the program's
 * own, its caches' and its clients'. */
static int share_of_memory(int jobs) {
    double megabytes = floor(qg_machine_memory() / 2 / jobs / 1e6);
    return megabytes < 1 ? 1 : megabytes > 1e9 ? 1000000000 : (int)megabytes;
}

/* What follows from the settings. */
static bool derive(struct loading *loading) {
    struct qg_settings *config = loading->config;
    size_t listen = (size_t)(find_setting("listen") - settings);
    config->listen_given = loading->given[listen] || loading->line[listen] > 0;
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    int threads = (int)strtol(config->threads, NULL, 10);
    config->thread_count = threads > 0 ? threads : processors > 0 ? (int)processors : 1;
    config->job_count = (int)strtol(config->jobs, NULL, 10);
    config->token_rate_count = (int)strtol(config->token_rate, NULL, 10);
    config->token_jobs_count = (int)strtol(config->token_jobs, NULL, 10);
    config->client_stream_count = (int)strtol(config->client_streams, NULL, 10);
    config->keep_log_day_count = (int)strtol(config->keep_log_days, NULL, 10);
    config->webhook_retry_s = (int)strtol(config->webhook_retry, NULL, 10);
    config->max_job_cost_s = (int)strtol(config->max_job_cost, NULL, 10);
    config->max_job_memory_mb = strcmp(config->max_job_memory, "auto") == 0
                                    ? share_of_memory(config->job_count)
                                    : (int)strtol(config->max_job_memory, NULL, 10);
    config->retention = (struct qg_retention){
        .job_days = (int)strtol(config->keep_jobs_days, NULL, 10),
        .evaluation_days = (int)strtol(config->keep_evaluations_days, NULL, 10),
        .jobs = (int)strtol(config->keep_jobs, NULL, 10),
        .megabytes = (int)strtol(config->keep_megabytes, NULL, 10),
    };
    qg_log_format_read(config->log_format, &config->log.format);
    qg_log_level_read(config->log_level, &config->log.level);
    config->logs_requests = strcmp(config->access_log, "on") == 0;
    if (!check_tls(loading))
        return false;
    return *config->state_dir || default_state_dir(loading);
}

static bool directory_exists(const char *name, const char *path, struct qg_text *message) {
    struct stat status;
    int error = stat(path, &status) != 0 ? errno : S_ISDIR(status.st_mode) ? 0 : ENOTDIR;
    if (!error && access(path, R_OK | X_OK) != 0)
        error = errno;
    message->failed |= error == ENOMEM;
    if (error)
        qg_text_format(message, "%s: found \"%.100s\" (%s), allowed is a directory that can be read\n", name, path,
                       strerror(error));
    return !error;
}

bool qg_settings_exist(const struct qg_settings *config, struct qg_text *message) {
    bool page = directory_exists("web-dir", config->web_dir, message);
    return directory_exists("schema-dir", config->schema_dir, message) && page;
}

enum qg_settings_action qg_settings_load(int argc, char *const *argv, struct qg_settings *config,
                                         struct qg_text *message) {
    struct loading loading = {.config = config, .message = message, .action = QG_SETTINGS_RUN};
    memset(config, 0, sizeof *config);
    for (size_t i = 0; i < SETTING_COUNT; i++)
        strcpy(value_of(config, &settings[i]), settings[i].standard);
    bool right = read_flags(&loading, argc, argv);
    if (loading.action == QG_SETTINGS_HELP)
        write_help(message);
    else if (loading.action == QG_SETTINGS_VERSION)
        qg_text_format(message, "quietgeard %s\n", PACKAGE_VERSION);
    if (loading.action != QG_SETTINGS_RUN)
        return loading.action;
    right = read_file(&loading) && right;
    if (!right || !derive(&loading))
        return QG_SETTINGS_WRONG;
    if (loading.check_only)
        return QG_SETTINGS_CHECKED;
    return config->restore_file ? QG_SETTINGS_RESTORE : QG_SETTINGS_RUN;
}
