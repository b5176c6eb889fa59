/* Flight inside the clearance: exact motion, and the first touch of the ring.
 *
 * Out of contact the rotor is linear. Measured from a moment at which displacement and velocity,
 * read on the rotating axes, are z0 and w0, its motion on axes that stand still from then on is
 *
 *     z(tau) = z0 + w phi(tau) + a (exp(i omega tau) - 1),  phi = (1 - exp(-2 zeta tau))/(2 zeta),
 *
 * with a = -omega/(omega - 2 i zeta) and w = w0 - i omega a: a whirl of radius |a| about a centre
 * that drifts along a straight line. phi tends to tau as zeta tends to 0.
 *
 * The first touch is the first root of g = |z|**2 - delta0**2. The search steps only as far as a
 * bound on g''' guarantees that g has no root, so no touch can hide between two steps. */
#ifndef WHOLE_MODEL
#include "flight.h"

static const double NEVER = INFINITY;

/* The amplitude a of the contact-free whirl on the rotating axes. */
static struct vector unbalance_whirl(const struct rotor *rotor)
{
    const double omega = rotor->omega, damping = 2.0 * rotor->zeta;
    if (omega == 0.0)
        return (struct vector){0.0, 0.0};
    const double square = omega * omega + damping * damping;
    return (struct vector){-omega * omega / square, -omega * damping / square};
}

/* phi(tau), without cancellation. */
static double drift(double tau, double zeta)
{
    const double exponent = 2.0 * zeta * tau;
    return exponent < 1e-300 ? tau : -expm1(-exponent) / (2.0 * zeta);
}

static struct vector turn_by(double angle) { return (struct vector){cos(angle), sin(angle)}; }

/* exp(i angle) - 1, without cancellation. */
static struct vector turn_less_one(double angle)
{
    const double half = sin(0.5 * angle);
    return (struct vector){-2.0 * half * half, sin(angle)};
}

/* w = w0 - i omega a. */
static struct vector drift_velocity(struct vector w0, struct vector a, double omega)
{
    return (struct vector){w0.x + omega * a.y, w0.y - omega * a.x};
}

struct motion_of_centre fly(struct motion_of_centre start, double tau, const struct rotor *rotor)
{
    const double omega = rotor->omega, angle = omega * tau;
    const struct vector a = unbalance_whirl(rotor), w = drift_velocity(start.w, a, omega);
    const struct vector turn = turn_by(angle), back = mirrored(turn);
    const struct vector moved = plus(scaled(drift(tau, rotor->zeta), w),
                                     product(a, turn_less_one(angle)));
    const struct vector spun = scaled(omega, quarter_turned(product(a, turn)));
    const struct vector velocity = plus(scaled(exp(-2.0 * rotor->zeta * tau), w), spun);
    return (struct motion_of_centre){.z = product(plus(start.z, moved), back),
                                     .w = product(velocity, back)};
}

/* The derivative of phi by zeta, without cancellation. */
static double drift_by_zeta(double tau, double zeta)
{
    const double x = 2.0 * zeta * tau;
    if (x > 0.1)
        return -2.0 * tau * tau * (1.0 - exp(-x) * (1.0 + x)) / (x * x);
    /* (1 - (1 + x) exp(-x))/x**2 is the sum over n of (-x)**n (n + 1)/(n + 2)! */
    double total = 0.0, power = 0.5;
    for (int n = 1; n < 12; n++) {
        total += power * n;
        power *= -x / (n + 2.0);
    }
    return -2.0 * tau * tau * total;
}

