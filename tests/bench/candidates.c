/* CMA-ES, differential evolution, NSGA-II. See candidates.h.
 *
 * Points are kept in the unit cube. Random numbers are counted, so that a run is a function of its seed.
 */
#include "tests/bench/candidates.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

#include "core/random.h"
#include "core/sequence.h"

enum { D = QG_SEARCH_DIMENSIONS_MAX, POPULATION = 32, LAMBDA = 16, MU = LAMBDA / 2 };

/* What every method needs: where it searches, and its random numbers. */
struct ground {
    const struct qg_box *box;
    const struct qg_objective_function *objective;
    size_t objectives;
    uint64_t seed;
    struct qg_sequence sequence;
    uint64_t drawn; /* index of the next block of random numbers */
};

static struct ground ground_of(const struct qg_box *box, const struct qg_objective_function *objective, uint64_t seed) {
    return (struct ground){.box = box,
                           .objective = objective,
                           .objectives = 1,
                           .seed = seed,
                           .sequence = qg_sequence_of(seed, box->dimensions)};
}

static double uniform(const struct ground *g, uint32_t lane) {
    return qg_random_uniform(g->seed, QG_STREAM_TESTS, g->drawn, lane);
}

static size_t below(const struct ground *g, size_t n, uint32_t lane) {
    return (size_t)(uniform(g, lane) * (double)n);
}

/* Into [0, 1] by reflection at its ends. */
static double mirrored(double u) {
    u = fabs(fmod(u, 2));
    return u > 1 ? 2 - u : u;
}

/* Evaluates n points of the unit cube, rows of D numbers, in batches. */
static enum qg_status evaluate(const struct ground *g, size_t n, double (*u)[D], double *f) {
    double x[QG_SEARCH_BATCH * D];
    size_t d = g->box->dimensions;
    enum qg_status status = QG_OK;
    for (size_t done = 0; done < n && status == QG_OK; done += QG_SEARCH_BATCH) {
        size_t batch = n - done < QG_SEARCH_BATCH ? n - done : QG_SEARCH_BATCH;
        for (size_t i = 0; i < batch; i++)
            for (size_t k = 0; k < d; k++)
                x[i * d + k] = g->box->lower[k] + u[done + i][k] * (g->box->upper[k] - g->box->lower[k]);
        status = g->objective->values(g->objective->self, batch, x, f + done * g->objectives);
    }
    return status;
}

/* ---- CMA-ES ------------------------------------------------------------------------------------------------------ */

/* The distribution, in the tutorial's symbols; rates depend on the dimensions alone. */
struct cma {
    size_t d;
    double weight[MU], mu_eff, c_c, c_sigma, c_1, c_mu, damping, chi;
    double mean[D], sigma, covariance[D][D], path_c[D], path_sigma[D];
    double basis[D * D], deviation[D]; /* eigenvectors as columns, square roots of eigenvalues */
    size_t generation;
};

static void set_rates(struct cma *c, size_t d) {
    double n = (double)d, sum = 0, squares = 0;
    *c = (struct cma){.d = d};
    for (size_t i = 0; i < MU; i++)
        sum += c->weight[i] = log(MU + 0.5) - log((double)i + 1);
    for (size_t i = 0; i < MU; i++) {
        c->weight[i] /= sum;
        squares += c->weight[i] * c->weight[i];
    }
    double m = c->mu_eff = 1 / squares;
    c->c_c = (4 + m / n) / (n + 4 + 2 * m / n);
    c->c_sigma = (m + 2) / (n + m + 5);
    c->c_1 = 2 / ((n + 1.3) * (n + 1.3) + m);
    c->c_mu = fmin(1 - c->c_1, 2 * (m - 2 + 1 / m) / ((n + 2) * (n + 2) + m));
    c->damping = 1 + 2 * fmax(0, sqrt((m - 1) / (n + 1)) - 1) + c->c_sigma;
    c->chi = sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
}

static void restart(struct cma *c, const double *mean) {
    memcpy(c->mean, mean, sizeof c->mean);
    memset(c->covariance, 0, sizeof c->covariance);
    memset(c->path_c, 0, sizeof c->path_c);
    memset(c->path_sigma, 0, sizeof c->path_sigma);
    for (size_t k = 0; k < c->d; k++)
        c->covariance[k][k] = 1;
    c->sigma = 0.2;
    c->generation = 0;
}

