/* Active sets for the contact problem; see contact.h for the problem and the two methods.
 *
 * With the touching set A known, the conditions are linear: C_AA lambda = c delta - g, c' lambda = F. One Cholesky
 * factor of C_AA gives u = C_AA^-1 c and v = C_AA^-1 g, then delta = (F + c'v) / (c'u), lambda = delta u - v. Gaps and
 * approach are counted from the first touch, min g_i / c_i: under a small force both are large beside what it closes, and
 * delta u - v would lose all its digits.
 */
#include "core/contact.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum qg_status qg_contact_init(struct qg_contact *contact, size_t n) {
    *contact = (struct qg_contact){.room = n};
    contact->load = calloc(n, sizeof(double));
    contact->opening = calloc(n, sizeof(double));
    contact->active = calloc(n, sizeof(int));
    contact->matrix = calloc(n * n, sizeof(double));
    contact->scratch = calloc(4 * n, sizeof(double));
    contact->is_active = calloc(n, 1);
    if (contact->load && contact->opening && contact->active && contact->matrix && contact->scratch &&
        contact->is_active)
        return QG_OK;
    qg_contact_finish(contact);
    return QG_OUT_OF_MEMORY;
}

void qg_contact_finish(struct qg_contact *contact) {
    free(contact->load);
    free(contact->opening);
    free(contact->active);
    free(contact->matrix);
    free(contact->scratch);
    free(contact->is_active);
    *contact = (struct qg_contact){0};
}

/* Lower Cholesky factor in place, row-major n x n. False when not positive definite. */
static bool factorize(double *a, size_t n) {
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            if (i != j)
                a[i * n + j] = sum / a[j * n + j];
            else if (sum > 0)
                a[i * n + i] = sqrt(sum);
            else
                return false;
        }
    }
    return true;
}

/* Solves L L' x = x. */
static void substitute(const double *l, size_t n, double *x) {
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            x[i] -= l[i * n + k] * x[k];
        x[i] /= l[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            x[i] -= l[k * n + i] * x[k];
        x[i] /= l[i * n + i];
    }
}

/* Writes is_active as the list active. */
static void list_active(struct qg_contact *c, size_t n) {
    c->touching = 0;
    for (size_t i = 0; i < n; i++)
        if (c->is_active[i])
            c->active[c->touching++] = (int)i;
}

/* The gap of a point when the first one touches. */
static double gap_left(const struct qg_contact *c, const struct qg_contact_problem *p, size_t i) {
    return p->gap[i] - p->lever[i] * c->first_touch;
}

/* What rounding may leave of an opening that is zero. */
static double opening_tolerance(const struct qg_contact *c) {
    return 1e-13 * c->closing + 1e-15 * c->first_touch;
}

/* Loads on the active set (into trial[touching]) and the approach with every point of the set exactly closed. */
static bool solve_closed(struct qg_contact *c, const struct qg_contact_problem *p, double *trial) {
    size_t n = c->touching;
    double *u = c->scratch, *v = c->scratch + c->room;
    for (size_t i = 0; i < n; i++) {
        const double *row = p->flexibility + (size_t)c->active[i] * p->n;
        for (size_t j = 0; j <= i; j++)
            c->matrix[i * n + j] = row[c->active[j]];
        u[i] = p->lever[c->active[i]];
        v[i] = gap_left(c, p, (size_t)c->active[i]);
    }
    c->iterations++;
    if (!factorize(c->matrix, n))
        return false;
    substitute(c->matrix, n, u);
    substitute(c->matrix, n, v);
    double cu = 0, cv = 0;
    for (size_t i = 0; i < n; i++) {
        cu += p->lever[c->active[i]] * u[i];
        cv += p->lever[c->active[i]] * v[i];
    }
    c->closing = (p->force + cv) / cu;
    c->approach = c->first_touch + c->closing;
    for (size_t i = 0; i < n; i++)
        trial[i] = c->closing * u[i] - v[i];
    return true;
}

/* w = g + C lambda - c delta for loads `trial` on the active set. */
static void compute_opening(struct qg_contact *c, const struct qg_contact_problem *p, const double *trial) {
    for (size_t i = 0; i < p->n; i++)
        c->opening[i] = gap_left(c, p, i) - p->lever[i] * c->closing;
    for (size_t k = 0; k < c->touching; k++) {
        const double *column = p->flexibility + (size_t)c->active[k] * p->n;
        for (size_t i = 0; i < p->n; i++)
            c->opening[i] += column[i] * trial[k];
    }
    for (size_t k = 0; k < c->touching; k++)
        c->opening[c->active[k]] = 0;
}

/* A cold guess: the points whose gap exceeds the smallest by less than a fifth of what the force alone would close. */
static void guess(struct qg_contact *c, const struct qg_contact_problem *p) {
    size_t first = 0;
    for (size_t i = 1; i < p->n; i++)
        if (p->gap[i] < p->gap[first])
            first = i;
    double limit = p->gap[first] + 0.2 * p->force * p->flexibility[first * p->n + first];
    for (size_t i = 0; i < p->n; i++)
        c->is_active[i] = i == first || p->gap[i] < limit;
}

