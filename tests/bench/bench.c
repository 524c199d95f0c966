/* make bench: how long each stage takes, as JSON lines on stdout, one figure per line.
 *
 * Case S with the standard relief (and without, where said), medians of several runs. Figures that depend on the machine
 * come with a peer measured in the same run: our integrator against SUNDIALS CVODE at the same accuracy, one thread
 * against two. Nothing here passes or fails.
 *
 * `bench dynamics_against_cvode` prints that line alone: the accuracy that docs/validation.md quotes.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "core/compliance.h"
#include "core/dynamics_batch.h"
#include "core/model.h"
#include "core/pool.h"
#include "core/statics.h"
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

/* Mesh and compliance of one gear; the unknowns of its sector come with it. */
static void compliance_of(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int gear, int refinement,
                          struct qg_compliance *out) {
    const struct qg_compliance_plan plan = {
        {pair->material.youngs_modulus, pair->material.poisson_ratio, pair->gears[gear].face_width, 0},
        gear == QG_PINION ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED,
        pair->gears[gear].teeth,
        2 * QG_PAIR_REACH,
        .stop = {0}};
    struct qg_sector_mesh mesh;
    enum qg_status status =
        qg_sector_mesh_init(&mesh, &pair->rack, &pair->gears[gear], &g->gears[gear], refinement, NULL);
    if (status == QG_OK)
        status = qg_compliance_init(out, &mesh, &plan);
    if (status != QG_OK)
        die("compliance", status);
    qg_sector_mesh_finish(&mesh);
}

