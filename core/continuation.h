/* One curve of periodic orbits over the frequency ratio, by pseudo-arclength continuation; for branches.c and tests.
 */
#ifndef QG_CORE_CONTINUATION_H
#define QG_CORE_CONTINUATION_H

#include "core/branches.h"
#include "core/orbit.h"

/* A point or direction in the space of the continuation: Poincare state and frequency ratio. */
struct qg_place {
    double x, v, p;
};

/* A period doubling on a traced curve, from which the branch of twice the period starts. */
struct qg_doubling {
    int period; /* of the branch that doubles */
    struct qg_place at;
    struct qg_state direction; /* eigenvector of the multiplier -1, of length 1 */
};

enum { QG_DOUBLINGS_MAX = 64 };

struct qg_continuation {
    const struct qg_oscillator *oscillator;
    double min, max; /* of the frequency ratio */
    const struct qg_stop *stop;
    size_t doubling_count; /* met so far; those beyond the room are counted in `doublings_lost` */
    size_t doublings_lost;
    struct qg_doubling doubling[QG_DOUBLINGS_MAX];
};

/* Traces the curve through an orbit in both directions. curve is zeroed by the caller and owned by it whatever the
 * status: QG_OK, QG_OUT_OF_MEMORY, QG_CANCELLED, or QG_NO_CONVERGENCE when `from` is no orbit. */
enum qg_status qg_continue_orbit(struct qg_continuation *c, const struct qg_orbit *from, struct qg_curve *curve);

/* Traces the branch of twice the period that starts at a period doubling; likewise. */
enum qg_status qg_continue_doubling(struct qg_continuation *c, const struct qg_doubling *from, struct qg_curve *curve);

/* Whether an orbit lies on a curve, up to a shift by whole mesh periods: within a tenth of the length of the curve's
 * segment there, which is far less than the distance of different branches. */
bool qg_curve_has(const struct qg_curve *curve, const struct qg_orbit *orbit);

/* Frees what a curve holds. */
void qg_curve_finish(struct qg_curve *curve);

#endif
