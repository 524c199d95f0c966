/* The march of the batched integrator under a force that depends on amplitude; part of dynamics_kernel.h, which see for
 * lanes, bits and units (time in steps, velocities per step).
 *
 * 1. Damping.  Within a step, x = exp(-zeta t) y turns x'' + 2 zeta x' + f(phi, x) = load into
 *        y'' = exp(zeta t) (load - f(phi, exp(-zeta t) y)) + zeta^2 y,
 *    free of y', for which Nystroem's method of order 4 (Hairer, Norsett, Wanner, Solving Ordinary Diff. Equations
 *    I, II.14) takes the force at the beginning, the middle and the end of a step:
 *        k1 = g(0, y0)   k2 = g(1/2, y0 + w/2 + k1/8)   k3 = g(1, y0 + w + k2/2)
 *        y1 = y0 + w + (k1 + 2 k2)/6      w1 = w + (k1 + 4 k2 + k3)/6
 *    The force at the beginning of the next step is that of k3, carried by its slope from where k3 looked to y1: 2
 *    looks at the force per step.
 * 2. Looks.  All lanes are at the same phase, so one section of the force (tabulated by force.c for middles and ends)
 *    serves all; each lane counts the rungs below it, up to the highest that any lane needs, and fetches its piece.
 *    Steps per mesh period are the table's or a half, a quarter, ... of them. The back flanks are looked at only when a
 *    lane is there.
 * 3. Edges.  At the edge of contact the force has a kink, m |w| (t - t*)+, with slope m of the first piece and speed of
 *    approach w. What the method makes of a kink is known in closed form, and so is the truth: the difference is added,
 *    which takes away the leading term of a crossing's error, of order 2. The tangent meets a jump of stiffness, and
 *    is corrected in the same way. Jumps of the force's second derivative, at the edges and at the knots between the
 *    pieces, are left alone: they, not the order of the method, bound the accuracy of violent motions. Over a mesh
 *    period through both edges the state errs by at most 1e-4, 2.5e-5, 1.3e-5 half-backlashes with steps of 0.1, 0.05,
 *    0.025 (test_force.c); weak motions are better by one to two orders.
 * 4. Tangent.  The derivative of the steps themselves, so that Newton's method sees the map that is marched.
 */

/* The steps of a batch: the force's table halved as often as it stays fine enough. Where their number changes, the map
 * of a mesh period jumps by its error; with halving only, that is at few speeds. */
static size_t force_steps(const struct qg_force *force, double lowest_ratio) {
    double needed = fmax(2.0 * QG_PI / (lowest_ratio * FORCE_STEP_MAX),
                         FORCE_STEPS_PER_HARMONIC * force->approach[QG_FLANK_DRIVE][0].harmonics);
    size_t steps = force->steps;
    while (steps % 2 == 0 && 0.5 * (double)steps >= needed)
        steps /= 2;
    return steps;
}

/* exp(-a) for small a, by its series. */
static reals decay_over(reals a) {
    reals sum = splat(0.0), term = splat(1.0);
    for (int n = 1; n <= 24; n++) {
        sum += term;
        term *= -a / (double)n;
    }
    return sum;
}

static void prepare_pull(struct batch *batch) {
    batch->pull_scale = batch->h2 * batch->oscillator->force_scale;
    batch->decay = decay_over(batch->d * 0.25);
    batch->grow = 1.0 / batch->decay;
}

/* One look at the force: per lane the force to the left and its derivative by x. */
struct pull {
    reals force, slope;
    reals depth[QG_FLANK_COUNT]; /* approach beyond each flank's edge, negative out of contact */
    bits beyond;
};

/* The section of a flank at half step i of a period, which lies in 0 .. 2 steps. */
struct row {
    const double *knot;
    const struct qg_force_piece *piece;
};

INLINE struct row row_at(const struct batch *batch, enum qg_flank flank, size_t half_step) {
    const struct qg_force *force = batch->oscillator->force;
    size_t row = half_step % (2 * batch->steps) * (force->steps / batch->steps) * force->levels;
    return (struct row){force->table[flank].knot + row, force->table[flank].piece + row};
}

/* Adds one flank's force at the approaches of the lanes, its direction +1 for the drive flank, -1 for the back. */
INLINE void add_flank(struct pull *pull, enum qg_flank flank, struct row row, size_t levels, reals approach) {
    bits rung = (bits)splat(0.0), above = ~rung;
    for (size_t j = 1; j < levels && any_sign(above); j++) {
        above = approach >= row.knot[j];
        rung -= above;
    }
    reals d, force, slope, bend, twist;
    for (int i = 0; i < QG_LANES; i++) {
        const struct qg_force_piece *p = &row.piece[rung[i]];
        d[i] = row.knot[rung[i]];
        force[i] = p->force, slope[i] = p->slope, bend[i] = p->bend, twist[i] = p->twist;
    }
    d = approach - d;
    reals zero = splat(0.0), direction = splat(flank == QG_FLANK_DRIVE ? 1.0 : -1.0);
    pull->depth[flank] = approach - row.knot[0];
    bits touching = pull->depth[flank] > 0.0;
    pull->force += choose(touching, direction * (force + d * (slope + d * (bend + d * twist))), zero);
    pull->slope += choose(touching, slope + d * (2.0 * bend + d * (3.0 * twist)), zero);
    pull->beyond |= rung == (long long)levels - 1;
}

