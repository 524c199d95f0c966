/* Testing samples of macro-geometries (macro_sample.h): a trial goes through the tests in the order of the constraints, and
 * each test draws what it is the first to need. */
#include "core/macro_sample.h"

#include <assert.h>
#include <math.h>

#include "core/random.h"

/* One sample as far as it is known. Index 0 is the pinion. */
struct trial {
    const struct qg_macro_search *search;
    uint64_t sample;
    double teeth[2];
    double module, pressure_angle_deg;
    double sine, cosine, tangent, angle; /* of the pressure angle */
    double reference[2], base[2];        /* radii */
    double working_cosine, working_sine; /* of the working pressure angle */
    double shift[2], outside[2], root[2], hob_tip[2];
    double addendum[2];  /* of the hob */
    double remaining[2]; /* distance of the form point from the base circle along the line of action */
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_macro_rating rating; /* as shares of the initial pair's */
};

/* ---- drawing ---------------------------------------------------------------------------------------------------- */

/* Lanes of the generator, below which the two tooth numbers are 0. */
enum { LANE_RACK = 1, LANE_SHIFTS, LANE_PINION_TIP, LANE_GEAR_TIP };

static double within(const struct qg_interval *range, double u) {
    return range->low + u * (range->high - range->low);
}

/* Two numbers of the trial, from one block. */
static void draw(const struct trial *t, uint32_t lane, const struct qg_interval *first,
                 const struct qg_interval *second, double out[2]) {
    double u[2];
    qg_random_two(t->search->macro.seed, QG_STREAM_MACRO, t->sample, lane, u);
    out[0] = within(first, u[0]);
    out[1] = within(second, u[1]);
}

static void draw_rack(struct trial *t) {
    const struct qg_macro_ranges *r = &t->search->macro.ranges;
    double x[2];
    draw(t, LANE_RACK, &r->module, &r->pressure_angle_deg, x);
    t->module = x[0];
    t->pressure_angle_deg = x[1];
    t->angle = x[1] * (M_PI / 180);
    t->sine = sin(t->angle);
    t->cosine = cos(t->angle);
    t->tangent = t->sine / t->cosine;
    for (int i = 0; i < 2; i++) {
        t->reference[i] = t->module * t->teeth[i] / 2;
        t->base[i] = t->reference[i] * t->cosine;
    }
}

static void draw_shifts(struct trial *t) {
    const struct qg_macro_ranges *r = &t->search->macro.ranges;
    draw(t, LANE_SHIFTS, &r->gears[QG_PINION].profile_shift, &r->gears[QG_GEAR].profile_shift, t->shift);
}

/* The tip of gear i and the root that it turns in. */
static void draw_tip(struct trial *t, int i) {
    const struct qg_macro_ranges *r = &t->search->macro.ranges;
    double x[2];
    draw(t, i == QG_PINION ? LANE_PINION_TIP : LANE_GEAR_TIP, &r->gears[i].outside_radius, &r->gears[1 - i].root_radius,
         x);
    t->outside[i] = x[0];
    t->root[1 - i] = x[1];
}

/* Tooth numbers of one sample without vectors. */
static void draw_teeth(struct trial *t) {
    const struct qg_teeth_draw *d = &t->search->teeth;
    const uint32_t key[2] = {(uint32_t)d->seed, (uint32_t)(d->seed >> 32)};
    uint32_t word[4] = {(uint32_t)(t->sample / 2), (uint32_t)(t->sample / 2 >> 32), 0, QG_STREAM_MACRO << 16};
    qg_philox(word, key);
    for (int i = 0; i < 2; i++)
        t->teeth[i] = d->low[i] + (uint32_t)((uint64_t)word[2 * (t->sample % 2) + (uint64_t)i] * d->count[i] >> 32);
}

/* ---- the tests, in the order of the constraints ------------------------------------------------------------------- */

static bool ratio_is_kept(struct trial *t) {
    return qg_macro_ratio_is_kept(t->teeth[0], t->teeth[1], &t->search->initial, t->search->macro.limits.ratio_percent);
}

static bool base_circles_fit(struct trial *t) {
    draw_rack(t);
    t->working_cosine = (t->base[0] + t->base[1]) / t->search->initial.center_distance;
    return t->working_cosine < 1;
}

