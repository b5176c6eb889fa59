/* Part of flight.c: with a shaft and a load.
 *
 * Out of contact the rotor is linear. Measured from a moment at which displacement and velocity,
 * read on the rotating axes, are z0 and w0, and the load points along g, its motion on axes that
 * stand still from then on is
 *
 *     z = C z0 + S w0 + omega**2 P + gamma Q g,
 *
 * with S the answer to a unit impulse, C = S' + 2 zeta S to a unit displacement, Q = int S to a
 * unit step, and P to exp(i omega tau). Each is written so that nothing cancels: as kappa tends to
 * zeta**2 or to 0, near resonance, and where zeta, kappa or omega vanish.
 *
 * Inside the ring |z| is at most delta0, which bounds force, acceleration and jerk over a step,
 * whatever the rotor. */
#ifndef ROTOR_IDA_SPRUNG_FLIGHT_H
#define ROTOR_IDA_SPRUNG_FLIGHT_H

#include "path.h"

/* Two terms below this part of a sum end it. */
static const double NEGLIGIBLE = 1e-18;
enum { TERMS = 28, MOST_HALVINGS = 60 };

static struct vector complex_ratio(struct vector a, struct vector b)
{
    const struct vector whole = product(a, mirrored(b));
    return scaled(1.0 / (b.x * b.x + b.y * b.y), whole);
}

/* 1/n, by which the terms of a series are divided. */
static const double PART[TERMS] = {0.0,      1.0,      1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,
                                   1.0 / 6,  1.0 / 7,  1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11,
                                   1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15, 1.0 / 16, 1.0 / 17,
                                   1.0 / 18, 1.0 / 19, 1.0 / 20, 1.0 / 21, 1.0 / 22, 1.0 / 23,
                                   1.0 / 24, 1.0 / 25, 1.0 / 26, 1.0 / 27};

/* Q by its series about 0: of y'' + 2 zeta y' + kappa y = 1. */
static double step_by_series(const struct rotor *rotor, double tau)
{
    const double damping = 2.0 * rotor->zeta * tau, spring = rotor->shaft_stiffness * tau * tau;
    double before = 0.0, last = 0.5 * tau * tau, total = last;
    for (int n = 3; n < TERMS; n++) {
        const double next = -PART[n] * (damping * last + spring * PART[n - 1] * before);
        before = last;
        last = next;
        total += next;
        if (fabs(last) + fabs(before) < NEGLIGIBLE * total)
            break;
    }
    return total;
}

/* P by its series about 0: of y'' + 2 zeta y' + kappa y = exp(i omega tau). */
static struct vector answer_by_series(const struct rotor *rotor, double tau)
{
    const double damping = 2.0 * rotor->zeta * tau, spring = rotor->shaft_stiffness * tau * tau;
    const double angle = rotor->omega * tau, first = 0.5 * tau * tau;
    struct vector before = {0.0, 0.0}, last = {first, 0.0}, total = last;
    struct vector forcing = last; /* (i omega tau)**(n - 2) tau**2/n! */
    for (int n = 3; n < TERMS; n++) {
        const double by_rate = -damping * PART[n], by_place = -spring * PART[n] * PART[n - 1];
        forcing = scaled(angle * PART[n], quarter_turned(forcing));
        const struct vector next = plus(plus(scaled(by_rate, last), scaled(by_place, before)),
                                        forcing);
        before = last;
        last = next;
        total = plus(total, next);
        if (fabs(last.x) + fabs(last.y) + fabs(before.x) + fabs(before.y) < NEGLIGIBLE * first)
            break;
    }
    return total;
}

/* (1 - exp(-rate tau))/rate. */
static double settled(double rate, double tau)
{
    const double exponent = rate * tau;
    return exponent < 1e-300 ? tau : -expm1(-exponent) / rate;
}

static double step_answer(const struct rotor *rotor, double tau, double split, double c)
{
    const double zeta = rotor->zeta, kappa = rotor->shaft_stiffness;
    if (2.0 * kappa >= zeta * zeta)
        return (1.0 - c) / kappa;
    const double fast = zeta + split;
    return (settled(kappa / fast, tau) - settled(fast, tau)) / (2.0 * split);
}

/* The answer of y' + rate y to exp(i omega tau): (exp(i omega tau) - exp(-rate tau))/(rate + i
 * omega).
 */
