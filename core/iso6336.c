/* The formulas of iso6336.h, one function per factor. */
#include "core/iso6336.h"

#include <assert.h>
#include <math.h>

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

const char *qg_iso6336_range_name(enum qg_iso6336_range range) {
#define WORD(name, word, text) word,
    static const char *const words[] = {QG_ISO6336_RANGE_TABLE(WORD)};
#undef WORD
    assert((unsigned)range < QG_ISO6336_RANGES);
    return words[range];
}

const char *qg_iso6336_range_text(enum qg_iso6336_range range) {
#define TEXT(name, word, text) text,
    static const char *const texts[] = {QG_ISO6336_RANGE_TABLE(TEXT)};
#undef TEXT
    assert((unsigned)range < QG_ISO6336_RANGES);
    return texts[range];
}

/* Relative: shifts in mm over the module, and halves that meet at a limit, have rounding errors. */
static const double rounding = 1e-9;

static bool shifts_are_beyond(const struct qg_iso6336_tooth tooth[2]) {
    double x1 = tooth[0].profile_shift, x2 = tooth[1].profile_shift;
    return x1 < x2 - rounding || x1 + x2 < -0.5 - rounding || x1 + x2 > 2 + rounding;
}

static double rim_of(const struct qg_gear *gear) {
    return gear->root_radius - gear->bore_diameter / 2;
}

static void find_ranges(const struct qg_gear_pair *pair, const struct qg_iso6336_tooth tooth[2],
                        struct qg_iso6336 *out) {
    out->is_beyond[QG_ISO6336_SHIFTS] = shifts_are_beyond(tooth);
    out->is_beyond[QG_ISO6336_SHORT_CONTACT] = tooth->contact_ratio < 1.2 - rounding;
    out->is_beyond[QG_ISO6336_LONG_CONTACT] = tooth->contact_ratio >= 2.5;
    for (int i = 0; i < 2; i++) {
        const struct qg_gear *gear = &pair->gears[i];
        double q = out->root[i].notch_parameter;
        out->is_beyond[QG_ISO6336_NOTCH] |= !(q >= 1 && q < 8);
        out->is_beyond[QG_ISO6336_THIN_RIM] |= rim_of(gear) <= 0.5 * (gear->outside_radius - gear->root_radius);
    }
}

/* ---- part 3: the tooth root -------------------------------------------------------------------------------------- */

/* theta - 2G/z tan theta + H = 0 by Newton's method from pi/6, as the standard does; false without a root below pi/2. */
static bool tangent_angle(double g, double teeth, double h, double *theta) {
    *theta = M_PI / 6;
    for (int i = 0; i < 40; i++) {
        double tangent = tan(*theta), ratio = 2 * g / teeth;
        double step = (*theta - ratio * tangent + h) / (1 - ratio * (1 + tangent * tangent));
        *theta -= step;
        if (!(*theta > -M_PI_2 && *theta < M_PI_2))
            return false;
        if (fabs(step) < 1e-14)
            return true;
    }
    return false;
}

/* The load at the outer point of single contact: radius, angle against the chord, height of its cut with the centre line
 * above the gear's axis (modules). */
static double load_height(const struct qg_iso6336_tooth *t, struct qg_iso6336_root *out) {
    double alpha = t->pressure_angle, base = t->teeth / 2 * cos(alpha);
    double along = sqrt(t->outside_radius * t->outside_radius - base * base) -
                   M_PI * cos(alpha) * (t->contact_ratio - 1); /* NaN when the tip lies below the base circle */
    out->load_radius = hypot(base, along);
    double alpha_e = atan2(along, base);
    double gamma = (M_PI_2 + 2 * t->profile_shift * tan(alpha)) / t->teeth + qg_involute(alpha) - qg_involute(alpha_e);
    out->load_angle = alpha_e - gamma;
    return out->load_radius * (cos(gamma) - sin(gamma) * tan(out->load_angle));
}

