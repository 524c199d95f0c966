/* The reference integrator: one speed with SUNDIALS CVODE, as plainly as possible, to judge the batched integrator.
 *
 * State (x, v, integral of x - origin, integral of its square), variable-order Adams, Newton with the exact Jacobian.
 * The right-hand side keeps to one side of the dead zone, so that it is smooth; root-finding on y = x - e at both edges
 * stops the integration there, the side changes, and CVODE starts anew. Nothing is shared with the batched integrator
 * but the Fourier series and, with a force that depends on amplitude, the section of it at a phase; the edges are then
 * those of the two flanks, and the first piece of the section goes on beyond them.
 *
 * Steady state: the march is compared with itself 1..QG_PERIOD_MAX mesh periods ago. A transient falls by exp(-zeta T)
 * per mesh period, so a return error D over n periods means a distance of D / (1 - exp(-zeta T n)) from the steady
 * orbit. The period is an n for which that distance is below TOLERANCE amplitudes and has been so for 1/zeta of time,
 * or the smallest divisor of n that does nearly as well: an orbit that creeps away from an unstable one does not pass.
 * After TRANSIENT/zeta without a verdict: period 0, and the RMS over WINDOW/zeta.
 *
 * Threads   one SUNContext per call; any thread. Failures: QG_NO_CONVERGENCE when CVODE gives up, QG_OUT_OF_MEMORY.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "core/dynamics.h"
#include "core/dynamics_batch.h"
#include "core/force.h"

enum { STATES = 4, EDGES = 2, REMEMBERED = QG_PERIOD_MAX + 1, STEPS_MAX = 100000 };

static const double TOLERANCE = 1e-6; /* in amplitudes */
static const double TRANSIENT = 24.0; /* in 1/zeta */
static const double WINDOW = 4.0;     /* in 1/zeta */

/* What CVODE is given to know. */
struct motion {
    const struct qg_oscillator *oscillator;
    double frequency_ratio;
    double side;   /* +1, 0, -1: which branch of the dead zone holds */
    double origin; /* of the integrals */
};

struct integrator {
    struct motion motion;
    SUNContext context;
    void *cvode;
    N_Vector state;
    SUNMatrix matrix;
    SUNLinearSolver solver;
};

/* The states of the last mesh periods, newest at count % REMEMBERED. */
struct trail {
    double state[REMEMBERED][STATES];
    size_t count;                      /* mesh periods marched */
    size_t settled[QG_PERIOD_MAX + 1]; /* for how many of them, without a break, the orbit has returned after n */
};

static double phase_at(const struct motion *motion, double time) {
    return motion->frequency_ratio * time / (2.0 * QG_PI);
}

/* What the flank in contact pulls back with at a displacement, by the force of the oscillator; slope by x. */
static double pull(const struct motion *motion, double phase, double x, double *slope) {
    const struct qg_oscillator *o = motion->oscillator;
    struct qg_force_section section;
    qg_force_section_init(&section, o->force, motion->side > 0.0 ? QG_FLANK_DRIVE : QG_FLANK_BACK, phase);
    double force = qg_force_section_at(&section, o->force->levels, motion->side * x - 1.0, true, slope);
    *slope *= o->force_scale;
    return motion->side * force * o->force_scale;
}

/* What the teeth pull back with, and its derivative by x. */
static double mesh_force(const struct motion *motion, double phase, double x, double *slope) {
    *slope = 0.0;
    if (motion->side == 0.0)
        return 0.0;
    if (motion->oscillator->force)
        return pull(motion, phase, x, slope);
    *slope = qg_fourier_at(&motion->oscillator->stiffness, phase);
    return *slope * (x - qg_fourier_at(&motion->oscillator->error, phase) - motion->side);
}

/* y at the two edges of the dead zone: displacement beyond the drive flanks' and above the back flanks'. */
static void distances(const struct qg_oscillator *o, double phase, double x, double out[EDGES]) {
    double drive = qg_fourier_at(o->force ? &o->force->approach[QG_FLANK_DRIVE][0] : &o->error, phase);
    double back = o->force ? qg_fourier_at(&o->force->approach[QG_FLANK_BACK][0], phase) : -drive;
    out[0] = x - 1.0 - drive;
    out[1] = x + 1.0 + back;
}

static int derivative(double time, N_Vector state, N_Vector out, void *user) {
    const struct motion *motion = user;
    const double *z = N_VGetArrayPointer(state);
    double *dz = N_VGetArrayPointer(out), slope;
    double force = mesh_force(motion, phase_at(motion, time), z[0], &slope);
    dz[0] = z[1];
    dz[1] = motion->oscillator->load - 2.0 * motion->oscillator->damping_ratio * z[1] - force;
    dz[2] = z[0] - motion->origin;
    dz[3] = dz[2] * dz[2];
    return 0;
}

