/* Reading documents and writing results, whole or not at all. */
#include "cli/files.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Reads until the end or until most + 1 bytes are there. */
static char *read_stream(FILE *stream, size_t most, size_t *length) {
    char *bytes = malloc(most + 1);
    if (!bytes)
        return NULL;
    *length = fread(bytes, 1, most + 1, stream);
    if (ferror(stream)) {
        free(bytes);
        return NULL;
    }
    return bytes;
}

char *qg_file_read(const char *path, size_t most, size_t *length) {
    if (strcmp(path, "-") == 0)
        return read_stream(stdin, most, length);
    FILE *file = fopen(path, "rbe");
    if (!file)
        return NULL;
    char *bytes = read_stream(file, most, length);
    const int error = errno;
    fclose(file);
    errno = error;
    return bytes;
}

/* The file that a path leads to: through symbolic links, when it is there already. The caller frees it; NULL: no memory. */
static char *place_of(const char *path) {
    char *place = realpath(path, NULL);
    return place ? place : strdup(path);
}

/* A temporary file beside the place. */
static bool open_beside(struct qg_output *output) {
    if (asprintf(&output->temporary, "%s.XXXXXX", output->place) < 0) {
        output->temporary = NULL;
        errno = ENOMEM;
        return false;
    }
    output->descriptor = mkostemp(output->temporary, O_CLOEXEC);
    if (output->descriptor >= 0)
        return true;
    free(output->temporary);
    output->temporary = NULL;
    return false;
}

/* Closes and removes the temporary file. */
static void close_beside(struct qg_output *output) {
    if (output->descriptor >= 0)
        close(output->descriptor);
    output->descriptor = -1;
    if (output->temporary)
        unlink(output->temporary);
    free(output->temporary);
    output->temporary = NULL;
}

bool qg_output_open(struct qg_output *output, const char *path) {
    struct stat there;
    *output = (struct qg_output){.path = path, .descriptor = -1};
    if (!path)
        return true;
    if (stat(path, &there) == 0 && !S_ISREG(there.st_mode)) {
        output->descriptor = open(path, O_WRONLY | O_CLOEXEC);
        return output->descriptor >= 0;
    }
    output->place = place_of(path);
    if (output->place && open_beside(output)) {
        close_beside(output);
        return true;
    }
    const int error = output->place ? errno : ENOMEM;
    qg_output_discard(output);
    errno = error;
    return false;
}

static bool write_all(int descriptor, const char *data, size_t length) {
    while (length > 0) {
        const ssize_t n = write(descriptor, data, length);
        if (n < 0 && errno != EINTR)
            return false;
        if (n > 0) {
            data += n;
            length -= (size_t)n;
        }
    }
    return true;
}

/* The permissions that a plainly created file would have got. */
static mode_t usual_mode(void) {
    const mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

/* Writes the file at output's place: beside it first, to the disk, then under its name. */
static bool write_file(struct qg_output *output, const struct qg_filling *filling) {
    bool good = open_beside(output) && filling->fill(output->descriptor, filling->self) &&
                fchmod(output->descriptor, filling->secret ? 0600 : usual_mode()) == 0 &&
                fsync(output->descriptor) == 0 && rename(output->temporary, output->place) == 0;
    const int error = errno;
    if (good) {
        free(output->temporary);
        output->temporary = NULL;
    }
    close_beside(output);
    errno = error;
    return good;
}

/* Signals that people end programs by. They are held back for the whole process by a handler: a mask holds for one thread,
 * and libraries have threads of their own, which would take the signal and end the program all the same. */
static const int ending_signals[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
enum { ENDING_SIGNALS = sizeof ending_signals / sizeof ending_signals[0] };

/* The signal that came while they were held back, 0 before one. A handler has no other way to tell. */
static volatile sig_atomic_t held_signal;

static void hold(int signal_number) {
    held_signal = signal_number;
}

static void hold_signals(struct sigaction before[ENDING_SIGNALS]) {
    const struct sigaction holding = {.sa_handler = hold, .sa_flags = SA_RESTART};
    held_signal = 0;
    for (size_t i = 0; i < ENDING_SIGNALS; i++) {
        sigaction(ending_signals[i], NULL, &before[i]);
        if (before[i].sa_handler != SIG_IGN)
            sigaction(ending_signals[i], &holding, NULL);
    }
}

/* Lets them work again, that which has come first of all. */
static void release_signals(const struct sigaction before[ENDING_SIGNALS]) {
    for (size_t i = 0; i < ENDING_SIGNALS; i++)
        sigaction(ending_signals[i], &before[i], NULL);
    if (held_signal)
        raise(held_signal);
}

bool qg_is_to_end(void) {
    return held_signal != 0;
}

/* The same with those signals held back, so that no half of a file stays behind. */
static bool write_file_undisturbed(struct qg_output *output, const struct qg_filling *filling) {
    struct sigaction before[ENDING_SIGNALS];
    hold_signals(before);
    const bool good = write_file(output, filling);
    const int error = errno;
    release_signals(before);
    errno = error;
    return good;
}

bool qg_output_fill(struct qg_output *output, const struct qg_filling *filling) {
    if (!output->path)
        return filling->fill(STDOUT_FILENO, filling->self);
    if (output->place)
        return write_file_undisturbed(output, filling);
    const bool good = filling->fill(output->descriptor, filling->self);
    const int error = errno;
    const bool closed = close(output->descriptor) == 0;
    output->descriptor = -1;
    if (!good)
        errno = error;
    return good && closed;
}

/* A text to be written. */
struct text {
    const char *data;
    size_t length;
};

static bool write_text(int descriptor, void *self) {
    const struct text *text = self;
    return write_all(descriptor, text->data, text->length);
}

bool qg_output_commit(struct qg_output *output, const char *data, size_t length) {
    struct text text = {data, length};
    return qg_output_fill(output, &(struct qg_filling){.fill = write_text, .self = &text});
}

void qg_output_discard(struct qg_output *output) {
    close_beside(output);
    free(output->place);
    output->place = NULL;
}
