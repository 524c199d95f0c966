/* Condensation of a tooth sector, and the ring of sectors.
 *
 * 1. Condensation. Unknowns are ordered interior first, retained (flank, sides, bore) last; a sparse Cholesky factor then
 *    holds in its last diagonal block the Cholesky factor of the Schur complement S of the retained unknowns, so one
 *    factorization condenses the sector without a single solve. A sector whose sides are free may float; a diagonal D is
 *    therefore added to its boundary unknowns before, and taken off S afterwards.
 * 2. The flank is eliminated too: local = S_ff^-1, response W = S_ff^-1 S_fb, boundary stiffness S_bb - S_bf W. A force f on
 *    the flank acts on the boundary as -W' f, and u_f = local f - W u_b.
 *    A stress row b over the sector's unknowns (interior part b_i, retained part b_r) becomes b_r - b_i K_ii^-1 K_ir over the
 *    retained ones. The factor has it ready: with y = L^-1 (b_i; 0), L_rr y_r = - K_ri K_ii^-1 b_i', one forward solve.
 *    Flank eliminated: rows stress_local = b_f local, stress_boundary = b_b - b_f W.
 * 3. Ring. Displacements are polar, so the plus side of sector j and the minus side of sector j + 1 are the same numbers.
 *    For the circumferential order n, u_plus = u_minus e^(i omega), omega = 2 pi n / z, which leaves a Hermitian matrix of the
 *    size of one side (and bore) per order; ring_d = 1/z sum_n T K_n^-1 T^H e^(i omega d). Orders n and z - n are conjugate.
 * 4. Torque ring. Order 0 may rotate freely. With w the weights of the mean tangential displacement of the bore and r the
 *    rigid rotation, a load p is balanced by the uniform traction: p - w (r'p)/(r'w) = P p, and the solution with w'u = 0 is
 *    (K_0 + c w w')^-1 P p for any c > 0; its symmetric form is P' (K_0 + c w w')^-1 P.
 */
#include "core/compliance.h"

#include <assert.h>
#include <cblas.h>
#include <complex.h>
#include <lapacke.h>
#include <math.h>
#include <omp.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbering -------------------------------------------------------------------------------------------------- */

/* Where the unknowns stand: interior first, then flank, minus side, plus side, bore. */
struct numbering {
    int *freedom; /* [2 nodes], -1: held */
    size_t count, interior, flank, side, bore;
};

enum zone { INTERIOR, FLANK, MINUS, PLUS, BORE, HELD };

static void number_zone(struct numbering *n, const unsigned char *zone, size_t freedoms, enum zone which) {
    for (size_t k = 0; k < freedoms; k++)
        if (zone[k] == which)
            n->freedom[k] = (int)n->count++;
}

/* Numbers listed nodes in the order of the list. */
static size_t number_list(struct numbering *n, const unsigned char *zone, const int *list, size_t nodes) {
    size_t before = n->count;
    for (size_t k = 0; k < nodes; k++)
        for (int c = 0; c < 2; c++)
            if (zone[2 * list[k] + c] != HELD)
                n->freedom[2 * list[k] + c] = (int)n->count++;
    return n->count - before;
}

static void mark(unsigned char *zone, const int *list, size_t nodes, enum zone which) {
    for (size_t k = 0; k < nodes; k++)
        zone[2 * list[k]] = zone[2 * list[k] + 1] = (unsigned char)which;
}

