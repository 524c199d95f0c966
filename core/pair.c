/* Geometry of two gears in mesh, and the reasons why a pair cannot run. */
#include "core/pair.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static const char *const gear_names[2] = {"pinion", "gear"};

/* Rack, material and the like: figures that make no sense by themselves. */
static void check_common(const struct qg_gear_pair *pair, struct qg_notes *notes) {
    const struct {
        const char *where;
        double value, above, below; /* allowed: above < value < below */
    } figures[] = {
        {"module", pair->rack.module, 0, INFINITY},
        {"pressure_angle", pair->rack.pressure_angle, 0, M_PI_4},
        {"center_distance", pair->center_distance, 0, INFINITY},
        {"material.youngs_modulus", pair->material.youngs_modulus, 0, INFINITY},
        {"material.poisson_ratio", pair->material.poisson_ratio, -1e-300, 0.5},
        {"material.density", pair->material.density, 0, INFINITY},
        {"damping_ratio", pair->damping_ratio, 0, 1},
        {"nominal_torque", pair->nominal_torque, 0, INFINITY},
    };
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        if (!(figures[i].value > figures[i].above && figures[i].value < figures[i].below))
            qg_notes_add(notes, figures[i].where, "found %g, allowed: %s, less than %g", figures[i].value,
                         figures[i].above < 0 ? "0 or more" : "more than 0", figures[i].below);
}

/* The path of contact must lie between the form points: else a tip digs into the mate's root curve. */
static void check_interference(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g,
                               struct qg_notes *notes) {
    double xi_at_mates_tip[2] = {g->path_start, g->line_length - g->path_end};
    for (int i = 0; i < 2; i++) {
        const struct qg_gear_geometry *gear = &g->gears[i];
        double needed = sqrt(fmax(0, gear->form_radius * gear->form_radius - gear->base_radius * gear->base_radius));
        double excess = needed - xi_at_mates_tip[i];
        if (excess <= 0)
            continue;
        const char *mate = gear_names[1 - i];
        char where[64];
        snprintf(where, sizeof where, "%s.outside_radius", mate);
        qg_notes_add(notes, where,
                     "interference: the tip of the %s reaches %.4f mm (along the line of action) below the %s's form "
                     "radius %.4f mm; lower the %s's outside radius %.4f mm or change the shifts",
                     mate, excess, gear_names[i], gear->form_radius, mate, pair->gears[1 - i].outside_radius);
    }
}

/* What can be said even of gears that cannot be cut: it does not depend on their roots' shape. */
static void check_mesh(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, struct qg_notes *notes) {
    if (g->backlash < 0)
        qg_notes_add(notes, "center_distance",
                     "negative backlash: the teeth overlap by %.4f mm along the line of action; raise the centre "
                     "distance %.4f mm or lower the profile shifts",
                     -g->backlash, pair->center_distance);
    else if (g->backlash == 0)
        qg_notes_add(notes, "center_distance", "no backlash: the dynamics measure lengths in it; allowed: more than 0");
    for (int i = 0; i < 2; i++)
        if (g->tip_clearance[i] <= 0) {
            char where[64];
            snprintf(where, sizeof where, "%s.outside_radius", gear_names[i]);
            qg_notes_add(notes, where, "the tip of the %s reaches %.4f mm into the root of its mate", gear_names[i],
                         -g->tip_clearance[i]);
        }
    if (g->contact_ratio < 1)
        qg_notes_add(
            notes, "center_distance",
            "contact ratio %.4f: the teeth lose contact before the next ones meet; allowed: 1 or more; lower the "
            "centre distance %.4f mm or raise the outside radii",
            g->contact_ratio, pair->center_distance);
    else if (g->contact_ratio > 5)
        qg_notes_add(notes, "center_distance",
                     "contact ratio %.4f, allowed: at most 5 (seven pairs of teeth are looked at)", g->contact_ratio);
}

/* Backlash along the line of action: what the two teeth leave of the working pitch, turned into the normal direction. */
static double normal_backlash(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g) {
    double left = 0;
    for (int i = 0; i < 2; i++) {
        double working_radius = g->gears[i].base_radius / cos(g->working_pressure_angle);
        left += 2 * working_radius * qg_half_tooth_angle(&pair->rack, &g->gears[i], working_radius);
    }
    double working_pitch = g->base_pitch / cos(g->working_pressure_angle);
    return (working_pitch - left) * cos(g->working_pressure_angle);
}

enum qg_status qg_pair_derive(const struct qg_gear_pair *pair, struct qg_pair_geometry *out, struct qg_notes *notes) {
    struct qg_notes mine = {0};
    if (!notes)
        notes = &mine;
    size_t before = notes->count + notes->lost;
    *out = (struct qg_pair_geometry){0};
    check_common(pair, notes);
    if (notes->count + notes->lost > before)
        return QG_IMPOSSIBLE_GEAR;
    bool gears_ok = true;
    for (int i = 0; i < 2; i++)
        gears_ok &= qg_gear_derive(&pair->rack, &pair->gears[i], pair->material.density,
                                   i == QG_PINION ? "pinion." : "gear.", &out->gears[i], notes) == QG_OK;
    for (int i = 0; i < 2; i++) /* also false when a figure made no sense and nothing was derived */
        if (!(out->gears[i].base_radius > 0 && pair->gears[i].outside_radius > out->gears[i].base_radius))
            return QG_IMPOSSIBLE_GEAR;

    double rb1 = out->gears[QG_PINION].base_radius, rb2 = out->gears[QG_GEAR].base_radius;
    double ra1 = pair->gears[QG_PINION].outside_radius, ra2 = pair->gears[QG_GEAR].outside_radius;
    double cosine = (rb1 + rb2) / pair->center_distance;
    if (cosine >= 1) {
        qg_notes_add(notes, "center_distance", "found %.4f mm, allowed: more than %.4f mm, the sum of the base radii",
                     pair->center_distance, rb1 + rb2);
        return QG_IMPOSSIBLE_GEAR;
    }
    out->working_pressure_angle = acos(cosine);
    out->base_pitch = out->gears[QG_PINION].base_pitch;
    out->line_length = pair->center_distance * sin(out->working_pressure_angle);
    out->path_start = out->line_length - sqrt(ra2 * ra2 - rb2 * rb2);
    out->path_end = sqrt(ra1 * ra1 - rb1 * rb1);
    out->contact_ratio = (out->path_end - out->path_start) / out->base_pitch;
    out->backlash = normal_backlash(pair, out);
    double i1 = out->gears[QG_PINION].moment_of_inertia, i2 = out->gears[QG_GEAR].moment_of_inertia;
    out->equivalent_mass = i1 * i2 / (i1 * rb2 * rb2 + i2 * rb1 * rb1);
    out->face_width = fmin(pair->gears[0].face_width, pair->gears[1].face_width);
    for (int i = 0; i < 2; i++)
        out->tip_clearance[i] = pair->center_distance - pair->gears[i].outside_radius - pair->gears[1 - i].root_radius;
    check_mesh(pair, out, notes);
    if (gears_ok)
        check_interference(pair, out, notes);
    return notes->count + notes->lost == before ? QG_OK : QG_IMPOSSIBLE_GEAR;
}

double qg_path_position(const struct qg_pair_geometry *geometry, double position, int pair) {
    double middle = (geometry->path_start + geometry->path_end) / 2;
    return middle + (position - 0.5 + pair) * geometry->base_pitch;
}
