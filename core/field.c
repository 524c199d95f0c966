/* Displacement and stress of a loaded pair; field.h tells the idea.
 *
 * Torque ring. The pinion's bore is radially rigid and free to turn; the flanks' moment M is balanced by a uniform traction,
 * whose nodal forces are - M / r times each node's share of the bore. The turn is then taken out by holding one node of the
 * bore tangentially (its reaction is zero up to rounding), and measured from the mean of the bore afterwards.
 */
#include "core/field.h"

#include <assert.h>
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "core/profile.h"
#include "core/statics.h"

/* Teeth on either side of the reference pair that are always fine. */
enum { FINE_REACH = 2 };

/* ---- loads on nodes --------------------------------------------------------------------------------------------- */

/* A field at work on one gear. */
struct gear_work {
    const struct qg_field *field;
    const struct qg_stop *stop;
    struct qg_field_gear *gear;
    const struct qg_gear_geometry *geometry;
    enum qg_support support;
    int which;
    double *load; /* N, [2 node_count] radial and tangential */
    double *u;    /* mm, likewise */
    int *freedom; /* [2 node_count] row, or -1: held */
    size_t count; /* rows */
    cholmod_common common;
    cholmod_sparse *matrix;
};

/* The fine tooth (gear_mesh.h) that belongs to a pair of teeth. */
static int fine_tooth(const struct qg_gear_mesh *mesh, int gear, int pair) {
    return (gear == QG_PINION ? pair : -pair) - mesh->first_tooth;
}

/* Adds a force (N) in an absolute direction at a radius of the contact flank of a pair's tooth. */
static void add_force(struct gear_work *w, int pair, double radius, double force, double direction) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    double base = w->geometry->base_radius, arc = (radius * radius - base * base) / (2 * base);
    size_t edge = 0, last = (mesh->flank_count - 1) / 2 - 1;
    while (edge < last && mesh->flank_arc[2 * edge + 2] <= arc)
        edge++;
    double from = mesh->flank_arc[2 * edge], to = mesh->flank_arc[2 * edge + 2];
    double z = fmin(1, fmax(-1, 2 * (arc - from) / (to - from) - 1));
    const double shape[3] = {z * (z - 1) / 2, 1 - z * z, z * (z + 1) / 2};
    const int *node = mesh->flank + (size_t)fine_tooth(mesh, w->which, pair) * mesh->flank_count + 2 * edge;
    for (int k = 0; k < 3; k++) {
        double angle = direction - mesh->node[node[k]].angle;
        w->load[2 * node[k]] += force * shape[k] * cos(angle);
        w->load[2 * node[k] + 1] += force * shape[k] * sin(angle);
    }
}

/* What all points of one contact solution share. */
struct contact_view {
    const struct qg_model *model;
    const struct qg_contact_site *site;
    const double *load; /* N, [site->n] */
    double angle[2];    /* rad, as mounted, of the teeth of pair 0 */
    double position;
    const struct qg_stop *stop;
};

/* Absolute angle of the outward normal of a gear's bare flank at a radius. */
static double flank_normal(const struct contact_view *view, int gear, int pair, double radius) {
    const struct qg_gear_pair *p = qg_model_pair(view->model);
    const struct qg_gear_geometry *g = &qg_model_geometry(view->model)->gears[gear];
    double tooth = view->angle[gear] + (gear == QG_PINION ? 2 : -2) * M_PI / p->gears[gear].teeth * pair;
    return tooth + qg_half_tooth_angle(&p->rack, g, radius) + M_PI_2 - acos(g->base_radius / radius);
}

/* Every loaded point presses along the normal of the flank that it looks at: the mate of the one whose tip may engage. */
static void load_flanks(struct gear_work *w, const struct contact_view *view) {
    for (size_t i = 0; i < view->site->n; i++) {
        const struct qg_contact_point *p = &view->site->point[i];
        if (!(view->load[i] > 0))
            continue;
        int mate = 1 - qg_tip_gear(qg_model_geometry(view->model), view->position, p->pair);
        for (int k = 0; k < QG_GAP_SAMPLES; k++) {
            const struct qg_gap_sample *at = &p->sample[k];
            if (!(at->weight > 0))
                continue;
            double normal = flank_normal(view, mate, p->pair, at->radius[mate]);
            add_force(w, p->pair, at->radius[w->which], at->weight * view->load[i],
                      w->which == mate ? normal + M_PI : normal);
        }
    }
}

