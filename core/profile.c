/* Profiles, their diagrams and the mounted pair; see profile.h.
 *
 * Mounting. With the pinion turning counter-clockwise about (0, 0) and the gear's axis at (a, 0), the flanks are pressed
 * together along the line of action from T1 = r_b1 (cos w, -sin w) in the direction (sin w, cos w), w the working pressure
 * angle. The pinion's flank at roll length xi stands on that line when its point, at the polar angle psi from the tooth's
 * centre line, has the polar angle atan(xi / r_b) - w; hence the tooth's centre line at atan(xi / r_b) - w - psi, which is
 * linear in xi as the string unwinds. For the gear the same holds in a frame turned by half a revolution, with its
 * own roll length (the line's length less xi).
 */
#include "core/profile.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>

/* Shorter pieces are left out: in the piece's own parameter, and for a flank in mm, so that its tangents can be taken. */
static const double shortest_piece = 1e-9, shortest_flank = 1e-6;

double qg_roll_length(const struct qg_gear_geometry *gear, double radius) {
    return sqrt(fmax(0, radius * radius - gear->base_radius * gear->base_radius));
}

double qg_radius_of_roll(const struct qg_gear_geometry *gear, double roll_length) {
    return hypot(gear->base_radius, roll_length);
}

static const struct qg_gear_geometry *geometry_of(const struct qg_made_gear *made) {
    return &made->geometry->gears[made->gear];
}

static const struct qg_gear *gear_of(const struct qg_made_gear *made) {
    return &made->pair->gears[made->gear];
}

/* Depth of the relief (mm) at a roll length. */
static double depth_at(const struct qg_made_gear *made, double roll) {
    return qg_relief_depth(made->relief, made->geometry, made->pair, made->gear,
                           qg_radius_of_roll(geometry_of(made), roll));
}

static struct qg_point from_polar(double radius, double angle) {
    return (struct qg_point){radius * cos(angle), radius * sin(angle)};
}

/* The point `depth` below the involute at a roll length. */
static struct qg_point below_involute(const struct qg_made_gear *made, double roll, double depth) {
    const struct qg_gear_geometry *g = geometry_of(made);
    double angle = qg_half_tooth_angle(&made->pair->rack, g, qg_radius_of_roll(g, roll)) - atan2(roll, g->base_radius);
    return from_polar(qg_radius_of_roll(g, roll - depth), angle + atan2(roll - depth, g->base_radius));
}

static struct qg_point flank_at(const struct qg_made_gear *made, double roll) {
    return below_involute(made, roll, depth_at(made, roll));
}

/* ---- pieces ----------------------------------------------------------------------------------------------------- */

static void add_piece(struct qg_profile *p, enum qg_piece_kind kind, double from, double to) {
    if (fabs(to - from) < (kind == QG_PIECE_FLANK ? shortest_flank : shortest_piece))
        return;
    assert(p->count < QG_PIECES_MAX);
    p->piece[p->count++] = (struct qg_piece){kind, from, to};
}

/* Roll lengths of the kinks between form radius and tip, ascending; at most two. */
static size_t find_kinks(const struct qg_made_gear *made, double kink[2]) {
    const struct qg_gear_geometry *g = geometry_of(made);
    const struct qg_ramp *ramps[2] = {&made->relief->gears[made->gear].root, &made->relief->gears[made->gear].tip};
    size_t count = 0;
    for (int i = 0; i < 2; i++)
        if (ramps[i]->present && ramps[i]->radius > g->form_radius && ramps[i]->radius < gear_of(made)->outside_radius)
            kink[count++] = qg_roll_length(g, ramps[i]->radius);
    if (count == 2 && kink[0] > kink[1]) {
        double swap = kink[0];
        kink[0] = kink[1];
        kink[1] = swap;
    }
    return count;
}

