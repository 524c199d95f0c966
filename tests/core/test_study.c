/* Studies: numbering, the log as the checkpoint, any executor, cancelling, and what is refused before anything runs. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/pool.h"
#include "core/study.h"

enum { LOG_ROOM = 400 };

/* An observer that writes everything down, hands back the first `known` evaluations, and stops when told. */
struct witness {
    struct qg_evaluation log[LOG_ROOM];
    size_t count, computed;
    const struct witness *earlier; /* whose log is handed back */
    size_t known;
    size_t steps, total, phase;
    double last_improved;
    size_t improved, references;
    size_t stop_after; /* evaluations; 0: never */
    enum qg_status answer;
};

static bool recall(void *self, struct qg_evaluation *e) {
    struct witness *w = self;
    if (!w->earlier || e->number >= w->known)
        return false;
    const struct qg_evaluation *old = &w->earlier->log[e->number];
    assert_int_equal(old->number, e->number);
    assert_int_equal(old->phase, e->phase);
    assert_memory_equal(old->parameter, e->parameter, sizeof e->parameter);
    e->f_pps = old->f_pps;
    e->f_dte = old->f_dte;
    e->f_dte_percentile = old->f_dte_percentile;
    w->log[w->count++] = *e;
    return true;
}

static enum qg_status record(void *self, const struct qg_evaluation *e, size_t n) {
    struct witness *w = self;
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(e[i].number, w->count);
        assert_true(w->count < LOG_ROOM);
        w->log[w->count++] = e[i];
    }
    w->computed += n;
    return w->answer;
}

/* Phases in the order of a run: newer ones have larger numbers, but the reliability comes last. */
static unsigned rank(enum qg_phase phase) {
    return phase == QG_PHASE_RELIABILITY ? QG_PHASE_COUNT : phase;
}

static void progress(void *self, const struct qg_progress *p) {
    struct witness *w = self;
    assert_true(p->done >= w->steps && p->done <= p->total);
    assert_true(rank(p->phase) >= rank((enum qg_phase)w->phase));
    assert_true(w->total == 0 || w->total == p->total);
    w->steps = p->done;
    w->total = p->total;
    w->phase = p->phase;
}

static void reference(void *self, const struct qg_design_result *r) {
    struct witness *w = self;
    w->references++;
    assert_true(r->f_dte > 0);
}

static void improved(void *self, const struct qg_design_result *r) {
    struct witness *w = self;
    assert_true(isfinite(r->f_dte) && isfinite(r->f_pps));
    w->improved++;
    w->last_improved = r->f_dte;
}

static bool cancelled(void *self) {
    const struct witness *w = self;
    return w->stop_after > 0 && w->count >= w->stop_after;
}

static struct qg_observer observed_by(struct witness *w) {
    return (struct qg_observer){.self = w,
                                .recall = recall,
                                .record = record,
                                .progress = progress,
                                .reference = reference,
                                .improved = improved,
                                .cancelled = cancelled};
}

static enum qg_status run(const struct qg_study *study, const struct qg_means *means, struct witness *w,
                          struct qg_study_result *result) {
    const struct qg_means serial = {.executor = qg_serial_executor};
    const struct qg_observer observer = observed_by(w);
    return qg_study_run(study, means ? means : &serial, &observer, result);
}

static struct witness *new_witness(void) {
    struct witness *w = calloc(1, sizeof *w);
    assert_non_null(w);
    return w;
}

static void same_stresses(const struct qg_stresses *a, const struct qg_stresses *b) {
    assert_true(a && b);
    for (int g = 0; g < 2; g++)
        for (size_t i = 0; i < a->positions; i++) {
            assert_true(a->tension[g][i].stress == b->tension[g][i].stress);
            assert_true(a->compression[g][i].stress == b->compression[g][i].stress);
        }
    assert_memory_equal(a->pressure, b->pressure, a->positions * a->pairs * sizeof *a->pressure);
}

