/* Job documents as the command line reads them. */
#ifndef QG_CLI_JOB_H
#define QG_CLI_JOB_H

#include "cli/commands.h"
#include "schema/document.h"

/* Reads the document options->subject, says on standard error what is wrong with it, and hands it to the command when
 * nothing is. The job is the command's to look at, not to keep. Returns the command's exit status, or 1 or 2. */
int qg_with_job(const struct qg_options *options,
                int (*command)(const struct qg_options *options, const struct qg_job *job));

/* Prints the warnings from number `first` on, one line each, with the document's name and the place in it. */
void qg_print_warnings(const char *path, const struct qg_notes *warnings, size_t first);

#endif
