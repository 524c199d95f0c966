/* The writer of results. Core's units become those in the names here: micrometres for errors, N m for torques, degrees for
 * angles. NaN, which core uses for "not computed", becomes null.
 */
#include "schema/result.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "config.h"
#include "schema/fields.h"
#include "schema/members.h"
#include "schema/result_internal.h"
#include "schema/stress_result.h"

static const char *const gear_names[] = {[QG_PINION] = "pinion", [QG_GEAR] = "gear"};

double qg_objective_at_the_edge(enum qg_objective objective, double value) {
    return objective == QG_OBJECTIVE_F_PPS ? value * um_per_mm : value;
}

/* An array of n numbers, each times factor. */
static void numbers(struct qg_text *text, const double *values, size_t n, double factor) {
    qg_json_open(text, '[');
    for (size_t i = 0; i < n; i++)
        qg_json_number(text, values[i] * factor);
    qg_json_close(text, ']');
}

/* Geometry */

static void write_gear_geometry(struct qg_text *text, const struct qg_pair_geometry *geometry, int i) {
    const struct qg_gear_geometry *gear = &geometry->gears[i];
    open_member(text, gear_names[i], '{');
    number(text, "reference_radius_mm", gear->reference_radius);
    number(text, "base_radius_mm", gear->base_radius);
    number(text, "form_radius_mm", gear->form_radius);
    number(text, "tooth_thickness_mm", gear->tooth_thickness);
    number(text, "tip_thickness_mm", gear->tip_thickness);
    number(text, "tip_clearance_mm", geometry->tip_clearance[i]);
    number(text, "hob_addendum_mm", gear->hob_addendum);
    number(text, "moment_of_inertia_kg_mm2", gear->moment_of_inertia);
    qg_json_close(text, '}');
}

void qg_geometry_write(struct qg_text *text, const struct qg_pair_geometry *geometry) {
    qg_json_open(text, '{');
    number(text, "working_pressure_angle_deg", geometry->working_pressure_angle * (180 / M_PI));
    number(text, "base_pitch_mm", geometry->base_pitch);
    number(text, "line_of_action_mm", geometry->line_length);
    number(text, "path_start_mm", geometry->path_start);
    number(text, "path_end_mm", geometry->path_end);
    number(text, "path_length_mm", geometry->path_end - geometry->path_start);
    number(text, "contact_ratio", geometry->contact_ratio);
    number(text, "backlash_mm", geometry->backlash);
    number(text, "equivalent_mass_kg", geometry->equivalent_mass);
    number(text, "contact_width_mm", geometry->face_width);
    for (int i = QG_PINION; i <= QG_GEAR; i++)
        write_gear_geometry(text, geometry, i);
    qg_json_close(text, '}');
}

/* Designs */

