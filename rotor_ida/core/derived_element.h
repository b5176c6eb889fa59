/* Derived from rotor_ida/model/element.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef ROTOR_IDA_DERIVED_ELEMENT_H
#define ROTOR_IDA_DERIVED_ELEMENT_H

#include "series.h"

/* What the law of a contact knows. */
struct element {
    double clearance, hertz, linear, contact_damping, loose, friction, sigma, radius, race_radius, mobility, holding, squared;
};

/* Its slope by the indentation. */
static inline double element_stiffness(const struct element *m, int n, double q)
{
    const double one = n == 0 ? 1.0 : 0.0;
    return 1.5 * m->hertz * q + one * m->linear;
}

/* The elastic energy. */
static inline double element_energy(const struct element *m, int n, double q)
{
    const double one = n == 0 ? 1.0 : 0.0;
    return (0.4 * m->hertz * q + one * (0.5 * m->linear)) * (q * q * (q * q));
}

/* The factor of contact damping, not clipped at 0. */
static inline double element_factor(const struct element *m, int n, double approach)
{
    const double one = n == 0 ? 1.0 : 0.0;
    return one * 1.0 + m->contact_damping * approach;
}

/* The tangential force of surfaces that slide. */
static inline double element_drag(const struct element *m, double push)
{
    return m->friction * m->sigma * push;
}

enum { ELEMENT_ROOT, ELEMENT_X, ELEMENT_Y, ELEMENT_VX, ELEMENT_VY, ELEMENT_SPIN, ELEMENT_RACE, ELEMENT_GIVEN };
enum { ELEMENT_NORMAL_X, ELEMENT_NORMAL_Y, ELEMENT_APPROACH, ELEMENT_SLIP, ELEMENT_PUSH, ELEMENT_FORCE_X, ELEMENT_FORCE_Y, ELEMENT_TURNING, ELEMENT_DRAG, ELEMENT_ANSWERS };
enum { SLOPE_ROOT, SLOPE_APPROACH, SLOPE_ACROSS, SLOPE_PUSH, SLOPE_DRAG, SLOPE_PULL, SLOPE_GIVEN };
enum { SLOPE_BY_ALONG, SLOPE_BY_ASIDE, SLOPE_BY_RATE, SLOPE_BY_PUSH_SHARE, SLOPE_BY_DRAG_SHARE, SLOPE_BY_APPROACH_SHARE, SLOPE_BY_ACROSS_SHARE, SLOPE_BY_DIFFERENCE, SLOPE_BY_PRODUCT, SLOPE_BY_PULL_SHARE, SLOPE_BY_CONTACT_DAMPING, SLOPES };
enum { CENTRED_X_BY_X, CENTRED_X_BY_Y, CENTRED_Y_BY_Y, CENTRED_SLOPES };

