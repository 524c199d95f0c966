/* A finite-element mesh of one whole gear: some teeth fine, where they touch the mate or are looked at, the others coarse;
 * with the reliefs in the mesh when asked.
 *
 * Sectors (mesh.h) of two densities join node by node, because their sides are cut alike. Teeth are numbered
 * counter-clockwise, tooth 0 with its centre line at angle 0 of the gear's own frame; the contact flank is the
 * counter-clockwise side of every tooth. Mounted (profile.h), the pinion's tooth of the pair k is tooth k, the gear's is
 * tooth -k.
 *
 * Relief in the mesh. Every node of the tooth moves along the inward normal of the involute at its radius, by the
 * relief's depth on the contact flank, falling linearly to nothing at the other flank, and fading out below the form
 * radius towards the joint of tooth and foot: so the flank is exactly the relieved one and no element is turned over.
 */
#ifndef QG_CORE_GEAR_MESH_H
#define QG_CORE_GEAR_MESH_H

#include "core/elasticity.h"
#include "core/relief.h"

/* What to mesh. The pointers must outlive the call only. */
struct qg_gear_mesh_plan {
    const struct qg_gear_pair *pair;
    const struct qg_pair_geometry *geometry;
    int gear;                             /* QG_PINION or QG_GEAR */
    const struct qg_relief *relief;       /* moved into the mesh; NULL: bare involutes */
    const struct qg_mesh_density *fine;   /* of the teeth first_tooth .. first_tooth + fine_teeth - 1 */
    const struct qg_mesh_density *coarse; /* of the others; foot_rows and body_rows as in fine */
    int refinement;                       /* >= 1, of both */
    int first_tooth, fine_teeth;          /* first_tooth may be negative; 1 <= fine_teeth <= teeth */
};

struct qg_gear_mesh {
    size_t node_count, element_count;
    struct qg_polar *node;            /* about the gear's axis; angles of any turn */
    int (*element)[QG_ELEMENT_NODES]; /* corners counter-clockwise, then the midsides; the fine teeth first, in order */
    int first_tooth, fine_teeth;
    size_t fine_elements; /* of one fine tooth, by blocks as in mesh.h */
    struct {
        int columns, rows;
    } block[QG_BLOCK_COUNT]; /* of a fine tooth */
    size_t flank_count;      /* nodes on the contact flank of a fine tooth, from the form point to the tip; odd */
    int *flank;              /* [fine_teeth * flank_count] */
    double *flank_arc;       /* mm, [flank_count]; of the bare involute, as in mesh.h */
    size_t bore_count;       /* even: corners and midsides in turn, clockwise, closed */
    int *bore;
    double *bore_share; /* [bore_count] weight of each node in the mean over the bore; sums to 1 */
};

/* The densities of the teeth that nobody looks at: the same sides, some 60 elements. */
struct qg_mesh_density qg_density_far(const struct qg_mesh_density *fine);

/* Meshes the gear. QG_OUT_OF_MEMORY, or QG_NO_CONVERGENCE when an element would be turned inside out (in notes). */
enum qg_status qg_gear_mesh_init(struct qg_gear_mesh *mesh, const struct qg_gear_mesh_plan *plan,
                                 struct qg_notes *notes);
void qg_gear_mesh_finish(struct qg_gear_mesh *mesh);

/* The element behind the edge `edge` (0 .. (flank_count - 1)/2 - 1, from the form point on) of the flank of the fine tooth
 * `tooth` (0 .. fine_teeth - 1); its fourth side, from its corner 3 to its corner 0, is the edge. */
size_t qg_gear_mesh_flank_element(const struct qg_gear_mesh *mesh, int tooth, size_t edge);

/* The mesh as the assembly of elasticity.h takes it: nodes and elements only, borrowed. */
struct qg_sector_mesh qg_gear_mesh_view(const struct qg_gear_mesh *mesh);

/* The gear whose tip corner may engage on a pair of teeth: the gear in approach, the pinion in recess. */
int qg_tip_gear(const struct qg_pair_geometry *geometry, double position, int pair);

#endif
