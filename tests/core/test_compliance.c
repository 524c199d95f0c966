/* Flank compliances: against the whole gear as one system, symmetry, scaling, convergence. */
#include "tests/core/cases.h"

#include <lapacke.h>
#include <stdlib.h>

#include "core/compliance.h"
#include "core/study.h"

/* A gear of few, short teeth: small enough to be solved as a whole. */
static struct cut_gear small_gear(int teeth) {
    struct cut_gear g = {.rack = {4, 20 * CASE_DEGREE},
                         .gear = {.teeth = teeth,
                                  .profile_shift = 2.4,
                                  .hob_tip_radius = 0.8,
                                  .bore_diameter = 4 * teeth - 18,
                                  .face_width = 10}};
    double shifted = 2 * teeth + 2.4;
    g.gear.root_radius = shifted - 4.6;
    g.gear.outside_radius = shifted + 0.6;
    struct qg_notes notes = {0};
    if (qg_gear_derive(&g.rack, &g.gear, 7.85e-6, "", &g.geometry, &notes) != QG_OK)
        fail_msg("%s: %s", notes.item[0].where, notes.item[0].text);
    return g;
}

static struct qg_sector_mesh sector_of(const struct cut_gear *g, int refinement) {
    struct qg_sector_mesh mesh;
    assert_int_equal(qg_sector_mesh_init(&mesh, &g->rack, &g->gear, &g->geometry, refinement, NULL), QG_OK);
    return mesh;
}

static struct qg_compliance compliance_of(const struct cut_gear *g, const struct qg_sector_mesh *mesh,
                                          const struct qg_plate *plate, enum qg_support support) {
    struct qg_compliance c;
    const struct qg_compliance_plan plan = {*plate, support, g->gear.teeth, 6, .stop = {0}};
    assert_int_equal(qg_compliance_init(&c, mesh, &plan), QG_OK);
    return c;
}

static const struct qg_plate steel = {206000, 0.3, 10, 0};

/* ---- the whole gear --------------------------------------------------------------------------------------------- */

/* All sectors in one mesh, each rotated into its place. freedom makes the nodes on common sides one and holds the
 * bore. */
struct whole_gear {
    struct qg_sector_mesh mesh;
    const struct qg_sector_mesh *sector;
    int teeth, *freedom, count;
    bool ring; /* torque ring: the bore may turn */
    cholmod_common common;
    cholmod_factor *factor;
};

static int node_of(const struct whole_gear *w, int sector, int node) {
    int turned = ((sector % w->teeth) + w->teeth) % w->teeth;
    return turned * (int)w->sector->node_count + node;
}

static void copy_sectors(struct whole_gear *w) {
    const struct qg_sector_mesh *s = w->sector;
    size_t z = (size_t)w->teeth;
    w->mesh.node = malloc(z * s->node_count * sizeof *w->mesh.node);
    w->mesh.element = malloc(z * s->element_count * sizeof *w->mesh.element);
    assert_true(w->mesh.node && w->mesh.element);
    for (int j = 0; j < w->teeth; j++) {
        for (size_t n = 0; n < s->node_count; n++)
            w->mesh.node[w->mesh.node_count++] =
                (struct qg_polar){s->node[n].radius, s->node[n].angle + 2 * M_PI * j / w->teeth};
        for (size_t e = 0; e < s->element_count; e++, w->mesh.element_count++)
            for (int k = 0; k < QG_ELEMENT_NODES; k++)
                w->mesh.element[w->mesh.element_count][k] = node_of(w, j, s->element[e][k]);
    }
}

/* Rows: bore held radially (and tangentially, or only at one node when it may turn), plus sides shared with the next
 * sector. */