static bool number_unknowns(struct numbering *n, const struct qg_sector_mesh *mesh, enum qg_support support) {
    size_t freedoms = 2 * mesh->node_count;
    unsigned char *zone = calloc(freedoms, 1);
    *n = (struct numbering){.freedom = malloc(freedoms * sizeof(int))};
    if (!zone || !n->freedom) {
        free(zone);
        return false;
    }
    memset(n->freedom, 0xff, freedoms * sizeof(int));
    mark(zone, mesh->flank, mesh->flank_count, FLANK);
    mark(zone, mesh->bore, mesh->bore_count, BORE);
    mark(zone, mesh->side[1], mesh->side_count, MINUS);
    mark(zone, mesh->side[0], mesh->side_count, PLUS);
    for (size_t k = 0; k < mesh->bore_count; k++) {
        zone[2 * mesh->bore[k]] = HELD;
        if (support == QG_SUPPORT_FIXED)
            zone[2 * mesh->bore[k] + 1] = HELD;
    }
    number_zone(n, zone, freedoms, INTERIOR);
    n->interior = n->count;
    n->flank = number_list(n, zone, mesh->flank, mesh->flank_count);
    n->side = number_list(n, zone, mesh->side[1], mesh->side_count);
    size_t plus = number_list(n, zone, mesh->side[0], mesh->side_count);
    assert(plus == n->side);
    (void)plus;
    n->bore = number_list(n, zone, mesh->bore + 1, mesh->bore_count - 2);
    free(zone);
    return true;
}

/* ---- condensation ----------------------------------------------------------------------------------------------- */

/* Adds `shift` to the diagonal from row `from` on; returns the shift, the mean of those entries. */
static double shift_diagonal(cholmod_sparse *a, size_t from) {
    int *start = a->p, *row = a->i;
    double *value = a->x, sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t j = from; j < a->ncol; j++)
            for (int k = start[j]; k < start[j + 1]; k++)
                if (row[k] == (int)j) {
                    if (pass == 0)
                        sum += value[k] / (double)(a->ncol - from);
                    else
                        value[k] += sum;
                }
    return sum;
}

/* Fill-reducing order with the retained unknowns last, and the shape of the factor LL' in that order; NULL when it fails. */
static cholmod_factor *analyze(cholmod_sparse *a, size_t interior, cholmod_common *common) {
    int *order = malloc(a->ncol * sizeof *order), *constraint = malloc(a->ncol * sizeof *constraint);
    cholmod_factor *factor = NULL;
    if (order && constraint) {
        for (size_t k = 0; k < a->ncol; k++)
            constraint[k] = k < interior ? 0 : 1;
        common->nmethods = 1;
        common->method[0].ordering = CHOLMOD_GIVEN;
        common->supernodal = CHOLMOD_SUPERNODAL;
        if (cholmod_camd(a, NULL, 0, constraint, order, common))
            factor = cholmod_analyze_p(a, order, NULL, 0, common);
    }
    free(order);
    free(constraint);
    return factor;
}

/* CHOLMOD's numbers cannot be interrupted: stop is asked before them. */
static enum qg_status factorize(cholmod_sparse *a, cholmod_factor *factor, const struct qg_stop *stop,
                                cholmod_common *common) {
    if (qg_is_stopped(stop))
        return QG_CANCELLED;
    return cholmod_factorize(a, factor, common) && common->status == CHOLMOD_OK ? QG_OK : QG_NO_CONVERGENCE;
}

/* Copies what a supernode (a run of columns with the same rows, their values a dense block) has in the columns from
 * `interior` on into the dense lower triangle. */
static void copy_supernode(const cholmod_factor *factor, size_t which, size_t interior, double *lower) {
    const int *super = factor->super, *first_row = factor->pi, *row = (const int *)factor->s + first_row[which];
    const double *value = (const double *)factor->x + ((const int *)factor->px)[which];
    const size_t kept = factor->n - interior, begin = (size_t)super[which], end = (size_t)super[which + 1],
                 rows = (size_t)(first_row[which + 1] - first_row[which]);
    for (size_t j = begin > interior ? begin : interior; j < end; j++)
        for (size_t i = j - begin; i < rows; i++)
            lower[(size_t)row[i] - interior + kept * (j - interior)] = value[i + rows * (j - begin)];
}

/* The retained unknowns' block of the factor as a dense lower triangle (column-major), and which unknown each row is. Read
 * from the supernodes: CHOLMOD's own way out of them, a sparse matrix, holds the whole factor twice for a moment. */