static void decompose(struct cma *c) {
    for (size_t j = 0; j < c->d; j++)
        for (size_t i = 0; i < c->d; i++)
            c->basis[j * c->d + i] = c->covariance[i][j];
    LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'L', (int)c->d, c->basis, (int)c->d, c->deviation);
    for (size_t k = 0; k < c->d; k++)
        c->deviation[k] = sqrt(fmax(c->deviation[k], 1e-20));
}

/* A population: points, and their steps from the mean in units of sigma. */
static void draw(struct ground *g, const struct cma *c, double (*u)[D], double (*step)[D]) {
    for (size_t i = 0; i < LAMBDA; i++, g->drawn++)
        for (size_t k = 0; k < c->d; k++) {
            double y = 0;
            for (size_t j = 0; j < c->d; j++)
                y += c->basis[j * c->d + k] * c->deviation[j] *
                     qg_random_gaussian(g->seed, QG_STREAM_TESTS, g->drawn, (uint32_t)j, 8);
            u[i][k] = mirrored(c->mean[k] + c->sigma * y);
            step[i][k] = (u[i][k] - c->mean[k]) / c->sigma;
        }
}

/* Insertion sort of indices by value. */
static void rank(const double *f, size_t n, size_t *order) {
    for (size_t i = 0; i < n; i++) {
        size_t k = i;
        for (; k > 0 && f[i] < f[order[k - 1]]; k--)
            order[k] = order[k - 1];
        order[k] = i;
    }
}

/* The paths: where the mean has been going. Returns whether the covariance's path is stalled. */
static bool follow_paths(struct cma *c, const double *mean_step) {
    double whitened[D] = {0}, length = 0;
    for (size_t j = 0; j < c->d; j++) {
        double along = 0;
        for (size_t k = 0; k < c->d; k++)
            along += c->basis[j * c->d + k] * mean_step[k];
        for (size_t k = 0; k < c->d; k++)
            whitened[k] += c->basis[j * c->d + k] * along / c->deviation[j];
    }
    for (size_t k = 0; k < c->d; k++) {
        c->path_sigma[k] =
            (1 - c->c_sigma) * c->path_sigma[k] + sqrt(c->c_sigma * (2 - c->c_sigma) * c->mu_eff) * whitened[k];
        length += c->path_sigma[k] * c->path_sigma[k];
    }
    length = sqrt(length);
    double expected = c->chi * sqrt(1 - pow(1 - c->c_sigma, 2 * (double)(c->generation + 1)));
    bool stalled = !(length < (1.4 + 2 / ((double)c->d + 1)) * expected);
    for (size_t k = 0; k < c->d; k++)
        c->path_c[k] =
            (1 - c->c_c) * c->path_c[k] + (stalled ? 0 : sqrt(c->c_c * (2 - c->c_c) * c->mu_eff) * mean_step[k]);
    c->sigma *= exp(c->c_sigma / c->damping * (length / c->chi - 1));
    return stalled;
}

static void update(struct cma *c, double (*step)[D], const size_t *order) {
    double mean_step[D] = {0};
    for (size_t i = 0; i < MU; i++)
        for (size_t k = 0; k < c->d; k++)
            mean_step[k] += c->weight[i] * step[order[i]][k];
    for (size_t k = 0; k < c->d; k++)
        c->mean[k] += c->sigma * mean_step[k];
    bool stalled = follow_paths(c, mean_step);
    for (size_t a = 0; a < c->d; a++)
        for (size_t b = 0; b < c->d; b++) {
            double rank_mu = 0, lost = stalled ? c->c_c * (2 - c->c_c) * c->covariance[a][b] : 0;
            for (size_t i = 0; i < MU; i++)
                rank_mu += c->weight[i] * step[order[i]][a] * step[order[i]][b];
            c->covariance[a][b] = (1 - c->c_1 - c->c_mu) * c->covariance[a][b] +
                                  c->c_1 * (c->path_c[a] * c->path_c[b] + lost) + c->c_mu * rank_mu;
        }
    c->generation++;
}

