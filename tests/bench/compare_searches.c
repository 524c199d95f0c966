/* make compare-searches: search methods against each other on the project's own cases, as the tables of docs/searches.md.
 *
 *   compare_searches EXAMPLES [SEEDS [SPEEDS]]      EXAMPLES: the directory of the example documents
 *
 * Each method gets, seed by seed, as many evaluations as Random-Simplex has made with that seed: the document's random
 * samples and 80 iterations. The front of two objectives is judged by its hypervolume towards the reference design.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/multistart.h"
#include "core/pool.h"
#include "core/study.h"
#include "schema/document.h"
#include "tests/bench/candidates.h"

enum { SEEDS_MAX = 100, SIMPLEX_ITERATIONS = 80 };

/* A case made ready, and the evaluations of one search in it. */
struct field {
    struct qg_job job;
    struct qg_box box;
    struct qg_model *model;
    struct qg_evaluator evaluator;
    struct qg_design_result *slot[QG_SEARCH_BATCH];
    double reference[2]; /* F_DTE, F_PPS */
    enum qg_objective objective;
    bool both;                  /* objectives, as ratios to the reference */
    size_t evaluations, budget; /* budget 0: none */
    double best;
    struct qg_front front;
};

static void die(const char *what) {
    fprintf(stderr, "compare_searches: %s\n", what);
    exit(1);
}

/* Notes one design: the best value so far, and the front. */
static void note(struct field *f, const struct qg_design_result *r, double *value) {
    if (!f->both) {
        *value = f->objective == QG_OBJECTIVE_F_DTE ? r->f_dte : 1e3 * r->f_pps;
        f->best = fmin(f->best, *value);
        return;
    }
    value[0] = r->f_dte / f->reference[0];
    value[1] = r->f_pps / f->reference[1];
    const struct qg_front_member member = {.value = {value[0], value[1]}};
    if (qg_front_add(&f->front, &member, NULL) != QG_OK)
        die("out of memory");
}

/* The objective function of all methods; QG_CANCELLED when the budget is used up. */
static enum qg_status values(void *self, size_t n, const double *x, double *out) {
    struct field *f = self;
    const struct qg_study *study = &f->job.study;
    const size_t left = f->budget - f->evaluations, wanted = f->budget > 0 && n > left ? left : n;
    for (size_t i = 0; i < wanted; i++) {
        f->slot[i]->relief = study->relief;
        for (size_t k = 0; k < study->bounds.count; k++) {
            qg_relief_ramp_of(&f->slot[i]->relief, study->bounds.parameter[k])->present = true;
            *qg_relief_parameter(&f->slot[i]->relief, study->bounds.parameter[k]) = x[i * study->bounds.count + k];
        }
    }
    enum qg_status status = qg_evaluate(&f->evaluator, f->both || f->objective == QG_OBJECTIVE_F_DTE, wanted, f->slot);
    if (status != QG_OK)
        die(qg_status_text(status));
    for (size_t i = 0; i < wanted; i++)
        note(f, f->slot[i], out + i * (f->both ? 2 : 1));
    f->evaluations += wanted;
    return wanted < n ? QG_CANCELLED : QG_OK;
}

/* ---- the cases --------------------------------------------------------------------------------------------------- */

static void read_case(struct field *f, const char *directory, const char *name, size_t speeds) {
    static char text[QG_DOCUMENT_BYTES_MAX];
    static struct qg_faults faults;
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.json", directory, name);
    FILE *file = fopen(path, "r");
    if (!file)
        die(path);
    const size_t length = fread(text, 1, sizeof text, file);
    fclose(file);
    if (qg_document_read(text, length, &f->job, &faults, NULL) != QG_DOCUMENT_OK)
        die(path);
    f->job.study.analysis.speeds.count = speeds;
    f->box.dimensions = f->job.study.bounds.count;
    memcpy(f->box.lower, f->job.study.bounds.lower, sizeof f->job.study.bounds.lower);
    memcpy(f->box.upper, f->job.study.bounds.upper, sizeof f->job.study.bounds.upper);
}

static void open_case(struct field *f, const struct qg_means *means) {
    const struct qg_study *study = &f->job.study;
    bool ok = qg_model_create(&study->pair, &study->analysis, means, NULL, &f->model) == QG_OK &&
              qg_evaluator_init(&f->evaluator, f->model, &means->executor) == QG_OK;
    for (size_t i = 0; i < QG_SEARCH_BATCH && ok; i++)
        ok = (f->slot[i] = qg_design_result_create(&study->analysis));
    if (!ok)
        die("out of memory");
    f->slot[0]->relief = study->relief;
    if (qg_evaluate(&f->evaluator, true, 1, f->slot) != QG_OK)
        die("the reference cannot be judged");
    f->reference[0] = f->slot[0]->f_dte;
    f->reference[1] = f->slot[0]->f_pps;
}

static void close_case(struct field *f) {
    for (size_t i = 0; i < QG_SEARCH_BATCH; i++)
        qg_design_result_destroy(f->slot[i]);
    qg_evaluator_finish(&f->evaluator);
    qg_model_destroy(f->model);
    qg_front_finish(&f->front);
}

/* ---- the methods ------------------------------------------------------------------------------------------------- */

typedef void method(struct field *f, const struct qg_objective_function *objective, uint64_t seed);

