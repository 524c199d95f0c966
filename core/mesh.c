/* Meshing of a tooth sector by transfinite interpolation in blocks; see mesh.h for the picture.
 *
 * Every block is a lattice of (2 rows + 1) x (2 columns + 1) points, u running across the tooth from the contact flank's
 * side to the other, v from the bore outwards; points with both indices odd would be element centres and do not exist.
 * Blocks share the nodes of their common edges: a block takes over the numbers of the edges that stand already and makes
 * the others. Inside, Gordon-Hall interpolation blends the four edges, whose point distributions may differ.
 *
 * The profile from the middle of the space to the tip is one curve in three pieces (root circle, trochoid, involute),
 * addressed by a coordinate q in [0, 3] and placed by arc length through a table.
 */
#include "core/mesh.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct point {
    double x, y; /* x along the tooth's centre line, y towards the contact flank */
};

const struct qg_mesh_density qg_density_analysis = {
    .tooth_columns = 20,
    .fillet_rows = 5,
    .root_columns = 6,
    .foot_rows = 6,
    .body_rows = 8,
    .flank_elements_per_module = 44,
    .tip_share = 0.15,
    .column_growth = 1.25,
    .back_columns = 4,
    .back_growth = 0.6,
};

/* Where the blocks meet, and where elements shrink. */
static const double tip_zone = 0.3; /* in modules: elements shrink towards the tip corner, which touches too */
/* Parameter of J. Three blocks share it, so the stress along the profile has a small step there; it lies towards the root
 * circle, away from where the fillet is stressed most (some 0.5 to 0.8). */
static const double joint_on_trochoid = 0.4;

/* ---- the profile ------------------------------------------------------------------------------------------------ */

enum { PROFILE_SAMPLES = 600 };

struct profile {
    const struct qg_rack *rack;
    const struct qg_gear *gear;
    const struct qg_gear_geometry *geometry;
    double length[3 * PROFILE_SAMPLES + 1]; /* arc length up to q = i / PROFILE_SAMPLES */
};

static double involute_arc(const struct qg_gear_geometry *g, double radius) {
    return (radius * radius - g->base_radius * g->base_radius) / (2 * g->base_radius);
}

static struct point to_point(struct qg_polar p) {
    return (struct point){p.radius * cos(p.angle), p.radius * sin(p.angle)};
}

/* The contact side's profile at q: 0..1 root circle, 1..2 trochoid, 2..3 involute. */
static struct point profile_at(const struct profile *p, double q) {
    const struct qg_gear_geometry *g = p->geometry;
    if (q < 1) {
        double start = M_PI / p->gear->teeth;
        double end = start - g->hob_tip_center_offset / g->reference_radius;
        return to_point((struct qg_polar){p->gear->root_radius, start + q * (end - start)});
    }
    if (q < 2)
        return to_point(qg_trochoid_point(p->rack, p->gear, g, q - 1));
    double from = involute_arc(g, g->form_radius), to = involute_arc(g, p->gear->outside_radius);
    double arc = from + fmin(1, q - 2) * (to - from);
    double radius = sqrt(g->base_radius * (g->base_radius + 2 * arc));
    return to_point((struct qg_polar){radius, qg_half_tooth_angle(p->rack, g, radius)});
}

static void profile_measure(struct profile *p) {
    struct point last = profile_at(p, 0);
    p->length[0] = 0;
    for (int i = 1; i <= 3 * PROFILE_SAMPLES; i++) {
        struct point next = profile_at(p, (double)i / PROFILE_SAMPLES);
        p->length[i] = p->length[i - 1] + hypot(next.x - last.x, next.y - last.y);
        last = next;
    }
}

