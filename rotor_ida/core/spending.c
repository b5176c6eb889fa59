/* What damping, load and drive take of a contact's energy on the rotating axes, and the heat of
 * sliding: by quadratures over the steps of Taylor series, which have no lanes for them.
 *
 * CVODE integrates both with the motion. The balance of energy over a contact is what they serve.
 */
#include "motion.h"

#ifdef WHOLE_MODEL
/* Places and weights of Gauss's quadrature of eight points on [0, 1], four to a vector. */
enum { AT_ONCE = 2, READ = 4 };
static const vec4 PLACES[AT_ONCE] = {
    {0.01985507175123188, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751},
    {0.5917173212478249, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681}};
static const vec4 WEIGHTS[AT_ONCE] = {
    {0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.18134189168918100},
    {0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.05061426814518813}};

#ifdef RUN_UP
/* What a contact spends against the field itself, where a torque drives it. */
static void spend_driven(struct motion *motion, double end, double *reached)
{
    const double reach = end - motion->low;
    for (int place = 0; place < 4 * AT_ONCE; place++) {
        double values[WIDTH], rate[WIDTH];
        const double part = reach * PLACES[place / 4][place % 4];
        evaluate(taylor_of(motion)->series.terms[0], WIDTH, WIDTH, taylor_of(motion)->order, part,
                 0, values);
        motion->mode->field(&motion->model, values, rate);
        const double weight = reach * WEIGHTS[place / 4][place % 4];
        reached[CONTACT_SPENT] += weight * rate[CONTACT_SPENT];
        if (motion->mode != &contact_mode)
            reached[RUB_HEAT] += weight * rate[RUB_HEAT];
    }
}

/* What a contact spends, by a quadrature over the last step: a lane of its own would cost more.
 * Where the speed is prescribed the formula is written here a second time. */
void spend(struct motion *motion, double end, double *reached)
{
    const struct parameters *m = &motion->model;
    const struct series *series = &taylor_of(motion)->series;
    if (is_plain(m)) /* there the series has no work, which is what the ring holds */
        reached[CONTACT_WORK] = spring_energy(m, reached[CONTACT_Q]);
    if (m->inverse_inertia > 0.0) {
        spend_driven(motion, end, reached);
        return;
    }
    vec4 values[CONTACT_SPEED + 1][AT_ONCE] = {{{0.0}}}, total = spread(0.0), heat = spread(0.0);
    const double reach = end - motion->low;
    for (int n = taylor_of(motion)->order; n >= 0; n--) {
        for (int i = 0; i <= CONTACT_SPEED; i++) {
            for (int v = 0; v < AT_ONCE; v++)
                values[i][v] = fma4(values[i][v], spread(reach) * PLACES[v],
                                    spread(series->terms[n][i]));
        }
    }
    const int rubs = motion->mode != &contact_mode, rolls = motion->mode == &rolling_mode;
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = values[CONTACT_Q][v], p = values[CONTACT_P][v], c = values[CONTACT_C][v];
        const vec4 s = values[CONTACT_S][v], omega = values[CONTACT_SPEED][v], square = q * q;
        const vec4 r = spread(m->delta0) + square, third = values[CONTACT_H][v] / r;
        const vec4 rim = spread(rubs ? m->disc_radius : 0.0) * omega, around = third - rim;
        const vec4 h = around * r, across = spread(m->load) * values[CONTACT_DOWN_T][v];
        const vec4 faster = spread(m->rate);
        vec4 drag = spread(m->friction * m->sigma * m->pressed) * square
                    * (spread(m->hertz) * q + spread(m->linear))
                    * (spread(1.0) + spread(m->contact_damping) * p);
        if (rolls)
            drag = across - omega * omega * s + rim * (spread(2.0 * m->zeta) + p / r)
                   + faster * (spread(m->disc_radius) - c);
        const vec4 damped = spread(2.0 * m->zeta) * (p * p + around * around - omega * h);
        const vec4 turning = faster * (p * s + around * c + h + omega * r * c);
        const vec4 drive = rubs ? drag * (rim + omega * r) : spread(0.0);
        total += WEIGHTS[v] * q * (damped + omega * r * across + turning - drive);
        heat += WEIGHTS[v] * q * drag * third;
    }
    reached[CONTACT_SPENT] += reach * (total[0] + total[1] + total[2] + total[3]);
    if (rubs && !rolls)
        reached[RUB_HEAT] += reach * (heat[0] + heat[1] + heat[2] + heat[3]);
}
#else
/* Read components of a contact where the quadrature over a step looks at them. */
static inline __attribute__((always_inline)) void look(const struct taylor *taylor,
                                                       const int *components, const int count,
                                                       double reach, vec4 (*values)[AT_ONCE])
{
    for (int i = 0; i < count; i++)
        values[i][0] = values[i][1] = spread(0.0);
    for (int n = taylor->order; n >= 0; n--) {
        for (int i = 0; i < count; i++) {
            const vec4 term = spread(taylor->series.terms[n][components[i]]);
            for (int v = 0; v < AT_ONCE; v++)
                values[i][v] = fma4(values[i][v], spread(reach) * PLACES[v], term);
        }
    }
}

