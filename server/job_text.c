/* Jobs as JSON. See job_text.h. */
#include "server/job_text.h"

#include <inttypes.h>
#include <stdio.h>
#include <time.h>

void qg_time_print(char out[QG_TIME_ROOM], int64_t milliseconds) {
    time_t seconds = (time_t)(milliseconds / 1000);
    struct tm utc;
    gmtime_r(&seconds, &utc);
    size_t length = strftime(out, QG_TIME_ROOM, "%Y-%m-%dT%H:%M:%S", &utc);
    snprintf(out + length, QG_TIME_ROOM - length, ".%03dZ", (int)(milliseconds % 1000));
}

static void write_string(struct qg_text *text, const char *name, const char *value) {
    qg_json_name(text, name);
    if (value)
        qg_json_string(text, value);
    else
        qg_json_null(text);
}

static void write_time(struct qg_text *text, const char *name, int64_t milliseconds) {
    char out[QG_TIME_ROOM];
    qg_time_print(out, milliseconds);
    write_string(text, name, milliseconds ? out : NULL);
}

static void write_progress(struct qg_text *text, const struct qg_job_progress *progress) {
    qg_json_name(text, "progress");
    qg_json_open(text, '{');
    qg_json_name(text, "done");
    qg_json_integer(text, (int64_t)progress->done);
    qg_json_name(text, "total");
    qg_json_integer(text, (int64_t)progress->total);
    write_string(text, "phase", progress->phase);
    qg_json_name(text, "eta_s");
    qg_json_number(text, progress->eta);
    qg_json_name(text, "best");
    qg_json_number(text, progress->best);
    qg_json_close(text, '}');
}

static void write_links(struct qg_text *text, const char *id) {
    static const char *const names[] = {"self",        "document", "events", "result", "frequency_response",
                                        "evaluations", "cancel"};
    static const char *const tails[] = {
        "", "/document", "/events", "/result", "/frequency-response", "/evaluations", "/cancel"};
    qg_json_name(text, "links");
    qg_json_open(text, '{');
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char link[96];
        snprintf(link, sizeof link, "/v1/jobs/%s%s", id, tails[i]);
        write_string(text, names[i], link);
    }
    qg_json_close(text, '}');
}

void qg_job_write(struct qg_text *text, struct qg_board *board, struct qg_job_row *row) {
    if (row->state == QG_STATE_RUNNING)
        qg_board_progress(board, row->id, &row->progress);
    qg_json_open(text, '{');
    write_string(text, "id", row->id);
    write_string(text, "name", row->name);
    write_string(text, "kind", row->kind);
    write_string(text, "objective", *row->objective ? row->objective : NULL);
    write_string(text, "external_id", row->external_id);
    qg_json_name(text, "labels");
    qg_json_raw(text, row->labels);
    write_string(text, "state", qg_state_name(row->state));
    qg_json_name(text, "cancel_requested");
    qg_json_bool(text, row->cancel_requested || row->state == QG_STATE_CANCELLED);
    write_progress(text, &row->progress);
    write_time(text, "submitted_at", row->submitted_at);
    write_time(text, "started_at", row->started_at);
    write_time(text, "finished_at", row->finished_at);
    write_string(text, "error", row->error);
    write_links(text, row->id);
    qg_json_close(text, '}');
}

void qg_etag(char etag[QG_ETAG_ROOM], const struct qg_text *text) {
    uint64_t hash = 14695981039346656037u; /* FNV-1a */
    for (size_t i = 0; i < text->length; i++)
        hash = (hash ^ (unsigned char)text->data[i]) * 1099511628211u;
    snprintf(etag, QG_ETAG_ROOM, "\"%016" PRIx64 "\"", hash);
}
