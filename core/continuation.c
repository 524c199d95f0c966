/* Pseudo-arclength continuation of periodic orbits (Keller 1977).
 *
 * Unknown is y = (x, v, p): a Poincare state and the frequency ratio. The orbits of period n are the roots of
 *
 *     G(y) = P^n(x, v; p) - (x, v) = 0,                                                                           (1)
 *
 * two equations for three unknowns: curves. From a root y0 with unit tangent t (G' t = 0, so t is the cross product of
 * the two rows of G') the next one is sought on the plane through y0 + h t that is perpendicular to t, with Newton's
 * method on (1) and t . (y - y0 - h t) = 0. A fold is nothing special for that. DP^n comes exactly from the integrator;
 * the derivative in p from two more lanes of the same batch, a central difference.
 *
 * Between two points of the curve is looked for sign changes of
 *     t_p                      fold;
 *     det(DP^n + I)            period doubling: 1 + trace + det, zero when a multiplier is -1;
 *     edges met by the orbit   a change of their number is a grazing;
 * and each is located by bisection or false position in h, which is exact to some 1e-8 in p. A Neimark-Sacker point
 * cannot exist (orbit.c).
 *
 * A curve ends at the ends of the range, where it closes upon itself (up to a shift by whole mesh periods), where a
 * curve of even period n runs into its own shifted image - that is the orbit of period n/2 at which it was born by
 * period doubling; states half a period apart pass through each other there - or where it leaves the amplitudes looked
 * at.
 *
 * P is once continuously differentiable: where an orbit grazes an edge the curve has a kink in its curvature, and the
 * steps get short by themselves.
 */
#include "core/continuation.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NEWTON_MAX = 9, LOCATE_MAX = 60, POINTS_MAX = 20000, STOP_EVERY = 16 };

static const double CONVERGED = 1e-10; /* of the last Newton step */
static const double DIFFERENCE = 1e-7; /* of p, for the derivative in p: small, for near a grazing that varies fast */
static const double STEP_FIRST = 1e-3;
static const double STEP_LEAST = 1e-8;
static const double STEP_MOST = 0.04;
static const double STEPS_OF_RANGE = 300; /* at least so many steps from one end of the range to the other */
static const double STRAIGHT = 0.98;      /* least cosine between successive tangents; about 11 degrees */
static const double DIVISIBLE = 1e-5;     /* a step longer than that is divided when something in it is not found */
static const double ON_CURVE = 0.1;       /* of a segment's length: a point nearer to it is on the curve */
static const double NEARBY = 0.3;         /* of the step: a root farther from its prediction is on another curve */
static const double LOCATED = 1e-9;       /* of h, for special points */

/* A root of (1) with what belongs to it. */
struct node {
    struct qg_place at, tangent;
    struct qg_orbit orbit; /* of the curve's period, even if it has a smaller one */
};

/* ---- places ----------------------------------------------------------------------------------------------------- */

static double dot(struct qg_place a, struct qg_place b) {
    return a.x * b.x + a.v * b.v + a.p * b.p;
}

static struct qg_place along(struct qg_place a, double h, struct qg_place b) {
    return (struct qg_place){a.x + h * b.x, a.v + h * b.v, a.p + h * b.p};
}

static struct qg_place cross(struct qg_place a, struct qg_place b) {
    return (struct qg_place){a.v * b.p - a.p * b.v, a.p * b.x - a.x * b.p, a.x * b.v - a.v * b.x};
}

static double distance(struct qg_place a, struct qg_place b) {
    struct qg_place d = along(a, -1.0, b);
    return sqrt(dot(d, d));
}

static struct qg_place unit(struct qg_place a) {
    double length = sqrt(dot(a, a));
    return (struct qg_place){a.x / length, a.v / length, a.p / length};
}

/* Distance of a point from the segment a b, in units of the segment's length. */
static double distance_from_segment(struct qg_place point, struct qg_place a, struct qg_place b) {
    struct qg_place along_ab = along(b, -1.0, a), to = along(point, -1.0, a);
    double square = dot(along_ab, along_ab), share = dot(to, along_ab) / square;
    share = fmin(fmax(share, 0.0), 1.0);
    struct qg_place off = along(to, -share, along_ab);
    return sqrt(dot(off, off) / square);
}

/* ---- Newton ----------------------------------------------------------------------------------------------------- */

/* G, the rows of G', and the shot behind them. */
struct linearization {
    double residual[2];
    struct qg_place row[2];
    struct qg_shot shot;
};

