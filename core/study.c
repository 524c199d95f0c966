/* Running a study: compliance, reference, search or map or macro-geometries, reliability, branches. Evaluations go through the gate of
 * study_gate.c.
 */
#include "core/study.h"

#include <assert.h>
#include <cblas.h>
#include <malloc.h>
#include <stdlib.h>

#include "core/macro_sample.h"
#include "core/study_internal.h"

const char *qg_phase_name(enum qg_phase phase) {
    static const char *const names[QG_PHASE_COUNT] = {"compliance",  "reference",   "random",   "simplex",
                                                      "reliability", "map",         "sampling", "candidates",
                                                      "multistart",  "verification"};
    assert((unsigned)phase < QG_PHASE_COUNT);
    return names[phase];
}

/* Large arrays are mapped, and given back when they are freed. The C library would raise that bound to the largest array freed
 * so far, keep the others in its heaps, one for each thread, and hold half as much again as is in use (docs/operations.md). */
enum { MAPPED_FROM = 1 << 20 };

/* OpenBLAS's own (driver/others/memory.c): a buffer, mapped or found free; and back among the free ones. */
void *blas_memory_alloc(int position);
void blas_memory_free(void *buffer);

enum { BLAS_BUFFERS_MAX = 64, BLAS_BUFFER_BYTES = 128 << 20 };

/* Whether there are addresses for one more buffer. */
static bool has_room_for_buffer(void) {
    void *volatile room = malloc((size_t)BLAS_BUFFER_BYTES + (1 << 20)); /* mapped, not touched */
    free(room);
    return room;
}

bool qg_numerics_init(int threads) {
    void *buffer[BLAS_BUFFERS_MAX];
    /* OpenBLAS's own threads, which it has from the start, may not have taken theirs yet */
    int wanted = threads + openblas_get_num_threads() - 1, count = 0;
    openblas_set_num_threads(1);
    mallopt(M_MMAP_THRESHOLD, MAPPED_FROM);
    if (wanted > BLAS_BUFFERS_MAX)
        wanted = BLAS_BUFFERS_MAX;
    while (count < wanted && has_room_for_buffer())
        buffer[count++] = blas_memory_alloc(0);
    bool enough = count == wanted;
    while (count > 0)
        blas_memory_free(buffer[--count]);
    return enough;
}

static enum qg_status build_model(struct qg_run *run, const struct qg_means *means) {
    double start = qg_run_now(run);
    run->phase = QG_PHASE_COMPLIANCE;
    qg_run_report_progress(run);
    enum qg_status status =
        qg_model_create(&run->study->pair, &run->study->analysis, means, &run->result->warnings, &run->model);
    run->result->timing.compliance = qg_run_now(run) - start;
    if (status != QG_OK)
        return status;
    run->result->size = qg_model_size(run->model);
    status = qg_evaluator_init(&run->evaluator, run->model, &means->executor);
    run->evaluator.cancelled = run->observer->cancelled;
    run->evaluator.self = run->observer->self;
    run->evaluator.clock = run->observer->clock;
    qg_run_advance(run, 1);
    return status;
}

/* Judges the given design, always with its full result, which goes to *given. */
static enum qg_status judge_given(struct qg_run *run, struct qg_design_result **given) {
    run->phase = QG_PHASE_REFERENCE;
    qg_run_report_progress(run);
    run->slot[0]->relief = (*given)->relief = run->study->relief;
    bool computed = false;
    enum qg_status status = qg_run_judge(run, true, 1, &computed);
    if (status == QG_OK && computed) {
        struct qg_design_result *t = *given;
        *given = run->slot[0];
        run->slot[0] = t;
    } else if (status == QG_OK) {
        (*given)->f_dte_percentile = run->evaluation[0].f_dte_percentile;
        status = qg_evaluate(&run->evaluator, true, 1, given);
    }
    for (unsigned i = 0; i < QG_OBJECTIVE_COUNT && status == QG_OK; i++)
        run->reference_value[i] = qg_objective_of(i, &run->evaluation[0]);
    if (status == QG_OK && qg_run_is_multiobjective(run))
        status = qg_run_compete(run, 0);
    if (status == QG_OK && run->observer->reference)
        run->observer->reference(run->observer->self, *given);
    qg_run_advance(run, 1);
    return status;
}

/* The values of the batch that starts at a cell go to the map. */
static enum qg_status note_cells(struct qg_run *run, size_t first, size_t n, const bool *computed) {
    struct qg_map *map = &run->result->map;
    enum qg_status status = QG_OK;
    bool all_fresh = true;
    for (size_t i = 0; i < n && status == QG_OK; i++) {
        map->value[QG_OBJECTIVE_F_DTE][first + i] = run->evaluation[i].f_dte;
        map->value[QG_OBJECTIVE_F_PPS][first + i] = run->evaluation[i].f_pps;
        status = qg_run_consider(run, i, computed[i]);
        all_fresh = all_fresh && computed[i];
    }
    if (status == QG_OK)
        qg_run_advance(run, n);
    return status == QG_OK && all_fresh ? qg_run_complete_best(run) : status;
}

