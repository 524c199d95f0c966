/* Inside of the dynamics, for its own files and their tests; nobody else includes this. */
#ifndef QG_CORE_DYNAMICS_BATCH_H
#define QG_CORE_DYNAMICS_BATCH_H

#include <stdbool.h>

#include "core/dynamics_steady.h"

/* Speeds that are integrated side by side, one per SIMD lane; also the speeds of one piece of a fixed-branch map. */
enum { QG_LANES = 8 };

#define QG_PI 3.14159265358979323846

/* Cosine and sine of 2 pi phase, the same bits on every processor; errors below 2e-16. Any thread. */
void qg_turn(double phase, double *cosine, double *sine);

/* The code paths of the batched integrator: the same source compiled for three instruction sets, the same bits. */
enum qg_batch_path { QG_PATH_BASELINE, QG_PATH_AVX2, QG_PATH_AVX512, QG_PATH_COUNT };

/* Whether this processor (and this compilation) has a path. The baseline is always there. */
bool qg_batch_path_available(enum qg_batch_path path);

/* How to run a piece. */
struct qg_batch_options {
    enum qg_batch_path path; /* must be available */
    bool plain;              /* march all the way: no jump to the linear orbit, no Newton steps */
};

/* qg_response_piece with a choice; for tests and measurements. */
void qg_response_piece_with(const struct qg_batch_options *options, const struct qg_oscillator *oscillator,
                            const struct qg_speed_map *map, size_t piece, struct qg_response *out);

/* Marches one oscillator over whole mesh periods, from phase 0 to phase 0, with the batched integrator. state is (x, v)
 * and is replaced by the end state; tangent (may be NULL) receives the derivative of the end state with respect to the
 * start, by rows: the monodromy matrix where the orbit is periodic. Any thread. */
void qg_batch_march(const struct qg_oscillator *oscillator, double frequency_ratio, size_t periods, double state[2],
                    double tangent[4]);

/* A march over whole mesh periods without judgement, and the derivative of its end state to its start, by rows. */
struct qg_march_only {
    size_t periods;
    double tangent[4];
};

/* Speeds first..first+count-1 of a map, count <= QG_LANES. start is replaced by the last state when the speeds are run
 * through one after another. */
struct qg_block {
    const struct qg_oscillator *oscillator;
    const struct qg_speed_map *map;
    size_t first, count;
    bool plain;
    struct qg_march_only *march; /* not NULL: no judgement, only this */
    struct qg_state *start;
    struct qg_response *out;
};

/* The entries of dynamics_kernel.h: one per path. Any thread. */
void qg_run_block_baseline(const struct qg_block *block);
void qg_run_block_avx2(const struct qg_block *block);
void qg_run_block_avx512(const struct qg_block *block);

#endif
