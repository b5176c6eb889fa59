/* A rotor system: many linear degrees of freedom, contacts at some of its nodes.
 *
 * Its coordinates y are such that the mass matrix is the unit matrix:
 *
 *     y'' + (C + Omega G) y' + (K + Omega' K_dot) y = unbalance + static force + contacts
 *
 * Rows and columns are padded with zeros to `stride`, four or a multiple of eight; matrices are
 * stored by columns. What is linear stands in system.c; what ends the mode of a contact in
 * system_guards.c, and what follows in system_contact.c; the growth of small changes in
 * system_tangent.c. */
#ifndef ROTOR_IDA_SYSTEM_H
#define ROTOR_IDA_SYSTEM_H

#include "core.h"

/* The law of a contact, and its race, of which the inverse inertia is 0 where there is none. */
struct system_law {
    double offset[2];
    double clearance, hertz, linear, contact_damping, friction, radius;
    double race_radius, inverse_race_inertia, race_drag;
    int64_t race; /* the same number for contacts that share a race */
};

/* How a contact goes on: `mode` as in core.h, the root of its indentation (with a linear spring the
 * indentation itself, see `is_spring`; so below in an episode), the speed of its race,
 * and the sense in which surfaces slide. */
struct system_touch {
    double root, race, sense;
    int32_t mode;
    int32_t zeros[3]; /* known zeros of its guards at this point: see system_guards.c */
};

/* The largest or smallest value so far, and its time. */
struct extreme {
    double value, time;
};

/* One episode of a contact; NaN where it began with the run, or has no end by its end. */
struct episode {
    double contact, entry, exit;
    struct extreme deepest, hardest; /* the root of its indentation, and its normal force */
    double impulse, work;            /* of the normal force */
    double heat, slip_distance, rolling_time;
};

/* The speed of a race so far. */
struct race {
    struct extreme largest, smallest;
};

/* Whether a rotor that a torque drives stands: its speed stays below a limit in size. */
struct standstill {
    double limit;       /* 0 where nobody asks */
    double since, rate; /* when it last fell below, NaN while it is above; its rate then */
    double longest;     /* the longest time below that has ended */
};

/* What a run has gained and lost so far: by the unbalance, to damping (with what gyroscopic
 * matrices that are not skew do, and the part of the stiffness that is skew), to the stiffness that
 * a changing speed adds, to the contacts, normally and tangentially, and to the bearings whose
 * coefficients change with the speed. */
struct ledger {
    double unbalance, damping, stiffness_rate, normal, tangential, bearings;
};

/* By how much the parts of a contact change with a parameter; its stiffness in parts of itself. */
struct law_change {
    double clearance, stiffness, contact_damping, friction;
};

/* By how much a system changes with a parameter. */
struct parameter {
    double speed;                      /* at all times the same */
    const double *stiffness, *damping; /* or NULL */
    const double *unbalance;           /* 2 rows; or NULL */
    const struct law_change *laws;     /* one a contact */
    const double *mass, *force;        /* or NULL */
};

/* An extremum of the distance of a place: 1 a maximum, -1 a minimum. */
struct extremum_of_place {
    double time, distance;
    int32_t place, kind;
};

/* A bearing or seal whose stiffness K and damping C change with the speed. From each knot to the
 * next they are cubics in the speed, from the knot on: rows of K_xx K_xy C_xx C_xy K_yx K_yy C_yx
 * C_yy, by the powers 0 to 3. */
enum { BEARING_POWERS = 4, BEARING_ENTRIES = 8 };
struct system_bearing {
    const double *rows; /* 2: its displacement by the coordinates */
    const double *knots, *cubics;
    int64_t knot_count;
    int64_t interval; /* in which the speed is; -1 or the last knot where it has left the table */
};

/* A place whose distance from a centre is observed. */
struct place {
    double centre[2];
    double sign;                   /* of the rate of its distance; 0 at first */
    struct extremum_of_place last; /* not in the table yet; its kind is 0 where there is none */
};

struct system_run {
    int64_t size, stride, contact_count;
    /* how many of the coordinates, the last, are of stators without mass: y' = -K y + contacts */
    int64_t massless;
    const double *stiffness, *damping, *gyroscopic, *stiffness_rate; /* or NULL */
    const double *circulation; /* the skew part of the stiffness, or NULL */
    const double *unbalance;   /* 2 rows: by the cosine and by the sine of the angle */
    const double *force;
    const double *rows; /* 2 a contact: its displacement by the coordinates */
    const struct system_law *laws;
    struct system_touch *touches;

    const struct piece *pieces;
    int64_t piece_count, piece;
    double inertia;                /* about the axis of rotation; 0 where the speed is prescribed */
    double weight[2];              /* moment of the unbalance's, by cosine and by minus sine */
    double rtol;                   /* of one step */
    double displacement, velocity; /* by which errors are measured */
    double fastest;                /* a bound of the system's own rates, without contacts */
    int64_t order;
    int64_t only_events; /* whether ledger, episodes and peaks are left as they are */
    double duration;
    const stop_flag *stop;

    double time, speed, angle;
    double piece_time, piece_angle; /* where the present piece of a prescribed speed began */
    double *state;                  /* two rows: y and y' */
    struct ledger ledger;
    struct standstill standstill;
    int32_t began; /* whether the modes of the contacts are decided */

    const double *sample_times;
    double *samples;       /* two rows each */
    double *sample_forces; /* 4 a contact: normal, tangential, slip, mode; NULL if not wanted */
    double *sample_turns;  /* 2 each: angle and speed */
    int64_t sample_count, sampled;
    double *event_times, *event_states, *event_turns; /* with 2 rows and the races; 2 */
    int32_t *event_kinds, *event_contacts;
    int64_t event_room, events;
    struct episode *episodes; /* with those that go on in the first rows of `open` */
    struct episode *open;     /* one a contact */
    struct race *races;       /* one a contact */
    int64_t episode_room, episode_count;
    int64_t steps;
    double *room; /* to work in */
    /* small changes of the start, side by side, and room for them: y, y' and races, a row each;
     * a multiple of eight; at a prescribed speed, without stators without mass */
    int64_t column_count;
    double *columns, *column_room;
    /* what parameters change besides, one a column from the first of these on */
    const struct parameter *parameters;
    int64_t parameter_count, first_of_parameters;
    int64_t method;                  /* while a contact touches, as in core.h */
    const struct sundials *sundials; /* NULL where series alone are wanted */
    double *cvode_room;
    const double *watched; /* rows by which samples see the columns */
    int64_t watched_count;
    double *sample_columns, *event_columns; /* one a row; 2 an event, of its contact */
    /* of the guards at events, by time; infinite where another event, or a piece, brings one about
     */
    double *event_rates;
    const double *place_rows; /* 2 a place: its displacement by the coordinates */
    struct place *places;
    int64_t place_count;
    struct extremum_of_place *extrema;
    int64_t extremum_room, extremum_count;
    struct system_bearing *bearings;
    int64_t bearing_count;
    double *bearing_room;
};

/* The stride of rows of a size. */
CORE_API int64_t core_system_stride(int64_t size);

/* How many doubles a run needs to work in. */
CORE_API int64_t core_system_room(int64_t size, int64_t contacts);

CORE_API int64_t core_system_column_room(int64_t size, int64_t contacts, int64_t columns);

CORE_API int64_t core_system_cvode_room(int64_t size, int64_t contacts);

CORE_API int64_t core_system_bearing_room(int64_t bearings, int64_t columns);

/* Follow a run to its end, as `core_run` does. FULL: with more room it goes on from where it is. */
CORE_API int core_system_run(struct system_run *run);

#endif
