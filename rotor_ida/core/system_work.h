/* What a run of a rotor system works with: the series of one step. */
#ifndef ROTOR_IDA_SYSTEM_WORK_H
#define ROTOR_IDA_SYSTEM_WORK_H

#include "derived_element.h"
#include "flight.h"
#include "system.h"

enum { MOST_CONTACTS = 16 };

/* What decides how long a contact goes on as it does: the root of its indentation, or the gap of
 * one that flies; the factor of its force (release and press); and its slip, or the grip that is
 * left. */
enum { OF_ROOT, OF_RELEASE, OF_SLIP, GUARDS };

/* Number of terms of the square of a series of the highest order. */
enum { GAP_TERMS = 2 * ORDERS };
/* Where contacts enter together, or without a radial velocity, flight goes on to an indentation of
 * this part of the clearance. */
static const double PASSED = 1e-11;
/* Rounding of a sum, in parts of the sizes of its terms: of a slip, and of a rate of slip. */
static const double ROUNDED = 64.0 * 2.220446049250313e-16;

/* A contact within a step. */
struct touching {
    const struct system_law *law;
    struct system_touch *touch;
    const double *rows; /* two of `stride` */
    struct element element;
    struct series series;
    double answers[ORDERS][ELEMENT_ANSWERS];
    double pull[ORDERS][2]; /* the acceleration of its displacement; while it rolls */
    double drag[ORDERS];    /* the tangential force T */
    double others[ORDERS];  /* the pace but for its own root */
    double hidden;          /* a tangential force that rounding hides, while it rolls */
    double mobility;        /* the largest acceleration of its displacement by a unit force */
    double stator_mobility; /* the velocity of its stator without mass by a unit force; or 0 */
    double inverse_root;    /* of the root of its indentation, at the beginning of the step */
    int is_edge;            /* whether its root is a factor of the pace */
    double radius, inner;   /* without clearance: see system_centred.c */
};

/* The series of a bearing whose coefficients change with the speed. */
enum { ROWS_OF_BEARING = 4 };
struct bearing_terms {
    double cubics[BEARING_POWERS][BEARING_ENTRIES]; /* about the speed at the beginning */
    double entries[ORDERS][BEARING_ENTRIES];        /* its coefficients, up to the degree */
    double motion[ORDERS][4];                       /* displacement and velocity */
    double force[ORDERS][2];
    double passed;   /* where the speed passes a knot */
    int64_t next;    /* the interval from there */
    double *columns; /* displacements and velocities of columns, 4 rows an order */
};

struct bearings {
    double powers[BEARING_POWERS - 1][ORDERS]; /* of the excess of the speed */
    int degree;                                /* of the coefficients */
    struct bearing_terms *each;
};

struct work {
    struct system_run *run;
    int64_t stride;
    int order;
    int has_torque, has_rate, moves;      /* whether the speed changes; and whether the pace does */
    int edges[MOST_CONTACTS], edge_count; /* the contacts whose roots are its factors */
    double *y, *v, *acceleration;         /* ORDERS rows each */
    double *resisted, *turned, *stiffened; /* (C + Omega G) y' or C y'; G y'; K_dot y */
    const double *diagonal; /* of the stiffness, where it has nothing else; or NULL */
    int is_summed;          /* whether accelerations are summed in registers; see system.c */
    double *both;           /* C + Omega G, where the speed is constant */
    double time[ORDERS], pace[ORDERS], cosine[ORDERS], sine[ORDERS];
    double spin[ORDERS], spin_rate[ORDERS], spin_square[ORDERS], turning[ORDERS];
    double by_cosine[ORDERS], by_sine[ORDERS]; /* what multiplies the unbalance's two rows */
    double swung[ORDERS][2]; /* the unbalance's two rows times the acceleration; under a torque */
    /* what is solved for at each order: the tangential forces that roll, and the rate of the spin
     */
    int rolling[MOST_CONTACTS], rolls;
    double matrix[MOST_CONTACTS + 1][MOST_CONTACTS + 1];
    int pivot[MOST_CONTACTS + 1];
    double right[MOST_CONTACTS + 1];
    int is_asked;    /* whether the matrix is left as it is */
    int is_singular; /* whether what is implicit has no solution */
    double step;
    struct system_cvode *cvode; /* or NULL */
    int is_led;                 /* whether its interpolant gives the terms */
    struct bearings *bearings;  /* or NULL */
    struct touching touching[MOST_CONTACTS];
};

#define COMPILED static inline __attribute__((always_inline))

/* To how many numbers rows are padded: one vector of four, or some of eight. */
static inline int64_t padded(int64_t size) { return size <= 4 ? 4 : (size + 7) / 8 * 8; }

