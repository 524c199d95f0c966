/* The set of all branches of one oscillator.
 *
 * Seeds are the attractors of attractors.c at every speed: what the fixed start, run-up and run-down reach, and what
 * random starts fall on, which is how branches are found that hang together with nothing else (isolas). Each seed that
 * does not lie on a branch known already is continued to a whole curve. Every period doubling met on the way is the
 * seed of the branch of twice the period; and where a curve ends on a period doubling, the branch of half the period is
 * followed too, in case nothing else has led to it.
 */
#include "core/branches.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/attractors.h"
#include "core/continuation.h"

static const struct qg_exploration exploration = {.speeds = 120, .starts = 64, .one_sided = false};

const char *qg_special_name(enum qg_special kind) {
    static const char *const names[QG_SPECIAL_COUNT] = {"fold", "period_doubling", "grazing_drive_flank",
                                                        "grazing_back_flank"};
    assert((unsigned)kind < QG_SPECIAL_COUNT);
    return names[kind];
}

const char *qg_branch_end_name(enum qg_branch_end end) {
    static const char *const names[] = {"range", "closed", "period_doubling", "amplitude", "lost"};
    assert((unsigned)end < sizeof names / sizeof *names);
    return names[end];
}

void qg_branches_finish(struct qg_branches *branches) {
    for (size_t i = 0; i < branches->count; i++)
        qg_curve_finish(&branches->curve[i]);
    *branches = (struct qg_branches){0};
}

/* ---- finding ---------------------------------------------------------------------------------------------------- */

static bool is_known(const struct qg_branches *b, const struct qg_orbit *orbit) {
    for (size_t i = 0; i < b->count; i++)
        if (qg_curve_has(&b->curve[i], orbit))
            return true;
    return false;
}

/* The orbit of a curve's point. */
static struct qg_orbit orbit_of(const struct qg_curve *curve, size_t point, int period) {
    struct qg_orbit orbit = {.frequency_ratio = curve->point[point].frequency_ratio, .period = period};
    for (int n = 0; n < period; n++) {
        const double *z = curve->state + (point * (size_t)curve->period + (size_t)n) * 2;
        orbit.state[n] = (struct qg_state){z[0], z[1]};
    }
    return orbit;
}

/* Enough curves, or enough points on them: under very small loads there is no end to either. */
static bool is_full(const struct qg_branches *b) {
    size_t points = 0;
    for (size_t i = 0; i < b->count; i++)
        points += b->curve[i].count;
    return b->count == QG_CURVES_MAX || points >= QG_CURVE_POINTS_MAX;
}

/* Keeps the new curve when its continuation came to something. */
static void keep(struct qg_branches *b, enum qg_status status) {
    struct qg_curve *curve = &b->curve[b->count];
    if (status == QG_OK && curve->count > 1)
        b->count++;
    else
        qg_curve_finish(curve);
    b->complete = b->complete && !is_full(b);
}

/* A numerical failure ends a curve, not the search for others. */
static enum qg_status tolerate(enum qg_status status) {
    return status == QG_NO_CONVERGENCE ? QG_OK : status;
}

static enum qg_status continue_orbit(struct qg_branches *b, struct qg_continuation *c, const struct qg_orbit *from) {
    if (is_full(b) || !qg_orbit_is_small(from) || is_known(b, from))
        return QG_OK;
    enum qg_status status = qg_continue_orbit(c, from, &b->curve[b->count]);
    keep(b, status);
    return tolerate(status);
}

/* Does a known curve of twice the period begin or end at this period doubling? */
static bool is_taken(const struct qg_branches *b, const struct qg_doubling *from) {
    for (size_t i = 0; i < b->count; i++) {
        const struct qg_curve *curve = &b->curve[i];
        for (int end = 0; end < 2 && curve->period == 2 * from->period; end++) {
            size_t point = end == 0 ? 0 : curve->count - 1;
            if (curve->end[end] != QG_END_PERIOD_DOUBLING ||
                fabs(curve->point[point].frequency_ratio - from->at.p) > 1e-5)
                continue;
            struct qg_orbit orbit = orbit_of(curve, point, from->period);
            for (int n = 0; n < from->period; n++)
                if (fabs(orbit.state[n].x - from->at.x) + fabs(orbit.state[n].v - from->at.v) < 1e-3)
                    return true;
        }
    }
    return false;
}

