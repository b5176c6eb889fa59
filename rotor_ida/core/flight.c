/* Flight in closed form: the motion, and the search in it for the first touch of the ring, and for
 * where the radius turns.
 *
 * The first touch is the first root of g = |z|**2 - delta0**2. The search steps only as far as a
 * bound on g''' guarantees that g has no root, so no touch can hide between two steps. */
#include "plain_flight.h"
#include "sprung_flight.h"

enum { MOST_POLISHING = 80 };

struct motion_of_centre fly(struct motion_of_centre start, double tau, const struct rotor *rotor)
{
    return IS_WHOLE ? sprung_fly(start, tau, rotor) : plain_fly(start, tau, rotor);
}

void fly_differences(double *rows, int count, double tau, const struct rotor *rotor)
{
    const struct answers by = IS_WHOLE ? sprung_answers(rotor, tau) : plain_answers(rotor, tau);
    const struct vector back = mirrored(by.turn);
    for (double *row = rows; row < rows + 4 * count; row += 4) {
        const struct vector z = {row[0], row[1]}, w = {row[2], row[3]};
        const struct vector there = product(plus(scaled(by.c, z), scaled(by.s, w)), back);
        const struct vector then = product(plus(scaled(by.c_rate, z), scaled(by.s_rate, w)), back);
        row[0] = there.x;
        row[1] = there.y;
        row[2] = then.x;
        row[3] = then.y;
    }
}

/* ---- The first touch ---- */

static struct path path_from(struct motion_of_centre start, const struct rotor *rotor, double limit)
{
    return IS_WHOLE ? sprung_begin(start, rotor, limit) : plain_begin(start, rotor, limit);
}

static struct gap gap_at(struct path *path, double tau)
{
    return IS_WHOLE ? sprung_gap(path, tau) : plain_gap(path, tau);
}

static struct turning turning_at(struct path *path, double tau)
{
    return IS_WHOLE ? sprung_turning(path, tau) : plain_turning(path, tau);
}

/* The root of g between `low` (g <= 0) and `high` (g > 0): Newton's method in a bracket. */
static double polish(struct path *path, double low, double high)
{
    double tau = high;
    for (int i = 0; i < MOST_POLISHING; i++) {
        const struct gap g = gap_at(path, tau);
        if (g.value > 0.0)
            high = tau;
        else
            low = tau;
        double new = tau - (g.slope > 0.0 ? g.value / g.slope : INFINITY);
        if (!(low < new && new < high))
            new = 0.5 * (low + high);
        if (fabs(new - tau) <= ROUNDING * tau || high - low <= ROUNDING * high)
            return new;
        tau = new;
    }
    return tau;
}

double first_touch(struct motion_of_centre start, const struct rotor *rotor, double limit,
                   const stop_flag *stop)
{
    struct path path = path_from(start, rotor, limit);
    const double delta0 = rotor->delta0, floor = path.floor;
    double tau = 0.0, outside = 0.0, step = path.longest;
    while (tau < limit && !asked_to_stop(stop)) {
        struct gap g = gap_at(&path, tau);
        if (g.value <= 0.0)
            outside = tau;
        if (g.value - floor >= -0.25 * floor) {
            const double root = polish(&path, outside, tau);
            if (gap_at(&path, root).slope > 0.0)
                return root;
            /* a flight that began, within rounding, in a hollow of the gap on the ring is over */
            if (g.slope > 0.0 && g.bend > 0.0)
                return tau;
            /* a touch that rounding cannot tell from a miss: pass over its summit */
            step = 2.0 * sqrt(2.0 * floor / larger(fabs(g.bend), floor)) + ROUNDING * tau;
        } else {
            const double out = IS_WHOLE ? sprung_farthest(&path, tau) : plain_farthest(&path, tau);
            if ((out - delta0) * 2.0 * delta0 <= 0.5 * floor)
                return INFINITY;
            g.value -= floor;
            const double reach = smaller(4.0 * step, limit - tau);
            step = IS_WHOLE ? sprung_safe_step(&path, g, reach)
                            : plain_safe_step(&path, g, tau, reach);
        }
        const double next = tau + larger(step, ROUNDING * tau);
        if (!(next > tau))
            return NAN;
        tau = next;
    }
    return INFINITY;
}

/* ---- Where the radius turns ---- */

/* The root of the rate between `low`, where it has the sign `rising`, and `high`, where it has the
 * other: Newton's method in a bracket. */
static double turn_between(struct path *path, double low, double high, double rising)
{
    double point = 0.5 * (low + high);
    for (int i = 0; i < MOST_POLISHING; i++) {
        const struct turning here = turning_at(path, point);
        if (here.rate * rising > 0.0)
            low = point;
        else
            high = point;
        double new = here.bend != 0.0 ? point - here.rate / here.bend : low;
        if (!(low < new && new < high))
            new = 0.5 * (low + high);
        if (fabs(new - point) <= ROUNDING * high || high - low <= ROUNDING * high)
            return new;
        point = new;
    }
    return point;
}

/* The steps are as far as a bound on the rate of change of the bend guarantees that the rate either
 * keeps its sign or is monotonic: so no two extrema can hide between two steps, but for those whose
 * whole swing is rounding. */
double next_turn(struct motion_of_centre start, const struct rotor *rotor, double from,
                 double limit, double *rising, const stop_flag *stop)
{
    struct path path = path_from(start, rotor, limit);
    double low = from, tau = from, reach = path.longest;
    for (;;) {
        const struct turning here = turning_at(&path, tau);
        const double noise = IS_WHOLE ? sprung_noise(&path, tau) : plain_noise(&path, tau);
        if (fabs(here.rate) > noise) {
            if (here.rate * *rising < 0.0 && tau > from)
                return turn_between(&path, low, tau, *rising);
            if (*rising == 0.0 || tau > from)
                *rising = here.rate > 0.0 ? 1.0 : -1.0;
            low = tau;
        }
        if (tau >= limit || asked_to_stop(stop))
            return INFINITY;
        const double bound = IS_WHOLE ? sprung_bend_rate(&path, reach)
                                      : plain_bend_rate(&path, tau);
        const double towards = here.rate > 0.0 ? here.bend : -here.bend;
        const double clear = first_root_of_majorant(-fabs(here.rate), -towards, bound);
        const double least = sqrt(2.0 * noise / bound) + ROUNDING * tau;
        const double step = smaller(larger(larger(clear, fabs(here.bend) / bound), least), reach);
        const double next = tau + smaller(step, limit - tau);
        if (!(next > tau))
            return INFINITY;
        tau = next;
        reach = isinf(path.longest) ? path.longest : smaller(4.0 * step, path.longest);
    }
}