static struct vector driven(struct vector rate, double omega, double tau)
{
    const struct vector apart = {rate.x, rate.y + omega},
                        spun = {cos(omega * tau), sin(omega * tau)};
    const double turn = apart.y * tau, half = sin(0.5 * turn), decay = exp(-apart.x * tau);
    if ((fabs(apart.x) + fabs(apart.y)) * tau < 1e-17)
        return scaled(tau, spun);
    const struct vector gone = {2.0 * decay * half * half - expm1(-apart.x * tau),
                                decay * sin(turn)};
    return product(spun, complex_ratio(gone, apart));
}

/* P by partial fractions of its poles -zeta +- split, or +- i split, which must lie apart. */
static struct vector answer_by_fractions(const struct rotor *rotor, double tau, double split,
                                         int vibrates, double slow)
{
    const struct vector first = {vibrates ? rotor->zeta : slow, vibrates ? -split : 0.0};
    const struct vector last = {vibrates ? rotor->zeta : rotor->zeta + split,
                                vibrates ? split : 0.0};
    const struct vector apart = plus(driven(first, rotor->omega, tau),
                                     scaled(-1.0, driven(last, rotor->omega, tau)));
    return scaled(0.5 / split, vibrates ? scaled(-1.0, quarter_turned(apart)) : apart);
}

/* The unbalance whirl over omega**2: 1/(kappa - omega**2 + 2 i zeta omega). */
static struct vector compliance(const struct rotor *rotor)
{
    const struct vector stiffness = {rotor->shaft_stiffness - rotor->omega * rotor->omega,
                                     2.0 * rotor->zeta * rotor->omega};
    return complex_ratio((struct vector){1.0, 0.0}, stiffness);
}

static struct answers sprung_answers(const struct rotor *rotor, double tau)
{
    const double zeta = rotor->zeta, kappa = rotor->shaft_stiffness, omega = rotor->omega;
    const double square = fma(zeta, zeta, -kappa), split = sqrt(fabs(square));
    const double fast = zeta + split, slow = fast > 0.0 ? kappa / fast : 0.0;
    const int vibrates = square < 0.0;
    struct answers found;
    if (vibrates) {
        const double decay = exp(-zeta * tau), cosine = cos(split * tau);
        const double sine = sin(split * tau) / split;
        found.s = decay * sine;
        found.c = decay * (cosine + zeta * sine);
        found.s_rate = decay * (cosine - zeta * sine);
    } else {
        found.s = exp(-slow * tau) * settled(2.0 * split, tau);
        found.c = exp(-slow * tau) + slow * found.s;
        found.s_rate = exp(-fast * tau) - slow * found.s;
    }
    found.c_rate = -kappa * found.s;
    found.turn = (struct vector){cos(omega * tau), sin(omega * tau)};
    const double free = larger(zeta, sqrt(kappa)) * tau, fastest = larger(free, omega * tau);
    /* the whirl and what is not settled of it cancel near resonance, and where both are slow */
    const int resonates = vibrates && split > 0.5 * omega && split < 2.0 * omega
                          && zeta < 0.25 * omega;
    const int creeps = !vibrates && larger(slow, omega) * tau < 0.5;
    found.q = 0.0;
    if (rotor->load > 0.0 || omega == 0.0)
        found.q = free <= 1.0 ? step_by_series(rotor, tau)
                              : step_answer(rotor, tau, split, found.c);
    if (omega == 0.0)
        found.p = (struct vector){found.q, 0.0};
    else if (fastest <= 1.0)
        found.p = answer_by_series(rotor, tau);
    else if (resonates || (free > 1.0 && creeps))
        found.p = answer_by_fractions(rotor, tau, split, vibrates, slow);
    else {
        const struct vector rest = {found.turn.x - found.c, found.turn.y - omega * found.s};
        found.p = product(compliance(rotor), rest);
    }
    found.p_rate = plus((struct vector){found.s, 0.0}, scaled(omega, quarter_turned(found.p)));
    return found;
}

