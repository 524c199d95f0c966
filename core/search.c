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

/* The next move is a reflection. */
static void begin_iteration(struct qg_simplex *s) {
    size_t d = s->box.dimensions;
    memset(s->center, 0, sizeof s->center);
    for (size_t i = 0; i < d; i++)
        for (size_t k = 0; k < d; k++)
            s->center[k] += s->vertex[i].x[k] / (double)d;
    s->stage = QG_SIMPLEX_REFLECTION;
    s->factor = 1;
}

void qg_simplex_span(struct qg_simplex *s, const struct qg_box *box, const struct qg_vertex *start) {
    assert(box->dimensions >= 1 && box->dimensions <= QG_SEARCH_DIMENSIONS_MAX);
    *s = (struct qg_simplex){.box = *box, .stage = QG_SIMPLEX_VERTICES};
    for (size_t i = 0; i <= box->dimensions; i++)
        s->vertex[i] = *start;
    for (size_t k = 0; k < box->dimensions; k++) {
        double step = 0.1 * (box->upper[k] - box->lower[k]);
        double *x = &s->vertex[k + 1].x[k];
        *x += *x + step <= box->upper[k] ? step : -step;
    }
}

/* center + factor (center - worst), clipped to the box. */
static void trial_point(const struct qg_simplex *s, double *out) {
    const struct qg_vertex *worst = &s->vertex[s->box.dimensions];
    for (size_t k = 0; k < s->box.dimensions; k++) {
        double x = s->center[k] + s->factor * (s->center[k] - worst->x[k]);
        out[k] = fmin(s->box.upper[k], fmax(s->box.lower[k], x));
    }
}

size_t qg_simplex_ask(const struct qg_simplex *s, double *x) {
    size_t d = s->box.dimensions;
    if (s->stage != QG_SIMPLEX_VERTICES) {
        trial_point(s, x);
        return 1;
    }
    for (size_t i = 0; i < d; i++)
        memcpy(x + i * d, s->vertex[i + 1].x, d * sizeof *x);
    return d;
}

/* Puts a vertex in the place of the worst; the iteration is over. */
static bool replace_worst(struct qg_simplex *s, const struct qg_vertex *vertex) {
    s->vertex[s->box.dimensions] = *vertex;
    sort_vertices(s);
    begin_iteration(s);
    return true;
}

static bool shrink(struct qg_simplex *s) {
    for (size_t i = 1; i <= s->box.dimensions; i++)
        for (size_t k = 0; k < s->box.dimensions; k++)
            s->vertex[i].x[k] = (s->vertex[0].x[k] + s->vertex[i].x[k]) / 2;
    s->stage = QG_SIMPLEX_VERTICES;
    return false;
}

static bool tell_reflection(struct qg_simplex *s, const struct qg_vertex *reflected) {
    size_t d = s->box.dimensions;
    double second_worst = s->vertex[d - 1].f; /* for d = 1 the best */
    if (reflected->f >= s->vertex[0].f && reflected->f < second_worst)
        return replace_worst(s, reflected);
    s->reflected = *reflected;
    s->factor = reflected->f < s->vertex[0].f ? 2 : reflected->f < s->vertex[d].f ? 0.5 : -0.5;
    s->stage = QG_SIMPLEX_SECOND;
    return false;
}

static bool tell_second(struct qg_simplex *s, const struct qg_vertex *further) {
    double to_beat = s->factor == -0.5 ? s->vertex[s->box.dimensions].f : s->reflected.f;
    if (further->f < to_beat || (s->factor == 0.5 && further->f == to_beat))
        return replace_worst(s, further);
    return s->factor == 2 ? replace_worst(s, &s->reflected) : shrink(s);
}

bool qg_simplex_tell(struct qg_simplex *s, const double *f) {
    if (s->stage == QG_SIMPLEX_VERTICES) {
        for (size_t i = 0; i < s->box.dimensions; i++)
            s->vertex[i + 1].f = f[i];
        sort_vertices(s);
        begin_iteration(s);
        return true;
    }
    struct qg_vertex trial = {.f = f[0]};
    trial_point(s, trial.x);
    return s->stage == QG_SIMPLEX_REFLECTION ? tell_reflection(s, &trial) : tell_second(s, &trial);
}

/* Asks, evaluates and tells until an iteration is over. */
static enum qg_status advance(struct qg_simplex *s) {
    double x[QG_SEARCH_DIMENSIONS_MAX * QG_SEARCH_DIMENSIONS_MAX], f[QG_SEARCH_DIMENSIONS_MAX];
    for (;;) {
        size_t n = qg_simplex_ask(s, x);
        enum qg_status status = s->objective.values(s->objective.self, n, x, f);
        if (status != QG_OK || qg_simplex_tell(s, f))
            return status;
    }
}

enum qg_status qg_simplex_init(struct qg_simplex *s, const struct qg_box *box,
                               const struct qg_objective_function *objective, const struct qg_vertex *start) {
    qg_simplex_span(s, box, start);
    s->objective = *objective;
    return advance(s);
}

enum qg_status qg_simplex_iterate(struct qg_simplex *s) {
    return advance(s);
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
