/* From a gear pair to a model, and from a design to its figures of merit. */
#include "core/model.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/attractors.h"
#include "core/compliance.h"
#include "core/force.h"
#include "core/statics.h"

struct qg_model {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_analysis analysis;
    struct qg_statics statics;
    struct qg_model_size size;
};

/* ---- building --------------------------------------------------------------------------------------------------- */

/* The two gears' finite elements, as pieces. */
struct compliance_work {
    const struct qg_model *model;
    const struct qg_means *means;
    const struct qg_compliance *kept[2]; /* held in the cache; NULL without one */
    struct qg_compliance own[2];         /* without a cache */
    enum qg_status status[2];
    struct qg_notes notes[2];
};

static struct qg_compliance_key key_of(const struct qg_model *m, int gear) {
    const struct qg_material *material = &m->pair.material;
    bool ring = gear == QG_PINION && m->analysis.bore == QG_BORE_TORQUE_RING;
    return (struct qg_compliance_key){
        .rack = m->pair.rack,
        .gear = m->pair.gears[gear],
        .plate = {material->youngs_modulus, material->poisson_ratio, m->pair.gears[gear].face_width,
                  m->analysis.plane == QG_PLANE_STRAIN},
        .support = ring ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED,
        .refinement = m->analysis.mesh_refinement,
        .reach = 2 * QG_PAIR_REACH,
    };
}

/* Mesh and compliance of one gear. */
static enum qg_status compute_compliance(const struct qg_compliance_key *key, struct compliance_work *work,
                                         size_t gear) {
    const struct qg_gear_geometry *geometry = &work->model->geometry.gears[gear];
    const struct qg_compliance_plan plan = {key->plate, (enum qg_support)key->support, key->gear.teeth, key->reach,
                                            work->means->stop};
    struct qg_sector_mesh mesh;
    if (qg_is_stopped(&plan.stop))
        return QG_CANCELLED;
    enum qg_status status =
        qg_sector_mesh_init(&mesh, &key->rack, &key->gear, geometry, key->refinement, &work->notes[gear]);
    if (status != QG_OK)
        return status;
    status = qg_compliance_init(&work->own[gear], &mesh, &plan);
    qg_sector_mesh_finish(&mesh);
    return status;
}

static void compliance_piece(void *context, size_t gear, int worker) {
    (void)worker;
    struct compliance_work *work = context;
    struct qg_cache *cache = work->means->cache;
    const struct qg_compliance_key key = key_of(work->model, (int)gear);
    if (cache && (work->kept[gear] = qg_cache_take(cache, &key)))
        return;
    work->status[gear] = compute_compliance(&key, work, gear);
    if (cache && work->status[gear] == QG_OK)
        work->kept[gear] = qg_cache_keep(cache, &key, &work->own[gear]);
}

static void release_compliance(struct compliance_work *work, int gear) {
    if (work->kept[gear])
        qg_cache_release(work->means->cache, work->kept[gear]);
    qg_compliance_finish(&work->own[gear]);
}

static double largest_force(const struct qg_model *m) {
    double most = 0;
    for (size_t k = 0; k < m->analysis.case_count; k++)
        most = fmax(most, m->analysis.torque_fraction[k]);
    if (m->analysis.mesh_stiffness == QG_STIFFNESS_LOAD_DEPENDENT)
        most *= QG_FORCE_REACH;
    return most * m->pair.nominal_torque / m->geometry.gears[QG_PINION].base_radius;
}

