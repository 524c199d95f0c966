/* Words to people, and documents to where they belong. */
#include "cli/words.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "core/status.h"

const char *qg_shown_name(const char *path) {
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

void qg_print_plain(const char *utf8) {
    for (const unsigned char *at = (const unsigned char *)utf8; *at; at++) {
        const bool c1 = at[0] == 0xc2 && at[1] >= 0x80 && at[1] < 0xa0; /* U+0080 to U+009F in UTF-8 */
        if (c1)
            at++;
        if (c1 || *at < 0x20 || *at == 0x7f)
            fprintf(stderr, "\\u%04x", *at);
        else
            fputc(*at, stderr);
    }
}

void qg_print_fault(const char *document, const char *pointer, const char *detail) {
    fprintf(stderr, "%s: ", qg_shown_name(document));
    qg_print_plain(pointer);
    fputs(pointer[0] ? ": " : "", stderr);
    qg_print_plain(detail);
    fputc('\n', stderr);
}

bool qg_read_count(const char *place, const char *text, long most, long *out) {
    char *end;
    if (!text)
        return true;
    errno = 0;
    *out = strtol(text, &end, 10);
    if (*text >= '0' && *text <= '9' && !*end && !errno && *out >= 1 && *out <= most)
        return true;
    fprintf(stderr, "quietgear: %s: found \"%s\", allowed is a whole number from 1 to %ld\n", place, text, most);
    return false;
}

int qg_deliver(struct qg_text *text, struct qg_output *output) {
    if (text->length == 0 || text->data[text->length - 1] != '\n')
        qg_text_add(text, "\n", 1);
    if (text->failed) {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(QG_OUT_OF_MEMORY));
        return QG_EXIT_FAILED;
    }
    if (qg_output_commit(output, text->data, text->length))
        return QG_EXIT_DONE;
    fprintf(stderr, "%s: %s\n", output->path ? output->path : "standard output", strerror(errno));
    return QG_EXIT_FAILED;
}
