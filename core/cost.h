/* What a study will cost, before it is run.
 *
 * Counts of the parts of a study times the time that each takes on one core of the machine of docs/performance.md, by these
 * laws: finite elements and operators grow with the third power of the refinement and the operators with the mesh
 * positions; a contact problem with the square of the refinement, one per position and load case; a speed map with the speeds
 * and load cases, by a factor for each branch and mesh stiffness; macro-geometries by the million. What depends on what the
 * computation meets (orbits that settle late, simplexes that end early) is taken as it usually is, so a study may take half
 * of it or twice as much, and a machine without the wide vectors of that one three times as much.
 */
#ifndef QG_CORE_COST_H
#define QG_CORE_COST_H

#include "core/study.h"

struct qg_cost {
    double evaluations;       /* designs judged by the search, the trials and the cells, the given one included */
    double processor_seconds; /* of one core */
};

/* The cost of a checked study. Both figures are finite and positive. Threads: any. */
struct qg_cost qg_study_cost(const struct qg_study *study);

#endif
