/* Flight inside the clearance, in closed form; see flight.c. */
#ifndef ROTOR_IDA_FLIGHT_H
#define ROTOR_IDA_FLIGHT_H

#include <math.h>
#include <stdint.h>

#include "core.h"

#define ROUNDING 0x1p-52

/* A vector in the plane: with i for a quarter turn, a complex number. */
struct vector {
    double x, y;
};

static inline struct vector plus(struct vector a, struct vector b)
{
    return (struct vector){a.x + b.x, a.y + b.y};
}

static inline struct vector scaled(double factor, struct vector a)
{
    return (struct vector){factor * a.x, factor * a.y};
}

/* Fused in the source: gcc 12 fuses one half of such a product, whatever it is told. */
static inline struct vector product(struct vector a, struct vector b)
{
    return (struct vector){fma(a.x, b.x, -(a.y * b.y)), fma(a.x, b.y, a.y * b.x)};
}

static inline struct vector mirrored(struct vector a) { return (struct vector){a.x, -a.y}; }

static inline struct vector quarter_turned(struct vector a) { return (struct vector){-a.y, a.x}; }

static inline double dot(struct vector a, struct vector b) { return a.x * b.x + a.y * b.y; }

static inline double cross(struct vector a, struct vector b) { return a.x * b.y - a.y * b.x; }

static inline double length(struct vector a) { return sqrt(a.x * a.x + a.y * a.y); }

/* Displacement and velocity, read on the rotating axes of the moment. */
struct motion_of_centre {
    struct vector z, w;
    struct vector down;  /* where a load points */
    double speed, angle; /* of the rotor; the angle since the phase began */
};

/* r r', or twice that, and its rate of change. */
struct turning {
    double rate, bend;
};

/* The larger and the smaller of two numbers, the second where one is NaN. */
static inline double larger(double a, double b) { return a > b ? a : b; }
static inline double smaller(double a, double b) { return a < b ? a : b; }

/* a to a power, of a from 0 on: to some rounding errors, the same ones on every system. */
static inline double to_power(double a, double power) { return exp(power * log(a)); }

struct motion_of_centre fly(struct motion_of_centre start, double tau, const struct rotor *rotor);

/* What omega (first), and what zeta adds to the motion after `tau`: derivatives of `fly`. */
void fly_by_parameters(struct motion_of_centre start, double tau, const struct rotor *rotor,
                       struct motion_of_centre added[2]);

/* Move differences, rows of four numbers, by a flight. */
void fly_differences(double *rows, int count, double tau, const struct rotor *rotor);

/* The time to the first touch of the ring; infinite if none comes by `limit`, or asked to stop; NaN
 * where the search gets nowhere. */
double first_touch(struct motion_of_centre start, const struct rotor *rotor, double limit,
                   const stop_flag *stop);

/* The first time after `from` at which the radius of a flight turns; infinite if it does not by
 * `limit`, or asked to stop. `rising` is 1 or -1 where the radius rises or falls before it; 0 at
 * the start of a flight. */
double next_turn(struct motion_of_centre start, const struct rotor *rotor, double from,
                 double limit, double *rising, const stop_flag *stop);

#endif
