/* Macro-geometry: the lean tests say what gear.h, pair.h and iso6336.h say, samples are the same on every path, what is
 * kept is the best and the front, and case S leads to pairs of a contact ratio above 2. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/iso6336.h"
#include "core/macro_sample.h"
#include "core/random.h"

static const struct qg_interval not_given = {NAN, NAN};
static const double as_large_as_fits = -1;

/* A search from a pair with the defaults of the job document. */
static struct qg_macro default_macro(void) {
    struct qg_macro macro = {.samples = 1000, .seed = 1, .keep = 10};
    macro.ranges.module = macro.ranges.pressure_angle_deg = not_given;
    for (int i = 0; i < 2; i++) {
        macro.ranges.gears[i].teeth = macro.ranges.gears[i].profile_shift = not_given;
        macro.ranges.gears[i].outside_radius = macro.ranges.gears[i].root_radius = not_given;
        macro.ranges.gears[i].hob_tip_radius = as_large_as_fits;
    }
    macro.limits = (struct qg_macro_limits){.ratio_percent = 1,
                                            .backlash = not_given,
                                            .tip_thickness = 0.4,
                                            .tip_clearance = 0.25,
                                            .contact_stress_factor = 1,
                                            .root_stress_factor = 1};
    return macro;
}

/* Ranges that hold a single pair. */
static void fix_to(struct qg_macro *macro, const struct qg_gear_pair *pair, double pressure_angle_deg) {
    macro->ranges.module = (struct qg_interval){pair->rack.module, pair->rack.module};
    macro->ranges.pressure_angle_deg = (struct qg_interval){pressure_angle_deg, pressure_angle_deg};
    for (int i = 0; i < 2; i++) {
        const struct qg_gear *g = &pair->gears[i];
        macro->ranges.gears[i].teeth = (struct qg_interval){g->teeth, g->teeth};
        macro->ranges.gears[i].profile_shift = (struct qg_interval){g->profile_shift, g->profile_shift};
        macro->ranges.gears[i].outside_radius = (struct qg_interval){g->outside_radius, g->outside_radius};
        macro->ranges.gears[i].root_radius = (struct qg_interval){g->root_radius, g->root_radius};
        macro->ranges.gears[i].hob_tip_radius = g->hob_tip_radius;
    }
}

static struct qg_macro_search make_search(struct qg_macro macro, const struct qg_gear_pair *initial) {
    struct qg_pair_geometry geometry;
    struct qg_macro_search search;
    struct qg_notes notes = {0};
    assert_int_equal(qg_pair_derive(initial, &geometry, NULL), QG_OK);
    qg_macro_complete(&macro, initial, geometry.backlash);
    qg_macro_check(&macro, initial, &geometry, &notes);
    if (notes.count > 0)
        fail_msg("%s: %s", notes.item[0].where, notes.item[0].text);
    assert_int_equal(qg_macro_search_init(&search, &macro, initial, &geometry), QG_OK);
    return search;
}

/* Ranges about case S in which most samples get beyond the first tests. */
static struct qg_macro narrow_macro(void) {
    struct qg_macro macro = default_macro();
    macro.ranges.module = (struct qg_interval){1.8, 2.3};
    macro.ranges.pressure_angle_deg = (struct qg_interval){16, 20};
    macro.ranges.gears[QG_PINION].teeth = (struct qg_interval){38, 47};
    macro.ranges.gears[QG_GEAR].teeth = (struct qg_interval){58, 72};
    macro.ranges.gears[QG_PINION].profile_shift = (struct qg_interval){-1, 1};
    macro.ranges.gears[QG_GEAR].profile_shift = (struct qg_interval){-2.5, 0.5};
    macro.ranges.gears[QG_PINION].outside_radius = (struct qg_interval){46.4, 47.6};
    macro.ranges.gears[QG_GEAR].outside_radius = (struct qg_interval){68.8, 70.4};
    macro.ranges.gears[QG_PINION].root_radius = (struct qg_interval){39.9, 41.1};
    macro.ranges.gears[QG_GEAR].root_radius = (struct qg_interval){62.4, 63.6};
    return macro;
}

/* ---- tooth numbers ------------------------------------------------------------------------------------------------ */

