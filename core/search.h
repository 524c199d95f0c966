/* Search in a box: uniform random samples, then Nelder-Mead from the best of them ("Random-Simplex" of the 2011 paper).
 *
 * A search hands over n points and gets n values; it cannot tell who computes them, where, or whether they come from a log.
 */
#ifndef QG_CORE_SEARCH_H
#define QG_CORE_SEARCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/status.h"

enum { QG_SEARCH_DIMENSIONS_MAX = 16, QG_SEARCH_BATCH = 16 };

/* The seam. x holds n points of `dimensions` coordinates, row by row; f takes n values. Anything but QG_OK ends the search
 * with that status. */
struct qg_objective_function {
    void *self;
    enum qg_status (*values)(void *self, size_t n, const double *x, double *f);
};

struct qg_box {
    size_t dimensions; /* 1 .. QG_SEARCH_DIMENSIONS_MAX */
    double lower[QG_SEARCH_DIMENSIONS_MAX], upper[QG_SEARCH_DIMENSIONS_MAX];
};

/* A point and its value. */
struct qg_vertex {
    double x[QG_SEARCH_DIMENSIONS_MAX];
    double f;
};

/* Uniform samples first .. first + count - 1 of the sequence of a seed, in batches of at most QG_SEARCH_BATCH. *best is
 * improved when a sample is strictly better (set best->f to INFINITY at first). */
enum qg_status qg_random_samples(const struct qg_box *box, uint64_t seed, size_t first, size_t count,
                                 const struct qg_objective_function *objective, struct qg_vertex *best);

/* What a simplex waits for. */
enum qg_simplex_stage {
    QG_SIMPLEX_VERTICES,   /* the values of vertices 1 .. dimensions: at the beginning and after a shrinkage */
    QG_SIMPLEX_REFLECTION, /* that of the worst vertex, reflected */
    QG_SIMPLEX_SECOND      /* that of the expanded or contracted one */
};

/* Nelder-Mead (Nelder and Mead 1965, standard coefficients 1, 2, 1/2, 1/2) with every trial point clipped to the box.
 * Made to be advanced one iteration at a time, or, by asking and telling, one batch of points at a time. */
struct qg_simplex {
    struct qg_box box;
    struct qg_objective_function objective;                /* not used by qg_simplex_ask and qg_simplex_tell */
    struct qg_vertex vertex[QG_SEARCH_DIMENSIONS_MAX + 1]; /* best first */
    enum qg_simplex_stage stage;
    double center[QG_SEARCH_DIMENSIONS_MAX]; /* of all vertices but the worst */
    double factor;                           /* of the point that is waited for: center + factor (center - worst) */
    struct qg_vertex reflected;              /* known in QG_SIMPLEX_SECOND */
};

/* Spans the first simplex as qg_simplex_init does, without evaluating it: its first batch are vertices 1 .. dimensions. */
void qg_simplex_span(struct qg_simplex *simplex, const struct qg_box *box, const struct qg_vertex *start);

/* The points that the simplex wants evaluated next, row by row into x: one, or `dimensions` of them. Returns how many. */
size_t qg_simplex_ask(const struct qg_simplex *simplex, double *x);

/* Takes the values of the points that qg_simplex_ask gives, all of them, and moves. True when that ends an iteration (or
 * the evaluation of the first simplex): vertices are sorted, vertex[0] is the best so far. */
bool qg_simplex_tell(struct qg_simplex *simplex, const double *f);

/* Spans the first simplex from a known vertex by steps of a tenth of the box, inwards where the box ends, and evaluates it
 * as one batch. */
enum qg_status qg_simplex_init(struct qg_simplex *simplex, const struct qg_box *box,
                               const struct qg_objective_function *objective, const struct qg_vertex *start);

/* One iteration: reflection, then expansion, contraction or shrinkage. vertex[0] is the best so far. */
enum qg_status qg_simplex_iterate(struct qg_simplex *simplex);

/* Largest extent of the simplex, as a share of the box. */
double qg_simplex_size(const struct qg_simplex *simplex);

/* 95 % confidence interval of a probability of which `failures` of `samples` trials came true (Clopper and Pearson 1934:
 * exact, never too narrow). samples >= 1. */
void qg_binomial_confidence(size_t failures, size_t samples, double *low, double *high);

#endif
