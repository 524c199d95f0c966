/* Smooth plane curves as few circular arcs: what drawings and machines take.
 *
 * A biarc is two arcs that share a tangent where they join, through two given points with two given tangents there. A
 * chain of biarcs along a curve therefore has the curve's tangent at every second corner and no kink anywhere.
 */
#ifndef QG_CORE_BIARC_H
#define QG_CORE_BIARC_H

#include "core/status.h"

/* A point of the plane, mm. */
struct qg_point {
    double x, y;
};

/* A corner of a chain of arcs and straight lines. */
struct qg_corner {
    double x, y; /* mm */
    double
        bulge; /* of the edge that begins here: tangent of a quarter of the arc's angle, > 0 counter-clockwise, 0 straight */
};

/* A chain of edges, from corner to corner. A zeroed one is empty and ready. */
struct qg_outline {
    size_t count, room;
    struct qg_corner *corner; /* [count]; the last one's bulge is 0 unless the chain is closed */
};

/* Appends a corner. QG_OUT_OF_MEMORY leaves the outline as it was. */
enum qg_status qg_outline_add(struct qg_outline *outline, struct qg_corner corner);

/* Frees what the outline holds and zeroes it. */
void qg_outline_finish(struct qg_outline *outline);

/* A curve with a continuous tangent, over t from 0 to 1. */
struct qg_plane_curve {
    struct qg_point (*at)(const void *self, double t); /* mm */
    const void *self;
};

/* Appends biarcs along the whole curve so that no point of it lies further than tolerance (mm, > 0) from them, each as long as
 * that allows. The corner at t = 0 is appended, the one at t = 1 is left to what follows: the chain can be continued.
 * The curve must be smooth; tangents are taken as differences over 1e-5 of it. Returns QG_OK or QG_OUT_OF_MEMORY. */
enum qg_status qg_biarcs_fit(const struct qg_plane_curve *curve, double tolerance, struct qg_outline *outline);

/* Appends straight chords likewise; tolerance is that of the chord. */
enum qg_status qg_chords_fit(const struct qg_plane_curve *curve, double tolerance, struct qg_outline *outline);

/* Distance (mm) of a point from the edge that begins at `from` and ends at `to`; the nearest place may be an end. */
double qg_edge_distance(const struct qg_corner *from, const struct qg_corner *to, struct qg_point point);

#endif
