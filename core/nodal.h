/* Loads at points of a flank as forces on its nodes, and how two such loads see each other through a gear.
 *
 * A contact point spreads its load over the nodes of a few element edges; the flexibility between two points is then a small
 * bilinear form in the flank-to-flank matrix of the gear (compliance.h).
 */
#ifndef QG_CORE_NODAL_H
#define QG_CORE_NODAL_H

#include "core/compliance.h"

/* A point's pressure reaches at most this many nodes of a flank. */
enum { QG_SPREAD_NODES = 24 };

/* A unit load as forces on nodes of a flank: radial and tangential components of nodes first .. first + count - 1. */
struct qg_spread {
    size_t first, count;
    double weight[2 * QG_SPREAD_NODES];
};

/* Distance (mm) between nodes around an arc length of the flank. */
double qg_node_distance(const struct qg_compliance *compliance, double arc);

/* Adds weight times the unit force along `direction` (absolute angle in the gear's frame) at an arc length of the flank. What
 * a spread holds must be added in the order of the flank, from its first edge on. */
void qg_spread_add(struct qg_spread *spread, const struct qg_compliance *compliance, double arc, double direction,
                   double weight);

/* The flank-to-flank matrices C_d of both gears, d = 0 .. reach. */
struct qg_flank_matrices {
    size_t n[2]; /* components per flank */
    double *c[2];
    int reach;
};

/* Computes them, reach at most the compliances'; stop is asked before each distance. QG_OUT_OF_MEMORY or QG_CANCELLED;
 * matrices are the caller's to finish, whatever the status. */
enum qg_status qg_flank_matrices_init(struct qg_flank_matrices *matrices, const struct qg_compliance compliance[2],
                                      int reach, const struct qg_stop *stop);
void qg_flank_matrices_finish(struct qg_flank_matrices *matrices);

/* mm/N: what a unit load spread as b moves the point spread as a, on the tooth `distance` counter-clockwise of b's. */
double qg_flank_flexibility(const struct qg_flank_matrices *matrices, int gear, int distance, const struct qg_spread *a,
                            const struct qg_spread *b);

/* The spreads of the points of one mesh position, without their empty rooms. */
struct qg_packed_spread {
    size_t first, count;
    const double *weight; /* [2 count], in the same allocation as the array of them */
};

/* Packs n pairs of spreads (pinion, gear) into one allocation, freed with free(). NULL when memory is short. */
struct qg_packed_spread (*qg_spreads_pack(struct qg_spread (*spread)[2], size_t n))[2];

#endif
