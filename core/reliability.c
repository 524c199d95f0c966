/* Monte Carlo of manufacturing errors, and what it says about each tolerance. */
#include "core/reliability.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/random.h"
#include "core/search.h"

/* Errors are cut at this many standard deviations: half the range. */
static const double cut = 3;

const double qg_quantile_levels[QG_QUANTILES] = {0.05, 0.25, 0.5, 0.75, 0.95};

/* In standard deviations. */
static double scaled_error(const struct qg_reliability *r, enum qg_parameter parameter, size_t trial) {
    return qg_random_gaussian(r->seed, QG_STREAM_RELIABILITY, trial, (uint32_t)parameter, cut);
}

double qg_reliability_error(const struct qg_reliability *r, enum qg_parameter parameter, size_t trial) {
    double range = qg_parameter_is_radius(parameter) ? r->radius_range : r->amplitude_range;
    return range / (2 * cut) * scaled_error(r, parameter, trial);
}

struct qg_relief qg_reliability_trial(const struct qg_reliability *r, const struct qg_gear_pair *pair,
                                      const struct qg_pair_geometry *geometry, const struct qg_relief *design,
                                      size_t trial) {
    struct qg_relief relief = *design;
    for (int k = 0; k < QG_PARAMETER_COUNT; k++) {
        enum qg_parameter parameter = (enum qg_parameter)k;
        if (!qg_relief_ramp_of(&relief, parameter)->present)
            continue;
        int gear = k / 4;
        double most = qg_parameter_is_radius(parameter) ? pair->gears[gear].outside_radius
                                                        : qg_relief_deepest(pair, geometry, gear);
        double *value = qg_relief_parameter(&relief, parameter);
        *value = fmin(most, fmax(0, *value + qg_reliability_error(r, parameter, trial)));
    }
    return relief;
}

/* ---- shares ----------------------------------------------------------------------------------------------------- */

enum { TERMS_MAX = 1 + 2 * QG_PARAMETER_COUNT, TRIALS_PER_TERM = 4 };

/* The regression's terms: 1, then u and u^2 - its mean for each parameter that has errors. */
struct regression {
    size_t parameters, terms;
    enum qg_parameter parameter[QG_PARAMETER_COUNT];
    double square_mean; /* E u^2 of the cut Gaussian */
    double matrix[TERMS_MAX][TERMS_MAX];
    double right[TERMS_MAX];
};

static void terms_of(const struct regression *g, const struct qg_reliability *r, size_t trial, double term[TERMS_MAX]) {
    term[0] = 1;
    for (size_t k = 0; k < g->parameters; k++) {
        double u = scaled_error(r, g->parameter[k], trial);
        term[1 + 2 * k] = u;
        term[2 + 2 * k] = u * u - g->square_mean;
    }
}

/* Solves the normal equations in place by Cholesky; false when the trials do not determine the terms. */
static bool solve_normal_equations(struct regression *g) {
    size_t n = g->terms;
    for (size_t j = 0; j < n; j++) {
        for (size_t i = j; i < n; i++) {
            double sum = g->matrix[i][j];
            for (size_t k = 0; k < j; k++)
                sum -= g->matrix[i][k] * g->matrix[j][k];
            if (i == j && !(sum > 1e-9 * g->matrix[0][0]))
                return false;
            g->matrix[i][j] = i == j ? sqrt(sum) : sum / g->matrix[j][j];
        }
    }
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            g->right[i] -= g->matrix[i][k] * g->right[k];
        g->right[i] /= g->matrix[i][i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            g->right[i] -= g->matrix[k][i] * g->right[k];
        g->right[i] /= g->matrix[i][i];
    }
    return true;
}

/* Variances of u and of u^2 for the Gaussian cut at +- c: with q = 2 c phi(c) / (2 Phi(c) - 1), E u^2 = 1 - q and
 * E u^4 = 3 - q (c^2 + 3). */
static void cut_moments(double *square, double *variance_of_square) {
    double density = exp(-cut * cut / 2) / sqrt(2 * M_PI), inside = erf(cut / sqrt(2));
    double q = 2 * cut * density / inside;
    *square = 1 - q;
    *variance_of_square = 3 - q * (cut * cut + 3) - *square * *square;
}

