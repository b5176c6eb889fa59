/* Derived from rotor_ida/model/spinning.py by `python -m rotor_ida.model.writing`. */
/* clang-format off */
#ifdef RUN_UP
#include "motion.h"

/* The rates of change of q, p, h, c, s, down_r, down_t, speed, t, angle, j, work, spent, drawn back to where they belong. */
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
    const double speed = state[CONTACT_SPEED];
    const double of_q = 0.5 * p;
    const double w1 = speed * speed;
    const double w2 = w1 * c;
    const double square = q * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w5 = spring * (1.0 + m->contact_damping * p);
    const double force = (1.0 - m->loose) * w5;
    const double r = m->delta0 + square;
    const double radial = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r;
    const double around = ratio(h, r);
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double w12 = p * s;
    const double w13 = around * c;
    const double velocity = w12 + w13;
    const double w15 = w5 * s;
    const double w16 = r * s;
    const double pull = (1.0 - m->loose) * w15 + m->shaft_stiffness * w16;
    const double left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull;
    const double faster = m->rate + m->inverse_inertia * left;
    const double w20 = faster * s;
    const double outwards = radial + centrifugal - w20;
    const double of_p = outwards * q;
    const double w23 = w1 * s;
    const double tangential = -w23 - 2.0 * m->zeta * around + m->load * down_t;
    const double w25 = faster * c;
    const double sideways = tangential - w25;
    const double moment = sideways * r;
    const double of_h = moment * q;
    const double turned = spin * q;
    const double w30 = q * speed;
    const double turn = turned - w30;
    const double w32 = turn * s;
    const double of_c = -w32;
    const double w34 = c * c;
    const double w35 = s * s;
    const double w36 = (1.0 - (w34 + w35)) * w30;
    const double w37 = w36 * c;
    const double of_s = turn * c;
    const double w39 = w36 * s;
    const double of_down_r = turned * down_t;
    const double w41 = down_r * down_r;
    const double w42 = down_t * down_t;
    const double w43 = (1.0 - (w41 + w42)) * w30;
    const double w44 = w43 * down_r;
    const double w45 = turned * down_r;
    const double of_down_t = -w45;
    const double w47 = w43 * down_t;
    const double w48 = faster * q;
    const double w49 = w5 * q;
    const double of_j = (1.0 - m->loose) * w49;
    const double w51 = w49 * p;
    const double of_work = (1.0 - m->loose) * w51;
    const double w53 = p * p;
    const double w54 = around * around;
    const double w55 = h * speed;
    const double damped = 2.0 * m->zeta * (w53 + w54 - w55);
    const double w57 = r * speed;
    const double w58 = w57 * down_t;
    const double w59 = (damped + m->load * w58) * q;
    const double w60 = around * r;
    const double w61 = r * c;
    const double w62 = w61 * speed;
    const double w63 = w48 * (velocity + w60 + w62);
    rate[CONTACT_Q] = of_q;
    rate[CONTACT_P] = of_p;
    rate[CONTACT_H] = of_h;
    rate[CONTACT_C] = of_c + 0.1 * w37;
    rate[CONTACT_S] = of_s + 0.1 * w39;
    rate[CONTACT_DOWN_R] = of_down_r + 0.1 * w44;
    rate[CONTACT_DOWN_T] = of_down_t + 0.1 * w47;
    rate[CONTACT_SPEED] = w48;
    rate[CONTACT_T] = q;
    rate[CONTACT_ANGLE] = w30;
    rate[CONTACT_J] = of_j;
    rate[CONTACT_WORK] = of_work;
    rate[CONTACT_SPENT] = w59 + w63;
}

/* Their derivatives by each of these, column by column. */
static void contact_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 169; i++)
        matrix[i] = 0.0;
    const double q = state[CONTACT_Q];
    const double p = state[CONTACT_P];
    const double h = state[CONTACT_H];
    const double c = state[CONTACT_C];
    const double s = state[CONTACT_S];
    const double down_r = state[CONTACT_DOWN_R];
    const double down_t = state[CONTACT_DOWN_T];
    const double speed = state[CONTACT_SPEED];
    const double w0 = speed * speed;
    const double w1 = w0 * c;
    const double w2 = 2.0 * m->zeta * p;
    const double w3 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w3 * square;
    const double w6 = m->contact_damping * p + 1.0;
    const double w7 = spring * w6;
    const double w8 = (1.0 - m->loose) * w7;
    const double w9 = square + m->delta0;
    const double w10 = m->shaft_stiffness * w9;
    const double w11 = ratio(h, w9);
    const double w12 = ratio(w11, w9);
    const double w13 = w12 * w11;
    const double w14 = p * s;
    const double w15 = w11 * c;
    const double w16 = w14 + w15;
    const double w17 = w7 * s;
    const double w18 = w9 * s;
    const double w19 = m->inverse_inertia * (-m->slope * speed + m->torque + 2.0 * m->zeta * w16 + ((1.0 - m->loose) * w17 + m->shaft_stiffness * w18)) + m->rate;
    const double w20 = w19 * s;
    const double w21 = w3 * q;
    const double w22 = (2.0 * w21 + m->hertz * square) * w6;
    const double w23 = w11 * q;
    const double w24 = ratio(w23, w9);
    const double w25 = w24 * w12;
    const double w26 = w12 * q;
    const double w27 = ratio(-2.0 * w24 - 2.0 * w26, w9);
    const double w28 = w27 * w11;
    const double w29 = w24 * c;
    const double w30 = w22 * s;
    const double w31 = q * s;
    const double w32 = -4.0 * m->zeta * w29 + ((1.0 - m->loose) * w30 + 2.0 * m->shaft_stiffness * w31);
    const double w33 = w32 * s;
    const double w34 = (-(1.0 - m->loose) * w22 - 2.0 * m->shaft_stiffness * q + (-2.0 * w25 + w28) - m->inverse_inertia * w33) * q;
    const double w35 = w0 * s;
    const double w36 = w19 * c;
    const double w37 = -w35 - 2.0 * m->zeta * w11 + m->load * down_t - w36;
    const double w38 = w37 * w9;
    const double w39 = w37 * q;
    const double w40 = w32 * c;
    const double w41 = (4.0 * m->zeta * w24 - m->inverse_inertia * w40) * w9;
    const double w42 = (2.0 * w39 + w41) * q;
    const double w43 = w27 * q;
    const double w44 = w12 + w43;
    const double w45 = w44 - speed;
    const double w46 = w45 * s;
    const double w47 = c * c;
    const double w48 = s * s;
    const double w49 = -(w47 + w48) + 1.0;
    const double w50 = w49 * speed;
    const double w51 = w50 * c;
    const double w52 = w45 * c;
    const double w53 = w50 * s;
    const double w54 = w44 * down_t;
    const double w55 = down_r * down_r;
    const double w56 = down_t * down_t;
    const double w57 = -(w55 + w56) + 1.0;
    const double w58 = w57 * speed;
    const double w59 = w58 * down_r;
    const double w60 = w44 * down_r;
    const double w61 = w58 * down_t;
    const double w62 = w32 * q;
    const double w63 = w22 * q;
    const double w64 = (w8 + (1.0 - m->loose) * w63) * p;
    const double w65 = p * p;
    const double w66 = w11 * w11;
    const double w67 = h * speed;
    const double w68 = w9 * speed;
    const double w69 = w68 * down_t;
    const double w70 = w24 * w11;
    const double w71 = q * speed;
    const double w72 = w71 * down_t;
    const double w73 = (-8.0 * m->zeta * w70 + 2.0 * m->load * w72) * q;
    const double w74 = w11 * w9;
    const double w75 = w9 * c;
    const double w76 = w75 * speed;
    const double w77 = w16 + w74 + w76;
    const double w78 = (w19 + m->inverse_inertia * w62) * w77;
    const double w79 = w19 * q;
    const double w80 = w24 * w9;
    const double w81 = q * c;
    const double w82 = w81 * speed;
    const double w83 = w79 * (-2.0 * w29 + (2.0 * w23 - 2.0 * w80) + 2.0 * w82);
    const double w84 = spring * s;
    const double w85 = 2.0 * m->zeta * s + (1.0 - m->loose) * m->contact_damping * w84;
    const double w86 = w85 * s;
    const double w87 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring - m->inverse_inertia * w86) * q;
    const double w88 = w85 * c;
    const double w89 = w88 * w9;
    const double w90 = w89 * q;
    const double w91 = w85 * q;
    const double w92 = spring * q;
    const double w93 = w92 * p;
    const double w94 = w7 * q;
    const double w95 = q * p;
    const double w96 = w91 * w77;
    const double w97 = w79 * s;
    const double w98 = ratio(1.0, w9);
    const double w99 = w12 * w98;
    const double w100 = ratio(w98, w9);
    const double w101 = w100 * w11;
    const double w102 = w98 * c;
    const double w103 = w102 * s;
    const double w104 = (w99 + w101 - 2.0 * m->zeta * m->inverse_inertia * w103) * q;
    const double w105 = w102 * c;
    const double w106 = (-2.0 * m->zeta * w98 - 2.0 * m->zeta * m->inverse_inertia * w105) * w9;
    const double w107 = w106 * q;
    const double w108 = w100 * q;
    const double w109 = w108 * s;
    const double w110 = w108 * c;
    const double w111 = w108 * down_t;
    const double w112 = w108 * down_r;
    const double w113 = w102 * q;
    const double w114 = w11 * w98;
    const double w115 = (2.0 * w114 - speed) * q;
    const double w116 = w77 * w113;
    const double w117 = w98 * w9;
    const double w118 = w79 * (w102 + w117);
    const double w119 = w11 * s;
    const double w120 = (w0 - 2.0 * m->zeta * m->inverse_inertia * w119) * q;
    const double w121 = (2.0 * m->zeta * m->inverse_inertia * w15 + w19) * w9;
    const double w122 = w121 * q;
    const double w123 = w71 * c;
    const double w124 = w123 * c;
    const double w125 = w49 * w71;
    const double w126 = 0.1 * w125;
    const double w127 = w26 - w71;
    const double w128 = w123 * s;
    const double w129 = w77 * w23;
    const double w130 = w79 * (w11 + w68);
    const double w131 = w2 + (w8 + w10);
    const double w132 = w131 * s;
    const double w133 = (m->inverse_inertia * w132 + w19) * q;
    const double w134 = w131 * c;
    const double w135 = (-w0 - m->inverse_inertia * w134) * w9;
    const double w136 = w135 * q;
    const double w137 = w71 * s;
    const double w138 = w137 * c;
    const double w139 = w137 * s;
    const double w140 = w131 * q;
    const double w141 = w140 * w77;
    const double w142 = w79 * p;
    const double w143 = w71 * down_r;
    const double w144 = w143 * down_r;
    const double w145 = w57 * w71;
    const double w146 = 0.1 * w145;
    const double w147 = w143 * down_t;
    const double w148 = w9 * q;
    const double w149 = w72 * down_r;
    const double w150 = w72 * down_t;
    const double w151 = w68 * q;
    const double w152 = c * speed;
    const double w153 = (2.0 * w152 - -m->slope * m->inverse_inertia * s) * q;
    const double w154 = s * speed;
    const double w155 = (-2.0 * w154 - -m->slope * m->inverse_inertia * c) * w9;
    const double w156 = w155 * q;
    const double w157 = w49 * q;
    const double w158 = w157 * c;
    const double w159 = w157 * s;
    const double w160 = w57 * q;
    const double w161 = w160 * down_r;
    const double w162 = w160 * down_t;
    const double w163 = w9 * down_t;
    const double w164 = (-2.0 * m->zeta * h + m->load * w163) * q;
    const double w165 = w77 * q;
    const double w166 = w79 * w75;
    matrix[1] = w1 - w2 - w8 - w10 + m->load * down_r + w13 - w20 + w34;
    matrix[2] = w38 + w42;
    matrix[3] = -w46 + 0.1 * w51;
    matrix[4] = w52 + 0.1 * w53;
    matrix[5] = w54 + 0.1 * w59;
    matrix[6] = -w60 + 0.1 * w61;
    matrix[7] = w19 + m->inverse_inertia * w62;
    matrix[8] = 1.0;
    matrix[9] = speed;
    matrix[10] = w8 + (1.0 - m->loose) * w63;
    matrix[11] = w64;
    matrix[12] = 2.0 * m->zeta * (w65 + w66 - w67) + m->load * w69 + w73 + (w78 + w83);
    matrix[13] = 0.5;
    matrix[14] = w87;
    matrix[15] = -m->inverse_inertia * w90;
    matrix[20] = m->inverse_inertia * w91;
    matrix[23] = (1.0 - m->loose) * m->contact_damping * w92;
    matrix[24] = (1.0 - m->loose) * m->contact_damping * w93 + (1.0 - m->loose) * w94;
    matrix[25] = 4.0 * m->zeta * w95 + (m->inverse_inertia * w96 + w97);
    matrix[27] = w104;
    matrix[28] = w107;
    matrix[29] = -w109;
    matrix[30] = w110;
    matrix[31] = w111;
    matrix[32] = -w112;
    matrix[33] = 2.0 * m->zeta * m->inverse_inertia * w113;
    matrix[38] = 2.0 * m->zeta * w115 + (2.0 * m->zeta * m->inverse_inertia * w116 + w118);
    matrix[40] = w120;
    matrix[41] = -w122;
    matrix[42] = -0.2 * w124 + w126;
    matrix[43] = w127 - 0.2 * w128;
    matrix[46] = 2.0 * m->zeta * m->inverse_inertia * w23;
    matrix[51] = 2.0 * m->zeta * m->inverse_inertia * w129 + w130;
    matrix[53] = -w133;
    matrix[54] = w136;
    matrix[55] = -w127 - 0.2 * w138;
    matrix[56] = -0.2 * w139 + w126;
    matrix[59] = m->inverse_inertia * w140;
    matrix[64] = m->inverse_inertia * w141 + w142;
    matrix[66] = m->load * q;
    matrix[70] = -0.2 * w144 + w146;
    matrix[71] = -w26 - 0.2 * w147;
    matrix[80] = m->load * w148;
    matrix[83] = w26 - 0.2 * w149;
    matrix[84] = -0.2 * w150 + w146;
    matrix[90] = m->load * w151;
    matrix[92] = w153;
    matrix[93] = w156;
    matrix[94] = w31 + 0.1 * w158;
    matrix[95] = -w81 + 0.1 * w159;
    matrix[96] = 0.1 * w161;
    matrix[97] = 0.1 * w162;
    matrix[98] = -m->slope * m->inverse_inertia * q;
    matrix[100] = q;
    matrix[103] = w164 + (-m->slope * m->inverse_inertia * w165 + w166);
}

