/* The parts of the writer of results that have files of their own; for them alone. */
#ifndef QG_SCHEMA_RESULT_INTERNAL_H
#define QG_SCHEMA_RESULT_INTERNAL_H

#include "schema/result.h"

/* The member "macro" of the result: counts, and every candidate with its pair; null unless the job is a macro one. */
void qg_macro_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result);

/* result_series.c: revolutions of the pinion per minute at a frequency ratio, with one mesh period per tooth; the members
 * "frequency_ratio", and "rms" and "period" at those ratios. */
double qg_pinion_rpm(const struct qg_design_result *design, const struct qg_case_result *one, double frequency_ratio);
void qg_frequency_ratios_write(struct qg_text *text, const struct qg_job *job);
void qg_response_write(struct qg_text *text, const struct qg_job *job, const struct qg_case_result *one);

#endif
