/* One whole job: a gear pair, how to compute, what is asked; and the answer.
 *
 * qg_study_run is a pure function of the study: same study, same bits, for any means and however often it was
 * interrupted. The observer sees every finished evaluation and may hand back earlier ones instead of having them computed:
 * the log of evaluations is the checkpoint.
 *
 * With several objectives the answer is their Pareto front, drawn from all evaluations of the search and the reference. Its
 * `design` is one of them: whose largest ratio to the reference, over the objectives, is smallest. It improves on the
 * reference as evenly as any, and it is known at any time of the search.
 *
 * F_DTE_PERCENTILE is a percentile of F_DTE over trials with manufacturing errors, the same errors for all designs, so that
 * it is a function of the design. A judged design is one evaluation, however many trials it took. The trials are others
 * than those of the reliability that judges the answer.
 */
#ifndef QG_CORE_STUDY_H
#define QG_CORE_STUDY_H

#include <stdint.h>

#include "core/front.h"
#include "core/grid.h"
#include "core/iso6336.h"
#include "core/macro_keep.h"
#include "core/model.h"
#include "core/multistart.h"
#include "core/reliability.h"

enum qg_study_kind {
    QG_STUDY_EVALUATE,    /* one design */
    QG_STUDY_OPTIMIZE,    /* search for the best design within bounds, optionally its reliability */
    QG_STUDY_RELIABILITY, /* reliability of the given design */
    QG_STUDY_MAP,         /* both objectives in every cell of a grid */
    QG_STUDY_MACRO,       /* search for equivalent pairs of a higher contact ratio, the best of them judged */
    QG_STUDY_KIND_COUNT
};

enum qg_objective {
    QG_OBJECTIVE_F_DTE,
    QG_OBJECTIVE_F_PPS,
    QG_OBJECTIVE_F_DTE_PERCENTILE, /* a percentile of F_DTE under manufacturing errors: of the reliability's */
    QG_OBJECTIVE_COUNT
};

/* Several objectives at once: an optimization for their Pareto front. */
struct qg_objectives {
    size_t count; /* 0: the study's one objective; else 2 or more */
    enum qg_objective item[QG_OBJECTIVE_COUNT];
};

/* The box of a search: which parameters move, and between what (mm). */
struct qg_bounds {
    size_t count;                                    /* 1..QG_PARAMETER_COUNT in an optimization */
    enum qg_parameter parameter[QG_PARAMETER_COUNT]; /* ascending, no repeats */
    double lower[QG_PARAMETER_COUNT], upper[QG_PARAMETER_COUNT];
};

/* How to search. Random-Simplex is the paper's: uniform samples in the box, then Nelder-Mead from the best of them. */
enum qg_search_method {
    QG_SEARCH_RANDOM_SIMPLEX,
    QG_SEARCH_MULTISTART_SIMPLEX, /* multistart.h */
    QG_SEARCH_METHOD_COUNT
};

struct qg_optimizer {
    size_t random_samples;     /* of Random-Simplex, >= 1 */
    size_t simplex_iterations; /* of Random-Simplex, >= 0 */
    uint64_t seed;
    enum qg_search_method method;
    size_t evaluations;         /* of the others: the whole budget, >= 1 */
    size_t starts;              /* of the multi-start simplex, 1 .. QG_STARTS_MAX */
    size_t verification_factor; /* the answer is judged again at so many times the mesh positions; 0: it is not */
};

struct qg_study {
    enum qg_study_kind kind;
    struct qg_gear_pair pair;
    struct qg_analysis analysis;
    struct qg_relief relief; /* the design (evaluate, reliability) or the reference (optimize, map); none in macro */
    enum qg_objective objective;
    struct qg_objectives objectives;
    struct qg_bounds bounds;
    struct qg_grid grid; /* of a map */
    struct qg_macro macro;
    struct qg_optimizer optimizer;
    struct qg_reliability reliability;
};

/* Phases of a study, in order; a study passes only through those that it needs. The log of evaluations keeps their numbers:
 * new ones come last. */