/* The hits of all paths against tooth numbers drawn one by one from the bare generator. */
static void test_paths_draw_the_same_teeth(void **state) {
    (void)state;
    enum { N = 4096 };
    static struct qg_teeth_hit hits[N];
    const struct qg_gear_pair s = CASE_S;
    const struct qg_teeth_draw draw = {
        .seed = UINT64_C(0x123456789abcdef), .low = {17, 26}, .count = {34, 52}, .initial = {28, 43}, .share = 0.05};
    const uint64_t first = (UINT64_C(1) << 33) - 2048; /* the upper word of the counter changes on the way */
    for (enum qg_batch_path path = 0; path < QG_PATH_COUNT; path++) {
        if (!qg_batch_path_available(path))
            continue;
        const size_t count = qg_teeth_hits(path, &draw, first, N, hits);
        size_t next = 0;
        for (uint32_t i = 0; i < N; i++) {
            const uint64_t block = (first + i) / 2;
            const uint32_t key[2] = {(uint32_t)draw.seed, (uint32_t)(draw.seed >> 32)};
            uint32_t w[4] = {(uint32_t)block, (uint32_t)(block >> 32), 0, QG_STREAM_MACRO << 16}, z[2];
            qg_philox(w, key);
            for (size_t g = 0; g < 2; g++)
                z[g] = draw.low[g] + (uint32_t)((double)w[2 * (i % 2) + g] / 0x1p32 * draw.count[g]);
            if (!qg_macro_ratio_is_kept(z[0], z[1], &s, 5))
                continue;
            assert_true(next < count);
            assert_int_equal(hits[next].sample, i);
            assert_int_equal(hits[next].teeth[0], z[0]);
            assert_int_equal(hits[next].teeth[1], z[1]);
            next++;
        }
        assert_int_equal(next, count);
        assert_true(count > 100 && count < N / 4);
    }
}

/* Every number of the ten is uniform within its range: mean and variance of many. */
static void test_parameters_are_uniform(void **state) {
    (void)state;
    enum { N = 20000, PARAMETERS = 10 };
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro macro = default_macro();
    const struct qg_macro_search search = make_search(macro, &s);
    const struct qg_macro_ranges *r = &search.macro.ranges;
    double sum[PARAMETERS] = {0}, squares[PARAMETERS] = {0};
    for (uint64_t i = 0; i < N; i++) {
        double angle;
        const struct qg_gear_pair p = qg_macro_sample(&search, i, &angle);
        const struct qg_gear *a = &p.gears[0], *b = &p.gears[1];
        const double value[PARAMETERS] = {p.rack.module,     angle,
                                          a->teeth,          b->teeth,
                                          a->profile_shift,  b->profile_shift,
                                          a->outside_radius, b->outside_radius,
                                          a->root_radius,    b->root_radius};
        const struct qg_interval *range[PARAMETERS] = {
            &r->module,
            &r->pressure_angle_deg,
            &r->gears[0].teeth,
            &r->gears[1].teeth,
            &r->gears[0].profile_shift,
            &r->gears[1].profile_shift,
            &r->gears[0].outside_radius,
            &r->gears[1].outside_radius,
            &r->gears[0].root_radius,
            &r->gears[1].root_radius,
        };
        for (int k = 0; k < PARAMETERS; k++) {
            const double u = (value[k] - range[k]->low) / (range[k]->high - range[k]->low);
            assert_true(u >= 0 && u <= 1);
            sum[k] += u;
            squares[k] += u * u;
        }
        assert_true(p.rack.pressure_angle == angle * (M_PI / 180));
        assert_true(p.center_distance == s.center_distance && a->face_width == s.gears[0].face_width);
    }
    for (int k = 0; k < PARAMETERS; k++) { /* five standard errors: sqrt(1/12/N) and sqrt(4/45/N); 34 steps of teeth */
        const bool whole = k == 2 || k == 3;
        assert_near(sum[k] / N, 0.5, 5 * sqrt(1.0 / 12 / N));
        assert_near(squares[k] / N, 1.0 / 3, 5 * sqrt(4.0 / 45 / N) + (whole ? 0.006 : 0));
    }
}

/* ---- lean against full -------------------------------------------------------------------------------------------- */

static bool is_noted(const struct qg_notes *notes, const char *word) {
    for (size_t i = 0; i < notes->count; i++)
        if (strstr(notes->item[i].text, word))
            return true;
    return false;
}

/* A sample derived and rated like any pair. */
struct full {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_notes notes;
    enum qg_status derived, rated;
    double contact, root; /* shares of the initial pair's */
};

