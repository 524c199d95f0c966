/* Drawing tooth numbers by the billion: the first test of a macro-geometry search, which most samples fail.
 *
 * One Philox block (random.h) has four words, tooth numbers of two samples: sample i takes words 0 and 1 (i even) or 2 and
 * 3 (i odd) of the block with counter (i/2, lane 0). A word w of 32 bits gives the tooth number low + floor(w count / 2^32);
 * no number of `count` <= 1000 is more probable than another by more than count 2^-32.
 * The same source is compiled for three instruction sets, with the same bits; the test of the ratio is one of exact products
 * (macro.h, qg_macro_ratio_is_kept).
 */
#ifndef QG_CORE_MACRO_TEETH_H
#define QG_CORE_MACRO_TEETH_H

#include <stddef.h>
#include <stdint.h>

#include "core/dynamics_batch.h"

struct qg_teeth_draw {
    uint64_t seed;
    uint32_t low[2], count[2]; /* tooth numbers low .. low + count - 1, at most 1000 */
    double initial[2];         /* tooth numbers of the initial pair */
    double share;              /* largest departure of the ratio, as a share of it; INFINITY draws without the test */
};

/* One sample whose ratio is kept. */
struct qg_teeth_hit {
    uint32_t sample; /* counted from the first of the call */
    uint16_t teeth[2];
};

/* Draws samples first .. first + n - 1 and writes down those whose ratio is kept, in their order; returns how many. first
 * and n are multiples of QG_TEETH_STEP, hits has room for n. The path must be available (dynamics_batch.h). Any thread. */
enum { QG_TEETH_STEP = 16 };
size_t qg_teeth_hits(enum qg_batch_path path, const struct qg_teeth_draw *draw, uint64_t first, size_t n,
                     struct qg_teeth_hit *hits);

/* The entries of macro_teeth_kernel.h: one per path. */
size_t qg_teeth_hits_baseline(const struct qg_teeth_draw *draw, uint64_t first, size_t n, struct qg_teeth_hit *hits);
size_t qg_teeth_hits_avx2(const struct qg_teeth_draw *draw, uint64_t first, size_t n, struct qg_teeth_hit *hits);
size_t qg_teeth_hits_avx512(const struct qg_teeth_draw *draw, uint64_t first, size_t n, struct qg_teeth_hit *hits);

#endif
