/* See nodal.h. Interpolation along a flank is that of its quadratic element edges. */
#include "core/nodal.h"

#include <assert.h>
#include <cblas.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The element edge of the flank that holds an arc length; beyond the ends, the outermost. */
static size_t edge_at(const struct qg_compliance *c, double arc) {
    size_t low = 0, high = (c->flank_count - 1) / 2;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (c->flank_arc[2 * middle] <= arc)
            low = middle;
        else
            high = middle;
    }
    return low;
}

double qg_node_distance(const struct qg_compliance *c, double arc) {
    size_t edge = edge_at(c, arc);
    return (c->flank_arc[2 * edge + 2] - c->flank_arc[2 * edge]) / 2;
}

void qg_spread_add(struct qg_spread *spread, const struct qg_compliance *c, double arc, double direction,
                   double weight) {
    size_t edge = edge_at(c, arc);
    double from = c->flank_arc[2 * edge], to = c->flank_arc[2 * edge + 2];
    double z = 2 * (arc - from) / (to - from) - 1;
    z = fmin(1, fmax(-1, z));
    const double shape[3] = {z * (z - 1) / 2, 1 - z * z, z * (z + 1) / 2};
    if (spread->count == 0)
        spread->first = 2 * edge;
    assert(2 * edge >= spread->first && 2 * edge + 3 - spread->first <= QG_SPREAD_NODES);
    if (2 * edge + 3 - spread->first > spread->count)
        spread->count = 2 * edge + 3 - spread->first;
    for (int k = 0; k < 3; k++) {
        size_t node = 2 * edge + (size_t)k, at_node = node - spread->first;
        double angle = direction - c->flank[node].angle;
        spread->weight[2 * at_node] += weight * shape[k] * cos(angle);
        spread->weight[2 * at_node + 1] += weight * shape[k] * sin(angle);
    }
}

static void flank_matrix(const struct qg_compliance *c, int distance, double *scratch, double *out) {
    int n = 2 * (int)c->flank_count, m = (int)c->boundary;
    if (distance == 0)
        memcpy(out, c->local, (size_t)n * (size_t)n * sizeof *out);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, m, m, 1, c->response, n,
                c->ring + (size_t)distance * (size_t)m * (size_t)m, m, 0, scratch, n);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, n, n, m, 1, scratch, n, c->response, n, distance == 0 ? 1 : 0,
                out, n);
}

enum qg_status qg_flank_matrices_init(struct qg_flank_matrices *f, const struct qg_compliance compliance[2], int reach,
                                      const struct qg_stop *stop) {
    *f = (struct qg_flank_matrices){.reach = reach};
    for (int g = 0; g < 2; g++) {
        size_t n = f->n[g] = 2 * compliance[g].flank_count;
        double *scratch = malloc(n * compliance[g].boundary * sizeof *scratch);
        f->c[g] = malloc((size_t)(reach + 1) * n * n * sizeof *f->c[g]);
        if (!f->c[g] || !scratch) {
            free(scratch);
            return QG_OUT_OF_MEMORY;
        }
        bool stopped = false;
        for (int d = 0; d <= reach && !stopped; d++) {
            stopped = qg_is_stopped(stop);
            if (!stopped)
                flank_matrix(&compliance[g], d, scratch, f->c[g] + (size_t)d * n * n);
        }
        free(scratch);
        if (stopped)
            return QG_CANCELLED;
    }
    return QG_OK;
}

void qg_flank_matrices_finish(struct qg_flank_matrices *f) {
    free(f->c[0]);
    free(f->c[1]);
}

/* a' C_d b; C_(-d) is the transpose. */
double qg_flank_flexibility(const struct qg_flank_matrices *f, int gear, int distance, const struct qg_spread *a,
                            const struct qg_spread *b) {
    if (distance < 0) {
        const struct qg_spread *t = a;
        a = b;
        b = t;
        distance = -distance;
    }
    assert(distance <= f->reach);
    size_t n = f->n[gear];
    const double *c = f->c[gear] + (size_t)distance * n * n;
    double sum = 0;
    for (size_t j = 0; j < 2 * b->count; j++) {
        const double *column = c + (2 * b->first + j) * n + 2 * a->first;
        double inner = 0;
        for (size_t i = 0; i < 2 * a->count; i++)
            inner += column[i] * a->weight[i];
        sum += inner * b->weight[j];
    }
    return sum;
}

struct qg_packed_spread (*qg_spreads_pack(struct qg_spread (*spread)[2], size_t n))[2] {
    size_t weights = 0;
    for (size_t i = 0; i < n; i++)
        weights += 2 * (spread[i][0].count + spread[i][1].count);
    struct qg_packed_spread(*packed)[2] = malloc(n * sizeof *packed + weights * sizeof(double));
    if (!packed)
        return NULL;
    double *at = (double *)(packed + n);
    for (size_t i = 0; i < n; i++)
        for (int g = 0; g < 2; g++) {
            const struct qg_spread *s = &spread[i][g];
            memcpy(at, s->weight, 2 * s->count * sizeof *at);
            packed[i][g] = (struct qg_packed_spread){s->first, s->count, at};
            at += 2 * s->count;
        }
    return packed;
}