static void same_design(const struct qg_design_result *a, const struct qg_design_result *b) {
    assert_memory_equal(&a->relief.gears[0].tip.radius, &b->relief.gears[0].tip.radius, sizeof(double));
    assert_memory_equal(&a->relief.gears[0].tip.amplitude, &b->relief.gears[0].tip.amplitude, sizeof(double));
    assert_memory_equal(&a->relief.gears[1].tip.amplitude, &b->relief.gears[1].tip.amplitude, sizeof(double));
    assert_true(a->f_pps == b->f_pps && a->f_dte == b->f_dte);
    for (size_t k = 0; k < a->case_count; k++) {
        const struct qg_case_result *x = &a->cases[k], *y = &b->cases[k];
        assert_memory_equal(x->static_transmission_error, y->static_transmission_error, a->positions * sizeof(double));
        assert_memory_equal(x->contact_pressure, y->contact_pressure, a->positions * sizeof(double));
        same_stresses(x->stresses, y->stresses);
        for (size_t i = 0; i < a->speeds; i++) {
            assert_true(x->response[i].rms == y->response[i].rms);
            assert_int_equal(x->response[i].period, y->response[i].period);
        }
    }
}

static void same_map(const struct qg_map *a, const struct qg_map *b) {
    assert_int_equal(a->cells, b->cells);
    for (int i = 0; i < QG_MAP_OBJECTIVES && a->cells > 0; i++)
        assert_memory_equal(a->value[i], b->value[i], a->cells * sizeof(double));
}

static void same_result(const struct qg_study_result *a, const struct qg_study_result *b) {
    same_design(a->design, b->design);
    same_design(a->reference, b->reference);
    assert_int_equal(a->evaluations, b->evaluations);
    assert_int_equal(a->history_count, b->history_count);
    for (size_t i = 0; i < a->history_count; i++) {
        assert_int_equal(a->history[i].evaluation, b->history[i].evaluation);
        assert_true(a->history[i].best == b->history[i].best);
    }
    same_map(&a->map, &b->map);
    assert_int_equal(a->reliability.failures, b->reliability.failures);
    assert_true(a->reliability.mean_f_dte == b->reliability.mean_f_dte);
    assert_int_equal(a->front.count, b->front.count);
    assert_true(a->hypervolume == b->hypervolume);
    for (size_t i = 0; i < a->front.count; i++)
        assert_int_equal(a->front.member[i].evaluation, b->front.member[i].evaluation);
    if (!isnan(a->design->f_dte_percentile)) {
        assert_true(a->design->f_dte_percentile == b->design->f_dte_percentile);
        assert_true(a->reference->f_dte_percentile == b->reference->f_dte_percentile);
    }
}

static void an_optimization_is_counted_and_watched(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct witness *w = new_witness();
    struct qg_study_result result;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(w->computed, w->count);
    assert_int_equal(w->count, 1 + result.evaluations + 20);
    assert_int_equal(w->total, 2 + 20 + 10 + 20);
    assert_int_equal(w->steps, w->total);
    assert_int_equal(w->references, 1);
    assert_int_equal(w->improved, result.history_count);
    assert_true(w->last_improved == result.design->f_dte);
    /* the answer is the best of the log, and the history its record */
    double best = INFINITY;
    size_t at = 0;
    for (size_t i = 1; i < 1 + result.evaluations; i++)
        if (w->log[i].f_dte < best) {
            best = w->log[i].f_dte;
            assert_int_equal(result.history[at].evaluation, i);
            assert_true(result.history[at++].best == best);
        }
    assert_int_equal(at, result.history_count);
    assert_true(best == result.design->f_dte);
    assert_true(best < result.reference->f_dte);
    assert_true(w->log[0].phase == QG_PHASE_REFERENCE && w->log[1].phase == QG_PHASE_RANDOM);
    assert_true(w->log[w->count - 1].phase == QG_PHASE_RELIABILITY);
    assert_true(w->log[0].parameter[QG_PINION_TIP_START_RADIUS] == 44.54);
    assert_true(w->log[5].parameter[QG_GEAR_TIP_START_RADIUS] == 67.64); /* not bounded: the reference's */
    qg_study_result_finish(&result);
    free(w);
}

static void any_prefix_of_the_log_leads_to_the_same_bits(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct witness *first = new_witness();
    struct qg_study_result undisturbed;
    assert_int_equal(run(&study, NULL, first, &undisturbed), QG_OK);
    const size_t prefixes[] = {1, 2, 17, 21, 25, 33, first->count - 20, first->count - 1, first->count};
    for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++) {
        struct witness *again = new_witness();
        struct qg_study_result resumed;
        again->earlier = first;
        again->known = prefixes[i];
        assert_int_equal(run(&study, NULL, again, &resumed), QG_OK);
        assert_int_equal(again->computed, first->count - prefixes[i]);
        assert_true(again->improved >= 1);
        same_result(&undisturbed, &resumed);
        qg_study_result_finish(&resumed);
        free(again);
    }
    qg_study_result_finish(&undisturbed);
    free(first);
}

