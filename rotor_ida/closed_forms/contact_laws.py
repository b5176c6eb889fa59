"""Both contact laws, by Hertz and of a linear spring, over arrays of exponents."""

from __future__ import annotations

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.model.contact import (
    HERTZ_EXPONENT,
    contact_force,
    contact_stiffness,
    indentation,
    secant_stiffness,
)


def force(radius: Values, delta0: Values, exponent: Values) -> Values:
    """Return ``f(r) = max(r - delta0, 0)**n`` [1].

    Examples
    --------
    >>> force(np.array([4.5, 4.5]), np.array([0.5, 0.5]), np.array([1.0, 1.5]))
    array([4., 8.])
    """
    linear = indentation(radius, delta0)
    return np.where(exponent == HERTZ_EXPONENT, contact_force(radius, delta0), linear)


def stiffnesses(radius: Values, delta0: Values, exponent: Values) -> tuple[Values, Values]:
    """Return the slope ``f'(r)`` and the secant stiffness ``f(r)/r`` [1].

    Where a linear contact begins, the slope is 1, and the secant without clearance as well.

    Examples
    --------
    >>> stiffnesses(np.array([4.5]), np.array([0.5]), np.array([1.0]))[0]
    array([1.])
    """
    hertz = exponent == HERTZ_EXPONENT
    slope = np.where(hertz, contact_stiffness(radius, delta0), np.where(radius < delta0, 0.0, 1.0))
    depth = indentation(radius, delta0)
    start = np.broadcast_to(np.where(delta0 > 0.0, 0.0, 1.0), depth.shape).copy()
    secant = np.divide(depth, radius, out=start, where=radius > 0.0)
    return slope, np.where(hertz, secant_stiffness(radius, delta0), secant)
