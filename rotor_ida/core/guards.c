/* What ends a mode of contact before the contact itself ends: the force falls to 0 or comes back,
 * surfaces stop sliding, or the grip is not enough for the disc to roll. */
#include "events.h"

/* Looks a step by CVODE is given for a change; one by Taylor series is cut so that it has one at
 * most. */
enum { LOOKS_FOR_CHANGE = 4 };
/* A margin below this many roundings of its terms is no margin. */
static const double MARGIN_ROUNDING = 16.0 * ROUNDING;

/* How far the radial velocity is inside the mode: above that of release, or below it where the
 * contact is loose. */
static double margin_of_release(const struct motion *motion, const double *values)
{
    const double above = values[CONTACT_P] - release_velocity(&motion->model);
    return is_loose(motion) ? -above : above;
}

double margin_of(const struct motion *motion, enum guard guard, const double *values,
                 double *growth)
{
    const struct parameters *m = &motion->model;
    if (guard == GRIPS_FORWARDS || guard == GRIPS_BACKWARDS) {
        double watched[WATCHED], rates[WATCHED];
        motion->mode->watched(m, values, watched, rates);
        const double sense = guard == GRIPS_FORWARDS ? -1.0 : 1.0;
        if (growth != NULL)
            *growth = rates[0] + sense * rates[1];
        return watched[0] + sense * watched[1];
    }
    if (growth != NULL) {
        double rate[MOST_VALUES];
        motion->mode->field(m, values, rate);
        const double side = is_loose(motion) ? -1.0 : 1.0;
        *growth = guard == RELEASE_OR_PRESS ? side * rate[CONTACT_P] : m->sigma * rate[RUB_SLIP];
    }
    return guard == RELEASE_OR_PRESS ? margin_of_release(motion, values)
                                     : m->sigma * values[RUB_SLIP];
}

/* The sizes of what the force is made of that rolling needs. */
static double size_of_hold(const struct motion *motion, const double *values)
{
    const struct parameters *m = &motion->model;
    const double r = radius_in_contact(m, values);
    const double omega = speed_of(motion, values), rim = rim_of(motion, values);
    const double size = omega * omega + m->load
                        + rim * (2.0 * m->zeta + fabs(values[CONTACT_P]) / r);
    if (!SPEED_CHANGES)
        return size;
    double rate[MOST_VALUES];
    rolling_mode.field(m, values, rate);
    const double q = values[CONTACT_Q];
    const double faster = q > 0.0 ? fabs(rate[CONTACT_SPEED]) / q : fabs(m->rate);
    return size + faster * (m->disc_radius + 1.0);
}

double hidden_hold(const struct motion *motion, const double *values)
{
    return MARGIN_ROUNDING * size_of_hold(motion, values);
}

double hidden_slip(const struct motion *motion, const double *values)
{
    const double r = radius_in_contact(&motion->model, values);
    const double others = fabs(values[CONTACT_P]) + rim_of(motion, values);
    return MARGIN_ROUNDING * (fabs(momentum_of(motion, values)) + r * others);
}

/* A margin that is no further below 0 may be rounding. */
static double hidden(const struct motion *motion, enum guard guard, const double *values)
{
    if (guard == RELEASE_OR_PRESS)
        return 0.0;
    return guard == SLIDING ? hidden_slip(motion, values) : hidden_hold(motion, values);
}

/* How far inside its mode a contact is at a point of the last step; and how fast that grows, which
 * is not asked of Taylor series. */
struct margin {
    double point, value, growth;
};

static struct margin margin_at(struct motion *motion, enum guard guard, double point)
{
    double growth = 0.0;
    const double *values = motion->at(motion, point);
    const double value = margin_of(motion, guard, values, motion->begins_anew ? NULL : &growth);
    return (struct margin){point, value, growth};
}

/* A point between two at which the contact is outside its mode, or the second of the two: where the
 * margin falls and rises between them, its least is looked at as long as it may be below `lowest`.
 */
