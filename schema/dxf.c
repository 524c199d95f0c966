/* The writer of DXF drawings: version AC1015 (AutoCAD 2000), ASCII, pairs of a group code and a value on lines of their own.
 *
 * AC1015 is the oldest version that says its unit ($INSUNITS) and has light-weight polylines, and is read by everything. It wants
 * its tables, two block definitions and a root dictionary even when they hold nothing; these are the texts below. Handles
 * are hexadecimal: the texts use those below 40, entities count from 40, $HANDSEED is beyond all.
 */
#include <math.h>
#include <string.h>

#include "core/profile.h"
#include "schema/drawing.h"

enum { FIRST_HANDLE = 0x40, MODEL_SPACE = 0x20 };

/* Layers: name, colour (of AutoCAD's index). */
static const struct layer {
    const char *name;
    int color;
} layers[] = {{"0", 7},     {"PINION", 5},     {"PINION_BORE", 5},  {"PINION_CIRCLES", 8},
              {"GEAR", 30}, {"GEAR_BORE", 30}, {"GEAR_CIRCLES", 8}, {"PATH_OF_CONTACT", 1}};
enum { LAYER_COUNT = sizeof layers / sizeof *layers, FIRST_LAYER_HANDLE = 0x30 };

static const char *const outline_layer[] = {"PINION", "GEAR"};
static const char *const bore_layer[] = {"PINION_BORE", "GEAR_BORE"};
static const char *const circle_layer[] = {"PINION_CIRCLES", "GEAR_CIRCLES"};

static const char before_layers[] = "0\nSECTION\n2\nCLASSES\n0\nENDSEC\n"
                                    "0\nSECTION\n2\nTABLES\n"
                                    "0\nTABLE\n2\nVPORT\n5\n1\n330\n0\n100\nAcDbSymbolTable\n70\n0\n0\nENDTAB\n"
                                    "0\nTABLE\n2\nLTYPE\n5\n2\n330\n0\n100\nAcDbSymbolTable\n70\n3\n"
                                    "0\nLTYPE\n5\n11\n330\n2\n100\nAcDbSymbolTableRecord\n100\nAcDbLinetypeTableRecord"
                                    "\n2\nByBlock\n70\n0\n3\n\n72\n65\n73\n0\n40\n0\n"
                                    "0\nLTYPE\n5\n12\n330\n2\n100\nAcDbSymbolTableRecord\n100\nAcDbLinetypeTableRecord"
                                    "\n2\nByLayer\n70\n0\n3\n\n72\n65\n73\n0\n40\n0\n"
                                    "0\nLTYPE\n5\n13\n330\n2\n100\nAcDbSymbolTableRecord\n100\nAcDbLinetypeTableRecord"
                                    "\n2\nContinuous\n70\n0\n3\nSolid line\n72\n65\n"
                                    "73\n0\n40\n0\n"
                                    "0\nENDTAB\n";

static const char after_layers[] =
    "0\nTABLE\n2\nSTYLE\n5\n4\n330\n0\n100\nAcDbSymbolTable\n70\n1\n"
    "0\nSTYLE\n5\n14\n330\n4\n100\nAcDbSymbolTableRecord\n100\nAcDbTextStyleTableRecord\n2\nStandard\n70\n0\n40\n0\n41"
    "\n1\n50\n0\n71\n0\n"
    "42\n2.5\n3\ntxt\n4\n\n"
    "0\nENDTAB\n"
    "0\nTABLE\n2\nVIEW\n5\n5\n330\n0\n100\nAcDbSymbolTable\n70\n0\n0\nENDTAB\n"
    "0\nTABLE\n2\nUCS\n5\n6\n330\n0\n100\nAcDbSymbolTable\n70\n0\n0\nENDTAB\n"
    "0\nTABLE\n2\nAPPID\n5\n7\n330\n0\n100\nAcDbSymbolTable\n70\n1\n"
    "0\nAPPID\n5\n15\n330\n7\n100\nAcDbSymbolTableRecord\n100\nAcDbRegAppTableRecord\n2\nACAD\n70\n0\n"
    "0\nENDTAB\n"
    "0\nTABLE\n2\nDIMSTYLE\n5\n8\n330\n0\n100\nAcDbSymbolTable\n70\n1\n100\nAcDbDimStyleTable\n"
    "0\nDIMSTYLE\n105\n16\n330\n8\n100\nAcDbSymbolTableRecord\n100\nAcDbDimStyleTableRecord\n2\nStandard\n70\n0\n"
    "0\nENDTAB\n"
    "0\nTABLE\n2\nBLOCK_RECORD\n5\n9\n330\n0\n100\nAcDbSymbolTable\n70\n2\n"
    "0\nBLOCK_RECORD\n5\n20\n330\n9\n100\nAcDbSymbolTableRecord\n100\nAcDbBlockTableRecord\n2\n*Model_Space\n"
    "0\nBLOCK_RECORD\n5\n21\n330\n9\n100\nAcDbSymbolTableRecord\n100\nAcDbBlockTableRecord\n2\n*Paper_Space\n"
    "0\nENDTAB\n0\nENDSEC\n"
    "0\nSECTION\n2\nBLOCKS\n"
    "0\nBLOCK\n5\n22\n330\n20\n100\nAcDbEntity\n8\n0\n100\nAcDbBlockBegin\n2\n*Model_"
    "Space\n70\n0\n10\n0\n20\n0\n30\n0\n"
    "3\n*Model_Space\n1\n\n0\nENDBLK\n5\n23\n330\n20\n100\nAcDbEntity\n8\n0\n100\nAcDbBlockEnd\n"
    "0\nBLOCK\n5\n24\n330\n21\n100\nAcDbEntity\n67\n1\n8\n0\n100\nAcDbBlockBegin\n2\n*Paper_"
    "Space\n70\n0\n10\n0\n20\n0\n30\n0\n"
    "3\n*Paper_Space\n1\n\n0\nENDBLK\n5\n25\n330\n21\n100\nAcDbEntity\n67\n1\n8\n0\n100\nAcDbBlockEnd\n"
    "0\nENDSEC\n";

