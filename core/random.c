/* Philox 4x32-10 and what is made from it. Counter words: index (two), lane with the attempt number, stream. */
#include "core/random.h"

#include <math.h>

void qg_philox(uint32_t counter[4], const uint32_t key[2]) {
    uint32_t k0 = key[0], k1 = key[1];
    for (int round = 0; round < 10; round++) {
        uint64_t a = (uint64_t)QG_PHILOX_M0 * counter[0], b = (uint64_t)QG_PHILOX_M1 * counter[2];
        uint32_t c1 = counter[1], c3 = counter[3];
        counter[0] = (uint32_t)(b >> 32) ^ c1 ^ k0;
        counter[1] = (uint32_t)b;
        counter[2] = (uint32_t)(a >> 32) ^ c3 ^ k1;
        counter[3] = (uint32_t)a;
        k0 += QG_PHILOX_W0;
        k1 += QG_PHILOX_W1;
    }
}

/* Two uniforms in [0, 1) of 53 bits from one block. */
static void uniforms(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane, uint32_t attempt,
                     double out[2]) {
    uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    uint32_t counter[4] = {(uint32_t)index, (uint32_t)(index >> 32), lane, (uint32_t)stream << 16 | attempt};
    qg_philox(counter, key);
    for (int i = 0; i < 2; i++) {
        uint64_t bits = (uint64_t)counter[2 * i] << 32 | counter[2 * i + 1];
        out[i] = (double)(bits >> 11) * 0x1p-53;
    }
}

double qg_random_uniform(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane) {
    double u[2];
    uniforms(seed, stream, index, lane, 0, u);
    return u[0];
}

void qg_random_two(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane, double out[2]) {
    uniforms(seed, stream, index, lane, 0, out);
}

double qg_random_gaussian(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane, double limit) {
    for (uint32_t attempt = 0;; attempt++) {
        double u[2];
        uniforms(seed, stream, index, lane, attempt, u);
        double radius = sqrt(-2 * log(1 - u[0]));
        double x = radius * cos(2 * M_PI * u[1]), y = radius * sin(2 * M_PI * u[1]);
        if (fabs(x) <= limit)
            return x;
        if (fabs(y) <= limit)
            return y;
    }
}
