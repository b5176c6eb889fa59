/* Derived from rotor_ida/model/modes.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_H
#define ROTOR_IDA_DERIVED_H

#include <math.h>

#include "core.h"

struct parameters {
    double omega, zeta, delta0, felt;
    double shaft_stiffness, contact_damping, load, hertz, linear, loose, friction, disc_radius, rim, sigma, rate, torque, slope, inverse_inertia; /* of other models */
};

static inline struct parameters parameters_of(const struct rotor *rotor, double felt)
{
    return (struct parameters){.omega = rotor->omega, .zeta = rotor->zeta, .delta0 = rotor->delta0, .felt = felt, .hertz = 1.0};
}

/* Whether a rotor is the paper's, but for friction, and its speed prescribed. */
static inline int is_plain(const struct parameters *m)
{
    return m->shaft_stiffness == 0.0 && m->contact_damping == 0.0 && m->load == 0.0 && m->hertz == 1.0 && m->linear == 0.0 && m->loose == 0.0 && m->torque == 0.0 && m->slope == 0.0 && m->inverse_inertia == 0.0;
}

/* The law of contact, by the root q of the indentation and the radial velocity. */

/* The elastic force. */
static inline double spring_of_root(const struct parameters *m, double q)
{
    (void)m;
    const double w0 = q * q;
    return w0 * q;
}

/* Its slope by the indentation. */
static inline double slope_of_root(const struct parameters *m, double q)
{
    (void)m;
    return 1.5 * q;
}

/* The elastic energy. */
static inline double energy_of_root(const struct parameters *m, double q)
{
    (void)m;
    const double w0 = q * q;
    const double w1 = w0 * w0;
    const double w2 = w1 * q;
    return 0.4 * w2;
}

/* The factor of contact damping, not clipped at 0. */
static inline double damping_factor(const struct parameters *m, double approach)
{
    (void)m;
    (void)approach;
    return 1.0;
}

/* The radial velocity of a release. */
static inline double release_velocity(const struct parameters *m)
{
    (void)m;
    return -(1.0) / (0.0);
}

/* The normal force, not clipped at 0. */
static inline double normal_force(const struct parameters *m, double q, double approach)
{
    (void)m;
    (void)approach;
    const double w0 = q * q;
    return w0 * q;
}

/* The rate of the normal force. */
static inline double rate_of_force(const struct parameters *m, double q, double approach, double of_q, double of_approach)
{
    (void)m;
    (void)approach;
    (void)of_approach;
    const double w0 = q * of_q;
    const double w1 = w0 * q;
    const double w2 = q * q;
    const double w3 = w2 * of_q;
    return 2.0 * w1 + w3;
}

/* The motion on the rotating axes: what a lane is given, and what follows. */
enum { LANE_X, LANE_Y, LANE_U, LANE_V, LANE_INVERSE, LANE_ROOT, LANE_APPROACH, LANE_DOWN_X, LANE_DOWN_Y, LANE_GIVEN };
/* Of approach, slip. */
static inline __attribute__((always_inline)) void motion_in_lane(
    const struct parameters *m, const double *state, double *answers)
{
    (void)m;
    const double x = state[LANE_X];
    const double y = state[LANE_Y];
    const double u = state[LANE_U];
    const double v = state[LANE_V];
    const double inverse = state[LANE_INVERSE];
    const double approach = fma(y, v, x * u) * inverse;
    const double slip = fma(-y, u, x * v) * inverse;
    answers[0] = approach;
    answers[1] = slip;
}
/* Of x, y, u, v. */
static inline __attribute__((always_inline)) void rates_in_lane(
    const struct parameters *m, const double *state, double *answers)
{
    const double x = state[LANE_X];
    const double y = state[LANE_Y];
    const double u = state[LANE_U];
    const double v = state[LANE_V];
    const double inverse = state[LANE_INVERSE];
    const double root = state[LANE_ROOT];
    const double push = root * root * root * inverse;
    answers[0] = fma(m->omega, y, u);
    answers[1] = fma(-m->omega, x, v);
    answers[2] = fma(m->omega, v, fma(-push, x, fma(-(2.0 * m->zeta), u, m->omega * m->omega)));
    answers[3] = fma(-m->omega, u, fma(-push, y, -2.0 * m->zeta * v));
}

enum { BY_OMEGA, BY_ZETA, BY_DELTA0, PARAMETERS };
enum { CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_T, CONTACT_J, CONTACT_SIZE };
enum { CONTACT_EXIT_GUARD = CONTACT_Q };
enum { CONTACT_EXTREMUM_GUARD = CONTACT_P };
enum { CARTESIAN_X, CARTESIAN_Y, CARTESIAN_VX, CARTESIAN_VY, CARTESIAN_SIZE };
/* Products of a series, and series that differences are multiplied by, at most. */
enum { SERIES_PRODUCTS = 16, SERIES_FACTORS = 4 };
enum { BY_SHAFT_STIFFNESS = 0, BY_CONTACT_DAMPING = 0, BY_LOAD = 0, BY_FRICTION = 0, BY_DISC_RADIUS = 0, CONTACT_DOWN_R = 0, CONTACT_DOWN_T = 0, CONTACT_WORK = 0, CONTACT_SPENT = 0, CONTACT_SPEED = 0, CONTACT_ANGLE = 0, CARTESIAN_DOWN_X = 0, CARTESIAN_DOWN_Y = 0, CARTESIAN_SPEED = 0, CARTESIAN_ANGLE = 0, RUB_Q = 0, RUB_P = 0, RUB_SLIP = 0, RUB_C = 0, RUB_S = 0, RUB_DOWN_R = 0, RUB_DOWN_T = 0, RUB_T = 0, RUB_J = 0, RUB_WORK = 0, RUB_SPENT = 0, RUB_HEAT = 0, RUB_SIZE = 0, RUB_EXIT_GUARD = 0, RUB_EXTREMUM_GUARD = 0, RUB_ROLL_GUARD = 0, RUB_SPEED = 0, RUB_ANGLE = 0, ROLLING_Q = 0, ROLLING_P = 0, ROLLING_SLIP = 0, ROLLING_C = 0, ROLLING_S = 0, ROLLING_DOWN_R = 0, ROLLING_DOWN_T = 0, ROLLING_T = 0, ROLLING_J = 0, ROLLING_WORK = 0, ROLLING_SPENT = 0, ROLLING_HEAT = 0, ROLLING_SIZE = 0, ROLLING_EXIT_GUARD = 0, ROLLING_EXTREMUM_GUARD = 0, ROLLING_SPEED = 0, ROLLING_ANGLE = 0 }; /* of other models */

#endif
