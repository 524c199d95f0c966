/* Memory: the sizes it is told from are those of the meshes and contact points that are made; no run takes more than was
 * told, and few take much less; advice leads below a limit.
 *
 * A run's memory is measured on a process of its own: its largest resident set, less that of one that runs nothing.
 */
#include "tests/core/cases.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/mesh.h"
#include "core/pool.h"
#include "core/statics.h"

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
enum { MEASURABLE = 0 }; /* sanitizers keep books on memory in memory */
#else
enum { MEASURABLE = 1 };
#endif

static struct qg_study example(enum qg_study_kind kind) {
    struct qg_study study = small_study();
    study.kind = kind;
    study.analysis.speeds.count = 100;
    study.optimizer.simplex_iterations = 2;
    return study;
}

/* ---- sizes ------------------------------------------------------------------------------------------------------- */

static void a_sector_has_the_size_that_is_told(void **state) {
    (void)state;
    const struct qg_gear_pair pairs[] = {CASE_S, CASE_H, CASE_B};
    for (size_t i = 0; i < 6; i++) {
        const struct qg_gear_pair *pair = &pairs[i / 2];
        const int gear = (int)(i % 2), refinement = 1 + (int)(i % 2);
        struct qg_pair_geometry geometry;
        struct qg_sector_mesh mesh;
        assert_int_equal(qg_pair_derive(pair, &geometry, NULL), QG_OK);
        assert_int_equal(
            qg_sector_mesh_init(&mesh, &pair->rack, &pair->gears[gear], &geometry.gears[gear], refinement, NULL),
            QG_OK);
        const int flank = ((int)mesh.flank_count - 1) / 2 / refinement;
        const struct qg_sector_size size = qg_sector_size(flank, refinement, true);
        assert_true(size.nodes == (double)mesh.node_count && size.elements == (double)mesh.element_count);
        assert_true(size.flank == 2 * (double)mesh.flank_count);
        assert_true(size.roots == 2 * ((double)mesh.root_count - 1));
        /* of the sides all but the radius of their foot at the bore, of the bore what turns between them */
        assert_true(size.boundary == 2 * (2 * (double)mesh.side_count - 1) + (double)mesh.bore_count - 2);
        qg_sector_mesh_finish(&mesh);
    }
}

/* Points are counted for a larger approach than comes true, so there are never fewer. */
static void points_are_counted_as_they_are_laid(void **state) {
    (void)state;
    const struct qg_means means = {.executor = qg_serial_executor};
    const struct qg_gear_pair pairs[] = {CASE_S, CASE_H, CASE_B};
    for (size_t i = 0; i < 3; i++) {
        struct qg_study study = example(QG_STUDY_EVALUATE);
        struct qg_model *model;
        study.pair = pairs[i];
        assert_int_equal(qg_model_create(&study.pair, &study.analysis, &means, NULL, &model), QG_OK);
        const struct qg_statics *statics = qg_model_statics(model);
        for (size_t k = 0; k < statics->positions; k++) {
            int teeth;
            double counted = (double)qg_statics_count_points(
                &study.pair, qg_model_geometry(model), statics->largest_gap, qg_statics_position(statics, k), &teeth);
            assert_true(counted >= (double)statics->site[k].n && counted <= 1.05 * (double)statics->site[k].n + 10);
        }
        qg_model_destroy(model);
    }
}

/* ---- runs -------------------------------------------------------------------------------------------------------- */

/* Runs the study, or NULL nothing, in a process of its own; bytes of its largest resident set. */
static double resident(const struct qg_study *study, int threads) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct qg_study_result result = {0};
        qg_numerics_init(1);
        struct qg_pool *pool = qg_pool_create(threads);
        const struct qg_means means = {.executor = qg_pool_executor(pool)};
        enum qg_status status = study ? qg_study_run(study, &means, NULL, &result) : QG_OK;
        qg_study_result_finish(&result);
        _exit(status == QG_OK ? 0 : 1);
    }
    struct rusage usage;
    int status;
    assert_true(wait4(child, &status, 0, &usage) == child);
    assert_int_equal(status, 0);
    return 1024.0 * (double)usage.ru_maxrss;
}

