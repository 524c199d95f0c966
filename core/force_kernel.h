/* The march of the batched integrator under a force that depends on amplitude; part of dynamics_kernel.h, which see for
 * lanes, bits and units (time in steps, velocities per step).
 *
 * 1. Damping.  Within a step, x = exp(-zeta t) y turns x'' + 2 zeta x' + f(phi, x) = load into
 *        y'' = exp(zeta t) (load - f(phi, exp(-zeta t) y)) + zeta^2 y,
 *    free of y', for which Nystroem's method of order 4 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations
 *    I, II.14) takes the force at the beginning, the middle and the end of a step:
 *        k1 = g(0, y0)   k2 = g(1/2, y0 + w/2 + k1/8)   k3 = g(1, y0 + w + k2/2)
 *        y1 = y0 + w + (k1 + 2 k2)/6      w1 = w + (k1 + 4 k2 + k3)/6
 *    The force at the beginning of the next step is that of k3, carried by its slope from where k3 looked to y1: two looks
 *    at the force per step.
 * 2. Looks.  All lanes are at the same phase, so one section of the force (tabulated by force.c for all middles and ends)
 *    serves all; each lane counts the rungs below it and fetches its piece. Steps per mesh period are a divisor of the
 *    table's. The back flanks are looked at only when a lane is there; their section is made on the spot.
 * 3. Edges.  At the edge of contact the force has a kink, m |w| (t - t*)+, with slope m of the first piece and speed of
 *    approach w. What the method makes of a kink is known in closed form, and so is the truth: the difference is added,
 *    which lifts the error of a crossing from order 3 to order 4. The tangent meets a jump of the stiffness, and is
 *    corrected in the same way. The knots between the pieces, where only the third derivative of the motion's force
 *    jumps, need nothing.
 * 4. Tangent.  The derivative of the steps themselves, so that Newton's method sees the map that is marched.
 */

/* The steps of a batch: the smallest divisor of the force's table that is fine enough. */
static size_t force_steps(const struct qg_force *force, double lowest_ratio) {
    size_t needed = (size_t)fmin(ceil(2.0 * QG_PI / (lowest_ratio * FORCE_STEP_MAX)), 1e9);
    size_t least = FORCE_STEPS_PER_HARMONIC * (size_t)force->approach[QG_FLANK_DRIVE][0].harmonics;
    needed = needed > least ? needed : least;
    for (size_t steps = 1; steps < force->steps; steps++) {
        if (force->steps % steps == 0 && steps >= needed)
            return steps;
    }
    return force->steps;
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
    reals depth; /* approach beyond the drive flank's edge; negative: out of contact */
    bits beyond;
};

/* The force of one flank at the approaches of the lanes. */
INLINE struct pull pull_of(const double *knot, const struct qg_force_piece *piece, size_t levels, reals approach) {
    bits rung = (bits)splat(0.0);
    for (size_t j = 1; j < levels; j++)
        rung -= approach >= knot[j];
    reals d, force, slope, bend, twist;
    for (int i = 0; i < QG_LANES; i++) {
        const struct qg_force_piece *p = &piece[rung[i]];
        d[i] = knot[rung[i]];
        force[i] = p->force, slope[i] = p->slope, bend[i] = p->bend, twist[i] = p->twist;
    }
    d = approach - d;
    reals depth = approach - knot[0], zero = splat(0.0);
    bits touching = depth > 0.0;
    return (struct pull){.force = choose(touching, force + d * (slope + d * (bend + d * twist)), zero),
                         .slope = choose(touching, slope + d * (2.0 * bend + d * (3.0 * twist)), zero),
                         .depth = depth,
                         .beyond = rung == (long long)levels - 1};
}

/* Adds the back flanks' force at half step i of a period. Answers the lanes' depth there. */
static reals add_back(const struct batch *batch, size_t half_step, reals x, struct pull *pull) {
    const struct qg_force *force = batch->oscillator->force;
    struct qg_force_section section;
    qg_force_section_init(&section, force, QG_FLANK_BACK, (double)half_step / (double)(2 * batch->steps));
    struct pull back = pull_of(section.approach, section.piece, force->levels, -x - 1.0);
    pull->force -= back.force;
    pull->slope += back.slope;
    pull->beyond |= back.beyond;
    return back.depth;
}

