/* Derived from rotor_ida/model/spinning.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_RUN_UP_H
#define ROTOR_IDA_DERIVED_RUN_UP_H

#include <math.h>

#include "core.h"

struct parameters {
    double zeta, delta0, shaft_stiffness, contact_damping, load, hertz, linear, felt, loose, friction, disc_radius, sigma, rate, torque, slope, inverse_inertia;
    double omega, rim; /* of other models */
};

static inline struct parameters parameters_of(const struct rotor *rotor, double felt)
{
    return (struct parameters){.zeta = rotor->zeta, .delta0 = rotor->delta0, .shaft_stiffness = rotor->shaft_stiffness, .contact_damping = rotor->contact_damping, .load = rotor->load, .hertz = rotor->contact_exponent > 1.0 ? 1.0 : 0.0, .linear = rotor->contact_exponent > 1.0 ? 0.0 : 1.0, .felt = felt, .loose = 0.0, .friction = rotor->friction, .disc_radius = rotor->disc_radius, .sigma = 0.0, .rate = rotor->rate, .torque = rotor->torque, .slope = rotor->slope, .inverse_inertia = rotor->inverse_inertia};
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
    const double w0 = q * q;
    return (m->hertz * q + m->linear) * w0;
}

/* Its slope by the indentation. */
static inline double slope_of_root(const struct parameters *m, double q)
{
    return 1.5 * m->hertz * q + m->linear;
}

/* The elastic energy. */
static inline double energy_of_root(const struct parameters *m, double q)
{
    const double w0 = q * q;
    const double w1 = w0 * w0;
    return (0.4 * m->hertz * q + 0.5 * m->linear) * w1;
}

/* The factor of contact damping, not clipped at 0. */
static inline double damping_factor(const struct parameters *m, double approach)
{
    return 1.0 + m->contact_damping * approach;
}

/* The radial velocity of a release. */
static inline double release_velocity(const struct parameters *m)
{
    return -(1.0) / (m->contact_damping);
}

/* The normal force, not clipped at 0. */
static inline double normal_force(const struct parameters *m, double q, double approach)
{
    const double w0 = q * q;
    const double w1 = (m->hertz * q + m->linear) * w0;
    const double w2 = w1 * (1.0 + m->contact_damping * approach);
    return (1.0 - m->loose) * w2;
}

/* The rate of the normal force. */
static inline double rate_of_force(const struct parameters *m, double q, double approach, double of_q, double of_approach)
{
    const double w0 = m->hertz * q + m->linear;
    const double w1 = q * of_q;
    const double w2 = w0 * w1;
    const double w3 = q * q;
    const double w4 = w3 * of_q;
    const double w5 = (2.0 * w2 + m->hertz * w4) * (m->contact_damping * approach + 1.0);
    const double w6 = w0 * w3;
    const double w7 = w6 * of_approach;
    return (1.0 - m->loose) * w5 + (1.0 - m->loose) * m->contact_damping * w7;
}

enum { CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_DOWN_R, CONTACT_DOWN_T, CONTACT_SPEED, CONTACT_T, CONTACT_ANGLE, CONTACT_J, CONTACT_WORK, CONTACT_SPENT, CONTACT_SIZE };
enum { CONTACT_EXIT_GUARD = CONTACT_Q };
enum { CONTACT_EXTREMUM_GUARD = CONTACT_P };
enum { CARTESIAN_X, CARTESIAN_Y, CARTESIAN_VX, CARTESIAN_VY, CARTESIAN_DOWN_X, CARTESIAN_DOWN_Y, CARTESIAN_SPEED, CARTESIAN_ANGLE, CARTESIAN_SIZE };
enum { RUB_Q, RUB_P, RUB_SLIP, RUB_C, RUB_S, RUB_DOWN_R, RUB_DOWN_T, RUB_SPEED, RUB_T, RUB_ANGLE, RUB_J, RUB_WORK, RUB_SPENT, RUB_HEAT, RUB_SIZE };
enum { RUB_EXIT_GUARD = RUB_Q };
enum { RUB_EXTREMUM_GUARD = RUB_P };
enum { RUB_ROLL_GUARD = RUB_SLIP };
enum { ROLLING_Q, ROLLING_P, ROLLING_SLIP, ROLLING_C, ROLLING_S, ROLLING_DOWN_R, ROLLING_DOWN_T, ROLLING_SPEED, ROLLING_T, ROLLING_ANGLE, ROLLING_J, ROLLING_WORK, ROLLING_SPENT, ROLLING_HEAT, ROLLING_SIZE };
enum { ROLLING_EXIT_GUARD = ROLLING_Q };
enum { ROLLING_EXTREMUM_GUARD = ROLLING_P };
/* Products of a series, and series that differences are multiplied by, at most. */
enum { SERIES_PRODUCTS = 32, SERIES_FACTORS = 1 };
enum { PARAMETERS = 1 };
enum { BY_OMEGA = 0, BY_ZETA = 0, BY_DELTA0 = 0, BY_SHAFT_STIFFNESS = 0, BY_CONTACT_DAMPING = 0, BY_LOAD = 0, BY_FRICTION = 0, BY_DISC_RADIUS = 0 }; /* of other models */

#endif