/* The branches at whose period doublings the newest curve ends. */
static enum qg_status continue_parents(struct qg_branches *b, struct qg_continuation *c, size_t newest) {
    enum qg_status status = QG_OK;
    for (int end = 0; end < 2 && status == QG_OK; end++) {
        const struct qg_curve *curve = &b->curve[newest];
        if (curve->end[end] != QG_END_PERIOD_DOUBLING)
            continue;
        size_t point = end == 0 ? 0 : curve->count - 1;
        struct qg_orbit parent = orbit_of(curve, point, curve->period / 2);
        status = continue_orbit(b, c, &parent);
    }
    return status;
}

/* Everything that hangs together with the curves from number `first` on. */
static enum qg_status continue_relatives(struct qg_branches *b, struct qg_continuation *c, size_t first) {
    enum qg_status status = QG_OK;
    size_t done = first;
    while (status == QG_OK && !is_full(b) && (done < b->count || c->doubling_count > 0)) {
        if (done < b->count) {
            status = continue_parents(b, c, done++);
            continue;
        }
        struct qg_doubling doubling = c->doubling[--c->doubling_count];
        if (is_taken(b, &doubling))
            continue;
        status = qg_continue_doubling(c, &doubling, &b->curve[b->count]);
        keep(b, status);
        status = tolerate(status);
    }
    return status;
}

static enum qg_status continue_attractors(struct qg_branches *b, struct qg_continuation *c,
                                          const struct qg_attractors *found) {
    enum qg_status status = QG_OK;
    for (size_t i = 0; i < found->count && status == QG_OK && !is_full(b); i++) {
        const struct qg_orbit *orbit = &found->item[i].orbit;
        size_t first = b->count;
        if (orbit->period <= 0) {
            b->unperiodic++;
            continue;
        }
        status = continue_orbit(b, c, orbit);
        if (status == QG_OK && b->count > first)
            status = continue_relatives(b, c, first);
    }
    return status;
}

enum qg_status qg_branches_find(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                const struct qg_stop *stop, struct qg_branches *branches) {
    *branches = (struct qg_branches){.complete = true};
    struct qg_attractors found;
    struct qg_continuation *c = calloc(1, sizeof *c);
    enum qg_status status = qg_attractors_find(oscillator, map, &exploration, &found);
    if (!c)
        status = QG_OUT_OF_MEMORY;
    if (status == QG_OK) {
        c->oscillator = oscillator;
        c->min = map->min;
        c->max = map->max;
        c->stop = stop;
        status = continue_attractors(branches, c, &found);
        branches->complete = branches->complete && c->doublings_lost == 0;
    }
    qg_attractors_finish(&found);
    free(c);
    return status;
}

/* ---- reading ---------------------------------------------------------------------------------------------------- */

static size_t add_orbit(const struct qg_orbit *orbit, size_t count, size_t room, struct qg_orbit *out) {
    for (size_t i = 0; i < count; i++)
        if (qg_orbit_same(&out[i], orbit, 1e-6))
            return count;
    if (count < room)
        out[count++] = *orbit;
    return count;
}

/* The orbit where the curve crosses a frequency ratio behind a point. */
static bool orbit_between(const struct qg_curve *curve, const struct qg_oscillator *oscillator, size_t point,
                          struct qg_orbit *orbit) {
    struct qg_orbit a = orbit_of(curve, point, curve->period), b = orbit_of(curve, point + 1, curve->period);
    double span = b.frequency_ratio - a.frequency_ratio;
    double share = span != 0.0 ? (orbit->frequency_ratio - a.frequency_ratio) / span : 0.0;
    bool found;
    orbit->state[0].x = a.state[0].x + share * (b.state[0].x - a.state[0].x);
    orbit->state[0].v = a.state[0].v + share * (b.state[0].v - a.state[0].v);
    qg_orbit_shoot(oscillator, curve->period, 1, orbit, &found);
    return found && orbit->period == curve->period;
}

size_t qg_branches_at(const struct qg_branches *branches, const struct qg_oscillator *oscillator,
                      double frequency_ratio, size_t room, struct qg_orbit *out) {
    size_t count = 0;
    for (size_t i = 0; i < branches->count; i++) {
        const struct qg_curve *curve = &branches->curve[i];
        for (size_t k = 0; k + 1 < curve->count; k++) {
            double a = curve->point[k].frequency_ratio, b = curve->point[k + 1].frequency_ratio;
            struct qg_orbit orbit = {.frequency_ratio = frequency_ratio};
            if ((a - frequency_ratio) * (b - frequency_ratio) <= 0.0 && orbit_between(curve, oscillator, k, &orbit))
                count = add_orbit(&orbit, count, room, out);
        }
    }
    return count;
}
