/* Fuzzer of the numerical core: bytes become the parameters of a gear pair, and what the geometry takes goes all the way
 * through mesh, compliance, contact, stresses and vibration. Coarse meshes and three positions: an input costs some 0.1 s.
 *
 * Each parameter is two bytes, from 0 to 65535, spread over its range; bytes that are missing are 0. Most pairs made like this
 * are gears that can be cut; the others have to be refused in words. What has to hold of the rest:
 *   - all figures are finite, residuals those of rounding, the flexibility symmetric (Maxwell and Betti);
 *   - the static transmission error is positive, and a larger torque makes it larger; load shares are no less than 0 and sum
 *     to 1;
 *   - a response is finite, or is called unbounded.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/iso6336.h"
#include "core/random.h"
#include "core/statics.h"
#include "core/study.h"
#include "tests/fuzz/fuzz.h"

enum { PARAMETERS = 32, POSITIONS = 3, CASES = 2, SPEEDS = 4 };

/* Coarse in everything: shapes are what is tried here, not accuracy. One input in four has the second one. */
static const struct qg_mesh_density densities[2] = {
    {.tooth_columns = 6,
     .fillet_rows = 3,
     .root_columns = 3,
     .foot_rows = 2,
     .body_rows = 3,
     .flank_elements_per_module = 6,
     .tip_share = 0.4,
     .column_growth = 1.3},
    {.tooth_columns = 12,
     .fillet_rows = 4,
     .root_columns = 4,
     .foot_rows = 4,
     .body_rows = 5,
     .flank_elements_per_module = 20,
     .tip_share = 0.2,
     .column_growth = 1.25},
};

/* Parameters that are evenly spread, except for the last third of the seeds: there every other one is at an end of its range. */
static size_t seed(size_t index, uint8_t *out) {
    enum { SEEDS = 24 };
    if (index >= SEEDS)
        return 0;
    for (uint32_t i = 0; i < 2 * PARAMETERS; i++)
        out[i] = (uint8_t)(256 * qg_random_uniform(7, QG_STREAM_TESTS, index, i));
    for (uint32_t i = index % 2; index >= 2 * SEEDS / 3 && i < PARAMETERS; i += 2)
        out[2 * i] = out[2 * i + 1] = out[2 * i] < 128 ? 0 : 255;
    return 2 * PARAMETERS;
}

struct fuzz_harness fuzz_harness = {"core", seed, NULL, 100, "pairs that can be made", 0};

/* ---- bytes to a job --------------------------------------------------------------------------------------------- */

struct bytes {
    const uint8_t *data;
    size_t left;
};

/* The next parameter, between low and high, both included. */
static double take(struct bytes *bytes, double low, double high) {
    unsigned value = 0;
    for (int i = 0; i < 2; i++) {
        value = value * 256 + (bytes->left ? *bytes->data : 0);
        bytes->data += bytes->left > 0;
        bytes->left -= bytes->left > 0;
    }
    return low + (high - low) * value / 65535;
}

/* Usual proportions and beyond; the tip is cut later, when the centre distance is known. */
static struct qg_gear take_gear(struct bytes *bytes, const struct qg_rack *rack) {
    double m = rack->module, alpha = rack->pressure_angle, addendum = take(bytes, 1, 1.5);
    struct qg_gear gear = {.teeth = (int)take(bytes, 10, 120), .profile_shift = take(bytes, -0.4, 0.9) * m};
    gear.root_radius = m * gear.teeth / 2 + gear.profile_shift - addendum * m;
    double fits = (M_PI / 4 - addendum * tan(alpha)) * cos(alpha) / (1 - sin(alpha));
    gear.hob_tip_radius = take(bytes, 0, 0.999) * fmax(0, fits) * m;
    gear.bore_diameter = 2 * take(bytes, 0.1, 0.97) * gear.root_radius;
    gear.face_width = take(bytes, 2, 60);
    gear.moment_of_inertia = take(bytes, 0, 5000);
    return gear;
}

/* Newton's method for the angle of an involute function, from above. */
static double angle_of_involute(double value) {
    double angle = cbrt(3 * fmax(value, 1e-6));
    for (int i = 0; i < 60; i++)
        angle -= (qg_involute(angle) - value) / (tan(angle) * tan(angle));
    return angle;
}

