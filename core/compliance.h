/* How the flanks of one gear yield: the flexibility between points of its contact flanks, all teeth and the body included.
 *
 * One tooth sector is condensed to its contact flank f and its boundary b (both sides, and the bore where it is free to
 * turn); z condensed sectors form a ring, which the discrete Fourier transform over the teeth takes apart (cyclic symmetry).
 * What remains is three small dense matrices. The displacement of the flank of tooth j under forces on the flank of tooth k is
 *
 *     u_j = C_(j-k) f_k,     C_d = [d = 0] local + response ring_d response',     C_(-d) = C_d'
 *
 * Points of the tooth's root (the generated curve from space to form point, both sides of the tooth) know their stress as a
 * row over the same forces; root j under forces on the flanks k:
 *
 *     s_j = stress_local f_j + stress_boundary b_j,   b_j = - sum over k of ring_(j-k) response' f_k
 *
 * with components radial, tangential for every flank node in turn (counter-clockwise positive), tooth j + 1 following
 * tooth j counter-clockwise, contact flanks on the counter-clockwise side of the teeth.
 */
#ifndef QG_CORE_COMPLIANCE_H
#define QG_CORE_COMPLIANCE_H

#include "core/elasticity.h"

/* How the bore is held. */
enum qg_support {
    QG_SUPPORT_FIXED,      /* no displacement */
    QG_SUPPORT_TORQUE_RING /* radially rigid, tangentially loaded by a uniform traction that balances the torque;
                              displacements are measured from the mean rotation of the bore */
};

/* All matrices column-major. n = 2 flank_count components, m = boundary. */
struct qg_compliance {
    size_t flank_count;
    double *flank_arc;       /* mm, [flank_count]; see mesh.h */
    struct qg_polar *flank;  /* [flank_count] */
    size_t boundary;         /* m */
    int reach;               /* largest |d| of ring */
    double *local;           /* mm/N, n x n: flank against flank with the boundary held */
    double *response;        /* n x m: minus the flank's displacement per boundary displacement */
    double *ring;            /* mm/N, (reach + 1) blocks of m x m: boundary of sector d per force at that of sector 0 */
    size_t root_count;       /* p: points of stress, corners and middles of element edges in turn; the first half below
                                  the contact flank, the other half opposite, each from the middle of the space up to the
                                  last edge before the form point */
    struct qg_polar *root;   /* [p] */
    double *stress_local;    /* MPa/N, p x n: stress along the root's surface, with the boundary held */
    double *stress_boundary; /* MPa/mm, p x m: per displacement of the boundary, the flank being free */
    size_t degrees_of_freedom; /* of the sector before condensation */
};

/* The gear that a sector belongs to. */
struct qg_compliance_plan {
    struct qg_plate plate;
    enum qg_support support;
    int teeth;
    int reach;           /* compliances are wanted for tooth distances up to this */
    struct qg_stop stop; /* asked before and after a factorization, and for every Fourier order of the ring */
};

/* Computes the compliance of a gear from the mesh of its sector. QG_OUT_OF_MEMORY, QG_NO_CONVERGENCE (a factorization
 * failed), or QG_CANCELLED when the plan's stop said so; compliance is empty then. */
enum qg_status qg_compliance_init(struct qg_compliance *compliance, const struct qg_sector_mesh *mesh,
                                  const struct qg_compliance_plan *plan);
void qg_compliance_finish(struct qg_compliance *compliance);

/* One entry of C_d (mm/N): displacement component `row` on tooth `distance` per force component `column` on tooth 0.
 * Slow (a bilinear form); for tests and single values. */
double qg_compliance_entry(const struct qg_compliance *compliance, int distance, size_t row, size_t column);

/* Stress influence (MPa/N): out (p x n, column-major) is what forces on the flank of tooth 0 cause in the root of the
 * tooth `distance` (-reach .. reach) counter-clockwise of it. QG_OUT_OF_MEMORY. */
enum qg_status qg_compliance_stress(const struct qg_compliance *compliance, int distance, double *out);

#endif
