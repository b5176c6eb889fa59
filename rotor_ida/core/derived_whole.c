/* Derived from rotor_ida/model/modes.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#if defined(WHOLE_MODEL) && !defined(RUN_UP)
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
    const double spring = (m->hertz * q + m->linear) * square;
    const double w3 = spring * (1.0 + m->contact_damping * p);
    const double push = (1.0 - m->loose) * w3;
    const double r = m->delta0 + square;
    const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double outwards = radial + centrifugal;
    const double of_p = outwards * q;
    const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
    const double moment = tangential * r;
    const double of_h = moment * q;
    const double turned = spin * q;
    const double turn = turned - m->omega * q;
    const double w17 = turn * s;
    const double of_c = -w17;
    const double w19 = c * c;
    const double w20 = s * s;
    const double w21 = (1.0 - (w19 + w20)) * q;
    const double w22 = w21 * c;
    const double of_s = turn * c;
    const double w24 = w21 * s;
    const double of_down_r = turned * down_t;
    const double w26 = down_r * down_r;
    const double w27 = down_t * down_t;
    const double w28 = (1.0 - (w26 + w27)) * q;
    const double w29 = w28 * down_r;
    const double w30 = turned * down_r;
    const double of_down_t = -w30;
    const double w32 = w28 * down_t;
    const double w33 = w3 * q;
    const double of_j = (1.0 - m->loose) * w33;
    const double w35 = w33 * p;
    const double of_work = (1.0 - m->loose) * w35;
    const double w37 = p * p;
    const double w38 = around * around;
    const double damped = 2.0 * m->zeta * (w37 + w38 - m->omega * h);
    const double w40 = r * down_t;
    const double w41 = (damped + m->load * m->omega * w40) * q;
    rate[CONTACT_Q] = of_q;
    rate[CONTACT_P] = of_p;
    rate[CONTACT_H] = of_h;
    rate[CONTACT_C] = of_c + 0.1 * m->omega * w22;
    rate[CONTACT_S] = of_s + 0.1 * m->omega * w24;
    rate[CONTACT_DOWN_R] = of_down_r + 0.1 * m->omega * w29;
    rate[CONTACT_DOWN_T] = of_down_t + 0.1 * m->omega * w32;
    rate[CONTACT_T] = q;
    rate[CONTACT_J] = of_j;
    rate[CONTACT_WORK] = of_work;
    rate[CONTACT_SPENT] = w41;
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
    const double spring = w0 * square;
    const double w3 = m->contact_damping * p + 1.0;
    const double w4 = spring * w3;
    const double w5 = (1.0 - m->loose) * w4;
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
    const double w18 = (-(1.0 - m->loose) * w11 - 2.0 * m->shaft_stiffness * q + (-2.0 * w14 + w17)) * q;
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
    const double w42 = (w5 + (1.0 - m->loose) * w41) * p;
    const double w43 = p * p;
    const double w44 = w7 * w7;
    const double w45 = w6 * down_t;
    const double w46 = w13 * w7;
    const double w47 = q * down_t;
    const double w48 = (-8.0 * m->zeta * w46 + 2.0 * (m->load * m->omega) * w47) * q;
    const double w49 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w50 = spring * q;
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
    matrix[8] = w5 + (1.0 - m->loose) * w41;
    matrix[9] = w42;
    matrix[10] = 2.0 * m->zeta * (w43 + w44 - m->omega * h) + m->load * m->omega * w45 + w48;
    matrix[11] = 0.5;
    matrix[12] = w49;
    matrix[19] = (1.0 - m->loose) * m->contact_damping * w50;
    matrix[20] = (1.0 - m->loose) * m->contact_damping * w51 + (1.0 - m->loose) * w52;
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
    const double w7 = (-(1.0 - m->loose) * w6 - m->shaft_stiffness) * q;
    const double w8 = ratio(1.0, r);
    const double w9 = around * w8;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w11 = w9 * spring;
    const double w12 = w11 * q;
    const double w13 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w14 = spring * w5;
    const double w15 = w14 * w8;
    const double w16 = (-(1.0 - m->loose) * w15 - m->shaft_stiffness) * q;
    growth[0][0] = 0.0;
    growth[0][1] = turned;
    growth[0][2] = q;
    growth[0][3] = 0.0;
    growth[1][0] = -turned;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = q;
    growth[2][0] = w7;
    growth[2][1] = -((1.0 - m->loose) * m->contact_damping) * w12;
    growth[2][2] = w13;
    growth[2][3] = turned;
    growth[3][0] = 0.0;
    growth[3][1] = w16;
    growth[3][2] = -turned;
    growth[3][3] = -2.0 * m->zeta * q;
}

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load, friction, disc_radius add to the rates by time of position and velocity. */
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
    const double spring = (m->hertz * q + m->linear) * square;
    const double w5 = spring * p;
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
    added[2][2] = (1.0 - m->loose) * w3;
    added[2][3] = 0.0;
    added[3][0] = 0.0;
    added[3][1] = 0.0;
    added[3][2] = -r;
    added[3][3] = 0.0;
    added[4][0] = 0.0;
    added[4][1] = 0.0;
    added[4][2] = -(1.0 - m->loose) * w5;
    added[4][3] = 0.0;
    added[5][0] = 0.0;
    added[5][1] = 0.0;
    added[5][2] = down_r;
    added[5][3] = down_t;
    added[6][0] = 0.0;
    added[6][1] = 0.0;
    added[6][2] = 0.0;
    added[6][3] = 0.0;
    added[7][0] = 0.0;
    added[7][1] = 0.0;
    added[7][2] = 0.0;
    added[7][3] = 0.0;
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
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w3 = times(series, 2, n, spring, one * 1.0 + m->contact_damping * p);
        const double push = (1.0 - m->loose) * w3;
        const double r = one * m->delta0 + square;
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double around = over(series, 3, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
        const double moment = times(series, 7, n, tangential, r); /* tangential * r */
        const double of_h = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w17 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w17;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w21 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w21;
        const double w23 = times(series, 14, n, w3, q); /* w3 * q */
        const double of_j = (1.0 - m->loose) * w23;
        const double w25 = times(series, 15, n, w23, p); /* w23 * p */
        const double of_work = (1.0 - m->loose) * w25;
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = of_work * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void contact_spent(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_DOWN_T};
    vec4 read[4][AT_ONCE];
    read_parts(series, order, reads, 4, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 h = read[2][v];
        const vec4 down_t = read[3][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 around = (h) / (r);
        const vec4 w4 = around * around;
        const vec4 damped = 2.0 * m->zeta * (w0 + w4 - m->omega * h);
        const vec4 w6 = r * down_t;
        const vec4 w7 = (damped + m->load * m->omega * w6) * q;
        rate[v][0] = w7;
        rate[v][1] = spread(0.0);
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
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        const double w3 = m->contact_damping * p;
        const double w4 = times(series, 2, n, spring, one * 1.0 + w3); /* spring * (1.0 + w3) */
        const double push = (1.0 - m->loose) * w4;
        const double r = one * m->delta0 + square;
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double around = over(series, 3, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t;
        const double moment = times(series, 7, n, tangential, r); /* tangential * r */
        const double of_h = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w18 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w18;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w22 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w22;
        const double w24 = times(series, 14, n, w4, q); /* w4 * q */
        const double of_j = (1.0 - m->loose) * w24;
        const double w26 = times(series, 15, n, w24, p); /* w24 * p */
        const double of_work = (1.0 - m->loose) * w26;
        const double w28 = w3 + one * 1.0;
        /* (1.5 * hertz * q + linear) * w28 */
        const double w29 = times(series, 16, n, 1.5 * m->hertz * q + one * m->linear, w28);
        /* (-(1.0 - loose) * w29 - shaft_stiffness) * q */
        const double w30 = times(series, 17, n, -(1.0 - m->loose) * w29 - one * m->shaft_stiffness, q);
        const double w31 = over(series, 18, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double w32 = times(series, 19, n, around, w31); /* around * w31 */
        const double w33 = times(series, 20, n, w32, spring); /* w32 * spring */
        const double w34 = times(series, 21, n, w33, q); /* w33 * q */
        /* (-2.0 * zeta - (1.0 - loose) * contact_damping * spring) * q */
        const double w35 = times(series, 22, n, one * (-2.0 * m->zeta) - (1.0 - m->loose) * m->contact_damping * spring, q);
        const double w36 = times(series, 23, n, spring, w28); /* spring * w28 */
        const double w37 = times(series, 24, n, w36, w31); /* w36 * w31 */
        /* (-(1.0 - loose) * w37 - shaft_stiffness) * q */
        const double w38 = times(series, 25, n, -(1.0 - m->loose) * w37 - one * m->shaft_stiffness, q);
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = of_work * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        series->factors[0][n] = q;
        series->factors[1][n] = turned;
        series->factors[2][n] = w30;
        series->factors[3][n] = -((1.0 - m->loose) * m->contact_damping) * w34;
        series->factors[4][n] = w35;
        series->factors[5][n] = w38;
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
    .spent = contact_spent,
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
    const double w6 = w4 * y;
    rate[CARTESIAN_X] = vx + m->omega * y;
    rate[CARTESIAN_Y] = vy - m->omega * x;
    rate[CARTESIAN_VX] = m->omega * m->omega - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x + m->omega * vy;
    rate[CARTESIAN_VY] = -2.0 * m->zeta * vy - m->felt * w6 - m->shaft_stiffness * y + m->load * down_y - m->omega * vx;
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

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load, friction, disc_radius add to the rates by time of position and velocity. */
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
    added[6][0] = 0.0;
    added[6][1] = 0.0;
    added[6][2] = 0.0;
    added[6][3] = 0.0;
    added[7][0] = 0.0;
    added[7][1] = 0.0;
    added[7][2] = 0.0;
    added[7][3] = 0.0;
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
        const double w6 = times(series, 5, n, w4, y); /* w4 * y */
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - m->felt * w6 - m->shaft_stiffness * y + m->load * down_y - m->omega * vx) * share;
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
        const double w6 = times(series, 5, n, w4, y); /* w4 * y */
        const double w7 = over(series, 6, n, w3, square, inverse_square); /* w3 / square */
        const double w8 = times(series, 7, n, w7, x); /* w7 * x */
        const double w9 = times(series, 8, n, w8, x); /* w8 * x */
        const double push = m->felt * w4;
        const double w11 = times(series, 9, n, w7, y); /* w7 * y */
        const double w12 = times(series, 10, n, w11, x); /* w11 * x */
        const double w13 = times(series, 11, n, w8, y); /* w8 * y */
        const double w14 = times(series, 12, n, w11, y); /* w11 * y */
        terms[CARTESIAN_X] = (vx + m->omega * y) * share;
        terms[CARTESIAN_Y] = (vy - m->omega * x) * share;
        terms[CARTESIAN_VX] = (one * (m->omega * m->omega) - 2.0 * m->zeta * vx - m->felt * w5 - m->shaft_stiffness * x + m->load * down_x + m->omega * vy) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - m->felt * w6 - m->shaft_stiffness * y + m->load * down_y - m->omega * vx) * share;
        terms[CARTESIAN_DOWN_X] = m->omega * down_y * share;
        terms[CARTESIAN_DOWN_Y] = -m->omega * down_x * share;
        series->factors[0][n] = -(0.5 * m->hertz * m->felt * w9 + push) - one * m->shaft_stiffness;
        series->factors[1][n] = -(0.5 * m->hertz * m->felt) * w12;
        series->factors[2][n] = -(0.5 * m->hertz * m->felt) * w13;
        series->factors[3][n] = -(0.5 * m->hertz * m->felt * w14 + push) - one * m->shaft_stiffness;
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

/* The rates of change of q, p, slip, c, s, down_r, down_t, t, j, work, spent, heat, drawn back to where they belong. */
static void rub_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double q = state[RUB_Q];
    const double p = state[RUB_P];
    const double slip = state[RUB_SLIP];
    const double c = state[RUB_C];
    const double s = state[RUB_S];
    const double down_r = state[RUB_DOWN_R];
    const double down_t = state[RUB_DOWN_T];
    const double of_q = 0.5 * p;
    const double square = q * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w3 = spring * (1.0 + m->contact_damping * p);
    const double push = (1.0 - m->loose) * w3;
    const double r = m->delta0 + square;
    const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
    const double slip_speed = ratio(slip, r);
    const double around = slip_speed - m->rim;
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double outwards = radial + centrifugal;
    const double of_p = outwards * q;
    const double drag = m->friction * m->sigma * (1.0 - m->loose) * w3;
    const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t - drag;
    const double w15 = tangential * r;
    const double moment = w15 + m->rim * p;
    const double of_slip = moment * q;
    const double turned = spin * q;
    const double turn = turned - m->omega * q;
    const double w20 = turn * s;
    const double of_c = -w20;
    const double w22 = c * c;
    const double w23 = s * s;
    const double w24 = (1.0 - (w22 + w23)) * q;
    const double w25 = w24 * c;
    const double of_s = turn * c;
    const double w27 = w24 * s;
    const double of_down_r = turned * down_t;
    const double w29 = down_r * down_r;
    const double w30 = down_t * down_t;
    const double w31 = (1.0 - (w29 + w30)) * q;
    const double w32 = w31 * down_r;
    const double w33 = turned * down_r;
    const double of_down_t = -w33;
    const double w35 = w31 * down_t;
    const double w36 = w3 * q;
    const double of_j = (1.0 - m->loose) * w36;
    const double w38 = w36 * p;
    const double w39 = p * p;
    const double h = slip - m->rim * r;
    const double around_ = ratio(h, r);
    const double w42 = around_ * around_;
    const double damped = 2.0 * m->zeta * (w39 + w42 - m->omega * h);
    const double w44 = r * down_t;
    const double spent = (damped + m->load * m->omega * w44) * q;
    const double w46 = w36 * (m->rim + m->omega * r);
    const double w47 = w36 * slip_speed;
    rate[RUB_Q] = of_q;
    rate[RUB_P] = of_p;
    rate[RUB_SLIP] = of_slip;
    rate[RUB_C] = of_c + 0.1 * m->omega * w25;
    rate[RUB_S] = of_s + 0.1 * m->omega * w27;
    rate[RUB_DOWN_R] = of_down_r + 0.1 * m->omega * w32;
    rate[RUB_DOWN_T] = of_down_t + 0.1 * m->omega * w35;
    rate[RUB_T] = q;
    rate[RUB_J] = of_j;
    rate[RUB_WORK] = (1.0 - m->loose) * w38;
    rate[RUB_SPENT] = spent - m->friction * m->sigma * (1.0 - m->loose) * w46;
    rate[RUB_HEAT] = m->friction * m->sigma * (1.0 - m->loose) * w47;
}

/* Their derivatives by each of these, column by column. */
static void rub_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 144; i++)
        matrix[i] = 0.0;
    const double q = state[RUB_Q];
    const double p = state[RUB_P];
    const double slip = state[RUB_SLIP];
    const double c = state[RUB_C];
    const double s = state[RUB_S];
    const double down_r = state[RUB_DOWN_R];
    const double down_t = state[RUB_DOWN_T];
    const double w0 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w0 * square;
    const double w3 = m->contact_damping * p + 1.0;
    const double w4 = spring * w3;
    const double w5 = (1.0 - m->loose) * w4;
    const double w6 = square + m->delta0;
    const double w7 = ratio(slip, w6);
    const double w8 = w7 - m->rim;
    const double w9 = ratio(w8, w6);
    const double w10 = w9 * w8;
    const double w11 = w0 * q;
    const double w12 = (2.0 * w11 + m->hertz * square) * w3;
    const double w13 = w7 * q;
    const double w14 = ratio(w13, w6);
    const double w15 = w14 * w9;
    const double w16 = w9 * q;
    const double w17 = ratio(-2.0 * w14 - 2.0 * w16, w6);
    const double w18 = w17 * w8;
    const double w19 = (-(1.0 - m->loose) * w12 - 2.0 * m->shaft_stiffness * q + (-2.0 * w15 + w18)) * q;
    const double w20 = (1.0 - m->loose) * (m->friction * m->sigma) * w4;
    const double w21 = -(m->omega * m->omega) * s - 2.0 * m->zeta * w8 + m->load * down_t - w20;
    const double w22 = w21 * w6;
    const double w23 = w21 * q;
    const double w24 = (4.0 * m->zeta * w14 - (1.0 - m->loose) * (m->friction * m->sigma) * w12) * w6;
    const double w25 = (2.0 * w23 + w24) * q;
    const double w26 = w17 * q;
    const double w27 = w9 + w26;
    const double w28 = w27 - m->omega;
    const double w29 = w28 * s;
    const double w30 = c * c;
    const double w31 = s * s;
    const double w32 = -(w30 + w31) + 1.0;
    const double w33 = w32 * c;
    const double w34 = w28 * c;
    const double w35 = w32 * s;
    const double w36 = w27 * down_t;
    const double w37 = down_r * down_r;
    const double w38 = down_t * down_t;
    const double w39 = -(w37 + w38) + 1.0;
    const double w40 = w39 * down_r;
    const double w41 = w27 * down_r;
    const double w42 = w39 * down_t;
    const double w43 = w12 * q;
    const double w44 = (w5 + (1.0 - m->loose) * w43) * p;
    const double w45 = p * p;
    const double w46 = slip - m->rim * w6;
    const double w47 = ratio(w46, w6);
    const double w48 = w47 * w47;
    const double w49 = w6 * down_t;
    const double w50 = w47 * q;
    const double w51 = ratio(-2.0 * m->rim * q - 2.0 * w50, w6);
    const double w52 = w51 * w47;
    const double w53 = q * down_t;
    const double w54 = (2.0 * m->zeta * (2.0 * w52 - -2.0 * m->rim * m->omega * q) + 2.0 * (m->load * m->omega) * w53) * q;
    const double w55 = w20 + (1.0 - m->loose) * (m->friction * m->sigma) * w43;
    const double w56 = m->omega * w6 + m->rim;
    const double w57 = w55 * w56;
    const double w58 = w4 * q;
    const double w59 = w58 * q;
    const double w60 = w55 * w7;
    const double w61 = w14 * w58;
    const double w62 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w63 = spring * w6;
    const double w64 = (-((1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma)) * w63 + m->rim) * q;
    const double w65 = spring * q;
    const double w66 = w65 * p;
    const double w67 = q * p;
    const double w68 = w65 * w56;
    const double w69 = w65 * w7;
    const double w70 = ratio(1.0, w6);
    const double w71 = w9 * w70;
    const double w72 = ratio(w70, w6);
    const double w73 = w8 * w72;
    const double w74 = (w71 + w73) * q;
    const double w75 = w70 * w6;
    const double w76 = w75 * q;
    const double w77 = w72 * q;
    const double w78 = w77 * s;
    const double w79 = w77 * c;
    const double w80 = w77 * down_t;
    const double w81 = w77 * down_r;
    const double w82 = w47 * w70;
    const double w83 = (2.0 * w82 - m->omega) * q;
    const double w84 = w58 * w70;
    const double w85 = q * c;
    const double w86 = w85 * c;
    const double w87 = w32 * q;
    const double w88 = 0.1 * m->omega * w87;
    const double w89 = w16 - m->omega * q;
    const double w90 = w85 * s;
    const double w91 = w6 * q;
    const double w92 = q * s;
    const double w93 = w92 * c;
    const double w94 = w92 * s;
    const double w95 = q * down_r;
    const double w96 = w95 * down_r;
    const double w97 = w39 * q;
    const double w98 = 0.1 * m->omega * w97;
    const double w99 = w95 * down_t;
    const double w100 = w53 * down_r;
    const double w101 = w53 * down_t;
    matrix[1] = m->omega * m->omega * c - 2.0 * m->zeta * p - w5 - m->shaft_stiffness * w6 + m->load * down_r + w10 + w19;
    matrix[2] = w22 + m->rim * p + w25;
    matrix[3] = -w29 + 0.1 * m->omega * w33;
    matrix[4] = w34 + 0.1 * m->omega * w35;
    matrix[5] = w36 + 0.1 * m->omega * w40;
    matrix[6] = -w41 + 0.1 * m->omega * w42;
    matrix[7] = 1.0;
    matrix[8] = w5 + (1.0 - m->loose) * w43;
    matrix[9] = w44;
    matrix[10] = 2.0 * m->zeta * (w45 + w48 - m->omega * w46) + m->load * m->omega * w49 + w54 - (w57 + (1.0 - m->loose) * (m->friction * m->sigma) * (2.0 * m->omega) * w59);
    matrix[11] = w60 - 2.0 * ((1.0 - m->loose) * (m->friction * m->sigma)) * w61;
    matrix[12] = 0.5;
    matrix[13] = w62;
    matrix[14] = w64;
    matrix[20] = (1.0 - m->loose) * m->contact_damping * w65;
    matrix[21] = (1.0 - m->loose) * m->contact_damping * w66 + (1.0 - m->loose) * w58;
    matrix[22] = 4.0 * m->zeta * w67 - (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w68;
    matrix[23] = (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w69;
    matrix[25] = w74;
    matrix[26] = -2.0 * m->zeta * w76;
    matrix[27] = -w78;
    matrix[28] = w79;
    matrix[29] = w80;
    matrix[30] = -w81;
    matrix[34] = 2.0 * m->zeta * w83;
    matrix[35] = (1.0 - m->loose) * (m->friction * m->sigma) * w84;
    matrix[37] = m->omega * m->omega * q;
    matrix[39] = -0.2 * m->omega * w86 + w88;
    matrix[40] = w89 - 0.2 * m->omega * w90;
    matrix[50] = -(m->omega * m->omega) * w91;
    matrix[51] = -w89 - 0.2 * m->omega * w93;
    matrix[52] = -0.2 * m->omega * w94 + w88;
    matrix[61] = m->load * q;
    matrix[65] = -0.2 * m->omega * w96 + w98;
    matrix[66] = -w16 - 0.2 * m->omega * w99;
    matrix[74] = m->load * w91;
    matrix[77] = w16 - 0.2 * m->omega * w100;
    matrix[78] = -0.2 * m->omega * w101 + w98;
    matrix[82] = m->load * m->omega * w91;
}

/* The rates of a small difference are this matrix times it. */
static void rub_growth(const struct parameters *m,
    const double *state, double growth[4][4])
{
    const double q = state[RUB_Q];
    const double p = state[RUB_P];
    const double slip = state[RUB_SLIP];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double slip_speed = ratio(slip, r);
    const double around = slip_speed - m->rim;
    const double spin = ratio(around, r);
    const double turned = spin * q;
    const double w6 = m->contact_damping * p + 1.0;
    const double w7 = (1.5 * m->hertz * q + m->linear) * w6;
    const double w8 = (-(1.0 - m->loose) * w7 - m->shaft_stiffness) * q;
    const double w9 = ratio(1.0, r);
    const double w10 = around * w9;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w12 = w10 * spring;
    const double w13 = spring * w6;
    const double w14 = w13 * w9;
    const double w15 = (-((1.0 - m->loose) * m->contact_damping) * w12 + (1.0 - m->loose) * (m->friction * m->sigma) * w14) * q;
    const double w16 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w17 = w7 * q;
    const double w18 = (-(1.0 - m->loose) * w14 - m->shaft_stiffness - (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w12) * q;
    const double w19 = (-((1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma)) * spring - spin) * q;
    growth[0][0] = 0.0;
    growth[0][1] = turned;
    growth[0][2] = q;
    growth[0][3] = 0.0;
    growth[1][0] = -turned;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = q;
    growth[2][0] = w8;
    growth[2][1] = w15;
    growth[2][2] = w16;
    growth[2][3] = turned;
    growth[3][0] = -((1.0 - m->loose) * (m->friction * m->sigma)) * w17;
    growth[3][1] = w18;
    growth[3][2] = w19;
    growth[3][3] = -2.0 * m->zeta * q;
}

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load, friction, disc_radius add to the rates by time of position and velocity. */
static void rub_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double q = state[RUB_Q];
    const double p = state[RUB_P];
    const double slip = state[RUB_SLIP];
    const double c = state[RUB_C];
    const double s = state[RUB_S];
    const double down_r = state[RUB_DOWN_R];
    const double down_t = state[RUB_DOWN_T];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double slip_speed = ratio(slip, r);
    const double around = slip_speed - m->rim;
    const double w4 = m->contact_damping * p + 1.0;
    const double w5 = (1.5 * m->hertz * q + m->linear) * w4;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w7 = spring * p;
    const double w8 = spring * w4;
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
    added[2][2] = (1.0 - m->loose) * w5;
    added[2][3] = -(m->friction * m->sigma * (-(1.0 - m->loose))) * w5;
    added[3][0] = 0.0;
    added[3][1] = 0.0;
    added[3][2] = -r;
    added[3][3] = 0.0;
    added[4][0] = 0.0;
    added[4][1] = 0.0;
    added[4][2] = -(1.0 - m->loose) * w7;
    added[4][3] = -(m->friction * m->sigma * (1.0 - m->loose)) * w7;
    added[5][0] = 0.0;
    added[5][1] = 0.0;
    added[5][2] = down_r;
    added[5][3] = down_t;
    added[6][0] = 0.0;
    added[6][1] = 0.0;
    added[6][2] = 0.0;
    added[6][3] = -(m->sigma * (1.0 - m->loose)) * w8;
    added[7][0] = 0.0;
    added[7][1] = 0.0;
    added[7][2] = 0.0;
    added[7][3] = 0.0;
}

/* The Taylor series of the state: 16 lanes. */
static void rub_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(12 <= WIDTH && 16 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][RUB_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 4);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[RUB_Q];
        const double p = here[RUB_P];
        const double slip = here[RUB_SLIP];
        const double c = here[RUB_C];
        const double s = here[RUB_S];
        const double down_r = here[RUB_DOWN_R];
        const double down_t = here[RUB_DOWN_T];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w3 = times(series, 2, n, spring, one * 1.0 + m->contact_damping * p);
        const double push = (1.0 - m->loose) * w3;
        const double r = one * m->delta0 + square;
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double slip_speed = over(series, 3, n, slip, r, inverse_r); /* slip / r */
        const double around = slip_speed - one * m->rim;
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double drag = m->friction * m->sigma * (1.0 - m->loose) * w3;
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t - drag;
        const double w15 = times(series, 7, n, tangential, r); /* tangential * r */
        const double moment = w15 + m->rim * p;
        const double of_slip = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w20 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w20;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w24 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w24;
        const double w26 = times(series, 14, n, w3, q); /* w3 * q */
        const double of_j = (1.0 - m->loose) * w26;
        const double w28 = times(series, 15, n, w26, p); /* w26 * p */
        terms[RUB_Q] = of_q * share;
        terms[RUB_P] = of_p * share;
        terms[RUB_SLIP] = of_slip * share;
        terms[RUB_C] = of_c * share;
        terms[RUB_S] = of_s * share;
        terms[RUB_DOWN_R] = of_down_r * share;
        terms[RUB_DOWN_T] = of_down_t * share;
        terms[RUB_T] = q * share;
        terms[RUB_J] = of_j * share;
        terms[RUB_WORK] = (1.0 - m->loose) * w28 * share;
        terms[RUB_SPENT] = one * 0.0 * share;
        terms[RUB_HEAT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rub_spent(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {RUB_Q, RUB_P, RUB_SLIP, RUB_DOWN_T};
    vec4 read[4][AT_ONCE];
    read_parts(series, order, reads, 4, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 slip = read[2][v];
        const vec4 down_t = read[3][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 h = slip - m->rim * r;
        const vec4 around = (h) / (r);
        const vec4 w5 = around * around;
        const vec4 damped = 2.0 * m->zeta * (w0 + w5 - m->omega * h);
        const vec4 w7 = r * down_t;
        const vec4 spent = (damped + m->load * m->omega * w7) * q;
        const vec4 spring = (m->hertz * q + m->linear) * square;
        const vec4 w10 = spring * (1.0 + m->contact_damping * p);
        const vec4 w11 = w10 * q;
        const vec4 w12 = w11 * (m->rim + m->omega * r);
        const vec4 slip_speed = (slip) / (r);
        const vec4 w14 = w11 * slip_speed;
        rate[v][0] = spent - m->friction * m->sigma * (1.0 - m->loose) * w12;
        rate[v][1] = m->friction * m->sigma * (1.0 - m->loose) * w14;
    }
}

/* The Taylor series of the state, and the factors of differences: 28 lanes. */
static void rub_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(12 <= WIDTH && 28 <= LANES && 8 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][RUB_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 7);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[RUB_Q];
        const double p = here[RUB_P];
        const double slip = here[RUB_SLIP];
        const double c = here[RUB_C];
        const double s = here[RUB_S];
        const double down_r = here[RUB_DOWN_R];
        const double down_t = here[RUB_DOWN_T];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        const double w3 = m->contact_damping * p;
        const double w4 = times(series, 2, n, spring, one * 1.0 + w3); /* spring * (1.0 + w3) */
        const double push = (1.0 - m->loose) * w4;
        const double r = one * m->delta0 + square;
        const double radial = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double slip_speed = over(series, 3, n, slip, r, inverse_r); /* slip / r */
        const double around = slip_speed - one * m->rim;
        const double spin = over(series, 4, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 5, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double drag = m->friction * m->sigma * (1.0 - m->loose) * w4;
        const double tangential = -(m->omega * m->omega) * s - 2.0 * m->zeta * around + m->load * down_t - drag;
        const double w16 = times(series, 7, n, tangential, r); /* tangential * r */
        const double moment = w16 + m->rim * p;
        const double of_slip = times(series, 8, n, moment, q); /* moment * q */
        const double turned = times(series, 9, n, spin, q); /* spin * q */
        const double turn = turned - m->omega * q;
        const double w21 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w21;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 12, n, turned, down_t); /* turned * down_t */
        const double w25 = times(series, 13, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w25;
        const double w27 = times(series, 14, n, w4, q); /* w4 * q */
        const double of_j = (1.0 - m->loose) * w27;
        const double w29 = times(series, 15, n, w27, p); /* w27 * p */
        const double w30 = w3 + one * 1.0;
        /* (1.5 * hertz * q + linear) * w30 */
        const double w31 = times(series, 16, n, 1.5 * m->hertz * q + one * m->linear, w30);
        /* (-(1.0 - loose) * w31 - shaft_stiffness) * q */
        const double w32 = times(series, 17, n, -(1.0 - m->loose) * w31 - one * m->shaft_stiffness, q);
        const double w33 = over(series, 18, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double w34 = times(series, 19, n, around, w33); /* around * w33 */
        const double w35 = times(series, 20, n, w34, spring); /* w34 * spring */
        const double w36 = times(series, 21, n, spring, w30); /* spring * w30 */
        const double w37 = times(series, 22, n, w36, w33); /* w36 * w33 */
        /* (-((1.0 - loose) * contact_damping) * w35 + (1.0 - loose) * (friction * sigma) * w37) * q */
        const double w38 = times(series, 23, n, -((1.0 - m->loose) * m->contact_damping) * w35 + (1.0 - m->loose) * (m->friction * m->sigma) * w37, q);
        /* (-2.0 * zeta - (1.0 - loose) * contact_damping * spring) * q */
        const double w39 = times(series, 24, n, one * (-2.0 * m->zeta) - (1.0 - m->loose) * m->contact_damping * spring, q);
        const double w40 = times(series, 25, n, w31, q); /* w31 * q */
        /* (-(1.0 - loose) * w37 - shaft_stiffness - (1.0 - loose) * contact_damping * (friction * sigma) * w35) * q */
        const double w41 = times(series, 26, n, -(1.0 - m->loose) * w37 - one * m->shaft_stiffness - (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w35, q);
        /* (-((1.0 - loose) * contact_damping * (friction * sigma)) * spring - spin) * q */
        const double w42 = times(series, 27, n, -((1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma)) * spring - spin, q);
        terms[RUB_Q] = of_q * share;
        terms[RUB_P] = of_p * share;
        terms[RUB_SLIP] = of_slip * share;
        terms[RUB_C] = of_c * share;
        terms[RUB_S] = of_s * share;
        terms[RUB_DOWN_R] = of_down_r * share;
        terms[RUB_DOWN_T] = of_down_t * share;
        terms[RUB_T] = q * share;
        terms[RUB_J] = of_j * share;
        terms[RUB_WORK] = (1.0 - m->loose) * w29 * share;
        terms[RUB_SPENT] = one * 0.0 * share;
        terms[RUB_HEAT] = one * 0.0 * share;
        series->factors[0][n] = q;
        series->factors[1][n] = turned;
        series->factors[2][n] = w32;
        series->factors[3][n] = w38;
        series->factors[4][n] = w39;
        series->factors[5][n] = -((1.0 - m->loose) * (m->friction * m->sigma)) * w40;
        series->factors[6][n] = w41;
        series->factors[7][n] = w42;
        one = 0.0;
    }
}

/* The Taylor series of four differences, from the factors that the state has given. */
static void rub_expand_differences(const struct parameters *m,
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
            const vec4 f2 = spread(series->factors[2][n - k]);
            sum_vx = fma4(f2, load(&series->apart[k][0]), sum_vx);
            const vec4 f3 = spread(series->factors[3][n - k]);
            sum_vx = fma4(f3, load(&series->apart[k][4]), sum_vx);
            const vec4 f4 = spread(series->factors[4][n - k]);
            sum_vx = fma4(f4, load(&series->apart[k][8]), sum_vx);
            const vec4 f5 = spread(series->factors[5][n - k]);
            sum_vy = fma4(f5, load(&series->apart[k][0]), sum_vy);
            const vec4 f6 = spread(series->factors[6][n - k]);
            sum_vy = fma4(f6, load(&series->apart[k][4]), sum_vy);
            const vec4 f7 = spread(series->factors[7][n - k]);
            sum_vy = fma4(f7, load(&series->apart[k][8]), sum_vy);
        }
        const vec4 share = spread(1.0 / (n + 1));
        store(&series->apart[n + 1][0], share * sum_x);
        store(&series->apart[n + 1][4], share * sum_y);
        store(&series->apart[n + 1][8], share * sum_vx);
        store(&series->apart[n + 1][12], share * sum_vy);
    }
}

const struct mode rub_mode = {
    .size = RUB_SIZE,
    .field = rub_field,
    .jacobian = rub_jacobian,
    .growth = rub_growth,
    .by_parameters = rub_by_parameters,
    .expand = rub_expand,
    .expand_with_factors = rub_expand_with_factors,
    .expand_differences = rub_expand_differences,
    .spent = rub_spent,
};

/* The rates of change of q, p, slip, c, s, down_r, down_t, t, j, work, spent, heat, drawn back to where they belong. */
static void rolling_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double of_q = 0.5 * p;
    const double square = q * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w3 = spring * (1.0 + m->contact_damping * p);
    const double push = (1.0 - m->loose) * w3;
    const double r = m->delta0 + square;
    const double w6 = ratio(1.0, r);
    const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r - m->rim * (-m->rim) * w6;
    const double of_p = outwards * q;
    const double w9 = w6 * q;
    const double turned = -m->rim * w9;
    const double turn = turned - m->omega * q;
    const double w12 = turn * s;
    const double of_c = -w12;
    const double w14 = c * c;
    const double w15 = s * s;
    const double w16 = (1.0 - (w14 + w15)) * q;
    const double w17 = w16 * c;
    const double of_s = turn * c;
    const double w19 = w16 * s;
    const double w20 = w9 * down_t;
    const double of_down_r = -m->rim * w20;
    const double w22 = down_r * down_r;
    const double w23 = down_t * down_t;
    const double w24 = (1.0 - (w22 + w23)) * q;
    const double w25 = w24 * down_r;
    const double w26 = w9 * down_r;
    const double of_down_t = m->rim * w26;
    const double w28 = w24 * down_t;
    const double w29 = w3 * q;
    const double of_j = (1.0 - m->loose) * w29;
    const double w31 = w29 * p;
    const double w32 = p * p;
    const double w33 = ratio(r, r);
    const double w34 = w33 * w33;
    const double damped = 2.0 * m->zeta * (w32 - -(-m->rim * (-m->rim)) * w34 - m->omega * (-m->rim) * r);
    const double w36 = r * down_t;
    const double spent = (damped + m->load * m->omega * w36) * q;
    const double w38 = ratio(p, r);
    const double hold = -(m->omega * m->omega) * s - 2.0 * m->zeta * (-m->rim) + m->load * down_t + m->rim * w38;
    const double w40 = hold * q;
    const double w41 = w40 * (m->rim + m->omega * r);
    rate[ROLLING_Q] = of_q;
    rate[ROLLING_P] = of_p;
    rate[ROLLING_SLIP] = 0.0;
    rate[ROLLING_C] = of_c + 0.1 * m->omega * w17;
    rate[ROLLING_S] = of_s + 0.1 * m->omega * w19;
    rate[ROLLING_DOWN_R] = of_down_r + 0.1 * m->omega * w25;
    rate[ROLLING_DOWN_T] = of_down_t + 0.1 * m->omega * w28;
    rate[ROLLING_T] = q;
    rate[ROLLING_J] = of_j;
    rate[ROLLING_WORK] = (1.0 - m->loose) * w31;
    rate[ROLLING_SPENT] = spent - w41;
    rate[ROLLING_HEAT] = 0.0;
}

/* Their derivatives by each of these, column by column. */
static void rolling_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 144; i++)
        matrix[i] = 0.0;
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double w0 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w0 * square;
    const double w3 = m->contact_damping * p + 1.0;
    const double w4 = spring * w3;
    const double w5 = (1.0 - m->loose) * w4;
    const double w6 = square + m->delta0;
    const double w7 = ratio(1.0, w6);
    const double w8 = w0 * q;
    const double w9 = (2.0 * w8 + m->hertz * square) * w3;
    const double w10 = w7 * q;
    const double w11 = ratio(w10, w6);
    const double w12 = (-(1.0 - m->loose) * w9 - 2.0 * m->shaft_stiffness * q - 2.0 * m->rim * m->rim * w11) * q;
    const double w13 = w11 * q;
    const double w14 = -m->rim * w7 + 2.0 * m->rim * w13;
    const double w15 = w14 - m->omega;
    const double w16 = w15 * s;
    const double w17 = c * c;
    const double w18 = s * s;
    const double w19 = -(w17 + w18) + 1.0;
    const double w20 = w19 * c;
    const double w21 = w15 * c;
    const double w22 = w19 * s;
    const double w23 = w14 * down_t;
    const double w24 = down_r * down_r;
    const double w25 = down_t * down_t;
    const double w26 = -(w24 + w25) + 1.0;
    const double w27 = w26 * down_r;
    const double w28 = w14 * down_r;
    const double w29 = w26 * down_t;
    const double w30 = w9 * q;
    const double w31 = (w5 + (1.0 - m->loose) * w30) * p;
    const double w32 = p * p;
    const double w33 = ratio(w6, w6);
    const double w34 = w33 * w33;
    const double w35 = w6 * down_t;
    const double w36 = w33 * q;
    const double w37 = ratio(-2.0 * m->rim * q + 2.0 * m->rim * w36, w6);
    const double w38 = w37 * w33;
    const double w39 = q * down_t;
    const double w40 = (2.0 * m->zeta * (-2.0 * m->rim * w38 - -2.0 * m->rim * m->omega * q) + 2.0 * (m->load * m->omega) * w39) * q;
    const double w41 = ratio(p, w6);
    const double w42 = -(m->omega * m->omega) * s - 2.0 * m->zeta * (-m->rim) + m->load * down_t + m->rim * w41;
    const double w43 = w41 * q;
    const double w44 = ratio(w43, w6);
    const double w45 = w44 * q;
    const double w46 = m->omega * w6 + m->rim;
    const double w47 = (w42 - 2.0 * m->rim * w45) * w46;
    const double w48 = w42 * q;
    const double w49 = w48 * q;
    const double w50 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w51 = spring * q;
    const double w52 = w51 * p;
    const double w53 = w4 * q;
    const double w54 = q * p;
    const double w55 = w10 * w46;
    const double w56 = q * c;
    const double w57 = w56 * c;
    const double w58 = w19 * q;
    const double w59 = 0.1 * m->omega * w58;
    const double w60 = -m->rim * w10;
    const double w61 = w60 - m->omega * q;
    const double w62 = w56 * s;
    const double w63 = q * s;
    const double w64 = w63 * c;
    const double w65 = w63 * s;
    const double w66 = w46 * q;
    const double w67 = q * down_r;
    const double w68 = w67 * down_r;
    const double w69 = w26 * q;
    const double w70 = 0.1 * m->omega * w69;
    const double w71 = w67 * down_t;
    const double w72 = w39 * down_r;
    const double w73 = w39 * down_t;
    const double w74 = w6 * q;
    matrix[1] = m->omega * m->omega * c - 2.0 * m->zeta * p - w5 - m->shaft_stiffness * w6 + m->load * down_r - -m->rim * m->rim * w7 + w12;
    matrix[3] = -w16 + 0.1 * m->omega * w20;
    matrix[4] = w21 + 0.1 * m->omega * w22;
    matrix[5] = w23 + 0.1 * m->omega * w27;
    matrix[6] = -w28 + 0.1 * m->omega * w29;
    matrix[7] = 1.0;
    matrix[8] = w5 + (1.0 - m->loose) * w30;
    matrix[9] = w31;
    matrix[10] = 2.0 * m->zeta * (w32 - -(-m->rim * (-m->rim)) * w34 - -m->rim * m->omega * w6) + m->load * m->omega * w35 + w40 - (w47 + 2.0 * m->omega * w49);
    matrix[12] = 0.5;
    matrix[13] = w50;
    matrix[20] = (1.0 - m->loose) * m->contact_damping * w51;
    matrix[21] = (1.0 - m->loose) * m->contact_damping * w52 + (1.0 - m->loose) * w53;
    matrix[22] = 4.0 * m->zeta * w54 - m->rim * w55;
    matrix[37] = m->omega * m->omega * q;
    matrix[39] = -0.2 * m->omega * w57 + w59;
    matrix[40] = w61 - 0.2 * m->omega * w62;
    matrix[51] = -w61 - 0.2 * m->omega * w64;
    matrix[52] = -0.2 * m->omega * w65 + w59;
    matrix[58] = m->omega * m->omega * w66;
    matrix[61] = m->load * q;
    matrix[65] = -0.2 * m->omega * w68 + w70;
    matrix[66] = m->rim * w10 - 0.2 * m->omega * w71;
    matrix[77] = w60 - 0.2 * m->omega * w72;
    matrix[78] = -0.2 * m->omega * w73 + w70;
    matrix[82] = m->load * m->omega * w74 - m->load * w66;
}

