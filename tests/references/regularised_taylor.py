"""Flight in closed form, contact by Taylor series in regularised variables.

With q = sqrt(|z| - delta0) and dt = q du the contact is analytic through entry and exit:

    q_u = Re(z conj v) / (2 |z|),  z_u = q v,  t_u = q,  e_u = i omega q e,
    v_u = q (-2 zeta v - q^3 z/|z| + omega^2 e),  |z| = delta0 + q^2,  e = exp(i omega t).

The coefficients follow from recurrences in ball arithmetic, and each step is as long as their
decay allows. The exit is the first root of the series of q, found with proof.
"""

from dataclasses import dataclass
from math import exp, log
from operator import mul

from flint import acb, arb, arb_poly, arb_series, ctx

from .first_root import first_root
from .motion import Instant, UnresolvedError, dot, gap_derivatives, leading_order, phasor, start_of


@dataclass(frozen=True)
class Accuracy:
    """Bits of every number, terms of every series, and the size of the first term left out."""

    bits: int = 240
    order: int = 48
    tolerance: float = 1e-44


FULL = Accuracy()
OTHER = Accuracy(bits=200, order=36, tolerance=1e-36)
COARSE = Accuracy(bits=170, order=32, tolerance=1e-30)


def events(case, accuracy=FULL, shift=(0, 0, 0, 0)):
    """Return whether the run starts in contact, its events as (kind, time), and depths.

    The depths are the greatest indentations of the contacts that end within the run.
    """
    ctx.prec = accuracy.bits
    now, found, depths, end = start_of(case, shift), [], [], arb(case.duration)
    derivatives = gap_derivatives(case, now)
    leading = leading_order(derivatives)
    if leading is None:
        return False, [], []
    in_contact = starts_in_contact = bool(derivatives[leading] > 0)
    if in_contact and leading > 2:
        raise UnresolvedError("a start that leaves the ring with its third derivative")
    tangential = in_contact and leading == 2
    while True:
        if in_contact:
            now = contact(case, now, end, accuracy, tangential=tangential)
        else:
            now = flight(case, now, end)
        if now is None:
            return starts_in_contact, found, depths
        found.append((-1 if in_contact else 1, now.time))
        if in_contact:
            depths.append(now.depth)
        in_contact, tangential = not in_contact, False


def flight(case, now, end):
    """Return the entry that ends a flight, or None where there is none until the end.

    z = c + d (1 - exp(-2 zeta s))/(2 zeta) + a exp(i omega s), s the time since now; the fraction
    is s at zeta = 0.
    """
    omega, damping, turn = arb(case.omega), 2 * arb(case.zeta), acb(0, arb(case.omega))
    whirl = acb(0)
    if case.omega:
        whirl = -omega / acb(omega, -damping) * phasor(case, now.time)
    glide = now.v - turn * whirl
    centre = now.z - whirl

    def motion(order, s):
        """Derivatives 0 to `order` of z at s."""
        sine, cosine = (omega * s).sin_cos()
        turning = whirl * acb(cosine, sine)
        gliding = glide * (-damping * s).exp()
        way = -(-damping * s).expm1() / damping if case.zeta else s
        drift = [centre + glide * way] + [gliding * (-damping) ** n for n in range(order)]
        return [turning * turn**n + drift[n] for n in range(order + 1)]

    radius2 = arb(case.delta0) ** 2

    def gap(order, s):
        z = motion(order, s)
        if order == 0:
            return dot(z[0], z[0]) - radius2
        if order == 1:
            return 2 * dot(z[0], z[1])
        if order == 2:
            return 2 * (dot(z[1], z[1]) + dot(z[0], z[2]))
        return 2 * (3 * dot(z[1], z[2]) + dot(z[0], z[3]))

    leading = leading_order(gap_derivatives(case, now))
    s = first_root(gap, (end - now.time).mid(), leading)
    if s is None:
        return None
    z, v = motion(1, s)
    return on_ring(case, now.time + s, z, v)


def on_ring(case, time, z, v, depth=0.0):
    """Put a state that has reached the ring exactly on it."""
    z = (z * (arb(case.delta0) / dot(z, z).sqrt())).mid()
    return Instant(time.mid(), z, v.mid(), on_ring=True, depth=depth)


def contact(case, now, end, accuracy, *, tangential=False):
    """Return the exit that ends a contact, or None where it lasts beyond the end."""
    if tangential:
        now = leave_ring_tangentially(case, now, accuracy)
    time, z, v = now.time, now.z, now.v
    q = arb(0)
    if not now.on_ring:
        q = gap_root(case, z)
    depth = 0.0
    while time < end:
        series_q, series_z, series_v, series_t = series(case, q, z, v, time, accuracy.order)
        step = longest_step([series_q, series_z, series_v], accuracy)
        u = exit_within(series_q, step)
        at = step if u is None else u
        depth = max(depth, deepest(series_q, float(at)))
        time, z, v = (value(terms, at).mid() for terms in (series_t, series_z, series_v))
        if u is not None:
            return on_ring(case, time, z, v, depth) if time < end else None
        q = value(series_q, at).mid()
    return None


def gap_root(case, z):
    """sqrt(|z| - delta0), also where the two are nearly the same, or exactly so."""
    gap = dot(z, z) - arb(case.delta0) ** 2
    if gap == 0:
        return arb(0)
    return (gap / (dot(z, z).sqrt() + arb(case.delta0))).sqrt().mid()


