/* Grids over relief parameters (grid.h): counting cells, and looking for the smallest among neighbours. */
#include "core/grid.h"

#include <assert.h>
#include <math.h>

size_t qg_grid_cells(const struct qg_grid *grid) {
    size_t cells = grid->count > 0;
    for (size_t k = 0; k < grid->count; k++)
        cells *= grid->axis[k].count;
    return cells;
}

/* Cells from one value of an axis to the next. */
static size_t stride(const struct qg_grid *grid, size_t axis) {
    return axis + 1 < grid->count ? grid->axis[axis + 1].count : 1;
}

size_t qg_grid_index(const struct qg_grid *grid, size_t cell, size_t axis) {
    assert(axis < grid->count && cell < qg_grid_cells(grid));
    return cell / stride(grid, axis) % grid->axis[axis].count;
}

double qg_axis_at(const struct qg_axis *axis, size_t index) {
    assert(index < axis->count);
    if (index + 1 == axis->count)
        return axis->to;
    return axis->from + (axis->to - axis->from) * (double)index / (double)(axis->count - 1);
}

struct qg_relief qg_grid_relief(const struct qg_grid *grid, const struct qg_relief *relief, size_t cell) {
    struct qg_relief at = *relief;
    for (size_t k = 0; k < grid->count; k++) {
        const struct qg_axis *axis = &grid->axis[k];
        qg_relief_ramp_of(&at, axis->parameter)->present = true;
        *qg_relief_parameter(&at, axis->parameter) = qg_axis_at(axis, qg_grid_index(grid, cell, k));
    }
    return at;
}

size_t qg_grid_smallest(const struct qg_grid *grid, const double *values) {
    size_t cells = qg_grid_cells(grid), smallest = 0;
    assert(cells > 0);
    for (size_t i = 1; i < cells; i++)
        if (values[i] < values[smallest] || (isnan(values[smallest]) && !isnan(values[i])))
            smallest = i;
    return smallest;
}

bool qg_grid_is_local_minimum(const struct qg_grid *grid, const double *values, size_t cell) {
    const size_t row = qg_grid_index(grid, cell, 0), rows = grid->axis[0].count;
    const size_t column = grid->count > 1 ? qg_grid_index(grid, cell, 1) : 0, columns = stride(grid, 0);
    const size_t top = row > 0 ? row - 1 : 0, bottom = row + 1 < rows ? row + 1 : row;
    const size_t left = column > 0 ? column - 1 : 0, right = column + 1 < columns ? column + 1 : column;
    for (size_t i = top; i <= bottom; i++)
        for (size_t j = left; j <= right; j++)
            if ((i != row || j != column) && !(values[cell] < values[i * columns + j]))
                return false;
    return true;
}