/* No less than a run takes; more by half at most for studies on one thread whose pairs are known. On two threads the gears'
 * compliances may or may not be at their largest at the same time, so that a run takes more or less. */
static void holds(const char *name, const struct qg_study *study, int threads, double most) {
    const double told = qg_study_memory(study, threads), taken = resident(study, threads) - resident(NULL, threads);
    print_message("%s, %d threads: told %.0f MB, taken %.0f MB\n", name, threads, told / 1e6, taken / 1e6);
    assert_true(taken <= told);
    assert_true(told <= most * taken);
}

static void runs_take_no_more_than_is_told(void **state) {
    (void)state;
    if (!MEASURABLE)
        return;
    struct qg_study s = example(QG_STUDY_EVALUATE);
    const struct qg_gear_pair h = CASE_H, b = CASE_B;
    holds("S", &s, 1, 1.5);
    holds("S", &s, 2, 2);
    s.analysis.bore = QG_BORE_CLAMPED;
    s.analysis.mesh_refinement = 2;
    holds("S, clamped, refinement 2", &s, 1, 1.5);
    s = example(QG_STUDY_EVALUATE);
    s.pair = h;
    s.analysis.mesh_positions = 150;
    holds("H, 150 positions", &s, 2, 2);
    s = example(QG_STUDY_EVALUATE);
    s.pair = b;
    s.relief = (struct qg_relief){0};
    s.analysis.mesh_stiffness = QG_STIFFNESS_LOAD_DEPENDENT;
    s.analysis.branches = QG_BRANCHES_ALL;
    holds("B, by load, all branches", &s, 1, 1.5);
}

static void searches_take_no_more_than_is_told(void **state) {
    (void)state;
    if (!MEASURABLE)
        return;
    struct qg_study s = example(QG_STUDY_OPTIMIZE);
    s.optimizer.verification_factor = 16;
    holds("S, verified at 224 positions", &s, 2, 2);
    s.optimizer.verification_factor = 0;
    s.analysis.speeds.count = 20000;
    s.optimizer.random_samples = 16;
    s.optimizer.simplex_iterations = 0;
    s.reliability.samples = 0;
    holds("S, 20000 speeds", &s, 2, 2);
    s = example(QG_STUDY_MACRO);
    s.objective = QG_OBJECTIVE_F_PPS;
    s.relief = (struct qg_relief){0};
    s.macro = (struct qg_macro){.samples = 2000000, .seed = 1, .keep = 2};
    struct qg_pair_geometry geometry;
    assert_int_equal(qg_pair_derive(&s.pair, &geometry, NULL), QG_OK);
    s.macro.ranges.module.low = s.macro.ranges.pressure_angle_deg.low = s.macro.limits.backlash.low = (double)NAN;
    for (int g = 0; g < 2; g++) {
        s.macro.ranges.gears[g].teeth.low = s.macro.ranges.gears[g].profile_shift.low = (double)NAN;
        s.macro.ranges.gears[g].outside_radius.low = s.macro.ranges.gears[g].root_radius.low = (double)NAN;
        s.macro.ranges.gears[g].hob_tip_radius = -1;
    }
    s.macro.limits.ratio_percent = 1;
    s.macro.limits.tip_thickness = 0.4;
    s.macro.limits.tip_clearance = 0.25;
    s.macro.limits.contact_stress_factor = s.macro.limits.root_stress_factor = 2;
    qg_macro_complete(&s.macro, &s.pair, geometry.backlash);
    holds("macro-geometries", &s, 2, 6);
}