/* The Taylor series of the state: 27 lanes. */
static void contact_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(13 <= WIDTH && 27 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
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
        const double speed = here[CONTACT_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double force = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double radial = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r;
        const double around = over(series, 5, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 6, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 7, n, spin, around); /* spin * around */
        const double w12 = times(series, 8, n, p, s); /* p * s */
        const double w13 = times(series, 9, n, around, c); /* around * c */
        const double velocity = w12 + w13;
        const double w15 = times(series, 10, n, w5, s); /* w5 * s */
        const double w16 = times(series, 11, n, r, s); /* r * s */
        const double pull = (1.0 - m->loose) * w15 + m->shaft_stiffness * w16;
        const double left = one * m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull;
        const double faster = one * m->rate + m->inverse_inertia * left;
        const double w20 = times(series, 12, n, faster, s); /* faster * s */
        const double outwards = radial + centrifugal - w20;
        const double of_p = times(series, 13, n, outwards, q); /* outwards * q */
        const double w23 = times(series, 14, n, w1, s); /* w1 * s */
        const double tangential = -w23 - 2.0 * m->zeta * around + m->load * down_t;
        const double w25 = times(series, 15, n, faster, c); /* faster * c */
        const double sideways = tangential - w25;
        const double moment = times(series, 16, n, sideways, r); /* sideways * r */
        const double of_h = times(series, 17, n, moment, q); /* moment * q */
        const double turned = times(series, 18, n, spin, q); /* spin * q */
        const double w30 = times(series, 19, n, q, speed); /* q * speed */
        const double turn = turned - w30;
        const double w32 = times(series, 20, n, turn, s); /* turn * s */
        const double of_c = -w32;
        const double of_s = times(series, 21, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 22, n, turned, down_t); /* turned * down_t */
        const double w36 = times(series, 23, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w36;
        const double w38 = times(series, 24, n, faster, q); /* faster * q */
        const double w39 = times(series, 25, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w39;
        const double w41 = times(series, 26, n, w39, p); /* w39 * p */
        const double of_work = (1.0 - m->loose) * w41;
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_SPEED] = w38 * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_ANGLE] = w30 * share;
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
    static const int reads[] = {CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_DOWN_T, CONTACT_SPEED};
    vec4 read[7][AT_ONCE];
    read_parts(series, order, reads, 7, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 h = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 down_t = read[5][v];
        const vec4 speed = read[6][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 around = (h) / (r);
        const vec4 w4 = around * around;
        const vec4 w5 = h * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 + w4 - w5);
        const vec4 w7 = r * speed;
        const vec4 w8 = w7 * down_t;
        const vec4 w9 = (damped + m->load * w8) * q;
        const vec4 w10 = p * s;
        const vec4 w11 = around * c;
        const vec4 velocity = w10 + w11;
        const vec4 spring = (m->hertz * q + m->linear) * square;
        const vec4 w14 = spring * (1.0 + m->contact_damping * p);
        const vec4 w15 = w14 * s;
        const vec4 w16 = r * s;
        const vec4 pull = (1.0 - m->loose) * w15 + m->shaft_stiffness * w16;
        const vec4 left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull;
        const vec4 faster = m->rate + m->inverse_inertia * left;
        const vec4 w20 = faster * q;
        const vec4 w21 = around * r;
        const vec4 w22 = r * c;
        const vec4 w23 = w22 * speed;
        const vec4 w24 = w20 * (velocity + w21 + w23);
        rate[v][0] = w9 + w24;
        rate[v][1] = spread(0.0);
    }
}

/* The Taylor series of the state: 20 lanes. */
static void contact_expand_prescribed(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(13 <= WIDTH && 20 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][CONTACT_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 5);
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
        const double speed = here[CONTACT_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double force = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double radial = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r;
        const double around = over(series, 5, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 6, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 7, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal - m->rate * s;
        const double of_p = times(series, 8, n, outwards, q); /* outwards * q */
        const double w14 = times(series, 9, n, w1, s); /* w1 * s */
        const double tangential = -w14 - 2.0 * m->zeta * around + m->load * down_t;
        const double sideways = tangential - m->rate * c;
        const double moment = times(series, 10, n, sideways, r); /* sideways * r */
        const double of_h = times(series, 11, n, moment, q); /* moment * q */
        const double turned = times(series, 12, n, spin, q); /* spin * q */
        const double w20 = times(series, 13, n, q, speed); /* q * speed */
        const double turn = turned - w20;
        const double w22 = times(series, 14, n, turn, s); /* turn * s */
        const double of_c = -w22;
        const double of_s = times(series, 15, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 16, n, turned, down_t); /* turned * down_t */
        const double w26 = times(series, 17, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w26;
        const double w28 = times(series, 18, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w28;
        const double w30 = times(series, 19, n, w28, p); /* w28 * p */
        const double of_work = (1.0 - m->loose) * w30;
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = of_down_r * share;
        terms[CONTACT_DOWN_T] = of_down_t * share;
        terms[CONTACT_SPEED] = m->rate * q * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_ANGLE] = w20 * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = of_work * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void contact_spent_prescribed(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_DOWN_T, CONTACT_SPEED};
    vec4 read[7][AT_ONCE];
    read_parts(series, order, reads, 7, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 h = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 down_t = read[5][v];
        const vec4 speed = read[6][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 around = (h) / (r);
        const vec4 w4 = around * around;
        const vec4 w5 = h * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 + w4 - w5);
        const vec4 w7 = r * speed;
        const vec4 w8 = w7 * down_t;
        const vec4 w9 = (damped + m->load * w8) * q;
        const vec4 w10 = p * s;
        const vec4 w11 = around * c;
        const vec4 velocity = w10 + w11;
        const vec4 w13 = around * r;
        const vec4 w14 = r * c;
        const vec4 w15 = w14 * speed;
        const vec4 w16 = (velocity + w13 + w15) * q;
        rate[v][0] = w9 + m->rate * w16;
        rate[v][1] = spread(0.0);
    }
}

/* The Taylor series of the state: 16 lanes. */
static void contact_expand_plain(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(13 <= WIDTH && 16 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
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
        const double speed = here[CONTACT_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        const double spring = times(series, 3, n, square, q); /* square * q */
        const double radial = w2 - 2.0 * m->zeta * p - spring;
        const double r = one * m->delta0 + square;
        const double around = over(series, 4, n, h, r, inverse_r); /* h / r */
        const double spin = over(series, 5, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 6, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal - m->rate * s;
        const double of_p = times(series, 7, n, outwards, q); /* outwards * q */
        const double w12 = times(series, 8, n, w1, s); /* w1 * s */
        const double tangential = -w12 - 2.0 * m->zeta * around;
        const double sideways = tangential - m->rate * c;
        const double moment = times(series, 9, n, sideways, r); /* sideways * r */
        const double of_h = times(series, 10, n, moment, q); /* moment * q */
        const double turned = times(series, 11, n, spin, q); /* spin * q */
        const double w18 = times(series, 12, n, q, speed); /* q * speed */
        const double turn = turned - w18;
        const double w20 = times(series, 13, n, turn, s); /* turn * s */
        const double of_c = -w20;
        const double of_s = times(series, 14, n, turn, c); /* turn * c */
        const double of_j = times(series, 15, n, spring, q); /* spring * q */
        terms[CONTACT_Q] = of_q * share;
        terms[CONTACT_P] = of_p * share;
        terms[CONTACT_H] = of_h * share;
        terms[CONTACT_C] = of_c * share;
        terms[CONTACT_S] = of_s * share;
        terms[CONTACT_DOWN_R] = one * 0.0 * share;
        terms[CONTACT_DOWN_T] = one * 0.0 * share;
        terms[CONTACT_SPEED] = m->rate * q * share;
        terms[CONTACT_T] = q * share;
        terms[CONTACT_ANGLE] = w18 * share;
        terms[CONTACT_J] = of_j * share;
        terms[CONTACT_WORK] = one * 0.0 * share;
        terms[CONTACT_SPENT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void contact_spent_plain(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_C, CONTACT_S, CONTACT_SPEED};
    vec4 read[6][AT_ONCE];
    read_parts(series, order, reads, 6, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 h = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 speed = read[5][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 around = (h) / (r);
        const vec4 w4 = around * around;
        const vec4 w5 = h * speed;
        const vec4 w6 = (w0 + w4 - w5) * q;
        const vec4 w7 = p * s;
        const vec4 w8 = around * c;
        const vec4 velocity = w7 + w8;
        const vec4 w10 = around * r;
        const vec4 w11 = r * c;
        const vec4 w12 = w11 * speed;
        const vec4 w13 = (velocity + w10 + w12) * q;
        rate[v][0] = 2.0 * m->zeta * w6 + m->rate * w13;
        rate[v][1] = spread(0.0);
    }
}

const struct mode contact_mode = {
    .size = CONTACT_SIZE,
    .field = contact_field,
    .jacobian = contact_jacobian,
    .expand = contact_expand,
    .expand_prescribed = contact_expand_prescribed,
    .expand_plain = contact_expand_plain,
    .spent = contact_spent,
    .spent_prescribed = contact_spent_prescribed,
    .spent_plain = contact_spent_plain,
};

/* The rates of change of x, y, vx, vy, down_x, down_y, speed, angle. */
static void cartesian_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    const double down_x = state[CARTESIAN_DOWN_X];
    const double down_y = state[CARTESIAN_DOWN_Y];
    const double speed = state[CARTESIAN_SPEED];
    const double w0 = y * speed;
    const double w1 = x * speed;
    const double w2 = speed * speed;
    const double w3 = x * x;
    const double w4 = y * y;
    const double square = w3 + w4;
    const double w6 = sqrt(sqrt(square));
    const double w7 = m->hertz * w6 + m->linear;
    const double w8 = w7 * x;
    const double w9 = vy * speed;
    const double w10 = w7 * y;
    const double w11 = m->felt * w10;
    const double w12 = m->shaft_stiffness * y;
    const double w13 = vx * speed;
    const double pull = w11 + w12;
    const double left = m->torque - m->slope * speed + 2.0 * m->zeta * vy + pull;
    const double faster = m->rate + m->inverse_inertia * left;
    const double w17 = down_y * speed;
    const double w18 = down_x * speed;
    rate[CARTESIAN_X] = vx + w0;
    rate[CARTESIAN_Y] = vy - w1;
    rate[CARTESIAN_VX] = w2 - 2.0 * m->zeta * vx - m->felt * w8 - m->shaft_stiffness * x + m->load * down_x + w9;
    rate[CARTESIAN_VY] = -2.0 * m->zeta * vy - w11 - w12 + m->load * down_y - w13 - faster;
    rate[CARTESIAN_DOWN_X] = w17;
    rate[CARTESIAN_DOWN_Y] = -w18;
    rate[CARTESIAN_SPEED] = faster;
    rate[CARTESIAN_ANGLE] = speed;
}

/* Their derivatives by each of these, column by column. */
static void cartesian_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 64; i++)
        matrix[i] = 0.0;
    const double x = state[CARTESIAN_X];
    const double y = state[CARTESIAN_Y];
    const double vx = state[CARTESIAN_VX];
    const double vy = state[CARTESIAN_VY];
    const double down_x = state[CARTESIAN_DOWN_X];
    const double down_y = state[CARTESIAN_DOWN_Y];
    const double speed = state[CARTESIAN_SPEED];
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
    const double w12 = 0.5 * m->hertz * m->felt * w11 + push;
    matrix[1] = -speed;
    matrix[2] = -(0.5 * m->hertz * m->felt * w6 + push) - m->shaft_stiffness;
    matrix[3] = -(0.5 * m->hertz * m->felt) * w8 - 0.5 * m->hertz * m->felt * m->inverse_inertia * w8;
    matrix[6] = 0.5 * m->hertz * m->felt * m->inverse_inertia * w8;
    matrix[8] = speed;
    matrix[10] = -(0.5 * m->hertz * m->felt) * w10;
    matrix[11] = -w12 - m->shaft_stiffness - m->inverse_inertia * (w12 + m->shaft_stiffness);
    matrix[14] = m->inverse_inertia * (w12 + m->shaft_stiffness);
    matrix[16] = 1.0;
    matrix[18] = -2.0 * m->zeta;
    matrix[19] = -speed;
    matrix[25] = 1.0;
    matrix[26] = speed;
    matrix[27] = -2.0 * m->zeta - 2.0 * m->zeta * m->inverse_inertia;
    matrix[30] = 2.0 * m->zeta * m->inverse_inertia;
    matrix[34] = m->load;
    matrix[37] = -speed;
    matrix[43] = m->load;
    matrix[44] = speed;
    matrix[48] = y;
    matrix[49] = -x;
    matrix[50] = 2.0 * speed + vy;
    matrix[51] = -vx - -m->slope * m->inverse_inertia;
    matrix[52] = down_y;
    matrix[53] = -down_x;
    matrix[54] = -m->slope * m->inverse_inertia;
    matrix[55] = 1.0;
}

/* The Taylor series of the state: 13 lanes. */
static void cartesian_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(8 <= WIDTH && 13 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double x_first = series->terms[0][CARTESIAN_X];
    const double y_first = series->terms[0][CARTESIAN_Y];
    const double first_w6 = sqrt(sqrt(x_first * x_first + y_first * y_first));
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
        const double speed = here[CARTESIAN_SPEED];
        const double w0 = times(series, 0, n, y, speed); /* y * speed */
        const double w1 = times(series, 1, n, x, speed); /* x * speed */
        const double w2 = times(series, 2, n, speed, speed); /* speed * speed */
        const double w3 = times(series, 3, n, x, x); /* x * x */
        const double w4 = times(series, 4, n, y, y); /* y * y */
        const double square = w3 + w4;
        /* square**0.25 */
        const double w6 = raised(series, 5, n, square, 0.25, one * first_w6, inverse_square);
        const double w7 = m->hertz * w6 + one * m->linear;
        const double w8 = times(series, 7, n, w7, x); /* w7 * x */
        const double w9 = times(series, 8, n, vy, speed); /* vy * speed */
        const double w10 = times(series, 9, n, w7, y); /* w7 * y */
        const double w11 = m->felt * w10;
        const double w12 = m->shaft_stiffness * y;
        const double w13 = times(series, 10, n, vx, speed); /* vx * speed */
        const double pull = w11 + w12;
        const double left = one * m->torque - m->slope * speed + 2.0 * m->zeta * vy + pull;
        const double faster = one * m->rate + m->inverse_inertia * left;
        const double w17 = times(series, 11, n, down_y, speed); /* down_y * speed */
        const double w18 = times(series, 12, n, down_x, speed); /* down_x * speed */
        terms[CARTESIAN_X] = (vx + w0) * share;
        terms[CARTESIAN_Y] = (vy - w1) * share;
        terms[CARTESIAN_VX] = (w2 - 2.0 * m->zeta * vx - m->felt * w8 - m->shaft_stiffness * x + m->load * down_x + w9) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - w11 - w12 + m->load * down_y - w13 - faster) * share;
        terms[CARTESIAN_DOWN_X] = w17 * share;
        terms[CARTESIAN_DOWN_Y] = -w18 * share;
        terms[CARTESIAN_SPEED] = faster * share;
        terms[CARTESIAN_ANGLE] = speed * share;
        one = 0.0;
    }
}

/* The Taylor series of the state: 13 lanes. */
static void cartesian_expand_prescribed(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(8 <= WIDTH && 13 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double x_first = series->terms[0][CARTESIAN_X];
    const double y_first = series->terms[0][CARTESIAN_Y];
    const double first_w6 = sqrt(sqrt(x_first * x_first + y_first * y_first));
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
        const double speed = here[CARTESIAN_SPEED];
        const double w0 = times(series, 0, n, y, speed); /* y * speed */
        const double w1 = times(series, 1, n, x, speed); /* x * speed */
        const double w2 = times(series, 2, n, speed, speed); /* speed * speed */
        const double w3 = times(series, 3, n, x, x); /* x * x */
        const double w4 = times(series, 4, n, y, y); /* y * y */
        const double square = w3 + w4;
        /* square**0.25 */
        const double w6 = raised(series, 5, n, square, 0.25, one * first_w6, inverse_square);
        const double w7 = m->hertz * w6 + one * m->linear;
        const double w8 = times(series, 7, n, w7, x); /* w7 * x */
        const double w9 = times(series, 8, n, vy, speed); /* vy * speed */
        const double w10 = times(series, 9, n, w7, y); /* w7 * y */
        const double w11 = times(series, 10, n, vx, speed); /* vx * speed */
        const double w12 = times(series, 11, n, down_y, speed); /* down_y * speed */
        const double w13 = times(series, 12, n, down_x, speed); /* down_x * speed */
        terms[CARTESIAN_X] = (vx + w0) * share;
        terms[CARTESIAN_Y] = (vy - w1) * share;
        terms[CARTESIAN_VX] = (w2 - 2.0 * m->zeta * vx - m->felt * w8 - m->shaft_stiffness * x + m->load * down_x + w9) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - m->felt * w10 - m->shaft_stiffness * y + m->load * down_y - w11 - one * m->rate) * share;
        terms[CARTESIAN_DOWN_X] = w12 * share;
        terms[CARTESIAN_DOWN_Y] = -w13 * share;
        terms[CARTESIAN_SPEED] = one * m->rate * share;
        terms[CARTESIAN_ANGLE] = speed * share;
        one = 0.0;
    }
}

/* The Taylor series of the state: 11 lanes. */
static void cartesian_expand_plain(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(8 <= WIDTH && 11 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double x_first = series->terms[0][CARTESIAN_X];
    const double y_first = series->terms[0][CARTESIAN_Y];
    const double first_w6 = sqrt(sqrt(x_first * x_first + y_first * y_first));
    const double inverse_square = inverse(x_first * x_first + y_first * y_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 3);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double x = here[CARTESIAN_X];
        const double y = here[CARTESIAN_Y];
        const double vx = here[CARTESIAN_VX];
        const double vy = here[CARTESIAN_VY];
        const double speed = here[CARTESIAN_SPEED];
        const double w0 = times(series, 0, n, y, speed); /* y * speed */
        const double w1 = times(series, 1, n, x, speed); /* x * speed */
        const double w2 = times(series, 2, n, speed, speed); /* speed * speed */
        const double w3 = times(series, 3, n, x, x); /* x * x */
        const double w4 = times(series, 4, n, y, y); /* y * y */
        const double square = w3 + w4;
        /* square**0.25 */
        const double w6 = raised(series, 5, n, square, 0.25, one * first_w6, inverse_square);
        const double w7 = times(series, 7, n, w6, x); /* w6 * x */
        const double w8 = times(series, 8, n, vy, speed); /* vy * speed */
        const double w9 = times(series, 9, n, w6, y); /* w6 * y */
        const double pull = m->felt * w9;
        const double w11 = times(series, 10, n, vx, speed); /* vx * speed */
        terms[CARTESIAN_X] = (vx + w0) * share;
        terms[CARTESIAN_Y] = (vy - w1) * share;
        terms[CARTESIAN_VX] = (w2 - 2.0 * m->zeta * vx - m->felt * w7 + w8) * share;
        terms[CARTESIAN_VY] = (-2.0 * m->zeta * vy - pull - w11 - one * m->rate) * share;
        terms[CARTESIAN_DOWN_X] = one * 0.0 * share;
        terms[CARTESIAN_DOWN_Y] = one * 0.0 * share;
        terms[CARTESIAN_SPEED] = one * m->rate * share;
        terms[CARTESIAN_ANGLE] = speed * share;
        one = 0.0;
    }
}

const struct mode cartesian_mode = {
    .size = CARTESIAN_SIZE,
    .field = cartesian_field,
    .jacobian = cartesian_jacobian,
    .expand = cartesian_expand,
    .expand_prescribed = cartesian_expand_prescribed,
    .expand_plain = cartesian_expand_plain,
};

/* The rates of change of q, p, slip, c, s, down_r, down_t, speed, t, angle, j, work, spent, heat, drawn back to where they belong. */
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
    const double speed = state[RUB_SPEED];
    const double of_q = 0.5 * p;
    const double w1 = speed * speed;
    const double w2 = w1 * c;
    const double square = q * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w5 = spring * (1.0 + m->contact_damping * p);
    const double push = (1.0 - m->loose) * w5;
    const double r = m->delta0 + square;
    const double radial = w2 - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
    const double slip_speed = ratio(slip, r);
    const double w10 = m->disc_radius * speed;
    const double around = slip_speed - w10;
    const double spin = ratio(around, r);
    const double centrifugal = spin * around;
    const double w14 = p * s;
    const double w15 = around * c;
    const double velocity = w14 + w15;
    const double w17 = w5 * s;
    const double w18 = r * s;
    const double pull = (1.0 - m->loose) * w17 + m->shaft_stiffness * w18;
    const double lever = m->disc_radius - c;
    const double w21 = w5 * lever;
    const double left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - m->friction * m->sigma * (1.0 - m->loose) * w21;
    const double faster = m->rate + m->inverse_inertia * left;
    const double w24 = faster * s;
    const double outwards = radial + centrifugal - w24;
    const double of_p = outwards * q;
    const double w27 = w1 * s;
    const double drag = m->friction * m->sigma * (1.0 - m->loose) * w5;
    const double tangential = -w27 - 2.0 * m->zeta * around + m->load * down_t - drag;
    const double w30 = faster * lever;
    const double sideways = tangential + w30;
    const double w32 = sideways * r;
    const double w33 = p * speed;
    const double moment = w32 + m->disc_radius * w33;
    const double of_slip = moment * q;
    const double turned = spin * q;
    const double w37 = q * speed;
    const double turn = turned - w37;
    const double w39 = turn * s;
    const double of_c = -w39;
    const double w41 = c * c;
    const double w42 = s * s;
    const double w43 = (1.0 - (w41 + w42)) * w37;
    const double w44 = w43 * c;
    const double of_s = turn * c;
    const double w46 = w43 * s;
    const double of_down_r = turned * down_t;
    const double w48 = down_r * down_r;
    const double w49 = down_t * down_t;
    const double w50 = (1.0 - (w48 + w49)) * w37;
    const double w51 = w50 * down_r;
    const double w52 = turned * down_r;
    const double of_down_t = -w52;
    const double w54 = w50 * down_t;
    const double w55 = faster * q;
    const double w56 = w5 * q;
    const double of_j = (1.0 - m->loose) * w56;
    const double w58 = w56 * p;
    const double w59 = p * p;
    const double w60 = r * speed;
    const double h = slip - m->disc_radius * w60;
    const double around_ = ratio(h, r);
    const double w63 = around_ * around_;
    const double w64 = h * speed;
    const double damped = 2.0 * m->zeta * (w59 + w63 - w64);
    const double w66 = w60 * down_t;
    const double spent = (damped + m->load * w66) * q;
    const double w68 = w56 * (w10 + w60);
    const double w69 = around * r;
    const double w70 = r * c;
    const double w71 = w70 * speed;
    const double w72 = w55 * (velocity + w69 + w71);
    const double w73 = w56 * slip_speed;
    rate[RUB_Q] = of_q;
    rate[RUB_P] = of_p;
    rate[RUB_SLIP] = of_slip;
    rate[RUB_C] = of_c + 0.1 * w44;
    rate[RUB_S] = of_s + 0.1 * w46;
    rate[RUB_DOWN_R] = of_down_r + 0.1 * w51;
    rate[RUB_DOWN_T] = of_down_t + 0.1 * w54;
    rate[RUB_SPEED] = w55;
    rate[RUB_T] = q;
    rate[RUB_ANGLE] = w37;
    rate[RUB_J] = of_j;
    rate[RUB_WORK] = (1.0 - m->loose) * w58;
    rate[RUB_SPENT] = spent - m->friction * m->sigma * (1.0 - m->loose) * w68 + w72;
    rate[RUB_HEAT] = m->friction * m->sigma * (1.0 - m->loose) * w73;
}

/* Their derivatives by each of these, column by column. */
static void rub_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 196; i++)
        matrix[i] = 0.0;
    const double q = state[RUB_Q];
    const double p = state[RUB_P];
    const double slip = state[RUB_SLIP];
    const double c = state[RUB_C];
    const double s = state[RUB_S];
    const double down_r = state[RUB_DOWN_R];
    const double down_t = state[RUB_DOWN_T];
    const double speed = state[RUB_SPEED];
    const double w0 = speed * speed;
    const double w1 = w0 * c;
    const double w2 = 2.0 * m->zeta * p;
    const double w3 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w3 * square;
    const double w6 = m->contact_damping * p + 1.0;
    const double w7 = spring * w6;
    const double w8 = (1.0 - m->loose) * w7;
    const double w9 = square + m->delta0;
    const double w10 = m->shaft_stiffness * w9;
    const double w11 = ratio(slip, w9);
    const double w12 = m->disc_radius * speed;
    const double w13 = w11 - w12;
    const double w14 = ratio(w13, w9);
    const double w15 = w14 * w13;
    const double w16 = p * s;
    const double w17 = w13 * c;
    const double w18 = w16 + w17;
    const double w19 = w7 * s;
    const double w20 = w9 * s;
    const double w21 = -c + m->disc_radius;
    const double w22 = w7 * w21;
    const double w23 = m->inverse_inertia * (-m->slope * speed + m->torque + 2.0 * m->zeta * w18 + ((1.0 - m->loose) * w19 + m->shaft_stiffness * w20) - (1.0 - m->loose) * (m->friction * m->sigma) * w22) + m->rate;
    const double w24 = w23 * s;
    const double w25 = w3 * q;
    const double w26 = (2.0 * w25 + m->hertz * square) * w6;
    const double w27 = w11 * q;
    const double w28 = ratio(w27, w9);
    const double w29 = w28 * w14;
    const double w30 = w14 * q;
    const double w31 = ratio(-2.0 * w28 - 2.0 * w30, w9);
    const double w32 = w31 * w13;
    const double w33 = w28 * c;
    const double w34 = w26 * s;
    const double w35 = q * s;
    const double w36 = w26 * w21;
    const double w37 = -4.0 * m->zeta * w33 + ((1.0 - m->loose) * w34 + 2.0 * m->shaft_stiffness * w35) - (1.0 - m->loose) * (m->friction * m->sigma) * w36;
    const double w38 = w37 * s;
    const double w39 = (-(1.0 - m->loose) * w26 - 2.0 * m->shaft_stiffness * q + (-2.0 * w29 + w32) - m->inverse_inertia * w38) * q;
    const double w40 = w0 * s;
    const double w41 = 2.0 * m->zeta * w13;
    const double w42 = (1.0 - m->loose) * (m->friction * m->sigma) * w7;
    const double w43 = w23 * w21;
    const double w44 = -w40 - w41 + m->load * down_t - w42 + w43;
    const double w45 = w44 * w9;
    const double w46 = p * speed;
    const double w47 = w44 * q;
    const double w48 = w37 * w21;
    const double w49 = (4.0 * m->zeta * w28 - (1.0 - m->loose) * (m->friction * m->sigma) * w26 + m->inverse_inertia * w48) * w9;
    const double w50 = (2.0 * w47 + w49) * q;
    const double w51 = w31 * q;
    const double w52 = w14 + w51;
    const double w53 = w52 - speed;
    const double w54 = w53 * s;
    const double w55 = c * c;
    const double w56 = s * s;
    const double w57 = -(w55 + w56) + 1.0;
    const double w58 = w57 * speed;
    const double w59 = w58 * c;
    const double w60 = w53 * c;
    const double w61 = w58 * s;
    const double w62 = w52 * down_t;
    const double w63 = down_r * down_r;
    const double w64 = down_t * down_t;
    const double w65 = -(w63 + w64) + 1.0;
    const double w66 = w65 * speed;
    const double w67 = w66 * down_r;
    const double w68 = w52 * down_r;
    const double w69 = w66 * down_t;
    const double w70 = w37 * q;
    const double w71 = w26 * q;
    const double w72 = (w8 + (1.0 - m->loose) * w71) * p;
    const double w73 = p * p;
    const double w74 = w9 * speed;
    const double w75 = m->disc_radius * w74;
    const double w76 = slip - w75;
    const double w77 = ratio(w76, w9);
    const double w78 = w77 * w77;
    const double w79 = w76 * speed;
    const double w80 = w74 * down_t;
    const double w81 = q * speed;
    const double w82 = w77 * q;
    const double w83 = ratio(-2.0 * m->disc_radius * w81 - 2.0 * w82, w9);
    const double w84 = w83 * w77;
    const double w85 = w81 * speed;
    const double w86 = w81 * down_t;
    const double w87 = (2.0 * m->zeta * (2.0 * w84 + 2.0 * m->disc_radius * w85) + 2.0 * m->load * w86) * q;
    const double w88 = w42 + (1.0 - m->loose) * (m->friction * m->sigma) * w71;
    const double w89 = w12 + w74;
    const double w90 = w88 * w89;
    const double w91 = w7 * q;
    const double w92 = w91 * w81;
    const double w93 = w13 * w9;
    const double w94 = w9 * c;
    const double w95 = w94 * speed;
    const double w96 = w18 + w93 + w95;
    const double w97 = (w23 + m->inverse_inertia * w70) * w96;
    const double w98 = w23 * q;
    const double w99 = w13 * q;
    const double w100 = w28 * w9;
    const double w101 = q * c;
    const double w102 = w101 * speed;
    const double w103 = w98 * (-2.0 * w33 + (2.0 * w99 - 2.0 * w100) + 2.0 * w102);
    const double w104 = w88 * w11;
    const double w105 = w28 * w91;
    const double w106 = spring * s;
    const double w107 = spring * w21;
    const double w108 = 2.0 * m->zeta * s + (1.0 - m->loose) * m->contact_damping * w106 - (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w107;
    const double w109 = w108 * s;
    const double w110 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring - m->inverse_inertia * w109) * q;
    const double w111 = w108 * w21;
    const double w112 = (-((1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma)) * spring + m->inverse_inertia * w111) * w9;
    const double w113 = (w112 + w12) * q;
    const double w114 = w108 * q;
    const double w115 = spring * q;
    const double w116 = w115 * p;
    const double w117 = q * p;
    const double w118 = w115 * w89;
    const double w119 = w114 * w96;
    const double w120 = w98 * s;
    const double w121 = w115 * w11;
    const double w122 = ratio(1.0, w9);
    const double w123 = w14 * w122;
    const double w124 = ratio(w122, w9);
    const double w125 = w13 * w124;
    const double w126 = w122 * c;
    const double w127 = w126 * s;
    const double w128 = (w123 + w125 - 2.0 * m->zeta * m->inverse_inertia * w127) * q;
    const double w129 = w126 * w21;
    const double w130 = (-2.0 * m->zeta * w122 + 2.0 * m->zeta * m->inverse_inertia * w129) * w9;
    const double w131 = w130 * q;
    const double w132 = w124 * q;
    const double w133 = w132 * s;
    const double w134 = w132 * c;
    const double w135 = w132 * down_t;
    const double w136 = w132 * down_r;
    const double w137 = w126 * q;
    const double w138 = w77 * w122;
    const double w139 = (2.0 * w138 - speed) * q;
    const double w140 = w96 * w137;
    const double w141 = w122 * w9;
    const double w142 = w98 * (w126 + w141);
    const double w143 = w91 * w122;
    const double w144 = w41 + w42;
    const double w145 = w144 * s;
    const double w146 = (w0 - m->inverse_inertia * w145) * q;
    const double w147 = w144 * w21;
    const double w148 = (m->inverse_inertia * w147 - w23) * w9;
    const double w149 = w148 * q;
    const double w150 = w81 * c;
    const double w151 = w150 * c;
    const double w152 = w57 * w81;
    const double w153 = 0.1 * w152;
    const double w154 = w30 - w81;
    const double w155 = w150 * s;
    const double w156 = w144 * q;
    const double w157 = w96 * w156;
    const double w158 = w98 * (w13 + w74);
    const double w159 = w2 + (w8 + w10);
    const double w160 = w159 * s;
    const double w161 = (m->inverse_inertia * w160 + w23) * q;
    const double w162 = w159 * w21;
    const double w163 = (-w0 + m->inverse_inertia * w162) * w9;
    const double w164 = w163 * q;
    const double w165 = w81 * s;
    const double w166 = w165 * c;
    const double w167 = w165 * s;
    const double w168 = w159 * q;
    const double w169 = w168 * w96;
    const double w170 = w98 * p;
    const double w171 = w81 * down_r;
    const double w172 = w171 * down_r;
    const double w173 = w65 * w81;
    const double w174 = 0.1 * w173;
    const double w175 = w171 * down_t;
    const double w176 = w9 * q;
    const double w177 = w86 * down_r;
    const double w178 = w86 * down_t;
    const double w179 = w74 * q;
    const double w180 = c * speed;
    const double w181 = w13 * w122;
    const double w182 = -m->slope - -(-m->disc_radius * (2.0 * m->zeta)) * c;
    const double w183 = w182 * s;
    const double w184 = (2.0 * w180 + (-m->disc_radius * w14 - m->disc_radius * w181) - m->inverse_inertia * w183) * q;
    const double w185 = s * speed;
    const double w186 = w182 * w21;
    const double w187 = (-2.0 * w185 - -m->disc_radius * (2.0 * m->zeta) + m->inverse_inertia * w186) * w9;
    const double w188 = (w187 + m->disc_radius * p) * q;
    const double w189 = w122 * q;
    const double w190 = -m->disc_radius * w189 - q;
    const double w191 = w190 * s;
    const double w192 = w57 * q;
    const double w193 = w192 * c;
    const double w194 = w190 * c;
    const double w195 = w192 * s;
    const double w196 = w189 * down_t;
    const double w197 = w65 * q;
    const double w198 = w197 * down_r;
    const double w199 = w189 * down_r;
    const double w200 = w197 * down_t;
    const double w201 = w182 * q;
    const double w202 = ratio(w9, w9);
    const double w203 = w77 * w202;
    const double w204 = w9 * down_t;
    const double w205 = (2.0 * m->zeta * (-2.0 * m->disc_radius * w203 - (w76 - w75)) + m->load * w204) * q;
    const double w206 = w91 * (m->disc_radius + w9);
    const double w207 = w96 * w201;
    const double w208 = w98 * (-m->disc_radius * c - m->disc_radius * w9 + w94);
    matrix[1] = w1 - w2 - w8 - w10 + m->load * down_r + w15 - w24 + w39;
    matrix[2] = w45 + m->disc_radius * w46 + w50;
    matrix[3] = -w54 + 0.1 * w59;
    matrix[4] = w60 + 0.1 * w61;
    matrix[5] = w62 + 0.1 * w67;
    matrix[6] = -w68 + 0.1 * w69;
    matrix[7] = w23 + m->inverse_inertia * w70;
    matrix[8] = 1.0;
    matrix[9] = speed;
    matrix[10] = w8 + (1.0 - m->loose) * w71;
    matrix[11] = w72;
    matrix[12] = 2.0 * m->zeta * (w73 + w78 - w79) + m->load * w80 + w87 - (w90 + 2.0 * ((1.0 - m->loose) * (m->friction * m->sigma)) * w92) + (w97 + w103);
    matrix[13] = w104 - 2.0 * ((1.0 - m->loose) * (m->friction * m->sigma)) * w105;
    matrix[14] = 0.5;
    matrix[15] = w110;
    matrix[16] = w113;
    matrix[21] = m->inverse_inertia * w114;
    matrix[24] = (1.0 - m->loose) * m->contact_damping * w115;
    matrix[25] = (1.0 - m->loose) * m->contact_damping * w116 + (1.0 - m->loose) * w91;
    matrix[26] = 4.0 * m->zeta * w117 - (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w118 + (m->inverse_inertia * w119 + w120);
    matrix[27] = (1.0 - m->loose) * m->contact_damping * (m->friction * m->sigma) * w121;
    matrix[29] = w128;
    matrix[30] = w131;
    matrix[31] = -w133;
    matrix[32] = w134;
    matrix[33] = w135;
    matrix[34] = -w136;
    matrix[35] = 2.0 * m->zeta * m->inverse_inertia * w137;
    matrix[40] = 2.0 * m->zeta * w139 + (2.0 * m->zeta * m->inverse_inertia * w140 + w142);
    matrix[41] = (1.0 - m->loose) * (m->friction * m->sigma) * w143;
    matrix[43] = w146;
    matrix[44] = w149;
    matrix[45] = -0.2 * w151 + w153;
    matrix[46] = w154 - 0.2 * w155;
    matrix[49] = m->inverse_inertia * w156;
    matrix[54] = m->inverse_inertia * w157 + w158;
    matrix[57] = -w161;
    matrix[58] = w164;
    matrix[59] = -w154 - 0.2 * w166;
    matrix[60] = -0.2 * w167 + w153;
    matrix[63] = m->inverse_inertia * w168;
    matrix[68] = m->inverse_inertia * w169 + w170;
    matrix[71] = m->load * q;
    matrix[75] = -0.2 * w172 + w174;
    matrix[76] = -w30 - 0.2 * w175;
    matrix[86] = m->load * w176;
    matrix[89] = w30 - 0.2 * w177;
    matrix[90] = -0.2 * w178 + w174;
    matrix[96] = m->load * w179;
    matrix[99] = w184;
    matrix[100] = w188;
    matrix[101] = -w191 + 0.1 * w193;
    matrix[102] = w194 + 0.1 * w195;
    matrix[103] = -m->disc_radius * w196 + 0.1 * w198;
    matrix[104] = m->disc_radius * w199 + 0.1 * w200;
    matrix[105] = m->inverse_inertia * w201;
    matrix[107] = q;
    matrix[110] = w205 - (1.0 - m->loose) * (m->friction * m->sigma) * w206 + (m->inverse_inertia * w207 + w208);
}

/* The Taylor series of the state: 29 lanes. */
static void rub_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 29 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][RUB_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 8);
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
        const double speed = here[RUB_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double push = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double radial = w2 - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double slip_speed = over(series, 5, n, slip, r, inverse_r); /* slip / r */
        const double around = slip_speed - m->disc_radius * speed;
        const double spin = over(series, 6, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 7, n, spin, around); /* spin * around */
        const double w13 = times(series, 8, n, p, s); /* p * s */
        const double w14 = times(series, 9, n, around, c); /* around * c */
        const double velocity = w13 + w14;
        const double w16 = times(series, 10, n, w5, s); /* w5 * s */
        const double w17 = times(series, 11, n, r, s); /* r * s */
        const double pull = (1.0 - m->loose) * w16 + m->shaft_stiffness * w17;
        const double lever = one * m->disc_radius - c;
        const double w20 = times(series, 12, n, w5, lever); /* w5 * lever */
        const double left = one * m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - m->friction * m->sigma * (1.0 - m->loose) * w20;
        const double faster = one * m->rate + m->inverse_inertia * left;
        const double w23 = times(series, 13, n, faster, s); /* faster * s */
        const double outwards = radial + centrifugal - w23;
        const double of_p = times(series, 14, n, outwards, q); /* outwards * q */
        const double w26 = times(series, 15, n, w1, s); /* w1 * s */
        const double drag = m->friction * m->sigma * (1.0 - m->loose) * w5;
        const double tangential = -w26 - 2.0 * m->zeta * around + m->load * down_t - drag;
        const double w29 = times(series, 16, n, faster, lever); /* faster * lever */
        const double sideways = tangential + w29;
        const double w31 = times(series, 17, n, sideways, r); /* sideways * r */
        const double w32 = times(series, 18, n, p, speed); /* p * speed */
        const double moment = w31 + m->disc_radius * w32;
        const double of_slip = times(series, 19, n, moment, q); /* moment * q */
        const double turned = times(series, 20, n, spin, q); /* spin * q */
        const double w36 = times(series, 21, n, q, speed); /* q * speed */
        const double turn = turned - w36;
        const double w38 = times(series, 22, n, turn, s); /* turn * s */
        const double of_c = -w38;
        const double of_s = times(series, 23, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 24, n, turned, down_t); /* turned * down_t */
        const double w42 = times(series, 25, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w42;
        const double w44 = times(series, 26, n, faster, q); /* faster * q */
        const double w45 = times(series, 27, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w45;
        const double w47 = times(series, 28, n, w45, p); /* w45 * p */
        terms[RUB_Q] = of_q * share;
        terms[RUB_P] = of_p * share;
        terms[RUB_SLIP] = of_slip * share;
        terms[RUB_C] = of_c * share;
        terms[RUB_S] = of_s * share;
        terms[RUB_DOWN_R] = of_down_r * share;
        terms[RUB_DOWN_T] = of_down_t * share;
        terms[RUB_SPEED] = w44 * share;
        terms[RUB_T] = q * share;
        terms[RUB_ANGLE] = w36 * share;
        terms[RUB_J] = of_j * share;
        terms[RUB_WORK] = (1.0 - m->loose) * w47 * share;
        terms[RUB_SPENT] = one * 0.0 * share;
        terms[RUB_HEAT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rub_spent(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {RUB_Q, RUB_P, RUB_SLIP, RUB_C, RUB_S, RUB_DOWN_T, RUB_SPEED};
    vec4 read[7][AT_ONCE];
    read_parts(series, order, reads, 7, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 slip = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 down_t = read[5][v];
        const vec4 speed = read[6][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 h = slip - m->disc_radius * w3;
        const vec4 around = (h) / (r);
        const vec4 w6 = around * around;
        const vec4 w7 = h * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 + w6 - w7);
        const vec4 w9 = w3 * down_t;
        const vec4 spent = (damped + m->load * w9) * q;
        const vec4 spring = (m->hertz * q + m->linear) * square;
        const vec4 w12 = spring * (1.0 + m->contact_damping * p);
        const vec4 w13 = w12 * q;
        const vec4 w14 = m->disc_radius * speed;
        const vec4 w15 = w13 * (w14 + w3);
        const vec4 w16 = p * s;
        const vec4 slip_speed = (slip) / (r);
        const vec4 around_ = slip_speed - w14;
        const vec4 w19 = around_ * c;
        const vec4 velocity = w16 + w19;
        const vec4 w21 = w12 * s;
        const vec4 w22 = r * s;
        const vec4 pull = (1.0 - m->loose) * w21 + m->shaft_stiffness * w22;
        const vec4 lever = m->disc_radius - c;
        const vec4 w25 = w12 * lever;
        const vec4 left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - m->friction * m->sigma * (1.0 - m->loose) * w25;
        const vec4 faster = m->rate + m->inverse_inertia * left;
        const vec4 w28 = faster * q;
        const vec4 w29 = around_ * r;
        const vec4 w30 = r * c;
        const vec4 w31 = w30 * speed;
        const vec4 w32 = w28 * (velocity + w29 + w31);
        const vec4 w33 = w13 * slip_speed;
        rate[v][0] = spent - m->friction * m->sigma * (1.0 - m->loose) * w15 + w32;
        rate[v][1] = m->friction * m->sigma * (1.0 - m->loose) * w33;
    }
}

/* The Taylor series of the state: 21 lanes. */
static void rub_expand_prescribed(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 21 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][RUB_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 6);
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
        const double speed = here[RUB_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double push = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double radial = w2 - 2.0 * m->zeta * p - push - m->shaft_stiffness * r + m->load * down_r;
        const double slip_speed = over(series, 5, n, slip, r, inverse_r); /* slip / r */
        const double around = slip_speed - m->disc_radius * speed;
        const double spin = over(series, 6, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 7, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal - m->rate * s;
        const double of_p = times(series, 8, n, outwards, q); /* outwards * q */
        const double w15 = times(series, 9, n, w1, s); /* w1 * s */
        const double drag = m->friction * m->sigma * (1.0 - m->loose) * w5;
        const double tangential = -w15 - 2.0 * m->zeta * around + m->load * down_t - drag;
        const double lever = one * m->disc_radius - c;
        const double sideways = tangential + m->rate * lever;
        const double w20 = times(series, 10, n, sideways, r); /* sideways * r */
        const double w21 = times(series, 11, n, p, speed); /* p * speed */
        const double moment = w20 + m->disc_radius * w21;
        const double of_slip = times(series, 12, n, moment, q); /* moment * q */
        const double turned = times(series, 13, n, spin, q); /* spin * q */
        const double w25 = times(series, 14, n, q, speed); /* q * speed */
        const double turn = turned - w25;
        const double w27 = times(series, 15, n, turn, s); /* turn * s */
        const double of_c = -w27;
        const double of_s = times(series, 16, n, turn, c); /* turn * c */
        const double of_down_r = times(series, 17, n, turned, down_t); /* turned * down_t */
        const double w31 = times(series, 18, n, turned, down_r); /* turned * down_r */
        const double of_down_t = -w31;
        const double w33 = times(series, 19, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w33;
        const double w35 = times(series, 20, n, w33, p); /* w33 * p */
        terms[RUB_Q] = of_q * share;
        terms[RUB_P] = of_p * share;
        terms[RUB_SLIP] = of_slip * share;
        terms[RUB_C] = of_c * share;
        terms[RUB_S] = of_s * share;
        terms[RUB_DOWN_R] = of_down_r * share;
        terms[RUB_DOWN_T] = of_down_t * share;
        terms[RUB_SPEED] = m->rate * q * share;
        terms[RUB_T] = q * share;
        terms[RUB_ANGLE] = w25 * share;
        terms[RUB_J] = of_j * share;
        terms[RUB_WORK] = (1.0 - m->loose) * w35 * share;
        terms[RUB_SPENT] = one * 0.0 * share;
        terms[RUB_HEAT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rub_spent_prescribed(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {RUB_Q, RUB_P, RUB_SLIP, RUB_C, RUB_S, RUB_DOWN_T, RUB_SPEED};
    vec4 read[7][AT_ONCE];
    read_parts(series, order, reads, 7, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 slip = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 down_t = read[5][v];
        const vec4 speed = read[6][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 h = slip - m->disc_radius * w3;
        const vec4 around = (h) / (r);
        const vec4 w6 = around * around;
        const vec4 w7 = h * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 + w6 - w7);
        const vec4 w9 = w3 * down_t;
        const vec4 spent = (damped + m->load * w9) * q;
        const vec4 spring = (m->hertz * q + m->linear) * square;
        const vec4 w12 = spring * (1.0 + m->contact_damping * p);
        const vec4 w13 = w12 * q;
        const vec4 w14 = m->disc_radius * speed;
        const vec4 w15 = w13 * (w14 + w3);
        const vec4 w16 = p * s;
        const vec4 slip_speed = (slip) / (r);
        const vec4 around_ = slip_speed - w14;
        const vec4 w19 = around_ * c;
        const vec4 velocity = w16 + w19;
        const vec4 w21 = around_ * r;
        const vec4 w22 = r * c;
        const vec4 w23 = w22 * speed;
        const vec4 w24 = (velocity + w21 + w23) * q;
        const vec4 w25 = w13 * slip_speed;
        rate[v][0] = spent - m->friction * m->sigma * (1.0 - m->loose) * w15 + m->rate * w24;
        rate[v][1] = m->friction * m->sigma * (1.0 - m->loose) * w25;
    }
}

/* The Taylor series of the state: 17 lanes. */
static void rub_expand_plain(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 17 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][RUB_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 5);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[RUB_Q];
        const double p = here[RUB_P];
        const double slip = here[RUB_SLIP];
        const double c = here[RUB_C];
        const double s = here[RUB_S];
        const double speed = here[RUB_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        const double spring = times(series, 3, n, square, q); /* square * q */
        const double radial = w2 - 2.0 * m->zeta * p - spring;
        const double r = one * m->delta0 + square;
        const double slip_speed = over(series, 4, n, slip, r, inverse_r); /* slip / r */
        const double around = slip_speed - m->disc_radius * speed;
        const double spin = over(series, 5, n, around, r, inverse_r); /* around / r */
        const double centrifugal = times(series, 6, n, spin, around); /* spin * around */
        const double outwards = radial + centrifugal - m->rate * s;
        const double of_p = times(series, 7, n, outwards, q); /* outwards * q */
        const double w13 = times(series, 8, n, w1, s); /* w1 * s */
        const double drag = m->friction * m->sigma * spring;
        const double tangential = -w13 - 2.0 * m->zeta * around - drag;
        const double lever = one * m->disc_radius - c;
        const double sideways = tangential + m->rate * lever;
        const double w18 = times(series, 9, n, sideways, r); /* sideways * r */
        const double w19 = times(series, 10, n, p, speed); /* p * speed */
        const double moment = w18 + m->disc_radius * w19;
        const double of_slip = times(series, 11, n, moment, q); /* moment * q */
        const double turned = times(series, 12, n, spin, q); /* spin * q */
        const double w23 = times(series, 13, n, q, speed); /* q * speed */
        const double turn = turned - w23;
        const double w25 = times(series, 14, n, turn, s); /* turn * s */
        const double of_c = -w25;
        const double of_s = times(series, 15, n, turn, c); /* turn * c */
        const double of_j = times(series, 16, n, spring, q); /* spring * q */
        terms[RUB_Q] = of_q * share;
        terms[RUB_P] = of_p * share;
        terms[RUB_SLIP] = of_slip * share;
        terms[RUB_C] = of_c * share;
        terms[RUB_S] = of_s * share;
        terms[RUB_DOWN_R] = one * 0.0 * share;
        terms[RUB_DOWN_T] = one * 0.0 * share;
        terms[RUB_SPEED] = m->rate * q * share;
        terms[RUB_T] = q * share;
        terms[RUB_ANGLE] = w23 * share;
        terms[RUB_J] = of_j * share;
        terms[RUB_WORK] = one * 0.0 * share;
        terms[RUB_SPENT] = one * 0.0 * share;
        terms[RUB_HEAT] = one * 0.0 * share;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rub_spent_plain(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {RUB_Q, RUB_P, RUB_SLIP, RUB_C, RUB_S, RUB_SPEED};
    vec4 read[6][AT_ONCE];
    read_parts(series, order, reads, 6, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 slip = read[2][v];
        const vec4 c = read[3][v];
        const vec4 s = read[4][v];
        const vec4 speed = read[5][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 h = slip - m->disc_radius * w3;
        const vec4 around = (h) / (r);
        const vec4 w6 = around * around;
        const vec4 w7 = h * speed;
        const vec4 w8 = (w0 + w6 - w7) * q;
        const vec4 spent = 2.0 * m->zeta * w8;
        const vec4 w10 = m->disc_radius * speed;
        const vec4 spring = square * q;
        const vec4 of_j = spring * q;
        const vec4 w13 = (w10 + w3) * of_j;
        const vec4 w14 = p * s;
        const vec4 slip_speed = (slip) / (r);
        const vec4 around_ = slip_speed - w10;
        const vec4 w17 = around_ * c;
        const vec4 velocity = w14 + w17;
        const vec4 w19 = around_ * r;
        const vec4 w20 = r * c;
        const vec4 w21 = w20 * speed;
        const vec4 w22 = (velocity + w19 + w21) * q;
        const vec4 w23 = slip_speed * of_j;
        rate[v][0] = spent - m->friction * m->sigma * w13 + m->rate * w22;
        rate[v][1] = m->friction * m->sigma * w23;
    }
}

const struct mode rub_mode = {
    .size = RUB_SIZE,
    .field = rub_field,
    .jacobian = rub_jacobian,
    .expand = rub_expand,
    .expand_prescribed = rub_expand_prescribed,
    .expand_plain = rub_expand_plain,
    .spent = rub_spent,
    .spent_prescribed = rub_spent_prescribed,
    .spent_plain = rub_spent_plain,
};

/* The rates of change of q, p, slip, c, s, down_r, down_t, speed, t, angle, j, work, spent, heat, drawn back to where they belong. */
static void rolling_field(const struct parameters *m,
    const double *state, double *rate)
{
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double speed = state[ROLLING_SPEED];
    const double of_q = 0.5 * p;
    const double w1 = speed * speed;
    const double w2 = w1 * c;
    const double square = q * q;
    const double spring = (m->hertz * q + m->linear) * square;
    const double w5 = spring * (1.0 + m->contact_damping * p);
    const double force = (1.0 - m->loose) * w5;
    const double r = m->delta0 + square;
    const double w8 = ratio(speed, r);
    const double w9 = w8 * speed;
    const double w10 = p * s;
    const double w11 = c * speed;
    const double velocity = w10 - m->disc_radius * w11;
    const double w13 = w5 * s;
    const double w14 = r * s;
    const double pull = (1.0 - m->loose) * w13 + m->shaft_stiffness * w14;
    const double w16 = w1 * s;
    const double w17 = p * speed;
    const double w18 = ratio(w17, r);
    const double hold = -w16 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->load * down_t + m->disc_radius * w18;
    const double lever = m->disc_radius - c;
    const double w21 = hold * lever;
    const double left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - w21;
    const double w23 = lever * lever;
    const double moved = 1.0 + m->inverse_inertia * w23;
    const double faster = ratio(m->rate + m->inverse_inertia * left, moved);
    const double w26 = faster * s;
    const double outwards = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r - m->disc_radius * (-m->disc_radius) * w9 - w26;
    const double of_p = outwards * q;
    const double w29 = w8 * q;
    const double turned = -m->disc_radius * w29;
    const double w31 = q * speed;
    const double turn = turned - w31;
    const double w33 = turn * s;
    const double of_c = -w33;
    const double w35 = c * c;
    const double w36 = s * s;
    const double w37 = (1.0 - (w35 + w36)) * w31;
    const double w38 = w37 * c;
    const double of_s = turn * c;
    const double w40 = w37 * s;
    const double w41 = w29 * down_t;
    const double of_down_r = -m->disc_radius * w41;
    const double w43 = down_r * down_r;
    const double w44 = down_t * down_t;
    const double w45 = (1.0 - (w43 + w44)) * w31;
    const double w46 = w45 * down_r;
    const double w47 = w29 * down_r;
    const double of_down_t = m->disc_radius * w47;
    const double w49 = w45 * down_t;
    const double w50 = faster * q;
    const double w51 = w5 * q;
    const double of_j = (1.0 - m->loose) * w51;
    const double w53 = w51 * p;
    const double w54 = p * p;
    const double w55 = r * speed;
    const double w56 = ratio(w55, r);
    const double w57 = w56 * w56;
    const double w58 = w55 * speed;
    const double damped = 2.0 * m->zeta * (w54 - -(-m->disc_radius * (-m->disc_radius)) * w57 + m->disc_radius * w58);
    const double w60 = w55 * down_t;
    const double spent = (damped + m->load * w60) * q;
    const double w62 = hold * q;
    const double w63 = m->disc_radius * speed + w55;
    const double w64 = w62 * w63;
    const double w65 = r * c;
    const double w66 = w65 * speed;
    const double turning = w50 * (velocity - m->disc_radius * w55 + w66);
    const double w68 = faster * lever;
    const double hold_ = hold + w68;
    const double added = hold_ - hold;
    const double w71 = added * q;
    const double w72 = w71 * w63;
    rate[ROLLING_Q] = of_q;
    rate[ROLLING_P] = of_p;
    rate[ROLLING_SLIP] = 0.0;
    rate[ROLLING_C] = of_c + 0.1 * w38;
    rate[ROLLING_S] = of_s + 0.1 * w40;
    rate[ROLLING_DOWN_R] = of_down_r + 0.1 * w46;
    rate[ROLLING_DOWN_T] = of_down_t + 0.1 * w49;
    rate[ROLLING_SPEED] = w50;
    rate[ROLLING_T] = q;
    rate[ROLLING_ANGLE] = w31;
    rate[ROLLING_J] = of_j;
    rate[ROLLING_WORK] = (1.0 - m->loose) * w53;
    rate[ROLLING_SPENT] = spent - w64 + turning - w72;
    rate[ROLLING_HEAT] = 0.0;
}

/* Their derivatives by each of these, column by column. */
static void rolling_jacobian(const struct parameters *m,
    const double *state, double *matrix)
{
    for (int i = 0; i < 196; i++)
        matrix[i] = 0.0;
    const double q = state[ROLLING_Q];
    const double p = state[ROLLING_P];
    const double c = state[ROLLING_C];
    const double s = state[ROLLING_S];
    const double down_r = state[ROLLING_DOWN_R];
    const double down_t = state[ROLLING_DOWN_T];
    const double speed = state[ROLLING_SPEED];
    const double w0 = speed * speed;
    const double w1 = w0 * c;
    const double w2 = 2.0 * m->zeta * p;
    const double w3 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w3 * square;
    const double w6 = m->contact_damping * p + 1.0;
    const double w7 = spring * w6;
    const double w8 = (1.0 - m->loose) * w7;
    const double w9 = square + m->delta0;
    const double w10 = m->shaft_stiffness * w9;
    const double w11 = ratio(speed, w9);
    const double w12 = w11 * speed;
    const double w13 = p * s;
    const double w14 = c * speed;
    const double velocity = w13 - m->disc_radius * w14;
    const double w16 = w7 * s;
    const double w17 = w9 * s;
    const double w18 = w0 * s;
    const double w19 = -m->disc_radius * (2.0 * m->zeta) * speed;
    const double w20 = p * speed;
    const double w21 = ratio(w20, w9);
    const double w22 = -w18 - w19 + m->load * down_t + m->disc_radius * w21;
    const double w23 = -c + m->disc_radius;
    const double w24 = w22 * w23;
    const double w25 = w23 * w23;
    const double w26 = m->inverse_inertia * w25 + 1.0;
    const double w27 = ratio(m->inverse_inertia * (-m->slope * speed + m->torque + 2.0 * m->zeta * velocity + ((1.0 - m->loose) * w16 + m->shaft_stiffness * w17) - w24) + m->rate, w26);
    const double w28 = w27 * s;
    const double w29 = w3 * q;
    const double w30 = (2.0 * w29 + m->hertz * square) * w6;
    const double w31 = w11 * q;
    const double w32 = ratio(w31, w9);
    const double w33 = w32 * speed;
    const double w34 = w30 * s;
    const double w35 = q * s;
    const double w36 = w21 * q;
    const double w37 = ratio(w36, w9);
    const double w38 = w37 * w23;
    const double w39 = ratio((1.0 - m->loose) * w34 + 2.0 * m->shaft_stiffness * w35 + 2.0 * m->disc_radius * w38, w26);
    const double w40 = w39 * s;
    const double w41 = (-(1.0 - m->loose) * w30 - 2.0 * m->shaft_stiffness * q - m->disc_radius * (2.0 * m->disc_radius) * w33 - m->inverse_inertia * w40) * q;
    const double w42 = w32 * q;
    const double w43 = -m->disc_radius * w11 + 2.0 * m->disc_radius * w42;
    const double w44 = w43 - speed;
    const double w45 = w44 * s;
    const double w46 = c * c;
    const double w47 = s * s;
    const double w48 = -(w46 + w47) + 1.0;
    const double w49 = w48 * speed;
    const double w50 = w49 * c;
    const double w51 = w44 * c;
    const double w52 = w49 * s;
    const double w53 = w43 * down_t;
    const double w54 = down_r * down_r;
    const double w55 = down_t * down_t;
    const double w56 = -(w54 + w55) + 1.0;
    const double w57 = w56 * speed;
    const double w58 = w57 * down_r;
    const double w59 = w43 * down_r;
    const double w60 = w57 * down_t;
    const double w61 = w39 * q;
    const double w62 = w30 * q;
    const double w63 = (w8 + (1.0 - m->loose) * w62) * p;
    const double w64 = p * p;
    const double w65 = w9 * speed;
    const double w66 = ratio(w65, w9);
    const double w67 = w66 * w66;
    const double w68 = w65 * speed;
    const double w69 = w65 * down_t;
    const double w70 = q * speed;
    const double w71 = -2.0 * m->disc_radius * w70;
    const double w72 = w66 * q;
    const double w73 = ratio(w71 + 2.0 * m->disc_radius * w72, w9);
    const double w74 = w73 * w66;
    const double w75 = w70 * speed;
    const double w76 = w70 * down_t;
    const double w77 = (2.0 * m->zeta * (-2.0 * m->disc_radius * w74 + 2.0 * m->disc_radius * w75) + 2.0 * m->load * w76) * q;
    const double w78 = w37 * q;
    const double w79 = m->disc_radius * speed + w65;
    const double w80 = (w22 - 2.0 * m->disc_radius * w78) * w79;
    const double w81 = w22 * q;
    const double w82 = w81 * w70;
    const double w83 = w9 * c;
    const double w84 = w83 * speed;
    const double w85 = velocity - m->disc_radius * w65 + w84;
    const double w86 = (w27 + m->inverse_inertia * w61) * w85;
    const double w87 = w27 * q;
    const double w88 = q * c;
    const double w89 = w88 * speed;
    const double w90 = w87 * (w71 + 2.0 * w89);
    const double w91 = w27 * w23;
    const double w92 = w22 + w91 - w22;
    const double w93 = w39 * w23;
    const double w94 = (-2.0 * m->disc_radius * w37 + m->inverse_inertia * w93 + 2.0 * m->disc_radius * w37) * q;
    const double w95 = (w92 + w94) * w79;
    const double w96 = w92 * q;
    const double w97 = w96 * w70;
    const double w98 = spring * s;
    const double w99 = w11 * w23;
    const double w100 = ratio(2.0 * m->zeta * s + (1.0 - m->loose) * m->contact_damping * w98 - m->disc_radius * w99, w26);
    const double w101 = w100 * s;
    const double w102 = (-2.0 * m->zeta - (1.0 - m->loose) * m->contact_damping * spring - m->inverse_inertia * w101) * q;
    const double w103 = w100 * q;
    const double w104 = spring * q;
    const double w105 = w104 * p;
    const double w106 = w7 * q;
    const double w107 = q * p;
    const double w108 = w31 * w79;
    const double w109 = w103 * w85;
    const double w110 = w87 * s;
    const double w111 = m->disc_radius * w11;
    const double w112 = w100 * w23;
    const double w113 = (w111 + m->inverse_inertia * w112 - w111) * q;
    const double w114 = w113 * w79;
    const double w115 = ratio(m->inverse_inertia * (w19 + w22) + 2.0 * m->inverse_inertia * w91, w26);
    const double w116 = w115 * s;
    const double w117 = (w0 - w116) * q;
    const double w118 = w70 * c;
    const double w119 = w118 * c;
    const double w120 = w48 * w70;
    const double w121 = 0.1 * w120;
    const double w122 = -m->disc_radius * w31;
    const double w123 = w122 - w70;
    const double w124 = w118 * s;
    const double w125 = w115 * q;
    const double w126 = w125 * w85;
    const double around = -m->disc_radius * speed;
    const double w128 = w87 * (around + w65);
    const double w129 = w115 * w23;
    const double w130 = (-w27 + w129) * q;
    const double w131 = w130 * w79;
    const double w132 = w23 * w0;
    const double w133 = ratio(w2 + (w8 + w10) + w132, w26);
    const double w134 = w133 * s;
    const double w135 = (m->inverse_inertia * w134 + w27) * q;
    const double w136 = w70 * s;
    const double w137 = w136 * c;
    const double w138 = w136 * s;
    const double w139 = w133 * q;
    const double w140 = w0 * q;
    const double w141 = w79 * w140;
    const double w142 = w139 * w85;
    const double w143 = w87 * p;
    const double w144 = w133 * w23;
    const double w145 = (-w0 + m->inverse_inertia * w144 + w0) * q;
    const double w146 = w145 * w79;
    const double w147 = w70 * down_r;
    const double w148 = w147 * down_r;
    const double w149 = w56 * w70;
    const double w150 = 0.1 * w149;
    const double w151 = w147 * down_t;
    const double w152 = ratio(w23, w26);
    const double w153 = w152 * s;
    const double w154 = w153 * q;
    const double w155 = w76 * down_r;
    const double w156 = w76 * down_t;
    const double w157 = w152 * q;
    const double w158 = w65 * q;
    const double w159 = w79 * q;
    const double w160 = w157 * w85;
    const double w161 = w152 * w23;
    const double w162 = (m->load - -(-m->load * m->inverse_inertia) * w161 - m->load) * q;
    const double w163 = w162 * w79;
    const double w164 = ratio(1.0, w9);
    const double w165 = w164 * speed;
    const double w166 = s * speed;
    const double w167 = ratio(p, w9);
    const double w168 = -2.0 * w166 - -m->disc_radius * (2.0 * m->zeta) + m->disc_radius * w167;
    const double w169 = w168 * w23;
    const double w170 = ratio(-m->slope - -(-m->disc_radius * (2.0 * m->zeta)) * c - w169, w26);
    const double w171 = w170 * s;
    const double w172 = (2.0 * w14 - (m->disc_radius * (-m->disc_radius) * w11 + m->disc_radius * (-m->disc_radius) * w165) - m->inverse_inertia * w171) * q;
    const double w173 = w164 * q;
    const double w174 = -m->disc_radius * w173 - q;
    const double w175 = w174 * s;
    const double w176 = w48 * q;
    const double w177 = w176 * c;
    const double w178 = w174 * c;
    const double w179 = w176 * s;
    const double w180 = w173 * down_t;
    const double w181 = w56 * q;
    const double w182 = w181 * down_r;
    const double w183 = w173 * down_r;
    const double w184 = w181 * down_t;
    const double w185 = w170 * q;
    const double w186 = ratio(w9, w9);
    const double w187 = w66 * w186;
    const double w188 = w9 * down_t;
    const double w189 = (2.0 * m->zeta * (2.0 * (-m->disc_radius * (-m->disc_radius)) * w187 + 2.0 * m->disc_radius * w65) + m->load * w188) * q;
    const double w190 = w168 * q;
    const double w191 = w190 * w79;
    const double w192 = m->disc_radius + w9;
    const double w193 = w81 * w192;
    const double w194 = w185 * w85;
    const double w195 = w87 * (-m->disc_radius * c - m->disc_radius * w9 + w83);
    const double w196 = w170 * w23;
    const double w197 = (w168 + m->inverse_inertia * w196 - w168) * q;
    const double w198 = w197 * w79;
    const double w199 = w96 * w192;
    matrix[1] = w1 - w2 - w8 - w10 + m->load * down_r - m->disc_radius * (-m->disc_radius) * w12 - w28 + w41;
    matrix[3] = -w45 + 0.1 * w50;
    matrix[4] = w51 + 0.1 * w52;
    matrix[5] = w53 + 0.1 * w58;
    matrix[6] = -w59 + 0.1 * w60;
    matrix[7] = w27 + m->inverse_inertia * w61;
    matrix[8] = 1.0;
    matrix[9] = speed;
    matrix[10] = w8 + (1.0 - m->loose) * w62;
    matrix[11] = w63;
    matrix[12] = 2.0 * m->zeta * (w64 - -(-m->disc_radius * (-m->disc_radius)) * w67 + m->disc_radius * w68) + m->load * w69 + w77 - (w80 + 2.0 * w82) + (w86 + w90) - (w95 + 2.0 * w97);
    matrix[14] = 0.5;
    matrix[15] = w102;
    matrix[21] = m->inverse_inertia * w103;
    matrix[24] = (1.0 - m->loose) * m->contact_damping * w104;
    matrix[25] = (1.0 - m->loose) * m->contact_damping * w105 + (1.0 - m->loose) * w106;
    matrix[26] = 4.0 * m->zeta * w107 - m->disc_radius * w108 + (m->inverse_inertia * w109 + w110) - w114;
    matrix[43] = w117;
    matrix[45] = -0.2 * w119 + w121;
    matrix[46] = w123 - 0.2 * w124;
    matrix[49] = w125;
    matrix[54] = w126 + w128 - w131;
    matrix[57] = -w135;
    matrix[59] = -w123 - 0.2 * w137;
    matrix[60] = -0.2 * w138 + w121;
    matrix[63] = m->inverse_inertia * w139;
    matrix[68] = w141 + (m->inverse_inertia * w142 + w143) - w146;
    matrix[71] = m->load * q;
    matrix[75] = -0.2 * w148 + w150;
    matrix[76] = m->disc_radius * w31 - 0.2 * w151;
    matrix[85] = -(-m->load * m->inverse_inertia) * w154;
    matrix[89] = w122 - 0.2 * w155;
    matrix[90] = -0.2 * w156 + w150;
    matrix[91] = -m->load * m->inverse_inertia * w157;
    matrix[96] = m->load * w158 - m->load * w159 - -(-m->load * m->inverse_inertia) * w160 - w163;
    matrix[99] = w172;
    matrix[101] = -w175 + 0.1 * w177;
    matrix[102] = w178 + 0.1 * w179;
    matrix[103] = -m->disc_radius * w180 + 0.1 * w182;
    matrix[104] = m->disc_radius * w183 + 0.1 * w184;
    matrix[105] = m->inverse_inertia * w185;
    matrix[107] = q;
    matrix[110] = w189 - (w191 + w193) + (m->inverse_inertia * w194 + w195) - (w198 + w199);
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
    const double speed = state[ROLLING_SPEED];
    const double w0 = m->hertz * q + m->linear;
    const double square = q * q;
    const double spring = w0 * square;
    const double w3 = m->contact_damping * p;
    const double w4 = spring * (1.0 + w3);
    const double grip = m->friction * (1.0 - m->loose) * w4;
    const double w6 = speed * speed;
    const double w7 = w6 * s;
    const double w8 = -w7;
    const double w9 = m->load * down_t;
    const double w10 = p * speed;
    const double r = m->delta0 + square;
    const double w12 = ratio(w10, r);
    const double hold = w8 - 2.0 * m->zeta * (-m->disc_radius) * speed + w9 + m->disc_radius * w12;
    const double w14 = p * s;
    const double w15 = c * speed;
    const double velocity = w14 - m->disc_radius * w15;
    const double w17 = 2.0 * m->zeta * velocity;
    const double w18 = w4 * s;
    const double w19 = r * s;
    const double pull = (1.0 - m->loose) * w18 + m->shaft_stiffness * w19;
    const double lever = m->disc_radius - c;
    const double w22 = hold * lever;
    const double left = m->torque - m->slope * speed + w17 + pull - w22;
    const double w24 = lever * lever;
    const double moved = 1.0 + m->inverse_inertia * w24;
    const double faster = ratio(m->rate + m->inverse_inertia * left, moved);
    const double w27 = faster * lever;
    const double hold_ = hold + w27;
    const double w29 = w0 * q;
    const double w30 = w3 + 1.0;
    const double w31 = (2.0 * w29 + m->hertz * square) * w30;
    const double w32 = w31 * p;
    const double w33 = w6 * c;
    const double w34 = 2.0 * m->zeta * p;
    const double force = (1.0 - m->loose) * w4;
    const double w36 = ratio(speed, r);
    const double w37 = w36 * speed;
    const double w38 = faster * s;
    const double outwards = w33 - w34 - force - m->shaft_stiffness * r + m->load * down_r - m->disc_radius * (-m->disc_radius) * w37 - w38;
    const double of_p = outwards * q;
    const double w41 = of_p * spring;
    const double w42 = square + m->delta0;
    const double w43 = ratio(w10, w42);
    const double w44 = w43 * q;
    const double w45 = ratio(w44, w42);
    const double w46 = w31 * s;
    const double w47 = q * s;
    const double w48 = -c + m->disc_radius;
    const double w49 = w45 * w48;
    const double w50 = w48 * w48;
    const double w51 = m->inverse_inertia * w50 + 1.0;
    const double w52 = ratio((1.0 - m->loose) * w46 + 2.0 * m->shaft_stiffness * w47 + 2.0 * m->disc_radius * w49, w51);
    const double w53 = w52 * w48;
    const double w54 = (-2.0 * m->disc_radius * w45 + m->inverse_inertia * w53) * p;
    const double w55 = ratio(speed, w42);
    const double w56 = spring * s;
    const double w57 = w55 * w48;
    const double w58 = ratio(2.0 * m->zeta * s + (1.0 - m->loose) * m->contact_damping * w56 - m->disc_radius * w57, w51);
    const double w59 = w58 * w48;
    const double w60 = of_p * (m->disc_radius * w55 + m->inverse_inertia * w59);
    const double w61 = spring * w30;
    const double w62 = w61 * s;
    const double w63 = w42 * s;
    const double w64 = -m->disc_radius * (2.0 * m->zeta) * speed;
    const double w65 = w8 - w64 + w9 + m->disc_radius * w43;
    const double w66 = w65 * w48;
    const double w67 = ratio(m->inverse_inertia * (-m->slope * speed + m->torque + w17 + ((1.0 - m->loose) * w62 + m->shaft_stiffness * w63) - w66) + m->rate, w51);
    const double w68 = w67 * w48;
    const double w69 = ratio(m->inverse_inertia * (w64 + w65) + 2.0 * m->inverse_inertia * w68, w51);
    const double w70 = w69 * w48;
    const double w71 = w36 * q;
    const double turned = -m->disc_radius * w71;
    const double w73 = q * speed;
    const double turn = turned - w73;
    const double w75 = turn * s;
    const double w76 = (-w67 + w70) * w75;
    const double w77 = w48 * w6;
    const double w78 = ratio(w34 + ((1.0 - m->loose) * w61 + m->shaft_stiffness * w42) + w77, w51);
    const double w79 = w78 * w48;
    const double of_s = turn * c;
    const double w81 = (-w6 + m->inverse_inertia * w79) * of_s;
    const double w82 = ratio(w48, w51);
    const double w83 = w82 * w48;
    const double w84 = w71 * down_r;
    const double w85 = (m->load - -(-m->load * m->inverse_inertia) * w83) * w84;
    const double w86 = faster * q;
    const double w87 = s * speed;
    const double w88 = ratio(p, w42);
    const double w89 = -2.0 * w87 - -m->disc_radius * (2.0 * m->zeta) + m->disc_radius * w88;
    const double w90 = w89 * w48;
    const double w91 = ratio(-m->slope - -(-m->disc_radius * (2.0 * m->zeta)) * c - w90, w51);
    const double w92 = w91 * w48;
    const double w93 = w86 * (w89 + m->inverse_inertia * w92);
    watched[0] = grip;
    watched[1] = hold_;
    rate[0] = 0.5 * ((1.0 - m->loose) * m->friction) * w32 + (1.0 - m->loose) * m->contact_damping * m->friction * w41;
    rate[1] = 0.5 * w54 + w60 - w76 + w81 + m->disc_radius * w85 + w93;
}

/* The Taylor series of the state: 29 lanes. */
static void rolling_expand(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 29 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][ROLLING_Q];
    const double c_first = series->terms[0][ROLLING_C];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    const double inverse_moved = inverse(1.0 + m->inverse_inertia * ((m->disc_radius - c_first) * (m->disc_radius - c_first)));
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 8);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[ROLLING_Q];
        const double p = here[ROLLING_P];
        const double c = here[ROLLING_C];
        const double s = here[ROLLING_S];
        const double down_r = here[ROLLING_DOWN_R];
        const double down_t = here[ROLLING_DOWN_T];
        const double speed = here[ROLLING_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double force = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double w8 = over(series, 5, n, speed, r, inverse_r); /* speed / r */
        const double w9 = times(series, 6, n, w8, speed); /* w8 * speed */
        const double w10 = times(series, 7, n, p, s); /* p * s */
        const double w11 = times(series, 8, n, c, speed); /* c * speed */
        const double velocity = w10 - m->disc_radius * w11;
        const double w13 = times(series, 9, n, w5, s); /* w5 * s */
        const double w14 = times(series, 10, n, r, s); /* r * s */
        const double pull = (1.0 - m->loose) * w13 + m->shaft_stiffness * w14;
        const double w16 = times(series, 11, n, w1, s); /* w1 * s */
        const double w17 = times(series, 12, n, p, speed); /* p * speed */
        const double w18 = over(series, 13, n, w17, r, inverse_r); /* w17 / r */
        const double hold = -w16 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->load * down_t + m->disc_radius * w18;
        const double lever = one * m->disc_radius - c;
        const double w21 = times(series, 14, n, hold, lever); /* hold * lever */
        const double left = one * m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - w21;
        const double w23 = times(series, 15, n, lever, lever); /* lever * lever */
        const double moved = one * 1.0 + m->inverse_inertia * w23;
        /* (rate + inverse_inertia * left) / moved */
        const double faster = over(series, 16, n, one * m->rate + m->inverse_inertia * left, moved, inverse_moved);
        const double w26 = times(series, 17, n, faster, s); /* faster * s */
        const double outwards = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r - m->disc_radius * (-m->disc_radius) * w9 - w26;
        const double of_p = times(series, 18, n, outwards, q); /* outwards * q */
        const double w29 = times(series, 19, n, w8, q); /* w8 * q */
        const double turned = -m->disc_radius * w29;
        const double w31 = times(series, 20, n, q, speed); /* q * speed */
        const double turn = turned - w31;
        const double w33 = times(series, 21, n, turn, s); /* turn * s */
        const double of_c = -w33;
        const double of_s = times(series, 22, n, turn, c); /* turn * c */
        const double w36 = times(series, 23, n, w29, down_t); /* w29 * down_t */
        const double of_down_r = -m->disc_radius * w36;
        const double w38 = times(series, 24, n, w29, down_r); /* w29 * down_r */
        const double of_down_t = m->disc_radius * w38;
        const double w40 = times(series, 25, n, faster, q); /* faster * q */
        const double w41 = times(series, 26, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w41;
        const double w43 = times(series, 27, n, w41, p); /* w41 * p */
        const double grip = m->friction * (1.0 - m->loose) * w5;
        const double w45 = times(series, 28, n, faster, lever); /* faster * lever */
        const double hold_ = hold + w45;
        terms[ROLLING_Q] = of_q * share;
        terms[ROLLING_P] = of_p * share;
        terms[ROLLING_SLIP] = one * 0.0 * share;
        terms[ROLLING_C] = of_c * share;
        terms[ROLLING_S] = of_s * share;
        terms[ROLLING_DOWN_R] = of_down_r * share;
        terms[ROLLING_DOWN_T] = of_down_t * share;
        terms[ROLLING_SPEED] = w40 * share;
        terms[ROLLING_T] = q * share;
        terms[ROLLING_ANGLE] = w31 * share;
        terms[ROLLING_J] = of_j * share;
        terms[ROLLING_WORK] = (1.0 - m->loose) * w43 * share;
        terms[ROLLING_SPENT] = one * 0.0 * share;
        terms[ROLLING_HEAT] = one * 0.0 * share;
        series->watched[n][0] = grip;
        series->watched[n][1] = hold_;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rolling_spent(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {ROLLING_Q, ROLLING_P, ROLLING_C, ROLLING_S, ROLLING_DOWN_T, ROLLING_SPEED};
    vec4 read[6][AT_ONCE];
    read_parts(series, order, reads, 6, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 c = read[2][v];
        const vec4 s = read[3][v];
        const vec4 down_t = read[4][v];
        const vec4 speed = read[5][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 w4 = (w3) / (r);
        const vec4 w5 = w4 * w4;
        const vec4 w6 = w3 * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 - -(-m->disc_radius * (-m->disc_radius)) * w5 + m->disc_radius * w6);
        const vec4 w8 = w3 * down_t;
        const vec4 spent = (damped + m->load * w8) * q;
        const vec4 w10 = speed * speed;
        const vec4 w11 = w10 * s;
        const vec4 w12 = p * speed;
        const vec4 w13 = (w12) / (r);
        const vec4 hold = -w11 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->load * down_t + m->disc_radius * w13;
        const vec4 w15 = hold * q;
        const vec4 w16 = m->disc_radius * speed + w3;
        const vec4 w17 = w15 * w16;
        const vec4 w18 = p * s;
        const vec4 w19 = c * speed;
        const vec4 velocity = w18 - m->disc_radius * w19;
        const vec4 spring = (m->hertz * q + m->linear) * square;
        const vec4 w22 = spring * (1.0 + m->contact_damping * p);
        const vec4 w23 = w22 * s;
        const vec4 w24 = r * s;
        const vec4 pull = (1.0 - m->loose) * w23 + m->shaft_stiffness * w24;
        const vec4 lever = m->disc_radius - c;
        const vec4 w27 = hold * lever;
        const vec4 left = m->torque - m->slope * speed + 2.0 * m->zeta * velocity + pull - w27;
        const vec4 w29 = lever * lever;
        const vec4 moved = 1.0 + m->inverse_inertia * w29;
        const vec4 faster = (m->rate + m->inverse_inertia * left) / (moved);
        const vec4 w32 = faster * q;
        const vec4 w33 = r * c;
        const vec4 w34 = w33 * speed;
        const vec4 turning = w32 * (velocity - m->disc_radius * w3 + w34);
        const vec4 w36 = faster * lever;
        const vec4 hold_ = hold + w36;
        const vec4 added = hold_ - hold;
        const vec4 w39 = added * q;
        const vec4 w40 = w39 * w16;
        rate[v][0] = spent - w17 + turning - w40;
        rate[v][1] = spread(0.0);
    }
}

/* The Taylor series of the state: 19 lanes. */
static void rolling_expand_prescribed(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 19 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
    const double q_first = series->terms[0][ROLLING_Q];
    const double inverse_r = inverse(m->delta0 + q_first * q_first);
    double one = 1.0; /* coefficient n of 1 */
    begin_lanes(series);
    for (int n = 0; n < order; n++) {
        sum_known(series, n, 5);
        const double *here = series->terms[n];
        double *terms = series->terms[n + 1];
        const double share = 1.0 / (n + 1);
        const double q = here[ROLLING_Q];
        const double p = here[ROLLING_P];
        const double c = here[ROLLING_C];
        const double s = here[ROLLING_S];
        const double down_r = here[ROLLING_DOWN_R];
        const double down_t = here[ROLLING_DOWN_T];
        const double speed = here[ROLLING_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        /* (hertz * q + linear) * square */
        const double spring = times(series, 3, n, m->hertz * q + one * m->linear, square);
        /* spring * (1.0 + contact_damping * p) */
        const double w5 = times(series, 4, n, spring, one * 1.0 + m->contact_damping * p);
        const double force = (1.0 - m->loose) * w5;
        const double r = one * m->delta0 + square;
        const double w8 = over(series, 5, n, speed, r, inverse_r); /* speed / r */
        const double w9 = times(series, 6, n, w8, speed); /* w8 * speed */
        const double outwards = w2 - 2.0 * m->zeta * p - force - m->shaft_stiffness * r + m->load * down_r - m->disc_radius * (-m->disc_radius) * w9 - m->rate * s;
        const double of_p = times(series, 7, n, outwards, q); /* outwards * q */
        const double w12 = times(series, 8, n, w8, q); /* w8 * q */
        const double turned = -m->disc_radius * w12;
        const double w14 = times(series, 9, n, q, speed); /* q * speed */
        const double turn = turned - w14;
        const double w16 = times(series, 10, n, turn, s); /* turn * s */
        const double of_c = -w16;
        const double of_s = times(series, 11, n, turn, c); /* turn * c */
        const double w19 = times(series, 12, n, w12, down_t); /* w12 * down_t */
        const double of_down_r = -m->disc_radius * w19;
        const double w21 = times(series, 13, n, w12, down_r); /* w12 * down_r */
        const double of_down_t = m->disc_radius * w21;
        const double w23 = times(series, 14, n, w5, q); /* w5 * q */
        const double of_j = (1.0 - m->loose) * w23;
        const double w25 = times(series, 15, n, w23, p); /* w23 * p */
        const double grip = m->friction * (1.0 - m->loose) * w5;
        const double w27 = times(series, 16, n, w1, s); /* w1 * s */
        const double w28 = times(series, 17, n, p, speed); /* p * speed */
        const double w29 = over(series, 18, n, w28, r, inverse_r); /* w28 / r */
        const double hold = -w27 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->load * down_t + m->disc_radius * w29;
        const double lever = one * m->disc_radius - c;
        const double hold_ = hold + m->rate * lever;
        terms[ROLLING_Q] = of_q * share;
        terms[ROLLING_P] = of_p * share;
        terms[ROLLING_SLIP] = one * 0.0 * share;
        terms[ROLLING_C] = of_c * share;
        terms[ROLLING_S] = of_s * share;
        terms[ROLLING_DOWN_R] = of_down_r * share;
        terms[ROLLING_DOWN_T] = of_down_t * share;
        terms[ROLLING_SPEED] = m->rate * q * share;
        terms[ROLLING_T] = q * share;
        terms[ROLLING_ANGLE] = w14 * share;
        terms[ROLLING_J] = of_j * share;
        terms[ROLLING_WORK] = (1.0 - m->loose) * w25 * share;
        terms[ROLLING_SPENT] = one * 0.0 * share;
        terms[ROLLING_HEAT] = one * 0.0 * share;
        series->watched[n][0] = grip;
        series->watched[n][1] = hold_;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rolling_spent_prescribed(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {ROLLING_Q, ROLLING_P, ROLLING_C, ROLLING_S, ROLLING_DOWN_T, ROLLING_SPEED};
    vec4 read[6][AT_ONCE];
    read_parts(series, order, reads, 6, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 c = read[2][v];
        const vec4 s = read[3][v];
        const vec4 down_t = read[4][v];
        const vec4 speed = read[5][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 w4 = (w3) / (r);
        const vec4 w5 = w4 * w4;
        const vec4 w6 = w3 * speed;
        const vec4 damped = 2.0 * m->zeta * (w0 - -(-m->disc_radius * (-m->disc_radius)) * w5 + m->disc_radius * w6);
        const vec4 w8 = w3 * down_t;
        const vec4 spent = (damped + m->load * w8) * q;
        const vec4 w10 = speed * speed;
        const vec4 w11 = w10 * s;
        const vec4 w12 = p * speed;
        const vec4 w13 = (w12) / (r);
        const vec4 hold = -w11 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->load * down_t + m->disc_radius * w13;
        const vec4 w15 = hold * q;
        const vec4 w16 = m->disc_radius * speed + w3;
        const vec4 w17 = w15 * w16;
        const vec4 w18 = p * s;
        const vec4 w19 = c * speed;
        const vec4 velocity = w18 - m->disc_radius * w19;
        const vec4 w21 = r * c;
        const vec4 w22 = w21 * speed;
        const vec4 w23 = (velocity - m->disc_radius * w3 + w22) * q;
        const vec4 turning = m->rate * w23;
        const vec4 lever = m->disc_radius - c;
        const vec4 hold_ = hold + m->rate * lever;
        const vec4 added = hold_ - hold;
        const vec4 w28 = added * q;
        const vec4 w29 = w28 * w16;
        rate[v][0] = spent - w17 + turning - w29;
        rate[v][1] = spread(0.0);
    }
}

/* The Taylor series of the state: 15 lanes. */
static void rolling_expand_plain(const struct parameters *m,
    struct series *series, int order)
{
    _Static_assert(14 <= WIDTH && 15 <= LANES && 0 <= FACTORS, "series.h has no room for this mode");
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
        const double speed = here[ROLLING_SPEED];
        const double of_q = 0.5 * p;
        const double w1 = times(series, 0, n, speed, speed); /* speed * speed */
        const double w2 = times(series, 1, n, w1, c); /* w1 * c */
        const double square = times(series, 2, n, q, q); /* q * q */
        const double spring = times(series, 3, n, square, q); /* square * q */
        const double r = one * m->delta0 + square;
        const double w6 = over(series, 4, n, speed, r, inverse_r); /* speed / r */
        const double w7 = times(series, 5, n, w6, speed); /* w6 * speed */
        const double outwards = w2 - 2.0 * m->zeta * p - spring - m->disc_radius * (-m->disc_radius) * w7 - m->rate * s;
        const double of_p = times(series, 6, n, outwards, q); /* outwards * q */
        const double w10 = times(series, 7, n, w6, q); /* w6 * q */
        const double turned = -m->disc_radius * w10;
        const double w12 = times(series, 8, n, q, speed); /* q * speed */
        const double turn = turned - w12;
        const double w14 = times(series, 9, n, turn, s); /* turn * s */
        const double of_c = -w14;
        const double of_s = times(series, 10, n, turn, c); /* turn * c */
        const double of_j = times(series, 11, n, spring, q); /* spring * q */
        const double grip = m->friction * spring;
        const double w19 = times(series, 12, n, w1, s); /* w1 * s */
        const double w20 = times(series, 13, n, p, speed); /* p * speed */
        const double w21 = over(series, 14, n, w20, r, inverse_r); /* w20 / r */
        const double hold = -w19 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->disc_radius * w21;
        const double lever = one * m->disc_radius - c;
        const double hold_ = hold + m->rate * lever;
        terms[ROLLING_Q] = of_q * share;
        terms[ROLLING_P] = of_p * share;
        terms[ROLLING_SLIP] = one * 0.0 * share;
        terms[ROLLING_C] = of_c * share;
        terms[ROLLING_S] = of_s * share;
        terms[ROLLING_DOWN_R] = one * 0.0 * share;
        terms[ROLLING_DOWN_T] = one * 0.0 * share;
        terms[ROLLING_SPEED] = m->rate * q * share;
        terms[ROLLING_T] = q * share;
        terms[ROLLING_ANGLE] = w12 * share;
        terms[ROLLING_J] = of_j * share;
        terms[ROLLING_WORK] = one * 0.0 * share;
        terms[ROLLING_SPENT] = one * 0.0 * share;
        terms[ROLLING_HEAT] = one * 0.0 * share;
        series->watched[n][0] = grip;
        series->watched[n][1] = hold_;
        one = 0.0;
    }
}

/* The rates of what damping, load and drive take, and of the heat, at parts of a step. */
static void rolling_spent_plain(const struct parameters *m,
    const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2])
{
    static const int reads[] = {ROLLING_Q, ROLLING_P, ROLLING_C, ROLLING_S, ROLLING_SPEED};
    vec4 read[5][AT_ONCE];
    read_parts(series, order, reads, 5, parts, read);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = read[0][v];
        const vec4 p = read[1][v];
        const vec4 c = read[2][v];
        const vec4 s = read[3][v];
        const vec4 speed = read[4][v];
        const vec4 w0 = p * p;
        const vec4 square = q * q;
        const vec4 r = m->delta0 + square;
        const vec4 w3 = r * speed;
        const vec4 w4 = (w3) / (r);
        const vec4 w5 = w4 * w4;
        const vec4 w6 = w3 * speed;
        const vec4 w7 = (w0 - -(-m->disc_radius * (-m->disc_radius)) * w5 + m->disc_radius * w6) * q;
        const vec4 spent = 2.0 * m->zeta * w7;
        const vec4 w9 = speed * speed;
        const vec4 w10 = w9 * s;
        const vec4 w11 = p * speed;
        const vec4 w12 = (w11) / (r);
        const vec4 hold = -w10 - 2.0 * m->zeta * (-m->disc_radius) * speed + m->disc_radius * w12;
        const vec4 w14 = hold * q;
        const vec4 w15 = m->disc_radius * speed + w3;
        const vec4 w16 = w14 * w15;
        const vec4 w17 = p * s;
        const vec4 w18 = c * speed;
        const vec4 velocity = w17 - m->disc_radius * w18;
        const vec4 w20 = r * c;
        const vec4 w21 = w20 * speed;
        const vec4 w22 = (velocity - m->disc_radius * w3 + w21) * q;
        const vec4 turning = m->rate * w22;
        const vec4 lever = m->disc_radius - c;
        const vec4 hold_ = hold + m->rate * lever;
        const vec4 added = hold_ - hold;
        const vec4 w27 = added * q;
        const vec4 w28 = w27 * w15;
        rate[v][0] = spent - w16 + turning - w28;
        rate[v][1] = spread(0.0);
    }
}

const struct mode rolling_mode = {
    .size = ROLLING_SIZE,
    .field = rolling_field,
    .jacobian = rolling_jacobian,
    .expand = rolling_expand,
    .expand_prescribed = rolling_expand_prescribed,
    .expand_plain = rolling_expand_plain,
    .watched = rolling_watched,
    .spent = rolling_spent,
    .spent_prescribed = rolling_spent_prescribed,
    .spent_plain = rolling_spent_plain,
};

#endif
