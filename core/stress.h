/* Stresses of a loaded pair over the mesh period: in the roots of the teeth, and the contact pressure along the path.
 *
 * Root. Compliance keeps a row per point of the generated root: the stress along the surface there per force on any flank
 * (compliance.h). The surface being free, that stress is the only principal one in the plane that is not zero; where it is
 * positive it is the largest principal stress. A tooth bends away from its load, so the fillet below its contact flank is in
 * tension, the one behind it in compression; the loads on neighbouring teeth and the body's rim are in the rows as well.
 * Plane elements spread a load over the gear's own face width, also where the mate is narrower.
 *
 * Pressure. The largest of each pair of teeth at each mesh position, against where on the line of action the bare involutes of
 * that pair touch. What statics.h says of tip corners and kinks holds.
 */
#ifndef QG_CORE_STRESS_H
#define QG_CORE_STRESS_H

#include "core/nodal.h"

/* Stress at a point of a root. */
struct qg_root_stress {
    double stress;      /* MPa, tension positive */
    struct qg_polar at; /* about the gear's axis, angle from the tooth's centre line, > 0 on the contact flank's side */
    int pair;           /* which pair of teeth the tooth belongs to */
    int on_contact_side; /* 1: below the contact flank, 0: on the other side of the tooth */
};

/* The largest pressure between a pair of teeth; all 0 where it carries nothing. */
struct qg_pair_pressure {
    double pressure; /* MPa */
    double
        path; /* mm, of the pair's theoretical contact along the line of action, from the pinion's point of tangency */
    double radius[2]; /* mm, of the place on the pinion's and on the gear's flank */
};

/* All stresses of one load case of one design. */
struct qg_stresses {
    size_t positions;
    struct qg_root_stress *tension[2];     /* [positions] the largest in any root of the gear */
    struct qg_root_stress *compression[2]; /* [positions] the smallest */
    struct qg_pair_pressure *pressure;     /* [positions * pairs], as load_share in model.h */
    size_t pairs;
    size_t most_tension[2], most_compression[2], most_pressure; /* where the extremes over the period stand */
};

/* Room for the stresses of `positions` positions and `pairs` pairs of teeth, zeroed. NULL when memory is short. */
struct qg_stresses *qg_stresses_create(size_t positions, size_t pairs);
void qg_stresses_destroy(struct qg_stresses *stresses);

/* Finds the extremes over the period; the arrays are filled. The first of equals. */
void qg_stresses_summarize(struct qg_stresses *stresses);

/* Stress influence of a pair of gears. */
struct qg_stress_rows {
    int reach;              /* largest distance between loaded tooth and root */
    size_t points[2];       /* root points per tooth */
    size_t components[2];   /* of a flank's forces */
    struct qg_polar *at[2]; /* [points] */
    double *influence[2];   /* MPa/N, (2 reach + 1) blocks of points x components: the root d = -reach .. reach teeth
                                counter-clockwise of the load */
};

/* Makes the rows for distances up to reach, at most the compliances'; stop is asked before each. QG_OUT_OF_MEMORY or
 * QG_CANCELLED; rows are the caller's to finish, whatever the status. */
enum qg_status qg_stress_rows_init(struct qg_stress_rows *rows, const struct qg_compliance compliance[2], int reach,
                                   const struct qg_stop *stop);
void qg_stress_rows_finish(struct qg_stress_rows *rows);

/* Adds to stress[points] (MPa) what `load` (N), spread as given, causes in the root `distance` teeth counter-clockwise of
 * it; nothing beyond the reach. */
void qg_stress_add(const struct qg_stress_rows *rows, int gear, int distance, const struct qg_packed_spread *spread,
                   double load, double *stress);

/* The largest and the smallest of a tooth's root stresses into *tension and *compression when they beat what stands there. */
void qg_stress_extremes(const struct qg_stress_rows *rows, int gear, int pair, const double *stress,
                        struct qg_root_stress *tension, struct qg_root_stress *compression);

#endif
