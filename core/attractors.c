/* Attractors, by sweeping.
 *
 * Marching finds what is stable, but a start per speed finds it at that speed only, and a run-up finds one branch. Here
 * every stable orbit that a march ends on is a seed: it is followed to the neighbouring speeds, up and down, eight
 * speeds at a time (one per SIMD lane), by extrapolating its state from the last three speeds and correcting with
 * Newton's method, until it loses stability or ends in a fold. A few batches of shots cover a branch that marching
 * would take hundreds of transients for. Where it ends, a march from its last state tells where a machine would go that
 * changes its speed slowly; that is a seed again. So the set holds what run-up and run-down visit, plus what fixed and
 * random starts fall on.
 *
 * Orbits whose Poincare states lie beyond QG_STATE_MAX are not followed: there is a stable orbit without bound in the
 * model (the parametric resonance of a pair that hammers on both flanks), and nothing in it to hold on to. One
 * that a start leads to is kept, at its speed.
 *
 * Invariants   at every speed of the map there is at least one attractor, the fixed start's; orbits in the list of a
 *              speed are pairwise different (up to a shift by whole mesh periods), stable, and of their smallest period.
 * Failures     memory only. A Newton iteration that does not converge ends a sweep, which the march then goes on with.
 */
#include "core/attractors.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "core/random.h"

const struct qg_exploration qg_worst_exploration = {.speeds = 64, .starts = QG_LANES, .one_sided = true};

static const double STEP_MAX = 0.0025; /* of the frequency ratio, between speeds of a sweep */
static const double JUMP = 0.1;        /* half-backlashes: a corrected orbit farther from its prediction is another */
static const double SAME = 1e-5;       /* half-backlashes: orbits nearer than that are one */
static const double SAME_CHAOS = 0.05; /* relative: responses without a period whose RMS differ less are one */
static const double START_DISTANCE = 3.0; /* half-backlashes, half the side of the box of random starts */

/* A steady response that was met at a speed of the fine map. */
struct seed {
    size_t speed;
    bool one_sided; /* worth something only clear of the back flank */
    struct qg_response response;
};

struct finder {
    const struct qg_oscillator *oscillator;
    struct qg_attractors *out;
    enum qg_status status;
    size_t pending, room; /* seeds met by sweeps, not yet planted */
    struct seed *seed;
};

struct qg_state qg_random_start(unsigned stream, size_t speed, size_t index) {
    uint64_t number = (uint64_t)speed << 32 | index;
    double x = qg_random_uniform(0, (enum qg_stream)stream, number, 0);
    double v = qg_random_uniform(0, (enum qg_stream)stream, number, 1);
    return (struct qg_state){(2.0 * x - 1.0) * START_DISTANCE, (2.0 * v - 1.0) * START_DISTANCE};
}

/* ---- the list --------------------------------------------------------------------------------------------------- */

static bool near(struct qg_state a, double x, double v) {
    return fabs(a.x - x) <= SAME && fabs(a.v - v) <= SAME;
}

static bool is_response(const struct qg_orbit *known, const struct qg_response *response) {
    if (response->period <= 0)
        return known->period == response->period && fabs(known->rms - response->rms) <= SAME_CHAOS * known->rms;
    for (int n = 0; n < known->period; n++)
        if (known->period == response->period && near(known->state[n], response->x, response->v))
            return true;
    return false;
}

static bool is_known(const struct qg_attractors *a, size_t speed, const struct qg_response *response) {
    for (size_t i = a->first[speed]; i != QG_NO_ATTRACTOR; i = a->item[i].next)
        if (is_response(&a->item[i].orbit, response))
            return true;
    return false;
}

static struct qg_response response_of(const struct qg_orbit *orbit) {
    return (struct qg_response){.rms = orbit->rms,
                                .mean = orbit->mean,
                                .period = orbit->period,
                                .beyond = orbit->beyond,
                                .x = orbit->state[0].x,
                                .v = orbit->state[0].v};
}

