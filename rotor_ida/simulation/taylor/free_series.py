"""The Taylor series of a rotor without clearance, in displacement and velocity on rotating axes.

    x' = vx + omega y,    vx' = omega**2 - 2 zeta vx + omega vy - k x
    y' = vy - omega x,    vy' =          - 2 zeta vy - omega vx - k y,    k = (x**2 + y**2)**(1/4)

The force is not smooth at the centre, so the series converges no farther than to a moment at which
the complex continuation of the motion passes there.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared_for_lanes
from rotor_ida.simulation.taylor.differences import (
    BEND_X,
    BEND_Y,
    DIRECTION_X,
    DIRECTION_Y,
    PACE,
    PULL,
)
from rotor_ida.simulation.taylor.rows import sum_known
from rotor_ida.simulation.taylor.series import Series, begin, over, times

Values = npt.NDArray[np.float64]

SQUARE_X, SQUARE_Y, ROOT, SLOPE, PULL_X, PULL_Y, QUOTIENT, BENT_X, BENT_Y = range(9)
X, Y, VX, VY = range(4)


@shared_for_lanes
def expand_free(
    series: Series, factors: Values, order: int, omega: float, zeta: float, pulled: float
) -> None:
    """Write all coefficients up to `order`, from those of order 0.

    The factors of `Differences` are written on the way, unless they are empty. `pulled` is 1 where
    the force acts; with 0 it is left out.
    """
    terms, left, right, known = series
    square = terms[0, X] ** 2 + terms[0, Y] ** 2
    first = pulled / square if square > 0.0 else 0.0
    root, one = math.sqrt(math.sqrt(pulled * square)), 1.0
    begin(left, right)
    for n in range(order):
        sum_known(left, right, known, n)
        _next_terms(terms, left, right, known, n, one, first, root, omega, 2.0 * zeta)
        if factors.size > 0:
            _next_factors(terms, left, right, known, n, one, first, factors)
        one = 0.0


@shared_for_lanes
def _next_terms(
    terms: Values, left: Values, right: Values, known: Values, n: int,
    one: float, first: float, root: float, omega: float, damping: float,
) -> None:  # fmt: skip
    """Write coefficients n + 1 of the state, from those up to n.

    `one` is coefficient n of the constant 1; at the beginning of the step `first` is ``1/r**2``
    and `root` is ``r**0.5``.
    """
    x, y, vx, vy = terms[n, X], terms[n, Y], terms[n, VX], terms[n, VY]
    square = times(left, right, known, SQUARE_X, n, x, x)
    square += times(left, right, known, SQUARE_Y, n, y, y)
    pull = _fourth_root(left, right, known, n, square, one * root, first)
    pull_x = times(left, right, known, PULL_X, n, pull, x)
    pull_y = times(left, right, known, PULL_Y, n, pull, y)
    share = 1.0 / (n + 1)
    terms[n + 1, X] = (vx + omega * y) * share
    terms[n + 1, Y] = (vy - omega * x) * share
    terms[n + 1, VX] = (one * omega * omega + omega * vy - damping * vx - pull_x) * share
    terms[n + 1, VY] = (-omega * vx - damping * vy - pull_y) * share


@shared_for_lanes
def _fourth_root(
    left: Values, right: Values, known: Values, n: int, a: float, root: float, first: float
) -> float:
    """Return coefficient n of ``b = a**(1/4)``, which solves ``a b' = a' b/4``.

    That is, ``n a_0 b_n`` is the sum over k below n of ``(n - 5 k)/4 a_(n-k) b_k``. `root` is
    ``b_0`` at n = 0, and 0 later; `first` is ``1/a_0``.
    """
    whole = times(left, right, known, ROOT, n, a, 0.0)
    part = times(left, right, known, SLOPE, n, a, 0.0)
    b = root + (0.25 * whole - 1.25 * part / max(n, 1)) * first
    right[n, ROOT], right[n, SLOPE] = b, n * b
    return float(b)


@shared_for_lanes
def _next_factors(
    terms: Values, left: Values, right: Values, known: Values, n: int, one: float, first: float,
    factors: Values,
) -> None:  # fmt: skip
    """Write coefficients n of the factors, with x and y for the direction: b/r**2 is k/(2 r**2)."""
    x, y, pull = terms[n, X], terms[n, Y], right[n, ROOT]
    bend = 0.5 * over(left, right, known, QUOTIENT, n, pull, left[n, ROOT], first)
    factors[PACE, n], factors[PULL, n] = one, pull
    factors[BEND_X, n] = times(left, right, known, BENT_X, n, bend, x)
    factors[BEND_Y, n] = times(left, right, known, BENT_Y, n, bend, y)
    factors[DIRECTION_X, n], factors[DIRECTION_Y, n] = x, y