static void threads_and_cache_change_no_bit(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct witness *w = new_witness();
    struct qg_study_result serial;
    assert_int_equal(run(&study, NULL, w, &serial), QG_OK);
    struct qg_pool *pool = qg_pool_create(3);
    const struct qg_means means = {.executor = qg_pool_executor(pool), .cache = qg_cache_create((size_t)64 << 20)};
    for (int turn = 0; turn < 2; turn++) {
        struct witness *other = new_witness();
        struct qg_study_result result;
        assert_int_equal(run(&study, &means, other, &result), QG_OK);
        same_result(&serial, &result);
        assert_memory_equal(w->log, other->log, w->count * sizeof *w->log);
        qg_study_result_finish(&result);
        free(other);
    }
    assert_int_equal(qg_cache_count(means.cache).found, 2);
    assert_int_equal(qg_cache_count(means.cache).kept, 2);
    qg_cache_destroy(means.cache);
    qg_pool_destroy(pool);
    qg_study_result_finish(&serial);
    free(w);
}

static void cancelling_stops_and_loses_nothing(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct witness *whole = new_witness(), *stopped = new_witness(), *rest = new_witness();
    struct qg_study_result a, b, c;
    assert_int_equal(run(&study, NULL, whole, &a), QG_OK);
    stopped->stop_after = 20;
    assert_int_equal(run(&study, NULL, stopped, &b), QG_CANCELLED);
    assert_true(stopped->count >= 20 && stopped->count < whole->count);
    rest->earlier = stopped;
    rest->known = stopped->count;
    assert_int_equal(run(&study, NULL, rest, &c), QG_OK);
    same_result(&a, &c);
    qg_study_result_finish(&a);
    qg_study_result_finish(&b);
    qg_study_result_finish(&c);
    free(whole);
    free(stopped);
    free(rest);
}

/* Says stop when it has been asked often enough, and from then on. */
struct patience {
    size_t asked, enough;
};

static bool is_enough(void *self) {
    struct patience *p = self;
    return ++p->asked > p->enough;
}

/* Wherever the making of a model is stopped, it ends with nothing made, and soon: serially, what is left to be asked are the
 * second gear or the other mesh positions. */
static void making_a_model_can_be_stopped(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct patience whole = {.enough = SIZE_MAX};
    struct qg_means means = {.executor = qg_serial_executor, .stop = {is_enough, &whole}};
    struct qg_model *model;
    assert_int_equal(qg_model_create(&study.pair, &study.analysis, &means, NULL, &model), QG_OK);
    qg_model_destroy(model);
    /* two gears: each once for every order of its ring, every position */
    const int *teeth = (int[]){study.pair.gears[0].teeth, study.pair.gears[1].teeth};
    assert_true(whole.asked > (size_t)(teeth[0] / 2 + teeth[1] / 2 + study.analysis.mesh_positions));
    for (size_t k = 0; k < whole.asked; k += 7) {
        struct patience p = {.enough = k};
        means.stop.self = &p;
        assert_int_equal(qg_model_create(&study.pair, &study.analysis, &means, NULL, &model), QG_CANCELLED);
        assert_null(model);
        assert_true(p.asked <= k + 1 + (size_t)study.analysis.mesh_positions);
    }
}

static bool at_once(void *self) {
    (void)self;
    return true;
}

/* A study that is cancelled at once makes no model first: nothing comes into the cache. */
static void a_cancelled_study_makes_no_model(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    const struct qg_observer observer = {.cancelled = at_once};
    const struct qg_means means = {.executor = qg_serial_executor, .cache = qg_cache_create((size_t)64 << 20)};
    struct qg_study_result result;
    assert_int_equal(qg_study_run(&study, &means, &observer, &result), QG_CANCELLED);
    assert_int_equal(qg_cache_count(means.cache).kept, 0);
    qg_study_result_finish(&result);
    qg_cache_destroy(means.cache);
}

static void a_log_that_cannot_be_written_ends_the_study(void **state) {
    (void)state;
    const struct qg_study study = small_study();
    struct witness *w = new_witness();
    struct qg_study_result result;
    w->answer = QG_OUT_OF_MEMORY;
    assert_int_equal(run(&study, NULL, w, &result), QG_OUT_OF_MEMORY);
    assert_int_equal(w->count, 1);
    qg_study_result_finish(&result);
    free(w);
}