static double one_compliance(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int gear,
                             int refinement, size_t *unknowns) {
    struct qg_compliance compliance;
    double start = now();
    compliance_of(pair, g, gear, refinement, &compliance);
    double seconds = now() - start;
    *unknowns = compliance.degrees_of_freedom;
    qg_compliance_finish(&compliance);
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
            seconds[i] = one_compliance(pair, &g, gear, 1, &unknowns);
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

/* ---- code paths ------------------------------------------------------------------------------------------------- */

/* One dynamic candidate by each instruction set, and by plain marching without any short cut. */
static void bench_paths(const struct qg_model *model, struct qg_design_result *r) {
    static const char *const names[QG_PATH_COUNT] = {"baseline", "avx2", "avx512"};
    const struct qg_speed_map *map = &qg_model_analysis(model)->speeds;
    for (int path = 0; path < QG_PATH_COUNT; path++)
        for (int plain = 0; plain < 2; plain++) {
            const struct qg_batch_options options = {(enum qg_batch_path)path, plain};
            double seconds[RUNS];
            if (!qg_batch_path_available(options.path))
                continue;
            for (int run = 0; run < RUNS; run++) {
                double start = now();
                for (size_t k = 0; k < r->case_count; k++) {
                    struct qg_oscillator o = oscillator_of(model, &r->cases[k]);
                    for (size_t piece = 0; piece < qg_response_pieces(map); piece++)
                        qg_response_piece_with(&options, &o, map, piece, r->cases[k].response);
                }
                seconds[run] = now() - start;
            }
            printf("{\"bench\": \"dynamics_path\", \"path\": \"%s\", \"plain_march\": %s, \"milliseconds\": %.2f}\n",
                   names[path], plain ? "true" : "false", 1e3 * median(seconds, RUNS));
        }
}

/* ---- floors ----------------------------------------------------------------------------------------------------- */

/* The speed maps of three oscillators that never lose contact: the tables of the integrator alone, which every speed needs
 * before anything is known about it. */
static void bench_dynamic_floor(const struct qg_model *model, struct qg_design_result *r) {
    const struct qg_speed_map *map = &qg_model_analysis(model)->speeds;
    double seconds[RUNS];
    for (int run = 0; run < RUNS; run++) {
        double start = now();
        for (size_t k = 0; k < r->case_count; k++) {
            struct qg_oscillator o = oscillator_of(model, &r->cases[k]);
            for (int h = 0; h < o.stiffness.harmonics; h++) {
                o.stiffness.cosine[h] *= 1e-3;
                o.stiffness.sine[h] *= 1e-3;
            }
            for (size_t piece = 0; piece < qg_response_pieces(map); piece++)
                qg_response_piece(&o, map, piece, r->cases[k].response);
        }
        seconds[run] = now() - start;
    }
    printf("{\"bench\": \"dynamic_floor\", \"what\": \"no speed loses contact\", \"milliseconds\": %.3f}\n",
           1e3 * median(seconds, RUNS));
}

/* The contact problems of one candidate without relief: from scratch, and with the touching points known, which is one
 * factorization each and cannot be avoided. */
static void bench_static_floor(const struct qg_gear_pair *pair) {
    struct qg_pair_geometry g;
    struct qg_compliance compliance[2];
    struct qg_statics statics;
    struct qg_statics_workspace w;
    const double force =
        qg_pair_derive(pair, &g, NULL) == QG_OK ? pair->nominal_torque / g.gears[QG_PINION].base_radius : 0;
    for (int gear = 0; gear < 2; gear++)
        compliance_of(pair, &g, gear, 1, &compliance[gear]);
    const struct qg_means means = {.executor = qg_serial_executor};
    if (qg_statics_init(&statics, pair, &g, compliance, 14, force, &means) != QG_OK ||
        qg_statics_workspace_init(&w, &statics) != QG_OK)
        die("statics", QG_OUT_OF_MEMORY);
    double seconds[2] = {0, 0};
    size_t factorizations = 0, touching = 0;
    for (size_t i = 0; i < statics.positions; i++) {
        const struct qg_contact_site *site = &statics.site[i];
        for (size_t k = 0; k < site->n; k++) {
            w.gap[k] = site->point[k].at.gap;
            w.lever[k] = site->point[k].lever;
        }
        for (int torque = 1; torque <= 3; torque++)
            for (int warm = 0; warm < 2; warm++) {
                const struct qg_contact_problem p = {site->n, site->flexibility, w.gap, w.lever, force * torque / 3};
                double start = now();
                if (qg_contact_solve(&w.contact, &p, warm) != QG_OK)
                    die("contact", QG_NO_CONVERGENCE);
                seconds[warm] += now() - start;
                factorizations += warm ? 0 : w.contact.iterations;
                touching += warm ? 0 : w.contact.touching;
            }
    }
    printf(
        "{\"bench\": \"contact_floor\", \"problems\": 42, \"points\": %zu, \"touching_mean\": %.1f, "
        "\"factorizations_mean\": %.1f, \"from_scratch_milliseconds\": %.3f, \"touching_known_milliseconds\": %.3f}\n",
        statics.most_points, (double)touching / 42, (double)factorizations / 42, 1e3 * seconds[0], 1e3 * seconds[1]);
    qg_statics_workspace_finish(&w);
    qg_statics_finish(&statics);
    qg_compliance_finish(&compliance[0]);
    qg_compliance_finish(&compliance[1]);
}

static void bench_candidates(const struct qg_model *model, bool only_against_cvode) {
    struct qg_evaluator e;
    struct qg_design_result *r = qg_design_result_create(qg_model_analysis(model));
    if (!r || qg_evaluator_init(&e, model, &qg_serial_executor) != QG_OK)
        die("evaluator", QG_OUT_OF_MEMORY);
    e.clock.now = clock_now;
    for (int relieved = only_against_cvode; relieved < 2; relieved++) {
        double statics;
        r->relief = relieved ? standard_relief() : (struct qg_relief){0};
        double total = one_candidate(&e, r, true, &statics);
        if (only_against_cvode) {
            bench_against_cvode(model, r, total - statics);
            break;
        }
        const char *name = relieved ? "standard" : "none";
        printf("{\"bench\": \"static_candidate\", \"relief\": \"%s\", \"positions\": 14, \"torques\": 3, "
               "\"milliseconds\": %.3f}\n",
               name, 1e3 * statics);
        printf("{\"bench\": \"dynamic_candidate\", \"relief\": \"%s\", \"speeds\": 1000, \"torques\": 3, "
               "\"milliseconds\": %.3f}\n",
               name, 1e3 * (total - statics));
        fflush(stdout);
        if (relieved) {
            bench_against_cvode(model, r, total - statics);
            bench_paths(model, r);
            bench_dynamic_floor(model, r);
        }
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

/* ---- growth ----------------------------------------------------------------------------------------------------- */

/* Milliseconds of one candidate (standard relief, one thread) with a changed analysis: statics and dynamics. */
static void measure_candidate(const struct qg_gear_pair *pair, const struct qg_analysis *analysis, double out[2]) {
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *model;
    struct qg_evaluator e;
    enum qg_status status = qg_model_create(pair, analysis, &means, NULL, &model);
    struct qg_design_result *r = qg_design_result_create(analysis);
    if (status != QG_OK || !r || qg_evaluator_init(&e, model, &means.executor) != QG_OK)
        die("growth", status);
    e.clock.now = clock_now;
    r->relief = standard_relief();
    double total = one_candidate(&e, r, true, &out[0]);
    out[1] = 1e3 * (total - out[0]);
    out[0] *= 1e3;
    qg_evaluator_finish(&e);
    qg_design_result_destroy(r);
    qg_model_destroy(model);
}

static void print_growth(const char *what, int value, const double ms[2]) {
    printf("{\"bench\": \"growth\", \"with\": \"%s\", \"value\": %d, \"static_milliseconds\": %.3f, "
           "\"dynamic_milliseconds\": %.2f}\n",
           what, value, ms[0], ms[1]);
    fflush(stdout);
}

static void bench_growth(const struct qg_gear_pair *pair) {
    double ms[2];
    for (int speeds = 250; speeds <= 4000; speeds *= 4) {
        struct qg_analysis a = paper_analysis();
        a.speeds.count = (size_t)speeds;
        measure_candidate(pair, &a, ms);
        print_growth("speeds", speeds, ms);
    }
    for (int positions = 14; positions <= 56; positions *= 2) {
        struct qg_analysis a = paper_analysis();
        a.mesh_positions = positions;
        measure_candidate(pair, &a, ms);
        print_growth("mesh positions", positions, ms);
    }
    for (int harmonics = 3; harmonics <= 24; harmonics *= 2) {
        struct qg_analysis a = paper_analysis();
        a.mesh_positions = 56;
        a.harmonics = harmonics;
        measure_candidate(pair, &a, ms);
        print_growth("harmonics at 56 positions", harmonics, ms);
    }
    for (int refinement = 1; refinement <= 3; refinement++) {
        struct qg_analysis a = paper_analysis();
        a.mesh_refinement = refinement;
        measure_candidate(pair, &a, ms);
        print_growth("mesh refinement", refinement, ms);
    }
}

/* Seconds of a compliance against the number of teeth (same tooth proportions) and the flank's resolution. */
static void bench_compliance_growth(const struct qg_gear_pair *pair) {
    for (int teeth = 28; teeth <= 448; teeth *= 4) {
        struct qg_gear_pair larger = *pair;
        double more = (teeth - 28) * pair->rack.module / 2;
        struct qg_gear *g = &larger.gears[QG_PINION];
        g->teeth = teeth;
        g->outside_radius += more;
        g->root_radius += more;
        struct qg_pair_geometry geometry = {0};
        size_t unknowns;
        enum qg_status status =
            qg_gear_derive(&larger.rack, g, larger.material.density, "pinion.", &geometry.gears[QG_PINION], NULL);
        if (status != QG_OK)
            die("more teeth", status);
        double seconds = one_compliance(&larger, &geometry, QG_PINION, 1, &unknowns);
        printf("{\"bench\": \"growth\", \"with\": \"teeth\", \"value\": %d, \"compliance_seconds\": %.4f}\n", teeth,
               seconds);
    }
    struct qg_pair_geometry geometry;
    if (qg_pair_derive(pair, &geometry, NULL) != QG_OK)
        die("geometry", QG_IMPOSSIBLE_GEAR);
    for (int refinement = 1; refinement <= 4; refinement++) {
        size_t unknowns;
        double seconds = one_compliance(pair, &geometry, QG_PINION, refinement, &unknowns);
        printf("{\"bench\": \"growth\", \"with\": \"flank resolution\", \"value\": %d, \"compliance_seconds\": %.4f, "
               "\"sector_degrees_of_freedom\": %zu}\n",
               refinement, seconds, unknowns);
        fflush(stdout);
    }
}

/* ---- a whole optimization --------------------------------------------------------------------------------------- */

/* When each phase began. */
struct phases {
    enum qg_phase last;
    double since, spent[QG_PHASE_COUNT];
};

static void on_progress(void *self, const struct qg_progress *progress) {
    struct phases *p = self;
    if (progress->phase != p->last) {
        p->spent[p->last] += now() - p->since;
        p->since = now();
        p->last = progress->phase;
    }
}

/* The case S example: 180 + 80, F_DTE, reliability 100. */
static struct qg_study example_study(const struct qg_gear_pair *pair) {
    struct qg_study study = {.kind = QG_STUDY_OPTIMIZE,
                             .pair = *pair,
                             .analysis = paper_analysis(),
                             .relief = standard_relief(),
                             .objective = QG_OBJECTIVE_F_DTE,
                             .bounds = {.count = 4,
                                        .parameter = {QG_PINION_TIP_START_RADIUS, QG_PINION_TIP_AMPLITUDE,
                                                      QG_GEAR_TIP_START_RADIUS, QG_GEAR_TIP_AMPLITUDE},
                                        .lower = {42, 0.003, 64, 0.003},
                                        .upper = {46.55, 0.035, 69.55, 0.035}},
                             .optimizer = {180, 80, 1},
                             .reliability = {100, 0.2, 0.012, 0.5, 1}};
    return study;
}

static void bench_optimization(const struct qg_gear_pair *pair) {
    const struct qg_study study = example_study(pair);
    double seconds[2], simplex[2];
    for (int threads = 1; threads <= 2; threads++) {
        struct qg_pool *pool = qg_pool_create(threads);
        if (!pool)
            die("threads", QG_OUT_OF_MEMORY);
        const struct qg_means means = {.executor = qg_pool_executor(pool)};
        double total[RUNS], in_simplex[RUNS];
        for (int run = 0; run < RUNS; run++) {
            struct phases phases = {.since = now()};
            const struct qg_observer observer = {.self = &phases, .progress = on_progress};
            struct qg_study_result result;
            double start = now();
            enum qg_status status = qg_study_run(&study, &means, &observer, &result);
            total[run] = now() - start;
            phases.spent[phases.last] += now() - phases.since;
            in_simplex[run] = phases.spent[QG_PHASE_SIMPLEX];
            qg_study_result_finish(&result);
            if (status != QG_OK)
                die("optimization", status);
        }
        seconds[threads - 1] = median(total, RUNS);
        simplex[threads - 1] = median(in_simplex, RUNS);
        qg_pool_destroy(pool);
    }
    printf("{\"bench\": \"optimize_case_S\", \"seconds_threads_1\": %.2f, \"seconds_threads_2\": %.2f, "
           "\"speed_up\": %.2f, \"simplex_seconds_threads_1\": %.2f, \"simplex_seconds_threads_2\": %.2f, "
           "\"simplex_speed_up\": %.2f}\n",
           seconds[0], seconds[1], seconds[0] / seconds[1], simplex[0], simplex[1], simplex[0] / simplex[1]);
}

/* Ten thousand trials about the standard relief on two threads. */
static void bench_reliability(const struct qg_gear_pair *pair) {
    struct qg_study study = example_study(pair);
    study.kind = QG_STUDY_RELIABILITY;
    study.bounds.count = 0;
    study.reliability.samples = 10000;
    struct qg_pool *pool = qg_pool_create(2);
    if (!pool)
        die("threads", QG_OUT_OF_MEMORY);
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    struct qg_study_result result;
    double start = now();
    enum qg_status status = qg_study_run(&study, &means, NULL, &result);
    double seconds = now() - start;
    if (status != QG_OK)
        die("reliability", status);
    printf("{\"bench\": \"reliability\", \"trials\": %zu, \"threads\": 2, \"seconds\": %.1f, \"failures\": %zu}\n",
           result.reliability.samples, seconds, result.reliability.failures);
    fflush(stdout);
    qg_study_result_finish(&result);
    qg_pool_destroy(pool);
}

static void print_memory(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("{\"bench\": \"peak_memory\", \"what\": \"all of the above\", \"mebibytes\": %.1f}\n",
           (double)usage.ru_maxrss / 1024);
}

int main(int argc, char **argv) {
    qg_numerics_init(1);
    struct qg_gear_pair pair = case_s();
    struct qg_analysis analysis = paper_analysis();
    const bool only_against_cvode = argc == 2 && strcmp(argv[1], "dynamics_against_cvode") == 0;
    if (argc > 1 && !only_against_cvode) {
        fprintf(stderr, "usage: %s [dynamics_against_cvode]\n", argv[0]);
        return 2;
    }
    const struct qg_means means = {.executor = qg_serial_executor};
    struct qg_model *model;
    if (!only_against_cvode)
        bench_compliance(&pair);
    double start = now();
    enum qg_status status = qg_model_create(&pair, &analysis, &means, NULL, &model);
    if (status != QG_OK)
        die("model", status);
    if (only_against_cvode) {
        bench_candidates(model, true);
        qg_model_destroy(model);
        return 0;
    }
    printf("{\"bench\": \"model\", \"what\": \"both gears and the contact operators at 14 positions\", \"seconds\": "
           "%.4f}\n",
           now() - start);
    bench_cache(&pair, &analysis);
    bench_candidates(model, false);
    bench_static_floor(&pair);
    bench_throughput(model);
    qg_model_destroy(model);
    bench_optimization(&pair);
    bench_reliability(&pair);
    print_memory();
    bench_compliance_growth(&pair);
    bench_growth(&pair);
    return 0;
}
