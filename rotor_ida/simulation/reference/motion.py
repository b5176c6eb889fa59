"""What the phases ask of an integration, and the root finder that works on any.

An integration takes one internal step at a time and can be read anywhere inside the last one, to
the solver's own order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]

# The solver looks at the goal only to choose its first step.
FAR_GOAL = 1e9
# Steps in a row that may end where they began: one does after a reading, the others are too short
# for the spacing of doubles.
MOST_IDLE_STEPS = 100
ROUNDING = 2.0**-52
MOST_HALVINGS = 200


class Motion(Protocol):
    """An autonomous system on its way from a start, led one internal step at a time.

    Attributes
    ----------
    low, point : float
        Ends of the last step.
    before, values : ndarray
        Values at those ends, valid until the next step.
    """

    low: float
    point: float
    before: Values
    values: Values

    def restart(self, start: Values, atol: Values) -> int:
        """Begin anew from `start` at point 0, with absolute tolerances `atol`."""

    def advance(self) -> int:
        """Take one internal step; return 0, or why it could not be taken."""

    def at(self, point: float) -> Values:
        """Return the values at a point of the last step, valid until the next reading."""

    def glance_at(self, point: float) -> Values:
        """Do as `at` does, faster and to rounding: for what does not act on the motion."""

    def evaluations(self) -> int:
        """Return the number of evaluations of the right-hand side since the start."""


def root(
    motion: Motion, function: Callable[[Values], float], level: float, low: float, high: float
) -> float:
    """Return a point between two points of the last step where `function` reaches `level`.

    Brent's method [1]_. The result is NaN where the difference does not change sign.

    References
    ----------
    .. [1] R. P. Brent, "Algorithms for Minimization without Derivatives", 1973, chapter 4.
    """
    a, b = low, high
    fa, fb = function(motion.at(a)) - level, function(motion.at(b)) - level
    if fa == 0.0:
        return a
    if fa * fb > 0.0 or np.isnan(fa) or np.isnan(fb):
        return np.nan
    c, fc, step, last = a, fa, b - a, b - a
    for _ in range(MOST_HALVINGS):
        if fb * fc > 0.0:
            c, fc, step, last = a, fa, b - a, b - a
        if abs(fc) < abs(fb):
            a, b, c = b, c, b
            fa, fb, fc = fb, fc, fb
        tolerance = 2.0 * ROUNDING * abs(b)
        half = 0.5 * (c - b)
        if abs(half) <= tolerance or fb == 0.0:
            break
        if abs(last) < tolerance or abs(fa) <= abs(fb):
            step = last = half
        else:
            p, q = _interpolated(a, b, c, fa, fb, fc)
            if 2.0 * p < min(3.0 * half * q - abs(tolerance * q), abs(last * q)):
                last, step = step, p / q
            else:
                step = last = half
        a, fa = b, fb
        b += step if abs(step) > tolerance else np.copysign(tolerance, half)
        fb = function(motion.at(b)) - level
    return b


def _interpolated(
    a: float, b: float, c: float, fa: float, fb: float, fc: float
) -> tuple[float, float]:
    """Return the step of the secant or of inverse quadratic interpolation, as p/q with p > 0."""
    s = fb / fa
    if a == c:
        p, q = (c - b) * s, 1.0 - s
    else:
        t, r = fa / fc, fb / fc
        p = s * ((c - b) * t * (t - r) - (b - a) * (r - 1.0))
        q = (t - 1.0) * (r - 1.0) * (s - 1.0)
    return (p, -q) if p > 0.0 else (-p, q)