static void linearize(const struct qg_oscillator *oscillator, int period, struct qg_place at,
                      struct linearization *out) {
    struct qg_shot shot[3] = {0};
    for (int i = 0; i < 3; i++) {
        shot[i].frequency_ratio = at.p + (i == 1 ? DIFFERENCE : i == 2 ? -DIFFERENCE : 0.0);
        shot[i].start = (struct qg_state){at.x, at.v};
    }
    qg_batch_shoot(oscillator, (size_t)period, 3, shot);
    const double *m = shot[0].tangent;
    out->residual[0] = shot[0].end.x - at.x;
    out->residual[1] = shot[0].end.v - at.v;
    out->row[0] = (struct qg_place){m[0] - 1.0, m[1], (shot[1].end.x - shot[2].end.x) / (2.0 * DIFFERENCE)};
    out->row[1] = (struct qg_place){m[2], m[3] - 1.0, (shot[1].end.v - shot[2].end.v) / (2.0 * DIFFERENCE)};
    out->shot = shot[0];
}

/* The step d with G' d = -G and t . d = 0. */
static struct qg_place newton_step(const struct linearization *l, struct qg_place t) {
    struct qg_place a = cross(l->row[1], t), b = cross(t, l->row[0]);
    double determinant = dot(l->row[0], a);
    struct qg_place d = {0};
    d = along(d, -l->residual[0] / determinant, a);
    return along(d, -l->residual[1] / determinant, b);
}

/* From a guess to the root on the plane through it perpendicular to t. Answers the number of iterations, 0 when there
 * is no convergence. The tangent is turned to go along with t. */
static int correct(const struct qg_continuation *c, int period, struct qg_place guess, struct qg_place t,
                   struct node *out) {
    double last = HUGE_VAL;
    out->at = guess;
    for (int n = 1; n <= NEWTON_MAX; n++) {
        struct linearization l;
        linearize(c->oscillator, period, out->at, &l);
        struct qg_place d = newton_step(&l, t);
        double length = sqrt(dot(d, d));
        if (!(length < 2.0 * last && length < 1.0))
            return 0;
        if (length <= CONVERGED) {
            out->tangent = unit(cross(l.row[0], l.row[1]));
            if (dot(out->tangent, t) < 0.0)
                out->tangent = along((struct qg_place){0}, -1.0, out->tangent);
            qg_orbit_from_shot(&out->orbit, &l.shot, period);
            return n;
        }
        last = length;
        out->at = along(out->at, 1.0, d);
        if (!(out->at.p > 0.01))
            return 0;
    }
    return 0;
}

/* ---- the curve's storage ---------------------------------------------------------------------------------------- */

void qg_curve_finish(struct qg_curve *curve) {
    free(curve->point);
    free(curve->state);
    free(curve->special);
    *curve = (struct qg_curve){0};
}

static enum qg_status reserve_points(struct qg_curve *curve) {
    if (curve->count < curve->room)
        return QG_OK;
    size_t room = curve->room ? 2 * curve->room : 256;
    struct qg_branch_point *point = realloc(curve->point, room * sizeof *point);
    if (point)
        curve->point = point;
    double *state = realloc(curve->state, room * 2 * (size_t)curve->period * sizeof *state);
    if (state)
        curve->state = state;
    if (!point || !state)
        return QG_OUT_OF_MEMORY;
    curve->room = room;
    return QG_OK;
}

static enum qg_status add_point(struct qg_curve *curve, const struct qg_orbit *orbit) {
    enum qg_status status = reserve_points(curve);
    if (status != QG_OK)
        return status;
    struct qg_branch_point *point = &curve->point[curve->count];
    *point = (struct qg_branch_point){.frequency_ratio = orbit->frequency_ratio,
                                      .rms = orbit->rms,
                                      .mean = orbit->mean,
                                      .stable = orbit->floquet.stable};
    memcpy(point->multiplier_real, orbit->floquet.real, sizeof point->multiplier_real);
    memcpy(point->multiplier_imaginary, orbit->floquet.imaginary, sizeof point->multiplier_imaginary);
    double *state = curve->state + curve->count * 2 * (size_t)curve->period;
    for (int n = 0; n < curve->period; n++) {
        const struct qg_state *z = &orbit->state[n % orbit->period];
        state[2 * n] = z->x;
        state[2 * n + 1] = z->v;
    }
    curve->count++;
    return QG_OK;
}

