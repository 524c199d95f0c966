/* When has an orbit become steady, and what is its period?
 *
 * The Poincare map P takes the state (x, v) at phase 0 over one mesh period T. A steady response of period n is a
 * stable fixed point z* of P^n. Two facts make the judgement sharp:
 *
 *   Liouville     det DP = exp(-2 zeta T) everywhere, because damping is the same on all branches of the dead zone.
 *                 Floquet multipliers are a complex pair of modulus exp(-zeta T), or two real ones, and then the slower
 *                 one decays more slowly than that. Return errors that fall faster belong to a saddle that the orbit is
 *                 about to leave.
 *   continuity    the force is continuous at the edges of the dead zone, so DP is the plain product of the flows
 *                 between the edges (the saltation matrices are the identity), and P is continuously differentiable.
 *
 * So a small return error alone proves nothing: near a stability limit it is small while the orbit creeps away. What
 * counts is the distance to the fixed point, (I - DP^n)^-1 (P^n z - z), and the stability of the fixed point, both from
 * the exact tangent that the integrator carries along (a "shot" of n mesh periods).
 *
 * The march of a lightly damped oscillator takes some 14/zeta of dimensionless time to fall to 1e-6. It is cut short by
 * Newton's method on P^n, under conditions that keep it on the branch to which the march was going:
 *   - the fixed point is stable;
 *   - every shot touches an edge: if not, all returns are exactly affine and say nothing about where the march will
 *     lose contact. Orbits that never lose contact are known in closed form and need no Newton steps
 *     (dynamics_kernel.h, linear orbit). A force that depends on amplitude bends all returns; there a shot without
 *     contact with the edge will do if the edge is SAFE times as far as the distance to the fixed point, so that the
 *     march cannot reach it any more;
 *   - the returns of the march before the shot, as far as they are remembered, follow the affine model z* + DP^n (z -
 *     z*) within AFFINE of their length: the march has entered a neighbourhood where it can only spiral in;
 *   - the first Newton step is no longer than what the march has explored in the periods remembered, and every further
 *     one at most AFFINE of the one before.
 * If not, the march goes on where it was and tries again later. Trials alternate between the smallest period whose
 * return error is small and the period whose return error is smallest. The period reported is the smallest that the
 * orbit has.
 *
 * Orbits without a verdict after TRANSIENT/zeta of dimensionless time get their RMS over the following WINDOW/zeta, and
 * a name. Quasi-periodic they cannot be: an invariant closed curve of P would enclose an area that P maps onto itself,
 * while Liouville has it shrink by exp(-2 zeta T). What is left is chaos, a period above QG_PERIOD_MAX, or a transient
 * too slow to tell. A deviation is carried along by the tangent of every mesh period: through the first quarter of the
 * window to turn it into the direction that grows fastest, then to be measured. On a periodic attractor it shrinks, or
 * nearly keeps its length close to a stability limit; the skewness of the multipliers' eigenvectors may lengthen it
 * once by some factor. If it ends PARTED times as long as it began, which is a largest Lyapunov exponent above
 * ln(PARTED) / (3/4 of the window), the response is called chaotic, otherwise long.
 *
 * A stiffness that varies so much that the motion grows without bound ends at RUNAWAY half-backlashes, or as many static
 * displacements when these are more, with the RMS of its last mesh period.
 */
#include "core/dynamics_steady.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics_batch.h"

enum { RETURNS = 9, FIRST_ATTEMPT = 4, NEWTON_MAX = 8, PERIODS_LEAST = 256, WINDOW_LEAST = 64, PERIODS_MOST = 100000 };

