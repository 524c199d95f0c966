/* quietgear: the command line. Jobs are computed here (run.c) or by a daemon (client.c).
 *
 * Standard output carries documents and nothing else; words go to standard error. Exit status: 0 done, 1 the job failed or
 * was cancelled, or the daemon does not answer or refuses (401, 403, 409, 429, 5xx), 2 the input is wrong (the document, or the command line itself).
 */
#include <errno.h>
#include <getopt.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/commands.h"
#include "config.h"
#include "core/study.h"

enum { LETTERS_ROOM = 32 }; /* for the options of one command line: more than there are */

static const char usage[] =
    "usage: quietgear run JOB.json [-o RESULT.json] [--threads N]\n"
    "       quietgear check JOB.json [--threads N]\n"
    "       quietgear export --format FORMAT JOB.json [-o FILE] [--position PHI]\n"
    "                        [--torque-fraction F | --load-case I]\n"
    "       quietgear submit JOB.json [--key KEY] [--server URL]\n"
    "       quietgear watch|result|cancel ID [-o RESULT.json] [--server URL]\n"
    "       quietgear token create NAME [--scopes LIST] [--days N] [--requests-per-minute N] [--queued-jobs N]\n"
    "       quietgear token list | token revoke ID\n"
    "       quietgear audit [--since TIME] [--until TIME] [--action ACTION] [--actor TOKEN] [--about ID]\n"
    "                       [--address ADDRESS] [--limit N]\n"
    "       quietgear backup FILE [--server URL]\n"
    "       quietgear --help | --version\n";

static const char help[] =
    "\n"
    "Optimizes the tooth reliefs of spur gear pairs. JOB.json is a job document, \"-\" is standard input.\n"
    "\n"
    "Here:\n"
    "  run     computes the job and writes the result, as JSON, to standard output\n"
    "  check   checks the document and prints the geometry that follows from it, as JSON; on standard error what\n"
    "          running it will take\n"
    "  export  writes the pair at one mesh position and torque for another program: abaqus, a contact model with\n"
    "          the reliefs in the mesh, which CalculiX and Abaqus run as it is; vtk (ParaView), gmsh or json, mesh,\n"
    "          displacement and stress under our own contact loads; dxf, both gears with their reliefs as arcs in\n"
    "          mm, or dxf-spaces, one tooth space of each\n"
    "By a daemon, quietgeard:\n"
    "  submit  sends the document and prints the id of the job\n"
    "  watch   follows a job until it has ended\n"
    "  result  fetches the result of a job\n"
    "  cancel  asks for a job to be stopped\n"
    "  token   create makes an access token and prints it, list shows all, revoke makes one worthless\n"
    "  audit   prints who did what, with an admin token: newest first, a line for each entry with time, action, id of\n"
    "          the token, address, what it was done to, name of the token\n"
    "  backup  fetches a copy of the database as it is now, with an admin token, and puts it in FILE when it is\n"
    "          complete; quietgeard --restore FILE puts it in its place again\n"
    "\n"
    "  -o, --output RESULT.json   (run, result) write to this file; it appears when the result is complete\n"
    "      --format FORMAT        (export) abaqus, vtk, gmsh, json, dxf or dxf-spaces\n"
    "      --position PHI         (export) mesh position in periods, 0 to 1; default: 0.5, pair 0 at mid path\n"
    "      --torque-fraction F    (export) share of the nominal torque, 0.001 to 10\n"
    "      --load-case I          (export) the load case /load_cases/I instead; default: the largest torque of all\n"
    "  -t, --threads N            (run, export) threads to use, 1 to 1024; default: one for each processor\n"
    "  -k, --key KEY              (submit) the same key again does not make a second job\n"
    "  -s, --server URL           the daemon; default: $QUIETGEAR_SERVER, or http://127.0.0.1:8080\n"
    "  -f, --token-file FILE      the access token is in this file; default: $QUIETGEAR_TOKEN, or the file\n"
    "                             $QUIETGEAR_TOKEN_FILE, or none\n"
    "      --ca-file FILE         authorities to be believed, in PEM; default: $QUIETGEAR_CA_FILE, or the system's\n"
    "      --scopes LIST          (token create) of read, submit, admin, with commas; default: read,submit\n"
    "      --days N               (token create) it expires after so many days; default: never\n"
    "      --requests-per-minute N, --queued-jobs N\n"
    "                             (token create) limits of its own; default: those that the daemon is set to\n"
    "      --since T, --until T   (audit) from T on, before T: 2030-12-31 or 2030-12-31T23:59:59Z, UTC\n"
    "      --action ACTION        (audit) such as token.create, or token for all that begin so\n"
    "      --actor TOKEN          (audit) by its id or name; quietgeard is the daemon itself\n"
    "      --about ID             (audit) of a job, token or webhook\n"
    "      --address ADDRESS      (audit) that it was asked from\n"
    "      --limit N              (audit) so many entries at most, 1 to 1000000; default: 50\n"
    "\n"
    "token list prints a line for each token: id, scopes, when it was made and expires, valid or expired, when\n"
    "it was used last, requests a minute, queued jobs, name; - stands for never, or for as the daemon is set.\n"
    "\n"
    "Exit status: 0 done, 1 the job failed or the daemon does not answer or refuses, 2 the input is wrong. Each fault "
    "is\n"
    "one line on standard error: the document, the place in it (a JSON pointer), what was found and what is allowed.\n";

