/* The gate of a study: every evaluation is numbered, then recalled from the log or computed and recorded; and the best of
 * them is kept.
 *
 * Numbers are given in the order in which the study asks, which depends on the document alone. Recalled evaluations come
 * from the observer's log, the others are computed as one batch and recorded. The values being the same doubles either way,
 * the study cannot tell an interrupted run from an undisturbed one.
 *
 * Full results (curves, responses) are kept for the best design only. After recalled evaluations, or when the search looks
 * at statics alone, the best design's full result is computed once more, outside of the numbering.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/study_internal.h"

/* The trials of a percentile begin here, those of the reliability at 0: the answer is judged by errors that its search has
 * not seen. */
static const size_t first_trial_of_percentiles = (size_t)1 << 32;

double qg_objective_of(enum qg_objective objective, const struct qg_evaluation *e) {
    return objective == QG_OBJECTIVE_F_DTE   ? e->f_dte
           : objective == QG_OBJECTIVE_F_PPS ? e->f_pps
                                             : e->f_dte_percentile;
}

bool qg_run_is_multiobjective(const struct qg_run *run) {
    return run->study->objectives.count > 0;
}

bool qg_study_asks(const struct qg_study *study, enum qg_objective objective) {
    for (size_t k = 0; k < study->objectives.count; k++)
        if (study->objectives.item[k] == objective)
            return true;
    return study->objectives.count == 0 && study->objective == objective;
}

double qg_run_objective(const struct qg_run *run, const struct qg_evaluation *e) {
    if (!qg_run_is_multiobjective(run))
        return qg_objective_of(run->study->objective, e);
    double largest = 0;
    for (size_t k = 0; k < run->study->objectives.count; k++) {
        enum qg_objective objective = run->study->objectives.item[k];
        largest = fmax(largest, qg_objective_of(objective, e) / run->reference_value[objective]);
    }
    return largest;
}

void qg_run_report_progress(const struct qg_run *run) {
    if (!run->observer->progress)
        return;
    const struct qg_progress progress = {run->done, run->total, run->phase, run->has_best, run->best_value};
    run->observer->progress(run->observer->self, &progress);
}

double qg_run_now(const struct qg_run *run) {
    return run->observer->clock.now ? run->observer->clock.now(run->observer->clock.self) : 0;
}

void qg_run_advance(struct qg_run *run, size_t steps) {
    run->done += steps;
    qg_run_report_progress(run);
}

static struct qg_evaluation new_evaluation(struct qg_run *run, const struct qg_relief *relief) {
    struct qg_relief copy = *relief;
    struct qg_evaluation e = {
        .number = run->next_number++, .phase = run->phase, .f_pps = NAN, .f_dte = NAN, .f_dte_percentile = NAN};
    for (int k = 0; k < QG_PARAMETER_COUNT; k++)
        if (qg_relief_ramp_of(&copy, (enum qg_parameter)k)->present)
            e.parameter[k] = *qg_relief_parameter(&copy, (enum qg_parameter)k);
    return e;
}

static bool recall(struct qg_run *run, struct qg_evaluation *e) {
    return run->observer->recall && run->observer->recall(run->observer->self, e);
}

/* Judges trials first .. first + n - 1, counted through all designs of a batch. */
static enum qg_status judge_trials(struct qg_run *run, struct qg_design_result *const *design, size_t first, size_t n) {
    const struct qg_reliability *r = &run->study->reliability;
    for (size_t i = 0; i < n; i++) {
        size_t at = first + i, trial = first_trial_of_percentiles + at % r->percentile_trials;
        run->percentile.slot[i]->relief = qg_reliability_trial(r, &run->study->pair, &run->result->geometry,
                                                               &design[at / r->percentile_trials]->relief, trial);
    }
    enum qg_status status = qg_evaluate(&run->evaluator, true, n, run->percentile.slot);
    for (size_t i = 0; i < n && status == QG_OK; i++)
        run->percentile.f_dte[first + i] = run->percentile.slot[i]->f_dte;
    return status;
}