static void number_rows(struct whole_gear *w) {
    const struct qg_sector_mesh *s = w->sector;
    w->freedom = malloc(2 * w->mesh.node_count * sizeof *w->freedom);
    int *master = malloc(w->mesh.node_count * sizeof *master);
    assert_true(w->freedom && master);
    for (size_t n = 0; n < w->mesh.node_count; n++) {
        master[n] = (int)n;
        w->freedom[2 * n] = w->freedom[2 * n + 1] = 0;
    }
    for (int j = 0; j < w->teeth; j++) {
        for (size_t k = 0; k < s->side_count; k++)
            master[node_of(w, j, s->side[0][k])] = node_of(w, j + 1, s->side[1][k]);
        for (size_t k = 0; k < s->bore_count; k++) {
            int n = node_of(w, j, s->bore[k]);
            w->freedom[2 * n] = -1;
            w->freedom[2 * n + 1] = w->ring ? 0 : -1;
        }
    }
    w->freedom[2 * node_of(w, 3, s->bore[1]) + 1] = -1;
    for (size_t n = 0; n < w->mesh.node_count; n++)
        for (size_t c = 0; c < 2; c++)
            if (master[n] == (int)n && w->freedom[2 * n + c] == 0)
                w->freedom[2 * n + c] = w->count++;
    for (size_t n = 0; n < w->mesh.node_count; n++)
        for (size_t c = 0; c < 2; c++)
            w->freedom[2 * n + c] = w->freedom[2 * (size_t)master[n] + c];
    free(master);
}

static struct whole_gear *whole_gear(const struct qg_sector_mesh *sector, int teeth, bool ring) {
    struct whole_gear *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->sector = sector;
    w->teeth = teeth;
    w->ring = ring;
    copy_sectors(w);
    number_rows(w);
    cholmod_start(&w->common);
    cholmod_sparse *k = qg_assemble(&w->mesh, &steel, w->freedom, (size_t)w->count, &w->common);
    assert_non_null(k);
    w->factor = cholmod_analyze(k, &w->common);
    assert_true(cholmod_factorize(k, w->factor, &w->common) && w->common.status == CHOLMOD_OK);
    cholmod_free_sparse(&k, &w->common);
    return w;
}

static void whole_gear_destroy(struct whole_gear *w) {
    cholmod_free_factor(&w->factor, &w->common);
    cholmod_finish(&w->common);
    free(w->mesh.node);
    free(w->mesh.element);
    free(w->freedom);
    free(w);
}

/* One of the edges around the whole bore: its three nodes, corner, midside, corner. Returns its angle, 0 behind the
 * last one. */
static double bore_edge(const struct whole_gear *w, int index, int edge[3]) {
    int per_sector = ((int)w->sector->bore_count - 1) / 2, j = index / per_sector;
    const int *bore = w->sector->bore + 2 * (index % per_sector);
    if (j >= w->teeth)
        return 0;
    for (int e = 0; e < 3; e++)
        edge[e] = node_of(w, j, bore[e]);
    return w->sector->node[bore[0]].angle - w->sector->node[bore[2]].angle;
}

static const double parabolic[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};

/* A uniform tangential traction on the bore whose moment is -moment. */
static void add_balance(const struct whole_gear *w, double moment, double *force) {
    double bore = w->sector->node[w->sector->bore[0]].radius, length;
    int edge[3];
    for (int i = 0; (length = bore_edge(w, i, edge)) > 0; i++)
        for (int e = 0; e < 3; e++) {
            int row = w->freedom[2 * edge[e] + 1];
            if (row >= 0)
                force[row] -= parabolic[e] * length / (2 * M_PI) * moment / bore;
        }
}

static double value_at(const struct whole_gear *w, const double *u, int node, int component) {
    int row = w->freedom[2 * node + component];
    return row < 0 ? 0 : u[row];
}

/* Mean rotation of the bore. */
static double bore_rotation(const struct whole_gear *w, const double *u) {
    double bore = w->sector->node[w->sector->bore[0]].radius, length, sum = 0;
    int edge[3];
    for (int i = 0; (length = bore_edge(w, i, edge)) > 0; i++)
        for (int e = 0; e < 3; e++)
            sum += parabolic[e] * length / (2 * M_PI) * value_at(w, u, edge[e], 1);
    return sum / bore;
}

