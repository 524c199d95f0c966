/* Whole gears out of sectors; gear_mesh.h tells the idea. */
#include "core/gear_mesh.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct qg_mesh_density qg_density_far(const struct qg_mesh_density *fine) {
    return (struct qg_mesh_density){.tooth_columns = 2,
                                    .fillet_rows = 2,
                                    .root_columns = 1,
                                    .foot_rows = fine->foot_rows,
                                    .body_rows = fine->body_rows,
                                    .flank_elements_per_module = 1.5,
                                    .tip_share = 1,
                                    .column_growth = 1};
}

/* ---- relief ----------------------------------------------------------------------------------------------------- */

/* Moves one node of the tooth; lowest is the radius at which the relief has faded out. */
static void relieve_node(const struct qg_gear_mesh_plan *plan, double lowest, struct qg_polar *node) {
    const struct qg_gear_geometry *g = &plan->geometry->gears[plan->gear];
    double depth = qg_relief_depth(plan->relief, plan->geometry, plan->pair, plan->gear, node->radius);
    double on_flank = fmax(node->radius, g->base_radius), half = qg_half_tooth_angle(&plan->pair->rack, g, on_flank);
    double fade = fmin(1, fmax(0, (node->radius - lowest) / (g->form_radius - lowest)));
    double across = fmin(1, fmax(0, (half + node->angle) / (2 * half))); /* 1 on the contact flank, 0 on the other */
    double normal = node->angle + M_PI_2 - acos(g->base_radius / on_flank);
    double move = -depth * fade * across;
    double x = node->radius * cos(node->angle) + move * cos(normal);
    double y = node->radius * sin(node->angle) + move * sin(normal);
    *node = (struct qg_polar){hypot(x, y), atan2(y, x)};
}

/* Puts the relief into a sector: all nodes of the tooth block, each once. */
static bool relieve_sector(const struct qg_gear_mesh_plan *plan, struct qg_sector_mesh *sector) {
    bool *done = calloc(sector->node_count, sizeof *done);
    if (!done)
        return false;
    size_t tooth = (size_t)sector->block[QG_BLOCK_TOOTH].columns * (size_t)sector->block[QG_BLOCK_TOOTH].rows;
    double lowest = sector->node[sector->element[0][0]].radius; /* where the flank side of the tooth begins */
    for (size_t e = 0; e < tooth; e++)
        for (int n = 0; n < QG_ELEMENT_NODES; n++) {
            int id = sector->element[e][n];
            if (!done[id])
                relieve_node(plan, lowest, &sector->node[id]);
            done[id] = true;
        }
    free(done);
    return true;
}

static enum qg_status make_sector(const struct qg_gear_mesh_plan *plan, const struct qg_mesh_density *density,
                                  struct qg_sector_mesh *sector, struct qg_notes *notes) {
    const struct qg_gear *gear = &plan->pair->gears[plan->gear];
    enum qg_status status = qg_sector_mesh_init_with(
        sector, &plan->pair->rack, gear, &plan->geometry->gears[plan->gear], density, plan->refinement, notes);
    if (status == QG_OK && plan->relief && !relieve_sector(plan, sector))
        status = QG_OUT_OF_MEMORY;
    return status;
}

/* ---- joining ---------------------------------------------------------------------------------------------------- */

/* A gear while its sectors are put in, counter-clockwise from the first fine tooth. */
struct joiner {
    struct qg_gear_mesh *mesh;
    int teeth, at;       /* sectors of the gear, put in already */
    int *id;             /* [nodes of the sector being put in] */
    int *first, *before; /* [side_count] nodes on the minus side of the first, on the plus side of the last sector */
    size_t bore_room;
};

static void number_nodes(struct joiner *j, const struct qg_sector_mesh *sector, double turn) {
    for (size_t n = 0; n < sector->node_count; n++)
        j->id[n] = -1;
    for (size_t k = 0; k < sector->side_count; k++) {
        if (j->at > 0)
            j->id[sector->side[1][k]] = j->before[k];
        if (j->at + 1 == j->teeth)
            j->id[sector->side[0][k]] = j->first[k];
    }
    for (size_t n = 0; n < sector->node_count; n++)
        if (j->id[n] < 0) {
            j->mesh->node[j->mesh->node_count] =
                (struct qg_polar){sector->node[n].radius, sector->node[n].angle + turn};
            j->id[n] = (int)j->mesh->node_count++;
        }
    for (size_t k = 0; k < sector->side_count; k++) {
        j->before[k] = j->id[sector->side[0][k]];
        if (j->at == 0)
            j->first[k] = j->id[sector->side[1][k]];
    }
}

/* The sector's part of the bore goes in front of what is there: the list runs clockwise. */
static void put_bore(struct joiner *j, const struct qg_sector_mesh *sector) {
    size_t n = sector->bore_count - 1;
    struct qg_gear_mesh *mesh = j->mesh;
    assert(mesh->bore_count + n <= j->bore_room);
    int *to = mesh->bore + j->bore_room - mesh->bore_count - n;
    for (size_t k = 0; k < n; k++)
        to[k] = j->id[sector->bore[k]];
    mesh->bore_count += n;
}

static void put_sector(struct joiner *j, const struct qg_sector_mesh *sector) {
    struct qg_gear_mesh *mesh = j->mesh;
    number_nodes(j, sector, 2 * M_PI / j->teeth * (mesh->first_tooth + j->at));
    for (size_t e = 0; e < sector->element_count; e++, mesh->element_count++)
        for (int n = 0; n < QG_ELEMENT_NODES; n++)
            mesh->element[mesh->element_count][n] = j->id[sector->element[e][n]];
    if (j->at < mesh->fine_teeth)
        for (size_t k = 0; k < mesh->flank_count; k++)
            mesh->flank[(size_t)j->at * mesh->flank_count + k] = j->id[sector->flank[k]];
    put_bore(j, sector);
    j->at++;
}

