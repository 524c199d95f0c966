/* Tip and root reliefs. */
#include "core/relief.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

bool qg_parameter_is_radius(enum qg_parameter parameter) {
    return parameter % 2 == 0;
}

struct qg_ramp *qg_relief_ramp_of(struct qg_relief *relief, enum qg_parameter parameter) {
    assert((unsigned)parameter < QG_PARAMETER_COUNT);
    int gear = parameter < QG_GEAR_TIP_START_RADIUS ? QG_PINION : QG_GEAR;
    bool tip = parameter % 4 < 2;
    return tip ? &relief->gears[gear].tip : &relief->gears[gear].root;
}

double *qg_relief_parameter(struct qg_relief *relief, enum qg_parameter parameter) {
    struct qg_ramp *ramp = qg_relief_ramp_of(relief, parameter);
    return qg_parameter_is_radius(parameter) ? &ramp->radius : &ramp->amplitude;
}

/* The abscissa over which a ramp is straight: the radius itself, or the roll angle up to its factor 1/r_b. */
static double abscissa(enum qg_relief_ramp ramp, double base_radius, double radius) {
    if (ramp == QG_RAMP_RADIUS)
        return radius;
    return sqrt(fmax(0, radius * radius - base_radius * base_radius));
}

/* What one ramp removes at `at`: 0 up to `from`, the amplitude at `to`; `to` may lie on either side. A ramp without length
 * removes nothing: else rounding would decide whether the corner itself, a single point, lies within it. */
static double ramp_depth(enum qg_relief_shape shape, double amplitude, double at, const double from_to[2]) {
    double from = from_to[0], to = from_to[1];
    double along = to >= from ? at - from : from - at;
    double length = fabs(to - from);
    if (along <= 0 || length == 0)
        return 0;
    double share = along >= length ? 1 : along / length;
    return amplitude * (shape == QG_SHAPE_PARABOLIC ? share * share : share);
}

double qg_relief_depth(const struct qg_relief *relief, const struct qg_pair_geometry *geometry,
                       const struct qg_gear_pair *pair, int gear, double radius) {
    const struct qg_ramp *tip = &relief->gears[gear].tip, *root = &relief->gears[gear].root;
    const struct qg_gear_geometry *g = &geometry->gears[gear];
    double at = abscissa(relief->ramp, g->base_radius, radius), depth = 0;
    if (tip->present) {
        double ends[2] = {abscissa(relief->ramp, g->base_radius, tip->radius),
                          abscissa(relief->ramp, g->base_radius, pair->gears[gear].outside_radius)};
        depth += ramp_depth(relief->shape, tip->amplitude, at, ends);
    }
    if (root->present && root->radius > g->form_radius) {
        double ends[2] = {abscissa(relief->ramp, g->base_radius, root->radius),
                          abscissa(relief->ramp, g->base_radius, g->form_radius)};
        depth += ramp_depth(relief->shape, root->amplitude, at, ends);
    }
    return depth;
}

double qg_relief_deepest(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, int gear) {
    return fmin(0.04 * pair->rack.module, geometry->gears[gear].tip_thickness / 2);
}

/* One ramp against the tooth: radius within [lowest, outside], amplitude within [0, most]. */
static void check_ramp(const struct qg_ramp *ramp, const char *place, const double limits[3], struct qg_notes *errors) {
    char where[64];
    double lowest = limits[0], outside = limits[1], most = limits[2];
    if (!(ramp->radius >= lowest && ramp->radius <= outside)) {
        snprintf(where, sizeof where, "%s_radius", place);
        qg_notes_add(errors, where, "found %.4f mm, allowed: %.4f to %.4f mm", ramp->radius, lowest, outside);
    }
    if (!(ramp->amplitude >= 0 && ramp->amplitude <= most)) {
        const char *dot = strrchr(place, '.');
        snprintf(where, sizeof where, "%.*s.amplitude", (int)(dot - place), place);
        qg_notes_add(errors, where, "found %.4f mm, allowed: 0 to %.4f mm", ramp->amplitude, most);
    }
}

enum qg_status qg_relief_check(const struct qg_relief *relief, const struct qg_gear_pair *pair,
                               const struct qg_pair_geometry *geometry, struct qg_notes *errors,
                               struct qg_notes *warnings) {
    static const char *const names[2] = {"pinion", "gear"};
    struct qg_notes mine = {0};
    if (!errors)
        errors = &mine;
    size_t before = errors->count + errors->lost;
    for (int i = 0; i < 2; i++) {
        const struct qg_gear_geometry *g = &geometry->gears[i];
        const struct qg_ramp *tip = &relief->gears[i].tip, *root = &relief->gears[i].root;
        double outside = pair->gears[i].outside_radius, most = qg_relief_deepest(pair, geometry, i);
        char place[64];
        if (tip->present) {
            snprintf(place, sizeof place, "%s.tip.start", names[i]);
            check_ramp(tip, place, (const double[]){g->form_radius, outside, most}, errors);
        }
        if (root->present) {
            snprintf(place, sizeof place, "%s.root.end", names[i]);
            check_ramp(root, place, (const double[]){pair->gears[i].root_radius, outside, most}, errors);
            if (root->radius <= g->form_radius) {
                snprintf(place, sizeof place, "%s.root.end_radius", names[i]);
                qg_notes_add(warnings, place,
                             "the root relief ends at %.4f mm, below the form radius %.4f mm: it removes nothing",
                             root->radius, g->form_radius);
            }
        }
    }
    return errors->count + errors->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}