def series(case, q, z, v, time, order):
    """Return the Taylor coefficients in u of q, z, v and t."""
    damping, omega = 2 * arb(case.zeta), arb(case.omega)
    delta0, push, turn = arb(case.delta0), acb(omega**2), acb(0, omega)
    q, z, v, e, t = [q], [z], [v], [phasor(case, time)], [time]
    qc, square, cube, radial, inverse, stiffness, force = [acb(q[0])], [], [], [], [], [], []
    conjugate = [v[0].conjugate()]

    def term(a, b, n):
        """Coefficient n of a product."""
        return sum(map(mul, a[: n + 1], b[n::-1]), arb(0))

    def complex_term(a, b, n):
        return sum(map(mul, a[: n + 1], b[n::-1]), acb(0))

    for n in range(order):
        square.append(term(q, q, n))
        cube.append(term(square, q, n))
        radial.append(complex_term(z, conjugate, n).real)
        if n == 0:
            inverse.append(1 / (delta0 + square[0]))
        else:
            rest = sum(map(mul, square[1:], inverse[::-1]), arb(0))
            inverse.append(-rest * inverse[0])
        stiffness.append(acb(term(cube, inverse, n)))
        force.append(push * e[n] - damping * v[n] - complex_term(stiffness, z, n))
        share = arb(1) / (n + 1)
        q.append(term(radial, inverse, n) * share / 2)
        z.append(complex_term(qc, v, n) * share)
        e.append(complex_term(qc, e, n) * turn * share)
        t.append(q[n] * share)
        v.append(complex_term(qc, force, n) * share)
        conjugate.append(v[-1].conjugate())
        qc.append(acb(q[-1]))
    return q, z, v, t


def longest_step(all_terms, accuracy):
    """Return the step at which the last two terms of every series are below the tolerance."""
    steps = [1.0]
    for terms in all_terms:
        for n in (len(terms) - 1, len(terms) - 2):
            size = float(abs(terms[n]).mid())
            if size > 0.0:
                steps.append(exp((log(accuracy.tolerance) - log(size)) / n))
    return arb(min(steps))


def value(terms, u):
    """Sum a series at u."""
    total = terms[-1]
    for term in terms[-2::-1]:
        total = total * u + term
    return total


def deepest(terms, step):
    """Greatest q^2 over a step, to a part in a thousand, from 65 points."""
    terms = [float(term.mid()) for term in terms]
    return max(value(terms, step * n / 64) ** 2 for n in range(65))


def exit_within(terms, step):
    """Return the first positive root of the series of q within a step, or None."""
    bound, power = arb(0), arb(1)
    for term in terms[1:]:
        power *= step
        bound += abs(term) * power
    if bound < terms[0]:
        return None
    polynomials = [arb_poly([-term.mid() for term in terms])]
    polynomials += [polynomials[0].derivative()]
    polynomials += [polynomials[1].derivative()]
    return first_root(
        lambda order, u: polynomials[order](u), step, leading=1 if terms[0] == 0 else 0
    )


def leave_ring_tangentially(case, now, accuracy):
    """Return a state a little after a start on the ring with r' = 0 < r''.

    There u is of no use (it would take for ever), but |z| - delta0 = t^2 p(t)^2 with p analytic:
    Picard's iteration on Taylor series in t gains at least two terms a time.
    """
    order = accuracy.order
    kept, ctx.cap = ctx.cap, order + 4
    try:
        damping, omega, delta0 = 2 * arb(case.zeta), arb(case.omega), arb(case.delta0)
        angle = arb_series([omega * now.time, omega], prec=order + 4)
        push = [omega**2 * angle.cos(), omega**2 * angle.sin()]
        places = [now.z.real, now.z.imag]
        speeds = [now.v.real, now.v.imag]
        second = gap_derivatives(case, now)[2] / (4 * delta0)  # half of r''
        pulls = [arb_series([0]), arb_series([0])]
        for _ in range(order):
            z = []
            for n in range(2):
                # v' = push - damping v - pull, solved for the terms of v one by one
                wanted = (push[n] - pulls[n]).coeffs()
                wanted += [arb(0)] * (order + 4 - len(wanted))
                v = [speeds[n]]
                for k in range(order + 2):
                    v.append((wanted[k] - damping * v[k]) / (k + 1))
                place = [places[n]] + [term / (k + 1) for k, term in enumerate(v)]
                z.append([term.mid() for term in place])
            full = [arb_series(terms, prec=order + 4) for terms in z]
            radius2 = (full[0] * full[0] + full[1] * full[1]).coeffs()
            radius = arb_series(radius2, prec=order + 4).sqrt()
            gap = arb_series([0, 0, *radius2[2:]], prec=order + 4) / (radius + delta0)
            root = arb_series([second, *gap.coeffs()[3:]], prec=order + 2).sqrt()
            cube = arb_series([0, 0, 0, *(root * root * root).coeffs()], prec=order + 4)
            pulls = [cube * each / radius for each in full]
        series_z = [acb(x, y) for x, y in zip(*z, strict=True)][: order + 1]
        series_v = [n * term for n, term in enumerate(series_z)][1:]
        step = longest_step([series_z, series_v, gap.coeffs()[:order]], accuracy) / 2
        after = Instant(now.time + step, value(series_z, step).mid(), value(series_v, step).mid())
    finally:
        ctx.cap = kept
    return after
