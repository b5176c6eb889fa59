/* Derived from rotor_ida/model/modes.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifndef WHOLE_MODEL
#include "motion.h"

const struct mode rub_mode = {0}; /* of other models */

const struct mode rolling_mode = {0}; /* of other models */

/* The rates of change of q, p, h, c, s, t, j, drawn back to where they belong. */
static void contact_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double of_q = 0.5 * p;
    const double square = q * q;
    const double spring = square * q;
    const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - spring;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double outwards = radial + centrifugal;
    const double of_p = outwards * q;
    const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around;
    const double moment = tangential * r;
    const double of_h = moment * q;
    const double turned = spin * q;
    const double turn = turned - m->omega * q;
    const double w15 = turn * s;
    const double of_c = -w15;
    const double w17 = c * c;
    const double w18 = s * s;
    const double w19 = (1.0 - (w17 + w18)) * q;
    const double w20 = w19 * c;
    const double of_s = turn * c;
    const double w22 = w19 * s;
    const double of_j = spring * q;
    rate[CONTACT_Q] = of_q;
    rate[CONTACT_P] = of_p;
    rate[CONTACT_H] = of_h;
    rate[CONTACT_C] = of_c + 0.1 * m->omega * w20;
    rate[CONTACT_S] = of_s + 0.1 * m->omega * w22;
    rate[CONTACT_T] = q;
    rate[CONTACT_J] = of_j;
}

/* Their derivatives by each of these, column by column. */
static void contact_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 49; i++)
        matrix[i] = 0.0;
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double square = q * q;
    const double spring = square * q;
    const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - spring;
    const double w3 = square + m->delta0;
    const double w4 = ratio(h, w3);
    const double w5 = ratio(w4, w3);
    const double w6 = w5 * w4;
    const double w7 = 2.0 * square + square;
    const double w8 = w4 * q;
    const double w9 = ratio(w8, w3);
    const double w10 = w9 * w5;
    const double w11 = w5 * q;
    const double w12 = ratio(-2.0 * w9 - 2.0 * w11, w3);
    const double w13 = w12 * w4;
    const double w14 = (-w7 + (-2.0 * w10 + w13)) * q;
    const double w15 = -(m->omega * m->omega) * s - 2.0 * m->zeta * w4;
    const double w16 = w15 * w3;
    const double w17 = w15 * q;
    const double w18 = w9 * w3;
    const double w19 = (2.0 * w17 + 4.0 * m->zeta * w18) * q;
    const double w20 = w12 * q;
    const double w21 = w5 + w20 - m->omega;
    const double w22 = w21 * s;
    const double w23 = c * c;
    const double w24 = s * s;
    const double w25 = -(w23 + w24) + 1.0;
    const double w26 = w25 * c;
    const double w27 = w21 * c;
    const double w28 = w25 * s;
    const double w29 = w7 * q;
    const double w30 = ratio(1.0, w3);
    const double w31 = w5 * w30;
    const double w32 = ratio(w30, w3);
    const double w33 = w32 * w4;
    const double w34 = (w31 + w33) * q;
    const double w35 = w30 * w3;
    const double w36 = w35 * q;
    const double w37 = w32 * q;
    const double w38 = w37 * s;
    const double w39 = w37 * c;
    const double w40 = q * c;
    const double w41 = w40 * c;
    const double w42 = w25 * q;
    const double w43 = 0.1 * m->omega * w42;
    const double w44 = w11 - m->omega * q;
    const double w45 = w40 * s;
    const double w46 = w3 * q;
    const double w47 = q * s;
    const double w48 = w47 * c;
    const double w49 = w47 * s;
    matrix[1] = radial + w6 + w14;
    matrix[2] = w16 + w19;
    matrix[3] = -w22 + 0.1 * m->omega * w26;
    matrix[4] = w27 + 0.1 * m->omega * w28;
    matrix[5] = 1.0;
    matrix[6] = spring + w29;
    matrix[7] = 0.5;
    matrix[8] = -2.0 * m->zeta * q;
    matrix[15] = w34;
    matrix[16] = -2.0 * m->zeta * w36;
    matrix[17] = -w38;
    matrix[18] = w39;
    matrix[22] = m->omega * m->omega * q;
    matrix[24] = -0.2 * m->omega * w41 + w43;
    matrix[25] = w44 - 0.2 * m->omega * w45;
    matrix[30] = -(m->omega * m->omega) * w46;
    matrix[31] = -w44 - 0.2 * m->omega * w48;
    matrix[32] = -0.2 * m->omega * w49 + w43;
}

