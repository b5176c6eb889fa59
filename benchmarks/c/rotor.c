/* A rotor in a clearance, simulated event by event, as one would write it in C over SUNDIALS.
 *
 * The same algorithm as rotor_ida/core: flight in closed form, with a search for the first
 * touch that no touch can escape; contact in variables that are smooth through entry and exit,
 * integrated by CVODE (Adams, Newton, dense), its exit polished on the solver's own interpolant,
 * and CVodeReInit for the next one. It does not know starts at rest on the ring.
 *
 *     rotor omega zeta delta0 x y vx vy duration samples step_rtol step_atol repetitions
 *
 * prints "seconds" (clock, processor) for each repetition and, of the last one, "event" with time
 * and kind, and "sample" with the number of samples and the last x and y. INDEX is the integer type of SUNDIALS' index.
 */
#include <complex.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef INDEX
#define INDEX int32_t
#endif

/* What is needed of SUNDIALS 7; the wheel carries the libraries without their headers. */
typedef struct SUNContext_ *SUNContext;
typedef struct Vector_ *N_Vector;
typedef struct Matrix_ *SUNMatrix;
typedef struct Solver_ *SUNLinearSolver;
typedef int (*CVRhsFn)(double, N_Vector, N_Vector, void *);
int SUNContext_Create(int, SUNContext *);
int SUNContext_Free(SUNContext *);
N_Vector N_VNew_Serial(INDEX, SUNContext);
double *N_VGetArrayPointer(N_Vector);
void N_VDestroy(N_Vector);
SUNMatrix SUNDenseMatrix(INDEX, INDEX, SUNContext);
void SUNMatDestroy(SUNMatrix);
SUNLinearSolver SUNLinSol_Dense(N_Vector, SUNMatrix, SUNContext);
int SUNLinSolFree(SUNLinearSolver);
void *CVodeCreate(int, SUNContext);
void CVodeFree(void **);
int CVodeInit(void *, CVRhsFn, double, N_Vector);
int CVodeReInit(void *, double, N_Vector);
int CVodeSVtolerances(void *, double, N_Vector);
int CVodeSetUserData(void *, void *);
int CVodeSetLinearSolver(void *, SUNLinearSolver, SUNMatrix);
int CVode(void *, double, N_Vector, double *, int);
int CVodeGetDky(void *, double, int, N_Vector);
enum { CV_ADAMS = 1, CV_ONE_STEP = 2 };

enum { Q, P, H, C, S, T, J, SIZE };
static const double ROUNDING = 0x1p-52, FAR_GOAL = 1e9;

typedef struct {
    double omega, zeta, delta0;
} Rotor;

typedef struct {
    Rotor rotor;
    double rtol, atol, duration, slack, time;
    double complex position, velocity; /* on the rotating axes */
    double *sample_times, *states, *event_times;
    signed char *event_kinds;
    int samples, sampled, events, room;
    SUNContext context;
    void *cvode;
    N_Vector state, tolerances, reading;
    SUNMatrix matrix;
    SUNLinearSolver linear;
    double low, point, before[SIZE]; /* the last step */
} Run;

static void stop(const char *message)
{
    fprintf(stderr, "%s\n", message);
    exit(1);
}

/* ---- flight ---------------------------------------------------------------------------- */

static double complex whirl(Rotor rotor)
{
    return rotor.omega == 0.0 ? 0.0 : -rotor.omega / CMPLX(rotor.omega, -2.0 * rotor.zeta);
}

static double drift(double tau, double zeta)
{
    double exponent = 2.0 * zeta * tau;
    return exponent < 1e-300 ? tau : -expm1(-exponent) / (2.0 * zeta);
}

static double complex turn_less_one(double angle)
{
    double half = sin(0.5 * angle);
    return CMPLX(-2.0 * half * half, sin(angle));
}

static void fly(double complex z0, double complex w0, double tau, Rotor rotor, double complex *z,
                double complex *v)
{
    double complex a = whirl(rotor), w = w0 - I * rotor.omega * a;
    double complex turn = CMPLX(cos(rotor.omega * tau), sin(rotor.omega * tau));
    double complex back = conj(turn);
    *z = (z0 + w * drift(tau, rotor.zeta) + a * turn_less_one(rotor.omega * tau)) * back;
    *v = (w * exp(-2.0 * rotor.zeta * tau) + I * rotor.omega * a * turn) * back;
}