static const char objects[] = "0\nSECTION\n2\nOBJECTS\n"
                              "0\nDICTIONARY\n5\nA\n330\n0\n100\nAcDbDictionary\n281\n1\n3\nACAD_GROUP\n350\nB\n"
                              "0\nDICTIONARY\n5\nB\n330\nA\n100\nAcDbDictionary\n281\n1\n"
                              "0\nENDSEC\n0\nEOF\n";

/* A drawing on its way out. */
struct drawing {
    struct qg_text *text;
    const struct qg_study *study;
    struct qg_pair_geometry geometry;
    unsigned handle; /* of the next entity */
};

static void put_word(struct drawing *d, int code, const char *word) {
    qg_text_format(d->text, "%d\n%s\n", code, word);
}

static void put_whole(struct drawing *d, int code, int value) {
    qg_text_format(d->text, "%d\n%d\n", code, value);
}

static void put_number(struct drawing *d, int code, double value) {
    char out[QG_NUMBER_ROOM];
    qg_number_print(out, value);
    put_word(d, code, out);
}

static void put_point(struct drawing *d, int code, struct qg_point p) {
    put_number(d, code, p.x);
    put_number(d, code + 10, p.y);
    put_whole(d, code + 20, 0);
}

/* ---- entities --------------------------------------------------------------------------------------------------- */

static void open_entity(struct drawing *d, const char *type, const char *layer) {
    qg_text_format(d->text, "0\n%s\n5\n%X\n330\n%X\n100\nAcDbEntity\n8\n%s\n", type, d->handle++, MODEL_SPACE, layer);
}

static void put_circle(struct drawing *d, const char *layer, double center, double radius) {
    open_entity(d, "CIRCLE", layer);
    put_word(d, 100, "AcDbCircle");
    put_point(d, 10, (struct qg_point){center, 0});
    put_number(d, 40, radius);
}

static void put_line(struct drawing *d, const char *layer, struct qg_point from, struct qg_point to) {
    open_entity(d, "LINE", layer);
    put_word(d, 100, "AcDbLine");
    put_point(d, 10, from);
    put_point(d, 11, to);
}

static void put_polyline(struct drawing *d, const char *layer, const struct qg_outline *outline, bool closed) {
    open_entity(d, "LWPOLYLINE", layer);
    put_word(d, 100, "AcDbPolyline");
    put_whole(d, 90, (int)outline->count);
    put_whole(d, 70, closed);
    for (size_t i = 0; i < outline->count; i++) {
        const struct qg_corner *c = &outline->corner[i];
        put_number(d, 10, c->x);
        put_number(d, 20, c->y);
        if (c->bulge != 0)
            put_number(d, 42, c->bulge);
    }
}

/* ---- the gears -------------------------------------------------------------------------------------------------- */

/* Half a tooth in arcs; text->failed when memory is short. */
static bool half_tooth(struct drawing *d, int gear, struct qg_outline *half) {
    struct qg_profile profile;
    qg_profile_init(&profile, &(struct qg_made_gear){&d->study->pair, &d->geometry, &d->study->relief, gear});
    return qg_profile_arcs(&profile, QG_ARC_TOLERANCE, half) == QG_OK;
}

static double axis_of(const struct drawing *d, int gear) {
    return gear == QG_GEAR ? d->study->pair.center_distance : 0;
}