/* Resultant of the flank loads, and the traction of a torque ring that balances their moment. */
static void balance(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    for (size_t n = 0; n < mesh->node_count; n++) {
        double c = cos(mesh->node[n].angle), s = sin(mesh->node[n].angle);
        w->gear->force[0] += c * w->load[2 * n] - s * w->load[2 * n + 1];
        w->gear->force[1] += s * w->load[2 * n] + c * w->load[2 * n + 1];
        w->gear->contact_moment += mesh->node[n].radius * w->load[2 * n + 1];
    }
    if (w->support == QG_SUPPORT_TORQUE_RING)
        for (size_t k = 0; k < mesh->bore_count; k++)
            w->load[2 * mesh->bore[k] + 1] -=
                w->gear->contact_moment * mesh->bore_share[k] / mesh->node[mesh->bore[k]].radius;
}

/* ---- solving ---------------------------------------------------------------------------------------------------- */

static void number_unknowns(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    memset(w->freedom, 0, 2 * mesh->node_count * sizeof *w->freedom);
    for (size_t k = 0; k < mesh->bore_count; k++) {
        w->freedom[2 * mesh->bore[k]] = -1;
        if (w->support == QG_SUPPORT_FIXED || k == 0)
            w->freedom[2 * mesh->bore[k] + 1] = -1;
    }
    for (size_t k = 0; k < 2 * mesh->node_count; k++)
        if (w->freedom[k] >= 0)
            w->freedom[k] = (int)w->count++;
}

/* x <- K^-1 x. Neither CHOLMOD's ordering nor its numbers can be interrupted: stop is asked between them. */
static enum qg_status solve_system(struct gear_work *w, double *x) {
    cholmod_dense right = {.nrow = w->count,
                           .ncol = 1,
                           .nzmax = w->count,
                           .d = w->count,
                           .x = x,
                           .xtype = CHOLMOD_REAL,
                           .dtype = CHOLMOD_DOUBLE};
    cholmod_factor *factor = cholmod_analyze(w->matrix, &w->common);
    cholmod_dense *solution = NULL;
    const bool stopped = qg_is_stopped(w->stop);
    if (factor && !stopped && cholmod_factorize(w->matrix, factor, &w->common) && w->common.status == CHOLMOD_OK)
        solution = qg_factor_solve(CHOLMOD_A, factor, &right, &w->common);
    if (solution)
        memcpy(x, solution->x, w->count * sizeof *x);
    enum qg_status status = stopped ? QG_CANCELLED : solution ? QG_OK : QG_NO_CONVERGENCE;
    cholmod_free_dense(&solution, &w->common);
    cholmod_free_factor(&factor, &w->common);
    return status;
}

/* Fills u from the loads. */
static enum qg_status solve(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    const struct qg_sector_mesh view = qg_gear_mesh_view(mesh);
    number_unknowns(w);
    w->matrix = qg_assemble(&view, &w->gear->plate, w->freedom, w->count, &w->common);
    double *x = malloc(w->count * sizeof *x);
    enum qg_status status = w->matrix && x ? QG_OK : QG_OUT_OF_MEMORY;
    if (status == QG_OK && qg_is_stopped(w->stop))
        status = QG_CANCELLED;
    if (status == QG_OK) {
        for (size_t k = 0; k < 2 * mesh->node_count; k++)
            if (w->freedom[k] >= 0)
                x[w->freedom[k]] = w->load[k];
        status = solve_system(w, x);
        for (size_t k = 0; k < 2 * mesh->node_count && status == QG_OK; k++)
            w->u[k] = w->freedom[k] >= 0 ? x[w->freedom[k]] : 0;
    }
    cholmod_free_sparse(&w->matrix, &w->common);
    free(x);
    return status;
}

/* Turns the pinion as a whole (rad). */
static void turn(struct gear_work *w, double by) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    for (size_t n = 0; n < mesh->node_count; n++)
        w->u[2 * n + 1] += by * mesh->node[n].radius;
}

/* Measures displacements from the mean of the bore. */
static void take_off_mean(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    double mean = 0;
    for (size_t k = 0; k < mesh->bore_count; k++)
        mean += mesh->bore_share[k] * w->u[2 * mesh->bore[k] + 1];
    turn(w, -mean / mesh->node[mesh->bore[0]].radius);
}