static bool last_block(const cholmod_factor *factor, size_t interior, double *lower, int *unknown) {
    size_t n = factor->n, kept = n - interior;
    const int *perm = factor->Perm;
    assert(factor->is_super && factor->xtype == CHOLMOD_REAL);
    for (size_t k = 0; k < kept; k++) {
        unknown[k] = perm[interior + k] - (int)interior;
        if (unknown[k] < 0)
            return false;
    }
    memset(lower, 0, kept * kept * sizeof *lower);
    for (size_t k = 0; k < factor->nsuper; k++)
        copy_supernode(factor, k, interior, lower);
    return true;
}

/* S = L L' - D on the boundary, in the numbering's order, full square, column-major. */
static bool unfold(const double *lower, const int *unknown, const struct numbering *n, double shift, double *s) {
    size_t kept = n->count - n->interior;
    double *product = calloc(kept * kept, sizeof *product);
    if (!product)
        return false;
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, (int)kept, (int)kept, 1, lower, (int)kept, 0, product,
                (int)kept);
    for (size_t j = 0; j < kept; j++)
        for (size_t i = j; i < kept; i++) {
            size_t a = (size_t)unknown[i], b = (size_t)unknown[j];
            s[a + kept * b] = s[b + kept * a] = product[i + kept * j];
        }
    for (size_t k = n->flank; k < kept; k++)
        s[k + kept * k] -= shift;
    free(product);
    return true;
}

/* ---- stress rows ------------------------------------------------------------------------------------------------- */

/* Stress rows of the root points over the retained unknowns, [points] x [kept], a point's row contiguous. */
struct stress_rows {
    size_t points, kept;
    double *row;            /* first what acts on the retained unknowns directly, in the end everything */
    double *interior;       /* forward-solved: [points][kept], in the factor's order */
    struct qg_polar *place; /* [points] */
};

/* What is condensed, and what the rows are made from. */
struct sector {
    const struct qg_sector_mesh *mesh;
    const struct qg_compliance_plan *plan;
    const struct numbering *numbering;
};

static bool stress_rows_init(struct stress_rows *s, const struct qg_sector_mesh *mesh, const struct numbering *n) {
    *s = (struct stress_rows){.points = 2 * (mesh->root_count - 1), .kept = n->count - n->interior};
    s->row = calloc(s->points * s->kept, sizeof *s->row);
    s->interior = malloc(s->points * s->kept * sizeof *s->interior);
    s->place = malloc(s->points * sizeof *s->place);
    return s->row && s->interior && s->place;
}

static void stress_rows_finish(struct stress_rows *s) {
    free(s->row);
    free(s->interior);
    free(s->place);
}

/* Adds `share` of the stress at z of a root edge to the row of a point: retained unknowns into s->row, interior ones into
 * `interior`. */
static struct qg_polar add_edge_stress(struct stress_rows *s, const struct sector *from, size_t point, const int *node,
                                       double z, double share, double *interior) {
    const struct qg_polar *at = from->mesh->node;
    const struct qg_polar polar[3] = {at[node[0]], at[node[1]], at[node[2]]};
    struct qg_edge_stress e = qg_edge_stress(polar, &from->plan->plate, z);
    for (int k = 0; k < 6; k++) {
        int f = from->numbering->freedom[2 * node[k / 2] + k % 2];
        if (f >= (int)from->numbering->interior)
            s->row[point * s->kept + (size_t)f - from->numbering->interior] += share * e.weight[k];
        else if (f >= 0)
            interior[f] += share * e.weight[k];
    }
    return e.at;
}

/* The point's row over the mesh's unknowns. Points are corners (the mean of both edges, the first of one) and the middles of
 * edges in turn. */