/* The commands, each with the letters of the options that go with it. */
static const struct command {
    const char *name, *options;
    int (*function)(const struct qg_options *options);
} commands[] = {
    {"run", "ot", qg_command_run},
    {"check", "t", qg_command_check},
    {"submit", "ksfa", qg_command_submit},
    {"watch", "sfa", qg_command_watch},
    {"result", "osfa", qg_command_result},
    {"cancel", "sfa", qg_command_cancel},
    {"audit", "sfaAWBISUN", qg_command_audit},
    {"token", "sfacDRQ", qg_command_token},
    {"backup", "sfa", qg_command_backup},
    {"export", "oFPTLt", qg_command_export},
};

__attribute__((format(printf, 1, 2))) static int refuse_usage(const char *format, ...) {
    va_list arguments;
    fputs("quietgear: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\n%s", usage);
    return QG_EXIT_WRONG_INPUT;
}

/* A whole number from 1 to QG_THREADS_MAX; 0 when it is none. */
static int parse_threads(const char *text) {
    char *end;
    errno = 0;
    const long n = strtol(text, &end, 10);
    return end == text || *end || errno || n < 1 || n > QG_THREADS_MAX ? 0 : (int)n;
}

/* Where the argument of an option goes; NULL for --threads, which is a number. */
static const char **place_of(struct qg_options *options, int letter) {
    const struct {
        int letter;
        const char **place;
    } places[] = {
        {'o', &options->result_path}, {'k', &options->key},
        {'s', &options->server},      {'f', &options->token_file},
        {'a', &options->ca_file},     {'c', &options->scopes},
        {'D', &options->days},        {'R', &options->requests_per_minute},
        {'Q', &options->queued_jobs}, {'F', &options->format},
        {'P', &options->position},    {'T', &options->torque_fraction},
        {'L', &options->load_case},   {'A', &options->action},
        {'W', &options->actor},       {'B', &options->about},
        {'I', &options->address},     {'S', &options->since},
        {'U', &options->until},       {'N', &options->limit},
    };
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (places[i].letter == letter)
            return places[i].place;
    return NULL;
}

/* Takes one option that has an argument. False when the argument is wrong. */
static bool take_option(struct qg_options *options, int letter, const char *argument) {
    const char **place = place_of(options, letter);
    if (place)
        *place = argument;
    else
        options->threads = parse_threads(argument);
    return place || options->threads > 0;
}

