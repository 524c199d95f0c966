/* The batched integrator: eight neighbouring speeds side by side, one per SIMD lane.
 *
 * The equation is linear wherever the gears are in one state of contact. With y = x - e, side s = +1
 * (drive flank in contact, y > 1), 0 (free, |y| <= 1) or -1 (back flank, y < -1), u = x - s and c = s^2,
 *
 *     u'' + 2 zeta u' + c kappa (u - e) = load                                                                    (1)
 *
 * so that its flow over a time step is an affine map, the same one on both flanks. All lanes take the same number N of
 * steps per mesh period: step k of every lane covers the phases k/N to (k+1)/N, kappa and e are the same in all lanes
 * there, and only the duration h = T/N differs from lane to lane. Time within a step is theta in [-1/2, 1/2];
 * velocities inside this file are per step, V = h x'. In theta, (1) reads
 *
 *     u_tt + d u_t + c h^2 kappa (u - e) = h^2 load,   d = 2 zeta h.                                               (2)
 *
 * 1. Excitation.  Per step, kappa and e are polynomials in theta of degree 7: the Taylor series of the Fourier series
 *    about the middle of the step. N is so large that the highest harmonic turns by no more than 1.2 rad in a step; the
 *    first term left out is then below 4e-7 of that harmonic's amplitude.
 * 2. Tables.  Per step and lane, the map of (2) with c = 1 from three power series about the middle of the step: two
 *    homogeneous solutions and a particular one, matched at both ends. Relative error near 1e-9, for steps of 0.2 in
 *    time, so the step is not limited by accuracy but by what comes next. The free map (c = 0) is the same for all
 *    steps.
 * 3. March.  A step costs a lane two affine maps and a selection between them. A step is looked at closely if its end
 *    lies outside the side's interval, or if the tangents at both ends leave that interval (y may have left and come
 *    back).
 * 4. Edges.  Steps looked at closely are done again for the lanes concerned, all in one go: power series of the motion
 *    from theta, first root of y = edge by Newton's method kept in a bracket, change of side, and on from there to the
 *    end of the step. The force is continuous at the edge, so an error dt in the time of crossing costs only O(dt^2): a
 *    tolerance of 1e-7 steps is rounding error.
 * 5. Linear orbit.  The product of the tables over a period is the Poincare map of a lane that stays on the drive
 *    flank. If its multipliers are complex, it has the invariant form q(d) = d ^ P d, q(P d) = det P q(d), an ellipse
 *    that shrinks from period to period; if they are real and below 1, both parts of a deviation along the eigenvectors
 *    shrink. If the orbit of the fixed point, fattened by what the present deviation can still become, nowhere touches
 *    the edge, then the march could never leave the flank again and its end is the fixed point: done, exactly. Many
 *    speeds are done in that way before their first step.
 * 6. Force that depends on amplitude: step 1 to 5 do not apply; force_kernel.h marches in place of 3 and 4.
 * 7. Verdict.  All else (return errors, Newton's method on the Poincare map, periods above one) is dynamics_steady.c.
 *    The tangent that it asks for goes through the same maps and series.
 *
 * Bits     no lane reads another; neighbours only share N, which depends on the map's cut into pieces and not on who
 *          runs them. This file is compiled for three instruction sets without fused multiply-add or reordering: equal
 *          bits.
 * Memory   the tables of up to STEPS_ROOM steps, on the stack (some 150 kB). With more steps per period the tables are
 *          made anew for each stretch of STEPS_ROOM steps: right, but slow; it takes p < 0.12 or more than 48
 *          harmonics.
 * Failures none; what does not settle gets period 0.
 */
#include "core/dynamics_batch.h"

#include <math.h>
#include <string.h>

#include "core/dynamics_steady.h"
#include "core/force.h"

#ifndef QG_RUN_BLOCK
#error "name the entry: QG_RUN_BLOCK"
#endif
#define INLINE static inline __attribute__((always_inline))

typedef double reals __attribute__((vector_size(64)));
typedef long long bits __attribute__((vector_size(64)));

enum {
    ORDER = 8,        /* of the power series of the motion */
    DEGREE = 7,       /* of kappa and e in a step */
    STEPS_ROOM = 256, /* steps in the tables */
    SEGMENTS_MAX = 8, /* sides visited within one step */
    ROOT_STEPS = 24
};

static const double STEP_MAX = 0.2;           /* in 1/omega_n, at the lowest speed of the batch */
static const double STEPS_PER_HARMONIC = 5.3; /* of one mesh period */
static const double FAR = 1e300;
static const double FORCE_STEP_MAX = 0.05; /* the same with a force that depends on amplitude */
enum { FORCE_STEPS_PER_HARMONIC = 16 };

/* kappa and e in one step: Taylor coefficients about its middle, and e and de/dtheta at its end. */
struct excitation {
    double kappa[DEGREE + 1], error[DEGREE + 1];
    double error_end, error_slope_end;
};

/* (u, V) at the end of a step = matrix (u, V) + shift, for c = 1. */
struct step_map {
    reals a11, a12, a21, a22, b1, b2;
};

/* The motion of all lanes at one instant, with the two columns of the tangent. */
struct motion {
    reals x, v, side;
    reals x1, v1, x2, v2;
};

/* What a lane's motion is kept within while on its side: lower <= y <= upper. */
struct interval {
    reals lower, upper;
};