static double extent(const struct cma *c) {
    double most = 0;
    for (size_t k = 0; k < c->d; k++)
        most = fmax(most, c->sigma * sqrt(c->covariance[k][k]));
    return most;
}

enum qg_status cma_es(const struct qg_box *box, const struct qg_objective_function *objective, uint64_t seed,
                      size_t samples) {
    struct ground g = ground_of(box, objective, seed);
    double u[LAMBDA][D], step[LAMBDA][D], f[LAMBDA], start[D] = {0}, least = INFINITY;
    size_t order[LAMBDA];
    struct cma c;
    set_rates(&c, box->dimensions);
    enum qg_status status = QG_OK;
    for (size_t done = 0; done < samples && status == QG_OK; done += LAMBDA) {
        for (size_t i = 0; i < LAMBDA; i++)
            qg_sequence_point(&g.sequence, done + i, u[i]);
        status = evaluate(&g, LAMBDA, u, f);
        for (size_t i = 0; i < LAMBDA && status == QG_OK; i++)
            if (f[i] < least) {
                least = f[i];
                memcpy(start, u[i], sizeof start);
            }
    }
    for (restart(&c, start); status == QG_OK;) {
        decompose(&c);
        draw(&g, &c, u, step);
        status = evaluate(&g, LAMBDA, u, f);
        if (status != QG_OK)
            break;
        rank(f, LAMBDA, order);
        update(&c, step, order);
        if (extent(&c) < 1e-3) {
            for (uint32_t k = 0; k < c.d; k++)
                start[k] = uniform(&g, k);
            g.drawn++;
            restart(&c, start);
        }
    }
    return status;
}

/* ---- differential evolution -------------------------------------------------------------------------------------- */

/* A rival of member i. */
static void breed(const struct ground *g, double (*u)[D], size_t i, size_t best, double *child) {
    size_t b = below(g, POPULATION, 1), c = below(g, POPULATION, 2), sure = below(g, g->box->dimensions, 3);
    double factor = 0.4 + 0.5 * uniform(g, 4);
    for (uint32_t k = 0; k < g->box->dimensions; k++) {
        child[k] = u[i][k];
        if (k != sure && uniform(g, 5 + k) >= 0.8)
            continue;
        double v = u[i][k] + 0.5 * (u[best][k] - u[i][k]) + factor * (u[b][k] - u[c][k]);
        child[k] = v < 0 ? u[i][k] / 2 : v > 1 ? (1 + u[i][k]) / 2 : v;
    }
}

enum qg_status differential_evolution(const struct qg_box *box, const struct qg_objective_function *objective,
                                      uint64_t seed) {
    struct ground g = ground_of(box, objective, seed);
    double u[POPULATION][D], f[POPULATION], child[POPULATION][D], value[POPULATION];
    size_t order[POPULATION];
    for (size_t i = 0; i < POPULATION; i++)
        qg_sequence_point(&g.sequence, i, u[i]);
    enum qg_status status = evaluate(&g, POPULATION, u, f);
    while (status == QG_OK) {
        rank(f, POPULATION, order);
        for (size_t i = 0; i < POPULATION; i++, g.drawn++)
            breed(&g, u, i, order[0], child[i]);
        status = evaluate(&g, POPULATION, child, value);
        for (size_t i = 0; i < POPULATION && status == QG_OK; i++)
            if (value[i] <= f[i]) {
                f[i] = value[i];
                memcpy(u[i], child[i], sizeof u[i]);
            }
    }
    return status;
}

/* ---- NSGA-II ----------------------------------------------------------------------------------------------------- */

enum { BOTH = 2 * POPULATION };

/* Parents and children together. */
struct herd {
    double u[BOTH][D], f[BOTH][2];
    size_t rank[BOTH]; /* 0: on the front, 1: on that of the others, ... */
    double crowding[BOTH];
};

static bool dominates(const double *a, const double *b) {
    return a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
}

