/* Multi-start simplex. See multistart.h.
 *
 * All points live in the box's own coordinates; distances are measured in shares of the box. The counting of evaluations is
 * in one place, `evaluate`: it cuts what is asked into batches, and what does not fit into the budget is left away, after
 * which the search is over.
 */
#include "core/multistart.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/sequence.h"

static const double share_of_samples = 0.3, apart = 0.15, finished_size = 1e-3, augmentation = 0.05;

enum { ROUND_POINTS_MAX = QG_STARTS_MAX * QG_SEARCH_DIMENSIONS_MAX };

/* One simplex and its weights; alive: still in the race and not finished. */
struct runner {
    struct qg_simplex simplex;
    double weight[QG_SEARCH_OBJECTIVES_MAX];
    bool alive;
};

struct multistart {
    const struct qg_multistart *plan;
    const struct qg_box *box;
    const struct qg_objective_function *objective;
    struct qg_sequence sequence;
    size_t left;       /* evaluations */
    size_t sampled;    /* points of the sequence used */
    size_t directions; /* weights used, over all rounds */
    struct {
        size_t count;
        double *x, *f; /* of this round: count rows of dimensions and of objectives */
        bool *taken;
    } samples;
    size_t runners;
    struct runner runner[QG_STARTS_MAX];
    double x[ROUND_POINTS_MAX * QG_SEARCH_DIMENSIONS_MAX], f[ROUND_POINTS_MAX * QG_SEARCH_OBJECTIVES_MAX];
};

/* Evaluates n points in batches, as far as the budget reaches. */
static enum qg_status evaluate(struct multistart *m, size_t n, const double *x, double *f) {
    enum qg_status status = QG_OK;
    n = n < m->left ? n : m->left;
    for (size_t done = 0; done < n && status == QG_OK;) {
        size_t batch = n - done < QG_SEARCH_BATCH ? n - done : QG_SEARCH_BATCH;
        status = m->objective->values(m->objective->self, batch, x + done * m->box->dimensions,
                                      f + done * m->plan->objectives);
        done += batch;
    }
    m->left -= n;
    return status;
}

/* ---- samples and starts ------------------------------------------------------------------------------------------ */

static enum qg_status sample(struct multistart *m) {
    size_t d = m->box->dimensions, n = (size_t)ceil(share_of_samples * (double)m->left);
    free(m->samples.x);
    free(m->samples.f);
    free(m->samples.taken);
    m->samples.count = n;
    m->samples.x = malloc(n * d * sizeof(double));
    m->samples.f = malloc(n * m->plan->objectives * sizeof(double));
    m->samples.taken = calloc(n, sizeof(bool));
    if (!m->samples.x || !m->samples.f || !m->samples.taken)
        return QG_OUT_OF_MEMORY;
    for (size_t i = 0; i < n; i++) {
        double *x = m->samples.x + i * d;
        qg_sequence_point(&m->sequence, m->sampled++, x);
        for (size_t k = 0; k < d; k++)
            x[k] = m->box->lower[k] + x[k] * (m->box->upper[k] - m->box->lower[k]);
    }
    return evaluate(m, n, m->samples.x, m->samples.f);
}

static double scalar(const struct multistart *m, const double *weight, const double *f) {
    if (m->plan->objectives == 1)
        return f[0];
    double largest = -INFINITY, sum = 0;
    for (size_t k = 0; k < m->plan->objectives; k++) {
        largest = fmax(largest, weight[k] * f[k]);
        sum += weight[k] * f[k];
    }
    return largest + augmentation * sum;
}

/* Weights of the next runner: even over the simplex of weights, all positive, summing to 1. Two objectives: the midpoints of
 * `starts` equal parts, in later rounds shifted by the golden section. Three: a two-dimensional sequence, folded. */
static void choose_weights(struct multistart *m, double *weight) {
    size_t n = m->plan->objectives, i = m->directions++;
    double u[2];
    if (n == 1) {
        weight[0] = 1;
    } else if (n == 2) {
        double at = ((double)(i % m->plan->starts) + 0.5) / (double)m->plan->starts;
        at += 0.6180339887498949 * (double)(i / m->plan->starts);
        weight[0] = fmin(0.99, fmax(0.01, at - floor(at)));
        weight[1] = 1 - weight[0];
    } else {
        const struct qg_sequence directions = qg_sequence_of(0, 2);
        qg_sequence_point(&directions, i, u);
        double low = fmin(u[0], u[1]), high = fmax(u[0], u[1]);
        const double gaps[] = {low, high - low, 1 - high};
        for (size_t k = 0; k < n; k++)
            weight[k] = 0.02 + 0.94 * gaps[k];
    }
}

/* Distance of a sample to a start, as a share of the box's diagonal. */
static double distance(const struct multistart *m, const double *x, const double *y) {
    double sum = 0;
    for (size_t k = 0; k < m->box->dimensions; k++) {
        double part = (x[k] - y[k]) / (m->box->upper[k] - m->box->lower[k]);
        sum += part * part;
    }
    return sqrt(sum / (double)m->box->dimensions);
}

