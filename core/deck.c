/* The contact model of a mounted pair; deck.h tells the idea. */
#include "core/deck.h"

#include <assert.h>
#include <math.h>

#include "core/profile.h"

const struct qg_mesh_density qg_density_deck = {
    .tooth_columns = 8,
    .fillet_rows = 3,
    .root_columns = 3,
    .foot_rows = 2,
    .body_rows = 4,
    .flank_elements_per_module = 24,
    .tip_share = 0.3,
    .column_growth = 1.25,
    .back_columns = 2,
    .back_growth = 0.6,
};

/* How far beyond the path of contact, in base pitches, pairs of teeth are still given a contact: load closes gaps there,
 * at full torque some 0.1 base pitches beyond. */
static const double beyond_path = 0.35;

/* Flanks overlap in the drawing by a twentieth of what the load closes at this usual stiffness: enough for contact to be
 * found at once, and fewest iterations of CalculiX by trial. */
static const double usual_stiffness = 14e3; /* N/mm per mm of width */

static const double penalty = 5e7; /* N/mm3: 1000 MPa press the surfaces 0.02 um into each other */

double qg_deck_node_angle(const struct qg_deck *deck, int gear, size_t node) {
    return deck->mesh[gear].node[node].angle + deck->angle[gear];
}

void qg_deck_node(const struct qg_deck *deck, int gear, size_t node, double xy[2]) {
    double radius = deck->mesh[gear].node[node].radius, angle = qg_deck_node_angle(deck, gear, node);
    xy[0] = deck->center[gear] + radius * cos(angle);
    xy[1] = radius * sin(angle);
}

/* ---- which teeth ------------------------------------------------------------------------------------------------ */

static bool may_touch(const struct qg_deck_plan *plan, int pair) {
    const struct qg_pair_geometry *g = plan->geometry;
    double xi = qg_path_position(g, plan->position, pair), more = beyond_path * g->base_pitch;
    return xi > fmax(0, g->path_start - more) && xi < fmin(g->line_length, g->path_end + more);
}

static void choose_pairs(struct qg_deck *deck, const struct qg_deck_plan *plan) {
    for (int k = -QG_PAIR_REACH; k <= QG_PAIR_REACH; k++)
        if (may_touch(plan, k))
            deck->contact[deck->contact_count++] =
                (struct qg_deck_contact){.pair = k, .slave = qg_tip_gear(plan->geometry, plan->position, k)};
    assert(deck->contact_count > 0); /* the contact ratio is at least 1 */
    int first = deck->contact[0].pair, last = deck->contact[deck->contact_count - 1].pair;
    for (size_t i = 0; i < deck->contact_count; i++) {
        deck->contact[i].tooth[QG_PINION] = deck->contact[i].pair - first;
        deck->contact[i].tooth[QG_GEAR] = last - deck->contact[i].pair;
    }
}

static enum qg_status mesh_gear(struct qg_deck *deck, const struct qg_deck_plan *plan, int gear,
                                struct qg_notes *notes) {
    int first = deck->contact[0].pair, last = deck->contact[deck->contact_count - 1].pair;
    struct qg_mesh_density coarse = qg_density_far(&qg_density_deck);
    const struct qg_gear_mesh_plan mesh = {.pair = plan->pair,
                                           .geometry = plan->geometry,
                                           .gear = gear,
                                           .relief = plan->relief,
                                           .fine = &qg_density_deck,
                                           .coarse = &coarse,
                                           .refinement = plan->refinement,
                                           .first_tooth = gear == QG_PINION ? first : -last,
                                           .fine_teeth = last - first + 1};
    return qg_gear_mesh_init(&deck->mesh[gear], &mesh, notes);
}

/* ---- seat ------------------------------------------------------------------------------------------------------- */

/* The turn of the mate, times its base radius, that brings its relieved flank to a point at `xy`; NAN where the point looks
 * past the flank. A relief of depth d turns the flank back by d / r_b at every radius, the normal being tangent to the base
 * circle. */
