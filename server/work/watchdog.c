/* systemd's watchdog. See watchdog.h. */
#include "server/work/watchdog.h"

#include <curl/curl.h>
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/systemd.h"

struct qg_watchdog {
    struct qg_vital_signs signs;
    long interval; /* ms */
    pthread_t thread;
    pthread_mutex_t mutex; /* guards stopping */
    pthread_cond_t end;
    bool stopping;
};

static size_t drop(char *bytes, size_t size, size_t count, void *to) {
    (void)bytes;
    (void)to;
    return size * count;
}

/* True when the daemon answers a request in time. It is asked at its own address, so whose certificate it shows is no
 * question. */
static bool answers(const char *url, long patience) {
    long status = 0;
    CURL *curl = curl_easy_init();
    if (!curl)
        return true; /* memory is short: no reason to be restarted */
    curl_easy_setopt(curl, CURLOPT_URL, url);
    curl_easy_setopt(curl, CURLOPT_PROXY, "");
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, patience);
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYPEER, 0L);
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYHOST, 0L);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, drop);
    CURLcode code = curl_easy_perform(curl);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    curl_easy_cleanup(curl);
    if (status == 0)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_ERROR, .event = QG_EVENT_WATCHDOG},
                     "watchdog: %s does not answer: %s", url, curl_easy_strerror(code));
    return status != 0;
}

bool qg_vital_signs_are_good(const struct qg_vital_signs *signs, long patience) {
    const char *stuck = signs->runner ? qg_runner_stuck(signs->runner) : NULL;
    if (stuck)
        qg_log_event(&(struct qg_log_event){.priority = QG_LOG_ERROR, .event = QG_EVENT_WATCHDOG}, "watchdog: %s",
                     stuck);
    return !stuck && (!*signs->url || answers(signs->url, patience));
}

static void sleep_until_next(struct qg_watchdog *watchdog) {
    if (!watchdog->stopping)
        qg_condition_wait(&watchdog->end, &watchdog->mutex, qg_monotonic_clock() + watchdog->interval);
}

static void *watch(void *self) {
    struct qg_watchdog *watchdog = self;
    pthread_mutex_lock(&watchdog->mutex);
    while (!watchdog->stopping) {
        pthread_mutex_unlock(&watchdog->mutex);
        if (qg_vital_signs_are_good(&watchdog->signs, watchdog->interval))
            qg_systemd_notify("WATCHDOG=1");
        pthread_mutex_lock(&watchdog->mutex);
        sleep_until_next(watchdog);
    }
    pthread_mutex_unlock(&watchdog->mutex);
    return NULL;
}

/* Milliseconds in which systemd wants to hear of us; 0: never. */
static long wanted_interval(void) {
    const char *time = getenv("WATCHDOG_USEC"), *process = getenv("WATCHDOG_PID");
    if (!time || (process && strtol(process, NULL, 10) != (long)getpid()))
        return 0;
    long microseconds = strtol(time, NULL, 10);
    return microseconds > 0 ? microseconds / 1000 : 0;
}

struct qg_watchdog *qg_watchdog_start(const struct qg_vital_signs *signs) {
    long wanted = wanted_interval();
    struct qg_watchdog *watchdog = wanted >= 3 ? calloc(1, sizeof *watchdog) : NULL;
    if (!watchdog)
        return NULL;
    watchdog->signs = *signs;
    watchdog->interval = wanted / 3;
    qg_condition_init(&watchdog->end);
    pthread_mutex_init(&watchdog->mutex, NULL);
    if (pthread_create(&watchdog->thread, NULL, watch, watchdog) == 0)
        return watchdog;
    qg_log(QG_LOG_ERROR, "watchdog: there is no thread to be had");
    pthread_cond_destroy(&watchdog->end);
    pthread_mutex_destroy(&watchdog->mutex);
    free(watchdog);
    return NULL;
}

void qg_watchdog_stop(struct qg_watchdog *watchdog) {
    if (!watchdog)
        return;
    pthread_mutex_lock(&watchdog->mutex);
    watchdog->stopping = true;
    pthread_cond_signal(&watchdog->end);
    pthread_mutex_unlock(&watchdog->mutex);
    pthread_join(watchdog->thread, NULL);
    pthread_cond_destroy(&watchdog->end);
    pthread_mutex_destroy(&watchdog->mutex);
    free(watchdog);
}