/* ---- what the solution says ------------------------------------------------------------------------------------- */

static void gather(const struct gear_work *w, const int element[QG_ELEMENT_NODES], struct qg_polar *node, double *u) {
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        node[n] = w->gear->mesh.node[element[n]];
        u[2 * n] = w->u[2 * element[n]];
        u[2 * n + 1] = w->u[2 * element[n] + 1];
    }
}

/* Forces on the bore: what the elements pull there less what was applied, and the moment with the traction in it. */
static void find_reactions(struct gear_work *w, const double *pull) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    for (size_t k = 0; k < mesh->bore_count; k++) {
        int n = mesh->bore[k];
        double c = cos(mesh->node[n].angle), s = sin(mesh->node[n].angle);
        double radial = pull[2 * n], tangential = pull[2 * n + 1];
        w->gear->reaction[0] += c * radial - s * tangential;
        w->gear->reaction[1] += s * radial + c * tangential;
        w->gear->reaction_moment += mesh->node[n].radius * tangential;
    }
}

/* K u element by element, for the reactions. */
static bool sum_forces(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    double *pull = calloc(2 * mesh->node_count, sizeof *pull);
    if (!pull)
        return false;
    for (size_t e = 0; e < mesh->element_count; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        double u[QG_ELEMENT_FREEDOMS], k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS];
        gather(w, mesh->element[e], node, u);
        qg_element_stiffness((const struct qg_polar *)node, &w->gear->plate, k);
        for (int i = 0; i < QG_ELEMENT_FREEDOMS; i++)
            for (int j = 0; j < QG_ELEMENT_FREEDOMS; j++)
                pull[2 * mesh->element[e][i / 2] + i % 2] += k[i][j] * u[j];
    }
    find_reactions(w, pull);
    free(pull);
    return true;
}

/* Stresses at the nodes, the mean over their elements. */
static bool find_stresses(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    struct qg_plane_stress *sum = w->gear->stress;
    int *times = calloc(mesh->node_count, sizeof *times);
    if (!times)
        return false;
    for (size_t e = 0; e < mesh->element_count; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        struct qg_plane_stress at[QG_ELEMENT_NODES];
        double u[QG_ELEMENT_FREEDOMS];
        gather(w, mesh->element[e], node, u);
        qg_element_stress(node, &w->gear->plate, u, at);
        for (int n = 0; n < QG_ELEMENT_NODES; n++) {
            int id = mesh->element[e][n];
            times[id]++;
            sum[id].xx += at[n].xx;
            sum[id].yy += at[n].yy;
            sum[id].xy += at[n].xy;
        }
    }
    for (size_t n = 0; n < mesh->node_count; n++) {
        sum[n].xx /= times[n];
        sum[n].yy /= times[n];
        sum[n].xy /= times[n];
    }
    free(times);
    return true;
}

static void to_cartesian(struct gear_work *w) {
    const struct qg_gear_mesh *mesh = &w->gear->mesh;
    for (size_t n = 0; n < mesh->node_count; n++) {
        double c = cos(mesh->node[n].angle), s = sin(mesh->node[n].angle);
        w->gear->displacement[2 * n] = c * w->u[2 * n] - s * w->u[2 * n + 1];
        w->gear->displacement[2 * n + 1] = s * w->u[2 * n] + c * w->u[2 * n + 1];
    }
}

/* ---- one gear --------------------------------------------------------------------------------------------------- */

/* Solves one gear under the contact's loads; the displacements stay in w->u. */
static enum qg_status work_out(struct gear_work *w, const struct contact_view *view) {
    size_t n = w->gear->mesh.node_count;
    w->load = calloc(2 * n, sizeof *w->load);
    w->u = calloc(2 * n, sizeof *w->u);
    w->freedom = malloc(2 * n * sizeof *w->freedom);
    w->gear->displacement = malloc(2 * n * sizeof *w->gear->displacement);
    w->gear->stress = calloc(n, sizeof *w->gear->stress);
    if (!w->load || !w->u || !w->freedom || !w->gear->displacement || !w->gear->stress)
        return QG_OUT_OF_MEMORY;
    load_flanks(w, view);
    balance(w);
    enum qg_status status = solve(w);
    if (status == QG_OK && qg_is_stopped(w->stop))
        status = QG_CANCELLED;
    if (status != QG_OK)
        return status;
    if (w->support == QG_SUPPORT_TORQUE_RING)
        take_off_mean(w);
    for (size_t k = 0; k < 2 * n; k++)
        w->gear->work += w->load[k] * w->u[k]; /* of the traction: zero, its displacement is */
    return sum_forces(w) && find_stresses(w) ? QG_OK : QG_OUT_OF_MEMORY;
}

