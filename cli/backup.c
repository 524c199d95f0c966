/* quietgear backup: fetches a copy of a daemon's database, while the daemon goes on working. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "cli/daemon.h"
#include "cli/files.h"
#include "cli/words.h"

/* The daemon copies the database and checks the copy before it sends the first byte. */
enum { PATIENCE_S = 3600 };

int qg_command_backup(const struct qg_options *options) {
    struct qg_output output;
    struct qg_answer answer = {0};
    if (!qg_output_open(&output, options->subject)) {
        fprintf(stderr, "%s: %s\n", options->subject, strerror(errno));
        return QG_EXIT_FAILED;
    }
    output.secret = true;
    const struct qg_call call = {.path = "/v1/backup", .sink = &output.descriptor, .patience = PATIENCE_S};
    int status = qg_ask(options, "backup", call, &answer);
    if (status == QG_EXIT_DONE && !qg_output_commit(&output, "", 0)) {
        fprintf(stderr, "%s: %s\n", options->subject, strerror(errno));
        status = QG_EXIT_FAILED;
    }
    qg_output_discard(&output);
    qg_answer_finish(&answer);
    return status;
}
