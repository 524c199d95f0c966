/* The full field of a loaded pair: displacement and stress everywhere in both gears, for one design, mesh position and torque.
 *
 * The contact loads are those of statics.h. They are put, as forces in absolute directions, on the nodes of two whole gears
 * (gear_mesh.h: the teeth around the contact as fine as in the analysis, the others coarse), which one sparse Cholesky
 * factorization each solves. Neither condensation nor cyclic symmetry nor the spreads of nodal.h take part, so the field
 * is an independent check of them:
 *
 *   balance    the moment of the flank forces about the pinion's axis is the torque; the reactions at the gear's bore
 *              balance the flank forces
 *   approach   at every loaded point the gap closes: g_i + y_i = c_i delta, y_i the yield of both flanks there. Weighted with
 *              the loads, delta = (sum lambda_i g_i + sum over both gears of f'u) / F: the static transmission error out of
 *              the field, to be compared with that of the contact problem
 *
 * Displacements. The gear's bore is fixed. The pinion's displacements contain its turn delta / r_b1, so that the flanks meet.
 * Reliefs are gaps here: the mesh is that of the bare involutes.
 *
 * Stress at nodes is the mean over their elements (elasticity.h). It resolves the contact as far as the flank's elements do,
 * a quarter of their length below the surface; at tip corners, elasticity has no finite value.
 */
#ifndef QG_CORE_FIELD_H
#define QG_CORE_FIELD_H

#include "core/gear_mesh.h"
#include "core/model.h"

/* One gear. Nodes are polar about its axis, angles absolute as mounted (profile.h). */
struct qg_field_gear {
    struct qg_gear_mesh mesh;
    struct qg_plate plate;
    double center;                  /* mm: x of the axis; y is 0 */
    double *displacement;           /* mm, [2 node_count]: x and y */
    struct qg_plane_stress *stress; /* [node_count]; x is absolute, too */
    double force[2];                /* N, of the contact on this gear */
    double contact_moment;          /* N mm, of the same about this gear's axis */
    double reaction[2];             /* N, at the bore, without the torque's own traction */
    double reaction_moment; /* N mm, at the bore about this gear's axis; the traction of a torque ring included */
    double work;            /* N mm: contact forces times elastic displacements, f'u */
};

/* A point of a flank that carries load. */
struct qg_field_load {
    int pair;         /* of teeth */
    double force;     /* N */
    double pressure;  /* MPa, qg_contact_pressure: 0 beside tip corners and where contact ends */
    double radius[2]; /* mm, on the pinion's and on the gear's flank */
};

struct qg_field {
    struct qg_field_gear gears[2];
    double position;        /* mesh periods */
    double torque;          /* N mm on the pinion */
    double approach;        /* mm, of the contact problem: the static transmission error */
    double approach_energy; /* mm, out of the field, as above */
    size_t load_count;
    struct qg_field_load *load;
};

/* What the field of a model is wanted for. */
struct qg_field_state {
    const struct qg_relief *relief;
    size_t site;         /* of the model: a position of its period */
    double torque;       /* N mm, > 0, at most the largest that the model was made for */
    struct qg_stop stop; /* asked before each gear, and around its factorization */
};

/* Computes the field of a model. QG_OUT_OF_MEMORY, QG_NO_CONVERGENCE, or QG_CANCELLED when the state's stop said so. field
 * is the caller's to finish, whatever the status. Threads: any; the model is only read.
 * Time and memory grow fast with the mesh. Of case_S_standard at mesh_refinement 1, 2 and 4: 1, 5 and 43 s of processor time,
 * 210 and 670 MB and 2.8 GB at the peak, model and text included, as /usr/bin/time says of
 * quietgear export --format vtk --threads 1. A gear's factorization, which nothing can stop, is up to a quarter of it. */
enum qg_status qg_field_init(struct qg_field *field, const struct qg_model *model, const struct qg_field_state *state);

/* What qg_field_compute is asked for. */
struct qg_field_plan {
    const struct qg_gear_pair *pair;
    const struct qg_analysis *analysis; /* its load cases and number of positions do not matter */
    const struct qg_relief *relief;
    double position; /* mesh periods, anywhere */
    double torque_fraction;
};

/* The same from scratch: makes the model of that one position first, or takes the gears' compliances out of means->cache. notes
 * may say why not. As qg_field_init otherwise, with means->stop. */
enum qg_status qg_field_compute(struct qg_field *field, const struct qg_field_plan *plan, const struct qg_means *means,
                                struct qg_notes *notes);
void qg_field_finish(struct qg_field *field);

/* Where a node stands, undeformed (mm, absolute). */
void qg_field_node(const struct qg_field *field, int gear, size_t node, double xy[2]);

#endif