static struct place place_after(const struct motion_of_centre *start, const struct rotor *rotor,
                                double tau)
{
    const struct answers by = sprung_answers(rotor, tau);
    const double push = rotor->omega * rotor->omega, load = rotor->load;
    struct place there = {.turn = by.turn};
    there.z = plus(plus(scaled(by.c, start->z), scaled(by.s, start->w)),
                   plus(scaled(push, by.p), scaled(load * by.q, start->down)));
    there.v = plus(plus(scaled(by.c_rate, start->z), scaled(by.s_rate, start->w)),
                   plus(scaled(push, by.p_rate), scaled(load * by.s, start->down)));
    there.b = plus(
        plus(scaled(push, by.turn), scaled(load, start->down)),
        plus(scaled(-2.0 * rotor->zeta, there.v), scaled(-rotor->shaft_stiffness, there.z)));
    return there;
}

static struct motion_of_centre sprung_fly(struct motion_of_centre start, double tau,
                                          const struct rotor *rotor)
{
    const struct place there = place_after(&start, rotor, tau);
    const struct vector back = mirrored(there.turn);
    return (struct motion_of_centre){.z = product(there.z, back),
                                     .w = product(there.v, back),
                                     .down = product(start.down, back)};
}

/* ---- What the search asks ---- */

/* The rate of the fastest motion that a flight inside the ring is capable of. */
static double rate_of(const struct rotor *rotor, double speed)
{
    const double force = rotor->omega * rotor->omega + rotor->load;
    return rotor->omega + 2.0 * rotor->zeta + sqrt(rotor->shaft_stiffness)
           + sqrt(force / rotor->delta0) + speed / rotor->delta0;
}

static struct path sprung_begin(struct motion_of_centre start, const struct rotor *rotor,
                                double limit)
{
    const double delta0 = rotor->delta0;
    const double whirl = rotor->omega * rotor->omega * length(compliance(rotor));
    return (struct path){
        .start = start,
        .rotor = rotor,
        .limit = limit,
        .floor = 64.0 * ROUNDING * delta0 * (delta0 + smaller(whirl, delta0 + 1.0)),
        .longest = 1.0 / rate_of(rotor, length(start.w)),
        .widest = length(start.z),
        .fastest = length(start.w),
    };
}

static struct gap sprung_gap(struct path *path, double tau)
{
    const struct place *at = &path->at;
    path->at = place_after(&path->start, path->rotor, tau);
    const double radius = length(at->z), delta0 = path->rotor->delta0;
    return (struct gap){(radius - delta0) * (radius + delta0), 2.0 * dot(at->z, at->v),
                        2.0 * (dot(at->v, at->v) + dot(at->z, at->b))};
}

static struct turning sprung_turning(struct path *path, double tau)
{
    const struct gap gap = sprung_gap(path, tau);
    return (struct turning){gap.slope, gap.bend};
}

/* A bound on |g'''| = |6 Re(conj(z') z'') + 2 Re(conj(z) z''')| from here over a time `reach`,
 * while the flight is inside the ring.
 *
 * With b the acceleration but for what the damping takes, |b| is at most `force`, and the speed
 * grows no faster. Over a short time the distance from the axis is bounded likewise. */
static double sprung_jerk_bound(const struct path *path, double reach)
{
    const struct rotor *rotor = path->rotor;
    const struct place *at = &path->at;
    const double omega = rotor->omega, damping = 2.0 * rotor->zeta;
    const double kappa = rotor->shaft_stiffness, push = omega * omega + rotor->load;
    const double radius = length(at->z), speed = length(at->v), part = kappa * reach * reach;
    double far = rotor->delta0;
    if (part < 0.5) {
        const double fastest = (speed + (push + kappa * radius) * reach) / (1.0 - part);
        far = smaller(radius + fastest * reach, far);
    }
    const double force = push + kappa * far;
    double fastest = speed + force * reach;
    if (damping > 0.0)
        fastest = smaller(fastest, larger(speed, force / damping));
    const double acceleration = force + damping * fastest;
    const double jerk = omega * omega * omega + damping * acceleration + kappa * fastest;
    return 6.0 * fastest * acceleration + 2.0 * far * jerk;
}

/* A step over which g stays below 0: its parabola, of curvature `bend` and the bound on what that
 * can grow to, allows it. */