static int jacobian(double time, N_Vector state, N_Vector slope, SUNMatrix out, void *user, N_Vector work1,
                    N_Vector work2, N_Vector work3) {
    (void)slope, (void)work1, (void)work2, (void)work3;
    const struct motion *motion = user;
    const double *z = N_VGetArrayPointer(state);
    double stiffness;
    mesh_force(motion, phase_at(motion, time), z[0], &stiffness);
    SUNMatZero(out);
    SM_ELEMENT_D(out, 0, 1) = 1.0;
    SM_ELEMENT_D(out, 1, 0) = -stiffness;
    SM_ELEMENT_D(out, 1, 1) = -2.0 * motion->oscillator->damping_ratio;
    SM_ELEMENT_D(out, 2, 0) = 1.0;
    SM_ELEMENT_D(out, 3, 0) = 2.0 * (z[0] - motion->origin);
    return 0;
}

static int edges(double time, N_Vector state, double *out, void *user) {
    const struct motion *motion = user;
    distances(motion->oscillator, phase_at(motion, time), N_VGetArrayPointer(state)[0], out);
    return 0;
}

/* Frees what integrator_init has made, also after its failure. */
static void integrator_finish(struct integrator *self) {
    CVodeFree(&self->cvode);
    if (self->solver)
        SUNLinSolFree(self->solver);
    if (self->matrix)
        SUNMatDestroy(self->matrix);
    if (self->state)
        N_VDestroy(self->state);
    SUNContext_Free(&self->context);
}

static bool integrator_allocate(struct integrator *self) {
    if (SUNContext_Create(NULL, &self->context) != 0)
        return false;
    self->state = N_VNew_Serial(STATES, self->context);
    self->matrix = SUNDenseMatrix(STATES, STATES, self->context);
    self->cvode = CVodeCreate(CV_ADAMS, self->context);
    if (!self->state || !self->matrix || !self->cvode)
        return false;
    self->solver = SUNLinSol_Dense(self->state, self->matrix, self->context);
    return self->solver != NULL;
}

static bool integrator_configure(struct integrator *self, double rtol) {
    return CVodeInit(self->cvode, derivative, 0.0, self->state) == CV_SUCCESS &&
           CVodeSStolerances(self->cvode, rtol, 0.01 * rtol) == CV_SUCCESS &&
           CVodeSetUserData(self->cvode, &self->motion) == CV_SUCCESS &&
           CVodeSetLinearSolver(self->cvode, self->solver, self->matrix) == CV_SUCCESS &&
           CVodeSetJacFn(self->cvode, jacobian) == CV_SUCCESS &&
           CVodeSetMaxNumSteps(self->cvode, STEPS_MAX) == CV_SUCCESS &&
           CVodeRootInit(self->cvode, EDGES, edges) == CV_SUCCESS &&
           CVodeSetNoInactiveRootWarn(self->cvode) == CV_SUCCESS;
}

static double side_of(const struct qg_oscillator *oscillator, double x) {
    double y[EDGES];
    distances(oscillator, 0.0, x, y);
    return y[0] > 0.0 ? 1.0 : y[1] < 0.0 ? -1.0 : 0.0;
}

static enum qg_status integrator_init(struct integrator *self, double x, double v, double rtol) {
    const struct qg_oscillator *oscillator = self->motion.oscillator;
    self->motion.origin = x;
    self->motion.side = side_of(oscillator, x);
    if (!integrator_allocate(self))
        return QG_OUT_OF_MEMORY;
    const double start[STATES] = {x, v, 0.0, 0.0};
    memcpy(N_VGetArrayPointer(self->state), start, sizeof start);
    return integrator_configure(self, rtol) ? QG_OK : QG_NO_CONVERGENCE;
}

/* Changes the side at an edge and starts anew. */
static bool pass_edge(struct integrator *self, double time) {
    int direction[EDGES];
    if (CVodeGetRootInfo(self->cvode, direction) != CV_SUCCESS)
        return false;
    if (direction[0] != 0)
        self->motion.side = direction[0] > 0 ? 1.0 : 0.0;
    else
        self->motion.side = direction[1] > 0 ? 0.0 : -1.0;
    return CVodeReInit(self->cvode, time, self->state) == CV_SUCCESS;
}

/* Integrates from edge to edge until `end`. */
static bool integrate(struct integrator *self, double end) {
    for (;;) {
        double time;
        if (CVodeSetStopTime(self->cvode, end) != CV_SUCCESS)
            return false;
        int flag = CVode(self->cvode, end, self->state, &time, CV_NORMAL);
        if (flag == CV_TSTOP_RETURN || flag == CV_SUCCESS)
            return true;
        if (flag != CV_ROOT_RETURN || !pass_edge(self, time))
            return false;
        if (time >= end)
            return true;
    }
}

static const double *past(const struct trail *trail, size_t periods) {
    return trail->state[(trail->count - periods) % REMEMBERED];
}