/* All positions of a period, or the one at *position. */
static enum qg_status build(struct qg_model *m, const double *position, const struct qg_means *means,
                            struct qg_notes *notes) {
    struct compliance_work *work = calloc(1, sizeof *work);
    if (!work)
        return QG_OUT_OF_MEMORY;
    work->model = m;
    work->means = means;
    means->executor.run(means->executor.self, 2, compliance_piece, work);
    enum qg_status status = work->status[0] != QG_OK ? work->status[0] : work->status[1];
    struct qg_compliance view[2];
    for (int g = 0; g < 2; g++) {
        view[g] = work->kept[g] ? *work->kept[g] : work->own[g];
        if (work->notes[g].count)
            qg_notes_add(notes, "", "%s", work->notes[g].item[0].text);
        m->size.degrees_of_freedom[g] = view[g].degrees_of_freedom;
        m->size.flank_nodes[g] = view[g].flank_count;
    }
    if (status == QG_OK && position)
        status = qg_statics_init_at(&m->statics, &m->pair, &m->geometry, view, *position, largest_force(m), means);
    else if (status == QG_OK)
        status = qg_statics_init(&m->statics, &m->pair, &m->geometry, view, (size_t)m->analysis.mesh_positions,
                                 largest_force(m), means);
    for (int g = 0; g < 2; g++)
        release_compliance(work, g);
    free(work);
    return status;
}

static enum qg_status create(const struct qg_gear_pair *pair, const struct qg_analysis *analysis,
                             const double *position, const struct qg_means *means, struct qg_notes *notes,
                             struct qg_model **model) {
    *model = NULL;
    struct qg_model *m = calloc(1, sizeof *m);
    if (!m)
        return QG_OUT_OF_MEMORY;
    m->pair = *pair;
    m->analysis = *analysis;
    if (position)
        m->analysis.mesh_positions = 1;
    enum qg_status status = qg_pair_derive(&m->pair, &m->geometry, notes);
    if (status == QG_OK)
        status = build(m, position, means, notes);
    if (status != QG_OK) {
        qg_model_destroy(m);
        return status;
    }
    *model = m;
    return QG_OK;
}

enum qg_status qg_model_create(const struct qg_gear_pair *pair, const struct qg_analysis *analysis,
                               const struct qg_means *means, struct qg_notes *notes, struct qg_model **model) {
    return create(pair, analysis, NULL, means, notes, model);
}

enum qg_status qg_model_create_at(const struct qg_gear_pair *pair, const struct qg_analysis *analysis, double position,
                                  const struct qg_means *means, struct qg_notes *notes, struct qg_model **model) {
    return create(pair, analysis, &position, means, notes, model);
}

void qg_model_destroy(struct qg_model *model) {
    if (!model)
        return;
    qg_statics_finish(&model->statics);
    free(model);
}

const struct qg_statics *qg_model_statics(const struct qg_model *model) {
    return &model->statics;
}

const struct qg_gear_pair *qg_model_pair(const struct qg_model *model) {
    return &model->pair;
}

const struct qg_pair_geometry *qg_model_geometry(const struct qg_model *model) {
    return &model->geometry;
}

const struct qg_analysis *qg_model_analysis(const struct qg_model *model) {
    return &model->analysis;
}

struct qg_model_size qg_model_size(const struct qg_model *model) {
    return model->size;
}

/* ---- results ---------------------------------------------------------------------------------------------------- */

struct qg_design_result *qg_design_result_create(const struct qg_analysis *analysis) {
    struct qg_design_result *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    size_t n = (size_t)analysis->mesh_positions, per_case = n * (4 + QG_PAIR_COUNT);
    r->positions = n;
    r->speeds = analysis->speeds.count;
    r->case_count = analysis->case_count;
    r->f_dte_percentile = NAN;
    r->storage = calloc(per_case * r->case_count, sizeof *r->storage);
    bool ok = r->storage != NULL;
    for (size_t k = 0; k < r->case_count && ok; k++) {
        struct qg_case_result *c = &r->cases[k];
        double *at = r->storage + k * per_case;
        c->static_transmission_error = at;
        c->unloaded_transmission_error = at + n;
        c->mesh_stiffness = at + 2 * n;
        c->contact_pressure = at + 3 * n;
        c->load_share = at + 4 * n;
        c->response = calloc(r->speeds, sizeof *c->response);
        ok = c->response != NULL;
    }
    if (ok)
        return r;
    qg_design_result_destroy(r);
    return NULL;
}