/* The rates of a small difference are this matrix times it. */
static void rolling_growth(const struct parameters *m,
    const double *state, double growth[4][4])
{
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double w2 = ratio(1.0, r);
    const double w3 = w2 * q;
    const double turned = -m->rim * w3;
    const double w5 = m->contact_damping * p + 1.0;
    const double w6 = (1.5 * m->hertz * q + m->linear) * w5;
    const double w7 = (-(1.0 - m->loose) * w6 - m->shaft_stiffness) * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w9 = w2 * spring;
    const double w10 = ratio(p, r);
    const double w11 = (-(-m->rim * (2.0 * m->zeta)) - m->omega * m->omega * s + m->load * down_t + m->disc_radius * m->omega * w10) * w2;
    const double w12 = (-((1.0 - m->loose) * (-m->rim * m->contact_damping)) * w9 + w11) * q;
    const double w13 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring) * q;
    const double w14 = ratio(w10, r);
    const double w15 = w14 * q;
    const double w16 = spring * w5;
    const double w17 = w16 * w2;
    const double w18 = (-2.0 * m->zeta * p + m->omega * m->omega * c - m->shaft_stiffness * r + m->load * down_r) * w2;
    const double w19 = ratio(w2, r);
    const double w20 = (-(1.0 - m->loose) * w17 - m->shaft_stiffness - (-m->shaft_stiffness - w18 - -(-m->rim * (m->disc_radius * m->omega)) * w19)) * q;
    const double w21 = (-(m->disc_radius * m->omega) * w2 + m->rim * w2) * q;
    growth[0][0] = 0.0;
    growth[0][1] = turned;
    growth[0][2] = q;
    growth[0][3] = 0.0;
    growth[1][0] = m->rim * w3;
    growth[1][1] = 0.0;
    growth[1][2] = 0.0;
    growth[1][3] = q;
    growth[2][0] = w7;
    growth[2][1] = w12;
    growth[2][2] = w13;
    growth[2][3] = turned;
    growth[3][0] = m->disc_radius * m->omega * w15;
    growth[3][1] = w20;
    growth[3][2] = w21;
    growth[3][3] = (-2.0 * m->zeta + 2.0 * m->zeta) * q;
}

