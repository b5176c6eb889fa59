"""Where folds lie: one curve for each clearance, from which each damping picks its folds.

Let theta be the phase lag, ``A = delta0 + u**2``, ``q = omega**2``, ``a = -cos(theta)`` and
``b = A - a``. A contacting whirl obeys ``u**3 = q b``, as the Hertz exponent is 3/2, and
``2 zeta A = omega sin(theta)``. With these the condition of a fold, D = 0, loses both q and zeta
and becomes

    (A + 2 delta0) a b = 2 u**2,    a + b = A:                                      (locus)

a and b are the two roots of one quadratic. On side 0 of the locus a is the smaller one, on
side 1 the larger; the sides meet where ``A**2 (A + 2 delta0) = 8 u**2``, and at a = 1 the locus
ends, at A = 3 - 2 delta0. Along it

    4 zeta**2 = (1 - a**2) u**3 / (A**2 b)                                        (damping)

rises and falls; each crossing of the given damping is a fold, with ``omega**2 = u**3/b``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.double_double import DoubleDouble

Flags = npt.NDArray[np.bool_]

_NODES_PER_DECADE = 24
# A bracket is cut into so many parts at a time.
_PARTS = 32
_MOST_ROUNDS = 30
_ROUNDING = 1e-14


@dataclass(frozen=True, slots=True)
class LocusSide:
    """One side of the locus of one clearance, cut so finely that the damping is monotone."""

    delta0: float
    side: int  # 0 where a is the smaller root, 1 where it is the larger
    u: Values  # ascending, with every turning point of the damping
    damping: Values  # 4 zeta**2 there; NaN where the locus is not


@dataclass(frozen=True, slots=True)
class LocusPoints:
    """Points of a locus; NaN where it is not."""

    a: Values  # -cos(theta)
    b: Values  # A + cos(theta)
    damping: Values  # 4 zeta**2
    slope: Values  # has the sign of the derivative of the damping by u


def locus_points(u: npt.ArrayLike, delta0: float, side: int) -> LocusPoints:
    """Return the points of one side of the locus at some ``u = sqrt(A - delta0)``, above zero.

    Examples
    --------
    >>> end = locus_points(3.0**0.5, 0.0, 0)
    >>> float(end.a), float(end.damping)
    (1.0, 0.0)
    """
    root = np.asarray(u, dtype=np.float64)
    square = root * root
    A = delta0 + square
    wide = A + 2.0 * delta0
    discriminant = A * A - 8.0 * square / wide
    meets = np.abs(discriminant) < _ROUNDING * A * A
    exists = meets | (discriminant > 0.0)
    larger = 0.5 * (A + np.sqrt(np.where(meets | ~exists, 0.0, discriminant)))
    smaller = 2.0 * square / (wide * larger)
    a, b = (smaller, larger) if side == 0 else (larger, smaller)
    a = np.where(np.abs(a - 1.0) < _ROUNDING, 1.0, a)
    exists &= a <= 1.0
    a, b = np.where(exists, a, np.nan), np.where(exists, b, np.nan)

    sine_squared = (1.0 - a) * (1.0 + a)
    damping = sine_squared * (root / A) ** 2 * (root / b)
    # d log(damping)/dA times (1 - a**2) b (b - a), where (b - a) da/dA = 6 delta0/wide**2 - a
    drift = 6.0 * delta0 / wide**2 - a
    slope = drift * (sine_squared - 2.0 * a * b)
    slope = slope + (b - a) * sine_squared * (b * (1.5 / square - 2.0 / A) - 1.0)
    return LocusPoints(a, b, damping, np.asarray(slope if side == 0 else -slope))


def fold_locus(delta0: float, smallest_damping: float) -> list[LocusSide]:
    """Return the two sides of the locus of folds of one clearance.

    The damping ``4 zeta**2`` vanishes where the locus runs to u = 0 and to infinity; it is
    followed far enough for the smallest that will be asked for.

    Examples
    --------
    >>> nearer, farther = fold_locus(0.0, 1e-3)
    >>> round(float((max(nearer.damping[nearer.damping >= 0.0]) / 4.0) ** 0.5), 8)
    0.15604517
    """
    special = _meeting_points(delta0)
    if delta0 < 1.0:
        special.append(float(np.sqrt(3.0 * (1.0 - delta0))))
    beside = 10.0 ** -np.arange(2.0, 15.0, 2.0)
    near = np.outer(special, np.concatenate([[1.0], 1.0 - beside, 1.0 + beside])).ravel()
    least = min(smallest_damping, 1.0)
    first_touch = delta0 * np.cbrt(least) or np.inf
    lowest = 0.1 * min(least, first_touch)
    highest = 10.0 * (1.0 + np.sqrt(delta0) + np.cbrt(1.0 / least))
    count = int(_NODES_PER_DECADE * np.log10(highest / lowest)) + 2
    nodes = np.unique(np.concatenate([np.geomspace(lowest, highest, count), near]))
    return [_side(nodes, delta0, side) for side in (0, 1)]


def _meeting_points(delta0: float) -> list[float]:
    """Return the u > 0 where the two sides meet: ``A**2 (A + 2 delta0) = 8 u**2``."""
    cubic = np.array([1.0, 5.0 * delta0, 7.0 * delta0**2 - 8.0, 3.0 * delta0**3])
    roots = np.roots(cubic)
    depths = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)]
    for _ in range(3):
        slope = np.polyval(np.polyder(cubic), depths)
        step = np.polyval(cubic, depths)
        depths = depths - np.divide(step, slope, out=np.zeros_like(depths), where=slope != 0.0)
    return [float(np.sqrt(depth)) for depth in depths if depth > 0.0]


def _side(nodes: Values, delta0: float, side: int) -> LocusSide:
    """Return one side, its turning points found and put among the nodes."""
    slope = locus_points(nodes, delta0, side).slope
    before = np.nonzero(slope[:-1] * slope[1:] < 0.0)[0]
    rising = slope[before] > 0.0
    turning = last_before(
        nodes[before],
        nodes[before + 1],
        lambda u: (locus_points(u, delta0, side).slope > 0.0) == rising,
    )
    u = np.unique(np.concatenate([nodes, turning]))
    return LocusSide(delta0, side, u, locus_points(u, delta0, side).damping)


def folds_on_side(locus: LocusSide, zeta: Values) -> tuple[npt.NDArray[np.int_], Values, Values]:
    """Return every fold on one side of the locus: which damping it belongs to, speed, amplitude.

    Examples
    --------
    >>> import numpy as np
    >>> row, omega, amplitude = folds_on_side(fold_locus(0.0, 0.01)[0], np.array([0.07]))
    >>> omega.round(6)
    array([1.597821, 1.932754])
    """
    damping = 4.0 * zeta * zeta
    above = locus.damping > damping[:, None]
    exists = np.isfinite(locus.damping[:-1] + locus.damping[1:])
    row, node = np.nonzero((above[:, :-1] != above[:, 1:]) & exists)
    bounds, falling = (locus.u[node], locus.u[node + 1]), above[row, node]
    low = last_before(
        *bounds,
        lambda u: (locus_points(u, locus.delta0, locus.side).damping > damping[row]) == falling,
    )
    points = locus_points(low, locus.delta0, locus.side)
    smaller = points.a if locus.side == 0 else points.b
    u, smaller = _polished(np.stack([low, smaller]), bounds, zeta[row], locus)
    amplitude = locus.delta0 + u * u
    b = amplitude - smaller if locus.side == 0 else smaller
    return row, np.sqrt(u**3 / b), amplitude


def last_before(low: Values, high: Values, before: Callable[[Values], Flags]) -> Values:
    """Return, cut down to neighbouring doubles, where `before` holds for the last time.

    Each round asks for many places between `low` and `high` at once, on a new first axis.
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
    start: Values, bounds: tuple[Values, Values], zeta: Values, locus: LocusSide
) -> Values:
    """Return u and the smaller of a and b after Newton steps with 32-digit residuals."""
    u, smaller = start
    delta0, one, two_zeta = (
        DoubleDouble.of(values) for values in (0.0 * u + locus.delta0, 0.0 * u + 1.0, 2.0 * zeta)
    )
    for _ in range(4):
        root, y = DoubleDouble.of(u), DoubleDouble.of(smaller)
        square = root * root
        A = delta0 + square
        wide = A + delta0 + delta0
        a, b = (y, A - y) if locus.side == 0 else (A - y, y)
        sine_squared, loss, cube = one - a * a, two_zeta * two_zeta * (A * A), square * root
        on_locus = (wide * (a * b) - square - square).high
        on_damping = (sine_squared * cube - loss * b).high

        da, db = (0.0, 2.0 * u) if locus.side == 0 else (2.0 * u, 0.0)  # by u, at fixed y
        locus_u = 2.0 * u * a.high * b.high + wide.high * 2.0 * u * y.high - 4.0 * u
        locus_y = wide.high * (A.high - 2.0 * y.high)
        damping_u = 3.0 * sine_squared.high * u * u - 2.0 * a.high * da * cube.high
        damping_u = damping_u - loss.high * (4.0 * u * b.high / A.high + db)
        damping_y = 2.0 * a.high * cube.high - loss.high
        damping_y = -damping_y if locus.side == 0 else damping_y

        determinant = locus_u * damping_y - locus_y * damping_u
        usable = determinant != 0.0
        step_u = on_locus * damping_y - locus_y * on_damping
        step_y = locus_u * on_damping - on_locus * damping_u
        zero = np.zeros_like(u)
        u = np.clip(u - np.divide(step_u, determinant, out=zero.copy(), where=usable), *bounds)
        smaller = smaller - np.divide(step_y, determinant, out=zero.copy(), where=usable)
    return np.stack([u, smaller])