/* Both flanks at half step i of a period. */
INLINE struct pull pull_at(const struct batch *batch, size_t half_step, reals x) {
    const struct qg_force *force = batch->oscillator->force;
    struct pull pull = {.depth[QG_FLANK_BACK] = splat(-1.0)};
    add_flank(&pull, QG_FLANK_DRIVE, row_at(batch, QG_FLANK_DRIVE, half_step), force->levels, x - 1.0);
    if (any_sign(-x - 1.0 > force->least_error[QG_FLANK_BACK]))
        add_flank(&pull, QG_FLANK_BACK, row_at(batch, QG_FLANK_BACK, half_step), force->levels, -x - 1.0);
    else
        pull.depth[QG_FLANK_BACK] = -x - 1.0 - row_at(batch, QG_FLANK_BACK, half_step).knot[0];
    return pull;
}

/* A lane's depth beyond one edge over a step, and what the edge does to it. */
struct crossing {
    reals theta, speed; /* when, in steps; per step, into contact positive */
    bits crosses, enters;
};

/* Depths at the beginning, the middle and the end. */
INLINE struct crossing find_edge(reals begin, reals middle, reals end) {
    bits crosses = negative(begin) ^ negative(end);
    reals c = 2.0 * (begin - 2.0 * middle + end), b = end - begin - c;
    reals theta = begin / choose(crosses, begin - end, splat(1.0));
    for (int i = 0; i < 3; i++) {
        reals slope = b + 2.0 * c * theta;
        theta -= (begin + theta * (b + theta * c)) / choose(magnitude(slope) > 1e-30, slope, splat(1e-30));
        theta = larger(smaller(theta, splat(1.0)), splat(0.0));
    }
    return (struct crossing){theta, b + 2.0 * c * theta, crosses, crosses & ~negative(end)};
}

/* What the method makes of (t - theta)+ and of its step, less the truth: for y and w. */
struct defect {
    reals ramp_x, ramp_v, jump_x, jump_v;
};

INLINE struct defect defect_of(reals theta) {
    reals zero = splat(0.0), rest = 1.0 - theta, early = larger(0.5 - theta, zero);
    reals before = choose(theta < 0.5, splat(1.0), zero);
    return (struct defect){.ramp_x = early * (1.0 / 3.0) - rest * rest * rest * (1.0 / 6.0),
                           .ramp_v = early * (2.0 / 3.0) + rest * (1.0 / 6.0) - rest * rest * 0.5,
                           .jump_x = before * (1.0 / 3.0) - rest * rest * 0.5,
                           .jump_v = before * (2.0 / 3.0) + 1.0 / 6.0 - rest};
}

/* Corrects a step for an edge. stiffness: slope of the force at the edge times h^2; direction: +1 drive, -1 back. */
static void correct_edge(const struct crossing *at, double direction, reals stiffness, const struct motion *begin,
                         struct motion *end, bool tangent) {
    struct defect defect = defect_of(at->theta);
    reals zero = splat(0.0), kink = choose(at->crosses, stiffness * magnitude(at->speed) * direction, zero);
    end->x += kink * defect.ramp_x;
    end->v += kink * defect.ramp_v;
    if (!tangent)
        return;
    reals jump = choose(at->crosses, choose(at->enters, stiffness, -stiffness), zero);
    reals first = jump * (begin->x1 + at->theta * begin->v1), second = jump * (begin->x2 + at->theta * begin->v2);
    end->x1 += first * defect.jump_x, end->v1 += first * defect.jump_v;
    end->x2 += second * defect.jump_x, end->v2 += second * defect.jump_v;
}

/* The three looks of a step, and the places they were taken at. */
struct looks {
    struct pull begin, middle, end;
    reals x_middle, x_end;
};

/* Corrects a step for the edges that a flank's depth has passed. depth_end: at the end of the step. Answers the lanes
 * that have met the edge. */
static bits correct_flank(const struct batch *batch, enum qg_flank flank, size_t step, const struct looks *looks,
                          const struct motion *begin, struct motion *end, reals depth_end, bool tangent) {
    struct crossing at = find_edge(looks->begin.depth[flank], looks->middle.depth[flank], depth_end);
    reals stiffness = batch->pull_scale * row_at(batch, flank, 2 * step + 1).piece[0].slope;
    correct_edge(&at, flank == QG_FLANK_DRIVE ? 1.0 : -1.0, stiffness, begin, end, tangent);
    return at.crosses;
}

