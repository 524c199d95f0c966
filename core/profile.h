/* The tooth profile of a gear as it is drawn and made, and the pair as it is mounted.
 *
 * Half a tooth, from the middle of the space to the tooth's centre line, is a chain of pieces:
 *     root circle - root curve (trochoid) - [step] - flank (involute less its relief), cut at the relief's kinks - tip circle.
 * The tooth is symmetric: both flanks get the relief.
 *
 * Relief is taken off along the involute's normal. At roll length xi (the length of the string that unwinds the involute,
 * sqrt(radius^2 - r_b^2)) the involute is r_b e1 + xi e2 with e2 the normal, so the relieved flank is r_b e1 + (xi - depth) e2:
 * its distance from the axis is that of the involute at xi - depth. The flank goes on until that reaches the tip circle,
 * with the relief that it has at the outside radius. Towards the root the relief ends at the form radius with its full
 * amplitude, and the root curve stands as the hob left it: between them is a step along the normal.
 *
 * Units as everywhere in core: mm, rad. Threads: any, everything given is only read.
 */
#ifndef QG_CORE_PROFILE_H
#define QG_CORE_PROFILE_H

#include "core/biarc.h"
#include "core/study.h"

/* A gear with its relief. The three must be valid (qg_study_check) and outlive what is made from them. */
struct qg_made_gear {
    const struct qg_gear_pair *pair;
    const struct qg_pair_geometry *geometry;
    const struct qg_relief *relief;
    int gear; /* QG_PINION or QG_GEAR */
};

enum qg_piece_kind {
    QG_PIECE_ROOT_CIRCLE, /* from, to: angle from the tooth's centre line */
    QG_PIECE_ROOT_CURVE,  /* the parameter of qg_trochoid_point */
    QG_PIECE_STEP,        /* mm below the involute at the form radius */
    QG_PIECE_FLANK,       /* mm of roll length */
    QG_PIECE_TIP_CIRCLE   /* angle from the tooth's centre line */
};

/* One smooth piece of the profile. */
struct qg_piece {
    enum qg_piece_kind kind;
    double from, to;
};

enum { QG_PIECES_MAX = 8 };
struct qg_profile {
    struct qg_made_gear made;
    size_t count;
    struct qg_piece piece[QG_PIECES_MAX];
};

/* Takes the profile apart into its pieces, from the middle of the space to the tooth's centre line. */
void qg_profile_init(struct qg_profile *profile, const struct qg_made_gear *made);

/* A point of a piece, exact to rounding, at `share` (0 to 1) of the way in its parameter. The tooth's centre line is the
 * x axis, the contact flank on the side of positive y. */
struct qg_point qg_profile_at(const struct qg_profile *profile, size_t piece, double share);

/* Appends half a tooth, from the middle of the space to the centre line, both included: straight chords, or arcs, no point of
 * the exact profile further than tolerance (mm) from them. Circles of root and tip are exact as arcs.
 * Returns QG_OK or QG_OUT_OF_MEMORY. */
enum qg_status qg_profile_chords(const struct qg_profile *profile, double tolerance, struct qg_outline *outline);
enum qg_status qg_profile_arcs(const struct qg_profile *profile, double tolerance, struct qg_outline *outline);

/* Runs an outline backwards. */
void qg_outline_reverse(struct qg_outline *outline);

/* Turns an outline about the origin by an angle (rad, counter-clockwise), then moves it along x by shift (mm). */
void qg_outline_turn(struct qg_outline *outline, double angle, double shift);

/* Continues an open outline, which ends on the x axis, by its own mirror image in that axis, run backwards. Two arcs that
 * meet on the axis become one. Half a tooth becomes a whole one: clockwise from the middle of one space to that of the next.
 * QG_OK or QG_OUT_OF_MEMORY. */
enum qg_status qg_outline_mirror(struct qg_outline *outline);

/* Appends to the empty outline `ring` the copies of a whole tooth (as qg_outline_mirror makes it) that fill a gear of so many
 * teeth: a closed chain, clockwise, whose last corner has the bulge of the edge back to the first. Two arcs that meet in the
 * middle of a space become one. QG_OK or QG_OUT_OF_MEMORY. */
enum qg_status qg_outline_ring(const struct qg_outline *tooth, int teeth, struct qg_outline *ring);

/* ---- the profile diagram ---------------------------------------------------------------------------------------- */

/* Roll length (mm) of a radius (mm) >= the base radius, and back. */
double qg_roll_length(const struct qg_gear_geometry *gear, double radius);
double qg_radius_of_roll(const struct qg_gear_geometry *gear, double roll_length);

/* Roll lengths (mm) that matter on a flank. */
struct qg_marks {
    double form;  /* where the involute begins */
    double start; /* start of active profile (SAP): the mate's tip touches here */
    double pitch; /* the pitch point */
    double end;   /* end of active profile (EAP): the own tip */
    /* Between these one pair alone carries the load: lowest and highest point of single tooth contact (LPSTC: the pair ahead
     * leaves at its own end; HPSTC: the pair behind enters at its own start), a base pitch from end and start. NaN at contact
     * ratios of 2 and more, where no pair is ever alone. */
    double lowest_single, highest_single;
};
void qg_profile_marks(const struct qg_pair_geometry *geometry, int gear, struct qg_marks *marks);

/* Fills roll[0..count-1] with roll lengths (mm), ascending from form radius to tip, that draw the relief's curve: evenly
 * spread, with the nearest ones moved onto the kinks. count >= 8. */
void qg_diagram_rolls(const struct qg_made_gear *made, size_t count, double *roll);

/* The least and the most that may be taken off under the bounds of a search or the axes of a map: two designs between whose
 * curves every design of the box lies. Both are the study's relief when nothing moves. */
void qg_study_extremes(const struct qg_study *study, struct qg_relief *least, struct qg_relief *most);

/* ---- the mounted pair ------------------------------------------------------------------------------------------- */

/* A place where two flanks touch. */
struct qg_touch {
    int pair;       /* number of the pair of teeth, 0 is the reference pair */
    double roll[2]; /* mm, on both flanks */
    struct qg_point at;
};

/* The pair at one mesh position: the pinion's axis at (0, 0), the gear's at (centre distance, 0), the pinion turning
 * counter-clockwise and driving. */
struct qg_mounted {
    double angle[2]; /* rad, of the centre line of the reference pair's tooth on each gear, from the x axis */
    size_t count;
    struct qg_touch touch[QG_PAIR_COUNT];
};

/* Where the bare involutes touch at a mesh position (in mesh periods; 0.5 puts the reference pair at the middle of the path
 * of contact, as in statics.h). A relief opens a gap of micrometres there. */
void qg_mounted_at(const struct qg_pair_geometry *geometry, const struct qg_gear_pair *pair, double position,
                   struct qg_mounted *mounted);

/* The point of the line of action at a distance (mm) from where it touches the pinion's base circle. */
struct qg_point qg_action_point(const struct qg_pair_geometry *geometry, double xi);

#endif
