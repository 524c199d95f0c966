/* Reading documents and writing results, whole or not at all. */
#include "cli/files.h"

#include <errno.h>
#include <fcntl.h>
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

bool qg_output_open(struct qg_output *output, const char *path) {
    *output = (struct qg_output){.path = path, .descriptor = -1};
    if (!path)
        return true;
    if (asprintf(&output->temporary, "%s.XXXXXX", path) < 0) {
        output->temporary = NULL;
        return false;
    }
    output->descriptor = mkostemp(output->temporary, O_CLOEXEC);
    if (output->descriptor >= 0)
        return true;
    free(output->temporary);
    output->temporary = NULL;
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

bool qg_output_commit(struct qg_output *output, const char *data, size_t length) {
    if (!output->path)
        return write_all(STDOUT_FILENO, data, length);
    bool good = write_all(output->descriptor, data, length) && fchmod(output->descriptor, usual_mode()) == 0 &&
                fsync(output->descriptor) == 0;
    good = close(output->descriptor) == 0 && good;
    output->descriptor = -1;
    good = good && rename(output->temporary, output->path) == 0;
    if (good) {
        free(output->temporary);
        output->temporary = NULL;
    }
    const int error = errno;
    qg_output_discard(output);
    errno = error;
    return good;
}

void qg_output_discard(struct qg_output *output) {
    if (output->descriptor >= 0)
        close(output->descriptor);
    if (output->temporary) {
        unlink(output->temporary);
        free(output->temporary);
    }
    output->temporary = NULL;
    output->descriptor = -1;
}
