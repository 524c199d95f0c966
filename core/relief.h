/* Tip and root reliefs: micrometres taken off the involute, normal to it.
 *
 * Tip relief: 0 up to a start radius, growing to its amplitude at the outside radius. Root relief: 0 down to an end
 * radius, growing to its amplitude at the form radius. Linear or parabolic (the square of the same ramp), over radius or
 * over roll angle.
 */
#ifndef QG_CORE_RELIEF_H
#define QG_CORE_RELIEF_H

#include <stdbool.h>

#include "core/pair.h"

enum qg_relief_shape { QG_SHAPE_LINEAR, QG_SHAPE_PARABOLIC };
enum qg_relief_ramp { QG_RAMP_RADIUS, QG_RAMP_ROLL_ANGLE };

/* One ramp. present false: nothing is removed, the other members are ignored. */
struct qg_ramp {
    bool present;
    double radius;    /* mm: start radius of a tip relief, end radius of a root relief */
    double amplitude; /* mm */
};

/* The reliefs of both gears: one design. */
struct qg_relief {
    enum qg_relief_shape shape;
    enum qg_relief_ramp ramp;
    struct {
        struct qg_ramp tip, root;
    } gears[2];
};

/* The eight numbers that a search may move, in this order. */
enum qg_parameter {
    QG_PINION_TIP_START_RADIUS,
    QG_PINION_TIP_AMPLITUDE,
    QG_PINION_ROOT_END_RADIUS,
    QG_PINION_ROOT_AMPLITUDE,
    QG_GEAR_TIP_START_RADIUS,
    QG_GEAR_TIP_AMPLITUDE,
    QG_GEAR_ROOT_END_RADIUS,
    QG_GEAR_ROOT_AMPLITUDE,
    QG_PARAMETER_COUNT
};

/* True for the four radii, false for the four amplitudes. */
bool qg_parameter_is_radius(enum qg_parameter parameter);

/* The place in relief where the parameter lives (mm), and the ramp it belongs to. */
double *qg_relief_parameter(struct qg_relief *relief, enum qg_parameter parameter);
struct qg_ramp *qg_relief_ramp_of(struct qg_relief *relief, enum qg_parameter parameter);

/* Material removed (mm, normal to the involute) at a radius of one gear's flank, tip and root together. */
double qg_relief_depth(const struct qg_relief *relief, const struct qg_pair_geometry *geometry,
                       const struct qg_gear_pair *pair, int gear, double radius);

/* The deepest relief that is allowed on a gear (mm): half of its tip thickness, and at most 0.04 modules, which is several
 * times what gears are given and bounds the gaps that statics.h makes ready. */
double qg_relief_deepest(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, int gear);

/* Checks a design against the pair: start radius between form and outside radius, amplitudes from 0 to the deepest
 * relief. Faults go to errors (where: "pinion.tip.start_radius", ...), things that do nothing (a root relief ending
 * below the form radius) to warnings; both may be NULL. Returns QG_OK or QG_IMPOSSIBLE_GEAR. */
enum qg_status qg_relief_check(const struct qg_relief *relief, const struct qg_gear_pair *pair,
                               const struct qg_pair_geometry *geometry, struct qg_notes *errors,
                               struct qg_notes *warnings);

#endif
