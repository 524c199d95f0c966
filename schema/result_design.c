/* The design of a result alone: as much of the result as qg_result_design_read looks at. See result.h. */
#include "schema/result_internal.h"

void qg_result_design_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result) {
    qg_json_open(text, '{');
    qg_json_name(text, "job");
    qg_document_write(text, job);
    qg_json_name(text, "design");
    if (result->design) {
        qg_json_open(text, '{');
        qg_json_name(text, "relief");
        qg_relief_write(text, &result->design->relief);
        qg_json_close(text, '}');
    } else {
        qg_json_null(text);
    }
    qg_macro_write(text, job, result);
    qg_json_close(text, '}');
}
