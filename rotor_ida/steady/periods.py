"""The period of a motion that repeats itself, and the distance of the motion from its cycle.

The states of largest radius are a Poincare section of the motion on the rotating axes. The motion
is periodic when they recur in the same order; its period is the time that this takes. The distance
follows from the difference of states one period apart. That difference is the distance times
``1 - mu``, with mu the cycle's multiplier, so that it is small on a slow transient far from the
cycle. So mu is computed too, by Taylor series; it decides when to stop, and no reported number
depends on it.

A load rotates on these axes once a revolution: under a load a motion can only repeat after whole
revolutions. There the section is stroboscopic, the states once a revolution, and the period a
whole number of revolutions.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import State
from rotor_ida.core.interface import DONE, message_of
from rotor_ida.core.runs import Rows, RunRequest, follow_run
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.simulation.flow import ATOL
from rotor_ida.steady.response import STEADY

# Smallest number of periods in the window: a single recurrence may be chance.
FEWEST_PERIODS = 3
# If the radius varies by at most this multiple of the states' miss, it may be a spiral inwards.
CLEAR_SWING = 1e6
# Tolerance of the multiplier, which decides when to stop and is not reported.
MULTIPLIER_RTOL = 1e-12
# Turning points closer in time are the same: rounding shifts them less, and two lie farther apart.
SAME_TURN = 1e-6


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


def turning_points(states: Values, extrema: Rows) -> TurningPoints:
    """Return the extrema of the radius, as in an `Orbit`, as turning points.

    Where the samples of the window, shape (n, 4), show a steady radius, extrema are noise and are
    left out.
    """
    radii = np.hypot(states[:, 0], states[:, 1])
    turns = extrema if np.ptp(radii) > STEADY * radii.max() else extrema[:0]
    return TurningPoints(turns["time"], turns["state"], turns["kind"] > 0.0)


@dataclass(frozen=True, slots=True)
class Recurrence:
    """How a motion repeats itself.

    Parameters
    ----------
    period : float
        Time after which it repeats [1].
    missed_by : float
        Largest difference of two states a period apart, in the last two periods, relative to the
        largest state [1].
    """

    period: float
    missed_by: float


def recurrence(turns: TurningPoints, tolerance: float) -> Recurrence | None:
    """Return how the motion repeats itself throughout the window; None if it does not.

    Two states a period apart may differ by `tolerance`, relative to the largest state.
    """
    times, states = turns.times[turns.are_maxima], turns.states[turns.are_maxima]
    most = times.size // FEWEST_PERIODS
    if most == 0:
        return None
    size = float(np.abs(states).max())
    allowed = min(tolerance * size, float(np.ptp(turns.radii)) / CLEAR_SWING)
    before = states[-2 : -2 - most : -1]
    candidates = 1 + np.flatnonzero(np.abs(before - states[-1]).max(axis=1) <= allowed)
    for count in candidates.tolist():
        missed_by = np.abs(states[count:] - states[:-count]).max(axis=1)
        if missed_by.max() <= allowed:
            period = float(times[-1] - times[-1 - count])
            return Recurrence(period, float(missed_by[-count:].max()) / size)
    return None


def recurrence_by_revolutions(
    states: Values, revolution: float, size: float, tolerance: float
) -> Recurrence | None:
    """Return after how many revolutions a motion repeats throughout the window, if it does.

    Parameters
    ----------
    states : ndarray, shape (n, 4)
        The states once a revolution [1].
    revolution : float
        Duration of a revolution [1].
    size : float
        The largest state of the motion [1].
    tolerance : float
        Allowed difference of two states a period apart, relative to `size`.
    """
    for count in range(1, (len(states) - 1) // FEWEST_PERIODS + 1):
        allowed = tolerance * size
        if count > 1:  # a spiral onto a shorter cycle comes back near itself as well
            others = np.abs(states[-count:-1] - states[-1]).max(axis=1)
            allowed = min(allowed, float(others.min()) / CLEAR_SWING)
        missed_by = np.abs(states[count:] - states[:-count]).max(axis=1)
        if missed_by.max() <= allowed:
            return Recurrence(count * revolution, float(missed_by[-count:].max()) / size)
    return None


def extreme_radii(turns: TurningPoints, period: float) -> tuple[float, float]:
    """Return the smallest and the largest radius in the last period of a window."""
    since = turns.times[turns.are_maxima][-1] - period
    radii = turns.radii[turns.times > since + SAME_TURN]
    return float(radii.min()), float(radii.max())


def slowest_multiplier(rotor: Rotor, state: State, period: float, stop: Stop) -> complex:
    """Return the nontrivial multiplier with which neighbours return most slowly.

    Under a load, with `state` at the start of a revolution, no multiplier is trivial.

    Raises
    ------
    SimulationError
        If the integration fails or is stopped.

    Notes
    -----
    Damping is uniform, so the multipliers are 1, ``q = exp(-2 zeta period)``, mu and ``q/mu``:
    the sum of all four, the trace of the monodromy matrix, gives mu. With contact damping or
    friction there are no such pairs.

    References
    ----------
    U. Dressler, "Symmetry property of the Lyapunov spectra of a class of dissipative dynamical
    systems with viscous damping", Physical Review A 38, 1988.
    """
    bundle = monodromy(rotor, state, period, stop)
    if rotor.load > 0.0:
        multipliers = np.linalg.eigvals(bundle)
        return complex(multipliers[np.argmax(np.abs(multipliers))])
    if not rotor.damps_uniformly:
        # no pairs: without the trivial one, that nearest 1
        multipliers = np.linalg.eigvals(bundle)
        rest = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
        return complex(rest[np.argmax(np.abs(rest))])
    product = math.exp(-2.0 * rotor.zeta * period)
    both = float(np.trace(bundle)) - 1.0 - product
    apart = cmath.sqrt(both * both - 4.0 * product)
    return 0.5 * max(both + apart, both - apart, key=abs)


def monodromy(rotor: Rotor, state: State, period: float, stop: Stop) -> Values:
    """Return the derivative of the state after a time by that before, shape (4, 4).

    Raises
    ------
    SimulationError
        If the integration fails or is stopped.
    """
    bundle = np.eye(4)
    seen = follow_run(
        RunRequest(
            rotor=rotor, start=state, duration=period, rtol=MULTIPLIER_RTOL,
            atol=ATOL * MULTIPLIER_RTOL, bundle=bundle, stop=stop,
        )
    )  # fmt: skip
    if seen.status != DONE:
        raise SimulationError(
            f"a cycle could not be followed: {message_of(seen.status)}", time=0.0, state=state
        )
    return bundle
