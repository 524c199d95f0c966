/* Grids: the order of their cells, the reliefs in them, and their minima, on values laid out by hand. */
#include "tests/core/cases.h"

#include "core/grid.h"

static const struct qg_grid plane = {
    2, {{QG_PINION_TIP_AMPLITUDE, 0.001, 0.004, 4}, {QG_GEAR_ROOT_END_RADIUS, 67, 65, 3}}};
static const struct qg_grid line = {1, {{QG_GEAR_TIP_START_RADIUS, 64, 69.55, 5}}};

static void cells_run_row_by_row(void **state) {
    (void)state;
    assert_int_equal(qg_grid_cells(&(struct qg_grid){0}), 0);
    assert_int_equal(qg_grid_cells(&line), 5);
    assert_int_equal(qg_grid_cells(&plane), 12);
    for (size_t cell = 0; cell < 12; cell++) {
        assert_int_equal(qg_grid_index(&plane, cell, 0), cell / 3);
        assert_int_equal(qg_grid_index(&plane, cell, 1), cell % 3);
    }
    for (size_t cell = 0; cell < 5; cell++)
        assert_int_equal(qg_grid_index(&line, cell, 0), cell);
}

static void axes_end_where_they_were_told(void **state) {
    (void)state;
    for (size_t count = 2; count <= 1000; count++) {
        const struct qg_axis axis = {QG_PINION_TIP_START_RADIUS, 42, 46.55, count},
                             back = {axis.parameter, 0.035, 0.003, count};
        assert_true(qg_axis_at(&axis, 0) == 42 && qg_axis_at(&axis, count - 1) == 46.55);
        assert_true(qg_axis_at(&back, 0) == 0.035 && qg_axis_at(&back, count - 1) == 0.003);
        for (size_t i = 1; i < count; i++) {
            assert_true(qg_axis_at(&axis, i) > qg_axis_at(&axis, i - 1));
            assert_true(qg_axis_at(&back, i) < qg_axis_at(&back, i - 1));
        }
    }
    assert_true(qg_axis_at(&plane.axis[1], 1) == 66);
}

static void a_cell_changes_its_parameters_only(void **state) {
    const struct qg_relief given = {.shape = QG_SHAPE_PARABOLIC,
                                    .gears = {{.tip = {true, 44.54, 0.016}}, {.root = {false, 0, 0.007}}}};
    (void)state;
    const struct qg_relief at = qg_grid_relief(&plane, &given, 2 * 3 + 1);
    assert_int_equal(at.shape, QG_SHAPE_PARABOLIC);
    assert_true(at.gears[QG_PINION].tip.radius == 44.54);
    assert_float_equal(at.gears[QG_PINION].tip.amplitude, 0.003, 1e-17);
    assert_true(at.gears[QG_GEAR].root.present);
    assert_true(at.gears[QG_GEAR].root.radius == 66 && at.gears[QG_GEAR].root.amplitude == 0.007);
    assert_false(at.gears[QG_PINION].root.present || at.gears[QG_GEAR].tip.present);
}

/* The local minima of values on a grid as a string of their cells. */
static const char *minima(const struct qg_grid *grid, const double *values) {
    static char cells[64];
    size_t n = 0;
    cells[0] = '\0';
    for (size_t cell = 0; cell < qg_grid_cells(grid); cell++)
        if (qg_grid_is_local_minimum(grid, values, cell))
            n += (size_t)snprintf(cells + n, sizeof cells - n, "%zu ", cell);
    return cells;
}

static void minima_on_a_line(void **state) {
    (void)state;
    assert_string_equal(minima(&line, (double[]){3, 2, 3, 2, 1}), "1 4 ");
    assert_string_equal(minima(&line, (double[]){1, 2, 1, 1, 2}), "0 ");
    assert_string_equal(minima(&line, (double[]){1, 1, 1, 1, 1}), "");
    assert_string_equal(minima(&line, (double[]){INFINITY, 4, INFINITY, NAN, 1}), "1 ");
    assert_int_equal(qg_grid_smallest(&line, (double[]){3, 2, 3, 2, 2}), 1);
    assert_int_equal(qg_grid_smallest(&line, (double[]){NAN, NAN, 3, 4, NAN}), 2);
}

static void minima_on_a_plane(void **state) {
    (void)state;
    assert_string_equal(minima(&plane, (double[]){5, 5, 5, /**/ 5, 1, 5, /**/ 5, 5, 5, /**/ 5, 5, 4}), "4 11 ");
    assert_string_equal(minima(&plane, (double[]){5, 5, 0, /**/ 5, 1, 5, /**/ 5, 5, 5, /**/ 4, 5, 5}),
                        "2 9 "); /* corners */
    /* The end of one row is no neighbour of the beginning of the next. */
    assert_string_equal(minima(&plane, (double[]){9, 9, 2, /**/ 1, 9, 9, /**/ 9, 9, 9, /**/ 9, 9, 9}), "2 3 ");
    assert_int_equal(qg_grid_smallest(&plane, (double[]){9, 9, 2, /**/ 1, 9, 9, /**/ 9, 9, 9, /**/ 9, 9, 0.5}), 11);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_run_row_by_row),
        cmocka_unit_test(axes_end_where_they_were_told),
        cmocka_unit_test(a_cell_changes_its_parameters_only),
        cmocka_unit_test(minima_on_a_line),
        cmocka_unit_test(minima_on_a_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
