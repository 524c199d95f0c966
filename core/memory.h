/* The memory that a study will take, before it is run.
 *
 * An upper estimate of what one run of a study holds at its peak, from the sizes of the arrays that it will allocate; the
 * essay in memory.c says which. It is meant to be relied on: tests/core/test_memory.c and `make memory` hold it against runs,
 * of which none may take more and few much less. Two parts are not known before: how far the gears approach each other, which
 * says how many points may touch (taken large), and the pairs that a macro-geometry search will find (taken as large as the
 * mesher makes them, so that such a study may take half of it). What would go beyond the estimate all the same, the run is
 * kept from allocating by qg_means.operator_bytes_max.
 */
#ifndef QG_CORE_MEMORY_H
#define QG_CORE_MEMORY_H

#include "core/study.h"

/* Bytes of one run of a checked study on so many threads, beside the program itself: its result as a text and its log of
 * evaluations included, as a daemon holds them. Finite and positive. Any thread; about a millisecond. */
double qg_study_memory(const struct qg_study *study, int threads);

/* Says how to bring a study that takes more than `most` bytes below that: a note for each figure of the study that would
 * do it alone, with the largest value that does; where none does, for the one that helps most. Nothing for a study that
 * takes no more. Any thread; some milliseconds. */
void qg_memory_advise(const struct qg_study *study, int threads, double most, struct qg_notes *notes);

/* What is counted of one gear's sector mesh, at a refinement. */
struct qg_sector_size {
    double nodes, elements;
    double unknowns; /* of the sector, those held at the bore included */
    double flank;    /* components of force on the contact flank */
    double boundary; /* unknowns of both sides and the bore */
    double roots;    /* points of the root where stress is looked for */
};

/* The size of the sector that the mesher makes of a gear whose flank has so many elements at refinement 1; floating: the
 * bore turns (torque ring), else it is held. */
struct qg_sector_size qg_sector_size(int flank_elements, int refinement, bool floating);

#endif
