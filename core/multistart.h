/* Multi-start simplex: low-discrepancy samples, then several simplexes at once from the best samples, the worse ones given up
 * on the way; for one objective or for the Pareto front of several.
 *
 * A round, for a budget of R evaluations:
 *   1. 3/10 of R are points of the sequence of sequence.h;
 *   2. the best of them that lie apart from each other (by 0.15 of the box's diagonal) each start a simplex (search.h);
 *   3. the simplexes advance together, one move each a batch, so that batches are wide. By successive halving (Jamieson and
 *      Talwalkar 2016) what remains of R is cut into equal stages: K simplexes in the first, K/2 rounded up in the next, and so
 *      on down to one; who has the smallest value stays.
 * A simplex that is smaller than a thousandth of the box is finished. When all are, the next round begins with what is left
 * of the budget, and the sequence goes on where it was. Exactly `evaluations` are made.
 *
 * With several objectives each simplex minimizes a scalar of its own, the augmented weighted Tchebycheff norm
 *     s_j(f) = max_k w_jk f_k + 0.05 sum_k w_jk f_k
 * (Steuer and Choo 1983), whose minimum lies on the front wherever that is, be it convex or not; weights w_j run evenly over
 * the trade-offs, none is given up. Objectives should be positive and of like size: ratios to a reference. The front itself
 * is drawn from all evaluations (front.h).
 *
 * Why this and not another method: docs/searches.md, printed by `make compare-searches`.
 */
#ifndef QG_CORE_MULTISTART_H
#define QG_CORE_MULTISTART_H

#include "core/search.h"

enum { QG_STARTS_MAX = 16, QG_SEARCH_OBJECTIVES_MAX = 3 };

struct qg_multistart {
    size_t evaluations; /* >= 1 */
    size_t starts;      /* simplexes at first, 1 .. QG_STARTS_MAX */
    size_t objectives;  /* values of a point, 1 .. QG_SEARCH_OBJECTIVES_MAX */
    uint64_t seed;
};

/* Makes `evaluations` of the objective, in batches of at most QG_SEARCH_BATCH whose sequence depends on the arguments and the
 * values alone. objective's f takes n * objectives values, row by row. What is best the caller sees by itself: every
 * evaluation passes through it. QG_OUT_OF_MEMORY, or the objective's status when that is not QG_OK. */
enum qg_status qg_multistart_search(const struct qg_multistart *plan, const struct qg_box *box,
                                    const struct qg_objective_function *objective);

#endif
