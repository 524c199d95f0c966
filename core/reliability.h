/* Manufacturing errors: what becomes of a design when its reliefs are not cut exactly.
 *
 * Monte Carlo: every parameter of a present ramp gets an independent Gaussian error, mean 0, standard deviation a sixth of
 * its range, cut to +- half the range. Trial i of a seed has the same errors for every design (common random numbers),
 * so that two designs compare fairly.
 *
 * The share of a parameter in the spread comes from the trials themselves: F is regressed on the scaled errors u_k and their
 * squares, F = a + sum_k b_k u_k + c_k (u_k^2 - E u^2), whose terms are uncorrelated because the errors are independent; the
 * share of parameter k is the variance of its two terms over the variance of F. What no single parameter explains
 * (interactions, jumps of the response) is left over.
 */
#ifndef QG_CORE_RELIABILITY_H
#define QG_CORE_RELIABILITY_H

#include <stdint.h>

#include "core/relief.h"

/* What is asked. */
struct qg_reliability {
    size_t samples;         /* 0: none */
    double radius_range;    /* mm, full width of the errors of radii */
    double amplitude_range; /* mm, full width of the errors of amplitudes */
    double limit_f_dte;     /* a trial fails above it */
    uint64_t seed;
    double percentile;        /* of the objective F_DTE_PERCENTILE: 50 .. 100 */
    size_t percentile_trials; /* that it is taken from, for each candidate: 2 .. QG_PERCENTILE_TRIALS_MAX */
};

enum { QG_PERCENTILE_TRIALS_MAX = 1000 };

enum { QG_HISTOGRAM_BINS = 20, QG_QUANTILES = 5 };

/* The quantiles that are reported: 5, 25, 50, 75, 95 %. */
extern const double qg_quantile_levels[QG_QUANTILES];

/* What came out. */
struct qg_reliability_result {
    size_t samples, failures;               /* 0 samples: none was asked */
    double probability_of_failure;          /* failures / samples */
    double confidence_low, confidence_high; /* 95 %, Clopper-Pearson */
    double mean_f_dte, standard_deviation, min_f_dte, max_f_dte;
    double quantile[QG_QUANTILES];       /* of F_DTE */
    size_t histogram[QG_HISTOGRAM_BINS]; /* trials per bin, even bins from min to max */
    bool has_share[QG_PARAMETER_COUNT];  /* parameters of present ramps, when there were trials enough to tell */
    double share[QG_PARAMETER_COUNT];    /* of the variance of F_DTE, 0..1 */
    double unexplained;                  /* 1 - sum of shares, at least 0 */
};

/* The error of a parameter in a trial (mm). */
double qg_reliability_error(const struct qg_reliability *reliability, enum qg_parameter parameter, size_t trial);

/* The design with the errors of a trial; radii are kept within the tooth, amplitudes between 0 and the deepest relief. */
struct qg_relief qg_reliability_trial(const struct qg_reliability *reliability, const struct qg_gear_pair *pair,
                                      const struct qg_pair_geometry *geometry, const struct qg_relief *design,
                                      size_t trial);

/* Sums up the trials: f_dte[i] of trial i, `samples` >= 1 of them. f_dte is sorted in place. */
void qg_reliability_summarize(const struct qg_reliability *reliability, const struct qg_relief *design, double *f_dte,
                              struct qg_reliability_result *out);

/* The percentile of the values of percentile_trials trials, interpolated between neighbours. f_dte is sorted in place. */
double qg_reliability_percentile(const struct qg_reliability *reliability, double *f_dte);

#endif
