/* One periodic orbit of the oscillator: found by shooting, with its Floquet multipliers. Inside of the dynamics, like
 * dynamics_batch.h: for attractors.c, branches.c and the tests.
 */
#ifndef QG_CORE_ORBIT_H
#define QG_CORE_ORBIT_H

#include <stdbool.h>

#include "core/dynamics_batch.h"

/* The eigenvalues of a monodromy matrix: two real ones, the larger in modulus first, or a complex pair, the one with
 * positive imaginary part first. */
struct qg_floquet {
    double real[2], imaginary[2];
    bool stable; /* both inside the unit circle */
};

/* The multipliers of a monodromy matrix, given by rows. */
struct qg_floquet qg_floquet_of(const double monodromy[4]);

/* Orbits are followed while the Poincare states' displacement and velocity are below this (half-backlashes, and times
 * omega_n). */
#define QG_STATE_MAX 10.0

/* A periodic orbit at one frequency ratio. */
struct qg_orbit {
    double frequency_ratio;
    int period;                           /* in mesh periods, 1..QG_PERIOD_MAX: the smallest that the orbit has */
    struct qg_state state[QG_PERIOD_MAX]; /* at phase 0, mesh period after mesh period; `period` of them */
    double monodromy[4];                  /* derivative of the Poincare map over `period` mesh periods, at state[0] */
    struct qg_floquet floquet;
    double rms, mean;                    /* of the DTE and of x, as in qg_response */
    int drive_crossings, back_crossings; /* edges of the dead zone met within `period` mesh periods, by flank */
    int beyond;                          /* 1: it leaves the ladder of the force (as in qg_response) */
};

/* Newton's method on the Poincare map over `period` mesh periods, for up to QG_LANES guesses side by side: each orbit's
 * frequency_ratio and state[0] are the guess and are replaced, with everything else, by the orbit found. found[i] tells
 * whether guess i converged, to a Newton step below 1e-10; if not, orbits[i] is of no use. The orbit may be of a
 * smaller period than was asked. Any thread; no allocation. */
void qg_orbit_shoot(const struct qg_oscillator *oscillator, int period, size_t count, struct qg_orbit *orbits,
                    bool *found);

/* Fills in the orbit from a shot over the mesh periods given that ended where it began. */
void qg_orbit_from_shot(struct qg_orbit *orbit, const struct qg_shot *shot, int periods);

/* Whether two orbits at the same speed are the same up to a shift by whole mesh periods: all states within `tolerance`
 * half-backlashes. */
bool qg_orbit_same(const struct qg_orbit *a, const struct qg_orbit *b, double tolerance);

/* Whether all its Poincare states are below QG_STATE_MAX. */
bool qg_orbit_is_small(const struct qg_orbit *orbit);

#endif