static struct full full_of(const struct qg_macro_search *s, uint64_t sample) {
    struct full f = {.pair = qg_macro_sample(s, sample, NULL), .rated = QG_NO_CONVERGENCE};
    struct qg_iso6336 iso, iso0;
    struct qg_pair_geometry g0;
    f.derived = qg_pair_derive(&f.pair, &f.geometry, &f.notes);
    if (f.derived != QG_OK)
        return f;
    qg_pair_derive(&s->initial, &g0, NULL);
    qg_iso6336_rate(&s->initial, &g0, s->initial.nominal_torque, &iso0);
    f.rated = qg_iso6336_rate(&f.pair, &f.geometry, f.pair.nominal_torque, &iso);
    f.contact =
        fmax(iso.contact_stress[0], iso.contact_stress[1]) / fmax(iso0.contact_stress[0], iso0.contact_stress[1]);
    f.root = fmax(iso.root_stress[0], iso.root_stress[1]) / fmax(iso0.root_stress[0], iso0.root_stress[1]);
    return f;
}

static double least(double a, double b) {
    return a < b ? a : b;
}

static double least_tip_clearance(const struct qg_gear_pair *p) {
    return least(p->center_distance - p->gears[0].outside_radius - p->gears[1].root_radius,
                 p->center_distance - p->gears[1].outside_radius - p->gears[0].root_radius);
}

static double sum_of_base_radii(const struct qg_gear_pair *p) {
    return p->rack.module / 2 * (p->gears[0].teeth + p->gears[1].teeth) * cos(p->rack.pressure_angle);
}

/* What two teeth leave of the working pitch, along the line of action; also for pairs that are not derived. */
static double backlash_of(const struct qg_gear_pair *p) {
    const double m = p->rack.module, cosine = sum_of_base_radii(p) / p->center_distance;
    double left = 0;
    for (int i = 0; i < 2; i++) {
        const struct qg_gear *gear = &p->gears[i];
        const struct qg_gear_geometry g = {.reference_radius = m * gear->teeth / 2,
                                           .base_radius = m * gear->teeth / 2 * cos(p->rack.pressure_angle),
                                           .tooth_thickness =
                                               M_PI * m / 2 + 2 * gear->profile_shift * tan(p->rack.pressure_angle)};
        left += 2 * g.base_radius / cosine * qg_half_tooth_angle(&p->rack, &g, g.base_radius / cosine);
    }
    return M_PI * m * cos(p->rack.pressure_angle) - left * cosine;
}

/* Whether a full pair satisfies everything. */
static bool full_passes(const struct qg_macro_search *s, const struct full *f) {
    const struct qg_macro_limits *l = &s->macro.limits;
    const double m = f->pair.rack.module;
    return qg_macro_ratio_is_kept(f->pair.gears[0].teeth, f->pair.gears[1].teeth, &s->initial, l->ratio_percent) &&
           f->derived == QG_OK && f->geometry.backlash >= l->backlash.low && f->geometry.backlash <= l->backlash.high &&
           least_tip_clearance(&f->pair) >= l->tip_clearance * m &&
           least(f->geometry.gears[0].tip_thickness, f->geometry.gears[1].tip_thickness) >= l->tip_thickness * m &&
           f->rated == QG_OK && f->contact <= l->contact_stress_factor && f->root <= l->root_stress_factor;
}

/* Whether the full pair violates the constraint that the lean tests name. */
static bool full_confirms(const struct qg_macro_search *s, const struct full *f, enum qg_macro_constraint c) {
    const struct qg_macro_limits *l = &s->macro.limits;
    const struct qg_pair_geometry *g = &f->geometry;
    const double m = f->pair.rack.module;
    switch (c) {
    case QG_MACRO_RATIO:
        return !qg_macro_ratio_is_kept(f->pair.gears[0].teeth, f->pair.gears[1].teeth, &s->initial, l->ratio_percent);
    case QG_MACRO_CENTER_DISTANCE:
        return !(sum_of_base_radii(&f->pair) < f->pair.center_distance);
    case QG_MACRO_BACKLASH:
        return !(backlash_of(&f->pair) >= l->backlash.low && backlash_of(&f->pair) <= l->backlash.high);
    case QG_MACRO_TIP_CLEARANCE:
        return least_tip_clearance(&f->pair) < l->tip_clearance * m;
    case QG_MACRO_HOB:
        return is_noted(&f->notes, "would not reach") || is_noted(&f->notes, "does not fit") ||
               note_about(&f->notes, "pinion.hob_tip_radius") || note_about(&f->notes, "gear.hob_tip_radius");
    case QG_MACRO_UNDERCUT:
        return is_noted(&f->notes, "undercut");
    case QG_MACRO_TOOTH:
        return is_noted(&f->notes, "must be above the form radius");
    case QG_MACRO_TIP_THICKNESS:
        return least(g->gears[0].tip_thickness, g->gears[1].tip_thickness) < l->tip_thickness * m;
    case QG_MACRO_INTERFERENCE:
        return is_noted(&f->notes, "interference");
    case QG_MACRO_CONTACT_RATIO:
        return is_noted(&f->notes, "contact ratio");
    case QG_MACRO_BODY:
        return f->derived != QG_OK && is_noted(&f->notes, "rim below the root");
    case QG_MACRO_RATING:
        return f->derived == QG_OK && f->rated != QG_OK;
    case QG_MACRO_CONTACT_STRESS:
        return f->contact > l->contact_stress_factor;
    default:
        return f->root > l->root_stress_factor;
    }
}

