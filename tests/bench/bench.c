/* make bench: how long each stage takes, as JSON lines on stdout, one figure per line.
 *
 * Case S with the standard relief (and without, where said), medians of several runs. Figures that depend on the machine
 * come with a peer measured in the same run: our integrator against SUNDIALS CVODE at the same accuracy, one thread
 * against two. Nothing here passes or fails.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "core/compliance.h"
#include "core/model.h"
#include "core/pool.h"
#include "core/study.h"

enum { RUNS = 5, SPEEDS_SAMPLED = 20, DESIGNS = 64 };

static const double pi = 3.14159265358979323846;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, size_t n) {
    qsort(values, n, sizeof *values, ascending);
    return values[n / 2];
}

static struct qg_gear_pair case_s(void) {
    return (struct qg_gear_pair){
        .rack = {3, 20 * pi / 180},
        .center_distance = 111,
        .gears = {{28, 1.927, 46.55, 39.55, 0.9, 40, 27, 0}, {43, 2.748, 69.55, 63.1, 0.9, 40, 22.5, 0}},
        .material = {206000, 0.3, 7850e-9},
        .damping_ratio = 0.01,
        .nominal_torque = 470e3};
}

static struct qg_relief standard_relief(void) {
    struct qg_relief relief = {0};
    relief.gears[QG_PINION].tip = (struct qg_ramp){true, 44.54, 0.016};
    relief.gears[QG_GEAR].tip = (struct qg_ramp){true, 67.64, 0.018};
    return relief;
}

static struct qg_analysis paper_analysis(void) {
    return (struct qg_analysis){.case_count = 3,
                                .torque_fraction = {0.33, 0.66, 1},
                                .mesh_positions = 14,
                                .mesh_refinement = 1,
                                .harmonics = 6,
                                .speeds = {.min = 0.2, .max = 1.4, .count = 1000, .start_static = 1}};
}

static void die(const char *what, enum qg_status status) {
    fprintf(stderr, "bench: %s: %s\n", what, qg_status_text(status));
    exit(1);
}

/* ---- finite elements -------------------------------------------------------------------------------------------- */

static double one_compliance(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int gear,
                             size_t *unknowns) {
    const struct qg_plate plate = {pair->material.youngs_modulus, pair->material.poisson_ratio,
                                   pair->gears[gear].face_width, 0};
    double start = now();
    struct qg_sector_mesh mesh;
    struct qg_compliance compliance;
    enum qg_status status = qg_sector_mesh_init(&mesh, &pair->rack, &pair->gears[gear], &g->gears[gear], 1, NULL);
    if (status == QG_OK)
        status = qg_compliance_init(&compliance, &mesh, &plate,
                                    gear == QG_PINION ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED,
                                    pair->gears[gear].teeth, 2 * QG_PAIR_REACH);
    double seconds = now() - start;
    if (status != QG_OK)
        die("compliance", status);
    *unknowns = compliance.degrees_of_freedom;
    qg_compliance_finish(&compliance);
    qg_sector_mesh_finish(&mesh);
    return seconds;
}

static void bench_compliance(const struct qg_gear_pair *pair) {
    struct qg_pair_geometry g;
    enum qg_status status = qg_pair_derive(pair, &g, NULL);
    if (status != QG_OK)
        die("geometry", status);
    for (int gear = 0; gear < 2; gear++) {
        double seconds[RUNS];
        size_t unknowns = 0;
        for (int i = 0; i < RUNS; i++)
            seconds[i] = one_compliance(pair, &g, gear, &unknowns);
        printf("{\"bench\": \"compliance\", \"gear\": \"%s\", \"seconds\": %.4f, \"sector_degrees_of_freedom\": %zu, "
               "\"whole_gear_degrees_of_freedom\": %zu}\n",
               gear == QG_PINION ? "pinion" : "gear", median(seconds, RUNS), unknowns,
               unknowns * (size_t)pair->gears[gear].teeth);
    }
}

/* A model whose gears the cache has. */
static void bench_cache(const struct qg_gear_pair *pair, const struct qg_analysis *analysis) {
    struct qg_means means = {.executor = qg_serial_executor, .cache = qg_cache_create((size_t)256 << 20)};
    double seconds[RUNS + 1];
    for (int i = 0; i <= RUNS; i++) {
        struct qg_model *model;
        double start = now();
        enum qg_status status = qg_model_create(pair, analysis, &means, NULL, &model);
        seconds[i] = now() - start;
        if (status != QG_OK)
            die("model", status);
        qg_model_destroy(model);
    }
    const struct qg_compliance_key key = {.rack = pair->rack};
    double start = now();
    for (int i = 0; i < 1000; i++)
        qg_cache_take(means.cache, &key);
    printf("{\"bench\": \"cache\", \"model_without_seconds\": %.4f, \"model_with_seconds\": %.4f, "
           "\"look_up_milliseconds\": %.6f, \"mebibytes\": %.1f}\n",
           seconds[0], median(seconds + 1, RUNS), now() - start, (double)qg_cache_count(means.cache).bytes / 0x1p20);
    qg_cache_destroy(means.cache);
}

