/* Derived from rotor_ida/equations/modes.py by `python -m rotor_ida.equations.writing`. */
/* clang-format off */
#ifdef WHOLE_MODEL
#include "motion.h"

/* The rates of change of q, p, h, c, s, down_r, down_t, t, j, work, spent, drawn back to where they belong. */
static void contact_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double down_r = state[CONTACT_DOWN_R];
    const double down_t = state[CONTACT_DOWN_T];
    const double of_q = 0.5 * p;
    const double square = q * q;
    const double push = (m->hertz * q + m->linear) * square;
    const double w3 = push * (1.0 + m->contact_damping * p);
    const double push_ = m->pressed * w3;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push_ - m->shaft_stiffness * r + m->load * down_r + centrifugal;
    const double of_p = outwards * q;
    const double sideways = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
    const double moment = sideways * r;
    const double of_h = moment * q;
    const double turned = spin * q;
    const double turn = turned - m->omega * q;
    const double w16 = turn * s;
    const double of_c = -w16;
    const double w18 = c * c;
    const double w19 = s * s;
    const double w20 = (1.0 - (w18 + w19)) * q;
    const double w21 = w20 * c;
    const double of_s = turn * c;
    const double w23 = w20 * s;
    const double of_down_r = turned * down_t;
    const double w25 = down_r * down_r;
    const double w26 = down_t * down_t;
    const double w27 = (1.0 - (w25 + w26)) * q;
    const double w28 = w27 * down_r;
    const double w29 = turned * down_r;
    const double of_down_t = -w29;
    const double w31 = w27 * down_t;
    const double w32 = w3 * q;
    const double of_j = m->pressed * w32;
    const double w34 = w32 * p;
    const double w35 = p * p;
    const double w36 = around * around;
    const double damped = 2.0 * m->zeta * (w35 + w36 - m->omega * h);
    const double w38 = r * down_t;
    const double w39 = (damped + m->load * m->omega * w38) * q;
    rate[CONTACT_Q] = of_q;
    rate[CONTACT_P] = of_p;
    rate[CONTACT_H] = of_h;
    rate[CONTACT_C] = of_c + 0.1 * m->omega * w21;
    rate[CONTACT_S] = of_s + 0.1 * m->omega * w23;
    rate[CONTACT_DOWN_R] = of_down_r + 0.1 * m->omega * w28;
    rate[CONTACT_DOWN_T] = of_down_t + 0.1 * m->omega * w31;
    rate[CONTACT_T] = q;
    rate[CONTACT_J] = of_j;
    rate[CONTACT_WORK] = m->pressed * w34;
    rate[CONTACT_SPENT] = w39;
}

