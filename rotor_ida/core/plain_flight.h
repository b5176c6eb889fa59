/* Part of flight.c: without shaft and load.
 *
 * Out of contact the rotor is linear. Measured from a moment at which displacement and velocity,
 * read on the rotating axes, are z0 and w0, its motion on axes that stand still from then on is
 *
 *     z(tau) = z0 + w phi(tau) + a (exp(i omega tau) - 1),  phi = (1 - exp(-2 zeta tau))/(2 zeta),
 *
 * with a = -omega/(omega - 2 i zeta) and w = w0 - i omega a: a whirl of radius |a| about a centre
 * that drifts along a straight line. phi tends to tau as zeta tends to 0. */
#ifndef ROTOR_IDA_PLAIN_FLIGHT_H
#define ROTOR_IDA_PLAIN_FLIGHT_H

#include "path.h"

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

static struct motion_of_centre plain_fly(struct motion_of_centre start, double tau,
                                         const struct rotor *rotor)
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

static struct answers plain_answers(const struct rotor *rotor, double tau)
{
    return (struct answers){.c = 1.0,
                            .s = drift(tau, rotor->zeta),
                            .s_rate = exp(-2.0 * rotor->zeta * tau),
                            .turn = turn_by(rotor->omega * tau)};
}

/* ---- What the search asks ---- */

/* The distance of the whirl's centre from the bearing axis. */
static double centre_at(const struct path *path, double tau)
{
    const struct vector centre = plus(path->start.z, scaled(-1.0, path->whirl));
    return length(plus(centre, scaled(drift(tau, path->rotor->zeta), path->drift)));
}

static struct path plain_begin(struct motion_of_centre start, const struct rotor *rotor,
                               double limit)
{
    const struct vector a = unbalance_whirl(rotor);
    struct path path = {.start = start,
                        .rotor = rotor,
                        .limit = limit,
                        .floor = 64.0 * ROUNDING * rotor->delta0 * (rotor->delta0 + length(a)),
                        .longest = INFINITY,
                        .widest = length(start.z) + 2.0 * length(a),
                        .whirl = a,
                        .drift = drift_velocity(start.w, a, rotor->omega)};
    path.last_centre = centre_at(&path, limit);
    return path;
}

static struct gap plain_gap(struct path *path, double tau)
{
    const double omega = path->rotor->omega, zeta = path->rotor->zeta, angle = omega * tau;
    const struct vector a = path->whirl, w = path->drift, turned = product(a, turn_by(angle));
    const double decay = exp(-2.0 * zeta * tau);
    const struct vector z = plus(plus(path->start.z, scaled(drift(tau, zeta), w)),
                                 product(a, turn_less_one(angle)));
    const struct vector v = plus(scaled(decay, w), scaled(omega, quarter_turned(turned)));
    const struct vector b = plus(scaled(-2.0 * zeta * decay, w), scaled(-omega * omega, turned));
    const double radius = length(z);
    return (struct gap){(radius - path->rotor->delta0) * (radius + path->rotor->delta0),
                        2.0 * dot(z, v), 2.0 * (dot(v, v) + dot(z, b))};
}

/* A bound on |g'''| = |6 Re(conj(z') z'') + 2 Re(conj(z) z''')| from `tau` to the touch. */
static double plain_jerk_bound(const struct path *path, double tau)
{
    const double omega = path->rotor->omega, zeta = path->rotor->zeta, a = length(path->whirl);
    const double decayed = length(path->drift) * exp(-2.0 * zeta * tau);
    const double speed = decayed + omega * a;
    const double acceleration = 2.0 * zeta * decayed + omega * omega * a;
    const double jerk = 4.0 * zeta * zeta * decayed + omega * omega * omega * a;
    return 6.0 * speed * acceleration + 2.0 * path->rotor->delta0 * jerk;
}

/* A step over which a function with this Taylor start and |g'''| < jerk stays below 0.
 *
 * On [0, L] it lies below the parabola of curvature `bend + jerk L`; the step is the largest L, to
 * a few bisections, that its parabola allows. */
static double plain_safe_step(const struct path *path, struct gap g, double tau, double reach)
{
    const double jerk = plain_jerk_bound(path, tau);
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

/* The centre drifts along a straight line, so it is farthest out at an end. */
static double plain_farthest(const struct path *path, double tau)
{
    return larger(centre_at(path, tau), path->last_centre) + length(path->whirl);
}

/* r r' and its rate of change.
 *
 * The disc's centre is at c + e, of which c drifts and e = a exp(i omega tau) whirls at a constant
 * radius; |c + e|**2/2 is taken without the constant |e|**2/2, so that a whirl about a centre near
 * the axis keeps its digits. */
static struct turning plain_turning(struct path *path, double tau)
{
    const double omega = path->rotor->omega, damping = 2.0 * path->rotor->zeta;
    const struct vector e = product(path->whirl, turn_by(omega * tau));
    const struct vector spun = scaled(omega, quarter_turned(e));
    const struct vector centre = plus(path->start.z, scaled(-1.0, path->whirl));
    const struct vector c = plus(centre, scaled(drift(tau, path->rotor->zeta), path->drift));
    const struct vector moving = scaled(exp(-damping * tau), path->drift);
    const struct vector whirling = plus(c, e), slowing = scaled(-damping, moving);
    return (struct turning){dot(whirling, moving) + dot(c, spun),
                            dot(moving, moving) + dot(whirling, slowing) + 2.0 * dot(moving, spun)
                                - omega * omega * dot(c, e)};
}

/* A bound on the rate of change of the bend from now to the limit: of
 *
 *     -6 zeta |c'|**2 + 4 zeta**2 Re(conj(c) c')
 *     + Re[(4 zeta**2 - 6 i zeta omega - 3 omega**2) conj(c') e - i omega**3 conj(c) e]. */
static double plain_bend_rate(const struct path *path, double tau)
{
    const double omega = path->rotor->omega, zeta = path->rotor->zeta, a = length(path->whirl);
    const double moving = length(path->drift) * exp(-2.0 * zeta * tau);
    const double centre = larger(centre_at(path, tau), path->last_centre);
    const double by_moving = 4.0 * zeta * zeta + 6.0 * zeta * omega + 3.0 * omega * omega;
    return 6.0 * zeta * moving * moving + 4.0 * zeta * zeta * centre * moving
           + a * (by_moving * moving + omega * omega * omega * centre);
}

static double plain_noise(const struct path *path, double tau)
{
    const double moving = length(path->drift) * exp(-2.0 * path->rotor->zeta * tau);
    return 8.0 * ROUNDING * (path->widest + length(path->drift) * tau)
           * (moving + path->rotor->omega * length(path->whirl));
}

#endif
