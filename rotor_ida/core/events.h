/* The event loop and its parts: how it begins (start.c), what it integrates (phases.c), and the
 * loop itself (events.c). */
#ifndef ROTOR_IDA_EVENTS_H
#define ROTOR_IDA_EVENTS_H

#include "observers.h"

/* The two integrations of a run: of contacts, and of displacement and velocity. CVODE's must not
 * move. */
struct motions {
    struct motion *contact, *free;
};

/* The largest indentation, or radius, of a phase so far, and when it was. */
struct peak {
    double values[MOST_VALUES];
    double time;
    double force; /* of a contact with damping the largest, which is not there */
};

enum where decide_mode(struct motion_of_centre start, const struct rotor *rotor);
/* Write the values with which a contact begins that may last for `left`, and tolerances of it. */
void begin_contact(struct motion_of_centre start, double left, const struct rotor *rotor,
                   double *values);
void contact_tolerances(const double *start, double rtol, double absolute, double *atol);
/* Put the unit matrix behind the values with which a motion begins, if it has tangents. */
void begin_differences(const struct motion *motion, double *start, double *atol);

/* Whether a contact of the whole model begins pressed or loose; and what it has lost. */
void begin_pressed(struct motion *motion, const double *start);
double lost_of(const struct motion *motion, const double *start, const double *values);
int integrate_contact(struct run *run, struct motion *motion, const double *start,
                      const double *atol, double *reached, struct peak *peak, int *left);
int follow_freely(struct run *run, struct motion *motion, struct peak *peak, int *touched);

/* A state on the rotating axes of a time. */
struct motion_of_centre motion_at(const double *state, double time, const struct rotor *rotor);
struct motion_of_centre where_it_is(const struct run *run);
int is_finite(const double *state);
void advance_run(struct run *run, double span, struct motion_of_centre centre);
int follow_events(struct run *run, const struct motions *motions);

#endif
