/* The parts of the writer of results that have files of their own; for result.c alone. */
#ifndef QG_SCHEMA_RESULT_INTERNAL_H
#define QG_SCHEMA_RESULT_INTERNAL_H

#include "schema/result.h"

/* The member "macro" of the result: counts, and every candidate with its pair; null unless the job is a macro one. */
void qg_macro_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result);

#endif
