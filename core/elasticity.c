/* Isoparametric eight-node (serendipity) quadrilaterals; any text on finite elements, e.g. Zienkiewicz and Taylor. */
#include "core/elasticity.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Natural coordinates of the nodes. */
static const double node_r[QG_ELEMENT_NODES] = {-1, 1, 1, -1, 0, 1, 0, -1};
static const double node_s[QG_ELEMENT_NODES] = {-1, -1, 1, 1, -1, 0, 1, 0};

/* Derivatives of the shape functions with respect to the natural coordinates. */
static void shape_gradients(double r, double s, double gradient[2][QG_ELEMENT_NODES]) {
    for (int n = 0; n < 4; n++) {
        double a = node_r[n], b = node_s[n];
        gradient[0][n] = 0.25 * a * (1 + b * s) * (2 * a * r + b * s);
        gradient[1][n] = 0.25 * b * (1 + a * r) * (2 * b * s + a * r);
    }
    for (int n = 4; n < 8; n += 2) { /* on the edges s = +-1 */
        gradient[0][n] = -r * (1 + node_s[n] * s);
        gradient[1][n] = 0.5 * node_s[n] * (1 - r * r);
    }
    for (int n = 5; n < 8; n += 2) { /* on the edges r = +-1 */
        gradient[0][n] = 0.5 * node_r[n] * (1 - s * s);
        gradient[1][n] = -s * (1 + node_r[n] * r);
    }
}

/* The three constants of the elasticity matrix: axial, coupling, shear. */
struct moduli {
    double axial, coupling, shear;
};

static struct moduli moduli_of(const struct qg_plate *plate) {
    double e = plate->youngs_modulus, nu = plate->poisson_ratio;
    struct moduli d = {.shear = e / (2 * (1 + nu))};
    double factor = plate->plane_strain ? e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) : e / (1 - nu * nu);
    d.axial = factor;
    d.coupling = factor * (plate->plane_strain ? nu / (1 - nu) : nu);
    return d;
}

/* Gradients in x and y at one natural point; returns the determinant of the mapping. */
static double cartesian_gradients(const double x[QG_ELEMENT_NODES], const double y[QG_ELEMENT_NODES],
                                  const double natural[2], double out[2][QG_ELEMENT_NODES]) {
    double g[2][QG_ELEMENT_NODES], j[2][2] = {{0}};
    shape_gradients(natural[0], natural[1], g);
    for (int n = 0; n < QG_ELEMENT_NODES; n++)
        for (int k = 0; k < 2; k++) {
            j[k][0] += g[k][n] * x[n];
            j[k][1] += g[k][n] * y[n];
        }
    double determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        out[0][n] = (j[1][1] * g[0][n] - j[0][1] * g[1][n]) / determinant;
        out[1][n] = (j[0][0] * g[1][n] - j[1][0] * g[0][n]) / determinant;
    }
    return determinant;
}

/* Adds weight * B' D B of one Gauss point, in x and y components. */
static void add_point(const double g[2][QG_ELEMENT_NODES], const struct moduli *d, double weight,
                      double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS]) {
    for (int a = 0; a < QG_ELEMENT_NODES; a++)
        for (int b = 0; b < QG_ELEMENT_NODES; b++) {
            double xx = g[0][a] * g[0][b], yy = g[1][a] * g[1][b], xy = g[0][a] * g[1][b], yx = g[1][a] * g[0][b];
            k[2 * a][2 * b] += weight * (d->axial * xx + d->shear * yy);
            k[2 * a][2 * b + 1] += weight * (d->coupling * xy + d->shear * yx);
            k[2 * a + 1][2 * b] += weight * (d->coupling * yx + d->shear * xy);
            k[2 * a + 1][2 * b + 1] += weight * (d->axial * yy + d->shear * xx);
        }
}

