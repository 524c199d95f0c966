/* The search of an optimization: the study's side of search.h and multistart.h.
 *
 * A search sees a function of n points. Here each point becomes a relief, goes through the gate, may become the best design,
 * and, with several objectives, competes for a place on the front.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/study_internal.h"

static struct qg_relief relief_at(const struct qg_study *study, const double *x) {
    struct qg_relief relief = study->relief;
    for (size_t k = 0; k < study->bounds.count; k++) {
        qg_relief_ramp_of(&relief, study->bounds.parameter[k])->present = true;
        *qg_relief_parameter(&relief, study->bounds.parameter[k]) = x[k];
    }
    return relief;
}

/* Whether a candidate's vibration has to be computed. */
static bool needs_dynamics(const struct qg_study *study) {
    return qg_study_asks(study, QG_OBJECTIVE_F_DTE) || qg_study_asks(study, QG_OBJECTIVE_F_DTE_PERCENTILE);
}

enum qg_status qg_run_compete(struct qg_run *run, size_t i) {
    const struct qg_evaluation *e = &run->evaluation[i];
    struct qg_front_member member = {.evaluation = e->number,
                                     .relief = run->slot[i]->relief,
                                     .f_pps = e->f_pps,
                                     .f_dte = e->f_dte,
                                     .f_dte_percentile = e->f_dte_percentile};
    for (size_t k = 0; k < run->study->objectives.count; k++) {
        enum qg_objective objective = run->study->objectives.item[k];
        member.value[k] = qg_objective_of(objective, e) / run->reference_value[objective];
    }
    return qg_front_add(&run->result->front, &member, NULL);
}

/* Takes note of the batch's evaluation i; f gets its value, or its values when there are several objectives. */
static enum qg_status note_candidate(struct qg_run *run, size_t i, bool full, double *f) {
    const struct qg_objectives *asked = &run->study->objectives;
    f[0] = qg_run_objective(run, &run->evaluation[i]);
    for (size_t k = 0; k < asked->count; k++)
        f[k] = qg_objective_of(asked->item[k], &run->evaluation[i]) / run->reference_value[asked->item[k]];
    enum qg_status status = asked->count > 0 ? qg_run_compete(run, i) : QG_OK;
    return status == QG_OK ? qg_run_consider(run, i, full) : status;
}

/* The search's side of the gate (search.h, qg_objective_function). */
static enum qg_status search_values(void *self, size_t n, const double *x, double *f) {
    struct qg_run *run = self;
    const struct qg_study *study = run->study;
    const size_t columns = study->objectives.count > 0 ? study->objectives.count : 1;
    bool dynamics = needs_dynamics(study), computed[QG_SEARCH_BATCH];
    assert(n <= QG_SEARCH_BATCH);
    for (size_t i = 0; i < n; i++)
        run->slot[i]->relief = relief_at(study, x + i * study->bounds.count);
    enum qg_status status = qg_run_judge(run, dynamics, n, computed);
    bool all_fresh = status == QG_OK;
    for (size_t i = 0; i < n && status == QG_OK; i++) {
        status = note_candidate(run, i, computed[i] && dynamics, f + i * columns);
        all_fresh = all_fresh && computed[i];
    }
    run->result->evaluations += n;
    if (run->phase != QG_PHASE_SIMPLEX && status == QG_OK)
        qg_run_advance(run, n);
    return status == QG_OK && all_fresh ? qg_run_complete_best(run) : status;
}

static enum qg_status random_simplex(struct qg_run *run, const struct qg_box *box,
                                     const struct qg_objective_function *objective) {
    const struct qg_optimizer *optimizer = &run->study->optimizer;
    struct qg_vertex best = {.f = INFINITY};
    run->phase = QG_PHASE_RANDOM;
    enum qg_status status = qg_random_samples(box, optimizer->seed, 0, optimizer->random_samples, objective, &best);
    struct qg_simplex simplex;
    run->phase = QG_PHASE_SIMPLEX;
    if (status == QG_OK && optimizer->simplex_iterations > 0)
        status = qg_simplex_init(&simplex, box, objective, &best);
    for (size_t i = 0; i < optimizer->simplex_iterations && status == QG_OK; i++) {
        status = qg_simplex_iterate(&simplex);
        run->result->simplex_iterations = i + 1;
        qg_run_advance(run, 1);
    }
    return status;
}

static enum qg_status multistart(struct qg_run *run, const struct qg_box *box,
                                 const struct qg_objective_function *objective) {
    const struct qg_study *study = run->study;
    const struct qg_multistart plan = {
        .evaluations = study->optimizer.evaluations,
        .starts = study->optimizer.starts,
        .objectives = study->objectives.count > 0 ? study->objectives.count : 1,
        .seed = study->optimizer.seed,
    };
    run->phase = QG_PHASE_MULTISTART;
    return qg_multistart_search(&plan, box, objective);
}

/* The front's share of the box up to the reference. */
static void measure_front(struct qg_run *run) {
    static const double reference[QG_FRONT_OBJECTIVES_MAX] = {1, 1, 1};
    if (qg_run_is_multiobjective(run))
        run->result->hypervolume = qg_front_hypervolume(&run->result->front, reference);
}

enum qg_status qg_run_search(struct qg_run *run) {
    const struct qg_study *study = run->study;
    struct qg_box box = {.dimensions = study->bounds.count};
    memcpy(box.lower, study->bounds.lower, sizeof study->bounds.lower);
    memcpy(box.upper, study->bounds.upper, sizeof study->bounds.upper);
    const struct qg_objective_function objective = {run, search_values};
    enum qg_status status = study->optimizer.method == QG_SEARCH_RANDOM_SIMPLEX ? random_simplex(run, &box, &objective)
                                                                                : multistart(run, &box, &objective);
    measure_front(run);
    return status == QG_OK ? qg_run_complete_best(run) : status;
}