/* The rates of a small difference are this matrix times it. */
static void contact_growth(const struct parameters *m,
    const double *state, double growth[4][4])
{
    const double q = state[CONTACT_Q];
    const double h = state[CONTACT_H];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double turned = spin * q;
    const double w5 = ratio(1.0, r);
    const double spring = square * q;
    const double w7 = w5 * spring;
    const double w8 = w7 * q;
    growth[0][0] = 0.0;
    growth[0][1] = turned;
    growth[0][2] = q;
    growth[0][3] = 0.0;
    growth[1][0] = -turned;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = q;
    growth[2][0] = -1.5 * square;
    growth[2][1] = 0.0;
    growth[2][2] = -2.0 * m->zeta * q;
    growth[2][3] = turned;
    growth[3][0] = 0.0;
    growth[3][1] = -w8;
    growth[3][2] = -turned;
    growth[3][3] = -2.0 * m->zeta * q;
}

/* What omega, zeta, delta0 add to the rates by time of position and velocity. */
static void contact_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    added[0][0] = 0.0;
    added[0][1] = -r;
    added[0][2] = 2.0 * m->omega * c + around;
    added[0][3] = -2.0 * m->omega * s - p;
    added[1][0] = 0.0;
    added[1][1] = 0.0;
    added[1][2] = -2.0 * p;
    added[1][3] = -2.0 * around;
    added[2][0] = 0.0;
    added[2][1] = 0.0;
    added[2][2] = 1.5 * q;
    added[2][3] = 0.0;
}

/* The Taylor series of the state: 12 lanes. */
static void contact_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(7 <= WIDTH && 12 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][CONTACT_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 3);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[CONTACT_Q];
        const double p = here[CONTACT_P];
        const double h = here[CONTACT_H];
        const double c = here[CONTACT_C];
        const double s = here[CONTACT_S];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        const double spring = times(series, 1, n, square, q); /* square * q */
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - spring;
        const double r = one * m->delta0 + square;
        const double around = over(series, 2, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 3, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 4, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 5, n, outwards, q); /* outwards * q */
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around;
        const double moment = times(series, 6, n, tangential, r); /* tangential * r */
        const double of_h = times(series, 7, n, moment, q); /* moment * q */
        const double turned = times(series, 8, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w15 = times(series, 9, n, turn, s); /* turn * s */
        const double of_c = -w15;
        const double of_s = times(series, 10, n, turn, c); /* turn * c */
        const double of_j = times(series, 11, n, spring, q); /* spring * q */
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        one = 0.0;
    }
}

/* The Taylor series of the state, and the factors of differences: 15 lanes. */
static void contact_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(7 <= WIDTH && 15 <= LANES && 4 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][CONTACT_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 4);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[CONTACT_Q];
        const double p = here[CONTACT_P];
        const double h = here[CONTACT_H];
        const double c = here[CONTACT_C];
        const double s = here[CONTACT_S];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        const double spring = times(series, 1, n, square, q); /* square * q */
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - spring;
        const double r = one * m->delta0 + square;
        const double around = over(series, 2, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 3, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 4, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 5, n, outwards, q); /* outwards * q */
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around;
        const double moment = times(series, 6, n, tangential, r); /* tangential * r */
        const double of_h = times(series, 7, n, moment, q); /* moment * q */
        const double turned = times(series, 8, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w15 = times(series, 9, n, turn, s); /* turn * s */
        const double of_c = -w15;
        const double of_s = times(series, 10, n, turn, c); /* turn * c */
        const double of_j = times(series, 11, n, spring, q); /* spring * q */
        const double w19 = over(series, 12, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double w20 = times(series, 13, n, w19, spring); /* w19 * spring */
        const double w21 = times(series, 14, n, w20, q); /* w20 * q */
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        series->factors[0][n] = q;
        series->factors[1][n] = turned;
        series->factors[2][n] = -1.5 * square;
        series->factors[3][n] = -w21;
        one = 0.0;
    }
}