/* Displacements of the whole gear under a unit force on tooth 0's flank (component `column` of the compliance);
 * freed by the caller. *rotation is what has to be taken off. */
static cholmod_dense *response_to(struct whole_gear *w, size_t column, double *rotation) {
    cholmod_dense *f = cholmod_zeros((size_t)w->count, 1, CHOLMOD_REAL, &w->common);
    int node = w->sector->flank[column / 2];
    double *force = f->x;
    force[w->freedom[2 * (size_t)node_of(w, 0, node) + column % 2]] = 1;
    if (w->ring && column % 2 == 1)
        add_balance(w, w->sector->node[node].radius, force);
    cholmod_dense *u = cholmod_solve(CHOLMOD_A, w->factor, f, &w->common);
    assert_non_null(u);
    cholmod_free_dense(&f, &w->common);
    *rotation = w->ring ? bore_rotation(w, u->x) : 0;
    return u;
}

/* ---- roots of the whole gear -------------------------------------------------------------------------------------- */

/* Stress along an edge of tooth j's root at z, from the solved displacements. */
static double edge_stress(const struct whole_gear *w, const double *u, int j, const int *edge, double z) {
    struct qg_polar polar[3];
    double sum = 0;
    for (int k = 0; k < 3; k++)
        polar[k] = w->mesh.node[node_of(w, j, edge[k])];
    struct qg_edge_stress e = qg_edge_stress((const struct qg_polar *)polar, &steel, z);
    for (int k = 0; k < 6; k++)
        sum += e.weight[k] * value_at(w, u, node_of(w, j, edge[k / 2]), k % 2);
    return sum;
}

/* Stress of root point `point` of tooth j: corners and middles in turn. */
static double root_stress(const struct whole_gear *w, const double *u, int j, size_t point) {
    size_t half = w->sector->root_count - 1, k = point % half;
    const int *edge = w->sector->root[point / half] + k / 2 * 2;
    if (k % 2 == 1)
        return edge_stress(w, u, j, edge, 0);
    double after = edge_stress(w, u, j, edge, -1);
    return k == 0 ? after : (after + edge_stress(w, u, j, edge - 2, 1)) / 2;
}

/* The influence of component `column` on the roots of the teeth around. */
static void compare_roots(const struct whole_gear *w, const struct qg_compliance *c, const double *u, size_t column) {
    size_t p = c->root_count;
    double *influence = malloc(p * 2 * c->flank_count * sizeof *influence), scale = 0;
    assert_non_null(influence);
    assert_int_equal(p, 2 * (w->sector->root_count - 1));
    for (int d = -3; d <= 3; d++) {
        assert_int_equal(qg_compliance_stress(c, d, influence), QG_OK);
        for (size_t i = 0; i < p && d == -3; i++)
            scale = fmax(scale, fabs(root_stress(w, u, 0, i)));
        for (size_t i = 0; i < p; i++)
            assert_near(influence[i + p * column], root_stress(w, u, d, i), 1e-7 * scale);
    }
    free(influence);
}

/* ---- the comparison ------------------------------------------------------------------------------------------------ */

static void compare_with_whole_gear(int teeth, enum qg_support support) {
    struct cut_gear g = small_gear(teeth);
    struct qg_sector_mesh sector = sector_of(&g, 1);
    struct qg_compliance c = compliance_of(&g, &sector, &steel, support);
    struct whole_gear *w = whole_gear(&sector, teeth, support == QG_SUPPORT_TORQUE_RING);
    size_t n = 2 * c.flank_count;
    const size_t columns[] = {0, 1, n / 2, n / 2 + 1, n - 2, n - 1};
    const int distances[] = {0, 1, -1, 2, -2, 3, 5, 6};
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) {
        double rotation;
        cholmod_dense *u = response_to(w, columns[i], &rotation);
        double scale = qg_compliance_entry(&c, 0, columns[i], columns[i]);
        assert_true(scale > 0);
        for (size_t k = 0; k < sizeof distances / sizeof *distances; k++)
            for (size_t row = 0; row < n; row += row % 2 ? n / 8 * 2 + 1 : 1) {
                int node = sector.flank[row / 2];
                double wanted = value_at(w, u->x, node_of(w, distances[k], node), (int)(row % 2));
                wanted -= row % 2 ? rotation * sector.node[node].radius : 0;
                assert_near(qg_compliance_entry(&c, distances[k], row, columns[i]), wanted, 1e-8 * scale);
            }
        compare_roots(w, &c, u->x, columns[i]);
        cholmod_free_dense(&u, &w->common);
    }
    whole_gear_destroy(w);
    qg_compliance_finish(&c);
    qg_sector_mesh_finish(&sector);
}

