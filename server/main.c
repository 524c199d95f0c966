/* quietgeard: settings, start, signals, stop.
 *
 * Started from the bottom up: store, computing threads, board, runner, HTTP; and stopped from the top down. SIGTERM and
 * SIGINT stop it: no new connections, running studies break off at their next piece and go back into the queue, long polls
 * are answered, and the next start continues from the logs. SIGHUP has the TLS certificate read again.
 * Exit status: 0 stopped as asked, 1 could not start, 2 wrong settings.
 */
#include <config.h>
#include <curl/curl.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <ucontext.h>
#include <unistd.h>

#include "core/pool.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/systemd.h"
#include "server/calls/table.h"
#include "server/http/http.h"
#include "server/http/tls.h"
#include "server/listener.h"
#include "server/settings.h"
#include "server/store/access.h"
#include "server/store/backup.h"
#include "server/work/field_maker.h"
#include "server/work/metrics.h"
#include "server/work/sender.h"
#include "server/work/watchdog.h"

/* Compliances kept from job to job: some thirty gears. */
enum { CACHE_BYTES = 256 << 20 };

/* All parts of the running daemon; NULL where not started. */
struct server {
    struct qg_pool *pool;
    struct qg_cache *cache;
    struct qg_service service;
    struct qg_sender *sender;
    struct qg_keeper *keeper;
    struct qg_http *http;
    struct qg_watchdog *watchdog;
};

/* Says so when systemd's socket has another address than the setting. */
static void warn_of_other_address(const struct qg_settings *settings, int listener) {
    char address[128];
    qg_listener_describe(listener, "", address, sizeof address);
    if (settings->listen_given && strcmp(address + strlen("://"), settings->listen) != 0)
        qg_log(QG_LOG_WARNING,
               "listen = %s has no effect, the socket that systemd handed over is used: change ListenStream= of "
               "quietgeard.socket",
               settings->listen);
}

/* The socket handed over, or one of our own; -1 after a logged failure. */
static int open_listener(const struct qg_settings *settings) {
    char message[QG_SETTING_ROOM + 256];
    int listener = qg_systemd_socket();
    if (listener == -2) {
        qg_log(QG_LOG_ERROR, "systemd handed over several sockets; one is understood");
        return -1;
    }
    if (listener >= 0) {
        warn_of_other_address(settings, listener);
        return listener;
    }
    listener = qg_listener_open(settings->listen, message, sizeof message);
    if (listener < 0)
        qg_log(QG_LOG_ERROR, "cannot listen: %s", message);
    return listener;
}

/* Tells where it listens: the log, the port file, systemd. */
static bool announce(struct server *server, const struct qg_settings *settings, int listener) {
    char address[128];
    int port = qg_listener_describe(listener, *settings->tls_certificate ? "https" : "http", address, sizeof address);
    if (*settings->port_file && qg_listener_write_port(settings->port_file, port) != 0) {
        qg_log(QG_LOG_ERROR, "%s: the port cannot be written there", settings->port_file);
        return false;
    }
    qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE, .event = QG_EVENT_DAEMON_STARTED},
                 "listening on %s, %d computing threads, %d jobs at a time of up to %d MB each%s, state in %s", address,
                 settings->thread_count, settings->job_count, settings->max_job_memory_mb,
                 settings->max_job_memory_mb ? "" : " (any)", settings->state_dir);
    struct qg_vital_signs signs = {.runner = server->service.runner};
    if (port > 0)
        snprintf(signs.url, sizeof signs.url, "%s/healthz", address);
    qg_systemd_notify("READY=1");
    server->watchdog = qg_watchdog_start(&signs);
    return true;
}