enum qg_phase {
    QG_PHASE_COMPLIANCE,
    QG_PHASE_REFERENCE, /* the given design */
    QG_PHASE_RANDOM,
    QG_PHASE_SIMPLEX,
    QG_PHASE_RELIABILITY,
    QG_PHASE_MAP,
    QG_PHASE_SAMPLING,   /* of macro-geometries, by closed formulas: no evaluations */
    QG_PHASE_CANDIDATES, /* those kept, by finite elements */
    QG_PHASE_MULTISTART,
    QG_PHASE_VERIFICATION, /* no evaluations */
    QG_PHASE_COUNT
};

/* "compliance", "reference", "random", "simplex", "reliability", "map", "sampling", "candidates", "multistart", "verification". */
const char *qg_phase_name(enum qg_phase phase);

/* One candidate tried. Numbers count from 0 through the whole study (the reference design is 0). */
struct qg_evaluation {
    size_t number;
    enum qg_phase phase;
    double parameter[QG_PARAMETER_COUNT]; /* mm; all eight of the design, 0 where its ramp is absent. In the phase
                                             "candidates", where designs have no relief: [0] is the number of the
                                             sample, below 2^53 */
    double f_pps;                         /* mm; NaN for a candidate that could not be judged */
    double f_dte;                         /* NaN when only statics was asked */
    double f_dte_percentile;              /* NaN unless it is an objective */
};

/* Steps done of the total; a step is a random sample, a simplex iteration, an evaluation of another search, a trial, a cell
 * of a map, a block of a million macro-geometries, one of the 2 keep candidates that there may be, the verification, the reference or the
 * compliance. */
struct qg_progress {
    size_t done, total;
    enum qg_phase phase;
    bool has_best;
    double best; /* best objective so far, as in struct qg_history_entry */
};

/* How a study is watched. Any member may be NULL. All calls come from the thread that called qg_study_run. */
struct qg_observer {
    void *self;
    /* Fills f_pps, f_dte and f_dte_percentile of an evaluation whose number, phase and parameters are given, and returns true, when it is
     * known from an earlier run; returns false when it has to be computed. Known ones are always a prefix. */
    bool (*recall)(void *self, struct qg_evaluation *evaluation);
    /* n evaluations were computed, in ascending order of number. QG_OK, or the study stops with that status. */
    enum qg_status (*record)(void *self, const struct qg_evaluation *evaluations, size_t n);
    void (*progress)(void *self, const struct qg_progress *progress);
    /* The reference design has been computed / a better design than all before: valid during the call. */
    void (*reference)(void *self, const struct qg_design_result *result);
    void (*improved)(void *self, const struct qg_design_result *result);
    /* Asked often, also from the executor's threads: true stops the study with QG_CANCELLED. Comes beside means->stop,
     * which is asked while models are made only when this is NULL. */
    bool (*cancelled)(void *self);
    struct qg_clock clock;
};

struct qg_history_entry {
    size_t evaluation; /* number */
    double best;       /* objective, core's units; of several the largest ratio to the reference's */
};

/* Objectives of a map's cells: F_DTE and F_PPS, the first of enum qg_objective. A candidate of macro is judged by
 * one of them, too. */
enum { QG_MAP_OBJECTIVES = 2 };

/* Both objectives in all cells of the study's grid, in the order of grid.h. */
struct qg_map {
    size_t cells;                     /* 0 unless map */
    double *value[QG_MAP_OBJECTIVES]; /* per objective and cell: F_DTE, F_PPS in mm */
};