/* ---- one candidate ---------------------------------------------------------------------------------------------- */

/* Median seconds of one candidate's statics, or of its statics and dynamics. */
static double one_candidate(struct qg_evaluator *e, struct qg_design_result *r, bool dynamics, double *statics) {
    enum { REPEATS = 9 };
    double total[REPEATS], static_part[REPEATS];
    for (int i = 0; i < REPEATS; i++) {
        double start = now(), before = e->times.statics;
        enum qg_status status = qg_evaluate(e, dynamics, 1, &r);
        if (status != QG_OK)
            die("candidate", status);
        total[i] = now() - start;
        static_part[i] = e->times.statics - before;
    }
    *statics = median(static_part, REPEATS);
    return median(total, REPEATS);
}

static double clock_now(void *self) {
    (void)self;
    return now();
}

/* The oscillator that the model used for a case (secant stiffness): rebuilt from the result's curves. */
static struct qg_oscillator oscillator_of(const struct qg_model *model, const struct qg_case_result *c) {
    const struct qg_analysis *a = qg_model_analysis(model);
    double half_backlash = qg_model_geometry(model)->backlash / 2, kappa[QG_POSITIONS_MAX] = {0};
    for (int i = 0; i < a->mesh_positions; i++)
        kappa[i] = c->mesh_stiffness[i] / c->mean_mesh_stiffness;
    struct qg_oscillator o = {.damping_ratio = qg_model_pair(model)->damping_ratio,
                              .load = c->normal_force / (c->mean_mesh_stiffness * half_backlash)};
    qg_fourier_from_samples(&o.stiffness, kappa, (size_t)a->mesh_positions, a->harmonics);
    return o;
}

/* CVODE marching at sampled speeds of all cases: seconds, largest relative departure from `reference`, speeds on the same
 * branch. reference NULL: fill `out` only. */
struct march {
    double seconds, error;
    size_t same_branch, total;
};

static struct march march_with_cvode(const struct qg_model *model, const struct qg_design_result *r, double rtol,
                                     const double *reference, double *out) {
    const struct qg_speed_map *map = &qg_model_analysis(model)->speeds;
    struct march m = {0};
    for (size_t k = 0; k < r->case_count; k++) {
        struct qg_oscillator o = oscillator_of(model, &r->cases[k]);
        for (size_t i = 0; i < SPEEDS_SAMPLED; i++) {
            size_t speed = i * (map->count - 1) / (SPEEDS_SAMPLED - 1), at = k * SPEEDS_SAMPLED + i;
            struct qg_response response;
            double start = now();
            enum qg_status status =
                qg_response_reference(&o, qg_speed_at(map, speed), qg_static_displacement(&o), 0, rtol, &response);
            m.seconds += now() - start;
            if (status != QG_OK)
                die("CVODE", status);
            out[at] = response.rms;
            m.total++;
            double departure = reference ? fabs(response.rms / reference[at] - 1) : 0;
            if (departure > 0.02)
                continue; /* another branch */
            m.same_branch++;
            m.error = fmax(m.error, departure);
        }
    }
    return m;
}

/* Our own departure from the reference values at the sampled speeds. */
static struct march our_accuracy(const struct qg_design_result *r, size_t speeds, const double *reference) {
    struct march m = {0};
    for (size_t k = 0; k < r->case_count; k++)
        for (size_t i = 0; i < SPEEDS_SAMPLED; i++) {
            double rms = r->cases[k].response[i * (speeds - 1) / (SPEEDS_SAMPLED - 1)].rms;
            double departure = fabs(rms / reference[k * SPEEDS_SAMPLED + i] - 1);
            m.total++;
            if (departure > 0.02)
                continue;
            m.same_branch++;
            m.error = fmax(m.error, departure);
        }
    return m;
}