static void stress_row(struct stress_rows *s, const struct sector *from, size_t point, double *interior) {
    size_t half = s->points / 2, k = point % half;
    const int *edge = from->mesh->root[point / half] + 2 * (k / 2);
    if (k % 2 == 1) {
        s->place[point] = add_edge_stress(s, from, point, edge, 0, 1, interior);
        return;
    }
    s->place[point] = add_edge_stress(s, from, point, edge, -1, k == 0 ? 1 : 0.5, interior);
    if (k > 0)
        add_edge_stress(s, from, point, edge - 2, 1, 0.5, interior);
}

/* Makes the rows and forward-solves their interior parts, some at a time. The factor is still whole. */
static enum qg_status solve_stress_rows(struct stress_rows *s, const struct sector *from, cholmod_factor *factor,
                                        cholmod_common *common) {
    enum { AT_ONCE = 16 };
    const struct numbering *n = from->numbering;
    bool ok = true;
    for (size_t first = 0; first < s->points && ok; first += AT_ONCE) {
        if (qg_is_stopped(&from->plan->stop))
            return QG_CANCELLED;
        size_t columns = s->points - first < AT_ONCE ? s->points - first : AT_ONCE;
        cholmod_dense *b = cholmod_zeros(n->count, columns, CHOLMOD_REAL, common), *p = NULL, *y = NULL;
        for (size_t k = 0; k < columns && b; k++)
            stress_row(s, from, first + k, (double *)b->x + k * n->count);
        p = b ? qg_factor_solve(CHOLMOD_P, factor, b, common) : NULL;
        y = p ? qg_factor_solve(CHOLMOD_L, factor, p, common) : NULL;
        ok = y != NULL;
        for (size_t k = 0; k < columns && ok; k++)
            memcpy(s->interior + (first + k) * s->kept, (double *)y->x + k * n->count + n->interior,
                   s->kept * sizeof *s->interior);
        cholmod_free_dense(&b, common);
        cholmod_free_dense(&p, common);
        cholmod_free_dense(&y, common);
    }
    return ok ? QG_OK : QG_NO_CONVERGENCE;
}

/* row += L_rr y_r, brought into the numbering's order. */
static void complete_stress_rows(struct stress_rows *s, const double *lower, const int *unknown) {
    cblas_dtrmm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, (int)s->kept, (int)s->points, 1,
                lower, (int)s->kept, s->interior, (int)s->kept);
    for (size_t p = 0; p < s->points; p++)
        for (size_t k = 0; k < s->kept; k++)
            s->row[p * s->kept + (size_t)unknown[k]] += s->interior[p * s->kept + k];
}

/* ---- the condensed sector ---------------------------------------------------------------------------------------- */

/* Schur complement of the retained unknowns of the sector (N/mm, *schur, the caller frees it), and the stress rows over
 * them. *schur is NULL when anything fails. */
static enum qg_status condense(const struct sector *from, struct stress_rows *rows, double **schur) {
    const struct numbering *n = from->numbering;
    omp_set_max_active_levels(
        0); /* per thread: CHOLMOD would open a team of its own, while parallelism is the executor's */
    cholmod_common common;
    cholmod_start(&common);
    common.print = 0;
    size_t kept = n->count - n->interior;
    double *s = malloc(kept * kept * sizeof *s), *lower = malloc(kept * kept * sizeof *lower);
    int *unknown = malloc(kept * sizeof *unknown);
    cholmod_sparse *a = qg_assemble(from->mesh, &from->plan->plate, n->freedom, n->count, &common);
    cholmod_factor *factor = NULL;
    enum qg_status status = s && lower && unknown && a ? QG_OK : QG_OUT_OF_MEMORY;
    if (status == QG_OK) {
        double shift = shift_diagonal(a, n->interior + n->flank);
        factor = analyze(a, n->interior, &common);
        status = factor ? factorize(a, factor, &from->plan->stop, &common) : QG_NO_CONVERGENCE;
        if (status == QG_OK)
            status = solve_stress_rows(rows, from, factor, &common);
        if (status == QG_OK && !last_block(factor, n->interior, lower, unknown))
            status = QG_NO_CONVERGENCE;
        cholmod_free_factor(&factor, &common); /* the largest of all, not needed any more */
        if (status == QG_OK && !unfold(lower, unknown, n, shift, s))
            status = QG_OUT_OF_MEMORY;
        if (status == QG_OK)
            complete_stress_rows(rows, lower, unknown);
    }
    if (status == QG_NO_CONVERGENCE && common.status != CHOLMOD_NOT_POSDEF)
        status = QG_OUT_OF_MEMORY;
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&a, &common);
    cholmod_finish(&common);
    free(lower);
    free(unknown);
    *schur = s;
    if (status != QG_OK) {
        free(s);
        *schur = NULL;
    }
    return status;
}

