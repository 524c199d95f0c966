/* Running a study: compliance, reference, search or map, reliability; every evaluation numbered, recalled or recorded.
 *
 * Numbers are given in the order in which the study asks, which depends on the document alone. Evaluations go through one
 * gate (judge): recalled ones come from the observer's log, the others are computed as one batch and recorded. The values
 * being the same doubles either way, the study cannot tell an interrupted run from an undisturbed one.
 *
 * Full results (curves, responses) are kept for the best design only. After recalled evaluations, or when the search looks
 * at statics alone, the best design's full result is computed once more, outside of the numbering.
 */
#include "core/study.h"

#include <assert.h>
#include <cblas.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/force.h"
#include "core/search.h"

const char *qg_phase_name(enum qg_phase phase) {
    static const char *const names[QG_PHASE_COUNT] = {"compliance", "reference",   "random",
                                                      "simplex",    "reliability", "map"};
    assert((unsigned)phase < QG_PHASE_COUNT);
    return names[phase];
}

void qg_numerics_init(void) {
    openblas_set_num_threads(1);
}

/* ---- checking --------------------------------------------------------------------------------------------------- */

static void check_analysis(const struct qg_analysis *a, struct qg_notes *errors) {
    int most = (a->mesh_positions - 1) / 2;
    if (a->harmonics > most)
        qg_notes_add(errors, "analysis.harmonics",
                     "found %d, allowed: 1 to %d, which is what %d mesh positions can resolve", a->harmonics, most,
                     a->mesh_positions);
    if (a->speeds.max < a->speeds.min)
        qg_notes_add(errors, "analysis.speeds.max", "found %g, allowed: at least min, which is %g", a->speeds.max,
                     a->speeds.min);
}

/* "bounds.pinion.tip.start_radius" and the like. */
static void bounds_place(char place[64], enum qg_parameter parameter) {
    static const char *const names[QG_PARAMETER_COUNT] = {
        "pinion.tip.start_radius", "pinion.tip.amplitude", "pinion.root.end_radius", "pinion.root.amplitude",
        "gear.tip.start_radius",   "gear.tip.amplitude",   "gear.root.end_radius",   "gear.root.amplitude"};
    snprintf(place, 64, "bounds.%s", names[parameter]);
}

/* What the pair allows a parameter to be (mm). */
static void parameter_limits(const struct qg_study *study, const struct qg_pair_geometry *g,
                             enum qg_parameter parameter, double limits[2]) {
    int gear = parameter < QG_GEAR_TIP_START_RADIUS ? QG_PINION : QG_GEAR;
    bool tip = parameter % 4 < 2, radius = qg_parameter_is_radius(parameter);
    limits[0] = !radius ? 0 : tip ? g->gears[gear].form_radius : study->pair.gears[gear].root_radius;
    limits[1] = radius ? study->pair.gears[gear].outside_radius : qg_relief_deepest(&study->pair, g, gear);
}

static void check_bounds(const struct qg_study *study, const struct qg_pair_geometry *g, struct qg_notes *errors) {
    struct qg_relief relief = study->relief;
    for (size_t k = 0; k < study->bounds.count; k++) {
        enum qg_parameter parameter = study->bounds.parameter[k];
        double lower = study->bounds.lower[k], upper = study->bounds.upper[k];
        char place[64];
        bounds_place(place, parameter);
        if (!(lower < upper))
            qg_notes_add(errors, place, "found [%g, %g] mm, allowed: the lower bound below the upper one", lower,
                         upper);
        double limits[2];
        parameter_limits(study, g, parameter, limits);
        if (!(lower >= limits[0] && upper <= limits[1]))
            qg_notes_add(errors, place, "found [%g, %g] mm, allowed: within %.4f to %.4f mm", lower, upper, limits[0],
                         limits[1]);
        struct qg_ramp *ramp = qg_relief_ramp_of(&relief, parameter);
        bool partner =
            (k > 0 && qg_relief_ramp_of(&relief, study->bounds.parameter[k - 1]) == ramp) ||
            (k + 1 < study->bounds.count && qg_relief_ramp_of(&relief, study->bounds.parameter[k + 1]) == ramp);
        if (!ramp->present && !partner)
            qg_notes_add(errors, place,
                         "the other parameter of this ramp is neither bounded nor given in the relief; bound both, or "
                         "give the relief's ramp");
    }
}