static struct qg_gear_pair take_pair(struct bytes *bytes) {
    struct qg_gear_pair pair = {.rack = {take(bytes, 0.5, 8), take(bytes, 14.5, 28) * M_PI / 180}};
    pair.material = (struct qg_material){take(bytes, 7e4, 2.1e5), take(bytes, 0, 0.45), take(bytes, 2e-6, 8e-6)};
    pair.damping_ratio = take(bytes, 0.005, 0.2);
    for (int g = 0; g < 2; g++)
        pair.gears[g] = take_gear(bytes, &pair.rack);
    double m = pair.rack.module, alpha = pair.rack.pressure_angle;
    double teeth = pair.gears[0].teeth + pair.gears[1].teeth;
    double shifts = (pair.gears[0].profile_shift + pair.gears[1].profile_shift) / m;
    double working = angle_of_involute(qg_involute(alpha) + 2 * shifts * tan(alpha) / teeth);
    pair.center_distance = m * teeth / 2 * cos(alpha) / cos(working) + take(bytes, 0.001, 0.15) * m;
    for (int g = 0; g < 2; g++)
        pair.gears[g].outside_radius = pair.center_distance - pair.gears[1 - g].root_radius - take(bytes, 0.1, 0.4) * m;
    double width = fmin(pair.gears[0].face_width, pair.gears[1].face_width);
    double base = m * pair.gears[0].teeth / 2 * cos(alpha);
    pair.nominal_torque = take(bytes, 10, 600) * width * base; /* 10 to 600 N per mm of face width */
    return pair;
}

/* A relief that the pair may have; none in one of three. */
static struct qg_relief take_relief(struct bytes *bytes, const struct qg_gear_pair *pair,
                                    const struct qg_pair_geometry *geometry) {
    struct qg_relief relief = {0};
    int kinds = (int)take(bytes, 0, 11.99);
    relief.shape = kinds & 1 ? QG_SHAPE_PARABOLIC : QG_SHAPE_LINEAR;
    relief.ramp = kinds & 2 ? QG_RAMP_ROLL_ANGLE : QG_RAMP_RADIUS;
    for (int g = 0; g < 2; g++) {
        double deepest = qg_relief_deepest(pair, geometry, g), form = geometry->gears[g].form_radius;
        struct qg_ramp ramp = {kinds < 8, form + take(bytes, 0, 1) * (pair->gears[g].outside_radius - form),
                               take(bytes, 0, 1) * deepest};
        if (kinds & 4)
            relief.gears[g].root = ramp;
        else
            relief.gears[g].tip = ramp;
    }
    struct qg_relief none = {0};
    return qg_relief_check(&relief, pair, geometry, NULL, NULL) == QG_OK ? relief : none;
}

/* ---- what has to hold ------------------------------------------------------------------------------------------- */

static void require_refusal(const struct qg_notes *notes) {
    fuzz_require(notes->count > 0);
    for (size_t i = 0; i < notes->count; i++)
        fuzz_require(*notes->item[i].text);
}

static void require_rating(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry) {
    struct qg_iso6336 rating;
    if (qg_iso6336_rate(pair, geometry, pair->nominal_torque, &rating) != QG_OK)
        return;
    for (int g = 0; g < 2; g++)
        fuzz_require(isfinite(rating.contact_stress[g]) && isfinite(rating.root_stress[g]));
    fuzz_require(rating.contact_stress[0] > 0 && isfinite(rating.stiffness.mesh));
}

/* C_d = C_(-d)' */
static void require_reciprocity(const struct qg_compliance *compliance) {
    size_t n = 2 * compliance->flank_count;
    for (int d = 0; d <= 1; d++)
        for (size_t i = 0; i < 4; i++) {
            size_t row = i * (n - 1) / 3, column = (i * 7 + 3) % n;
            double a = qg_compliance_entry(compliance, d, row, column);
            double b = qg_compliance_entry(compliance, -d, column, row);
            double scale = fabs(qg_compliance_entry(compliance, 0, row, row)) +
                           fabs(qg_compliance_entry(compliance, 0, column, column));
            fuzz_require(isfinite(a) && fabs(a - b) <= 1e-8 * scale);
        }
}