/* Same verdict for every sample; counts what was met. */
static void compare(const struct qg_macro_search *s, uint64_t samples, size_t met[QG_MACRO_CONSTRAINTS + 1]) {
    for (uint64_t i = 0; i < samples; i++) {
        struct qg_macro_point point;
        const enum qg_macro_constraint verdict = qg_macro_test(s, i, &point);
        const struct full f = full_of(s, i);
        met[verdict]++;
        if ((verdict == QG_MACRO_CONSTRAINTS) != full_passes(s, &f))
            fail_msg("sample %llu: lean %s", (unsigned long long)i,
                     verdict == QG_MACRO_CONSTRAINTS ? "passes" : qg_macro_constraint_name(verdict));
        if (verdict < QG_MACRO_CONSTRAINTS && !full_confirms(s, &f, verdict))
            fail_msg("sample %llu: %s is not confirmed: %s", (unsigned long long)i, qg_macro_constraint_name(verdict),
                     f.notes.count ? f.notes.item[0].text : "nothing noted");
        if (verdict == QG_MACRO_CONSTRAINTS) {
            assert_true(point.contact_ratio == f.geometry.contact_ratio);
            assert_true(point.contact_stress == f.contact && point.root_stress == f.root && point.sample == i);
        }
    }
}

static void test_lean_tests_say_what_the_full_ones_say(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    size_t met[QG_MACRO_CONSTRAINTS + 1] = {0};
    struct qg_macro macro = narrow_macro();
    macro.limits.ratio_percent = 3;
    macro.limits.backlash = (struct qg_interval){0.05, 3};
    macro.limits.contact_stress_factor = 1.05;
    struct qg_macro_search search = make_search(macro, &s);
    compare(&search, 30000, met);

    /* Given roundings, long teeth, a bore in the way. */
    struct qg_gear_pair bored = s;
    bored.gears[QG_PINION].bore_diameter = 76;
    macro.ranges.gears[QG_PINION].root_radius = (struct qg_interval){38.2, 41};
    macro.ranges.gears[QG_PINION].hob_tip_radius = 0.5;
    macro.ranges.gears[QG_GEAR].hob_tip_radius = 0.2;
    macro.ranges.gears[QG_PINION].profile_shift = (struct qg_interval){-2.5, 0.5};
    macro.ranges.gears[QG_PINION].outside_radius = (struct qg_interval){44, 47.5};
    macro.ranges.gears[QG_GEAR].outside_radius = (struct qg_interval){65, 70.5};
    macro.ranges.gears[QG_GEAR].profile_shift = (struct qg_interval){-2, 2};
    search = make_search(macro, &bored);
    compare(&search, 40000, met);

    /* Few teeth: undercut, tips that hit roots' flanks. */
    macro = default_macro();
    macro.ranges.gears[QG_PINION].teeth = (struct qg_interval){10, 20};
    macro.ranges.gears[QG_GEAR].teeth = (struct qg_interval){16, 32};
    macro.ranges.module = (struct qg_interval){4, 8};
    macro.ranges.gears[QG_PINION].outside_radius = (struct qg_interval){44, 56};
    macro.ranges.gears[QG_GEAR].outside_radius = (struct qg_interval){66, 78};
    macro.ranges.gears[QG_PINION].root_radius = (struct qg_interval){30, 42};
    macro.ranges.gears[QG_GEAR].root_radius = (struct qg_interval){52, 64};
    macro.limits.backlash = (struct qg_interval){0, 4};
    macro.limits.ratio_percent = 10;
    macro.limits.tip_thickness = macro.limits.tip_clearance = 0;
    search = make_search(macro, &s);
    compare(&search, 40000, met);

    /* Case B, of ratio 1, with wide limits. */
    const struct qg_gear_pair b = CASE_B;
    macro = default_macro();
    macro.limits.ratio_percent = 50;
    macro.limits.backlash = (struct qg_interval){0, 10};
    search = make_search(macro, &b);
    compare(&search, 20000, met);
    for (int c = 0; c <= QG_MACRO_CONSTRAINTS; c++)
        if (met[c] == 0 && c != QG_MACRO_RATING)
            fail_msg("no sample was rejected for %s",
                     c < QG_MACRO_CONSTRAINTS ? qg_macro_constraint_name(c) : "nothing");
}