static void fixed_bore_agrees_with_the_whole_gear(void **state) {
    (void)state;
    compare_with_whole_gear(9, QG_SUPPORT_FIXED);
    compare_with_whole_gear(12, QG_SUPPORT_FIXED);
}

static void torque_ring_agrees_with_the_whole_gear(void **state) {
    (void)state;
    compare_with_whole_gear(9, QG_SUPPORT_TORQUE_RING);
    compare_with_whole_gear(12, QG_SUPPORT_TORQUE_RING);
}

/* ---- stress recovered another way ---------------------------------------------------------------------------------- */

/* The stress tensor (xx, yy, xy) in an element at a natural point, from the gradient of all its eight nodes. */
static void element_stress(const struct whole_gear *w, const double *u, const int *element, const double at[2],
                           double out[3]) {
    static const double r[8] = {-1, 1, 1, -1, 0, 1, 0, -1}, s[8] = {-1, -1, 1, 1, -1, 0, 1, 0};
    double jacobian[2][2] = {{0}}, slope[2][2] = {{0}}; /* d(x, y) and d(ux, uy) per natural coordinate */
    for (int n = 0; n < 8; n++) {
        double corner = 0.25 * (1 + r[n] * at[0]) * (1 + s[n] * at[1]), d[2];
        d[0] = n < 4 ? 0.25 * r[n] * (1 + s[n] * at[1]) * (r[n] * at[0] + s[n] * at[1] - 1) + corner * r[n]
                     : (r[n] == 0 ? -at[0] * (1 + s[n] * at[1]) : 0.5 * r[n] * (1 - at[1] * at[1]));
        d[1] = n < 4 ? 0.25 * s[n] * (1 + r[n] * at[0]) * (r[n] * at[0] + s[n] * at[1] - 1) + corner * s[n]
                     : (s[n] == 0 ? -at[1] * (1 + r[n] * at[0]) : 0.5 * s[n] * (1 - at[0] * at[0]));
        struct qg_polar p = w->mesh.node[element[n]];
        double ur = value_at(w, u, element[n], 0), ut = value_at(w, u, element[n], 1);
        const double x[2] = {p.radius * cos(p.angle), p.radius * sin(p.angle)};
        const double v[2] = {ur * cos(p.angle) - ut * sin(p.angle), ur * sin(p.angle) + ut * cos(p.angle)};
        for (int a = 0; a < 2; a++)
            for (int b = 0; b < 2; b++) {
                jacobian[a][b] += x[a] * d[b];
                slope[a][b] += v[a] * d[b];
            }
    }
    double det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0], grad[2][2];
    for (int a = 0; a < 2; a++) {
        grad[a][0] = (slope[a][0] * jacobian[1][1] - slope[a][1] * jacobian[1][0]) / det;
        grad[a][1] = (slope[a][1] * jacobian[0][0] - slope[a][0] * jacobian[0][1]) / det;
    }
    double e = steel.youngs_modulus, nu = steel.poisson_ratio;
    out[0] = e / (1 - nu * nu) * (grad[0][0] + nu * grad[1][1]);
    out[1] = e / (1 - nu * nu) * (grad[1][1] + nu * grad[0][0]);
    out[2] = e / (2 * (1 + nu)) * (grad[0][1] + grad[1][0]);
}