static void random_simplex(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    struct qg_vertex best = {.f = INFINITY};
    struct qg_simplex simplex;
    enum qg_status status =
        qg_random_samples(&f->box, seed, 0, f->job.study.optimizer.random_samples, objective, &best);
    if (status == QG_OK)
        status = qg_simplex_init(&simplex, &f->box, objective, &best);
    for (int i = 0; i < SIMPLEX_ITERATIONS && status == QG_OK; i++)
        status = qg_simplex_iterate(&simplex);
}

static void multistart(struct field *f, const struct qg_objective_function *objective, uint64_t seed, size_t starts) {
    const struct qg_multistart plan = {f->budget, starts, f->both ? 2 : 1, seed};
    qg_multistart_search(&plan, &f->box, objective);
}

static void one_start(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    multistart(f, objective, seed, 1);
}

static void four_starts(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    multistart(f, objective, seed, 4);
}

static void eight_starts(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    multistart(f, objective, seed, 8);
}

static void evolution_strategy(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    cma_es(&f->box, objective, seed, f->budget / 5);
}

static void differential(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    differential_evolution(&f->box, objective, seed);
}

static void genetic(struct field *f, const struct qg_objective_function *objective, uint64_t seed) {
    nsga_ii(&f->box, objective, seed);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *sorted, size_t n) {
    return (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
}

/* Runs a method with every seed; figures get the best value, or the hypervolume. */
static void run_seeds(struct field *f, method *search, size_t seeds, size_t *budget, double *figures) {
    static const double corner[] = {1, 1, 1};
    for (size_t i = 0; i < seeds; i++) {
        const struct qg_objective_function objective = {f, values};
        qg_front_finish(&f->front);
        f->front.objectives = 2;
        f->evaluations = 0;
        f->best = INFINITY;
        f->budget = budget[i];
        search(f, &objective, i + 1);
        budget[i] = f->evaluations;
        figures[i] = f->both ? qg_front_hypervolume(&f->front, corner) : f->best;
    }
}

struct row {
    const char *name;
    method *search;
};

/* The budgets come from the first row of a case, which has none itself. */
static void print_rows(struct field *f, const char *title, const struct row *rows, size_t n, size_t seeds,
                       size_t *budget) {
    for (size_t i = 0; i < n; i++) {
        double figures[SEEDS_MAX], sum = 0;
        run_seeds(f, rows[i].search, seeds, budget, figures);
        qsort(figures, seeds, sizeof *figures, ascending);
        for (size_t k = 0; k < seeds; k++)
            sum += (double)budget[k];
        const double best = figures[f->both ? seeds - 1 : 0], worst = figures[f->both ? 0 : seeds - 1];
        printf("| %s | %s | %.4g | %.4g | %.4g | %.0f |\n", title, rows[i].name, best, median(figures, seeds), worst,
               sum / (double)seeds);
        fflush(stdout);
    }
}

static void compare_objective(struct field *f, const char *name, enum qg_objective objective, size_t seeds,
                              size_t *budget) {
    static const struct row rows[] = {{"random_simplex", random_simplex},
                                      {"multistart_simplex, 1 start", one_start},
                                      {"multistart_simplex, 4 starts", four_starts},
                                      {"CMA-ES", evolution_strategy},
                                      {"differential evolution", differential}};
    char title[100];
    f->both = false;
    f->objective = objective;
    memset(budget, 0, SEEDS_MAX * sizeof *budget);
    snprintf(title, sizeof title, "%s, `%s`", name, objective == QG_OBJECTIVE_F_DTE ? "f_dte" : "f_pps");
    print_rows(f, title, rows, sizeof rows / sizeof *rows, seeds, budget);
}

static void compare_fronts(struct field *f, const char *name, size_t seeds, size_t *budget) {
    static const struct row rows[] = {{"NSGA-II", genetic},
                                      {"multistart_simplex, 4 starts", four_starts},
                                      {"multistart_simplex, 8 starts", eight_starts}};
    f->both = true;
    print_rows(f, name, rows, sizeof rows / sizeof *rows, seeds, budget);
}

int main(int argc, char **argv) {
    static const char *const cases[][2] = {
        {"case_S_optimize", "S, four"}, {"case_H_optimize", "H, four"}, {"case_H_optimize_8", "H, eight"}};
    enum { CASES = sizeof cases / sizeof *cases };
    static struct field field[CASES];
    static size_t budget[CASES][SEEDS_MAX];
    const size_t seeds = argc > 2 ? (size_t)atoi(argv[2]) : 10, speeds = argc > 3 ? (size_t)atoi(argv[3]) : 100;
    if (argc < 2 || seeds < 1 || seeds > SEEDS_MAX || speeds < 1)
        die("usage: compare_searches EXAMPLES [SEEDS [SPEEDS]]");
    qg_numerics_init(1);
    struct qg_pool *pool = qg_pool_create(2);
    if (!pool)
        die("cannot start the threads");
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    printf("| case, objective | method | best | median | worst | evaluations |\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < CASES; i++) {
        read_case(&field[i], argv[1], cases[i][0], speeds);
        open_case(&field[i], &means);
        compare_objective(&field[i], cases[i][1], QG_OBJECTIVE_F_PPS, seeds, budget[i]);
        compare_objective(&field[i], cases[i][1], QG_OBJECTIVE_F_DTE, seeds, budget[i]);
    }
    printf("\n| case | method | best hypervolume | median | worst | evaluations |\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < CASES; i++) {
        compare_fronts(&field[i], cases[i][1], seeds, budget[i]);
        close_case(&field[i]);
    }
    qg_pool_destroy(pool);
    return 0;
}