/* What computes: store, threads, board, runner. */
static bool start_service(struct server *server, const struct qg_settings *settings) {
    char message[QG_STORE_MESSAGE_ROOM];
    struct qg_service *service = &server->service;
    service->web_dir = settings->web_dir;
    service->schema_dir = settings->schema_dir;
    service->allowed_hosts = settings->allowed_hosts;
    service->thread_count = settings->thread_count;
    service->job_cost_max = settings->max_job_cost_s;
    service->logs_requests = settings->logs_requests;
    service->job_memory_max = settings->max_job_memory_mb;
    service->store = qg_store_open(settings->state_dir, message);
    if (!service->store) {
        qg_log(QG_LOG_ERROR, "%s", message);
        return false;
    }
    server->pool = qg_pool_create(settings->thread_count);
    server->cache = qg_cache_create(CACHE_BYTES);
    service->board = qg_board_create();
    service->job_copies = service->board ? qg_job_copies_create(service->store, service->board) : NULL;
    service->routes = &qg_calls;
    service->metrics = qg_metrics_create(qg_calls.count);
    service->backups = qg_backups_create(settings->state_dir);
    if (server->pool && server->cache && service->job_copies && service->metrics && service->backups) {
        const struct qg_workplace workplace = {
            .store = service->store,
            .board = service->board,
            .means = {.executor = qg_pool_executor(server->pool),
                      .cache = server->cache,
                      .operator_bytes_max = service->job_memory_max * 1e6},
            .metrics = service->metrics,
        };
        service->runner = qg_runner_start(&workplace, settings->job_count);
        service->field_maker = qg_field_maker_start(&workplace.means);
    }
    if (!service->runner || !service->field_maker)
        qg_log(QG_LOG_ERROR, "cannot start the computing threads");
    return service->runner && service->field_maker;
}

/* Who may do what. Tokens are needed unless only this machine can connect, and no proxy on it brings others. */
static bool start_access(struct server *server, const struct qg_settings *settings, bool is_loopback) {
    struct qg_service *service = &server->service;
    const struct qg_access_options options = {
        .required = !is_loopback || strcmp(settings->require_tokens, "always") == 0 || *settings->trusted_proxies,
        .rate = settings->token_rate_count,
        .queue = settings->token_jobs_count,
        .keep_days = settings->keep_log_day_count,
    };
    service->trusted_proxies = settings->trusted_proxies;
    service->client_stream_max = settings->client_stream_count;
    service->cors_origins = settings->cors_origins;
    service->webhook_rules = settings->webhook_allow;
    service->webhook_networks = settings->webhook_networks;
    service->access = qg_access_open(service->store, &options);
    if (!is_loopback && !*settings->tls_certificate)
        qg_log(QG_LOG_WARNING,
               "tokens and jobs cross the network in the clear: set tls-certificate and tls-key, or listen "
               "on loopback behind a proxy that has them");
    return service->access && qg_access_bootstrap(service->access, settings->state_dir, settings->new_admin_token);
}

static void tidy(void *access) {
    qg_access_tidy(access);
}

/* Who tells others of what happens, and who drops what is old. */
static bool start_helpers(struct server *server, const struct qg_settings *settings) {
    const struct qg_sender_options options = {
        .rules = settings->webhook_allow,
        .networks = settings->webhook_networks,
        .first_wait = settings->webhook_retry_s,
        .keep_log_days = settings->keep_log_day_count,
        .metrics = server->service.metrics,
    };
    server->sender = qg_sender_start(server->service.store, &options);
    server->keeper = qg_keeper_start(server->service.store, server->service.board, &settings->retention,
                                     (struct qg_chore){.run = tidy, .self = server->service.access});
    if (!server->sender || !server->keeper)
        qg_log(QG_LOG_ERROR, "cannot start the threads that deliver webhooks and drop old jobs");
    return server->sender && server->keeper;
}

/* Logs each line of a message as an error. */
static void log_lines(const struct qg_text *message) {
    const char *line = message->data ? message->data : "there is not enough memory for the certificate";
    for (size_t length; *line; line += length + (line[length] != '\0')) {
        length = strcspn(line, "\n");
        qg_log(QG_LOG_ERROR, "%.*s", (int)length, line);
    }
}