static int print_and_end(const char *first, const char *second) {
    return printf("%s%s", first, second) < 0 || fflush(stdout) != 0 ? QG_EXIT_FAILED : QG_EXIT_DONE;
}

static const struct command *find_command(const char *name) {
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (strcmp(commands[i].name, name) == 0)
            return &commands[i];
    return NULL;
}

static const struct option option_names[] = {
    {"output", required_argument, NULL, 'o'},
    {"threads", required_argument, NULL, 't'},
    {"key", required_argument, NULL, 'k'},
    {"server", required_argument, NULL, 's'},
    {"token-file", required_argument, NULL, 'f'},
    {"ca-file", required_argument, NULL, 'a'},
    {"scopes", required_argument, NULL, 'c'},
    {"days", required_argument, NULL, 'D'},
    {"requests-per-minute", required_argument, NULL, 'R'},
    {"queued-jobs", required_argument, NULL, 'Q'},
    {"action", required_argument, NULL, 'A'},
    {"actor", required_argument, NULL, 'W'},
    {"about", required_argument, NULL, 'B'},
    {"address", required_argument, NULL, 'I'},
    {"since", required_argument, NULL, 'S'},
    {"until", required_argument, NULL, 'U'},
    {"limit", required_argument, NULL, 'N'},
    {"format", required_argument, NULL, 'F'},
    {"position", required_argument, NULL, 'P'},
    {"torque-fraction", required_argument, NULL, 'T'},
    {"load-case", required_argument, NULL, 'L'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {0},
};

/* Takes the words that are no options. Returns -1 to go on, or the exit status to end with. */
static int take_words(int count, char **words, struct qg_options *options) {
    if (count > 0 && !find_command(words[0]))
        return refuse_usage("found the command \"%s\", allowed run, check, export, submit, watch, result, cancel, "
                            "token, audit or backup",
                            words[0]);
    const bool is_token = count > 0 && strcmp(words[0], "token") == 0,
               is_audit = count > 0 && strcmp(words[0], "audit") == 0;
    if (is_audit && count > 1)
        return refuse_usage("found %d words, allowed one: audit takes options only", count);
    if (is_token && count == 3)
        options->argument = words[2];
    else if (count != 2 && !is_audit)
        return refuse_usage("found %d %s, allowed two: a command and its job", count, count == 1 ? "word" : "words");
    options->command = words[0];
    options->subject = is_audit ? NULL : words[1];
    return -1;
}

/* Fills in the options; letters gets those that were given. Returns -1 to go on, or the exit status to end with. */
static int parse_options(int count, char **words, struct qg_options *options, char letters[LETTERS_ROOM]) {
    for (int letter; (letter = getopt_long(count, words, "o:t:k:s:f:hV", option_names, NULL)) != -1;) {
        if (letter == 'h')
            return print_and_end(usage, help);
        if (letter == 'V')
            return print_and_end("quietgear " PACKAGE_VERSION, "\n");
        if (letter == '?')
            return refuse_usage("see --help");
        if (!take_option(options, letter, optarg))
            return refuse_usage("--threads: found %s, allowed 1 to %d", optarg, QG_THREADS_MAX);
        if (!strchr(letters, letter))
            strncat(letters, &(char){(char)letter}, 1);
    }
    return take_words(count - optind, words + optind, options);
}

int main(int count, char **words) {
    struct qg_options options = {0};
    char letters[LETTERS_ROOM] = "";
    const int parsed = parse_options(count, words, &options, letters);
    if (!qg_numerics_init(parsed >= 0 ? 1 : qg_run_threads(&options))) {
        fputs("quietgear: not enough memory for OpenBLAS: 128 MiB of addresses are needed for each thread\n", stderr);
        _exit(QG_EXIT_FAILED);
    }
    if (parsed >= 0)
        return parsed;
    const struct command *command = find_command(options.command);
    const size_t fitting = strspn(letters, command->options);
    if (letters[fitting])
        return refuse_usage("the option -%c does not go with %s", letters[fitting], command->name);
    return command->function(&options);
}
