/* What a macro-geometry search keeps of its samples: counts, the best by contact ratio, the front against stress.
 *
 * A tally is filled sample by sample within a block and block by block within a search, always in the order of the samples:
 * what it holds then depends on nothing else. Samples of equal geometry, as ranges of no width give, are one pair: the first
 * is kept, the others are counted only. Different pairs of equal figures are all kept as far as there is room.
 */
#ifndef QG_CORE_MACRO_KEEP_H
#define QG_CORE_MACRO_KEEP_H

#include "core/macro.h"

/* What is drawn of a pair: two tooth numbers, module, pressure angle, two each of profile shifts, outside and root radii. */
enum { QG_MACRO_PARAMETERS = 10 };

/* A sample that has passed. */
struct qg_macro_point {
    uint64_t sample;
    double contact_ratio;
    double contact_stress, root_stress; /* as shares of the initial pair's */
    double parameter[QG_MACRO_PARAMETERS];
};

/* The figure of the front: the larger one of the two shares. */
double qg_macro_stress(const struct qg_macro_point *point);

enum { QG_MACRO_FRONT_ROOM = 256 };

struct qg_macro_tally {
    uint64_t samples, passed, rejected[QG_MACRO_CONSTRAINTS]; /* samples = passed + the sum of rejected;
                                                                 each sample counts, whatever its geometry */
    size_t keep;                                              /* room in best */
    size_t best_count;
    struct qg_macro_point best[QG_MACRO_KEEP_MAX]; /* largest contact ratio first; of equals the earlier sample first */
    size_t front_count;
    struct qg_macro_point front[QG_MACRO_FRONT_ROOM]; /* likewise; stress falls along it */
    size_t front_dropped;                             /* points of the front for which there was no room */
};

/* An empty tally. */
void qg_macro_tally_init(struct qg_macro_tally *tally, size_t keep);

/* Counts a point that has passed and keeps it if it belongs to the best or to the front: no other point has at least its
 * contact ratio and at most its stress, and is better in one of both. Not kept when a point of the same ten parameters
 * (exactly) is kept already. A front without room drops the inner point whose
 * neighbours have the nearest contact ratios. */
void qg_macro_tally_add(struct qg_macro_tally *tally, const struct qg_macro_point *point);

/* Adds a later tally to one of the same keep. */
void qg_macro_tally_merge(struct qg_macro_tally *tally, const struct qg_macro_tally *later);

/* The points to be judged: the best, and of the front all, or, when it has more than `keep`, keep points spread evenly over
 * it by their place, both ends among them. out has room for 2 keep; largest contact ratio first, no sample twice. on_front
 * and among_best (2 keep entries each) say why a point is there. Returns how many. */
size_t qg_macro_tally_choose(const struct qg_macro_tally *tally, struct qg_macro_point *out, bool *on_front,
                             bool *among_best);

#endif