/* Coefficient n of what a contact answers, from those up to n of what it is given:
 * 11 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void element_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(7 <= WIDTH && 11 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double root_first = series->terms[0][ELEMENT_ROOT];
    const double inverse_radius = inverse(m->clearance + (m->squared * (root_first * root_first) + (1.0 - m->squared) * root_first));
    sum_known(series, n, 3);
    const double root = here[ELEMENT_ROOT];
    const double x = here[ELEMENT_X];
    const double y = here[ELEMENT_Y];
    const double vx = here[ELEMENT_VX];
    const double vy = here[ELEMENT_VY];
    const double spin = here[ELEMENT_SPIN];
    const double race = here[ELEMENT_RACE];
    const double w0 = times(series, 0, n, root, root); /* root * root */
    const double w1 = m->squared * w0 + (1.0 - m->squared) * root;
    const double radius = one * m->clearance + w1;
    const double normal_x = over(series, 1, n, x, radius, inverse_radius); /* x / radius */
    const double normal_y = over(series, 2, n, y, radius, inverse_radius); /* y / radius */
    const double w5 = times(series, 3, n, normal_x, vx); /* normal_x * vx */
    const double w6 = times(series, 4, n, normal_y, vy); /* normal_y * vy */
    const double approach = w5 + w6;
    const double w8 = times(series, 5, n, normal_x, vy); /* normal_x * vy */
    const double w9 = times(series, 6, n, normal_y, vx); /* normal_y * vx */
    const double across = w8 - w9;
    const double slip = across + m->radius * spin - m->race_radius * race;
    /* w1 * (hertz * root + linear) */
    const double w12 = times(series, 7, n, w1, m->hertz * root + one * m->linear);
    /* (1.0 + contact_damping * approach) * w12 */
    const double w13 = times(series, 8, n, one * 1.0 + m->contact_damping * approach, w12);
    const double push = (1.0 - m->loose) * w13;
    const double w15 = times(series, 9, n, w13, normal_y); /* w13 * normal_y */
    const double w16 = times(series, 10, n, w13, normal_x); /* w13 * normal_x */
    const double push_x = (1.0 - m->loose) * w16;
    const double force_x = m->friction * m->sigma * (1.0 - m->loose) * w15 - push_x;
    const double push_y = (1.0 - m->loose) * w15;
    const double force_y = -(m->friction * m->sigma * (1.0 - m->loose)) * w16 - push_y;
    answers[ELEMENT_NORMAL_X] = normal_x;
    answers[ELEMENT_NORMAL_Y] = normal_y;
    answers[ELEMENT_APPROACH] = approach;
    answers[ELEMENT_SLIP] = slip;
    answers[ELEMENT_PUSH] = push;
    answers[ELEMENT_FORCE_X] = force_x;
    answers[ELEMENT_FORCE_Y] = force_y;
}

/* What it answers, as values. */
static inline __attribute__((always_inline)) void element_values(
    const struct element *m, const double *state, double *answers)
{
    const double root = state[ELEMENT_ROOT];
    const double x = state[ELEMENT_X];
    const double y = state[ELEMENT_Y];
    const double vx = state[ELEMENT_VX];
    const double vy = state[ELEMENT_VY];
    const double spin = state[ELEMENT_SPIN];
    const double race = state[ELEMENT_RACE];
    const double w0 = root * root;
    const double w1 = m->squared * w0 + (1.0 - m->squared) * root;
    const double radius = m->clearance + w1;
    const double normal_x = ratio(x, radius);
    const double normal_y = ratio(y, radius);
    const double w5 = normal_x * vx;
    const double w6 = normal_y * vy;
    const double approach = w5 + w6;
    const double w8 = normal_x * vy;
    const double w9 = normal_y * vx;
    const double across = w8 - w9;
    const double slip = across + m->radius * spin - m->race_radius * race;
    const double w12 = w1 * (m->hertz * root + m->linear);
    const double w13 = (1.0 + m->contact_damping * approach) * w12;
    const double push = (1.0 - m->loose) * w13;
    const double w15 = w13 * normal_y;
    const double w16 = w13 * normal_x;
    const double push_x = (1.0 - m->loose) * w16;
    const double force_x = m->friction * m->sigma * (1.0 - m->loose) * w15 - push_x;
    const double push_y = (1.0 - m->loose) * w15;
    const double force_y = -(m->friction * m->sigma * (1.0 - m->loose)) * w16 - push_y;
    answers[ELEMENT_NORMAL_X] = normal_x;
    answers[ELEMENT_NORMAL_Y] = normal_y;
    answers[ELEMENT_APPROACH] = approach;
    answers[ELEMENT_SLIP] = slip;
    answers[ELEMENT_PUSH] = push;
    answers[ELEMENT_FORCE_X] = force_x;
    answers[ELEMENT_FORCE_Y] = force_y;
}

