/* A contact model of the whole mounted pair for an external finite-element program, as plain numbers: nodes, elements,
 * contact pairs, supports and loads. Writing it down in a program's own language is schema's business (abaqus.h).
 *
 * It is the same problem as that of statics.h, stated another way round: both whole gears meshed, the reliefs in the mesh and
 * not as gaps, contact found by the program and not by our own solver. So it checks this project's approximations by a
 * program that knows none of them.
 *
 * Plane stress. Programs that expand plane elements to solids make a slab of finite width out of plane stress, and the
 * answer depends on that width. In the plane, Hooke's law of plane stress with (E, nu) is that of plane strain with
 *     E' = E (1 + 2 nu) / (1 + nu)^2,    nu' = nu / (1 + nu)
 * so plane-strain elements with these constants are plane stress exactly, as far as displacements and stresses in the
 * plane go; the stress out of the plane is then to be ignored.
 *
 * Contact. Every pair of teeth that may touch is a contact pair of its own, in which the flank whose tip corner may engage
 * is the slave: the gear's in approach, the pinion's in recess. With the other choice penalty contact finds equilibria that
 * depend on the path of loading.
 *
 * Seat. With free play between the flanks the pinion could turn without resistance, and a static program would find no
 * equilibrium. It is therefore drawn turned until the first flanks touch, and a hair further (`overlap`); the static
 * transmission error is the turn in the drawing plus the one that the program finds: STE = seat + r_b1 theta.
 */
#ifndef QG_CORE_DECK_H
#define QG_CORE_DECK_H

#include "core/gear_mesh.h"
#include "core/model.h"

/* The teeth of a deck at refinement 1: fine enough for the static transmission error to 1 % and the root stress to some 3 %,
 * coarse enough for an answer in some seconds. */
extern const struct qg_mesh_density qg_density_deck;

/* What is to be written down. */
struct qg_deck_plan {
    const struct qg_gear_pair *pair;
    const struct qg_pair_geometry *geometry;
    const struct qg_relief *relief;
    enum qg_plane plane;
    enum qg_bore bore;
    int refinement;  /* divides every element edge; 1 solves in some seconds and is good to 1 % */
    double position; /* mesh periods */
    double torque;   /* N mm on the pinion, > 0 */
};

/* One pair of teeth that may touch. */
struct qg_deck_contact {
    int pair;     /* -QG_PAIR_REACH .. QG_PAIR_REACH */
    int slave;    /* the gear whose flank is the slave surface */
    int tooth[2]; /* the fine tooth (gear_mesh.h) of each gear */
};

struct qg_deck {
    struct qg_gear_mesh mesh[2];
    double angle[2];  /* rad: by which each mesh is turned about its axis, the pinion's with its seat */
    double center[2]; /* mm: x of the axes; y is 0 */
    double base_radius[2];
    double thickness[2];                  /* mm */
    double youngs_modulus, poisson_ratio; /* MPa; for plane-strain elements */
    double penalty;                       /* N/mm3 */
    size_t contact_count;
    struct qg_deck_contact contact[QG_PAIR_COUNT];
    double touch; /* mm along the line of action: the turn at which the first flanks touch */
    double seat;  /* mm: the turn in the drawing */
    double position, torque;
    enum qg_plane plane;
    enum qg_bore bore;
};

/* Builds the model. The plan's pair must have passed qg_pair_derive and its relief qg_relief_check. QG_OUT_OF_MEMORY, or
 * QG_NO_CONVERGENCE when the gears cannot be meshed (in notes). The caller frees it with qg_deck_finish. */
enum qg_status qg_deck_init(struct qg_deck *deck, const struct qg_deck_plan *plan, struct qg_notes *notes);
void qg_deck_finish(struct qg_deck *deck);

/* Where a node stands in the drawing (mm). */
void qg_deck_node(const struct qg_deck *deck, int gear, size_t node, double xy[2]);

/* Absolute angle (rad) of a node about its gear's axis. */
double qg_deck_node_angle(const struct qg_deck *deck, int gear, size_t node);

#endif