static void the_static_objective_is_the_smallest_pps(void **state) {
    (void)state;
    struct qg_study study = small_study();
    study.objective = QG_OBJECTIVE_F_PPS;
    study.reliability.samples = 0;
    struct witness *w = new_witness();
    struct qg_study_result result;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    for (size_t i = 1; i < w->count; i++) {
        assert_true(w->log[i].f_pps >= result.design->f_pps);
        assert_true(isnan(w->log[i].f_dte));
    }
    assert_true(isfinite(result.design->f_dte)); /* the answer comes with its dynamics all the same */
    assert_int_equal(result.reliability.samples, 0);
    qg_study_result_finish(&result);
    free(w);
}

static void one_design_and_its_reliability(void **state) {
    (void)state;
    struct qg_study study = small_study();
    struct qg_study_result evaluated, tried;
    struct witness *w = new_witness();
    study.kind = QG_STUDY_EVALUATE;
    assert_int_equal(run(&study, NULL, w, &evaluated), QG_OK);
    assert_int_equal(w->count, 1);
    assert_null(evaluated.reference);
    free(w);
    w = new_witness();
    study.kind = QG_STUDY_RELIABILITY;
    assert_int_equal(run(&study, NULL, w, &tried), QG_OK);
    assert_int_equal(w->count, 21);
    same_design(evaluated.design, tried.design);
    size_t failures = 0;
    for (size_t i = 1; i < 21; i++)
        failures += w->log[i].f_dte > study.reliability.limit_f_dte;
    assert_int_equal(failures, tried.reliability.failures);
    qg_study_result_finish(&evaluated);
    qg_study_result_finish(&tried);
    free(w);
}

static void a_search_that_gains_nothing_says_so(void **state) {
    (void)state;
    struct qg_study study = small_study();
    struct qg_study_result result;
    struct witness *w = new_witness();
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(result.warnings.count, 0);
    qg_study_result_finish(&result);
    free(w);
    w = new_witness();
    study.optimizer = (struct qg_optimizer){.random_samples = 1, .seed = 1};
    study.bounds.lower[1] = 0.034; /* far too deep */
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_true(result.design->f_dte > result.reference->f_dte);
    assert_int_equal(result.warnings.count, 1);
    assert_string_equal(result.warnings.item[0].where, "optimizer");
    qg_study_result_finish(&result);
    free(w);
}

/* Several simplexes for one objective. */
static struct qg_study small_multistart(void) {
    struct qg_study study = small_study();
    study.optimizer.method = QG_SEARCH_MULTISTART_SIMPLEX;
    study.reliability.samples = 4;
    return study;
}

/* Two objectives, one of them robust. */
static struct qg_study small_front(void) {
    struct qg_study study = small_multistart();
    study.objectives = (struct qg_objectives){2, {QG_OBJECTIVE_F_DTE_PERCENTILE, QG_OBJECTIVE_F_PPS}};
    study.optimizer.evaluations = 40;
    return study;
}

static void a_multistart_search_is_counted(void **state) {
    (void)state;
    const struct qg_study study = small_multistart();
    struct witness *w = new_witness();
    struct qg_study_result result;
    double best = INFINITY;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(result.evaluations, 60);
    assert_int_equal(w->count, 1 + 60 + 4);
    assert_int_equal(w->total, 2 + 60 + 4);
    assert_int_equal(w->improved, result.history_count);
    for (size_t i = 1; i <= 60; i++) {
        assert_int_equal(w->log[i].phase, QG_PHASE_MULTISTART);
        assert_true(isnan(w->log[i].f_dte_percentile));
        best = fmin(best, w->log[i].f_dte);
    }
    assert_true(best == result.design->f_dte && best < result.reference->f_dte);
    assert_true(isnan(result.design->f_dte_percentile));
    assert_int_equal(result.front.count, 0);
    qg_study_result_finish(&result);
    free(w);
}

