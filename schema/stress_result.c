/* The writer of stresses. Angles become degrees, torques N m. */
#include "schema/stress_result.h"
#include "schema/members.h"

#include <math.h>

static const double degree = M_PI / 180;
static const char *const gear_names[] = {[QG_PINION] = "pinion", [QG_GEAR] = "gear"};

/* {"pinion": values[0], "gear": values[1]} */
static void both(struct qg_text *text, const char *name, const double values[2]) {
    open_member(text, name, '{');
    for (int g = QG_PINION; g <= QG_GEAR; g++)
        number(text, gear_names[g], values[g]);
    qg_json_close(text, '}');
}

/* ---- roots ------------------------------------------------------------------------------------------------------- */

/* Where an extreme stands. */
static void write_place(struct qg_text *text, const char *name, const struct qg_root_stress *at, size_t position,
                        size_t positions) {
    open_member(text, name, '{');
    number(text, "radius_mm", at->at.radius);
    number(text, "angle_deg", at->at.angle / degree);
    number(text, "mesh_position", (double)position / (double)positions);
    qg_json_name(text, "pair");
    qg_json_integer(text, at->pair);
    qg_json_close(text, '}');
}

static void write_extreme(struct qg_text *text, const char *value, const char *place,
                          struct qg_root_stress *const curve[2], const size_t at[2], size_t positions) {
    const double extreme[2] = {curve[QG_PINION][at[QG_PINION]].stress, curve[QG_GEAR][at[QG_GEAR]].stress};
    both(text, value, extreme);
    open_member(text, place, '{');
    for (int g = QG_PINION; g <= QG_GEAR; g++)
        write_place(text, gear_names[g], &curve[g][at[g]], at[g], positions);
    qg_json_close(text, '}');
}

static void write_curve(struct qg_text *text, const char *name, const struct qg_root_stress *curve, size_t positions) {
    open_member(text, name, '[');
    for (size_t i = 0; i < positions; i++)
        qg_json_number(text, curve[i].stress);
    qg_json_close(text, ']');
}

static void write_roots(struct qg_text *text, const struct qg_stresses *s) {
    write_extreme(text, "max_root_stress_mpa", "max_root_stress_at", s->tension, s->most_tension, s->positions);
    write_extreme(text, "min_root_stress_mpa", "min_root_stress_at", s->compression, s->most_compression, s->positions);
    open_member(text, "root_stress_mpa", '{');
    for (int g = QG_PINION; g <= QG_GEAR; g++) {
        open_member(text, gear_names[g], '{');
        write_curve(text, "tension", s->tension[g], s->positions);
        write_curve(text, "compression", s->compression[g], s->positions);
        qg_json_close(text, '}');
    }
    qg_json_close(text, '}');
}

/* ---- pressure ---------------------------------------------------------------------------------------------------- */

/* The index of the k-th entry along the path: pairs follow each other by one base pitch, positions within it. */
static size_t along_path(const struct qg_stresses *s, size_t k) {
    return k % s->positions * s->pairs + k / s->positions;
}

enum pressure_column { PATH, PRESSURE, PINION_RADIUS, GEAR_RADIUS };

static void write_column(struct qg_text *text, const char *name, const struct qg_stresses *s,
                         enum pressure_column column) {
    open_member(text, name, '[');
    for (size_t k = 0; k < s->positions * s->pairs; k++) {
        const struct qg_pair_pressure *p = &s->pressure[along_path(s, k)];
        const double values[] = {p->path, p->pressure, p->radius[QG_PINION], p->radius[QG_GEAR]};
        if (p->pressure > 0)
            qg_json_number(text, values[column]);
    }
    qg_json_close(text, ']');
}