static struct margin point_outside(struct motion *motion, enum guard guard, double lowest,
                                   struct margin left, struct margin right)
{
    const struct margin last = right;
    for (int i = 0; left.growth < 0.0 && 0.0 < right.growth && i < MOST_NARROWING; i++) {
        const double reach = right.point - left.point;
        const double least = larger(left.value + left.growth * reach,
                                    right.value - right.growth * reach);
        if (!(least < lowest) || reach <= ROUNDING * right.point)
            break;
        const double part = i % 4 == 3 ? 0.5 : left.growth / (left.growth - right.growth);
        const struct margin here = margin_at(motion, guard, left.point + part * reach);
        if (here.value < lowest)
            return here;
        if (here.growth < 0.0)
            left = here;
        else
            right = here;
    }
    return last;
}

/* A point from `from` on, before `to`, that is inside the mode, which begins where it ended last.
 */
static double point_within_mode(struct motion *motion, enum guard guard, double from, double to)
{
    double point = from, reach = to - from;
    while (margin_of(motion, guard, motion->at(motion, point), NULL) <= 0.0 && reach > 1e-14 * to) {
        reach *= 0.125;
        point = from + reach;
    }
    return point;
}

/* Whether surfaces that stand still at a point are driven on in the sense in which they slide, but
 * for rounding. After a slip their speed grows like the square of time: the error of a step may
 * exceed it. */
static int is_driven_on(struct motion *motion, double point)
{
    const double *values = motion->at(motion, point);
    double watched[WATCHED], rates[WATCHED];
    rolling_mode.watched(&motion->model, values, watched, rates);
    return motion->model.sigma * watched[1] > watched[0] - hidden_hold(motion, values);
}

/* Where in the last step, up to `end`, a margin falls through 0: at its beginning where nothing of
 * the step is inside the mode; infinite where it does not, NaN where it cannot be found. */
static double crossing_in_step(struct motion *motion, enum guard guard, double end)
{
    const int looks = motion->begins_anew ? 1 : LOOKS_FOR_CHANGE;
    const double lowest = -hidden(motion, guard, motion->before);
    struct margin from = margin_at(motion, guard, motion->low);
    for (int look = 1; look <= looks; look++) {
        const double low = motion->low;
        const double next = look < looks ? low + (end - low) * look / looks : end;
        const struct margin to = margin_at(motion, guard, next);
        const struct margin outside = to.value < lowest
                                          ? to
                                          : point_outside(motion, guard, lowest, from, to);
        if (outside.value < lowest) {
            const double inside = point_within_mode(motion, guard, from.point, outside.point);
            if (margin_of(motion, guard, motion->at(motion, inside), NULL) > 0.0)
                return root_of_guard(motion, guard, inside, outside.point);
            if (guard != SLIDING || !is_driven_on(motion, from.point))
                return from.point;
        }
        from = to;
    }
    return INFINITY;
}

/* Take another change if it comes first, or cannot be found. */
static void take_first(struct change *first, struct motion *motion, enum guard guard, double end)
{
    const double point = crossing_in_step(motion, guard, end);
    if (point < first->point || isnan(point))
        *first = (struct change){point, guard};
}

struct change change_in_step(struct motion *motion, double end)
{
    struct change first = NO_CHANGE;
    if (motion->model.contact_damping > 0.0)
        take_first(&first, motion, RELEASE_OR_PRESS, end);
    if (motion->mode == &rub_mode && motion->model.sigma != 0.0)
        take_first(&first, motion, SLIDING, end);
    if (motion->mode != &rolling_mode)
        return first;
    double watched[WATCHED], rates[WATCHED], hold = 0.0;
    const double hidden_by = hidden_hold(motion, motion->before);
    motion->mode->watched(&motion->model, motion->before, watched, rates);
    hold = fabs(watched[1]);
    motion->mode->watched(&motion->model, motion->values, watched, rates);
    if (larger(hold, fabs(watched[1])) > hidden_by) {
        take_first(&first, motion, GRIPS_FORWARDS, end);
        take_first(&first, motion, GRIPS_BACKWARDS, end);
    }
    return first;
}