/* Its own trials, judged one by one: the percentile in the log is that of their F_DTE, for the reference and a candidate. */
static void the_percentile_is_that_of_its_trials(void **state) {
    (void)state;
    struct qg_study study = small_front();
    study.objectives.count = 0;
    study.objective = QG_OBJECTIVE_F_DTE_PERCENTILE;
    struct witness *w = new_witness();
    struct qg_study_result result, one;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    static const size_t looked_at[] = {0, 9};
    for (size_t k = 0; k < 2; k++) {
        const struct qg_evaluation *e = &w->log[looked_at[k]];
        double f_dte[5];
        for (size_t trial = 0; trial < 5; trial++) {
            struct qg_study single = small_study();
            single.kind = QG_STUDY_EVALUATE;
            for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
                if (qg_relief_ramp_of(&single.relief, i)->present)
                    *qg_relief_parameter(&single.relief, i) = e->parameter[i];
            single.relief = qg_reliability_trial(&study.reliability, &study.pair, &result.geometry, &single.relief,
                                                 ((size_t)1 << 32) + trial);
            struct witness *other = new_witness();
            assert_int_equal(run(&single, NULL, other, &one), QG_OK);
            f_dte[trial] = one.design->f_dte;
            qg_study_result_finish(&one);
            free(other);
        }
        assert_true(qg_reliability_percentile(&study.reliability, f_dte) == e->f_dte_percentile);
    }
    assert_true(w->log[0].f_dte_percentile == result.reference->f_dte_percentile);
    assert_true(result.design->f_dte_percentile < result.reference->f_dte_percentile);
    assert_true(isnan(w->log[w->count - 1].f_dte_percentile)); /* a trial of the reliability has none of its own */
    qg_study_result_finish(&result);
    free(w);
}

/* The front is that of all evaluations; the design is the one whose largest ratio to the reference is smallest. */
static void the_front_is_drawn_from_all_evaluations(void **state) {
    (void)state;
    const struct qg_study study = small_front();
    struct witness *w = new_witness();
    struct qg_study_result result;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    size_t on_front = 0, chosen = 1;
    double least = INFINITY;
    for (size_t i = 0; i <= 40; i++) {
        const struct qg_evaluation *a = &w->log[i];
        bool beaten = false;
        for (size_t j = 0; j <= 40; j++) {
            const struct qg_evaluation *b = &w->log[j];
            beaten = beaten || (b->f_pps <= a->f_pps && b->f_dte_percentile <= a->f_dte_percentile &&
                                (j < i || b->f_pps < a->f_pps || b->f_dte_percentile < a->f_dte_percentile) && j != i);
        }
        on_front += !beaten;
        double ratio = fmax(a->f_pps / w->log[0].f_pps, a->f_dte_percentile / w->log[0].f_dte_percentile);
        if (i > 0 && ratio < least) {
            least = ratio;
            chosen = i;
        }
    }
    assert_int_equal(result.front.count, on_front);
    assert_true(on_front > 2);
    assert_true(result.design->f_pps == w->log[chosen].f_pps);
    assert_true(result.design->f_dte_percentile == w->log[chosen].f_dte_percentile);
    assert_true(result.history[result.history_count - 1].best == least);
    assert_true(result.hypervolume > 0 && result.hypervolume < 1);
    for (size_t i = 0; i < result.front.count; i++)
        assert_true(result.front.member[i].f_pps == w->log[result.front.member[i].evaluation].f_pps);
    qg_study_result_finish(&result);
    free(w);
}

/* How many warnings are at a place. */
static size_t warnings_at(const struct qg_notes *notes, const char *where) {
    size_t n = 0;
    for (size_t i = 0; i < notes->count; i++)
        n += strcmp(notes->item[i].where, where) == 0;
    return n;
}

/* The verification says what evaluations with more mesh positions say, is in no log, and warns of what is lost. */
static void a_verification_judges_both_designs_again(void **state) {
    (void)state;
    struct qg_study study = small_multistart(), fine = small_study();
    study.objective = QG_OBJECTIVE_F_PPS;
    study.optimizer.verification_factor = 3;
    struct witness *w = new_witness(), *v = new_witness(), *u = new_witness();
    struct qg_study_result result, reference, design;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(w->count, 1 + 60 + 4);
    assert_int_equal(w->total, 2 + 60 + 4 + 1);
    assert_int_equal(w->steps, w->total);
    assert_int_equal(result.verification.mesh_positions, 42);
    fine.kind = QG_STUDY_EVALUATE;
    fine.analysis.mesh_positions = 42;
    assert_int_equal(run(&fine, NULL, v, &reference), QG_OK);
    fine.relief = result.design->relief;
    assert_int_equal(run(&fine, NULL, u, &design), QG_OK);
    assert_true(result.verification.f_pps[0] == reference.design->f_pps);
    assert_true(result.verification.f_dte[0] == reference.design->f_dte);
    assert_true(result.verification.f_pps[1] == design.design->f_pps);
    assert_true(result.verification.f_dte[1] == design.design->f_dte);
    double before = 1 - result.design->f_pps / result.reference->f_pps,
           left = 1 - design.design->f_pps / reference.design->f_pps;
    assert_true(before > 0);
    assert_int_equal(warnings_at(&result.warnings, "optimizer"), left < 0.9 * before);
    qg_study_result_finish(&result);
    study.optimizer.verification_factor = 1; /* as many positions as before: nothing to verify */
    free(w);
    w = new_witness();
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(result.verification.mesh_positions, 0);
    assert_int_equal(w->total, 2 + 60 + 4);
    qg_study_result_finish(&result);
    qg_study_result_finish(&reference);
    qg_study_result_finish(&design);
    free(w);
    free(v);
    free(u);
}

