/* A flight as the search for its first touch, and for where its radius turns, needs it.
 *
 * The closed form of the motion differs without shaft and load (plain_flight.h) and with them
 * (sprung_flight.h). Both say where the flight is, and bound how fast that can change. */
#ifndef ROTOR_IDA_PATH_H
#define ROTOR_IDA_PATH_H

#include "flight.h"

/* What a motion answers: C to a unit displacement, S to a unit impulse, Q to a unit step and P to
 * exp(i omega tau), with the rates of change of C, S and P; and exp(i omega tau). Q is looked at
 * where there is a load, or no spin; Q and P with a shaft or a load. */
struct answers {
    double c, c_rate, s, s_rate, q;
    struct vector p, p_rate, turn;
};

/* Displacement, velocity and acceleration on axes that stand still. */
struct place {
    struct vector z, v, b;
    struct vector turn; /* of the unbalance since the start */
};

struct path {
    struct motion_of_centre start;
    const struct rotor *rotor;
    double limit;
    double floor;   /* the smallest |z|**2 - delta0**2 that stands clear of rounding */
    double longest; /* no step is longer */
    double widest;  /* the size of the displacement, for rounding */
    /* without shaft and load: the whirl, the drift, and how far out that ends at the limit */
    struct vector whirl, drift;
    double last_centre;
    /* with them: where it is, at the time that was looked at last, and the largest speed so far */
    struct place at;
    double fastest;
};

/* g = |z|**2 - delta0**2 and its first two derivatives. */
struct gap {
    double value, slope, bend;
};

/* The first s > 0 with value + slope s + curvature s**2/2 = 0, value < 0; infinite for none. */
static inline double first_root_of_majorant(double value, double slope, double curvature)
{
    const double discriminant = slope * slope - 2.0 * curvature * value;
    if (discriminant < 0.0)
        return INFINITY;
    const double root = sqrt(discriminant);
    if (slope >= 0.0)
        return slope + root > 0.0 ? -2.0 * value / (slope + root) : INFINITY;
    return curvature > 0.0 ? (root - slope) / curvature : INFINITY;
}

#endif