/* Coefficient n of what one that rolls answers, from those up to n of what it is given:
 * 13 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void rolling_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(7 <= WIDTH && 13 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double root_first = series->terms[0][ELEMENT_ROOT];
    const double inverse_radius = inverse(m->clearance + (m->squared * (root_first * root_first) + (1.0 - m->squared) * root_first));
    sum_known(series, n, 4);
    const double root = here[ELEMENT_ROOT];
    const double x = here[ELEMENT_X];
    const double y = here[ELEMENT_Y];
    const double vx = here[ELEMENT_VX];
    const double vy = here[ELEMENT_VY];
    const double spin = here[ELEMENT_SPIN];
    const double race = here[ELEMENT_RACE];
    const double w0 = times(series, 0, n, root, root); /* root * root */
    const double w1 = m->squared * w0 + (1.0 - m->squared) * root;
    const double radius = one * m->clearance + w1;
    const double normal_x = over(series, 1, n, x, radius, inverse_radius); /* x / radius */
    const double normal_y = over(series, 2, n, y, radius, inverse_radius); /* y / radius */
    const double w5 = times(series, 3, n, normal_x, vx); /* normal_x * vx */
    const double w6 = times(series, 4, n, normal_y, vy); /* normal_y * vy */
    const double approach = w5 + w6;
    const double w8 = times(series, 5, n, normal_x, vy); /* normal_x * vy */
    const double w9 = times(series, 6, n, normal_y, vx); /* normal_y * vx */
    const double across = w8 - w9;
    const double slip = across + m->radius * spin - m->race_radius * race;
    /* w1 * (hertz * root + linear) */
    const double w12 = times(series, 7, n, w1, m->hertz * root + one * m->linear);
    /* (1.0 + contact_damping * approach) * w12 */
    const double w13 = times(series, 8, n, one * 1.0 + m->contact_damping * approach, w12);
    const double push = (1.0 - m->loose) * w13;
    const double w15 = times(series, 9, n, w13, normal_y); /* w13 * normal_y */
    const double w16 = times(series, 10, n, w13, normal_x); /* w13 * normal_x */
    const double push_x = (1.0 - m->loose) * w16;
    const double force_x = m->friction * m->sigma * (1.0 - m->loose) * w15 - push_x;
    const double push_y = (1.0 - m->loose) * w15;
    const double force_y = -(m->friction * m->sigma * (1.0 - m->loose)) * w16 - push_y;
    const double w21 = times(series, 11, n, approach, across); /* approach * across */
    const double turning = over(series, 12, n, w21, radius, inverse_radius); /* w21 / radius */
    answers[ELEMENT_NORMAL_X] = normal_x;
    answers[ELEMENT_NORMAL_Y] = normal_y;
    answers[ELEMENT_APPROACH] = approach;
    answers[ELEMENT_SLIP] = slip;
    answers[ELEMENT_PUSH] = push;
    answers[ELEMENT_FORCE_X] = force_x;
    answers[ELEMENT_FORCE_Y] = force_y;
    answers[ELEMENT_TURNING] = turning;
}