static const double AFFINE = 0.1;          /* largest departure from the affine model */
static const double NEARLY_RETURNED = 0.1; /* return error, in amplitudes, that makes a period worth a trial */
static const double CONVERGED = 1e-7;      /* distance to the fixed point, in amplitudes */
static const double MARCHED = 1e-6;        /* the same for an orbit that is only marched */
static const double SAFE = 3.0;            /* clearance from the edge, in distances to the fixed point */
static const double SAME_POINT = 1e-4;     /* in amplitudes: two states of an orbit are one */
static const double TRANSIENT = 24.0;      /* in 1/zeta */
static const double WINDOW = 4.0;          /* in 1/zeta */
static const double PARTED = 100.0;        /* growth of a deviation that is called chaos */
static const double PARTED_ENOUGH = 1e100; /* growth beyond which it is not followed */
static const double RUNAWAY = 1e6;         /* half-backlashes, or loads when that is more */

/* Not hypot(): that may differ in the last bit from one processor to another. */
static double length(struct qg_state a) {
    return sqrt(a.x * a.x + a.v * a.v);
}

static double distance(struct qg_state a, struct qg_state b) {
    return length((struct qg_state){a.x - b.x, a.v - b.v});
}

static size_t whole_periods(double time, double mesh_period, size_t least) {
    double periods = ceil(time / mesh_period);
    if (!(periods < PERIODS_MOST))
        return PERIODS_MOST;
    return periods < (double)least ? least : (size_t)periods;
}

void qg_steady_init(struct qg_steady *steady, const struct qg_oscillator *oscillator, double frequency_ratio,
                    struct qg_state start) {
    memset(steady, 0, sizeof *steady);
    steady->mesh_period = 2.0 * QG_PI / frequency_ratio;
    steady->damping_ratio = oscillator->damping_ratio;
    steady->load = oscillator->load;
    steady->origin = start.x;
    steady->periods_max = whole_periods(TRANSIENT / oscillator->damping_ratio, steady->mesh_period, PERIODS_LEAST);
    steady->window = whole_periods(WINDOW / oscillator->damping_ratio, steady->mesh_period, WINDOW_LEAST);
    steady->stage = QG_STEADY_MARCH;
    steady->next_attempt = FIRST_ATTEMPT;
    steady->history[0] = start;
}

bool qg_steady_wants_tangent(const struct qg_steady *steady) {
    return steady->stage == QG_STEADY_SHOOT || steady->stage == QG_STEADY_WINDOW;
}

bool qg_steady_restarts_tangent(const struct qg_steady *steady) {
    return steady->stage == QG_STEADY_WINDOW || (steady->stage == QG_STEADY_SHOOT && steady->done == 0);
}

/* The state of the march some mesh periods ago. */
static struct qg_state past(const struct qg_steady *steady, size_t periods) {
    assert(periods <= steady->marched && periods < QG_HISTORY);
    return steady->history[(steady->marched - periods) % QG_HISTORY];
}

static void remember(struct qg_steady *steady, const struct qg_period *period) {
    double n = (double)period->steps, mean = period->sum / n;
    steady->marched++;
    steady->history[steady->marched % QG_HISTORY] = period->end;
    steady->amplitude = sqrt(fmax(period->sum_of_squares / n - mean * mean, 0.0));
}

/* What lengths are compared with: the amplitude, but not less than rounding can resolve. */
static double scale(const struct qg_steady *steady) {
    return steady->amplitude + 1e-6 * steady->load;
}

/* The period to try now, or 0. */
static int candidate(const struct qg_steady *steady) {
    int best = 0;
    double least = HUGE_VAL;
    for (int n = 1; n <= QG_PERIOD_MAX && (size_t)(3 * n) <= steady->marched; n++) {
        double error = distance(past(steady, 0), past(steady, (size_t)n));
        if (error > NEARLY_RETURNED * scale(steady) || error >= least)
            continue;
        best = n;
        least = error;
        if (steady->attempts % 2 == 0)
            break;
    }
    return best;
}

static void begin_sums(struct qg_steady *steady) {
    steady->sum = steady->sum_of_squares = 0.0;
    steady->steps = 0;
    steady->beyond = false;
    steady->clearance = HUGE_VAL;
}

