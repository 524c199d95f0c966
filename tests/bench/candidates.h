/* Search methods that were weighed against those of core, and lost: kept for `make compare-searches` alone.
 *
 * All search the unit cube scaled to a box, in batches of at most QG_SEARCH_BATCH, and go on until the objective answers
 * something else than QG_OK, which is then their answer: the budget is the objective's.
 */
#ifndef QG_TESTS_BENCH_CANDIDATES_H
#define QG_TESTS_BENCH_CANDIDATES_H

#include "core/search.h"

/* CMA-ES (Hansen, "The CMA evolution strategy: a tutorial", 2016): population 16, from the best of `samples`
 * low-discrepancy points with a step of a fifth of the box, restarted from a random point when it has shrunk below a
 * thousandth. Points beyond the box are mirrored into it, and count as the mirrored ones. */
enum qg_status cma_es(const struct qg_box *box, const struct qg_objective_function *objective, uint64_t seed,
                      size_t samples);

/* Differential evolution, current-to-best/1/bin (Storn and Price 1997): population 32, crossover 0.8, step 0.5 towards the
 * best, factor 0.4 .. 0.9 of the difference; beyond the box half way to it. */
enum qg_status differential_evolution(const struct qg_box *box, const struct qg_objective_function *objective,
                                      uint64_t seed);

/* NSGA-II (Deb, Pratap, Agarwal, Meyarivan 2002) for two objectives: population 32, simulated binary crossover (index 15),
 * polynomial mutation (index 20) of one in `dimensions` coordinates. The objective's f takes two values a point. */
enum qg_status nsga_ii(const struct qg_box *box, const struct qg_objective_function *objective, uint64_t seed);

#endif
