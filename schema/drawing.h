/* Drawings that go out: profile data for a page or a measuring machine's diagram, and DXF for a workshop.
 *
 * Both are about one design: the study's pair and its relief. The pair as mounted has the pinion's axis at (0, 0) and the gear's at
 * (centre distance, 0); the pinion turns counter-clockwise and drives. Both flanks of every tooth get the relief.
 */
#ifndef QG_SCHEMA_DRAWING_H
#define QG_SCHEMA_DRAWING_H

#include "schema/document.h"

/* Chord and arc tolerances, mm: how far a drawn line may lie from the exact profile. */
#define QG_CHORD_TOLERANCE 1e-3
#define QG_ARC_TOLERANCE 1e-4

/* Reads what is to be drawn: a job document, or one that lacks its "kind" and is then taken as "evaluate", so that
 * {"gear_pair": ..., "relief": ...} is enough. Otherwise as qg_document_read. */
enum qg_document_status qg_design_read(const char *bytes, size_t length, struct qg_job *job, struct qg_faults *faults,
                                       struct qg_notes *warnings);

/* Takes the design out of a result, as qg_result_write wrote it: the job, with the relief of "design" in the place of its own.
 * Of a macro search: an evaluation of its best candidate.
 * QG_DOCUMENT_OK; QG_DOCUMENT_INVALID when the bytes are no result, job is then of no use; QG_DOCUMENT_NO_MEMORY.
 * Threads: any. */
enum qg_document_status qg_result_design_read(const char *bytes, size_t length, struct qg_job *job);

/* Writes the profile data of a job that was read: outline of one tooth of each gear in chords, the profile diagram with its
 * marks and, when a search or a map moves the relief, the least and the most that may be removed; the mesh over one period.
 * schema/profile.schema.json describes it. Look at text->failed at the end. Threads: any. */
void qg_profile_write(struct qg_text *text, const struct qg_job *job);

/* What a DXF shows. */
enum qg_extent {
    QG_EXTENT_GEARS, /* both gears, whole, mounted */
    QG_EXTENT_SPACES /* of each gear one tooth space, from the middle of one tip to that of the next, upright */
};

/* The extent of that name, "gears" or "spaces"; -1 when there is none. */
int qg_extent_of_name(const char *name);

/* Writes a DXF drawing (AC1015, ASCII, millimetres) of a job that was read. Profiles are light-weight polylines whose arcs hold
 * QG_ARC_TOLERANCE, closed for whole gears, on a layer for each gear; bores, reference, base and pitch circles and the path
 * of contact have layers of their own. position is that of the mesh, in periods, for QG_EXTENT_GEARS.
 * Look at text->failed at the end. Threads: any. */
void qg_dxf_write(struct qg_text *text, const struct qg_job *job, enum qg_extent extent, double position);

#endif