/* The percentile of n designs, when the study asks for it and this phase is about it. */
static enum qg_status judge_percentiles(struct qg_run *run, size_t n, struct qg_design_result *const *design) {
    const struct qg_reliability *r = &run->study->reliability;
    bool asked = run->percentile.asked && run->phase != QG_PHASE_RELIABILITY;
    size_t trials = asked ? n * r->percentile_trials : 0;
    for (size_t i = 0; i < n; i++)
        design[i]->f_dte_percentile = NAN;
    for (size_t done = 0; done < trials; done += QG_SEARCH_BATCH) {
        size_t left = trials - done;
        enum qg_status status = judge_trials(run, design, done, left < QG_SEARCH_BATCH ? left : QG_SEARCH_BATCH);
        if (status != QG_OK)
            return status;
    }
    for (size_t i = 0; i < n && asked; i++)
        design[i]->f_dte_percentile = qg_reliability_percentile(r, run->percentile.f_dte + i * r->percentile_trials);
    return QG_OK;
}

enum qg_status qg_run_judge(struct qg_run *run, bool dynamics, size_t n, bool *computed) {
    struct qg_design_result *fresh[QG_SEARCH_BATCH];
    struct qg_evaluation *e = run->evaluation;
    size_t known = 0, count = 0;
    for (size_t i = 0; i < n; i++) {
        e[i] = new_evaluation(run, &run->slot[i]->relief);
        computed[i] = !recall(run, &e[i]);
        if (computed[i])
            fresh[count++] = run->slot[i];
        else
            known++;
    }
    if (count == 0)
        return QG_OK;
    enum qg_status status = qg_evaluate(&run->evaluator, dynamics, count, fresh);
    if (status == QG_OK)
        status = judge_percentiles(run, count, fresh);
    if (status != QG_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        if (computed[i]) {
            e[i].f_pps = run->slot[i]->f_pps;
            e[i].f_dte = run->slot[i]->f_dte;
            e[i].f_dte_percentile = run->slot[i]->f_dte_percentile;
        }
    assert(known == 0 || !computed[0]); /* recalled ones are a prefix */
    return run->observer->record ? run->observer->record(run->observer->self, e + known, count) : QG_OK;
}

bool qg_run_begin_evaluation(struct qg_run *run, double mark, struct qg_evaluation *evaluation) {
    const struct qg_relief none = {0};
    *evaluation = new_evaluation(run, &none);
    evaluation->parameter[0] = mark;
    return recall(run, evaluation);
}

enum qg_status qg_run_record(struct qg_run *run, const struct qg_evaluation *evaluation) {
    return run->observer->record ? run->observer->record(run->observer->self, evaluation, 1) : QG_OK;
}

enum qg_status qg_run_complete_best(struct qg_run *run) {
    if (!run->has_best || run->best_known)
        return QG_OK;
    run->best->relief = run->best_relief;
    run->best->f_dte_percentile = run->best_percentile;
    enum qg_status status = qg_evaluate(&run->evaluator, true, 1, &run->best);
    run->best_known = status == QG_OK;
    if (run->best_known && run->observer->improved)
        run->observer->improved(run->observer->self, run->best);
    return status;
}

static enum qg_status add_history(struct qg_study_result *result, size_t number, double best) {
    struct qg_history_entry *grown = realloc(result->history, (result->history_count + 1) * sizeof *grown);
    if (!grown)
        return QG_OUT_OF_MEMORY;
    result->history = grown;
    grown[result->history_count++] = (struct qg_history_entry){number, best};
    return QG_OK;
}

enum qg_status qg_run_consider(struct qg_run *run, size_t i, bool full) {
    double value = qg_run_objective(run, &run->evaluation[i]);
    if (run->has_best && !(value < run->best_value))
        return QG_OK;
    run->has_best = true;
    run->best_value = value;
    run->best_percentile = run->evaluation[i].f_dte_percentile;
    run->best_relief = run->slot[i]->relief;
    run->best_known = full;
    if (run->best_known) {
        struct qg_design_result *t = run->best;
        run->best = run->slot[i];
        run->slot[i] = t;
        if (run->observer->improved)
            run->observer->improved(run->observer->self, run->best);
    }
    return add_history(run->result, run->evaluation[i].number, value);
}