/* Any prefix of the log, any threads: the same bits. */
static void the_new_searches_go_on_where_their_log_ends(void **state) {
    (void)state;
    struct qg_pool *pool = qg_pool_create(3);
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    for (int which = 0; which < 2; which++) {
        const struct qg_study study = which ? small_front() : small_multistart();
        struct witness *first = new_witness();
        struct qg_study_result undisturbed;
        assert_int_equal(run(&study, NULL, first, &undisturbed), QG_OK);
        const size_t prefixes[] = {0, 1, 12, 23, 31, 41, first->count};
        for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++) {
            struct witness *again = new_witness();
            struct qg_study_result resumed;
            again->earlier = first;
            again->known = prefixes[i];
            assert_int_equal(run(&study, i % 2 ? NULL : &means, again, &resumed), QG_OK);
            assert_int_equal(again->computed, first->count - prefixes[i]);
            same_result(&undisturbed, &resumed);
            assert_memory_equal(first->log, again->log, first->count * sizeof *first->log);
            qg_study_result_finish(&resumed);
            free(again);
        }
        qg_study_result_finish(&undisturbed);
        free(first);
    }
    qg_pool_destroy(pool);
}

/* 5 x 4 cells: two batches, the second of which is not full. */
static struct qg_study small_map(enum qg_objective objective) {
    struct qg_study study = small_study();
    study.kind = QG_STUDY_MAP;
    study.objective = objective;
    study.bounds.count = 0;
    study.reliability.samples = 0;
    study.grid =
        (struct qg_grid){2, {{QG_PINION_TIP_START_RADIUS, 46, 43, 5}, {QG_GEAR_TIP_AMPLITUDE, 0.005, 0.03, 4}}};
    return study;
}

static void a_map_judges_every_cell_both_ways(void **state) {
    (void)state;
    for (int objective = 0; objective < QG_MAP_OBJECTIVES; objective++) {
        const struct qg_study study = small_map((enum qg_objective)objective);
        struct witness *w = new_witness();
        struct qg_study_result result;
        assert_int_equal(run(&study, NULL, w, &result), QG_OK);
        assert_int_equal(w->count, 1 + 20);
        assert_int_equal(w->total, 2 + 20);
        assert_int_equal(w->steps, w->total);
        assert_int_equal(w->references, 1);
        assert_int_equal(w->improved, result.history_count);
        assert_int_equal(result.map.cells, 20);
        for (size_t i = 0; i < 20; i++) {
            const struct qg_evaluation *e = &w->log[1 + i];
            assert_int_equal(e->phase, QG_PHASE_MAP);
            assert_true(e->parameter[QG_PINION_TIP_START_RADIUS] == qg_axis_at(&study.grid.axis[0], i / 4));
            assert_true(e->parameter[QG_GEAR_TIP_AMPLITUDE] == qg_axis_at(&study.grid.axis[1], i % 4));
            assert_true(e->parameter[QG_PINION_TIP_AMPLITUDE] == 0.016); /* not on the grid: the reference's */
            assert_true(e->f_pps == result.map.value[QG_OBJECTIVE_F_PPS][i] && e->f_pps > 0);
            assert_true(e->f_dte == result.map.value[QG_OBJECTIVE_F_DTE][i] && e->f_dte > 0);
        }
        const size_t best = qg_grid_smallest(&study.grid, result.map.value[objective]);
        assert_true(result.design->f_pps == result.map.value[QG_OBJECTIVE_F_PPS][best]);
        assert_true(result.design->f_dte == result.map.value[QG_OBJECTIVE_F_DTE][best]);
        assert_true(result.design->relief.gears[QG_GEAR].tip.amplitude == qg_axis_at(&study.grid.axis[1], best % 4));
        assert_true(w->last_improved == result.design->f_dte);
        qg_study_result_finish(&result);
        free(w);
    }
}