struct batch {
    const struct qg_oscillator *oscillator;
    size_t steps;       /* N */
    bool has_error;     /* e is not zero */
    double error_start; /* e and de/dtheta at phase 0 */
    double error_slope_start;
    reals h, d, h2, forcing;                  /* duration of a step, 2 zeta h, h^2, h^2 load */
    reals free_x_v, free_v_v, free_x, free_v; /* the free map: x += free_x_v V + free_x, V = free_v_v V + free_v */
    size_t first, filled;                     /* the tables hold steps first..first+filled-1 */
    struct excitation excitation[STEPS_ROOM];
    struct step_map map[STEPS_ROOM];
    reals pull_scale, decay, grow; /* with a force: h^2 force_scale, exp(-zeta h / 2) and its inverse */
};

/* Results of one mesh period for all lanes. */
struct sums {
    reals origin, sum, squares;
    reals clearance;                       /* with a force: least distance from the drive flank's edge; else 0 */
    bits beyond;                           /* lanes that left the ladder of the force */
    reals drive_crossings, back_crossings; /* edges met since the lane began */
};

/* The orbit that stays on the drive flank. */
struct linear_orbit {
    reals x, v; /* its fixed point */
    reals mean, rms;
    reals clearance; /* least distance from the edge; not positive: the orbit does not exist */
    /* Complex multipliers: the invariant form, and the square of the largest u within a period per unit of it. */
    bits spiral;
    reals form11, form12, form22, reach;
    /* Real multipliers: the functionals that take a deviation apart along the eigenvectors, and the largest |u| within
     * a period per unit of each part. */
    reals part1_x, part1_v, part2_x, part2_v, reach1, reach2;
};

INLINE reals splat(double a) {
    return (reals){a, a, a, a, a, a, a, a};
}

INLINE reals choose(bits mask, reals a, reals b) {
    return (reals)(((bits)a & mask) | ((bits)b & ~mask));
}

/* The sign bit of each lane spread over it. */
INLINE bits negative(reals a) {
    return (bits)a < 0;
}

INLINE bool any_sign(bits a) {
    typedef long long half __attribute__((vector_size(32)));
    typedef long long quarter __attribute__((vector_size(16)));
    half h = __builtin_shufflevector(a, a, 0, 1, 2, 3) | __builtin_shufflevector(a, a, 4, 5, 6, 7);
    quarter q = __builtin_shufflevector(h, h, 0, 1) | __builtin_shufflevector(h, h, 2, 3);
    return (q[0] | q[1]) < 0;
}

INLINE reals magnitude(reals a) {
    return (reals)((bits)a & 0x7fffffffffffffffLL);
}

INLINE reals larger(reals a, reals b) {
    return choose(a > b, a, b);
}

INLINE reals smaller(reals a, reals b) {
    return choose(a < b, a, b);
}

INLINE reals square_root(reals a) {
    for (int i = 0; i < QG_LANES; i++)
        a[i] = sqrt(a[i]);
    return a;
}

/* --- excitation --- */

/* Taylor weights of one harmonic: value and slope at the middle of a step to the coefficients of the step. */
struct harmonic {
    double value[DEGREE + 1], slope[DEGREE + 1];
    double cosine, sine;           /* of the harmonic's angle at the middle of the step */
    double turn_cosine, turn_sine; /* of its turn per step */
};

static void harmonic_init(struct harmonic *out, int number, size_t step, size_t steps) {
    double per_step = (double)number / (double)steps, weight = 1.0;
    for (int n = 0; n <= DEGREE; n++) {
        double sign = n % 4 < 2 ? weight : -weight;
        out->value[n] = n % 2 == 0 ? sign : 0.0;
        out->slope[n] = n % 2 == 1 ? sign : 0.0;
        weight *= 2.0 * QG_PI * per_step / (n + 1);
    }
    qg_turn((double)((size_t)number * (2 * step + 1) % (2 * steps)) / (double)(2 * steps), &out->cosine, &out->sine);
    qg_turn(per_step, &out->turn_cosine, &out->turn_sine);
}

static void harmonic_turn(struct harmonic *at) {
    double cosine = at->cosine * at->turn_cosine - at->sine * at->turn_sine;
    at->sine = at->cosine * at->turn_sine + at->sine * at->turn_cosine;
    at->cosine = cosine;
}

static void add_harmonic(double coefficient[DEGREE + 1], const struct harmonic *at, double cosine, double sine) {
    double value = cosine * at->cosine + sine * at->sine, slope = sine * at->cosine - cosine * at->sine;
    for (int n = 0; n <= DEGREE; n++)
        coefficient[n] += value * at->value[n] + slope * at->slope[n];
}

static double polynomial(const double coefficient[DEGREE + 1], double theta) {
    double value = 0.0;
    for (int n = DEGREE; n >= 0; n--)
        value = value * theta + coefficient[n];
    return value;
}

static double polynomial_slope(const double coefficient[DEGREE + 1], double theta) {
    double value = 0.0;
    for (int n = DEGREE; n >= 1; n--)
        value = value * theta + n * coefficient[n];
    return value;
}

static bool is_zero(const struct qg_fourier *series) {
    bool zero = series->mean == 0.0;
    for (int j = 0; j < series->harmonics; j++)
        zero = zero && series->cosine[j] == 0.0 && series->sine[j] == 0.0;
    return zero;
}

