/* See stress.h. Distances between teeth are counter-clockwise, as in compliance.h; statics.c, which knows the pairs of teeth,
 * adds up the loads of a mesh position. */
#include "core/stress.h"

#include <stdlib.h>

/* ---- results ----------------------------------------------------------------------------------------------------- */

struct qg_stresses *qg_stresses_create(size_t positions, size_t pairs) {
    struct qg_stresses *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->positions = positions;
    s->pairs = pairs;
    s->pressure = calloc(positions * pairs, sizeof *s->pressure);
    int complete = s->pressure != NULL;
    for (int g = 0; g < 2; g++) {
        s->tension[g] = calloc(positions, sizeof *s->tension[g]);
        s->compression[g] = calloc(positions, sizeof *s->compression[g]);
        complete = complete && s->tension[g] && s->compression[g];
    }
    if (complete)
        return s;
    qg_stresses_destroy(s);
    return NULL;
}

void qg_stresses_destroy(struct qg_stresses *stresses) {
    if (!stresses)
        return;
    for (int g = 0; g < 2; g++) {
        free(stresses->tension[g]);
        free(stresses->compression[g]);
    }
    free(stresses->pressure);
    free(stresses);
}

void qg_stresses_summarize(struct qg_stresses *s) {
    for (int g = 0; g < 2; g++) {
        s->most_tension[g] = s->most_compression[g] = 0;
        for (size_t i = 1; i < s->positions; i++) {
            if (s->tension[g][i].stress > s->tension[g][s->most_tension[g]].stress)
                s->most_tension[g] = i;
            if (s->compression[g][i].stress < s->compression[g][s->most_compression[g]].stress)
                s->most_compression[g] = i;
        }
    }
    s->most_pressure = 0;
    for (size_t i = 1; i < s->positions * s->pairs; i++)
        if (s->pressure[i].pressure > s->pressure[s->most_pressure].pressure)
            s->most_pressure = i;
}

/* ---- influence --------------------------------------------------------------------------------------------------- */

enum qg_status qg_stress_rows_init(struct qg_stress_rows *rows, const struct qg_compliance compliance[2], int reach,
                                   const struct qg_stop *stop) {
    *rows = (struct qg_stress_rows){.reach = reach};
    for (int g = 0; g < 2; g++) {
        const struct qg_compliance *c = &compliance[g];
        size_t p = rows->points[g] = c->root_count, n = rows->components[g] = 2 * c->flank_count;
        rows->at[g] = malloc(p * sizeof *rows->at[g]);
        rows->influence[g] = malloc((size_t)(2 * reach + 1) * p * n * sizeof *rows->influence[g]);
        if (!rows->at[g] || !rows->influence[g])
            return QG_OUT_OF_MEMORY;
        for (size_t k = 0; k < p; k++)
            rows->at[g][k] = c->root[k];
        for (int d = -reach; d <= reach; d++) {
            if (qg_is_stopped(stop))
                return QG_CANCELLED;
            if (qg_compliance_stress(c, d, rows->influence[g] + (size_t)(d + reach) * p * n) != QG_OK)
                return QG_OUT_OF_MEMORY;
        }
    }
    return QG_OK;
}

void qg_stress_rows_finish(struct qg_stress_rows *rows) {
    for (int g = 0; g < 2; g++) {
        free(rows->at[g]);
        free(rows->influence[g]);
    }
    *rows = (struct qg_stress_rows){0};
}

void qg_stress_add(const struct qg_stress_rows *rows, int gear, int distance, const struct qg_packed_spread *spread,
                   double load, double *stress) {
    if (abs(distance) > rows->reach)
        return;
    size_t p = rows->points[gear];
    const double *column =
        rows->influence[gear] + ((size_t)(distance + rows->reach) * rows->components[gear] + 2 * spread->first) * p;
    for (size_t j = 0; j < 2 * spread->count; j++, column += p)
        for (size_t i = 0; i < p; i++)
            stress[i] += column[i] * (load * spread->weight[j]);
}

void qg_stress_extremes(const struct qg_stress_rows *rows, int gear, int pair, const double *stress,
                        struct qg_root_stress *tension, struct qg_root_stress *compression) {
    for (size_t i = 0; i < rows->points[gear]; i++) {
        const struct qg_root_stress here = {stress[i], rows->at[gear][i], pair, i < rows->points[gear] / 2};
        if (here.stress > tension->stress)
            *tension = here;
        if (here.stress < compression->stress)
            *compression = here;
    }
}