/* The Taylor series of four differences, from the factors that the state has given. */
static void contact_expand_differences(const struct parameters *m,
    struct series *series, int order)
{
    for (int n = 0; n < order; n++) {
        const vec4 vx = load(&series->apart[n][8]);
        const vec4 vy = load(&series->apart[n][12]);
        /* what does not change in time */
        store(&series->steady[n][0], vx);
        store(&series->steady[n][4], vy);
        store(&series->steady[n][8], spread(-2.0 * m->zeta) * vx);
        store(&series->steady[n][12], spread(-2.0 * m->zeta) * vy);
        vec4 sum_x = spread(0.0);
        vec4 sum_y = spread(0.0);
        vec4 sum_vx = spread(0.0);
        vec4 sum_vy = spread(0.0);
        /* the row written last comes last, as it is waited for */
        for (int k = 0; k <= n; k++) {
            const vec4 pace = spread(series->factors[0][n - k]);
            sum_x = fma4(pace, load(&series->steady[k][0]), sum_x);
            sum_y = fma4(pace, load(&series->steady[k][4]), sum_y);
            sum_vx = fma4(pace, load(&series->steady[k][8]), sum_vx);
            sum_vy = fma4(pace, load(&series->steady[k][12]), sum_vy);
            const vec4 f1 = spread(series->factors[1][n - k]);
            sum_x = fma4(f1, load(&series->apart[k][4]), sum_x);
            sum_y = fma4(-f1, load(&series->apart[k][0]), sum_y);
            sum_vx = fma4(f1, load(&series->apart[k][12]), sum_vx);
            sum_vy = fma4(-f1, load(&series->apart[k][8]), sum_vy);
            const vec4 f2 = spread(series->factors[2][n - k]);
            sum_vx = fma4(f2, load(&series->apart[k][0]), sum_vx);
            const vec4 f3 = spread(series->factors[3][n - k]);
            sum_vy = fma4(f3, load(&series->apart[k][4]), sum_vy);
        }
        const vec4 share = spread(1.0 / (n + 1));
        store(&series->apart[n + 1][0], share * sum_x);
        store(&series->apart[n + 1][4], share * sum_y);
        store(&series->apart[n + 1][8], share * sum_vx);
        store(&series->apart[n + 1][12], share * sum_vy);
    }
}

const struct mode contact_mode = {
    .size = CONTACT_SIZE,
    .field = contact_field,
    .jacobian = contact_jacobian,
    .growth = contact_growth,
    .by_parameters = contact_by_parameters,
    .expand = contact_expand,
    .expand_with_factors = contact_expand_with_factors,
    .expand_differences = contact_expand_differences,
};

/* The rates of change of x, y, vx, vy. */
static void cartesian_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    const double w0 = x * x;
    const double w1 = y * y;
    const double square = w0 + w1;
    const double w3 = sqrt(sqrt(square));
    const double w4 = w3 * x;
    const double w5 = w3 * y;
    rate[CARTESIAN_X] = vx + m->omega * y;
    rate[CARTESIAN_Y] = vy - m->omega * x;
    rate[CARTESIAN_VX] = m->omega * m->omega - 2.0 * m->zeta * vx - m->felt * w4 + m->omega * vy;
    rate[CARTESIAN_VY] = -2.0 * m->zeta * vy - m->felt * w5 - m->omega * vx;
}

