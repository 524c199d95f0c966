/* A thinned view of a gear's full field, small enough to send to a page and to draw: quadrilaterals over the fine teeth, their
 * corners a choice of the mesh's nodes, so that what is shown at them is the full solution.
 */
#ifndef QG_CORE_FIELD_VIEW_H
#define QG_CORE_FIELD_VIEW_H

#include "core/field.h"

struct qg_field_view {
    size_t node_count, quad_count;
    int *node;      /* [node_count] their numbers in the gear's mesh */
    int (*quad)[4]; /* counter-clockwise, places in node[] */
};

/* Some 440 quadrilaterals per fine tooth, whatever the mesh's refinement; every element of the root's surface at refinement
 * 1 is kept. QG_OUT_OF_MEMORY. The view holds no pointer into the mesh. */
enum qg_status qg_field_view_init(struct qg_field_view *view, const struct qg_gear_mesh *mesh);
void qg_field_view_finish(struct qg_field_view *view);

#endif
