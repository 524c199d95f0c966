/* Macro-geometry studies: what is kept is judged and logged, resumes and threads change no bit, and nothing found is an
 * answer too. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/macro_sample.h"
#include "core/pool.h"
#include "core/study.h"

enum { KEEP = 2, LOG_ROOM = 1 + 2 * KEEP };

/* Compliances of all tests: most of them build the same models. */
static struct qg_cache *cache;

/* Ranges about case S in which some pairs of a million pass; few speeds. */
static struct qg_study macro_study(void) {
    struct qg_study study = {
        .kind = QG_STUDY_MACRO,
        .pair = CASE_S,
        .analysis = {.case_count = 2,
                     .torque_fraction = {1, 0.5},
                     .mesh_positions = 6,
                     .mesh_refinement = 1,
                     .harmonics = 2,
                     .speeds = {.min = 0.4, .max = 1.2, .count = 16, .start_static = 1}},
        .macro = {.samples = QG_MACRO_BLOCK + 5000,
                  .seed = 3,
                  .keep = KEEP,
                  .ranges = {.module = {1.8, 2.3},
                             .pressure_angle_deg = {16, 20},
                             .gears = {{{38, 47}, {-1, 1}, {46.4, 47.6}, {39.9, 41.1}, -1},
                                       {{58, 72}, {-2.5, 0.5}, {68.8, 70.4}, {62.4, 63.6}, 0.2}}},
                  .limits = {1, {0.2, 0.4}, 0.4, 0.25, 1, 1}},
    };
    return study;
}

/* An observer with a log, of which the first `known` entries are handed back. */
struct watcher {
    struct qg_evaluation log[LOG_ROOM];
    size_t count, known, computed, improved, references, steps, total;
    const struct watcher *earlier;
    enum qg_phase cancel_in; /* cancelled once this phase has come; 0: never */
    enum qg_phase phase;
};

static bool recall(void *self, struct qg_evaluation *e) {
    struct watcher *w = self;
    if (e->number >= w->known)
        return false;
    const struct qg_evaluation *old = &w->earlier->log[e->number];
    assert_true(old->phase == e->phase && memcmp(old->parameter, e->parameter, sizeof e->parameter) == 0);
    *e = w->log[w->count++] = *old;
    return true;
}

static enum qg_status record(void *self, const struct qg_evaluation *e, size_t n) {
    struct watcher *w = self;
    for (size_t i = 0; i < n; i++) {
        assert_true(e[i].number == w->count && w->count < LOG_ROOM);
        w->log[w->count++] = e[i];
    }
    w->computed += n;
    return QG_OK;
}

static void progress(void *self, const struct qg_progress *p) {
    struct watcher *w = self;
    assert_true(p->phase >= w->phase && p->done >= w->steps && p->done <= p->total);
    w->steps = p->done;
    w->total = p->total;
    w->phase = p->phase;
}

static void reference(void *self, const struct qg_design_result *r) {
    struct watcher *w = self;
    assert_int_equal(r->pair.gears[QG_PINION].teeth, 28);
    w->references++;
}

static void improved(void *self, const struct qg_design_result *r) {
    struct watcher *w = self;
    assert_true(r->f_dte > 0 && r->pair.gears[QG_PINION].teeth >= 38 && r->backlash > 0.2);
    w->improved++;
}

static bool cancelled(void *self) {
    const struct watcher *w = self;
    return w->cancel_in > 0 && w->phase >= w->cancel_in;
}

static enum qg_status run(const struct qg_study *study, const struct qg_means *means, struct watcher *w,
                          struct qg_study_result *result) {
    const struct qg_means serial = {.executor = qg_serial_executor, .cache = cache};
    const struct qg_observer observer = {.self = w,
                                         .recall = recall,
                                         .record = record,
                                         .progress = progress,
                                         .reference = reference,
                                         .improved = improved,
                                         .cancelled = cancelled};
    return qg_study_run(study, means ? means : &serial, &observer, result);
}

