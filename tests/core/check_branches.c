/* make check-branches: do the branches found by continuation contain every steady state that marching reaches?
 *
 * Case S, both reliefs, three torques: at 40 speeds 200 random states each (or as many as the
 * first argument says, a multiple of 8) are marched to their steady state, with
 * other random numbers than those the search for branches uses. A periodic one must be a stable orbit of the branches
 * at that speed. One without a period up to QG_PERIOD_MAX is marched on, to see what it is. Prints a markdown table;
 * exit status 1 when something is not contained.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/attractors.h"
#include "core/branches.h"
#include "core/random.h"
#include "tests/core/oscillators.h"

enum { MARCHED_SPEEDS = 40, ORBITS = 200, LONGEST = 128, SETTLING = 20000 };

struct tally {
    size_t starts; /* per speed */
    size_t marched, period[QG_PERIOD_MAX + 1], longer, unsettled, missed, stable_most;
};

/* The period, up to LONGEST mesh periods, of a motion that was marched for SETTLING more; 0 when there is none. */
static int true_period(const struct qg_oscillator *o, double p, const struct qg_response *r) {
    double start[2] = {r->x, r->v}, z[2];
    qg_batch_march(o, p, SETTLING, start, NULL);
    memcpy(z, start, sizeof z);
    for (int n = 1; n <= LONGEST; n++) {
        qg_batch_march(o, p, 1, z, NULL);
        if (hypot(z[0] - start[0], z[1] - start[1]) < 1e-8)
            return n;
    }
    return 0;
}

static bool contains(const struct qg_orbit *orbits, size_t count, const struct qg_response *r) {
    for (size_t i = 0; i < count; i++)
        for (int n = 0; n < orbits[i].period; n++)
            if (orbits[i].floquet.stable && orbits[i].period == r->period &&
                hypot(orbits[i].state[n].x - r->x, orbits[i].state[n].v - r->v) < 1e-5)
                return true;
    return false;
}

static void take(struct tally *t, const struct qg_oscillator *o, double p, const struct qg_response *r) {
    if (r->period > 0)
        t->period[r->period]++;
    else if (true_period(o, p, r) > 0)
        t->longer++;
    else
        t->unsettled++;
    t->marched++;
}

static void check_speed(const struct qg_oscillator *o, const struct qg_branches *b, size_t speed, struct tally *t) {
    static struct qg_orbit orbits[ORBITS];
    double p = 0.2 + 1.2 * ((double)speed + 0.5) / MARCHED_SPEEDS, ratio[QG_LANES];
    size_t count = qg_branches_at(b, o, p, ORBITS, orbits), stable = 0;
    for (size_t i = 0; i < count; i++)
        stable += orbits[i].floquet.stable;
    t->stable_most = stable > t->stable_most ? stable : t->stable_most;
    for (size_t first = 0; first < t->starts; first += QG_LANES) {
        struct qg_state start[QG_LANES];
        struct qg_response out[QG_LANES];
        for (size_t i = 0; i < QG_LANES; i++) {
            ratio[i] = p;
            start[i] = qg_random_start(QG_STREAM_TESTS, speed, first + i);
        }
        qg_batch_settle(o, QG_LANES, ratio, start, out);
        for (size_t i = 0; i < QG_LANES; i++) {
            take(t, o, p, &out[i]);
            if (out[i].period > 0 && !contains(orbits, count, &out[i])) {
                t->missed++;
                printf("not contained: p = %.6f, period %d, rms %.6f, x %.8f, v %.8f\n", p, out[i].period, out[i].rms,
                       out[i].x, out[i].v);
            }
        }
    }
}

static void print_row(const char *relief, int load_case, const struct qg_branches *b, const struct tally *t) {
    printf("| %s | %d/3 | %zu | %zu | %zu |", relief, load_case + 1, b->count, t->stable_most, t->marched);
    for (int n = 1; n <= QG_PERIOD_MAX; n++)
        printf(" %zu |", t->period[n]);
    printf(" %zu | %zu | %zu |\n", t->longer, t->unsettled, t->missed);
}

int main(int count, char **words) {
    static struct qg_branches branches;
    const char *const relief[RELIEFS] = {"none", "standard"};
    const struct qg_speed_map range = {.min = 0.2, .max = 1.4, .count = SPEEDS, .start_static = 1};
    const size_t starts = count > 1 ? strtoul(words[1], NULL, 10) : 200;
    size_t missed = 0;
    printf(
        "| relief | torque | branches | stable, most at one speed | marched | period 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | "
        "9 to %d | none | not contained |\n",
        LONGEST);
    printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 0; n < RELIEFS * CASES; n++) {
        struct qg_oscillator o = case_s(n / CASES, n % CASES);
        struct tally tally = {.starts = starts};
        if (qg_branches_find(&o, &range, NULL, &branches) != QG_OK)
            return 1;
        for (size_t speed = 0; speed < MARCHED_SPEEDS; speed++)
            check_speed(&o, &branches, speed, &tally);
        print_row(relief[n / CASES], n % CASES, &branches, &tally);
        missed += tally.missed;
        qg_branches_finish(&branches);
    }
    return missed > 0;
}
