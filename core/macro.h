/* Macro-geometry: what is asked when an equivalent pair is looked for, and what a sample has to satisfy.
 *
 * Ten parameters of a pair are drawn uniformly within ranges (teeth x 2, module, pressure angle, profile shifts x 2,
 * outside radii x 2, root radii x 2). Centre distance, face widths, bores, material, damping and torque are those of an
 * initial pair, as is a moment of inertia that the user has given. Constraints say which samples are possible and
 * equivalent; they are tested in a fixed order, and the first that is violated rejects the sample. The method is that of
 * Faggioni, Samani, Bertacchi, Pellicano, Mech. Mach. Theory 46 (2011) 544-557, section 6.
 */
#ifndef QG_CORE_MACRO_H
#define QG_CORE_MACRO_H

#include <stdbool.h>
#include <stdint.h>

#include "core/pair.h"

/* Both ends included; low == high fixes a parameter. */
struct qg_interval {
    double low, high;
};

/* Where a parameter is drawn. An interval whose low end is NaN was not given: qg_macro_complete. */
struct qg_macro_ranges {
    struct qg_interval module; /* mm */
    struct qg_interval
        pressure_angle_deg; /* degrees, so that a pair written down in degrees is the same one when read */
    struct {
        struct qg_interval teeth;          /* whole numbers */
        struct qg_interval profile_shift;  /* mm */
        struct qg_interval outside_radius; /* mm */
        struct qg_interval root_radius;    /* mm */
        double hob_tip_radius;             /* mm, given; negative: as large as fits */
    } gears[2];
};

/* What a sample has to satisfy beyond being a pair that runs. */
struct qg_macro_limits {
    double ratio_percent;         /* largest departure from the initial pair's ratio z2/z1, percent of it */
    struct qg_interval backlash;  /* mm, normal backlash; low end NaN: not given */
    double tip_thickness;         /* modules, smallest */
    double tip_clearance;         /* modules, smallest */
    double contact_stress_factor; /* largest, as a share of the initial pair's */
    double root_stress_factor;    /* largest, as a share of the initial pair's */
};

enum { QG_MACRO_KEEP_MAX = 100 };

struct qg_macro {
    uint64_t samples; /* >= 1 */
    uint64_t seed;
    size_t keep; /* 1 .. QG_MACRO_KEEP_MAX */
    struct qg_macro_ranges ranges;
    struct qg_macro_limits limits;
};

/* The constraints in the order in which they are tested: enum, name, what a sample must have. */
#define QG_MACRO_TABLE(X)                                                                                              \
    X(QG_MACRO_RATIO, "ratio", "a transmission ratio near the initial one")                                            \
    X(QG_MACRO_CENTER_DISTANCE, "center_distance", "base circles that fit between the axes")                           \
    X(QG_MACRO_BACKLASH, "backlash", "a backlash within its limits")                                                   \
    X(QG_MACRO_TIP_CLEARANCE, "tip_clearance", "room between each tip and the mate's root")                            \
    X(QG_MACRO_HOB, "hob", "a hob whose tip reaches into the gear and has room for its rounding")                      \
    X(QG_MACRO_UNDERCUT, "undercut", "flanks that the hob does not cut away again")                                    \
    X(QG_MACRO_TOOTH, "tooth", "tips outside the form and root circles")                                               \
    X(QG_MACRO_TIP_THICKNESS, "tip_thickness", "tips thick enough")                                                    \
    X(QG_MACRO_INTERFERENCE, "interference", "tips that touch no mate below its form radius")                          \
    X(QG_MACRO_CONTACT_RATIO, "contact_ratio", "a contact ratio from 1 to 5")                                          \
    X(QG_MACRO_BODY, "body", "room for the bores, and whatever else a pair needs")                                     \
    X(QG_MACRO_RATING, "rating", "a tooth that the formulas of ISO 6336 can rate")                                     \
    X(QG_MACRO_CONTACT_STRESS, "contact_stress", "no more contact stress than allowed")                                \
    X(QG_MACRO_ROOT_STRESS, "root_stress", "no more root stress than allowed")

#define QG_MACRO_NAME(name, word, text) name,
enum qg_macro_constraint { QG_MACRO_TABLE(QG_MACRO_NAME) QG_MACRO_CONSTRAINTS };
#undef QG_MACRO_NAME

/* The table's name of a constraint ("ratio", "undercut", ...) and its words for what a sample must have. */
const char *qg_macro_constraint_name(enum qg_macro_constraint constraint);
const char *qg_macro_constraint_text(enum qg_macro_constraint constraint);

/* Fills in what was not given, from the initial pair, whose figures carry the index 0:
 *     teeth            0.6 z0 to 1.8 z0, rounded inwards, at least 5
 *     module           0.5 m0 to 1.2 m0
 *     pressure angle   6 degrees about the initial one, at least 10, at most 35
 *     profile shift    -m0 to m0
 *     outside radius   half a module m0 about the initial one
 *     root radius      a quarter module m0 below to three quarters above the initial one
 *     backlash         0.8 to 1.2 times the initial one
 * backlash0 in mm. The initial pair must have passed qg_pair_derive. */
void qg_macro_complete(struct qg_macro *macro, const struct qg_gear_pair *initial, double backlash0);

/* Checks a completed search against the initial pair: ranges in order, tooth numbers among which the ratio can be kept,
 * roots that leave room for the bores, an initial pair that ISO 6336 can rate. Faults go to notes, with places like
 * "macro.ranges.pinion.teeth". geometry is the initial pair's. Returns QG_OK or QG_IMPOSSIBLE_GEAR. */
enum qg_status qg_macro_check(const struct qg_macro *macro, const struct qg_gear_pair *initial,
                              const struct qg_pair_geometry *geometry, struct qg_notes *notes);

/* True when z2/z1 departs from the initial ratio by no more than allowed: |z2 z10 - z1 z20| <= p z1 z20, p the share. The
 * products are exact. */
bool qg_macro_ratio_is_kept(double z1, double z2, const struct qg_gear_pair *initial, double ratio_percent);

/* What a pair is rated by. */
struct qg_macro_rating {
    double contact_stress; /* MPa, sigma_H, the larger one of both gears */
    double root_stress;    /* MPa, sigma_F, the larger one of both gears */
};

/* Rates a pair at its nominal torque by ISO 6336 (iso6336.h). QG_NO_CONVERGENCE when the formulas have no value. */
enum qg_status qg_macro_rate(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry,
                             struct qg_macro_rating *out);

#endif