enum qg_status qg_iso6336_root_factors(const struct qg_iso6336_tooth *t, struct qg_iso6336_root *out) {
    double alpha = t->pressure_angle, rho = t->tip_rounding, theta;
    double e = M_PI_4 - t->dedendum * tan(alpha) - (1 - sin(alpha)) * rho / cos(alpha);
    double g = rho - t->dedendum + t->profile_shift;
    double h = 2 / t->teeth * (M_PI_2 - e) - M_PI / 3;
    if (!tangent_angle(g, t->teeth, h, &theta))
        return QG_NO_CONVERGENCE;
    double center = g / cos(theta) - rho; /* of the rounding, along the 30 degree normal */
    out->chord = t->teeth * sin(M_PI / 3 - theta) + sqrt(3) * center;
    out->fillet_radius = rho + 2 * g * g / (cos(theta) * (t->teeth * cos(theta) * cos(theta) - 2 * g));
    out->load_arm = load_height(t, out) - (t->teeth * cos(M_PI / 3 - theta) + center) / 2;
    if (!(out->chord > 0 && out->fillet_radius > 0 && out->load_arm > 0 && out->load_angle > 0))
        return QG_NO_CONVERGENCE;
    double slenderness = out->chord / out->load_arm;
    out->notch_parameter = out->chord / (2 * out->fillet_radius);
    out->form_factor = 6 * out->load_arm * cos(out->load_angle) / (out->chord * out->chord * cos(alpha));
    out->stress_correction_factor =
        (1.2 + 0.13 * slenderness) * pow(out->notch_parameter, 1 / (1.21 + 2.3 / slenderness));
    return QG_OK;
}

double qg_iso6336_deep_tooth_factor(double contact_ratio) {
    if (contact_ratio <= 2.05)
        return 1;
    return contact_ratio > 2.5 ? 0.7 : 2.366 - 0.666 * contact_ratio;
}

/* Y_B; rim and tooth depth in mm. */
static double rim_factor(double rim, double depth) {
    return rim >= 1.2 * depth ? 1 : 1.6 * log(2.242 * depth / rim);
}

/* ---- part 1: stiffness ------------------------------------------------------------------------------------------- */

/* C_B of one gear's rack. */
static double rack_factor(const struct qg_iso6336_tooth *t) {
    return (1 + 0.5 * (1.2 - t->dedendum)) * (1 - 0.02 * (20 - t->pressure_angle * 180 / M_PI));
}

struct qg_iso6336_stiffness qg_iso6336_stiffness(const struct qg_iso6336_tooth tooth[2], double specific_loading,
                                                 double youngs_modulus) {
    double z1 = tooth[0].teeth, z2 = tooth[1].teeth, x1 = tooth[0].profile_shift, x2 = tooth[1].profile_shift;
    struct qg_iso6336_stiffness s = {.specific_loading = specific_loading};
    s.flexibility = 0.04723 + 0.15551 / z1 + 0.25791 / z2 - 0.00635 * x1 - 0.11654 * x1 / z1 - 0.00193 * x2 -
                    0.24188 * x2 / z2 + 0.00529 * x1 * x1 + 0.00182 * x2 * x2;
    s.theoretical = 1 / s.flexibility;
    s.rack_factor = (rack_factor(&tooth[0]) + rack_factor(&tooth[1])) / 2;
    double light = specific_loading < 100 ? pow(specific_loading / 100, 0.25) : 1;
    s.single = 0.8 * s.theoretical * s.rack_factor * youngs_modulus / 206000 * light;
    s.mesh = s.single * (0.75 * tooth[0].contact_ratio + 0.25);
    return s;
}

/* ---- part 2: contact --------------------------------------------------------------------------------------------- */