/* Splits S: out->local, out->response, and the boundary's stiffness with the flank free (m x m, returned). NULL when anything
 * fails, and *why then says what. */
static double *eliminate_flank(const double *s, size_t kept, size_t flank, struct qg_compliance *out,
                               enum qg_status *why) {
    size_t m = kept - flank;
    int nf = (int)flank, nb = (int)m, ld = (int)kept;
    double *stiffness = malloc(m * m * sizeof *stiffness);
    *why = stiffness ? QG_OK : QG_OUT_OF_MEMORY;
    if (!stiffness)
        return NULL;
    LAPACKE_dlacpy(LAPACK_COL_MAJOR, 'A', nf, nf, s, ld, out->local, nf);
    LAPACKE_dlacpy(LAPACK_COL_MAJOR, 'A', nf, nb, s + kept * flank, ld, out->response, nf);
    LAPACKE_dlacpy(LAPACK_COL_MAJOR, 'A', nb, nb, s + flank + kept * flank, ld, stiffness, nb);
    if (LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', nf, out->local, nf) ||
        LAPACKE_dpotrs(LAPACK_COL_MAJOR, 'L', nf, nb, out->local, nf, out->response, nf) ||
        LAPACKE_dpotri(LAPACK_COL_MAJOR, 'L', nf, out->local, nf)) {
        free(stiffness);
        *why = QG_NO_CONVERGENCE;
        return NULL;
    }
    for (size_t j = 0; j < flank; j++)
        for (size_t i = 0; i < j; i++)
            out->local[i + flank * j] = out->local[j + flank * i];
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, nb, nb, nf, -1, s + kept * flank, ld, out->response, nf, 1,
                stiffness, nb);
    return stiffness;
}

/* The rows with the flank eliminated; response and local stand. */
static void eliminate_flank_from_rows(const struct stress_rows *rows, struct qg_compliance *out) {
    int p = (int)rows->points, kept = (int)rows->kept, n = 2 * (int)out->flank_count, m = (int)out->boundary;
    memcpy(out->root, rows->place, rows->points * sizeof *out->root);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p, n, n, 1, rows->row, kept, out->local, n, 0,
                out->stress_local, p);
    for (size_t i = 0; i < rows->points; i++)
        for (size_t j = 0; j < out->boundary; j++)
            out->stress_boundary[i + rows->points * j] = rows->row[i * rows->kept + 2 * out->flank_count + j];
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p, m, n, -1, rows->row, kept, out->response, n, 1,
                out->stress_boundary, p);
}

/* ---- ring ------------------------------------------------------------------------------------------------------- */

/* The ring's unknowns are one side and the bore: q = (minus side, bore). */
struct ring {
    size_t side, bore, size; /* size = side + bore */
    const double *stiffness; /* of the boundary (minus, plus, bore), m x m */
    double *weight;          /* [size] of the bore's mean tangential displacement; NULL when the bore is fixed */
    double *rotation;        /* [size] rigid rotation */
};

/* Boundary index of ring unknown k: on the minus side, and on the plus side (or -1 for bore unknowns). */
static size_t minus_of(const struct ring *r, size_t k) {
    return k < r->side ? k : k + r->side;
}