static double majorant_root(double value, double slope, double curvature)
{
    double discriminant = slope * slope - 2.0 * curvature * value;
    if (discriminant < 0.0)
        return INFINITY;
    double root = sqrt(discriminant);
    if (slope >= 0.0)
        return slope + root > 0.0 ? -2.0 * value / (slope + root) : INFINITY;
    return curvature > 0.0 ? (root - slope) / curvature : INFINITY;
}

static double safe_step(double value, double slope, double curvature, double jerk, double reach)
{
    double low = fmin(reach, majorant_root(value, slope, curvature + jerk * reach)), high = reach;
    if (low >= reach)
        return reach;
    for (int k = 0; k < 6; k++) {
        double middle = high < 4.0 * low ? 0.5 * (low + high) : sqrt(low * high);
        double allowed = majorant_root(value, slope, curvature + jerk * middle);
        if (allowed >= middle) {
            low = middle;
        } else {
            high = middle;
            low = fmax(low, allowed);
        }
    }
    return low;
}

static double gap(double complex z0, double complex a, double complex w, double tau, Rotor rotor,
                  double *slope, double *bend)
{
    double omega = rotor.omega, decay = exp(-2.0 * rotor.zeta * tau);
    double complex turn = CMPLX(cos(omega * tau), sin(omega * tau));
    double complex z = z0 + w * drift(tau, rotor.zeta) + a * turn_less_one(omega * tau);
    double complex v = w * decay + I * omega * a * turn;
    double complex b = -2.0 * rotor.zeta * decay * w - omega * omega * a * turn;
    double radius = cabs(z);
    *slope = 2.0 * creal(conj(z) * v);
    *bend = 2.0 * (creal(conj(v) * v) + creal(conj(z) * b));
    return (radius - rotor.delta0) * (radius + rotor.delta0);
}

static double polish(double complex z0, double complex a, double complex w, double low,
                     double high, Rotor rotor)
{
    double tau = high, slope, bend;
    for (int k = 0; k < 80; k++) {
        double g = gap(z0, a, w, tau, rotor, &slope, &bend);
        if (g > 0.0)
            high = tau;
        else
            low = tau;
        double new = slope > 0.0 ? tau - g / slope : -INFINITY;
        if (!(low < new && new < high))
            new = 0.5 * (low + high);
        if (fabs(new - tau) <= ROUNDING * tau || high - low <= ROUNDING * high)
            return new;
        tau = new;
    }
    return tau;
}

static double first_touch(double complex z0, double complex w0, Rotor rotor, double limit)
{
    double omega = rotor.omega, zeta = rotor.zeta, delta0 = rotor.delta0, slope, bend;
    double complex a = whirl(rotor), w = w0 - I * omega * a;
    double size = cabs(a), speed0 = cabs(w), floor_ = 64.0 * ROUNDING * delta0 * (delta0 + size);
    double last_centre = cabs(z0 - a + w * drift(limit, zeta));
    double tau = 0.0, outside = 0.0, step = limit;
    while (tau < limit) {
        double g = gap(z0, a, w, tau, rotor, &slope, &bend);
        if (g <= 0.0)
            outside = tau;
        if (g - floor_ >= -0.25 * floor_) {
            double ignored, rate, root = polish(z0, a, w, outside, tau, rotor);
            gap(z0, a, w, root, rotor, &rate, &ignored);
            if (rate > 0.0)
                return root;
            step = 2.0 * sqrt(2.0 * floor_ / fmax(-bend, floor_)) + ROUNDING * tau;
        } else {
            double centre = fmax(cabs(z0 - a + w * drift(tau, zeta)), last_centre);
            if ((centre + size - delta0) * 2.0 * delta0 <= 0.5 * floor_)
                return INFINITY;
            double decayed = speed0 * exp(-2.0 * zeta * tau);
            double speed = decayed + omega * size;
            double acceleration = 2.0 * zeta * decayed + omega * omega * size;
            double third = 4.0 * zeta * zeta * decayed + omega * omega * omega * size;
            double jerk = 6.0 * speed * acceleration + 2.0 * delta0 * third;
            step = safe_step(g - floor_, slope, bend, jerk, fmin(4.0 * step, limit - tau));
        }
        tau += fmax(step, ROUNDING * tau);
    }
    return INFINITY;
}

