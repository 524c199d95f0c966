/* quietgear backup: fetches a copy of a daemon's database, while the daemon goes on working. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "cli/daemon.h"
#include "cli/files.h"
#include "cli/words.h"

/* The daemon copies the database and checks the copy before it sends the first byte. */
enum { PATIENCE_S = 3600 };

/* What the filling is told, and what it found out. */
struct fetching {
    const struct qg_options *options;
    int status;
};

static bool fetch(int descriptor, void *self) {
    struct fetching *fetching = self;
    struct qg_answer answer = {0};
    const struct qg_call call = {.path = "/v1/backup", .sink = &descriptor, .patience = PATIENCE_S};
    fetching->status = qg_ask(fetching->options, "backup", call, &answer);
    qg_answer_finish(&answer);
    return fetching->status == QG_EXIT_DONE;
}

int qg_command_backup(const struct qg_options *options) {
    struct qg_output output;
    struct fetching fetching = {options, QG_EXIT_DONE};
    const struct qg_filling filling = {.fill = fetch, .self = &fetching, .secret = true};
    bool done = qg_output_open(&output, options->subject) && qg_output_fill(&output, &filling);
    if (!done && fetching.status == QG_EXIT_DONE) {
        fprintf(stderr, "%s: %s\n", options->subject, strerror(errno));
        fetching.status = QG_EXIT_FAILED;
    }
    qg_output_discard(&output);
    return fetching.status;
}