/* Coefficient n of what one with a stator without mass answers, from those up to n of what it is given:
 * 14 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void massless_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(7 <= WIDTH && 14 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double root_first = series->terms[0][ELEMENT_ROOT];
    const double inverse_radius = inverse(m->clearance + (m->squared * (root_first * root_first) + (1.0 - m->squared) * root_first));
    const double inverse_softened = inverse(1.0 + m->mobility * m->contact_damping * ((m->squared * (root_first * root_first) + (1.0 - m->squared) * root_first) * (m->hertz * root_first + m->linear)));
    sum_known(series, n, 4);
    const double root = here[ELEMENT_ROOT];
    const double x = here[ELEMENT_X];
    const double y = here[ELEMENT_Y];
    const double vx = here[ELEMENT_VX];
    const double vy = here[ELEMENT_VY];
    const double spin = here[ELEMENT_SPIN];
    const double race = here[ELEMENT_RACE];
    const double w0 = times(series, 0, n, root, root); /* root * root */
    const double w1 = m->squared * w0 + (1.0 - m->squared) * root;
    const double radius = one * m->clearance + w1;
    const double normal_x = over(series, 1, n, x, radius, inverse_radius); /* x / radius */
    const double normal_y = over(series, 2, n, y, radius, inverse_radius); /* y / radius */
    const double w5 = times(series, 3, n, normal_x, vx); /* normal_x * vx */
    const double w6 = times(series, 4, n, normal_y, vy); /* normal_y * vy */
    const double approach = w5 + w6;
    /* w1 * (hertz * root + linear) */
    const double spring = times(series, 5, n, w1, m->hertz * root + one * m->linear);
    /* (1.0 + contact_damping * approach) * spring */
    const double w9 = times(series, 6, n, one * 1.0 + m->contact_damping * approach, spring);
    const double softened = one * 1.0 + m->mobility * m->contact_damping * spring;
    const double w11 = over(series, 7, n, w9, softened, inverse_softened); /* w9 / softened */
    const double approach_ = approach - m->mobility * (1.0 - m->loose) * w11;
    const double w13 = times(series, 8, n, normal_x, vy); /* normal_x * vy */
    const double w14 = times(series, 9, n, normal_y, vx); /* normal_y * vx */
    const double across = w13 - w14;
    const double rim = m->radius * spin - m->race_radius * race;
    const double drag = m->friction * m->sigma * (1.0 - m->loose) * w11 + m->holding * (across + rim);
    const double across_ = across - m->mobility * drag;
    const double slip = across_ + rim;
    const double push = (1.0 - m->loose) * w11;
    const double w21 = times(series, 10, n, drag, normal_y); /* drag * normal_y */
    const double w22 = times(series, 11, n, w11, normal_x); /* w11 * normal_x */
    const double force_x = w21 - (1.0 - m->loose) * w22;
    const double w24 = times(series, 12, n, drag, normal_x); /* drag * normal_x */
    const double w25 = times(series, 13, n, w11, normal_y); /* w11 * normal_y */
    const double force_y = -w24 - (1.0 - m->loose) * w25;
    answers[ELEMENT_NORMAL_X] = normal_x;
    answers[ELEMENT_NORMAL_Y] = normal_y;
    answers[ELEMENT_APPROACH] = approach_;
    answers[ELEMENT_SLIP] = slip;
    answers[ELEMENT_PUSH] = push;
    answers[ELEMENT_FORCE_X] = force_x;
    answers[ELEMENT_FORCE_Y] = force_y;
    answers[ELEMENT_DRAG] = drag;
}

/* What it answers, as values. */
static inline __attribute__((always_inline)) void massless_values(
    const struct element *m, const double *state, double *answers)
{
    const double root = state[ELEMENT_ROOT];
    const double x = state[ELEMENT_X];
    const double y = state[ELEMENT_Y];
    const double vx = state[ELEMENT_VX];
    const double vy = state[ELEMENT_VY];
    const double spin = state[ELEMENT_SPIN];
    const double race = state[ELEMENT_RACE];
    const double w0 = root * root;
    const double w1 = m->squared * w0 + (1.0 - m->squared) * root;
    const double radius = m->clearance + w1;
    const double normal_x = ratio(x, radius);
    const double normal_y = ratio(y, radius);
    const double w5 = normal_x * vx;
    const double w6 = normal_y * vy;
    const double approach = w5 + w6;
    const double spring = w1 * (m->hertz * root + m->linear);
    const double w9 = (1.0 + m->contact_damping * approach) * spring;
    const double softened = 1.0 + m->mobility * m->contact_damping * spring;
    const double w11 = ratio(w9, softened);
    const double approach_ = approach - m->mobility * (1.0 - m->loose) * w11;
    const double w13 = normal_x * vy;
    const double w14 = normal_y * vx;
    const double across = w13 - w14;
    const double rim = m->radius * spin - m->race_radius * race;
    const double drag = m->friction * m->sigma * (1.0 - m->loose) * w11 + m->holding * (across + rim);
    const double across_ = across - m->mobility * drag;
    const double slip = across_ + rim;
    const double push = (1.0 - m->loose) * w11;
    const double w21 = drag * normal_y;
    const double w22 = w11 * normal_x;
    const double force_x = w21 - (1.0 - m->loose) * w22;
    const double w24 = drag * normal_x;
    const double w25 = w11 * normal_y;
    const double force_y = -w24 - (1.0 - m->loose) * w25;
    answers[ELEMENT_NORMAL_X] = normal_x;
    answers[ELEMENT_NORMAL_Y] = normal_y;
    answers[ELEMENT_APPROACH] = approach_;
    answers[ELEMENT_SLIP] = slip;
    answers[ELEMENT_PUSH] = push;
    answers[ELEMENT_FORCE_X] = force_x;
    answers[ELEMENT_FORCE_Y] = force_y;
    answers[ELEMENT_DRAG] = drag;
}