/* ---- known pairs -------------------------------------------------------------------------------------------------- */

static void test_the_initial_pair_is_its_own_equivalent(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro macro = default_macro();
    struct qg_pair_geometry g;
    qg_pair_derive(&s, &g, NULL);
    fix_to(&macro, &s, 20);
    macro.limits.ratio_percent = 0;
    macro.limits.backlash = (struct qg_interval){g.backlash - 1e-9, g.backlash + 1e-9};
    const struct qg_macro_search search = make_search(macro, &s);
    struct qg_macro_tally tally;
    const struct qg_macro_block block = {.search = &search};
    qg_macro_block_run(&block, qg_macro_best_path(), &tally);
    assert_int_equal(tally.passed, 1000);
    assert_true(tally.best[0].contact_stress == 1 && tally.best[0].root_stress == 1);
    assert_true(tally.best[0].contact_ratio == g.contact_ratio);
    assert_true(tally.best_count == 1 && tally.best[0].sample == 0); /* of equal geometries the first */
    assert_true(tally.front_count == 1 && tally.front_dropped == 0);
}

/* Case H is what the paper's search found from case S; by ISO 6336 it bears 9 and 19 % more stress. */
static void test_case_H_is_found_when_stress_may_grow(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S, h = CASE_H;
    struct qg_macro macro = default_macro();
    struct qg_macro_point point;
    fix_to(&macro, &h, 18);
    struct qg_macro_search search = make_search(macro, &s);
    assert_int_equal(qg_macro_test(&search, 5, &point), QG_MACRO_CONTACT_STRESS);
    macro.limits.contact_stress_factor = macro.limits.root_stress_factor = 1.2;
    search = make_search(macro, &s);
    assert_int_equal(qg_macro_test(&search, 5, &point), QG_MACRO_CONSTRAINTS);
    assert_near(point.contact_ratio, 2.0063, 5e-5);
}

/* The largest rounding leaves the hob's tip no flat, or lies with its centre on the rolling line. */
static void test_largest_hob_tips_fit(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    const struct qg_macro_search search = make_search(narrow_macro(), &s);
    size_t full_tips = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        const struct qg_gear_pair p = qg_macro_sample(&search, i, NULL);
        for (int k = 0; k < 2; k++) {
            struct qg_gear_geometry g;
            struct qg_notes notes = {0};
            if (!(p.gears[k].hob_tip_radius > 0))
                continue;
            qg_gear_derive(&p.rack, &p.gears[k], 7.85e-6, "", &g, &notes);
            assert_null(note_about(&notes, "hob_tip_radius"));
            assert_true(fabs(g.hob_tip_center_offset) < 1e-8 || fabs(g.hob_tip_center_depth) < 1e-12);
            full_tips++;
        }
    }
    assert_true(full_tips > 2000); /* of 6000; the other hobs have no room at all */
}

/* ---- blocks ------------------------------------------------------------------------------------------------------- */

static bool same_points(const struct qg_macro_point *a, const struct qg_macro_point *b, size_t n) {
    return memcmp(a, b, n * sizeof *a) == 0;
}

