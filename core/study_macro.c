/* The search for an equivalent pair: the study's side of macro_sample.h.
 *
 * 1. Sampling. Blocks of a million samples are pieces of the executor; their tallies are merged in the order of the blocks.
 *    Nothing of it is logged: a study that was interrupted samples anew. That is 3 s of processor time for a billion
 *    where the tooth numbers reject most, as with the default ranges, and a minute where they reject nothing (docs/macro.md);
 *    the document allows a hundred billion, some 5 minutes of processor time and 100.
 * 2. Candidates. Every pair that was kept gets a finite-element model of its own and is judged without relief, stresses included, as one
 *    evaluation of the log with the sample's number as its mark. F_DTE of a recalled one comes from the log; its statics are
 *    computed again, because the candidate's other figures are not logged. Same bits either way.
 * A candidate whose model cannot be made is told in a warning and stays without figures; it ends nothing.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/macro_sample.h"
#include "core/study_internal.h"

/* ---- sampling ----------------------------------------------------------------------------------------------------- */

enum { BATCH = 32 }; /* blocks between two reports of progress */

struct sampling {
    const struct qg_run *run;
    struct qg_macro_search search;
    enum qg_batch_path path;
    size_t first; /* block of the batch */
    struct qg_macro_tally all, tally[BATCH];
};

static void sampling_piece(void *context, size_t item, int worker) {
    (void)worker;
    struct sampling *s = context;
    const struct qg_macro_block block = {&s->search, s->first + item, s->run->observer->cancelled,
                                         s->run->observer->self};
    qg_macro_block_run(&block, s->path, &s->tally[item]);
}

static bool is_cancelled(const struct qg_run *run) {
    return run->observer->cancelled && run->observer->cancelled(run->observer->self);
}

static enum qg_status sample_blocks(struct qg_run *run, struct sampling *s) {
    const size_t blocks = qg_macro_blocks(&s->search.macro);
    const struct qg_executor *executor = &run->evaluator.executor;
    for (s->first = 0; s->first < blocks; s->first += BATCH) {
        const size_t left = blocks - s->first, n = left < BATCH ? left : BATCH;
        executor->run(executor->self, n, sampling_piece, s);
        if (is_cancelled(run))
            return QG_CANCELLED;
        for (size_t i = 0; i < n; i++)
            qg_macro_tally_merge(&s->all, &s->tally[i]);
        qg_run_advance(run, n);
    }
    return QG_OK;
}

/* The kept samples as candidates, not judged yet. */
static enum qg_status list_candidates(const struct sampling *s, struct qg_macro_result *result) {
    const size_t room = 2 * s->all.keep;
    struct qg_macro_point point[2 * QG_MACRO_KEEP_MAX];
    bool on_front[2 * QG_MACRO_KEEP_MAX], among_best[2 * QG_MACRO_KEEP_MAX];
    result->candidate = calloc(room, sizeof *result->candidate);
    if (!result->candidate)
        return QG_OUT_OF_MEMORY;
    result->count = result->best = qg_macro_tally_choose(&s->all, point, on_front, among_best);
    for (size_t i = 0; i < result->count; i++) {
        struct qg_macro_candidate *c = &result->candidate[i];
        *c = (struct qg_macro_candidate){.point = point[i], .on_front = on_front[i], .among_best = among_best[i]};
        c->pair = qg_macro_sample(&s->search, point[i].sample, &c->pressure_angle_deg);
        c->is_possible = qg_pair_derive(&c->pair, &c->geometry, NULL) == QG_OK;
    }
    return QG_OK;
}

static void note_counts(const struct sampling *s, struct qg_macro_result *result) {
    result->samples = s->all.samples;
    result->passed = s->all.passed;
    for (int i = 0; i < QG_MACRO_CONSTRAINTS; i++)
        result->rejected[i] = s->all.rejected[i];
    result->initial = s->search.initial_rating;
    result->front_count = s->all.front_count;
    result->front_dropped = s->all.front_dropped;
}