/* One end of an axis against what the pair allows. */
static void check_axis_end(size_t axis, const char *end, double value, const double limits[2],
                           struct qg_notes *errors) {
    char place[64];
    snprintf(place, sizeof place, "grid.%zu.%s", axis, end);
    if (!(value >= limits[0] && value <= limits[1]))
        qg_notes_add(errors, place, "found %g mm, allowed: within %.4f to %.4f mm", value, limits[0], limits[1]);
}

static void check_axis(const struct qg_study *study, const struct qg_pair_geometry *g, size_t k,
                       struct qg_notes *errors) {
    const struct qg_axis *axis = &study->grid.axis[k], *other = &study->grid.axis[1 - k];
    const bool has_other = study->grid.count == QG_AXES_MAX;
    struct qg_relief relief = study->relief;
    double limits[2];
    char place[64];
    parameter_limits(study, g, axis->parameter, limits);
    check_axis_end(k, "from", axis->from, limits, errors);
    check_axis_end(k, "to", axis->to, limits, errors);
    snprintf(place, sizeof place, "grid.%zu.to", k);
    if (axis->from == axis->to)
        qg_notes_add(errors, place, "found %g mm, allowed: another value than from, smaller or larger", axis->to);
    snprintf(place, sizeof place, "grid.%zu.parameter", k);
    const struct qg_ramp *ramp = qg_relief_ramp_of(&relief, axis->parameter);
    if (k > 0 && axis->parameter == other->parameter)
        qg_notes_add(errors, place, "found the parameter of the first axis again, allowed: another one");
    else if (!ramp->present && !(has_other && qg_relief_ramp_of(&relief, other->parameter) == ramp))
        qg_notes_add(errors, place,
                     "the other parameter of this ramp is neither on the grid nor given in the relief; put both on the "
                     "grid, or give the relief's ramp");
}

static void check_grid(const struct qg_study *study, const struct qg_pair_geometry *g, struct qg_notes *errors) {
    const size_t cells = qg_grid_cells(&study->grid);
    for (size_t k = 0; k < study->grid.count; k++)
        check_axis(study, g, k, errors);
    if (cells > QG_GRID_CELLS_MAX)
        qg_notes_add(errors, "grid", "found %zu cells, allowed: at most %d", cells, QG_GRID_CELLS_MAX);
}

enum qg_status qg_study_check(const struct qg_study *study, struct qg_pair_geometry *geometry, struct qg_notes *errors,
                              struct qg_notes *warnings) {
    struct qg_pair_geometry mine;
    struct qg_notes own = {0};
    if (!errors)
        errors = &own;
    if (!geometry)
        geometry = &mine;
    size_t before = errors->count + errors->lost;
    check_analysis(&study->analysis, errors);
    if (qg_pair_derive(&study->pair, geometry, errors) == QG_OK) {
        qg_relief_check(&study->relief, &study->pair, geometry, errors, warnings);
        if (study->kind == QG_STUDY_OPTIMIZE)
            check_bounds(study, geometry, errors);
        if (study->kind == QG_STUDY_MAP)
            check_grid(study, geometry, errors);
    }
    return errors->count + errors->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}

/* ---- running ---------------------------------------------------------------------------------------------------- */

/* A study at work. */
struct run {
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
    struct qg_relief best_relief;
    struct qg_evaluation evaluation[QG_SEARCH_BATCH]; /* of the batch being judged */
};

static double objective_of(const struct run *run, const struct qg_evaluation *e) {
    return run->study->objective == QG_OBJECTIVE_F_DTE ? e->f_dte : e->f_pps;
}

static void report_progress(const struct run *run) {
    if (!run->observer->progress)
        return;
    const struct qg_progress progress = {run->done, run->total, run->phase, run->has_best, run->best_value};
    run->observer->progress(run->observer->self, &progress);
}

static void advance(struct run *run, size_t steps) {
    run->done += steps;
    report_progress(run);
}

static struct qg_evaluation new_evaluation(struct run *run, const struct qg_relief *relief) {
    struct qg_relief copy = *relief;
    struct qg_evaluation e = {.number = run->next_number++, .phase = run->phase, .f_pps = NAN, .f_dte = NAN};
    for (int k = 0; k < QG_PARAMETER_COUNT; k++)
        if (qg_relief_ramp_of(&copy, (enum qg_parameter)k)->present)
            e.parameter[k] = *qg_relief_parameter(&copy, (enum qg_parameter)k);
    return e;
}