/* A block is its samples one by one, on any path; a search ends where it should. */
static void test_blocks_are_their_samples(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro macro = narrow_macro();
    macro.samples = QG_MACRO_BLOCK + 150001;
    macro.limits.backlash = (struct qg_interval){0.05, 3};
    const struct qg_macro_search search = make_search(macro, &s);
    static struct qg_macro_tally plain, tally;
    assert_int_equal(qg_macro_blocks(&macro), 2);
    qg_macro_tally_init(&plain, macro.keep);
    for (uint64_t i = QG_MACRO_BLOCK; i < macro.samples; i++) {
        struct qg_macro_point point;
        const enum qg_macro_constraint failed = qg_macro_test(&search, i, &point);
        if (failed == QG_MACRO_CONSTRAINTS) {
            qg_macro_tally_add(&plain, &point);
        } else {
            plain.samples++;
            plain.rejected[failed]++;
        }
    }
    assert_true(plain.passed > 20);
    const struct qg_macro_block block = {.search = &search, .number = 1};
    for (enum qg_batch_path path = 0; path < QG_PATH_COUNT; path++) {
        if (!qg_batch_path_available(path))
            continue;
        qg_macro_block_run(&block, path, &tally);
        assert_int_equal(tally.samples, 150001);
        assert_int_equal(tally.passed, plain.passed);
        assert_memory_equal(tally.rejected, plain.rejected, sizeof plain.rejected);
        assert_int_equal(tally.best_count, plain.best_count);
        assert_int_equal(tally.front_count, plain.front_count);
        assert_true(same_points(tally.best, plain.best, plain.best_count));
        assert_true(same_points(tally.front, plain.front, plain.front_count));
    }
}

static bool always(void *self) {
    (void)self;
    return true;
}

static void test_a_cancelled_block_stops(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    const struct qg_macro_search search = make_search(narrow_macro(), &s);
    static struct qg_macro_tally tally;
    const struct qg_macro_block block = {.search = &search, .cancelled = always};
    qg_macro_block_run(&block, qg_macro_best_path(), &tally);
    assert_int_equal(tally.samples, 0);
}

/* From case S: pairs of a contact ratio of 2 and more with no more stress than case S. */
static void test_case_S_leads_to_high_contact_ratios(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro macro = narrow_macro();
    macro.samples = 6 * QG_MACRO_BLOCK;
    macro.limits.backlash = not_given;
    const struct qg_macro_search search = make_search(macro, &s);
    static struct qg_macro_tally all, one;
    qg_macro_tally_init(&all, macro.keep);
    for (size_t i = 0; i < qg_macro_blocks(&macro); i++) {
        const struct qg_macro_block block = {.search = &search, .number = i};
        qg_macro_block_run(&block, qg_macro_best_path(), &one);
        qg_macro_tally_merge(&all, &one);
    }
    uint64_t sum = all.passed;
    for (int c = 0; c < QG_MACRO_CONSTRAINTS; c++)
        sum += all.rejected[c];
    assert_true(sum == macro.samples && all.samples == macro.samples);
    assert_int_equal(all.best_count, macro.keep);
    for (size_t i = 0; i < all.best_count; i++) {
        const struct full f = full_of(&search, all.best[i].sample);
        assert_true(full_passes(&search, &f));
        assert_true(f.geometry.contact_ratio >= 2 && f.contact <= 1 && f.root <= 1);
    }
}

/* ---- what is kept ------------------------------------------------------------------------------------------------- */

static struct qg_macro_point random_point(struct dice *dice, uint64_t sample) {
    return (struct qg_macro_point){.sample = sample,
                                   .contact_ratio = dice_integer(dice, 100, 300) / 100.0,
                                   .contact_stress = dice_integer(dice, 50, 120) / 100.0,
                                   .root_stress = dice_integer(dice, 50, 120) / 100.0,
                                   .parameter = {(double)sample}};
}

static bool is_on_front(const struct qg_macro_point *points, size_t n, const struct qg_macro_point *p) {
    for (size_t i = 0; i < n; i++) {
        const double s = qg_macro_stress(&points[i]), mine = qg_macro_stress(p);
        if (points[i].contact_ratio >= p->contact_ratio && s <= mine &&
            (points[i].contact_ratio > p->contact_ratio || s < mine))
            return false;
    }
    return true;
}

