/* What both integrators of the oscillator share: Fourier series, the static equilibrium, the speeds and their cut into
 * pieces. Nothing here calls the mathematical library for sines: its results may differ in the last bit from one
 * processor to another, and the same document shall give the same bits everywhere.
 */
#include "core/dynamics.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/dynamics_batch.h"
#include "core/force.h"

/* Taylor series of sine and cosine for |angle| <= pi/4; the first term left out is below 1e-17. */
static double short_sine(double angle) {
    double square = angle * angle, term = angle, sum = 0.0;
    for (int n = 1; n <= 17; n += 2) {
        sum += term;
        term *= -square / ((n + 1) * (n + 2));
    }
    return sum;
}

static double short_cosine(double angle) {
    double square = angle * angle, term = 1.0, sum = 0.0;
    for (int n = 0; n <= 18; n += 2) {
        sum += term;
        term *= -square / ((n + 1) * (n + 2));
    }
    return sum;
}

void qg_turn(double phase, double *cosine, double *sine) {
    phase -= floor(phase);
    int quarter = (int)(4.0 * phase + 0.5);
    double angle = 2.0 * QG_PI * (phase - 0.25 * quarter);
    double c = short_cosine(angle), s = short_sine(angle);
    switch (quarter % 4) {
    case 0:
        *cosine = c, *sine = s;
        break;
    case 1:
        *cosine = -s, *sine = c;
        break;
    case 2:
        *cosine = -c, *sine = -s;
        break;
    default:
        *cosine = s, *sine = -c;
    }
}

void qg_fourier_from_samples(struct qg_fourier *out, const double *samples, size_t n, int harmonics) {
    assert(n >= 1 && harmonics >= 0 && harmonics <= QG_HARMONICS_MAX && 2 * (size_t)harmonics + 1 <= n);
    memset(out, 0, sizeof *out);
    out->harmonics = harmonics;
    for (size_t i = 0; i < n; i++)
        out->mean += samples[i] / (double)n;
    for (int j = 1; j <= harmonics; j++) {
        for (size_t i = 0; i < n; i++) {
            double c, s;
            qg_turn((double)((size_t)j * i % n) / (double)n, &c, &s);
            out->cosine[j - 1] += 2.0 / (double)n * samples[i] * c;
            out->sine[j - 1] += 2.0 / (double)n * samples[i] * s;
        }
    }
}

double qg_fourier_at(const struct qg_fourier *series, double phase) {
    double value = series->mean;
    for (int j = 1; j <= series->harmonics; j++) {
        double c, s;
        qg_turn(j * (phase - floor(phase)), &c, &s);
        value += series->cosine[j - 1] * c + series->sine[j - 1] * s;
    }
    return value;
}

double qg_static_displacement(const struct qg_oscillator *oscillator) {
    if (oscillator->force) {
        struct qg_force_section section;
        qg_force_section_init(&section, oscillator->force, QG_FLANK_DRIVE, 0.0);
        return 1.0 + qg_force_section_approach(&section, oscillator->force->levels,
                                               oscillator->load / oscillator->force_scale);
    }
    return qg_fourier_at(&oscillator->error, 0.0) + 1.0 + oscillator->load / qg_fourier_at(&oscillator->stiffness, 0.0);
}

double qg_speed_at(const struct qg_speed_map *map, size_t i) {
    assert(i < map->count);
    if (map->count == 1)
        return map->min;
    return map->min + (double)i * (map->max - map->min) / (double)(map->count - 1);
}

size_t qg_response_pieces(const struct qg_speed_map *map) {
    if (map->branch != QG_BRANCH_FIXED)
        return 1;
    return (map->count + QG_LANES - 1) / QG_LANES;
}
