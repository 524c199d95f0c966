/* All branches of one oscillator: its periodic orbits as curves over the frequency ratio, stable and unstable parts,
 * through the folds; what bends, splits or touches the dead zone's edge is marked. Found by pseudo-arclength
 * continuation (branches.c).
 */
#ifndef QG_CORE_BRANCHES_H
#define QG_CORE_BRANCHES_H

#include <stdbool.h>

#include "core/dynamics.h"

/* A point of a branch: one periodic orbit. */
struct qg_branch_point {
    double frequency_ratio;
    double rms, mean; /* of the DTE and of x, in half-backlashes */
    bool stable;
    double multiplier_real[2], multiplier_imaginary[2]; /* Floquet multipliers: two real, or a complex pair */
};

enum qg_special {
    QG_SPECIAL_FOLD,            /* the branch turns back; a multiplier passes +1 */
    QG_SPECIAL_PERIOD_DOUBLING, /* a multiplier passes -1; a branch of twice the period meets this one here */
    QG_SPECIAL_GRAZING_DRIVE,   /* the orbit touches the edge of the dead zone on the drive flank */
    QG_SPECIAL_GRAZING_BACK,    /* likewise on the back flank */
    QG_SPECIAL_COUNT
};

/* A special point, its frequency ratio to 1e-6. */
struct qg_special_point {
    enum qg_special kind;
    double frequency_ratio, rms;
};

/* Why a branch ends where it ends. */
enum qg_branch_end {
    QG_END_RANGE,           /* at the least or greatest speed */
    QG_END_CLOSED,          /* it is a closed curve: back at its beginning */
    QG_END_PERIOD_DOUBLING, /* on a branch of half the period */
    QG_END_AMPLITUDE,       /* displacement or velocity grows beyond 10 half-backlashes (times omega_n) */
    QG_END_LOST             /* the continuation went no further: steps too small, or too many */
};

/* One branch, from end to end. The orbits inside are those of branches.c. */
struct qg_curve {
    int period; /* in mesh periods */
    enum qg_branch_end end[2];
    size_t count, room;
    struct qg_branch_point *point;
    double *state; /* behind the points: per point `period` Poincare states, x and v */
    size_t special_count, special_room;
    struct qg_special_point *special;
};

enum { QG_CURVES_MAX = 96, QG_CURVE_POINTS_MAX = 40000 };

/* The branches of one oscillator, in the order in which they were found. */
struct qg_branches {
    size_t count;
    bool complete; /* false: ended at QG_CURVES_MAX curves or QG_CURVE_POINTS_MAX points */
    struct qg_curve curve[QG_CURVES_MAX];
    size_t unperiodic; /* steady responses met that have no period up to QG_PERIOD_MAX */
};

/* Finds the branches of periods 1..QG_PERIOD_MAX within the map's range of speeds: from the attractors of its speeds
 * (attractors.h) and from every period doubling on. branches is initialised by the call and must be given to
 * qg_branches_finish whatever the status: QG_OK, QG_OUT_OF_MEMORY or QG_CANCELLED. Any thread; a pure function of
 * oscillator and map. Some tenths of a second to some seconds. */
enum qg_status qg_branches_find(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                const struct qg_stop *stop, struct qg_branches *branches);
void qg_branches_finish(struct qg_branches *branches);

/* "fold", "period_doubling", "grazing_drive_flank", "grazing_back_flank". */
const char *qg_special_name(enum qg_special kind);

/* "range", "closed", "period_doubling", "amplitude", "lost". */
const char *qg_branch_end_name(enum qg_branch_end end);

/* The branches' orbits at one frequency ratio, exactly: where the curves cross it, corrected by Newton's method. out
 * has room for `room`; answers how many there are. Any thread. */
struct qg_orbit;
size_t qg_branches_at(const struct qg_branches *branches, const struct qg_oscillator *oscillator,
                      double frequency_ratio, size_t room, struct qg_orbit *out);

#endif
