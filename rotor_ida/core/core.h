/* What the core offers to Python.
 *
 * Every function fills memory that its caller owns, and keeps nothing between calls. Those that may
 * last look at the byte `stop` often enough to end within a second after that is set; those that
 * follow a motion return a `status`. */
#ifndef ROTOR_IDA_CORE_H
#define ROTOR_IDA_CORE_H

#include <stdatomic.h>
#include <stdint.h>

#include "derived_rotor.h"
#include "model.h"

/* What the library shows to others; all else is hidden. */
#define CORE_API __attribute__((visibility("default")))

/* A byte by which another thread asks a call to stop, by anything but 0. */
typedef _Atomic uint8_t stop_flag;

static inline int asked_to_stop(const stop_flag *stop)
{
    return atomic_load_explicit(stop, memory_order_relaxed) != 0;
}

/* How a call ended; the flags of SUNDIALS are negative. core/interface.py says each in words. A
 * user never sees FULL or FULL_INSIDE: Python gives the tables more room and calls again. */
enum status {
    DONE = 0,            /* so far without trouble; of a run that has returned: at its duration. So
                          * ends too a run of a system that Python stops as it has seen enough */
    NOT_FINITE = 1001,   /* a number is NaN or infinite */
    NO_ROOT = 1002,      /* of one disc: an event was seen, but its root could not be found */
    STUCK = 1003,        /* the time no longer advances */
    STOPPED = 1004,      /* by the caller */
    FULL = 1005,         /* a table is full between two events: the caller goes on from there with
                          * more room; if it is that of one disc's extrema, it begins anew */
    NO_SOLVER = 1006,    /* CVODE could not be opened */
    FULL_INSIDE = 1007,  /* of one disc: it is full within a contact: the caller begins anew */
    UNBALANCED = 1008,   /* of one disc: the energy of a contact does not balance */
    STALLED = 1009,      /* of one disc: the speed fell through 0, where the torque turns no more */
    RUNAWAY = 1010,      /* of one disc: the torque lets the speed run away */
    SINGULAR = 1011,     /* of a system: no forces are determined that let its contacts roll */
    OUT_OF_STEPS = 1012, /* of one disc: it has taken as many steps as its caller allows */
    UNBOUNDED = 1013,    /* of a system: nothing bounds its motion, which grows */
    OUT_OF_TABLE = 1014  /* of a system: the speed leaves the table of a bearing */
};

/* How a speed changes up to a time. At its beginning a prescribed one is `speed`. */
struct piece {
    double end, rate, torque, slope, inverse_inertia, speed;
};

/* Who compiled this library, with which flags, for which processors, for which model, from which
 * sources, for which version of the package. */
CORE_API const char *core_compiler(void);
CORE_API const char *core_flags(void);
CORE_API const char *core_level(void);
CORE_API const char *core_model(void);
CORE_API const char *core_sources(void);
CORE_API const char *core_version(void);
/* The widest level whose instructions this processor and its system offer: see LEVELS in Python. */
CORE_API int core_widest_level(void);

/* The functions of SUNDIALS that the core calls, found by Python in the libraries of scikit-sundae;
 * their objects are addresses. An index is passed in 64 bits, which the calling conventions of
 * x86-64 and AArch64 let stand for one of 32. */