/* ---- the record ------------------------------------------------------------------------ */

static double next_sample(const Run *run)
{
    return run->sampled < run->samples ? run->sample_times[run->sampled] : INFINITY;
}

static void take(Run *run, double complex z, double complex v)
{
    double angle = run->rotor.omega * run->sample_times[run->sampled];
    double complex turn = CMPLX(cos(angle), sin(angle));
    double *row = run->states + 4 * run->sampled++;
    z *= turn, v *= turn;
    row[0] = creal(z), row[1] = cimag(z), row[2] = creal(v), row[3] = cimag(v);
}

static void mark(Run *run, int kind)
{
    if (run->events == run->room) {
        run->room *= 2;
        run->event_times = realloc(run->event_times, run->room * sizeof(double));
        run->event_kinds = realloc(run->event_kinds, run->room);
    }
    run->event_times[run->events] = run->time;
    run->event_kinds[run->events++] = kind;
}

/* ---- contact --------------------------------------------------------------------------- */

static int field(double u, N_Vector state, N_Vector rate, void *data)
{
    const Rotor *rotor = data;
    const double *y = N_VGetArrayPointer(state);
    double *f = N_VGetArrayPointer(rate);
    double omega = rotor->omega, zeta = rotor->zeta, unbalance = omega * omega;
    double q = y[Q], radius = rotor->delta0 + q * q, spin = y[H] / (radius * radius);
    (void)u;
    f[Q] = 0.5 * y[P];
    f[P] = q * (y[H] * spin / radius - 2.0 * zeta * y[P] - q * q * q + unbalance * y[C]);
    f[H] = -q * (2.0 * zeta * y[H] + unbalance * radius * y[S]);
    f[C] = -q * y[S] * (spin - omega);
    f[S] = q * y[C] * (spin - omega);
    f[T] = q;
    f[J] = q * q * q * q;
    return 0;
}

static const double *at(Run *run, double point)
{
    if (point >= run->point)
        return N_VGetArrayPointer(run->state);
    if (point <= run->low)
        return run->before;
    if (CVodeGetDky(run->cvode, point, 0, run->reading) != 0)
        stop("CVodeGetDky failed");
    return N_VGetArrayPointer(run->reading);
}

/* Brent's method for y[which] = level between two points of the last step. */
static double root(Run *run, int which, double level, double a, double b)
{
    double fa = at(run, a)[which] - level, fb = at(run, b)[which] - level;
    double c = a, fc = fa, step = b - a, last = b - a;
    if (fa == 0.0)
        return a;
    if (fa * fb > 0.0)
        stop("a step holds no root");
    for (int k = 0; k < 200; k++) {
        if (fb * fc > 0.0)
            c = a, fc = fa, step = last = b - a;
        if (fabs(fc) < fabs(fb)) {
            a = b, b = c, c = a;
            fa = fb, fb = fc, fc = fa;
        }
        double tolerance = 2.0 * ROUNDING * fabs(b), half = 0.5 * (c - b);
        if (fabs(half) <= tolerance || fb == 0.0)
            break;
        if (fabs(last) < tolerance || fabs(fa) <= fabs(fb)) {
            step = last = half;
        } else {
            double s = fb / fa, p, q;
            if (a == c) {
                p = 2.0 * half * s, q = 1.0 - s;
            } else {
                double t = fa / fc, r = fb / fc;
                p = s * (2.0 * half * t * (t - r) - (b - a) * (r - 1.0));
                q = (t - 1.0) * (r - 1.0) * (s - 1.0);
            }
            if (p > 0.0)
                q = -q;
            else
                p = -p;
            if (2.0 * p < fmin(3.0 * half * q - fabs(tolerance * q), fabs(last * q)))
                last = step, step = p / q;
            else
                step = last = half;
        }
        a = b, fa = fb;
        b += fabs(step) > tolerance ? step : copysign(tolerance, half);
        fb = at(run, b)[which] - level;
    }
    return b;
}

static void cartesian(const double *y, double delta0, double complex *z, double complex *v)
{
    double complex direction = CMPLX(y[C], y[S]) / hypot(y[C], y[S]);
    double radius = delta0 + y[Q] * y[Q];
    *z = radius * direction;
    *v = CMPLX(y[P], y[H] / radius) * direction;
}