/* Fills the excitation of the steps held. */
static void tabulate_excitation(struct batch *batch) {
    const struct qg_fourier *kappa = &batch->oscillator->stiffness, *error = &batch->oscillator->error;
    for (size_t k = 0; k < batch->filled; k++) {
        memset(&batch->excitation[k], 0, sizeof batch->excitation[k]);
        batch->excitation[k].kappa[0] = kappa->mean;
        batch->excitation[k].error[0] = error->mean;
    }
    int harmonics = kappa->harmonics > error->harmonics ? kappa->harmonics : error->harmonics;
    for (int j = 1; j <= harmonics; j++) {
        struct harmonic at;
        harmonic_init(&at, j, batch->first, batch->steps);
        for (size_t k = 0; k < batch->filled; k++, harmonic_turn(&at)) {
            if (j <= kappa->harmonics)
                add_harmonic(batch->excitation[k].kappa, &at, kappa->cosine[j - 1], kappa->sine[j - 1]);
            if (batch->has_error && j <= error->harmonics)
                add_harmonic(batch->excitation[k].error, &at, error->cosine[j - 1], error->sine[j - 1]);
        }
    }
    for (size_t k = 0; k < batch->filled && batch->has_error; k++) {
        struct excitation *at = &batch->excitation[k];
        at->error_end = polynomial(at->error, 0.5);
        at->error_slope_end = polynomial_slope(at->error, 0.5);
    }
    if (batch->first == 0 && batch->has_error) {
        batch->error_start = polynomial(batch->excitation[0].error, -0.5);
        batch->error_slope_start = polynomial_slope(batch->excitation[0].error, -0.5);
    }
}

/* --- power series --- */

/* 1 / ((n + 1) (n + 2)) */
static const double reciprocal[ORDER - 1] = {1.0 / 2, 1.0 / 6, 1.0 / 12, 1.0 / 20, 1.0 / 30, 1.0 / 42, 1.0 / 56};

/* Completes the power series u of (2) from its first two coefficients. stiffness is c h^2; error may be NULL for 0. */
INLINE void complete_series(reals u[ORDER + 1], const reals kappa[DEGREE + 1], const reals *error, reals d,
                            reals stiffness, reals forcing) {
    reals stretch[DEGREE + 1];
#pragma GCC unroll 8
    for (int n = 0; n <= ORDER - 2; n++) {
        stretch[n] = error ? u[n] - error[n] : u[n];
        reals force = kappa[0] * stretch[n];
#pragma GCC unroll 8
        for (int j = 1; j <= n; j++)
            force += kappa[j] * stretch[n - j];
        reals sum = -(d * (n + 1.0)) * u[n + 1] - stiffness * force;
        if (n == 0)
            sum += forcing;
        u[n + 2] = sum * reciprocal[n];
    }
}

INLINE reals series_at(const reals u[ORDER + 1], reals theta) {
    reals value = u[ORDER];
#pragma GCC unroll 8
    for (int n = ORDER - 1; n >= 0; n--)
        value = value * theta + u[n];
    return value;
}

INLINE reals series_slope_at(const reals u[ORDER + 1], reals theta) {
    reals value = u[ORDER] * (double)ORDER;
#pragma GCC unroll 8
    for (int n = ORDER - 1; n >= 1; n--)
        value = value * theta + u[n] * (double)n;
    return value;
}

/* Values and slopes at theta = -1/2 and +1/2. */
struct ends {
    reals left, left_slope, right, right_slope;
};

INLINE struct ends series_ends(const reals u[ORDER + 1]) {
    reals even = splat(0.0), odd = even, even_slope = even, odd_slope = even;
    double power = 1.0;
#pragma GCC unroll 9
    for (int n = 0; n <= ORDER; n++) {
        if (n % 2 == 0) {
            even += u[n] * power;
            odd_slope += u[n] * (2.0 * n * power);
        } else {
            odd += u[n] * power;
            even_slope += u[n] * (2.0 * n * power);
        }
        power *= 0.5;
    }
    return (struct ends){even - odd, even_slope - odd_slope, even + odd, even_slope + odd_slope};
}

/* Coefficients about another point: p(theta + shift). */
INLINE void shift_polynomial(reals out[DEGREE + 1], const double coefficient[DEGREE + 1], reals shift) {
#pragma GCC unroll 8
    for (int n = 0; n <= DEGREE; n++)
        out[n] = splat(coefficient[n]);
#pragma GCC unroll 8
    for (int i = 0; i < DEGREE; i++) {
#pragma GCC unroll 8
        for (int n = DEGREE - 1; n >= i; n--)
            out[n] += shift * out[n + 1];
    }
}

/* --- tables --- */

static void tabulate_step(const struct batch *batch, const struct excitation *at, struct step_map *map) {
    reals kappa[DEGREE + 1], error[DEGREE + 1], u[ORDER + 1];
#pragma GCC unroll 8
    for (int n = 0; n <= DEGREE; n++) {
        kappa[n] = splat(at->kappa[n]);
        error[n] = splat(at->error[n]);
    }
    reals zero = splat(0.0), one = splat(1.0);
    u[0] = one, u[1] = zero;
    complete_series(u, kappa, NULL, batch->d, batch->h2, zero);
    struct ends p = series_ends(u);
    u[0] = zero, u[1] = one;
    complete_series(u, kappa, NULL, batch->d, batch->h2, zero);
    struct ends q = series_ends(u);
    u[0] = zero, u[1] = zero;
    complete_series(u, kappa, error, batch->d, batch->h2, batch->forcing);
    struct ends r = series_ends(u);
    reals scale = one / (p.left * q.left_slope - q.left * p.left_slope);
    map->a11 = (p.right * q.left_slope - q.right * p.left_slope) * scale;
    map->a12 = (q.right * p.left - p.right * q.left) * scale;
    map->a21 = (p.right_slope * q.left_slope - q.right_slope * p.left_slope) * scale;
    map->a22 = (q.right_slope * p.left - p.right_slope * q.left) * scale;
    map->b1 = r.right - (map->a11 * r.left + map->a12 * r.left_slope);
    map->b2 = r.right_slope - (map->a21 * r.left + map->a22 * r.left_slope);
}