/* Best and front of points with many equals, against looking at all pairs; in one go and merged. */
static void test_best_and_front_are_those_of_all_points(void **state) {
    (void)state;
    enum { N = 600, KEEP = 12 };
    static struct qg_macro_tally whole, part, merged;
    struct dice dice = {7};
    for (int round = 0; round < 20; round++) {
        struct qg_macro_point points[N];
        qg_macro_tally_init(&whole, KEEP);
        qg_macro_tally_init(&merged, KEEP);
        for (size_t i = 0; i < N; i++) {
            if (i % 100 == 0)
                qg_macro_tally_init(&part, KEEP);
            points[i] = random_point(&dice, i);
            qg_macro_tally_add(&whole, &points[i]);
            qg_macro_tally_add(&part, &points[i]);
            if (i % 100 == 99)
                qg_macro_tally_merge(&merged, &part);
        }
        size_t on_front = 0;
        for (size_t i = 0; i < N; i++)
            if (is_on_front(points, N, &points[i])) {
                bool found = false;
                on_front++;
                for (size_t k = 0; k < whole.front_count; k++)
                    found = found || whole.front[k].sample == i;
                assert_true(found);
            }
        assert_int_equal(on_front, whole.front_count);
        for (size_t k = 0; k < KEEP; k++) { /* place k has k points before it */
            size_t before = 0;
            for (size_t i = 0; i < N; i++)
                before += points[i].contact_ratio > whole.best[k].contact_ratio ||
                          (points[i].contact_ratio == whole.best[k].contact_ratio && i < whole.best[k].sample);
            assert_int_equal(before, k);
        }
        assert_int_equal(merged.passed, N);
        assert_int_equal(merged.front_count, whole.front_count);
        assert_true(same_points(merged.best, whole.best, KEEP));
        assert_true(same_points(merged.front, whole.front, whole.front_count));
    }
}

/* Points of equal geometry are one, the first, in one go and merged; a single different parameter makes two. */
static void test_equal_geometries_are_kept_once(void **state) {
    (void)state;
    enum { N = 60, KEEP = 20, GEOMETRIES = 3 };
    static struct qg_macro_tally whole, part, merged;
    qg_macro_tally_init(&whole, KEEP);
    qg_macro_tally_init(&merged, KEEP);
    for (uint64_t i = 0; i < N; i++) {
        struct qg_macro_point p = {i, 2, 0.5, 0.5, {28, 43}};
        p.parameter[QG_MACRO_PARAMETERS - 1] = (double)(i / 5 % GEOMETRIES);
        if (i % 12 == 0)
            qg_macro_tally_init(&part, KEEP);
        qg_macro_tally_add(&whole, &p);
        qg_macro_tally_add(&part, &p);
        if (i % 12 == 11)
            qg_macro_tally_merge(&merged, &part);
    }
    assert_true(whole.passed == N && merged.passed == N);
    assert_true(whole.best_count == GEOMETRIES && whole.front_count == GEOMETRIES);
    for (uint64_t k = 0; k < GEOMETRIES; k++)
        assert_true(whole.best[k].sample == 5 * k && whole.front[k].sample == 5 * k);
    assert_true(merged.best_count == GEOMETRIES && merged.front_count == GEOMETRIES);
    assert_true(same_points(merged.best, whole.best, GEOMETRIES));
    assert_true(same_points(merged.front, whole.front, GEOMETRIES));
}

static void test_a_full_front_keeps_its_ends(void **state) {
    (void)state;
    enum { N = 1000, KEEP = 5 };
    static struct qg_macro_tally t;
    qg_macro_tally_init(&t, KEEP);
    for (uint64_t i = 0; i < N; i++) { /* all on the front, in a mixed order */
        const uint64_t k = i * 7 % N;
        const struct qg_macro_point p = {i, 1 + 0.001 * (double)k, 0.5 + 0.0005 * (double)k, 0.1, {(double)i}};
        qg_macro_tally_add(&t, &p);
    }
    assert_int_equal(t.front_count, QG_MACRO_FRONT_ROOM);
    assert_int_equal(t.front_dropped, N - QG_MACRO_FRONT_ROOM);
    assert_near(t.front[0].contact_ratio, 1.999, 1e-12);
    assert_near(t.front[QG_MACRO_FRONT_ROOM - 1].contact_ratio, 1, 1e-12);

    struct qg_macro_point out[2 * KEEP];
    bool on_front[2 * KEEP], among_best[2 * KEEP];
    const size_t n = qg_macro_tally_choose(&t, out, on_front, among_best);
    assert_int_equal(n, 2 * KEEP - 1); /* the first point is both */
    assert_true(on_front[0] && among_best[0] && on_front[n - 1] && !among_best[n - 1]);
    assert_near(out[n - 1].contact_ratio, 1, 1e-12);
    for (size_t i = 1; i < n; i++)
        assert_true(out[i].contact_ratio < out[i - 1].contact_ratio);
}

/* ---- defaults and checks ------------------------------------------------------------------------------------------ */

