/* Elements and assembly: patch test, rigid motions, moduli, and rings with closed solutions. */
#include "tests/core/cases.h"

#include <lapacke.h>
#include <stdlib.h>

#include "core/elasticity.h"

typedef double element_matrix[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS];

static const struct qg_plate steel = {206000, 0.3, 22.5, 0};

struct plane {
    double x, y;
};

static struct plane to_plane(struct qg_polar p) {
    return (struct plane){p.radius * cos(p.angle), p.radius * sin(p.angle)};
}

static struct qg_polar to_polar(struct plane p) {
    return (struct qg_polar){hypot(p.x, p.y), atan2(p.y, p.x)};
}

/* A quadrilateral somewhere off the axis, its corners and midsides moved at random: no side is straight. */
static void distorted_element(struct dice *dice, struct qg_polar node[QG_ELEMENT_NODES]) {
    static const double at[QG_ELEMENT_NODES][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1},
                                                   {0, -1},  {1, 0},  {0, 1}, {-1, 0}};
    double turned = dice_between(dice, 0, 6.28), stretch = dice_between(dice, 0.3, 3);
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        double x = stretch * (at[n][0] + dice_between(dice, -0.12, 0.12)),
               y = at[n][1] + dice_between(dice, -0.12, 0.12);
        node[n] =
            to_polar((struct plane){10 + x * cos(turned) - y * sin(turned), 4 + x * sin(turned) + y * cos(turned)});
    }
}

/* Area within parabolic sides; see test_mesh.c. */
static double element_area(const struct qg_polar node[QG_ELEMENT_NODES]) {
    double area = 0;
    for (int k = 0; k < 4; k++) {
        struct plane a = to_plane(node[k]), b = to_plane(node[4 + k]), c = to_plane(node[(k + 1) % 4]);
        double bx = b.x - (a.x + c.x) / 2, by = b.y - (a.y + c.y) / 2;
        area += (a.x * c.y - a.y * c.x) / 2 - 2 * ((c.x - a.x) * by - (c.y - a.y) * bx) / 3;
    }
    return area;
}

/* u = displacement gradient times position, plus a shift; as radial and tangential components at a node. */
struct linear_field {
    double gradient[2][2], shift[2];
};

static void field_at(const struct linear_field *f, struct qg_polar node, double out[2]) {
    struct plane p = to_plane(node);
    double x = f->gradient[0][0] * p.x + f->gradient[0][1] * p.y + f->shift[0];
    double y = f->gradient[1][0] * p.x + f->gradient[1][1] * p.y + f->shift[1];
    out[0] = x * cos(node.angle) + y * sin(node.angle);
    out[1] = y * cos(node.angle) - x * sin(node.angle);
}

/* Hooke's law written with E and nu in the plane-stress form; plane strain by the equivalent constants. */
static double energy_density(const struct linear_field *f, const struct qg_plate *plate) {
    double e = plate->youngs_modulus, nu = plate->poisson_ratio;
    if (plate->plane_strain) {
        e /= 1 - nu * nu;
        nu /= 1 - nu;
    }
    double xx = f->gradient[0][0], yy = f->gradient[1][1], shear = f->gradient[0][1] + f->gradient[1][0];
    return e / (1 - nu * nu) * (xx * xx + yy * yy + 2 * nu * xx * yy) / 2 + e / (2 * (1 + nu)) * shear * shear / 2;
}

static const struct linear_field constant_strains[3] = {
    {{{1e-3, 0}, {0, 0}}, {0.1, 0.2}},
    {{{0, 0}, {0, 1e-3}}, {-0.1, 0}},
    {{{0, 1e-3}, {0, 0}}, {0, 0.3}},
};

/* ---- one element ------------------------------------------------------------------------------------------------ */

static void stiffness_is_symmetric_with_three_rigid_motions(void **state) {
    (void)state;
    struct dice dice = {41};
    for (int i = 0; i < 200; i++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        element_matrix k;
        double value[QG_ELEMENT_FREEDOMS];
        distorted_element(&dice, node);
        assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), 0);
        for (int a = 0; a < QG_ELEMENT_FREEDOMS; a++)
            for (int b = 0; b < a; b++)
                assert_near(k[a][b], k[b][a], 1e-9 * steel.youngs_modulus);
        assert_int_equal(
            LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', QG_ELEMENT_FREEDOMS, &k[0][0], QG_ELEMENT_FREEDOMS, value), 0);
        for (int n = 0; n < 3; n++)
            assert_near(value[n], 0, 1e-11 * value[QG_ELEMENT_FREEDOMS - 1]);
        assert_true(value[3] > 1e-4 * value[QG_ELEMENT_FREEDOMS - 1]); /* no more than three */
    }
}

