/* A motion: an autonomous system on its way from a start, led one internal step at a time.
 *
 * It can be read anywhere inside the last step. Taylor series lead it (taylor.c), or CVODE
 * (cvode.c); the phases of the event loop are written once for both. */
#ifndef ROTOR_IDA_MOTION_H
#define ROTOR_IDA_MOTION_H

#include "flight.h"
#include "series.h"

/* Values are state and differences, without a gap; every array of them has room for the most. */
enum { MOST_STATE = WIDTH, MOST_VALUES = MOST_STATE + APART };

/* What is derived from one mode of the model. */
struct mode {
    int size;
    void (*field)(const struct parameters *, const double *state, double *rate);
    void (*jacobian)(const struct parameters *, const double *state, double *matrix);
    /* of neighbours, where they are followed */
    void (*growth)(const struct parameters *, const double *state, double growth[4][4]);
    void (*by_parameters)(const struct parameters *, const double *state,
                          double added[PARAMETERS][4]);
    void (*expand)(const struct parameters *, struct series *, int order);
    /* the same where the speed is prescribed, and of a rotor that is the paper's besides */
    void (*expand_prescribed)(const struct parameters *, struct series *, int order);
    void (*expand_plain)(const struct parameters *, struct series *, int order);
    /* the rates of what a contact of the whole model spends, and of the heat, at parts of a step;
     * and the same two again */
    void (*spent)(const struct parameters *, const struct series *, int order, const vec4 *parts,
                  vec4 (*rate)[2]);
    void (*spent_prescribed)(const struct parameters *, const struct series *, int order,
                             const vec4 *parts, vec4 (*rate)[2]);
    void (*spent_plain)(const struct parameters *, const struct series *, int order,
                        const vec4 *parts, vec4 (*rate)[2]);
    void (*expand_with_factors)(const struct parameters *, struct series *, int order);
    void (*expand_differences)(const struct parameters *, struct series *, int order);
    /* what is beside the state and yet needed to say when the mode ends, and its rates; or NULL */
    void (*watched)(const struct parameters *, const double *state, double *watched, double *rate);
};

extern const struct mode contact_mode, cartesian_mode;
/* With friction a contact slides or rolls. All three are laid out alike. */
extern const struct mode rub_mode, rolling_mode;
_Static_assert(!HAS_FRICTION
                   || ((int)RUB_Q == CONTACT_Q && (int)RUB_P == CONTACT_P && (int)RUB_C == CONTACT_C
                       && (int)RUB_DOWN_R == CONTACT_DOWN_R && (int)RUB_T == CONTACT_T
                       && (int)RUB_SPEED == CONTACT_SPEED && (int)RUB_ANGLE == CONTACT_ANGLE
                       && (int)RUB_J == CONTACT_J && (int)RUB_WORK == CONTACT_WORK
                       && (int)RUB_SPENT == CONTACT_SPENT && (int)RUB_SLIP == (int)ROLLING_SLIP
                       && (int)RUB_HEAT == (int)ROLLING_HEAT && (int)RUB_SIZE == (int)ROLLING_SIZE),
               "the modes of a contact must be laid out alike");

struct motion {
    const struct mode *mode;
    struct parameters model;
    double rtol;
    int tangents;    /* whether four differences come behind the state */
    int begins_anew; /* whether the differences are the unit matrix at the beginning of each step */
    double low, point; /* ends of the last step; and the values there, as vectors like them */
    _Alignas(32) double before[MOST_VALUES];
    _Alignas(32) double values[MOST_VALUES];
    int (*restart)(struct motion *, const double *start, const double *atol);
    int (*advance)(struct motion *);
    const double *(*at)(struct motion *, double point);
    /* faster, and to rounding; of a contact up to its time, without the integrals behind it */
    const double *(*glance_at)(struct motion *, double point);
    const double *(*rate)(struct motion *); /* at the beginning of the step */
    int64_t (*evaluations)(struct motion *);
    /* add what a contact spends up to a point of the last step; NULL where its values have it */
    void (*spend)(struct motion *, double end, double *reached);
    struct vector down; /* where the load points as the phase begins, on the rotating axes */
};

static inline int is_contact(const struct motion *motion)
{
    return motion->mode != &cartesian_mode;
}

/* The speed of the rotor, and that of the rim. */
static inline double speed_of(const struct motion *motion, const double *values)
{
    if (SPEED_CHANGES)
        return values[is_contact(motion) ? (int)CONTACT_SPEED : (int)CARTESIAN_SPEED];
    return motion->model.omega;
}

/* How far a speed that changes has turned the rotor in this phase. */
static inline double angle_of(const struct motion *motion, const double *values)
{
    return values[is_contact(motion) ? (int)CONTACT_ANGLE : (int)CARTESIAN_ANGLE];
}

