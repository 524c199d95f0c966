/* When has an orbit become steady, and what is its period? The judge of one speed; see dynamics_steady.c. */
#ifndef QG_CORE_DYNAMICS_STEADY_H
#define QG_CORE_DYNAMICS_STEADY_H

#include <stdbool.h>

#include "core/dynamics.h"

/* States kept: three returns of the longest period and the present one. */
enum { QG_HISTORY = 3 * QG_PERIOD_MAX + 1 };

/* A Poincare state: displacement and velocity at phase 0. */
struct qg_state {
    double x, v;
};

/* What one mesh period of integration yielded. Sums are over the integration steps of the period, of x - origin and of
 * its square; origin is qg_steady.origin. */
struct qg_period {
    struct qg_state end;
    double tangent[4]; /* d(end)/d(start) since qg_steady asked for a fresh one; only read if it did */
    double sum, sum_of_squares;
    size_t steps;
    bool linear;      /* on the drive flank all the time */
    bool beyond;      /* above the ladder of the force at some time */
    double clearance; /* of a motion on a curved force: least distance from the drive flank's edge; else 0 */
};

enum qg_steady_stage { QG_STEADY_MARCH, QG_STEADY_SHOOT, QG_STEADY_WINDOW, QG_STEADY_DONE };

struct qg_steady {
    bool plain;         /* never leave the marched trajectory */
    double mesh_period; /* T = 2 pi / p */
    double damping_ratio;
    double load;
    double origin;      /* of the sums */
    size_t periods_max; /* marched without a verdict, then the long window */
    size_t window;      /* periods of the long window */

    enum qg_steady_stage stage;
    size_t marched;      /* mesh periods on the trajectory so far */
    size_t next_attempt; /* when marched reaches it */
    size_t attempts;
    struct qg_state history[QG_HISTORY]; /* ring; entry marched % QG_HISTORY is the present state */
    double amplitude;                    /* standard deviation of x in the last marched period */

    int period;                             /* the period tried, in mesh periods */
    int done;                               /* mesh periods of it integrated */
    int iteration;                          /* Newton steps taken */
    bool linear;                            /* no edge of the dead zone was touched so far */
    bool beyond;                            /* the ladder of the force was left in the shot or the window */
    double clearance;                       /* least one of the shot */
    double last_step;                       /* length of the last one */
    struct qg_state start;                  /* of the shot */
    struct qg_state visited[QG_PERIOD_MAX]; /* ends of its mesh periods */
    struct qg_state resume;                 /* where the march goes on if shooting fails */
    double sum, sum_of_squares;             /* of the shot, or of the window */
    size_t steps;
    struct qg_state deviation; /* carried through the window by the tangent; of length 1 after its first quarter */

    struct qg_response response; /* once stage is QG_STEADY_DONE */
};

/* Starts the judgement of one speed at a state. */
void qg_steady_init(struct qg_steady *steady, const struct qg_oscillator *oscillator, double frequency_ratio,
                    struct qg_state start);

/* Whether the tangent is wanted, and whether it must start afresh as the identity with the next mesh period. */
bool qg_steady_wants_tangent(const struct qg_steady *steady);
bool qg_steady_restarts_tangent(const struct qg_steady *steady);

/* Takes in one mesh period. Returns true when *next, the state from which to go on, is not the period's end state. */
bool qg_steady_advance(struct qg_steady *steady, const struct qg_period *period, struct qg_state *next);

#endif