/* The point of the last step at a time: Newton's method, kept in a bracket. */
static void take_at(Run *run, double high, double time)
{
    double low = run->low, length = run->point - low;
    const double *before = run->before, *after = N_VGetArrayPointer(run->state), *y;
    double span = after[T] - before[T], part = (time - before[T]) / span;
    double point = low + length * part;
    if (before[Q] > 0.0 && after[Q] > 0.0) {
        double start = span / before[Q] - length, end = length - span / after[Q];
        point += part * (1.0 - part) * (start * (1.0 - part) + end * part);
    }
    point = fmin(fmax(point, low), high);
    y = at(run, point);
    for (int k = 0; k < 60; k++) {
        double late = y[T] - time;
        if (fabs(late) <= 4e-16 * fmax(1.0, time) || high - low <= 4e-16 * high)
            break;
        if (late > 0.0)
            high = point;
        else
            low = point;
        double new = y[Q] > 0.0 ? point - late / y[Q] : low;
        point = low < new && new < high ? new : 0.5 * (low + high);
        y = at(run, point);
    }
    double complex z, v;
    cartesian(y, run->rotor.delta0, &z, &v);
    take(run, z, v);
}

static void restart(Run *run, double contact_root)
{
    double complex direction = run->position / cabs(run->position);
    double complex along = run->velocity * conj(direction);
    double *y = N_VGetArrayPointer(run->state), *atol = N_VGetArrayPointer(run->tolerances);
    y[Q] = contact_root, y[P] = creal(along);
    y[H] = cimag(conj(run->position) * run->velocity);
    y[C] = creal(direction), y[S] = cimag(direction), y[T] = y[J] = 0.0;
    double size = fmax(y[Q], fabs(y[P]));
    double brief = y[P] < 0.0 && y[Q] > 0.0 ? y[Q] * y[Q] / -y[P] : size;
    for (int k = 0; k < SIZE; k++)
        atol[k] = run->atol;
    atol[Q] = atol[P] = fmax(run->rtol * size, 1e-16);
    atol[T] = atol[J] = fmax(run->rtol * brief, 1e-30);
    run->low = run->point = 0.0;
    if (CVodeReInit(run->cvode, 0.0, run->state) != 0 ||
        CVodeSVtolerances(run->cvode, run->rtol, run->tolerances) != 0)
        stop("CVODE could not be started");
}

/* Follow one contact to its exit or to the end of the run. */
static void follow_contact(Run *run, double contact_root)
{
    double began = run->time, duration = run->duration - began, peak = contact_root;
    double reached[SIZE], *y = N_VGetArrayPointer(run->state);
    int left = 0;
    restart(run, contact_root);
    while (!left) {
        memcpy(run->before, y, sizeof run->before);
        run->low = run->point;
        if (CVode(run->cvode, FAR_GOAL, run->state, &run->point, CV_ONE_STEP) < 0)
            stop("CVODE gave up");
        double end = run->point;
        memcpy(reached, y, sizeof reached);
        if (reached[Q] <= 0.0) {
            double inside = run->low, length = end - inside;
            while (at(run, inside)[Q] <= 0.0 && length > 1e-14 * end)
                inside = run->low + (length *= 0.125);
            end = root(run, Q, 0.0, inside, end), left = 1;
            memcpy(reached, at(run, end), sizeof reached);
            reached[Q] = 0.0;
        }
        if (reached[T] > duration + (left ? run->slack : 0.0)) {
            end = root(run, T, duration, run->low, end), left = 0;
            memcpy(reached, at(run, end), sizeof reached);
            reached[T] = duration;
        }
        if (run->before[P] > 0.0 && reached[P] < 0.0 &&
            run->before[Q] + run->before[P] * (end - run->low) > peak * (1.0 + 1e-13))
            peak = fmax(peak, at(run, root(run, P, 0.0, run->low, end))[Q]);
        peak = fmax(peak, reached[Q]);
        while (next_sample(run) - began <= reached[T])
            take_at(run, end, next_sample(run) - began);
        if (reached[T] >= duration)
            break;
    }
    cartesian(reached, run->rotor.delta0, &run->position, &run->velocity);
    run->time = reached[T] == duration ? run->duration : began + reached[T];
    if (left)
        mark(run, -1);
}

/* ---- the run --------------------------------------------------------------------------- */