void fly_by_parameters(struct motion_of_centre start, double tau, const struct rotor *rotor,
                       struct motion_of_centre added[2])
{
    const double omega = rotor->omega, zeta = rotor->zeta, angle = omega * tau;
    struct vector a = {0.0, 0.0}, a_omega = a, a_zeta = a;
    if (omega > 0.0 || zeta > 0.0) {
        /* by the pole omega - 2 i zeta: da/domega = 2 i zeta/pole**2, da/dzeta = -2 i omega/... */
        const double square = omega * omega + 4.0 * zeta * zeta;
        const struct vector unit = {omega / square, 2.0 * zeta / square};
        const struct vector over_square = product(unit, unit);
        a = scaled(-omega, unit);
        a_omega = scaled(2.0 * zeta, quarter_turned(over_square));
        a_zeta = scaled(-2.0 * omega, quarter_turned(over_square));
    }
    const struct vector w = drift_velocity(start.w, a, omega);
    const struct vector w_omega = scaled(-1.0, quarter_turned(plus(a, scaled(omega, a_omega))));
    const struct vector w_zeta = scaled(-omega, quarter_turned(a_zeta));
    const double reach = drift(tau, zeta), decay = exp(-2.0 * zeta * tau);
    const struct vector turn = turn_by(angle), less_one = turn_less_one(angle);
    const struct vector spin = scaled(omega, quarter_turned(turn)), back = mirrored(turn);
    const struct vector position = plus(start.z, plus(scaled(reach, w), product(a, less_one)));
    const struct vector velocity = plus(scaled(decay, w), product(a, spin));
    const struct vector turned = quarter_turned(plus(product(a, turn), scaled(-1.0, position)));
    const struct vector spun = quarter_turned(plus(product(a, spin), scaled(-1.0, velocity)));
    const struct vector slowed = {decay - turn.x, -turn.y};
    const struct vector z_omega = plus(plus(scaled(reach, w_omega), product(a_omega, less_one)),
                                       scaled(tau, turned));
    const struct vector v_omega = plus(product(w_omega, slowed), scaled(tau, spun));
    const struct vector z_zeta = plus(
        plus(scaled(reach, w_zeta), scaled(drift_by_zeta(tau, zeta), w)),
        product(a_zeta, less_one));
    const struct vector v_zeta = plus(plus(scaled(decay, w_zeta), scaled(-2.0 * tau * decay, w)),
                                      product(a_zeta, spin));
    added[0] = (struct motion_of_centre){.z = product(z_omega, back), .w = product(v_omega, back)};
    added[1] = (struct motion_of_centre){.z = product(z_zeta, back), .w = product(v_zeta, back)};
}

void fly_differences(double *rows, int count, double tau, const struct rotor *rotor)
{
    const double reach = drift(tau, rotor->zeta), decay = exp(-2.0 * rotor->zeta * tau);
    const struct vector back = mirrored(turn_by(rotor->omega * tau));
    for (double *row = rows; row < rows + 4 * count; row += 4) {
        const struct vector z = {row[0], row[1]}, w = {row[2], row[3]};
        const struct vector there = product(plus(z, scaled(reach, w)), back);
        const struct vector then = product(scaled(decay, w), back);
        row[0] = there.x;
        row[1] = there.y;
        row[2] = then.x;
        row[3] = then.y;
    }
}

/* A flight, as the search for its first touch needs it. */
struct search {
    struct vector z0, a, w;
    double omega, zeta, delta0;
};

/* g and its first two derivatives. */
struct gap {
    double value, slope, bend;
};

static struct gap gap_at(const struct search *flight, double tau)
{
    const double omega = flight->omega, angle = omega * tau;
    const struct vector a = flight->a, w = flight->w, turned = product(a, turn_by(angle));
    const double decay = exp(-2.0 * flight->zeta * tau);
    const struct vector z = plus(plus(flight->z0, scaled(drift(tau, flight->zeta), w)),
                                 product(a, turn_less_one(angle)));
    const struct vector v = plus(scaled(decay, w), scaled(omega, quarter_turned(turned)));
    const struct vector b = plus(scaled(-2.0 * flight->zeta * decay, w),
                                 scaled(-omega * omega, turned));
    const double radius = length(z);
    return (struct gap){(radius - flight->delta0) * (radius + flight->delta0), 2.0 * dot(z, v),
                        2.0 * (dot(v, v) + dot(z, b))};
}

/* The first s > 0 with value + slope s + curvature s**2/2 = 0, value < 0. */
static double first_root_of_majorant(double value, double slope, double curvature)
{
    const double discriminant = slope * slope - 2.0 * curvature * value;
    if (discriminant < 0.0)
        return NEVER;
    const double root = sqrt(discriminant);
    if (slope >= 0.0)
        return slope + root > 0.0 ? -2.0 * value / (slope + root) : NEVER;
    return curvature > 0.0 ? (root - slope) / curvature : NEVER;
}