/* What a contact with friction spends, for which the drive has to put in T (V + omega r) on these
 * axes; and the heat of sliding. */
static void spend_with_friction(struct motion *motion, double end, double *reached)
{
    enum { COUNT = 5 };
    static const int components[COUNT] = {RUB_Q, RUB_P, RUB_SLIP, RUB_DOWN_T, RUB_S};
    const struct parameters *m = &motion->model;
    const double reach = end - motion->low, torque = m->omega * m->load;
    const double sliding = m->friction * m->sigma * m->pressed;
    const int rolls = motion->mode == &rolling_mode;
    vec4 values[COUNT][AT_ONCE], total = spread(0.0), heat = spread(0.0);
    values[3][0] = values[3][1] = spread(0.0);
    if (rolls)
        look(taylor_of(motion), components, COUNT, reach, values);
    else if (m->load > 0.0) /* as far as they are needed */
        look(taylor_of(motion), components, COUNT - 1, reach, values);
    else
        look(taylor_of(motion), components, COUNT - 2, reach, values);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = values[0][v], p = values[1][v], across = values[3][v], square = q * q;
        const vec4 r = spread(m->delta0) + square, slip = values[2][v] / r;
        const vec4 around = slip - spread(m->rim), h = around * r;
        vec4 drag;
        if (rolls)
            drag = spread(m->load) * across - spread(m->omega * m->omega) * values[4][v]
                   + spread(m->rim) * (spread(2.0 * m->zeta) + p / r);
        else
            drag = spread(sliding) * square * (spread(m->hertz) * q + spread(m->linear))
                   * (spread(1.0) + spread(m->contact_damping) * p);
        const vec4 damped = spread(2.0 * m->zeta)
                            * (p * p + around * around - spread(m->omega) * h);
        const vec4 drive = drag * (spread(m->rim) + spread(m->omega) * r);
        total += WEIGHTS[v] * q * (damped + spread(torque) * r * across - drive);
        heat += WEIGHTS[v] * q * drag * slip;
    }
    reached[RUB_SPENT] += reach * (total[0] + total[1] + total[2] + total[3]);
    if (!rolls)
        reached[RUB_HEAT] += reach * (heat[0] + heat[1] + heat[2] + heat[3]);
}

/* What a contact spends, by a quadrature over the last step: a lane of its own would cost more. The
 * formula is written here a second time, as the balance of energy is there to witness. */
void spend(struct motion *motion, double end, double *reached)
{
    if (motion->mode != &contact_mode) {
        spend_with_friction(motion, end, reached);
        return;
    }
    const struct parameters *m = &motion->model;
    const struct series *series = &taylor_of(motion)->series;
    const double torque = m->omega * m->load, damping = 2.0 * m->zeta, reach = end - motion->low;
    if (damping == 0.0 && torque == 0.0)
        return;
    static const int components[READ] = {CONTACT_Q, CONTACT_P, CONTACT_H, CONTACT_DOWN_T};
    vec4 values[READ][AT_ONCE] = {{{0.0}}};
    for (int n = taylor_of(motion)->order; n >= 0; n--) {
        for (int i = 0; i < READ; i++) {
            const vec4 term = spread(series->terms[n][components[i]]);
            for (int v = 0; v < AT_ONCE; v++)
                values[i][v] = fma4(values[i][v], spread(reach) * PLACES[v], term);
        }
    }
    vec4 total = spread(0.0);
    for (int v = 0; v < AT_ONCE; v++) {
        const vec4 q = values[0][v], p = values[1][v], h = values[2][v], across = values[3][v];
        const vec4 r = spread(m->delta0) + q * q, around = h / r;
        const vec4 damped = spread(damping) * (p * p + around * around - spread(m->omega) * h);
        total += WEIGHTS[v] * q * (damped + spread(torque) * r * across);
    }
    reached[CONTACT_SPENT] += reach * (total[0] + total[1] + total[2] + total[3]);
}
#endif
#endif