void qg_design_result_destroy(struct qg_design_result *result) {
    if (!result)
        return;
    for (size_t k = 0; k < result->case_count; k++) {
        free(result->cases[k].response);
        if (result->cases[k].branches)
            qg_branches_finish(result->cases[k].branches);
        free(result->cases[k].branches);
        qg_stresses_destroy(result->cases[k].stresses);
    }
    free(result->storage);
    free(result);
}

/* ---- one design ------------------------------------------------------------------------------------------------- */

/* Stiffness by the chosen definition, its mean, and what the dynamics are made dimensionless with. With a force of
 * positions and amplitudes it is the secant for the time being (make_force puts the tangent in its place). */
static void derive_stiffness(const struct qg_model *m, struct qg_case_result *c) {
    size_t n = (size_t)m->analysis.mesh_positions;
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        double approach = c->static_transmission_error[i];
        if (m->analysis.mesh_stiffness == QG_STIFFNESS_CONSISTENT)
            approach -= c->unloaded_transmission_error[i];
        c->mesh_stiffness[i] = c->normal_force / approach;
        sum += c->mesh_stiffness[i];
    }
    c->mean_mesh_stiffness = sum / (double)n;
    /* N/mm over kg is 1000 / s^2 */
    c->natural_frequency = sqrt(1000 * c->mean_mesh_stiffness / m->geometry.equivalent_mass) / (2 * M_PI);
}

/* ---- the force of one design ------------------------------------------------------------------------------------- */

/* The ladder of a design: its loads, and the approaches found under them. */
struct ladder {
    size_t levels;
    double load[QG_FORCE_LEVELS_MAX]; /* N */
    double *approach;                 /* mm, [levels][positions] */
};

/* Puts the tangent stiffness at the case's load in the place of the secant. */
static void set_tangents(const struct ladder *ladder, size_t positions, struct qg_case_result *c) {
    size_t level = 0;
    while (ladder->load[level] < c->normal_force)
        level++;
    for (size_t i = 0; i < positions; i++) {
        double approach[QG_FORCE_LEVELS_MAX];
        for (size_t j = 0; j < ladder->levels; j++)
            approach[j] = ladder->approach[j * positions + i];
        c->mesh_stiffness[i] = qg_force_tangent(ladder->load, approach, ladder->levels, level);
    }
}

/* From the ladder to the force, approaches in half-backlashes. */
static enum qg_status force_from_ladder(const struct qg_model *m, struct ladder *ladder, struct qg_force **force) {
    size_t n = (size_t)m->analysis.mesh_positions;
    for (size_t i = 0; i < ladder->levels * n; i++)
        ladder->approach[i] /= m->geometry.backlash / 2;
    const struct qg_force_samples samples = {
        .positions = n,
        .harmonics = m->analysis.harmonics,
        .levels = ladder->levels,
        .load = ladder->load,
        .approach = ladder->approach,
        .mirror = qg_back_flank_phase(&m->pair, &m->geometry),
        .steps = qg_force_steps(m->analysis.speeds.min, m->analysis.harmonics),
    };
    return qg_force_create(&samples, force);
}

/* The force of a design whose cases are solved; their mesh stiffness becomes the tangent. */
static enum qg_status make_force(const struct qg_model *m, struct qg_statics_workspace *workspace,
                                 struct qg_design_result *r, struct qg_force **force) {
    struct ladder ladder;
    double load[QG_CASES_MAX];
    for (size_t k = 0; k < r->case_count; k++)
        load[k] = r->cases[k].normal_force;
    ladder.levels = qg_force_ladder(load, r->case_count, ladder.load);
    ladder.approach = malloc(ladder.levels * m->statics.positions * sizeof *ladder.approach);
    if (!ladder.approach)
        return QG_OUT_OF_MEMORY;
    enum qg_status status =
        qg_statics_ladder(&m->statics, workspace, &r->relief, ladder.levels, ladder.load, ladder.approach);
    for (size_t k = 0; k < r->case_count && status == QG_OK; k++)
        set_tangents(&ladder, m->statics.positions, &r->cases[k]);
    if (status == QG_OK)
        status = force_from_ladder(m, &ladder, force);
    free(ladder.approach);
    return status;
}