static void rigid_motions_need_no_force(void **state) {
    (void)state;
    static const struct linear_field motions[3] = {
        {{{0, 0}, {0, 0}}, {1, 0}}, {{{0, 0}, {0, 0}}, {0, 1}}, {{{0, -1}, {1, 0}}, {0, 0}}};
    struct dice dice = {42};
    for (int i = 0; i < 100; i++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        element_matrix k;
        distorted_element(&dice, node);
        assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), 0);
        for (int m = 0; m < 3; m++) {
            double u[QG_ELEMENT_FREEDOMS];
            for (int n = 0; n < QG_ELEMENT_NODES; n++)
                field_at(&motions[m], node[n], u + 2 * n);
            for (int a = 0; a < QG_ELEMENT_FREEDOMS; a++) {
                double force = 0, size = 0;
                for (int b = 0; b < QG_ELEMENT_FREEDOMS; b++) {
                    force += k[a][b] * u[b];
                    size += fabs(k[a][b] * u[b]);
                }
                assert_near(force, 0, 1e-12 * size);
            }
        }
    }
}

static void constant_strain_has_its_energy(void **state) {
    (void)state;
    struct dice dice = {43};
    for (int i = 0; i < 200; i++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        element_matrix k;
        struct qg_plate plate = steel;
        plate.plane_strain = i % 2;
        distorted_element(&dice, node);
        assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &plate, k), 0);
        double volume = element_area((const struct qg_polar *)node) * plate.thickness;
        for (int s = 0; s < 3; s++) {
            double u[QG_ELEMENT_FREEDOMS], energy = 0;
            for (int n = 0; n < QG_ELEMENT_NODES; n++)
                field_at(&constant_strains[s], node[n], u + 2 * n);
            for (int a = 0; a < QG_ELEMENT_FREEDOMS; a++)
                for (int b = 0; b < QG_ELEMENT_FREEDOMS; b++)
                    energy += u[a] * k[a][b] * u[b] / 2;
            assert_near_share(energy, volume * energy_density(&constant_strains[s], &plate), 1e-9);
        }
    }
}

static void plane_strain_is_plane_stress_of_other_constants(void **state) {
    (void)state;
    struct dice dice = {44};
    struct qg_polar node[QG_ELEMENT_NODES];
    element_matrix strain, stress, thick;
    distorted_element(&dice, node);
    const struct qg_plate a = {206000, 0.3, 10, 1}, b = {206000 / (1 - 0.09), 0.3 / 0.7, 10, 0};
    const struct qg_plate c = {2 * 206000, 0.3, 30, 1};
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &a, strain), 0);
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &b, stress), 0);
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &c, thick), 0);
    for (int i = 0; i < QG_ELEMENT_FREEDOMS; i++)
        for (int j = 0; j < QG_ELEMENT_FREEDOMS; j++) {
            assert_near(strain[i][j], stress[i][j], 1e-6);
            assert_near(thick[i][j], 6 * strain[i][j], 1e-5);
        }
}

static void turned_elements_are_refused(void **state) {
    (void)state;
    static const struct plane square[QG_ELEMENT_NODES] = {{10, 0}, {12, 0}, {12, 2}, {10, 2},
                                                          {11, 0}, {12, 1}, {11, 2}, {10, 1}};
    static const int clockwise[QG_ELEMENT_NODES] = {3, 2, 1, 0, 6, 5, 4, 7};
    struct qg_polar node[QG_ELEMENT_NODES];
    element_matrix k;
    for (int n = 0; n < QG_ELEMENT_NODES; n++)
        node[n] = to_polar(square[n]);
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), 0);
    node[2] = to_polar((struct plane){10.2, 0.2}); /* a corner pushed through the diagonal */
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), -1);
    for (int n = 0; n < QG_ELEMENT_NODES; n++)
        node[n] = to_polar(square[clockwise[n]]);
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), -1);
    for (int n = 0; n < QG_ELEMENT_NODES; n++)
        node[n] = to_polar(square[0]); /* a point */
    assert_int_equal(qg_element_stiffness((const struct qg_polar *)node, &steel, k), -1);
}

/* ---- patch of a whole sector ------------------------------------------------------------------------------------ */