/* Judges all cells of the grid, statics and dynamics. */
static enum qg_status map_cells(struct qg_run *run) {
    const struct qg_study *study = run->study;
    enum qg_status status = QG_OK;
    run->phase = QG_PHASE_MAP;
    for (size_t done = 0; done < run->result->map.cells && status == QG_OK;) {
        const size_t left = run->result->map.cells - done, n = left < QG_SEARCH_BATCH ? left : QG_SEARCH_BATCH;
        bool computed[QG_SEARCH_BATCH];
        for (size_t i = 0; i < n; i++)
            run->slot[i]->relief = qg_grid_relief(&study->grid, &study->relief, done + i);
        status = qg_run_judge(run, true, n, computed);
        if (status == QG_OK)
            status = note_cells(run, done, n, computed);
        done += n;
    }
    return status == QG_OK ? qg_run_complete_best(run) : status;
}

/* Judges all trials and sums them up. */
static enum qg_status try_reliability(struct qg_run *run, const struct qg_relief *design) {
    const struct qg_reliability *r = &run->study->reliability;
    double *f_dte = malloc(r->samples * sizeof *f_dte);
    enum qg_status status = f_dte ? QG_OK : QG_OUT_OF_MEMORY;
    run->phase = QG_PHASE_RELIABILITY;
    for (size_t done = 0; done < r->samples && status == QG_OK;) {
        size_t n = r->samples - done < QG_SEARCH_BATCH ? r->samples - done : QG_SEARCH_BATCH;
        bool computed[QG_SEARCH_BATCH];
        for (size_t i = 0; i < n; i++)
            run->slot[i]->relief = qg_reliability_trial(r, &run->study->pair, &run->result->geometry, design, done + i);
        status = qg_run_judge(run, true, n, computed);
        for (size_t i = 0; i < n && status == QG_OK; i++)
            f_dte[done + i] = run->evaluation[i].f_dte;
        done += n;
        if (status == QG_OK)
            qg_run_advance(run, n);
    }
    if (status == QG_OK)
        qg_reliability_summarize(r, design, f_dte, &run->result->reliability);
    free(f_dte);
    return status;
}

static enum qg_status find_branches(struct qg_run *run) {
    if (run->study->kind != QG_STUDY_EVALUATE || run->study->analysis.branches != QG_BRANCHES_ALL)
        return QG_OK;
    enum qg_status status = qg_evaluate_branches(&run->evaluator, run->best);
    qg_run_advance(run, 1);
    return status;
}

/* Stresses of the designs that the answer holds. They depend on the design alone, not on how it was found. A macro study's
 * design has them from its own model. */
static enum qg_status find_stresses(struct qg_run *run) {
    const bool is_of_this_model = run->study->kind != QG_STUDY_MACRO;
    enum qg_status status = is_of_this_model ? qg_evaluate_stresses(&run->evaluator, run->best) : QG_OK;
    if (status == QG_OK && run->result->reference)
        status = qg_evaluate_stresses(&run->evaluator, run->result->reference);
    return status;
}

/* ISO 6336 beside the finite elements. */
static void rate(struct qg_run *run) {
    const struct qg_gear_pair *pair = &run->study->pair;
    struct qg_study_result *result = run->result;
    result->is_rated = qg_iso6336_rate(pair, &result->geometry, pair->nominal_torque, &result->iso6336) == QG_OK;
    if (!result->is_rated)
        qg_notes_add(
            &result->warnings, "",
            "ISO 6336 has no tooth-root stress for this pair: no 30 degree tangent touches a fillet, or the load at "
            "the outer point of single contact acts below it");
}

/* Kinds whose given design is not the answer but what it is compared with. */
static bool has_reference(const struct qg_study *study) {
    return study->kind == QG_STUDY_OPTIMIZE || study->kind == QG_STUDY_MAP || study->kind == QG_STUDY_MACRO;
}

