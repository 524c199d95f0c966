/* The mesh force as a function of position and amplitude, F(phi, delta): what "load_dependent" dynamics pull with.
 *
 * The contact model is asked at every mesh position for the approach under a ladder of loads. Each rung j, load F_j,
 * thus has a static transmission error delta_j(phi), which is kept as a Fourier series; rung 0 is no load, its approach
 * the unloaded transmission error. At one phase the force is the monotone cubic interpolant of the points (delta_j,
 * F_j): zero below delta_0, continued with its last slope above the last rung. At a rung's load the approach is the
 * rung's series, exactly: the static limit is the transmission error at every load of the ladder, and the load cases
 * are on it.
 *
 * Two flanks: the drive flanks, and the back flanks on which the teeth fall when they have crossed the backlash.
 *
 * Units: approach in whatever unit it was given in (half-backlashes for the dynamics), force likewise (newton).
 */
#ifndef QG_CORE_FORCE_H
#define QG_CORE_FORCE_H

#include <stdbool.h>

#include "core/dynamics.h"
#include "core/pair.h"

enum { QG_FORCE_LEVELS_MAX = 48, QG_FORCE_STEPS_MAX = 2880 };

/* The ladder ends at so many times the largest load it is made for. */
#define QG_FORCE_REACH 4.0

enum qg_flank { QG_FLANK_DRIVE, QG_FLANK_BACK, QG_FLANK_COUNT };

/* From one rung to the next, d = delta - delta_j: force + d (slope + d (bend + d twist)). */
struct qg_force_piece {
    double force, slope, bend, twist;
};

/* The force at one phase. Below the first rung there is none; piece[levels - 1] is the straight end. */
struct qg_force_section {
    double approach[QG_FORCE_LEVELS_MAX]; /* [levels], strictly ascending */
    struct qg_force_piece piece[QG_FORCE_LEVELS_MAX];
};

/* Sections at the phases i / (2 steps), for the integrator. */
struct qg_force_table {
    double *knot;                 /* [2 steps][levels] */
    struct qg_force_piece *piece; /* [2 steps][levels] */
};

/* F(phi, delta) of one design. Constant once created; shared by threads. */
struct qg_force {
    size_t levels;                                                   /* rungs, the first without load */
    double load[QG_FORCE_LEVELS_MAX];                                /* ascending from 0 */
    struct qg_fourier approach[QG_FLANK_COUNT][QG_FORCE_LEVELS_MAX]; /* of the two flanks' rungs, over the mesh phase */
    double least_error[QG_FLANK_COUNT];                              /* smallest approach of rung 0 over the period */
    size_t damped; /* rungs whose harmonics had to be reduced to keep the rungs apart (qg_force_create) */
    size_t steps;
    struct qg_force_table table[QG_FLANK_COUNT];
};

/* What a force is made from. */
struct qg_force_samples {
    size_t positions;       /* n: samples at phases i/n */
    int harmonics;          /* of the series, <= (n - 1) / 2 */
    size_t levels;          /* 2..QG_FORCE_LEVELS_MAX */
    const double *load;     /* [levels], strictly ascending from 0 */
    const double *approach; /* [levels][positions], strictly ascending over the levels at each position */
    double
        mirror;   /* the back flanks at phase phi are what the drive flanks are at mirror - phi (qg_back_flank_phase) */
    size_t steps; /* of the integrator, per mesh period: see qg_force_steps */
};

/* The ladder for some loads (> 0, any order): 0, then from a twentieth of the smallest to QG_FORCE_REACH times the
 * largest, all the loads among them, successive ones in a ratio of at most 1.3 (more when the loads lie too far apart
 * for QG_FORCE_LEVELS_MAX rungs). count + 4 <= QG_FORCE_LEVELS_MAX. Returns the number of rungs. */
size_t qg_force_ladder(const double *loads, size_t count, double ladder[QG_FORCE_LEVELS_MAX]);

/* Steps per mesh period that a force must be tabulated for to serve speeds from a lowest frequency ratio upwards. At
 * most QG_FORCE_STEPS_MAX, which serves 0.044; slower speeds get longer steps. */
size_t qg_force_steps(double lowest_ratio, int harmonics);

/* Makes the force. Where truncated series of neighbouring rungs come closer than a tenth of their mean distance, the
 * harmonics of their distance are reduced until they do not, and the rung is counted in `damped`. On QG_OK *force is
 * the caller's, to be destroyed; else QG_OUT_OF_MEMORY. */
enum qg_status qg_force_create(const struct qg_force_samples *samples, struct qg_force **force);
void qg_force_destroy(struct qg_force *force);

/* Replaces the back flanks' force: series of all rungs, [levels]. For tests: the seam that real gears fill by
 * mirroring. */
void qg_force_set_back(struct qg_force *force, const struct qg_fourier *approach);

/* The force of a flank at a phase. */
void qg_force_section_init(struct qg_force_section *section, const struct qg_force *force, enum qg_flank flank,
                           double phase);

/* Force at an approach, and its derivative (slope may be NULL). Below the first rung: the first piece's cubic goes on
 * when `through` is set (for integrators that stop at the edge), else 0. */
double qg_force_section_at(const struct qg_force_section *section, size_t levels, double approach, bool through,
                           double *slope);

/* The approach at which a force > 0 is reached. */
double qg_force_section_approach(const struct qg_force_section *section, size_t levels, double force);

/* The slope dF/ddelta at rung `level` >= 1, below the last, of a section through the given approaches [levels]. */
double qg_force_tangent(const double *load, const double *approach, size_t levels, size_t level);

/* The phase S by which the back flanks mirror the drive flanks: at phase phi, the teeth having crossed the backlash,
 * the back flanks touch as the drive flanks do at S - phi. In [0, 1). See force.c. */
double qg_back_flank_phase(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry);

#endif