static void work_init(struct gear_work *w, struct qg_field *field, const struct contact_view *view, int gear) {
    const struct qg_analysis *analysis = qg_model_analysis(view->model);
    bool ring = gear == QG_PINION && analysis->bore == QG_BORE_TORQUE_RING;
    *w = (struct gear_work){.field = field,
                            .stop = view->stop,
                            .gear = &field->gears[gear],
                            .geometry = &qg_model_geometry(view->model)->gears[gear],
                            .support = ring ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED,
                            .which = gear};
    omp_set_max_active_levels(0); /* parallelism is the executor's; as in compliance.c */
    cholmod_start(&w->common);
    w->common.print = 0;
}

static void work_finish(struct gear_work *w) {
    cholmod_finish(&w->common);
    free(w->load);
    free(w->u);
    free(w->freedom);
}

/* ---- the pair --------------------------------------------------------------------------------------------------- */

/* The pairs of teeth that are fine: the reference pair's neighbours and all that carry load. */
static void fine_pairs(const struct qg_field *field, const struct qg_gear_pair *pair, int range[2]) {
    int first = QG_PAIR_REACH, last = -QG_PAIR_REACH;
    for (size_t i = 0; i < field->load_count; i++) {
        first = field->load[i].pair < first ? field->load[i].pair : first;
        last = field->load[i].pair > last ? field->load[i].pair : last;
    }
    range[0] = first < -FINE_REACH ? first : -FINE_REACH;
    range[1] = last > FINE_REACH ? last : FINE_REACH;
    if (range[1] - range[0] >= pair->gears[QG_PINION].teeth || range[1] - range[0] >= pair->gears[QG_GEAR].teeth) {
        range[0] = first;
        range[1] = last;
    }
}

static enum qg_status mesh_gear(struct qg_field *field, const struct qg_model *model, int gear, const double angle[2]) {
    const struct qg_gear_pair *pair = qg_model_pair(model);
    const struct qg_analysis *analysis = qg_model_analysis(model);
    struct qg_mesh_density far = qg_density_far(&qg_density_analysis);
    struct qg_field_gear *g = &field->gears[gear];
    int range[2];
    fine_pairs(field, pair, range);
    const struct qg_gear_mesh_plan plan = {.pair = pair,
                                           .geometry = qg_model_geometry(model),
                                           .gear = gear,
                                           .fine = &qg_density_analysis,
                                           .coarse = &far,
                                           .refinement = analysis->mesh_refinement,
                                           .first_tooth = gear == QG_PINION ? range[0] : -range[1],
                                           .fine_teeth = range[1] - range[0] + 1};
    g->center = gear == QG_GEAR ? pair->center_distance : 0;
    g->plate = (struct qg_plate){pair->material.youngs_modulus, pair->material.poisson_ratio,
                                 pair->gears[gear].face_width, analysis->plane == QG_PLANE_STRAIN};
    enum qg_status status = qg_gear_mesh_init(&g->mesh, &plan, NULL);
    for (size_t n = 0; n < g->mesh.node_count; n++)
        g->mesh.node[n].angle += angle[gear];
    return status;
}

/* The loaded points, for the reader of the field. */
static bool list_loads(struct qg_field *field, const struct contact_view *view) {
    const struct qg_statics *statics = qg_model_statics(view->model);
    field->load = malloc(view->site->n * sizeof *field->load);
    for (size_t i = 0; i < view->site->n && field->load; i++) {
        const struct qg_contact_point *p = &view->site->point[i];
        if (!(view->load[i] > 0))
            continue;
        field->load[field->load_count++] =
            (struct qg_field_load){p->pair,
                                   view->load[i],
                                   qg_contact_pressure(statics, view->site, view->load, i),
                                   {p->at.radius[QG_PINION], p->at.radius[QG_GEAR]}};
    }
    return field->load != NULL;
}

