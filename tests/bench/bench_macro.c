/* Part of make bench: how many macro-geometries are tested in a second, as JSON lines on stdout.
 *
 * The search of schema/examples/case_S_macro.json, whose ranges are the defaults, on one and on two threads and on every code
 * path; the floor, which is the drawing of tooth numbers that are all rejected; and the worst case, tooth numbers that are
 * fixed, so that every sample needs its numbers of 53 bits and its backlash. Processor time counts all threads and suffers
 * less from a busy machine than the time that passes. Nothing here passes or fails.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/macro_sample.h"
#include "core/pool.h"

enum { RUNS = 3, BLOCKS = 128, BLOCKS_FIXED = 16 };

static double now(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Nanoseconds per sample, passed on the clock and spent by the processor. */
struct cost {
    double wall, cpu;
};

static struct cost read_clocks(void) {
    return (struct cost){now(CLOCK_MONOTONIC), now(CLOCK_PROCESS_CPUTIME_ID)};
}

/* Keeps the least of several runs: what was spent since a reading of the clocks, per sample. */
static void take_least(struct cost *least, const struct cost *since, uint64_t samples) {
    const struct cost end = read_clocks();
    least->wall = fmin(least->wall, 1e9 * (end.wall - since->wall) / (double)samples);
    least->cpu = fmin(least->cpu, 1e9 * (end.cpu - since->cpu) / (double)samples);
}

static struct qg_gear_pair case_s(void) {
    return (struct qg_gear_pair){
        .rack = {3, 20 * (3.14159265358979323846 / 180)},
        .center_distance = 111,
        .gears = {{28, 1.927, 46.55, 39.55, 0.9, 40, 27, 0}, {43, 2.748, 69.55, 63.1, 0.9, 40, 22.5, 0}},
        .material = {206000, 0.3, 7850e-9},
        .damping_ratio = 0.01,
        .nominal_torque = 470e3};
}

/* The defaults of the job document; tooth numbers may be fixed to 40/61. */
static struct qg_macro_search make_search(bool fixed_teeth) {
    const struct qg_gear_pair pair = case_s();
    const struct qg_interval none = {(double)NAN, (double)NAN};
    const struct qg_interval teeth[2] = {{40, 40}, {61, 61}};
    struct qg_macro macro = {.samples = (fixed_teeth ? BLOCKS_FIXED : BLOCKS) * QG_MACRO_BLOCK,
                             .seed = 1,
                             .keep = 10,
                             .ranges = {none, none, {{none, none, none, none, -1}, {none, none, none, none, -1}}},
                             .limits = {1, none, 0.4, 0.25, 1, 1}};
    struct qg_pair_geometry geometry;
    struct qg_macro_search search;
    for (int i = 0; fixed_teeth && i < 2; i++)
        macro.ranges.gears[i].teeth = teeth[i];
    if (qg_pair_derive(&pair, &geometry, NULL) != QG_OK)
        exit(1);
    qg_macro_complete(&macro, &pair, geometry.backlash);
    if (qg_macro_search_init(&search, &macro, &pair, &geometry) != QG_OK)
        exit(1);
    return search;
}

struct work {
    const struct qg_macro_search *search;
    enum qg_batch_path path;
    struct qg_macro_tally tally[BLOCKS];
};

static void piece(void *context, size_t item, int worker) {
    (void)worker;
    struct work *work = context;
    const struct qg_macro_block block = {.search = work->search, .number = item};
    qg_macro_block_run(&block, work->path, &work->tally[item]);
}

static struct cost measure(const struct qg_macro_search *search, enum qg_batch_path path, int threads,
                           uint64_t *passed) {
    static struct work work;
    struct cost least = {(double)INFINITY, (double)INFINITY};
    const size_t blocks = qg_macro_blocks(&search->macro);
    struct qg_pool *pool = qg_pool_create(threads);
    if (!pool)
        exit(1);
    const struct qg_executor executor = qg_pool_executor(pool);
    work.search = search;
    work.path = path;
    for (int run = 0; run < RUNS; run++) {
        const struct cost start = read_clocks();
        executor.run(executor.self, blocks, piece, &work);
        take_least(&least, &start, search->macro.samples);
    }
    *passed = 0;
    for (size_t i = 0; i < blocks; i++)
        *passed += work.tally[i].passed;
    qg_pool_destroy(pool);
    return least;
}

static void print_search(const char *what, const struct qg_macro_search *search) {
    uint64_t passed;
    const struct cost one = measure(search, qg_macro_best_path(), 1, &passed);
    const struct cost two = measure(search, qg_macro_best_path(), 2, &passed);
    printf("{\"bench\": \"macro\", \"what\": \"%s\", \"samples\": %llu, \"passed\": %llu, \"cpu_nanoseconds\": %.2f, "
           "\"nanoseconds_threads_1\": %.2f, \"nanoseconds_threads_2\": %.2f}\n",
           what, (unsigned long long)search->macro.samples, (unsigned long long)passed, one.cpu, one.wall, two.wall);
    fflush(stdout);
}

/* Tooth numbers of all samples, of which none keeps the ratio. */
static struct cost measure_floor(const struct qg_macro_search *search, enum qg_batch_path path) {
    enum { N = 1 << 14 };
    static struct qg_teeth_hit hits[N];
    struct qg_teeth_draw draw = search->teeth;
    struct cost least = {(double)INFINITY, (double)INFINITY};
    draw.share = -1;
    for (int run = 0; run < RUNS; run++) {
        const struct cost start = read_clocks();
        for (uint64_t first = 0; first < 32 * QG_MACRO_BLOCK; first += N)
            qg_teeth_hits(path, &draw, first, N, hits);
        take_least(&least, &start, 32 * QG_MACRO_BLOCK);
    }
    return least;
}

int main(void) {
    static const char *const names[QG_PATH_COUNT] = {"baseline", "avx2", "avx512"};
    const struct qg_macro_search usual = make_search(false), fixed = make_search(true);
    print_search("ranges by default", &usual);
    print_search("tooth numbers fixed", &fixed);
    for (enum qg_batch_path path = 0; path < QG_PATH_COUNT; path++) {
        uint64_t passed;
        if (!qg_batch_path_available(path))
            continue;
        const struct cost search = measure(&usual, path, 1, &passed), least = measure_floor(&usual, path);
        printf("{\"bench\": \"macro_path\", \"path\": \"%s\", \"cpu_nanoseconds\": %.2f, "
               "\"floor_cpu_nanoseconds\": %.2f}\n",
               names[path], search.cpu, least.cpu);
        fflush(stdout);
    }
    return 0;
}
