/* The writer of input decks. Lines stay below 132 characters, which CalculiX asks for, and comments hold ASCII only. */
#include "schema/abaqus.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

static const char *const set_names[2] = {[QG_PINION] = "PINION", [QG_GEAR] = "GEAR"};

static void words(struct qg_text *text, const char *line) {
    qg_text_add(text, line, strlen(line));
}

/* The number behind `before`, to 13 digits: CalculiX reads no more than 20 characters of one. */
static void number(struct qg_text *text, const char *before, double value) {
    char printed[QG_NUMBER_ROOM];
    snprintf(printed, sizeof printed, "%.13g", value);
    words(text, before);
    qg_text_add(text, printed, (size_t)qg_number_print(printed, strtod(printed, NULL)));
}

/* Numbers of the first node and of the first element of a gear, from 1 on. */
static size_t first_node(const struct qg_deck *deck, int gear) {
    return gear == QG_PINION ? 1 : 1 + deck->mesh[QG_PINION].node_count;
}

static size_t first_element(const struct qg_deck *deck, int gear) {
    return gear == QG_PINION ? 1 : 1 + deck->mesh[QG_PINION].element_count;
}

static size_t ring_node(const struct qg_deck *deck) {
    return 1 + deck->mesh[QG_PINION].node_count + deck->mesh[QG_GEAR].node_count;
}

/* ---- head ------------------------------------------------------------------------------------------------------- */

/* Text of a stranger's as a comment: anything but printable ASCII becomes a question mark. */
static void add_plain(struct qg_text *text, const char *utf8, size_t most) {
    for (size_t k = 0; utf8[k] && k < most; k++) {
        char c = utf8[k] >= 0x20 && utf8[k] < 0x7f ? utf8[k] : '?';
        qg_text_add(text, &c, 1);
    }
}

static void write_comment(struct qg_text *text, const struct qg_job *job, const struct qg_deck *deck) {
    words(text, "** quietgear " PACKAGE_VERSION ": static contact of a spur gear pair; N, mm, MPa\n** job: ");
    add_plain(text, job->name, 80);
    words(text, "\n** gear pair: ");
    add_plain(text, job->pair_name, 80);
    number(text, "\n** mesh position ", deck->position);
    number(text, " periods, torque on the pinion ", deck->torque);
    words(text, " N mm\n");
    if (deck->plane == QG_PLANE_STRESS)
        words(text, "** Plane stress: plane-strain elements with E(1+2v)/(1+v)^2 and v/(1+v) are exactly that in the\n"
                    "** plane; ignore the stress out of it.\n");
    else
        words(text, "** Plane strain.\n");
    words(text,
          "** The reliefs are in the mesh. The pinion is drawn turned beyond the contact of the bare involutes, by\n");
    number(text, "** seat = ", deck->seat);
    words(text, " mm along the line of action, where the first flanks overlap a little.\n");
    words(text, "** Static transmission error (mm) = seat + U1 of node set RING");
    number(text, " times ",
           deck->base_radius[QG_PINION] / deck->mesh[QG_PINION].node[deck->mesh[QG_PINION].bore[0]].radius);
    words(text, "\n** (base radius over bore radius; U1 is the mean tangential displacement of the pinion's bore).\n");
}

/* ---- mesh ------------------------------------------------------------------------------------------------------- */

static void write_nodes(struct qg_text *text, const struct qg_deck *deck) {
    words(text, "*NODE, NSET=ALL_NODES\n");
    for (int g = 0; g < 2; g++)
        for (size_t n = 0; n < deck->mesh[g].node_count; n++) {
            double xy[2];
            qg_deck_node(deck, g, n, xy);
            qg_text_format(text, "%zu", first_node(deck, g) + n);
            number(text, ", ", xy[0]);
            number(text, ", ", xy[1]);
            words(text, "\n");
        }
    qg_text_format(text, "*NODE, NSET=RING\n%zu, 0, 0\n", ring_node(deck));
}

static void write_elements(struct qg_text *text, const struct qg_deck *deck, int gear) {
    const struct qg_gear_mesh *mesh = &deck->mesh[gear];
    qg_text_format(text, "*ELEMENT, TYPE=CPE8, ELSET=%s\n", set_names[gear]);
    for (size_t e = 0; e < mesh->element_count; e++) {
        qg_text_format(text, "%zu", first_element(deck, gear) + e);
        for (int k = 0; k < QG_ELEMENT_NODES; k++)
            qg_text_format(text, ", %zu", first_node(deck, gear) + (size_t)mesh->element[e][k]);
        words(text, "\n");
    }
    qg_text_format(text, "*SOLID SECTION, ELSET=%s, MATERIAL=STEEL\n", set_names[gear]);
    number(text, "", deck->thickness[gear]);
    words(text, "\n");
}

static void write_bore_set(struct qg_text *text, const struct qg_deck *deck, int gear) {
    const struct qg_gear_mesh *mesh = &deck->mesh[gear];
    qg_text_format(text, "*NSET, NSET=%s_BORE\n", set_names[gear]);
    for (size_t k = 0; k < mesh->bore_count; k++)
        qg_text_format(text, "%zu%s", first_node(deck, gear) + (size_t)mesh->bore[k],
                       (k + 1) % 10 == 0 || k + 1 == mesh->bore_count ? "\n" : ", ");
}

/* ---- contact ---------------------------------------------------------------------------------------------------- */