static void write_load_share(struct qg_text *text, const struct qg_case_result *one, size_t positions) {
    open_member(text, "load_share", '{');
    open_member(text, "pair", '[');
    for (int k = -QG_PAIR_REACH; k <= QG_PAIR_REACH; k++)
        qg_json_integer(text, k);
    qg_json_close(text, ']');
    open_member(text, "share", '[');
    for (size_t i = 0; i < positions; i++)
        numbers(text, one->load_share + i * QG_PAIR_COUNT, QG_PAIR_COUNT, 1);
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

/* What statics yields over the mesh positions. */
static void write_statics(struct qg_text *text, const struct qg_case_result *one, size_t n) {
    const struct {
        const char *name;
        const double *values;
        double factor;
    } curves[] = {
        {"static_transmission_error_um", one->static_transmission_error, um_per_mm},
        {"unloaded_transmission_error_um", one->unloaded_transmission_error, um_per_mm},
        {"mesh_stiffness_n_per_mm", one->mesh_stiffness, 1},
        {"contact_pressure_mpa", one->contact_pressure, 1},
    };
    for (size_t i = 0; i < sizeof curves / sizeof *curves; i++) {
        qg_json_name(text, curves[i].name);
        numbers(text, curves[i].values, n, curves[i].factor);
    }
    write_load_share(text, one, n);
}

/* Branches: every member of a point in an array of its own. */

static void write_multipliers(struct qg_text *text, const struct qg_curve *curve) {
    open_member(text, "multipliers", '[');
    for (size_t i = 0; i < curve->count; i++) {
        const struct qg_branch_point *point = &curve->point[i];
        qg_json_open(text, '[');
        for (int k = 0; k < 2; k++) {
            qg_json_open(text, '[');
            qg_json_number(text, point->multiplier_real[k]);
            qg_json_number(text, point->multiplier_imaginary[k]);
            qg_json_close(text, ']');
        }
        qg_json_close(text, ']');
    }
    qg_json_close(text, ']');
}

static void write_special_points(struct qg_text *text, const struct qg_curve *curve) {
    open_member(text, "special_points", '[');
    for (size_t i = 0; i < curve->special_count; i++) {
        qg_json_open(text, '{');
        qg_json_name(text, "type");
        qg_json_string(text, qg_special_name(curve->special[i].kind));
        number(text, "frequency_ratio", curve->special[i].frequency_ratio);
        number(text, "rms", curve->special[i].rms);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

/* One figure of every point of a curve. */
static void write_points(struct qg_text *text, const char *name, const struct qg_curve *curve, size_t offset) {
    open_member(text, name, '[');
    for (size_t i = 0; i < curve->count; i++)
        qg_json_number(text, *(const double *)((const char *)&curve->point[i] + offset));
    qg_json_close(text, ']');
}

static void write_curve(struct qg_text *text, const struct qg_curve *curve) {
    qg_json_open(text, '{');
    integer(text, "period", (size_t)curve->period);
    open_member(text, "ends", '[');
    for (int i = 0; i < 2; i++)
        qg_json_string(text, qg_branch_end_name(curve->end[i]));
    qg_json_close(text, ']');
    write_points(text, "frequency_ratio", curve, offsetof(struct qg_branch_point, frequency_ratio));
    write_points(text, "rms", curve, offsetof(struct qg_branch_point, rms));
    write_points(text, "mean", curve, offsetof(struct qg_branch_point, mean));
    open_member(text, "stable", '[');
    for (size_t i = 0; i < curve->count; i++)
        qg_json_bool(text, curve->point[i].stable);
    qg_json_close(text, ']');
    write_multipliers(text, curve);
    write_special_points(text, curve);
    qg_json_close(text, '}');
}

/* Only there when it was asked for. */
static void write_branches(struct qg_text *text, const struct qg_branches *branches) {
    if (!branches)
        return;
    open_member(text, "branches", '[');
    for (size_t i = 0; i < branches->count; i++)
        write_curve(text, &branches->curve[i]);
    qg_json_close(text, ']');
}

static void write_dynamics(struct qg_text *text, const struct qg_job *job, const struct qg_design_result *design,
                           size_t i) {
    const struct qg_case_result *one = &design->cases[i];
    const bool computed = !isnan(one->max_rms);
    number(text, "max_rms", one->max_rms);
    number(text, "max_rms_at", computed ? one->max_rms_at : NAN);
    number(text, "max_rms_at_pinion_rpm", computed ? qg_pinion_rpm(design, one, one->max_rms_at) : NAN);
    if (computed) {
        open_member(text, "frequency_response", '{');
        qg_frequency_ratios_write(text, job);
        qg_response_write(text, job, one);
        qg_json_close(text, '}');
    } else {
        qg_json_name(text, "frequency_response");
        qg_json_null(text);
    }
}

static void write_case(struct qg_text *text, const struct qg_job *job, const struct qg_design_result *design,
                       size_t i) {
    const struct qg_case_result *one = &design->cases[i];
    qg_json_open(text, '{');
    number(text, "torque_nm", one->torque / nmm_per_nm);
    number(text, "normal_force_n", one->normal_force);
    write_statics(text, one, design->positions);
    number(text, "mean_mesh_stiffness_n_per_mm", one->mean_mesh_stiffness);
    number(text, "pps_um", one->pps * um_per_mm);
    number(text, "loaded_contact_ratio", one->loaded_contact_ratio);
    number(text, "max_contact_pressure_mpa", one->max_contact_pressure);
    qg_stresses_write(text, one->stresses, -QG_PAIR_REACH);
    number(text, "complementarity_residual", one->complementarity_residual);
    number(text, "natural_frequency_hz", one->natural_frequency);
    write_dynamics(text, job, design, i);
    write_branches(text, one->branches);
    qg_json_close(text, '}');
}

/* A design, or null. */
static void write_design(struct qg_text *text, const struct qg_job *job, const struct qg_design_result *design) {
    if (!design) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    qg_json_name(text, "relief");
    qg_relief_write(text, &design->relief);
    number(text, "f_pps_um", design->f_pps * um_per_mm);
    number(text, "f_dte", design->f_dte);
    number(text, "f_dte_percentile", design->f_dte_percentile);
    open_member(text, "load_cases", '[');
    for (size_t i = 0; i < design->case_count; i++)
        write_case(text, job, design, i);
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

/* The rest of a result */

/* By how much the design is below the reference, in percent of it; NaN when that says nothing. */
static double improvement(double design, double reference) {
    return reference > 0 ? 100 * (reference - design) / reference : NAN;
}

static void write_improvement(struct qg_text *text, const struct qg_study_result *result) {
    qg_json_name(text, "improvement");
    if (!result->design || !result->reference) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    number(text, "f_dte_percent", improvement(result->design->f_dte, result->reference->f_dte));
    number(text, "f_pps_percent", improvement(result->design->f_pps, result->reference->f_pps));
    number(text, "f_dte_percentile_percent",
           improvement(result->design->f_dte_percentile, result->reference->f_dte_percentile));
    qg_json_close(text, '}');
}

/* The front and its hypervolume, or two nulls. */
static void write_front(struct qg_text *text, const struct qg_study_result *result) {
    const struct qg_front *front = &result->front;
    number(text, "hypervolume", front->objectives > 0 ? result->hypervolume : NAN);
    qg_json_name(text, "pareto");
    if (front->objectives == 0) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '[');
    for (size_t i = 0; i < front->count; i++) {
        const struct qg_front_member *member = &front->member[i];
        qg_json_open(text, '{');
        integer(text, "evaluation", member->evaluation);
        qg_json_name(text, "relief");
        qg_relief_write(text, &member->relief);
        number(text, "f_pps_um", member->f_pps * um_per_mm);
        number(text, "f_dte", member->f_dte);
        number(text, "f_dte_percentile", member->f_dte_percentile);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

/* Reference and design at more mesh positions, or null. */
static void write_verification(struct qg_text *text, const struct qg_study_result *result) {
    const struct qg_verification *v = &result->verification;
    static const char *const designs[] = {"reference", "design"};
    qg_json_name(text, "verification");
    if (v->mesh_positions == 0) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    integer(text, "mesh_positions", (size_t)v->mesh_positions);
    for (int i = 0; i < 2; i++) {
        open_member(text, designs[i], '{');
        number(text, "f_pps_um", v->f_pps[i] * um_per_mm);
        number(text, "f_dte", v->f_dte[i]);
        qg_json_close(text, '}');
    }
    open_member(text, "improvement", '{');
    number(text, "f_dte_percent", improvement(v->f_dte[1], v->f_dte[0]));
    number(text, "f_pps_percent", improvement(v->f_pps[1], v->f_pps[0]));
    qg_json_close(text, '}');
    qg_json_close(text, '}');
}

static void write_search(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result) {
    qg_json_name(text, "search");
    if (job->study.kind != QG_STUDY_OPTIMIZE) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    integer(text, "evaluations", result->evaluations);
    qg_json_name(text, "method");
    qg_json_string(text, qg_method_name(job->study.optimizer.method));
    number(text, "simplex_iterations",
           job->study.optimizer.method == QG_SEARCH_RANDOM_SIMPLEX ? (double)result->simplex_iterations : NAN);
    open_member(text, "history", '[');
    for (size_t i = 0; i < result->history_count; i++) {
        qg_json_open(text, '{');
        integer(text, "evaluation", result->history[i].evaluation);
        number(text, "best", qg_objective_at_the_edge(job->study.objective, result->history[i].best));
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
    write_front(text, result);
    qg_json_close(text, '}');
}

/* Maps: what lies where on the grid */

/* Where a cell lies, and both objectives there. */
static void write_cell(struct qg_text *text, const struct qg_grid *grid, const struct qg_map *map, size_t cell) {
    qg_json_open(text, '{');
    open_member(text, "cell", '[');
    for (size_t k = 0; k < grid->count; k++)
        qg_json_integer(text, (int64_t)qg_grid_index(grid, cell, k));
    qg_json_close(text, ']');
    open_member(text, "values", '[');
    for (size_t k = 0; k < grid->count; k++)
        qg_json_number(text, qg_axis_at(&grid->axis[k], qg_grid_index(grid, cell, k)));
    qg_json_close(text, ']');
    number(text, "f_pps_um", map->value[QG_OBJECTIVE_F_PPS][cell] * um_per_mm);
    number(text, "f_dte", map->value[QG_OBJECTIVE_F_DTE][cell]);
    qg_json_close(text, '}');
}

static void write_axes(struct qg_text *text, const struct qg_grid *grid) {
    open_member(text, "axes", '[');
    for (size_t k = 0; k < grid->count; k++) {
        qg_json_open(text, '{');
        qg_json_name(text, "parameter");
        qg_json_string(text, qg_parameter_name(grid->axis[k].parameter));
        open_member(text, "values", '[');
        for (size_t i = 0; i < grid->axis[k].count; i++)
            qg_json_number(text, qg_axis_at(&grid->axis[k], i));
        qg_json_close(text, ']');
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

/* An array for one axis, an array of rows for two. */
static void write_cells(struct qg_text *text, const struct qg_grid *grid, const double *values, double factor) {
    if (grid->count == 1) {
        numbers(text, values, grid->axis[0].count, factor);
        return;
    }
    qg_json_open(text, '[');
    for (size_t i = 0; i < grid->axis[0].count; i++)
        numbers(text, values + i * grid->axis[1].count, grid->axis[1].count, factor);
    qg_json_close(text, ']');
}

static void write_minima(struct qg_text *text, const struct qg_grid *grid, const struct qg_map *map) {
    static const enum qg_objective order[] = {QG_OBJECTIVE_F_PPS, QG_OBJECTIVE_F_DTE};
    static const char *const names[] = {[QG_OBJECTIVE_F_PPS] = "f_pps", [QG_OBJECTIVE_F_DTE] = "f_dte"};
    open_member(text, "minima", '{');
    for (int i = 0; i < QG_MAP_OBJECTIVES; i++) {
        qg_json_name(text, names[order[i]]);
        write_cell(text, grid, map, qg_grid_smallest(grid, map->value[order[i]]));
    }
    qg_json_close(text, '}');
    open_member(text, "local_minima", '{');
    for (int i = 0; i < QG_MAP_OBJECTIVES; i++) {
        open_member(text, names[order[i]], '[');
        for (size_t cell = 0; cell < map->cells; cell++)
            if (qg_grid_is_local_minimum(grid, map->value[order[i]], cell))
                write_cell(text, grid, map, cell);
        qg_json_close(text, ']');
    }
    qg_json_close(text, '}');
}

static void write_map(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result) {
    const struct qg_grid *grid = &job->study.grid;
    qg_json_name(text, "map");
    if (result->map.cells == 0) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    write_axes(text, grid);
    qg_json_name(text, "f_pps_um");
    write_cells(text, grid, result->map.value[QG_OBJECTIVE_F_PPS], um_per_mm);
    qg_json_name(text, "f_dte");
    write_cells(text, grid, result->map.value[QG_OBJECTIVE_F_DTE], 1);
    write_minima(text, grid, &result->map);
    qg_json_close(text, '}');
}

/* Each tolerance's share in the spread, and what no single one explains. */
static void write_shares(struct qg_text *text, const struct qg_reliability_result *r) {
    bool any = false;
    open_member(text, "variance_shares", '{');
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        if (r->has_share[i]) {
            number(text, qg_parameter_name((enum qg_parameter)i), r->share[i]);
            any = true;
        }
    if (any)
        number(text, "unexplained", r->unexplained);
    qg_json_close(text, '}');
}

static void write_spread(struct qg_text *text, const struct qg_reliability_result *r) {
    number(text, "mean_f_dte", r->mean_f_dte);
    number(text, "standard_deviation_f_dte", r->standard_deviation);
    number(text, "min_f_dte", r->min_f_dte);
    number(text, "max_f_dte", r->max_f_dte);
    open_member(text, "quantiles_f_dte", '{');
    for (int i = 0; i < QG_QUANTILES; i++) {
        char level[QG_NUMBER_ROOM];
        qg_number_print(level, qg_quantile_levels[i]);
        number(text, level, r->quantile[i]);
    }
    qg_json_close(text, '}');
    open_member(text, "histogram", '{');
    number(text, "from", r->min_f_dte);
    number(text, "to", r->max_f_dte);
    open_member(text, "counts", '[');
    for (int i = 0; i < QG_HISTOGRAM_BINS; i++)
        qg_json_integer(text, (int64_t)r->histogram[i]);
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

static void write_reliability(struct qg_text *text, const struct qg_study_result *result) {
    const struct qg_reliability_result *r = &result->reliability;
    qg_json_name(text, "reliability");
    if (r->samples == 0) {
        qg_json_null(text);
        return;
    }
    qg_json_open(text, '{');
    integer(text, "samples", r->samples);
    integer(text, "failures", r->failures);
    number(text, "probability_of_failure", r->probability_of_failure);
    open_member(text, "confidence_95", '[');
    qg_json_number(text, r->confidence_low);
    qg_json_number(text, r->confidence_high);
    qg_json_close(text, ']');
    write_spread(text, r);
    write_shares(text, r);
    qg_json_close(text, '}');
}

/* Null when the formulas have no value for this pair. */
static void write_rating(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result) {
    qg_json_name(text, "iso6336");
    if (result->is_rated)
        qg_iso6336_write(text, &result->iso6336, job->study.pair.nominal_torque, result->geometry.face_width);
    else
        qg_json_null(text);
}

static void write_timing(struct qg_text *text, const struct qg_study_result *result, int threads) {
    open_member(text, "timing", '{');
    number(text, "wall_s", result->timing.wall);
    number(text, "compliance_s", result->timing.compliance);
    number(text, "static_s", result->timing.statics);
    number(text, "dynamic_s", result->timing.dynamics);
    integer(text, "threads", (size_t)threads);
    qg_json_close(text, '}');
}

/* How large the finite-element models of both gears are. */
static void write_model_size(struct qg_text *text, const struct qg_model_size *size) {
    open_member(text, "model", '{');
    for (int i = QG_PINION; i <= QG_GEAR; i++) {
        open_member(text, gear_names[i], '{');
        integer(text, "degrees_of_freedom", size->degrees_of_freedom[i]);
        integer(text, "flank_nodes", size->flank_nodes[i]);
        qg_json_close(text, '}');
    }
    qg_json_close(text, '}');
}

/* Strings, each with the JSON pointer of what it is about in front. */
static void write_warnings(struct qg_text *text, const struct qg_notes *warnings) {
    open_member(text, "warnings", '[');
    for (size_t i = 0; i < warnings->count; i++) {
        const struct qg_note *note = &warnings->item[i];
        char pointer[QG_POINTER_ROOM], line[QG_POINTER_ROOM + sizeof note->text + 2];
        qg_document_pointer(note->where, pointer);
        snprintf(line, sizeof line, "%s%s%s", pointer, pointer[0] ? ": " : "", note->text);
        qg_json_string(text, line);
    }
    qg_json_close(text, ']');
}

void qg_result_write(struct qg_text *text, const struct qg_job *job, const struct qg_study_result *result,
                     int threads) {
    qg_json_open(text, '{');
    qg_json_name(text, "version");
    qg_json_string(text, PACKAGE_VERSION);
    qg_json_name(text, "job");
    qg_document_write(text, job);
    qg_json_name(text, "geometry");
    qg_geometry_write(text, &result->geometry);
    write_rating(text, job, result);
    qg_json_name(text, "design");
    write_design(text, job, result->design);
    qg_json_name(text, "reference");
    write_design(text, job, result->reference);
    write_improvement(text, result);
    write_search(text, job, result);
    write_verification(text, result);
    write_map(text, job, result);
    qg_macro_write(text, job, result);
    write_reliability(text, result);
    write_model_size(text, &result->size);
    write_timing(text, result, threads);
    write_warnings(text, &result->warnings);
    qg_json_close(text, '}');
}
