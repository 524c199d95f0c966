/* A Pareto front: of all designs judged, those that no other one beats.
 *
 * One design dominates another when it is no worse in any objective and better in at least one; all objectives are to be
 * small. The front keeps what is not dominated; of designs with the same values in all objectives, the first.
 */
#ifndef QG_CORE_FRONT_H
#define QG_CORE_FRONT_H

#include "core/relief.h"
#include "core/status.h"

enum { QG_FRONT_OBJECTIVES_MAX = 3 };

/* A design on the front. */
struct qg_front_member {
    size_t evaluation; /* its number in the study */
    struct qg_relief relief;
    double f_pps;                          /* mm */
    double f_dte;                          /* half-backlashes */
    double f_dte_percentile;               /* NaN where it was not asked for */
    double value[QG_FRONT_OBJECTIVES_MAX]; /* the objectives, in the units of the study's search */
};

/* Zeroed but for `objectives` (1 .. QG_FRONT_OBJECTIVES_MAX) it is an empty front. */
struct qg_front {
    size_t objectives;
    size_t count, room;
    struct qg_front_member *member; /* owned; ascending in the first objective */
};

/* Lets a design compete: it joins and drives out those that it dominates, or is left away. A NaN among its values keeps it
 * out. *joined (may be NULL) says which. QG_OUT_OF_MEMORY leaves the front as it was. */
enum qg_status qg_front_add(struct qg_front *front, const struct qg_front_member *member, bool *joined);

/* Volume of what the front dominates within the box from the origin to `corner` (`objectives` numbers), as a share of that
 * box: 0 is nothing, more is better (Zitzler and Thiele 1998). By slicing along one objective after the other (While,
 * Hingston, Barone and Huband 2006). Members beyond the corner count for nothing. */
double qg_front_hypervolume(const struct qg_front *front, const double *corner);

/* Frees what the front holds and empties it. */
void qg_front_finish(struct qg_front *front);

#endif
