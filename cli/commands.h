/* The commands of the command line, and what they are told. */
#ifndef QG_CLI_COMMANDS_H
#define QG_CLI_COMMANDS_H

enum {
    QG_EXIT_DONE = 0,
    QG_EXIT_FAILED = 1,      /* the job, or the way to the daemon */
    QG_EXIT_WRONG_INPUT = 2, /* the document, the id of the job, or the command line itself */
    QG_THREADS_MAX = 1024
};

/* What the command line asks for. Strings live as long as main's arguments. */
struct qg_options {
    const char *command;
    const char
        *subject; /* the job document, the id of a job, what to do with tokens, the file of a backup; NULL for audit */
    const char *result_path; /* NULL: standard output */
    const char *server;   /* address of the daemon, without a slash at the end; NULL: the environment's, or loopback */
    const char *key;      /* Idempotency-Key of a submission; NULL: none */
    int threads;          /* 0: as many as there are processors */
    const char *argument; /* of token create and token revoke: the name, the id */
    const char *scopes;   /* of token create: names with commas between; NULL: read,submit */
    const char *days, *requests_per_minute, *queued_jobs; /* likewise: whole numbers, read there; NULL: not given */
    const char *action, *actor, *about, *address, *since, *until, *limit; /* of audit: which entries; NULL: any */
    const char *token_file;                                               /* NULL: see qg_token_load */
    const char *ca_file; /* PEM file with the authorities to be believed; NULL: the environment's, or the system's */
    const char *format;  /* of an export, as are the next three, which it reads itself; NULL: not given */
    const char *position, *torque_fraction, *load_case;
};

/* All commands return an exit status; documents go to standard output or the file, words to standard error. */

/* How many threads `run` computes with: as told, or one for each processor. */
int qg_run_threads(const struct qg_options *options);

/* Computes the job here. */
int qg_command_run(const struct qg_options *options);
/* Checks the document and prints the geometry that follows from it. */
int qg_command_check(const struct qg_options *options);
/* Writes the pair at one mesh position and torque for another program. */
int qg_command_export(const struct qg_options *options);
/* Sends the document to a daemon and prints the job's id. */
int qg_command_submit(const struct qg_options *options);
/* Follows a job until it has ended. */
int qg_command_watch(const struct qg_options *options);
/* Fetches the result of a job. */
int qg_command_result(const struct qg_options *options);
/* Asks the daemon to stop a job. */
int qg_command_cancel(const struct qg_options *options);
/* Fetches a copy of the daemon's database, for its administrator. */
int qg_command_backup(const struct qg_options *options);
/* Prints what a daemon's audit log says. */
int qg_command_audit(const struct qg_options *options);
/* Makes, lists and revokes access tokens of a daemon. */
int qg_command_token(const struct qg_options *options);

#endif
