/* A motion: an autonomous system on its way from a start, led one internal step at a time.
 *
 * It can be read anywhere inside the last step. Taylor series lead it (taylor.c), or CVODE
 * (cvode.c); the phases of the event loop are written once for both. */
#ifndef ROTOR_IDA_MOTION_H
#define ROTOR_IDA_MOTION_H

#include "core.h"
#ifdef WHOLE_MODEL
#include "derived_whole.h"
#else
#include "derived.h"
#endif
#include "flight.h"
#include "series.h"

/* Values are state and differences, without a gap; every array of them has room for the most. */
enum { MOST_STATE = WIDTH, MOST_VALUES = MOST_STATE + APART };

/* What is derived from one mode of the model. */
struct mode {
    int size;
    void (*field)(const struct parameters *, const double *state, double *rate);
    void (*jacobian)(const struct parameters *, const double *state, double *matrix);
    void (*growth)(const struct parameters *, const double *state, double growth[4][4]);
    void (*by_parameters)(const struct parameters *, const double *state,
                          double added[PARAMETERS][4]);
    void (*expand)(const struct parameters *, struct series *, int order);
    void (*expand_with_factors)(const struct parameters *, struct series *, int order);
    void (*expand_differences)(const struct parameters *, struct series *, int order);
};

extern const struct mode contact_mode, cartesian_mode;

struct motion {
    const struct mode *mode;
    struct parameters model;
    double rtol;
    int tangents;    /* whether four differences come behind the state */
    int begins_anew; /* whether the differences are the unit matrix at the beginning of each step */
    double low, point;                               /* ends of the last step */
    double before[MOST_VALUES], values[MOST_VALUES]; /* there */
    int (*restart)(struct motion *, const double *start, const double *atol);
    int (*advance)(struct motion *);
    const double *(*at)(struct motion *, double point);
    /* faster, and to rounding; of a contact up to its time, without the integrals behind it */
    const double *(*glance_at)(struct motion *, double point);
    const double *(*rate)(struct motion *); /* at the beginning of the step */
    int64_t (*evaluations)(struct motion *);
#ifdef WHOLE_MODEL
    /* add what a contact spends up to a point of the last step; NULL where its values have it */
    void (*spend)(struct motion *, double end, double *reached);
    struct vector down; /* where the load points as the phase begins, on the rotating axes */
#endif
};

#ifdef WHOLE_MODEL
/* The direction of the load by time and by the direction of the contact. By its own rate alone it
 * would turn away from the unbalance in a long phase, a tolerance a step. */
static inline struct vector load_of(const struct motion *motion, const double *values, double point)
{
    const int contact = motion->mode == &contact_mode;
    const double angle = motion->model.omega * (contact ? values[CONTACT_T] : point);
    const struct vector down = product(motion->down, (struct vector){cos(angle), -sin(angle)});
    return contact ? product(down, (struct vector){values[CONTACT_C], -values[CONTACT_S]}) : down;
}

static inline void put_load_right(const struct motion *motion, double *values, double point)
{
    if (motion->model.load == 0.0)
        return;
    const struct vector down = load_of(motion, values, point);
    const int place = motion->mode == &contact_mode ? (int)CONTACT_DOWN_R : (int)CARTESIAN_DOWN_X;
    values[place] = down.x;
    values[place + 1] = down.y;
}
#endif

static inline int values_of(const struct motion *motion)
{
    return motion->mode->size + (motion->tangents ? APART : 0);
}

/* Copy values of a motion: of the few without tangents, faster than by memcpy. */
static inline void copy_values(const struct motion *motion, const double *from, double *to)
{
    for (int i = 0; i < MOST_STATE; i += 4)
        store(&to[i], load(&from[i]));
    if (motion->tangents)
        memcpy(&to[MOST_STATE], &from[MOST_STATE], sizeof(double) * APART);
}

struct taylor {
    struct motion motion;
    int order;
    double fallen;         /* what is left of a first term that falls as it is best, at order + 1 */
    int64_t orders, steps; /* expanded, and taken, since the start */
    double atol[MOST_STATE], inverse[MOST_STATE], sizes[WIDTH];
    double reading[MOST_VALUES];
    int has_basis;
    _Alignas(32) double basis[ORDERS][32]; /* of Bernstein, once it is needed */
    struct series series;
};

void open_taylor(struct taylor *taylor, const struct mode *mode, struct parameters model,
                 double rtol, int tangents);

/* A point between two points of the last step where `function` reaches `level`; NaN where the
 * difference does not change sign. Brent, "Algorithms for Minimization without Derivatives", 1973,
 * chapter 4. */
double root_in_step(struct motion *motion, double (*function)(const double *values), double level,
                    double low, double high);

#endif