/* Peels off one front after the other. */
static void sort_fronts(struct herd *h, size_t n) {
    bool done[BOTH] = {false};
    for (size_t left = n, level = 0; left > 0; level++) {
        bool front[BOTH] = {false};
        for (size_t i = 0; i < n; i++) {
            front[i] = !done[i];
            for (size_t j = 0; j < n && front[i]; j++)
                front[i] = done[j] || !dominates(h->f[j], h->f[i]);
        }
        for (size_t i = 0; i < n; i++)
            if (front[i]) {
                done[i] = true;
                h->rank[i] = level;
                left--;
            }
    }
}

/* Sum over the objectives of the gap between a member's neighbours on its front; at the ends infinite. */
static void measure_crowding(struct herd *h, size_t n) {
    for (size_t i = 0; i < n; i++) {
        h->crowding[i] = 0;
        for (int k = 0; k < 2; k++) {
            double before = -INFINITY, behind = INFINITY;
            for (size_t j = 0; j < n; j++) {
                if (j == i || h->rank[j] != h->rank[i])
                    continue;
                double away = h->f[j][k] - h->f[i][k];
                before = away <= 0 ? fmax(before, away) : before;
                behind = away >= 0 ? fmin(behind, away) : behind;
            }
            h->crowding[i] += behind - before;
        }
    }
}

static bool is_better(const struct herd *h, size_t a, size_t b) {
    return h->rank[a] < h->rank[b] || (h->rank[a] == h->rank[b] && h->crowding[a] > h->crowding[b]);
}

/* The better half comes first. */
static void select_half(struct herd *h) {
    struct herd old = *h;
    size_t order[BOTH];
    for (size_t i = 0; i < BOTH; i++) {
        size_t k = i;
        for (; k > 0 && is_better(&old, i, order[k - 1]); k--)
            order[k] = order[k - 1];
        order[k] = i;
    }
    for (size_t i = 0; i < POPULATION; i++) {
        memcpy(h->u[i], old.u[order[i]], sizeof h->u[i]);
        memcpy(h->f[i], old.f[order[i]], sizeof h->f[i]);
        h->rank[i] = old.rank[order[i]];
        h->crowding[i] = old.crowding[order[i]];
    }
}

static size_t tournament(const struct ground *g, const struct herd *h, uint32_t lane) {
    size_t a = below(g, POPULATION, lane), b = below(g, POPULATION, lane + 1);
    return is_better(h, a, b) ? a : b;
}

static void mate(const struct ground *g, struct herd *h, size_t child) {
    const double *a = h->u[tournament(g, h, 0)], *b = h->u[tournament(g, h, 2)];
    size_t d = g->box->dimensions;
    for (uint32_t k = 0; k < d; k++) {
        double u = uniform(g, 10 + k), spread = pow(u < 0.5 ? 2 * u : 1 / (2 * (1 - u)), 1.0 / 16);
        double v = uniform(g, 40 + k) < 0.9 ? ((1 + spread) * a[k] + (1 - spread) * b[k]) / 2 : a[k];
        if (uniform(g, 70 + k) < 1 / (double)d) {
            double m = uniform(g, 100 + k);
            v += m < 0.5 ? pow(2 * m, 1.0 / 21) - 1 : 1 - pow(2 * (1 - m), 1.0 / 21);
        }
        h->u[child][k] = mirrored(v);
    }
}

enum qg_status nsga_ii(const struct qg_box *box, const struct qg_objective_function *objective, uint64_t seed) {
    struct ground g = ground_of(box, objective, seed);
    struct herd h;
    g.objectives = 2;
    for (size_t i = 0; i < POPULATION; i++)
        qg_sequence_point(&g.sequence, i, h.u[i]);
    enum qg_status status = evaluate(&g, POPULATION, h.u, h.f[0]);
    sort_fronts(&h, POPULATION);
    measure_crowding(&h, POPULATION);
    while (status == QG_OK) {
        for (size_t i = 0; i < POPULATION; i++, g.drawn++)
            mate(&g, &h, POPULATION + i);
        status = evaluate(&g, POPULATION, h.u + POPULATION, h.f[POPULATION]);
        if (status != QG_OK)
            break;
        sort_fronts(&h, BOTH);
        measure_crowding(&h, BOTH);
        select_half(&h);
    }
    return status;
}