static void add_sums(struct qg_steady *steady, const struct qg_period *period) {
    steady->sum += period->sum;
    steady->sum_of_squares += period->sum_of_squares;
    steady->steps += period->steps;
    steady->beyond = steady->beyond || period->beyond;
    steady->clearance = fmin(steady->clearance, period->clearance);
}

static void begin_shot(struct qg_steady *steady, struct qg_state start) {
    steady->stage = QG_STEADY_SHOOT;
    steady->start = start;
    steady->done = 0;
    steady->linear = true;
    begin_sums(steady);
}

static void finish(struct qg_steady *steady, int period, struct qg_state state) {
    double n = (double)steady->steps, mean = steady->sum / n;
    steady->response = (struct qg_response){
        .rms = sqrt(fmax(steady->sum_of_squares / n - mean * mean, 0.0)),
        .mean = steady->origin + mean,
        .period = period,
        .beyond = steady->beyond,
        .x = state.x,
        .v = state.v,
    };
    steady->stage = QG_STEADY_DONE;
}

/* Back to the march after a trial that led nowhere. */
static bool resume(struct qg_steady *steady, struct qg_state *next) {
    size_t pause = steady->marched / 4;
    steady->stage = QG_STEADY_MARCH;
    steady->attempts++;
    steady->next_attempt = steady->marched + (pause < FIRST_ATTEMPT ? FIRST_ATTEMPT : pause);
    *next = steady->resume;
    return true;
}

/* The smallest period of the orbit just shot. */
static int smallest_period(const struct qg_steady *steady) {
    for (int n = 1; n < steady->period; n++) {
        if (steady->period % n == 0 && distance(steady->visited[n - 1], steady->start) < SAME_POINT * scale(steady))
            return n;
    }
    return steady->period;
}

static bool stable(const double m[4]) {
    double trace = m[0] + m[3], determinant = m[0] * m[3] - m[1] * m[2];
    return determinant < 1.0 && fabs(trace) < 1.0 + determinant;
}

/* (I - m)^-1 r: from the state to the fixed point of the affine map with matrix m and return error r. */
static struct qg_state to_fixed_point(const double m[4], struct qg_state r) {
    double determinant = (1.0 - m[0]) * (1.0 - m[3]) - m[1] * m[2];
    return (struct qg_state){((1.0 - m[3]) * r.x + m[1] * r.v) / determinant,
                             (m[2] * r.x + (1.0 - m[0]) * r.v) / determinant};
}

/* Do all returns of the march that are remembered, and at least two before the shot, follow the affine model about the
 * fixed point? */
static bool follows_affine_model(const struct qg_steady *steady, const double m[4], struct qg_state fixed) {
    size_t period = (size_t)steady->period,
           remembered = steady->marched < QG_HISTORY ? steady->marched : QG_HISTORY - 1;
    for (size_t i = 1; (i + 1) * period <= remembered && i < RETURNS; i++) {
        struct qg_state to = past(steady, i * period), from = past(steady, (i + 1) * period);
        double dx = from.x - fixed.x, dv = from.v - fixed.v;
        struct qg_state expected = {fixed.x + m[0] * dx + m[1] * dv, fixed.v + m[2] * dx + m[3] * dv};
        if (distance(expected, to) > AFFINE * distance(from, to) + CONVERGED * scale(steady))
            return false;
    }
    return true;
}

/* How far the march has moved about in the periods remembered. */
static double explored(const struct qg_steady *steady) {
    double farthest = 0.0;
    for (size_t i = 1; i < QG_HISTORY && i <= steady->marched; i++)
        farthest = fmax(farthest, distance(past(steady, 0), past(steady, i)));
    return farthest;
}