static void test_defaults_come_from_the_initial_pair(void **state) {
    (void)state;
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro macro = default_macro();
    macro.ranges.gears[QG_GEAR].profile_shift = (struct qg_interval){0, 0};
    qg_macro_complete(&macro, &s, 0.3);
    const struct qg_macro_ranges *r = &macro.ranges;
    assert_true(r->gears[QG_PINION].teeth.low == 17 && r->gears[QG_PINION].teeth.high == 50);
    assert_true(r->gears[QG_GEAR].teeth.low == 26 && r->gears[QG_GEAR].teeth.high == 77);
    assert_near(r->module.low, 1.5, 1e-12);
    assert_near(r->module.high, 3.6, 1e-12);
    assert_near(r->pressure_angle_deg.low, 14, 1e-12);
    assert_near(r->pressure_angle_deg.high, 26, 1e-12);
    assert_true(r->gears[QG_PINION].profile_shift.low == -3 && r->gears[QG_PINION].profile_shift.high == 3);
    assert_true(r->gears[QG_GEAR].profile_shift.low == 0 && r->gears[QG_GEAR].profile_shift.high == 0);
    assert_near(r->gears[QG_GEAR].outside_radius.low, 68.05, 1e-12);
    assert_near(r->gears[QG_GEAR].outside_radius.high, 71.05, 1e-12);
    assert_near(r->gears[QG_PINION].root_radius.low, 38.8, 1e-12);
    assert_near(r->gears[QG_PINION].root_radius.high, 41.8, 1e-12);
    assert_near(macro.limits.backlash.low, 0.24, 1e-12);
    assert_near(macro.limits.backlash.high, 0.36, 1e-12);
}

static void refused_at(const struct qg_macro *macro, const char *where) {
    const struct qg_gear_pair s = CASE_S;
    struct qg_macro completed = *macro;
    struct qg_pair_geometry geometry;
    struct qg_notes notes = {0};
    qg_pair_derive(&s, &geometry, NULL);
    qg_macro_complete(&completed, &s, geometry.backlash);
    assert_int_equal(qg_macro_check(&completed, &s, &geometry, &notes), QG_IMPOSSIBLE_GEAR);
    assert_non_null(note_about(&notes, where));
}

static void test_impossible_searches_are_refused(void **state) {
    (void)state;
    struct qg_macro macro = default_macro();
    macro.ranges.module = (struct qg_interval){3, 2};
    refused_at(&macro, "macro.ranges.module");
    macro = default_macro();
    macro.ranges.gears[QG_GEAR].teeth = (struct qg_interval){70, 77};
    macro.ranges.gears[QG_PINION].teeth = (struct qg_interval){20, 30};
    refused_at(&macro, "macro.ranges");
    macro = default_macro();
    macro.ranges.gears[QG_PINION].root_radius = (struct qg_interval){19, 20.5};
    refused_at(&macro, "macro.ranges.pinion.root_radius");
    macro = default_macro();
    macro.limits.backlash = (struct qg_interval){0.4, 0.3};
    refused_at(&macro, "macro.constraints.backlash");
}

static void test_constraints_have_names(void **state) {
    (void)state;
    assert_string_equal(qg_macro_constraint_name(QG_MACRO_RATIO), "ratio");
    assert_string_equal(qg_macro_constraint_name(QG_MACRO_ROOT_STRESS), "root_stress");
    assert_string_equal(qg_macro_constraint_text(QG_MACRO_TIP_THICKNESS), "tips thick enough");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_paths_draw_the_same_teeth),
        cmocka_unit_test(test_parameters_are_uniform),
        cmocka_unit_test(test_lean_tests_say_what_the_full_ones_say),
        cmocka_unit_test(test_the_initial_pair_is_its_own_equivalent),
        cmocka_unit_test(test_case_H_is_found_when_stress_may_grow),
        cmocka_unit_test(test_largest_hob_tips_fit),
        cmocka_unit_test(test_blocks_are_their_samples),
        cmocka_unit_test(test_a_cancelled_block_stops),
        cmocka_unit_test(test_case_S_leads_to_high_contact_ratios),
        cmocka_unit_test(test_best_and_front_are_those_of_all_points),
        cmocka_unit_test(test_equal_geometries_are_kept_once),
        cmocka_unit_test(test_a_full_front_keeps_its_ends),
        cmocka_unit_test(test_defaults_come_from_the_initial_pair),
        cmocka_unit_test(test_impossible_searches_are_refused),
        cmocka_unit_test(test_constraints_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
