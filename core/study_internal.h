/* A study at work: what the parts of study.c share (study_gate.c, study_search.c, study_macro.c,
 * study_warnings.c). Not for others.
 *
 * Everything here belongs to the thread that called qg_study_run.
 */
#ifndef QG_CORE_STUDY_INTERNAL_H
#define QG_CORE_STUDY_INTERNAL_H

#include "core/search.h"
#include "core/study.h"

/* A study at work. */
struct qg_run {
    const struct qg_study *study;
    const struct qg_observer *observer;
    struct qg_study_result *result;
    struct qg_model *model;
    struct qg_evaluator evaluator;
    enum qg_phase phase;
    size_t next_number;                             /* of the next evaluation */
    size_t done, total;                             /* steps, for progress */
    struct qg_design_result *slot[QG_SEARCH_BATCH]; /* results of one batch */
    struct qg_design_result *best;                  /* full result of the best design, when best_known */
    bool best_known;
    bool has_best;
    double best_value;
    double best_percentile; /* its f_dte_percentile */
    struct qg_relief best_relief;
    struct qg_evaluation evaluation[QG_SEARCH_BATCH]; /* of the batch being judged */
    double reference_value[QG_OBJECTIVE_COUNT];       /* all objectives of the reference */
    struct {                                          /* of F_DTE_PERCENTILE, when it is an objective */
        bool asked;
        struct qg_design_result *slot[QG_SEARCH_BATCH]; /* trials being judged */
        double *f_dte;                                  /* of all trials of a batch of designs */
    } percentile;
};

/* One objective of an evaluation, core's units. */
double qg_objective_of(enum qg_objective objective, const struct qg_evaluation *e);

/* What the study makes small: its objective, or of several the largest ratio to the reference. */
double qg_run_objective(const struct qg_run *run, const struct qg_evaluation *e);

/* Whether the study looks for a front of several objectives. */
bool qg_run_is_multiobjective(const struct qg_run *run);

/* Tells the observer how far the run is; qg_run_advance counts steps first. */
void qg_run_report_progress(const struct qg_run *run);
void qg_run_advance(struct qg_run *run, size_t steps);

/* The gate: judges the designs in slot[0 .. n-1]->relief as the next n evaluations; fills run->evaluation, and the slots
 * of those that were computed (computed[i]). n <= QG_SEARCH_BATCH. */
enum qg_status qg_run_judge(struct qg_run *run, bool dynamics, size_t n, bool *computed);

/* The same gate for a single evaluation whose computing is the caller's: gives a design without relief the next number
 * and a mark in parameter[0], and tells whether its values are recalled; and records it when they were computed. */
bool qg_run_begin_evaluation(struct qg_run *run, double mark, struct qg_evaluation *evaluation);
enum qg_status qg_run_record(struct qg_run *run, const struct qg_evaluation *evaluation);

/* Seconds by the observer's clock; 0 without one. */
double qg_run_now(const struct qg_run *run);

/* Takes note of the batch's evaluation i when it beats the best so far; full says that its slot holds the full result. */
enum qg_status qg_run_consider(struct qg_run *run, size_t i, bool full);

/* Sees to it that run->best holds the full result of the best design, dynamics included, and tells the observer. */
enum qg_status qg_run_complete_best(struct qg_run *run);

/* Lets the batch's evaluation i compete for a place on the front. */
enum qg_status qg_run_compete(struct qg_run *run, size_t i);

/* Searches the study's box and leaves the best in run->best. */
enum qg_status qg_run_search(struct qg_run *run);

/* Samples macro-geometries and judges what was kept; leaves the best in run->best if there is one. */
enum qg_status qg_run_macro(struct qg_run *run, const struct qg_means *means);

/* Judges reference and answer of an optimization again at more mesh positions, when the study asks for it, and warns when
 * little is left of the improvement. The steps that it counts as. */
enum qg_status qg_run_verify(struct qg_run *run, const struct qg_means *means);
size_t qg_verification_steps(const struct qg_study *study);

/* What the answer's reader should know: warnings into the result. */
void qg_run_warn(struct qg_run *run);

#endif