/* A gear's sector under constant strain: curved sides, every shape of element. Inner nodes must be free of force,
 * and the work of the boundary is the energy. */
static void patch_test_on_a_tooth_sector(void **state) {
    (void)state;
    struct qg_gear_pair pair = CASE_S;
    struct qg_gear_geometry geometry;
    struct qg_sector_mesh mesh;
    assert_int_equal(qg_gear_derive(&pair.rack, &pair.gears[0], 7.85e-6, "", &geometry, NULL), QG_OK);
    assert_int_equal(qg_sector_mesh_init(&mesh, &pair.rack, &pair.gears[0], &geometry, 1, NULL), QG_OK);
    size_t n = 2 * mesh.node_count;
    int *freedom = malloc(n * sizeof *freedom);
    unsigned char *outside = calloc(mesh.node_count, 1);
    assert_true(freedom && outside);
    for (size_t i = 0; i < n; i++)
        freedom[i] = (int)i;
    double area = 0;
    int *shared = calloc(mesh.node_count, sizeof *shared); /* midsides of inner edges belong to two elements */
    assert_non_null(shared);
    for (size_t e = 0; e < mesh.element_count; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        for (int k = 0; k < QG_ELEMENT_NODES; k++)
            node[k] = mesh.node[mesh.element[e][k]];
        area += element_area((const struct qg_polar *)node);
        for (int k = 4; k < 8; k++)
            shared[mesh.element[e][k]]++;
    }
    for (size_t e = 0; e < mesh.element_count; e++)
        for (int k = 0; k < 4; k++)
            if (shared[mesh.element[e][4 + k]] == 1)
                outside[mesh.element[e][k]] = outside[mesh.element[e][(k + 1) % 4]] = outside[mesh.element[e][4 + k]] =
                    1;
    cholmod_common common;
    cholmod_start(&common);
    cholmod_sparse *k = qg_assemble(&mesh, &steel, freedom, n, &common);
    assert_non_null(k);
    cholmod_dense *u = cholmod_zeros(n, 1, CHOLMOD_REAL, &common), *f = cholmod_zeros(n, 1, CHOLMOD_REAL, &common);
    for (int s = 0; s < 3; s++) {
        double one[2] = {1, 0}, zero[2] = {0, 0}, energy = 0, *x = u->x, *y = f->x;
        for (size_t i = 0; i < mesh.node_count; i++)
            field_at(&constant_strains[s], mesh.node[i], x + 2 * i);
        cholmod_sdmult(k, 0, one, zero, u, f, &common);
        for (size_t i = 0; i < n; i++) {
            energy += x[i] * y[i] / 2;
            if (!outside[i / 2]) /* forces of a boundary edge are of the order stress x length x thickness = 1000 N */
                assert_near(y[i], 0, 1e-6);
        }
        assert_near_share(energy, area * steel.thickness * energy_density(&constant_strains[s], &steel), 1e-8);
    }
    cholmod_free_dense(&u, &common);
    cholmod_free_dense(&f, &common);
    cholmod_free_sparse(&k, &common);
    cholmod_finish(&common);
    free(freedom);
    free(outside);
    free(shared);
    qg_sector_mesh_finish(&mesh);
}

/* ---- rings ------------------------------------------------------------------------------------------------------ */

/* A sector of a ring: rows x columns elements between two radii. */
struct ring_mesh {
    struct qg_sector_mesh mesh;
    int rows, columns;
    double inner, outer, angle;
    int *id; /* lattice of (2 rows + 1) x (2 columns + 1) */
};

static int lattice(const struct ring_mesh *r, int i, int j) {
    return r->id[i * (2 * r->columns + 1) + j];
}

static struct ring_mesh ring_mesh(int rows, int columns) {
    struct ring_mesh r = {.rows = rows, .columns = columns, .inner = 20, .outer = 50, .angle = M_PI / 6};
    static const int at[QG_ELEMENT_NODES][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}};
    int points = (2 * rows + 1) * (2 * columns + 1);
    r.id = malloc((size_t)points * sizeof *r.id);
    r.mesh.node = malloc((size_t)points * sizeof *r.mesh.node);
    r.mesh.element = malloc((size_t)(rows * columns) * sizeof *r.mesh.element);
    assert_true(r.id && r.mesh.node && r.mesh.element);
    for (int i = 0; i <= 2 * rows; i++)
        for (int j = 0; j <= 2 * columns; j++) {
            if (i % 2 && j % 2)
                continue;
            r.mesh.node[r.mesh.node_count] =
                (struct qg_polar){r.inner + (r.outer - r.inner) * i / (2 * rows), r.angle * j / (2 * columns)};
            r.id[i * (2 * columns + 1) + j] = (int)r.mesh.node_count++;
        }
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            int *element = r.mesh.element[r.mesh.element_count++];
            for (int n = 0; n < QG_ELEMENT_NODES; n++)
                element[n] = lattice(&r, 2 * i + at[n][0], 2 * j + at[n][1]);
        }
    return r;
}