/* One pair that a macro study has kept, and what finite elements say of it without relief. */
struct qg_macro_candidate {
    struct qg_macro_point point;
    bool on_front, among_best;
    struct qg_gear_pair pair;
    double pressure_angle_deg;        /* of the pair: exactly what became its rack's angle */
    struct qg_pair_geometry geometry; /* of the pair */
    bool is_possible;  /* false: the sample passed on the edge of rounding, and the geometry says nothing */
    size_t evaluation; /* its number in the log */
    bool judged;       /* false: no finite-element model could be made; the following figures are NaN */
    double f_pps;      /* mm */
    double f_dte;
    double max_contact_pressure; /* MPa, over the load cases */
    double max_root_stress;      /* MPa, tension, over both gears and the load cases */
    double loaded_contact_ratio; /* at the largest load case */
    double mean_mesh_stiffness;  /* N/mm, at the largest load case */
};

struct qg_macro_result {
    uint64_t samples, passed, rejected[QG_MACRO_CONSTRAINTS]; /* samples is 0 unless macro */
    struct qg_macro_rating initial;                           /* the initial pair */
    size_t front_count;   /* points on the front, of which at most `keep` are candidates */
    size_t front_dropped; /* for which there was no room (macro_keep.h) */
    size_t count;
    struct qg_macro_candidate *candidate; /* largest contact ratio first */
    size_t best;                          /* the candidate that is the design; count when there is none */
};

/* Reference and answer of an optimization at more mesh positions; [0] is the reference, [1] the answer. */
struct qg_verification {
    int mesh_positions; /* 0: not verified */
    double f_pps[2];    /* mm */
    double f_dte[2];
};

struct qg_study_result {
    struct qg_pair_geometry geometry;
    bool is_rated;             /* false where the formulas have no value: a warning then says so */
    struct qg_iso6336 iso6336; /* under the nominal torque, without reliefs */
    struct qg_model_size size;
    struct qg_design_result *design;    /* the answer; of a map the cell, of macro the candidate with the smallest
                                           objective; NULL when macro has no candidate */
    struct qg_design_result *reference; /* the given design; NULL unless optimize, map or macro (the initial pair) */
    size_t evaluations;                 /* of the search; 0 unless optimize */
    size_t simplex_iterations;          /* done, of Random-Simplex */
    size_t history_count;
    struct qg_history_entry *history; /* every improvement of the best, first to last */
    struct qg_front
        front;          /* all evaluations that none beats; values are ratios to the reference's; empty unless several
                              objectives were asked */
    double hypervolume; /* of that front, towards the reference (front.h) */
    struct qg_reliability_result reliability;
    struct qg_verification verification;
    struct qg_map map;
    struct qg_macro_result macro;
    struct {
        double wall, compliance, statics, dynamics; /* s; 0 without a clock */
    } timing;
    struct qg_notes warnings;
};

/* Whether an optimization or a map looks at an objective: as its one objective, or among several. Any thread. */
bool qg_study_asks(const struct qg_study *study, enum qg_objective objective);

/* Checks a study before it is run: geometry of the pair, relief and bounds against it, consistency of the analysis.
 * errors gets every fault found; warnings what is legal but does nothing. geometry (may be NULL) is filled when the pair is
 * possible. Returns QG_OK or QG_IMPOSSIBLE_GEAR. Milliseconds at most. */
enum qg_status qg_study_check(const struct qg_study *study, struct qg_pair_geometry *geometry, struct qg_notes *errors,
                              struct qg_notes *warnings);

/* Runs a checked study. result is initialised by the call and must be given to qg_study_result_finish, whatever the
 * status. observer may be NULL. */
enum qg_status qg_study_run(const struct qg_study *study, const struct qg_means *means,
                            const struct qg_observer *observer, struct qg_study_result *result);
void qg_study_result_finish(struct qg_study_result *result);

/* To be called once by a program before its other threads start. One thread inside BLAS, because parallelism is the
 * executor's; arrays of a megabyte and more go back to the system when they are freed; and a buffer of BLAS for each of so
 * many threads and for each that OpenBLAS has started itself (64 at most). OpenBLAS maps those when they are first needed,
 * 128 MiB of addresses each, and asks again for ever when there is no room; here that is found out before. False when there
 * is none: then the program should say so and end by _exit, for a thread of OpenBLAS may be asking already, and exit waits
 * for it. */
bool qg_numerics_init(int threads);

#endif
