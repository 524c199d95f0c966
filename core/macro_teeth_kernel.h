/* Tooth numbers side by side: one Philox block, hence two samples, per SIMD lane (macro_teeth.h).
 *
 * A lane holds a 32-bit word of the generator in the lower half of 64 bits. The product of two words is one instruction on
 * such lanes, which ignores the upper halves; so what lands there (the upper half of a product, passed through exclusive
 * ors) is never cleared. Shifted products have a clean upper half.
 */
#include <assert.h>
#include <string.h>

#include "core/macro_teeth.h"
#include "core/random.h"

#ifndef QG_TEETH_HITS
#error "name the entry: QG_TEETH_HITS"
#endif
#if defined(__AVX512F__) || defined(__AVX2__) || defined(__SSE2__)
#include <immintrin.h>
#endif
#define INLINE static inline __attribute__((always_inline))

#if defined(__AVX512F__)
enum { WIDTH = 64 };
#elif defined(__AVX2__)
enum { WIDTH = 32 };
#else
enum { WIDTH = 16 };
#endif
enum { LANES = WIDTH / sizeof(uint64_t) };
static_assert(QG_TEETH_STEP % (2 * LANES) == 0, "a step is whole vectors");

typedef uint64_t words __attribute__((vector_size(WIDTH)));
typedef int64_t marks __attribute__((vector_size(WIDTH)));
typedef double reals __attribute__((vector_size(WIDTH)));

INLINE words splat(uint64_t value) {
    words all = {0};
    return all + value;
}

/* Products of the lower halves. */
INLINE words product(words a, words b) {
#if defined(__AVX512F__)
    return (words)_mm512_mul_epu32((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
    return (words)_mm256_mul_epu32((__m256i)a, (__m256i)b);
#elif defined(__SSE2__)
    return (words)_mm_mul_epu32((__m128i)a, (__m128i)b);
#else
    return (a & UINT32_MAX) * (b & UINT32_MAX);
#endif
}

/* Whole numbers below 2^52 as doubles: set as the fraction of 2^52, which is then taken off. */
INLINE reals real_of(words whole) {
    return (reals)(whole | UINT64_C(0x4330000000000000)) - 0x1p52;
}

/* Ten rounds of Philox; out[k] holds word k of all lanes' blocks, the upper halves undefined. */
INLINE void philox(uint64_t seed, words block, words out[4]) {
    words c0 = block, c1 = block >> 32, c2 = splat(0), c3 = splat((uint64_t)QG_STREAM_MACRO << 16);
    uint32_t k0 = (uint32_t)seed, k1 = (uint32_t)(seed >> 32);
#pragma GCC unroll 10
    for (int round = 0; round < 10; round++) {
        const words a = product(splat(QG_PHILOX_M0), c0), b = product(splat(QG_PHILOX_M1), c2);
        c0 = (b >> 32) ^ c1 ^ k0;
        c1 = b;
        c2 = (a >> 32) ^ c3 ^ k1;
        c3 = a;
        k0 += QG_PHILOX_W0;
        k1 += QG_PHILOX_W1;
    }
    out[0] = c0;
    out[1] = c1;
    out[2] = c2;
    out[3] = c3;
}

/* Tooth numbers from two words, z1 + 2^16 z2, with the sign bit set where the ratio is kept. */
INLINE words judge(const struct qg_teeth_draw *d, words w1, words w2) {
    const words z1 = (product(w1, splat(d->count[0])) >> 32) + d->low[0];
    const words z2 = (product(w2, splat(d->count[1])) >> 32) + d->low[1];
    const reals wanted = real_of(z1) * d->initial[1], difference = real_of(z2) * d->initial[0] - wanted;
    const marks kept = (reals)((words)difference & INT64_MAX) <= d->share * wanted;
    return z1 | z2 << 16 | ((words)kept & (UINT64_C(1) << 63));
}

size_t QG_TEETH_HITS(const struct qg_teeth_draw *draw, uint64_t first, size_t n, struct qg_teeth_hit *hits) {
    words lane = {0};
    size_t count = 0;
    for (size_t i = 0; i < LANES; i++)
        lane[i] = i;
    for (size_t done = 0; done < n; done += 2 * LANES) {
        words word[4];
        uint64_t judged[2][LANES];
        philox(draw->seed, lane + (first + done) / 2, word);
        for (size_t odd = 0; odd < 2; odd++) {
            const words verdict = judge(draw, word[2 * odd], word[2 * odd + 1]);
            memcpy(judged[odd], &verdict, sizeof verdict);
        }
        for (size_t i = 0; i < 2 * LANES; i++) {
            const uint64_t one = judged[i % 2][i / 2];
            if (one >> 63)
                hits[count++] =
                    (struct qg_teeth_hit){(uint32_t)(done + i), {(uint16_t)one, (uint16_t)((one >> 16) & UINT16_MAX)}};
        }
    }
    return count;
}
