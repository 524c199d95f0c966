/* What a study holds at its peak. See memory.h.
 *
 * Let F be the elements of a flank at refinement 1, r the refinement, and of one gear n the components of force on its flank,
 * m the unknowns on its sector's boundary, N those of the sector, p its root points (qg_sector_size). Bytes, doubles of 8:
 *   compliance   kept: 8 (n^2 + n m + 13 m^2 + p (n + m)), 13 tooth distances (compliance.h); at work: CHOLMOD's factor with
 *                what it needs beside, N (1750 + 2.2 sqrt N), fitted above all of tests/core/test_memory.c (a factor of a
 *                plane mesh grows a little faster than its unknowns), and the rows of stress, 16 p (n + m)
 *   operators    while they are made: both compliances, flank matrices 8 (d + 1) n^2, stress rows 8 (2 d + 3) p n, d the largest
 *                distance between pairs that touch; kept: the rows, and for each of the P mesh positions with its c
 *                contact points 8 c^2 + 600 c
 *   workers      8 c^2 each for a contact problem
 *   designs      a result is 8 * 11 P + 48 S bytes for each load case, S the speeds; a batch holds QG_SEARCH_BATCH of them, a
 *                search for a percentile twice as many; with a force that depends on the load its tables beside each
 *   log, texts   the evaluations; the curves as JSON and CSV, and what a database holds of them while it stores them: some 200
 *                characters for each speed of each load case of each design in the answer
 * Peak: the largest of making the compliances, making the operators, judging designs; of a verification or a candidate pair the
 * same once more on top of the model that stays. Both gears' compliances are made at the same time on two threads or more.
 * c is counted on the involutes as statics.c lays the points. It depends on the approach under the largest load, which is
 * taken as F/(E b) times 60 and what the body between bore and flank twists, (1 + nu)/pi (r^2/r_bore^2 - 1): three fair
 * gears have 28 to 39 in all.
 */
#include "core/memory.h"

#include <math.h>

#include "core/attractors.h"
#include "core/force.h"
#include "core/mesh.h"
#include "core/statics.h"

/* Bytes of this and that. */
static const double word = 8, of_point = 600, of_program = 10e6, of_worker = 0.5e6, of_branches = 8e6,
                    of_sampling = 33 * (double)sizeof(struct qg_macro_tally);
/* Characters. Of a speed: its frequency response as JSON and as CSV, and the latter once more as the database's record; of a
 * mesh position and of a map's cell: the result as it is written, stored, and read. */
static const double text_of_speed = 50 + 2 * 80, text_of_position = 3 * 400, text_of_cell = 3 * 60;
/* Attractors that a speed may have, for the worst branch: more than any seen. */
static const double attractors_of_speed = 4;

/* ---- sizes ------------------------------------------------------------------------------------------------------- */

struct qg_sector_size qg_sector_size(int flank_elements, int refinement, bool floating) {
    const struct qg_mesh_density *d = &qg_density_analysis;
    double r = refinement, flank = flank_elements < 4 ? 4 : flank_elements;
    double across = d->tooth_columns + 2 * d->root_columns, sides = d->body_rows + d->foot_rows;
    struct qg_sector_size s;
    s.elements = r * r * (d->tooth_columns * (flank + d->fillet_rows) + across * d->foot_rows + across * d->body_rows);
    /* of a plane mesh of E eight-node quadrilaterals with B edges on its rim: 3 E + B + 1 nodes (Euler) */
    double rim = r * (2 * across + 2 * sides + 2 * (flank + d->fillet_rows));
    s.nodes = 3 * s.elements + rim + 1;
    s.unknowns = 2 * s.nodes;
    s.flank = 2 * (2 * r * flank + 1);
    s.boundary = 2 * (4 * r * sides) + (floating ? 4 * r * across / 2 + 1 : 0);
    s.roots = 2 * (2 * r * (d->root_columns + d->fillet_rows));
    return s;
}