static enum qg_status sample(struct qg_run *run) {
    const struct qg_study *study = run->study;
    struct sampling *s = calloc(1, sizeof *s);
    if (!s)
        return QG_OUT_OF_MEMORY;
    s->run = run;
    s->path = qg_macro_best_path();
    qg_macro_tally_init(&s->all, study->macro.keep);
    enum qg_status status = qg_macro_search_init(&s->search, &study->macro, &study->pair, &run->result->geometry);
    if (status == QG_OK)
        status = sample_blocks(run, s);
    if (status == QG_OK)
        status = list_candidates(s, &run->result->macro);
    if (status == QG_OK)
        note_counts(s, &run->result->macro);
    free(s);
    return status;
}

/* ---- candidates --------------------------------------------------------------------------------------------------- */

/* Judges a pair without relief by a model of its own, into slot 0. */
static enum qg_status judge_pair(struct qg_run *run, const struct qg_means *means, const struct qg_gear_pair *pair,
                                 bool dynamics) {
    struct qg_model *model;
    struct qg_evaluator evaluator;
    struct qg_notes notes = {0};
    const double start = qg_run_now(run);
    enum qg_status status = qg_model_create(pair, &run->study->analysis, means, &notes, &model);
    run->result->timing.compliance += qg_run_now(run) - start;
    if (status != QG_OK)
        return status;
    status = qg_evaluator_init(&evaluator, model, &means->executor);
    if (status == QG_OK) {
        evaluator.cancelled = run->observer->cancelled;
        evaluator.self = run->observer->self;
        evaluator.clock = run->observer->clock;
        run->slot[0]->relief = (struct qg_relief){0};
        status = qg_evaluate(&evaluator, dynamics, 1, run->slot);
        if (status == QG_OK)
            status = qg_evaluate_stresses(&evaluator, run->slot[0]);
        run->evaluator.times.statics += evaluator.times.statics;
        run->evaluator.times.dynamics += evaluator.times.dynamics;
        qg_evaluator_finish(&evaluator);
    }
    qg_model_destroy(model);
    return status;
}

/* The load case of the largest torque. */
static const struct qg_case_result *largest_case(const struct qg_design_result *design) {
    const struct qg_case_result *largest = &design->cases[0];
    for (size_t k = 1; k < design->case_count; k++)
        if (design->cases[k].torque > largest->torque)
            largest = &design->cases[k];
    return largest;
}

/* What the candidate's entry in the result says of the design in slot 0. */
static void note_figures(struct qg_macro_candidate *c, const struct qg_evaluation *e,
                         const struct qg_design_result *design) {
    const struct qg_case_result *largest = largest_case(design);
    c->judged = true;
    c->f_pps = e->f_pps;
    c->f_dte = e->f_dte;
    c->max_contact_pressure = c->max_root_stress = 0;
    for (size_t k = 0; k < design->case_count; k++) {
        const struct qg_stresses *s = design->cases[k].stresses;
        c->max_contact_pressure = fmax(c->max_contact_pressure, design->cases[k].max_contact_pressure);
        for (int i = 0; i < 2; i++)
            c->max_root_stress = fmax(c->max_root_stress, s->tension[i][s->most_tension[i]].stress);
    }
    c->loaded_contact_ratio = largest->loaded_contact_ratio;
    c->mean_mesh_stiffness = largest->mean_mesh_stiffness;
}

static void note_failure(struct qg_run *run, struct qg_macro_candidate *c, enum qg_status status) {
    c->f_pps = c->f_dte = c->max_contact_pressure = c->max_root_stress = c->loaded_contact_ratio =
        c->mean_mesh_stiffness = NAN;
    qg_notes_add(&run->result->warnings, "macro", "sample %llu passed, but could not be judged by finite elements: %s",
                 (unsigned long long)c->point.sample, qg_status_text(status));
}