/* Exchanges every offending point at once. Returns how many offended. */
static size_t exchange(struct qg_contact *c, const struct qg_contact_problem *p, const double *trial) {
    size_t offending = 0;
    double tolerance = opening_tolerance(c);
    for (size_t k = 0; k < c->touching; k++)
        if (trial[k] < 0) {
            c->is_active[c->active[k]] = 0;
            offending++;
        }
    for (size_t i = 0; i < p->n; i++)
        if (!c->is_active[i] && c->opening[i] < -tolerance) {
            c->is_active[i] = 1;
            offending++;
        }
    return offending;
}

enum outcome { SOLVED, CYCLING, FAILED };

/* Block exchanges until nothing offends; gives up when the number of offending points does not shrink for long. */
static enum outcome block_exchanges(struct qg_contact *c, const struct qg_contact_problem *p, double *trial) {
    size_t best = p->n + 1;
    for (int patience = 12; patience > 0; patience--) {
        list_active(c, p->n);
        if (c->touching == 0)
            return CYCLING;
        if (!solve_closed(c, p, trial))
            return FAILED;
        compute_opening(c, p, trial);
        size_t offending = exchange(c, p, trial);
        if (offending == 0)
            return SOLVED;
        if (offending < best) {
            best = offending;
            patience = 12;
        }
    }
    return CYCLING;
}

/* Moves the feasible loads towards the trial loads until a load vanishes; that point leaves. True when none vanished. */
static bool step_towards(struct qg_contact *c, const double *trial) {
    double step = 1;
    int leaving = -1;
    for (size_t k = 0; k < c->touching; k++) {
        double now = c->load[c->active[k]];
        if (trial[k] < 0 && now / (now - trial[k]) < step) {
            step = now / (now - trial[k]);
            leaving = c->active[k];
        }
    }
    for (size_t k = 0; k < c->touching; k++) {
        int i = c->active[k];
        c->load[i] += step * (trial[k] - c->load[i]);
    }
    if (leaving < 0)
        return true;
    c->load[leaving] = 0;
    c->is_active[leaving] = 0;
    return false;
}

/* The primal active-set method from one loaded point: loads stay feasible, the energy falls, so no set comes twice. */
static enum outcome one_by_one(struct qg_contact *c, const struct qg_contact_problem *p, double *trial) {
    size_t first = 0;
    for (size_t i = 1; i < p->n; i++)
        if (p->gap[i] < p->gap[first])
            first = i;
    memset(c->load, 0, p->n * sizeof *c->load);
    memset(c->is_active, 0, p->n);
    c->load[first] = p->force / p->lever[first];
    c->is_active[first] = 1;
    for (size_t limit = 50 * p->n + 50; limit > 0; limit--) {
        list_active(c, p->n);
        if (!solve_closed(c, p, trial))
            return FAILED;
        if (!step_towards(c, trial))
            continue;
        compute_opening(c, p, trial);
        size_t worst = 0;
        for (size_t i = 1; i < p->n; i++)
            if (c->opening[i] < c->opening[worst])
                worst = i;
        if (c->opening[worst] >= -opening_tolerance(c))
            return SOLVED;
        c->is_active[worst] = 1;
    }
    return FAILED;
}

static double residual_of(const struct qg_contact *c, const struct qg_contact_problem *p) {
    double worst = 0, sum = 0, scale = fabs(c->approach);
    for (size_t i = 0; i < p->n; i++) {
        worst = fmax(worst, fmax(-c->load[i] / p->force, -c->opening[i] / scale));
        worst = fmax(worst, fabs(c->load[i] * c->opening[i]) / (p->force * scale));
        sum += p->lever[i] * c->load[i];
    }
    /* closure of the touching points, evaluated afresh */
    for (size_t k = 0; k < c->touching; k++) {
        size_t i = (size_t)c->active[k];
        double w = p->gap[i] - p->lever[i] * c->approach;
        for (size_t j = 0; j < c->touching; j++)
            w += p->flexibility[i * p->n + (size_t)c->active[j]] * c->load[c->active[j]];
        worst = fmax(worst, fabs(w) / scale);
    }
    return fmax(worst, fabs(sum - p->force) / p->force);
}

enum qg_status qg_contact_solve(struct qg_contact *c, const struct qg_contact_problem *p, int warm) {
    assert(p->n >= 1 && p->n <= c->room && p->force > 0);
    double *trial = c->scratch + 2 * c->room;
    c->first_touch = INFINITY;
    for (size_t i = 0; i < p->n; i++)
        c->first_touch = fmin(c->first_touch, p->gap[i] / p->lever[i]);
    if (!warm)
        guess(c, p);
    c->iterations = 0;
    enum outcome outcome = block_exchanges(c, p, trial);
    if (outcome != SOLVED)
        outcome = one_by_one(c, p, trial);
    if (outcome != SOLVED)
        return QG_NO_CONVERGENCE;
    memset(c->load, 0, p->n * sizeof *c->load);
    for (size_t k = 0; k < c->touching; k++)
        c->load[c->active[k]] = trial[k];
    c->residual = residual_of(c, p);
    return QG_OK;
}
