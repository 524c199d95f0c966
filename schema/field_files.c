/* The full field as files of visualization programs. Both number nodes and elements through pinion and gear; the order of
 * the eight nodes of an element, corners and then the midsides behind each, is ours in both. */
#include "schema/field.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One figure of a node, up to `components` of them. */
struct quantity {
    const char *name;
    int components;
    void (*read)(const struct qg_field *field, int gear, size_t node, double *out);
};

static void read_displacement(const struct qg_field *field, int gear, size_t node, double *out) {
    out[0] = field->gears[gear].displacement[2 * node];
    out[1] = field->gears[gear].displacement[2 * node + 1];
    out[2] = 0;
}

static void read_stress(const struct qg_field *field, int gear, size_t node, double *out) {
    const struct qg_plane_stress *s = &field->gears[gear].stress[node];
    out[0] = s->xx;
    out[1] = s->yy;
    out[2] = s->xy;
}

static void read_von_mises(const struct qg_field *field, int gear, size_t node, double *out) {
    *out = qg_von_mises(&field->gears[gear].stress[node], &field->gears[gear].plate);
}

static void read_max_principal(const struct qg_field *field, int gear, size_t node, double *out) {
    *out = qg_max_principal(&field->gears[gear].stress[node]);
}

static const struct quantity displacement = {"displacement", 3, read_displacement};
static const struct quantity stress = {"stress", 3, read_stress};
static const struct quantity scalars[] = {{"von_mises", 1, read_von_mises}, {"max_principal", 1, read_max_principal}};
enum { SCALARS = sizeof scalars / sizeof *scalars };

static void words(struct qg_text *text, const char *line) {
    qg_text_add(text, line, strlen(line));
}

/* Numbers with blanks before them, to 9 digits, whatever the locale. */
static void numbers(struct qg_text *text, const double *value, int count) {
    for (int k = 0; k < count; k++) {
        char printed[QG_NUMBER_ROOM];
        snprintf(printed, sizeof printed, "%.9g", value[k]);
        int length = qg_number_print(printed, strtod(printed, NULL));
        qg_text_add(text, " ", 1);
        qg_text_add(text, printed, (size_t)length);
    }
}

static size_t nodes_of(const struct qg_field *field) {
    return field->gears[QG_PINION].mesh.node_count + field->gears[QG_GEAR].mesh.node_count;
}

static size_t elements_of(const struct qg_field *field) {
    return field->gears[QG_PINION].mesh.element_count + field->gears[QG_GEAR].mesh.element_count;
}

/* What comes before a gear's first node. */
static size_t nodes_before(const struct qg_field *field, int gear) {
    return gear == QG_PINION ? 0 : field->gears[QG_PINION].mesh.node_count;
}

static void write_place(struct qg_text *text, const struct qg_field *field, int gear, size_t node) {
    double at[3] = {0};
    qg_field_node(field, gear, node, at);
    numbers(text, at, 3);
    words(text, "\n");
}

static void write_element(struct qg_text *text, const struct qg_field *field, int gear, size_t element, size_t first) {
    for (int k = 0; k < QG_ELEMENT_NODES; k++)
        qg_text_format(text, " %zu",
                       first + nodes_before(field, gear) + (size_t)field->gears[gear].mesh.element[element][k]);
    words(text, "\n");
}

/* ---- VTK -------------------------------------------------------------------------------------------------------- */

static void write_vtk_values(struct qg_text *text, const struct qg_field *field, const struct quantity *quantity) {
    for (int g = 0; g < 2; g++)
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++) {
            double value[3];
            quantity->read(field, g, n, value);
            numbers(text, value, quantity->components);
            words(text, "\n");
        }
}

static void write_vtk_mesh(struct qg_text *text, const struct qg_field *field) {
    enum { QUADRATIC_QUAD = 23 };
    qg_text_format(text, "DATASET UNSTRUCTURED_GRID\nPOINTS %zu double\n", nodes_of(field));
    for (int g = 0; g < 2; g++)
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++)
            write_place(text, field, g, n);
    qg_text_format(text, "CELLS %zu %zu\n", elements_of(field), (QG_ELEMENT_NODES + 1) * elements_of(field));
    for (int g = 0; g < 2; g++)
        for (size_t e = 0; e < field->gears[g].mesh.element_count; e++) {
            qg_text_format(text, "%d", QG_ELEMENT_NODES);
            write_element(text, field, g, e, 0);
        }
    qg_text_format(text, "CELL_TYPES %zu\n", elements_of(field));
    for (size_t e = 0; e < elements_of(field); e++)
        qg_text_format(text, "%d\n", QUADRATIC_QUAD);
}

