/* Jobs as JSON. See job_text.h. */
#include "server/work/job_text.h"

#include <math.h>
#include <stdio.h>

#include "server/base/member.h"

static void write_progress(struct qg_text *text, const struct qg_job_progress *progress) {
    qg_json_name(text, "progress");
    qg_json_open(text, '{');
    qg_json_name(text, "done");
    qg_json_integer(text, (int64_t)progress->done);
    qg_json_name(text, "total");
    qg_json_integer(text, (int64_t)progress->total);
    qg_member_text(text, "phase", progress->phase);
    qg_json_name(text, "eta_s");
    qg_json_number(text, progress->eta);
    qg_json_name(text, "best");
    qg_json_number(text, progress->best);
    qg_json_close(text, '}');
}

void qg_estimate_write(struct qg_text *text, const struct qg_estimate *estimate) {
    qg_json_name(text, "estimate");
    if (isnan(estimate->evaluations) || isnan(estimate->seconds)) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    qg_json_name(text, "evaluations");
    qg_json_number(text, estimate->evaluations);
    qg_json_name(text, "seconds");
    qg_json_number(text, estimate->seconds);
    qg_json_name(text, "memory_mb");
    qg_json_number(text, estimate->memory_mb);
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
        qg_member_text(text, names[i], link);
    }
    qg_json_close(text, '}');
}

void qg_job_write(struct qg_text *text, struct qg_board *board, struct qg_job_row *row) {
    if (row->state == QG_STATE_RUNNING)
        qg_board_progress(board, row->id, &row->progress);
    qg_json_open(text, '{');
    qg_member_text(text, "id", row->id);
    qg_member_text(text, "name", row->name);
    qg_member_text(text, "kind", row->kind);
    qg_member_text(text, "objective", *row->objective ? row->objective : NULL);
    qg_member_text(text, "external_id", row->external_id);
    qg_json_name(text, "labels");
    qg_json_raw(text, row->labels);
    qg_member_text(text, "state", qg_state_name(row->state));
    qg_json_name(text, "cancel_requested");
    qg_json_bool(text, row->cancel_requested || row->state == QG_STATE_CANCELLED);
    write_progress(text, &row->progress);
    qg_estimate_write(text, &row->estimate);
    qg_member_time(text, "submitted_at", row->submitted_at);
    qg_member_time(text, "started_at", row->started_at);
    qg_member_time(text, "finished_at", row->finished_at);
    qg_member_text(text, "error", row->error);
    write_links(text, row->id);
    qg_json_close(text, '}');
}