/* What is counted once, at refinement 1: it does not depend on what qg_memory_advise varies. */
struct scale {
    int flank_elements[2];
    int distance;       /* between pairs of teeth that touch */
    double points;      /* root mean square over the mesh period */
    double most_points; /* at one position */
};

static int flank_elements(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, int gear) {
    const struct qg_gear_geometry *g = &geometry->gears[gear];
    double outside = pair->gears[gear].outside_radius;
    double arc = (outside * outside - g->form_radius * g->form_radius) / (2 * g->base_radius);
    return qg_flank_elements(&qg_density_analysis, arc / pair->rack.module);
}

/* An upper estimate of the approach (mm) of the pair under the study's largest load. */
static double largest_approach(const struct qg_study *study, const struct qg_pair_geometry *geometry) {
    const struct qg_gear_pair *pair = &study->pair;
    double most = 0, yielding = 0;
    for (size_t k = 0; k < study->analysis.case_count; k++)
        most = fmax(most, study->analysis.torque_fraction[k]);
    if (study->analysis.mesh_stiffness == QG_STIFFNESS_LOAD_DEPENDENT)
        most *= QG_FORCE_REACH;
    for (int g = 0; g < 2; g++) {
        double turns = 2 * geometry->gears[g].base_radius / pair->gears[g].bore_diameter;
        double twist = (1 + pair->material.poisson_ratio) / M_PI * fmax(0, turns * turns - 1);
        yielding += (30 + twist) / pair->gears[g].face_width;
    }
    double force = most * pair->nominal_torque / geometry->gears[QG_PINION].base_radius;
    return force / pair->material.youngs_modulus * yielding;
}

static struct scale scale_of(const struct qg_study *study) {
    enum { POSITIONS = 8 };
    struct qg_pair_geometry geometry;
    struct scale s = {.distance = 0};
    qg_pair_derive(&study->pair, &geometry, NULL); /* a checked study: the pair is possible */
    double reach = qg_statics_reach(&study->pair, &geometry, largest_approach(study, &geometry));
    for (int g = 0; g < 2; g++)
        s.flank_elements[g] = flank_elements(&study->pair, &geometry, g);
    for (int i = 0; i < POSITIONS; i++) {
        int pairs;
        double points = (double)qg_statics_count_points(&study->pair, &geometry, reach, (double)i / POSITIONS, &pairs);
        s.points += points * points / POSITIONS;
        s.most_points = fmax(s.most_points, points);
        s.distance = pairs - 1 > s.distance ? pairs - 1 : s.distance;
    }
    s.points = sqrt(s.points);
    return s;
}

/* The largest pair that a macro-geometry search may find: flanks of 4 modules, contact ratio 3. */
static struct scale scale_of_candidates(void) {
    int flank = qg_flank_elements(&qg_density_analysis, 4);
    double points = 3.0 * 2 * flank;
    return (struct scale){{flank, flank}, 4, points, points};
}

/* ---- a model ----------------------------------------------------------------------------------------------------- */

/* Bytes of the parts of a model's making and of what stays. */
struct model_bytes {
    double compliance; /* peak while they are made */
    double operators;  /* peak while these are made */
    double kept;
    double worker; /* of one worker's contact problem */
};

static double kept_of_compliance(const struct qg_sector_size *s) {
    return word * (s->flank * s->flank + s->flank * s->boundary + 13 * s->boundary * s->boundary +
                   s->roots * (s->flank + s->boundary));
}

static double work_of_compliance(const struct qg_sector_size *s) {
    return s->unknowns * (1750 + 2.2 * sqrt(s->unknowns)) + 2 * word * s->roots * (s->flank + s->boundary);
}

