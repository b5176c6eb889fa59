/* Derived from rotor_ida/model/modes.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_H
#define ROTOR_IDA_DERIVED_H

#include "core.h"

struct parameters {
    double omega, zeta, delta0, felt;
};

static inline struct parameters parameters_of(const struct rotor *rotor, double felt)
{
    return (struct parameters){rotor->omega, rotor->zeta, rotor->delta0, felt};
}

enum { BY_OMEGA, BY_ZETA, BY_DELTA0, PARAMETERS };
enum { CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_T, CONTACT_J, CONTACT_SIZE };
enum { CONTACT_EXIT_GUARD = CONTACT_Q };
enum { CONTACT_EXTREMUM_GUARD = CONTACT_P };
enum { CARTESIAN_X, CARTESIAN_Y, CARTESIAN_VX, CARTESIAN_VY, CARTESIAN_SIZE };

#endif