void qg_profile_init(struct qg_profile *profile, const struct qg_made_gear *made) {
    const struct qg_gear_geometry *g = geometry_of(made);
    const struct qg_gear *gear = gear_of(made);
    *profile = (struct qg_profile){.made = *made};
    double root_end = qg_trochoid_point(&made->pair->rack, gear, g, 0).angle;
    double form = qg_roll_length(g, g->form_radius), outside = qg_roll_length(g, gear->outside_radius);
    double tip = outside + depth_at(made, outside), kink[2];
    add_piece(profile, QG_PIECE_ROOT_CIRCLE, M_PI / gear->teeth, root_end);
    add_piece(profile, QG_PIECE_ROOT_CURVE, 0, 1);
    add_piece(profile, QG_PIECE_STEP, 0, depth_at(made, form));
    size_t kinks = find_kinks(made, kink);
    for (size_t i = 0; i < kinks; i++) {
        add_piece(profile, QG_PIECE_FLANK, form, kink[i]);
        form = kink[i];
    }
    add_piece(profile, QG_PIECE_FLANK, form, tip);
    struct qg_point corner = flank_at(made, tip);
    add_piece(profile, QG_PIECE_TIP_CIRCLE, atan2(corner.y, corner.x), 0);
}

struct qg_point qg_profile_at(const struct qg_profile *profile, size_t piece, double share) {
    const struct qg_made_gear *made = &profile->made;
    const struct qg_gear *gear = gear_of(made);
    assert(piece < profile->count);
    const struct qg_piece *p = &profile->piece[piece];
    double at = p->from + share * (p->to - p->from);
    switch (p->kind) {
    case QG_PIECE_ROOT_CIRCLE:
        return from_polar(gear->root_radius, at);
    case QG_PIECE_ROOT_CURVE: {
        struct qg_polar polar = qg_trochoid_point(&made->pair->rack, gear, geometry_of(made), at);
        return from_polar(polar.radius, polar.angle);
    }
    case QG_PIECE_STEP:
        return below_involute(made, qg_roll_length(geometry_of(made), geometry_of(made)->form_radius), at);
    case QG_PIECE_FLANK:
        return flank_at(made, at);
    case QG_PIECE_TIP_CIRCLE:
    default:
        return from_polar(gear->outside_radius, at);
    }
}

/* ---- outlines --------------------------------------------------------------------------------------------------- */

struct piece_curve {
    const struct qg_profile *profile;
    size_t piece;
};

static struct qg_point piece_curve_at(const void *self, double t) {
    const struct piece_curve *c = self;
    return qg_profile_at(c->profile, c->piece, t);
}

/* One piece that is already a line or a circle. */
static enum qg_status add_plain(const struct qg_profile *profile, size_t piece, struct qg_outline *outline) {
    const struct qg_piece *p = &profile->piece[piece];
    struct qg_point at = qg_profile_at(profile, piece, 0);
    double turned = p->kind == QG_PIECE_STEP ? 0 : p->to - p->from;
    return qg_outline_add(outline, (struct qg_corner){at.x, at.y, tan(turned / 4)});
}

static enum qg_status add_profile(const struct qg_profile *profile, double tolerance, bool arcs,
                                  struct qg_outline *outline) {
    enum qg_status status = QG_OK;
    for (size_t i = 0; i < profile->count && status == QG_OK; i++) {
        const struct piece_curve self = {profile, i};
        const struct qg_plane_curve curve = {piece_curve_at, &self};
        enum qg_piece_kind kind = profile->piece[i].kind;
        bool smooth = kind == QG_PIECE_ROOT_CURVE || kind == QG_PIECE_FLANK;
        if (arcs)
            status = smooth ? qg_biarcs_fit(&curve, tolerance, outline) : add_plain(profile, i, outline);
        else
            status = kind == QG_PIECE_STEP ? add_plain(profile, i, outline) : qg_chords_fit(&curve, tolerance, outline);
    }
    struct qg_point end = qg_profile_at(profile, profile->count - 1, 1);
    return status == QG_OK ? qg_outline_add(outline, (struct qg_corner){end.x, end.y, 0}) : status;
}

