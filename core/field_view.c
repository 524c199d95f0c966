/* Thinning: in every block of a tooth sector, elements are taken together in groups of rows and columns. Blocks that share an
 * edge cut it alike, so the groups join as the elements do. */
#include "core/field_view.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* Groups across either root, along flank, fillet, foot and body. */
enum { ROOT_GROUPS = 6, FLANK_GROUPS = 24, FILLET_GROUPS = 5, FOOT_GROUPS = 3, BODY_GROUPS = 4 };
enum { CUTS_MAX = 64 };

/* Where groups begin and end: element numbers, ascending. */
struct cuts {
    int count; /* groups */
    int at[CUTS_MAX];
};

/* Cuts `elements` further elements into groups as even as can be. */
static void cut(struct cuts *cuts, int elements, int groups) {
    int from = cuts->at[cuts->count];
    groups = groups < elements ? groups : elements;
    assert(cuts->count + groups < CUTS_MAX);
    for (int k = 1; k <= groups; k++)
        cuts->at[cuts->count + k] = from + elements * k / groups;
    cuts->count += groups;
}

/* The columns of tooth and foot grow from the contact flank inwards and shrink again towards the opposite one: groups of many
 * where they are thinnest, of one further on, so that pressure below the surface shows as well as the root on the other side. */
static void cut_tooth(struct cuts *cuts, int columns) {
    static const int share[] = {4, 8, 11, 13, 15, 16, 17, 18, 19, 20};
    int from = cuts->at[cuts->count];
    assert(columns % 20 == 0); /* qg_density_analysis, refined */
    for (size_t k = 0; k < sizeof share / sizeof *share; k++)
        cuts->at[++cuts->count] = from + share[k] * columns / 20;
}

static void cut_block(const struct qg_gear_mesh *mesh, enum qg_mesh_block block, struct cuts *columns,
                      struct cuts *rows) {
    int flank = (int)(mesh->flank_count - 1) / 2;
    int tooth = mesh->block[QG_BLOCK_TOOTH].columns, root = mesh->block[QG_BLOCK_ROOT_PLUS].columns;
    *columns = *rows = (struct cuts){0};
    switch (block) {
    case QG_BLOCK_TOOTH:
        cut_tooth(columns, tooth);
        cut(rows, mesh->block[block].rows - flank, FILLET_GROUPS);
        cut(rows, flank, FLANK_GROUPS);
        break;
    case QG_BLOCK_FOOT:
        cut_tooth(columns, tooth);
        cut(rows, mesh->block[block].rows, FOOT_GROUPS);
        break;
    case QG_BLOCK_BODY:
        cut(columns, root, ROOT_GROUPS);
        cut_tooth(columns, tooth);
        cut(columns, root, ROOT_GROUPS);
        cut(rows, mesh->block[block].rows, BODY_GROUPS);
        break;
    default: /* either root */
        cut(columns, root, ROOT_GROUPS);
        cut(rows, mesh->block[block].rows, FOOT_GROUPS);
    }
}

/* A view while it is made. */
struct thinner {
    struct qg_field_view *view;
    const struct qg_gear_mesh *mesh;
    int *place; /* [nodes of the mesh] in view->node, or -1 */
};

static int take(struct thinner *t, int node) {
    if (t->place[node] < 0) {
        t->place[node] = (int)t->view->node_count;
        t->view->node[t->view->node_count++] = node;
    }
    return t->place[node];
}

/* The groups of one block whose elements begin at `first`; returns how many elements it has. */
static size_t thin_block(struct thinner *t, enum qg_mesh_block block, size_t first) {
    struct cuts columns, rows;
    size_t across = (size_t)t->mesh->block[block].columns;
    cut_block(t->mesh, block, &columns, &rows);
    for (int r = 0; r < rows.count; r++)
        for (int c = 0; c < columns.count; c++) {
            size_t low = first + (size_t)rows.at[r] * across, high = first + (size_t)(rows.at[r + 1] - 1) * across;
            size_t left = (size_t)columns.at[c], right = (size_t)columns.at[c + 1] - 1;
            const int corners[4] = {t->mesh->element[low + left][0], t->mesh->element[low + right][1],
                                    t->mesh->element[high + right][2], t->mesh->element[high + left][3]};
            int *quad = t->view->quad[t->view->quad_count++];
            for (int k = 0; k < 4; k++)
                quad[k] = take(t, corners[k]);
        }
    return across * (size_t)t->mesh->block[block].rows;
}

static size_t quads_of_tooth(const struct qg_gear_mesh *mesh) {
    size_t sum = 0;
    for (int b = 0; b < QG_BLOCK_COUNT; b++) {
        struct cuts columns, rows;
        cut_block(mesh, (enum qg_mesh_block)b, &columns, &rows);
        sum += (size_t)columns.count * (size_t)rows.count;
    }
    return sum;
}

enum qg_status qg_field_view_init(struct qg_field_view *view, const struct qg_gear_mesh *mesh) {
    size_t room = (size_t)mesh->fine_teeth * quads_of_tooth(mesh);
    *view = (struct qg_field_view){.node = malloc(4 * room * sizeof *view->node),
                                   .quad = malloc(room * sizeof *view->quad)};
    struct thinner t = {view, mesh, malloc(mesh->node_count * sizeof *t.place)};
    if (!view->node || !view->quad || !t.place) {
        free(t.place);
        qg_field_view_finish(view);
        return QG_OUT_OF_MEMORY;
    }
    memset(t.place, 0xff, mesh->node_count * sizeof *t.place);
    for (int tooth = 0; tooth < mesh->fine_teeth; tooth++) {
        size_t first = (size_t)tooth * mesh->fine_elements;
        for (int b = 0; b < QG_BLOCK_COUNT; b++)
            first += thin_block(&t, (enum qg_mesh_block)b, first);
    }
    free(t.place);
    return QG_OK;
}

void qg_field_view_finish(struct qg_field_view *view) {
    free(view->node);
    free(view->quad);
    *view = (struct qg_field_view){0};
}