/* K_n = T^H K T, T = (1, e^(i omega), 1). */
static void ring_matrix(const struct ring *r, double omega, double complex *out) {
    size_t m = 2 * r->side + r->bore;
    double complex turn = cexp(I * omega);
    for (size_t j = 0; j < r->size; j++)
        for (size_t i = 0; i < r->size; i++) {
            size_t a = minus_of(r, i), b = minus_of(r, j);
            double complex value = r->stiffness[a + m * b];
            if (i < r->side)
                value += conj(turn) * r->stiffness[a + r->side + m * b];
            if (j < r->side)
                value += turn * r->stiffness[a + m * (b + r->side)];
            if (i < r->side && j < r->side)
                value += r->stiffness[a + r->side + m * (b + r->side)];
            out[i + r->size * j] = value;
        }
}

/* In place, Hermitian positive definite, full square out. */
static bool invert(double complex *a, size_t n) {
    if (LAPACKE_zpotrf(LAPACK_COL_MAJOR, 'L', (int)n, a, (int)n) ||
        LAPACKE_zpotri(LAPACK_COL_MAJOR, 'L', (int)n, a, (int)n))
        return false;
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < j; i++)
            a[i + n * j] = conj(a[j + n * i]);
    return true;
}

/* a <- P' a P with P = 1 - w r' / (r'w): the load is balanced, the mean rotation of the bore taken off. */
static void project(const struct ring *r, double complex *a) {
    size_t n = r->size;
    double rw = cblas_ddot((int)n, r->rotation, 1, r->weight, 1);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < n; i++) { /* row i of a times P */
            double complex aw = 0;
            for (size_t j = 0; j < n; j++)
                aw += a[i + n * j] * r->weight[j];
            for (size_t j = 0; j < n; j++)
                a[i + n * j] -= aw * r->rotation[j] / rw;
        }
        for (size_t j = 0; j < n; j++) /* transpose, so that the second pass does the other side */
            for (size_t i = 0; i < j; i++) {
                double complex t = a[i + n * j];
                a[i + n * j] = a[j + n * i];
                a[j + n * i] = t;
            }
    }
}

/* Flexibility of circumferential order `order`; out is size x size. */
static bool ring_order(const struct ring *r, int order, int teeth, double complex *out) {
    ring_matrix(r, 2 * M_PI * order / teeth, out);
    bool floating = order == 0 && r->weight;
    if (floating) {
        double norm = cblas_ddot((int)r->size, r->weight, 1, r->weight, 1), diagonal = 0;
        for (size_t k = 0; k < r->size; k++)
            diagonal += creal(out[k + r->size * k]) / (double)r->size;
        for (size_t j = 0; j < r->size; j++)
            for (size_t i = 0; i < r->size; i++)
                out[i + r->size * j] += diagonal / norm * r->weight[i] * r->weight[j];
    }
    if (!invert(out, r->size))
        return false;
    if (floating)
        project(r, out);
    return true;
}

/* ring_d += factor Re(e^(i omega d) T X T^H). */
static void accumulate(const struct ring *r, const double complex *x, double omega, int distance, double factor,
                       double *out) {
    size_t m = 2 * r->side + r->bore;
    double complex turn = cexp(I * omega), phase = cexp(I * omega * distance);
    for (size_t j = 0; j < r->size; j++)
        for (size_t i = 0; i < r->size; i++) {
            size_t a = minus_of(r, i), b = minus_of(r, j);
            double complex value = factor * phase * x[i + r->size * j];
            out[a + m * b] += creal(value);
            if (i < r->side)
                out[a + r->side + m * b] += creal(turn * value);
            if (j < r->side)
                out[a + m * (b + r->side)] += creal(value * conj(turn));
            if (i < r->side && j < r->side)
                out[a + r->side + m * (b + r->side)] += creal(value);
        }
}