/* M1 for gear = 0, M2 for gear = 1. */
static double single_contact_factor(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int gear) {
    double pairs = g->contact_ratio >= 2 ? 2 : 1, left[2];
    for (int i = 0; i < 2; i++) {
        double ratio = pair->gears[i].outside_radius / g->gears[i].base_radius;
        double pitches = i == gear ? pairs : g->contact_ratio - pairs;
        left[i] = sqrt(ratio * ratio - 1) - pitches * 2 * M_PI / pair->gears[i].teeth;
    }
    return fmax(1, tan(g->working_pressure_angle) / sqrt(left[0] * left[1]));
}

static void rate_contact(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, struct qg_iso6336 *out) {
    double alpha = pair->rack.pressure_angle, working = g->working_pressure_angle, nu = pair->material.poisson_ratio;
    double ratio = (double)pair->gears[QG_GEAR].teeth / pair->gears[QG_PINION].teeth;
    double diameter = 2 * g->gears[QG_PINION].reference_radius;
    out->zone_factor = sqrt(2 * cos(working) / sin(working)) / cos(alpha);
    out->elasticity_factor = sqrt(pair->material.youngs_modulus / (2 * M_PI * (1 - nu * nu)));
    out->contact_ratio_factor = sqrt((4 - fmin(3, g->contact_ratio)) / 3);
    out->nominal_contact_stress = out->zone_factor * out->elasticity_factor * out->contact_ratio_factor *
                                  sqrt(out->tangential_force / (diameter * g->face_width) * (ratio + 1) / ratio);
    for (int i = 0; i < 2; i++) {
        out->single_contact_factor[i] = single_contact_factor(pair, g, i);
        out->contact_stress[i] = out->single_contact_factor[i] * out->nominal_contact_stress;
    }
}

/* ---- the pair ---------------------------------------------------------------------------------------------------- */

static struct qg_iso6336_tooth tooth_of(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int i) {
    double m = pair->rack.module;
    return (struct qg_iso6336_tooth){
        .teeth = pair->gears[i].teeth,
        .pressure_angle = pair->rack.pressure_angle,
        .profile_shift = pair->gears[i].profile_shift / m,
        .dedendum = g->gears[i].hob_addendum / m,
        .tip_rounding = pair->gears[i].hob_tip_radius / m,
        .outside_radius = pair->gears[i].outside_radius / m,
        .contact_ratio = g->contact_ratio,
    };
}

static void rate_root(const struct qg_gear_pair *pair, const struct qg_pair_geometry *g, int i,
                      struct qg_iso6336 *out) {
    const struct qg_gear *gear = &pair->gears[i];
    const struct qg_iso6336_root *root = &out->root[i];
    double m = pair->rack.module;
    out->root_face_width[i] = fmin(gear->face_width, g->face_width + 2 * m);
    out->rim_factor[i] = rim_factor(rim_of(gear), gear->outside_radius - gear->root_radius);
    out->root_stress[i] = out->tangential_force / (out->root_face_width[i] * m) * root->form_factor *
                          root->stress_correction_factor * out->rim_factor[i] * out->deep_tooth_factor;
}

enum qg_status qg_iso6336_rate(const struct qg_gear_pair *pair, const struct qg_pair_geometry *geometry, double torque,
                               struct qg_iso6336 *out) {
    *out = (struct qg_iso6336){.tangential_force = torque / geometry->gears[QG_PINION].reference_radius};
    struct qg_iso6336_tooth tooth[2];
    for (int i = 0; i < 2; i++) {
        tooth[i] = tooth_of(pair, geometry, i);
        enum qg_status status = qg_iso6336_root_factors(&tooth[i], &out->root[i]);
        if (status != QG_OK)
            return status;
    }
    out->deep_tooth_factor = qg_iso6336_deep_tooth_factor(geometry->contact_ratio);
    rate_contact(pair, geometry, out);
    for (int i = 0; i < 2; i++)
        rate_root(pair, geometry, i, out);
    out->stiffness = qg_iso6336_stiffness((const struct qg_iso6336_tooth *)tooth,
                                          out->tangential_force / geometry->face_width, pair->material.youngs_modulus);
    find_ranges(pair, (const struct qg_iso6336_tooth *)tooth, out);
    return QG_OK;
}
