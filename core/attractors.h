/* The steady states of one oscillator, speed by speed: every stable periodic orbit found, and what is steady without
 * being periodic. From them comes the response QG_BRANCH_WORST. Inside of the dynamics, except qg_worst_response.
 */
#ifndef QG_CORE_ATTRACTORS_H
#define QG_CORE_ATTRACTORS_H

#include "core/dynamics.h"
#include "core/orbit.h"

/* How hard to look beyond what slow changes of speed lead to: `starts` random states (counter-based, the same in every
 * run) are marched to their steady state at each of `speeds` equidistant speeds of the map. one_sided: of what they
 * find only periodic orbits that stay clear of the back flank are taken. */
struct qg_exploration {
    size_t speeds, starts;
    bool one_sided;
};

/* What QG_BRANCH_WORST uses. */
extern const struct qg_exploration qg_worst_exploration;

/* A random state number `index` out of the box of starts: displacement and velocity within +-3 half-backlashes (times
 * omega_n) of rest in the middle of the dead zone. Stream is enum qg_stream's (random.h). */
struct qg_state qg_random_start(unsigned stream, size_t speed, size_t index);

/* An orbit in the list of its speed. Of a response that is not periodic only period (one of QG_PERIOD_*), rms, mean and
 * state[0] hold. */
struct qg_attractor {
    struct qg_orbit orbit;
    size_t next; /* of the same speed, or QG_NO_ATTRACTOR */
};
#define QG_NO_ATTRACTOR ((size_t)-1)

/* The attractors found at the speeds of `fine`, the map with its steps divided into `stride` so that orbits can be
 * followed from one speed to the next: speed i of the map is speed i * stride of `fine`. */
struct qg_attractors {
    struct qg_speed_map fine;
    size_t stride;
    size_t *first; /* per speed of `fine`: index of the first attractor, or QG_NO_ATTRACTOR */
    size_t count, room;
    struct qg_attractor *item;
};

/* Finds attractors: the fixed-start map at every speed, random starts, and from each orbit so found the sweep up and
 * down through the speeds as far as the orbit is stable; where it ends, the march on from there, as in a run-up or
 * run-down. out is initialised by the call and must be given to qg_attractors_finish whatever the status: QG_OK or
 * QG_OUT_OF_MEMORY. Any thread; a pure function of its arguments. */
enum qg_status qg_attractors_find(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                  const struct qg_exploration *exploration, struct qg_attractors *out);
void qg_attractors_finish(struct qg_attractors *attractors);

/* QG_BRANCH_WORST: at every speed of the map the largest RMS of all stable branches found, where found means
 *   - reached from the map's fixed start, at any speed, by slow changes of speed up and down (this holds what fixed,
 *     run_up and run_down show); or
 *   - a periodic orbit that stays clear of the back flank, met from one of the random starts of qg_worst_exploration or
 *     swept to from there.
 * Orbits that hammer on both flanks and to which no change of speed leads are left out: they need a blow to begin with,
 * and some of them grow beyond all bounds (docs/branches.md); continuation (branches.h) shows them. out has map->count
 * entries. QG_OK or QG_OUT_OF_MEMORY; out is of no use then. */
enum qg_status qg_worst_response(const struct qg_oscillator *oscillator, const struct qg_speed_map *map,
                                 struct qg_response *out);

#endif
