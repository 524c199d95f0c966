/* The mesh force F(phi, delta): ladder, interpolation, back flanks.
 *
 * 1. Slopes. Between rungs j and j+1 the secant compliance is c_j = (delta_{j+1} - delta_j) / (F_{j+1} - F_j). At rung
 *    j the tangent compliance dc = w c_{j-1} + (1 - w) c_j, w = H_j / (H_{j-1} + H_j) with H_j = F_{j+1} - F_j, is the
 *    parabola's, of second order. With w kept within [1/3, 2/3] the slope 1/dc is at most three times the smaller of
 *    the neighbouring secant stiffnesses, which is Fritsch and Carlson's condition (SIAM J. Numer. Anal. 17, 1980): the
 *    Hermite cubic between the rungs is monotone. The weights do not depend on the phase and no switch looks at the
 *    data, so that the force is as smooth in phi as the series are, and C1 in delta. The ends take their only secant.
 * 2. Series. Monotony at all phases needs c_j(phi) > 0 for the truncated series of the rungs. At the mesh positions
 *    that is so by physics; between them truncation might break it, and then the harmonics of c_j are scaled down.
 * 3. Back flanks. Reflection in the line of centres turns a pair with its back flanks in contact, turning forwards,
 *    into the same pair with its drive flanks in contact, turning backwards; the teeth are symmetric and carry the same
 *    relief on both sides. So the back flanks' force is the drive flanks' at another phase, which falls as phi grows.
 *    Take a pinion tooth whose centre line stands at the angle beta before the line of centres, of half tooth angle psi
 *    at the pitch point. Its leading flank touches the line of action at xi = r_b1 (tan alpha_w + beta + psi), and,
 *    reflected, its trailing one at xi' = r_b1 (tan alpha_w - beta + psi). Both belong to a phase by
 *    xi = middle + (phi - 1/2 + k) p_b, so that
 *        phi + phi' = S1 = 2 (r_b1 (tan alpha_w + psi) - middle) / p_b   (mod 1).
 *    phi is the phase of the pinion while x = +b. On the way to x = -b the pinion falls back by its share m/m1 of 2b
 *    (m_i = I_i / r_bi^2, m = m1 m2 / (m1 + m2); the momentum of both gears together does not notice the backlash), and
 *    the gear runs ahead by the rest. Hence S = S1 + (m/m1) 2b / p_b. Counting from the gear instead gives the same S.
 */
#include "core/force.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/dynamics_batch.h"

static const double FIRST_RUNG = 0.05; /* of the smallest load */
static const double RATIO_MOST = 1.3;  /* between rungs */
static const double APART = 0.1;       /* least distance between rungs, of their mean distance */
static const double STEP_MAX = 0.05;   /* in 1/omega_n, at the lowest speed */
static const int STEPS_PER_HARMONIC = 16;

/* ---- ladder ------------------------------------------------------------------------------------------------------ */

struct ladder {
    double *load;
    size_t count;
    double ratio;
    bool full;
};

