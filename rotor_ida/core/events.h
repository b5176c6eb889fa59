/* The event loop and its parts: how it begins (start.c), what it integrates (contact_phase.c and
 * free_phase.c), what changes the mode of a contact (guards.c finds the place, contact_modes.c says
 * what follows, also at a start, a release and a press), whether a speed can be followed
 * (speed_limits.c), whether a contact balances (balance.c), and the loop itself (events.c). */
#ifndef ROTOR_IDA_EVENTS_H
#define ROTOR_IDA_EVENTS_H

#include "observers.h"

/* A rise by less than this part is rounding. */
static const double LEAST_RISE = 1e-13;
/* Most points of a step at which a largest force, or a least margin, is sought. */
enum { MOST_NARROWING = 60 };

/* Asked before each step: whether the caller stops the run, or it is out of steps. */
static inline int allow_step(struct run *run)
{
    if (asked_to_stop(run->stop))
        return STOPPED;
    run->steps++;
    return run->most_steps > 0 && run->steps > run->most_steps ? OUT_OF_STEPS : DONE;
}

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
    double slid;  /* of a contact with friction: how far its surfaces have slid */
};

enum where decide_mode(struct motion_of_centre start, const struct rotor *rotor);
/* Write the values with which a contact begins that may last for `left`, and tolerances of it. */
void begin_contact(struct motion_of_centre start, double left, const struct rotor *rotor,
                   double *values);
void contact_tolerances(const double *start, double rtol, double absolute, double *atol);
/* Put the unit matrix behind the values with which a motion begins, if it has tangents. */
void begin_differences(const struct motion *motion, double *start, double *atol);

/* The force and the energy of a contact (balance.c): keep its largest force, in a step up to `end`;
 * what it has lost to contact damping; and whether its energy balances. */
void raise_force(struct peak *peak, struct motion *motion, double end, const double *reached);
double lost_of(const struct motion *motion, const double *start, const double *values);
int is_balanced(const struct motion *motion, double absolute, const double *start,
                const double *deepest, const double *reached, int64_t steps);
/* The heat of sliding in a contact. */
double heat_of(const struct motion *motion, const double *values);
/* A change of the mode of a contact: where in the last step, and what says so. */
struct change {
    double point;
    enum guard guard;
};
static const struct change NO_CHANGE = {INFINITY, RELEASE_OR_PRESS};

/* The first of them in the last step, up to `end`: infinite where there is none, NaN where it
 * cannot be found (guards.c). */
struct change change_in_step(struct motion *motion, double end);
/* The slip below which rounding hides it. */
double hidden_slip(const struct motion *motion, const double *values);

/* Decide whether a contact begins loose (contact_modes.c). */
void decide_looseness(struct motion *motion, const double *start);
/* Go on as follows from what happened; return what it is called, or 0 (contact_modes.c). */
int pass_guard(struct motion *motion, enum guard guard, double *values);
/* Begin a contact with friction, if there is any; and decide how it goes on. */
void begin_with_friction(struct motion *motion, double *start, double *atol);
void decide_friction(struct motion *motion, double *values);
enum contact_mode contact_mode_of(const struct motion *motion);
/* Write down how a contact goes on from the last event, or from the start; and with it what has
 * happened. Where the mode ended where it began (`is_none`) nothing is recorded but how it goes on,
 * except to put right an event at the same time. */
void record_mode(struct run *run, const struct motion *motion);
void record_change(struct run *run, const struct motion *motion, int kind, int is_none,
                   const double *values);
int integrate_contact(struct run *run, struct motion *motion, const double *start,
                      const double *atol, double *reached, struct peak *peak, int *left);
int follow_freely(struct run *run, struct motion *motion, struct peak *peak, int *touched);

/* Whether the speed falls below 0 in the last step up to `end`, which then ends there, or has run
 * away (speed_limits.c). */
int check_speed(struct motion *motion, double *end, double *reached);

/* Let the speed change as the present piece has it. */
void begin_piece(struct run *run);

/* A state on the rotating axes of a time. */
struct motion_of_centre motion_at(const double *state, double time, const struct rotor *rotor);
struct motion_of_centre where_it_is(const struct run *run);
int is_finite(const double *state);
void advance_run(struct run *run, double span, struct motion_of_centre centre);
int follow_events(struct run *run, const struct motions *motions);

#endif
