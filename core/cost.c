/* What a study will cost. See cost.h. */
#include "core/cost.h"

/* Seconds of one core. Fitted to `quietgear run --threads 1` (user time) of the examples with changed figures. */
static const double compliance_of_pair = 0.13, operators_of_position = 0.0026, contact_problem = 3.7e-5,
                    branches_of_case = 0.3, million_samples = 0.0135;
/* Per speed and load case, by branch: with a mesh stiffness, with a force that depends on the load. */
static const double speed_with_stiffness[QG_BRANCH_COUNT] = {3e-6, 3e-6, 3e-6, 25e-6};
static const double speed_with_force[QG_BRANCH_COUNT] = {175e-6, 430e-6, 430e-6, 2000e-6};

/* A model, made ready. */
static double cost_of_model(const struct qg_analysis *analysis) {
    double refinement = analysis->mesh_refinement;
    return refinement * refinement *
           (compliance_of_pair * refinement + operators_of_position * analysis->mesh_positions);
}

/* The statics of one design. */
static double cost_of_statics(const struct qg_analysis *analysis) {
    double refinement = analysis->mesh_refinement;
    return contact_problem * refinement * refinement * analysis->mesh_positions * (double)analysis->case_count;
}

/* Its speed maps. */
static double cost_of_dynamics(const struct qg_analysis *analysis) {
    const double *per_speed =
        analysis->mesh_stiffness == QG_STIFFNESS_LOAD_DEPENDENT ? speed_with_force : speed_with_stiffness;
    return per_speed[analysis->speeds.branch] * (double)analysis->speeds.count * (double)analysis->case_count;
}

/* Evaluations that a search makes beside the given design; a simplex usually tries two points an iteration. */
static double count_of_search(const struct qg_study *study) {
    const struct qg_optimizer *optimizer = &study->optimizer;
    if (optimizer->method != QG_SEARCH_RANDOM_SIMPLEX)
        return (double)optimizer->evaluations;
    return (double)optimizer->random_samples + (double)study->bounds.count + 2 * (double)optimizer->simplex_iterations;
}

static struct qg_cost cost_of_search(const struct qg_study *study) {
    double count = count_of_search(study), design = cost_of_statics(&study->analysis),
           whole = design + cost_of_dynamics(&study->analysis);
    if (qg_study_asks(study, QG_OBJECTIVE_F_DTE_PERCENTILE))
        design = whole * (double)(1 + study->reliability.percentile_trials);
    else if (qg_study_asks(study, QG_OBJECTIVE_F_DTE))
        design = whole;
    return (struct qg_cost){count, count * design};
}

struct qg_cost qg_study_cost(const struct qg_study *study) {
    const struct qg_analysis *analysis = &study->analysis;
    double model = cost_of_model(analysis), design = cost_of_statics(analysis) + cost_of_dynamics(analysis);
    struct qg_cost cost = {1, model + design};
    if (study->kind == QG_STUDY_OPTIMIZE) {
        struct qg_cost search = cost_of_search(study);
        cost.evaluations += search.evaluations;
        cost.processor_seconds += search.processor_seconds;
    } else if (study->kind == QG_STUDY_MAP) {
        cost.evaluations += (double)qg_grid_cells(&study->grid);
        cost.processor_seconds += (double)qg_grid_cells(&study->grid) * design;
    } else if (study->kind == QG_STUDY_MACRO) {
        cost.evaluations += 2 * (double)study->macro.keep;
        cost.processor_seconds +=
            2 * (double)study->macro.keep * (model + design) + million_samples * (double)study->macro.samples / 1e6;
    }
    if (study->kind == QG_STUDY_OPTIMIZE || study->kind == QG_STUDY_RELIABILITY) {
        cost.evaluations += (double)study->reliability.samples;
        cost.processor_seconds += (double)study->reliability.samples * design;
    }
    if (analysis->branches == QG_BRANCHES_ALL)
        cost.processor_seconds += branches_of_case * (double)analysis->case_count;
    return cost;
}