/* A step over which a function with this Taylor start and |g'''| < jerk stays below 0.
 *
 * On [0, L] it lies below the parabola of curvature `bend + jerk L`; the step is the largest L, to
 * a few bisections, that its parabola allows. */
static double safe_step(struct gap g, double jerk, double reach)
{
    const double first = first_root_of_majorant(g.value, g.slope, g.bend + jerk * reach);
    if (first >= reach)
        return reach;
    double low = first, high = reach;
    for (int i = 0; i < 6; i++) {
        const double middle = high < 4.0 * low ? 0.5 * (low + high) : sqrt(low * high);
        const double allowed = first_root_of_majorant(g.value, g.slope, g.bend + jerk * middle);
        if (allowed >= middle) {
            low = middle;
        } else {
            high = middle;
            low = larger(allowed, low);
        }
    }
    return low;
}

/* A bound on |g'''| = |6 Re(conj(z') z'') + 2 Re(conj(z) z''')| from `tau` to the touch. */
static double jerk_bound(const struct search *flight, double tau)
{
    const double omega = flight->omega, zeta = flight->zeta, a = length(flight->a);
    const double decayed = length(flight->w) * exp(-2.0 * zeta * tau);
    const double speed = decayed + omega * a;
    const double acceleration = 2.0 * zeta * decayed + omega * omega * a;
    const double jerk = 4.0 * zeta * zeta * decayed + omega * omega * omega * a;
    return 6.0 * speed * acceleration + 2.0 * flight->delta0 * jerk;
}

/* The root of g between `low` (g <= 0) and `high` (g > 0): Newton's method in a bracket. */
static double polish(const struct search *flight, double low, double high)
{
    double tau = high;
    for (int i = 0; i < 80; i++) {
        const struct gap g = gap_at(flight, tau);
        if (g.value > 0.0)
            high = tau;
        else
            low = tau;
        double new = tau - (g.slope > 0.0 ? g.value / g.slope : NEVER);
        if (!(low < new && new < high))
            new = 0.5 * (low + high);
        if (fabs(new - tau) <= ROUNDING * tau || high - low <= ROUNDING * high)
            return new;
        tau = new;
    }
    return tau;
}

/* The distance of the whirl's centre from the bearing axis. */
static double centre_at(const struct search *flight, double tau)
{
    const struct vector centre = plus(flight->z0, scaled(-1.0, flight->a));
    return length(plus(centre, scaled(drift(tau, flight->zeta), flight->w)));
}

double first_touch(struct motion_of_centre start, const struct rotor *rotor, double limit,
                   const uint8_t *stop)
{
    const struct vector a = unbalance_whirl(rotor);
    const struct search flight = {
        start.z,      a,           drift_velocity(start.w, a, rotor->omega),
        rotor->omega, rotor->zeta, rotor->delta0};
    const double delta0 = rotor->delta0, radius = length(a);
    /* the smallest |z|**2 - delta0**2 that stands clear of rounding */
    const double floor = 64.0 * ROUNDING * delta0 * (delta0 + radius);
    const double last_centre = centre_at(&flight, limit);
    double tau = 0.0, outside = 0.0, step = limit;
    while (tau < limit && !asked_to_stop(stop)) {
        struct gap g = gap_at(&flight, tau);
        if (g.value <= 0.0)
            outside = tau;
        if (g.value - floor >= -0.25 * floor) {
            const double root = polish(&flight, outside, tau);
            if (gap_at(&flight, root).slope > 0.0)
                return root;
            /* a flight that began, within rounding, in a hollow of the gap on the ring is over */
            if (g.slope > 0.0 && g.bend > 0.0)
                return tau;
            /* a touch that rounding cannot tell from a miss: pass over its summit */
            step = 2.0 * sqrt(2.0 * floor / larger(fabs(g.bend), floor)) + ROUNDING * tau;
        } else {
            /* the centre drifts along a straight line, so it is farthest out at an end */
            const double centre = larger(centre_at(&flight, tau), last_centre);
            if ((centre + radius - delta0) * 2.0 * delta0 <= 0.5 * floor)
                return NEVER;
            g.value -= floor;
            step = safe_step(g, jerk_bound(&flight, tau), smaller(4.0 * step, limit - tau));
        }
        const double next = tau + larger(step, ROUNDING * tau);
        if (!(next > tau))
            return NAN;
        tau = next;
    }
    return NEVER;
}