/* Both gears under the loads of a solved contact. `closed` is sum lambda g (N mm) of its points. */
static enum qg_status solve_gears(struct qg_field *field, const struct contact_view *view, double closed) {
    const struct qg_pair_geometry *geometry = qg_model_geometry(view->model);
    double base = geometry->gears[QG_PINION].base_radius;
    struct gear_work work[2];
    enum qg_status status = QG_OK;
    for (int g = 0; g < 2; g++)
        work_init(&work[g], field, view, g);
    for (int g = 0; g < 2 && status == QG_OK; g++) {
        status = qg_is_stopped(view->stop) ? QG_CANCELLED : mesh_gear(field, view->model, g, view->angle);
        if (status == QG_OK)
            status = work_out(&work[g], view);
    }
    if (status == QG_OK) {
        double yielded = field->gears[QG_PINION].work + field->gears[QG_GEAR].work;
        field->approach_energy = (closed + yielded) / (field->torque / base);
        turn(&work[QG_PINION], field->approach_energy / base);
        for (int g = 0; g < 2; g++)
            to_cartesian(&work[g]);
    }
    for (int g = 0; g < 2; g++)
        work_finish(&work[g]);
    return status;
}

enum qg_status qg_field_init(struct qg_field *field, const struct qg_model *model, const struct qg_field_state *state) {
    const struct qg_statics *statics = qg_model_statics(model);
    const struct qg_pair_geometry *geometry = qg_model_geometry(model);
    struct qg_statics_workspace workspace;
    struct qg_mounted mounted;
    const size_t i = state->site;
    assert(i < statics->positions && state->torque > 0);
    *field = (struct qg_field){.position = qg_statics_position(statics, i), .torque = state->torque};
    qg_mounted_at(geometry, qg_model_pair(model), field->position, &mounted);
    enum qg_status status = qg_statics_workspace_init(&workspace, statics);
    if (status != QG_OK)
        return status;
    status = qg_statics_contact(statics, &workspace, state->relief, i,
                                state->torque / geometry->gears[QG_PINION].base_radius);
    const struct contact_view view = {.model = model,
                                      .site = &statics->site[i],
                                      .load = workspace.contact.load,
                                      .angle = {mounted.angle[0], mounted.angle[1]},
                                      .position = field->position,
                                      .stop = &state->stop};
    if (status == QG_OK && !list_loads(field, &view))
        status = QG_OUT_OF_MEMORY;
    if (status == QG_OK) {
        double closed = 0;
        for (size_t k = 0; k < view.site->n; k++)
            closed += workspace.gap[k] * view.load[k];
        field->approach = workspace.contact.approach;
        status = solve_gears(field, &view, closed);
    }
    qg_statics_workspace_finish(&workspace);
    return status;
}

enum qg_status qg_field_compute(struct qg_field *field, const struct qg_field_plan *plan, const struct qg_means *means,
                                struct qg_notes *notes) {
    struct qg_analysis analysis = *plan->analysis;
    struct qg_model *model;
    *field = (struct qg_field){0};
    analysis.case_count = 1;
    analysis.torque_fraction[0] = plan->torque_fraction;
    enum qg_status status = qg_model_create_at(plan->pair, &analysis, plan->position, means, notes, &model);
    const struct qg_field_state state = {
        .relief = plan->relief, .torque = plan->torque_fraction * plan->pair->nominal_torque, .stop = means->stop};
    if (status == QG_OK)
        status = qg_field_init(field, model, &state);
    qg_model_destroy(model);
    return status;
}

void qg_field_finish(struct qg_field *field) {
    for (int g = 0; g < 2; g++) {
        qg_gear_mesh_finish(&field->gears[g].mesh);
        free(field->gears[g].displacement);
        free(field->gears[g].stress);
    }
    free(field->load);
    *field = (struct qg_field){0};
}

void qg_field_node(const struct qg_field *field, int gear, size_t node, double xy[2]) {
    const struct qg_field_gear *g = &field->gears[gear];
    xy[0] = g->center + g->mesh.node[node].radius * cos(g->mesh.node[node].angle);
    xy[1] = g->mesh.node[node].radius * sin(g->mesh.node[node].angle);
}
