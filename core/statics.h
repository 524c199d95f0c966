/* Static contact of the pair over one mesh period: static transmission error and everything that comes with it.
 *
 * A mesh position phi = i/N is made ready once per gear pair: which points of which pairs of teeth can touch, the gap that
 * the bare involutes leave there, and the flexibility between all of them. A design (its reliefs) then only adds to the gaps
 * and costs one small contact problem per position and torque.
 *
 * Points and gaps. Of two flanks in contact one may touch with its tip corner: in approach the gear's, in recess the
 * pinion's (the split is the pitch point). Contact points are laid on that flank (the tip's), up to and including the
 * corner; each looks along the normal of the other flank, which is tangent to that gear's base circle, so that the gap of two
 * involutes has a closed form and closes by exactly the rotation of the other gear, also outside of the theoretical path.
 * Pressure is piecewise linear between the points; gap and displacement are averaged with the same weights, which keeps
 * the flexibility symmetric.
 */
#ifndef QG_CORE_STATICS_H
#define QG_CORE_STATICS_H

#include "core/compliance.h"
#include "core/contact.h"
#include "core/model.h"
#include "core/nodal.h"
#include "core/stress.h"

enum { QG_GAP_SAMPLES = 6 };

/* Where the gap of a point is averaged. */
struct qg_gap_sample {
    double weight;    /* sums to 1 over the samples of a point */
    double gap;       /* mm, of the bare involutes */
    double radius[2]; /* mm, on the pinion's and the gear's flank */
};

/* One point that may touch. */
struct qg_contact_point {
    int pair;     /* -QG_PAIR_REACH .. QG_PAIR_REACH */
    double lever; /* moment arm of its normal about the pinion's axis, over the pinion's base radius */
    int near_corner; /* 1 within QG_CORNER_ZONE of the tip corner, where the pressure of a sharp edge has no finite value */
    double width;            /* mm of flank over which its load is spread (integral of its hat function) */
    struct qg_gap_sample at; /* the point itself, weight unused */
    struct qg_gap_sample sample[QG_GAP_SAMPLES]; /* around it */
};

/* One mesh position. */
struct qg_contact_site {
    size_t n;
    struct qg_contact_point *point;       /* [n], by pair, then towards the tip */
    double *flexibility;                  /* mm/N, n x n */
    struct qg_packed_spread (*spread)[2]; /* [n] pinion, gear: a point's unit load on the flank's nodes */
};

/* All positions of a period. */
struct qg_statics {
    const struct qg_gear_pair *pair;
    const struct qg_pair_geometry *geometry;
    size_t positions;
    double first;       /* mesh periods: position i is first + i / positions */
    size_t most_points; /* over the positions */
    double largest_gap; /* mm: points whose bare gap is larger are left out */
    struct qg_contact_site *site;
    struct qg_stress_rows stress;
};

/* Distance from the tip corner, in modules, within which contact pressure is not reported: elasticity gives a sharp corner
 * an infinite one, and a mesh whatever its fineness allows. */
#define QG_CORNER_ZONE 0.05

/* Makes all positions ready. compliance[2] are the gears' (tooth distances up to 2 QG_PAIR_REACH); they are not needed
 * afterwards. largest_force (N) is the largest normal force that will be asked for. pair and geometry must outlive statics.
 * Positions are pieces of means->executor; means->stop is asked before each, and between the matrices that all need.
 * QG_OUT_OF_MEMORY (also beyond means->operator_bytes_max), QG_NO_CONVERGENCE when nothing can touch, QG_CANCELLED when stop said so; statics is empty then. */
enum qg_status qg_statics_init(struct qg_statics *statics, const struct qg_gear_pair *pair,
                               const struct qg_pair_geometry *geometry, const struct qg_compliance *compliance,
                               size_t positions, double largest_force, const struct qg_means *means);
/* The same for one position (mesh periods) anywhere in the period: statics->positions is 1. */
enum qg_status qg_statics_init_at(struct qg_statics *statics, const struct qg_gear_pair *pair,
                                  const struct qg_pair_geometry *geometry, const struct qg_compliance *compliance,
                                  double position, double largest_force, const struct qg_means *means);
void qg_statics_finish(struct qg_statics *statics);

/* The bare gap (mm) up to which points are laid, where the pair approaches by `approach` (mm) under the largest force:
 * reliefs may be as deep as qg_relief_deepest, and what lies farther apart than that and 1.5 approaches cannot touch. */
double qg_statics_reach(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, double approach);

/* How many points a mesh position (mesh periods) will have, for a reach (mm) and meshes of refinement 1, n times as many at
 * refinement n: before anything is computed. *pairs tells on how many pairs of teeth. Any thread; some 50 us. */
size_t qg_statics_count_points(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry,
                               double largest_gap, double position, int *pairs);

/* The mesh position of site i, in mesh periods. */
double qg_statics_position(const struct qg_statics *statics, size_t i);

/* Room for one thread to solve in. */
struct qg_statics_workspace {
    struct qg_contact contact;
    double *gap, *lever;
    double *stress;      /* of all teeth's root points of one gear */
    struct qg_stop stop; /* asked before each position; may be set after the init, which leaves it empty */
};
enum qg_status qg_statics_workspace_init(struct qg_statics_workspace *workspace, const struct qg_statics *statics);
void qg_statics_workspace_finish(struct qg_statics_workspace *workspace);

/* Fills the static members of result->cases[0 .. case_count-1], whose torque is given, for result->relief: transmission
 * errors, load shares, contact pressures, pps, ratios, residual. Mesh stiffness and f_pps are not its business.
 * QG_CANCELLED when the workspace's stop said so; the members are then incomplete. */
enum qg_status qg_statics_solve(const struct qg_statics *statics, struct qg_statics_workspace *workspace,
                                struct qg_design_result *result);

/* Solves the contact of a relief at site i under a normal force (N), and leaves it in the workspace: contact.load and
 * contact.approach, and in gap the gaps (mm) of the points as they were before loading. */
enum qg_status qg_statics_contact(const struct qg_statics *statics, struct qg_statics_workspace *workspace,
                                  const struct qg_relief *relief, size_t i, double force);

/* Contact pressure (MPa) over the narrower face width at point i of a site under the loads (N) of its points, averaged with its
 * neighbours; 0 at the ends of a flank and beside a tip corner. */
double qg_contact_pressure(const struct qg_statics *statics, const struct qg_contact_site *site, const double *load,
                           size_t i);

/* The approaches of a design under a ladder of loads: approach[j * positions + i] (mm) at load[j] (N) and position i.
 * load[0] is 0: its approach is the unloaded transmission error; the others ascend and are at most the largest force that
 * the statics were made ready for. Each load's contact is the first guess of the next. Stops as qg_statics_solve does. */
enum qg_status qg_statics_ladder(const struct qg_statics *statics, struct qg_statics_workspace *workspace,
                                 const struct qg_relief *relief, size_t levels, const double *load, double *approach);

/* Stresses of a design at one position under each of `count` loads (N, ascending or not, at most the largest force): solves the
 * contact as qg_statics_solve does, with the same bits, and fills the entries of that position in stresses[0 .. count-1]
 * (QG_PAIR_COUNT pairs). Costs some four times what the contact does, so it is for designs that are kept. */
enum qg_status qg_statics_stress(const struct qg_statics *statics, struct qg_statics_workspace *workspace,
                                 const struct qg_relief *relief, size_t position, size_t count, const double *load,
                                 struct qg_stresses *const *stresses);

#endif
