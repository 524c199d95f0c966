/* Job documents read and checked for the commands that work here, without a daemon. */
#include "cli/job.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/files.h"
#include "cli/words.h"

static void print_faults(const char *path, const struct qg_faults *faults) {
    for (size_t i = 0; i < faults->count; i++)
        qg_print_fault(path, faults->item[i].pointer, faults->item[i].detail);
    if (faults->lost)
        fprintf(stderr, "%s: and %zu more\n", qg_shown_name(path), faults->lost);
}

void qg_print_warnings(const char *path, const struct qg_notes *warnings, size_t first) {
    for (size_t i = first; i < warnings->count; i++) {
        char pointer[QG_POINTER_ROOM];
        qg_document_pointer(warnings->item[i].where, pointer);
        fprintf(stderr, "%s: warning: %s%s%s\n", qg_shown_name(path), pointer, pointer[0] ? ": " : "",
                warnings->item[i].text);
    }
}

/* Reads and checks the document; says what is wrong with it. Returns an exit status. */
static int read_job(const char *path, struct qg_job *job) {
    struct qg_notes warnings = {0};
    size_t length;
    char *bytes = qg_file_read(path, QG_DOCUMENT_BYTES_MAX, &length);
    if (!bytes) {
        const int error = errno;
        fprintf(stderr, "%s: %s\n", qg_shown_name(path), strerror(error));
        return error == ENOMEM ? QG_EXIT_FAILED : QG_EXIT_WRONG_INPUT;
    }
    struct qg_faults *faults = malloc(sizeof *faults);
    const enum qg_document_status status =
        faults ? qg_document_read(bytes, length, job, faults, &warnings) : QG_DOCUMENT_NO_MEMORY;
    free(bytes);
    if (status == QG_DOCUMENT_OK)
        qg_print_warnings(path, &warnings, 0);
    else if (status != QG_DOCUMENT_NO_MEMORY)
        print_faults(path, faults);
    free(faults);
    if (status != QG_DOCUMENT_NO_MEMORY)
        return status == QG_DOCUMENT_OK ? QG_EXIT_DONE : QG_EXIT_WRONG_INPUT;
    fprintf(stderr, "%s: %s\n", qg_shown_name(path), qg_status_text(QG_OUT_OF_MEMORY));
    return QG_EXIT_FAILED;
}

int qg_with_job(const struct qg_options *options,
                int (*command)(const struct qg_options *options, const struct qg_job *job)) {
    struct qg_job *job = malloc(sizeof *job);
    if (!job) {
        fprintf(stderr, "quietgear: %s\n", qg_status_text(QG_OUT_OF_MEMORY));
        return QG_EXIT_FAILED;
    }
    int status = read_job(options->subject, job);
    if (status == QG_EXIT_DONE)
        status = command(options, job);
    free(job);
    return status;
}
