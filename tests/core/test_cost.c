/* The cost of studies: what makes one dearer, and that it is counted once. The times of core/cost.c are checked against runs by
 * tests/service/check.bats.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/cost.h"

/* Two load cases, 14 positions, 100 speeds. */
static struct qg_study example(enum qg_study_kind kind) {
    struct qg_study study = {
        .kind = kind,
        .analysis = {.case_count = 2, .mesh_positions = 14, .mesh_refinement = 1, .speeds = {.count = 100}},
        .optimizer = {.random_samples = 50, .simplex_iterations = 20},
        .bounds = {.count = 4},
        .grid = {.count = 2, .axis = {{.count = 5}, {.count = 7}}},
        .reliability = {.samples = 30, .percentile_trials = 10},
        .macro = {.samples = 1000000000, .keep = 8},
    };
    return study;
}

static double seconds(const struct qg_study *study) {
    return qg_study_cost(study).processor_seconds;
}

static void counts_evaluations(void **state) {
    (void)state;
    static const double expected[QG_STUDY_KIND_COUNT] = {1, 1 + 50 + 4 + 40 + 30, 1 + 30, 1 + 35, 1 + 16};
    for (int kind = 0; kind < QG_STUDY_KIND_COUNT; kind++) {
        struct qg_study study = example((enum qg_study_kind)kind);
        assert_true(qg_study_cost(&study).evaluations == expected[kind]);
        assert_true(seconds(&study) > 0 && isfinite(seconds(&study)));
    }
    struct qg_study study = example(QG_STUDY_OPTIMIZE);
    study.optimizer.method = QG_SEARCH_MULTISTART_SIMPLEX;
    study.optimizer.evaluations = 400;
    study.reliability.samples = 0;
    assert_true(qg_study_cost(&study).evaluations == 401);
}

/* What is not asked for costs nothing; what is, does. */
static void costs_follow_what_is_asked(void **state) {
    (void)state;
    struct qg_study plain = example(QG_STUDY_OPTIMIZE), statics = plain, robust = plain, worst = plain, loads = plain,
                    fine = plain, all = plain;
    statics.objective = QG_OBJECTIVE_F_PPS;
    robust.objective = QG_OBJECTIVE_F_DTE_PERCENTILE;
    worst.analysis.speeds.branch = QG_BRANCH_WORST;
    loads.analysis.mesh_stiffness = QG_STIFFNESS_LOAD_DEPENDENT;
    fine.analysis.mesh_refinement = 4;
    all.analysis.branches = QG_BRANCHES_ALL;
    assert_true(seconds(&statics) < seconds(&plain));
    assert_true(seconds(&robust) > 5 * seconds(&plain));
    assert_true(seconds(&worst) > seconds(&plain));
    assert_true(seconds(&loads) > seconds(&worst));
    assert_true(seconds(&fine) > 10 * seconds(&plain));
    assert_true(seconds(&all) > seconds(&plain));
    robust.objective = QG_OBJECTIVE_F_DTE;
    assert_true(seconds(&robust) == seconds(&plain));
}

/* The largest studies that a document can ask for still have a figure. */
static void the_largest_is_finite(void **state) {
    (void)state;
    struct qg_study study = example(QG_STUDY_OPTIMIZE);
    study.analysis.case_count = QG_CASES_MAX;
    study.analysis.mesh_positions = QG_POSITIONS_MAX;
    study.analysis.mesh_refinement = QG_REFINEMENT_MAX;
    study.analysis.speeds.count = QG_SPEEDS_MAX;
    study.objective = QG_OBJECTIVE_F_DTE_PERCENTILE;
    study.optimizer.random_samples = study.optimizer.simplex_iterations = 1000000;
    study.reliability.percentile_trials = QG_PERCENTILE_TRIALS_MAX;
    assert_true(seconds(&study) > 1e9 && isfinite(seconds(&study)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_evaluations),
        cmocka_unit_test(costs_follow_what_is_asked),
        cmocka_unit_test(the_largest_is_finite),
    };
    return cmocka_run_group_tests_name("cost", tests, NULL, NULL);
}