struct sundials {
    int (*context_new)(int communicator, void **context);
    int (*context_free)(void **context);
    int (*handlers_clear)(void *context);
    void *(*vector_over)(int64_t size, double *data, void *context);
    int (*vector_fuse)(void *vector, int on);
    void (*vector_free)(void *vector);
    double *(*vector_data)(void *vector);
    void *(*matrix_new)(int64_t rows, int64_t columns, void *context);
    void (*matrix_free)(void *matrix);
    double *(*matrix_data)(void *matrix);
    void *(*linear_new)(void *vector, void *matrix, void *context);
    int (*linear_free)(void *linear);
    void *(*create)(int method, void *context);
    void (*free)(void **memory);
    int (*init)(void *memory, int (*field)(double, void *, void *, void *), double, void *state);
    int (*reinit)(void *memory, double point, void *state);
    int (*tolerances)(void *memory, double rtol, void *atol);
    int (*weigh_by)(void *memory, int (*weights)(void *state, void *weights, void *user));
    int (*user_data)(void *memory, void *user);
    int (*linear_use)(void *memory, void *linear, void *matrix);
    int (*jacobian)(void *memory, int (*jacobian)(double, void *, void *, void *, void *, void *,
                                                  void *, void *));
    int (*solve)(void *memory, double goal, void *state, double *reached, int task);
    int (*derivative)(void *memory, double point, int order, void *vector);
    int (*last_order)(void *memory, int *order);
    int (*evaluations)(void *memory, long *count);
};

enum method { TAYLOR = 0, ADAMS = 1, BDF = 2 };
enum where { UNDECIDED = -1, IN_FLIGHT = 0, IN_CONTACT = 1 };
/* At EXIT the surfaces part; at RELEASE they overlap still, but contact damping has brought the
 * force to 0 and they are loose, until PRESS or EXIT. */
enum event { ENTRY = 1, EXIT = -1, ROLL = 2, SLIP = -2, REVERSE = 3, PRESS = 4, RELEASE = -4 };
/* The mode of a contact: sliding, by its sense, 1 or -1, or else. */
enum contact_mode {
    FLIES = 0,
    SLIDES_FORWARDS = 1,
    SLIDES_BACKWARDS = -1,
    ROLLS = 2,
    IS_LOOSE = 3
};

/* One contact; NaN where it began with the run, or has no end by its end. */
struct contact {
    double entry, exit, peak_time;
    double peak_root; /* of the largest indentation */
    double impulse, momentum;
    double lost; /* energy, to contact damping */
    double largest_force;
    double heat, slip_distance; /* of sliding */
};

/* An extremum of the radius: a maximum, 1, or a minimum, -1. */
struct extremum {
    double time, radius, kind, state[4];
};

/* One run: what is asked, where it stands, and what is recorded of it.
 *
 * Every state is (x, y, vx, vy), read on the rotating axes of its time. Once the run is over, those
 * of samples and events and the last one are turned to axes that stand still, if so asked. A table
 * that is not wanted has no room. */
struct run {
    struct rotor rotor;
    double rtol, atol;      /* of one step */
    double duration, slack; /* time to simulate, and how far after it an event may lie */
    int32_t fixed_axes; /* whether all that is reported is to be read on axes that stand still */
    int32_t method;     /* of contacts; and of flight, where that is not exact, if CVODE's */
    int32_t exact_flight;
    int32_t began; /* where it began: written */
    const stop_flag *stop;
    const struct sundials *sundials; /* NULL where Taylor series alone are wanted */

    double time, state[4];
    double shift; /* how long before time 0 the axes began to turn: a load has turned with them */
    int32_t where;
    int32_t differences; /* rows of `bundle`: 0, 4, or 7 (whole: 12) with parameters */
    double *bundle;      /* differences from the motion, carried along; read like a state */

    const double *sample_times;
    double *samples; /* rows of 4 */
    int64_t sample_count, sampled;
    double *event_times, *event_states; /* rows of 4 */
    int8_t *event_kinds;
    int8_t *event_modes; /* with friction: how it moves from each event on */
    int64_t event_room, events;
    struct contact *contacts;
    int64_t contact_room, contact_count;
    struct extremum *extrema;
    int64_t extremum_room, extremum_count;
    int64_t evaluations;
    int64_t steps, most_steps; /* of the solver, and flights in closed form; 0 for any number */
    int32_t mode_began;        /* with friction: how it moved at its start: written */
    int32_t flattened;         /* whether rolling has taken a dimension from the bundle: written */
    double volume_lost;        /* logarithm of what reversals have left of its volume: written */