/* Their derivatives by each of these, column by column. */
static void contact_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 121; i++)
        matrix[i] = 0.0;
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double down_r = state[CONTACT_DOWN_R];
    const double down_t = state[CONTACT_DOWN_T];
    const double w0 = m->hertz * q + m->linear;
    const double square = q * q;
    const double push = w0 * square;
    const double w3 = m->contact_damping * p + 1.0;
    const double w4 = push * w3;
    const double w5 = m->pressed * w4;
    const double w6 = square + m->delta0;
    const double w7 = ratio(h, w6);
    const double w8 = ratio(w7, w6);
    const double w9 = w8 * w7;
    const double w10 = w0 * q;
    const double w11 = (2.0 * w10 + m->hertz * square) * w3;
    const double w12 = w7 * q;
    const double w13 = ratio(w12, w6);
    const double w14 = w13 * w8;
    const double w15 = w8 * q;
    const double w16 = ratio(-2.0 * w13 - 2.0 * w15, w6);
    const double w17 = w16 * w7;
    const double w18 = (-m->pressed * w11 - 2.0 * m->shaft_stiffness * q + (-2.0 * w14 + w17)) * q;
    const double w19 = -(m->omega * m->omega) * s - 2.0 * m->zeta * w7 + m->load * down_t;
    const double w20 = w19 * w6;
    const double w21 = w19 * q;
    const double w22 = w13 * w6;
    const double w23 = (2.0 * w21 + 4.0 * m->zeta * w22) * q;
    const double w24 = w16 * q;
    const double w25 = w8 + w24;
    const double w26 = w25 - m->omega;
    const double w27 = w26 * s;
    const double w28 = c * c;
    const double w29 = s * s;
    const double w30 = -(w28 + w29) + 1.0;
    const double w31 = w30 * c;
    const double w32 = w26 * c;
    const double w33 = w30 * s;
    const double w34 = w25 * down_t;
    const double w35 = down_r * down_r;
    const double w36 = down_t * down_t;
    const double w37 = -(w35 + w36) + 1.0;
    const double w38 = w37 * down_r;
    const double w39 = w25 * down_r;
    const double w40 = w37 * down_t;
    const double w41 = w11 * q;
    const double w42 = (w5 + m->pressed * w41) * p;
    const double w43 = p * p;
    const double w44 = w7 * w7;
    const double w45 = w6 * down_t;
    const double w46 = w13 * w7;
    const double w47 = q * down_t;
    const double w48 = (-8.0 * m->zeta * w46 + 2.0 * (m->load * m->omega) * w47) * q;
    const double w49 = (-2.0 * m->zeta - m->pressed * m->contact_damping * push) * q;
    const double w50 = push * q;
    const double w51 = w50 * p;
    const double w52 = w4 * q;
    const double w53 = q * p;
    const double w54 = ratio(1.0, w6);
    const double w55 = w8 * w54;
    const double w56 = ratio(w54, w6);
    const double w57 = w56 * w7;
    const double w58 = (w55 + w57) * q;
    const double w59 = w54 * w6;
    const double w60 = w59 * q;
    const double w61 = w56 * q;
    const double w62 = w61 * s;
    const double w63 = w61 * c;
    const double w64 = w61 * down_t;
    const double w65 = w61 * down_r;
    const double w66 = w7 * w54;
    const double w67 = (2.0 * w66 - m->omega) * q;
    const double w68 = q * c;
    const double w69 = w68 * c;
    const double w70 = w30 * q;
    const double w71 = 0.1 * m->omega * w70;
    const double w72 = w15 - m->omega * q;
    const double w73 = w68 * s;
    const double w74 = w6 * q;
    const double w75 = q * s;
    const double w76 = w75 * c;
    const double w77 = w75 * s;
    const double w78 = q * down_r;
    const double w79 = w78 * down_r;
    const double w80 = w37 * q;
    const double w81 = 0.1 * m->omega * w80;
    const double w82 = w78 * down_t;
    const double w83 = w47 * down_r;
    const double w84 = w47 * down_t;
    matrix[1] = m->omega * m->omega * c - 2.0 * m->zeta * p - w5 - m->shaft_stiffness * w6 + m->load * down_r + w9 + w18;
    matrix[2] = w20 + w23;
    matrix[3] = -w27 + 0.1 * m->omega * w31;
    matrix[4] = w32 + 0.1 * m->omega * w33;
    matrix[5] = w34 + 0.1 * m->omega * w38;
    matrix[6] = -w39 + 0.1 * m->omega * w40;
    matrix[7] = 1.0;
    matrix[8] = w5 + m->pressed * w41;
    matrix[9] = w42;
    matrix[10] = 2.0 * m->zeta * (w43 + w44 - m->omega * h) + m->load * m->omega * w45 + w48;
    matrix[11] = 0.5;
    matrix[12] = w49;
    matrix[19] = m->pressed * m->contact_damping * w50;
    matrix[20] = m->pressed * m->contact_damping * w51 + m->pressed * w52;
    matrix[21] = 4.0 * m->zeta * w53;
    matrix[23] = w58;
    matrix[24] = -2.0 * m->zeta * w60;
    matrix[25] = -w62;
    matrix[26] = w63;
    matrix[27] = w64;
    matrix[28] = -w65;
    matrix[32] = 2.0 * m->zeta * w67;
    matrix[34] = m->omega * m->omega * q;
    matrix[36] = -0.2 * m->omega * w69 + w71;
    matrix[37] = w72 - 0.2 * m->omega * w73;
    matrix[46] = -(m->omega * m->omega) * w74;
    matrix[47] = -w72 - 0.2 * m->omega * w76;
    matrix[48] = -0.2 * m->omega * w77 + w71;
    matrix[56] = m->load * q;
    matrix[60] = -0.2 * m->omega * w79 + w81;
    matrix[61] = -w15 - 0.2 * m->omega * w82;
    matrix[68] = m->load * w74;
    matrix[71] = w15 - 0.2 * m->omega * w83;
    matrix[72] = -0.2 * m->omega * w84 + w81;
    matrix[76] = m->load * m->omega * w74;
}

