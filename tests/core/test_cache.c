/* The cache of compliances: found by content, held while taken, dropped in order of last use. */
#include "tests/core/cases.h"

#include <stdlib.h>

#include "core/cache.h"

/* A compliance that only fills memory: flank_count 1, boundary m, reach 0, numbers that tell it apart. */
static struct qg_compliance filler(size_t m, double value) {
    struct qg_compliance c = {.flank_count = 1, .boundary = m};
    c.flank_arc = calloc(1, sizeof *c.flank_arc);
    c.flank = calloc(1, sizeof *c.flank);
    c.local = calloc(4, sizeof *c.local);
    c.response = calloc(2 * m, sizeof *c.response);
    c.ring = calloc(m * m, sizeof *c.ring);
    assert_true(c.flank_arc && c.flank && c.local && c.response && c.ring);
    c.local[0] = value;
    return c;
}

static struct qg_compliance_key key_of(int number) {
    const struct qg_gear_pair pair = CASE_S;
    struct qg_compliance_key key = {.rack = pair.rack, .gear = pair.gears[0], .refinement = 1, .reach = 6};
    key.plate = (struct qg_plate){206000, 0.3, 27, 0};
    key.gear.face_width = number;
    return key;
}

static const struct qg_compliance *keep(struct qg_cache *cache, int number, size_t m) {
    struct qg_compliance c = filler(m, number);
    const struct qg_compliance_key key = key_of(number);
    const struct qg_compliance *kept = qg_cache_keep(cache, &key, &c);
    assert_non_null(kept);
    assert_null(c.local); /* handed over */
    assert_true(kept->local[0] == number);
    return kept;
}

static const struct qg_compliance *take(struct qg_cache *cache, int number) {
    const struct qg_compliance_key key = key_of(number);
    return qg_cache_take(cache, &key);
}

static void what_was_kept_is_found(void **state) {
    (void)state;
    struct qg_cache *cache = qg_cache_create((size_t)1 << 20);
    assert_null(take(cache, 1));
    const struct qg_compliance *one = keep(cache, 1, 4), *two = keep(cache, 2, 4);
    assert_ptr_equal(take(cache, 1), one);
    assert_ptr_equal(take(cache, 2), two);
    struct qg_cache_counts counts = qg_cache_count(cache);
    assert_int_equal(counts.kept, 2);
    assert_int_equal(counts.found, 2);
    assert_int_equal(counts.missed, 1);
    for (int i = 0; i < 2; i++) {
        qg_cache_release(cache, one);
        qg_cache_release(cache, two);
    }
    qg_cache_destroy(cache);
}

static void every_figure_of_the_key_counts(void **state) {
    (void)state;
    struct qg_cache *cache = qg_cache_create((size_t)1 << 20);
    const struct qg_compliance *one = keep(cache, 1, 4);
    struct qg_compliance_key key = key_of(1);
    double *figures[] = {&key.rack.module,         &key.rack.pressure_angle, &key.gear.profile_shift,
                         &key.gear.outside_radius, &key.gear.root_radius,    &key.gear.hob_tip_radius,
                         &key.gear.bore_diameter,  &key.gear.face_width,     &key.plate.youngs_modulus,
                         &key.plate.poisson_ratio, &key.plate.thickness};
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) {
        double was = *figures[i];
        *figures[i] = nextafter(was, INFINITY);
        assert_null(qg_cache_take(cache, &key));
        *figures[i] = was;
    }
    int *numbers[] = {&key.gear.teeth, &key.plate.plane_strain, &key.support, &key.refinement, &key.reach};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        ++*numbers[i];
        assert_null(qg_cache_take(cache, &key));
        --*numbers[i];
    }
    key.gear.moment_of_inertia = 5; /* has no part in it */
    assert_ptr_equal(qg_cache_take(cache, &key), one);
    qg_cache_release(cache, one);
    qg_cache_release(cache, one);
    qg_cache_destroy(cache);
}

static void the_least_recently_used_goes_first(void **state) {
    (void)state;
    enum { M = 100 }; /* some 82 kB each */
    struct qg_cache *cache = qg_cache_create((size_t)170 << 10);
    qg_cache_release(cache, keep(cache, 1, M));
    qg_cache_release(cache, keep(cache, 2, M));
    qg_cache_release(cache, take(cache, 1)); /* now 2 is the older one */
    qg_cache_release(cache, keep(cache, 3, M));
    assert_null(take(cache, 2));
    const struct qg_compliance *one = take(cache, 1), *three = take(cache, 3);
    assert_true(one && three);
    assert_int_equal(qg_cache_count(cache).kept, 2);
    qg_cache_release(cache, one);
    qg_cache_release(cache, three);
    qg_cache_destroy(cache);
}

static void what_is_held_stays(void **state) {
    (void)state;
    struct qg_cache *cache = qg_cache_create(1); /* room for nothing */
    const struct qg_compliance *one = keep(cache, 1, 10);
    assert_ptr_equal(take(cache, 1), one);
    qg_cache_release(cache, one);
    assert_true(one->local[0] == 1);
    qg_cache_release(cache, one);
    assert_null(take(cache, 1));
    assert_int_equal(qg_cache_count(cache).bytes, 0);
    qg_cache_destroy(cache);
}

static void the_second_to_come_gets_the_first_ones(void **state) {
    (void)state;
    struct qg_cache *cache = qg_cache_create((size_t)1 << 20);
    const struct qg_compliance *first = keep(cache, 1, 4);
    struct qg_compliance late = filler(4, 1);
    const struct qg_compliance_key key = key_of(1);
    assert_ptr_equal(qg_cache_keep(cache, &key, &late), first);
    assert_null(late.local);
    assert_int_equal(qg_cache_count(cache).kept, 1);
    qg_cache_release(cache, first);
    qg_cache_release(cache, first);
    qg_cache_destroy(cache);
    qg_cache_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_kept_is_found),
        cmocka_unit_test(every_figure_of_the_key_counts),
        cmocka_unit_test(the_least_recently_used_goes_first),
        cmocka_unit_test(what_is_held_stays),
        cmocka_unit_test(the_second_to_come_gets_the_first_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