static enum qg_status add_special(struct qg_curve *curve, enum qg_special kind, const struct qg_orbit *orbit) {
    if (curve->special_count == curve->special_room) {
        size_t room = curve->special_room ? 2 * curve->special_room : 16;
        struct qg_special_point *grown = realloc(curve->special, room * sizeof *grown);
        if (!grown)
            return QG_OUT_OF_MEMORY;
        curve->special = grown;
        curve->special_room = room;
    }
    curve->special[curve->special_count++] = (struct qg_special_point){kind, orbit->frequency_ratio, orbit->rms};
    return QG_OK;
}

static struct qg_place place_of(const struct qg_curve *curve, size_t point, int shift) {
    const double *state = curve->state + (point * (size_t)curve->period + (size_t)shift) * 2;
    return (struct qg_place){state[0], state[1], curve->point[point].frequency_ratio};
}

bool qg_curve_has(const struct qg_curve *curve, const struct qg_orbit *orbit) {
    const double margin = 1e-3;
    struct qg_place at = {orbit->state[0].x, orbit->state[0].v, orbit->frequency_ratio};
    if (orbit->period != curve->period)
        return false;
    for (size_t i = 0; i + 1 < curve->count; i++) {
        double a = curve->point[i].frequency_ratio, b = curve->point[i + 1].frequency_ratio;
        if (at.p < fmin(a, b) - margin || at.p > fmax(a, b) + margin)
            continue;
        for (int shift = 0; shift < curve->period; shift++)
            if (distance_from_segment(at, place_of(curve, i, shift), place_of(curve, i + 1, shift)) < ON_CURVE)
                return true;
    }
    return false;
}

static void reverse_points(struct qg_curve *curve) {
    size_t width = 2 * (size_t)curve->period;
    for (size_t i = 0, j = curve->count; i + 1 < j; i++) {
        struct qg_branch_point point = curve->point[i];
        double state[2 * QG_PERIOD_MAX];
        j--;
        curve->point[i] = curve->point[j];
        curve->point[j] = point;
        memcpy(state, curve->state + i * width, width * sizeof *state);
        memcpy(curve->state + i * width, curve->state + j * width, width * sizeof *state);
        memcpy(curve->state + j * width, state, width * sizeof *state);
    }
}

/* ---- special points --------------------------------------------------------------------------------------------- */

static double test_function(const struct node *node, enum qg_special kind) {
    const double *m = node->orbit.monodromy;
    switch (kind) {
    case QG_SPECIAL_FOLD:
        return node->tangent.p;
    case QG_SPECIAL_PERIOD_DOUBLING:
        return 1.0 + m[0] + m[3] + (m[0] * m[3] - m[1] * m[2]);
    case QG_SPECIAL_GRAZING_DRIVE:
        return node->orbit.drive_crossings;
    default:
        return node->orbit.back_crossings;
    }
}

/* Does the test function pass from one side to the other between two values? */
static bool passes(enum qg_special kind, double a, double b) {
    return kind < QG_SPECIAL_GRAZING_DRIVE ? (a < 0.0) != (b < 0.0) : a != b;
}

/* Where between node a and the root at distance h from it the test function changes; h is set to the distance. False
 * when the corrector fails on the way. */
static bool locate(const struct qg_continuation *c, enum qg_special kind, const struct node *a, const struct node *b,
                   double *h, struct node *out) {
    double low = 0.0, high = *h, f_low = test_function(a, kind), f_high = test_function(b, kind);
    bool smooth = kind < QG_SPECIAL_GRAZING_DRIVE;
    *out = *b;
    for (int n = 0; n < LOCATE_MAX && high - low > LOCATED; n++) {
        double share = smooth && n % 3 != 2 ? f_low / (f_low - f_high) : 0.5;
        double middle = low + fmin(fmax(share, 0.01), 0.99) * (high - low);
        if (!correct(c, a->orbit.period, along(a->at, middle, a->tangent), a->tangent, out))
            return false;
        double f = test_function(out, kind);
        if (passes(kind, f_low, f))
            high = middle, f_high = f;
        else
            low = middle, f_low = f;
        *h = middle;
        if (smooth && fabs(f) < 1e-12)
            break;
    }
    return true;
}

static void note_doubling(struct qg_continuation *c, const struct node *node) {
    const double *m = node->orbit.monodromy;
    struct qg_state a = {m[1], -1.0 - m[0]}, b = {-1.0 - m[3], m[2]};
    double length_a = sqrt(a.x * a.x + a.v * a.v), length_b = sqrt(b.x * b.x + b.v * b.v);
    struct qg_state e = length_a > length_b ? a : b;
    double length = fmax(length_a, length_b);
    if (2 * node->orbit.period > QG_PERIOD_MAX)
        return;
    if (c->doubling_count == QG_DOUBLINGS_MAX) {
        c->doublings_lost++;
        return;
    }
    c->doubling[c->doubling_count++] = (struct qg_doubling){node->orbit.period, node->at, {e.x / length, e.v / length}};
}