/* One input. */
struct trial {
    struct qg_gear_pair pair;
    struct qg_pair_geometry geometry;
    struct qg_relief relief;
    const struct qg_mesh_density *density;
    struct qg_compliance compliance[2];
};

/* Finite elements of one gear. False when its sector cannot be meshed, which is said in a note. */
static bool make_compliance(struct trial *trial, int g) {
    const struct qg_gear_pair *pair = &trial->pair;
    const struct qg_gear *gear = &pair->gears[g];
    const struct qg_plate plate = {pair->material.youngs_modulus, pair->material.poisson_ratio, gear->face_width, g};
    struct qg_sector_mesh mesh;
    struct qg_notes notes = {0};
    enum qg_status status =
        qg_sector_mesh_init_with(&mesh, &pair->rack, gear, &trial->geometry.gears[g], trial->density, 1, &notes);
    if (status != QG_OK) {
        require_refusal(&notes);
        return false;
    }
    enum qg_support support = g == QG_PINION ? QG_SUPPORT_TORQUE_RING : QG_SUPPORT_FIXED;
    const struct qg_compliance_plan plan = {plate, support, gear->teeth, 2 * QG_PAIR_REACH, .stop = {0}};
    fuzz_require(qg_compliance_init(&trial->compliance[g], &mesh, &plan) == QG_OK);
    qg_sector_mesh_finish(&mesh);
    require_reciprocity(&trial->compliance[g]);
    return true;
}

static void require_site(const struct qg_contact_site *site) {
    fuzz_require(site->n > 0);
    for (size_t i = 0; i < site->n; i++) {
        fuzz_require(site->flexibility[i * site->n + i] > 0);
        for (size_t j = 0; j < i; j++) {
            double a = site->flexibility[i * site->n + j], b = site->flexibility[j * site->n + i];
            fuzz_require(fabs(a - b) <= 1e-9 * site->flexibility[i * site->n + i]);
        }
    }
}

/* bare: without relief. The unloaded error is that of the gaps at points, the loaded one has gaps averaged around them
 * (statics.h); a ramp shorter than an element, a kink as high as the relief, may put them in the other order. */
static void require_case(const struct qg_case_result *c, bool bare) {
    fuzz_require(c->complementarity_residual <= 1e-8);
    fuzz_require(c->pps >= 0 && isfinite(c->pps) && c->loaded_contact_ratio > 0.99 &&
                 isfinite(c->max_contact_pressure));
    for (size_t i = 0; i < POSITIONS; i++) {
        fuzz_require(isfinite(c->static_transmission_error[i]) && c->static_transmission_error[i] > 0);
        fuzz_require(!bare || c->static_transmission_error[i] > c->unloaded_transmission_error[i]);
        double sum = 0;
        for (size_t k = 0; k < QG_PAIR_COUNT; k++) {
            fuzz_require(c->load_share[i * QG_PAIR_COUNT + k] >= -1e-12);
            sum += c->load_share[i * QG_PAIR_COUNT + k];
        }
        fuzz_require(fabs(sum - 1) <= 1e-9);
    }
}

static void require_stresses(const struct qg_statics *statics, struct qg_statics_workspace *workspace,
                             const struct qg_design_result *result) {
    struct qg_stresses *stresses = qg_stresses_create(POSITIONS, QG_PAIR_COUNT);
    fuzz_require(stresses);
    for (size_t i = 0; i < POSITIONS; i++) {
        const double force = result->cases[0].normal_force;
        fuzz_require(qg_statics_stress(statics, workspace, &result->relief, i, 1, &force, &stresses) == QG_OK);
        for (int g = 0; g < 2; g++)
            fuzz_require(isfinite(stresses->tension[g][i].stress) && isfinite(stresses->compression[g][i].stress) &&
                         stresses->tension[g][i].stress >= stresses->compression[g][i].stress);
    }
    qg_stresses_destroy(stresses);
}

