/* Two gears in mesh: the pair's data, and what follows from them.
 *
 * The contact runs along the line of action, common tangent of both base circles. A place on it is given by
 * xi, the distance from the point where the line touches the pinion's base circle; xi of the gear is length - xi.
 */
#ifndef QG_CORE_PAIR_H
#define QG_CORE_PAIR_H

#include "core/gear.h"

struct qg_material {
    double youngs_modulus; /* MPa */
    double poisson_ratio;  /* 0 <= . < 0.5 */
    double density;        /* kg/mm3 */
};

/* A gear pair as the designer gives it. */
struct qg_gear_pair {
    struct qg_rack rack;
    double center_distance; /* mm */
    struct qg_gear gears[2];
    struct qg_material material;
    double damping_ratio;  /* zeta, share of critical, 0 < . < 1 */
    double nominal_torque; /* N mm, on the pinion */
};

/* What follows from a pair. Lengths in mm along the line of action where nothing else is said. */
struct qg_pair_geometry {
    struct qg_gear_geometry gears[2];
    double working_pressure_angle; /* rad */
    double base_pitch;             /* 2 pi r_b1 / z1 */
    double line_length;            /* between the two points of tangency: a sin(alpha_w) */
    double path_start;             /* xi where contact begins: the gear's tip */
    double path_end;               /* xi where it ends: the pinion's tip */
    double contact_ratio;          /* (path_end - path_start) / base_pitch */
    double backlash;               /* 2b, normal backlash */
    double equivalent_mass;        /* kg, I1 I2 / (I1 r_b2^2 + I2 r_b1^2) */
    double face_width;             /* mm, the smaller: contact takes place over it */
    double tip_clearance[2];       /* mm, between this gear's tip and the other one's root */
};

/* Derives both gears and the pair, and refuses with every reason found: faults of each gear, negative backlash, tip
 * that reaches below the mate's form radius (interference), tip-to-root collision, contact ratio below 1.
 * Returns QG_OK or QG_IMPOSSIBLE_GEAR. */
enum qg_status qg_pair_derive(const struct qg_gear_pair *pair, struct qg_pair_geometry *out, struct qg_notes *notes);

/* Where the bare involutes of a pair of teeth touch: xi (mm) at a mesh position (in mesh periods, growing with rotation).
 * Pair 0 is at the middle of the path of contact at position 0.5; each next pair is one base pitch ahead. The teeth touch when
 * it lies between path_start and path_end. */
double qg_path_position(const struct qg_pair_geometry *geometry, double position, int pair);

#endif