static void write_surface(struct qg_text *text, const struct qg_deck *deck, size_t contact, int gear) {
    const struct qg_gear_mesh *mesh = &deck->mesh[gear];
    qg_text_format(text, "*SURFACE, NAME=%s_FLANK_%zu, TYPE=ELEMENT\n", set_names[gear], contact + 1);
    for (size_t edge = 0; 2 * edge + 2 < mesh->flank_count; edge++) {
        size_t element = qg_gear_mesh_flank_element(mesh, deck->contact[contact].tooth[gear], edge);
        qg_text_format(text, "%zu, S4\n", first_element(deck, gear) + element);
    }
}

static void write_contacts(struct qg_text *text, const struct qg_deck *deck) {
    words(text, "*SURFACE INTERACTION, NAME=FLANKS\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n");
    number(text, "", deck->penalty);
    words(text, "\n");
    for (size_t k = 0; k < deck->contact_count; k++) {
        int slave = deck->contact[k].slave;
        for (int g = 0; g < 2; g++)
            write_surface(text, deck, k, g);
        qg_text_format(text, "** pair of teeth %d; the tip of the slave, named first, may engage\n",
                       deck->contact[k].pair);
        qg_text_format(text, "*CONTACT PAIR, INTERACTION=FLANKS, TYPE=SURFACE TO SURFACE\n%s_FLANK_%zu, %s_FLANK_%zu\n",
                       set_names[slave], k + 1, set_names[1 - slave], k + 1);
    }
}

/* ---- the pinion's bore ------------------------------------------------------------------------------------------ */

/* Radially rigid: no radial displacement of any bore node; RING is the mean of the tangential ones. */
static void write_torque_ring(struct qg_text *text, const struct qg_deck *deck) {
    const struct qg_gear_mesh *mesh = &deck->mesh[QG_PINION];
    words(text, "** Components of PINION_BORE are radial and tangential. It cannot move radially; RING is the mean of\n"
                "** its tangential displacements.\n*TRANSFORM, NSET=PINION_BORE, TYPE=C\n0, 0, 0, 0, 0, 1\n"
                "*BOUNDARY\nPINION_BORE, 1, 1\n");
    qg_text_format(text, "*EQUATION\n%zu\n%zu, 1, -1\n", mesh->bore_count + 1, ring_node(deck));
    for (size_t k = 0; k < mesh->bore_count; k++) {
        qg_text_format(text, "%zu, 2", first_node(deck, QG_PINION) + (size_t)mesh->bore[k]);
        number(text, ", ", mesh->bore_share[k]);
        words(text, "\n");
    }
}

/* Clamped to a shaft that turns as a whole: every bore node moves as RING does, tangentially. */
static void write_clamp(struct qg_text *text, const struct qg_deck *deck) {
    const struct qg_gear_mesh *mesh = &deck->mesh[QG_PINION];
    words(text, "** The pinion's bore turns as a whole; RING is its tangential displacement.\n");
    for (size_t k = 0; k < mesh->bore_count; k++)
        for (int c = 1; c <= 2; c++) {
            double direction = qg_deck_node_angle(deck, QG_PINION, (size_t)mesh->bore[k]) + M_PI_2;
            qg_text_format(text, "*EQUATION\n2\n%zu, %d, -1", first_node(deck, QG_PINION) + (size_t)mesh->bore[k], c);
            qg_text_format(text, ", %zu, 1", ring_node(deck));
            number(text, ", ", c == 1 ? cos(direction) : sin(direction));
            words(text, "\n");
        }
}

/* The torque: uniform tangential traction on the bore as consistent nodal forces, or one force on RING. */
static void write_torque(struct qg_text *text, const struct qg_deck *deck) {
    const struct qg_gear_mesh *mesh = &deck->mesh[QG_PINION];
    double force = deck->torque / mesh->node[mesh->bore[0]].radius;
    words(text, "*CLOAD\n");
    if (deck->bore == QG_BORE_CLAMPED) {
        qg_text_format(text, "%zu, 1", ring_node(deck));
        number(text, ", ", force);
        words(text, "\n");
        return;
    }
    for (size_t k = 0; k < mesh->bore_count; k++) {
        qg_text_format(text, "%zu, 2", first_node(deck, QG_PINION) + (size_t)mesh->bore[k]);
        number(text, ", ", force * mesh->bore_share[k]);
        words(text, "\n");
    }
}

/* ---- putting it together ---------------------------------------------------------------------------------------- */

static void write_step(struct qg_text *text, const struct qg_deck *deck) {
    words(text, "*STEP, INC=100\n*STATIC\n1, 1, 1e-5, 1\n");
    write_torque(text, deck);
    words(text, "*NODE PRINT, NSET=RING\nU\n*NODE PRINT, NSET=GEAR_BORE\nRF\n"
                "*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n");
}

void qg_abaqus_write(struct qg_text *text, const struct qg_job *job, const struct qg_deck *deck) {
    words(text, "*HEADING\nquietgear: static contact of a spur gear pair\n");
    write_comment(text, job, deck);
    write_nodes(text, deck);
    for (int g = 0; g < 2; g++)
        write_elements(text, deck, g);
    words(text, "*MATERIAL, NAME=STEEL\n*ELASTIC\n");
    number(text, "", deck->youngs_modulus);
    number(text, ", ", deck->poisson_ratio);
    words(text, "\n");
    for (int g = 0; g < 2; g++)
        write_bore_set(text, deck, g);
    write_contacts(text, deck);
    if (deck->bore == QG_BORE_CLAMPED)
        write_clamp(text, deck);
    else
        write_torque_ring(text, deck);
    words(text, "*BOUNDARY\nGEAR_BORE, 1, 2\n");
    write_step(text, deck);
}