/* Judges candidate i through the gate; recalled ones keep their logged values. */
static enum qg_status judge_candidate(struct qg_run *run, const struct qg_means *means, size_t i) {
    struct qg_macro_candidate *c = &run->result->macro.candidate[i];
    struct qg_evaluation *e = &run->evaluation[0];
    const bool known = qg_run_begin_evaluation(run, (double)c->point.sample, e);
    c->evaluation = e->number;
    const enum qg_status judged = judge_pair(run, means, &c->pair, !known);
    const bool failed = judged == QG_NO_CONVERGENCE || judged == QG_IMPOSSIBLE_GEAR;
    if (judged != QG_OK && !failed)
        return judged;
    if (!known && !failed) {
        e->f_pps = run->slot[0]->f_pps;
        e->f_dte = run->slot[0]->f_dte;
    }
    const enum qg_status recorded = known ? QG_OK : qg_run_record(run, e);
    if (recorded != QG_OK)
        return recorded;
    if (failed) {
        note_failure(run, c, judged);
        return QG_OK;
    }
    note_figures(c, e, run->slot[0]);
    if (!run->has_best || qg_run_objective(run, e) < run->best_value)
        run->result->macro.best = i;
    return qg_run_consider(run, 0, !known);
}

/* After recalled candidates the best one's dynamics are still to be computed. */
static enum qg_status complete_best(struct qg_run *run, const struct qg_means *means) {
    const struct qg_macro_result *macro = &run->result->macro;
    if (!run->has_best || run->best_known)
        return QG_OK;
    const enum qg_status status = judge_pair(run, means, &macro->candidate[macro->best].pair, true);
    if (status != QG_OK)
        return status;
    struct qg_design_result *t = run->best;
    run->best = run->slot[0];
    run->slot[0] = t;
    run->best_known = true;
    if (run->observer->improved)
        run->observer->improved(run->observer->self, run->best);
    return QG_OK;
}

/* ---- the whole ---------------------------------------------------------------------------------------------------- */

/* Why there is none: the test that rejected most, and the one that nothing got beyond. */
static void warn_of_none(struct qg_run *run) {
    const struct qg_macro_result *macro = &run->result->macro;
    int most = 0, last = 0;
    for (int i = 1; i < QG_MACRO_CONSTRAINTS; i++) {
        most = macro->rejected[i] > macro->rejected[most] ? i : most;
        last = macro->rejected[i] > 0 ? i : last;
    }
    qg_notes_add(
        &run->result->warnings, "macro",
        "none of %llu samples passed; most were rejected by %s (%s), the %llu that got furthest by %s (%s): more "
        "samples, narrower ranges or wider limits may find some",
        (unsigned long long)macro->samples, qg_macro_constraint_name((enum qg_macro_constraint)most),
        qg_macro_constraint_text((enum qg_macro_constraint)most), (unsigned long long)macro->rejected[last],
        qg_macro_constraint_name((enum qg_macro_constraint)last),
        qg_macro_constraint_text((enum qg_macro_constraint)last));
}

static void warn_of_samples(struct qg_run *run) {
    const struct qg_macro_result *macro = &run->result->macro;
    if (macro->passed == 0)
        warn_of_none(run);
    if (macro->front_dropped > 0)
        qg_notes_add(&run->result->warnings, "macro",
                     "the front had room for %d points at a time; %zu were dropped, those whose neighbours had the "
                     "nearest contact ratios",
                     QG_MACRO_FRONT_ROOM, macro->front_dropped);
}

enum qg_status qg_run_macro(struct qg_run *run, const struct qg_means *means) {
    struct qg_macro_result *macro = &run->result->macro;
    run->phase = QG_PHASE_SAMPLING;
    qg_run_report_progress(run);
    enum qg_status status = sample(run);
    run->phase = QG_PHASE_CANDIDATES;
    for (size_t i = 0; i < macro->count && status == QG_OK; i++) {
        status = judge_candidate(run, means, i);
        qg_run_advance(run, status == QG_OK);
    }
    if (status == QG_OK)
        status = complete_best(run, means);
    if (status != QG_OK)
        return status;
    qg_run_advance(run, 2 * run->study->macro.keep - macro->count);
    warn_of_samples(run);
    return QG_OK;
}