static enum qg_status run_phases(struct qg_run *run, const struct qg_means *means) {
    const struct qg_study *study = run->study;
    rate(run);
    enum qg_status status = build_model(run, means);
    const bool optimize = study->kind == QG_STUDY_OPTIMIZE, map = study->kind == QG_STUDY_MAP;
    struct qg_design_result **given = has_reference(study) ? &run->result->reference : &run->best;
    if (status == QG_OK)
        status = judge_given(run, given);
    if (status == QG_OK && optimize)
        status = qg_run_search(run);
    if (status == QG_OK && map)
        status = map_cells(run);
    if (status == QG_OK && study->kind == QG_STUDY_MACRO)
        status = qg_run_macro(run, means);
    if (status == QG_OK)
        status = qg_run_verify(run, means);
    if (status == QG_OK && study->reliability.samples > 0 && study->kind != QG_STUDY_EVALUATE)
        status = try_reliability(run, &run->best->relief);
    if (status == QG_OK)
        status = find_branches(run);
    if (status == QG_OK)
        status = find_stresses(run);
    if (status == QG_OK)
        qg_run_warn(run);
    return status;
}

static bool allocate_map(struct qg_map *map, const struct qg_grid *grid) {
    map->cells = qg_grid_cells(grid);
    for (int i = 0; i < QG_MAP_OBJECTIVES; i++)
        map->value[i] = calloc(map->cells, sizeof *map->value[i]);
    return map->value[QG_OBJECTIVE_F_DTE] && map->value[QG_OBJECTIVE_F_PPS];
}

static bool allocate_trials(struct qg_run *run) {
    bool ok = true;
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++)
        ok = (run->percentile.slot[i] = qg_design_result_create(&run->study->analysis)) && ok;
    run->percentile.f_dte = calloc(QG_SEARCH_BATCH * run->study->reliability.percentile_trials, sizeof(double));
    return ok && run->percentile.f_dte;
}

/* Rooms for results: the batch, the best, the reference, the map. */
static enum qg_status allocate(struct qg_run *run) {
    const struct qg_analysis *analysis = &run->study->analysis;
    bool ok = true;
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++)
        ok = (run->slot[i] = qg_design_result_create(analysis)) && ok;
    ok = (run->best = qg_design_result_create(analysis)) && ok;
    if (has_reference(run->study))
        ok = (run->result->reference = qg_design_result_create(analysis)) && ok;
    if (run->study->kind == QG_STUDY_MAP)
        ok = allocate_map(&run->result->map, &run->study->grid) && ok;
    if (run->percentile.asked)
        ok = allocate_trials(run) && ok;
    return ok ? QG_OK : QG_OUT_OF_MEMORY;
}

static size_t steps_of(const struct qg_study *study) {
    size_t steps = 2 + qg_verification_steps(study); /* compliance and the given design */
    if (study->kind == QG_STUDY_OPTIMIZE)
        steps += study->optimizer.method == QG_SEARCH_RANDOM_SIMPLEX
                     ? study->optimizer.random_samples + study->optimizer.simplex_iterations
                     : study->optimizer.evaluations;
    if (study->kind == QG_STUDY_MAP)
        steps += qg_grid_cells(&study->grid);
    if (study->kind == QG_STUDY_MACRO)
        steps += qg_macro_blocks(&study->macro) + 2 * study->macro.keep;
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
    struct qg_run *run = calloc(1, sizeof *run);
    if (!run)
        return QG_OUT_OF_MEMORY;
    run->study = study;
    run->observer = observer ? observer : &nobody;
    struct qg_means own = *means;
    if (run->observer->cancelled)
        own.stop = (struct qg_stop){run->observer->cancelled, run->observer->self};
    run->result = result;
    run->total = steps_of(study);
    result->front.objectives = study->objectives.count;
    run->percentile.asked = study->kind == QG_STUDY_OPTIMIZE && qg_study_asks(study, QG_OBJECTIVE_F_DTE_PERCENTILE);
    double start = qg_run_now(run);
    enum qg_status status = qg_study_check(study, &result->geometry, NULL, &result->warnings);
    if (status == QG_OK)
        status = allocate(run);
    if (status == QG_OK)
        status = run_phases(run, &own);
    result->timing.statics = run->evaluator.times.statics;
    result->timing.dynamics = run->evaluator.times.dynamics;
    result->timing.wall = qg_run_now(run) - start;
    if (run->evaluator.model)
        qg_evaluator_finish(&run->evaluator);
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++) {
        qg_design_result_destroy(run->slot[i]);
        qg_design_result_destroy(run->percentile.slot[i]);
    }
    free(run->percentile.f_dte);
    if (study->kind == QG_STUDY_MACRO && !run->has_best) { /* no candidate: no answer */
        qg_design_result_destroy(run->best);
        run->best = NULL;
    }
    result->design = run->best;
    qg_model_destroy(run->model);
    free(run);
    return status;
}

void qg_study_result_finish(struct qg_study_result *result) {
    qg_design_result_destroy(result->design);
    qg_design_result_destroy(result->reference);
    free(result->history);
    qg_front_finish(&result->front);
    for (int i = 0; i < QG_MAP_OBJECTIVES; i++)
        free(result->map.value[i]);
    free(result->macro.candidate);
    *result = (struct qg_study_result){0};
}
