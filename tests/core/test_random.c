/* Counted random numbers: known answers, moments, independence of lanes, cuts. */
#include "tests/core/cases.h"

#include "core/random.h"

enum { DRAWS = 200000 };

/* Known answers published with the generator (Random123, kat_vectors: philox4x32 10). */
static void philox_gives_the_published_answers(void **state) {
    (void)state;
    static const struct {
        uint32_t counter[4], key[2], wanted[4];
    } known[] = {
        {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
         {0xffffffff, 0xffffffff},
         {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        uint32_t counter[4];
        memcpy(counter, known[i].counter, sizeof counter);
        qg_philox(counter, known[i].key);
        assert_memory_equal(counter, known[i].wanted, sizeof counter);
    }
}

static void uniforms_fill_the_unit_interval(void **state) {
    (void)state;
    enum { BINS = 64 };
    int bin[BINS] = {0};
    double moment[5] = {0};
    for (uint64_t i = 0; i < DRAWS; i++) {
        double u = qg_random_uniform(7, QG_STREAM_SEARCH, i, 3), power = 1;
        assert_true(u >= 0 && u < 1);
        bin[(int)(u * BINS)]++;
        for (int k = 1; k < 5; k++)
            moment[k] += (power *= u) / DRAWS;
    }
    for (int k = 1; k < 5; k++) /* E u^k = 1/(k+1), five standard errors */
        assert_near(moment[k], 1.0 / (k + 1), 5 * sqrt((1.0 / (2 * k + 1) - 1.0 / ((k + 1) * (k + 1))) / DRAWS));
    double chi = 0, expected = (double)DRAWS / BINS;
    for (int b = 0; b < BINS; b++)
        chi += (bin[b] - expected) * (bin[b] - expected) / expected;
    assert_true(chi > 30 && chi < 120); /* 63 degrees of freedom: 63 +- 11 */
}

static void uniforms_have_53_bits(void **state) {
    (void)state;
    int last_bit = 0;
    for (uint64_t i = 0; i < 1000; i++) {
        double scaled = qg_random_uniform(1, QG_STREAM_SEARCH, i, 0) * 0x1p53;
        assert_true(scaled == floor(scaled));
        last_bit += fmod(scaled, 2) == 1;
    }
    assert_true(last_bit > 400 && last_bit < 600);
}

static void gaussians_have_their_moments(void **state) {
    (void)state;
    double moment[5] = {0};
    int beyond[4] = {0};
    for (uint64_t i = 0; i < DRAWS; i++) {
        double x = qg_random_gaussian(3, QG_STREAM_RELIABILITY, i, 1, 100), power = 1;
        for (int k = 1; k < 5; k++)
            moment[k] += (power *= x) / DRAWS;
        for (int k = 1; k < 4; k++)
            beyond[k] += fabs(x) > k;
    }
    double error = 1 / sqrt(DRAWS);
    assert_near(moment[1], 0, 5 * error);
    assert_near(moment[2], 1, 5 * sqrt(2) * error);
    assert_near(moment[3], 0, 5 * sqrt(15) * error);
    assert_near(moment[4], 3, 5 * sqrt(96) * error);
    for (int k = 1; k < 4; k++) {
        double share = erfc(k / sqrt(2));
        assert_near((double)beyond[k] / DRAWS, share, 5 * sqrt(share) * error);
    }
}

/* Cut at L: variance 1 - 2 L phi(L) / (2 Phi(L) - 1), and no heap at the limit. */
static void gaussians_are_cut_by_drawing_again(void **state) {
    (void)state;
    const double limits[] = {3, 1, 0.2};
    for (size_t l = 0; l < sizeof limits / sizeof *limits; l++) {
        double limit = limits[l], sum = 0, square = 0;
        int outer = 0;
        for (uint64_t i = 0; i < DRAWS; i++) {
            double x = qg_random_gaussian(4, QG_STREAM_RELIABILITY, i, 0, limit);
            assert_true(fabs(x) <= limit);
            sum += x;
            square += x * x;
            outer += fabs(x) > 0.98 * limit;
        }
        double inside = erf(limit / sqrt(2)), density = exp(-limit * limit / 2) / sqrt(2 * M_PI);
        double variance = 1 - 2 * limit * density / inside, rim = 1 - erf(0.98 * limit / sqrt(2)) / inside;
        assert_near(sum / DRAWS, 0, 5 * sqrt(variance / DRAWS));
        assert_near(square / DRAWS, variance, 0.01 * variance);
        assert_near((double)outer / DRAWS, rim, 5 * sqrt(rim / DRAWS));
    }
}

/* Correlation of two sequences of uniforms, in standard errors. */
static double correlation(double (*first)(uint64_t), double (*second)(uint64_t)) {
    double sum = 0;
    for (uint64_t i = 0; i < DRAWS; i++)
        sum += (first(i) - 0.5) * (second(i) - 0.5);
    return 12 * sum / sqrt(DRAWS);
}

static double base_lane(uint64_t i) {
    return qg_random_uniform(9, QG_STREAM_SEARCH, i, 0);
}
static double next_lane(uint64_t i) {
    return qg_random_uniform(9, QG_STREAM_SEARCH, i, 1);
}
static double next_index(uint64_t i) {
    return qg_random_uniform(9, QG_STREAM_SEARCH, i + 1, 0);
}
static double far_index(uint64_t i) {
    return qg_random_uniform(9, QG_STREAM_SEARCH, i + (UINT64_C(1) << 32), 0);
}
static double next_seed(uint64_t i) {
    return qg_random_uniform(10, QG_STREAM_SEARCH, i, 0);
}
static double far_seed(uint64_t i) {
    return qg_random_uniform(9 + (UINT64_C(1) << 32), QG_STREAM_SEARCH, i, 0);
}
static double other_stream(uint64_t i) {
    return qg_random_uniform(9, QG_STREAM_RELIABILITY, i, 0);
}

static void every_coordinate_gives_other_numbers(void **state) {
    (void)state;
    double (*const others[])(uint64_t) = {next_lane, next_index, far_index, next_seed, far_seed, other_stream};
    for (size_t k = 0; k < sizeof others / sizeof *others; k++)
        assert_true(fabs(correlation(base_lane, others[k])) < 4.5);
    assert_true(correlation(base_lane, base_lane) > 100); /* the measure itself works */
}

static void numbers_have_no_state(void **state) {
    (void)state;
    double forwards[100];
    for (uint64_t i = 0; i < 100; i++)
        forwards[i] = qg_random_gaussian(5, QG_STREAM_RELIABILITY, i, 2, 1);
    for (uint64_t i = 100; i-- > 0;)
        assert_true(forwards[i] == qg_random_gaussian(5, QG_STREAM_RELIABILITY, i, 2, 1));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_the_published_answers),
        cmocka_unit_test(uniforms_fill_the_unit_interval),
        cmocka_unit_test(uniforms_have_53_bits),
        cmocka_unit_test(gaussians_have_their_moments),
        cmocka_unit_test(gaussians_are_cut_by_drawing_again),
        cmocka_unit_test(every_coordinate_gives_other_numbers),
        cmocka_unit_test(numbers_have_no_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