/* The response over the last mesh periods. */
static void measure(const struct trail *trail, const struct motion *motion, int periods, struct qg_response *out) {
    const double *now = past(trail, 0), *then = past(trail, (size_t)periods);
    double duration = periods * 2.0 * QG_PI / motion->frequency_ratio;
    double mean = (now[2] - then[2]) / duration, square = (now[3] - then[3]) / duration;
    *out = (struct qg_response){.rms = sqrt(fmax(square - mean * mean, 0.0)),
                                .mean = motion->origin + mean,
                                .period = periods,
                                .x = now[0],
                                .v = now[1]};
}

/* How far the orbit is from where it was n mesh periods ago. */
static double return_error(const struct trail *trail, int n) {
    const double *now = past(trail, 0), *then = past(trail, (size_t)n);
    return hypot(now[0] - then[0], now[1] - then[1]);
}

/* The smallest period of an orbit that has settled on returning after n within `distance`: a transient that turns once
 * in n periods is seen by the divisors of n only later. */
static int smallest_period(const struct trail *trail, int n, double distance) {
    for (int divisor = 1; divisor < n; divisor++) {
        if (n % divisor == 0 && return_error(trail, divisor) <= 10.0 * distance)
            return divisor;
    }
    return n;
}

/* Takes in one mesh period; the verdict is the period of the response, or 0. */
static int judge(struct trail *trail, const struct motion *motion) {
    double mesh_period = 2.0 * QG_PI / motion->frequency_ratio, damping = motion->oscillator->damping_ratio;
    struct qg_response last;
    measure(trail, motion, 1, &last);
    double allowed = TOLERANCE * (last.rms + 1e-6 * motion->oscillator->load);
    for (int n = 1; n <= QG_PERIOD_MAX && (size_t)n <= trail->count; n++) {
        bool returned = return_error(trail, n) <= allowed * -expm1(-damping * mesh_period * n);
        trail->settled[n] = returned ? trail->settled[n] + 1 : 0;
    }
    for (int n = 1; n <= QG_PERIOD_MAX; n++) {
        if ((double)trail->settled[n] * mesh_period * damping >= 1.0)
            return smallest_period(trail, n, allowed);
    }
    return 0;
}

static bool march_one_period(struct integrator *self, struct trail *trail) {
    double end = (double)(trail->count + 1) * 2.0 * QG_PI / self->motion.frequency_ratio;
    if (!integrate(self, end))
        return false;
    trail->count++;
    memcpy(trail->state[trail->count % REMEMBERED], N_VGetArrayPointer(self->state), sizeof trail->state[0]);
    return true;
}

/* The long window of an orbit without a verdict. */
static bool measure_window(struct integrator *self, struct trail *trail, struct qg_response *out) {
    double then[STATES], mesh_period = 2.0 * QG_PI / self->motion.frequency_ratio;
    double periods = ceil(WINDOW / (self->motion.oscillator->damping_ratio * mesh_period));
    memcpy(then, past(trail, 0), sizeof then);
    for (double i = 0.0; i < periods; i++) {
        if (!march_one_period(self, trail))
            return false;
    }
    const double *now = past(trail, 0);
    double duration = periods * mesh_period;
    double mean = (now[2] - then[2]) / duration, square = (now[3] - then[3]) / duration;
    *out = (struct qg_response){
        .rms = sqrt(fmax(square - mean * mean, 0.0)), .mean = self->motion.origin + mean, .x = now[0], .v = now[1]};
    return true;
}

static bool march(struct integrator *self, struct qg_response *out) {
    struct trail trail = {.count = 0};
    memcpy(trail.state[0], N_VGetArrayPointer(self->state), sizeof trail.state[0]);
    double mesh_period = 2.0 * QG_PI / self->motion.frequency_ratio;
    double periods_max = ceil(TRANSIENT / (self->motion.oscillator->damping_ratio * mesh_period));
    while ((double)trail.count < periods_max) {
        if (!march_one_period(self, &trail))
            return false;
        int period = judge(&trail, &self->motion);
        if (period > 0) {
            measure(&trail, &self->motion, period, out);
            return true;
        }
    }
    return measure_window(self, &trail, out);
}

enum qg_status qg_response_reference(const struct qg_oscillator *oscillator, double frequency_ratio, double x, double v,
                                     double rtol, struct qg_response *out) {
    assert(frequency_ratio > 0.0 && rtol > 0.0 && oscillator->damping_ratio > 0.0);
    struct integrator integrator = {.motion = {.oscillator = oscillator, .frequency_ratio = frequency_ratio}};
    enum qg_status status = integrator_init(&integrator, x, v, rtol);
    if (status == QG_OK && !march(&integrator, out))
        status = QG_NO_CONVERGENCE;
    integrator_finish(&integrator);
    return status;
}
