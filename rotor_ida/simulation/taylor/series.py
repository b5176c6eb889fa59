"""Taylor coefficients of products and quotients, from which those of the motion follow.

Coefficient n of a product is a convolution of the coefficients of its factors. All but its two end
terms are known as soon as the coefficients below n are. So these known parts of all products of
one system are summed together, each in a lane of its own, which is nearly all of the arithmetic;
what remains of order n is then written as the equations are.

References
----------
.. [1] Jorba and M. Zou, "A software package for the numerical integration of ODEs by means of
   high-order Taylor methods", Experimental Mathematics 14, 2005, section 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared, shared_for_lanes
from rotor_ida.simulation.taylor.rows import LANES, WIDTH

Values = npt.NDArray[np.float64]


class Series(NamedTuple):
    """Coefficients about the beginning of a step, and the factors of which they were made.

    Parameters
    ----------
    terms : ndarray, shape (orders, 8)
        Coefficients of the state, of up to 8 components.
    left, right : ndarray, shape (orders, 16)
        Coefficients of the two factors of each product.
    known : ndarray, shape (16,)
        The coefficients of the products, of the order at hand, without their end terms.
    """

    terms: Values
    left: Values
    right: Values
    known: Values


@shared
def new_series(orders: int) -> Series:
    """Return room for so many coefficients."""
    return Series(
        np.zeros((orders, WIDTH)),
        np.zeros((orders, LANES)),
        np.zeros((orders, LANES)),
        np.zeros(LANES),
    )


@shared_for_lanes
def begin(left: Values, right: Values) -> None:
    """Make ready for coefficients 0."""
    for lane in range(LANES):
        left[0, lane] = 0.0
        right[0, lane] = 0.0


@shared_for_lanes
def times(
    left: Values, right: Values, known: Values, lane: int, n: int, a: float, b: float
) -> float:
    """Return coefficient n of a product, given those of its factors, the one known last first.

    The row 0 of the factors must be 0 before they get there: it has one end term, not two. There
    are no branches here, as numba would count references to the arrays around each.
    """
    right[n, lane] = b
    total = known[lane] + left[0, lane] * b + a * right[0, lane]
    left[n, lane] = a
    return float(total)


@shared_for_lanes
def over(
    left: Values, right: Values, known: Values, lane: int, n: int, c: float, a: float, first: float
) -> float:
    """Return coefficient n of ``b = c/a``, given those of c and a, and `first`, which is ``1/a_0``.

    Coefficient n of the product of a and b is that of c.
    """
    b = (c - known[lane]) * first - a * (right[0, lane] * first)
    left[n, lane], right[n, lane] = a, b
    return float(b)
