/* Periodic orbits by shooting.
 *
 * With P the Poincare map over one mesh period T, an orbit of period n is a root of G(z) = P^n(z) - z. The integrator
 * carries the exact tangent DP^n along (the force is continuous at the edges of the dead zone, so there is nothing to
 * add there: the saltation matrices are the identity), and Newton's method converges quadratically to stable and
 * unstable orbits alike. DP^n at the root is the monodromy matrix; its eigenvalues are the Floquet multipliers.
 *
 * Liouville: damping is the same on both flanks and in the dead zone, so det DP^n = mu1 mu2 = exp(-2 zeta n T)
 * everywhere. What can happen to an orbit when the speed changes follows from that:
 *   fold             a real multiplier passes +1, the other being exp(-2 zeta n T): the branch turns back;
 *   period doubling  a real multiplier passes -1;
 *   Neimark-Sacker   cannot happen. It takes a complex pair of modulus 1, but a complex pair has |mu|^2 = mu1 mu2, that
 *                    is |mu| = exp(-zeta n T) < 1. Nor can there be a torus for it to give birth to: an invariant
 *                    closed curve would enclose an area which P maps onto itself but shrinks by exp(-2 zeta T).
 * Instability is therefore always one real multiplier outside the unit circle.
 */
#include "core/orbit.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { NEWTON_MAX = 12 };

static const double CONVERGED = 1e-10; /* length of the last Newton step, in half-backlashes */
static const double FARTHEST = 1e3;    /* half-backlashes: a guess that goes there is lost */
static const double SAME_POINT = 1e-7; /* half-backlashes: an orbit that returns so closely has returned */

struct qg_floquet qg_floquet_of(const double m[4]) {
    double half = 0.5 * (m[0] + m[3]), determinant = m[0] * m[3] - m[1] * m[2];
    double discriminant = 0.25 * (m[0] - m[3]) * (m[0] - m[3]) + m[1] * m[2], root = sqrt(fabs(discriminant));
    struct qg_floquet f = {.stable = determinant < 1.0 && fabs(2.0 * half) < 1.0 + determinant};
    if (discriminant < 0.0) {
        f.real[0] = f.real[1] = half;
        f.imaginary[0] = root;
        f.imaginary[1] = -root;
    } else {
        f.real[0] = half < 0.0 ? half - root : half + root;
        f.real[1] = f.real[0] != 0.0 ? determinant / f.real[0] : 0.0;
    }
    return f;
}

static double distance(struct qg_state a, struct qg_state b) {
    double x = a.x - b.x, v = a.v - b.v;
    return sqrt(x * x + v * v);
}

static int smallest_period(const struct qg_shot *shot, int periods) {
    for (int n = 1; n < periods; n++)
        if (periods % n == 0 && distance(shot->visited[n - 1], shot->start) < SAME_POINT)
            return n;
    return periods;
}

void qg_orbit_from_shot(struct qg_orbit *orbit, const struct qg_shot *shot, int periods) {
    double n = (double)shot->steps, mean = shot->sum / n;
    orbit->frequency_ratio = shot->frequency_ratio;
    orbit->period = periods;
    orbit->state[0] = shot->start;
    memcpy(orbit->state + 1, shot->visited, (size_t)(periods - 1) * sizeof *shot->visited);
    memcpy(orbit->monodromy, shot->tangent, sizeof orbit->monodromy);
    orbit->floquet = qg_floquet_of(shot->tangent);
    orbit->rms = sqrt(fmax(shot->sum_of_squares / n - mean * mean, 0.0));
    orbit->mean = shot->start.x + mean;
    orbit->drive_crossings = shot->drive_crossings;
    orbit->back_crossings = shot->back_crossings;
    orbit->beyond = shot->beyond;
}

/* The Newton step from a shot's start, (I - DP^n)^-1 (P^n z - z); answers its length. */
static double newton_step(const struct qg_shot *shot, struct qg_state *step) {
    const double *m = shot->tangent;
    double determinant = (1.0 - m[0]) * (1.0 - m[3]) - m[1] * m[2];
    double x = shot->end.x - shot->start.x, v = shot->end.v - shot->start.v;
    *step = (struct qg_state){((1.0 - m[3]) * x + m[1] * v) / determinant, (m[2] * x + (1.0 - m[0]) * v) / determinant};
    return sqrt(step->x * step->x + step->v * step->v);
}

enum verdict { GOING, CONVERGED_NOW, LOST };

/* One Newton step of one guess. */
static enum verdict improve(struct qg_shot *shot) {
    struct qg_state step;
    double length = newton_step(shot, &step);
    if (length <= CONVERGED)
        return CONVERGED_NOW;
    if (!(length < FARTHEST))
        return LOST;
    shot->start.x += step.x;
    shot->start.v += step.v;
    return GOING;
}

/* Newton's method for shots side by side; lanes that are done march along. */
static void iterate(const struct qg_oscillator *oscillator, int period, size_t count, struct qg_shot *shots,
                    enum verdict *verdict) {
    for (size_t i = 0; i < count; i++)
        verdict[i] = GOING;
    for (int n = 0; n < NEWTON_MAX; n++) {
        bool going = false;
        qg_batch_shoot(oscillator, (size_t)period, count, shots);
        for (size_t i = 0; i < count; i++) {
            if (verdict[i] == GOING)
                verdict[i] = improve(&shots[i]);
            going = going || verdict[i] == GOING;
        }
        if (!going)
            return;
    }
}

/* The same orbit over its smallest period. */
static void reduce(const struct qg_oscillator *oscillator, struct qg_orbit *orbit, const struct qg_shot *shot,
                   int periods) {
    struct qg_shot shorter = {.frequency_ratio = shot->frequency_ratio, .start = shot->start};
    qg_batch_shoot(oscillator, (size_t)periods, 1, &shorter);
    qg_orbit_from_shot(orbit, &shorter, periods);
}

void qg_orbit_shoot(const struct qg_oscillator *oscillator, int period, size_t count, struct qg_orbit *orbits,
                    bool *found) {
    assert(period >= 1 && period <= QG_PERIOD_MAX && count >= 1 && count <= QG_LANES);
    struct qg_shot shots[QG_LANES] = {0};
    enum verdict verdict[QG_LANES];
    for (size_t i = 0; i < count; i++) {
        shots[i].frequency_ratio = orbits[i].frequency_ratio;
        shots[i].start = orbits[i].state[0];
    }
    iterate(oscillator, period, count, shots, verdict);
    for (size_t i = 0; i < count; i++) {
        found[i] = verdict[i] == CONVERGED_NOW;
        if (!found[i])
            continue;
        int smallest = smallest_period(&shots[i], period);
        if (smallest < period)
            reduce(oscillator, &orbits[i], &shots[i], smallest);
        else
            qg_orbit_from_shot(&orbits[i], &shots[i], period);
    }
}

bool qg_orbit_same(const struct qg_orbit *a, const struct qg_orbit *b, double tolerance) {
    if (a->period != b->period)
        return false;
    for (int shift = 0; shift < a->period; shift++) {
        int n = 0;
        while (n < a->period && distance(a->state[n], b->state[(n + shift) % b->period]) <= tolerance)
            n++;
        if (n == a->period)
            return true;
    }
    return false;
}

bool qg_orbit_is_small(const struct qg_orbit *orbit) {
    bool small = true;
    for (int n = 0; n < orbit->period; n++)
        small = small && fabs(orbit->state[n].x) < QG_STATE_MAX && fabs(orbit->state[n].v) < QG_STATE_MAX;
    return small;
}