/* Makes the tables hold the stretch that begins with step `first`; does nothing if they do. */
static void tabulate(struct batch *batch, size_t first) {
    if (batch->filled > 0 && batch->first == first)
        return;
    batch->first = first;
    batch->filled = batch->steps - first < STEPS_ROOM ? batch->steps - first : STEPS_ROOM;
    tabulate_excitation(batch);
    for (size_t k = 0; k < batch->filled; k++)
        tabulate_step(batch, &batch->excitation[k], &batch->map[k]);
}

/* The free map over a whole step: phi1 = (1 - exp(-d)) / d and phi2 = (1 - phi1) / d by their series. */
static void tabulate_free(struct batch *batch) {
    reals phi1 = splat(0.0), phi2 = phi1, term = splat(1.0);
    for (int n = 1; n <= 30; n++) {
        phi1 += term;
        term *= -batch->d / (n + 1.0);
        phi2 -= term / batch->d;
    }
    batch->free_x_v = phi1;
    batch->free_v_v = splat(1.0) - batch->d * phi1;
    batch->free_x = batch->forcing * phi2;
    batch->free_v = batch->forcing * phi1;
}

#include "core/force_kernel.h"

static size_t steps_per_period(const struct qg_oscillator *oscillator, double lowest_ratio) {
    int kappa = oscillator->stiffness.harmonics, error = oscillator->error.harmonics;
    double by_time = ceil(2.0 * QG_PI / (lowest_ratio * STEP_MAX));
    double by_harmonics = ceil(STEPS_PER_HARMONIC * (kappa > error ? kappa : error));
    return (size_t)fmax(fmax(by_time, by_harmonics), 16.0);
}

static void batch_init(struct batch *batch, const struct qg_oscillator *oscillator, const double ratio[QG_LANES]) {
    double lowest = ratio[0];
    for (int i = 1; i < QG_LANES; i++)
        lowest = fmin(lowest, ratio[i]);
    batch->oscillator = oscillator;
    batch->steps = oscillator->force ? force_steps(oscillator->force, lowest) : steps_per_period(oscillator, lowest);
    batch->has_error = !is_zero(&oscillator->error);
    batch->error_start = batch->error_slope_start = 0.0;
    batch->filled = 0;
    for (int i = 0; i < QG_LANES; i++)
        batch->h[i] = 2.0 * QG_PI / (ratio[i] * (double)batch->steps);
    batch->d = batch->h * (2.0 * oscillator->damping_ratio);
    batch->h2 = batch->h * batch->h;
    batch->forcing = batch->h2 * oscillator->load;
    if (oscillator->force) {
        prepare_pull(batch);
        return;
    }
    tabulate_free(batch);
    tabulate(batch, 0);
}

/* --- march --- */

INLINE struct interval interval_of(reals side) {
    reals far = splat(FAR), one = splat(1.0);
    return (struct interval){choose(side > 0.0, one, choose(side < 0.0, -far, -one)),
                             choose(side > 0.0, far, choose(side < 0.0, -one, one))};
}

INLINE reals side_of(reals y) {
    return choose(y > 1.0, splat(1.0), choose(y < -1.0, splat(-1.0), splat(0.0)));
}

/* Sign bits of the lanes whose y may have left the interval between two instants one unit of theta apart. */
INLINE bits leaves(struct interval in, reals y, reals slope, reals y_end, reals slope_end, reals duration) {
    reals forward = y + slope * duration, backward = y_end - slope_end * duration;
    bits below = (bits)(y_end - in.lower) | ((bits)(forward - in.lower) & (bits)(backward - in.lower));
    bits above = (bits)(in.upper - y_end) | ((bits)(in.upper - forward) & (bits)(in.upper - backward));
    return below | above;
}

/* The root of a power series in [0, end], given that it has one sign near theta = 0 and the other at the end. */
static reals root(const reals g[ORDER + 1], reals end, bits wanted) {
    reals inside = splat(0.0), outside = end, theta = end;
    bits outside_sign = negative(series_at(g, end));
    for (int i = 0; i < ROOT_STEPS && any_sign(wanted); i++) {
        reals value = series_at(g, theta);
        bits is_outside = ~(negative(value) ^ outside_sign);
        outside = choose(wanted & is_outside, theta, outside);
        inside = choose(wanted & ~is_outside, theta, inside);
        reals newton = theta - value / series_slope_at(g, theta);
        bits kept = (newton > inside) & (newton < outside);
        reals next = choose(kept, newton, (inside + outside) * 0.5);
        bits arrived = magnitude(next - theta) < 1e-7;
        theta = choose(wanted, next, theta);
        wanted &= ~arrived;
    }
    return theta;
}

/* Where y is farthest out of its interval between theta = 0 and end, for lanes whose slope changes sign there. */
static reals extremum(const reals g[ORDER + 1], reals end, bits wanted) {
    reals slope[ORDER + 1];
    for (int n = 0; n < ORDER; n++)
        slope[n] = g[n + 1] * (n + 1.0);
    slope[ORDER] = splat(0.0);
    return root(slope, end, wanted);
}

