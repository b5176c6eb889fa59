"""Where the radius turns, for a run of the reference, which records no extrema as it goes.

Between two samples ``g = r r' = x vx + y vy`` is approximated by the cubic with its exact slopes.
The same stretch is then simulated once more with samples at the roots of the cubics, which leave
the solver's steps as they are, and Newton's method corrects the times. So these are the turning
points of the very motion that was followed, by the very method that followed it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline

from rotor_ida.core.interface import EXTREMUM_COLUMNS
from rotor_ida.equations.contact import secant_stiffness
from rotor_ida.equations.modes import Along, acceleration
from rotor_ida.parameters import Rotor

Values = npt.NDArray[np.float64]

# A step of Newton's method shorter than this leaves an error of its square.
CLOSE = 1e-6
ATTEMPTS = 8


def extrema_between(
    rotor: Rotor, times: Values, states: Values, again: Callable[[Values], Values]
) -> Values:
    """Return the extrema of the radius in a window, as a run of the core records them.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    times : ndarray, shape (n,)
        Equally spaced times from the start of the window, 0, to its end [1].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times, on the rotating axes [1].
    again : callable
        Simulates the same window once more, and returns the states at other times.

    Returns
    -------
    ndarray, shape (m, 7)
        Time, radius, kind (-1 or 1) and state of each [1].
    """
    g, slope = _radial_motion(rotor, states)
    roots = CubicHermiteSpline(times, g, slope).roots(extrapolate=False)
    guesses: Values = np.unique(roots[np.isfinite(roots)])
    for _ in range(ATTEMPTS):
        found, reached = guesses, again(guesses)
        g, slope = _radial_motion(rotor, reached)
        change = -np.divide(g, slope, out=np.full_like(g, np.inf), where=slope != 0.0)
        good = np.abs(change) <= CLOSE
        if good.all():
            break
        # where the cubic had a root and the motion has none, Newton's method wanders off
        near = np.abs(change) <= times[1]
        guesses = np.unique(np.clip(found[near] + change[near], 0.0, times[-1]))
    once = good & (np.diff(found, prepend=-np.inf) > CLOSE)
    rows = np.empty((int(once.sum()), EXTREMUM_COLUMNS))
    rows[:, 0], rows[:, 2], rows[:, 3:] = found[once], -np.sign(slope[once]), reached[once]
    rows[:, 1] = np.hypot(rows[:, 3], rows[:, 4])
    return rows


def _radial_motion(rotor: Rotor, states: Values) -> tuple[Values, Values]:
    """Return ``g = r r'`` and its rate of change, of states on the rotating axes."""
    x, y, vx, vy = states.T
    secant = secant_stiffness(np.hypot(x, y), rotor.delta0)
    ax = acceleration(Along(x, vx, x, 1.0), secant, rotor)
    ay = acceleration(Along(y, vy, y, 0.0), secant, rotor)
    return x * vx + y * vy, vx**2 + vy**2 + x * ax + y * ay