static void same_result(const struct qg_study_result *a, const struct qg_study_result *b) {
    const struct qg_macro_result *x = &a->macro, *y = &b->macro;
    assert_int_equal(x->count, y->count);
    assert_int_equal(x->best, y->best);
    assert_int_equal(x->passed, y->passed);
    assert_memory_equal(x->rejected, y->rejected, sizeof x->rejected);
    for (size_t i = 0; i < x->count; i++) {
        const struct qg_macro_candidate *c = &x->candidate[i], *d = &y->candidate[i];
        assert_memory_equal(&c->point, &d->point, sizeof c->point);
        assert_memory_equal(&c->pair, &d->pair, sizeof c->pair);
        assert_true(c->f_pps == d->f_pps && c->f_dte == d->f_dte && c->evaluation == d->evaluation);
        assert_true(c->max_contact_pressure == d->max_contact_pressure && c->max_root_stress == d->max_root_stress);
        assert_true(c->loaded_contact_ratio == d->loaded_contact_ratio);
        assert_true(c->mean_mesh_stiffness == d->mean_mesh_stiffness);
    }
    assert_true(a->design->f_dte == b->design->f_dte && a->design->f_pps == b->design->f_pps);
    assert_memory_equal(&a->design->pair, &b->design->pair, sizeof a->design->pair);
    for (size_t i = 0; i < a->design->speeds; i++)
        assert_true(a->design->cases[0].response[i].rms == b->design->cases[0].response[i].rms);
    assert_true(a->reference->f_dte == b->reference->f_dte);
}

/* The candidate as an evaluation of its own. */
static void check_candidate(const struct qg_study *study, const struct qg_macro_candidate *c) {
    struct qg_study one = *study;
    struct qg_study_result result;
    const struct qg_means means = {.executor = qg_serial_executor, .cache = cache};
    one.kind = QG_STUDY_EVALUATE;
    one.pair = c->pair;
    assert_int_equal(qg_study_run(&one, &means, NULL, &result), QG_OK);
    assert_true(result.design->f_pps == c->f_pps && result.design->f_dte == c->f_dte);
    assert_true(result.geometry.contact_ratio == c->point.contact_ratio);
    assert_true(c->is_possible && result.geometry.backlash == c->geometry.backlash);
    assert_true(result.geometry.equivalent_mass == c->geometry.equivalent_mass);
    assert_true(result.design->cases[0].loaded_contact_ratio == c->loaded_contact_ratio);
    assert_true(result.design->cases[0].max_contact_pressure == c->max_contact_pressure);
    const struct qg_stresses *stresses = result.design->cases[0].stresses;
    assert_true(fmax(stresses->tension[0][stresses->most_tension[0]].stress,
                     stresses->tension[1][stresses->most_tension[1]].stress) == c->max_root_stress);
    qg_study_result_finish(&result);
}

static void what_is_kept_is_judged(void **state) {
    (void)state;
    for (int objective = 0; objective < QG_MAP_OBJECTIVES; objective++) {
        struct qg_study study = macro_study();
        study.objective = (enum qg_objective)objective;
        struct watcher w = {0};
        struct qg_study_result r;
        assert_int_equal(run(&study, NULL, &w, &r), QG_OK);
        const struct qg_macro_result *m = &r.macro;
        uint64_t sum = m->passed;
        for (int i = 0; i < QG_MACRO_CONSTRAINTS; i++)
            sum += m->rejected[i];
        assert_true(sum == study.macro.samples && m->samples == study.macro.samples && m->passed >= KEEP);
        assert_true(m->count >= KEEP && w.count == 1 + m->count && w.computed == w.count);
        assert_true(w.total == 2 + 2 + 2 * KEEP && w.steps == w.total);
        assert_true(w.references == 1 && w.improved >= 1 && w.improved == r.history_count);
        for (size_t i = 0; i < m->count; i++) {
            const struct qg_evaluation *e = &w.log[1 + i];
            const struct qg_macro_candidate *c = &m->candidate[i];
            assert_true(e->phase == QG_PHASE_CANDIDATES && e->parameter[0] == (double)c->point.sample);
            assert_true(e->f_pps == c->f_pps && e->f_dte == c->f_dte && c->evaluation == 1 + i && c->judged);
            assert_true(c->on_front || c->among_best);
            assert_true(objective == QG_OBJECTIVE_F_DTE ? c->f_dte >= r.design->f_dte : c->f_pps >= r.design->f_pps);
        }
        assert_memory_equal(&r.design->pair, &m->candidate[m->best].pair, sizeof r.design->pair);
        assert_true(r.design->f_dte == m->candidate[m->best].f_dte && isfinite(r.design->f_pps));
        assert_memory_equal(&r.reference->pair, &study.pair, sizeof study.pair);
        if (objective == 0)
            check_candidate(&study, &m->candidate[m->count - 1]);
        qg_study_result_finish(&r);
    }
}