static struct model_bytes bytes_of_model(const struct scale *scale, const struct qg_analysis *a, int positions,
                                         int threads) {
    struct model_bytes out = {0};
    double made = 0, alone = 0, matrices = 0, rows = 0, r = a->mesh_refinement;
    double points = r * scale->points, most = r * scale->most_points;
    for (int g = 0; g < 2; g++) {
        bool floating = g == QG_PINION && a->bore == QG_BORE_TORQUE_RING;
        struct qg_sector_size s = qg_sector_size(scale->flank_elements[g], a->mesh_refinement, floating);
        double work = work_of_compliance(&s);
        alone = threads > 1 ? alone + work : fmax(alone, made + work);
        made += kept_of_compliance(&s);
        matrices += word * (scale->distance + 1) * s.flank * s.flank;
        rows += word * (2 * scale->distance + 3) * s.roots * s.flank;
    }
    out.compliance = threads > 1 ? alone + made : alone;
    out.kept = rows + positions * (word * points * points + of_point * points);
    out.operators = made + matrices + out.kept + threads * (2 * of_point * most + of_worker);
    out.worker = word * most * most + of_worker;
    return out;
}

/* ---- designs ----------------------------------------------------------------------------------------------------- */

static double bytes_of_design(const struct qg_analysis *a, int positions, bool dynamics) {
    double cases = (double)a->case_count;
    return cases * positions * word * (4 + QG_PAIR_COUNT) +
           (dynamics ? cases * (double)a->speeds.count * (double)sizeof(struct qg_response) : 0) +
           (double)sizeof(struct qg_design_result);
}

/* The tabulated force of one design; 0 where the force does not depend on the load. */
static double bytes_of_force(const struct qg_analysis *a) {
    double load[QG_FORCE_LEVELS_MAX];
    if (a->mesh_stiffness != QG_STIFFNESS_LOAD_DEPENDENT)
        return 0;
    double levels = (double)qg_force_ladder(a->torque_fraction, a->case_count, load),
           steps = (double)qg_force_steps(a->speeds.min, a->harmonics);
    return QG_FLANK_COUNT * 2 * steps * levels * (word + (double)sizeof(struct qg_force_piece)) +
           (double)sizeof(struct qg_force) + word * levels * a->mesh_positions;
}

/* Of the threads that look for the worst branch, or for all branches. */
static double bytes_of_attractors(const struct qg_analysis *a, int threads) {
    if (a->speeds.branch != QG_BRANCH_WORST && a->branches != QG_BRANCHES_ALL)
        return 0;
    double speeds = fmax((double)a->speeds.count, (a->speeds.max - a->speeds.min) / 0.0025 + 1);
    double pieces = fmin(threads, (double)(QG_SEARCH_BATCH * a->case_count));
    return pieces * speeds *
           (attractors_of_speed * (double)sizeof(struct qg_attractor) + 2 * sizeof(struct qg_response));
}

static bool searches(const struct qg_study *study) {
    return study->kind == QG_STUDY_OPTIMIZE || study->kind == QG_STUDY_MAP;
}

/* Designs in a batch that are judged with dynamics, those of a percentile included. */
static double designs_with_dynamics(const struct qg_study *study) {
    bool percentile = study->kind == QG_STUDY_OPTIMIZE && qg_study_asks(study, QG_OBJECTIVE_F_DTE_PERCENTILE);
    bool statics = study->kind == QG_STUDY_OPTIMIZE && !percentile && !qg_study_asks(study, QG_OBJECTIVE_F_DTE) &&
                   study->reliability.samples == 0;
    if (study->kind == QG_STUDY_EVALUATE || study->kind == QG_STUDY_MACRO || statics)
        return 1;
    return QG_SEARCH_BATCH * (percentile ? 2 : 1);
}

