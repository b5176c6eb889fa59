/* Flight of a machine with a shaft and a load: exact motion, and the first touch of the ring.
 *
 * Out of contact the machine is linear. Measured from a moment at which displacement and velocity,
 * read on the rotating axes, are z0 and w0, and the load points along g, its motion on axes that
 * stand still from then on is
 *
 *     z = C z0 + S w0 + omega**2 P + gamma Q g,
 *
 * with S the answer to a unit impulse, C = S' + 2 zeta S to a unit displacement, Q = int S to a
 * unit step, and P to exp(i omega tau). Each is written so that nothing cancels: as kappa tends to
 * zeta**2 or to 0, near resonance, and where zeta, kappa or omega vanish.
 *
 * The first touch is looked for as in flight.c. Inside the ring |z| is at most delta0, which bounds
 * force, acceleration and jerk over a step, whatever the machine. */
#if defined(WHOLE_MODEL) && !defined(RUN_UP)
#include "flight.h"

static const double NEVER = INFINITY;
/* Two terms below this part of a sum end it. */
static const double NEGLIGIBLE = 1e-18;
enum { TERMS = 28, MOST_POLISHING = 80, MOST_HALVINGS = 60 };

/* C, S, Q and P, and the rates of change of C, S and P; and exp(i omega tau). Q is looked at where
 * there is a load, or no spin. */
struct answers {
    double c, c_rate, s, s_rate, q;
    struct vector p, p_rate, turn;
};

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

static struct answers answers_after(const struct rotor *rotor, double tau)
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

/* Displacement, velocity and acceleration on axes that stand still. */
struct place {
    struct vector z, v, b;
    struct vector turn; /* of the unbalance since the start */
};