/* ---- Where the radius turns ---- */

/* r r' and its rate of change.
 *
 * The disc's centre is at c + e, of which c drifts and e = a exp(i omega tau) whirls at a constant
 * radius; |c + e|**2/2 is taken without the constant |e|**2/2, so that a whirl about a centre near
 * the axis keeps its digits. */
struct turning {
    double rate, bend;
};

static struct turning turning_at(const struct search *flight, double tau)
{
    const double omega = flight->omega, damping = 2.0 * flight->zeta;
    const struct vector e = product(flight->a, turn_by(omega * tau));
    const struct vector spun = scaled(omega, quarter_turned(e));
    const struct vector centre = plus(flight->z0, scaled(-1.0, flight->a));
    const struct vector c = plus(centre, scaled(drift(tau, flight->zeta), flight->w));
    const struct vector moving = scaled(exp(-damping * tau), flight->w);
    const struct vector whirling = plus(c, e), slowing = scaled(-damping, moving);
    return (struct turning){dot(whirling, moving) + dot(c, spun),
                            dot(moving, moving) + dot(whirling, slowing) + 2.0 * dot(moving, spun)
                                - omega * omega * dot(c, e)};
}

/* A bound on the rate of change of the bend from `tau` to `limit`: of
 *
 *     -6 zeta |c'|**2 + 4 zeta**2 Re(conj(c) c')
 *     + Re[(4 zeta**2 - 6 i zeta omega - 3 omega**2) conj(c') e - i omega**3 conj(c) e]. */
static double bend_rate_bound(const struct search *flight, double tau, double limit)
{
    const double omega = flight->omega, zeta = flight->zeta, a = length(flight->a);
    const double moving = length(flight->w) * exp(-2.0 * zeta * tau);
    const double centre = larger(centre_at(flight, tau), centre_at(flight, limit));
    const double by_moving = 4.0 * zeta * zeta + 6.0 * zeta * omega + 3.0 * omega * omega;
    return 6.0 * zeta * moving * moving + 4.0 * zeta * zeta * centre * moving
           + a * (by_moving * moving + omega * omega * omega * centre);
}

/* The root of the rate between `low`, where it has the sign `rising`, and `high`, where it has the
 * other: Newton's method in a bracket. */
static double turn_between(const struct search *flight, double low, double high, double rising)
{
    double point = 0.5 * (low + high);
    for (int i = 0; i < 80; i++) {
        const struct turning here = turning_at(flight, point);
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
                 double limit, double *rising, const uint8_t *stop)
{
    const struct vector a = unbalance_whirl(rotor);
    const struct search flight = {
        start.z,      a,           drift_velocity(start.w, a, rotor->omega),
        rotor->omega, rotor->zeta, rotor->delta0};
    const double reach = length(start.z) + 2.0 * length(a);
    double low = from, tau = from;
    for (;;) {
        const struct turning here = turning_at(&flight, tau);
        const double moving = length(flight.w) * exp(-2.0 * rotor->zeta * tau);
        const double noise = 8.0 * ROUNDING * (reach + length(flight.w) * tau)
                             * (moving + rotor->omega * length(a));
        if (fabs(here.rate) > noise) {
            if (here.rate * *rising < 0.0 && tau > from)
                return turn_between(&flight, low, tau, *rising);
            if (*rising == 0.0 || tau > from)
                *rising = here.rate > 0.0 ? 1.0 : -1.0;
            low = tau;
        }
        if (tau >= limit || asked_to_stop(stop))
            return NEVER;
        const double bound = bend_rate_bound(&flight, tau, limit);
        const double towards = here.rate > 0.0 ? here.bend : -here.bend;
        const double clear = first_root_of_majorant(-fabs(here.rate), -towards, bound);
        const double least = sqrt(2.0 * noise / bound) + ROUNDING * tau;
        const double step = larger(larger(clear, fabs(here.bend) / bound), least);
        const double next = tau + smaller(step, limit - tau);
        if (!(next > tau))
            return NEVER;
        tau = next;
    }
}

#endif