/* One stretch on one side, from theta to the first edge or the end of the step. */
struct segment {
    reals begin, duration; /* in theta */
    bits crosses;          /* lanes that end on an edge */
    bits upward;           /* of those, lanes that go up */
};

/* Finds where the lanes in `wanted` leave their interval. g is the series of y from the segment's beginning. */
static void find_crossing(struct segment *segment, const reals g[ORDER + 1], reals side, bits wanted) {
    struct interval in = interval_of(side);
    reals rest = 0.5 - segment->begin, end = rest;
    reals y_end = series_at(g, rest), slope_end = series_slope_at(g, rest);
    bits below = y_end<in.lower, above = y_end> in.upper;
    bits turns = negative(g[1]) ^ negative(slope_end);
    bits doubtful = wanted & turns & ~below & ~above;
    doubtful &= negative((reals)leaves(in, g[0], g[1], y_end, slope_end, rest));
    if (any_sign(doubtful)) {
        reals theta = extremum(g, rest, doubtful);
        reals y = series_at(g, theta);
        below |= doubtful & (y < in.lower);
        above |= doubtful & (y > in.upper);
        end = choose(doubtful, theta, end);
    }
    segment->crosses = wanted & (below | above);
    segment->upward = above;
    segment->duration = rest;
    if (!any_sign(segment->crosses))
        return;
    reals distance[ORDER + 1];
    distance[0] = g[0] - choose(below, in.lower, in.upper);
    for (int n = 1; n <= ORDER; n++)
        distance[n] = g[n];
    segment->duration = choose(segment->crosses, root(distance, end, segment->crosses), rest);
}

/* Carries a column of the tangent through a segment. */
INLINE void carry_column(reals *x, reals *v, const struct batch *batch, const reals kappa[DEGREE + 1], reals stiffness,
                         reals duration, bits wanted) {
    reals u[ORDER + 1];
    u[0] = *x, u[1] = *v;
    complete_series(u, kappa, NULL, batch->d, stiffness, splat(0.0));
    *x = choose(wanted, series_at(u, duration), *x);
    *v = choose(wanted, series_slope_at(u, duration), *v);
}

/* Does one step again for the lanes wanted, from edge to edge. */
static void resolve_step(const struct batch *batch, const struct excitation *at, struct motion *motion, bits wanted,
                         bool tangent, struct sums *sums) {
    struct segment segment = {.begin = splat(-0.5)};
    for (int i = 0; i < SEGMENTS_MAX && any_sign(wanted); i++) {
        reals kappa[DEGREE + 1], error[DEGREE + 1], u[ORDER + 1], g[ORDER + 1];
        shift_polynomial(kappa, at->kappa, segment.begin);
        shift_polynomial(error, at->error, segment.begin);
        reals stiffness = choose(motion->side == 0.0, splat(0.0), batch->h2);
        u[0] = motion->x - motion->side, u[1] = motion->v;
        complete_series(u, kappa, error, batch->d, stiffness, batch->forcing);
        for (int n = 0; n <= ORDER; n++)
            g[n] = n <= DEGREE ? u[n] - error[n] : u[n];
        g[0] += motion->side;
        find_crossing(&segment, g, motion->side, wanted);
        if (i == SEGMENTS_MAX - 1)
            segment.crosses = wanted & 0, segment.duration = 0.5 - segment.begin;
        motion->x = choose(wanted, motion->side + series_at(u, segment.duration), motion->x);
        motion->v = choose(wanted, series_slope_at(u, segment.duration), motion->v);
        if (tangent) {
            carry_column(&motion->x1, &motion->v1, batch, kappa, stiffness, segment.duration, wanted);
            carry_column(&motion->x2, &motion->v2, batch, kappa, stiffness, segment.duration, wanted);
        }
        reals side = motion->side + choose(segment.upward, splat(1.0), splat(-1.0));
        reals met = choose(segment.crosses, splat(1.0), splat(0.0));
        bits at_drive = motion->side + side > 0.0;
        sums->drive_crossings += choose(at_drive, met, splat(0.0));
        sums->back_crossings += choose(at_drive, splat(0.0), met);
        motion->side = choose(segment.crosses, side, motion->side);
        segment.begin += segment.duration;
        wanted &= segment.crosses;
    }
}

INLINE void map_column(reals *x, reals *v, const struct batch *batch, const struct step_map *map, bits contact) {
    reals x_contact = map->a11 * *x + map->a12 * *v, v_contact = map->a21 * *x + map->a22 * *v;
    reals x_free = *x + batch->free_x_v * *v, v_free = batch->free_v_v * *v;
    *x = choose(contact, x_contact, x_free);
    *v = choose(contact, v_contact, v_free);
}

/* One mesh period of all lanes; lanes that are not active go on without regard to edges. Answers which lanes stayed on
 * the drive flank all the time. */