/* The rates of a small difference are this matrix times it. */
static void contact_growth(const struct parameters *m,
    const double *state, double growth[4][4])
{
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double turned = spin * q;
    const double w5 = m->contact_damping * p + 1.0;
    const double w6 = (1.5 * m->hertz * q + m->linear) * w5;
    const double w7 = (-m->pressed * w6 - m->shaft_stiffness) * q;
    const double w8 = ratio(1.0, r);
    const double w9 = around * w8;
    const double push = (m->hertz * q + m->linear) * square;
    const double w11 = w9 * push;
    const double w12 = w11 * q;
    const double w13 = (-2.0 * m->zeta - m->pressed * m->contact_damping * push) * q;
    const double w14 = push * w5;
    const double w15 = w14 * w8;
    const double w16 = (-m->pressed * w15 - m->shaft_stiffness) * q;
    growth[0][0] = 0.0;
    growth[0][1] = turned;
    growth[0][2] = q;
    growth[0][3] = 0.0;
    growth[1][0] = -turned;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = q;
    growth[2][0] = w7;
    growth[2][1] = -(m->pressed * m->contact_damping) * w12;
    growth[2][2] = w13;
    growth[2][3] = turned;
    growth[3][0] = 0.0;
    growth[3][1] = w16;
    growth[3][2] = -turned;
    growth[3][3] = -2.0 * m->zeta * q;
}

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load add to the rates by time of position and velocity. */
static void contact_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double down_r = state[CONTACT_DOWN_R];
    const double down_t = state[CONTACT_DOWN_T];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double around = ratio(h, r);
    const double w3 = (1.5 * m->hertz * q + m->linear) * (m->contact_damping * p + 1.0);
    const double push = (m->hertz * q + m->linear) * square;
    const double w5 = push * p;
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
    added[2][2] = m->pressed * w3;
    added[2][3] = 0.0;
    added[3][0] = 0.0;
    added[3][1] = 0.0;
    added[3][2] = -r;
    added[3][3] = 0.0;
    added[4][0] = 0.0;
    added[4][1] = 0.0;
    added[4][2] = -m->pressed * w5;
    added[4][3] = 0.0;
    added[5][0] = 0.0;
    added[5][1] = 0.0;
    added[5][2] = down_r;
    added[5][3] = down_t;
}

