/* Checking a study before it is run: everything that the gear pair forbids, with the figures (study.h, qg_study_check).
 */
#include <stdio.h>

#include "core/study.h"

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

/* What the objectives need beside themselves. */
static void check_objectives(const struct qg_study *study, struct qg_notes *errors, struct qg_notes *warnings) {
    const char *place = study->objectives.count > 0 ? "objectives" : "objective";
    const struct qg_reliability *r = &study->reliability;
    bool percentile = qg_study_asks(study, QG_OBJECTIVE_F_DTE_PERCENTILE);
    if (study->objectives.count > 0 && study->optimizer.method == QG_SEARCH_RANDOM_SIMPLEX)
        qg_notes_add(
            errors, "optimizer.method",
            "found random_simplex with %zu objectives, allowed: multistart_simplex, which searches for a front",
            study->objectives.count);
    if (percentile && study->kind != QG_STUDY_OPTIMIZE)
        qg_notes_add(errors, place,
                     "found f_dte_percentile, allowed in a map or among macro-geometries: f_dte or f_pps");
    else if (percentile && r->samples == 0)
        qg_notes_add(
            errors, place,
            "found f_dte_percentile without manufacturing errors, allowed together with reliability, which says "
            "how large they are");
    else if (percentile && r->radius_range == 0 && r->amplitude_range == 0)
        qg_notes_add(warnings, "reliability",
                     "both ranges are 0: f_dte_percentile is then f_dte, at many times the cost");
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
    if (study->kind == QG_STUDY_OPTIMIZE || study->kind == QG_STUDY_MAP || study->kind == QG_STUDY_MACRO)
        check_objectives(study, errors, warnings);
    if (qg_pair_derive(&study->pair, geometry, errors) == QG_OK) {
        qg_relief_check(&study->relief, &study->pair, geometry, errors, warnings);
        if (study->kind == QG_STUDY_OPTIMIZE)
            check_bounds(study, geometry, errors);
        if (study->kind == QG_STUDY_MAP)
            check_grid(study, geometry, errors);
        if (study->kind == QG_STUDY_MACRO)
            qg_macro_check(&study->macro, &study->pair, geometry, errors);
    }
    return errors->count + errors->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}