/* Coefficient n of what one without clearance answers, from those up to n of what it is given:
 * 6 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void centred_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(7 <= WIDTH && 6 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double x_first = series->terms[0][ELEMENT_X];
    const double y_first = series->terms[0][ELEMENT_Y];
    const double first_w3 = sqrt(sqrt(x_first * x_first + y_first * y_first));
    const double inverse_w2 = inverse(x_first * x_first + y_first * y_first);
    sum_known(series, n, 2);
    const double x = here[ELEMENT_X];
    const double y = here[ELEMENT_Y];
    const double w0 = times(series, 0, n, x, x); /* x * x */
    const double w1 = times(series, 1, n, y, y); /* y * y */
    const double w2 = w0 + w1;
    /* w2**0.25 */
    const double w3 = raised(series, 2, n, w2, 0.25, one * first_w3, inverse_w2);
    const double push = m->hertz * w3 + one * m->linear;
    const double w5 = times(series, 4, n, push, x); /* push * x */
    const double w6 = times(series, 5, n, push, y); /* push * y */
    answers[ELEMENT_FORCE_X] = -w5;
    answers[ELEMENT_FORCE_Y] = -w6;
}

/* What it answers, as values. */
static inline __attribute__((always_inline)) void centred_values(
    const struct element *m, const double *state, double *answers)
{
    const double x = state[ELEMENT_X];
    const double y = state[ELEMENT_Y];
    const double w0 = x * x;
    const double w1 = y * y;
    const double w2 = w0 + w1;
    const double w3 = sqrt(sqrt(w2));
    const double push = m->hertz * w3 + m->linear;
    const double w5 = push * x;
    const double w6 = push * y;
    answers[ELEMENT_FORCE_X] = -w5;
    answers[ELEMENT_FORCE_Y] = -w6;
}

