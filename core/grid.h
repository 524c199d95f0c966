/* Grids over one or two relief parameters, and what stands out on them.
 *
 * Cells are numbered row by row: cell = i * (count of the second axis) + j, i along the first axis. Values on a grid are
 * plain arrays in that order.
 */
#ifndef QG_CORE_GRID_H
#define QG_CORE_GRID_H

#include "core/relief.h"

enum { QG_AXES_MAX = 2, QG_GRID_CELLS_MAX = 10000 };

/* Equidistant values from `from` to `to`, both included; `to` may be the smaller one. */
struct qg_axis {
    enum qg_parameter parameter;
    double from, to; /* mm */
    size_t count;    /* 2 .. 1000 */
};

struct qg_grid {
    size_t count; /* of axes: 1 .. QG_AXES_MAX in a map, 0 in other studies */
    struct qg_axis axis[QG_AXES_MAX];
};

/* How many cells. 0 without axes. */
size_t qg_grid_cells(const struct qg_grid *grid);

/* The index of a cell along an axis, and the value of that axis there (mm); the ends are `from` and `to` to the last bit. */
size_t qg_grid_index(const struct qg_grid *grid, size_t cell, size_t axis);
double qg_axis_at(const struct qg_axis *axis, size_t index);

/* The relief of a cell: `relief` with the grid's parameters put in, their ramps present. */
struct qg_relief qg_grid_relief(const struct qg_grid *grid, const struct qg_relief *relief, size_t cell);

/* The cell of the smallest of the values, the first of equals; NaN is never the smallest. The grid has cells. */
size_t qg_grid_smallest(const struct qg_grid *grid, const double *values);

/* True when the cell's value is strictly below that of all its neighbours, of which there are up to 2 on one axis and 8 on
 * two, those across corners included. A flat valley has none. NaN is below nothing, and nothing is below NaN. */
bool qg_grid_is_local_minimum(const struct qg_grid *grid, const double *values, size_t cell);

#endif