/* Turns rows and columns from x, y into radial, tangential at each node. */
static void to_polar_components(const struct qg_polar node[QG_ELEMENT_NODES],
                                double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS]) {
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        double c = cos(node[n].angle), s = sin(node[n].angle);
        for (int j = 0; j < QG_ELEMENT_FREEDOMS; j++) {
            double x = k[2 * n][j], y = k[2 * n + 1][j];
            k[2 * n][j] = c * x + s * y;
            k[2 * n + 1][j] = c * y - s * x;
        }
        for (int i = 0; i < QG_ELEMENT_FREEDOMS; i++) {
            double x = k[i][2 * n], y = k[i][2 * n + 1];
            k[i][2 * n] = c * x + s * y;
            k[i][2 * n + 1] = c * y - s * x;
        }
    }
}

int qg_element_stiffness(const struct qg_polar node[QG_ELEMENT_NODES], const struct qg_plate *plate,
                         double out[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS]) {
    static const double at[3] = {-0.77459666924148337704, 0, 0.77459666924148337704};
    static const double weight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    double x[QG_ELEMENT_NODES], y[QG_ELEMENT_NODES], gradient[2][QG_ELEMENT_NODES];
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        x[n] = node[n].radius * cos(node[n].angle);
        y[n] = node[n].radius * sin(node[n].angle);
    }
    struct moduli d = moduli_of(plate);
    memset(out, 0, sizeof(double) * QG_ELEMENT_FREEDOMS * QG_ELEMENT_FREEDOMS);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double determinant = cartesian_gradients(x, y, (const double[]){at[i], at[j]}, gradient);
            if (!(determinant > 0))
                return -1;
            add_point((const double(*)[QG_ELEMENT_NODES])gradient, &d,
                      weight[i] * weight[j] * determinant * plate->thickness, out);
        }
    to_polar_components(node, out);
    return 0;
}

/* Adds one element's upper-triangle entries. */
static void scatter(cholmod_triplet *t, const int nodes[QG_ELEMENT_NODES], const int *freedom,
                    double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS]) {
    int *row = t->i, *column = t->j;
    double *value = t->x;
    for (int a = 0; a < QG_ELEMENT_FREEDOMS; a++)
        for (int b = 0; b < QG_ELEMENT_FREEDOMS; b++) {
            int i = freedom[2 * nodes[a / 2] + a % 2], j = freedom[2 * nodes[b / 2] + b % 2];
            if (i < 0 || j < 0 || i > j)
                continue;
            row[t->nnz] = i;
            column[t->nnz] = j;
            value[t->nnz++] = k[a][b];
        }
}

cholmod_sparse *qg_assemble(const struct qg_sector_mesh *mesh, const struct qg_plate *plate, const int *freedom,
                            size_t count, cholmod_common *common) {
    size_t room = mesh->element_count * (QG_ELEMENT_FREEDOMS * (QG_ELEMENT_FREEDOMS + 1) / 2);
    cholmod_triplet *t = cholmod_allocate_triplet(count, count, room, 1, CHOLMOD_REAL, common);
    if (!t)
        return NULL;
    bool degenerate = false;
    for (size_t e = 0; e < mesh->element_count && !degenerate; e++) {
        struct qg_polar node[QG_ELEMENT_NODES];
        double k[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS];
        for (int n = 0; n < QG_ELEMENT_NODES; n++)
            node[n] = mesh->node[mesh->element[e][n]];
        degenerate = qg_element_stiffness((const struct qg_polar *)node, plate, k) != 0;
        scatter(t, mesh->element[e], freedom, k);
    }
    cholmod_sparse *matrix = degenerate ? NULL : cholmod_triplet_to_sparse(t, room, common);
    cholmod_free_triplet(&t, common);
    return matrix;
}

cholmod_dense *qg_factor_solve(int system, cholmod_factor *factor, cholmod_dense *b, cholmod_common *common) {
    cholmod_dense *x = NULL, *e = NULL;
    cholmod_dense *y = cholmod_allocate_dense(b->nrow, b->ncol, b->nrow, CHOLMOD_REAL, common);
    if (y)
        cholmod_solve2(system, factor, b, NULL, &x, NULL, &y, &e, common);
    if (common->status < CHOLMOD_OK)
        cholmod_free_dense(&x, common);
    cholmod_free_dense(&y, common);
    cholmod_free_dense(&e, common);
    return x;
}

