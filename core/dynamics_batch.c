/* Which code runs which piece of a speed map. The integrator itself is dynamics_kernel.h, compiled once for each of the
 * instruction sets that the paths name; the best one that the processor has is taken.
 */
#include "core/dynamics_batch.h"

#include <assert.h>
#include <string.h>

bool qg_batch_path_available(enum qg_batch_path path) {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
    if (path == QG_PATH_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
    if (path == QG_PATH_AVX2)
        return __builtin_cpu_supports("avx2");
#endif
    return path == QG_PATH_BASELINE;
}

static void run_block(const struct qg_block *block, enum qg_batch_path path) {
    assert(qg_batch_path_available(path));
    if (path == QG_PATH_AVX512)
        qg_run_block_avx512(block);
    else if (path == QG_PATH_AVX2)
        qg_run_block_avx2(block);
    else
        qg_run_block_baseline(block);
}

static enum qg_batch_path best_path(void) {
    enum qg_batch_path path = QG_PATH_COUNT - 1;
    while (!qg_batch_path_available(path))
        path--;
    return path;
}

static struct qg_state start_state(const struct qg_oscillator *oscillator, const struct qg_speed_map *map) {
    double x = map->start_static ? qg_static_displacement(oscillator) : map->start_displacement;
    return (struct qg_state){x, map->start_static ? 0.0 : map->start_velocity};
}

void qg_response_piece_with(const struct qg_batch_options *options, const struct qg_oscillator *oscillator,
                            const struct qg_speed_map *map, size_t piece, struct qg_response *out) {
    assert(piece < qg_response_pieces(map) && oscillator->damping_ratio > 0.0 && oscillator->load > 0.0);
    struct qg_state start = start_state(oscillator, map);
    struct qg_block block = {
        .oscillator = oscillator, .map = map, .plain = options->plain, .start = &start, .out = out};
    size_t blocks = (map->count + QG_LANES - 1) / QG_LANES;
    size_t begin = map->branch == QG_BRANCH_FIXED ? piece : 0,
           end = map->branch == QG_BRANCH_FIXED ? piece + 1 : blocks;
    for (size_t n = begin; n < end; n++) {
        size_t number = map->branch == QG_BRANCH_RUN_DOWN ? blocks - 1 - n : n;
        block.first = number * QG_LANES;
        block.count = map->count - block.first < QG_LANES ? map->count - block.first : QG_LANES;
        run_block(&block, options->path);
    }
}

void qg_response_piece(const struct qg_oscillator *oscillator, const struct qg_speed_map *map, size_t piece,
                       struct qg_response *out) {
    struct qg_batch_options options = {.path = best_path()};
    qg_response_piece_with(&options, oscillator, map, piece, out);
}

void qg_batch_shoot(const struct qg_oscillator *oscillator, size_t periods, size_t count, struct qg_shot *shots) {
    assert(count >= 1 && count <= QG_LANES && periods >= 1);
    double ratio[QG_LANES];
    for (size_t i = 0; i < count; i++)
        ratio[i] = shots[i].frequency_ratio;
    struct qg_block block = {
        .oscillator = oscillator, .count = count, .ratio = ratio, .shots = shots, .periods = periods};
    run_block(&block, best_path());
}

void qg_batch_settle(const struct qg_oscillator *oscillator, size_t count, const double *frequency_ratio,
                     const struct qg_state *start, struct qg_response *out) {
    assert(count >= 1 && count <= QG_LANES);
    struct qg_state states[QG_LANES];
    memcpy(states, start, count * sizeof *start);
    struct qg_block block = {
        .oscillator = oscillator, .count = count, .ratio = frequency_ratio, .start = states, .out = out};
    run_block(&block, best_path());
}

void qg_batch_march(const struct qg_oscillator *oscillator, double frequency_ratio, size_t periods, double state[2],
                    double tangent[4]) {
    struct qg_shot shot = {.frequency_ratio = frequency_ratio, .start = {state[0], state[1]}};
    qg_batch_shoot(oscillator, periods, 1, &shot);
    state[0] = shot.end.x;
    state[1] = shot.end.v;
    if (tangent)
        memcpy(tangent, shot.tangent, sizeof shot.tangent);
}