static void add(struct finder *f, size_t speed, const struct qg_orbit *orbit) {
    struct qg_attractors *a = f->out;
    if (a->count == a->room) {
        size_t room = a->room ? 2 * a->room : 1024;
        struct qg_attractor *grown = realloc(a->item, room * sizeof *grown);
        if (!grown) {
            f->status = QG_OUT_OF_MEMORY;
            return;
        }
        a->item = grown;
        a->room = room;
    }
    a->item[a->count] = (struct qg_attractor){*orbit, a->first[speed]};
    a->first[speed] = a->count++;
}

/* ---- sweeps ----------------------------------------------------------------------------------------------------- */

/* A sweep: the last three orbits' states, newest first, and how many speeds to try next. */
struct sweep {
    size_t speed; /* of the newest */
    int direction;
    int period;
    bool one_sided;
    size_t known;            /* of past[] */
    struct qg_state past[3]; /* at speed, speed - direction, speed - 2 direction */
    size_t block;
};

static void move_on(struct sweep *s, const struct qg_orbit *orbit) {
    s->past[2] = s->past[1];
    s->past[1] = s->past[0];
    s->past[0] = orbit->state[0];
    s->known += s->known < 3;
    s->speed += (size_t)s->direction;
}

/* The state `ahead` speeds on: by the parabola, line or point through what is known. */
static struct qg_state predict(const struct sweep *s, double ahead) {
    const struct qg_state *z = s->past;
    double a = ahead, b = 0.0;
    if (s->known < 2)
        return z[0];
    if (s->known > 2)
        b = 0.5 * ahead * (ahead + 1.0);
    struct qg_state out = {z[0].x + a * (z[0].x - z[1].x), z[0].v + a * (z[0].v - z[1].v)};
    out.x += b * (z[0].x - 2.0 * z[1].x + (s->known > 2 ? z[2].x : 0.0));
    out.v += b * (z[0].v - 2.0 * z[1].v + (s->known > 2 ? z[2].v : 0.0));
    return out;
}

/* Speeds left ahead of the sweep. */
static size_t left(const struct sweep *s, const struct qg_speed_map *map) {
    return s->direction > 0 ? map->count - 1 - s->speed : s->speed;
}

static bool wanted(const struct qg_orbit *orbit, bool one_sided) {
    return qg_orbit_is_small(orbit) && !(one_sided && orbit->back_crossings > 0);
}

/* Tries the next `block` speeds. Answers how many of them were added; *met when an orbit known already ended it. */
static size_t try_block(struct finder *f, struct sweep *s, bool *met) {
    struct qg_orbit orbit[QG_LANES];
    struct qg_state guess[QG_LANES];
    bool found[QG_LANES];
    size_t rest = left(s, &f->out->fine), count = s->block < rest ? s->block : rest, n = 0;
    for (size_t i = 0; i < count; i++) {
        guess[i] = orbit[i].state[0] = predict(s, (double)(i + 1));
        orbit[i].frequency_ratio = qg_speed_at(&f->out->fine, s->speed + (i + 1) * (size_t)s->direction);
    }
    qg_orbit_shoot(f->oscillator, s->period, count, orbit, found);
    for (; n < count && f->status == QG_OK && !*met; n++) {
        const struct qg_orbit *o = &orbit[n];
        bool good = found[n] && o->floquet.stable && o->period == s->period && wanted(o, s->one_sided) &&
                    fabs(o->state[0].x - guess[n].x) + fabs(o->state[0].v - guess[n].v) < JUMP;
        if (!good)
            break;
        struct qg_response response = response_of(o);
        *met = is_known(f->out, s->speed + (size_t)s->direction, &response);
        if (*met)
            break;
        move_on(s, o);
        add(f, s->speed, o);
    }
    return n;
}

/* Follows an orbit until it ends. Answers true when it ended before the last speed; *end is then where a machine would
 * go at the next one. */
