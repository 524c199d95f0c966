/* The result of a macro-geometry search: what each constraint rejected, and the pairs that were kept.
 */
#include <inttypes.h>
#include <stdio.h>

#include "schema/members.h"
#include "schema/result_internal.h"

/* In the order of testing. */
static void write_rejected(struct qg_text *text, const struct qg_macro_result *macro) {
    qg_json_name(text, "rejected");
    qg_json_open(text, '[');
    for (int i = 0; i < QG_MACRO_CONSTRAINTS; i++) {
        qg_json_open(text, '{');
        qg_json_name(text, "constraint");
        qg_json_string(text, qg_macro_constraint_name((enum qg_macro_constraint)i));
        integer(text, "count", macro->rejected[i]);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

static void write_initial(struct qg_text *text, const struct qg_study_result *result) {
    qg_json_name(text, "initial");
    qg_json_open(text, '{');
    number(text, "contact_ratio", result->geometry.contact_ratio);
    number(text, "iso_contact_stress_mpa", result->macro.initial.contact_stress);
    number(text, "iso_root_stress_mpa", result->macro.initial.root_stress);
    qg_json_close(text, '}');
}

static void write_candidate(struct qg_text *text, const struct qg_job *job, const struct qg_macro_candidate *c) {
    char name[64];
    snprintf(name, sizeof name, "sample %" PRIu64 " of seed %" PRIu64, c->point.sample, job->study.macro.seed);
    qg_json_open(text, '{');
    integer(text, "evaluation", c->evaluation);
    integer(text, "sample", c->point.sample);
    boolean(text, "among_best", c->among_best);
    boolean(text, "on_front", c->on_front);
    number(text, "contact_ratio", c->point.contact_ratio);
    number(text, "contact_stress_factor", c->point.contact_stress);
    number(text, "root_stress_factor", c->point.root_stress);
    boolean(text, "judged", c->judged);
    number(text, "f_pps_um", c->f_pps * 1e3);
    number(text, "f_dte", c->f_dte);
    number(text, "max_contact_pressure_mpa", c->max_contact_pressure);
    number(text, "max_root_stress_mpa", c->max_root_stress);
    number(text, "loaded_contact_ratio", c->loaded_contact_ratio);
    number(text, "mean_mesh_stiffness_n_per_mm", c->mean_mesh_stiffness);
    qg_json_name(text, "geometry");
    if (c->is_possible)
        qg_geometry_write(text, &c->geometry);
    else
        qg_json_null(text);
    qg_json_name(text, "gear_pair");
    qg_pair_write(text, job, &c->pair, c->pressure_angle_deg, name);
    qg_json_close(text, '}');
}

void qg_macro_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result) {
    const struct qg_macro_result *macro = &result->macro;
    qg_json_name(text, "macro");
    if (macro->samples == 0) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    integer(text, "samples", macro->samples);
    integer(text, "passed", macro->passed);
    write_rejected(text, macro);
    write_initial(text, result);
    integer(text, "front_size", macro->front_count);
    qg_json_name(text, "best");
    if (macro->best < macro->count)
        qg_json_integer(text, (int64_t)macro->best);
    else
        qg_json_null(text);
    qg_json_name(text, "candidates");
    qg_json_open(text, '[');
    for (size_t i = 0; i < macro->count; i++)
        write_candidate(text, job, &macro->candidate[i]);
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}