/* The profile's point that divides the stretch [from, to] of q in the ratio `share` of its arc length. */
static struct point profile_between(const struct profile *p, double from, double to, double share) {
    double a = p->length[(int)lround(from * PROFILE_SAMPLES)], b = p->length[(int)lround(to * PROFILE_SAMPLES)];
    double wanted = a + share * (b - a);
    int low = (int)lround(from * PROFILE_SAMPLES), high = (int)lround(to * PROFILE_SAMPLES);
    if (share <= 0 || high <= low)
        return profile_at(p, from);
    if (share >= 1)
        return profile_at(p, to);
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (p->length[middle] <= wanted)
            low = middle;
        else
            high = middle;
    }
    double step = p->length[high] - p->length[low];
    double inside = step > 0 ? (wanted - p->length[low]) / step : 0;
    return profile_at(p, (low + inside) / PROFILE_SAMPLES);
}

/* ---- blocks ----------------------------------------------------------------------------------------------------- */

struct block {
    int columns, rows; /* elements */
    int *id;           /* node numbers of the lattice, -1 where not made yet */
};

enum edge { BOTTOM, TOP, LEFT, RIGHT };

/* Number of lattice points along u and v. */
static int across(const struct block *b) {
    return 2 * b->columns + 1;
}

static int along(const struct block *b) {
    return 2 * b->rows + 1;
}

static int *lattice(const struct block *b, int i, int j) {
    return &b->id[j * across(b) + i];
}

static int *edge_point(const struct block *b, enum edge edge, int k) {
    switch (edge) {
    case BOTTOM:
        return lattice(b, k, 0);
    case TOP:
        return lattice(b, k, along(b) - 1);
    case LEFT:
        return lattice(b, 0, k);
    case RIGHT:
    default:
        return lattice(b, across(b) - 1, k);
    }
}

static bool block_init(struct block *b, int columns, int rows) {
    *b = (struct block){columns, rows, NULL};
    size_t n = (size_t)across(b) * (size_t)along(b);
    b->id = malloc(n * sizeof *b->id);
    if (b->id)
        memset(b->id, 0xff, n * sizeof *b->id);
    return b->id != NULL;
}

/* Everything that is at work while a sector is meshed. */
struct mesher {
    struct qg_sector_mesh *mesh;
    struct profile profile;
    const struct qg_mesh_density *density;
    size_t node_room, element_room;
    int refinement;
    double sector_angle; /* pi / z, half of it */
    double foot_radius;  /* of the arc between foot and body */
    double foot_angle;   /* of K */
    double *tooth_share; /* lattice distribution across the tooth, 2 columns + 1 */
    double *flank_share; /* lattice distribution along the flank from J to the tip */
    int fillet_rows, flank_rows;
    double flank_length; /* of the involute, in modules */
    struct block tooth, foot, root[2], body;
};

static int new_node(struct mesher *m, struct point p) {
    assert(m->mesh->node_count < m->node_room);
    m->mesh->node[m->mesh->node_count] = (struct qg_polar){hypot(p.x, p.y), atan2(p.y, p.x)};
    return (int)m->mesh->node_count++;
}

static struct point node_point(const struct mesher *m, int id) {
    return to_point(m->mesh->node[id]);
}

static void put(struct mesher *m, int *place, struct point p) {
    if (*place < 0)
        *place = new_node(m, p);
}

/* Takes over the nodes of another block's edge. */
static void share_edge(const struct block *to, enum edge to_edge, const struct block *from, enum edge from_edge) {
    int n = to_edge == BOTTOM || to_edge == TOP ? across(to) : along(to);
    for (int k = 0; k < n; k++)
        *edge_point(to, to_edge, k) = *edge_point(from, from_edge, k);
}

/* Share of the edge's length up to each of its points: the blending coordinate. */
static double edge_share(const struct mesher *m, const struct block *b, enum edge edge, int k) {
    int n = edge == BOTTOM || edge == TOP ? across(b) : along(b);
    double sum = 0, part = 0;
    for (int i = 1; i < n; i++) {
        struct point p = node_point(m, *edge_point(b, edge, i - 1)), q = node_point(m, *edge_point(b, edge, i));
        double step = hypot(q.x - p.x, q.y - p.y);
        sum += step;
        if (i <= k)
            part += step;
    }
    return part / sum;
}