static bits march_period(struct batch *batch, struct motion *motion, bits active, struct sums *sums, bool tangent) {
    if (batch->oscillator->force)
        return march_force_period(batch, motion, sums, tangent);
    struct motion now = *motion;
    struct interval in = interval_of(now.side);
    bits contact = now.side != 0.0;
    reals y = now.x - batch->error_start, slope = now.v - batch->error_slope_start;
    sums->sum = sums->squares = splat(0.0);
    bits linear = now.side > 0.0;
    for (size_t k = 0; k < batch->steps; k++) {
        if (k % STEPS_ROOM == 0)
            tabulate(batch, k);
        const struct step_map *map = &batch->map[k % STEPS_ROOM];
        const struct excitation *at = &batch->excitation[k % STEPS_ROOM];
        struct motion next = now;
        reals u = now.x - now.side;
        reals x_contact = now.side + (map->a11 * u + map->a12 * now.v + map->b1);
        reals v_contact = map->a21 * u + map->a22 * now.v + map->b2;
        reals x_free = now.x + (batch->free_x_v * now.v + batch->free_x);
        reals v_free = batch->free_v_v * now.v + batch->free_v;
        next.x = choose(contact, x_contact, x_free);
        next.v = choose(contact, v_contact, v_free);
        if (tangent) {
            map_column(&next.x1, &next.v1, batch, map, contact);
            map_column(&next.x2, &next.v2, batch, map, contact);
        }
        reals y_end = next.x - at->error_end, slope_end = next.v - at->error_slope_end;
        bits suspects = leaves(in, y, slope, y_end, slope_end, splat(1.0)) & active;
        if (any_sign(suspects)) {
            struct motion again = now;
            bits wanted = suspects < 0;
            linear &= ~wanted;
            resolve_step(batch, at, &again, wanted, tangent, sums);
            next.x = choose(wanted, again.x, next.x);
            next.v = choose(wanted, again.v, next.v);
            next.side = again.side;
            if (tangent) {
                next.x1 = choose(wanted, again.x1, next.x1);
                next.v1 = choose(wanted, again.v1, next.v1);
                next.x2 = choose(wanted, again.x2, next.x2);
                next.v2 = choose(wanted, again.v2, next.v2);
            }
            in = interval_of(next.side);
            contact = next.side != 0.0;
            y_end = next.x - at->error_end, slope_end = next.v - at->error_slope_end;
        }
        now = next;
        y = y_end, slope = slope_end;
        reals deviation = now.x - sums->origin;
        sums->sum += deviation;
        sums->squares += deviation * deviation;
    }
    *motion = now;
    return linear;
}

/* --- linear orbit --- */

/* The affine map of (u, V) from the beginning of the period to step k on the drive flank. */
struct product {
    reals m11, m12, m21, m22, q1, q2;
};

INLINE void extend_product(struct product *product, const struct step_map *map) {
    struct product p = *product;
    product->m11 = map->a11 * p.m11 + map->a12 * p.m21;
    product->m12 = map->a11 * p.m12 + map->a12 * p.m22;
    product->m21 = map->a21 * p.m11 + map->a22 * p.m21;
    product->m22 = map->a21 * p.m12 + map->a22 * p.m22;
    product->q1 = map->a11 * p.q1 + map->a12 * p.q2 + map->b1;
    product->q2 = map->a21 * p.q1 + map->a22 * p.q2 + map->b2;
}

INLINE struct product identity_product(void) {
    reals zero = splat(0.0), one = splat(1.0);
    return (struct product){one, zero, zero, one, zero, zero};
}

/* Complex multipliers: the invariant form d ^ P d, made positive definite and of determinant 1. */
INLINE void find_invariant_form(struct linear_orbit *orbit, const struct product *period) {
    reals half = (period->m22 - period->m11) * 0.5;
    reals determinant = -period->m21 * period->m12 - half * half;
    orbit->spiral = determinant > 0.0;
    reals scale = 1.0 / square_root(choose(orbit->spiral, determinant, splat(1.0)));
    scale = choose(period->m21 < 0.0, -scale, scale);
    orbit->form11 = scale * period->m21;
    orbit->form12 = scale * half;
    orbit->form22 = -scale * period->m12;
}

/* The eigenvectors (m12, mu - m11) of real multipliers; u along them. */
struct eigenvectors {
    reals x, v1, v2;
};

/* Real multipliers, both inside the unit circle: the eigenvectors and the functionals dual to them. */
INLINE struct eigenvectors find_eigenvectors(struct linear_orbit *orbit, const struct product *period) {
    reals half = (period->m22 - period->m11) * 0.5, product = period->m12 * period->m21;
    reals root = square_root(larger(half * half + product, splat(0.0)));
    struct eigenvectors e = {period->m12, half + root, half - root};
    reals scale = 1.0 / (e.x * (e.v1 - e.v2));
    orbit->part1_x = -e.v2 * scale, orbit->part1_v = e.x * scale;
    orbit->part2_x = e.v1 * scale, orbit->part2_v = -e.x * scale;
    return e;
}

INLINE bits is_stable(const struct product *period) {
    reals determinant = period->m11 * period->m22 - period->m12 * period->m21;
    return magnitude(period->m11 + period->m22) < 1.0 + determinant;
}