/* Both flanks at half step i of a period, which lies in 0 .. 2 steps. */
INLINE struct pull pull_at(const struct batch *batch, size_t half_step, reals x) {
    const struct qg_force *force = batch->oscillator->force;
    size_t row = half_step % (2 * batch->steps) * (force->steps / batch->steps) * force->levels;
    struct pull pull = pull_of(force->knot + row, force->piece + row, force->levels, x - 1.0);
    if (any_sign(-x - 1.0 > force->least_error[QG_FLANK_BACK]))
        add_back(batch, half_step, x, &pull);
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

/* Answers which lanes met the edge. */
static bits correct_drive_edge(const struct batch *batch, size_t step, const struct looks *looks,
                               const struct motion *begin, struct motion *end, reals depth_end, bool tangent) {
    const struct qg_force *force = batch->oscillator->force;
    size_t row = (2 * step + 1) * (force->steps / batch->steps) * force->levels;
    struct crossing at = find_edge(looks->begin.depth, looks->middle.depth, depth_end);
    correct_edge(&at, 1.0, batch->pull_scale * force->piece[row].slope, begin, end, tangent);
    return at.crosses;
}

static bits correct_back_edge(const struct batch *batch, size_t step, const struct looks *looks,
                              const struct motion *begin, struct motion *end, bool tangent) {
    const struct qg_force *force = batch->oscillator->force;
    struct pull unused = {0};
    reals depth_begin = add_back(batch, 2 * step, begin->x, &unused);
    reals depth_middle = add_back(batch, 2 * step + 1, looks->x_middle, &unused);
    reals depth_end = add_back(batch, 2 * step + 2, end->x, &unused);
    struct crossing at = find_edge(depth_begin, depth_middle, depth_end);
    if (!any_sign(at.crosses))
        return at.crosses;
    struct qg_force_section section;
    qg_force_section_init(&section, force, QG_FLANK_BACK, (double)(2 * step + 1) / (double)(2 * batch->steps));
    correct_edge(&at, -1.0, batch->pull_scale * section.piece[0].slope, begin, end, tangent);
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

/* March of one mesh period; answers which lanes stayed on the drive flank all the time. */
static bits march_force_period(const struct batch *batch, struct motion *motion, struct sums *sums, bool tangent) {
    const struct qg_force *force = batch->oscillator->force;
    struct motion now = *motion;
    struct looks looks;
    looks.begin = pull_at(batch, 0, now.x);
    sums->sum = sums->squares = splat(0.0);
    sums->clearance = looks.begin.depth;
    sums->beyond = looks.begin.beyond;
    for (size_t k = 0; k < batch->steps; k++) {
        struct motion next = step_force(batch, k, &now, &looks, tangent);
        reals moved = next.x - looks.x_end, depth_end = looks.end.depth + moved;
        if (any_sign((bits)looks.begin.depth ^ (bits)depth_end)) {
            bits met = correct_drive_edge(batch, k, &looks, &now, &next, depth_end, tangent);
            sums->drive_crossings += choose(met, splat(1.0), splat(0.0));
            moved = next.x - looks.x_end, depth_end = looks.end.depth + moved;
        }
        reals deepest = smaller(next.x, smaller(now.x, looks.x_middle));
        if (any_sign(-deepest - 1.0 > force->least_error[QG_FLANK_BACK])) {
            bits met = correct_back_edge(batch, k, &looks, &now, &next, tangent);
            sums->back_crossings += choose(met, splat(1.0), splat(0.0));
        }
        moved = next.x - looks.x_end;
        now = next;
        sums->clearance = smaller(sums->clearance, smaller(looks.middle.depth, depth_end));
        sums->beyond |= looks.middle.beyond | looks.end.beyond;
        looks.begin = looks.end;
        looks.begin.force += looks.end.slope * moved;
        looks.begin.depth = looks.end.depth + moved;
        reals deviation = now.x - sums->origin;
        sums->sum += deviation;
        sums->squares += deviation * deviation;
    }
    *motion = now;
    return sums->clearance > 0.0;
}
