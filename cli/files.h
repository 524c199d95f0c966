/* Files as the command line knows them: documents in, results out. */
#ifndef QG_CLI_FILES_H
#define QG_CLI_FILES_H

#include <stdbool.h>
#include <stddef.h>

/* A result file while it is being made: a temporary file beside it, which takes its name only when it is complete. What is
 * there already and no plain file (a device, a pipe) is written to instead, and never replaced. */
struct qg_output {
    const char *path; /* NULL: standard output */
    char *place;      /* path, symbolic links followed */
    char *temporary;  /* NULL: path is written to */
    int descriptor;
};

/* Reads a whole file, or standard input when path is "-", but not more than `most` bytes and one. Returns memory that the
 * caller frees, or NULL with errno set. */
char *qg_file_read(const char *path, size_t most, size_t *length);

/* Makes and removes a temporary file beside path (kept, not copied), or opens the device or pipe at path, so that a bad place
 * shows before the work is done. path NULL means standard output, and then nothing happens. False with errno set. */
bool qg_output_open(struct qg_output *output, const char *path);

/* Writes everything, to the disk, and gives the file its name; signals that end the program wait for that. False with errno
 * set; the temporary file is gone then. */
bool qg_output_commit(struct qg_output *output, const char *data, size_t length);

/* How a file is filled that is too large for the memory. */
struct qg_filling {
    bool (*fill)(int descriptor, void *self); /* writes it; false: the file is not to be */
    void *self;
    bool secret; /* the file is for its owner alone */
};

/* As qg_output_commit. Filling may take long, so it should look at times whether it is to end. */
bool qg_output_fill(struct qg_output *output, const struct qg_filling *filling);

/* True when a signal that ends the program is being held back. */
bool qg_is_to_end(void);

/* Closes and frees what an output holds, committed or not. */
void qg_output_discard(struct qg_output *output);

#endif
