"""Where folds lie: one curve for each clearance, from which each damping picks its folds.

Let theta be the phase lag, ``t = cos(theta)``, ``A = delta0 + u**2`` and ``q = omega**2``. A
contacting whirl obeys ``u**3 = q (A + t)`` and ``2 zeta A = omega sin(theta)``. With these the
condition of a fold, D = 0, loses both q and zeta and becomes

    (A + 2 delta0) (t**2 + A t) + 2 u**2 = 0,                                       (locus)

a quadratic in t, whose two roots in (-1, 0) are the two `sides` of the locus. They meet where
``A**2 (A + 2 delta0) = 8 u**2``, and at t = -1 the locus ends, at A = 3 - 2 delta0. Along it

    4 zeta**2 = (1 - t**2) u**3 / (A**2 (A + t))                                  (damping)

rises and falls; each crossing of the given damping is a fold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.closed_forms.double_double import DoubleDouble

Values = npt.NDArray[np.float64]

SIDES = (0, 1)  # the root t nearer to 0, and the one nearer to -1
_NODES_PER_DECADE = 24
_BISECTIONS = 80


@dataclass(frozen=True, slots=True)
class LocusPiece:
    """A stretch of the locus along which ``4 zeta**2`` only rises or only falls.

    Parameters
    ----------
    side : int
        Which root t of the locus it follows.
    u : tuple of float
        ``sqrt(A - delta0)`` at its two ends [1].
    damping : tuple of float
        ``4 zeta**2`` at its two ends [1].
    """

    side: int
    u: tuple[float, float]
    damping: tuple[float, float]


def cosine_on_locus(u: npt.ArrayLike, delta0: npt.ArrayLike, side: int) -> Values:
    """Return ``t = cos(theta)`` on one side of the locus; NaN where the locus is not.

    Examples
    --------
    >>> float(cosine_on_locus(3.0**0.5, 0.0, 0))
    -1.0
    """
    depth = np.square(np.asarray(u, dtype=np.float64))
    amplitude = np.asarray(delta0 + depth)
    product = 2.0 * depth / (amplitude + 2.0 * np.asarray(delta0))
    discriminant = amplitude**2 - 4.0 * product
    meets = np.abs(discriminant) < 1e-14 * amplitude**2
    real = np.where(meets, 0.0, np.where(discriminant < 0.0, np.nan, discriminant))
    nearer_minus_one = -0.5 * (amplitude + np.sqrt(real))
    cosine = product / nearer_minus_one if side == 0 else nearer_minus_one
    cosine = np.where(np.abs(cosine + 1.0) < 1e-14, -1.0, cosine)
    return np.asarray(np.where(cosine >= -1.0, cosine, np.nan))


def damping_on_locus(u: npt.ArrayLike, delta0: npt.ArrayLike, side: int) -> Values:
    """Return ``4 zeta**2`` of the fold at `u`; NaN where the locus is not.

    Examples
    --------
    >>> float(damping_on_locus(3.0**0.5, 0.0, 0))
    0.0
    """
    root = np.asarray(u, dtype=np.float64)
    amplitude = delta0 + root * root
    cosine = cosine_on_locus(root, delta0, side)
    excess = _amplitude_plus_cosine(root, amplitude, delta0, cosine)
    return np.asarray((1.0 - cosine) * (1.0 + cosine) * (root / amplitude) ** 2 * (root / excess))


def _amplitude_plus_cosine(u: Values, amplitude: Values, delta0: npt.ArrayLike, t: Values) -> Values:
    """Return ``A + t``, minus the other root of the locus, without cancellation."""
    return np.asarray(-2.0 * u * u / ((amplitude + 2.0 * np.asarray(delta0)) * t))


def locus_pieces(delta0: float, smallest_damping: float) -> list[LocusPiece]:
    """Return the monotone pieces of the locus that can hold a fold.

    Parameters
    ----------
    delta0 : float
        Clearance [1].
    smallest_damping : float
        Smallest ``4 zeta**2`` asked for [1]: the locus runs to u = 0 and to infinity, where
        the damping vanishes, and is followed that far.

    Returns
    -------
    list of LocusPiece
        Its pieces.

    Examples
    --------
    >>> [piece.side for piece in locus_pieces(0.0, 1e-3)]
    [0, 0]
    """
    special = _meeting_points(delta0)
    if delta0 < 1.0:
        special.append(np.sqrt(3.0 * (1.0 - delta0)))
    lowest = 0.1 * min(smallest_damping, delta0 * np.cbrt(smallest_damping) or np.inf)
    highest = 10.0 * (1.0 + np.sqrt(delta0) + np.cbrt(1.0 / smallest_damping))
    count = int(_NODES_PER_DECADE * np.log10(highest / lowest)) + 2
    near = [point * (1.0 + sign * 10.0**-k) for point in special for k in range(2, 15, 2) for sign in (-1, 1)]
    nodes = np.unique([*np.geomspace(lowest, highest, count), *special, *near])
    return [piece for side in SIDES for piece in _pieces_on_side(nodes, delta0, side)]


def _meeting_points(delta0: float) -> list[float]:
    """Return the u > 0 where the two sides meet: ``A**2 (A + 2 delta0) = 8 u**2``."""
    cubic = np.array([1.0, 5.0 * delta0, 7.0 * delta0**2 - 8.0, 3.0 * delta0**3])
    roots = np.roots(cubic)
    depths = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)]
    for _ in range(3):
        slope = np.polyval(np.polyder(cubic), depths)
        depths = depths - np.divide(
            np.polyval(cubic, depths), slope, out=np.zeros_like(depths), where=slope != 0.0
        )
    return [float(np.sqrt(depth)) for depth in depths if depth > 0.0]


def _pieces_on_side(nodes: Values, delta0: float, side: int) -> list[LocusPiece]:
    """Return the pieces of one side, cut at its ends and where the damping turns."""
    damping = damping_on_locus(nodes, delta0, side)
    turning = _damping_slope(nodes, delta0, side)
    pieces = []
    for left, right in zip(range(nodes.size - 1), range(1, nodes.size), strict=True):
        if not np.isfinite(damping[left] + damping[right]):
            continue
        ends = [float(nodes[left]), float(nodes[right])]
        if turning[left] * turning[right] < 0.0:
            ends.insert(1, _turning_point(ends[0], ends[1], delta0, side))
        values = [float(damping_on_locus(end, delta0, side)) for end in ends]
        pieces += [
            LocusPiece(side, (ends[k], ends[k + 1]), (values[k], values[k + 1]))
            for k in range(len(ends) - 1)
        ]
    return pieces


def _damping_slope(u: npt.ArrayLike, delta0: float, side: int) -> Values:
    """Return a quantity with the sign of ``d(4 zeta**2)/dA`` along one side of the locus."""
    root = np.asarray(u, dtype=np.float64)
    amplitude = delta0 + root * root
    t = cosine_on_locus(root, delta0, side)
    excess = _amplitude_plus_cosine(root, amplitude, delta0, t)
    drift = t + 6.0 * delta0 / (amplitude + 2.0 * delta0) ** 2
    spread = t + excess  # 2 t + A: of one sign on each side, zero where the sides meet
    shape = 2.0 * t * excess + (1.0 - t) * (1.0 + t)  # over (1 - t**2) (A + t)
    remainder = (1.5 / (root * root) - 2.0 / amplitude) * excess - 1.0
    slope = drift * shape + spread * remainder * (1.0 - t) * (1.0 + t)
    return np.asarray(slope if side == 0 else -slope)


def _turning_point(low: float, high: float, delta0: float, side: int) -> float:
    """Return where the damping turns between two nodes, by bisection."""
    sign = np.sign(_damping_slope(low, delta0, side))
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if np.sign(_damping_slope(middle, delta0, side)) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def folds_on_pieces(
    pieces: list[LocusPiece], damping: Values, zeta: Values, delta0: float
) -> tuple[npt.NDArray[np.int_], Values, Values]:
    """Return every crossing of the given dampings.

    Parameters
    ----------
    pieces : list of LocusPiece
        The locus of one clearance.
    damping, zeta : ndarray, shape (m,)
        ``4 zeta**2`` and zeta itself [1].
    delta0 : float
        Clearance [1].

    Returns
    -------
    row : ndarray of int, shape (n,)
        Which damping the fold belongs to.
    u, cosine : ndarray, shape (n,)
        ``sqrt(A - delta0)`` and ``cos(theta)`` at the fold [1].

    Examples
    --------
    >>> import numpy as np
    >>> zeta = np.array([0.07])
    >>> pieces = locus_pieces(0.0, 0.0196)
    >>> row, u, cosine = folds_on_pieces(pieces, 4.0 * zeta**2, zeta, 0.0)
    >>> (u**3 / (u**2 + cosine)) ** 0.5
    array([1.932754..., 1.597821...])
    """
    ends = np.array([piece.damping for piece in pieces]).reshape(-1, 2) - 0.0
    above_left = ends[None, :, 0] > damping[:, None]
    above_right = ends[None, :, 1] > damping[:, None]
    row, which = np.nonzero(above_left != above_right)
    low = np.array([piece.u[0] for piece in pieces])[which]
    high = np.array([piece.u[1] for piece in pieces])[which]
    side = np.array([piece.side for piece in pieces], dtype=int)[which]
    falling = above_left[row, which]

    def on_side(function_of: Values, *, cosine: bool) -> Values:
        evaluate = cosine_on_locus if cosine else damping_on_locus
        return np.where(side == 0, evaluate(function_of, delta0, 0), evaluate(function_of, delta0, 1))

    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        before = (on_side(middle, cosine=False) > damping[row]) == falling
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    u = 0.5 * (low + high)
    return row, *_polished(u, on_side(u, cosine=True), zeta[row], delta0)


def _polished(u: Values, t: Values, zeta: Values, delta0: float) -> tuple[Values, Values]:
    """Return `u` and `t` after Newton steps in both, with 32-digit residuals."""
    clearance, one = DoubleDouble.of(np.full_like(u, delta0)), DoubleDouble.of(np.ones_like(u))
    double_zeta = DoubleDouble.of(2.0 * zeta)
    damping = double_zeta * double_zeta
    for _ in range(3):
        root, cosine = DoubleDouble.of(u), DoubleDouble.of(t)
        square = root * root
        amplitude = clearance + square
        wide = amplitude + clearance + clearance
        excess = amplitude + cosine
        locus = wide * (cosine * excess) + square + square
        cube = square * root
        loss = damping * (amplitude * amplitude)
        matching = (one - cosine * cosine) * cube - loss * excess
        A, m = amplitude.high, damping.high
        locus_u = 2.0 * u * (t * excess.high + wide.high * t + 2.0)
        locus_t = wide.high * (2.0 * t + A)
        matching_u = 3.0 * (1.0 - t * t) * u * u - 2.0 * u * m * A * (2.0 * excess.high + A)
        matching_t = -2.0 * t * cube.high - loss.high
        determinant = locus_u * matching_t - locus_t * matching_u
        step_u = (locus.high * matching_t - locus_t * matching.high) / determinant
        step_t = (locus_u * matching.high - locus.high * matching_u) / determinant
        u, t = u - step_u, t - step_t
    return u, t
