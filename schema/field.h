/* Full fields on their way out: JSON for a page to draw, VTK for ParaView, MSH for Gmsh. */
#ifndef QG_SCHEMA_FIELD_H
#define QG_SCHEMA_FIELD_H

#include "core/field.h"
#include "schema/text.h"

/* All writers append to text; its `failed` tells of memory that ran short. Threads: any. */

/* The thinned view (core/field_view.h) of the engaged teeth as one JSON object, some 400 KB, schema/field.schema.json: nodes,
 * quadrilaterals, displacement, equivalent and largest principal stress of each gear, and the points that carry load. */
void qg_field_write(struct qg_text *text, const struct qg_field *field);

/* Both whole gears as a legacy VTK file of quadratic quadrilaterals; point data: displacement (mm), stress (MPa, components
 * xx yy xy), von_mises, max_principal; cell data: gear (0 pinion, 1 gear). */
void qg_field_write_vtk(struct qg_text *text, const struct qg_field *field);

/* The same as a file of Gmsh, MSH 4.1, physical surfaces "pinion" and "gear", and a view per quantity. */
void qg_field_write_gmsh(struct qg_text *text, const struct qg_field *field);

#endif
