"""The locus of folds: one curve for each restoring law, on which each damping has its folds.

Let theta be the phase lag, ``g(A) = f(A) + kappa A`` the force of contact and shaft together,
``W = A f' - f``, ``q = omega**2``, ``a = -cos(theta)`` and ``b = A - a``. A contacting whirl obeys
``g = q b`` and ``2 zeta A = omega sin(theta)``. With these the condition of a fold, D = 0, loses
both q and zeta and becomes

    a b = g/W,    a + b = A.                                                         (locus)

a and b are the two roots of one quadratic. On side 0 of the locus a is the smaller one, on side 1
the larger; the sides meet where ``A**2 W = 4 g``, and at a = 1 the locus ends, where
``g = (A - 1) W``: these are the folds without damping. Along it

    4 zeta**2 = (1 - a**2) g / (A**2 b)                                            (damping)

rises and falls; each crossing of the given damping is a fold, with ``omega**2 = g/b``.

The turning points of the damping along a side are found as sign changes of its slope between nodes,
which are closer than any turning points encountered. It is not proven that none is missed:
``tests/closed_forms/test_folds.py`` compares the number of folds with the real roots of a
resultant, for Hertz contact without a shaft, and with the number of whirls on both sides of each.

The shaft cancels in W. For Hertz contact ``W = u (A + 2 delta0)/2`` with ``u = sqrt(A - delta0)``.
For a linear contact ``W = delta0``: without clearance such a rotor is linear and has no fold.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Flags, Values
from rotor_ida.closed_forms.curve_polynomials import Fold
from rotor_ida.closed_forms.double_double import DoubleDouble
from rotor_ida.closed_forms.restoring_law import RestoringLaw

_NODES_PER_DECADE = 24
_NODES_BETWEEN = 65
# Number of parts into which a bracket is cut at a time.
_PARTS = 32
_MOST_ROUNDS = 30
_ROUNDING = 1e-14
# A root of a polynomial counts as real if its relative imaginary part is below this; a false one is
# harmless as a node.
_REAL = 1e-5


@dataclass(frozen=True, slots=True)
class LocusSide:
    """One side of the locus of one restoring law, cut at each turning point of the damping."""

    law: RestoringLaw
    side: int  # 0 where a is the smaller root, 1 where it is the larger
    u: Values  # ascending, with every turning point of the damping
    damping: Values  # 4 zeta**2 there; NaN off the locus


@dataclass(frozen=True, slots=True)
class LocusPoints:
    """Points of a locus; NaN where there is none."""

    a: Values  # -cos(theta)
    b: Values  # A + cos(theta)
    damping: Values  # 4 zeta**2
    slope: Values  # has the sign of the derivative of the damping by u


class Cusp(NamedTuple):
    """Damping ratio, speed and amplitude at which the last two folds merge [dimensionless]."""

    zeta: float
    omega: float
    amplitude: float


NO_CUSP = Cusp(math.nan, math.nan, math.nan)


def locus_points(u: npt.ArrayLike, law: RestoringLaw, side: int) -> LocusPoints:
    """Return the points of one side of the locus at given ``u = sqrt(A - delta0)``, above zero.

    Examples
    --------
    >>> end = locus_points(3.0**0.5, RestoringLaw(0.0), 0)
    >>> float(end.a), float(end.damping)
    (1.0, 0.0)
    """
    root = np.asarray(u, dtype=np.float64)
    A, force, W = law.forces(root)
    slope, bend = law.slopes(root)
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
    # d log(damping)/dA times (1 - a**2) b (b - a), where (b - a) da/dA is the drift
    drift = slope / W - product * (bend / W) - a
    rising = drift * (sine_squared - 2.0 * a * b)
    rising = rising + (b - a) * sine_squared * (b * (slope / force - 2.0 / A) - 1.0)
    return LocusPoints(a, b, damping, np.asarray(rising if side == 0 else -rising))


@lru_cache(maxsize=16)
def fold_locus(law: RestoringLaw, smallest_damping: float) -> tuple[LocusSide, ...]:
    """Return the two sides of the locus of folds without friction; none if there is no fold.

    The damping ``4 zeta**2`` vanishes as the locus tends to u = 0 and to infinity. The locus is
    followed far enough for the smallest damping needed.

    Examples
    --------
    >>> nearer, farther = fold_locus(RestoringLaw(0.0), 1e-3)
    >>> round(float((max(nearer.damping[nearer.damping >= 0.0]) / 4.0) ** 0.5), 8)
    0.15604517
    """
    if not law.hertz and law.delta0 == 0.0:
        return ()
    special = np.sort(np.concatenate([_meeting_points(law), undamped_roots(law)]))
    beside = 10.0 ** -np.arange(2.0, 15.0, 2.0)
    near = np.outer(special, np.concatenate([[1.0], 1.0 - beside, 1.0 + beside])).ravel()
    lowest, highest = _reach(law, min(smallest_damping, 1.0))
    count = int(_NODES_PER_DECADE * np.log10(highest / lowest)) + 2
    ends = np.concatenate([[lowest], special[special > lowest], [highest]])
    between = [np.linspace(low, high, _NODES_BETWEEN) for low, high in pairwise(ends)]
    nodes = np.unique(np.concatenate([np.geomspace(lowest, highest, count), near, *between]))
    return tuple(_side(nodes, law, side) for side in (0, 1))


def _reach(law: RestoringLaw, least: float) -> tuple[float, float]:
    """Return the ends of the range of u in which 4 zeta**2 may be as large as `least`."""
    d, kappa = law.delta0, law.shaft_stiffness
    highest = 1.0 + np.sqrt(d) + np.cbrt(1.0 / least) + np.cbrt(kappa)
    highest = 10.0 * (highest + ((1.0 + kappa) / least) ** 0.25)
    if law.hertz:
        first_touch = d * np.cbrt(least) or np.inf
        return 0.1 * min(least, first_touch), highest
    # the locus of a linear contact may begin at the stator itself
    return 1e-8 * min(least, d * np.sqrt(least * d), d), highest


def _meeting_points(law: RestoringLaw) -> Values:
    """Return the u > 0 where the two sides meet: ``A**2 W = 4 g``."""
    A, force, W = law.polynomials()
    return approximate_roots(A * A * W - 8.0 * force)


def undamped_roots(law: RestoringLaw) -> Values:
    """Return the u > 0 of the folds without damping: ``(A - 1) W = g``, with A > 1."""
    if not law.hertz:
        return np.empty(0)
    A, force, W = law.polynomials()
    found = approximate_roots((A - 1.0) * W - 2.0 * force)
    return found[law.delta0 + found * found > 1.0]


def approximate_roots(polynomial: np.poly1d) -> Values:
    """Return the positive roots in floating point, each once; nearly real ones count as real."""
    roots = np.asarray(polynomial.roots, dtype=np.complex128)
    points = roots.real[(np.abs(roots.imag) < _REAL * np.abs(roots)) & (roots.real > 0.0)]
    derivative = polynomial.deriv()
    for _ in range(4):
        value, slope = polynomial(points), derivative(points)
        step = np.divide(value, slope, out=np.zeros_like(points), where=slope != 0.0)
        points = points - np.where(np.abs(step) < 0.1 * points, step, 0.0)
    return np.unique(points)


def _side(nodes: Values, law: RestoringLaw, side: int) -> LocusSide:
    """Return one side, with its turning points included in the nodes."""
    slope = locus_points(nodes, law, side).slope
    before = np.nonzero(slope[:-1] * slope[1:] < 0.0)[0]
    rising = slope[before] > 0.0
    turning = last_before(
        nodes[before],
        nodes[before + 1],
        lambda u: (locus_points(u, law, side).slope > 0.0) == rising,
    )
    u = np.unique(np.concatenate([nodes, turning]))
    return LocusSide(law, side, u, locus_points(u, law, side).damping)


def folds_on_side(locus: LocusSide, zeta: Values) -> list[list[Fold]]:
    """Return the folds on one side of the locus, separately for each damping.

    Examples
    --------
    >>> found = folds_on_side(fold_locus(RestoringLaw(0.0), 0.01)[0], np.array([0.07, 0.2]))
    >>> [[round(fold.omega, 6) for fold in each] for each in found]
    [[1.597821, 1.932754], []]
    """
    law, side = locus.law, locus.side
    damping = 4.0 * zeta * zeta
    above = locus.damping > damping[:, None]
    # In a linear contact the locus begins at the first touch with a damping above 0. Where that is
    # the given one to rounding, the first touch is no fold.
    same = np.abs(locus.damping - damping[:, None]) <= _ROUNDING * damping[:, None]
    begun = np.logical_or.accumulate(~same, axis=1)
    above = np.where(begun, above, np.take_along_axis(above, begun.argmax(axis=1)[:, None], axis=1))
    exists = np.isfinite(locus.damping[:-1] + locus.damping[1:])
    row, node = np.nonzero((above[:, :-1] != above[:, 1:]) & exists)
    bounds, falling = (locus.u[node], locus.u[node + 1]), above[row, node]
    low = last_before(
        *bounds,
        lambda u: (locus_points(u, law, side).damping > damping[row]) == falling,
    )
    points = locus_points(low, law, side)
    smaller = points.a if side == 0 else points.b
    omega, amplitude = _polished(low, smaller, bounds, zeta[row], law, side)
    found: list[list[Fold]] = [[] for _ in zeta]
    for number, *fold in zip(row.tolist(), omega.tolist(), amplitude.tolist(), strict=True):
        found[number].append(Fold(*fold))
    return found


def last_before(low: Values, high: Values, before: Callable[[Values], Flags]) -> Values:
    """Return the last place where `before` is true, to neighbouring doubles.

    Each round evaluates many places between `low` and `high` at once, on a new first axis.
    """
    parts = np.linspace(0.0, 1.0, _PARTS + 1)[1:-1, None]
    column = np.arange(low.size)
    for _ in range(_MOST_ROUNDS):
        if (np.nextafter(low, high) == high).all():
            break
        inner = np.clip(low + parts * (high - low), low, high)
        places = np.concatenate([low[None], inner, high[None]])
        passed = np.logical_and.accumulate(before(inner)).sum(axis=0)
        low, high = places[passed, column], places[passed + 1, column]
    return low


def _polished(
    u: Values,
    smaller: Values,
    bounds: tuple[Values, Values],
    zeta: Values,
    law: RestoringLaw,
    side: int,
) -> tuple[Values, Values]:
    """Return speed and amplitude after Newton steps, keeping the last one as a low part."""
    for _ in range(4):
        step_u, step_smaller = _newton_step(u, smaller, zeta, law, side)
        u, smaller = np.clip(u - step_u, *bounds), smaller - step_smaller
    step_u, step_smaller = _newton_step(u, smaller, zeta, law, side)
    small = np.abs(step_u) < _ROUNDING * u  # not where two folds nearly coincide
    root = DoubleDouble.of(u) - DoubleDouble.of(np.where(small, step_u, 0.0))
    y = DoubleDouble.of(smaller) - DoubleDouble.of(np.where(small, step_smaller, 0.0))
    A = DoubleDouble.of(np.full_like(u, law.delta0)) + root * root
    force = root * root if not law.hertz else root * root * root
    force = force + DoubleDouble.of(np.full_like(u, law.shaft_stiffness)) * A
    b = y if side else A - y
    return np.sqrt(force.high / b.high), A.high


def _newton_step(
    u: Values, smaller: Values, zeta: Values, law: RestoringLaw, side: int
) -> tuple[Values, Values]:
    """Return the step of u and of the smaller of a and b, from 32-digit residuals.

    The equations are ``2 W a b = 2 g`` and ``(1 - a**2) g = 4 zeta**2 A**2 b``.
    """
    one, d, kappa, two_zeta = (
        DoubleDouble.of(0.0 * u + each)
        for each in (1.0, law.delta0, law.shaft_stiffness, 2.0 * zeta)
    )
    along = 2.0 if side else 0.0  # a = A - b takes what A gains, or b = A - a does
    turn = -1.0 if side else 1.0
    root, y = DoubleDouble.of(u), DoubleDouble.of(smaller)
    square = root * root
    A = d + square
    wide = A + d + d
    a, b = (A - y, y) if side else (y, A - y)
    force, W = (square * root, root * wide) if law.hertz else (square, d + d)
    force = force + kappa * A
    sine_squared, loss = one - a * a, two_zeta * two_zeta * (A * A)
    on_locus = (W * (a * b) - force - force).high
    on_damping = (sine_squared * force - loss * b).high

    force_u = (3.0 * u * u if law.hertz else 2.0 * u) + 2.0 * kappa.high * u
    W_u = wide.high + 2.0 * u * u if law.hertz else 0.0
    locus_u = W_u * a.high * b.high + W.high * 2.0 * u * y.high - 2.0 * force_u
    locus_y = W.high * (A.high - 2.0 * y.high)
    damping_u = sine_squared.high * force_u - 2.0 * a.high * along * u * force.high
    damping_u = damping_u - loss.high * (4.0 * u * b.high / A.high + (2.0 - along) * u)
    damping_y = turn * (loss.high - 2.0 * a.high * force.high)

    determinant = locus_u * damping_y - locus_y * damping_u
    usable = determinant != 0.0
    step_u = on_locus * damping_y - locus_y * on_damping
    step_smaller = locus_u * on_damping - on_locus * damping_u
    zero = np.zeros_like(u)
    return (
        np.divide(step_u, determinant, out=zero.copy(), where=usable),
        np.divide(step_smaller, determinant, out=zero.copy(), where=usable),
    )


def undamped_folds(law: RestoringLaw) -> list[Fold]:
    """Return speed and amplitude of the folds without damping: the ends of the locus, a = 1."""
    u = undamped_roots(law)
    found: list[Fold] = []
    for side in (0, 1):
        A = law.delta0 + u * u
        here = u[A >= 2.0] if side == 0 else u[A < 2.0]
        smaller = np.ones_like(here) if side == 0 else law.delta0 + here * here - 1.0
        bounds = (0.9 * here, 1.1 * here)
        omega, amplitude = _polished(here, smaller, bounds, np.zeros_like(here), law, side)
        found += map(Fold, omega.tolist(), amplitude.tolist())
    return found


def frictionless_cusp(law: RestoringLaw) -> Cusp:
    """Return the cusp without friction: the largest damping on the locus; NaN without folds."""
    best, place, side = 0.0, 0.0, 0
    for locus in fold_locus(law, 1e-3):
        damping = np.where(np.isfinite(locus.damping), locus.damping, -1.0)
        largest = int(damping.argmax())
        if damping[largest] > best:
            best, place, side = float(damping[largest]), float(locus.u[largest]), locus.side
    if best == 0.0:
        return NO_CUSP
    u = np.array(place)
    amplitude, force, _ = law.forces(u)
    b = locus_points(u, law, side).b
    return Cusp(0.5 * math.sqrt(best), math.sqrt(float(force / b)), float(amplitude))
