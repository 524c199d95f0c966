/* What the commands that speak to a daemon share: its address, the token shown to it, and its answers as people see them.
 *
 * What the daemon refuses it refuses in problem documents (RFC 9457); their faults are printed as those of `run` are, and
 * their status decides the exit status: the input is wrong (400, 404, 413, 415, 422), or else the call has failed.
 */
#ifndef QG_CLI_DAEMON_H
#define QG_CLI_DAEMON_H

#include <cjson/cJSON.h>

#include "cli/commands.h"
#include "cli/http.h"

/* Makes a call about `subject` to the daemon that the options or $QUIETGEAR_SERVER name. The access token is that of the
 * file of --token-file, else $QUIETGEAR_TOKEN, else that of the file $QUIETGEAR_TOKEN_FILE, else there is none; the
 * authorities that may vouch for an HTTPS daemon are those of --ca-file or $QUIETGEAR_CA_FILE, else the system's. Returns
 * QG_EXIT_DONE for a status from 200 to 304, else says why not and returns what to exit with. call->server, authorization
 * and ca_file are filled in here. The caller finishes the answer in any case. */
int qg_ask(const struct qg_options *options, const char *subject, struct qg_call call, struct qg_answer *answer);

/* The answer's body as JSON, to be deleted by the caller; NULL when it is none. */
cJSON *qg_parse(const struct qg_answer *answer);

/* The string at a key; "" when there is none. */
const char *qg_string_at(const cJSON *object, const char *key);

/* The number at a key; NaN when there is none. */
double qg_number_at(const cJSON *object, const char *key);

/* Says that the answer about `subject` makes no sense. Returns QG_EXIT_FAILED. */
int qg_say_strange(const char *subject);

#endif