static inline double *row_of(const struct work *work, double *rows, int n)
{
    return &rows[n * work->stride];
}

COMPILED double sum_of_products(const double *a, const double *b, int64_t size)
{
    vec4 sum = spread(0.0);
    for (int64_t i = 0; i < size; i += 4)
        sum = fma4(load(&a[i]), load(&b[i]), sum);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Add a row, scaled, to another. */
COMPILED void add_scaled(double factor, const double *row, double *to, int64_t size)
{
    const vec4 by = spread(factor);
    for (int64_t i = 0; i < size; i += 4)
        store(&to[i], fma4(by, load(&row[i]), load(&to[i])));
}

/* The same of two rows that follow one another. */
COMPILED void add_both(double first, double second, const double *rows, int64_t size, double *to)
{
    for (int64_t i = 0; i < size; i += 4) {
        const vec4 sum = fma4(spread(first), load(&rows[i]), load(&to[i]));
        store(&to[i], fma4(spread(second), load(&rows[size + i]), sum));
    }
}

/* Eight columns of rows. */
typedef double vec8 __attribute__((vector_size(64)));

COMPILED vec8 load8(const double *from)
{
    vec8 row;
    memcpy(&row, from, sizeof row);
    return row;
}

COMPILED void store8(double *to, vec8 row) { memcpy(to, &row, sizeof row); }

COMPILED vec8 spread8(double number)
{
    return (vec8){number, number, number, number, number, number, number, number};
}

COMPILED vec8 fma_each(vec8 a, vec8 b, vec8 c)
{
    return (vec8){fma(a[0], b[0], c[0]), fma(a[1], b[1], c[1]), fma(a[2], b[2], c[2]),
                  fma(a[3], b[3], c[3]), fma(a[4], b[4], c[4]), fma(a[5], b[5], c[5]),
                  fma(a[6], b[6], c[6]), fma(a[7], b[7], c[7])};
}

COMPILED vec8 fma8(double by, vec8 b, vec8 c) { return fma_each(spread8(by), b, c); }

COMPILED vec4 halves_of(vec8 a)
{
    return (vec4){a[0] + a[4], a[1] + a[5], a[2] + a[6], a[3] + a[7]};
}

/* The scalar products of two rows that follow one another with a row. */
COMPILED void sums_of_products(const double *rows, const double *b, int64_t size, double sums[2])
{
    vec4 along[2], aside[2]; /* as each sum waits for itself, there are two of each row */
    for (int j = 0; j < 2; j++)
        along[j] = aside[j] = spread(0.0);
    int64_t i = 0;
    for (; i + 8 <= size; i += 8) {
        for (int j = 0; j < 2; j++) {
            along[j] = fma4(load(&rows[i + 4 * j]), load(&b[i + 4 * j]), along[j]);
            aside[j] = fma4(load(&rows[size + i + 4 * j]), load(&b[i + 4 * j]), aside[j]);
        }
    }
    for (; i < size; i += 4) {
        along[0] = fma4(load(&rows[i]), load(&b[i]), along[0]);
        aside[0] = fma4(load(&rows[size + i]), load(&b[i]), aside[0]);
    }
    const vec4 first = along[0] + along[1], second = aside[0] + aside[1];
    sums[0] = (first[0] + first[1]) + (first[2] + first[3]);
    sums[1] = (second[0] + second[1]) + (second[2] + second[3]);
}

/* Add rows, each times a factor, to a row, in some vectors of eight columns. As each sum waits for
 * itself, there are two of each column. */
COMPILED void add_eights(const int eights, double scale, const double *factors, int factor_apart,
                         const double *rows, int64_t many, int64_t stride, double *to)
{
    enum { MOST = 2 };
    vec8 even[MOST], odd[MOST];
    for (int e = 0; e < eights; e++) {
        even[e] = load8(&to[8 * e]);
        odd[e] = (vec8){0.0};
    }
    int64_t k = 0;
    for (; k + 1 < many; k += 2, rows += 2 * stride) {
        const double first = scale * factors[k * factor_apart];
        const double second = scale * factors[(k + 1) * factor_apart];
        for (int e = 0; e < eights; e++) {
            even[e] = fma8(first, load8(&rows[8 * e]), even[e]);
            odd[e] = fma8(second, load8(&rows[stride + 8 * e]), odd[e]);
        }
    }
    for (int e = 0; e < eights && k < many; e++)
        even[e] = fma8(scale * factors[k * factor_apart], load8(&rows[8 * e]), even[e]);
    for (int e = 0; e < eights; e++)
        store8(&to[8 * e], even[e] + odd[e]);
}

/* The same of all columns. */
COMPILED void add_sums(double scale, const double *factors, int factor_apart, const double *rows,
                       int64_t many, int64_t stride, double *to)
{
    int64_t i = 0;
    for (; i + 16 <= stride; i += 16)
        add_eights(2, scale, factors, factor_apart, &rows[i], many, stride, &to[i]);
    for (; i + 8 <= stride; i += 8)
        add_eights(1, scale, factors, factor_apart, &rows[i], many, stride, &to[i]);
    if (i == stride)
        return;
    vec4 even = load(&to[i]), odd = spread(0.0);
    const double *row = &rows[i];
    int64_t k = 0;
    for (; k + 1 < many; k += 2, row += 2 * stride) {
        even = fma4(spread(scale * factors[k * factor_apart]), load(row), even);
        odd = fma4(spread(scale * factors[(k + 1) * factor_apart]), load(row + stride), odd);
    }
    if (k < many)
        even = fma4(spread(scale * factors[k * factor_apart]), load(row), even);
    store(&to[i], even + odd);
}

/* Add a matrix times a row, or take it away. */
COMPILED void multiply(const double *matrix, const double *row, double sign, int64_t size,
                       int64_t stride, double *to)
{
    add_sums(sign, row, 1, matrix, size, stride, to);
}

/* Coefficient n of a product, from terms that are so far apart in memory, without the first terms
 * of its first factor. Two sums side by side, as each waits for itself. */
COMPILED double convolved_from(int first, const double *a, int a_apart, const double *b,
                               int b_apart, int n)
{
    double even = 0.0, odd = 0.0;
    int k = first;
    for (; k < n; k += 2) {
        even = fma(a[k * a_apart], b[(n - k) * b_apart], even);
        odd = fma(a[(k + 1) * a_apart], b[(n - k - 1) * b_apart], odd);
    }
    return k == n ? fma(a[n * a_apart], b[0], even) + odd : even + odd;
}

/* Coefficient n of a product. */
COMPILED double convolved(const double *a, int a_apart, const double *b, int b_apart, int n)
{
    return convolved_from(0, a, a_apart, b, b_apart, n);
}

/* The same without a_0. */
COMPILED double convolved_later(const double *a, int a_apart, const double *b, int b_apart, int n)
{
    return convolved_from(1, a, a_apart, b, b_apart, n);
}

COMPILED double polynomial(const double *terms, int apart, int order, double point)
{
    double value = terms[order * apart];
    for (int n = order - 1; n >= 0; n--)
        value = fma(value, point, terms[n * apart]);
    return value;
}

/* The velocity of a coordinate without mass by its spring and a constant force. */
static inline double drift_of(const struct system_run *run, const double *y, double force,
                              int64_t i)
{
    return force - run->stiffness[i * (run->stride + 1)] * y[i];
}

static inline int is_touching(const struct touching *each) { return each->touch->mode != FLIES; }
static inline int pushes(const struct touching *each)
{
    return each->touch->mode != FLIES && each->touch->mode != IS_LOOSE;
}
/* Whether a contact has no clearance, and so never opens. */
static inline int is_centred(const struct touching *each) { return each->law->clearance == 0.0; }
/* Whether the law is analytic in the indentation itself, which then stands in the place of its
 * root, and the pace is that of time. */
static inline int is_spring(const struct touching *each)
{
    return each->law->hertz == 0.0 && !is_centred(each);
}
/* What is followed of an indentation: its root, or this itself. */
static inline double root_of(const struct touching *each, double depth)
{
    return is_spring(each) ? depth : sqrt(depth);
}
/* Its indentation by what is followed. */
static inline double depth_of(const struct touching *each, double root)
{
    return is_spring(each) ? root : root * root;
}
/* Whether it touches until the root of its indentation falls to 0. */
static inline int may_leave(const struct touching *each)
{
    return is_touching(each) && !is_centred(each);
}
/* Coefficient n of the largest tangential force that friction allows. */
static inline double grip_of(const struct touching *each, int n)
{
    return each->law->friction * each->answers[n][ELEMENT_PUSH];
}
/* Whether the friction of another contact, or of this one, turns the race of a contact. */
static inline int turns_race(const struct touching *other, const struct touching *each)
{
    return other->law->race == each->law->race && pushes(other);
}
/* The rate of the slip that a unit tangential force causes by the race. */
static inline double yield_of_race(const struct system_law *law)
{
    return law->race_radius * law->race_radius * law->inverse_race_inertia;
}

/* system.c */
struct work *open_work(struct system_run *run);
void begin_system_piece(struct work *work);
/* Begin the series of a step with the state of the run; write coefficients up to `order`; and the
 * length of the step. */
void begin_terms(struct work *work);
void expand_system(struct work *work, int order);
void choose_step(struct work *work);
/* Write the matrix and the right-hand side of what is implicit at the beginning of a step. */
void ask_implicit(struct work *work);
/* Solve for what is implicit, with the matrix of this step. */
void solve_implicit(const struct work *work, int size, double *right);
void turn_as_prescribed(struct system_run *run);
/* Move the state of the run to a point of the step, and keep its ledger. */
void read_rows(const struct work *work, const double *rows, double point, double *values);
void move_system(struct work *work, double point);

/* system_ledger.c */
/* Keep what has been gained and lost up to a point of the step, which takes so long. */
void keep_ledger(struct work *work, double point, double span);
/* The angle by which a rotor that a torque drives turns up to a point of the step. */
double turned_by(const struct work *work, double point);

/* system_roots.c: series as polynomials */
/* Write coefficients up to `last` of a b + c d, of series up to an order. */
void write_product(int order, int last, const double *a, const double *b, const double *c,
                   const double *d, double *product);
/* The first point of (0, step] at which a polynomial falls through 0; infinite where there is none.
 * Of its zeros at 0 the first `zeros` are known and do not count. */
double first_fall(const double *terms, int apart, int order, double step, int zeros);
/* Write the points, at most `order` + 1, at which a polynomial changes its sign in (0, step], and
 * at 0 if it had the other `sign` before; 0 if none. Return how many, and the sign behind them. */
int sign_changes(const double *terms, int order, double step, double *sign, double *points);

/* system_guards.c: what happens first in a step. */
struct happening {
    double point;
    int contact, guard;
};
struct happening first_happening(struct work *work, double step);

/* system_contact.c */
void set_element(struct touching *each);
double radius_of_touch(const struct work *work, const struct touching *each);
/* Do what follows from what happens, and record it. */
int change_contact(struct work *work, struct happening what);
/* End contacts together whose roots fall to 0 together: the fictitious time does not get there. */
int leave_together(struct work *work);
/* Decide at the start which contacts touch, and at a jump of the acceleration which still roll: all
 * that no longer do, but for one, get a slip recorded. */
int begin_contacts(struct work *work);
int decide_rolling_of_others(struct work *work, int but);

/* system_extrema.c */
/* Keep what is largest in a step up to a point, which is at a time; and the slowest races. */
void keep_peaks(struct work *work, double point, double until);
/* Keep the extrema of the distances of places in a step up to a point, which is at a time. */
void keep_extrema(struct work *work, double point, double until);

/* system_centred.c: contacts without clearance */
void begin_centred(const struct work *work, struct touching *each);
/* Whether its law is linear at this step, as is no force: then by this stiffness. */
int is_linear_here(const struct touching *each, double *stiffness);
void push_centred(struct touching *each, int n);
/* Shorten a step so that it does not pass the centre. */
double before_centre(const struct work *work, const struct touching *each, double step);
void sample_centred(const struct work *work, const struct touching *each, double point,
                    double *forces);
void keep_centred(struct work *work, const struct touching *each, double point);
/* Write the series of the square of its radius. */
void write_square(const struct work *work, const struct touching *each, double *square);

/* system_bearing.c: bearings whose coefficients change with the speed */
struct bearings *open_bearings(const struct system_run *run);
/* Begin their series at the speed of the run; let their forces, coefficient n, accelerate. */
void begin_bearings(struct work *work);
void push_by_bearings(struct work *work, int n, double *to);
/* End a step where the speed passes a knot; and go on in the next interval. */
int limit_to_knots(struct work *work);
void pass_knots(struct work *work, double point);

/* system_tangent.c: small changes of the motion */
void open_columns(struct work *work);
/* Gather what matrices do with them at the speeds of a piece. */
void begin_column_piece(struct work *work);
/* Remove the slip from the changes of a start that rolls: a neighbouring start slides at first, and
 * friction stops that at once. */
void begin_columns(struct work *work);
/* Write the series of a step; read their displacements at a sample, and, of the contact, at an
 * event of it. */
void expand_columns(struct work *work);
void sample_columns(const struct work *work, double point);
void record_columns(const struct system_run *run, int contact);
/* Move them to a point of the step, before the motion itself; and through an event, with it. */
void move_columns(struct work *work, double point);
int change_with_columns(struct work *work, struct happening what);

/* system_cvode.c: with CVODE in the place of series */
int open_system_cvode(struct work *work);
void close_system_cvode(struct work *work);
/* Whether CVODE leads the motion from here; and its next step, as `expand_system` writes one. */
int leads(const struct work *work);
int step_by_cvode(struct work *work);
/* Take coefficients n of the interpolant. */
void take_terms(struct work *work, int n);

/* system_run.c */
void record_system_event(struct system_run *run, int kind, int contact);

#endif