/* Logs that the certificate was read, and until when it is good. */
static void log_certificate(struct qg_tls *tls, const char *deed) {
    char until[QG_TIME_ROOM];
    int64_t end = qg_tls_valid_until(tls);
    bool is_over = end < qg_wall_clock();
    qg_time_print(until, end);
    qg_log_event(
        &(struct qg_log_event){.priority = is_over ? QG_LOG_WARNING : QG_LOG_NOTICE, .event = QG_EVENT_CERTIFICATE},
        "certificate: %s, %s %s", deed, is_over ? "expired since" : "valid until", until);
}

/* Reads certificate and key, if there are any. */
static bool load_tls(struct server *server, const struct qg_settings *settings) {
    struct qg_text message = {0};
    if (!*settings->tls_certificate)
        return true;
    server->service.tls = qg_tls_create(settings->tls_certificate, settings->tls_key, &message);
    if (server->service.tls)
        log_certificate(server->service.tls, "read");
    else
        log_lines(&message);
    qg_text_finish(&message);
    return server->service.tls;
}

/* Reads certificate and key again: they may have been renewed. */
static void reload(struct server *server) {
    struct qg_text message = {0};
    if (!server->service.tls) {
        qg_log(QG_LOG_NOTICE, "reload: there is no certificate to read again");
        return;
    }
    if (qg_tls_reload(server->service.tls, &message)) {
        log_certificate(server->service.tls, "read again");
        qg_store_note(server->service.store, NULL, "daemon.reload", "certificate");
    } else {
        log_lines(&message);
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_ERROR, .event = QG_EVENT_CERTIFICATE},
                     "reload: the certificate of before stays in use");
    }
    qg_text_finish(&message);
}

static bool start(struct server *server, const struct qg_settings *settings) {
    int listener = open_listener(settings);
    if (listener < 0)
        return false;
    if (!load_tls(server, settings) || !start_service(server, settings) ||
        !start_access(server, settings, qg_listener_is_loopback(listener)) || !start_helpers(server, settings)) {
        close(listener);
        return false;
    }
    server->http = qg_http_start(&server->service, listener);
    if (server->http) {
        qg_store_note(server->service.store, NULL, "daemon.start", PACKAGE_VERSION);
        return announce(server, settings, listener);
    }
    qg_log(QG_LOG_ERROR, "cannot start the HTTP server");
    close(listener);
    return false;
}

static void stop(struct server *server) {
    struct qg_service *service = &server->service;
    if (server->http)
        qg_store_note(service->store, NULL, "daemon.stop", PACKAGE_VERSION);
    qg_watchdog_stop(server->watchdog);
    qg_http_quiesce(server->http);
    if (service->runner)
        qg_runner_interrupt(service->runner);
    if (service->board)
        qg_board_shut(service->board);
    qg_http_stop(server->http);
    qg_runner_stop(service->runner);
    qg_field_maker_stop(service->field_maker);
    qg_sender_stop(server->sender);
    qg_keeper_stop(server->keeper);
    qg_backups_destroy(service->backups);
    qg_job_copies_destroy(service->job_copies);
    qg_board_destroy(service->board);
    qg_metrics_destroy(service->metrics);
    qg_pool_destroy(server->pool);
    qg_cache_destroy(server->cache);
    qg_access_close(service->access);
    qg_tls_destroy(service->tls);
    qg_store_close(service->store);
}

/* A signal that is obeyed has met a thread that does not block it: one that OpenBLAS started when it was loaded, before main.
 * From the handler's end on that thread blocks it, and the process is sent it again, for the thread that waits for it. Only
 * functions that are safe in a handler are called. */
static void pass_on(int number, siginfo_t *info, void *context) {
    ucontext_t *interrupted = context;
    int error = errno;
    (void)info;
    sigaddset(&interrupted->uc_sigmask, number);
    kill(getpid(), number);
    errno = error;
}