static struct point blend(const struct mesher *m, const struct block *b, int i, int j, double u, double v) {
    struct point bottom = node_point(m, *edge_point(b, BOTTOM, i)), top = node_point(m, *edge_point(b, TOP, i));
    struct point left = node_point(m, *edge_point(b, LEFT, j)), right = node_point(m, *edge_point(b, RIGHT, j));
    int last_i = across(b) - 1, last_j = along(b) - 1;
    struct point c00 = node_point(m, *lattice(b, 0, 0)), c10 = node_point(m, *lattice(b, last_i, 0));
    struct point c01 = node_point(m, *lattice(b, 0, last_j)), c11 = node_point(m, *lattice(b, last_i, last_j));
#define QG_BLEND(w)                                                                                                    \
    ((1 - v) * bottom.w + v * top.w + (1 - u) * left.w + u * right.w - (1 - u) * (1 - v) * c00.w -                     \
     u * (1 - v) * c10.w - (1 - u) * v * c01.w - u * v * c11.w)
    return (struct point){QG_BLEND(x), QG_BLEND(y)};
#undef QG_BLEND
}

/* Fills a block whose four edges stand. */
static void block_fill(struct mesher *m, const struct block *b, double *scratch) {
    double *bottom = scratch, *top = bottom + across(b), *left = top + across(b), *right = left + along(b);
    for (int i = 0; i < across(b); i++) {
        bottom[i] = edge_share(m, b, BOTTOM, i);
        top[i] = edge_share(m, b, TOP, i);
    }
    for (int j = 0; j < along(b); j++) {
        left[j] = edge_share(m, b, LEFT, j);
        right[j] = edge_share(m, b, RIGHT, j);
    }
    for (int j = 1; j < along(b) - 1; j++)
        for (int i = 1; i < across(b) - 1; i++) {
            if (i % 2 && j % 2)
                continue;
            double du = top[i] - bottom[i], dv = right[j] - left[j];
            double u = (bottom[i] + left[j] * du) / (1 - du * dv), v = left[j] + u * dv;
            put(m, lattice(b, i, j), blend(m, b, i, j, u, v));
        }
}

static void block_elements(struct mesher *m, const struct block *b) {
    static const int at[QG_ELEMENT_NODES][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}};
    for (int r = 0; r < b->rows; r++)
        for (int c = 0; c < b->columns; c++) {
            assert(m->mesh->element_count < m->element_room);
            int *e = m->mesh->element[m->mesh->element_count++];
            for (int n = 0; n < QG_ELEMENT_NODES; n++)
                e[n] = *lattice(b, 2 * c + at[n][0], 2 * r + at[n][1]);
        }
}

/* ---- distributions ---------------------------------------------------------------------------------------------- */

/* Lattice coordinates 0..1 of n elements whose lengths grow by `growth`; midsides halve their element. */
static void geometric(double *share, int n, double growth) {
    double total = growth == 1 ? n : (pow(growth, n) - 1) / (growth - 1);
    share[0] = 0;
    double at = 0, step = 1;
    for (int i = 0; i < n; i++, step *= growth) {
        share[2 * i + 1] = (at + step / 2) / total;
        at += step;
        share[2 * i + 2] = at / total;
    }
}

/* Lattice coordinates 0..1 across the tooth: columns grow away from the contact flank; the last ones shrink again towards
 * the opposite one, whose fillet is stressed as much. Refinement divides every column, in its own growth. */
static void across_tooth(const struct mesher *m) {
    const struct qg_mesh_density *d = m->density;
    const int n = d->tooth_columns, parts = 2 * m->refinement;
    double at = 0, length = 1;
    for (int e = 0; e < n; e++) {
        double growth = e < n - d->back_columns ? d->column_growth : d->back_growth;
        double *share = m->tooth_share + e * parts; /* its first is the last one's end */
        geometric(share, m->refinement, pow(growth, 1.0 / m->refinement));
        for (int k = 0; k <= parts; k++)
            share[k] = at + length * share[k];
        at += length;
        length *= e + 1 < n - d->back_columns ? d->column_growth : d->back_growth;
    }
    for (int k = 1; k <= 2 * m->tooth.columns; k++)
        m->tooth_share[k] /= at;
}

