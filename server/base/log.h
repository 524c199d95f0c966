/* The daemon's log: one line per event on stderr, each opened by the journal's priority prefix "<N>".
 *
 * No timestamps: whoever collects stderr (the journal, a terminal, a file behind a logger) knows the time. No secrets and
 * no request bodies are ever logged.
 */
#ifndef QG_SERVER_BASE_LOG_H
#define QG_SERVER_BASE_LOG_H

#include <stdarg.h>

/* The priorities in use, numbered as in syslog(3). */
enum qg_priority { QG_LOG_ERROR = 3, QG_LOG_WARNING = 4, QG_LOG_NOTICE = 5, QG_LOG_INFO = 6, QG_LOG_DEBUG = 7 };

/* Writes one line, printf-like. Control characters in the text become '?', so that what a client sent cannot forge a
 * second line, but for a line end at the end; text beyond 1 KiB is cut. One write(2) a line. Threads: any. */
void qg_log(enum qg_priority priority, const char *format, ...) __attribute__((format(printf, 2, 3)));
void qg_log_va(enum qg_priority priority, const char *format, va_list arguments) __attribute__((format(printf, 2, 0)));

#endif
