/* The shifted Kronecker sequence. See sequence.h. */
#include "core/sequence.h"

#include <assert.h>
#include <math.h>

#include "core/random.h"

static const double primes[QG_SEQUENCE_DIMENSIONS_MAX] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};

struct qg_sequence qg_sequence_of(uint64_t seed, size_t dimensions) {
    assert(dimensions >= 1 && dimensions <= QG_SEQUENCE_DIMENSIONS_MAX);
    struct qg_sequence s = {.dimensions = dimensions};
    for (size_t k = 0; k < dimensions; k++) {
        s.step[k] = sqrt(primes[k]) - floor(sqrt(primes[k]));
        s.shift[k] = qg_random_uniform(seed, QG_STREAM_SEQUENCE, 0, (uint32_t)k);
    }
    return s;
}

void qg_sequence_point(const struct qg_sequence *s, size_t index, double *u) {
    for (size_t k = 0; k < s->dimensions; k++) {
        double x = s->shift[k] + (double)index * s->step[k];
        u[k] = x - floor(x);
    }
}