static inline double rim_of(const struct motion *motion, const double *values)
{
    return SPEED_CHANGES ? motion->model.disc_radius * speed_of(motion, values) : motion->model.rim;
}

/* Whether a torque drives the speed. */
static inline int is_driven(const struct motion *motion)
{
    return SPEED_CHANGES && motion->model.inverse_inertia > 0.0;
}

/* Whether damping would make the force of a contact tensile, so that there is none. */
static inline int is_loose(const struct motion *motion) { return motion->model.loose > 0.0; }

/* Whether surfaces slide in a contact, or the disc rolls. */
static inline int is_rubbing(const struct motion *motion)
{
    return HAS_FRICTION && motion->mode != &contact_mode;
}

/* Where the disc's centre is in a contact: how far out, and in which direction. */
static inline double radius_in_contact(const struct parameters *m, const double *values)
{
    return m->delta0 + values[CONTACT_Q] * values[CONTACT_Q];
}

static inline struct vector direction_of(const double *values)
{
    const struct vector direction = {values[CONTACT_C], values[CONTACT_S]};
    return scaled(1.0 / length(direction), direction);
}

/* The angular momentum in a contact: with friction its values hold the moment of the slip. */
static inline double momentum_of(const struct motion *motion, const double *values)
{
    if (is_rubbing(motion))
        return values[RUB_SLIP]
               - rim_of(motion, values) * radius_in_contact(&motion->model, values);
    return values[CONTACT_H];
}

/* The direction of the load by time and by the direction of the contact. By its own rate alone it
 * would turn away from the unbalance in a long phase, a tolerance a step. */
static inline struct vector load_of(const struct motion *motion, const double *values, double point)
{
    const int contact = is_contact(motion);
    const double angle = SPEED_CHANGES
                             ? angle_of(motion, values)
                             : motion->model.omega * (contact ? values[CONTACT_T] : point);
    const struct vector down = product(motion->down, (struct vector){cos(angle), -sin(angle)});
    return contact ? product(down, (struct vector){values[CONTACT_C], -values[CONTACT_S]}) : down;
}

static inline void put_load_right(const struct motion *motion, double *values, double point)
{
    if (!HAS_LOAD || motion->model.load == 0.0)
        return;
    const struct vector down = load_of(motion, values, point);
    const int place = is_contact(motion) ? (int)CONTACT_DOWN_R : (int)CARTESIAN_DOWN_X;
    values[place] = down.x;
    values[place + 1] = down.y;
}

/* What the error of the moment of the slip is measured by: that is large of a large disc, however
 * slowly its centre moves, and no more than so many times the angular momentum. */
static inline double size_of_slip(const struct motion *motion, const double *values, double times)
{
    return fmin(fabs(values[RUB_SLIP]), times * fabs(momentum_of(motion, values)));
}

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
    double atol[MOST_STATE], inverse[MOST_STATE];
    _Alignas(32) double sizes[WIDTH];
    _Alignas(32) double reading[MOST_VALUES];
    int has_basis;
    _Alignas(32) double basis[ORDERS][32]; /* of Bernstein, once it is needed */
    struct series series;
};

static inline struct taylor *taylor_of(struct motion *motion) { return (struct taylor *)motion; }

/* Add to `reached` what a contact spends over the last step up to `end` (spending.c). */
void spend(struct motion *motion, double end, double *reached);
/* How far the surfaces slide in the last step up to `end`: the integral of |v_s|. */
double slid_in_step(struct motion *motion, double end);

void open_taylor(struct taylor *taylor, const struct mode *mode, struct parameters model,
                 double rtol, int tangents);

/* A point between two points of the last step where `function` reaches `level`; NaN where the
 * difference does not change sign. Brent, "Algorithms for Minimization without Derivatives", 1973,
 * chapter 4. */
double root_in_step(struct motion *motion, double (*function)(const double *values), double level,
                    double low, double high);

/* What must not fall below 0 while a contact goes on as it does: the factor of the force,
 * 1 + c d', which falls through 0 at a release, or, while the contact is loose, what is left below
 * it, as it rises through 0 at a press; the slip, in the sense in which surfaces slide; and what is
 * left of the grip, for a force that would have them slide forwards, or backwards. */
enum guard { RELEASE_OR_PRESS, SLIDING, GRIPS_FORWARDS, GRIPS_BACKWARDS };

/* One of them, at values; and how fast it grows, if that is asked for. */
double margin_of(const struct motion *motion, enum guard guard, const double *values,
                 double *growth);

/* The tangential force below which rounding hides the one that rolling needs. */
double hidden_hold(const struct motion *motion, const double *values);

/* As `root_in_step`, of a guard. */
double root_of_guard(struct motion *motion, enum guard guard, double low, double high);

#endif