static void find_shares(const struct qg_reliability *r, const struct qg_relief *design, const double *f,
                        struct qg_reliability_result *out) {
    struct regression g = {0};
    struct qg_relief copy = *design;
    double square_variance;
    cut_moments(&g.square_mean, &square_variance);
    for (int k = 0; k < QG_PARAMETER_COUNT; k++) {
        double range = qg_parameter_is_radius((enum qg_parameter)k) ? r->radius_range : r->amplitude_range;
        if (qg_relief_ramp_of(&copy, (enum qg_parameter)k)->present && range > 0)
            g.parameter[g.parameters++] = (enum qg_parameter)k;
    }
    g.terms = 1 + 2 * g.parameters;
    double variance = out->standard_deviation * out->standard_deviation;
    if (g.parameters == 0 || r->samples < TRIALS_PER_TERM * g.terms || !(variance > 0))
        return;
    for (size_t i = 0; i < r->samples; i++) {
        double term[TERMS_MAX];
        terms_of(&g, r, i, term);
        for (size_t a = 0; a < g.terms; a++) {
            g.right[a] += term[a] * f[i];
            for (size_t b = 0; b <= a; b++)
                g.matrix[a][b] += term[a] * term[b];
        }
    }
    if (!solve_normal_equations(&g))
        return;
    double sum = 0;
    for (size_t k = 0; k < g.parameters; k++) {
        double linear = g.right[1 + 2 * k], square = g.right[2 + 2 * k];
        double share = (linear * linear * g.square_mean + square * square * square_variance) / variance;
        out->has_share[g.parameter[k]] = true;
        out->share[g.parameter[k]] = share;
        sum += share;
    }
    out->unexplained = fmax(0, 1 - sum);
}

/* ---- summary ---------------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of sorted values, interpolated between neighbours. */
static double quantile(const double *sorted, size_t n, double level) {
    double at = level * (double)(n - 1);
    size_t low = (size_t)at;
    return low + 1 < n ? sorted[low] + (at - (double)low) * (sorted[low + 1] - sorted[low]) : sorted[n - 1];
}

double qg_reliability_percentile(const struct qg_reliability *r, double *f_dte) {
    qsort(f_dte, r->percentile_trials, sizeof *f_dte, ascending);
    return quantile(f_dte, r->percentile_trials, r->percentile / 100);
}

static void count_bins(const double *f, size_t n, struct qg_reliability_result *out) {
    double width = (out->max_f_dte - out->min_f_dte) / QG_HISTOGRAM_BINS;
    for (size_t i = 0; i < n; i++) {
        size_t bin = width > 0 ? (size_t)((f[i] - out->min_f_dte) / width) : 0;
        out->histogram[bin < QG_HISTOGRAM_BINS ? bin : QG_HISTOGRAM_BINS - 1]++;
    }
}

void qg_reliability_summarize(const struct qg_reliability *r, const struct qg_relief *design, double *f,
                              struct qg_reliability_result *out) {
    size_t n = r->samples;
    assert(n > 0);
    *out = (struct qg_reliability_result){.samples = n, .min_f_dte = INFINITY, .max_f_dte = -INFINITY};
    double sum = 0, squares = 0;
    for (size_t i = 0; i < n; i++) {
        out->failures += f[i] > r->limit_f_dte;
        sum += f[i];
        out->min_f_dte = fmin(out->min_f_dte, f[i]);
        out->max_f_dte = fmax(out->max_f_dte, f[i]);
    }
    out->mean_f_dte = sum / (double)n;
    for (size_t i = 0; i < n; i++)
        squares += (f[i] - out->mean_f_dte) * (f[i] - out->mean_f_dte);
    out->standard_deviation = n > 1 ? sqrt(squares / (double)(n - 1)) : 0;
    out->probability_of_failure = (double)out->failures / (double)n;
    qg_binomial_confidence(out->failures, n, &out->confidence_low, &out->confidence_high);
    find_shares(r, design, f, out);
    count_bins(f, n, out);
    qsort(f, n, sizeof *f, ascending);
    for (int k = 0; k < QG_QUANTILES; k++)
        out->quantile[k] = quantile(f, n, qg_quantile_levels[k]);
}