static double gap_at(const struct qg_deck *deck, const struct qg_deck_plan *plan, const struct qg_deck_contact *contact,
                     const double xy[2]) {
    int mate = 1 - contact->slave;
    const struct qg_gear_geometry *g = &plan->geometry->gears[mate];
    double x = xy[0] - deck->center[mate], y = xy[1], radius = hypot(x, y);
    if (radius < g->form_radius || radius > plan->pair->gears[mate].outside_radius)
        return NAN;
    int tooth = mate == QG_PINION ? contact->pair : -contact->pair;
    double center_line = deck->angle[mate] + 2 * M_PI / plan->pair->gears[mate].teeth * tooth;
    double depth = qg_relief_depth(plan->relief, plan->geometry, plan->pair, mate, radius);
    double flank = center_line + qg_half_tooth_angle(&plan->pair->rack, g, radius) - depth / g->base_radius;
    return g->base_radius * remainder(atan2(y, x) - flank, 2 * M_PI);
}

/* The smallest gap over all nodes of all slave flanks, with the gears where the bare involutes touch. */
static double first_touch(const struct qg_deck *deck, const struct qg_deck_plan *plan) {
    double least = INFINITY;
    for (size_t i = 0; i < deck->contact_count; i++) {
        const struct qg_deck_contact *contact = &deck->contact[i];
        const struct qg_gear_mesh *mesh = &deck->mesh[contact->slave];
        const int *flank = mesh->flank + (size_t)contact->tooth[contact->slave] * mesh->flank_count;
        for (size_t k = 0; k < mesh->flank_count; k++) {
            double xy[2];
            qg_deck_node(deck, contact->slave, (size_t)flank[k], xy);
            least = fmin(least, gap_at(deck, plan, contact, xy)); /* fmin passes over NAN */
        }
    }
    return least;
}

/* ---- putting it together ---------------------------------------------------------------------------------------- */

static void set_figures(struct qg_deck *deck, const struct qg_deck_plan *plan) {
    double e = plan->pair->material.youngs_modulus, nu = plan->pair->material.poisson_ratio;
    bool stress = plan->plane == QG_PLANE_STRESS;
    deck->youngs_modulus = stress ? e * (1 + 2 * nu) / ((1 + nu) * (1 + nu)) : e;
    deck->poisson_ratio = stress ? nu / (1 + nu) : nu;
    deck->penalty = penalty;
    deck->position = plan->position;
    deck->torque = plan->torque;
    deck->plane = plan->plane;
    deck->bore = plan->bore;
    deck->center[QG_GEAR] = plan->pair->center_distance;
    struct qg_mounted mounted;
    qg_mounted_at(plan->geometry, plan->pair, plan->position, &mounted);
    for (int g = 0; g < 2; g++) {
        deck->angle[g] = mounted.angle[g];
        deck->thickness[g] = plan->pair->gears[g].face_width;
        deck->base_radius[g] = plan->geometry->gears[g].base_radius;
    }
}

enum qg_status qg_deck_init(struct qg_deck *deck, const struct qg_deck_plan *plan, struct qg_notes *notes) {
    *deck = (struct qg_deck){0};
    set_figures(deck, plan);
    choose_pairs(deck, plan);
    enum qg_status status = QG_OK;
    for (int g = 0; g < 2 && status == QG_OK; g++)
        status = mesh_gear(deck, plan, g, notes);
    if (status != QG_OK) {
        qg_deck_finish(deck);
        return status;
    }
    deck->touch = first_touch(deck, plan);
    double load = plan->torque / deck->base_radius[QG_PINION] / plan->geometry->face_width;
    deck->seat = deck->touch + 0.05 * load / usual_stiffness;
    deck->angle[QG_PINION] += deck->seat / deck->base_radius[QG_PINION];
    return QG_OK;
}

void qg_deck_finish(struct qg_deck *deck) {
    for (int g = 0; g < 2; g++)
        qg_gear_mesh_finish(&deck->mesh[g]);
    *deck = (struct qg_deck){0};
}