static bool recall(struct run *run, struct qg_evaluation *e) {
    return run->observer->recall && run->observer->recall(run->observer->self, e);
}

/* The gate: judges the designs in slot[0 .. n-1]->relief as the next n evaluations; fills run->evaluation, and the slots
 * of those that were computed (computed[i]). */
static enum qg_status judge(struct run *run, bool dynamics, size_t n, bool *computed) {
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
    if (status != QG_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        if (computed[i]) {
            e[i].f_pps = run->slot[i]->f_pps;
            e[i].f_dte = run->slot[i]->f_dte;
        }
    assert(known == 0 || !computed[0]); /* recalled ones are a prefix */
    return run->observer->record ? run->observer->record(run->observer->self, e + known, count) : QG_OK;
}

/* Sees to it that run->best holds the full result of the best design, dynamics included, and tells the observer. */
static enum qg_status complete_best(struct run *run) {
    if (!run->has_best || run->best_known)
        return QG_OK;
    run->best->relief = run->best_relief;
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

/* Takes note of the batch's evaluation i when it beats the best so far; full says that its slot holds the full result. */
static enum qg_status consider(struct run *run, size_t i, bool full) {
    double value = objective_of(run, &run->evaluation[i]);
    if (run->has_best && !(value < run->best_value))
        return QG_OK;
    run->has_best = true;
    run->best_value = value;
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
    struct run *run = self;
    bool dynamics = run->study->objective == QG_OBJECTIVE_F_DTE, computed[QG_SEARCH_BATCH];
    assert(n <= QG_SEARCH_BATCH);
    for (size_t i = 0; i < n; i++)
        run->slot[i]->relief = relief_at(run->study, x + i * run->study->bounds.count);
    enum qg_status status = judge(run, dynamics, n, computed);
    bool all_fresh = status == QG_OK;
    for (size_t i = 0; i < n && status == QG_OK; i++) {
        f[i] = objective_of(run, &run->evaluation[i]);
        status = consider(run, i, computed[i] && dynamics);
        all_fresh = all_fresh && computed[i];
    }
    run->result->evaluations += n;
    if (run->phase == QG_PHASE_RANDOM && status == QG_OK)
        advance(run, n);
    return all_fresh ? complete_best(run) : status;
}

/* ---- phases ----------------------------------------------------------------------------------------------------- */

static double now(const struct run *run) {
    return run->observer->clock.now ? run->observer->clock.now(run->observer->clock.self) : 0;
}

static enum qg_status build_model(struct run *run, const struct qg_means *means) {
    double start = now(run);
    run->phase = QG_PHASE_COMPLIANCE;
    report_progress(run);
    enum qg_status status =
        qg_model_create(&run->study->pair, &run->study->analysis, means, &run->result->warnings, &run->model);
    run->result->timing.compliance = now(run) - start;
    if (status != QG_OK)
        return status;
    run->result->size = qg_model_size(run->model);
    status = qg_evaluator_init(&run->evaluator, run->model, &means->executor);
    run->evaluator.cancelled = run->observer->cancelled;
    run->evaluator.self = run->observer->self;
    run->evaluator.clock = run->observer->clock;
    advance(run, 1);
    return status;
}

/* Judges the given design, always with its full result, which goes to *given. */
static enum qg_status judge_given(struct run *run, struct qg_design_result **given) {
    run->phase = QG_PHASE_REFERENCE;
    report_progress(run);
    run->slot[0]->relief = (*given)->relief = run->study->relief;
    bool computed = false;
    enum qg_status status = judge(run, true, 1, &computed);
    if (status == QG_OK && computed) {
        struct qg_design_result *t = *given;
        *given = run->slot[0];
        run->slot[0] = t;
    } else if (status == QG_OK) {
        status = qg_evaluate(&run->evaluator, true, 1, given);
    }
    if (status == QG_OK && run->observer->reference)
        run->observer->reference(run->observer->self, *given);
    advance(run, 1);
    return status;
}

static enum qg_status search(struct run *run) {
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
        advance(run, 1);
    }
    return status == QG_OK ? complete_best(run) : status;
}

/* The values of the batch that starts at a cell go to the map. */
static enum qg_status note_cells(struct run *run, size_t first, size_t n, const bool *computed) {
    struct qg_map *map = &run->result->map;
    enum qg_status status = QG_OK;
    bool all_fresh = true;
    for (size_t i = 0; i < n && status == QG_OK; i++) {
        map->value[QG_OBJECTIVE_F_DTE][first + i] = run->evaluation[i].f_dte;
        map->value[QG_OBJECTIVE_F_PPS][first + i] = run->evaluation[i].f_pps;
        status = consider(run, i, computed[i]);
        all_fresh = all_fresh && computed[i];
    }
    if (status == QG_OK)
        advance(run, n);
    return status == QG_OK && all_fresh ? complete_best(run) : status;
}

/* Judges all cells of the grid, statics and dynamics. */
static enum qg_status map_cells(struct run *run) {
    const struct qg_study *study = run->study;
    enum qg_status status = QG_OK;
    run->phase = QG_PHASE_MAP;
    for (size_t done = 0; done < run->result->map.cells && status == QG_OK;) {
        const size_t left = run->result->map.cells - done, n = left < QG_SEARCH_BATCH ? left : QG_SEARCH_BATCH;
        bool computed[QG_SEARCH_BATCH];
        for (size_t i = 0; i < n; i++)
            run->slot[i]->relief = qg_grid_relief(&study->grid, &study->relief, done + i);
        status = judge(run, true, n, computed);
        if (status == QG_OK)
            status = note_cells(run, done, n, computed);
        done += n;
    }
    return status == QG_OK ? complete_best(run) : status;
}

/* Judges all trials and sums them up. */
static enum qg_status try_reliability(struct run *run, const struct qg_relief *design) {
    const struct qg_reliability *r = &run->study->reliability;
    double *f_dte = malloc(r->samples * sizeof *f_dte);
    enum qg_status status = f_dte ? QG_OK : QG_OUT_OF_MEMORY;
    run->phase = QG_PHASE_RELIABILITY;
    for (size_t done = 0; done < r->samples && status == QG_OK;) {
        size_t n = r->samples - done < QG_SEARCH_BATCH ? r->samples - done : QG_SEARCH_BATCH;
        bool computed[QG_SEARCH_BATCH];
        for (size_t i = 0; i < n; i++)
            run->slot[i]->relief = qg_reliability_trial(r, &run->study->pair, &run->result->geometry, design, done + i);
        status = judge(run, true, n, computed);
        for (size_t i = 0; i < n && status == QG_OK; i++)
            f_dte[done + i] = run->evaluation[i].f_dte;
        done += n;
        if (status == QG_OK)
            advance(run, n);
    }
    if (status == QG_OK)
        qg_reliability_summarize(r, design, f_dte, &run->result->reliability);
    free(f_dte);
    return status;
}

/* ---- what the response is not ----------------------------------------------------------------------------------- */

/* Responses without a period are never silent: one warning for every load case that has some. */
static void warn_of_responses(struct run *run, const struct qg_design_result *design, const char *name) {
    for (size_t k = 0; k < design->case_count; k++) {
        const struct qg_case_result *c = &design->cases[k];
        size_t chaotic = 0, unbounded = 0, slow = 0;
        for (size_t i = 0; i < design->speeds; i++) {
            chaotic += c->response[i].period == QG_PERIOD_CHAOTIC;
            unbounded += c->response[i].period == QG_PERIOD_UNBOUNDED;
            slow += c->response[i].period == QG_PERIOD_LONG;
        }
        if (chaotic + unbounded + slow > 0)
            qg_notes_add(
                &run->result->warnings, "analysis.speeds",
                "%s at %g N m: %zu of %zu speeds have a response without a period up to %d (%zu chaotic, %zu of "
                "a longer period or not settled, %zu growing without bound); its period says which",
                name, c->torque / 1000, chaotic + slow + unbounded, design->speeds, QG_PERIOD_MAX, chaotic, slow,
                unbounded);
    }
}

static void warn_of_branches(struct run *run, const struct qg_design_result *design) {
    for (size_t k = 0; k < design->case_count; k++) {
        const struct qg_branches *b = design->cases[k].branches;
        size_t lost = 0;
        for (size_t i = 0; b && i < b->count; i++)
            lost += b->curve[i].end[0] == QG_END_LOST || b->curve[i].end[1] == QG_END_LOST;
        if (b && !b->complete)
            qg_notes_add(
                &run->result->warnings, "analysis.branches",
                "at %g N m: the search for branches was ended after %zu curves; there are more (limits: %d curves, %d "
                "points)",
                design->cases[k].torque / 1000, b->count, QG_CURVES_MAX, QG_CURVE_POINTS_MAX);
        if (lost > 0)
            qg_notes_add(&run->result->warnings, "analysis.branches",
                         "at %g N m: %zu of %zu branches could not be followed to an end",
                         design->cases[k].torque / 1000, lost, b->count);
        if (b && b->unperiodic > 0)
            qg_notes_add(&run->result->warnings, "analysis.branches",
                         "at %g N m: %zu steady responses met on the way have no period up to %d and lie on no branch",
                         design->cases[k].torque / 1000, b->unperiodic, QG_PERIOD_MAX);
    }
}

static enum qg_status find_branches(struct run *run) {
    if (run->study->kind != QG_STUDY_EVALUATE || run->study->analysis.branches != QG_BRANCHES_ALL)
        return QG_OK;
    enum qg_status status = qg_evaluate_branches(&run->evaluator, run->best);
    advance(run, 1);
    return status;
}

/* Says where the answer's orbits were stronger than the force was tabulated for. */
static void warn_beyond(const struct qg_design_result *design, struct qg_notes *warnings) {
    for (size_t k = 0; k < design->case_count; k++)
        if (design->cases[k].speeds_beyond > 0)
            qg_notes_add(warnings, "analysis.mesh_stiffness",
                         "at %g N m: at %zu of %zu speeds the force exceeds %g times the largest load; there it is "
                         "continued with its last slope",
                         design->cases[k].torque / 1000, design->cases[k].speeds_beyond, design->speeds,
                         QG_FORCE_REACH);
}

/* Teeth that give way by more than a tenth of the module have left the small displacements that all of core assumes: the
 * torque or the gears' bodies are not what was meant. */
static void warn_of_large_approach(struct run *run, const struct qg_design_result *design, const char *name) {
    const double most = 0.1 * run->study->pair.rack.module;
    for (size_t k = 0; k < design->case_count; k++) {
        const struct qg_case_result *c = &design->cases[k];
        double largest = 0;
        for (size_t i = 0; i < design->positions; i++)
            largest = fmax(largest, c->static_transmission_error[i]);
        if (largest > most)
            qg_notes_add(
                &run->result->warnings, "nominal_torque",
                "%s at %g N m: the static transmission error reaches %.4g mm, more than a tenth of the module; the "
                "method is one of small displacements",
                name, c->torque / 1000, largest);
    }
}

/* A search that was too short, or bounds or a grid that exclude what the reference has, may end above the reference. */
static void warn_of_no_gain(struct run *run) {
    const struct qg_design_result *reference = run->result->reference, *design = run->best;
    bool dte = run->study->objective == QG_OBJECTIVE_F_DTE;
    double before = dte ? reference->f_dte : reference->f_pps, after = dte ? design->f_dte : design->f_pps;
    bool map = run->study->kind == QG_STUDY_MAP;
    if (after > before)
        qg_notes_add(&run->result->warnings, map ? "grid" : "optimizer",
                     "the best design found is %.1f %% worse than the reference: %s", 100 * (after / before - 1),
                     map ? "the grid lies elsewhere, or is too coarse" : "search longer, or widen the bounds");
}

static bool is_said(const struct qg_notes *notes, const struct qg_note *note) {
    for (size_t i = 0; i < notes->count; i++)
        if (strcmp(notes->item[i].where, note->where) == 0 && strcmp(notes->item[i].text, note->text) == 0)
            return true;
    return false;
}

/* Says what of the design that was found does nothing, unless the check has said it of the given one. */
static void warn_of_relief(struct run *run) {
    struct qg_notes notes = {0};
    qg_relief_check(&run->best->relief, &run->study->pair, &run->result->geometry, NULL, &notes);
    for (size_t i = 0; i < notes.count; i++) {
        if (is_said(&run->result->warnings, &notes.item[i]))
            continue;
        char place[sizeof notes.item[i].where + sizeof "bounds."];
        snprintf(place, sizeof place, "bounds.%s", notes.item[i].where);
        qg_notes_add(&run->result->warnings, run->study->kind == QG_STUDY_MAP ? "grid" : place, "design: %s",
                     notes.item[i].text);
    }
}

static void warn(struct run *run) {
    if (run->result->reference) {
        warn_of_no_gain(run);
        warn_of_relief(run);
        warn_of_large_approach(run, run->result->reference, "reference");
        warn_of_responses(run, run->result->reference, "reference");
    }
    warn_of_large_approach(run, run->best, "design");
    warn_of_responses(run, run->best, "design");
    warn_of_branches(run, run->best);
    warn_beyond(run->best, &run->result->warnings);
}

static enum qg_status run_phases(struct run *run, const struct qg_means *means) {
    const struct qg_study *study = run->study;
    enum qg_status status = build_model(run, means);
    bool optimize = study->kind == QG_STUDY_OPTIMIZE, map = study->kind == QG_STUDY_MAP;
    struct qg_design_result **given = optimize || map ? &run->result->reference : &run->best;
    if (status == QG_OK)
        status = judge_given(run, given);
    if (status == QG_OK && optimize)
        status = search(run);
    if (status == QG_OK && map)
        status = map_cells(run);
    if (status == QG_OK && study->reliability.samples > 0 && study->kind != QG_STUDY_EVALUATE)
        status = try_reliability(run, &run->best->relief);
    if (status == QG_OK)
        status = find_branches(run);
    if (status == QG_OK)
        warn(run);
    return status;
}

static bool allocate_map(struct qg_map *map, const struct qg_grid *grid) {
    map->cells = qg_grid_cells(grid);
    for (int i = 0; i < QG_OBJECTIVE_COUNT; i++)
        map->value[i] = calloc(map->cells, sizeof *map->value[i]);
    return map->value[QG_OBJECTIVE_F_DTE] && map->value[QG_OBJECTIVE_F_PPS];
}

/* Rooms for results: the batch, the best, the reference, the map. */
static enum qg_status allocate(struct run *run) {
    const struct qg_analysis *analysis = &run->study->analysis;
    bool ok = true;
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++)
        ok = (run->slot[i] = qg_design_result_create(analysis)) && ok;
    ok = (run->best = qg_design_result_create(analysis)) && ok;
    if (run->study->kind == QG_STUDY_OPTIMIZE || run->study->kind == QG_STUDY_MAP)
        ok = (run->result->reference = qg_design_result_create(analysis)) && ok;
    if (run->study->kind == QG_STUDY_MAP)
        ok = allocate_map(&run->result->map, &run->study->grid) && ok;
    return ok ? QG_OK : QG_OUT_OF_MEMORY;
}