/* Results of designs, and what judging them takes beside. */
static double bytes_of_designs(const struct qg_study *study, int threads) {
    const struct qg_analysis *a = &study->analysis;
    double batch = designs_with_dynamics(study), kept = searches(study) || study->kind == QG_STUDY_MACRO ? 3 : 2;
    double stresses =
        2 * (double)a->case_count * a->mesh_positions *
        (4 * (double)sizeof(struct qg_root_stress) + QG_PAIR_COUNT * (double)sizeof(struct qg_pair_pressure));
    double branches = a->branches == QG_BRANCHES_ALL ? of_branches * (double)a->case_count : 0;
    return (batch + kept) * bytes_of_design(a, a->mesh_positions, true) +
           (QG_SEARCH_BATCH - fmin(batch, QG_SEARCH_BATCH)) * bytes_of_design(a, a->mesh_positions, false) +
           fmin(batch, QG_SEARCH_BATCH) * bytes_of_force(a) + bytes_of_attractors(a, threads) + stresses + branches;
}

/* ---- log and texts ----------------------------------------------------------------------------------------------- */

/* Evaluations that a study may make; as cost.c, but none too few. */
static double most_evaluations(const struct qg_study *study) {
    const struct qg_optimizer *o = &study->optimizer;
    double count = 1, trials = (double)study->reliability.samples;
    if (study->kind == QG_STUDY_MAP)
        return count + (double)qg_grid_cells(&study->grid);
    if (study->kind == QG_STUDY_MACRO)
        return count + 2 * (double)study->macro.keep;
    if (study->kind == QG_STUDY_OPTIMIZE)
        count += o->method == QG_SEARCH_RANDOM_SIMPLEX
                     ? (double)o->random_samples + 2 * (double)o->simplex_iterations + (double)study->bounds.count
                     : (double)o->evaluations;
    return study->kind == QG_STUDY_EVALUATE ? count : count + trials;
}

static double bytes_of_log(const struct qg_study *study) {
    double each = (double)(sizeof(struct qg_evaluation) + sizeof(struct qg_history_entry)) + word;
    if (study->objectives.count > 0)
        each += (double)sizeof(struct qg_front_member);
    if (study->kind == QG_STUDY_OPTIMIZE && study->optimizer.method == QG_SEARCH_MULTISTART_SIMPLEX)
        each += word * (double)(study->bounds.count + QG_OBJECTIVE_COUNT);
    return each * most_evaluations(study);
}

