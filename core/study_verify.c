/* Verification: the reference and the answer of a search, judged once more at more mesh positions.
 *
 * A search for f_pps finds designs whose peaks lie between the mesh positions; its figures then flatter. Both designs are
 * judged by a second model of the same pair, which differs in the number of positions alone, so that what is left of the
 * improvement can be told. These judgements are no evaluations: they have no numbers and are not in the log.
 */
#include <math.h>

#include "core/study_internal.h"

/* Below this share of the improvement that the search has found, what is left of it is worth a warning. */
static const double expected_share = 0.9;

/* Positions of the verification; 0 when none was asked for or the search has had as many as there can be. */
static int positions_of(const struct qg_study *study) {
    const int asked = (int)study->optimizer.verification_factor * study->analysis.mesh_positions;
    const int positions = asked < QG_POSITIONS_MAX ? asked : QG_POSITIONS_MAX;
    return study->kind == QG_STUDY_OPTIMIZE && positions > study->analysis.mesh_positions ? positions : 0;
}

size_t qg_verification_steps(const struct qg_study *study) {
    return positions_of(study) > 0;
}

/* Judges both designs in a model that is ready. */
static enum qg_status judge_both(struct qg_run *run, const struct qg_executor *executor, const struct qg_model *model) {
    struct qg_verification *v = &run->result->verification;
    const struct qg_design_result *judged[2] = {run->result->reference, run->best};
    struct qg_design_result *again[2] = {NULL};
    struct qg_evaluator evaluator;
    enum qg_status status = qg_evaluator_init(&evaluator, model, executor);
    if (status != QG_OK)
        return status;
    evaluator.cancelled = run->observer->cancelled;
    evaluator.self = run->observer->self;
    for (int i = 0; i < 2 && status == QG_OK; i++) {
        again[i] = qg_design_result_create(qg_model_analysis(model));
        if (again[i])
            again[i]->relief = judged[i]->relief;
        else
            status = QG_OUT_OF_MEMORY;
    }
    if (status == QG_OK)
        status = qg_evaluate(&evaluator, true, 2, again);
    for (int i = 0; i < 2; i++) {
        if (status == QG_OK) {
            v->f_pps[i] = again[i]->f_pps;
            v->f_dte[i] = again[i]->f_dte;
        }
        qg_design_result_destroy(again[i]);
    }
    qg_evaluator_finish(&evaluator);
    return status;
}

/* By how much, as a share of the reference, the design is below it. */
static double improvement(double reference, double design) {
    return 1 - design / reference;
}

/* Says when what is left of an improvement is much less than it was. */
static void warn_of_loss(struct qg_run *run, const char *name, double before, double left) {
    if (before > 0 && left < expected_share * before)
        qg_notes_add(&run->result->warnings, "optimizer",
                     "at %d mesh positions %s improves by %.1f %% only, not by %.1f %% as at %d: search with more "
                     "analysis.mesh_positions",
                     run->result->verification.mesh_positions, name, 100 * left, 100 * before,
                     run->study->analysis.mesh_positions);
}

static void warn_of_losses(struct qg_run *run) {
    const struct qg_verification *v = &run->result->verification;
    const struct qg_design_result *reference = run->result->reference, *design = run->best;
    if (qg_study_asks(run->study, QG_OBJECTIVE_F_PPS))
        warn_of_loss(run, "f_pps", improvement(reference->f_pps, design->f_pps), improvement(v->f_pps[0], v->f_pps[1]));
    if (qg_study_asks(run->study, QG_OBJECTIVE_F_DTE) || qg_study_asks(run->study, QG_OBJECTIVE_F_DTE_PERCENTILE))
        warn_of_loss(run, "f_dte", improvement(reference->f_dte, design->f_dte), improvement(v->f_dte[0], v->f_dte[1]));
}

enum qg_status qg_run_verify(struct qg_run *run, const struct qg_means *means) {
    struct qg_analysis analysis = run->study->analysis;
    struct qg_model *model;
    analysis.mesh_positions = positions_of(run->study);
    if (analysis.mesh_positions == 0)
        return QG_OK;
    run->phase = QG_PHASE_VERIFICATION;
    qg_run_report_progress(run);
    enum qg_status status = qg_model_create(&run->study->pair, &analysis, means, NULL, &model);
    if (status != QG_OK)
        return status;
    run->result->verification.mesh_positions = analysis.mesh_positions;
    status = judge_both(run, &means->executor, model);
    qg_model_destroy(model);
    if (status == QG_OK) {
        warn_of_losses(run);
        qg_run_advance(run, 1);
    }
    return status;
}