static double sprung_safe_step(const struct path *path, struct gap g, double reach)
{
    for (int i = 0; i < MOST_HALVINGS; i++) {
        const double curvature = g.bend + sprung_jerk_bound(path, reach) * reach;
        const double allowed = first_root_of_majorant(g.value, g.slope, curvature);
        if (allowed >= reach)
            return reach;
        if (allowed >= 0.5 * reach)
            return allowed;
        reach *= 0.5;
    }
    return reach;
}

/* What a flight is made of: the whirl with the unbalance, and what is not yet settled about the
 * place at which the load holds the rotor. */
struct parts {
    double whirl;                 /* radius of the whirl; infinite where there is none */
    double rest;                  /* distance of that place from the axis */
    struct vector centre, moving; /* displacement and velocity without the whirl */
    struct vector off;            /* displacement without the whirl, from that place */
};

static struct parts parts_of(const struct path *path)
{
    const struct rotor *rotor = path->rotor;
    const struct place *at = &path->at;
    const double omega = rotor->omega, kappa = rotor->shaft_stiffness;
    struct parts found = {.whirl = 0.0, .rest = 0.0, .centre = at->z, .moving = at->v};
    if (omega > 0.0) {
        const struct vector whirl = product(scaled(omega * omega, compliance(rotor)), at->turn);
        found.whirl = isfinite(whirl.x + whirl.y) ? length(whirl) : INFINITY;
        found.centre = plus(at->z, scaled(-1.0, whirl));
        found.moving = plus(at->v, scaled(-omega, quarter_turned(whirl)));
    }
    found.off = found.centre;
    if (rotor->load > 0.0) {
        const struct vector rest = scaled(rotor->load / kappa, path->start.down);
        found.rest = kappa > 0.0 ? length(rest) : INFINITY;
        found.off = plus(found.centre, scaled(-1.0, rest));
    }
    return found;
}

/* Without shaft and load the whirl's centre drifts along a straight line, and is farthest out at an
 * end. With a shaft the energy of what is not yet settled only falls. */
static double sprung_farthest(const struct path *path, double tau)
{
    const struct rotor *rotor = path->rotor;
    const struct parts now = parts_of(path);
    const double kappa = rotor->shaft_stiffness;
    if (!isfinite(now.whirl + now.rest))
        return INFINITY;
    if (kappa == 0.0) {
        const double reach = settled(2.0 * rotor->zeta, path->limit - tau);
        const struct vector then = plus(now.centre, scaled(reach, now.moving));
        return now.whirl + larger(length(now.centre), length(then));
    }
    return now.whirl + now.rest + sqrt(dot(now.off, now.off) + dot(now.moving, now.moving) / kappa);
}

/* A bound on |g'''| over a step, as the unbalance whirl keeps its radius: of
 *
 *     2 Re(conj(c) e) + |c|**2,    e the whirl, c all else,
 *
 * by bounds on c and its derivatives. It falls as the motion settles; infinite where none is known.
 */
static double settling_bound(const struct path *path, double reach)
{
    const struct rotor *rotor = path->rotor;
    const struct parts now = parts_of(path);
    const double omega = rotor->omega, damping = 2.0 * rotor->zeta, kappa = rotor->shaft_stiffness;
    if (!isfinite(now.whirl + now.rest))
        return INFINITY;
    const double moving = length(now.moving);
    double place = length(now.centre) + moving * reach, first = moving;
    if (kappa > 0.0) {
        first = sqrt(dot(now.moving, now.moving) + kappa * dot(now.off, now.off));
        place = now.rest + first / sqrt(kappa);
    }
    const double second = (damping + sqrt(kappa)) * first;
    const double third = damping * second + kappa * first;
    const double with_whirl = third
                              + omega * (3.0 * second + omega * (3.0 * first + omega * place));
    return 2.0 * (now.whirl * with_whirl + 3.0 * first * second + place * third);
}

static double sprung_noise(struct path *path, double tau)
{
    const double fastest_turn = path->rotor->omega + sqrt(path->rotor->shaft_stiffness);
    path->widest = larger(path->widest, length(path->at.z));
    path->fastest = larger(path->fastest, length(path->at.v));
    return 32.0 * ROUNDING * (1.0 + fastest_turn * tau) * path->widest * path->fastest;
}

static double sprung_bend_rate(const struct path *path, double reach)
{
    return smaller(settling_bound(path, reach), sprung_jerk_bound(path, reach));
}

#endif
