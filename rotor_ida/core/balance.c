/* The force and the energy of a contact: its largest force, what it has lost, and whether its
 * energy balances. */
#include "events.h"

double lost_of(const struct motion *motion, const double *start, const double *values)
{
    const struct parameters *m = &motion->model;
    if (m->contact_damping == 0.0)
        return 0.0;
    return values[CONTACT_WORK] - energy_of_root(m, values[CONTACT_Q])
           + energy_of_root(m, start[CONTACT_Q]);
}

/* What the motion has of the energy on the rotating axes, but for the ring: there the unbalance
 * pulls with a constant force. Its largest part is kept in `scale`. */
static double energy_of(const struct motion *motion, const double *values, double *scale)
{
    const struct parameters *m = &motion->model;
    const double radius = radius_in_contact(m, values);
    const double p = values[CONTACT_P], momentum = momentum_of(motion, values);
    const double around = momentum / radius;
    const double moving = 0.5 * (p * p + around * around);
    const double bent = 0.5 * m->shaft_stiffness * radius * radius;
    const double lifted = m->load * radius * values[CONTACT_DOWN_R];
    const double omega = speed_of(motion, values), turning = omega * momentum;
    const double pulled = omega * omega * radius * values[CONTACT_C];
    *scale = larger(*scale, moving + bent + fabs(lifted) + fabs(turning) + fabs(pulled));
    return moving + bent - lifted - turning - pulled;
}

/* The error of energy allowed a step, in tolerances. A step's own is up to one of them. */
static const double ENERGY_ERROR = 100.0;
/* Steps that are allowed for beginning and end. */
enum { STEPS_AT_ENDS = 10 };

/* Whether energy balances over a contact of so many steps: what the motion has lost went into the
 * ring, into damping, and into the work of the load that turns on these axes. It is measured by the
 * largest energies at the ends and where the contact is deepest, and by what the ring holds: a
 * start deep in it that only creeps back has next to none beside that. */
int is_balanced(const struct motion *motion, double absolute, const double *start,
                const double *deepest, const double *reached, int64_t steps)
{
    const struct parameters *m = &motion->model;
    double scale = 0.0;
    energy_of(motion, deepest, &scale);
    scale += fabs(deepest[CONTACT_WORK]) + fabs(deepest[CONTACT_SPENT])
             + fabs(reached[CONTACT_WORK]) + fabs(reached[CONTACT_SPENT])
             + fabs(heat_of(motion, reached)) + energy_of_root(m, start[CONTACT_Q])
             + energy_of_root(m, reached[CONTACT_Q]);
    const double before = energy_of(motion, start, &scale);
    const double after = energy_of(motion, reached, &scale);
    const double missing = after - before + reached[CONTACT_WORK] - start[CONTACT_WORK]
                           + reached[CONTACT_SPENT] - start[CONTACT_SPENT]
                           + heat_of(motion, reached) - heat_of(motion, start);
    /* what errors of angular momentum and of directions come to that are allowed by themselves */
    const double radius = radius_in_contact(m, reached);
    const double spin = fabs(momentum_of(motion, reached)) / (radius * radius);
    const double omega = larger(speed_of(motion, start), speed_of(motion, reached));
    const double apart = omega + spin + (omega * omega + m->load) * radius;
    /* so much of the angular momentum is lost in the moment of the slip of a large disc */
    const double rounded = ROUNDING * rim_of(motion, reached) * radius;
    const double allowed = ENERGY_ERROR * (double)(steps + STEPS_AT_ENDS);
    return fabs(missing) <= allowed * (motion->rtol * scale + (absolute + rounded) * apart);
}

/* The normal force of a contact at values, and how fast it grows. */
struct push {
    double force, growth;
};

static double force_at(const struct motion *motion, const double *values)
{
    return larger(normal_force(&motion->model, values[CONTACT_Q], values[CONTACT_P]), 0.0);
}

static struct push push_of(const struct motion *motion, const double *values, const double *rate)
{
    const double growth = rate_of_force(&motion->model, values[CONTACT_Q], values[CONTACT_P],
                                        rate[CONTACT_Q], rate[CONTACT_P]);
    return (struct push){force_at(motion, values), growth};
}

static struct push push_within(struct motion *motion, const double *values)
{
    double rate[MOST_VALUES];
    motion->mode->field(&motion->model, values, rate);
    return push_of(motion, values, rate);
}

/* Keep the largest force of a step up to `end`: with damping it comes before the largest
 * indentation. It is sought where the force grows at the beginning and falls at the end. */
void raise_force(struct peak *peak, struct motion *motion, double end, const double *reached)
{
    if (motion->model.contact_damping == 0.0 || is_loose(motion))
        return;
    struct push left = push_of(motion, motion->before, motion->rate(motion));
    peak->force = larger(peak->force, larger(left.force, force_at(motion, reached)));
    if (!(left.growth > 0.0))
        return;
    struct push right = push_within(motion, reached);
    double low = motion->low, high = end;
    for (int i = 0; left.growth > 0.0 && 0.0 > right.growth && i < MOST_NARROWING; i++) {
        /* no more than what it grows from either end is to be had */
        const double most = smaller(left.force + left.growth * (high - low),
                                    right.force - right.growth * (high - low));
        if (most <= peak->force * (1.0 + LEAST_RISE))
            break;
        /* by the secant of the growth, or halves where that gets nowhere */
        const double part = i % 4 == 3 ? 0.5 : left.growth / (left.growth - right.growth);
        const double point = low + part * (high - low);
        const struct push here = push_within(motion, motion->at(motion, point));
        peak->force = larger(peak->force, here.force);
        if (here.growth > 0.0) {
            low = point;
            left = here;
        } else {
            high = point;
            right = here;
        }
    }
}