/* The Taylor series of the state: 16 lanes. */
static void contact_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(11 <= WIDTH && 16 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
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
        const double down_r = here[CONTACT_DOWN_R];
        const double down_t = here[CONTACT_DOWN_T];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double push = times(series, 1, n, m->hertz * q + one * m->linear, square);
        /* push * (1.0 + contact_damping * p) */
        const double w3 = times(series, 2, n, push, one * 1.0 + m->contact_damping * p);
        const double push_ = m->pressed * w3;
        const double r = one * m->delta0 + square;
        const double around = over(series, 3, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push_ - m->shaft_stiffness * r + m->load * down_r + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double sideways = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
        const double moment = times(series, 7, n, sideways, r); /* sideways * r */
        const double of_h = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w16 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w16;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w20 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w20;
        const double w22 = times(series, 14, n, w3, q); /* w3 * q */
        const double of_j = m->pressed * w22;
        const double w24 = times(series, 15, n, w22, p); /* w22 * p */
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = m->pressed * w24 * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The Taylor series of the state, and the factors of differences: 26 lanes. */
static void contact_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(11 <= WIDTH && 26 <= LANES && 6 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][CONTACT_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 7);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[CONTACT_Q];
        const double p = here[CONTACT_P];
        const double h = here[CONTACT_H];
        const double c = here[CONTACT_C];
        const double s = here[CONTACT_S];
        const double down_r = here[CONTACT_DOWN_R];
        const double down_t = here[CONTACT_DOWN_T];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double push = times(series, 1, n, m->hertz * q + one * m->linear, square);
        const double w3 = m->contact_damping * p;
        const double w4 = times(series, 2, n, push, one * 1.0 + w3); /* push * (1.0 + w3) */
        const double push_ = m->pressed * w4;
        const double r = one * m->delta0 + square;
        const double around = over(series, 3, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push_ - m->shaft_stiffness * r + m->load * down_r + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double sideways = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
        const double moment = times(series, 7, n, sideways, r); /* sideways * r */
        const double of_h = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w17 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w17;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w21 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w21;
        const double w23 = times(series, 14, n, w4, q); /* w4 * q */
        const double of_j = m->pressed * w23;
        const double w25 = times(series, 15, n, w23, p); /* w23 * p */
        const double w26 = w3 + one * 1.0;
        /* (1.5 * hertz * q + linear) * w26 */
        const double w27 = times(series, 16, n, 1.5 * m->hertz * q + one * m->linear, w26);
        /* (-pressed * w27 - shaft_stiffness) * q */
        const double w28 = times(series, 17, n, -m->pressed * w27 - one * m->shaft_stiffness, q);
        const double w29 = over(series, 18, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double w30 = times(series, 19, n, around, w29); /* around * w29 */
        const double w31 = times(series, 20, n, w30, push); /* w30 * push */
        const double w32 = times(series, 21, n, w31, q); /* w31 * q */
        /* (-2.0 * zeta - pressed * contact_damping * push) * q */
        const double w33 = times(series, 22, n, one * (-2.0 * m->zeta) - m->pressed * m->contact_damping * push, q);
        const double w34 = times(series, 23, n, push, w26); /* push * w26 */
        const double w35 = times(series, 24, n, w34, w29); /* w34 * w29 */
        /* (-pressed * w35 - shaft_stiffness) * q */
        const double w36 = times(series, 25, n, -m->pressed * w35 - one * m->shaft_stiffness, q);
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = m->pressed * w25 * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        series->factors[0][n] = q;
        series->factors[1][n] = turned;
        series->factors[2][n] = w28;
        series->factors[3][n] = -(m->pressed * m->contact_damping) * w32;
        series->factors[4][n] = w33;
        series->factors[5][n] = w36;
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
        store(&series->steady[n][8], spread(0.0));
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
            sum_vx = fma4(f3, load(&series->apart[k][4]), sum_vx);
            const vec4 f4 = spread(series->factors[4][n - k]);
            sum_vx = fma4(f4, load(&series->apart[k][8]), sum_vx);
            const vec4 f5 = spread(series->factors[5][n - k]);
            sum_vy = fma4(f5, load(&series->apart[k][4]), sum_vy);
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

/* The rates of change of x, y, vx, vy, down_x, down_y. */
static void cartesian_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    const double down_x = state[CARTESIAN_DOWN_X];
    const double down_y = state[CARTESIAN_DOWN_Y];
    const double w0 = x * x;
    const double w1 = y * y;
    const double square = w0 + w1;
    const double w3 = sqrt(sqrt(square));
    const double w4 = m->hertz * w3 + m->linear;
    const double w5 = w4 * x;
    const double ax = m->omega * m->omega - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x;
    const double w7 = w4 * y;
    const double ay = -2.0 * m->zeta * vy - m->felt * w7 - m->shaft_stiffness * y + m->load * down_y;
    rate[CARTESIAN_X] = vx + m->omega * y;
    rate[CARTESIAN_Y] = vy - m->omega * x;
    rate[CARTESIAN_VX] = ax + m->omega * vy;
    rate[CARTESIAN_VY] = ay - m->omega * vx;
    rate[CARTESIAN_DOWN_X] = m->omega * down_y;
    rate[CARTESIAN_DOWN_Y] = -m->omega * down_x;
}

/* Their derivatives by each of these, column by column. */
static void cartesian_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 36; i++)
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
    const double push = m->felt * (m->hertz * w3 + m->linear);
    const double w8 = w5 * y;
    const double w9 = w4 * y;
    const double w10 = w9 * x;
    const double w11 = w9 * y;
    matrix[1] = -m->omega;
    matrix[2] = -(0.5 * m->hertz * m->felt * w6 + push) - m->shaft_stiffness;
    matrix[3] = -(0.5 * m->hertz * m->felt) * w8;
    matrix[6] = m->omega;
    matrix[8] = -(0.5 * m->hertz * m->felt) * w10;
    matrix[9] = -(0.5 * m->hertz * m->felt * w11 + push) - m->shaft_stiffness;
    matrix[12] = 1.0;
    matrix[14] = -2.0 * m->zeta;
    matrix[15] = -m->omega;
    matrix[19] = 1.0;
    matrix[20] = m->omega;
    matrix[21] = -2.0 * m->zeta;
    matrix[26] = m->load;
    matrix[29] = -m->omega;
    matrix[33] = m->load;
    matrix[34] = m->omega;
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
    const double push = m->felt * (m->hertz * w3 + m->linear);
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
    growth[2][0] = -(0.5 * m->hertz * m->felt * w6 + push) - m->shaft_stiffness;
    growth[2][1] = -(0.5 * m->hertz * m->felt) * w9;
    growth[2][2] = -2.0 * m->zeta;
    growth[2][3] = m->omega;
    growth[3][0] = -(0.5 * m->hertz * m->felt) * w10;
    growth[3][1] = -(0.5 * m->hertz * m->felt * w11 + push) - m->shaft_stiffness;
    growth[3][2] = -m->omega;
    growth[3][3] = -2.0 * m->zeta;
}

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load add to the rates by time of position and velocity. */
static void cartesian_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    const double down_x = state[CARTESIAN_DOWN_X];
    const double down_y = state[CARTESIAN_DOWN_Y];
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
    added[3][0] = 0.0;
    added[3][1] = 0.0;
    added[3][2] = -x;
    added[3][3] = -y;
    added[4][0] = 0.0;
    added[4][1] = 0.0;
    added[4][2] = 0.0;
    added[4][3] = 0.0;
    added[5][0] = 0.0;
    added[5][1] = 0.0;
    added[5][2] = down_x;
    added[5][3] = down_y;
}

