"""Where the radius turns from growing to shrinking, or back: the roots of r r'.

The motion is read at equally spaced times. Between two of them ``g = r r' = x vx + y vy`` is
approximated by the cubic with its exact slopes. The same stretch is then simulated once more with
samples at the roots of the cubics, which leave the solver's steps as they are, and Newton's method
corrects the times. So these are the turning points of the very motion that was followed, by the
very method that followed it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline

from rotor_ida.equations.contact import secant_stiffness
from rotor_ida.equations.modes import Along, acceleration, turned_rates
from rotor_ida.parameters import Rotor

Values = npt.NDArray[np.float64]

# A radius that varies by less than this part of it does not turn, to what tolerances can tell.
CONSTANT = 1e-9
# A step of Newton's method shorter than this leaves an error of about its square.
CLOSE = 1e-6
ATTEMPTS = 8


@dataclass(frozen=True, slots=True)
class TurningPoints:
    """The turning points of the radius in a window, in order of time.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times from the start of the window [1].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` there, on the rotating axes [1].
    are_maxima : ndarray of bool, shape (n,)
        Whether the radius is largest there, or smallest.
    """

    times: Values
    states: Values
    are_maxima: npt.NDArray[np.bool_]

    @property
    def radii(self) -> Values:
        """Distances from the bearing axis [1]."""
        return np.hypot(self.states[:, 0], self.states[:, 1])


def turning_points(
    rotor: Rotor, times: Values, states: Values, again: Callable[[Values], Values]
) -> TurningPoints:
    """Return the turning points of the radius in a window.

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
    """
    radii = np.hypot(states[:, 0], states[:, 1])
    if np.ptp(radii) <= CONSTANT * radii.max():
        return TurningPoints(np.empty(0), np.empty((0, 4)), np.empty(0, dtype=np.bool_))
    guesses = roots_of_cubics(rotor, times, states)
    for _ in range(ATTEMPTS):
        found, reached = guesses, again(guesses)
        g, slope = radial_motion(rotor, reached)
        change = -np.divide(g, slope, out=np.full_like(g, np.inf), where=slope != 0.0)
        good = np.abs(change) <= CLOSE
        if good.all():
            break
        # where the cubic had a root and the motion has none, Newton's method wanders off
        near = np.abs(change) <= times[1]
        guesses = np.unique(np.clip(found[near] + change[near], 0.0, times[-1]))
    return _corrected(rotor, found[good], reached[good], change[good])


def _corrected(rotor: Rotor, times: Values, states: Values, change: Values) -> TurningPoints:
    """Take the last step of Newton's method, too short to simulate anything again for it."""
    once = np.diff(times + change, prepend=-np.inf) > CLOSE
    times, states, change = times[once], states[once], change[once]
    states = states + change[:, None] * _rates(rotor, states)
    _, slope = radial_motion(rotor, states)
    return TurningPoints(times + change, states, slope < 0.0)


def roots_of_cubics(rotor: Rotor, times: Values, states: Values) -> Values:
    """Return the roots of the cubics through ``r r'`` at some times, with its slopes there."""
    g, slope = radial_motion(rotor, states)
    roots = CubicHermiteSpline(times, g, slope).roots(extrapolate=False)
    unique: Values = np.unique(roots[np.isfinite(roots)])
    return unique


def radial_motion(rotor: Rotor, states: Values) -> tuple[Values, Values]:
    """Return ``g = r r'`` and its rate of change, of states on the rotating axes."""
    x, y, vx, vy = states.T
    ax, ay = _accelerations(rotor, states)
    return x * vx + y * vy, vx**2 + vy**2 + x * ax + y * ay


def _rates(rotor: Rotor, states: Values) -> Values:
    """Return the rates of change of states, read on the rotating axes."""
    x, y, vx, vy = states.T
    ax, ay = _accelerations(rotor, states)
    return np.stack(turned_rates((x, y), (vx, vy), (ax, ay), rotor.omega), axis=-1)


def _accelerations(rotor: Rotor, states: Values) -> tuple[Values, Values]:
    """Return the accelerations on fixed axes, read along the rotating ones."""
    x, y, vx, vy = states.T
    secant = secant_stiffness(np.hypot(x, y), rotor.delta0)
    ax = acceleration(Along(x, vx, x, 1.0), secant, rotor)
    return ax, acceleration(Along(y, vy, y, 0.0), secant, rotor)