/* ---- the oscillator ---------------------------------------------------------------------------------------------- */

/* The oscillator of one case: kappa = k / k_mean, e and load in half-backlashes. force may be NULL. */
static void make_oscillator(const struct qg_model *m, const struct qg_case_result *c, const struct qg_force *force,
                            struct qg_oscillator *out) {
    size_t n = (size_t)m->analysis.mesh_positions;
    double half_backlash = m->geometry.backlash / 2, sample[QG_POSITIONS_MAX] = {0};
    *out = (struct qg_oscillator){.damping_ratio = m->pair.damping_ratio,
                                  .load = c->normal_force / (c->mean_mesh_stiffness * half_backlash),
                                  .force = force,
                                  .force_scale = 1 / (c->mean_mesh_stiffness * half_backlash)};
    for (size_t i = 0; i < n; i++)
        sample[i] = c->mesh_stiffness[i] / c->mean_mesh_stiffness;
    qg_fourier_from_samples(&out->stiffness, sample, n, m->analysis.harmonics);
    for (size_t i = 0; i < n; i++)
        sample[i] = c->unloaded_transmission_error[i] / half_backlash;
    if (m->analysis.mesh_stiffness == QG_STIFFNESS_CONSISTENT)
        qg_fourier_from_samples(&out->error, sample, n, m->analysis.harmonics);
}

/* ---- the evaluator ---------------------------------------------------------------------------------------------- */

enum qg_status qg_evaluator_init(struct qg_evaluator *e, const struct qg_model *model,
                                 const struct qg_executor *executor) {
    *e = (struct qg_evaluator){.model = model, .executor = *executor};
    e->workspace = calloc((size_t)executor->workers, sizeof *e->workspace);
    enum qg_status status = e->workspace ? QG_OK : QG_OUT_OF_MEMORY;
    for (int i = 0; i < executor->workers && status == QG_OK; i++)
        status = qg_statics_workspace_init(&e->workspace[i], &model->statics);
    if (status != QG_OK)
        qg_evaluator_finish(e);
    return status;
}

void qg_evaluator_finish(struct qg_evaluator *e) {
    for (int i = 0; e->workspace && i < e->executor.workers; i++)
        qg_statics_workspace_finish(&e->workspace[i]);
    free(e->workspace);
    *e = (struct qg_evaluator){0};
}

/* What the pieces of one call share. */
struct batch {
    const struct qg_evaluator *evaluator;
    struct qg_design_result *const *results;
    struct qg_oscillator *oscillator; /* [n * case_count] */
    struct qg_force **force;          /* [n], NULL without one */
    enum qg_status *status;           /* [n] of the statics */
    enum qg_status *response_status;  /* [n * case_count]; of QG_BRANCH_WORST, which needs memory */
    size_t cases, pieces;             /* pieces per oscillator */
    bool dynamics;                    /* will follow */
};

static bool is_cancelled(const struct qg_evaluator *e) {
    return e->cancelled && e->cancelled(e->self);
}

static void statics_piece(void *context, size_t item, int worker) {
    struct batch *b = context;
    const struct qg_model *m = b->evaluator->model;
    struct qg_design_result *r = b->results[item];
    if (is_cancelled(b->evaluator)) {
        b->status[item] = QG_CANCELLED;
        return;
    }
    for (size_t k = 0; k < b->cases; k++)
        r->cases[k].torque = m->analysis.torque_fraction[k] * m->pair.nominal_torque;
    b->evaluator->workspace[worker].stop = (struct qg_stop){b->evaluator->cancelled, b->evaluator->self};
    b->status[item] = qg_statics_solve(&m->statics, &b->evaluator->workspace[worker], r);
    if (b->status[item] != QG_OK)
        return;
    for (size_t k = 0; k < b->cases; k++)
        derive_stiffness(m, &r->cases[k]);
    if (m->analysis.mesh_stiffness == QG_STIFFNESS_LOAD_DEPENDENT && b->dynamics)
        b->status[item] = make_force(m, &b->evaluator->workspace[worker], r, &b->force[item]);
    if (b->status[item] != QG_OK)
        return;
    r->f_pps = 0;
    r->f_dte = NAN;
    for (size_t k = 0; k < b->cases; k++) {
        make_oscillator(m, &r->cases[k], b->force[item], &b->oscillator[item * b->cases + k]);
        r->f_pps = fmax(r->f_pps, r->cases[k].pps);
        r->cases[k].max_rms = r->cases[k].max_rms_at = NAN;
        r->cases[k].speeds_beyond = 0;
    }
}