/* A special point found within a step. */
struct event {
    double h;
    enum qg_special kind;
    struct node node;
};

/* The special points between a and b, in their order along the curve. False when one of them cannot be located. */
static bool find_events(const struct qg_continuation *c, const struct node *a, const struct node *b,
                        struct event event[QG_SPECIAL_COUNT], int *count) {
    double step = dot(along(b->at, -1.0, a->at), a->tangent);
    *count = 0;
    for (int kind = 0; kind < QG_SPECIAL_COUNT; kind++) {
        struct event e = {.h = step, .kind = (enum qg_special)kind};
        if (!passes(e.kind, test_function(a, e.kind), test_function(b, e.kind)))
            continue;
        if (!locate(c, e.kind, a, b, &e.h, &e.node))
            return false;
        int at = (*count)++;
        for (; at > 0 && event[at - 1].h > e.h; at--)
            event[at] = event[at - 1];
        event[at] = e;
    }
    return true;
}

/* Special points become points of the curve, so that its stable parts end exactly there. */
static enum qg_status add_event(struct qg_continuation *c, struct qg_curve *curve, const struct event *event) {
    const struct node *node = &event->node;
    if (node->at.p < c->min || node->at.p > c->max)
        return QG_OK;
    if (event->kind == QG_SPECIAL_PERIOD_DOUBLING)
        note_doubling(c, node);
    enum qg_status status = add_special(curve, event->kind, &node->orbit);
    return status == QG_OK ? add_point(curve, &node->orbit) : status;
}

/* A step along the curve: the special points in between, and its end. QG_NO_CONVERGENCE, and nothing is added, when a
 * special point cannot be located and the step is long enough to be taken in smaller ones. */
static enum qg_status add_step(struct qg_continuation *c, struct qg_curve *curve, const struct node *a,
                               const struct node *b) {
    struct event event[QG_SPECIAL_COUNT];
    int count;
    if (!find_events(c, a, b, event, &count) && distance(a->at, b->at) > DIVISIBLE)
        return QG_NO_CONVERGENCE;
    enum qg_status status = QG_OK;
    for (int i = 0; i < count && status == QG_OK; i++)
        status = add_event(c, curve, &event[i]);
    return status == QG_OK ? add_point(curve, &b->orbit) : status;
}

/* ---- ends ------------------------------------------------------------------------------------------------------- */

static struct qg_place shifted(const struct node *node, int shift) {
    return (struct qg_place){node->orbit.state[shift].x, node->orbit.state[shift].v, node->at.p};
}

/* Has the curve come back to `start` between a and b? Then *end is the start as it is met there, shifted by some mesh
 * periods. */
static bool closes(const struct node *start, const struct node *a, const struct node *b, struct node *end) {
    int period = a->orbit.period;
    for (int shift = 0; shift < period; shift++) {
        if (distance_from_segment(start->at, shifted(a, shift), shifted(b, shift)) >= ON_CURVE)
            continue;
        *end = *start;
        for (int n = 0; n < period; n++)
            end->orbit.state[n] = start->orbit.state[(n + period - shift) % period];
        end->at = shifted(end, 0);
        return true;
    }
    return false;
}

/* From one state to that half a period later. */
static struct qg_state half_way(const struct node *node) {
    const struct qg_state *z = node->orbit.state;
    int half = node->orbit.period / 2;
    return (struct qg_state){z[half].x - z[0].x, z[half].v - z[0].v};
}

/* Has the orbit run through the one of half its period between a and b? */
static bool halves(const struct node *a, const struct node *b) {
    if (a->orbit.period % 2 != 0)
        return false;
    struct qg_state before = half_way(a), after = half_way(b);
    double reach = 4.0 * distance(a->at, b->at);
    return before.x * after.x + before.v * after.v < 0.0 &&
           sqrt(before.x * before.x + before.v * before.v) + sqrt(after.x * after.x + after.v * after.v) < reach;
}

static double doubling_function(const double m[4]) {
    return 1.0 + m[0] + m[3] + (m[0] * m[3] - m[1] * m[2]);
}