    /* Where the speed changes, and looked at there alone: in which piece it is, the angle of the
     * unbalance, and tables of angle and speed at samples and events. */
    const struct piece *pieces;
    int64_t piece_count, piece;
    double angle;
    double *sample_turns, *event_turns; /* rows of 2 */
};

/* Follow a run from where it stands to its end.
 *
 * FULL: a table has no room for what may come. With more room in the tables of events and contacts
 * the run goes on from where it stands; where that of extrema is full, or that of events inside a
 * contact (FULL_INSIDE), it must begin anew. */
CORE_API int core_run(struct run *run);

/* Follow a run over many spans of its duration, each from where the one before ended, and write
 * into each row of `stretches` the logarithms of the factors by which a span has stretched the four
 * differences of its bundle, which are made orthonormal after each; and of that by which reversals
 * have changed their volume. Where the disc has rolled the last of the four is lost, of which the
 * logarithm is that of 0, and another takes its place. */
enum { STRETCH_COLUMNS = 5 };
CORE_API int core_stretch(struct run *run, int64_t spans, double *stretches, int64_t *done);

/* Whether a rotor at a state begins in contact. */
CORE_API int core_starts_in_contact(const struct rotor *rotor, const double state[4]);

/* The states that follow on some states after as many flights without contact. */
CORE_API void core_fly(const struct rotor *rotor, const double *states, const double *spans,
                       double *reached, int64_t count);

/* The time to the first touch of the ring from a state in flight; infinite if none comes by
 * `limit`, NaN where the search gets nowhere. */
CORE_API double core_first_touch(const struct rotor *rotor, const double state[4], double limit,
                                 const stop_flag *stop);

/* Turn rows of (x, y, vx, vy) by the angles omega t. */
CORE_API void core_rotate(double *states, const double *times, double omega, int64_t count);

/* How a run can contradict the mechanics. */
enum fault {
    SOUND,
    EVENT_NOT_FINITE,
    BACKWARDS,
    NOT_IN_TURN,
    OFF_THE_RING,
    SAMPLE_NOT_FINITE,
    WRONG_SIDE_OF_THE_RING,
    TENSILE,
    SLIDES_ASTRAY,
    SLIPS_WHILE_ROLLING,
    PEAKS_OUTSIDE
};

/* The first fault of the events, samples and contacts of a run, and its row in that table: times
 * increase; entry and exit alternate; they lie on the ring but for rounding; samples lie on their
 * side of it but for `allowed`, and the normal force of those not loose is not below 0, nor
 * absent where it would not be; and contacts peak in their own span. */
CORE_API int core_fault(const struct run *run, double allowed, int64_t *row);

/* Follow many starts on the rotating axes until an attractor holds them or `duration` has passed.
 * The states, 4 rows of `count`, become those at the end; the time that each took is added. A label
 * becomes the number of the trapping region, `region_count` for a whirl that never touches the ring
 * again, one more for fading touches, from two more on that of the limit cycle, or -1; starts with
 * a label of 0 or more are left alone. A region is 4 + 10 numbers, `free_whirl` and a section are
 * as in `rotor_ida.basins.kernel`. */
CORE_API int core_follow_lanes(const struct rotor *rotor, double *states, int16_t *labels,
                               float *times, int64_t count, const double *regions,
                               int64_t region_count, const double free_whirl[4],
                               const double *sections, int64_t section_count, double duration,
                               double tolerance, const stop_flag *stop);

/* The least |L (s - c)|**2 with which each of many states passes a section of a limit cycle between
 * two times; infinite where one does not. */
CORE_API int core_measure_returns(const struct rotor *rotor, const double *states, int64_t count,
                                  const double section[21], double earliest, double latest,
                                  double tolerance, double *values, const stop_flag *stop);

#endif
