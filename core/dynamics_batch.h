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

/* One lane's march over a given number of mesh periods, without judgement. */
struct qg_shot {
    double frequency_ratio;                 /* given */
    struct qg_state start;                  /* given: the state at phase 0 */
    struct qg_state end;                    /* after the last mesh period */
    struct qg_state visited[QG_PERIOD_MAX]; /* after each of the first mesh periods; later ones are not kept */
    double tangent[4];                      /* derivative of end with respect to start, by rows */
    double sum, sum_of_squares;             /* over the steps, of x - start.x and of its square */
    size_t steps;
    int drive_crossings, back_crossings; /* how often y passed +1 and -1, the edges of the dead zone */
    int beyond;                          /* 1: it left the ladder of the force (as in qg_response) */
};

/* Marches up to QG_LANES shots of one oscillator side by side over `periods` >= 1 mesh periods. Any thread. */
void qg_batch_shoot(const struct qg_oscillator *oscillator, size_t periods, size_t count, struct qg_shot *shots);

/* Marches up to QG_LANES states, each at its own frequency ratio, to their steady responses: the judgement of
 * qg_response_piece without a map. Any thread. */
void qg_batch_settle(const struct qg_oscillator *oscillator, size_t count, const double *frequency_ratio,
                     const struct qg_state *start, struct qg_response *out);

/* What the lanes do. Without `ratio`: speeds first..first+count-1 of a map, count <= QG_LANES; start is replaced by the
 * last state when the speeds are run through one after another. */
struct qg_block {
    const struct qg_oscillator *oscillator;
    const struct qg_speed_map *map;
    size_t first, count;
    bool plain;
    const double *ratio;   /* not NULL: the lanes' own speeds; no map, and start holds one state per lane */
    struct qg_shot *shots; /* not NULL: no judgement, only these, over `periods` mesh periods; needs ratio */
    size_t periods;
    struct qg_state *start;
    struct qg_response *out;
};

/* The entries of dynamics_kernel.h: one per path. Any thread. */
void qg_run_block_baseline(const struct qg_block *block);
void qg_run_block_avx2(const struct qg_block *block);
void qg_run_block_avx512(const struct qg_block *block);

#endif
