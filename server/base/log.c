/* The daemon's log on stderr. See log.h. */
#include "server/base/log.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LINE_ROOM = 1024 };

static void replace_control_characters(char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c < 0x20 || c == 0x7f)
            text[i] = '?';
    }
}

void qg_log_va(enum qg_priority priority, const char *format, va_list arguments) {
    char line[LINE_ROOM];
    int prefix = snprintf(line, sizeof line, "<%d>", (int)priority);
    vsnprintf(line + prefix, sizeof line - (size_t)prefix - 1, format, arguments);
    size_t length = strlen(line);
    if (line[length - 1] == '\n') /* libmicrohttpd's messages end a line themselves */
        length--;
    replace_control_characters(line, length);
    line[length] = '\n';
    ssize_t written = write(STDERR_FILENO, line, length + 1);
    (void)written; /* a log that cannot be written has nowhere to complain */
}

void qg_log(enum qg_priority priority, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    qg_log_va(priority, format, arguments);
    va_end(arguments);
}
