/* The archive of non-dominated designs, and its hypervolume. See front.h.
 *
 * Fronts have tens to some hundreds of members: a linear pass per evaluation costs nothing beside the evaluation itself.
 */
#include "core/front.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* a is nowhere worse than b: it dominates b, or is its equal. */
static bool covers(const struct qg_front *front, const double *a, const double *b) {
    for (size_t k = 0; k < front->objectives; k++)
        if (!(a[k] <= b[k]))
            return false;
    return true;
}

static bool has_nan(const struct qg_front *front, const double *value) {
    for (size_t k = 0; k < front->objectives; k++)
        if (isnan(value[k]))
            return true;
    return false;
}

/* Makes sure that one more fits. */
static bool make_room(struct qg_front *front) {
    if (front->count < front->room)
        return true;
    size_t room = front->room ? 2 * front->room : 64;
    struct qg_front_member *grown = realloc(front->member, room * sizeof *grown);
    if (!grown)
        return false;
    front->member = grown;
    front->room = room;
    return true;
}

/* Drives out whom the newcomer covers. */
static void drive_out(struct qg_front *front, const double *value) {
    size_t kept = 0;
    for (size_t i = 0; i < front->count; i++)
        if (!covers(front, value, front->member[i].value))
            front->member[kept++] = front->member[i];
    front->count = kept;
}

static void insert(struct qg_front *front, const struct qg_front_member *member) {
    size_t at = front->count++;
    for (; at > 0 && member->value[0] < front->member[at - 1].value[0]; at--)
        front->member[at] = front->member[at - 1];
    front->member[at] = *member;
}

enum qg_status qg_front_add(struct qg_front *front, const struct qg_front_member *member, bool *joined) {
    assert(front->objectives >= 1 && front->objectives <= QG_FRONT_OBJECTIVES_MAX);
    bool joins = !has_nan(front, member->value);
    for (size_t i = 0; i < front->count && joins; i++)
        joins = !covers(front, front->member[i].value, member->value);
    if (joined)
        *joined = joins;
    if (!joins)
        return QG_OK;
    if (!make_room(front))
        return QG_OUT_OF_MEMORY;
    drive_out(front, member->value);
    insert(front, member);
    return QG_OK;
}

typedef double point[QG_FRONT_OBJECTIVES_MAX];

static int by_last_of_two(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (x[1] > y[1]) - (x[1] < y[1]);
}

static int by_last_of_three(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (x[2] > y[2]) - (x[2] < y[2]);
}

/* Share of the unit box that is dominated by n points inside it, in the first k objectives. The points are reordered. Slabs
 * between neighbours in objective k are dominated, in the other objectives, by all points up to there. */
static double dominated(point *points, size_t n, size_t k, point *room) {
    double volume = 0;
    if (k == 1) {
        for (size_t i = 0; i < n; i++)
            volume = fmax(volume, 1 - points[i][0]);
        return volume;
    }
    qsort(points, n, sizeof *points, k == 2 ? by_last_of_two : by_last_of_three);
    for (size_t i = 0; i < n; i++) {
        double height = (i + 1 < n ? points[i + 1][k - 1] : 1) - points[i][k - 1];
        memcpy(room, points, (i + 1) * sizeof *points);
        volume += height > 0 ? height * dominated(room, i + 1, k - 1, room + i + 1) : 0;
    }
    return volume;
}

double qg_front_hypervolume(const struct qg_front *front, const double *corner) {
    size_t n = 0;
    point *points = malloc((front->count + 1) * QG_FRONT_OBJECTIVES_MAX * sizeof *points);
    if (!points)
        return (double)NAN;
    for (size_t i = 0; i < front->count; i++) {
        bool inside = true;
        for (size_t k = 0; k < front->objectives; k++) {
            points[n][k] = front->member[i].value[k] / corner[k];
            inside = inside && points[n][k] < 1;
        }
        n += inside;
    }
    double volume = dominated(points, n, front->objectives, points + n);
    free(points);
    return volume;
}

void qg_front_finish(struct qg_front *front) {
    free(front->member);
    *front = (struct qg_front){.objectives = front->objectives};
}
