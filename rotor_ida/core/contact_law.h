/* The law of contact: Hertz's force q**3, or a linear one q**2, of the indentation q**2. */
#ifndef ROTOR_IDA_CONTACT_LAW_H
#define ROTOR_IDA_CONTACT_LAW_H

#include "core.h"
#include DERIVED_HEADER

/* The force of the spring of the contact. */
static inline double spring_force(const struct parameters *m, double q)
{
    return q * q * (m->hertz * q + m->linear);
}

/* Its derivative by the indentation. */
static inline double spring_stiffness(const struct parameters *m, double q)
{
    return 1.5 * m->hertz * q + m->linear;
}

/* The energy that it holds. */
static inline double spring_energy(const struct parameters *m, double q)
{
    const double square = q * q;
    return square * square * (m->hertz * q * 0.4 + m->linear * 0.5);
}

/* The factor of contact damping on the force at a radial velocity: 1 + c d', not clipped at 0. */
static inline double damping_factor(const struct parameters *m, double velocity)
{
    return 1.0 + m->contact_damping * velocity;
}

#endif