/* Length of the flank's element that begins at the distance `rest` (in modules) from the tip, in modules. */
static double flank_element(const struct qg_mesh_density *d, double rest) {
    double share = d->tip_share + (1 - d->tip_share) * fmin(1, rest / tip_zone);
    return share / d->flank_elements_per_module;
}

int qg_flank_elements(const struct qg_mesh_density *density, double length) {
    int n = 0;
    for (double rest = length; rest > 0 && n < QG_FLANK_ELEMENTS_MAX; n++)
        rest -= flank_element(density, rest);
    return n;
}

/* Along the contact flank: fillet rows that shrink towards the form point (0..1), then the involute (1..2), even at first
 * and finer towards the tip. Every element of refinement 1 is divided evenly by the refinement. */
static void flank_distribution(struct mesher *m) {
    double *share = m->flank_share + 2 * m->fillet_rows;
    geometric(m->flank_share, m->fillet_rows, pow(0.85, 1.0 / m->refinement));
    int n = m->flank_rows / m->refinement, parts = 2 * m->refinement;
    double at = 0;
    for (int e = 0; e < n; e++) {
        double length = flank_element(m->density, m->flank_length - at);
        for (int k = 1; k <= parts; k++)
            share[e * parts + k] = at + length * k / parts;
        at += length;
    }
    for (int k = 1; k <= 2 * m->flank_rows; k++)
        share[k] = 1 + share[k] / at;
}

/* ---- the blocks of a sector ------------------------------------------------------------------------------------- */

static struct point mirrored(struct point p, bool mirror) {
    return mirror ? (struct point){p.x, -p.y} : p;
}

static struct point flank_point(const struct mesher *m, int k) {
    double share = m->flank_share[k], joint = 1 + joint_on_trochoid;
    return share <= 1 ? profile_between(&m->profile, joint, 2, share) : profile_between(&m->profile, 2, 3, share - 1);
}

static void lay_tooth(struct mesher *m, double *scratch) {
    struct block *b = &m->tooth;
    for (int k = 0; k < along(b); k++) {
        struct point p = flank_point(m, k);
        put(m, edge_point(b, LEFT, k), p);
        put(m, edge_point(b, RIGHT, k), mirrored(p, true));
    }
    struct qg_polar joint = m->mesh->node[*lattice(b, 0, 0)], tip = m->mesh->node[*lattice(b, 0, along(b) - 1)];
    /* the tooth hangs down into its foot, but never near the foot's own arc, which lies close under a thin rim */
    double sag = joint.radius * (1 - cos(joint.angle) + 0.3 * sin(joint.angle));
    double deepest = fmin(sag, 0.4 * (joint.radius - m->foot_radius));
    for (int i = 0; i < across(b); i++) {
        double u = m->tooth_share[i];
        double dip = deepest * 4 * u * (1 - u);
        put(m, edge_point(b, BOTTOM, i), to_point((struct qg_polar){joint.radius - dip, joint.angle * (1 - 2 * u)}));
        put(m, edge_point(b, TOP, i), to_point((struct qg_polar){tip.radius, tip.angle * (1 - 2 * u)}));
    }
    block_fill(m, b, scratch);
}

static struct point on_foot_arc(const struct mesher *m, double from, double to, double share) {
    return to_point((struct qg_polar){m->foot_radius, from + share * (to - from)});
}

static struct point on_line(struct point a, struct point b, double share) {
    return (struct point){a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)};
}

static void lay_foot(struct mesher *m, const double *rows, double *scratch) {
    struct block *b = &m->foot;
    share_edge(b, TOP, &m->tooth, BOTTOM);
    struct point joint = node_point(m, *lattice(b, 0, along(b) - 1));
    for (int k = 0; k < along(b); k++)
        for (int side = 0; side < 2; side++) {
            struct point foot = on_foot_arc(m, m->foot_angle, m->foot_angle, 0);
            struct point p = mirrored(on_line(foot, joint, rows[k]), side == 1);
            put(m, edge_point(b, side == 0 ? LEFT : RIGHT, k), p);
        }
    for (int i = 0; i < across(b); i++) {
        double u = 0.5 * m->tooth_share[i] + 0.5 * i / (across(b) - 1);
        put(m, edge_point(b, BOTTOM, i), on_foot_arc(m, m->foot_angle, -m->foot_angle, u));
    }
    block_fill(m, b, scratch);
}

