/* The gear pair as an oscillator with backlash, and its steady response over a range of speeds.
 *
 * One degree of freedom along the line of action, lengths in half-backlashes b, time in 1/omega_n, omega_n^2 =
 * k_mean/m:
 *
 *     x'' + 2 zeta x' + kappa(tau) g(x - e(tau)) = load
 *
 * g is the dead zone of half-width 1: g(y) = y - 1 for y > 1, 0 for |y| <= 1, y + 1 for y < -1. kappa (mean 1) and e
 * are Fourier series in the mesh phase phi = p tau / (2 pi), p = omega_mesh / omega_n the frequency ratio. phi = 0 at
 * tau = 0. DTE = x - mean(x); its RMS is taken over whole periods of the steady state.
 *
 * With a force that depends on position and amplitude (force.h), f in newton times force_scale, the equation is
 *
 *     x'' + 2 zeta x' + f_drive(phi, x - 1) - f_back(phi, -x - 1) = load
 */
#ifndef QG_CORE_DYNAMICS_H
#define QG_CORE_DYNAMICS_H

#include <stddef.h>

#include "core/status.h"

enum { QG_HARMONICS_MAX = 32, QG_PERIOD_MAX = 8 };

/* f(phi) = mean + sum_{j=1..harmonics} cosine[j-1] cos(2 pi j phi) + sine[j-1] sin(2 pi j phi). */
struct qg_fourier {
    int harmonics;
    double mean;
    double cosine[QG_HARMONICS_MAX];
    double sine[QG_HARMONICS_MAX];
};

/* The first `harmonics` harmonics of n equidistant samples f(i/n) of one period (discrete Fourier transform).
 * Requires harmonics <= (n - 1) / 2. */
void qg_fourier_from_samples(struct qg_fourier *out, const double *samples, size_t n, int harmonics);

/* The series at a phase (periods). */
double qg_fourier_at(const struct qg_fourier *series, double phase);

struct qg_force;

/* One load case of one design, dimensionless. */
struct qg_oscillator {
    double damping_ratio;        /* zeta > 0 */
    double load;                 /* F / (k_mean b) > 0 */
    struct qg_fourier stiffness; /* kappa, mean 1 */
    struct qg_fourier error;     /* e / b; all zero with the secant stiffness */
    const struct qg_force
        *force;         /* not NULL: it pulls instead of kappa and e; approaches in half-backlashes. Borrowed */
    double force_scale; /* what makes its forces dimensionless: 1 / (k_mean b) */
};

enum qg_branch {
    QG_BRANCH_FIXED,    /* every speed starts from the same state */
    QG_BRANCH_RUN_UP,   /* speeds ascending, each starts from the last one's steady state */
    QG_BRANCH_RUN_DOWN, /* speeds descending, likewise */
    QG_BRANCH_WORST,    /* the largest RMS of all stable responses found (attractors.h) */
    QG_BRANCH_COUNT
};

/* What qg_response.period says of a response without a period of 1..QG_PERIOD_MAX (essay in dynamics_steady.c). */
enum {
    QG_PERIOD_LONG = 0,      /* a longer period, or not settled in the time given */
    QG_PERIOD_CHAOTIC = -1,  /* neighbouring orbits part exponentially */
    QG_PERIOD_UNBOUNDED = -2 /* grows beyond all bounds; RMS and mean are those of its last mesh period */
};

/* Which speeds, and from where. Speeds are equidistant: min + i (max - min) / (count - 1). */
struct qg_speed_map {
    double min, max; /* frequency ratio p, 0 < min <= max */
    size_t count;    /* >= 1 */
    enum qg_branch branch;
    int start_static;          /* 1: displacement is the static equilibrium at tau = 0; 0: start_displacement */
    double start_displacement; /* in half-backlashes */
    double start_velocity;     /* in half-backlashes times omega_n */
};

/* The frequency ratio of speed i. */
double qg_speed_at(const struct qg_speed_map *map, size_t i);

/* The steady response at one speed. One that has not become periodic after 24/zeta of dimensionless time is named
 * QG_PERIOD_LONG or QG_PERIOD_CHAOTIC and has its RMS taken over the following 4/zeta (at least 256 and 64 mesh
 * periods; dynamics_steady.c). */
struct qg_response {
    double rms;  /* of the DTE, in half-backlashes */
    double mean; /* of x, in half-backlashes */
    int period;  /* in mesh periods, 1..QG_PERIOD_MAX; or one of the names above */
    int beyond; /* 1: the orbit left the ladder of the force, where it is continued with its last slope */
    double x, v; /* a state on the steady orbit at phase 0 (for continuing a run) */
};

/* The static equilibrium at tau = 0: x > 1 with kappa(0) g(x - e(0)) = load, or f_drive(0, x - 1) = load. */
double qg_static_displacement(const struct qg_oscillator *oscillator);

/* The work for one oscillator falls into independent pieces, the same for any number of threads. A fixed-branch map is
 * cut into blocks of speeds; every other one is one piece. */
size_t qg_response_pieces(const struct qg_speed_map *map);

/* Computes one piece: fills out[i] for the speeds of that piece, out having map->count entries in ascending order of
 * speed. Batched integrator of our own (dynamics_kernel.h): no allocation, any thread, the same bits on every
 * processor. Not for QG_BRANCH_WORST, which is qg_worst_response (attractors.h). */
void qg_response_piece(const struct qg_oscillator *oscillator, const struct qg_speed_map *map, size_t piece,
                       struct qg_response *out);

/* The reference integrator: one speed with SUNDIALS CVODE, root-finding at the edges of the dead zone, marched from
 * (x, v) at tau = 0 to the steady state at relative tolerance rtol. Slow; the oracle of the tests and of the benchmark.
 * QG_NO_CONVERGENCE when CVODE gives up. */
enum qg_status qg_response_reference(const struct qg_oscillator *oscillator, double frequency_ratio, double x, double v,
                                     double rtol, struct qg_response *out);

#endif
