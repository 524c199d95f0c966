/* Biarcs through a curve.
 *
 * Given P0, P1 with unit tangents T0, T1, the family of biarcs has one free number; the choice here is equal lengths d of
 * both control legs. The joint is (P0 + P1 + d (T0 - T1)) / 2, and that the legs' ends stand 2 d apart gives
 *     2 (1 - T0.T1) d^2 + 2 (v.(T0 + T1)) d - v.v = 0,   v = P1 - P0,
 * of which the positive root is taken, in the form that stays exact as the tangents become parallel. (The construction
 * is that of K. M. Bolton, "Biarc curves", Computer-Aided Design 7 (1975) 89-92.) An arc that leaves a point at the angle
 * a from its chord turns by 2 a, so its bulge is tan(a / 2).
 *
 * The error of a biarc falls with the cube of its length, so the longest one that holds the tolerance is found by bisection.
 * The distance is measured at samples; SAFETY leaves room for what lies between them.
 */
#include "core/biarc.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { SAMPLES = 24, BISECTIONS = 14 };
static const double SAFETY = 0.9;
static const double DIFFERENCE = 1e-5; /* of the curve's parameter, for tangents */

enum qg_status qg_outline_add(struct qg_outline *outline, struct qg_corner corner) {
    if (outline->count == outline->room) {
        size_t room = outline->room ? 2 * outline->room : 64;
        struct qg_corner *grown = realloc(outline->corner, room * sizeof *grown);
        if (!grown)
            return QG_OUT_OF_MEMORY;
        outline->corner = grown;
        outline->room = room;
    }
    outline->corner[outline->count++] = corner;
    return QG_OK;
}

void qg_outline_finish(struct qg_outline *outline) {
    free(outline->corner);
    *outline = (struct qg_outline){0};
}

static double dot(struct qg_point a, struct qg_point b) {
    return a.x * b.x + a.y * b.y;
}

static double cross(struct qg_point a, struct qg_point b) {
    return a.x * b.y - a.y * b.x;
}

static struct qg_point minus(struct qg_point a, struct qg_point b) {
    return (struct qg_point){a.x - b.x, a.y - b.y};
}

/* Unit tangent of the curve: a central difference, one-sided of second order at the ends. */
static struct qg_point tangent_at(const struct qg_plane_curve *curve, double t) {
    double h = t < DIFFERENCE ? DIFFERENCE : t > 1 - DIFFERENCE ? -DIFFERENCE : 0;
    struct qg_point d;
    if (h == 0) {
        d = minus(curve->at(curve->self, t + DIFFERENCE), curve->at(curve->self, t - DIFFERENCE));
    } else {
        struct qg_point p0 = curve->at(curve->self, t), p1 = curve->at(curve->self, t + h);
        struct qg_point p2 = curve->at(curve->self, t + 2 * h);
        double sign = h > 0 ? 1 : -1;
        d = (struct qg_point){sign * (4 * p1.x - 3 * p0.x - p2.x), sign * (4 * p1.y - 3 * p0.y - p2.y)};
    }
    double length = hypot(d.x, d.y);
    assert(length > 0);
    return (struct qg_point){d.x / length, d.y / length};
}

/* Bulge of the arc that starts in direction a and whose chord has direction b, or the other way round. */
static double bulge_between(struct qg_point a, struct qg_point b) {
    return tan(atan2(cross(a, b), dot(a, b)) / 2);
}

/* The two arcs between two places of the curve: start, joint, and the end (whose bulge is 0). */
struct biarc {
    struct qg_corner corner[3];
};

static struct biarc biarc_between(const struct qg_plane_curve *curve, double from, double to) {
    struct qg_point p0 = curve->at(curve->self, from), p1 = curve->at(curve->self, to);
    struct qg_point t0 = tangent_at(curve, from), t1 = tangent_at(curve, to), v = minus(p1, p0);
    double a = 2 * (1 - dot(t0, t1)), b = dot(v, t0) + dot(v, t1), c = dot(v, v);
    double d = c / (b + sqrt(b * b + a * c));
    struct qg_point joint = {(p0.x + p1.x + d * (t0.x - t1.x)) / 2, (p0.y + p1.y + d * (t0.y - t1.y)) / 2};
    return (struct biarc){{{p0.x, p0.y, bulge_between(t0, minus(joint, p0))},
                           {joint.x, joint.y, bulge_between(minus(p1, joint), t1)},
                           {p1.x, p1.y, 0}}};
}

static double end_distance(const struct qg_corner *from, const struct qg_corner *to, struct qg_point point) {
    return fmin(hypot(point.x - from->x, point.y - from->y), hypot(point.x - to->x, point.y - to->y));
}