/* Blocks the signals that the daemon obeys in this thread and all to come; they are waited for instead. In threads that are
 * there already they are passed on: left to their default, they would end the daemon while nobody waits for them. */
static void hold_signals(sigset_t *obeyed) {
    const struct sigaction passing = {.sa_sigaction = pass_on, .sa_flags = SA_SIGINFO | SA_RESTART};
    sigemptyset(obeyed);
    sigaddset(obeyed, SIGTERM);
    sigaddset(obeyed, SIGINT);
    sigaddset(obeyed, SIGHUP);
    pthread_sigmask(SIG_BLOCK, obeyed, NULL);
    sigaction(SIGTERM, &passing, NULL);
    sigaction(SIGINT, &passing, NULL);
    sigaction(SIGHUP, &passing, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is a full disk, told by errno */
}

/* Serves until a signal says to stop; returns that signal. */
static int obey(struct server *server, const sigset_t *obeyed) {
    int number = 0;
    while (sigwait(obeyed, &number) == 0 && number == SIGHUP)
        reload(server);
    return number;
}

static int serve(const struct qg_settings *settings) {
    struct server server = {0};
    sigset_t obeyed;
    hold_signals(&obeyed);
    umask(0077);
    /* the computing threads, and the one that makes fields */
    if (!qg_numerics_init(settings->thread_count + 1)) {
        qg_log(QG_LOG_ERROR, "not enough memory for OpenBLAS: 128 MiB of addresses are needed for each thread");
        _exit(1);
    }
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) {
        qg_log(QG_LOG_ERROR, "not enough memory for libcurl");
        return 1;
    }
    bool started = start(&server, settings);
    if (started) {
        qg_log(QG_LOG_NOTICE, "stopping on signal %d", obey(&server, &obeyed));
        qg_systemd_notify("STOPPING=1");
    }
    stop(&server);
    curl_global_cleanup();
    if (started && *settings->port_file)
        unlink(settings->port_file);
    if (started)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_NOTICE, .event = QG_EVENT_DAEMON_STOPPED}, "stopped");
    return started ? 0 : 1;
}

static int restore(const struct qg_settings *settings) {
    char message[QG_STORE_MESSAGE_ROOM];
    umask(0077);
    if (!qg_backup_restore(settings->state_dir, settings->restore_file, message)) {
        qg_log(QG_LOG_ERROR, "%s", message);
        return 1;
    }
    char before[QG_SETTING_ROOM + 32];
    snprintf(before, sizeof before, "%s/quietgear.db.before-restore", settings->state_dir);
    qg_log(QG_LOG_NOTICE, "%s is restored; %s", settings->state_dir,
           access(before, F_OK) == 0 ? "what was there is quietgear.db.before-restore" : "no database was there");
    return 0;
}

int main(int argc, char **argv) {
    static struct qg_settings settings;
    struct qg_text message = {0};
    int status = 0;
    enum qg_settings_action action = qg_settings_load(argc, argv, &settings, &message);
    if ((action == QG_SETTINGS_RUN || action == QG_SETTINGS_CHECKED) && !qg_settings_exist(&settings, &message))
        action = QG_SETTINGS_WRONG;
    switch (action) {
    case QG_SETTINGS_RUN:
    case QG_SETTINGS_RESTORE:
        qg_log_open(&settings.log);
        status = action == QG_SETTINGS_RUN ? serve(&settings) : restore(&settings);
        qg_log_close();
        break;
    case QG_SETTINGS_CHECKED:
        break;
    case QG_SETTINGS_HELP:
    case QG_SETTINGS_VERSION:
        fputs(message.data, stdout);
        break;
    case QG_SETTINGS_WRONG:
        fputs(message.failed || !message.data ? "out of memory\n" : message.data, stderr);
        status = message.failed || !message.data ? 1 : 2;
        break;
    }
    qg_text_finish(&message);
    return status;
}