/* A cell is what an evaluation of its relief gives. */
static void a_cell_of_a_map_is_an_evaluation(void **state) {
    (void)state;
    struct qg_study study = small_map(QG_OBJECTIVE_F_DTE), one = study;
    struct witness *w = new_witness(), *v = new_witness();
    struct qg_study_result map, evaluated;
    assert_int_equal(run(&study, NULL, w, &map), QG_OK);
    one.kind = QG_STUDY_EVALUATE;
    one.relief = qg_grid_relief(&study.grid, &study.relief, 13);
    assert_int_equal(run(&one, NULL, v, &evaluated), QG_OK);
    assert_true(evaluated.design->f_pps == map.map.value[QG_OBJECTIVE_F_PPS][13]);
    assert_true(evaluated.design->f_dte == map.map.value[QG_OBJECTIVE_F_DTE][13]);
    assert_int_equal(evaluated.map.cells, 0);
    qg_study_result_finish(&map);
    qg_study_result_finish(&evaluated);
    free(w);
    free(v);
}

static void a_map_goes_on_after_any_prefix_with_any_threads(void **state) {
    (void)state;
    const struct qg_study study = small_map(QG_OBJECTIVE_F_PPS);
    struct witness *first = new_witness();
    struct qg_study_result undisturbed;
    assert_int_equal(run(&study, NULL, first, &undisturbed), QG_OK);
    struct qg_pool *pool = qg_pool_create(3);
    const struct qg_means means = {.executor = qg_pool_executor(pool)};
    const size_t prefixes[] = {0, 1, 2, 9, 16, 17, 18, 20, 21};
    for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++) {
        struct witness *again = new_witness();
        struct qg_study_result resumed;
        again->earlier = first;
        again->known = prefixes[i];
        assert_int_equal(run(&study, i % 2 ? NULL : &means, again, &resumed), QG_OK);
        assert_int_equal(again->computed, first->count - prefixes[i]);
        assert_true(again->improved >= 1);
        same_result(&undisturbed, &resumed);
        qg_study_result_finish(&resumed);
        free(again);
    }
    qg_pool_destroy(pool);
    qg_study_result_finish(&undisturbed);
    free(first);
}

/* Eight parameters; the pinion's root relief cannot but end below the form radius of 40.47 mm. */
static void a_root_relief_below_the_form_radius_is_warned_of(void **state) {
    (void)state;
    struct qg_study study = small_study();
    study.reliability.samples = 0;
    study.bounds = (struct qg_bounds){.count = QG_PARAMETER_COUNT,
                                      .lower = {42, 0.003, 39.6, 0.003, 64, 0.003, 64, 0.003},
                                      .upper = {46.55, 0.035, 40.4, 0.02, 69.55, 0.035, 66, 0.02}};
    for (unsigned i = 0; i < QG_PARAMETER_COUNT; i++)
        study.bounds.parameter[i] = i;
    struct witness *w = new_witness();
    struct qg_study_result result;
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_true(result.design->relief.gears[QG_PINION].root.present &&
                result.design->relief.gears[QG_GEAR].root.present);
    assert_int_equal(warnings_at(&result.warnings, "bounds.pinion.root.end_radius"), 1);
    assert_int_equal(warnings_at(&result.warnings, "bounds.gear.root.end_radius"), 0);
    qg_study_result_finish(&result);
    /* Of a root relief that was given, once, and as of the given one. */
    study = small_map(QG_OBJECTIVE_F_DTE);
    study.relief.gears[QG_PINION].root = (struct qg_ramp){true, 40, 0.01};
    free(w);
    w = new_witness();
    assert_int_equal(run(&study, NULL, w, &result), QG_OK);
    assert_int_equal(warnings_at(&result.warnings, "pinion.root.end_radius"), 1);
    assert_int_equal(warnings_at(&result.warnings, "grid"), 0);
    qg_study_result_finish(&result);
    free(w);
}

/* Runs the check on a study and returns the first fault's place ("" and a failed test when there is none). */
static const char *first_fault(const struct qg_study *study) {
    static struct qg_notes errors;
    errors = (struct qg_notes){0};
    assert_int_equal(qg_study_check(study, NULL, &errors, NULL), QG_IMPOSSIBLE_GEAR);
    assert_true(errors.count > 0);
    return errors.item[0].where;
}

