/* The contact model of a mounted pair in the input language of Abaqus, which CalculiX reads, too. */
#ifndef QG_SCHEMA_ABAQUS_H
#define QG_SCHEMA_ABAQUS_H

#include "core/deck.h"
#include "schema/document.h"

/* Appends the complete input deck: units N, mm, MPa. Nodes are numbered pinion first, then gear, then the reference node,
 * whose first component is the mean tangential displacement (mm, counter-clockwise) of the pinion's bore; elements pinion
 * first. Sets: PINION, GEAR (elements), PINION_BORE, GEAR_BORE, RING (nodes), and the surfaces PINION_FLANK_n,
 * GEAR_FLANK_n of the n-th contact pair. Printed by the solver: the displacement of RING, the reactions at GEAR_BORE.
 * Comments say what is what, job.name among them as far as it is printable ASCII. The text's `failed` tells of memory that
 * ran short. Threads: any. */
void qg_abaqus_write(struct qg_text *text, const struct qg_job *job, const struct qg_deck *deck);

#endif