/* Follows the orbit of the fixed point and the deviations from it through one period. */
static void follow_linear_orbit(struct batch *batch, struct linear_orbit *orbit, const struct eigenvectors *e) {
    struct product at = identity_product();
    reals zero = splat(0.0), u = orbit->x - 1.0, v = orbit->v, bend = zero, sum = zero, squares = zero;
    orbit->clearance = splat(FAR);
    orbit->reach = orbit->reach1 = orbit->reach2 = zero;
    for (size_t k = 0; k < batch->steps; k++) {
        if (k % STEPS_ROOM == 0)
            tabulate(batch, k);
        const struct step_map *map = &batch->map[k % STEPS_ROOM];
        extend_product(&at, map);
        reals before = u, v_before = v;
        u = map->a11 * before + map->a12 * v_before + map->b1;
        v = map->a21 * before + map->a22 * v_before + map->b2;
        orbit->clearance = smaller(orbit->clearance, u - batch->excitation[k % STEPS_ROOM].error_end);
        bend = larger(bend, magnitude(v - v_before));
        reals reach =
            at.m11 * at.m11 * orbit->form22 - 2.0 * at.m11 * at.m12 * orbit->form12 + at.m12 * at.m12 * orbit->form11;
        orbit->reach = larger(orbit->reach, reach);
        orbit->reach1 = larger(orbit->reach1, magnitude(at.m11 * e->x + at.m12 * e->v1));
        orbit->reach2 = larger(orbit->reach2, magnitude(at.m11 * e->x + at.m12 * e->v2));
        reals deviation = u - (orbit->x - 1.0);
        sum += deviation;
        squares += deviation * deviation;
    }
    reals mean = sum / (double)batch->steps;
    orbit->mean = orbit->x + mean;
    orbit->rms = square_root(larger(squares / (double)batch->steps - mean * mean, zero));
    orbit->clearance -= bend * 0.25; /* between the steps y may be lower, by an eighth of the bend */
}

static void find_linear_orbit(struct batch *batch, struct linear_orbit *orbit) {
    struct product period = identity_product();
    for (size_t k = 0; k < batch->steps; k++) {
        if (k % STEPS_ROOM == 0)
            tabulate(batch, k);
        extend_product(&period, &batch->map[k % STEPS_ROOM]);
    }
    reals a = 1.0 - period.m11, b = 1.0 - period.m22, determinant = a * b - period.m12 * period.m21;
    orbit->x = (b * period.q1 + period.m12 * period.q2) / determinant + 1.0;
    orbit->v = (period.m21 * period.q1 + a * period.q2) / determinant;
    find_invariant_form(orbit, &period);
    struct eigenvectors e = find_eigenvectors(orbit, &period);
    follow_linear_orbit(batch, orbit, &e);
    orbit->clearance = choose(is_stable(&period), orbit->clearance, splat(-1.0));
}

/* The lanes that are bound to end on the linear orbit: no later deviation can reach the edge. */
INLINE bits captured(const struct linear_orbit *orbit, const struct motion *motion) {
    const double margin = 1.03; /* deviations, too, may be larger between the steps */
    reals dx = motion->x - orbit->x, dv = motion->v - orbit->v;
    reals form = orbit->form11 * dx * dx + 2.0 * orbit->form12 * dx * dv + orbit->form22 * dv * dv;
    reals part1 = magnitude(orbit->part1_x * dx + orbit->part1_v * dv);
    reals part2 = magnitude(orbit->part2_x * dx + orbit->part2_v * dv);
    bits spiral = form * orbit->reach * (margin * margin) < orbit->clearance * orbit->clearance;
    bits straight = (part1 * orbit->reach1 + part2 * orbit->reach2) * margin < orbit->clearance;
    return (orbit->clearance > 0.0) & ((orbit->spiral & spiral) | (~orbit->spiral & straight));
}

/* --- a batch of speeds --- */

/* The lanes' judges beside the vectors. */
struct lanes {
    struct qg_steady steady[QG_LANES];
    bits active, linear;
    struct motion motion;
    struct linear_orbit orbit;
    struct sums sums;
};

static void place_lane(struct lanes *lanes, const struct batch *batch, int i, struct qg_state state) {
    double y = state.x - batch->error_start;
    lanes->motion.x[i] = state.x;
    lanes->motion.v[i] = state.v * batch->h[i];
    lanes->motion.side[i] = y > 1.0 ? 1.0 : y < -1.0 ? -1.0 : 0.0;
}

static void fresh_tangent(struct lanes *lanes, const struct batch *batch, int i) {
    lanes->motion.x1[i] = 1.0, lanes->motion.v1[i] = 0.0;
    lanes->motion.x2[i] = 0.0, lanes->motion.v2[i] = batch->h[i];
}

static void start_lane(struct lanes *lanes, const struct batch *batch, int i, double ratio, struct qg_state start) {
    qg_steady_init(&lanes->steady[i], batch->oscillator, ratio, start);
    place_lane(lanes, batch, i, start);
    lanes->sums.origin[i] = start.x;
    lanes->active[i] = -1;
}

/* Ends the lanes that are bound for the linear orbit. */
static void capture_lanes(struct lanes *lanes, const struct batch *batch, bool plain) {
    bits mask = captured(&lanes->orbit, &lanes->motion) & (lanes->motion.side > 0.0) & lanes->active;
    if (plain || !any_sign(mask))
        return;
    for (int i = 0; i < QG_LANES; i++) {
        if (!mask[i] || lanes->steady[i].stage == QG_STEADY_SHOOT)
            continue;
        lanes->steady[i].response = (struct qg_response){.rms = lanes->orbit.rms[i],
                                                         .mean = lanes->orbit.mean[i],
                                                         .period = 1,
                                                         .x = lanes->orbit.x[i],
                                                         .v = lanes->orbit.v[i] / batch->h[i]};
        lanes->active[i] = 0;
    }
}

static void advance_lane(struct lanes *lanes, const struct batch *batch, int i) {
    const struct motion *motion = &lanes->motion;
    double h = batch->h[i];
    struct qg_period period = {.end = {motion->x[i], motion->v[i] / h},
                               .tangent = {motion->x1[i], motion->x2[i], motion->v1[i] / h, motion->v2[i] / h},
                               .sum = lanes->sums.sum[i],
                               .sum_of_squares = lanes->sums.squares[i],
                               .steps = batch->steps,
                               .linear = lanes->linear[i] != 0,
                               .beyond = lanes->sums.beyond[i] != 0,
                               .clearance = lanes->sums.clearance[i]};
    struct qg_state next;
    if (qg_steady_advance(&lanes->steady[i], &period, &next))
        place_lane(lanes, batch, i, next);
    if (qg_steady_restarts_tangent(&lanes->steady[i]))
        fresh_tangent(lanes, batch, i);
    if (lanes->steady[i].stage == QG_STEADY_DONE)
        lanes->active[i] = 0;
}

