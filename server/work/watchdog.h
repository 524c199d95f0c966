/* systemd's watchdog: told that the daemon lives only when its parts have just been seen to work.
 *
 * A thread that says so every few seconds proves nothing but itself. So before each word a check asks the parts: an HTTP request
 * to the daemon's own address, through accept, the event loop, the routes and the database; and the runner, whose thread of
 * heartbeats has to turn and whose jobs have to give signs from within their computations. When a check fails or does not come
 * back nothing is said, and systemd restarts the daemon after WatchdogSec; jobs go on from their logs.
 */
#ifndef QG_SERVER_WORK_WATCHDOG_H
#define QG_SERVER_WORK_WATCHDOG_H

#include <stdbool.h>

#include "server/work/runner.h"

struct qg_watchdog;

/* What is looked at. */
struct qg_vital_signs {
    char url[160];            /* that has to answer, whatever it says; "": none */
    struct qg_runner *runner; /* NULL: none */
};

/* True when all of it works; else the reason is logged. Takes `patience` ms at most for the request. Threads: any. */
bool qg_vital_signs_are_good(const struct qg_vital_signs *signs, long patience);

/* Starts the thread when systemd wants to hear ($WATCHDOG_USEC, and $WATCHDOG_PID is this process or unset): it checks, and
 * tells, three times in that time. NULL when systemd does not, or when there is no thread to be had (logged). */
struct qg_watchdog *qg_watchdog_start(const struct qg_vital_signs *signs);

/* Stops it, after a check that is going on. NULL is allowed. To be called before what is looked at is stopped. */
void qg_watchdog_stop(struct qg_watchdog *watchdog);

#endif
