/* Random-Simplex, and the confidence interval of a counted share. */
#include "core/search.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/random.h"

enum qg_status qg_random_samples(const struct qg_box *box, uint64_t seed, size_t first, size_t count,
                                 const struct qg_objective_function *objective, struct qg_vertex *best) {
    double x[QG_SEARCH_BATCH * QG_SEARCH_DIMENSIONS_MAX], f[QG_SEARCH_BATCH];
    size_t d = box->dimensions;
    for (size_t done = 0; done < count;) {
        size_t n = count - done < QG_SEARCH_BATCH ? count - done : QG_SEARCH_BATCH;
        for (size_t i = 0; i < n; i++)
            for (size_t k = 0; k < d; k++) {
                double u = qg_random_uniform(seed, QG_STREAM_SEARCH, first + done + i, (uint32_t)k);
                x[i * d + k] = box->lower[k] + u * (box->upper[k] - box->lower[k]);
            }
        enum qg_status status = objective->values(objective->self, n, x, f);
        if (status != QG_OK)
            return status;
        for (size_t i = 0; i < n; i++)
            if (f[i] < best->f) {
                best->f = f[i];
                memcpy(best->x, x + i * d, d * sizeof *x);
            }
        done += n;
    }
    return QG_OK;
}

/* Insertion sort, stable: best first. */
static void sort_vertices(struct qg_simplex *s) {
    for (size_t i = 1; i <= s->box.dimensions; i++) {
        struct qg_vertex v = s->vertex[i];
        size_t k = i;
        for (; k > 0 && v.f < s->vertex[k - 1].f; k--)
            s->vertex[k] = s->vertex[k - 1];
        s->vertex[k] = v;
    }
}

/* Evaluates vertices 1 .. dimensions as one batch and sorts. */
static enum qg_status evaluate_all_but_first(struct qg_simplex *s) {
    size_t d = s->box.dimensions;
    double x[QG_SEARCH_DIMENSIONS_MAX * QG_SEARCH_DIMENSIONS_MAX] = {0}, f[QG_SEARCH_DIMENSIONS_MAX];
    for (size_t i = 0; i < d; i++)
        memcpy(x + i * d, s->vertex[i + 1].x, d * sizeof *x);
    enum qg_status status = s->objective.values(s->objective.self, d, x, f);
    for (size_t i = 0; i < d && status == QG_OK; i++)
        s->vertex[i + 1].f = f[i];
    if (status == QG_OK)
        sort_vertices(s);
    return status;
}

enum qg_status qg_simplex_init(struct qg_simplex *s, const struct qg_box *box,
                               const struct qg_objective_function *objective, const struct qg_vertex *start) {
    assert(box->dimensions >= 1 && box->dimensions <= QG_SEARCH_DIMENSIONS_MAX);
    *s = (struct qg_simplex){.box = *box, .objective = *objective};
    for (size_t i = 0; i <= box->dimensions; i++)
        s->vertex[i] = *start;
    for (size_t k = 0; k < box->dimensions; k++) {
        double step = 0.1 * (box->upper[k] - box->lower[k]);
        double *x = &s->vertex[k + 1].x[k];
        *x += *x + step <= box->upper[k] ? step : -step;
    }
    return evaluate_all_but_first(s);
}

/* centre + factor (centre - worst), clipped to the box, evaluated. */
static enum qg_status probe(const struct qg_simplex *s, const double *center, double factor, struct qg_vertex *out) {
    const struct qg_vertex *worst = &s->vertex[s->box.dimensions];
    for (size_t k = 0; k < s->box.dimensions; k++) {
        double x = center[k] + factor * (center[k] - worst->x[k]);
        out->x[k] = fmin(s->box.upper[k], fmax(s->box.lower[k], x));
    }
    return s->objective.values(s->objective.self, 1, out->x, &out->f);
}

static enum qg_status shrink(struct qg_simplex *s) {
    for (size_t i = 1; i <= s->box.dimensions; i++)
        for (size_t k = 0; k < s->box.dimensions; k++)
            s->vertex[i].x[k] = (s->vertex[0].x[k] + s->vertex[i].x[k]) / 2;
    return evaluate_all_but_first(s);
}

enum qg_status qg_simplex_iterate(struct qg_simplex *s) {
    size_t d = s->box.dimensions;
    double center[QG_SEARCH_DIMENSIONS_MAX] = {0};
    for (size_t i = 0; i < d; i++)
        for (size_t k = 0; k < d; k++)
            center[k] += s->vertex[i].x[k] / (double)d;
    struct qg_vertex reflected = {.f = INFINITY}, further = {.f = INFINITY}, *worst = &s->vertex[d];
    enum qg_status status = probe(s, center, 1, &reflected);
    if (status != QG_OK)
        return status;
    double second_worst = s->vertex[d - 1].f; /* for d = 1 the best */
    if (reflected.f >= s->vertex[0].f && reflected.f < second_worst) {
        *worst = reflected;
    } else {
        double factor = reflected.f < s->vertex[0].f ? 2 : reflected.f < worst->f ? 0.5 : -0.5;
        status = probe(s, center, factor, &further);
        if (status != QG_OK)
            return status;
        double to_beat = factor == -0.5 ? worst->f : reflected.f;
        if (further.f < to_beat || (factor == 0.5 && further.f == to_beat))
            *worst = further;
        else if (factor == 2)
            *worst = reflected;
        else
            return shrink(s);
    }
    sort_vertices(s);
    return QG_OK;
}

double qg_simplex_size(const struct qg_simplex *s) {
    double size = 0;
    for (size_t i = 1; i <= s->box.dimensions; i++)
        for (size_t k = 0; k < s->box.dimensions; k++) {
            double width = s->box.upper[k] - s->box.lower[k];
            if (width > 0)
                size = fmax(size, fabs(s->vertex[i].x[k] - s->vertex[0].x[k]) / width);
        }
    return size;
}

/* P(X >= k) for X binomial (n, p), 0 < p < 1. */
static double upper_tail(size_t k, size_t n, double p) {
    double sum = 0;
    for (size_t i = k; i <= n; i++) {
        double log_ways = lgamma((double)n + 1) - lgamma((double)i + 1) - lgamma((double)(n - i) + 1);
        sum += exp(log_ways + (double)i * log(p) + (double)(n - i) * log1p(-p));
    }
    return sum;
}

/* The p for which P(X >= k) = tail; P grows with p. */
static double probability_with_tail(size_t k, size_t n, double tail) {
    double low = 0, high = 1;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (upper_tail(k, n, middle) < tail)
            low = middle;
        else
            high = middle;
    }
    return (low + high) / 2;
}

void qg_binomial_confidence(size_t failures, size_t samples, double *low, double *high) {
    assert(samples >= 1 && failures <= samples);
    *low = failures == 0 ? 0 : probability_with_tail(failures, samples, 0.025);
    *high = failures == samples ? 1 : probability_with_tail(failures + 1, samples, 0.975);
}
