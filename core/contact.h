/* The frictionless contact problem of a loaded pair: which points touch, and with what force.
 *
 * n points may touch. Point i has the initial gap g_i >= 0 along its contact normal, closes by c_i delta when the gears
 * approach each other by delta along the line of action (c_i is 1 for a normal along it), and yields by C lambda:
 *
 *     w = g + C lambda - c delta >= 0,   lambda >= 0,   lambda' w = 0,   c' lambda = F
 *
 * C is symmetric positive definite: a strictly convex quadratic program with one solution. Solved exactly (to rounding) by
 * exchanging whole blocks of points between touching and open, as Judice and Pires do for linear complementarity
 * problems; should that cycle, by the primal active-set method, which always ends.
 */
#ifndef QG_CORE_CONTACT_H
#define QG_CORE_CONTACT_H

#include "core/status.h"

/* One problem. */
struct qg_contact_problem {
    size_t n;                  /* >= 1 */
    const double *flexibility; /* mm/N, n x n, symmetric */
    const double *gap;         /* mm, [n] */
    const double *lever;       /* [n], > 0: c */
    double force;              /* N, > 0 */
};

/* Room to work in, and the solution. */
struct qg_contact {
    size_t room;
    double *load;       /* N, [n]: lambda */
    double *opening;    /* mm, [n]: w */
    double approach;    /* mm: delta = first_touch + closing */
    double first_touch; /* mm: smallest g_i / c_i, where a vanishing force would stop */
    double closing;     /* mm: what the force adds */
    double residual;    /* largest of -lambda/F, -w/delta, lambda w/(F delta), |c'lambda - F|/F */
    size_t iterations;  /* factorizations */
    size_t touching;    /* points with load */
    int *active;        /* [touching] their indices, ascending; also the first guess of the next solve when kept */
    double *matrix;     /* scratch */
    double *scratch;
    unsigned char *is_active;
};

/* Room for problems of up to n points. QG_OUT_OF_MEMORY. */
enum qg_status qg_contact_init(struct qg_contact *contact, size_t n);
void qg_contact_finish(struct qg_contact *contact);

/* Solves. warm: start from the points that touched in the last solve, else from scratch. QG_NO_CONVERGENCE when a
 * factorization fails, which a positive definite C excludes. Allocates nothing. */
enum qg_status qg_contact_solve(struct qg_contact *contact, const struct qg_contact_problem *problem, int warm);

#endif
