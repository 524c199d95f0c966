/* What the reader of an answer should know: responses without a period, branches cut short, a search without gain.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/force.h"
#include "core/study_internal.h"

/* Responses without a period are never silent: one warning for every load case that has some. */
static void warn_of_responses(struct qg_run *run, const struct qg_design_result *design, const char *name) {
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

static void warn_of_branches(struct qg_run *run, const struct qg_design_result *design) {
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
static void warn_of_large_approach(struct qg_run *run, const struct qg_design_result *design, const char *name) {
    const double most = 0.1 * design->pair.rack.module;
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

/* What the search compares designs by. */
static double compared(const struct qg_run *run, const struct qg_design_result *design) {
    const struct qg_evaluation judged = {
        .f_pps = design->f_pps, .f_dte = design->f_dte, .f_dte_percentile = design->f_dte_percentile};
    return qg_run_objective(run, &judged);
}

/* A search that was too short, or bounds or a grid that exclude what the reference has, may end above the reference. */
static void warn_of_no_gain(struct qg_run *run) {
    const struct qg_design_result *reference = run->result->reference, *design = run->best;
    double before = compared(run, reference), after = compared(run, design);
    const enum qg_study_kind kind = run->study->kind;
    if (after > before)
        qg_notes_add(&run->result->warnings,
                     kind == QG_STUDY_MAP     ? "grid"
                     : kind == QG_STUDY_MACRO ? "macro"
                                              : "optimizer",
                     "the best design found is %.1f %% worse than the reference: %s", 100 * (after / before - 1),
                     kind == QG_STUDY_MAP     ? "the grid lies elsewhere, or is too coarse"
                     : kind == QG_STUDY_MACRO ? "neither has reliefs yet; an optimization will tell"
                                              : "search longer, or widen the bounds");
}

static bool is_said(const struct qg_notes *notes, const struct qg_note *note) {
    for (size_t i = 0; i < notes->count; i++)
        if (strcmp(notes->item[i].where, note->where) == 0 && strcmp(notes->item[i].text, note->text) == 0)
            return true;
    return false;
}

/* Says what of the design that was found does nothing, unless the check has said it of the given one. */
static void warn_of_relief(struct qg_run *run) {
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

void qg_run_warn(struct qg_run *run) {
    const bool answered = run->study->kind != QG_STUDY_MACRO || run->has_best;
    if (run->result->reference && answered) {
        warn_of_no_gain(run);
        warn_of_relief(run);
    }
    if (run->result->reference) {
        warn_of_large_approach(run, run->result->reference, "reference");
        warn_of_responses(run, run->result->reference, "reference");
    }
    if (!answered)
        return;
    warn_of_large_approach(run, run->best, "design");
    warn_of_responses(run, run->best, "design");
    warn_of_branches(run, run->best);
    warn_beyond(run->best, &run->result->warnings);
}