/* Ranges of no width: all samples are the initial pair, which is judged once. */
static void one_geometry_is_one_candidate(void **state) {
    (void)state;
    struct qg_study study = macro_study();
    study.macro.samples = 5000;
    struct qg_macro_ranges *r = &study.macro.ranges;
    r->module = (struct qg_interval){study.pair.rack.module, study.pair.rack.module};
    r->pressure_angle_deg = (struct qg_interval){20, 20};
    for (int g = 0; g < 2; g++) {
        const struct qg_gear *gear = &study.pair.gears[g];
        r->gears[g].teeth = (struct qg_interval){gear->teeth, gear->teeth};
        r->gears[g].profile_shift = (struct qg_interval){gear->profile_shift, gear->profile_shift};
        r->gears[g].outside_radius = (struct qg_interval){gear->outside_radius, gear->outside_radius};
        r->gears[g].root_radius = (struct qg_interval){gear->root_radius, gear->root_radius};
        r->gears[g].hob_tip_radius = gear->hob_tip_radius;
    }
    struct qg_study_result result;
    const struct qg_means means = {.executor = qg_serial_executor, .cache = cache};
    assert_int_equal(qg_study_run(&study, &means, NULL, &result), QG_OK);
    assert_true(result.macro.samples == 5000 && result.macro.passed == 5000);
    assert_int_equal(result.macro.count, 1);
    assert_int_equal(result.macro.candidate[0].point.sample, 0);
    assert_true(result.macro.candidate[0].judged && result.macro.candidate[0].f_dte == result.reference->f_dte);
    qg_study_result_finish(&result);
}

static void any_prefix_and_any_threads_give_the_same_bits(void **state) {
    (void)state;
    const struct qg_study study = macro_study();
    struct watcher first = {0};
    struct qg_study_result undisturbed, resumed;
    assert_int_equal(run(&study, NULL, &first, &undisturbed), QG_OK);
    struct qg_pool *pool = qg_pool_create(3);
    const struct qg_means means = {.executor = qg_pool_executor(pool), .cache = cache};
    const struct qg_means fresh = {.executor = qg_pool_executor(pool)}; /* without the cache */
    for (size_t known = 0; known <= first.count; known++) {
        struct watcher again = {.earlier = &first, .known = known};
        assert_int_equal(run(&study, known % 2 ? NULL : known ? &means : &fresh, &again, &resumed), QG_OK);
        assert_int_equal(again.computed, first.count - known);
        assert_memory_equal(again.log, first.log, first.count * sizeof *first.log);
        same_result(&undisturbed, &resumed);
        qg_study_result_finish(&resumed);
    }
    qg_pool_destroy(pool);
    qg_study_result_finish(&undisturbed);
}

static void cancelling_stops_in_either_phase(void **state) {
    (void)state;
    static const enum qg_phase phases[] = {QG_PHASE_SAMPLING, QG_PHASE_CANDIDATES};
    const struct qg_study study = macro_study();
    for (size_t i = 0; i < 2; i++) {
        struct watcher w = {.cancel_in = phases[i]};
        struct qg_study_result result;
        assert_int_equal(run(&study, NULL, &w, &result), QG_CANCELLED);
        assert_true(w.phase == phases[i] && w.count < 1 + 2 * KEEP);
        qg_study_result_finish(&result);
    }
}

static void nothing_found_is_said(void **state) {
    (void)state;
    struct qg_study study = macro_study();
    struct watcher w = {0};
    struct qg_study_result r;
    study.macro.limits.contact_stress_factor = 0.1;
    study.macro.samples = 100000;
    assert_int_equal(run(&study, NULL, &w, &r), QG_OK);
    assert_null(r.design);
    assert_true(r.reference->f_dte > 0);
    assert_true(r.macro.passed == 0 && r.macro.count == 0 && r.macro.best == 0 && w.count == 1);
    assert_true(w.steps == w.total);
    assert_int_equal(r.warnings.count, 1);
    assert_string_equal(r.warnings.item[0].where, "macro");
    assert_non_null(strstr(r.warnings.item[0].text, "none of 100000 samples passed; most were rejected by ratio"));
    assert_non_null(strstr(r.warnings.item[0].text, " that got furthest by contact_stress (no more contact stress"));
    assert_non_null(strstr(r.warnings.item[0].text, "may find some")); /* nothing is cut off */
    qg_study_result_finish(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_kept_is_judged),
        cmocka_unit_test(one_geometry_is_one_candidate),
        cmocka_unit_test(any_prefix_and_any_threads_give_the_same_bits),
        cmocka_unit_test(cancelling_stops_in_either_phase),
        cmocka_unit_test(nothing_found_is_said),
    };
    qg_numerics_init(1);
    cache = qg_cache_create((size_t)256 << 20);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    qg_cache_destroy(cache);
    return failed;
}