static void bench_against_cvode(const struct qg_model *model, const struct qg_design_result *r, double our_seconds) {
    size_t speeds = qg_model_analysis(model)->speeds.count;
    double reference[QG_CASES_MAX * SPEEDS_SAMPLED], values[QG_CASES_MAX * SPEEDS_SAMPLED];
    march_with_cvode(model, r, 1e-10, NULL, reference);
    struct march ours = our_accuracy(r, speeds, reference);
    struct march theirs = {0};
    double rtol = 1e-4;
    do { /* the loosest tolerance with which CVODE is as accurate as 1e-4 */
        rtol /= 10;
        theirs = march_with_cvode(model, r, rtol, reference, values);
    } while (theirs.error > 1e-4 && rtol > 1e-10);
    double per_candidate = theirs.seconds / (double)theirs.total * (double)(speeds * r->case_count);
    printf("{\"bench\": \"dynamics_against_cvode\", \"speeds_compared\": %zu, \"our_largest_rms_error\": %.2g, "
           "\"same_branch\": %zu, \"cvode_rtol\": %g, \"cvode_largest_rms_error\": %.2g, "
           "\"cvode_seconds_per_candidate\": %.2f, \"our_seconds_per_candidate\": %.5f, \"ratio\": %.0f}\n",
           ours.total, ours.error, ours.same_branch, rtol, theirs.error, per_candidate, our_seconds,
           per_candidate / our_seconds);
}

static void bench_candidates(const struct qg_model *model) {
    struct qg_evaluator e;
    struct qg_design_result *r = qg_design_result_create(qg_model_analysis(model));
    if (!r || qg_evaluator_init(&e, model, &qg_serial_executor) != QG_OK)
        die("evaluator", QG_OUT_OF_MEMORY);
    e.clock.now = clock_now;
    for (int relieved = 0; relieved < 2; relieved++) {
        double statics;
        r->relief = relieved ? standard_relief() : (struct qg_relief){0};
        double total = one_candidate(&e, r, true, &statics);
        const char *name = relieved ? "standard" : "none";
        printf("{\"bench\": \"static_candidate\", \"relief\": \"%s\", \"positions\": 14, \"torques\": 3, "
               "\"milliseconds\": %.3f}\n",
               name, 1e3 * statics);
        printf("{\"bench\": \"dynamic_candidate\", \"relief\": \"%s\", \"speeds\": 1000, \"torques\": 3, "
               "\"milliseconds\": %.3f}\n",
               name, 1e3 * (total - statics));
        fflush(stdout);
        if (relieved)
            bench_against_cvode(model, r, total - statics);
    }
    qg_evaluator_finish(&e);
    qg_design_result_destroy(r);
}

/* ---- throughput ------------------------------------------------------------------------------------------------- */

/* Designs of a small spread around the standard relief. */
static struct qg_relief varied(int i) {
    struct qg_relief relief = standard_relief();
    relief.gears[QG_PINION].tip.amplitude += 0.0001 * (i % 32);
    relief.gears[QG_GEAR].tip.radius -= 0.02 * (i % 32);
    return relief;
}

static double evaluations_per_second(const struct qg_model *model, int threads) {
    struct qg_pool *pool = qg_pool_create(threads);
    struct qg_design_result *results[DESIGNS];
    struct qg_executor executor;
    struct qg_evaluator e;
    if (!pool)
        die("threads", QG_OUT_OF_MEMORY);
    executor = qg_pool_executor(pool);
    if (qg_evaluator_init(&e, model, &executor) != QG_OK)
        die("evaluator", QG_OUT_OF_MEMORY);
    for (int i = 0; i < DESIGNS; i++) {
        results[i] = qg_design_result_create(qg_model_analysis(model));
        if (!results[i])
            die("results", QG_OUT_OF_MEMORY);
        results[i]->relief = varied(i);
    }
    double rate[RUNS];
    for (int run = 0; run < RUNS; run++) {
        double start = now();
        enum qg_status status = qg_evaluate(&e, true, DESIGNS, results);
        if (status != QG_OK)
            die("evaluations", status);
        rate[run] = DESIGNS / (now() - start);
    }
    for (int i = 0; i < DESIGNS; i++)
        qg_design_result_destroy(results[i]);
    qg_evaluator_finish(&e);
    qg_pool_destroy(pool);
    return median(rate, RUNS);
}

static void bench_throughput(const struct qg_model *model) {
    double one = evaluations_per_second(model, 1), two = evaluations_per_second(model, 2);
    printf("{\"bench\": \"evaluations_per_second\", \"threads_1\": %.1f, \"threads_2\": %.1f, \"speed_up\": %.2f}\n",
           one, two, two / one);
}

int main(void) {
    qg_numerics_init();
    struct qg_gear_pair pair = case_s();
    struct qg_analysis analysis = paper_analysis();
    bench_compliance(&pair);
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *model;
    double start = now();
    enum qg_status status = qg_model_create(&pair, &analysis, &means, NULL, &model);
    if (status != QG_OK)
        die("model", status);
    printf("{\"bench\": \"model\", \"what\": \"both gears and the contact operators at 14 positions\", \"seconds\": "
           "%.4f}\n",
           now() - start);
    bench_cache(&pair, &analysis);
    bench_candidates(model);
    bench_throughput(model);
    qg_model_destroy(model);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("{\"bench\": \"peak_memory\", \"mebibytes\": %.1f}\n", (double)usage.ru_maxrss / 1024);
    return 0;
}