static enum qg_status join_ring(const struct ring *r, const struct qg_compliance_plan *plan,
                                struct qg_compliance *out) {
    const int teeth = plan->teeth;
    double complex *x = malloc(r->size * r->size * sizeof *x);
    if (!x)
        return QG_OUT_OF_MEMORY;
    enum qg_status status = QG_OK;
    size_t m = out->boundary;
    for (int order = 0; order <= teeth / 2 && status == QG_OK; order++) {
        bool alone = order == 0 || 2 * order == teeth; /* its own conjugate */
        double factor = (alone ? 1.0 : 2.0) / teeth;
        if (qg_is_stopped(&plan->stop))
            status = QG_CANCELLED;
        else if (!ring_order(r, order, teeth, x))
            status = QG_NO_CONVERGENCE;
        for (int d = 0; d <= out->reach && status == QG_OK; d++)
            accumulate(r, x, 2 * M_PI * order / teeth, d, factor, out->ring + (size_t)d * m * m);
    }
    free(x);
    return status;
}

/* Weights of the bore's mean tangential displacement (consistent with quadratic edges) and the rigid rotation, both in the
 * ring's unknowns. */
static void bore_vectors(const struct qg_sector_mesh *mesh, const struct numbering *n, struct ring *r) {
    size_t base = n->interior + n->flank;
    for (size_t k = 0; k + 2 < mesh->bore_count; k += 2) {
        const int *edge = mesh->bore + k;
        double length = mesh->node[edge[0]].angle - mesh->node[edge[2]].angle;
        static const double share[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
        for (int e = 0; e < 3; e++) {
            size_t b = (size_t)n->freedom[2 * edge[e] + 1] - base; /* boundary index: minus, plus, bore */
            r->weight[b < r->side ? b : b - r->side] += share[e] * length;
        }
    }
    for (size_t k = 0; k < mesh->side_count; k++) {
        int f = n->freedom[2 * mesh->side[1][k] + 1];
        if (f >= 0)
            r->rotation[(size_t)f - base] = mesh->node[mesh->side[1][k]].radius;
    }
    for (size_t k = 1; k + 1 < mesh->bore_count; k++)
        r->rotation[(size_t)n->freedom[2 * mesh->bore[k] + 1] - base - r->side] = mesh->node[mesh->bore[k]].radius;
}

static enum qg_status solve_ring(const struct sector *from, const double *stiffness, struct qg_compliance *out) {
    const struct numbering *n = from->numbering;
    struct ring r = {.side = n->side, .bore = n->bore, .size = n->side + n->bore, .stiffness = stiffness};
    enum qg_status status = QG_OK;
    if (n->bore > 0) {
        r.weight = calloc(r.size, sizeof *r.weight);
        r.rotation = calloc(r.size, sizeof *r.rotation);
        if (r.weight && r.rotation)
            bore_vectors(from->mesh, n, &r);
        else
            status = QG_OUT_OF_MEMORY;
    }
    if (status == QG_OK)
        status = join_ring(&r, from->plan, out);
    free(r.weight);
    free(r.rotation);
    return status;
}

/* ---- putting it together ---------------------------------------------------------------------------------------- */

static bool allocate(struct qg_compliance *c, const struct qg_sector_mesh *mesh, const struct numbering *n, int reach) {
    size_t m = n->count - n->interior - n->flank;
    c->flank_count = mesh->flank_count;
    c->boundary = m;
    c->reach = reach;
    c->degrees_of_freedom = n->count;
    c->flank_arc = malloc(mesh->flank_count * sizeof *c->flank_arc);
    c->flank = malloc(mesh->flank_count * sizeof *c->flank);
    c->local = malloc(n->flank * n->flank * sizeof *c->local);
    c->response = malloc(n->flank * m * sizeof *c->response);
    c->root_count = 2 * (mesh->root_count - 1);
    c->root = malloc(c->root_count * sizeof *c->root);
    c->stress_local = malloc(c->root_count * n->flank * sizeof *c->stress_local);
    c->stress_boundary = malloc(c->root_count * m * sizeof *c->stress_boundary);
    c->ring = calloc((size_t)(reach + 1) * m * m, sizeof *c->ring);
    if (!c->flank_arc || !c->flank || !c->local || !c->response || !c->ring || !c->root || !c->stress_local ||
        !c->stress_boundary)
        return false;
    for (size_t k = 0; k < mesh->flank_count; k++) {
        c->flank_arc[k] = mesh->flank_arc[k];
        c->flank[k] = mesh->node[mesh->flank[k]];
    }
    return true;
}

/* Everything behind the allocation: condenses the sector and joins the ring. */
static enum qg_status compute(const struct sector *from, struct stress_rows *rows, struct qg_compliance *out) {
    const struct numbering *n = from->numbering;
    double *s = NULL, *stiffness = NULL;
    enum qg_status status = condense(from, rows, &s);
    if (status == QG_OK && qg_is_stopped(&from->plan->stop))
        status = QG_CANCELLED;
    if (status == QG_OK)
        stiffness = eliminate_flank(s, n->count - n->interior, n->flank, out, &status);
    free(s);
    if (status == QG_OK) {
        eliminate_flank_from_rows(rows, out);
        status = solve_ring(from, stiffness, out);
    }
    free(stiffness);
    return status;
}

enum qg_status qg_compliance_init(struct qg_compliance *compliance, const struct qg_sector_mesh *mesh,
                                  const struct qg_compliance_plan *plan) {
    *compliance = (struct qg_compliance){0};
    struct numbering n;
    struct stress_rows rows = {0};
    enum qg_status status = QG_OUT_OF_MEMORY;
    if (number_unknowns(&n, mesh, plan->support) && allocate(compliance, mesh, &n, plan->reach) &&
        stress_rows_init(&rows, mesh, &n))
        status = compute(&(struct sector){mesh, plan, &n}, &rows, compliance);
    stress_rows_finish(&rows);
    free(n.freedom);
    if (status != QG_OK)
        qg_compliance_finish(compliance);
    return status;
}

void qg_compliance_finish(struct qg_compliance *compliance) {
    free(compliance->flank_arc);
    free(compliance->flank);
    free(compliance->local);
    free(compliance->response);
    free(compliance->ring);
    free(compliance->root);
    free(compliance->stress_local);
    free(compliance->stress_boundary);
    *compliance = (struct qg_compliance){0};
}

double qg_compliance_entry(const struct qg_compliance *c, int distance, size_t row, size_t column) {
    if (distance < 0)
        return qg_compliance_entry(c, -distance, column, row);
    assert(distance <= c->reach);
    size_t n = 2 * c->flank_count, m = c->boundary;
    const double *ring = c->ring + (size_t)distance * m * m;
    double sum = distance == 0 ? c->local[row + n * column] : 0;
    for (size_t j = 0; j < m; j++) {
        double inner = 0;
        for (size_t i = 0; i < m; i++)
            inner += c->response[row + n * i] * ring[i + m * j];
        sum += inner * c->response[column + n * j];
    }
    return sum;
}

enum qg_status qg_compliance_stress(const struct qg_compliance *c, int distance, double *out) {
    assert(abs(distance) <= c->reach);
    int p = (int)c->root_count, n = 2 * (int)c->flank_count, m = (int)c->boundary;
    if (p == 0) /* a flank without a root, as of springs */
        return QG_OK;
    double *scratch = malloc(c->root_count * c->boundary * sizeof *scratch);
    if (!scratch)
        return QG_OUT_OF_MEMORY;
    if (distance == 0)
        memcpy(out, c->stress_local, c->root_count * 2 * c->flank_count * sizeof *out);
    cblas_dgemm(CblasColMajor, CblasNoTrans, distance < 0 ? CblasTrans : CblasNoTrans, p, m, m, 1, c->stress_boundary,
                p, c->ring + (size_t)abs(distance) * c->boundary * c->boundary, m, 0, scratch, p);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, p, n, m, -1, scratch, p, c->response, n, distance == 0, out,
                p);
    free(scratch);
    return QG_OK;
}
