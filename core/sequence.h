/* A low-discrepancy sequence: points that fill the unit cube more evenly than independent random ones.
 *
 * The Kronecker sequence x_i = frac(s + i a) with Richtmyer's steps (1951): a_k is the square root of the k-th prime. Those
 * are independent over the rationals, so the sequence is equidistributed (Weyl 1916); each coordinate by itself is as even as
 * quadratic irrationals make it. The shift s is uniform and comes from the seed (Cranley and Patterson 1976): each point
 * by itself is uniformly distributed.
 */
#ifndef QG_CORE_SEQUENCE_H
#define QG_CORE_SEQUENCE_H

#include <stddef.h>
#include <stdint.h>

enum { QG_SEQUENCE_DIMENSIONS_MAX = 16 };

struct qg_sequence {
    size_t dimensions;
    double shift[QG_SEQUENCE_DIMENSIONS_MAX], step[QG_SEQUENCE_DIMENSIONS_MAX];
};

/* The sequence of a seed; 1 <= dimensions <= QG_SEQUENCE_DIMENSIONS_MAX. */
struct qg_sequence qg_sequence_of(uint64_t seed, size_t dimensions);

/* Point `index`, from 0: `dimensions` coordinates in [0, 1). Any order, any thread. */
void qg_sequence_point(const struct qg_sequence *sequence, size_t index, double *u);

#endif