/* A shot has ended: accept the orbit, take a Newton step, or give up. */
static bool judge_shot(struct qg_steady *steady, const struct qg_period *shot, struct qg_state *next) {
    struct qg_state error = {shot->end.x - steady->start.x, shot->end.v - steady->start.v};
    struct qg_state step = to_fixed_point(shot->tangent, error);
    bool blind = steady->linear && !(steady->clearance > SAFE * length(step));
    if (!stable(shot->tangent) || (blind && steady->iteration > 0))
        return resume(steady, next);
    if (length(step) <= (steady->plain ? MARCHED : CONVERGED) * scale(steady)) {
        finish(steady, smallest_period(steady), shot->end);
        return false;
    }
    struct qg_state fixed = {steady->start.x + step.x, steady->start.v + step.v};
    bool hopeful;
    if (steady->iteration == 0)
        hopeful = !steady->plain && !blind && length(step) <= explored(steady) &&
                  follows_affine_model(steady, shot->tangent, fixed);
    else
        hopeful = steady->iteration < NEWTON_MAX && length(step) <= AFFINE * steady->last_step;
    if (!hopeful)
        return resume(steady, next);
    steady->iteration++;
    steady->last_step = length(step);
    begin_shot(steady, fixed);
    *next = fixed;
    return true;
}

static bool advance_shot(struct qg_steady *steady, const struct qg_period *period, struct qg_state *next) {
    steady->visited[steady->done++] = period->end;
    add_sums(steady, period);
    steady->linear = steady->linear && period->linear;
    if (steady->iteration == 0) { /* the first shot starts on the trajectory: it is part of the march */
        remember(steady, period);
        steady->resume = period->end;
    }
    return steady->done == steady->period && judge_shot(steady, period, next);
}

/* Ends a motion that grows without bound. False when it does not. */
static bool end_runaway(struct qg_steady *steady, const struct qg_period *period) {
    if (length(period->end) < RUNAWAY * fmax(1.0, steady->load))
        return false;
    begin_sums(steady);
    add_sums(steady, period);
    finish(steady, QG_PERIOD_UNBOUNDED, period->end);
    return true;
}

static void advance_march(struct qg_steady *steady, const struct qg_period *period) {
    remember(steady, period);
    if (steady->marched >= steady->periods_max) {
        steady->stage = QG_STEADY_WINDOW;
        steady->done = 0;
        steady->deviation = (struct qg_state){1.0, 0.0};
        begin_sums(steady);
        return;
    }
    if (end_runaway(steady, period) || steady->marched < steady->next_attempt)
        return;
    steady->period = candidate(steady);
    if (steady->period == 0) {
        steady->next_attempt = steady->marched + 1;
        return;
    }
    steady->iteration = 0;
    begin_shot(steady, period->end);
}

static void carry_deviation(struct qg_steady *steady, const double tangent[4]) {
    struct qg_state d = steady->deviation;
    if (!(length(d) < PARTED_ENOUGH))
        return;
    steady->deviation = (struct qg_state){tangent[0] * d.x + tangent[1] * d.v, tangent[2] * d.x + tangent[3] * d.v};
    if ((size_t)steady->done == steady->window / 4) {
        double unit = 1.0 / fmax(length(steady->deviation), 1.0 / PARTED_ENOUGH);
        steady->deviation.x *= unit;
        steady->deviation.v *= unit;
    }
}

static void advance_window(struct qg_steady *steady, const struct qg_period *period) {
    add_sums(steady, period);
    steady->done++;
    carry_deviation(steady, period->tangent);
    if (!end_runaway(steady, period) && (size_t)steady->done == steady->window)
        finish(steady, length(steady->deviation) > PARTED ? QG_PERIOD_CHAOTIC : QG_PERIOD_LONG, period->end);
}

bool qg_steady_advance(struct qg_steady *steady, const struct qg_period *period, struct qg_state *next) {
    switch (steady->stage) {
    case QG_STEADY_MARCH:
        advance_march(steady, period);
        return false;
    case QG_STEADY_SHOOT:
        return advance_shot(steady, period, next);
    case QG_STEADY_WINDOW:
        advance_window(steady, period);
        return false;
    case QG_STEADY_DONE:
    default:
        return false;
    }
}