static bool sweep(struct finder *f, struct sweep *s, struct seed *end) {
    bool met = false;
    while (left(s, &f->out->fine) > 0 && !met && f->status == QG_OK) {
        size_t added = try_block(f, s, &met);
        if (added == 0 && s->block == 1)
            break;
        s->block = added < s->block ? 1 : s->block * 2 < QG_LANES ? s->block * 2 : QG_LANES;
    }
    if (met || left(s, &f->out->fine) == 0 || f->status != QG_OK)
        return false;
    end->speed = s->speed + (size_t)s->direction;
    end->one_sided = s->one_sided;
    double ratio = qg_speed_at(&f->out->fine, end->speed);
    qg_batch_settle(f->oscillator, 1, &ratio, s->past, &end->response);
    return true;
}

/* ---- seeds ------------------------------------------------------------------------------------------------------ */

/* Puts a seed aside until the sweeps at hand are done. */
static void put_aside(struct finder *f, const struct seed *seed) {
    if (f->pending == f->room) {
        size_t room = f->room ? 2 * f->room : 64;
        struct seed *grown = realloc(f->seed, room * sizeof *grown);
        if (!grown) {
            f->status = QG_OUT_OF_MEMORY;
            return;
        }
        f->seed = grown;
        f->room = room;
    }
    f->seed[f->pending++] = *seed;
}

/* A new orbit: into the list, and on to its neighbours in both directions. */
static void spread(struct finder *f, const struct seed *seed, const struct qg_orbit *orbit) {
    add(f, seed->speed, orbit);
    for (int direction = -1; direction <= 1 && f->status == QG_OK; direction += 2) {
        struct sweep s = {.speed = seed->speed,
                          .direction = direction,
                          .period = orbit->period,
                          .one_sided = seed->one_sided,
                          .known = 1,
                          .block = 1};
        struct seed end;
        s.past[0] = orbit->state[0];
        if (sweep(f, &s, &end))
            put_aside(f, &end);
    }
}

/* The stable orbit behind a response that was judged periodic; false when shooting does not find one. */
static bool polish(const struct finder *f, const struct seed *seed, struct qg_orbit *orbit) {
    bool found;
    orbit->frequency_ratio = qg_speed_at(&f->out->fine, seed->speed);
    orbit->state[0] = (struct qg_state){seed->response.x, seed->response.v};
    qg_orbit_shoot(f->oscillator, seed->response.period, 1, orbit, &found);
    return found && orbit->floquet.stable && fabs(orbit->rms - seed->response.rms) < 1e-3 * orbit->rms + SAME;
}

/* What is steady without being periodic has no more than its figures. */
static void add_unperiodic(struct finder *f, const struct seed *seed) {
    struct qg_orbit orbit = {.frequency_ratio = qg_speed_at(&f->out->fine, seed->speed),
                             .period = seed->response.period,
                             .state = {{seed->response.x, seed->response.v}},
                             .rms = seed->response.rms,
                             .mean = seed->response.mean,
                             .beyond = seed->response.beyond};
    add(f, seed->speed, &orbit);
}

/* Takes in one response, if it is new. One that was judged periodic but that shooting does not confirm is kept by its
 * figures, as too slow to tell. */
static void take(struct finder *f, struct seed seed) {
    struct qg_orbit orbit;
    if (is_known(f->out, seed.speed, &seed.response))
        return;
    bool periodic = seed.response.period > 0;
    if (periodic && polish(f, &seed, &orbit)) {
        struct qg_response polished = response_of(&orbit);
        if (is_known(f->out, seed.speed, &polished))
            return;
        if (wanted(&orbit, seed.one_sided))
            spread(f, &seed, &orbit);
        else if (!seed.one_sided)
            add(f, seed.speed, &orbit);
        return;
    }
    if (periodic)
        seed.response.period = QG_PERIOD_LONG;
    if (!seed.one_sided && !is_known(f->out, seed.speed, &seed.response))
        add_unperiodic(f, &seed);
}