static size_t steps_of(const struct qg_study *study) {
    size_t steps = 2; /* compliance and the given design */
    if (study->kind == QG_STUDY_OPTIMIZE)
        steps += study->optimizer.random_samples + study->optimizer.simplex_iterations;
    if (study->kind == QG_STUDY_MAP)
        steps += qg_grid_cells(&study->grid);
    if (study->kind == QG_STUDY_EVALUATE)
        steps += study->analysis.branches == QG_BRANCHES_ALL;
    else
        steps += study->reliability.samples;
    return steps;
}

enum qg_status qg_study_run(const struct qg_study *study, const struct qg_means *means,
                            const struct qg_observer *observer, struct qg_study_result *result) {
    static const struct qg_observer nobody = {0};
    *result = (struct qg_study_result){0};
    struct run *run = calloc(1, sizeof *run);
    if (!run)
        return QG_OUT_OF_MEMORY;
    run->study = study;
    run->observer = observer ? observer : &nobody;
    run->result = result;
    run->total = steps_of(study);
    double start = now(run);
    enum qg_status status = qg_study_check(study, &result->geometry, NULL, &result->warnings);
    if (status == QG_OK)
        status = allocate(run);
    if (status == QG_OK)
        status = run_phases(run, means);
    result->timing.statics = run->evaluator.times.statics;
    result->timing.dynamics = run->evaluator.times.dynamics;
    result->timing.wall = now(run) - start;
    if (run->evaluator.model)
        qg_evaluator_finish(&run->evaluator);
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++)
        qg_design_result_destroy(run->slot[i]);
    result->design = run->best;
    qg_model_destroy(run->model);
    free(run);
    return status;
}

void qg_study_result_finish(struct qg_study_result *result) {
    qg_design_result_destroy(result->design);
    qg_design_result_destroy(result->reference);
    free(result->history);
    for (int i = 0; i < QG_OBJECTIVE_COUNT; i++)
        free(result->map.value[i]);
    *result = (struct qg_study_result){0};
}