/* The root of the space on one side: between the sector's side and the foot. */
static void lay_root(struct mesher *m, int side, const double *rows, double *scratch) {
    struct block *b = &m->root[side];
    bool mirror = side == 1;
    enum edge outer = mirror ? RIGHT : LEFT, inner = mirror ? LEFT : RIGHT;
    share_edge(b, inner, &m->foot, mirror ? RIGHT : LEFT);
    struct point bottom = on_foot_arc(m, m->sector_angle, 0, 0), top = profile_at(&m->profile, 0);
    for (int k = 0; k < along(b); k++)
        put(m, edge_point(b, outer, k), mirrored(on_line(bottom, top, rows[k]), mirror));
    for (int i = 0; i < across(b); i++) {
        double u = (double)i / (across(b) - 1);
        int at = mirror ? across(b) - 1 - i : i;
        put(m, edge_point(b, BOTTOM, at), mirrored(on_foot_arc(m, m->sector_angle, m->foot_angle, u), mirror));
        put(m, edge_point(b, TOP, at), mirrored(profile_between(&m->profile, 0, 1 + joint_on_trochoid, u), mirror));
    }
    block_fill(m, b, scratch);
}

static void lay_body(struct mesher *m) {
    struct block *b = &m->body;
    int at = 0;
    const struct block *above[3] = {&m->root[0], &m->foot, &m->root[1]};
    for (int k = 0; k < 3; k++)
        for (int i = k == 0 ? 0 : 1; i < across(above[k]); i++)
            *edge_point(b, TOP, at++) = *edge_point(above[k], BOTTOM, i);
    assert(at == across(b));
    double bore = m->profile.gear->bore_diameter / 2;
    double *rows = m->flank_share; /* no longer needed: reuse as scratch */
    geometric(rows, b->rows, pow(0.8, 1.0 / m->refinement));
    for (int j = 0; j < along(b) - 1; j++)
        for (int i = 0; i < across(b); i++) {
            if (i % 2 && j % 2)
                continue;
            double angle = m->mesh->node[*edge_point(b, TOP, i)].angle;
            double radius = bore + rows[j] * (m->foot_radius - bore);
            *lattice(b, i, j) = (int)m->mesh->node_count;
            new_node(m, to_point((struct qg_polar){radius, angle}));
        }
}

/* ---- lists of nodes --------------------------------------------------------------------------------------------- */

static void list_flank(struct mesher *m) {
    struct qg_sector_mesh *mesh = m->mesh;
    const struct qg_gear_geometry *g = m->profile.geometry;
    int first = 2 * m->fillet_rows;
    mesh->flank_count = (size_t)(2 * m->flank_rows + 1);
    for (size_t k = 0; k < mesh->flank_count; k++) {
        mesh->flank[k] = *edge_point(&m->tooth, LEFT, first + (int)k);
        mesh->flank_arc[k] = involute_arc(g, mesh->node[mesh->flank[k]].radius);
    }
}

/* The root's nodes: from the middle of the space over root and fillet blocks up to the form point. */
static void list_root(struct mesher *m) {
    struct qg_sector_mesh *mesh = m->mesh;
    for (int side = 0; side < 2; side++) {
        const struct block *b = &m->root[side];
        size_t n = 0;
        for (int i = 0; i < across(b); i++)
            mesh->root[side][n++] = *edge_point(b, TOP, side == 0 ? i : across(b) - 1 - i);
        for (int k = 1; k <= 2 * m->fillet_rows; k++)
            mesh->root[side][n++] = *edge_point(&m->tooth, side == 0 ? LEFT : RIGHT, k);
        mesh->root_count = n;
    }
}