/* What could not be known before is refused where it would be allocated. */
static void operators_keep_their_limit(void **state) {
    (void)state;
    const struct qg_study study = example(QG_STUDY_EVALUATE);
    struct qg_means means = {.executor = qg_serial_executor, .operator_bytes_max = 1e6};
    struct qg_model *model;
    assert_int_equal(qg_model_create(&study.pair, &study.analysis, &means, NULL, &model), QG_OUT_OF_MEMORY);
    means.operator_bytes_max = 100e6;
    assert_int_equal(qg_model_create(&study.pair, &study.analysis, &means, NULL, &model), QG_OK);
    qg_model_destroy(model);
}

/* ---- the formula by itself --------------------------------------------------------------------------------------- */

static void more_takes_more(void **state) {
    (void)state;
    const struct qg_study plain = example(QG_STUDY_OPTIMIZE);
    const double told = qg_study_memory(&plain, 2);
    struct qg_study s = plain;
    s.analysis.mesh_positions = 512;
    assert_true(qg_study_memory(&s, 2) > 3 * told);
    s = plain;
    s.analysis.mesh_refinement = 4;
    assert_true(qg_study_memory(&s, 2) > 10 * told);
    s = plain;
    s.analysis.speeds.count = QG_SPEEDS_MAX;
    assert_true(qg_study_memory(&s, 2) > told + 100e6);
    s = plain;
    s.optimizer.random_samples = 1000000;
    assert_true(qg_study_memory(&s, 2) > told + 100e6);
    s = plain;
    s.analysis.speeds.count = 50000;
    const double fixed = qg_study_memory(&s, 2);
    s.analysis.speeds.branch = QG_BRANCH_WORST;
    assert_true(qg_study_memory(&s, 2) > fixed);
    assert_true(qg_study_memory(&plain, 1) < told);
}

/* The study with one of the advised values. */
static struct qg_study advised(const struct qg_study *study, const struct qg_note *note) {
    struct qg_study s = *study;
    size_t found, value;
    assert_int_equal(sscanf(note->text, "found %zu; up to %zu would do", &found, &value), 2);
    assert_true(value < found);
    if (strcmp(note->where, "analysis.mesh_positions") == 0)
        s.analysis.mesh_positions = (int)value;
    else if (strcmp(note->where, "analysis.mesh_refinement") == 0)
        s.analysis.mesh_refinement = (int)value;
    else if (strcmp(note->where, "optimizer.verification_factor") == 0)
        s.optimizer.verification_factor = value;
    else
        fail_msg("advice on %s", note->where);
    return s;
}

static void advice_leads_below_the_limit(void **state) {
    (void)state;
    struct qg_study s = example(QG_STUDY_EVALUATE);
    struct qg_notes notes = {0};
    qg_memory_advise(&s, 2, 1e12, &notes);
    assert_int_equal(notes.count, 0);
    s.analysis.mesh_positions = 512;
    qg_memory_advise(&s, 2, 200e6, &notes);
    assert_int_equal(notes.count, 1);
    for (size_t i = 0; i < notes.count; i++) {
        struct qg_study smaller = advised(&s, &notes.item[i]);
        assert_true(qg_study_memory(&smaller, 2) <= 200e6);
        smaller.analysis.mesh_positions++;
        assert_true(qg_study_memory(&smaller, 2) > 200e6);
    }
    s.analysis.mesh_refinement = 4; /* neither of the two alone is enough */
    notes.count = 0;
    qg_memory_advise(&s, 2, 200e6, &notes);
    assert_int_equal(notes.count, 1);
    assert_non_null(strstr(notes.item[0].text, "something else has to be less as well"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(runs_take_no_more_than_is_told), /* first: while this process has no threads */
        cmocka_unit_test(searches_take_no_more_than_is_told),
        cmocka_unit_test(a_sector_has_the_size_that_is_told),
        cmocka_unit_test(points_are_counted_as_they_are_laid),
        cmocka_unit_test(operators_keep_their_limit),
        cmocka_unit_test(more_takes_more),
        cmocka_unit_test(advice_leads_below_the_limit),
    };
    return cmocka_run_group_tests_name("memory", tests, NULL, NULL);
}