/* A column of the tangent through a step. */
INLINE void step_column(reals *x, reals *v, const struct batch *batch, const struct looks *looks) {
    reals dh = batch->d * 0.5, dh2 = dh * dh, decay2 = batch->decay * batch->decay;
    reals w = *v + dh * *x, k1 = (dh2 - batch->pull_scale * looks->begin.slope) * *x;
    reals k2 = (dh2 - batch->pull_scale * looks->middle.slope) * (*x + w * 0.5 + k1 * 0.125);
    reals k3 = (dh2 - batch->pull_scale * looks->end.slope) * (*x + w + k2 * 0.5);
    reals y = *x + w + (k1 + 2.0 * k2) * (1.0 / 6.0);
    w += (k1 + 4.0 * k2 + k3) * (1.0 / 6.0);
    *x = decay2 * y;
    *v = decay2 * (w - dh * y);
}

/* One step of all lanes without regard to edges. looks->begin is given. */
INLINE struct motion step_force(const struct batch *batch, size_t step, const struct motion *now, struct looks *looks,
                                bool tangent) {
    struct motion next = *now;
    reals dh = batch->d * 0.5, dh2 = dh * dh, decay2 = batch->decay * batch->decay, grow2 = batch->grow * batch->grow;
    reals w = now->v + dh * now->x;
    reals k1 = batch->forcing - batch->pull_scale * looks->begin.force + dh2 * now->x;
    reals y = now->x + w * 0.5 + k1 * 0.125;
    looks->x_middle = batch->decay * y;
    looks->middle = pull_at(batch, 2 * step + 1, looks->x_middle);
    reals k2 = batch->grow * (batch->forcing - batch->pull_scale * looks->middle.force) + dh2 * y;
    y = now->x + w + k2 * 0.5;
    looks->x_end = decay2 * y;
    looks->end = pull_at(batch, 2 * step + 2, looks->x_end);
    reals k3 = grow2 * (batch->forcing - batch->pull_scale * looks->end.force) + dh2 * y;
    y = now->x + w + (k1 + 2.0 * k2) * (1.0 / 6.0);
    w += (k1 + 4.0 * k2 + k3) * (1.0 / 6.0);
    next.x = decay2 * y;
    next.v = decay2 * (w - dh * y);
    if (tangent) {
        step_column(&next.x1, &next.v1, batch, looks);
        step_column(&next.x2, &next.v2, batch, looks);
    }
    return next;
}

/* Corrects a step for all edges met, and counts them. Answers the look at its end, carried from where it was taken to
 * there. */
static struct pull correct_step(const struct batch *batch, size_t step, const struct looks *looks,
                                const struct motion *begin, struct motion *end, struct sums *sums, bool tangent) {
    reals moved = end->x - looks->x_end, one = splat(1.0), zero = splat(0.0);
    reals drive = looks->end.depth[QG_FLANK_DRIVE] + moved, back = looks->end.depth[QG_FLANK_BACK] - moved;
    if (any_sign((bits)looks->begin.depth[QG_FLANK_DRIVE] ^ (bits)drive)) {
        bits met = correct_flank(batch, QG_FLANK_DRIVE, step, looks, begin, end, drive, tangent);
        sums->drive_crossings += choose(met, one, zero);
    }
    if (any_sign((bits)looks->begin.depth[QG_FLANK_BACK] ^ (bits)back)) {
        bits met = correct_flank(batch, QG_FLANK_BACK, step, looks, begin, end, back, tangent);
        sums->back_crossings += choose(met, one, zero);
    }
    struct pull pull = looks->end;
    moved = end->x - looks->x_end;
    pull.force += pull.slope * moved;
    pull.depth[QG_FLANK_DRIVE] += moved;
    pull.depth[QG_FLANK_BACK] -= moved;
    return pull;
}

/* March of one mesh period; answers which lanes stayed on the drive flank all the time. */
static bits march_force_period(const struct batch *batch, struct motion *motion, struct sums *sums, bool tangent) {
    struct motion now = *motion;
    struct looks looks;
    looks.begin = pull_at(batch, 0, now.x);
    sums->sum = sums->squares = splat(0.0);
    sums->clearance = looks.begin.depth[QG_FLANK_DRIVE];
    sums->beyond = looks.begin.beyond;
    for (size_t k = 0; k < batch->steps; k++) {
        struct motion next = step_force(batch, k, &now, &looks, tangent);
        looks.begin = correct_step(batch, k, &looks, &now, &next, sums, tangent);
        now = next;
        reals least = smaller(looks.middle.depth[QG_FLANK_DRIVE], looks.begin.depth[QG_FLANK_DRIVE]);
        sums->clearance = smaller(sums->clearance, least);
        sums->beyond |= looks.middle.beyond | looks.end.beyond;
        reals deviation = now.x - sums->origin;
        sums->sum += deviation;
        sums->squares += deviation * deviation;
    }
    *motion = now;
    return sums->clearance > 0.0;
}
