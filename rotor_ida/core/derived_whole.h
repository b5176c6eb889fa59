/* Derived from rotor_ida/equations/modes.py by `python -m rotor_ida.equations.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_WHOLE_H
#define ROTOR_IDA_DERIVED_WHOLE_H

#include "core.h"

struct parameters {
    double omega, zeta, delta0, shaft_stiffness, contact_damping, load, hertz, linear, felt, pressed;
};

static inline struct parameters parameters_of(const struct rotor *rotor, double felt)
{
    return (struct parameters){rotor->omega, rotor->zeta, rotor->delta0, rotor->shaft_stiffness, rotor->contact_damping, rotor->load, rotor->contact_exponent > 1.0 ? 1.0 : 0.0, rotor->contact_exponent > 1.0 ? 0.0 : 1.0, felt, 1.0};
}

enum { PARAMETERS = 6 };
enum { CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_DOWN_R, CONTACT_DOWN_T, CONTACT_T, CONTACT_J, CONTACT_WORK, CONTACT_SPENT, CONTACT_SIZE };
enum { CONTACT_EXIT_GUARD = CONTACT_Q };
enum { CONTACT_EXTREMUM_GUARD = CONTACT_P };
enum { CARTESIAN_X, CARTESIAN_Y, CARTESIAN_VX, CARTESIAN_VY, CARTESIAN_DOWN_X, CARTESIAN_DOWN_Y, CARTESIAN_SIZE };

#endif