/* No sample near a start starts another simplex; those of several objectives differ by their weights already. */
static void take_sample(struct multistart *m, size_t sample) {
    size_t d = m->box->dimensions;
    const double *x = m->samples.x + sample * d;
    m->samples.taken[sample] = true;
    for (size_t i = 0; i < m->samples.count && m->plan->objectives == 1; i++)
        if (distance(m, x, m->samples.x + i * d) < apart)
            m->samples.taken[i] = true;
}

/* Starts a simplex at the best sample that is still free; false when there is none. */
static bool start_runner(struct multistart *m) {
    struct runner *r = &m->runner[m->runners];
    size_t d = m->box->dimensions, best = m->samples.count;
    struct qg_vertex start = {.f = INFINITY};
    double weight[QG_SEARCH_OBJECTIVES_MAX];
    choose_weights(m, weight);
    for (size_t i = 0; i < m->samples.count; i++) {
        double f = scalar(m, weight, m->samples.f + i * m->plan->objectives);
        if (!m->samples.taken[i] && (best == m->samples.count || f < start.f)) {
            best = i;
            start.f = f;
        }
    }
    if (best == m->samples.count)
        return false;
    memcpy(start.x, m->samples.x + best * d, d * sizeof *start.x);
    take_sample(m, best);
    qg_simplex_span(&r->simplex, m->box, &start);
    memcpy(r->weight, weight, sizeof weight);
    r->alive = true;
    m->runners++;
    return true;
}

/* ---- the race ---------------------------------------------------------------------------------------------------- */

static size_t alive(const struct multistart *m) {
    size_t n = 0;
    for (size_t j = 0; j < m->runners; j++)
        n += m->runner[j].alive;
    return n;
}

/* Gives up the worst until `keep` are left. */
static void drop_worst(struct multistart *m, size_t keep) {
    for (size_t n = alive(m); n > keep; n--) {
        struct runner *worst = NULL;
        for (size_t j = 0; j < m->runners; j++)
            if (m->runner[j].alive && (!worst || m->runner[j].simplex.vertex[0].f > worst->simplex.vertex[0].f))
                worst = &m->runner[j];
        worst->alive = false;
    }
}

/* Tells a runner its values; finishes it when it has become small. */
static void tell(struct multistart *m, struct runner *r, size_t n, const double *f) {
    double values[QG_SEARCH_DIMENSIONS_MAX];
    for (size_t i = 0; i < n; i++)
        values[i] = scalar(m, r->weight, f + i * m->plan->objectives);
    if (qg_simplex_tell(&r->simplex, values))
        r->alive = qg_simplex_size(&r->simplex) >= finished_size;
}

/* One move of all that are alive. */
static enum qg_status move_all(struct multistart *m) {
    size_t asked[QG_STARTS_MAX] = {0}, n = 0, d = m->box->dimensions;
    for (size_t j = 0; j < m->runners; j++)
        if (m->runner[j].alive)
            n += asked[j] = qg_simplex_ask(&m->runner[j].simplex, m->x + n * d);
    bool all = n <= m->left;
    enum qg_status status = evaluate(m, n, m->x, m->f);
    if (status != QG_OK || !all)
        return status;
    const double *f = m->f;
    for (size_t j = 0; j < m->runners; j++)
        if (asked[j] > 0) {
            tell(m, &m->runner[j], asked[j], f);
            f += asked[j] * m->plan->objectives;
        }
    return QG_OK;
}

/* How many stages there are from k simplexes down to one. */
static size_t stages_of(size_t k) {
    size_t n = 1;
    for (; k > 1; k = (k + 1) / 2)
        n++;
    return n;
}

static enum qg_status race(struct multistart *m) {
    enum qg_status status = QG_OK;
    size_t keep = m->runners, stages = m->plan->objectives == 1 ? stages_of(keep) : 1;
    for (; stages > 0 && status == QG_OK; stages--) {
        size_t end = m->left - m->left / stages; /* evaluations left when the stage is over */
        while (m->left > end && alive(m) > 0 && status == QG_OK)
            status = move_all(m);
        keep = (keep + 1) / 2;
        if (stages > 1)
            drop_worst(m, keep);
    }
    return status;
}

static enum qg_status run_round(struct multistart *m) {
    enum qg_status status = sample(m);
    m->runners = 0;
    if (status != QG_OK || m->left == 0)
        return status;
    while (m->runners < m->plan->starts && start_runner(m)) {
    }
    return race(m);
}

enum qg_status qg_multistart_search(const struct qg_multistart *plan, const struct qg_box *box,
                                    const struct qg_objective_function *objective) {
    assert(plan->starts >= 1 && plan->starts <= QG_STARTS_MAX);
    assert(plan->objectives >= 1 && plan->objectives <= QG_SEARCH_OBJECTIVES_MAX);
    struct multistart *m = calloc(1, sizeof *m);
    if (!m)
        return QG_OUT_OF_MEMORY;
    m->plan = plan;
    m->box = box;
    m->objective = objective;
    m->sequence = qg_sequence_of(plan->seed, box->dimensions);
    m->left = plan->evaluations;
    enum qg_status status = QG_OK;
    while (status == QG_OK && m->left > 0)
        status = run_round(m);
    free(m->samples.x);
    free(m->samples.f);
    free(m->samples.taken);
    free(m);
    return status;
}