/* Their derivatives by each of these, column by column. */
static void cartesian_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 16; i++)
        matrix[i] = 0.0;
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double w0 = x * x;
    const double w1 = y * y;
    const double square = w0 + w1;
    const double w3 = sqrt(sqrt(square));
    const double w4 = ratio(w3, square);
    const double w5 = w4 * x;
    const double w6 = w5 * x;
    const double push = m->felt * w3;
    const double w8 = w5 * y;
    const double w9 = w4 * y;
    const double w10 = w9 * x;
    const double w11 = w9 * y;
    matrix[1] = -m->omega;
    matrix[2] = -(0.5 * m->felt * w6 + push);
    matrix[3] = -0.5 * m->felt * w8;
    matrix[4] = m->omega;
    matrix[6] = -0.5 * m->felt * w10;
    matrix[7] = -(0.5 * m->felt * w11 + push);
    matrix[8] = 1.0;
    matrix[10] = -2.0 * m->zeta;
    matrix[11] = -m->omega;
    matrix[13] = 1.0;
    matrix[14] = m->omega;
    matrix[15] = -2.0 * m->zeta;
}

/* The rates of a small difference are this matrix times it. */
static void cartesian_growth(const struct parameters *m,
    const double *state, double growth[4][4])
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double w0 = x * x;
    const double w1 = y * y;
    const double square = w0 + w1;
    const double w3 = sqrt(sqrt(square));
    const double w4 = ratio(w3, square);
    const double w5 = w4 * x;
    const double w6 = w5 * x;
    const double push = m->felt * w3;
    const double w8 = w4 * y;
    const double w9 = w8 * x;
    const double w10 = w5 * y;
    const double w11 = w8 * y;
    growth[0][0] = 0.0;
    growth[0][1] = m->omega;
    growth[0][2] = 1.0;
    growth[0][3] = 0.0;
    growth[1][0] = -m->omega;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = 1.0;
    growth[2][0] = -(0.5 * m->felt * w6 + push);
    growth[2][1] = -0.5 * m->felt * w9;
    growth[2][2] = -2.0 * m->zeta;
    growth[2][3] = m->omega;
    growth[3][0] = -0.5 * m->felt * w10;
    growth[3][1] = -(0.5 * m->felt * w11 + push);
    growth[3][2] = -m->omega;
    growth[3][3] = -2.0 * m->zeta;
}

/* What omega, zeta, delta0 add to the rates by time of position and velocity. */
static void cartesian_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    added[0][0] = y;
    added[0][1] = -x;
    added[0][2] = 2.0 * m->omega + vy;
    added[0][3] = -vx;
    added[1][0] = 0.0;
    added[1][1] = 0.0;
    added[1][2] = -2.0 * vx;
    added[1][3] = -2.0 * vy;
    added[2][0] = 0.0;
    added[2][1] = 0.0;
    added[2][2] = 0.0;
    added[2][3] = 0.0;
}

/* The Taylor series of the state: 6 lanes. */
static void cartesian_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(4 <= WIDTH && 6 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double x_first = series->terms[0][CARTESIAN_X];
    const double y_first = series->terms[0][CARTESIAN_Y];
    const double first_w3 = sqrt(sqrt(x_first * x_first + y_first * y_first));
    const double inverse_square = inverse(x_first * x_first + y_first * y_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 2);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double x = here[CARTESIAN_X];
        const double y = here[CARTESIAN_Y];
        const double vx = here[CARTESIAN_VX];
        const double vy = here[CARTESIAN_VY];
        const double w0 = times(series, 0, n, x, x); /* x * x */
        const double w1 = times(series, 1, n, y, y); /* y * y */
        const double square = w0 + w1;
        /* square**0.25 */
        const double w3 = raised(series, 2, n, square, 0.25, one * first_w3, inverse_square);
        const double w4 = times(series, 4, n, w3, x); /* w3 * x */
        const double w5 = times(series, 5, n, w3, y); /* w3 * y */
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w4 + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - m->felt * w5 - m->omega * vx) * share;
        one = 0.0;
    }
}