enum qg_status qg_profile_chords(const struct qg_profile *profile, double tolerance, struct qg_outline *outline) {
    return add_profile(profile, tolerance, false, outline);
}

enum qg_status qg_profile_arcs(const struct qg_profile *profile, double tolerance, struct qg_outline *outline) {
    return add_profile(profile, tolerance, true, outline);
}

/* Two arcs alike in a row: the bulge of both together, tan of twice the angle whose tangent is one's. */
static double doubled(double bulge) {
    return 2 * bulge / (1 - bulge * bulge);
}

void qg_outline_reverse(struct qg_outline *outline) {
    size_t n = outline->count;
    for (size_t i = 0; i < n / 2; i++) {
        struct qg_corner swap = outline->corner[i];
        outline->corner[i] = outline->corner[n - 1 - i];
        outline->corner[n - 1 - i] = swap;
    }
    for (size_t i = 0; i + 1 < n; i++)
        outline->corner[i].bulge = -outline->corner[i + 1].bulge;
    if (n > 0)
        outline->corner[n - 1].bulge = 0;
}

void qg_outline_turn(struct qg_outline *outline, double angle, double shift) {
    double cosine = cos(angle), sine = sin(angle);
    for (size_t i = 0; i < outline->count; i++) {
        struct qg_corner *c = &outline->corner[i];
        *c = (struct qg_corner){cosine * c->x - sine * c->y + shift, sine * c->x + cosine * c->y, c->bulge};
    }
}

/* Mirrored at the x axis and run backwards, an edge keeps its bulge, which then belongs to its other end. */
enum qg_status qg_outline_mirror(struct qg_outline *outline) {
    assert(outline->count >= 2);
    const size_t half = outline->count - 1;
    struct qg_corner *before = &outline->corner[half - 1];
    if (before->bulge != 0) {
        before->bulge = doubled(before->bulge);
        outline->count--;
    }
    enum qg_status status = QG_OK;
    for (size_t i = half; i-- > 0 && status == QG_OK;) {
        struct qg_corner at = outline->corner[i];
        at.y = -at.y;
        at.bulge = i > 0 ? outline->corner[i - 1].bulge : 0;
        status = qg_outline_add(outline, at);
    }
    return status;
}

enum qg_status qg_outline_ring(const struct qg_outline *tooth, int teeth, struct qg_outline *ring) {
    assert(ring->count == 0 && tooth->count >= 3 && teeth > 0);
    const size_t last = tooth->count - 1;
    const bool through = tooth->corner[0].bulge != 0; /* one arc from the root of one tooth to that of the next */
    enum qg_status status = QG_OK;
    for (int k = 0; k < teeth; k++)
        for (size_t i = through; i < last && status == QG_OK; i++) {
            double angle = -2 * M_PI * k / teeth, cosine = cos(angle), sine = sin(angle);
            const struct qg_corner *c = &tooth->corner[i];
            double bulge = through && i == last - 1 ? doubled(c->bulge) : c->bulge;
            status = qg_outline_add(
                ring, (struct qg_corner){cosine * c->x - sine * c->y, sine * c->x + cosine * c->y, bulge});
        }
    return status;
}

/* ---- the profile diagram ---------------------------------------------------------------------------------------- */

void qg_profile_marks(const struct qg_pair_geometry *geometry, int gear, struct qg_marks *marks) {
    const struct qg_gear_geometry *g = &geometry->gears[gear];
    bool pinion = gear == QG_PINION;
    marks->form = qg_roll_length(g, g->form_radius);
    marks->pitch = g->base_radius * tan(geometry->working_pressure_angle);
    marks->start = pinion ? geometry->path_start : geometry->line_length - geometry->path_end;
    marks->end = pinion ? geometry->path_end : geometry->line_length - geometry->path_start;
    bool alone = geometry->contact_ratio < 2;
    marks->lowest_single = alone ? marks->end - geometry->base_pitch : (double)NAN;
    marks->highest_single = alone ? marks->start + geometry->base_pitch : (double)NAN;
}