static void dynamics_piece(void *context, size_t item, int worker) {
    (void)worker;
    struct batch *b = context;
    if (is_cancelled(b->evaluator))
        return;
    size_t piece = item % b->pieces, oscillator = item / b->pieces;
    struct qg_case_result *c = &b->results[oscillator / b->cases]->cases[oscillator % b->cases];
    const struct qg_speed_map *speeds = &b->evaluator->model->analysis.speeds;
    if (speeds->branch == QG_BRANCH_WORST)
        b->response_status[oscillator] = qg_worst_response(&b->oscillator[oscillator], speeds, c->response);
    else
        qg_response_piece(&b->oscillator[oscillator], speeds, piece, c->response);
}

/* The largest RMS of each case and of the design, and how many orbits left the ladder. */
static void find_peaks(const struct qg_speed_map *map, struct qg_design_result *r) {
    r->f_dte = 0;
    for (size_t k = 0; k < r->case_count; k++) {
        struct qg_case_result *c = &r->cases[k];
        size_t peak = 0;
        c->speeds_beyond = 0;
        for (size_t i = 0; i < map->count; i++) {
            c->speeds_beyond += c->response[i].beyond != 0;
            if (c->response[i].rms > c->response[peak].rms)
                peak = i;
        }
        c->max_rms = c->response[peak].rms;
        c->max_rms_at = qg_speed_at(map, peak);
        r->f_dte = fmax(r->f_dte, c->max_rms);
    }
}

static double now(const struct qg_evaluator *e) {
    return e->clock.now ? e->clock.now(e->clock.self) : 0;
}

static enum qg_status run_statics(struct qg_evaluator *e, struct batch *b, size_t n) {
    double start = now(e);
    e->executor.run(e->executor.self, n, statics_piece, b);
    e->times.statics += now(e) - start;
    for (size_t i = 0; i < n; i++)
        if (b->status[i] != QG_OK)
            return b->status[i];
    return QG_OK;
}

static enum qg_status run_dynamics(struct qg_evaluator *e, struct batch *b, size_t n) {
    double start = now(e);
    e->executor.run(e->executor.self, n * b->cases * b->pieces, dynamics_piece, b);
    e->times.dynamics += now(e) - start;
    if (is_cancelled(e))
        return QG_CANCELLED;
    for (size_t i = 0; i < n * b->cases; i++)
        if (b->response_status[i] != QG_OK)
            return b->response_status[i];
    for (size_t i = 0; i < n; i++)
        find_peaks(&e->model->analysis.speeds, b->results[i]);
    return QG_OK;
}

enum qg_status qg_evaluate(struct qg_evaluator *e, bool dynamics, size_t n, struct qg_design_result *const *results) {
    const struct qg_analysis *analysis = &e->model->analysis;
    struct batch b = {.evaluator = e, .results = results, .cases = analysis->case_count, .dynamics = dynamics};
    b.pieces = qg_response_pieces(&analysis->speeds);
    b.oscillator = calloc(n * b.cases, sizeof *b.oscillator);
    b.force = calloc(n, sizeof *b.force);
    b.status = calloc(n, sizeof *b.status);
    b.response_status = calloc(n * b.cases, sizeof *b.response_status);
    bool made = b.oscillator && b.force && b.status && b.response_status;
    for (size_t i = 0; i < n; i++) {
        results[i]->pair = e->model->pair;
        results[i]->backlash = e->model->geometry.backlash;
    }
    enum qg_status status = made ? run_statics(e, &b, n) : QG_OUT_OF_MEMORY;
    if (status == QG_OK && dynamics)
        status = run_dynamics(e, &b, n);
    for (size_t i = 0; b.force && i < n; i++)
        qg_force_destroy(b.force[i]);
    free(b.oscillator);
    free(b.force);
    free(b.status);
    free(b.response_status);
    return status;
}