/* What omega, zeta, delta0, shaft_stiffness, contact_damping, load, friction, disc_radius add to the rates by time of position and velocity. */
static void rolling_by_parameters(const struct parameters *m,
    const double *state, double added[PARAMETERS][4])
{
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double square = q * q;
    const double r = m->delta0 + square;
    const double w2 = -2.0 * m->omega * s;
    const double w3 = ratio(p, r);
    const double w4 = (1.5 * m->hertz * q + m->linear) * (m->contact_damping * p + 1.0);
    const double spring = (m->hertz * q + m->linear) * square;
    const double w6 = spring * p;
    added[0][0] = 0.0;
    added[0][1] = -r;
    added[0][2] = 2.0 * m->omega * c - m->rim;
    added[0][3] = w2 - (w2 + m->disc_radius * w3) - p;
    added[1][0] = 0.0;
    added[1][1] = 0.0;
    added[1][2] = -2.0 * p;
    added[1][3] = 2.0 * m->rim - 2.0 * m->rim;
    added[2][0] = 0.0;
    added[2][1] = 0.0;
    added[2][2] = (1.0 - m->loose) * w4;
    added[2][3] = 0.0;
    added[3][0] = 0.0;
    added[3][1] = 0.0;
    added[3][2] = -r;
    added[3][3] = 0.0;
    added[4][0] = 0.0;
    added[4][1] = 0.0;
    added[4][2] = -(1.0 - m->loose) * w6;
    added[4][3] = 0.0;
    added[5][0] = 0.0;
    added[5][1] = 0.0;
    added[5][2] = down_r;
    added[5][3] = down_t - down_t;
    added[6][0] = 0.0;
    added[6][1] = 0.0;
    added[6][2] = 0.0;
    added[6][3] = 0.0;
    added[7][0] = 0.0;
    added[7][1] = 0.0;
    added[7][2] = 0.0;
    added[7][3] = -m->omega * w3;
}

