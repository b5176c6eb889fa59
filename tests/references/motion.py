"""A case to be solved, and how its rotor moves before it touches.

z'' + 2 zeta z' + max(|z| - delta0, 0)^1.5 z/|z| = omega^2 exp(i omega t), z = x + i y.
"""

from dataclasses import dataclass

from flint import acb, arb


@dataclass(frozen=True)
class Case:
    """One run: the doubles that define it, and one line on what it tests."""

    name: str
    tests: str
    omega: float
    zeta: float
    delta0: float
    start: tuple[float, float, float, float]
    duration: float


@dataclass(frozen=True)
class Instant:
    """Time, place and velocity; `on_ring` where |z| is delta0 by construction.

    `depth` is the greatest indentation of the contact that ends here.
    """

    time: arb
    z: acb
    v: acb
    on_ring: bool = False
    depth: float = 0.0


class UnresolvedError(ArithmeticError):
    """The precision in use cannot tell what the rotor does next."""


def dot(a, b):
    """Re(a conj(b))."""
    return a.real * b.real + a.imag * b.imag


def phasor(case, time):
    """exp(i omega t)."""
    sine, cosine = (arb(case.omega) * time).sin_cos()
    return acb(cosine, sine)


def start_of(case, shift=(0, 0, 0, 0)):
    """Return the start of a case, moved by `shift`."""
    x, y, vx, vy = (arb(value) + moved for value, moved in zip(case.start, shift, strict=True))
    return Instant(arb(0), acb(x, y), acb(vx, vy))


def gap_derivatives(case, now):
    """Return g, g', g'', g''' of g = |z|^2 - delta0^2 as the motion without contact has them."""
    damping, omega = 2 * arb(case.zeta), arb(case.omega)
    push = omega**2 * phasor(case, now.time)
    z, v = now.z, now.v
    second = push - damping * v
    third = acb(0, 1) * omega * push - damping * second
    gap = arb(0) if now.on_ring else dot(z, z) - arb(case.delta0) ** 2
    return [
        gap,
        2 * dot(z, v),
        2 * (dot(v, v) + dot(z, second)),
        2 * (3 * dot(v, second) + dot(z, third)),
    ]


def leading_order(derivatives):
    """Return the order of the first derivative that is not exactly zero, None where all are."""
    for order, value in enumerate(derivatives):
        if value == 0:
            continue
        if value.contains(0):
            raise UnresolvedError(f"the sign of derivative {order} of the gap is hidden: {value}")
        return order
    return None


def rests_on_ring(case, now):
    """Without unbalance a rotor that stands still on the ring stays there for ever."""
    return case.omega == 0 and now.v == 0 and leading_order(gap_derivatives(case, now)) is None