static void list_sides_and_bore(struct mesher *m) {
    struct qg_sector_mesh *mesh = m->mesh;
    for (int side = 0; side < 2; side++) {
        enum edge outer = side == 0 ? LEFT : RIGHT;
        size_t n = 0;
        for (int k = 0; k < along(&m->body); k++)
            mesh->side[side][n++] = *edge_point(&m->body, outer, k);
        for (int k = 1; k < along(&m->root[side]); k++)
            mesh->side[side][n++] = *edge_point(&m->root[side], outer, k);
        mesh->side_count = n;
    }
    mesh->bore_count = (size_t)across(&m->body);
    for (int i = 0; i < across(&m->body); i++)
        mesh->bore[i] = *edge_point(&m->body, BOTTOM, i);
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

/* Twice the signed area of the triangle. */
static double turn(struct point a, struct point b, struct point c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool elements_are_convex(const struct mesher *m) {
    for (size_t e = 0; e < m->mesh->element_count; e++) {
        struct point p[4];
        for (int k = 0; k < 4; k++)
            p[k] = node_point(m, m->mesh->element[e][k]);
        for (int k = 0; k < 4; k++)
            if (turn(p[k], p[(k + 1) % 4], p[(k + 2) % 4]) <= 0)
                return false;
    }
    return true;
}

/* ---- putting it together ---------------------------------------------------------------------------------------- */

static bool mesher_init(struct mesher *m) {
    const struct qg_gear *gear = m->profile.gear;
    const struct qg_gear_geometry *g = m->profile.geometry;
    const struct qg_mesh_density *d = m->density;
    int r = m->refinement;
    double arc = involute_arc(g, gear->outside_radius) - involute_arc(g, g->form_radius);
    m->flank_length = arc / m->profile.rack->module;
    m->flank_rows = r * (int)fmax(4, qg_flank_elements(d, m->flank_length));
    m->fillet_rows = r * d->fillet_rows;
    m->sector_angle = M_PI / gear->teeth;
    double rim = gear->root_radius - gear->bore_diameter / 2;
    m->foot_radius = gear->root_radius - fmin(1.2 * m->profile.rack->module, rim / 2);
    m->foot_angle = 0.6 * m->sector_angle;
    bool ok = block_init(&m->tooth, r * d->tooth_columns, m->fillet_rows + m->flank_rows) &&
              block_init(&m->foot, r * d->tooth_columns, r * d->foot_rows) &&
              block_init(&m->root[0], r * d->root_columns, r * d->foot_rows) &&
              block_init(&m->root[1], r * d->root_columns, r * d->foot_rows) &&
              block_init(&m->body, r * (d->tooth_columns + 2 * d->root_columns), r * d->body_rows);
    m->tooth_share = calloc((size_t)across(&m->tooth), sizeof(double));
    m->flank_share = calloc((size_t)along(&m->tooth) + (size_t)along(&m->body), sizeof(double));
    return ok && m->tooth_share && m->flank_share;
}

static void mesher_finish(struct mesher *m) {
    struct block *blocks[] = {&m->tooth, &m->foot, &m->root[0], &m->root[1], &m->body};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++)
        free(blocks[i]->id);
    free(m->tooth_share);
    free(m->flank_share);
}

static bool mesh_allocate(struct mesher *m) {
    struct qg_sector_mesh *mesh = m->mesh;
    const struct block *blocks[] = {&m->tooth, &m->foot, &m->root[0], &m->root[1], &m->body};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        m->node_room += (size_t)across(blocks[i]) * (size_t)along(blocks[i]);
        m->element_room += (size_t)blocks[i]->columns * (size_t)blocks[i]->rows;
    }
    size_t side = (size_t)along(&m->body) + (size_t)along(&m->root[0]);
    size_t root = (size_t)across(&m->root[0]) + 2 * (size_t)m->fillet_rows;
    mesh->node = malloc(m->node_room * sizeof *mesh->node);
    mesh->element = malloc(m->element_room * sizeof *mesh->element);
    mesh->flank = malloc((size_t)along(&m->tooth) * sizeof *mesh->flank);
    mesh->flank_arc = malloc((size_t)along(&m->tooth) * sizeof *mesh->flank_arc);
    mesh->root[0] = malloc(root * sizeof *mesh->root[0]);
    mesh->root[1] = malloc(root * sizeof *mesh->root[1]);
    mesh->side[0] = malloc(side * sizeof *mesh->side[0]);
    mesh->side[1] = malloc(side * sizeof *mesh->side[1]);
    mesh->bore = malloc((size_t)across(&m->body) * sizeof *mesh->bore);
    return mesh->node && mesh->element && mesh->flank && mesh->flank_arc && mesh->root[0] && mesh->root[1] &&
           mesh->side[0] && mesh->side[1] && mesh->bore;
}

