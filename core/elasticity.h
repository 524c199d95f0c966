/* Plane elasticity with eight-node quadrilaterals: element stiffness, and the assembled matrix of a mesh.
 *
 * Displacements are radial and tangential at every node (counter-clockwise positive), forces likewise.
 */
#ifndef QG_CORE_ELASTICITY_H
#define QG_CORE_ELASTICITY_H

#include <cholmod.h>

#include "core/mesh.h"

/* Isotropic plane elasticity of a slab. */
struct qg_plate {
    double youngs_modulus; /* MPa */
    double poisson_ratio;
    double thickness; /* mm */
    int plane_strain; /* 0: plane stress */
};

/* Degrees of freedom of an element: radial and tangential displacement of each node in turn. */
enum { QG_ELEMENT_FREEDOMS = 2 * QG_ELEMENT_NODES };

/* Stiffness (N/mm) of one element with its nodes at `corner` (polar coordinates), 3 x 3 Gauss points. Symmetric.
 * Returns 0, or -1 when the mapping is singular or turned at a Gauss point. */
int qg_element_stiffness(const struct qg_polar node[QG_ELEMENT_NODES], const struct qg_plate *plate,
                         double out[QG_ELEMENT_FREEDOMS][QG_ELEMENT_FREEDOMS]);

/* Assembles the mesh's stiffness as a symmetric CHOLMOD matrix (upper triangle stored). freedom[2 n + c] is the row of
 * component c (0 radial, 1 tangential) of node n, or -1 where the displacement is held at zero; rows are 0..count-1.
 * common belongs to the calling thread; the caller frees the result with cholmod_free_sparse. NULL when memory is short or
 * an element is degenerate. */
cholmod_sparse *qg_assemble(const struct qg_sector_mesh *mesh, const struct qg_plate *plate, const int *freedom,
                            size_t count, cholmod_common *common);

/* Solves a system of a factor (CHOLMOD_A: A x = b, CHOLMOD_L: L x = b, CHOLMOD_P: x = P b, ...) for a dense real b, as
 * cholmod_solve does. That, as of 3.0.14, makes two workspaces for a supernodal factor, forgets the failure of the first when
 * the second succeeds, and follows a null pointer; here the first is made before. The caller frees x by cholmod_free_dense.
 * NULL when memory is short or the factor does not fit. common belongs to the calling thread. */
cholmod_dense *qg_factor_solve(int system, cholmod_factor *factor, cholmod_dense *b, cholmod_common *common);

/* A point of a traction-free edge, and how its stress follows from the displacements of the edge's nodes. */
struct qg_edge_stress {
    struct qg_polar at;
    double weight[6]; /* MPa/mm, of radial and tangential displacement of each node in turn */
};

/* Stress along the edge of an element (nodes in order: end, midside, end) at the natural coordinate z in [-1, 1]. Where no
 * traction acts it is the one principal stress in the plane that is not zero, so it follows from the edge's own stretch:
 *     sigma = E' t . du/ds,  E' = E in plane stress, E/(1 - nu^2) in plane strain,
 * t the tangent, s the arc. It needs no derivative across the surface, so the depth of the elements below hardly matters. */
struct qg_edge_stress qg_edge_stress(const struct qg_polar node[3], const struct qg_plate *plate, double z);

/* Stresses in the plane, axes x and y (MPa). */
struct qg_plane_stress {
    double xx, yy, xy;
};

/* Stresses of an element at its nodes, from displacements (mm; radial and tangential of each node in turn): taken at the
 * 2 x 2 Gauss points, where those of a quadratic element are most accurate (Barlow 1976), and carried on to the nodes
 * bilinearly. x is the direction of the polar angle 0. */
void qg_element_stress(const struct qg_polar node[QG_ELEMENT_NODES], const struct qg_plate *plate,
                       const double displacement[QG_ELEMENT_FREEDOMS], struct qg_plane_stress out[QG_ELEMENT_NODES]);

/* The equivalent stress of von Mises; out of the plane is 0 in plane stress, nu (xx + yy) in plane strain. The largest
 * principal stress in the plane. MPa. */
double qg_von_mises(const struct qg_plane_stress *stress, const struct qg_plate *plate);
double qg_max_principal(const struct qg_plane_stress *stress);

#endif
