/* The progress bar of a study on a terminal: phase, share done, time left, best value so far. */
#ifndef QG_CLI_PROGRESS_H
#define QG_CLI_PROGRESS_H

#include <stdbool.h>
#include <stdio.h>

#include "core/study.h"

/* State of one bar. It belongs to the thread that runs the study. */
struct qg_bar {
    FILE *out;
    bool shown;   /* something stands on the line */
    double start; /* s, when the study began */
    double
        steady;   /* s, when the first step behind the finite elements was done; the time left is reckoned from there */
    double drawn; /* s, when it was last drawn */
    size_t steady_done;
};

/* A monotonic clock, in seconds. The argument is ignored: it fits struct qg_clock. */
double qg_monotonic_seconds(void *self);

/* Begins a bar on `out`. With out NULL nothing is ever drawn. */
void qg_bar_init(struct qg_bar *bar, FILE *out);

/* Draws the progress, at most ten times a second. best is the objective in core's units. */
void qg_bar_update(struct qg_bar *bar, const struct qg_progress *progress, enum qg_objective objective);

/* Wipes the line, so that what is printed next stands alone. */
void qg_bar_finish(struct qg_bar *bar);

#endif