/* The period doubling of the orbit of half the period near `between`, by secants in p. */
static bool find_parent(const struct qg_continuation *c, int period, struct qg_place between, struct qg_orbit *parent) {
    double p[2] = {between.p, between.p + 1e-5}, f[2];
    struct qg_orbit orbit = {.state = {{between.x, between.v}}};
    bool found = true;
    for (int n = 0; n < 30; n++) {
        int i = n < 2 ? n : 1;
        if (n >= 2) {
            double next = p[1] - f[1] * (p[1] - p[0]) / (f[1] - f[0]);
            p[0] = p[1], f[0] = f[1], p[1] = next;
        }
        orbit.frequency_ratio = p[i];
        qg_orbit_shoot(c->oscillator, period, 1, &orbit, &found);
        if (!found || orbit.period != period || !(fabs(p[i] - between.p) < 0.01))
            return false;
        f[i] = doubling_function(orbit.monodromy);
        *parent = orbit;
        if (n >= 2 && (fabs(p[1] - p[0]) < 1e-9 || fabs(f[1]) < 1e-11))
            return true;
    }
    return false;
}

/* Ends a curve of even period on the branch that it was born from. QG_NO_CONVERGENCE, and nothing is added, when there
 * is no period doubling here: then the step has only gone over to the curve's shifted image. */
static enum qg_status end_on_parent(struct qg_continuation *c, struct qg_curve *curve, const struct node *a,
                                    const struct node *b) {
    struct qg_state before = half_way(a), after = half_way(b);
    double f = before.x * before.x + before.v * before.v, g = before.x * after.x + before.v * after.v;
    double step = distance(a->at, b->at), reach = fabs(a->at.p - b->at.p) + 0.1 * step;
    struct qg_place between = along(a->at, f / (f - g), along(b->at, -1.0, a->at));
    struct qg_orbit parent;
    if (!find_parent(c, curve->period / 2, between, &parent) || fabs(parent.frequency_ratio - between.p) > reach)
        return step > DIVISIBLE ? QG_NO_CONVERGENCE : QG_OK;
    enum qg_status status = add_special(curve, QG_SPECIAL_PERIOD_DOUBLING, &parent);
    return status == QG_OK ? add_point(curve, &parent) : status;
}

/* Ends a curve exactly at the end of the range that lies between a and b. */
static enum qg_status end_on_range(struct qg_continuation *c, struct qg_curve *curve, const struct node *a,
                                   const struct node *b) {
    double bound = b->at.p < c->min ? c->min : c->max, share = (bound - a->at.p) / (b->at.p - a->at.p);
    struct qg_place at = along(a->at, share, along(b->at, -1.0, a->at));
    struct qg_orbit orbit = {.frequency_ratio = bound, .state = {{at.x, at.v}}};
    bool found;
    if (fabs(bound - a->at.p) < 1e-9)
        return QG_OK;
    qg_orbit_shoot(c->oscillator, curve->period, 1, &orbit, &found);
    if (!found || orbit.period != curve->period)
        return QG_OK;
    struct node end = {.at = {orbit.state[0].x, orbit.state[0].v, bound}, .tangent = b->tangent, .orbit = orbit};
    return add_step(c, curve, a, &end);
}

/* ---- tracing ---------------------------------------------------------------------------------------------------- */

static double longest_step(const struct qg_continuation *c, const struct node *at) {
    double by_ratio = (c->max - c->min) / STEPS_OF_RANGE / fmax(fabs(at->tangent.p), 1e-3);
    return fmax(fmin(STEP_MOST, by_ratio), 1e-6);
}

/* The next root, at most *h away; *h becomes the step to try afterwards. False when the steps get too small. */
static bool step_on(const struct qg_continuation *c, const struct node *from, double *h, struct node *next) {
    for (*h = fmin(*h, longest_step(c, from)); *h > STEP_LEAST; *h *= 0.5) {
        struct qg_place guess = along(from->at, *h, from->tangent);
        int iterations = correct(c, from->orbit.period, guess, from->tangent, next);
        if (iterations == 0 || distance(next->at, guess) > NEARBY * *h ||
            (dot(from->tangent, next->tangent) < STRAIGHT && *h > 1e-6))
            continue;
        if (iterations <= 4)
            *h *= 1.5;
        return true;
    }
    return false;
}

static bool is_stopped(const struct qg_continuation *c) {
    return c->stop && c->stop->asked && c->stop->asked(c->stop->self);
}

