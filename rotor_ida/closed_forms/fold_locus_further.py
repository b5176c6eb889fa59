"""Where folds lie with a shaft, or with a linear contact: `fold_locus` for any restoring force.

Let ``g(A) = f(A) + kappa A`` be the force of ring and shaft together and ``W = A f' - f``. With a
and b as for `fold_locus` a contacting whirl obeys ``g = q b`` and ``2 zeta A = omega sin(theta)``,
and the condition of a fold becomes

    a b = g/W,    a + b = A,                                                         (locus)
    4 zeta**2 = (1 - a**2) g / (A**2 b).                                           (damping)

The shaft falls out of W. By Hertz ``W = u (A + 2 delta0)/2``, in a linear contact
``W = delta0``: without clearance such a rotor is linear and has no fold. At a = 1 the locus ends,
where ``g = (A - 1) W``: these are the folds without damping.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.fold_locus import LocusPoints, last_before

_NODES_PER_DECADE = 24
_NODES_BETWEEN = 65
_ROUNDING = 1e-14
# A root of a polynomial is real if its imaginary part is so much smaller; as a node it does no harm
# if it is not.
_REAL = 1e-5


@dataclass(frozen=True, slots=True)
class Ring:
    """What springs back, and rubs: clearance, stiffness of the shaft, law of contact, friction."""

    delta0: float
    shaft_stiffness: float
    hertz: bool
    friction: float = 0.0

    def forces(self, u: Values) -> tuple[Values, Values, Values]:
        """Return A, g and W at ``u = sqrt(A - delta0)``."""
        square = u * u
        A = self.delta0 + square
        if self.hertz:
            return A, square * u + self.shaft_stiffness * A, 0.5 * u * (A + 2.0 * self.delta0)
        return A, square + self.shaft_stiffness * A, self.delta0 + 0.0 * u

    def stiffness(self, A: Values) -> Values:
        """Return ``g/A`` at amplitudes."""
        depth = np.maximum(A - self.delta0, 0.0)
        force = depth * np.sqrt(depth) if self.hertz else depth
        return force / A + self.shaft_stiffness

    def slopes(self, u: Values) -> tuple[Values, Values]:
        """Return the derivatives of g and W by A."""
        if self.hertz:
            return 1.5 * u + self.shaft_stiffness, 0.75 * (self.delta0 + u * u) / u
        return 1.0 + self.shaft_stiffness + 0.0 * u, 0.0 * u


@dataclass(frozen=True, slots=True)
class FurtherSide:
    """One side of the locus, cut so finely that the damping is monotone: see `LocusSide`."""

    ring: Ring
    side: int
    u: Values
    damping: Values


def points_on_side(u: Values, ring: Ring, side: int) -> LocusPoints:
    """Return the points of one side of the locus, as `locus_points` does."""
    A, force, W = ring.forces(u)
    slope, bend = ring.slopes(u)
    product = force / W
    discriminant = A * A - 4.0 * product
    meets = np.abs(discriminant) < _ROUNDING * A * A
    exists = meets | (discriminant > 0.0)
    larger = 0.5 * (A + np.sqrt(np.where(meets | ~exists, 0.0, discriminant)))
    smaller = product / larger
    a, b = (smaller, larger) if side == 0 else (larger, smaller)
    a = np.where(np.abs(a - 1.0) < _ROUNDING, 1.0, a)
    exists &= a <= 1.0
    a, b = np.where(exists, a, np.nan), np.where(exists, b, np.nan)

    sine_squared = (1.0 - a) * (1.0 + a)
    damping = sine_squared * (force / A) / (A * b)
    # as in `locus_points`, where the drift is the derivative of a b, less a
    drift = slope / W - product * (bend / W) - a
    rising = drift * (sine_squared - 2.0 * a * b)
    rising = rising + (b - a) * sine_squared * (b * (slope / force - 2.0 / A) - 1.0)
    return LocusPoints(a, b, damping, rising if side == 0 else -rising)


def further_locus(ring: Ring, smallest_damping: float) -> list[FurtherSide]:
    """Return the two sides of the locus of folds; none where there is no fold.

    Examples
    --------
    >>> nearer, farther = further_locus(Ring(0.0, 0.0, True), 1e-3)
    >>> round(float((max(nearer.damping[nearer.damping >= 0.0]) / 4.0) ** 0.5), 8)
    0.15604517
    """
    if not ring.hertz and ring.delta0 == 0.0:
        return []
    special = np.sort(np.concatenate([_meeting_points(ring), undamped_roots(ring)]))
    beside = 10.0 ** -np.arange(2.0, 15.0, 2.0)
    near = np.outer(special, np.concatenate([[1.0], 1.0 - beside, 1.0 + beside])).ravel()
    lowest, highest = _reach(ring, min(smallest_damping, 1.0))
    count = int(_NODES_PER_DECADE * np.log10(highest / lowest)) + 2
    ends = np.concatenate([[lowest], special[special > lowest], [highest]])
    between = [np.linspace(low, high, _NODES_BETWEEN) for low, high in pairwise(ends)]
    nodes = np.unique(np.concatenate([np.geomspace(lowest, highest, count), near, *between]))
    return [_side(nodes, ring, side) for side in (0, 1)]


def _reach(ring: Ring, least: float) -> tuple[float, float]:
    """Return the ends of the range of u in which 4 zeta**2 may be as large as `least`."""
    d, kappa = ring.delta0, ring.shaft_stiffness
    highest = 1.0 + np.sqrt(d) + np.cbrt(1.0 / least) + np.cbrt(kappa)
    highest = 10.0 * (highest + ((1.0 + kappa) / least) ** 0.25)
    if ring.hertz:
        first_touch = d * np.cbrt(least) or np.inf
        return 0.1 * min(least, first_touch), highest
    # the locus of a linear contact may begin at the ring itself
    return 1e-8 * min(least, d * np.sqrt(least * d), d), highest


def _meeting_points(ring: Ring) -> Values:
    """Return the u > 0 where the two sides meet: ``A**2 W = 4 g``."""
    A, force, W = _polynomials(ring)
    return positive_roots(A * A * W - 8.0 * force)


def undamped_roots(ring: Ring) -> Values:
    """Return the u > 0 of the folds without damping: ``(A - 1) W = g``, with A > 1."""
    if not ring.hertz:
        return np.empty(0)
    A, force, W = _polynomials(ring)
    found = positive_roots((A - 1.0) * W - 2.0 * force)
    return found[ring.delta0 + found * found > 1.0]


def _polynomials(ring: Ring) -> tuple[np.poly1d, np.poly1d, np.poly1d]:
    """Return A, g and 2 W as polynomials in u."""
    u = np.poly1d([1.0, 0.0])
    A = u * u + ring.delta0
    if ring.hertz:
        return A, u * u * u + ring.shaft_stiffness * A, u * (A + 2.0 * ring.delta0)
    return A, u * u + ring.shaft_stiffness * A, np.poly1d([2.0 * ring.delta0])


def positive_roots(polynomial: np.poly1d) -> Values:
    """Return the positive roots, each once."""
    roots = np.asarray(polynomial.roots, dtype=np.complex128)
    points = roots.real[(np.abs(roots.imag) < _REAL * np.abs(roots)) & (roots.real > 0.0)]
    derivative = polynomial.deriv()
    for _ in range(4):
        value, slope = polynomial(points), derivative(points)
        step = np.divide(value, slope, out=np.zeros_like(points), where=slope != 0.0)
        points = points - np.where(np.abs(step) < 0.1 * points, step, 0.0)
    return np.unique(points)


def _side(nodes: Values, ring: Ring, side: int) -> FurtherSide:
    """Return one side, its turning points found and put among the nodes."""
    slope = points_on_side(nodes, ring, side).slope
    before = np.nonzero(slope[:-1] * slope[1:] < 0.0)[0]
    rising = slope[before] > 0.0
    turning = last_before(
        nodes[before],
        nodes[before + 1],
        lambda u: (points_on_side(u, ring, side).slope > 0.0) == rising,
    )
    u = np.unique(np.concatenate([nodes, turning]))
    return FurtherSide(ring, side, u, points_on_side(u, ring, side).damping)


def further_folds(locus: FurtherSide, zeta: Values) -> tuple[npt.NDArray[np.int_], Values, Values]:
    """Return every fold on one side: which damping it belongs to, speed, amplitude."""
    ring, side = locus.ring, locus.side
    damping = 4.0 * zeta * zeta
    above = locus.damping > damping[:, None]
    exists = np.isfinite(locus.damping[:-1] + locus.damping[1:])
    row, node = np.nonzero((above[:, :-1] != above[:, 1:]) & exists)
    bounds, falling = (locus.u[node], locus.u[node + 1]), above[row, node]
    low = last_before(
        *bounds,
        lambda u: (points_on_side(u, ring, side).damping > damping[row]) == falling,
    )
    points = points_on_side(low, ring, side)
    smaller = points.a if side == 0 else points.b
    return row, *polished(low, smaller, bounds, zeta[row], ring, side)


def polished(
    u: Values,
    smaller: Values,
    bounds: tuple[Values, Values],
    zeta: Values,
    ring: Ring,
    side: int,
) -> tuple[Values, Values]:
    """Return speed and amplitude after Newton steps with 32-digit residuals.

    The unknowns are u and the smaller of a and b, the equations ``2 W a b = 2 g`` and
    ``(1 - a**2) g = 4 zeta**2 A**2 b``.
    """
    one, d, kappa, two_zeta = (
        DoubleDouble.of(0.0 * u + each)
        for each in (1.0, ring.delta0, ring.shaft_stiffness, 2.0 * zeta)
    )
    along = 2.0 if side else 0.0  # a = A - b takes what A gains, or b = A - a does
    turn = -1.0 if side else 1.0
    for _ in range(5):
        root, y = DoubleDouble.of(u), DoubleDouble.of(smaller)
        square = root * root
        A = d + square
        wide = A + d + d
        a, b = (A - y, y) if side else (y, A - y)
        force, W = (square * root, root * wide) if ring.hertz else (square, d + d)
        force = force + kappa * A
        sine_squared, loss = one - a * a, two_zeta * two_zeta * (A * A)
        on_locus = (W * (a * b) - force - force).high
        on_damping = (sine_squared * force - loss * b).high

        force_u = (3.0 * u * u if ring.hertz else 2.0 * u) + 2.0 * kappa.high * u
        W_u = wide.high + 2.0 * u * u if ring.hertz else 0.0
        locus_u = W_u * a.high * b.high + W.high * 2.0 * u * y.high - 2.0 * force_u
        locus_y = W.high * (A.high - 2.0 * y.high)
        damping_u = sine_squared.high * force_u - 2.0 * a.high * along * u * force.high
        damping_u = damping_u - loss.high * (4.0 * u * b.high / A.high + (2.0 - along) * u)
        damping_y = turn * (loss.high - 2.0 * a.high * force.high)

        determinant = locus_u * damping_y - locus_y * damping_u
        usable = determinant != 0.0
        step_u = on_locus * damping_y - locus_y * on_damping
        step_y = locus_u * on_damping - on_locus * damping_u
        zero = np.zeros_like(u)
        u = np.clip(u - np.divide(step_u, determinant, out=zero.copy(), where=usable), *bounds)
        smaller = smaller - np.divide(step_y, determinant, out=zero.copy(), where=usable)
    amplitude, total, _ = ring.forces(u)
    return np.sqrt(total / (smaller if side else amplitude - smaller)), amplitude


def undamped_folds(ring: Ring) -> list[tuple[float, float]]:
    """Return speed and amplitude of the folds without damping: the ends of the locus, a = 1."""
    u = undamped_roots(ring)
    found = []
    for side in (0, 1):
        A = ring.delta0 + u * u
        here = u[A >= 2.0] if side == 0 else u[A < 2.0]
        smaller = np.ones_like(here) if side == 0 else ring.delta0 + here * here - 1.0
        bounds = (0.9 * here, 1.1 * here)
        omega, amplitude = polished(here, smaller, bounds, np.zeros_like(here), ring, side)
        found += list(zip(omega.tolist(), amplitude.tolist(), strict=True))
    return found