/* The Taylor series of the state, and the factors of differences: 13 lanes. */
static void cartesian_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(4 <= WIDTH && 13 <= LANES && 4 <= FACTORS, "series.h has no room for this mode");
    const double x_first = series->terms[0][CARTESIAN_X];
    const double y_first = series->terms[0][CARTESIAN_Y];
    const double first_w3 = sqrt(sqrt(x_first * x_first + y_first * y_first));
    const double inverse_square = inverse(x_first * x_first + y_first * y_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 4);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double x = here[CARTESIAN_X];
        const double y = here[CARTESIAN_Y];
        const double vx = here[CARTESIAN_VX];
        const double vy = here[CARTESIAN_VY];
        const double w0 = times(series, 0, n, x, x); /* x * x */
        const double w1 = times(series, 1, n, y, y); /* y * y */
        const double square = w0 + w1;
        /* square**0.25 */
        const double w3 = raised(series, 2, n, square, 0.25, one * first_w3, inverse_square);
        const double w4 = times(series, 4, n, w3, x); /* w3 * x */
        const double w5 = times(series, 5, n, w3, y); /* w3 * y */
        const double w6 = over(series, 6, n, w3, square, inverse_square); /* w3 / square */
        const double w7 = times(series, 7, n, w6, x); /* w6 * x */
        const double w8 = times(series, 8, n, w7, x); /* w7 * x */
        const double push = m->felt * w3;
        const double w10 = times(series, 9, n, w6, y); /* w6 * y */
        const double w11 = times(series, 10, n, w10, x); /* w10 * x */
        const double w12 = times(series, 11, n, w7, y); /* w7 * y */
        const double w13 = times(series, 12, n, w10, y); /* w10 * y */
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w4 + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - m->felt * w5 - m->omega * vx) * share;
        series->factors[0][n] = -(0.5 * m->felt * w8 + push);
        series->factors[1][n] = -0.5 * m->felt * w11;
        series->factors[2][n] = -0.5 * m->felt * w12;
        series->factors[3][n] = -(0.5 * m->felt * w13 + push);
        one = 0.0;
    }
}

/* The Taylor series of four differences, from the factors that the state has given. */
static void cartesian_expand_differences(const struct parameters *m,
    struct series *series, int order)
{
    for (int n = 0; n < order; n++) {
        const vec4 x = load(&series->apart[n][0]);
        const vec4 y = load(&series->apart[n][4]);
        const vec4 vx = load(&series->apart[n][8]);
        const vec4 vy = load(&series->apart[n][12]);
        /* what does not change in time */
        vec4 sum_x = spread(m->omega) * y + vx;
        vec4 sum_y = spread(-m->omega) * x + vy;
        vec4 sum_vx = spread(-2.0 * m->zeta) * vx + spread(m->omega) * vy;
        vec4 sum_vy = spread(-m->omega) * vx + spread(-2.0 * m->zeta) * vy;
        /* the row written last comes last, as it is waited for */
        for (int k = 0; k <= n; k++) {
            const vec4 f0 = spread(series->factors[0][n - k]);
            sum_vx = fma4(f0, load(&series->apart[k][0]), sum_vx);
            const vec4 f1 = spread(series->factors[1][n - k]);
            sum_vx = fma4(f1, load(&series->apart[k][4]), sum_vx);
            const vec4 f2 = spread(series->factors[2][n - k]);
            sum_vy = fma4(f2, load(&series->apart[k][0]), sum_vy);
            const vec4 f3 = spread(series->factors[3][n - k]);
            sum_vy = fma4(f3, load(&series->apart[k][4]), sum_vy);
        }
        const vec4 share = spread(1.0 / (n + 1));
        store(&series->apart[n + 1][0], share * sum_x);
        store(&series->apart[n + 1][4], share * sum_y);
        store(&series->apart[n + 1][8], share * sum_vx);
        store(&series->apart[n + 1][12], share * sum_vy);
    }
}

const struct mode cartesian_mode = {
    .size = CARTESIAN_SIZE,
    .field = cartesian_field,
    .jacobian = cartesian_jacobian,
    .growth = cartesian_growth,
    .by_parameters = cartesian_by_parameters,
    .expand = cartesian_expand,
    .expand_with_factors = cartesian_expand_with_factors,
    .expand_differences = cartesian_expand_differences,
};

#endif