/* Marches until no lane is active. */
static void settle(struct lanes *lanes, struct batch *batch, bool plain) {
    capture_lanes(lanes, batch, plain);
    while (any_sign(lanes->active)) {
        bool tangent = false;
        for (int i = 0; i < QG_LANES; i++)
            tangent = tangent || (lanes->active[i] && qg_steady_wants_tangent(&lanes->steady[i]));
        lanes->linear = march_period(batch, &lanes->motion, lanes->active, &lanes->sums, tangent);
        for (int i = 0; i < QG_LANES; i++) {
            if (lanes->active[i])
                advance_lane(lanes, batch, i);
        }
        capture_lanes(lanes, batch, plain);
    }
}

static double ratio_of(const struct qg_block *block, size_t i) {
    return block->ratio ? block->ratio[i] : qg_speed_at(block->map, block->first + i);
}

static void prepare_block(const struct qg_block *block, struct batch *batch, struct lanes *lanes,
                          double ratio[QG_LANES]) {
    for (size_t i = 0; i < QG_LANES; i++)
        ratio[i] = ratio_of(block, i < block->count ? i : block->count - 1);
    batch_init(batch, block->oscillator, ratio);
    memset(lanes, 0, sizeof *lanes);
    for (int i = 0; i < QG_LANES; i++) /* lanes never used rest in the dead zone */
        fresh_tangent(lanes, batch, i);
    if (batch->oscillator->force)
        return;
    find_linear_orbit(batch, &lanes->orbit);
    tabulate(batch, 0);
}

/* All speeds side by side, from the same state or each from its own. */
static void run_abreast(const struct qg_block *block, struct batch *batch, struct lanes *lanes, const double *ratio) {
    for (size_t i = 0; i < block->count; i++) {
        start_lane(lanes, batch, (int)i, ratio[i], block->start[block->ratio ? i : 0]);
        lanes->steady[i].plain = block->plain;
    }
    settle(lanes, batch, block->plain);
    for (size_t i = 0; i < block->count; i++)
        block->out[block->first + i] = lanes->steady[i].response;
}

/* One speed after another, each from the steady state of the one before. */
static void run_in_turn(const struct qg_block *block, struct batch *batch, struct lanes *lanes, const double *ratio) {
    for (size_t n = 0; n < block->count; n++) {
        size_t i = block->map->branch == QG_BRANCH_RUN_UP ? n : block->count - 1 - n;
        start_lane(lanes, batch, (int)i, ratio[i], *block->start);
        lanes->steady[i].plain = block->plain;
        settle(lanes, batch, block->plain);
        const struct qg_response *response = &lanes->steady[i].response;
        block->out[block->first + i] = *response;
        *block->start = (struct qg_state){response->x, response->v};
    }
}

static void finish_shot(const struct lanes *lanes, const struct batch *batch, int i, struct qg_shot *shot) {
    const struct motion *end = &lanes->motion;
    double h = batch->h[i], tangent[4] = {end->x1[i], end->x2[i], end->v1[i] / h, end->v2[i] / h};
    memcpy(shot->tangent, tangent, sizeof tangent);
    shot->end = (struct qg_state){end->x[i], end->v[i] / h};
    shot->drive_crossings = (int)lanes->sums.drive_crossings[i];
    shot->back_crossings = (int)lanes->sums.back_crossings[i];
}

/* All lanes over a given number of mesh periods. */
static void march_only(const struct qg_block *block, struct batch *batch, struct lanes *lanes, const double *ratio) {
    struct qg_shot *shots = block->shots;
    for (size_t i = 0; i < block->count; i++) {
        start_lane(lanes, batch, (int)i, ratio[i], shots[i].start);
        shots[i].sum = shots[i].sum_of_squares = 0.0;
        shots[i].steps = block->periods * batch->steps;
        shots[i].beyond = 0;
    }
    for (size_t n = 0; n < block->periods; n++) {
        march_period(batch, &lanes->motion, lanes->active, &lanes->sums, true);
        for (int i = 0; i < (int)block->count; i++) {
            shots[i].sum += lanes->sums.sum[i];
            shots[i].sum_of_squares += lanes->sums.squares[i];
            shots[i].beyond |= lanes->sums.beyond[i] != 0;
            if (n < QG_PERIOD_MAX)
                shots[i].visited[n] = (struct qg_state){lanes->motion.x[i], lanes->motion.v[i] / batch->h[i]};
        }
    }
    for (int i = 0; i < (int)block->count; i++)
        finish_shot(lanes, batch, i, &shots[i]);
}

void QG_RUN_BLOCK(const struct qg_block *block) {
    struct batch batch;
    struct lanes lanes;
    double ratio[QG_LANES];
    prepare_block(block, &batch, &lanes, ratio);
    if (block->shots)
        march_only(block, &batch, &lanes, ratio);
    else if (block->ratio || block->map->branch == QG_BRANCH_FIXED)
        run_abreast(block, &batch, &lanes, ratio);
    else
        run_in_turn(block, &batch, &lanes, ratio);
}