static void write_pressures(struct qg_text *text, const struct qg_stresses *s, int lowest_pair) {
    const struct qg_pair_pressure *most = &s->pressure[s->most_pressure];
    open_member(text, "max_contact_pressure_at", '{');
    number(text, "path_mm", most->path);
    number(text, "pinion_radius_mm", most->radius[QG_PINION]);
    number(text, "gear_radius_mm", most->radius[QG_GEAR]);
    number(text, "mesh_position", (double)(s->most_pressure / s->pairs) / (double)s->positions);
    qg_json_name(text, "pair");
    qg_json_integer(text, (int)(s->most_pressure % s->pairs) + lowest_pair);
    qg_json_close(text, '}');
    open_member(text, "contact_pressure_path", '{');
    write_column(text, "path_mm", s, PATH);
    write_column(text, "pressure_mpa", s, PRESSURE);
    write_column(text, "pinion_radius_mm", s, PINION_RADIUS);
    write_column(text, "gear_radius_mm", s, GEAR_RADIUS);
    qg_json_close(text, '}');
}

void qg_stresses_write(struct qg_text *text, const struct qg_stresses *stresses, int lowest_pair) {
    static const char *const members[] = {"max_root_stress_mpa",  "max_root_stress_at", "min_root_stress_mpa",
                                          "min_root_stress_at",   "root_stress_mpa",    "max_contact_pressure_at",
                                          "contact_pressure_path"};
    if (stresses) {
        write_roots(text, stresses);
        write_pressures(text, stresses, lowest_pair);
        return;
    }
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        qg_json_name(text, members[i]);
        qg_json_null(text);
    }
}

/* ---- ISO 6336 ---------------------------------------------------------------------------------------------------- */

static void write_root_factors(struct qg_text *text, const struct qg_iso6336 *iso, int gear) {
    open_member(text, gear_names[gear], '{');
    number(text, "y_f", iso->root[gear].form_factor);
    number(text, "y_s", iso->root[gear].stress_correction_factor);
    number(text, "y_b", iso->rim_factor[gear]);
    number(text, "q_s", iso->root[gear].notch_parameter);
    number(text, "face_width_mm", iso->root_face_width[gear]);
    qg_json_close(text, '}');
}

static void write_factors(struct qg_text *text, const struct qg_iso6336 *iso) {
    open_member(text, "factors", '{');
    number(text, "z_h", iso->zone_factor);
    number(text, "z_e_sqrt_mpa", iso->elasticity_factor);
    number(text, "z_eps", iso->contact_ratio_factor);
    number(text, "z_b", iso->single_contact_factor[QG_PINION]);
    number(text, "z_d", iso->single_contact_factor[QG_GEAR]);
    number(text, "y_dt", iso->deep_tooth_factor);
    for (int g = QG_PINION; g <= QG_GEAR; g++)
        write_root_factors(text, iso, g);
    qg_json_close(text, '}');
}

/* Where the pair lies outside of the standard's ranges. */
static void write_ranges(struct qg_text *text, const struct qg_iso6336 *iso) {
    open_member(text, "outside_of_range", '[');
    for (int i = 0; i < QG_ISO6336_RANGES; i++) {
        if (!iso->is_beyond[i])
            continue;
        qg_json_open(text, '{');
        qg_json_name(text, "range");
        qg_json_string(text, qg_iso6336_range_name((enum qg_iso6336_range)i));
        qg_json_name(text, "detail");
        qg_json_string(text, qg_iso6336_range_text((enum qg_iso6336_range)i));
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

void qg_iso6336_write(struct qg_text *text, const struct qg_iso6336 *iso, double torque, double width) {
    qg_json_open(text, '{');
    number(text, "torque_nm", torque / 1000);
    number(text, "tangential_force_n", iso->tangential_force);
    number(text, "nominal_contact_stress_mpa", iso->nominal_contact_stress);
    both(text, "contact_stress_mpa", iso->contact_stress);
    both(text, "root_stress_mpa", iso->root_stress);
    number(text, "theoretical_tooth_stiffness_n_per_mm_um", iso->stiffness.theoretical);
    number(text, "tooth_stiffness_n_per_mm_um", iso->stiffness.single);
    number(text, "mesh_stiffness_n_per_mm_um", iso->stiffness.mesh);
    number(text, "mesh_stiffness_n_per_mm", iso->stiffness.mesh * 1000 * width);
    write_factors(text, iso);
    write_ranges(text, iso);
    qg_json_close(text, '}');
}