/* Appends `to`, and before it what lies between the last rung and it, halving ratios until they are small enough. */
static void climb(struct ladder *ladder, double to) {
    if (ladder->count == QG_FORCE_LEVELS_MAX) {
        ladder->full = true;
        return;
    }
    double from = ladder->load[ladder->count - 1];
    if (to > from * ladder->ratio) {
        climb(ladder, sqrt(from * to));
        climb(ladder, to);
    } else {
        ladder->load[ladder->count++] = to;
    }
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

size_t qg_force_ladder(const double *loads, size_t count, double ladder[QG_FORCE_LEVELS_MAX]) {
    assert(count >= 1 && count + 4 <= QG_FORCE_LEVELS_MAX);
    double sorted[QG_FORCE_LEVELS_MAX];
    memcpy(sorted, loads, count * sizeof *loads);
    qsort(sorted, count, sizeof *sorted, ascending);
    struct ladder at = {.load = ladder, .ratio = RATIO_MOST, .full = true};
    for (; at.full; at.ratio *= 1.25) {
        at.full = false;
        ladder[0] = 0.0;
        ladder[1] = FIRST_RUNG * sorted[0];
        at.count = 2;
        for (size_t k = 0; k < count; k++)
            if (sorted[k] > ladder[at.count - 1])
                climb(&at, sorted[k]);
        climb(&at, QG_FORCE_REACH * sorted[count - 1]);
    }
    return at.count;
}

size_t qg_force_steps(double lowest_ratio, int harmonics) {
    static const size_t grids[] = {180, 360, 720, 1440, QG_FORCE_STEPS_MAX};
    double needed = fmax(2.0 * QG_PI / (lowest_ratio * STEP_MAX), (double)(STEPS_PER_HARMONIC * harmonics));
    size_t i = 0;
    while ((double)grids[i] < needed && grids[i] < QG_FORCE_STEPS_MAX)
        i++;
    return grids[i];
}

/* ---- sections ---------------------------------------------------------------------------------------------------- */

/* The tangent compliance at rung j, 0 < j < levels - 1, from the secant compliances below and above. */
static double compliance_at(const double *load, size_t j, double below, double above) {
    double h = load[j] - load[j - 1], h_next = load[j + 1] - load[j];
    double weight = fmin(2.0 / 3.0, fmax(1.0 / 3.0, h_next / (h + h_next)));
    return weight * below + (1.0 - weight) * above;
}

double qg_force_tangent(const double *load, const double *approach, size_t levels, size_t level) {
    assert(level >= 1 && level + 1 < levels);
    (void)levels;
    double below = (approach[level] - approach[level - 1]) / (load[level] - load[level - 1]);
    double above = (approach[level + 1] - approach[level]) / (load[level + 1] - load[level]);
    return 1.0 / compliance_at(load, level, below, above);
}

/* The pieces of a section from its knots. */
static void join(const double *load, size_t levels, const double *knot, struct qg_force_piece *piece) {
    double below = (knot[1] - knot[0]) / load[1], slope = 1.0 / below;
    for (size_t j = 0; j + 1 < levels; j++) {
        double width = knot[j + 1] - knot[j], secant = (load[j + 1] - load[j]) / width, slope_end = secant;
        if (j + 2 < levels) {
            double above = (knot[j + 2] - knot[j + 1]) / (load[j + 2] - load[j + 1]);
            slope_end = 1.0 / compliance_at(load, j + 1, below, above);
            below = above;
        }
        piece[j] = (struct qg_force_piece){.force = load[j],
                                           .slope = slope,
                                           .bend = (3.0 * secant - 2.0 * slope - slope_end) / width,
                                           .twist = (slope + slope_end - 2.0 * secant) / (width * width)};
        slope = slope_end;
    }
    piece[levels - 1] = (struct qg_force_piece){.force = load[levels - 1], .slope = slope};
}

/* Cosines and sines of all harmonics of a phase. */
struct turns {
    double cosine[QG_HARMONICS_MAX], sine[QG_HARMONICS_MAX];
};

static double series_at(const struct qg_fourier *series, const struct turns *turns) {
    double value = series->mean;
    for (int j = 0; j < series->harmonics; j++)
        value += series->cosine[j] * turns->cosine[j] + series->sine[j] * turns->sine[j];
    return value;
}

static void turns_at(struct turns *turns, int harmonics, double phase) {
    double c, s;
    phase -= floor(phase);
    qg_turn(phase, &c, &s);
    for (int j = 0; j < harmonics; j++) {
        turns->cosine[j] = j ? turns->cosine[j - 1] * c - turns->sine[j - 1] * s : c;
        turns->sine[j] = j ? turns->cosine[j - 1] * s + turns->sine[j - 1] * c : s;
    }
}

static void fill_section(const struct qg_force *force, enum qg_flank flank, double phase, double *knot,
                         struct qg_force_piece *piece) {
    struct turns turns;
    turns_at(&turns, force->approach[flank][0].harmonics, phase);
    for (size_t j = 0; j < force->levels; j++)
        knot[j] = series_at(&force->approach[flank][j], &turns);
    join(force->load, force->levels, knot, piece);
}

void qg_force_section_init(struct qg_force_section *section, const struct qg_force *force, enum qg_flank flank,
                           double phase) {
    fill_section(force, flank, phase, section->approach, section->piece);
}

double qg_force_section_at(const struct qg_force_section *section, size_t levels, double approach, bool through,
                           double *slope) {
    size_t j = 0;
    while (j + 1 < levels && approach >= section->approach[j + 1])
        j++;
    double d = approach - section->approach[j];
    const struct qg_force_piece *p = &section->piece[j];
    bool touching = through || approach > section->approach[0];
    if (slope)
        *slope = touching ? p->slope + d * (2.0 * p->bend + d * 3.0 * p->twist) : 0.0;
    return touching ? p->force + d * (p->slope + d * (p->bend + d * p->twist)) : 0.0;
}

double qg_force_section_approach(const struct qg_force_section *section, size_t levels, double force) {
    size_t j = 0;
    while (j + 1 < levels && force >= section->piece[j + 1].force)
        j++;
    const struct qg_force_piece *p = &section->piece[j];
    double low = section->approach[j];
    if (j + 1 == levels)
        return low + (force - p->force) / p->slope;
    double high = section->approach[j + 1];
    for (int i = 0; i < 80 && high > low; i++) {
        double middle = 0.5 * (low + high);
        if (middle == low || middle == high)
            break;
        if (qg_force_section_at(section, levels, middle, true, NULL) < force)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static double least_of(const struct qg_fourier *series, size_t phases) {
    double least = HUGE_VAL;
    for (size_t i = 0; i < phases; i++) {
        struct turns turns;
        turns_at(&turns, series->harmonics, (double)i / (double)phases);
        least = fmin(least, series_at(series, &turns));
    }
    return least;
}

static struct qg_fourier combine(const struct qg_fourier *a, double factor, const struct qg_fourier *b) {
    struct qg_fourier out = *a;
    out.mean += factor * b->mean;
    for (int j = 0; j < a->harmonics; j++) {
        out.cosine[j] += factor * b->cosine[j];
        out.sine[j] += factor * b->sine[j];
    }
    return out;
}

static void scale_harmonics(struct qg_fourier *series, double factor) {
    for (int j = 0; j < series->harmonics; j++) {
        series->cosine[j] *= factor;
        series->sine[j] *= factor;
    }
}

/* Phases at which the distance between rungs is looked at. */
static size_t phases_of(int harmonics) {
    return 16 * (size_t)(harmonics + 1);
}

/* Sees to it that a rung keeps its distance from the one below. */
static void keep_apart(struct qg_force *force, size_t level) {
    struct qg_fourier *rungs = force->approach[QG_FLANK_DRIVE];
    struct qg_fourier distance = combine(&rungs[level], -1.0, &rungs[level - 1]);
    double least = least_of(&distance, phases_of(distance.harmonics)), mean = distance.mean;
    assert(mean > 0.0);
    if (least >= APART * mean)
        return;
    scale_harmonics(&distance, (1.0 - APART) * mean / (mean - least));
    rungs[level] = combine(&rungs[level - 1], 1.0, &distance);
    force->damped++;
}

/* f(mirror - phi) */
static struct qg_fourier mirrored(const struct qg_fourier *series, double mirror) {
    struct qg_fourier out = *series;
    struct turns turns;
    turns_at(&turns, series->harmonics, mirror);
    for (int j = 0; j < series->harmonics; j++) {
        out.cosine[j] = series->cosine[j] * turns.cosine[j] + series->sine[j] * turns.sine[j];
        out.sine[j] = series->cosine[j] * turns.sine[j] - series->sine[j] * turns.cosine[j];
    }
    return out;
}

static void fill_table(struct qg_force *force, enum qg_flank flank) {
    const struct qg_force_table *table = &force->table[flank];
    size_t phases = 2 * force->steps, levels = force->levels;
    for (size_t i = 0; i < phases; i++)
        fill_section(force, flank, (double)i / (double)phases, table->knot + i * levels, table->piece + i * levels);
    const struct qg_fourier *edge = &force->approach[flank][0];
    force->least_error[flank] = least_of(edge, phases_of(edge->harmonics));
}

static bool allocate_tables(struct qg_force *force) {
    size_t n = 2 * force->steps * force->levels;
    bool ok = true;
    for (int flank = 0; flank < QG_FLANK_COUNT; flank++) {
        struct qg_force_table *table = &force->table[flank];
        table->knot = malloc(n * sizeof *table->knot);
        table->piece = malloc(n * sizeof *table->piece);
        ok = ok && table->knot && table->piece;
    }
    return ok;
}

void qg_force_set_back(struct qg_force *force, const struct qg_fourier *approach) {
    memcpy(force->approach[QG_FLANK_BACK], approach, force->levels * sizeof *approach);
    fill_table(force, QG_FLANK_BACK);
}

enum qg_status qg_force_create(const struct qg_force_samples *samples, struct qg_force **out) {
    assert(samples->levels >= 2 && samples->levels <= QG_FORCE_LEVELS_MAX && samples->load[0] == 0.0);
    struct qg_force *force = *out = calloc(1, sizeof *force);
    if (!force)
        return QG_OUT_OF_MEMORY;
    force->levels = samples->levels;
    force->steps = samples->steps;
    if (!allocate_tables(force)) {
        qg_force_destroy(force);
        *out = NULL;
        return QG_OUT_OF_MEMORY;
    }
    struct qg_fourier back[QG_FORCE_LEVELS_MAX], *drive = force->approach[QG_FLANK_DRIVE];
    for (size_t j = 0; j < samples->levels; j++) {
        force->load[j] = samples->load[j];
        qg_fourier_from_samples(&drive[j], samples->approach + j * samples->positions, samples->positions,
                                samples->harmonics);
        if (j > 0)
            keep_apart(force, j);
        back[j] = mirrored(&drive[j], samples->mirror);
    }
    fill_table(force, QG_FLANK_DRIVE);
    qg_force_set_back(force, back);
    return QG_OK;
}

void qg_force_destroy(struct qg_force *force) {
    if (!force)
        return;
    for (int flank = 0; flank < QG_FLANK_COUNT; flank++) {
        free(force->table[flank].knot);
        free(force->table[flank].piece);
    }
    free(force);
}

/* ---- back flanks ------------------------------------------------------------------------------------------------- */

double qg_back_flank_phase(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g) {
    const struct qg_gear_geometry *pinion = &g->gears[QG_PINION];
    double pitch_radius = pinion->base_radius / cos(g->working_pressure_angle);
    double psi = qg_half_tooth_angle(&pair->rack, pinion, pitch_radius);
    double middle = 0.5 * (g->path_start + g->path_end);
    double pinion_share = g->equivalent_mass * pinion->base_radius * pinion->base_radius / pinion->moment_of_inertia;
    double sum = 2.0 * (pinion->base_radius * (tan(g->working_pressure_angle) + psi) - middle);
    double phase = (sum + pinion_share * g->backlash) / g->base_pitch;
    return phase - floor(phase);
}