void qg_field_write_vtk(struct qg_text *text, const struct qg_field *field) {
    words(text, "# vtk DataFile Version 3.0\nquietgear: spur gear pair, mm, MPa\nASCII\n");
    write_vtk_mesh(text, field);
    qg_text_format(text, "CELL_DATA %zu\nSCALARS gear int 1\nLOOKUP_TABLE default\n", elements_of(field));
    for (int g = 0; g < 2; g++)
        for (size_t e = 0; e < field->gears[g].mesh.element_count; e++)
            qg_text_format(text, "%d\n", g);
    qg_text_format(text, "POINT_DATA %zu\nVECTORS displacement double\n", nodes_of(field));
    write_vtk_values(text, field, &displacement);
    for (int k = 0; k < SCALARS; k++) {
        qg_text_format(text, "SCALARS %s double 1\nLOOKUP_TABLE default\n", scalars[k].name);
        write_vtk_values(text, field, &scalars[k]);
    }
    qg_text_format(text, "FIELD components 1\n%s %d %zu double\n", stress.name, stress.components, nodes_of(field));
    write_vtk_values(text, field, &stress);
}

/* ---- Gmsh ------------------------------------------------------------------------------------------------------- */

static void write_gmsh_entities(struct qg_text *text, const struct qg_field *field) {
    words(text, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"pinion\"\n2 2 \"gear\"\n"
                "$EndPhysicalNames\n$Entities\n0 0 2 0\n");
    for (int g = 0; g < 2; g++) { /* a surface: tag, box, one physical tag, no bounding curves */
        double most = 0;
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++)
            most = field->gears[g].mesh.node[n].radius > most ? field->gears[g].mesh.node[n].radius : most;
        double x = field->gears[g].center;
        qg_text_format(text, "%d", g + 1);
        numbers(text, (const double[]){x - most, -most, 0, x + most, most, 0}, 6);
        qg_text_format(text, " 1 %d 0\n", g + 1);
    }
    words(text, "$EndEntities\n");
}

static void write_gmsh_mesh(struct qg_text *text, const struct qg_field *field) {
    enum { QUADRATIC_QUAD = 16 };
    qg_text_format(text, "$Nodes\n2 %zu 1 %zu\n", nodes_of(field), nodes_of(field));
    for (int g = 0; g < 2; g++) {
        qg_text_format(text, "2 %d 0 %zu\n", g + 1, field->gears[g].mesh.node_count);
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++)
            qg_text_format(text, "%zu\n", 1 + nodes_before(field, g) + n);
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++)
            write_place(text, field, g, n);
    }
    qg_text_format(text, "$EndNodes\n$Elements\n2 %zu 1 %zu\n", elements_of(field), elements_of(field));
    size_t number = 1;
    for (int g = 0; g < 2; g++) {
        qg_text_format(text, "2 %d %d %zu\n", g + 1, QUADRATIC_QUAD, field->gears[g].mesh.element_count);
        for (size_t e = 0; e < field->gears[g].mesh.element_count; e++) {
            qg_text_format(text, "%zu", number++);
            write_element(text, field, g, e, 1);
        }
    }
    words(text, "$EndElements\n");
}

/* A view: a name; time 0; step 0, components, nodes. Stress is a tensor of nine there. */
static void write_gmsh_view(struct qg_text *text, const struct qg_field *field, const struct quantity *quantity) {
    bool tensor = quantity->read == read_stress;
    qg_text_format(text, "$NodeData\n1\n\"%s\"\n1\n0\n3\n0\n%d\n%zu\n", quantity->name,
                   tensor ? 9 : quantity->components, nodes_of(field));
    for (int g = 0; g < 2; g++)
        for (size_t n = 0; n < field->gears[g].mesh.node_count; n++) {
            double v[3];
            quantity->read(field, g, n, v);
            qg_text_format(text, "%zu", 1 + nodes_before(field, g) + n);
            if (tensor)
                numbers(text, (const double[]){v[0], v[2], 0, v[2], v[1], 0, 0, 0, 0}, 9);
            else
                numbers(text, v, quantity->components);
            words(text, "\n");
        }
    words(text, "$EndNodeData\n");
}

void qg_field_write_gmsh(struct qg_text *text, const struct qg_field *field) {
    write_gmsh_entities(text, field);
    write_gmsh_mesh(text, field);
    write_gmsh_view(text, field, &displacement);
    for (int k = 0; k < SCALARS; k++)
        write_gmsh_view(text, field, &scalars[k]);
    write_gmsh_view(text, field, &stress);
}
