/* Documents. See documents.h.
 */
#include "server/documents.h"

#include <stdio.h>
#include <stdlib.h>

/* A document's faults as a problem. */
static void reply_faults(struct qg_reply *reply, enum qg_document_status status, const struct qg_faults *faults) {
    enum qg_problem_code code = status == QG_DOCUMENT_NOT_JSON ? QG_PROBLEM_NOT_JSON : QG_PROBLEM_INVALID_DOCUMENT;
    char detail[64];
    snprintf(detail, sizeof detail, "%zu fault%s found", faults->count + faults->lost,
             faults->count + faults->lost == 1 ? "" : "s");
    qg_problem_write(&reply->body, code, detail, faults);
    reply->status = qg_problem_status(code);
    reply->media_type = "application/problem+json";
}

struct qg_job *qg_request_document(const struct qg_request *request, struct qg_notes *warnings,
                                   struct qg_reply *reply) {
    struct qg_job *job = calloc(1, sizeof *job);
    struct qg_faults *faults = calloc(1, sizeof *faults);
    enum qg_document_status status = QG_DOCUMENT_NO_MEMORY;
    if (job && faults)
        status =
            qg_document_read(request->body.data ? request->body.data : "", request->body.length, job, faults, warnings);
    if (status == QG_DOCUMENT_NO_MEMORY)
        qg_reply_problem(reply, QG_PROBLEM_UNAVAILABLE, "there is not enough memory to read the document");
    else if (status != QG_DOCUMENT_OK)
        reply_faults(reply, status, faults);
    free(faults);
    if (status == QG_DOCUMENT_OK)
        return job;
    free(job);
    return NULL;
}
