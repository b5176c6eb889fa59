/* What watches a run and writes down what it was asked for; see observers.c. */
#ifndef ROTOR_IDA_OBSERVERS_H
#define ROTOR_IDA_OBSERVERS_H

#include "motion.h"

enum { EVENTS_A_CONTACT = 2 };

/* A stretch of flight: from where, and for how long. */
struct flight {
    struct motion_of_centre start;
    double span;
};

/* The part of the last step of a motion that belongs to the run: up to `end`, where its values are
 * `reached`, and the time since the beginning of the phase is `until`. */
struct step {
    struct motion *motion;
    double end, until;
    const double *reached;
};

double time_left(const struct run *run);
/* The same until a phase has to end: there a prescribed rate may change. */
double phase_left(const struct run *run);

/* Begin and end a run: report samples at its start, and at its end. */
void observe_start(struct run *run);
void observe_end(struct run *run);
/* Watch a flight, and a step in contact or of a flight that is integrated. */
void observe_flight(struct run *run, const struct flight *flight);
int observe_step(struct run *run, const struct step *step);
/* Move a bundle over a flight, and over a step of a motion whose differences begin anew with it. */
void carry_over_flight(struct run *run, const struct flight *flight);
void carry_over_step(struct run *run, const struct step *step);
/* Carry differences over a contact that has been followed as one. */
void observe_phase(struct run *run, struct motion *motion, const double *start,
                   const double *reached);
/* What a jump of the tangential force makes of differences, where surfaces that slid in a sense, or
 * did not (0), begin to roll or to slide the other way. */
void observe_jump(struct run *run, const struct motion *motion, double sense, const double *values);

void record_event(struct run *run, enum event kind);
/* The same inside a phase, at a time since its beginning. */
void record_event_inside(struct run *run, enum event kind, double since,
                         struct motion_of_centre centre);

/* Displacement and velocity on the rotating axes of the state of a motion. */
struct motion_of_centre centre_of(const struct motion *motion, const double *values);

double contact_root_of(const double *values);
double radial_velocity_of(const double *values);
double time_of(const double *values);
double radial_rate_of(const double *values);
double squared_radius_of(const double *values);

#endif