/* Coefficient n of what a contact that is moved a little answers, from those up to n of what it is given:
 * 13 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void slope_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(6 <= WIDTH && 13 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double root_first = series->terms[0][SLOPE_ROOT];
    const double inverse_radius = inverse(m->clearance + (m->squared * (root_first * root_first) + (1.0 - m->squared) * root_first));
    sum_known(series, n, 4);
    const double root = here[SLOPE_ROOT];
    const double approach = here[SLOPE_APPROACH];
    const double across = here[SLOPE_ACROSS];
    const double push = here[SLOPE_PUSH];
    const double drag = here[SLOPE_DRAG];
    const double pull = here[SLOPE_PULL];
    /* (1.5 * hertz * root + linear) * (1.0 + contact_damping * approach) */
    const double along = times(series, 0, n, 1.5 * m->hertz * root + one * m->linear, one * 1.0 + m->contact_damping * approach);
    const double w1 = times(series, 1, n, root, root); /* root * root */
    const double w2 = m->squared * w1 + (1.0 - m->squared) * root;
    const double radius = one * m->clearance + w2;
    /* across / radius */
    const double across_share = over(series, 2, n, across, radius, inverse_radius);
    /* w2 * (hertz * root + linear) */
    const double spring = times(series, 3, n, w2, m->hertz * root + one * m->linear);
    const double w6 = times(series, 4, n, across_share, spring); /* across_share * spring */
    const double resisted = m->contact_damping * spring;
    const double w8 = over(series, 5, n, push, radius, inverse_radius); /* push / radius */
    const double w9 = over(series, 6, n, drag, radius, inverse_radius); /* drag / radius */
    /* approach / radius */
    const double approach_share = over(series, 7, n, approach, radius, inverse_radius);
    /* across_share * across_share */
    const double w11 = times(series, 8, n, across_share, across_share);
    /* approach_share * approach_share */
    const double w12 = times(series, 9, n, approach_share, approach_share);
    /* approach_share * across_share */
    const double w13 = times(series, 10, n, approach_share, across_share);
    const double w14 = over(series, 11, n, pull, radius, inverse_radius); /* pull / radius */
    const double w15 = times(series, 12, n, spring, approach); /* spring * approach */
    answers[SLOPE_BY_ALONG] = along;
    answers[SLOPE_BY_ASIDE] = m->contact_damping * w6;
    answers[SLOPE_BY_RATE] = resisted;
    answers[SLOPE_BY_PUSH_SHARE] = w8;
    answers[SLOPE_BY_DRAG_SHARE] = w9;
    answers[SLOPE_BY_APPROACH_SHARE] = approach_share;
    answers[SLOPE_BY_ACROSS_SHARE] = across_share;
    answers[SLOPE_BY_DIFFERENCE] = w11 - w12;
    answers[SLOPE_BY_PRODUCT] = w13;
    answers[SLOPE_BY_PULL_SHARE] = w14;
    answers[SLOPE_BY_CONTACT_DAMPING] = w15;
}

/* Coefficient n of what one without clearance that is moved a little answers, from those up to n of what it is given:
 * 10 lanes, which must be empty at n = 0. */
static inline __attribute__((always_inline)) void centred_slope_order(
    const struct element *m, struct series *series, int n, double *answers)
{
    _Static_assert(7 <= WIDTH && 10 <= LANES, "no room");
    const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;
    const double x_first = series->terms[0][ELEMENT_X];
    const double y_first = series->terms[0][ELEMENT_Y];
    const double first_w3 = sqrt(sqrt(x_first * x_first + y_first * y_first));
    const double inverse_w2 = inverse(x_first * x_first + y_first * y_first);
    sum_known(series, n, 3);
    const double x = here[ELEMENT_X];
    const double y = here[ELEMENT_Y];
    const double w0 = times(series, 0, n, x, x); /* x * x */
    const double w1 = times(series, 1, n, y, y); /* y * y */
    const double w2 = w0 + w1;
    /* w2**0.25 */
    const double w3 = raised(series, 2, n, w2, 0.25, one * first_w3, inverse_w2);
    const double w4 = over(series, 4, n, w3, w2, inverse_w2); /* w3 / w2 */
    const double w5 = times(series, 5, n, w4, x); /* w4 * x */
    const double w6 = times(series, 6, n, w5, x); /* w5 * x */
    const double w7 = m->hertz * w3 + one * m->linear;
    const double w8 = times(series, 7, n, w4, y); /* w4 * y */
    const double w9 = times(series, 8, n, w8, x); /* w8 * x */
    const double w10 = times(series, 9, n, w8, y); /* w8 * y */
    answers[CENTRED_X_BY_X] = -(0.5 * m->hertz * w6 + w7);
    answers[CENTRED_X_BY_Y] = -0.5 * m->hertz * w9;
    answers[CENTRED_Y_BY_Y] = -(0.5 * m->hertz * w10 + w7);
}

#endif