static double line_distance(const struct qg_corner *from, const struct qg_corner *to, struct qg_point point) {
    struct qg_point chord = {to->x - from->x, to->y - from->y}, p = {point.x - from->x, point.y - from->y};
    double length = dot(chord, chord), along = dot(chord, p);
    if (along <= 0 || along >= length)
        return end_distance(from, to, point);
    return fabs(cross(chord, p)) / sqrt(length);
}

/* In the frame of the chord: half its length c along x, the arc's centre at height k, its middle at -bulge c. A point lies
 * within the arc's angle when it is on the arc's side of both rays from the centre through the ends. */
double qg_edge_distance(const struct qg_corner *from, const struct qg_corner *to, struct qg_point point) {
    double c = hypot(to->x - from->x, to->y - from->y) / 2, bulge = from->bulge;
    if (bulge == 0 || c == 0)
        return line_distance(from, to, point);
    struct qg_point u = {(to->x - from->x) / (2 * c), (to->y - from->y) / (2 * c)};
    struct qg_point p = {point.x - (from->x + to->x) / 2, point.y - (from->y + to->y) / 2};
    struct qg_point q = {dot(p, u), cross(u, p)};
    double k = c * (1 - bulge * bulge) / (2 * bulge), radius = c * (1 + bulge * bulge) / (2 * fabs(bulge));
    struct qg_point w = {q.x, q.y - k};
    double aside = fabs(w.x) * fabs(k) - c * fabs(w.y), ahead = bulge > 0 ? -w.y : w.y;
    bool minor = fabs(bulge) <= 1, within = minor ? ahead > 0 && aside <= 0 : ahead > 0 || aside >= 0;
    return within ? fabs(hypot(w.x, w.y) - radius) : end_distance(from, to, point);
}

/* Largest distance of the curve between two places from edges of a chain of `edges` edges. */
static double error_between(const struct qg_plane_curve *curve, const double ends[2], const struct qg_corner *corner,
                            size_t edges) {
    double worst = 0;
    for (int i = 1; i < SAMPLES; i++) {
        struct qg_point p = curve->at(curve->self, ends[0] + (ends[1] - ends[0]) * i / SAMPLES);
        double nearest = INFINITY;
        for (size_t e = 0; e < edges; e++)
            nearest = fmin(nearest, qg_edge_distance(&corner[e], &corner[e + 1], p));
        worst = fmax(worst, nearest);
    }
    return worst;
}

static struct biarc chord_between(const struct qg_plane_curve *curve, double from, double to) {
    struct qg_point p0 = curve->at(curve->self, from), p1 = curve->at(curve->self, to);
    return (struct biarc){{{p0.x, p0.y, 0}, {p1.x, p1.y, 0}}};
}

/* The two ways of spanning a stretch: one straight edge, or two arcs. */
struct span {
    struct biarc (*between)(const struct qg_plane_curve *curve, double from, double to);
    size_t edges;
};

static bool span_holds(const struct span *span, const struct qg_plane_curve *curve, const double ends[2],
                       double tolerance) {
    struct biarc b = span->between(curve, ends[0], ends[1]);
    return error_between(curve, ends, b.corner, span->edges) <= SAFETY * tolerance;
}

/* The furthest place that one span from `from` reaches within the tolerance. */
static double reach(const struct span *span, const struct qg_plane_curve *curve, double from, double tolerance) {
    double inside = from, outside = 1;
    if (span_holds(span, curve, (const double[]){from, 1}, tolerance))
        return 1;
    for (int i = 0; i < BISECTIONS || inside == from; i++) {
        double middle = (inside + outside) / 2;
        if (middle - from < 1e-9 || span_holds(span, curve, (const double[]){from, middle}, tolerance))
            inside = middle; /* so short a stretch passes as it is */
        else
            outside = middle;
    }
    return inside;
}

/* Appends spans along the curve, each as long as it may be. */
static enum qg_status fit(const struct span *span, const struct qg_plane_curve *curve, double tolerance,
                          struct qg_outline *outline) {
    assert(tolerance > 0);
    for (double from = 0; from < 1;) {
        double to = reach(span, curve, from, tolerance);
        struct biarc b = span->between(curve, from, to);
        for (size_t e = 0; e < span->edges; e++)
            if (qg_outline_add(outline, b.corner[e]) != QG_OK)
                return QG_OUT_OF_MEMORY;
        from = to;
    }
    return QG_OK;
}

enum qg_status qg_biarcs_fit(const struct qg_plane_curve *curve, double tolerance, struct qg_outline *outline) {
    return fit(&(struct span){biarc_between, 2}, curve, tolerance, outline);
}

enum qg_status qg_chords_fit(const struct qg_plane_curve *curve, double tolerance, struct qg_outline *outline) {
    return fit(&(struct span){chord_between, 1}, curve, tolerance, outline);
}