static enum qg_status lay_everything(struct mesher *m) {
    int longest = along(&m->tooth) > across(&m->body) ? along(&m->tooth) : across(&m->body);
    double *scratch = malloc(4 * (size_t)longest * sizeof *scratch);
    double *rows = malloc((size_t)along(&m->foot) * sizeof *rows);
    if (!scratch || !rows) {
        free(scratch);
        free(rows);
        return QG_OUT_OF_MEMORY;
    }
    across_tooth(m);
    geometric(rows, m->foot.rows, pow(0.85, 1.0 / m->refinement));
    flank_distribution(m);
    lay_tooth(m, scratch);
    list_flank(m);
    lay_foot(m, rows, scratch);
    lay_root(m, 0, rows, scratch);
    lay_root(m, 1, rows, scratch);
    lay_body(m);
    const struct block *blocks[] = {&m->tooth, &m->foot, &m->root[0], &m->root[1], &m->body};
    for (size_t i = 0; i < QG_BLOCK_COUNT; i++) {
        block_elements(m, blocks[i]);
        m->mesh->block[i].columns = blocks[i]->columns;
        m->mesh->block[i].rows = blocks[i]->rows;
    }
    list_root(m);
    list_sides_and_bore(m);
    free(scratch);
    free(rows);
    return QG_OK;
}

enum qg_status qg_sector_mesh_init(struct qg_sector_mesh *mesh, const struct qg_rack *rack, const struct qg_gear *gear,
                                   const struct qg_gear_geometry *geometry, int refinement, struct qg_notes *notes) {
    return qg_sector_mesh_init_with(mesh, rack, gear, geometry, &qg_density_analysis, refinement, notes);
}

enum qg_status qg_sector_mesh_init_with(struct qg_sector_mesh *mesh, const struct qg_rack *rack,
                                        const struct qg_gear *gear, const struct qg_gear_geometry *geometry,
                                        const struct qg_mesh_density *density, int refinement, struct qg_notes *notes) {
    *mesh = (struct qg_sector_mesh){0};
    struct mesher *m = calloc(1, sizeof *m);
    if (!m)
        return QG_OUT_OF_MEMORY;
    m->mesh = mesh;
    m->density = density;
    m->refinement = refinement;
    m->profile.rack = rack;
    m->profile.gear = gear;
    m->profile.geometry = geometry;
    profile_measure(&m->profile);
    enum qg_status status = mesher_init(m) && mesh_allocate(m) ? lay_everything(m) : QG_OUT_OF_MEMORY;
    if (status == QG_OK && !elements_are_convex(m)) {
        qg_notes_add(notes, "",
                     "the mesher turned an element inside out on a gear of %d teeth: its proportions are "
                     "outside of what it can mesh",
                     gear->teeth);
        status = QG_NO_CONVERGENCE;
    }
    mesher_finish(m);
    free(m);
    if (status != QG_OK)
        qg_sector_mesh_finish(mesh);
    return status;
}

void qg_sector_mesh_finish(struct qg_sector_mesh *mesh) {
    free(mesh->node);
    free(mesh->element);
    free(mesh->flank);
    free(mesh->flank_arc);
    free(mesh->root[0]);
    free(mesh->root[1]);
    free(mesh->side[0]);
    free(mesh->side[1]);
    free(mesh->bore);
    *mesh = (struct qg_sector_mesh){0};
}