/* Takes in a response and all that follows from it. */
static void plant(struct finder *f, const struct seed *seed) {
    take(f, *seed);
    while (f->pending > 0 && f->status == QG_OK)
        take(f, f->seed[--f->pending]);
}

static void plant_fixed(struct finder *f, const struct qg_speed_map *map) {
    struct qg_speed_map fixed = *map;
    fixed.branch = QG_BRANCH_FIXED;
    struct qg_response *response = malloc(map->count * sizeof *response);
    if (!response) {
        f->status = QG_OUT_OF_MEMORY;
        return;
    }
    for (size_t piece = 0; piece < qg_response_pieces(&fixed); piece++)
        qg_response_piece(f->oscillator, &fixed, piece, response);
    for (size_t i = 0; i < map->count; i++)
        plant(f, &(struct seed){i * f->out->stride, false, response[i]});
    free(response);
}

static void plant_random(struct finder *f, size_t speed, const struct qg_exploration *exploration) {
    size_t starts = exploration->starts;
    for (size_t first = 0; first < starts && f->status == QG_OK; first += QG_LANES) {
        size_t count = starts - first < QG_LANES ? starts - first : QG_LANES;
        double ratio[QG_LANES];
        struct qg_state start[QG_LANES];
        struct qg_response response[QG_LANES];
        for (size_t i = 0; i < count; i++) {
            ratio[i] = qg_speed_at(&f->out->fine, speed);
            start[i] = qg_random_start(QG_STREAM_STARTS, speed, first + i);
        }
        qg_batch_settle(f->oscillator, count, ratio, start, response);
        for (size_t i = 0; i < count; i++)
            plant(f, &(struct seed){speed, exploration->one_sided, response[i]});
    }
}

static enum qg_status prepare(struct qg_attractors *out, const struct qg_speed_map *map) {
    double step = map->count > 1 ? (map->max - map->min) / (double)(map->count - 1) : 0.0;
    *out = (struct qg_attractors){.fine = *map, .stride = (size_t)fmax(1.0, ceil(step / STEP_MAX))};
    out->fine.branch = QG_BRANCH_FIXED;
    out->fine.count = (map->count - 1) * out->stride + 1;
    out->first = malloc(out->fine.count * sizeof *out->first);
    for (size_t i = 0; out->first && i < out->fine.count; i++)
        out->first[i] = QG_NO_ATTRACTOR;
    return out->first ? QG_OK : QG_OUT_OF_MEMORY;
}

enum qg_status qg_attractors_find(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                  const struct qg_exploration *exploration, struct qg_attractors *out) {
    struct finder f = {.oscillator = oscillator, .out = out, .status = prepare(out, map)};
    if (f.status == QG_OK)
        plant_fixed(&f, map);
    size_t speeds = exploration->speeds < out->fine.count ? exploration->speeds : out->fine.count;
    for (size_t i = 0; i < speeds && f.status == QG_OK; i++)
        plant_random(&f, speeds > 1 ? i * (out->fine.count - 1) / (speeds - 1) : 0, exploration);
    free(f.seed);
    return f.status;
}

void qg_attractors_finish(struct qg_attractors *attractors) {
    free(attractors->first);
    free(attractors->item);
    *attractors = (struct qg_attractors){0};
}

enum qg_status qg_worst_response(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                 struct qg_response *out) {
    struct qg_attractors found;
    enum qg_status status = qg_attractors_find(oscillator, map, &qg_worst_exploration, &found);
    for (size_t i = 0; i < map->count && status == QG_OK; i++) {
        size_t at = found.first[i * found.stride], worst = at;
        assert(at != QG_NO_ATTRACTOR);
        for (; at != QG_NO_ATTRACTOR; at = found.item[at].next)
            if (found.item[at].orbit.rms > found.item[worst].orbit.rms)
                worst = at;
        out[i] = response_of(&found.item[worst].orbit);
    }
    qg_attractors_finish(&found);
    return status;
}
