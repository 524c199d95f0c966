/* The search of an optimization: the study's side of search.h.
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

/* The search's side of the gate (search.h, qg_objective_function). */
static enum qg_status search_values(void *self, size_t n, const double *x, double *f) {
    struct qg_run *run = self;
    bool dynamics = run->study->objective == QG_OBJECTIVE_F_DTE, computed[QG_SEARCH_BATCH];
    assert(n <= QG_SEARCH_BATCH);
    for (size_t i = 0; i < n; i++)
        run->slot[i]->relief = relief_at(run->study, x + i * run->study->bounds.count);
    enum qg_status status = qg_run_judge(run, dynamics, n, computed);
    bool all_fresh = status == QG_OK;
    for (size_t i = 0; i < n && status == QG_OK; i++) {
        f[i] = qg_run_objective(run, &run->evaluation[i]);
        status = qg_run_consider(run, i, computed[i] && dynamics);
        all_fresh = all_fresh && computed[i];
    }
    run->result->evaluations += n;
    if (run->phase == QG_PHASE_RANDOM && status == QG_OK)
        qg_run_advance(run, n);
    return all_fresh ? qg_run_complete_best(run) : status;
}

enum qg_status qg_run_search(struct qg_run *run) {
    const struct qg_study *study = run->study;
    struct qg_box box = {.dimensions = study->bounds.count};
    memcpy(box.lower, study->bounds.lower, sizeof study->bounds.lower);
    memcpy(box.upper, study->bounds.upper, sizeof study->bounds.upper);
    const struct qg_objective_function objective = {run, search_values};
    struct qg_vertex best = {.f = INFINITY};
    run->phase = QG_PHASE_RANDOM;
    enum qg_status status =
        qg_random_samples(&box, study->optimizer.seed, 0, study->optimizer.random_samples, &objective, &best);
    struct qg_simplex simplex;
    run->phase = QG_PHASE_SIMPLEX;
    if (status == QG_OK && study->optimizer.simplex_iterations > 0)
        status = qg_simplex_init(&simplex, &box, &objective, &best);
    for (size_t i = 0; i < study->optimizer.simplex_iterations && status == QG_OK; i++) {
        status = qg_simplex_iterate(&simplex);
        run->result->simplex_iterations = i + 1;
        qg_run_advance(run, 1);
    }
    return status == QG_OK ? qg_run_complete_best(run) : status;
}