/* What is watched beside the state, and how it changes. */
static void rolling_watched(const struct parameters *m,
    const double *state, double *watched, double *rate)
{
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double w0 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w0 * square;
    const double w3 = m->contact_damping * p;
    const double w4 = spring * (1.0 + w3);
    const double grip = m->friction * (1.0 - m->loose) * w4;
    const double r = m->delta0 + square;
    const double w7 = ratio(p, r);
    const double hold = -(m->omega * m->omega) * s - 2.0 * m->zeta * (-m->rim) + m->load * down_t + m->rim * w7;
    const double w9 = w0 * q;
    const double w10 = (2.0 * w9 + m->hertz * square) * (w3 + 1.0);
    const double w11 = w10 * p;
    const double push = (1.0 - m->loose) * w4;
    const double w13 = ratio(1.0, r);
    const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r - m->rim * (-m->rim) * w13;
    const double of_p = outwards * q;
    const double w16 = of_p * spring;
    const double w17 = square + m->delta0;
    const double w18 = ratio(p, w17);
    const double w19 = w18 * q;
    const double w20 = ratio(w19, w17);
    const double w21 = w20 * p;
    const double w22 = ratio(1.0, w17);
    const double w23 = of_p * w22;
    const double w24 = w13 * q;
    const double turned = -m->rim * w24;
    const double turn = turned - m->omega * q;
    const double of_s = turn * c;
    const double w28 = w24 * down_r;
    watched[0] = grip;
    watched[1] = hold;
    rate[0] = 0.5 * ((1.0 - m->loose) * m->friction) * w11 + (1.0 - m->loose) * m->contact_damping * m->friction * w16;
    rate[1] = -m->rim * w21 + m->rim * w23 - m->omega * m->omega * of_s + m->load * m->rim * w28;
}

