"""The Taylor series of the differences of `rotor_ida.simulation.tangents`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import lent, shared
from rotor_ida.simulation.tangents import COUNT, VX, VY, X, Y
from rotor_ida.simulation.taylor.rows import LANES, Count, sum_products

Values = npt.NDArray[np.float64]

# What the motion gives: its pace by u, and times the pace a, b c and b s; then c and s.
PACE, PULL, BEND_X, BEND_Y, DIRECTION_X, DIRECTION_Y = range(6)
FACTORS = 6
_PARTS: Count = (0, 0, 0, 0)
_SIDES: Count = (0, 0)


class Differences(NamedTuple):
    """Coefficients of four differences about the beginning of a step, and of what they are made of.

    Parameters
    ----------
    terms : ndarray, shape (orders, 16)
        Coefficients of the differences.
    factors : ndarray, shape (6, orders)
        Coefficients of the factors that the motion gives.
    parts : ndarray, shape (4, orders, 16)
        What the first four factors multiply.
    sides : ndarray, shape (2, orders, 16)
        What the last two factors multiply: the x, and the y, of the differences.
    total, radial : ndarray, shape (16,)
        Sums of such products.
    kept : ndarray
        What keeps them all.
    """

    terms: Values
    factors: Values
    parts: Values
    sides: Values
    total: Values
    radial: Values
    kept: Values


@shared
def new_differences(orders: int) -> Differences:
    """Return room for so many coefficients."""
    table, known = orders * LANES, 7 * orders * LANES + FACTORS * orders
    kept = np.zeros(known + 2 * LANES)
    return Differences(
        lent(kept[:table]).reshape((orders, LANES)),
        lent(kept[7 * table : known]).reshape((FACTORS, orders)),
        lent(kept[table : 5 * table]).reshape((4, orders, LANES)),
        lent(kept[5 * table : 7 * table]).reshape((2, orders, LANES)),
        lent(kept[known : known + LANES]),
        lent(kept[known + LANES :]),
        kept,
    )


@shared
def expand_differences(differences: Differences, order: int, omega: float, zeta: float) -> None:
    """Write all coefficients of the differences up to `order`, from those of order 0."""
    terms, factors, parts, sides, total, radial, _kept = differences
    damping = 2.0 * zeta
    for n in range(order):
        for i in range(COUNT):
            sides[0, n, i], sides[1, n, i] = terms[n, X + i], terms[n, Y + i]
        sum_products(factors, DIRECTION_X, sides, _SIDES, n, radial)
        for i in range(COUNT):
            x, y, vx, vy = terms[n, X + i], terms[n, Y + i], terms[n, VX + i], terms[n, VY + i]
            parts[PACE, n, X + i] = vx + omega * y
            parts[PACE, n, Y + i] = vy - omega * x
            parts[PACE, n, VX + i] = omega * vy - damping * vx
            parts[PACE, n, VY + i] = -omega * vx - damping * vy
            parts[PULL, n, VX + i], parts[PULL, n, VY + i] = -x, -y
            parts[BEND_X, n, VX + i] = parts[BEND_Y, n, VY + i] = -radial[i]
        sum_products(factors, PACE, parts, _PARTS, n, total)
        share = 1.0 / (n + 1)
        for i in range(LANES):
            terms[n + 1, i] = total[i] * share


@shared
def longest_step_of(differences: Differences, order: int, rtol: float) -> float:
    """Return the step at which the last two terms of each difference reach its tolerance."""
    terms = differences.terms
    last, before = 0.0, 0.0
    for i in range(COUNT):
        size = 0.0
        for j in range(i, LANES, COUNT):
            size = max(size, abs(terms[0, j]), abs(terms[1, j]))
        if size > 0.0:
            part = 1.0 / (rtol * size)
            for j in range(i, LANES, COUNT):
                last = max(last, abs(terms[order, j]) * part)
                before = max(before, abs(terms[order - 1, j]) * part)
    step = math.inf
    if last > 0.0:
        step = last ** (-1.0 / order)
    if before > 0.0:
        step = min(step, before ** (-1.0 / (order - 1)))
    return step
