/* One gear pair made ready for judging many relief designs, and what one design yields.
 *
 * qg_model_create does what does not depend on the relief: finite elements of both gears, compliance between flank points,
 * the contact operators at every mesh position. After that the model is constant and may be shared by all threads; a design
 * costs some small contact problems (statics) and the speed map (dynamics).
 */
#ifndef QG_CORE_MODEL_H
#define QG_CORE_MODEL_H

#include <stdbool.h>

#include "core/branches.h"
#include "core/cache.h"
#include "core/dynamics.h"
#include "core/executor.h"
#include "core/relief.h"
#include "core/stress.h"

enum qg_plane { QG_PLANE_STRESS, QG_PLANE_STRAIN };

/* How the pinion is held; the gear's bore is always fixed. */
enum qg_bore {
    QG_BORE_TORQUE_RING, /* pinion bore radially rigid, torque as uniform tangential traction, rotation = mean of the bore */
    QG_BORE_CLAMPED      /* pinion bore fixed like the gear's */
};

enum qg_mesh_stiffness {
    QG_STIFFNESS_SECANT,        /* k = F/delta, e = 0 in the equation of motion */
    QG_STIFFNESS_CONSISTENT,    /* k = F/(delta - e), e in the equation of motion */
    QG_STIFFNESS_LOAD_DEPENDENT /* no stiffness but the force F(phi, delta) itself (force.h), on both flanks; lengths of
                                   time and p refer to the mean secant stiffness at the case's load, so that p and the
                                   natural frequency compare with those of the secant definition */
};

/* Whether all branches are looked for, beside the responses of the speed map. */
enum qg_branches_asked { QG_BRANCHES_NONE, QG_BRANCHES_ALL };

enum { QG_CASES_MAX = 16, QG_POSITIONS_MAX = 512, QG_SPEEDS_MAX = 100000, QG_REFINEMENT_MAX = 4 };

/* Pairs of teeth are numbered -QG_PAIR_REACH .. QG_PAIR_REACH; pair 0 is at the middle of the path at phi = 0.5. */
enum { QG_PAIR_REACH = 3, QG_PAIR_COUNT = 2 * QG_PAIR_REACH + 1 };

/* How to compute. */
struct qg_analysis {
    size_t case_count;
    double torque_fraction[QG_CASES_MAX]; /* of the nominal torque, > 0 */
    int mesh_positions;                   /* N, at phi = i/N */
    int mesh_refinement;                  /* 1 is converged to 0.2 %; n divides every element edge by n */
    enum qg_plane plane;
    enum qg_bore bore;
    enum qg_mesh_stiffness mesh_stiffness;
    int harmonics; /* of kappa and e, <= (N - 1) / 2 */
    struct qg_speed_map speeds;
    enum qg_branches_asked branches; /* of one design; searches do without */
};

/* What one load case of one design yields. Arrays over mesh positions have N entries, those over speeds speeds.count. */
struct qg_case_result {
    double torque;                       /* N mm */
    double normal_force;                 /* N, torque / base radius of the pinion */
    double *static_transmission_error;   /* mm, per position */
    double *unloaded_transmission_error; /* mm, per position */
    double *mesh_stiffness;              /* N/mm, per position, by the chosen definition; load_dependent: dF/ddelta at
                                            the case's load (the secant when dynamics were not asked for) */
    double *load_share;                  /* per position and pair: [i * QG_PAIR_COUNT + k + QG_PAIR_REACH], sums to 1 */
    double *contact_pressure;            /* MPa, largest at each position, tip corners left out (statics.h) */
    double mean_mesh_stiffness;      /* N/mm, mean of mesh_stiffness over the period; load_dependent: of the secant */
    double pps;                      /* mm, peak to peak of the static transmission error */
    double loaded_contact_ratio;     /* pairs carrying load, averaged over the positions */
    double max_contact_pressure;     /* MPa */
    double complementarity_residual; /* largest violation of the contact conditions, relative (contact.h) */
    double natural_frequency;        /* Hz, sqrt(k_mean / m) / (2 pi) */
    double max_rms;                  /* of the DTE over all speeds, half-backlashes; NaN without dynamics */
    double max_rms_at;               /* the frequency ratio where */
    size_t speeds_beyond;            /* load_dependent: speeds whose orbit left the ladder of loads (force.h) */
    struct qg_response *response;    /* per speed */
    struct qg_branches *branches;    /* owned; NULL unless qg_evaluate_branches has filled it in */
    struct qg_stresses *stresses;    /* owned; NULL unless qg_evaluate_stresses has filled it in */
};