/* The Taylor series of the state: 6 lanes. */
static void cartesian_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(6 <= WIDTH && 6 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
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
        const double down_x = here[CARTESIAN_DOWN_X];
        const double down_y = here[CARTESIAN_DOWN_Y];
        const double w0 = times(series, 0, n, x, x); /* x * x */
        const double w1 = times(series, 1, n, y, y); /* y * y */
        const double square = w0 + w1;
        /* square**0.25 */
        const double w3 = raised(series, 2, n, square, 0.25, one * first_w3, inverse_square);
        const double w4 = m->hertz * w3 + one * m->linear;
        const double w5 = times(series, 4, n, w4, x); /* w4 * x */
        const double ax = one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x;
        const double w7 = times(series, 5, n, w4, y); /* w4 * y */
        const double ay = -2.0 * m->zeta * vy - m->felt * w7 - m->shaft_stiffness * y + m->load * down_y;
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (ax + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (ay - m->omega * vx) * share;
        terms[CARTESIAN_DOWN_X] = m->omega * down_y * share;
        terms[CARTESIAN_DOWN_Y] = -m->omega * down_x * share;
        one = 0.0;
    }
}

/* The Taylor series of the state, and the factors of differences: 13 lanes. */
static void cartesian_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(6 <= WIDTH && 13 <= LANES && 4 <= FACTORS, "series.h has no room for this mode");
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
        const double down_x = here[CARTESIAN_DOWN_X];
        const double down_y = here[CARTESIAN_DOWN_Y];
        const double w0 = times(series, 0, n, x, x); /* x * x */
        const double w1 = times(series, 1, n, y, y); /* y * y */
        const double square = w0 + w1;
        /* square**0.25 */
        const double w3 = raised(series, 2, n, square, 0.25, one * first_w3, inverse_square);
        const double w4 = m->hertz * w3 + one * m->linear;
        const double w5 = times(series, 4, n, w4, x); /* w4 * x */
        const double ax = one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x;
        const double w7 = times(series, 5, n, w4, y); /* w4 * y */
        const double ay = -2.0 * m->zeta * vy - m->felt * w7 - m->shaft_stiffness * y + m->load * down_y;
        const double w9 = over(series, 6, n, w3, square, inverse_square); /* w3 / square */
        const double w10 = times(series, 7, n, w9, x); /* w9 * x */
        const double w11 = times(series, 8, n, w10, x); /* w10 * x */
        const double push = m->felt * w4;
        const double w13 = times(series, 9, n, w9, y); /* w9 * y */
        const double w14 = times(series, 10, n, w13, x); /* w13 * x */
        const double w15 = times(series, 11, n, w10, y); /* w10 * y */
        const double w16 = times(series, 12, n, w13, y); /* w13 * y */
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (ax + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (ay - m->omega * vx) * share;
        terms[CARTESIAN_DOWN_X] = m->omega * down_y * share;
        terms[CARTESIAN_DOWN_Y] = -m->omega * down_x * share;
        series->factors[0][n] = -(0.5 * m->hertz * m->felt * w11 + push) - one * m->shaft_stiffness;
        series->factors[1][n] = -(0.5 * m->hertz * m->felt) * w14;
        series->factors[2][n] = -(0.5 * m->hertz * m->felt) * w15;
        series->factors[3][n] = -(0.5 * m->hertz * m->felt * w16 + push) - one * m->shaft_stiffness;
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