static void open_run(Run *run)
{
    run->time = 0.0, run->sampled = run->events = 0, run->room = 64;
    run->sample_times = malloc(run->samples * sizeof(double));
    run->states = malloc(4 * run->samples * sizeof(double));
    run->event_times = malloc(run->room * sizeof(double));
    run->event_kinds = malloc(run->room);
    for (int k = 0; k < run->samples; k++)
        run->sample_times[k] = k * (run->duration / (run->samples - 1));
    run->sample_times[run->samples - 1] = run->duration;
    SUNContext_Create(0, &run->context);
    run->state = N_VNew_Serial(SIZE, run->context);
    run->tolerances = N_VNew_Serial(SIZE, run->context);
    run->reading = N_VNew_Serial(SIZE, run->context);
    for (int k = 0; k < SIZE; k++)
        N_VGetArrayPointer(run->state)[k] = N_VGetArrayPointer(run->tolerances)[k] = 1.0;
    run->cvode = CVodeCreate(CV_ADAMS, run->context);
    run->matrix = SUNDenseMatrix(SIZE, SIZE, run->context);
    run->linear = SUNLinSol_Dense(run->state, run->matrix, run->context);
    if (CVodeInit(run->cvode, field, 0.0, run->state) != 0 ||
        CVodeSVtolerances(run->cvode, run->rtol, run->tolerances) != 0 ||
        CVodeSetUserData(run->cvode, &run->rotor) != 0 ||
        CVodeSetLinearSolver(run->cvode, run->linear, run->matrix) != 0)
        stop("CVODE could not be made");
}

static void close_run(Run *run)
{
    CVodeFree(&run->cvode);
    SUNLinSolFree(run->linear);
    SUNMatDestroy(run->matrix);
    N_VDestroy(run->state), N_VDestroy(run->tolerances), N_VDestroy(run->reading);
    SUNContext_Free(&run->context);
    free(run->sample_times), free(run->states), free(run->event_times), free(run->event_kinds);
}

static void go(Run *run)
{
    Rotor rotor = run->rotor;
    double depth = cabs(run->position) - rotor.delta0;
    if (depth > 0.0)
        follow_contact(run, sqrt(depth));
    while (run->time < run->duration) {
        double complex z0 = run->position, w0 = run->velocity, z, v;
        double began = run->time, left = run->duration - began, limit = left + run->slack;
        double touch = first_touch(z0, w0, rotor, limit), span = touch <= limit ? touch : left;
        double until = span >= left ? run->duration : began + span;
        while (next_sample(run) <= until) {
            fly(z0, w0, next_sample(run) - began, rotor, &z, &v);
            take(run, z, v);
        }
        fly(z0, w0, span, rotor, &run->position, &run->velocity);
        run->time = until;
        if (touch > limit)
            break;
        run->position *= rotor.delta0 / cabs(run->position);
        mark(run, 1);
        follow_contact(run, 0.0);
    }
}

static double now(clockid_t clock)
{
    struct timespec moment;
    clock_gettime(clock, &moment);
    return moment.tv_sec + 1e-9 * moment.tv_nsec;
}

int main(int count, char **given)
{
    if (count != 13)
        stop("omega zeta delta0 x y vx vy duration samples step_rtol step_atol repetitions");
    double number[13];
    for (int k = 1; k < 13; k++)
        number[k] = strtod(given[k], NULL);
    for (int repetitions = number[12]; repetitions > 0; repetitions--) {
        double wall = now(CLOCK_MONOTONIC), cpu = now(CLOCK_PROCESS_CPUTIME_ID);
        Run run = {.rotor = {number[1], number[2], number[3]},
                   .position = CMPLX(number[4], number[5]),
                   .velocity = CMPLX(number[6], number[7]),
                   .duration = number[8],
                   .samples = number[9],
                   .rtol = number[10],
                   .atol = number[11]};
        open_run(&run);
        go(&run);
        wall = now(CLOCK_MONOTONIC) - wall, cpu = now(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        printf("seconds %.9f %.9f\n", wall, cpu);
        if (repetitions == 1) {
            for (int k = 0; k < run.events; k++)
                printf("event %.17g %d\n", run.event_times[k], run.event_kinds[k]);
            double *last = run.states + 4 * (run.sampled - 1);
            printf("sample %d %.17g %.17g\n", run.sampled, last[0], last[1]);
        }
        close_run(&run);
    }
    return 0;
}