static bool backlash_is_within(struct trial *t) {
    const struct qg_interval *limits = &t->search->macro.limits.backlash;
    draw_shifts(t);
    t->working_sine = sqrt(1 - t->working_cosine * t->working_cosine);
    const double involute = t->tangent - t->angle;
    const double working_involute = t->working_sine / t->working_cosine - acos(t->working_cosine);
    const double backlash =
        2 * ((t->base[0] + t->base[1]) * (working_involute - involute) - (t->shift[0] + t->shift[1]) * t->sine);
    return backlash > 0 && backlash >= limits->low && backlash <= limits->high;
}

static bool tips_are_clear(struct trial *t) {
    const double needed = t->search->macro.limits.tip_clearance * t->module;
    for (int i = 0; i < 2; i++) {
        draw_tip(t, i);
        const double clearance = t->search->initial.center_distance - t->outside[i] - t->root[1 - i];
        if (!(clearance > 0 && clearance >= needed))
            return false;
    }
    return true;
}

/* The rounding of the hob's tip as the search wants it. */
static double hob_tip_radius(const struct trial *t, int i) {
    const double given = t->search->macro.ranges.gears[i].hob_tip_radius;
    if (given >= 0)
        return given;
    const double widest = (M_PI * t->module / 4 - t->addendum[i] * t->tangent) * t->cosine / (1 - t->sine);
    return fmin(widest * (1 - 1e-9), t->reference[i] - t->root[i]);
}

static bool hobs_fit(struct trial *t) {
    for (int i = 0; i < 2; i++) {
        t->addendum[i] = t->reference[i] + t->shift[i] - t->root[i];
        const double rho = t->hob_tip[i] = hob_tip_radius(t, i);
        const double flat = M_PI * t->module / 4 - (t->addendum[i] - rho) * t->tangent - rho / t->cosine;
        if (!(t->addendum[i] > 0 && rho >= 0 && flat >= 0))
            return false;
    }
    return true;
}

static bool flanks_stay_whole(struct trial *t) {
    for (int i = 0; i < 2; i++) {
        const double depth = t->reference[i] - t->root[i] - t->hob_tip[i] * (1 - t->sine);
        t->remaining[i] = t->reference[i] * t->sine - depth / t->sine;
        if (!(t->remaining[i] >= 0))
            return false;
    }
    return true;
}

static bool tips_are_outside(struct trial *t) {
    for (int i = 0; i < 2; i++)
        if (!(t->outside[i] > fmax(hypot(t->base[i], t->remaining[i]), t->root[i])))
            return false;
    return true;
}

static bool tips_are_thick(struct trial *t) {
    const double needed = t->search->macro.limits.tip_thickness * t->module;
    for (int i = 0; i < 2; i++) {
        const double at_tip = acos(t->base[i] / t->outside[i]);
        const double half_angle = (M_PI * t->module / 4 + t->shift[i] * t->tangent) / t->reference[i] +
                                  (t->tangent - t->angle) - (tan(at_tip) - at_tip);
        const double thickness = 2 * t->outside[i] * half_angle;
        if (!(thickness > 0 && thickness >= needed))
            return false;
    }
    return true;
}

/* Length of the tangent from a tip to its gear's base circle. */
static double tip_tangent(const struct trial *t, int i) {
    return sqrt(t->outside[i] * t->outside[i] - t->base[i] * t->base[i]);
}

static bool tips_do_not_interfere(struct trial *t) {
    const double line = t->search->initial.center_distance * t->working_sine;
    return line - tip_tangent(t, QG_GEAR) >= t->remaining[QG_PINION] &&
           line - tip_tangent(t, QG_PINION) >= t->remaining[QG_GEAR];
}

static bool contact_ratio_is_within(struct trial *t) {
    const double line = t->search->initial.center_distance * t->working_sine;
    const double ratio = (tip_tangent(t, QG_PINION) + tip_tangent(t, QG_GEAR) - line) / (M_PI * t->module * t->cosine);
    return ratio >= 1 && ratio <= 5;
}