/* The Taylor series of the state: 13 lanes. */
static void rolling_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(12 <= WIDTH && 13 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][ROLLING_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 4);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[ROLLING_Q];
        const double p = here[ROLLING_P];
        const double c = here[ROLLING_C];
        const double s = here[ROLLING_S];
        const double down_r = here[ROLLING_DOWN_R];
        const double down_t = here[ROLLING_DOWN_T];
        const double of_q = 0.5 * p;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w3 = times(series, 2, n, spring, one * 1.0 + m->contact_damping * p);
        const double push = (1.0 - m->loose) * w3;
        const double r = one * m->delta0 + square;
        const double w6 = over(series, 3, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double outwards = m->omega * m->omega * c - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r - m->rim * (-m->rim) * w6;
        const double of_p = times(series, 4, n, outwards, q); /* outwards * q */
        const double w9 = times(series, 5, n, w6, q); /* w6 * q */
        const double turned = -m->rim * w9;
        const double turn = turned - m->omega * q;
        const double w12 = times(series, 6, n, turn, s); /* turn * s */
        const double of_c = -w12;
        const double of_s = times(series, 7, n, turn, c); /* turn * c */
        const double w15 = times(series, 8, n, w9, down_t); /* w9 * down_t */
        const double of_down_r = -m->rim * w15;
        const double w17 = times(series, 9, n, w9, down_r); /* w9 * down_r */
        const double of_down_t = m->rim * w17;
        const double w19 = times(series, 10, n, w3, q); /* w3 * q */
        const double of_j = (1.0 - m->loose) * w19;
        const double w21 = times(series, 11, n, w19, p); /* w19 * p */
        const double grip = m->friction * (1.0 - m->loose) * w3;
        const double w23 = over(series, 12, n, p, r, inverse_r); /* p / r */
        const double hold = -(m->omega * m->omega) * s - one * (2.0 * m->zeta * (-m->rim)) + m->load * down_t + m->rim * w23;
        terms[ROLLING_Q] = of_q * share;
        terms[ROLLING_P] = of_p * share;
        terms[ROLLING_SLIP] = one * 0.0 * share;
        terms[ROLLING_C] = of_c * share;
        terms[ROLLING_S] = of_s * share;
        terms[ROLLING_DOWN_R] = of_down_r * share;
        terms[ROLLING_DOWN_T] = of_down_t * share;
        terms[ROLLING_T] = q * share;
        terms[ROLLING_J] = of_j * share;
        terms[ROLLING_WORK] = (1.0 - m->loose) * w21 * share;
        terms[ROLLING_SPENT] = one * 0.0 * share;
        terms[ROLLING_HEAT] = one * 0.0 * share;
        series->watched[n][0] = grip;
        series->watched[n][1] = hold;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rolling_spent(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {ROLLING_Q, ROLLING_P, ROLLING_S, ROLLING_DOWN_T};
    vec4 read[4][AT_ONCE];
    read_parts(series, order, reads, 4, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 s = read[2][v];
        const vec4 down_t = read[3][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = (r) / (r);
        const vec4 w4 = w3 * w3;
        const vec4 damped = 2.0 * m->zeta * (w0 - -(-m->rim * (-m->rim)) * w4 - m->omega * (-m->rim) * r);
        const vec4 w6 = r * down_t;
        const vec4 spent = (damped + m->load * m->omega * w6) * q;
        const vec4 w8 = (p) / (r);
        const vec4 hold = -(m->omega * m->omega) * s - 2.0 * m->zeta * (-m->rim) + m->load * down_t + m->rim * w8;
        const vec4 w10 = hold * q;
        const vec4 w11 = w10 * (m->rim + m->omega * r);
        rate[v][0] = spent - w11;
        rate[v][1] = spread(0.0);
    }
}

/* The Taylor series of the state, and the factors of differences: 27 lanes. */
static void rolling_expand_with_factors(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(12 <= WIDTH && 27 <= LANES && 8 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][ROLLING_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 7);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[ROLLING_Q];
        const double p = here[ROLLING_P];
        const double c = here[ROLLING_C];
        const double s = here[ROLLING_S];
        const double down_r = here[ROLLING_DOWN_R];
        const double down_t = here[ROLLING_DOWN_T];
        const double of_q = 0.5 * p;
        const double w1 = m->omega * m->omega * c;
        const double square = times(series, 0, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 1, n, m->hertz * q + one * m->linear, square);
        const double w4 = m->contact_damping * p;
        const double w5 = times(series, 2, n, spring, one * 1.0 + w4); /* spring * (1.0 + w4) */
        const double push = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double w8 = m->shaft_stiffness * r;
        const double w9 = m->load * down_r;
        const double w10 = over(series, 3, n, one * 1.0, r, inverse_r); /* 1.0 / r */
        const double outwards = w1 - 2.0 * m->zeta * p - push - w8 + w9 - m->rim * (-m->rim) * w10;
        const double of_p = times(series, 4, n, outwards, q); /* outwards * q */
        const double w13 = times(series, 5, n, w10, q); /* w10 * q */
        const double turned = -m->rim * w13;
        const double turn = turned - m->omega * q;
        const double w16 = times(series, 6, n, turn, s); /* turn * s */
        const double of_c = -w16;
        const double of_s = times(series, 7, n, turn, c); /* turn * c */
        const double w19 = times(series, 8, n, w13, down_t); /* w13 * down_t */
        const double of_down_r = -m->rim * w19;
        const double w21 = times(series, 9, n, w13, down_r); /* w13 * down_r */
        const double of_down_t = m->rim * w21;
        const double w23 = times(series, 10, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w23;
        const double w25 = times(series, 11, n, w23, p); /* w23 * p */
        const double w26 = w4 + one * 1.0;
        /* (1.5 * hertz * q + linear) * w26 */
        const double w27 = times(series, 12, n, 1.5 * m->hertz * q + one * m->linear, w26);
        /* (-(1.0 - loose) * w27 - shaft_stiffness) * q */
        const double w28 = times(series, 13, n, -(1.0 - m->loose) * w27 - one * m->shaft_stiffness, q);
        const double w29 = times(series, 14, n, w10, spring); /* w10 * spring */
        const double w30 = m->load * down_t;
        const double w31 = over(series, 15, n, p, r, inverse_r); /* p / r */
        /* (-(-rim * (2.0 * zeta)) - omega * omega * s + w30 + disc_radius * omega * w31) * w10 */
        const double w32 = times(series, 16, n, one * (-(-m->rim * (2.0 * m->zeta))) - m->omega * m->omega * s + w30 + m->disc_radius * m->omega * w31, w10);
        /* (-((1.0 - loose) * (-rim * contact_damping)) * w29 + w32) * q */
        const double w33 = times(series, 17, n, -((1.0 - m->loose) * (-m->rim * m->contact_damping)) * w29 + w32, q);
        /* (-2.0 * zeta - (1.0 - loose) * contact_damping * spring) * q */
        const double w34 = times(series, 18, n, one * (-2.0 * m->zeta) - (1.0 - m->loose) * m->contact_damping * spring, q);
        const double w35 = over(series, 19, n, w31, r, inverse_r); /* w31 / r */
        const double w36 = times(series, 20, n, w35, q); /* w35 * q */
        const double w37 = times(series, 21, n, spring, w26); /* spring * w26 */
        const double w38 = times(series, 22, n, w37, w10); /* w37 * w10 */
        /* (-2.0 * zeta * p + w1 - w8 + w9) * w10 */
        const double w39 = times(series, 23, n, -2.0 * m->zeta * p + w1 - w8 + w9, w10);
        const double w40 = over(series, 24, n, w10, r, inverse_r); /* w10 / r */
        /* (-(1.0 - loose) * w38 - shaft_stiffness - (-shaft_stiffness - w39 - -(-rim * (disc_radius * omega)) * w40)) * q */
        const double w41 = times(series, 25, n, -(1.0 - m->loose) * w38 - one * m->shaft_stiffness - (one * (-m->shaft_stiffness) - w39 - -(-m->rim * (m->disc_radius * m->omega)) * w40), q);
        /* (-(disc_radius * omega) * w10 + rim * w10) * q */
        const double w42 = times(series, 26, n, -(m->disc_radius * m->omega) * w10 + m->rim * w10, q);
        const double grip = m->friction * (1.0 - m->loose) * w5;
        const double hold = -(m->omega * m->omega) * s - one * (2.0 * m->zeta * (-m->rim)) + w30 + m->rim * w31;
        terms[ROLLING_Q] = of_q * share;
        terms[ROLLING_P] = of_p * share;
        terms[ROLLING_SLIP] = one * 0.0 * share;
        terms[ROLLING_C] = of_c * share;
        terms[ROLLING_S] = of_s * share;
        terms[ROLLING_DOWN_R] = of_down_r * share;
        terms[ROLLING_DOWN_T] = of_down_t * share;
        terms[ROLLING_T] = q * share;
        terms[ROLLING_J] = of_j * share;
        terms[ROLLING_WORK] = (1.0 - m->loose) * w25 * share;
        terms[ROLLING_SPENT] = one * 0.0 * share;
        terms[ROLLING_HEAT] = one * 0.0 * share;
        series->factors[0][n] = q;
        series->factors[1][n] = turned;
        series->factors[2][n] = w28;
        series->factors[3][n] = w33;
        series->factors[4][n] = w34;
        series->factors[5][n] = m->disc_radius * m->omega * w36;
        series->factors[6][n] = w41;
        series->factors[7][n] = w42;
        series->watched[n][0] = grip;
        series->watched[n][1] = hold;
        one = 0.0;
    }
}

/* The Taylor series of four differences, from the factors that the state has given. */
static void rolling_expand_differences(const struct parameters *m,
    struct series *series, int order)
{
    for (int n = 0; n < order; n++) {
        const vec4 vx = load(&series->apart[n][8]);
        const vec4 vy = load(&series->apart[n][12]);
        /* what does not change in time */
        store(&series->steady[n][0], vx);
        store(&series->steady[n][4], vy);
        store(&series->steady[n][8], spread(0.0));
        store(&series->steady[n][12], spread(-2.0 * m->zeta + 2.0 * m->zeta) * vy);
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
            const vec4 f2 = spread(series->factors[2][n - k]);
            sum_vx = fma4(f2, load(&series->apart[k][0]), sum_vx);
            const vec4 f3 = spread(series->factors[3][n - k]);
            sum_vx = fma4(f3, load(&series->apart[k][4]), sum_vx);
            const vec4 f4 = spread(series->factors[4][n - k]);
            sum_vx = fma4(f4, load(&series->apart[k][8]), sum_vx);
            const vec4 f5 = spread(series->factors[5][n - k]);
            sum_vy = fma4(f5, load(&series->apart[k][0]), sum_vy);
            const vec4 f6 = spread(series->factors[6][n - k]);
            sum_vy = fma4(f6, load(&series->apart[k][4]), sum_vy);
            const vec4 f7 = spread(series->factors[7][n - k]);
            sum_vy = fma4(f7, load(&series->apart[k][8]), sum_vy);
        }
        const vec4 share = spread(1.0 / (n + 1));
        store(&series->apart[n + 1][0], share * sum_x);
        store(&series->apart[n + 1][4], share * sum_y);
        store(&series->apart[n + 1][8], share * sum_vx);
        store(&series->apart[n + 1][12], share * sum_vy);
    }
}

const struct mode rolling_mode = {
    .size = ROLLING_SIZE,
    .field = rolling_field,
    .jacobian = rolling_jacobian,
    .growth = rolling_growth,
    .by_parameters = rolling_by_parameters,
    .expand = rolling_expand,
    .expand_with_factors = rolling_expand_with_factors,
    .expand_differences = rolling_expand_differences,
    .watched = rolling_watched,
    .spent = rolling_spent,
};

#endif