/* What the step from one node to the next brings to an end, if anything: *end, and the curve's last points. */
static enum qg_status finish(struct qg_continuation *c, struct qg_curve *curve, const struct node step[2],
                             const struct node *start, enum qg_branch_end *end) {
    struct node closing;
    if (step[1].at.p < c->min || step[1].at.p > c->max) {
        *end = QG_END_RANGE;
        return end_on_range(c, curve, &step[0], &step[1]);
    }
    if (halves(&step[0], &step[1])) {
        *end = QG_END_PERIOD_DOUBLING;
        return end_on_parent(c, curve, &step[0], &step[1]);
    }
    if (start && closes(start, &step[0], &step[1], &closing)) {
        *end = QG_END_CLOSED;
        return add_step(c, curve, &step[0], &closing);
    }
    if (!qg_orbit_is_small(&step[1].orbit)) {
        *end = QG_END_AMPLITUDE;
        return add_step(c, curve, &step[0], &step[1]);
    }
    return QG_OK;
}

/* Follows the curve from a node along its tangent to an end. */
static enum qg_status trace(struct qg_continuation *c, struct qg_curve *curve, const struct node *start,
                            enum qg_branch_end *end) {
    struct node step[2] = {*start};
    double h = STEP_FIRST;
    *end = QG_END_LOST;
    for (size_t n = 0; n < POINTS_MAX; n++) {
        if (n % STOP_EVERY == 0 && is_stopped(c))
            return QG_CANCELLED;
        if (!step_on(c, &step[0], &h, &step[1]))
            return QG_OK;
        enum qg_status status = finish(c, curve, step, n > 2 ? start : NULL, end);
        if (status == QG_OK && *end == QG_END_LOST)
            status = add_step(c, curve, &step[0], &step[1]);
        else if (status != QG_NO_CONVERGENCE)
            return status;
        if (status == QG_NO_CONVERGENCE) {
            h = 0.25 * distance(step[0].at, step[1].at);
            *end = QG_END_LOST;
            continue;
        }
        if (status != QG_OK)
            return status;
        step[0] = step[1];
    }
    return QG_OK;
}

enum qg_status qg_continue_orbit(struct qg_continuation *c, const struct qg_orbit *from, struct qg_curve *curve) {
    struct node start;
    struct qg_place guess = {from->state[0].x, from->state[0].v, from->frequency_ratio};
    curve->period = from->period;
    if (!correct(c, from->period, guess, (struct qg_place){0.0, 0.0, 1.0}, &start))
        return QG_NO_CONVERGENCE;
    struct node back = start;
    back.tangent = along((struct qg_place){0}, -1.0, start.tangent);
    enum qg_status status = trace(c, curve, &back, &curve->end[0]);
    reverse_points(curve);
    if (status == QG_OK)
        status = add_point(curve, &start.orbit);
    if (curve->end[0] == QG_END_CLOSED)
        curve->end[1] = QG_END_CLOSED;
    else if (status == QG_OK)
        status = trace(c, curve, &start, &curve->end[1]);
    return status;
}

/* The first root beside a period doubling; the parent's own orbit is no answer. */
static bool leave_parent(const struct qg_continuation *c, const struct qg_doubling *from, struct node *out) {
    struct qg_place direction = {from->direction.x, from->direction.v, 0.0};
    for (double h = 0.02; h > 1e-5; h *= 0.5) {
        if (!correct(c, 2 * from->period, along(from->at, h, direction), direction, out))
            continue;
        struct qg_state half = half_way(out);
        if (distance(out->at, along(from->at, h, direction)) < NEARBY * h &&
            sqrt(half.x * half.x + half.v * half.v) > 0.5 * h)
            return true;
    }
    return false;
}

enum qg_status qg_continue_doubling(struct qg_continuation *c, const struct qg_doubling *from, struct qg_curve *curve) {
    struct qg_orbit parent = {.frequency_ratio = from->at.p, .state = {{from->at.x, from->at.v}}};
    struct node start;
    bool found;
    curve->period = 2 * from->period;
    qg_orbit_shoot(c->oscillator, from->period, 1, &parent, &found);
    if (!found || !leave_parent(c, from, &start))
        return QG_NO_CONVERGENCE;
    curve->end[0] = QG_END_PERIOD_DOUBLING;
    enum qg_status status = add_point(curve, &parent);
    if (status == QG_OK)
        status = add_special(curve, QG_SPECIAL_PERIOD_DOUBLING, &parent);
    if (status == QG_OK)
        status = add_point(curve, &start.orbit);
    return status == QG_OK ? trace(c, curve, &start, &curve->end[1]) : status;
}