/* The trial as a pair; all must be drawn. */
static void make_pair(struct trial *t) {
    t->pair = t->search->initial;
    t->pair.rack = (struct qg_rack){t->module, t->angle};
    for (int i = 0; i < 2; i++) {
        struct qg_gear *gear = &t->pair.gears[i];
        gear->teeth = (int)t->teeth[i];
        gear->profile_shift = t->shift[i];
        gear->outside_radius = t->outside[i];
        gear->root_radius = t->root[i];
        gear->hob_tip_radius = t->hob_tip[i];
    }
}

static bool pair_can_run(struct trial *t) {
    make_pair(t);
    return qg_pair_derive(&t->pair, &t->geometry, NULL) == QG_OK;
}

static bool rating_has_a_value(struct trial *t) {
    const struct qg_macro_rating *initial = &t->search->initial_rating;
    if (qg_macro_rate(&t->pair, &t->geometry, &t->rating) != QG_OK)
        return false;
    t->rating.contact_stress /= initial->contact_stress;
    t->rating.root_stress /= initial->root_stress;
    return true;
}

static bool contact_stress_is_kept(struct trial *t) {
    return t->rating.contact_stress <= t->search->macro.limits.contact_stress_factor;
}

static bool root_stress_is_kept(struct trial *t) {
    return t->rating.root_stress <= t->search->macro.limits.root_stress_factor;
}

typedef bool trial_test(struct trial *t);
static trial_test *const tests[QG_MACRO_CONSTRAINTS] = {
    [QG_MACRO_RATIO] = ratio_is_kept,
    [QG_MACRO_CENTER_DISTANCE] = base_circles_fit,
    [QG_MACRO_BACKLASH] = backlash_is_within,
    [QG_MACRO_TIP_CLEARANCE] = tips_are_clear,
    [QG_MACRO_HOB] = hobs_fit,
    [QG_MACRO_UNDERCUT] = flanks_stay_whole,
    [QG_MACRO_TOOTH] = tips_are_outside,
    [QG_MACRO_TIP_THICKNESS] = tips_are_thick,
    [QG_MACRO_INTERFERENCE] = tips_do_not_interfere,
    [QG_MACRO_CONTACT_RATIO] = contact_ratio_is_within,
    [QG_MACRO_BODY] = pair_can_run,
    [QG_MACRO_RATING] = rating_has_a_value,
    [QG_MACRO_CONTACT_STRESS] = contact_stress_is_kept,
    [QG_MACRO_ROOT_STRESS] = root_stress_is_kept,
};

/* The first test from `from` on that the trial does not pass. */
static enum qg_macro_constraint first_failed(struct trial *t, enum qg_macro_constraint from) {
    enum qg_macro_constraint constraint = from;
    while (constraint < QG_MACRO_CONSTRAINTS && tests[constraint](t))
        constraint++;
    return constraint;
}

static struct qg_macro_point point_of(const struct trial *t) {
    const struct qg_gear *pinion = &t->pair.gears[QG_PINION], *gear = &t->pair.gears[QG_GEAR];
    return (struct qg_macro_point){.sample = t->sample,
                                   .contact_ratio = t->geometry.contact_ratio,
                                   .contact_stress = t->rating.contact_stress,
                                   .root_stress = t->rating.root_stress,
                                   .parameter = {pinion->teeth, gear->teeth, t->pair.rack.module, t->pressure_angle_deg,
                                                 pinion->profile_shift, gear->profile_shift, pinion->outside_radius,
                                                 gear->outside_radius, pinion->root_radius, gear->root_radius}};
}

/* ---- searches --------------------------------------------------------------------------------------------------- */

enum qg_status qg_macro_search_init(struct qg_macro_search *search, const struct qg_macro *macro,
                                    const struct qg_gear_pair *initial, const struct qg_pair_geometry *geometry) {
    *search = (struct qg_macro_search){.macro = *macro, .initial = *initial};
    search->teeth = (struct qg_teeth_draw){.seed = macro->seed, .share = macro->limits.ratio_percent / 100};
    for (int i = 0; i < 2; i++) {
        const struct qg_interval *teeth = &macro->ranges.gears[i].teeth;
        assert(teeth->low >= 1 && teeth->high >= teeth->low && teeth->high <= 1000);
        search->teeth.low[i] = (uint32_t)teeth->low;
        search->teeth.count[i] = (uint32_t)(teeth->high - teeth->low) + 1;
        search->teeth.initial[i] = initial->gears[i].teeth;
    }
    return qg_macro_rate(initial, geometry, &search->initial_rating);
}