static struct place place_after(const struct motion_of_centre *start, const struct rotor *rotor,
                                double tau)
{
    const struct answers by = answers_after(rotor, tau);
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

struct motion_of_centre fly(struct motion_of_centre start, double tau, const struct rotor *rotor)
{
    const struct place there = place_after(&start, rotor, tau);
    const struct vector back = mirrored(there.turn);
    return (struct motion_of_centre){.z = product(there.z, back),
                                     .w = product(there.v, back),
                                     .down = product(start.down, back)};
}

void fly_differences(double *rows, int count, double tau, const struct rotor *rotor)
{
    const struct answers by = answers_after(rotor, tau);
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

/* g = |z|**2 - delta0**2 and its first two derivatives. */
struct gap {
    double value, slope, bend;
};

static struct gap gap_of(const struct place *at, double delta0)
{
    const double radius = length(at->z);
    return (struct gap){(radius - delta0) * (radius + delta0), 2.0 * dot(at->z, at->v),
                        2.0 * (dot(at->v, at->v) + dot(at->z, at->b))};
}

/* A bound on |g'''| = |6 Re(conj(z') z'') + 2 Re(conj(z) z''')| from here over a time `reach`,
 * while the flight is inside the ring.
 *
 * With b the acceleration but for what the damping takes, |b| is at most `force`, and the speed
 * grows no faster. Over a short time the distance from the axis is bounded likewise. */
static double jerk_bound(const struct rotor *rotor, const struct place *at, double reach)
{
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

/* A step over which g stays below 0: its parabola, of curvature `bend` and the bound on what that
 * can grow to, allows it. */
static double safe_step(struct gap g, const struct rotor *rotor, const struct place *at,
                        double reach)
{
    for (int i = 0; i < MOST_HALVINGS; i++) {
        const double curvature = g.bend + jerk_bound(rotor, at, reach) * reach;
        const double allowed = first_root_of_majorant(g.value, g.slope, curvature);
        if (allowed >= reach)
            return reach;
        if (allowed >= 0.5 * reach)
            return allowed;
        reach *= 0.5;
    }
    return reach;
}

/* The root of g between `low` (g <= 0) and `high` (g > 0): Newton's method in a bracket. */
static double polish(const struct motion_of_centre *start, const struct rotor *rotor, double low,
                     double high)
{
    double tau = high;
    for (int i = 0; i < MOST_POLISHING; i++) {
        const struct place at = place_after(start, rotor, tau);
        const struct gap g = gap_of(&at, rotor->delta0);
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

/* What a flight is made of: the whirl with the unbalance, and what is not yet settled about the
 * place at which the load holds the rotor. */
struct parts {
    double whirl;                 /* radius of the whirl; infinite where there is none */
    double rest;                  /* distance of that place from the axis */
    struct vector centre, moving; /* displacement and velocity without the whirl */
    struct vector off;            /* displacement without the whirl, from that place */
};

static struct parts parts_of(const struct motion_of_centre *start, const struct rotor *rotor,
                             const struct place *at)
{
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
        const struct vector rest = scaled(rotor->load / kappa, start->down);
        found.rest = kappa > 0.0 ? length(rest) : INFINITY;
        found.off = plus(found.centre, scaled(-1.0, rest));
    }
    return found;
}

/* How far from the axis the flight can come at most from now on; infinite where that is not known.
 *
 * Without shaft and load the whirl's centre drifts along a straight line, and is farthest out at an
 * end. With a shaft the energy of what is not yet settled only falls. */
static double farthest(const struct motion_of_centre *start, const struct rotor *rotor,
                       const struct place *at, double tau, double limit)
{
    const struct parts now = parts_of(start, rotor, at);
    const double kappa = rotor->shaft_stiffness;
    if (!isfinite(now.whirl + now.rest))
        return INFINITY;
    if (kappa == 0.0) {
        const double reach = settled(2.0 * rotor->zeta, limit - tau);
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
static double settling_bound(const struct motion_of_centre *start, const struct rotor *rotor,
                             const struct place *at, double reach)
{
    const struct parts now = parts_of(start, rotor, at);
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

/* The rate of the fastest motion that a flight inside the ring is capable of. */
static double rate_of(const struct rotor *rotor, double speed)
{
    const double force = rotor->omega * rotor->omega + rotor->load;
    return rotor->omega + 2.0 * rotor->zeta + sqrt(rotor->shaft_stiffness)
           + sqrt(force / rotor->delta0) + speed / rotor->delta0;
}

double first_touch(struct motion_of_centre start, const struct rotor *rotor, double limit,
                   const uint8_t *stop)
{
    const double delta0 = rotor->delta0;
    const double whirl = rotor->omega * rotor->omega * length(compliance(rotor));
    /* the smallest |z|**2 - delta0**2 that stands clear of rounding */
    const double floor = 64.0 * ROUNDING * delta0 * (delta0 + smaller(whirl, delta0 + 1.0));
    double tau = 0.0, outside = 0.0, step = 1.0 / rate_of(rotor, length(start.w));
    while (tau < limit && !asked_to_stop(stop)) {
        const struct place at = place_after(&start, rotor, tau);
        struct gap g = gap_of(&at, delta0);
        if (g.value <= 0.0)
            outside = tau;
        if (g.value - floor >= -0.25 * floor) {
            const double root = polish(&start, rotor, outside, tau);
            const struct place there = place_after(&start, rotor, root);
            if (gap_of(&there, delta0).slope > 0.0)
                return root;
            /* a flight that began, within rounding, in a hollow of the gap on the ring is over */
            if (g.slope > 0.0 && g.bend > 0.0)
                return tau;
            /* a touch that rounding cannot tell from a miss: pass over its summit */
            step = 2.0 * sqrt(2.0 * floor / larger(fabs(g.bend), floor)) + ROUNDING * tau;
        } else {
            const double reach = farthest(&start, rotor, &at, tau, limit);
            if ((reach - delta0) * 2.0 * delta0 <= 0.5 * floor)
                return NEVER;
            g.value -= floor;
            step = safe_step(g, rotor, &at, smaller(4.0 * step, limit - tau));
        }
        const double next = tau + larger(step, ROUNDING * tau);
        if (!(next > tau))
            return NAN;
        tau = next;
    }
    return NEVER;
}

/* ---- Where the radius turns ---- */

/* The root of r r' between `low`, where it has the sign `rising`, and `high`, where it has the
 * other. */
static double turn_between(const struct motion_of_centre *start, const struct rotor *rotor,
                           double low, double high, double rising)
{
    double point = 0.5 * (low + high);
    for (int i = 0; i < MOST_POLISHING; i++) {
        const struct place at = place_after(start, rotor, point);
        const struct gap here = gap_of(&at, rotor->delta0);
        if (here.slope * rising > 0.0)
            low = point;
        else
            high = point;
        double new = here.bend != 0.0 ? point - here.slope / here.bend : low;
        if (!(low < new && new < high))
            new = 0.5 * (low + high);
        if (fabs(new - point) <= ROUNDING * high || high - low <= ROUNDING * high)
            return new;
        point = new;
    }
    return point;
}

/* The steps are as far as a bound on the rate of change of the bend guarantees that r r' either
 * keeps its sign or is monotonic, as in flight.c. */
double next_turn(struct motion_of_centre start, const struct rotor *rotor, double from,
                 double limit, double *rising, const uint8_t *stop)
{
    const double fastest_turn = rotor->omega + sqrt(rotor->shaft_stiffness);
    const double farthest_step = 1.0 / rate_of(rotor, length(start.w));
    double low = from, tau = from, reach = farthest_step;
    double widest = length(start.z), fastest = length(start.w);
    for (;;) {
        const struct place at = place_after(&start, rotor, tau);
        const struct gap here = gap_of(&at, rotor->delta0);
        widest = larger(widest, length(at.z));
        fastest = larger(fastest, length(at.v));
        const double noise = 32.0 * ROUNDING * (1.0 + fastest_turn * tau) * widest * fastest;
        if (fabs(here.slope) > noise) {
            if (here.slope * *rising < 0.0 && tau > from)
                return turn_between(&start, rotor, low, tau, *rising);
            if (*rising == 0.0 || tau > from)
                *rising = here.slope > 0.0 ? 1.0 : -1.0;
            low = tau;
        }
        if (tau >= limit || asked_to_stop(stop))
            return NEVER;
        const double bound = smaller(settling_bound(&start, rotor, &at, reach),
                                     jerk_bound(rotor, &at, reach));
        const double towards = here.slope > 0.0 ? here.bend : -here.bend;
        const double clear = first_root_of_majorant(-fabs(here.slope), -towards, bound);
        const double least = sqrt(2.0 * noise / bound) + ROUNDING * tau;
        const double step = smaller(larger(larger(clear, fabs(here.bend) / bound), least), reach);
        const double next = tau + smaller(step, limit - tau);
        if (!(next > tau))
            return NEVER;
        tau = next;
        reach = smaller(4.0 * step, farthest_step);
    }
}

#endif