/* The case's secant stiffness as an oscillator, at a few speeds. */
static void require_responses(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry,
                              const struct qg_case_result *c) {
    double stiffness[POSITIONS], mean = 0;
    for (size_t i = 0; i < POSITIONS; i++) {
        stiffness[i] = c->normal_force / c->static_transmission_error[i];
        mean += stiffness[i] / POSITIONS;
    }
    for (size_t i = 0; i < POSITIONS; i++)
        stiffness[i] /= mean;
    struct qg_oscillator oscillator = {.damping_ratio = pair->damping_ratio,
                                       .load = c->normal_force / (mean * geometry->backlash / 2)};
    qg_fourier_from_samples(&oscillator.stiffness, stiffness, POSITIONS, 1);
    const struct qg_speed_map map = {.min = 0.3, .max = 1.3, .count = SPEEDS, .start_static = 1};
    struct qg_response response[SPEEDS];
    for (size_t piece = 0; piece < qg_response_pieces(&map); piece++)
        qg_response_piece(&oscillator, &map, piece, response);
    for (size_t i = 0; i < SPEEDS; i++)
        fuzz_require(response[i].period == QG_PERIOD_UNBOUNDED || (isfinite(response[i].rms) && response[i].rms >= 0));
}

/* Two torques, the nominal one first. */
static void require_design(const struct qg_statics *statics, struct qg_design_result *result) {
    struct qg_statics_workspace workspace;
    fuzz_require(qg_statics_workspace_init(&workspace, statics) == QG_OK);
    bool bare = true;
    for (int g = 0; g < 2; g++)
        bare = bare && !result->relief.gears[g].tip.present && !result->relief.gears[g].root.present;
    for (size_t k = 0; k < CASES; k++)
        result->cases[k].torque = statics->pair->nominal_torque / (double)(1 + k);
    fuzz_require(qg_statics_solve(statics, &workspace, result) == QG_OK);
    for (size_t k = 0; k < CASES; k++)
        require_case(&result->cases[k], bare);
    for (size_t i = 0; i < POSITIONS; i++)
        fuzz_require(result->cases[0].static_transmission_error[i] > result->cases[1].static_transmission_error[i]);
    require_stresses(statics, &workspace, result);
    require_responses(statics->pair, statics->geometry, &result->cases[0]);
    qg_statics_workspace_finish(&workspace);
}

static void require_statics(const struct trial *trial) {
    struct qg_statics statics;
    const struct qg_analysis analysis = {.case_count = CASES, .mesh_positions = POSITIONS, .speeds = {.count = SPEEDS}};
    double force = trial->pair.nominal_torque / trial->geometry.gears[QG_PINION].base_radius;
    const struct qg_means means = {.executor = qg_serial_executor};
    fuzz_require(qg_statics_init(&statics, &trial->pair, &trial->geometry, trial->compliance, POSITIONS, force,
                                 &means) == QG_OK);
    for (size_t i = 0; i < POSITIONS; i++)
        require_site(&statics.site[i]);
    struct qg_design_result *result = qg_design_result_create(&analysis);
    fuzz_require(result);
    result->relief = trial->relief;
    require_design(&statics, result);
    qg_design_result_destroy(result);
    qg_statics_finish(&statics);
}

static void require_pair(struct trial *trial) {
    const struct qg_pair_geometry *geometry = &trial->geometry;
    fuzz_require(geometry->contact_ratio >= 1 && geometry->backlash > 0 && geometry->equivalent_mass > 0);
    require_rating(&trial->pair, geometry);
    if (make_compliance(trial, QG_PINION) && make_compliance(trial, QG_GEAR)) {
        fuzz_harness.accepted++;
        require_statics(trial);
    }
    for (int g = 0; g < 2; g++)
        qg_compliance_finish(&trial->compliance[g]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool ready;
    if (!ready)
        qg_numerics_init(1);
    ready = true;
    struct bytes bytes = {data, size};
    struct trial trial = {.pair = take_pair(&bytes)};
    struct qg_notes notes = {0};
    if (qg_pair_derive(&trial.pair, &trial.geometry, &notes) == QG_OK) {
        fuzz_require(notes.count == 0);
        trial.relief = take_relief(&bytes, &trial.pair, &trial.geometry);
        trial.density = &densities[take(&bytes, 0, 1) > 0.75];
        require_pair(&trial);
    } else {
        require_refusal(&notes);
    }
    return 0;
}
