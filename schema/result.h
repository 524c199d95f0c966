/* What goes out: results, amplitude-frequency data, evaluations. Units at the JSON edge are in the names.
 */
#ifndef QG_SCHEMA_RESULT_H
#define QG_SCHEMA_RESULT_H

#include "schema/document.h"

/* All writers append to text and never fail by themselves: look at text->failed at the end. Threads: any. */

/* The whole result document: version, job, geometry, design, reference, improvement, search, verification, map, macro,
 * reliability, model, timing, warnings; schema/result.schema.json describes it. What a job did not ask for is null. threads is only reported. */
void qg_result_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result, int threads);

/* The members job, design (its relief alone) and macro of the same: what qg_result_design_read (drawing.h) looks at, without
 * the curves, which can be some 100 MB. "design" is null when the result has none. */
void qg_result_design_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result);

/* The derived geometry alone, as `quietgear check` prints it and as the result's "geometry" member. */
void qg_geometry_write(struct qg_text *text, const struct qg_pair_geometry *geometry);

/* Amplitude against frequency: {"half_backlash_um": b, "frequency_ratio": [...], "design": {...}, "reference": {...}}; each
 * of both has the half-backlash of the pair that it was judged with, which differ in a macro job.
 * design and reference may be NULL and are then null, as they are without dynamics. The CSV has one row per speed and load
 * case: design,torque_nm,frequency_ratio,pinion_rpm,rms,period, the first being "design" or "reference". */
void qg_frequency_response_write(struct qg_text *text, const struct qg_job *job,
                                 const struct qg_pair_geometry *geometry, const struct qg_design_result *design,
                                 const struct qg_design_result *reference);
void qg_frequency_response_write_csv(struct qg_text *text, const struct qg_job *job,
                                     const struct qg_design_result *design, const struct qg_design_result *reference);

/* One evaluation as one line of NDJSON (with the newline), or as one row of CSV; the header row of the CSV. Parameters of
 * absent ramps are left out, in CSV they are empty fields, as is F_DTE when only statics was asked, and its percentile when
 * it is no objective. A candidate of a macro job
 * has no parameters; its line has the member "sample", and the result's macro.candidates have the evaluation's number. */
void qg_evaluation_write(struct qg_text *text, const struct qg_evaluation *evaluation);
void qg_evaluation_write_csv(struct qg_text *text, const struct qg_evaluation *evaluation);
void qg_evaluation_write_csv_header(struct qg_text *text);

/* Objective values at the JSON edge: F_PPS in micrometres, the others as they are. */
double qg_objective_at_the_edge(enum qg_objective objective, double value);

#endif
