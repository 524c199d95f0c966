/* Sampling macro-geometries by the billion: what a sample is, and which constraint rejects it.
 *
 * Sample i of a seed is a pure function of both: the numbers are counted (random.h, QG_STREAM_MACRO). The two tooth numbers
 * come from the block (i/2, lane 0), see macro_teeth.h; the others from the blocks (i, lane), two 53-bit numbers each:
 *     lane 1  module, pressure angle                  lane 3  pinion's outside radius, gear's root radius
 *     lane 2  shift of the pinion, of the gear        lane 4  gear's outside radius, pinion's root radius
 * each low + u (high - low), 0 <= u < 1. They are drawn lazily: a sample that fails its first tests has cost two words and a
 * handful of vector instructions, and the numbers that it would have had are never made.
 *
 * The tests are the conditions of gear.h and pair.h in a lean form, with what the gears of a pair share computed once:
 *     center distance  (r_b1 + r_b2)/a < 1, a the centre distance
 *     backlash         2b = 2 (r_b1 + r_b2)(inv a_w - inv alpha) - 2 (x1 m + x2 m) sin alpha        (pair.c, summed up)
 *     undercut         remaining = r sin alpha - (d + rho sin alpha)/sin alpha >= 0                  (gear.c)
 *     interference     line_length - sqrt(r_a^2 - r_b^2) of each tip >= remaining of its mate
 * What passes all of them is derived by qg_pair_derive and rated by ISO 6336 as any pair is; only that decides. The lean
 * form differs from gear.h and pair.h by rounding alone.
 *
 * Hob tips "as large as fits": rho = (pi m/4 - h tan alpha) cos alpha / (1 - sin alpha), h the hob's addendum, less a
 * billionth, and at most r - r_f, so that the rounding's centre does not rise above the rolling line.
 */
#ifndef QG_CORE_MACRO_SAMPLE_H
#define QG_CORE_MACRO_SAMPLE_H

#include "core/macro_keep.h"
#include "core/macro_teeth.h"

/* A search made ready. */
struct qg_macro_search {
    struct qg_macro macro; /* completed and checked */
    struct qg_gear_pair initial;
    struct qg_macro_rating initial_rating;
    struct qg_teeth_draw teeth;
};

/* Copies what it needs. QG_NO_CONVERGENCE when the initial pair cannot be rated. */
enum qg_status qg_macro_search_init(struct qg_macro_search *search, const struct qg_macro *macro,
                                    const struct qg_gear_pair *initial, const struct qg_pair_geometry *geometry);

/* One sample in full: the pair (all ten parameters drawn, the rest the initial pair's) and its pressure angle in degrees,
 * which may be NULL. Any thread. */
struct qg_gear_pair qg_macro_sample(const struct qg_macro_search *search, uint64_t sample, double *pressure_angle_deg);

/* The first constraint that a sample violates, by the lean tests; QG_MACRO_CONSTRAINTS when it passes, and then *point is
 * filled in. Any thread. */
enum qg_macro_constraint qg_macro_test(const struct qg_macro_search *search, uint64_t sample,
                                       struct qg_macro_point *point);

/* Blocks are the pieces of a search, the same for any executor. */
#define QG_MACRO_BLOCK (UINT64_C(1) << 20)
size_t qg_macro_blocks(const struct qg_macro *macro);

/* Tests the samples of one block into a fresh tally, on the best path of this processor or on a given one. cancelled (may be
 * NULL) is asked now and then; when it says true the tally is incomplete. Any thread. */
struct qg_macro_block {
    const struct qg_macro_search *search;
    size_t number;
    bool (*cancelled)(void *self);
    void *self;
};
void qg_macro_block_run(const struct qg_macro_block *block, enum qg_batch_path path, struct qg_macro_tally *tally);
enum qg_batch_path qg_macro_best_path(void);

#endif
