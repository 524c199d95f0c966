/* Random numbers by counting: Philox 4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3",
 * SC'11). A number is a pure function of its key (seed, stream) and counter (index, lane): no state, any order, any thread.
 */
#ifndef QG_CORE_RANDOM_H
#define QG_CORE_RANDOM_H

#include <stdint.h>

/* Streams keep the uses of one seed apart. */
enum qg_stream {
    QG_STREAM_SEARCH = 1,
    QG_STREAM_RELIABILITY = 2,
    QG_STREAM_STARTS = 3,
    QG_STREAM_TESTS = 4,
    QG_STREAM_MACRO = 5,
    QG_STREAM_SEQUENCE = 6
};

/* The generator's multipliers and the steps of its key. */
#define QG_PHILOX_M0 UINT32_C(0xD2511F53)
#define QG_PHILOX_M1 UINT32_C(0xCD9E8D57)
#define QG_PHILOX_W0 UINT32_C(0x9E3779B9)
#define QG_PHILOX_W1 UINT32_C(0xBB67AE85)

/* The bare generator: 10 rounds of a four-word counter under a two-word key, in place. */
void qg_philox(uint32_t counter[4], const uint32_t key[2]);

/* Uniform in [0, 1), 53 bits. index counts trials, lane the numbers within a trial. */
double qg_random_uniform(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane);

/* Both numbers of the same block, for who needs two: out[0] is qg_random_uniform's. */
void qg_random_two(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane, double out[2]);

/* Standard Gaussian, cut to +- limit by drawing again (limit > 0); Box-Muller. */
double qg_random_gaussian(uint64_t seed, enum qg_stream stream, uint64_t index, uint32_t lane, double limit);

#endif
