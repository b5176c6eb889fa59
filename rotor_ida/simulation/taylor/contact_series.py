"""The Taylor series of a contact, in the variables of `rotor_ida.simulation.contact_phase`.

With ``r = delta0 + q**2``, and k the rate at which the direction turns:

    q' = p/2                                                 t' = q
    p' = q (h**2/r**3 - 2 zeta p - q**3 + omega**2 c)        j' = q**4
    h' = -q (2 zeta h + omega**2 r s)                        k = q (h/r**2 - omega)
    c' = -s k,  s' = c k
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared_for_lanes
from rotor_ida.simulation.contact_phase import C, H, J, P, Q, S, T
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

SQUARE, INVERSE, FORCE, AROUND, SPIN, LIFT, ACROSS, OUT, DRAG, TURN, SINE, COSINE = range(12)
IMPULSE, SECANT, BENT_X, BENT_Y = range(12, 16)


@shared_for_lanes
def expand_contact(
    series: Series, factors: Values, order: int, omega: float, zeta: float, delta0: float
) -> None:
    """Write all coefficients up to `order`, from those of order 0.

    The factors of `Differences` are written on the way, unless they are empty.
    """
    terms, left, right, known = series
    first, one = 1.0 / (delta0 + terms[0, Q] ** 2), 1.0
    begin(left, right)
    for n in range(order):
        sum_known(left, right, known, n)
        _next_terms(terms, left, right, known, n, one, first, omega, 2.0 * zeta, delta0)
        if factors.size > 0:
            _next_factors(terms, left, right, known, n, factors)
        one = 0.0


@shared_for_lanes
def _next_terms(
    terms: Values, left: Values, right: Values, known: Values, n: int,
    one: float, first: float, omega: float, damping: float, delta0: float,
) -> None:  # fmt: skip
    """Write coefficients n + 1 of the state, from those up to n.

    `one` is coefficient n of the constant 1, and `first` is 1/r at the beginning.
    """
    q, p, h, c, s = terms[n, Q], terms[n, P], terms[n, H], terms[n, C], terms[n, S]
    unbalance = omega * omega
    square = times(left, right, known, SQUARE, n, q, q)
    radius = square + one * delta0
    inverse = over(left, right, known, INVERSE, n, one, radius, first)
    around = times(left, right, known, AROUND, n, inverse, h)
    spin = times(left, right, known, SPIN, n, around, inverse)
    force = times(left, right, known, FORCE, n, square, q)
    lift = times(left, right, known, LIFT, n, spin, around)
    across = times(left, right, known, ACROSS, n, radius, s)
    turn = times(left, right, known, TURN, n, spin - one * omega, q)
    out = times(left, right, known, OUT, n, unbalance * c - damping * p - force + lift, q)
    drag = times(left, right, known, DRAG, n, damping * h + unbalance * across, q)
    share = 1.0 / (n + 1)
    terms[n + 1, Q] = 0.5 * p * share
    terms[n + 1, P] = out * share
    terms[n + 1, H] = -drag * share
    terms[n + 1, C] = -times(left, right, known, SINE, n, turn, s) * share
    terms[n + 1, S] = times(left, right, known, COSINE, n, turn, c) * share
    terms[n + 1, T] = q * share
    terms[n + 1, J] = times(left, right, known, IMPULSE, n, square, square) * share


@shared_for_lanes
def _next_factors(
    terms: Values, left: Values, right: Values, known: Values, n: int, factors: Values
) -> None:
    """Write coefficients n of the factors: ``q**4/r`` is q f/r, ``3 q**2/2`` is q f'."""
    whole = (n + 1) * terms[n + 1, J]
    pull = times(left, right, known, SECANT, n, whole, right[n, INVERSE])
    bend = 1.5 * left[n, FORCE] - pull
    c, s = terms[n, C], terms[n, S]
    factors[PACE, n], factors[PULL, n] = terms[n, Q], pull
    factors[BEND_X, n] = times(left, right, known, BENT_X, n, bend, c)
    factors[BEND_Y, n] = times(left, right, known, BENT_Y, n, bend, s)
    factors[DIRECTION_X, n], factors[DIRECTION_Y, n] = c, s