/* What one design yields. */
struct qg_design_result {
    struct qg_gear_pair pair; /* that was judged */
    double backlash;          /* mm, its normal backlash: f_dte and rms are in halves of it */
    struct qg_relief relief;
    double f_pps; /* mm, largest pps of all cases */
    double f_dte; /* largest max_rms of all cases; NaN without dynamics */
    double
        f_dte_percentile; /* under manufacturing errors; NaN unless a study has asked (qg_evaluate leaves it alone) */
    size_t positions, speeds, case_count;
    struct qg_case_result cases[QG_CASES_MAX];
    double *storage; /* behind the arrays over positions of all cases */
};

/* Room for one result with the model's sizes. NULL when memory is short. */
struct qg_design_result *qg_design_result_create(const struct qg_analysis *analysis);
void qg_design_result_destroy(struct qg_design_result *result);

struct qg_model;

/* What building a model cost and how large it is. */
struct qg_model_size {
    size_t degrees_of_freedom[2]; /* unknowns of one tooth sector's finite elements, per gear */
    size_t flank_nodes[2];
};

/* What a computation may use. */
struct qg_means {
    struct qg_executor executor;
    struct qg_cache *cache;    /* of compliances; NULL: none is kept */
    struct qg_stop stop;       /* asked while a model or a field is made, from the executor's threads, too */
    double operator_bytes_max; /* the contact operators of one model may take so many bytes, else making it ends with
                                  QG_OUT_OF_MEMORY; 0: any. For what memory.h cannot know before */
};

/* Checks the pair (notes say what is impossible) and builds the model; the two gears are computed as two pieces of the
 * executor, unless the cache has them. On QG_OK *model is owned by the caller. QG_CANCELLED when means->stop said so, which
 * takes no longer than the factorization or the mesh position at work. */
enum qg_status qg_model_create(const struct qg_gear_pair *pair, const struct qg_analysis *analysis,
                               const struct qg_means *means, struct qg_notes *notes, struct qg_model **model);
/* The same for one mesh position anywhere in the period: analysis->mesh_positions is taken as 1. */
enum qg_status qg_model_create_at(const struct qg_gear_pair *pair, const struct qg_analysis *analysis, double position,
                                  const struct qg_means *means, struct qg_notes *notes, struct qg_model **model);
void qg_model_destroy(struct qg_model *model);

/* The contact operators (statics.h); they live as long as the model. */
struct qg_statics;
const struct qg_statics *qg_model_statics(const struct qg_model *model);

const struct qg_gear_pair *qg_model_pair(const struct qg_model *model);
const struct qg_pair_geometry *qg_model_geometry(const struct qg_model *model);
const struct qg_analysis *qg_model_analysis(const struct qg_model *model);
struct qg_model_size qg_model_size(const struct qg_model *model);

/* An outside clock: core has none. */
struct qg_clock {
    double (*now)(void *self); /* seconds, monotonic; NULL: times are not taken */
    void *self;
};

struct qg_statics_workspace;

/* The seam between searches and computing power: designs in, figures of merit out. */
struct qg_evaluator {
    const struct qg_model *model;
    struct qg_executor executor;
    struct qg_statics_workspace *workspace; /* one per worker */
    bool (*cancelled)(void *self);          /* may be NULL; asked before each piece, from any thread */
    void *self;
    struct qg_clock clock;
    struct {
        double statics, dynamics; /* s of wall time so far */
    } times;
};

/* Makes the workspaces. model must outlive the evaluator; cancelled, self and clock may be set afterwards. */
enum qg_status qg_evaluator_init(struct qg_evaluator *evaluator, const struct qg_model *model,
                                 const struct qg_executor *executor);
void qg_evaluator_finish(struct qg_evaluator *evaluator);

/* Judges n designs: the statics of all as one batch of pieces, then (if dynamics is set) the speed maps of all as another.
 * results[i]->relief is the input, the rest is filled in, the model's pair included. QG_CANCELLED when `cancelled` said so; the results are then
 * incomplete. */
enum qg_status qg_evaluate(struct qg_evaluator *evaluator, bool dynamics, size_t n,
                           struct qg_design_result *const *results);

/* Looks for all branches of a design that qg_evaluate has judged, in the range of the model's speeds: one piece per load
 * case. QG_OUT_OF_MEMORY, or QG_CANCELLED when `cancelled` said so; the branches are then incomplete. */
enum qg_status qg_evaluate_branches(struct qg_evaluator *evaluator, struct qg_design_result *result);

/* Finds the stresses of a design that qg_evaluate has judged, all load cases: one piece per mesh position. Not part of
 * qg_evaluate, which searches call for thousands of designs. QG_OUT_OF_MEMORY, or QG_CANCELLED when `cancelled` said so; the
 * stresses are then incomplete. */
enum qg_status qg_evaluate_stresses(struct qg_evaluator *evaluator, struct qg_design_result *result);

#endif