/* The element that has the edge, and the natural point in the middle of that edge. */
static const int *element_of_edge(const struct whole_gear *w, const int *edge, double at[2]) {
    static const double middle[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    for (size_t e = 0; e < w->sector->element_count; e++)
        for (int k = 0; k < 4; k++)
            if (w->mesh.element[e][4 + k] == edge[1]) {
                at[0] = middle[k][0];
                at[1] = middle[k][1];
                return w->mesh.element[e];
            }
    fail_msg("no element has node %d on an edge", edge[1]);
    return NULL;
}

/* Under a force at the middle of the flank, the largest principal stress of the elements at the root's surface, computed from
 * the whole tensor, is the stress along the surface, and hardly anything acts across it. */
static void largest_principal_stress_lies_along_the_surface(void **state) {
    (void)state;
    struct cut_gear g = small_gear(9);
    struct qg_sector_mesh sector = sector_of(&g, 2);
    struct whole_gear *w = whole_gear(&sector, 9, false);
    double rotation, most = 0, from_tensor = 0;
    cholmod_dense *u = response_to(w, 2 * (sector.flank_count / 2) + 1, &rotation);
    double *x = u->x;
    for (size_t i = 0; i < u->nrow; i++)
        x[i] = -x[i]; /* pressed, not pulled */
    for (size_t i = 0; i < sector.root_count - 1; i++)
        for (size_t half = 0; half < 2; half++)
            most = fmax(most, fabs(root_stress(w, x, 0, i + half * (sector.root_count - 1))));
    for (size_t k = 0; k + 2 < sector.root_count; k += 2) {
        double at[2] = {0, 0}, t[3];
        const int *element = element_of_edge(w, sector.root[0] + k, at);
        element_stress(w, x, element, at, t);
        double principal = (t[0] + t[1]) / 2 + hypot((t[0] - t[1]) / 2, t[2]);
        double other = (t[0] + t[1]) / 2 - hypot((t[0] - t[1]) / 2, t[2]);
        from_tensor = fmax(from_tensor, principal);
        double along = edge_stress(w, x, 0, sector.root[0] + k, 0);
        assert_near(principal, fmax(along, 0), 0.02 * most);
        assert_near(other, fmin(along, 0), 0.02 * most);
    }
    double largest = 0;
    for (size_t i = 0; i < sector.root_count - 1; i++)
        largest = fmax(largest, root_stress(w, x, 0, i));
    assert_near_share(largest, from_tensor, 0.03);
    cholmod_free_dense(&u, &w->common);
    whole_gear_destroy(w);
    qg_sector_mesh_finish(&sector);
}

/* Equal forces on all teeth turn the gear as a ring: then the bore is evenly loaded and only turns, so a held bore and a torque
 * ring leave the same stresses, but for what varies along the bore within one tooth, which dies away in the rim. */
static void equal_forces_on_all_teeth_do_not_see_how_the_bore_is_held(void **state) {
    (void)state;
    enum { TEETH = 9, REACH = 4 };
    struct cut_gear g = small_gear(TEETH);
    struct qg_sector_mesh sector = sector_of(&g, 1);
    struct qg_compliance c[2];
    double *sum[2], *one, most = 0;
    size_t size = 0;
    for (int k = 0; k < 2; k++) {
        c[k] = compliance_of(&g, &sector, &steel, k == 0 ? QG_SUPPORT_FIXED : QG_SUPPORT_TORQUE_RING);
        size = c[k].root_count * 2 * c[k].flank_count;
        sum[k] = calloc(size, sizeof *sum[k]);
        one = malloc(size * sizeof *one);
        assert_true(sum[k] && one);
        for (int d = -REACH; d <= REACH; d++) {
            assert_int_equal(qg_compliance_stress(&c[k], d, one), QG_OK);
            for (size_t i = 0; i < size; i++)
                sum[k][i] += one[i];
        }
        free(one);
    }
    for (size_t i = 0; i < size; i++)
        most = fmax(most, fabs(sum[0][i]));
    for (size_t i = 0; i < size; i++)
        assert_near(sum[1][i], sum[0][i], 1e-4 * most);
    for (int k = 0; k < 2; k++) {
        free(sum[k]);
        qg_compliance_finish(&c[k]);
    }
    qg_sector_mesh_finish(&sector);
}

/* ---- invariants ------------------------------------------------------------------------------------------------- */

/* Flank components of a few teeth: C_0 symmetric, and the matrix over several teeth positive definite. */
static void check_invariants(const struct cut_gear *g, enum qg_support support) {
    enum { PICKED = 8, TEETH = 3, SIZE = PICKED * TEETH };
    struct qg_sector_mesh sector = sector_of(g, 1);
    struct qg_compliance c = compliance_of(g, &sector, &steel, support);
    size_t n = 2 * c.flank_count, pick[PICKED];
    for (size_t k = 0; k < PICKED; k++)
        pick[k] = k % 2 + 2 * (k / 2 * (c.flank_count - 1) / (PICKED / 2 - 1));
    assert_int_equal(pick[PICKED - 1], n - 1);
    for (size_t i = 0; i < PICKED; i++)
        for (size_t j = 0; j < i; j++)
            assert_near(qg_compliance_entry(&c, 0, pick[i], pick[j]), qg_compliance_entry(&c, 0, pick[j], pick[i]),
                        1e-12 * qg_compliance_entry(&c, 0, pick[0], pick[0]));
    double a[SIZE * SIZE];
    for (size_t i = 0; i < SIZE; i++)
        for (size_t j = 0; j < SIZE; j++)
            a[i * SIZE + j] =
                qg_compliance_entry(&c, (int)(i / PICKED) - (int)(j / PICKED), pick[i % PICKED], pick[j % PICKED]);
    assert_int_equal(LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', SIZE, a, SIZE), 0);
    for (size_t k = 0; k < c.flank_count; k++) {
        assert_near(c.flank_arc[k], sector.flank_arc[k], 0);
        assert_near(c.flank[k].radius, sector.node[sector.flank[k]].radius, 0);
    }
    qg_compliance_finish(&c);
    qg_sector_mesh_finish(&sector);
}

static void compliance_is_symmetric_and_positive(void **state) {
    (void)state;
    struct cut_gear g = small_gear(9);
    struct cut_gear s = {.rack = all_cases[0].pair.rack, .gear = all_cases[0].pair.gears[QG_PINION]};
    assert_int_equal(qg_gear_derive(&s.rack, &s.gear, 7.85e-6, "", &s.geometry, NULL), QG_OK);
    check_invariants(&g, QG_SUPPORT_FIXED);
    check_invariants(&g, QG_SUPPORT_TORQUE_RING);
    check_invariants(&s, QG_SUPPORT_TORQUE_RING);
}

/* A far tooth of a gear with a free bore feels the torque ring's balance only through the body: when a tooth is
 * loaded, the rotation of the bore is the reference, so that a stiff thin ring around it hardly moves. */
static void far_teeth_hardly_move(void **state) {
    (void)state;
    struct cut_gear g = small_gear(12);
    for (int support = QG_SUPPORT_FIXED; support <= QG_SUPPORT_TORQUE_RING; support++) {
        struct qg_sector_mesh sector = sector_of(&g, 1);
        struct qg_compliance c = compliance_of(&g, &sector, &steel, (enum qg_support)support);
        size_t tip = 2 * c.flank_count - 1;
        double own = qg_compliance_entry(&c, 0, tip, tip), next = qg_compliance_entry(&c, 1, tip, tip);
        double far = qg_compliance_entry(&c, 6, tip, tip);
        assert_true(fabs(next) < 0.2 * own);
        assert_true(fabs(far) < fabs(next));
        qg_compliance_finish(&c);
        qg_sector_mesh_finish(&sector);
    }
}

static void compliance_scales_with_modulus_and_width(void **state) {
    (void)state;
    struct cut_gear g = small_gear(9);
    struct qg_sector_mesh sector = sector_of(&g, 1);
    const struct qg_plate other = {2 * 206000, 0.3, 30, 0}, strain = {206000 * (1 - 0.09), 0.3, 10, 1};
    const struct qg_plate stress = {206000, 0.3 / 0.7, 10, 0};
    for (int support = QG_SUPPORT_FIXED; support <= QG_SUPPORT_TORQUE_RING; support++) {
        struct qg_compliance a = compliance_of(&g, &sector, &steel, (enum qg_support)support);
        struct qg_compliance b = compliance_of(&g, &sector, &other, (enum qg_support)support);
        struct qg_compliance c = compliance_of(&g, &sector, &strain, (enum qg_support)support);
        struct qg_compliance d = compliance_of(&g, &sector, &stress, (enum qg_support)support);
        size_t n = 2 * a.flank_count;
        for (int distance = 0; distance <= 3; distance++)
            for (size_t row = 0; row < n; row += 11) {
                double scale = qg_compliance_entry(&a, 0, n / 2 + 1, n / 2 + 1);
                double one = qg_compliance_entry(&a, distance, row, n / 2 + 1);
                assert_near(6 * qg_compliance_entry(&b, distance, row, n / 2 + 1), one, 1e-11 * scale);
                assert_near(qg_compliance_entry(&c, distance, row, n / 2 + 1),
                            qg_compliance_entry(&d, distance, row, n / 2 + 1), 1e-10 * scale);
            }
        qg_compliance_finish(&a);
        qg_compliance_finish(&b);
        qg_compliance_finish(&c);
        qg_compliance_finish(&d);
    }
    qg_sector_mesh_finish(&sector);
}

/* What the tips of the next tooth and of the loaded one move under a force at mid-flank. A force on a single node is the
 * hardest load for a mesh: the own tooth still changes by 0.1 % from refinement 1 to 2, and six times less to 3. */
static void refinement_converges(void **state) {
    (void)state;
    struct cut_gear g = small_gear(9);
    double own[3], next[3];
    for (int r = 1; r <= 3; r++) {
        struct qg_sector_mesh sector = sector_of(&g, r);
        struct qg_compliance c = compliance_of(&g, &sector, &steel, QG_SUPPORT_TORQUE_RING);
        size_t edges = (c.flank_count - 1) / 2 / (size_t)r; /* of refinement 1 */
        size_t middle = 2 * (2 * (edges / 2) * (size_t)r) + 1, tip = 2 * c.flank_count - 1;
        own[r - 1] = qg_compliance_entry(&c, 0, tip, middle);
        next[r - 1] = qg_compliance_entry(&c, 1, tip, middle);
        qg_compliance_finish(&c);
        qg_sector_mesh_finish(&sector);
    }
    assert_near_share(own[0], own[1], 2e-3);
    assert_near_share(next[0], next[1], 1e-3);
    assert_true(fabs(own[1] - own[2]) < fabs(own[0] - own[1]) / 2);
    assert_true(fabs(next[1] - next[2]) < fabs(next[0] - next[1]) / 2);
}

static void finish_accepts_nothing(void **state) {
    (void)state;
    struct qg_compliance c = {0};
    qg_compliance_finish(&c);
    qg_compliance_finish(&c);
    assert_null(c.ring);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fixed_bore_agrees_with_the_whole_gear),
        cmocka_unit_test(torque_ring_agrees_with_the_whole_gear),
        cmocka_unit_test(largest_principal_stress_lies_along_the_surface),
        cmocka_unit_test(equal_forces_on_all_teeth_do_not_see_how_the_bore_is_held),
        cmocka_unit_test(compliance_is_symmetric_and_positive),
        cmocka_unit_test(far_teeth_hardly_move),
        cmocka_unit_test(compliance_scales_with_modulus_and_width),
        cmocka_unit_test(refinement_converges),
        cmocka_unit_test(finish_accepts_nothing),
    };
    qg_numerics_init(1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