static void wrong_studies_are_refused_at_their_place(void **state) {
    (void)state;
    struct qg_study study = small_study();
    assert_int_equal(qg_study_check(&study, NULL, NULL, NULL), QG_OK);
    study.bounds.lower[0] = 46.6;
    assert_string_equal(first_fault(&study), "bounds.pinion.tip.start_radius");
    study = small_study();
    study.bounds.upper[2] = 0.2;
    assert_string_equal(first_fault(&study), "bounds.gear.tip.amplitude");
    study = small_study();
    study.relief.gears[QG_GEAR].tip.present = false; /* its start radius is then nowhere */
    assert_string_equal(first_fault(&study), "bounds.gear.tip.amplitude");
    study = small_map(QG_OBJECTIVE_F_DTE);
    assert_int_equal(qg_study_check(&study, NULL, NULL, NULL), QG_OK);
    study.grid.axis[0].from = 46.6;
    assert_string_equal(first_fault(&study), "grid.0.from");
    study = small_map(QG_OBJECTIVE_F_DTE);
    study.grid.axis[1].to = study.grid.axis[1].from;
    assert_string_equal(first_fault(&study), "grid.1.to");
    study = small_map(QG_OBJECTIVE_F_DTE);
    study.grid.axis[1] = study.grid.axis[0];
    assert_string_equal(first_fault(&study), "grid.1.parameter");
    study = small_map(QG_OBJECTIVE_F_DTE);
    study.grid.axis[0].parameter = QG_PINION_ROOT_END_RADIUS; /* without an amplitude */
    assert_string_equal(first_fault(&study), "grid.0.parameter");
    study = small_map(QG_OBJECTIVE_F_DTE);
    study.grid.axis[0].count = 101;
    study.grid.axis[1].count = 100;
    assert_string_equal(first_fault(&study), "grid");
    study = small_map(QG_OBJECTIVE_F_DTE_PERCENTILE);
    assert_string_equal(first_fault(&study), "objective");
    study = small_front();
    assert_int_equal(qg_study_check(&study, NULL, NULL, NULL), QG_OK);
    study.reliability.samples = 0;
    assert_string_equal(first_fault(&study), "objectives");
    study = small_front();
    study.optimizer.method = QG_SEARCH_RANDOM_SIMPLEX;
    assert_string_equal(first_fault(&study), "optimizer.method");
    study = small_study();
    study.analysis.harmonics = 7;
    assert_string_equal(first_fault(&study), "analysis.harmonics");
    study = small_study();
    study.analysis.speeds.max = 0.3;
    assert_string_equal(first_fault(&study), "analysis.speeds.max");
    study = small_study();
    study.pair.gears[QG_GEAR].profile_shift = 6;
    assert_int_equal(strncmp(first_fault(&study), "gear.", 5), 0);
    study = small_study();
    study.relief.gears[QG_PINION].tip.radius = 50;
    assert_string_equal(first_fault(&study), "pinion.tip.start_radius");
}

int main(void) {
    qg_numerics_init(1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_optimization_is_counted_and_watched),
        cmocka_unit_test(any_prefix_of_the_log_leads_to_the_same_bits),
        cmocka_unit_test(threads_and_cache_change_no_bit),
        cmocka_unit_test(cancelling_stops_and_loses_nothing),
        cmocka_unit_test(making_a_model_can_be_stopped),
        cmocka_unit_test(a_cancelled_study_makes_no_model),
        cmocka_unit_test(a_log_that_cannot_be_written_ends_the_study),
        cmocka_unit_test(the_static_objective_is_the_smallest_pps),
        cmocka_unit_test(one_design_and_its_reliability),
        cmocka_unit_test(a_search_that_gains_nothing_says_so),
        cmocka_unit_test(a_multistart_search_is_counted),
        cmocka_unit_test(the_percentile_is_that_of_its_trials),
        cmocka_unit_test(the_front_is_drawn_from_all_evaluations),
        cmocka_unit_test(a_verification_judges_both_designs_again),
        cmocka_unit_test(the_new_searches_go_on_where_their_log_ends),
        cmocka_unit_test(a_map_judges_every_cell_both_ways),
        cmocka_unit_test(a_cell_of_a_map_is_an_evaluation),
        cmocka_unit_test(a_map_goes_on_after_any_prefix_with_any_threads),
        cmocka_unit_test(a_root_relief_below_the_form_radius_is_warned_of),
        cmocka_unit_test(wrong_studies_are_refused_at_their_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