void qg_diagram_rolls(const struct qg_made_gear *made, size_t count, double *roll) {
    assert(count >= 8);
    const struct qg_gear_geometry *g = geometry_of(made);
    double from = qg_roll_length(g, g->form_radius), to = qg_roll_length(g, gear_of(made)->outside_radius), kink[2];
    for (size_t i = 0; i < count; i++)
        roll[i] = from + (to - from) * (double)i / (double)(count - 1);
    size_t kinks = find_kinks(made, kink);
    for (size_t k = 0; k < kinks; k++) {
        size_t nearest = (size_t)lround((kink[k] - from) / (to - from) * (double)(count - 1));
        if (nearest > 0 && nearest < count - 1 && !(k == 1 && roll[nearest] == kink[0]))
            roll[nearest] = kink[k];
    }
}

/* A parameter's two ends: which one takes less off? A tip relief grows when it starts lower, all else grows with the number. */
static void spread_parameter(const double ends[2], enum qg_parameter parameter, struct qg_relief *least,
                             struct qg_relief *most) {
    bool tip_start = parameter == QG_PINION_TIP_START_RADIUS || parameter == QG_GEAR_TIP_START_RADIUS;
    double low = fmin(ends[0], ends[1]), high = fmax(ends[0], ends[1]);
    qg_relief_ramp_of(least, parameter)->present = true;
    qg_relief_ramp_of(most, parameter)->present = true;
    *qg_relief_parameter(least, parameter) = tip_start ? high : low;
    *qg_relief_parameter(most, parameter) = tip_start ? low : high;
}

void qg_study_extremes(const struct qg_study *study, struct qg_relief *least, struct qg_relief *most) {
    *least = *most = study->relief;
    if (study->kind == QG_STUDY_OPTIMIZE)
        for (size_t i = 0; i < study->bounds.count; i++)
            spread_parameter((const double[]){study->bounds.lower[i], study->bounds.upper[i]},
                             study->bounds.parameter[i], least, most);
    if (study->kind == QG_STUDY_MAP)
        for (size_t i = 0; i < study->grid.count; i++)
            spread_parameter((const double[]){study->grid.axis[i].from, study->grid.axis[i].to},
                             study->grid.axis[i].parameter, least, most);
}

/* ---- the mounted pair ------------------------------------------------------------------------------------------- */

struct qg_point qg_action_point(const struct qg_pair_geometry *geometry, double xi) {
    double r = geometry->gears[QG_PINION].base_radius, w = geometry->working_pressure_angle;
    return (struct qg_point){r * cos(w) + xi * sin(w), -r * sin(w) + xi * cos(w)};
}

/* Angle of the centre line of a tooth whose flank stands on the line of action with a roll length, in the gear's own frame. */
static double tooth_angle(const struct qg_pair_geometry *geometry, const struct qg_gear_pair *pair, int gear,
                          double roll) {
    const struct qg_gear_geometry *g = &geometry->gears[gear];
    double psi = qg_half_tooth_angle(&pair->rack, g, qg_radius_of_roll(g, roll));
    return atan2(roll, g->base_radius) - geometry->working_pressure_angle - psi;
}

void qg_mounted_at(const struct qg_pair_geometry *geometry, const struct qg_gear_pair *pair, double position,
                   struct qg_mounted *mounted) {
    double xi = qg_path_position(geometry, position, 0);
    *mounted = (struct qg_mounted){.angle = {tooth_angle(geometry, pair, QG_PINION, xi),
                                             tooth_angle(geometry, pair, QG_GEAR, geometry->line_length - xi) + M_PI}};
    for (int k = -QG_PAIR_REACH; k <= QG_PAIR_REACH; k++) {
        double at = qg_path_position(geometry, position, k);
        if (at < geometry->path_start || at > geometry->path_end)
            continue;
        mounted->touch[mounted->count++] =
            (struct qg_touch){.pair = k, .roll = {at, geometry->line_length - at}, .at = qg_action_point(geometry, at)};
    }
}
