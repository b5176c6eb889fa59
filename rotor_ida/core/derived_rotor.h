/* Derived from rotor_ida/model/parameters.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_ROTOR_H
#define ROTOR_IDA_DERIVED_ROTOR_H

/* A rotor, and how its speed changes: at a rate, or by what a torque, which falls by a
 * slope with the speed, leaves against the reaction of the motion. Where it changes,
 * omega is that of the moment; else the last four are 0. */
struct rotor {
    double omega, zeta, delta0, shaft_stiffness, contact_exponent, contact_damping, load, friction, disc_radius;
    double rate, torque, slope, inverse_inertia;
};

#endif