/* Quadratic edges: a sixth, four sixths, a sixth of the edge each. */
static void share_bore(struct qg_gear_mesh *mesh) {
    size_t n = mesh->bore_count;
    for (size_t k = 0; k < n; k += 2) {
        double from = mesh->node[mesh->bore[k]].angle, to = mesh->node[mesh->bore[(k + 2) % n]].angle;
        double length = remainder(from - to, 2 * M_PI) / (2 * M_PI);
        mesh->bore_share[k] += length / 6;
        mesh->bore_share[k + 1] += 4 * length / 6;
        mesh->bore_share[(k + 2) % n] += length / 6;
    }
}

static bool allocate(struct qg_gear_mesh *mesh, const struct qg_sector_mesh sector[2], int teeth, size_t *bore_room) {
    size_t fine = (size_t)mesh->fine_teeth, far = (size_t)(teeth - mesh->fine_teeth);
    size_t nodes = fine * sector[0].node_count + far * sector[1].node_count;
    size_t elements = fine * sector[0].element_count + far * sector[1].element_count;
    *bore_room = fine * (sector[0].bore_count - 1) + far * (sector[1].bore_count - 1);
    mesh->node = malloc(nodes * sizeof *mesh->node);
    mesh->element = malloc(elements * sizeof *mesh->element);
    mesh->flank = malloc(fine * mesh->flank_count * sizeof *mesh->flank);
    mesh->flank_arc = malloc(mesh->flank_count * sizeof *mesh->flank_arc);
    mesh->bore = malloc(*bore_room * sizeof *mesh->bore);
    mesh->bore_share = calloc(*bore_room, sizeof *mesh->bore_share);
    return mesh->node && mesh->element && mesh->flank && mesh->flank_arc && mesh->bore && mesh->bore_share;
}

static enum qg_status join(struct qg_gear_mesh *mesh, const struct qg_sector_mesh sector[2], int teeth) {
    assert(sector[0].side_count == sector[1].side_count);
    size_t side = sector[0].side_count;
    size_t most = sector[0].node_count > sector[1].node_count ? sector[0].node_count : sector[1].node_count;
    struct joiner j = {.mesh = mesh, .teeth = teeth};
    j.id = malloc((most + 2 * side) * sizeof *j.id);
    if (!j.id || !allocate(mesh, sector, teeth, &j.bore_room)) {
        free(j.id);
        return QG_OUT_OF_MEMORY;
    }
    j.first = j.id + most;
    j.before = j.first + side;
    memcpy(mesh->flank_arc, sector[0].flank_arc, mesh->flank_count * sizeof *mesh->flank_arc);
    for (int t = 0; t < teeth; t++)
        put_sector(&j, &sector[t < mesh->fine_teeth ? 0 : 1]);
    share_bore(mesh);
    free(j.id);
    return QG_OK;
}

enum qg_status qg_gear_mesh_init(struct qg_gear_mesh *mesh, const struct qg_gear_mesh_plan *plan,
                                 struct qg_notes *notes) {
    struct qg_sector_mesh sector[2] = {{0}};
    int teeth = plan->pair->gears[plan->gear].teeth;
    assert(plan->fine_teeth >= 1 && plan->fine_teeth <= teeth);
    *mesh = (struct qg_gear_mesh){.first_tooth = plan->first_tooth, .fine_teeth = plan->fine_teeth};
    enum qg_status status = make_sector(plan, plan->fine, &sector[0], notes);
    if (status == QG_OK)
        status = make_sector(plan, plan->coarse, &sector[1], notes);
    if (status == QG_OK) {
        mesh->fine_elements = sector[0].element_count;
        mesh->flank_count = sector[0].flank_count;
        for (int b = 0; b < QG_BLOCK_COUNT; b++) {
            mesh->block[b].columns = sector[0].block[b].columns;
            mesh->block[b].rows = sector[0].block[b].rows;
        }
        status = join(mesh, sector, teeth);
    }
    for (int k = 0; k < 2; k++)
        qg_sector_mesh_finish(&sector[k]);
    if (status != QG_OK)
        qg_gear_mesh_finish(mesh);
    return status;
}

void qg_gear_mesh_finish(struct qg_gear_mesh *mesh) {
    free(mesh->node);
    free(mesh->element);
    free(mesh->flank);
    free(mesh->flank_arc);
    free(mesh->bore);
    free(mesh->bore_share);
    *mesh = (struct qg_gear_mesh){0};
}

size_t qg_gear_mesh_flank_element(const struct qg_gear_mesh *mesh, int tooth, size_t edge) {
    size_t fillet_rows = (size_t)mesh->block[QG_BLOCK_TOOTH].rows - (mesh->flank_count - 1) / 2;
    size_t row = fillet_rows + edge;
    return (size_t)tooth * mesh->fine_elements + row * (size_t)mesh->block[QG_BLOCK_TOOTH].columns;
}

struct qg_sector_mesh qg_gear_mesh_view(const struct qg_gear_mesh *mesh) {
    return (struct qg_sector_mesh){.node_count = mesh->node_count,
                                   .element_count = mesh->element_count,
                                   .node = mesh->node,
                                   .element = mesh->element};
}

/* ---- mounting --------------------------------------------------------------------------------------------------- */

int qg_tip_gear(const struct qg_pair_geometry *geometry, double position, int pair) {
    double pitch_point = geometry->gears[QG_PINION].base_radius * tan(geometry->working_pressure_angle);
    return qg_path_position(geometry, position, pair) < pitch_point ? QG_GEAR : QG_PINION;
}