struct qg_edge_stress qg_edge_stress(const struct qg_polar node[3], const struct qg_plate *plate, double z) {
    const double shape[3] = {z * (z - 1) / 2, 1 - z * z, z * (z + 1) / 2}, slope[3] = {z - 0.5, -2 * z, z + 0.5};
    double nu = plate->poisson_ratio;
    double modulus = plate->youngs_modulus / (plate->plane_strain ? 1 - nu * nu : 1);
    double at[2] = {0, 0}, along[2] = {0, 0};
    for (int n = 0; n < 3; n++) {
        double x = node[n].radius * cos(node[n].angle), y = node[n].radius * sin(node[n].angle);
        at[0] += shape[n] * x;
        at[1] += shape[n] * y;
        along[0] += slope[n] * x;
        along[1] += slope[n] * y;
    }
    struct qg_edge_stress out = {.at = {hypot(at[0], at[1]), atan2(at[1], at[0])}};
    double factor = modulus / (along[0] * along[0] + along[1] * along[1]);
    for (int n = 0; n < 3; n++) {
        double c = cos(node[n].angle), s = sin(node[n].angle);
        out.weight[2 * n] = factor * slope[n] * (along[0] * c + along[1] * s);
        out.weight[2 * n + 1] = factor * slope[n] * (along[1] * c - along[0] * s);
    }
    return out;
}

/* ---- stress ----------------------------------------------------------------------------------------------------- */

static struct qg_plane_stress stress_at(const double x[QG_ELEMENT_NODES], const double y[QG_ELEMENT_NODES],
                                        const double u[QG_ELEMENT_FREEDOMS], const struct moduli *d,
                                        const double natural[2]) {
    double g[2][QG_ELEMENT_NODES], xx = 0, yy = 0, xy = 0;
    cartesian_gradients(x, y, natural, g);
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        xx += g[0][n] * u[2 * n];
        yy += g[1][n] * u[2 * n + 1];
        xy += g[1][n] * u[2 * n] + g[0][n] * u[2 * n + 1];
    }
    return (struct qg_plane_stress){d->axial * xx + d->coupling * yy, d->coupling * xx + d->axial * yy, d->shear * xy};
}

void qg_element_stress(const struct qg_polar node[QG_ELEMENT_NODES], const struct qg_plate *plate,
                       const double displacement[QG_ELEMENT_FREEDOMS], struct qg_plane_stress out[QG_ELEMENT_NODES]) {
    static const double gauss = 0.57735026918962576451; /* 1 / sqrt(3) */
    double x[QG_ELEMENT_NODES], y[QG_ELEMENT_NODES], u[QG_ELEMENT_FREEDOMS];
    struct qg_plane_stress at[4];
    struct moduli d = moduli_of(plate);
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        double c = cos(node[n].angle), s = sin(node[n].angle);
        x[n] = node[n].radius * c;
        y[n] = node[n].radius * s;
        u[2 * n] = c * displacement[2 * n] - s * displacement[2 * n + 1];
        u[2 * n + 1] = s * displacement[2 * n] + c * displacement[2 * n + 1];
    }
    for (int k = 0; k < 4; k++)
        at[k] = stress_at(x, y, u, &d, (const double[]){gauss * node_r[k], gauss * node_s[k]});
    for (int n = 0; n < QG_ELEMENT_NODES; n++) {
        out[n] = (struct qg_plane_stress){0};
        for (int k = 0; k < 4; k++) {
            double w = 0.25 * (1 + node_r[k] * node_r[n] / gauss) * (1 + node_s[k] * node_s[n] / gauss);
            out[n].xx += w * at[k].xx;
            out[n].yy += w * at[k].yy;
            out[n].xy += w * at[k].xy;
        }
    }
}

double qg_von_mises(const struct qg_plane_stress *s, const struct qg_plate *plate) {
    double zz = plate->plane_strain ? plate->poisson_ratio * (s->xx + s->yy) : 0;
    double a = s->xx - s->yy, b = s->yy - zz, c = zz - s->xx;
    return sqrt((a * a + b * b + c * c) / 2 + 3 * s->xy * s->xy);
}

double qg_max_principal(const struct qg_plane_stress *s) {
    return (s->xx + s->yy) / 2 + hypot((s->xx - s->yy) / 2, s->xy);
}