static void put_gear(struct drawing *d, int gear, double angle) {
    struct qg_outline tooth = {0}, ring = {0};
    double axis = axis_of(d, gear);
    if (half_tooth(d, gear, &tooth) && qg_outline_mirror(&tooth) == QG_OK &&
        qg_outline_ring(&tooth, d->study->pair.gears[gear].teeth, &ring) == QG_OK) {
        qg_outline_turn(&ring, angle, axis);
        put_polyline(d, outline_layer[gear], &ring, true);
    } else {
        d->text->failed = true;
    }
    qg_outline_finish(&tooth);
    qg_outline_finish(&ring);
    const struct qg_gear_geometry *g = &d->geometry.gears[gear];
    put_circle(d, bore_layer[gear], axis, d->study->pair.gears[gear].bore_diameter / 2);
    put_circle(d, circle_layer[gear], axis, g->reference_radius);
    put_circle(d, circle_layer[gear], axis, g->base_radius);
    put_circle(d, circle_layer[gear], axis, g->base_radius / cos(d->geometry.working_pressure_angle));
}

/* From the middle of one tip through the space, which points up, to the middle of the next. */
static void put_space(struct drawing *d, int gear) {
    struct qg_outline half = {0};
    bool made = half_tooth(d, gear, &half);
    if (made) {
        qg_outline_turn(&half, -M_PI / d->study->pair.gears[gear].teeth, 0);
        qg_outline_reverse(&half);
        half.corner[half.count - 1].y = 0; /* the middle of the space, to the last bit */
        made = qg_outline_mirror(&half) == QG_OK;
    }
    if (made) {
        qg_outline_turn(&half, M_PI_2, axis_of(d, gear));
        put_polyline(d, outline_layer[gear], &half, false);
    } else {
        d->text->failed = true;
    }
    qg_outline_finish(&half);
}

/* ---- the file --------------------------------------------------------------------------------------------------- */

static void put_header(struct drawing *d) {
    const struct qg_gear *gears = d->study->pair.gears;
    double high = fmax(gears[0].outside_radius, gears[1].outside_radius);
    qg_text_format(d->text, "999\nquietgear: tooth profiles, arcs within 0.1 micrometres\n"
                            "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$DWGCODEPAGE\n3\nANSI_1252\n"
                            "9\n$HANDSEED\n5\nFFFF\n9\n$INSUNITS\n70\n4\n9\n$MEASUREMENT\n70\n1\n9\n$LUNITS\n70\n2\n");
    put_word(d, 9, "$EXTMIN");
    put_point(d, 10, (struct qg_point){-gears[QG_PINION].outside_radius, -high});
    put_word(d, 9, "$EXTMAX");
    put_point(d, 10, (struct qg_point){d->study->pair.center_distance + gears[QG_GEAR].outside_radius, high});
    put_word(d, 0, "ENDSEC");
}

static void put_layers(struct drawing *d) {
    qg_text_add(d->text, before_layers, sizeof before_layers - 1);
    qg_text_format(d->text, "0\nTABLE\n2\nLAYER\n5\n3\n330\n0\n100\nAcDbSymbolTable\n70\n%d\n", LAYER_COUNT);
    for (int i = 0; i < LAYER_COUNT; i++)
        qg_text_format(d->text,
                       "0\nLAYER\n5\n%X\n330\n3\n100\nAcDbSymbolTableRecord\n100\nAcDbLayerTableRecord\n2\n%s\n70\n0\n"
                       "62\n%d\n6\nContinuous\n",
                       FIRST_LAYER_HANDLE + i, layers[i].name, layers[i].color);
    qg_text_format(d->text, "0\nENDTAB\n");
    qg_text_add(d->text, after_layers, sizeof after_layers - 1);
}

static void put_mounted(struct drawing *d, double position) {
    struct qg_mounted mounted;
    qg_mounted_at(&d->geometry, &d->study->pair, position, &mounted);
    put_gear(d, QG_PINION, mounted.angle[QG_PINION]);
    put_gear(d, QG_GEAR, mounted.angle[QG_GEAR]);
    put_line(d, "PATH_OF_CONTACT", qg_action_point(&d->geometry, d->geometry.path_start),
             qg_action_point(&d->geometry, d->geometry.path_end));
}

void qg_dxf_write(struct qg_text *text, const struct qg_job *job, enum qg_extent extent, double position) {
    struct drawing d = {.text = text, .study = &job->study, .handle = FIRST_HANDLE};
    qg_pair_derive(&job->study.pair, &d.geometry, NULL); /* the reader has found it possible */
    put_header(&d);
    put_layers(&d);
    qg_text_format(text, "0\nSECTION\n2\nENTITIES\n");
    if (extent == QG_EXTENT_GEARS) {
        put_mounted(&d, position);
    } else {
        put_space(&d, QG_PINION);
        put_space(&d, QG_GEAR);
    }
    qg_text_format(text, "0\nENDSEC\n");
    qg_text_add(text, objects, sizeof objects - 1);
}

int qg_extent_of_name(const char *name) {
    return strcmp(name, "gears") == 0 ? QG_EXTENT_GEARS : strcmp(name, "spaces") == 0 ? QG_EXTENT_SPACES : -1;
}
