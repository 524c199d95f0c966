/* The writer of profile data. Lengths in mm, what is removed in micrometres, angles in degrees, arrays side by side. */
#include <math.h>

#include "core/profile.h"
#include "schema/drawing.h"
#include "schema/members.h"

enum { DIAGRAM_POINTS = 121, FRAMES = 49 };

static const char *const gear_names[] = {[QG_PINION] = "pinion", [QG_GEAR] = "gear"};
static const double degree = M_PI / 180;

/* A design with what follows from it. */
struct drawn {
    const struct qg_study *study;
    struct qg_pair_geometry geometry;
    struct qg_relief least, most;
};

static struct qg_made_gear made_gear(const struct drawn *d, const struct qg_relief *relief, int gear) {
    return (struct qg_made_gear){&d->study->pair, &d->geometry, relief, gear};
}

/* One tooth, clockwise from the middle of a space to that of the next. */
static void write_outline(struct qg_text *text, const struct drawn *d, int gear) {
    struct qg_made_gear made = made_gear(d, &d->study->relief, gear);
    struct qg_profile profile;
    struct qg_outline tooth = {0};
    qg_profile_init(&profile, &made);
    if (qg_profile_chords(&profile, QG_CHORD_TOLERANCE, &tooth) != QG_OK || qg_outline_mirror(&tooth) != QG_OK)
        text->failed = true;
    open_member(text, "outline", '{');
    number(text, "tolerance_mm", QG_CHORD_TOLERANCE);
    for (int axis = 0; axis < 2; axis++) {
        open_member(text, axis ? "y_mm" : "x_mm", '[');
        for (size_t i = 0; i < tooth.count; i++)
            qg_json_number(text, axis ? tooth.corner[i].y : tooth.corner[i].x);
        qg_json_close(text, ']');
    }
    qg_json_close(text, '}');
    qg_outline_finish(&tooth);
}

/* Null when the roll length is NaN: there is no such point. */
static void write_mark(struct qg_text *text, const char *name, const struct qg_gear_geometry *gear, double roll) {
    if (isnan(roll)) {
        qg_json_name(text, name);
        qg_json_null(text);
        return;
    }
    open_member(text, name, '{');
    number(text, "roll_length_mm", roll);
    number(text, "roll_angle_deg", roll / gear->base_radius / degree);
    number(text, "radius_mm", qg_radius_of_roll(gear, roll));
    qg_json_close(text, '}');
}

static void write_marks(struct qg_text *text, const struct drawn *d, int gear) {
    const struct qg_gear_geometry *g = &d->geometry.gears[gear];
    struct qg_marks marks;
    qg_profile_marks(&d->geometry, gear, &marks);
    open_member(text, "marks", '{');
    write_mark(text, "form", g, marks.form);
    write_mark(text, "start_of_active_profile", g, marks.start);
    write_mark(text, "lowest_single_contact", g, marks.lowest_single);
    write_mark(text, "pitch_point", g, marks.pitch);
    write_mark(text, "highest_single_contact", g, marks.highest_single);
    write_mark(text, "end_of_active_profile", g, marks.end);
    qg_json_close(text, '}');
}

/* One curve of the diagram; each design is drawn over roll lengths that hold its own kinks. */
static void write_curve(struct qg_text *text, const char *name, const struct qg_made_gear *made) {
    double roll[DIAGRAM_POINTS];
    const struct qg_gear_geometry *g = &made->geometry->gears[made->gear];
    qg_diagram_rolls(made, DIAGRAM_POINTS, roll);
    open_member(text, name, '{');
    open_member(text, "roll_length_mm", '[');
    for (size_t i = 0; i < DIAGRAM_POINTS; i++)
        qg_json_number(text, roll[i]);
    qg_json_close(text, ']');
    open_member(text, "removed_um", '[');
    for (size_t i = 0; i < DIAGRAM_POINTS; i++)
        qg_json_number(text, um_per_mm * qg_relief_depth(made->relief, made->geometry, made->pair, made->gear,
                                                         qg_radius_of_roll(g, roll[i])));
    qg_json_close(text, ']');
    qg_json_close(text, '}');
}

static void write_diagram(struct qg_text *text, const struct drawn *d, int gear) {
    const bool moves = d->study->kind == QG_STUDY_OPTIMIZE || d->study->kind == QG_STUDY_MAP;
    const struct qg_relief *reliefs[] = {&d->study->relief, &d->least, &d->most};
    static const char *const names[] = {"design", "least", "most"};
    open_member(text, "diagram", '{');
    for (int i = 0; i < 3; i++) {
        struct qg_made_gear made = made_gear(d, reliefs[i], gear);
        if (i == 0 || moves) {
            write_curve(text, names[i], &made);
        } else {
            qg_json_name(text, names[i]);
            qg_json_null(text);
        }
    }
    qg_json_close(text, '}');
}