static double bytes_of_texts(const struct qg_study *study) {
    const struct qg_analysis *a = &study->analysis;
    double designs = searches(study) || study->kind == QG_STUDY_MACRO ? 2 : 1;
    double curves = designs * (double)a->case_count *
                    ((double)a->speeds.count * text_of_speed + a->mesh_positions * text_of_position);
    return curves + text_of_cell * (double)qg_grid_cells(&study->grid);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static int verified_positions(const struct qg_study *study) {
    size_t asked = study->optimizer.verification_factor * (size_t)study->analysis.mesh_positions;
    if (study->kind != QG_STUDY_OPTIMIZE || asked <= (size_t)study->analysis.mesh_positions)
        return 0;
    return asked < QG_POSITIONS_MAX ? (int)asked : QG_POSITIONS_MAX;
}

/* Making a model and judging in it. */
static double peak_of(const struct model_bytes *m, double designs, int threads) {
    return fmax(fmax(m->compliance, m->operators), m->kept + threads * m->worker + designs);
}

static double bytes_of(const struct qg_study *study, const struct scale *scale, int threads) {
    const struct qg_analysis *a = &study->analysis;
    struct model_bytes model = bytes_of_model(scale, a, a->mesh_positions, threads);
    double designs = bytes_of_designs(study, threads), peak = peak_of(&model, designs, threads),
           stays = model.kept + threads * model.worker + designs;
    int again = verified_positions(study);
    if (again > 0) {
        struct model_bytes finer = bytes_of_model(scale, a, again, threads);
        peak = fmax(peak, stays + peak_of(&finer, 2 * bytes_of_design(a, again, true), threads));
    }
    if (study->kind == QG_STUDY_MACRO) {
        const struct scale largest = scale_of_candidates();
        struct model_bytes candidate = bytes_of_model(&largest, a, a->mesh_positions, threads);
        peak = fmax(peak, stays + peak_of(&candidate, 0, threads)) + of_sampling;
    }
    return peak + bytes_of_log(study) + bytes_of_texts(study) + of_program;
}

double qg_study_memory(const struct qg_study *study, int threads) {
    const struct scale scale = scale_of(study);
    return bytes_of(study, &scale, threads);
}

/* ---- advice ------------------------------------------------------------------------------------------------------ */

/* A figure of a study that may be made smaller: exactly one of the two types. */
struct figure {
    const char *where;
    size_t *size;
    int *whole;
    size_t least;
};

enum { FIGURES = 9 };

static void figures_of(struct qg_study *study, struct figure out[FIGURES]) {
    struct qg_analysis *a = &study->analysis;
    struct qg_optimizer *o = &study->optimizer;
    const struct figure figures[FIGURES] = {
        {"analysis.mesh_refinement", NULL, &a->mesh_refinement, 1},
        {"analysis.mesh_positions", NULL, &a->mesh_positions, 4},
        {"analysis.speeds.count", &a->speeds.count, NULL, 1},
        {"analysis.torque_fraction", &a->case_count, NULL, 1},
        {"optimizer.verification_factor", &o->verification_factor, NULL, 0},
        {"optimizer.random_samples", &o->random_samples, NULL, 1},
        {"optimizer.simplex_iterations", &o->simplex_iterations, NULL, 0},
        {"optimizer.evaluations", &o->evaluations, NULL, 1},
        {"reliability.samples", &study->reliability.samples, NULL, 1},
    };
    for (int i = 0; i < FIGURES; i++)
        out[i] = figures[i];
}

static size_t value_of(const struct figure *f) {
    return f->size ? *f->size : (size_t)*f->whole;
}

static void set_value(const struct figure *f, size_t value) {
    if (f->size)
        *f->size = value;
    else
        *f->whole = (int)value;
}

/* The study's bytes with a figure set to a value; the figure is left as it was. */
static double bytes_with(const struct qg_study *study, const struct scale *scale, int threads, const struct figure *f,
                         size_t value) {
    size_t before = value_of(f);
    set_value(f, value);
    double bytes = bytes_of(study, scale, threads);
    set_value(f, before);
    return bytes;
}

/* The largest value of a figure with which the study takes at most `most`; its least one does. */
static size_t largest_value(const struct qg_study *study, const struct scale *scale, int threads,
                            const struct figure *f, double most) {
    size_t low = f->least, high = value_of(f);
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (bytes_with(study, scale, threads, f, middle) <= most)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void qg_memory_advise(const struct qg_study *study, int threads, double most, struct qg_notes *notes) {
    struct qg_study copy = *study;
    struct figure figure[FIGURES];
    const struct scale scale = scale_of(study);
    double bytes = bytes_of(study, &scale, threads), best = bytes;
    int helps_most = 0;
    bool advised = false;
    figures_of(&copy, figure);
    for (int i = 0; i < FIGURES && bytes > most; i++) {
        const struct figure *f = &figure[i];
        double least = value_of(f) > f->least ? bytes_with(&copy, &scale, threads, f, f->least) : bytes;
        if (least <= most)
            qg_notes_add(notes, f->where, "found %zu; up to %zu would do", value_of(f),
                         largest_value(&copy, &scale, threads, f, most));
        advised = advised || least <= most;
        helps_most = least < best ? i : helps_most;
        best = fmin(best, least);
    }
    if (bytes > most && !advised)
        qg_notes_add(notes, figure[helps_most].where,
                     "found %zu; with %zu the job would take %.0f MB, and something else has to be less as well",
                     value_of(&figure[helps_most]), figure[helps_most].least, ceil(best / 1e6));
}
