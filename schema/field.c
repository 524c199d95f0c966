/* The full field as JSON. Figures are rounded to what the eye can use: 0.1 um of place, 1 nm of displacement, 0.1 MPa. */
#include "schema/field.h"

#include <math.h>

#include "core/field_view.h"
#include "schema/members.h"
#include "schema/result.h"

static const char *const gear_names[2] = {[QG_PINION] = "pinion", [QG_GEAR] = "gear"};

/* One figure of a node. */
typedef double figure(const struct qg_field *field, int gear, size_t node);

static double node_x(const struct qg_field *field, int gear, size_t node) {
    double xy[2];
    qg_field_node(field, gear, node, xy);
    return xy[0];
}

static double node_y(const struct qg_field *field, int gear, size_t node) {
    double xy[2];
    qg_field_node(field, gear, node, xy);
    return xy[1];
}

static double displacement_x_um(const struct qg_field *field, int gear, size_t node) {
    return 1e3 * field->gears[gear].displacement[2 * node];
}

static double displacement_y_um(const struct qg_field *field, int gear, size_t node) {
    return 1e3 * field->gears[gear].displacement[2 * node + 1];
}

static double von_mises(const struct qg_field *field, int gear, size_t node) {
    return qg_von_mises(&field->gears[gear].stress[node], &field->gears[gear].plate);
}

static double max_principal(const struct qg_field *field, int gear, size_t node) {
    return qg_max_principal(&field->gears[gear].stress[node]);
}

static const struct column {
    const char *name;
    figure *value;
    double scale; /* 1 / the step it is rounded to */
} columns[] = {
    {"x_mm", node_x, 1e4},
    {"y_mm", node_y, 1e4},
    {"displacement_x_um", displacement_x_um, 1e3},
    {"displacement_y_um", displacement_y_um, 1e3},
    {"von_mises_mpa", von_mises, 10},
    {"max_principal_mpa", max_principal, 10},
};

static void rounded(struct qg_text *text, double value, double scale) {
    qg_json_number(text, nearbyint(value * scale) / scale);
}

static void write_quads(struct qg_text *text, const struct qg_field_view *view) {
    qg_json_name(text, "quads");
    qg_json_open(text, '[');
    for (size_t q = 0; q < view->quad_count; q++) {
        qg_json_open(text, '[');
        for (int k = 0; k < 4; k++)
            qg_json_integer(text, view->quad[q][k]);
        qg_json_close(text, ']');
    }
    qg_json_close(text, ']');
}

static void write_gear(struct qg_text *text, const struct qg_field *field, int gear) {
    struct qg_field_view view;
    if (qg_field_view_init(&view, &field->gears[gear].mesh) != QG_OK) {
        text->failed = true;
        return;
    }
    qg_json_name(text, gear_names[gear]);
    qg_json_open(text, '{');
    number(text, "center_x_mm", field->gears[gear].center);
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++) {
        qg_json_name(text, columns[k].name);
        qg_json_open(text, '[');
        for (size_t n = 0; n < view.node_count; n++)
            rounded(text, columns[k].value(field, gear, (size_t)view.node[n]), columns[k].scale);
        qg_json_close(text, ']');
    }
    write_quads(text, &view);
    qg_json_close(text, '}');
    qg_field_view_finish(&view);
}

static void write_contact(struct qg_text *text, const struct qg_field *field) {
    qg_json_name(text, "contact");
    qg_json_open(text, '[');
    for (size_t i = 0; i < field->load_count; i++) {
        const struct qg_field_load *load = &field->load[i];
        qg_json_open(text, '{');
        qg_json_name(text, "pair");
        qg_json_integer(text, load->pair);
        qg_json_name(text, "pinion_radius_mm");
        rounded(text, load->radius[QG_PINION], 1e4);
        qg_json_name(text, "gear_radius_mm");
        rounded(text, load->radius[QG_GEAR], 1e4);
        qg_json_name(text, "pressure_mpa");
        rounded(text, load->pressure, 10);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

void qg_field_write(struct qg_text *text, const struct qg_field *field) {
    qg_json_open(text, '{');
    number(text, "mesh_position", field->position);
    number(text, "torque_nm", field->torque / 1e3);
    number(text, "static_transmission_error_um", 1e3 * field->approach);
    for (int g = 0; g < 2; g++)
        write_gear(text, field, g);
    write_contact(text, field);
    qg_json_close(text, '}');
}