static void write_gear(struct qg_text *text, const struct drawn *d, int i) {
    const struct qg_gear *gear = &d->study->pair.gears[i];
    const struct qg_gear_geometry *g = &d->geometry.gears[i];
    open_member(text, gear_names[i], '{');
    qg_json_name(text, "teeth");
    qg_json_integer(text, gear->teeth);
    number(text, "bore_radius_mm", gear->bore_diameter / 2);
    number(text, "root_radius_mm", gear->root_radius);
    number(text, "base_radius_mm", g->base_radius);
    number(text, "form_radius_mm", g->form_radius);
    number(text, "reference_radius_mm", g->reference_radius);
    number(text, "pitch_radius_mm", g->base_radius / cos(d->geometry.working_pressure_angle));
    number(text, "outside_radius_mm", gear->outside_radius);
    write_outline(text, d, i);
    write_marks(text, d, i);
    write_diagram(text, d, i);
    qg_json_close(text, '}');
}

static void write_point(struct qg_text *text, const char *name, struct qg_point p) {
    open_member(text, name, '[');
    qg_json_number(text, p.x);
    qg_json_number(text, p.y);
    qg_json_close(text, ']');
}

/* Points [x, y] in mm. */
static void write_line_of_action(struct qg_text *text, const struct qg_pair_geometry *g) {
    open_member(text, "line_of_action", '{');
    write_point(text, "pinion_tangent_mm", qg_action_point(g, 0));
    write_point(text, "path_start_mm", qg_action_point(g, g->path_start));
    write_point(text, "pitch_point_mm",
                qg_action_point(g, g->gears[QG_PINION].base_radius * tan(g->working_pressure_angle)));
    write_point(text, "path_end_mm", qg_action_point(g, g->path_end));
    write_point(text, "gear_tangent_mm", qg_action_point(g, g->line_length));
    qg_json_close(text, '}');
}

static void write_touches(struct qg_text *text, const struct qg_mounted *mounted) {
    qg_json_open(text, '[');
    for (size_t i = 0; i < mounted->count; i++) {
        const struct qg_touch *touch = &mounted->touch[i];
        qg_json_open(text, '{');
        qg_json_name(text, "pair");
        qg_json_integer(text, touch->pair);
        write_point(text, "at_mm", touch->at);
        number(text, "pinion_roll_length_mm", touch->roll[QG_PINION]);
        number(text, "gear_roll_length_mm", touch->roll[QG_GEAR]);
        qg_json_close(text, '}');
    }
    qg_json_close(text, ']');
}

/* The mounted pair over one mesh period, both ends included. */
static void write_mesh(struct qg_text *text, const struct drawn *d) {
    static const char *const members[] = {"position", "pinion_angle_deg", "gear_angle_deg", "contacts"};
    open_member(text, "mesh", '{');
    for (int m = 0; m < 4; m++) {
        open_member(text, members[m], '[');
        for (int i = 0; i < FRAMES; i++) {
            struct qg_mounted mounted;
            double position = (double)i / (FRAMES - 1);
            qg_mounted_at(&d->geometry, &d->study->pair, position, &mounted);
            if (m == 3)
                write_touches(text, &mounted);
            else
                qg_json_number(text, m == 0 ? position : mounted.angle[m - 1] / degree);
        }
        qg_json_close(text, ']');
    }
    qg_json_close(text, '}');
}

void qg_profile_write(struct qg_text *text, const struct qg_job *job) {
    struct drawn d = {.study = &job->study};
    qg_pair_derive(&job->study.pair, &d.geometry, NULL); /* the reader has found it possible */
    qg_study_extremes(&job->study, &d.least, &d.most);
    qg_json_open(text, '{');
    number(text, "center_distance_mm", job->study.pair.center_distance);
    number(text, "working_pressure_angle_deg", d.geometry.working_pressure_angle / degree);
    number(text, "base_pitch_mm", d.geometry.base_pitch);
    number(text, "contact_ratio", d.geometry.contact_ratio);
    write_gear(text, &d, QG_PINION);
    write_gear(text, &d, QG_GEAR);
    write_line_of_action(text, &d.geometry);
    write_mesh(text, &d);
    qg_json_close(text, '}');
}