static void ring_mesh_finish(struct ring_mesh *r) {
    free(r->id);
    free(r->mesh.node);
    free(r->mesh.element);
}

/* Rows for all unknowns but those of the inner circle when it is held; both sides share theirs, which makes the
 * sector a ring. */
static int number_ring(const struct ring_mesh *r, bool hold_inner, int *freedom) {
    int count = 0;
    for (int i = 0; i <= 2 * r->rows; i++)
        for (int j = 0; j <= 2 * r->columns; j++)
            for (int c = 0; c < 2; c++) {
                if (i % 2 && j % 2)
                    continue;
                int *row = &freedom[2 * lattice(r, i, j) + c];
                if (i == 0 && hold_inner)
                    *row = -1;
                else
                    *row = j == 2 * r->columns ? freedom[2 * lattice(r, i, 0) + c] : count++;
            }
    return count;
}

/* Unit traction on a circle of the lattice in one component: consistent loads of the parabolic edges. */
static void load_circle(const struct ring_mesh *r, int i, int component, const int *freedom, double traction,
                        double *force) {
    static const double share[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
    double radius = r->mesh.node[lattice(r, i, 0)].radius, length = radius * r->angle / r->columns;
    for (int j = 0; j < r->columns; j++)
        for (int k = 0; k < 3; k++)
            force[freedom[2 * lattice(r, i, 2 * j + k) + component]] += traction * steel.thickness * length * share[k];
}

/* Solves K u = force, u overwriting force. Where the ring may turn freely, one tangential row is held. */
static void solve(const struct ring_mesh *r, const int *freedom, int count, int held, double *force) {
    cholmod_common common;
    cholmod_start(&common);
    cholmod_sparse *k = qg_assemble(&r->mesh, &steel, freedom, (size_t)count, &common);
    assert_non_null(k);
    const int *start = k->p, *row = k->i;
    double *value = k->x;
    for (int j = 0; j < count; j++)
        for (int at = start[j]; at < start[j + 1]; at++)
            if (row[at] == held && j == held)
                value[at] *= 1e8;
    cholmod_dense *b = cholmod_zeros((size_t)count, 1, CHOLMOD_REAL, &common);
    memcpy(b->x, force, (size_t)count * sizeof *force);
    cholmod_factor *factor = cholmod_analyze(k, &common);
    assert_true(cholmod_factorize(k, factor, &common) && common.status == CHOLMOD_OK);
    cholmod_dense *u = cholmod_solve(CHOLMOD_A, factor, b, &common);
    memcpy(force, u->x, (size_t)count * sizeof *force);
    cholmod_free_dense(&u, &common);
    cholmod_free_dense(&b, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&k, &common);
    cholmod_finish(&common);
}

/* Largest error of the radial displacement of a ring under inner pressure, relative to the largest displacement.
 * Lame, plane stress: u = p a^2 / (E (b^2 - a^2)) ((1 - nu) r + (1 + nu) b^2 / r). */
static double lame_error(int rows, int columns) {
    struct ring_mesh r = ring_mesh(rows, columns);
    int *freedom = malloc(2 * r.mesh.node_count * sizeof *freedom);
    double *u = calloc(2 * r.mesh.node_count, sizeof *u), worst = 0, largest = 0;
    const double pressure = 100, a = r.inner, b = r.outer, e = steel.youngs_modulus, nu = steel.poisson_ratio;
    int count = number_ring(&r, false, freedom);
    load_circle(&r, 0, 0, freedom, pressure, u);
    solve(&r, freedom, count, freedom[2 * lattice(&r, 0, 0) + 1], u);
    for (size_t n = 0; n < r.mesh.node_count; n++) {
        double at = r.mesh.node[n].radius;
        double exact = pressure * a * a / (e * (b * b - a * a)) * ((1 - nu) * at + (1 + nu) * b * b / at);
        worst = fmax(worst, fmax(fabs(u[freedom[2 * n]] - exact), fabs(u[freedom[2 * n + 1]])));
        largest = fmax(largest, exact);
    }
    ring_mesh_finish(&r);
    free(freedom);
    free(u);
    return worst / largest;
}

static void ring_under_pressure_follows_lame(void **state) {
    (void)state;
    double coarse = lame_error(4, 2), fine = lame_error(8, 4);
    assert_true(coarse < 1e-3);
    assert_true(fine < coarse / 8);
}

/* A ring held at its inner circle and sheared at the outer: u_t = M r / (4 pi G t) (1/a^2 - 1/r^2). */
static double torsion_error(int rows, int columns) {
    struct ring_mesh r = ring_mesh(rows, columns);
    int *freedom = malloc(2 * r.mesh.node_count * sizeof *freedom);
    double *u = calloc(2 * r.mesh.node_count, sizeof *u), worst = 0, largest = 0;
    const double traction = 50, a = r.inner, b = r.outer;
    double shear = steel.youngs_modulus / (2 * (1 + steel.poisson_ratio)), moment = traction * 2 * M_PI * b * b;
    int count = number_ring(&r, true, freedom);
    load_circle(&r, 2 * rows, 1, freedom, traction, u);
    solve(&r, freedom, count, -1, u);
    for (size_t n = 0; n < r.mesh.node_count; n++) {
        double at = r.mesh.node[n].radius, exact = moment * at / (4 * M_PI * shear) * (1 / (a * a) - 1 / (at * at));
        double got = freedom[2 * n + 1] < 0 ? 0 : u[freedom[2 * n + 1]];
        worst = fmax(worst, fabs(got - exact));
        largest = fmax(largest, exact);
    }
    ring_mesh_finish(&r);
    free(freedom);
    free(u);
    return worst / largest;
}

static void twisted_ring_follows_its_closed_form(void **state) {
    (void)state;
    double coarse = torsion_error(4, 2), fine = torsion_error(8, 4);
    assert_true(coarse < 2e-3);
    assert_true(fine < coarse / 6);
}

/* ---- stress along free edges -------------------------------------------------------------------------------------- */

/* An edge bent and turned anyhow: of a displacement that is linear in x and y, the stretch along it is exact. */
static void edge_stress_of_a_constant_strain_is_exact(void **state) {
    (void)state;
    const struct qg_polar edge[3] = {{30, 0.1}, {30.6, 0.13}, {31.4, 0.15}};
    const struct qg_plate strain = {206000, 0.3, 10, 1};
    for (int s = 0; s < 3; s++)
        for (double z = -1; z <= 1; z += 0.5) {
            struct qg_edge_stress e = qg_edge_stress(edge, &steel, z), f = qg_edge_stress(edge, &strain, z);
            double u[2], got = 0, got_strain = 0, at[3][2], along[2];
            for (int n = 0; n < 3; n++) {
                field_at(&constant_strains[s], edge[n], u);
                for (int c = 0; c < 2; c++) {
                    got += e.weight[2 * n + c] * u[c];
                    got_strain += f.weight[2 * n + c] * u[c];
                }
                at[n][0] = edge[n].radius * cos(edge[n].angle);
                at[n][1] = edge[n].radius * sin(edge[n].angle);
            }
            for (int c = 0; c < 2; c++)
                along[c] = (z - 0.5) * at[0][c] - 2 * z * at[1][c] + (z + 0.5) * at[2][c];
            const double(*g)[2] = constant_strains[s].gradient;
            double square = along[0] * along[0] + along[1] * along[1];
            double stretch = (g[0][0] * along[0] * along[0] + g[1][1] * along[1] * along[1] +
                              (g[0][1] + g[1][0]) * along[0] * along[1]) /
                             square;
            assert_near(got, steel.youngs_modulus * stretch, 1e-6);
            assert_near(got_strain, got / (1 - 0.09), 1e-6);
        }
}

/* Bending of a curved bar by end moments (Golovin): hoop stress per moment and thickness at radius r. */
static double golovin(double a, double b, double r) {
    double k = log(b / a), n = pow(b * b - a * a, 2) - 4 * a * a * b * b * k * k;
    return -4 / n * (-a * a * b * b / (r * r) * k + b * b * log(r / b) + a * a * log(a / r) + b * b - a * a);
}

/* Free side of a curved bar: consistent forces of Golovin's stresses on the elements' edges there. */
static void load_side(const struct ring_mesh *r, const int *freedom, double *force) {
    static const double z[3] = {-0.77459666924148337704, 0, 0.77459666924148337704};
    static const double weight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    double height = (r->outer - r->inner) / r->rows;
    for (int i = 0; i < r->rows; i++)
        for (int k = 0; k < 3; k++) {
            const double shape[3] = {z[k] * (z[k] - 1) / 2, 1 - z[k] * z[k], z[k] * (z[k] + 1) / 2};
            double at = r->inner + (i + (1 + z[k]) / 2) * height;
            double load = golovin(r->inner, r->outer, at) * steel.thickness * weight[k] * height / 2;
            for (int n = 0; n < 3; n++)
                force[freedom[2 * lattice(r, 2 * i + n, 2 * r->columns) + 1]] += load * shape[n];
        }
}

/* Largest error of the stress along both free surfaces of a curved bar in bending, relative to the largest stress; the side at
 * angle 0 is a plane of symmetry. */
static double golovin_error(int rows, int columns) {
    struct ring_mesh r = ring_mesh(rows, columns);
    int *freedom = malloc(2 * r.mesh.node_count * sizeof *freedom), count = 0;
    double *u = calloc(2 * r.mesh.node_count, sizeof *u), worst = 0;
    assert_true(freedom && u);
    for (size_t k = 0; k < 2 * r.mesh.node_count; k++)
        freedom[k] = 0;
    for (int i = 0; i <= 2 * rows; i++)
        freedom[2 * lattice(&r, i, 0) + 1] = -1;
    freedom[2 * lattice(&r, 0, 0)] = -1;
    for (size_t k = 0; k < 2 * r.mesh.node_count; k++)
        freedom[k] = freedom[k] < 0 ? -1 : count++;
    load_side(&r, freedom, u);
    solve(&r, freedom, count, -1, u);
    for (int i = 0; i <= 2 * rows; i += 2 * rows)
        for (int j = 0; j < columns; j++) {
            struct qg_polar edge[3];
            double got = 0;
            for (int n = 0; n < 3; n++)
                edge[n] = r.mesh.node[lattice(&r, i, 2 * j + n)];
            struct qg_edge_stress e = qg_edge_stress((const struct qg_polar *)edge, &steel, 0);
            for (int k = 0; k < 6; k++) {
                int f = freedom[2 * lattice(&r, i, 2 * j + k / 2) + k % 2];
                got += f < 0 ? 0 : e.weight[k] * u[f];
            }
            worst = fmax(worst, fabs(got - golovin(r.inner, r.outer, edge[0].radius)));
        }
    double largest = fabs(golovin(r.inner, r.outer, r.inner));
    ring_mesh_finish(&r);
    free(freedom);
    free(u);
    return worst / largest;
}

static void bent_bar_has_the_surface_stress_of_its_closed_form(void **state) {
    (void)state;
    double coarse = golovin_error(6, 4), fine = golovin_error(12, 8);
    assert_true(coarse < 2e-2);
    assert_true(fine < coarse / 3);
}

static void degenerate_meshes_are_not_assembled(void **state) {
    (void)state;
    struct ring_mesh r = ring_mesh(2, 2);
    int *freedom = malloc(2 * r.mesh.node_count * sizeof *freedom);
    int count = number_ring(&r, false, freedom);
    cholmod_common common;
    cholmod_start(&common);
    int t = r.mesh.element[3][0];
    r.mesh.element[3][0] = r.mesh.element[3][2];
    r.mesh.element[3][2] = t;
    assert_null(qg_assemble(&r.mesh, &steel, freedom, (size_t)count, &common));
    cholmod_finish(&common);
    ring_mesh_finish(&r);
    free(freedom);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stiffness_is_symmetric_with_three_rigid_motions),
        cmocka_unit_test(rigid_motions_need_no_force),
        cmocka_unit_test(constant_strain_has_its_energy),
        cmocka_unit_test(plane_strain_is_plane_stress_of_other_constants),
        cmocka_unit_test(turned_elements_are_refused),
        cmocka_unit_test(patch_test_on_a_tooth_sector),
        cmocka_unit_test(ring_under_pressure_follows_lame),
        cmocka_unit_test(twisted_ring_follows_its_closed_form),
        cmocka_unit_test(edge_stress_of_a_constant_strain_is_exact),
        cmocka_unit_test(bent_bar_has_the_surface_stress_of_its_closed_form),
        cmocka_unit_test(degenerate_meshes_are_not_assembled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