/* The load cases of one design, as pieces. */
struct branches_work {
    const struct qg_evaluator *evaluator;
    struct qg_design_result *result;
    const struct qg_force *force; /* NULL without one */
    enum qg_status status[QG_CASES_MAX];
};

static void branches_piece(void *context, size_t item, int worker) {
    (void)worker;
    struct branches_work *work = context;
    const struct qg_evaluator *e = work->evaluator;
    struct qg_case_result *c = &work->result->cases[item];
    const struct qg_stop stop = {e->cancelled, e->self};
    struct qg_oscillator oscillator;
    make_oscillator(e->model, c, work->force, &oscillator);
    if (!c->branches)
        c->branches = calloc(1, sizeof *c->branches);
    else
        qg_branches_finish(c->branches);
    work->status[item] =
        c->branches ? qg_branches_find(&oscillator, &e->model->analysis.speeds, &stop, c->branches) : QG_OUT_OF_MEMORY;
}

enum qg_status qg_evaluate_branches(struct qg_evaluator *e, struct qg_design_result *result) {
    struct branches_work work = {.evaluator = e, .result = result};
    struct qg_force *force = NULL;
    double start = now(e);
    if (e->model->analysis.mesh_stiffness == QG_STIFFNESS_LOAD_DEPENDENT) {
        enum qg_status status = make_force(e->model, &e->workspace[0], result, &force);
        if (status != QG_OK)
            return status;
    }
    work.force = force;
    e->executor.run(e->executor.self, result->case_count, branches_piece, &work);
    qg_force_destroy(force);
    e->times.dynamics += now(e) - start;
    for (size_t k = 0; k < result->case_count; k++)
        if (work.status[k] != QG_OK)
            return work.status[k];
    return QG_OK;
}

/* The mesh positions of one design, as pieces. */
struct stress_work {
    const struct qg_evaluator *evaluator;
    const struct qg_relief *relief;
    size_t cases;
    double load[QG_CASES_MAX]; /* N */
    struct qg_stresses *stresses[QG_CASES_MAX];
    enum qg_status status[QG_POSITIONS_MAX];
};

static void stress_piece(void *context, size_t item, int worker) {
    struct stress_work *work = context;
    const struct qg_evaluator *e = work->evaluator;
    work->status[item] = is_cancelled(e) ? QG_CANCELLED
                                         : qg_statics_stress(&e->model->statics, &e->workspace[worker], work->relief,
                                                             item, work->cases, work->load, work->stresses);
}

enum qg_status qg_evaluate_stresses(struct qg_evaluator *e, struct qg_design_result *result) {
    struct stress_work work = {.evaluator = e, .relief = &result->relief, .cases = result->case_count};
    double start = now(e);
    for (size_t k = 0; k < result->case_count; k++) {
        struct qg_case_result *c = &result->cases[k];
        if (!c->stresses && !(c->stresses = qg_stresses_create(result->positions, QG_PAIR_COUNT)))
            return QG_OUT_OF_MEMORY;
        work.load[k] = c->normal_force;
        work.stresses[k] = c->stresses;
    }
    e->executor.run(e->executor.self, result->positions, stress_piece, &work);
    for (size_t i = 0; i < result->positions; i++)
        if (work.status[i] != QG_OK)
            return work.status[i];
    for (size_t k = 0; k < result->case_count; k++)
        qg_stresses_summarize(result->cases[k].stresses);
    e->times.statics += now(e) - start;
    return QG_OK;
}
