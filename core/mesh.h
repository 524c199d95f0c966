/* A finite-element mesh of one tooth sector, from the bore to the tooth tip.
 *
 * All teeth are alike, so one sector of angle 2 pi / z is enough (compliance.h joins them). The sector is cut into blocks
 * of curved quadrilaterals with eight nodes:
 *
 *            tip
 *          .-----.          T   tooth: rows along the flank, columns across, fine at the contact flank
 *          |  T  |          C   foot of the tooth, same columns
 *     A .__J__.__J__. A     R   root of the space, on both sides
 *       | R | C | R |       B   body: radial columns down to the bore
 *     K'|___K___K___|K'
 *       |     B     |
 *       '-----------'  bore
 *
 * The tooth's centre line is at angle 0, the contact flank on the side of positive angles. Nodes are given in polar
 * coordinates about the gear's axis; displacements are taken in the radial and tangential direction of each node, which
 * makes neighbouring sectors and the bore's support trivial to couple.
 */
#ifndef QG_CORE_MESH_H
#define QG_CORE_MESH_H

#include "core/gear.h"

enum { QG_ELEMENT_NODES = 8 };

/* How finely the blocks are cut. Sectors of one gear join when foot_rows and body_rows agree, whatever else differs. */
struct qg_mesh_density {
    int tooth_columns, fillet_rows, root_columns, foot_rows, body_rows; /* elements */
    double flank_elements_per_module;
    double tip_share;     /* length of the last element at the tip corner, to that of a flank element */
    double column_growth; /* of the tooth's columns, from the contact flank inwards */
    int back_columns;     /* so many of the columns, those at the opposite flank, grow by back_growth instead */
    double back_growth;   /* > 0; without meaning where back_columns is 0 */
};

/* The density of the analysis at refinement 1: STE converged to 0.2 %. */
extern const struct qg_mesh_density qg_density_analysis;

/* Elements that the contact flank has at refinement 1 from the tip corner to a length (modules) along it; at most
 * QG_FLANK_ELEMENTS_MAX, none for a length of 0 or less. A flank has at least 4. */
enum { QG_FLANK_ELEMENTS_MAX = 250 };
int qg_flank_elements(const struct qg_mesh_density *density, double length);

/* The blocks in the order in which their elements are numbered, row by row from the bore outwards and across from the
 * contact flank's side. */
enum qg_mesh_block {
    QG_BLOCK_TOOTH,
    QG_BLOCK_FOOT,
    QG_BLOCK_ROOT_PLUS,
    QG_BLOCK_ROOT_MINUS,
    QG_BLOCK_BODY,
    QG_BLOCK_COUNT
};

struct qg_sector_mesh {
    size_t node_count, element_count;
    struct qg_polar *node;
    int (*element)[QG_ELEMENT_NODES]; /* corners counter-clockwise, then the midsides after each of them */
    size_t flank_count;               /* odd: corners and midsides of the element edges on the contact flank */
    int *flank;                       /* nodes on the involute, from the form point to the tip */
    double *flank_arc; /* mm, arc length of the involute from the base circle, (rho^2 - r_b^2) / (2 r_b) */
    size_t root_count; /* odd: corners and midsides of the element edges on the generated root, of either side */
    int *root[2]; /* nodes from the middle of the space to the form point: [0] below the contact flank, [1] opposite */
    size_t side_count;
    int *side[2]; /* nodes on the sector's sides, from the bore outwards: [0] at +pi/z, [1] at -pi/z, matched */
    size_t bore_count;
    int *bore; /* nodes on the bore, from +pi/z to -pi/z, corners and midsides in turn */
    struct {
        int columns, rows;
    } block[QG_BLOCK_COUNT]; /* elements of each */
};

/* Meshes one sector. refinement >= 1 divides every element edge. The gear must have passed qg_gear_derive.
 * QG_OUT_OF_MEMORY, or QG_NO_CONVERGENCE when an element would be turned inside out (reported in notes). */
enum qg_status qg_sector_mesh_init(struct qg_sector_mesh *mesh, const struct qg_rack *rack, const struct qg_gear *gear,
                                   const struct qg_gear_geometry *geometry, int refinement, struct qg_notes *notes);
/* The same at a density of the caller's choice. */
enum qg_status qg_sector_mesh_init_with(struct qg_sector_mesh *mesh, const struct qg_rack *rack,
                                        const struct qg_gear *gear, const struct qg_gear_geometry *geometry,
                                        const struct qg_mesh_density *density, int refinement, struct qg_notes *notes);
void qg_sector_mesh_finish(struct qg_sector_mesh *mesh);

#endif
