/* Oscillators that several tests of the dynamics work on. */
#ifndef QG_TESTS_CORE_OSCILLATORS_H
#define QG_TESTS_CORE_OSCILLATORS_H

#include "core/dynamics.h"

enum { SAMPLES = 14, CASES = 3, RELIEFS = 2, SPEEDS = 1000 };

/* Static transmission error of case S in micrometres at phases i/14 for 1/3, 2/3 and all of 470 N m, without relief and
 * with the standard one: CalculiX, two whole gears, plane stress, pinion bore held by a torque ring. */
static const double transmission_error[RELIEFS][CASES][SAMPLES] = {
    {{9.8656, 9.8972, 10.9083, 13.877, 13.6187, 13.4254, 13.3045, 13.255, 13.2725, 13.356, 13.5107, 13.7316, 10.8098,
      9.8935},
     {19.382, 19.4394, 20.7626, 26.0044, 26.5279, 26.1593, 25.9289, 25.8308, 25.8619, 26.0254, 26.3273, 25.4586,
      20.5763, 19.4323},
     {28.7617, 28.8515, 30.4131, 35.8473, 39.1656, 38.6227, 38.2806, 38.1379, 38.1884, 38.4351, 38.8876, 35.0329,
      30.1036, 28.8299}},
    {{22.3043, 22.0918, 21.648, 18.5738, 15.6138, 13.6199, 13.3046, 13.2551, 13.2725, 13.5129, 15.2839, 17.9197, 20.688,
      22.2141},
     {31.7516, 31.5632, 31.6374, 31.6003, 28.4261, 26.4682, 25.9291, 25.831, 25.8621, 26.3139, 28.1266, 30.9658,
      31.7096, 31.7055},
     {41.0575, 40.8944, 41.2148, 44.3624, 41.0217, 39.0272, 38.2809, 38.1382, 38.1886, 38.8433, 40.734, 43.7535,
      41.2653, 41.0397}}};

static const double base_radius = 39.467, half_backlash = 0.15604; /* mm */

/* Case S with secant stiffness and six harmonics. */
static inline struct qg_oscillator case_s(int relief, int load_case) {
    double force = 470e3 * (load_case + 1) / 3.0 / base_radius, stiffness[SAMPLES], mean = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        stiffness[i] = force / (1e-3 * transmission_error[relief][load_case][i]);
        mean += stiffness[i] / SAMPLES;
    }
    for (int i = 0; i < SAMPLES; i++)
        stiffness[i] /= mean;
    struct qg_oscillator out = {.damping_ratio = 0.01, .load = force / (mean * half_backlash)};
    qg_fourier_from_samples(&out.stiffness, stiffness, SAMPLES, 6);
    return out;
}

/* Constant stiffness. */
static inline struct qg_oscillator plain_oscillator(double damping_ratio, double load) {
    return (struct qg_oscillator){.damping_ratio = damping_ratio, .load = load, .stiffness = {.mean = 1.0}};
}

#endif