struct qg_gear_pair qg_macro_sample(const struct qg_macro_search *search, uint64_t sample, double *pressure_angle_deg) {
    struct trial t = {.search = search, .sample = sample};
    draw_teeth(&t);
    draw_rack(&t);
    draw_shifts(&t);
    for (int i = 0; i < 2; i++)
        draw_tip(&t, i);
    for (int i = 0; i < 2; i++) {
        t.addendum[i] = t.reference[i] + t.shift[i] - t.root[i];
        t.hob_tip[i] = hob_tip_radius(&t, i);
    }
    make_pair(&t);
    if (pressure_angle_deg)
        *pressure_angle_deg = t.pressure_angle_deg;
    return t.pair;
}

enum qg_macro_constraint qg_macro_test(const struct qg_macro_search *search, uint64_t sample,
                                       struct qg_macro_point *point) {
    struct trial t = {.search = search, .sample = sample};
    draw_teeth(&t);
    const enum qg_macro_constraint failed = first_failed(&t, 0);
    if (failed == QG_MACRO_CONSTRAINTS)
        *point = point_of(&t);
    return failed;
}

/* ---- blocks ----------------------------------------------------------------------------------------------------- */

size_t qg_macro_blocks(const struct qg_macro *macro) {
    return (size_t)((macro->samples + QG_MACRO_BLOCK - 1) / QG_MACRO_BLOCK);
}

enum qg_batch_path qg_macro_best_path(void) {
    enum qg_batch_path path = QG_PATH_COUNT - 1;
    while (!qg_batch_path_available(path))
        path--;
    return path;
}

/* A sample that has kept the ratio: the other tests. */
static void test_hit(const struct qg_macro_search *search, uint64_t sample, const uint16_t teeth[2],
                     struct qg_macro_tally *tally) {
    struct trial t;
    t.search = search;
    t.sample = sample;
    t.teeth[0] = teeth[0];
    t.teeth[1] = teeth[1];
    const enum qg_macro_constraint failed = first_failed(&t, QG_MACRO_RATIO + 1);
    if (failed < QG_MACRO_CONSTRAINTS) {
        tally->samples++;
        tally->rejected[failed]++;
    } else {
        const struct qg_macro_point point = point_of(&t);
        qg_macro_tally_add(tally, &point);
    }
}

void qg_macro_block_run(const struct qg_macro_block *block, enum qg_batch_path path, struct qg_macro_tally *tally) {
    enum { STEP = 4096 };
    static_assert(QG_MACRO_BLOCK % STEP == 0 && STEP % QG_TEETH_STEP == 0, "steps fill blocks");
    const struct qg_macro_search *s = block->search;
    struct qg_teeth_hit hits[STEP];
    const uint64_t begin = block->number * QG_MACRO_BLOCK, left = s->macro.samples - begin;
    const uint64_t end = begin + (left < QG_MACRO_BLOCK ? left : QG_MACRO_BLOCK);
    assert(begin < s->macro.samples);
    qg_macro_tally_init(tally, s->macro.keep);
    for (uint64_t at = begin; at < end && !(block->cancelled && block->cancelled(block->self)); at += STEP) {
        const uint64_t samples = end - at < STEP ? end - at : STEP;
        const size_t count = qg_teeth_hits(path, &s->teeth, at, STEP, hits);
        uint64_t tested = 0;
        for (; tested < count && hits[tested].sample < samples; tested++)
            test_hit(s, at + hits[tested].sample, hits[tested].teeth, tally);
        tally->samples += samples - tested;
        tally->rejected[QG_MACRO_RATIO] += samples - tested;
    }
}

size_t qg_teeth_hits(enum qg_batch_path path, const struct qg_teeth_draw *draw, uint64_t first, size_t n,
                     struct qg_teeth_hit *hits) {
    assert(qg_batch_path_available(path) && first % QG_TEETH_STEP == 0 && n % QG_TEETH_STEP == 0);
    if (path == QG_PATH_AVX512)
        return qg_teeth_hits_avx512(draw, first, n, hits);
    if (path == QG_PATH_AVX2)
        return qg_teeth_hits_avx2(draw, first, n, hits);
    return qg_teeth_hits_baseline(draw, first, n, hits);
}
