"""The period of a motion that repeats itself.

The states of largest radius are a Poincare section of the motion on the rotating axes. The motion
is periodic when they recur in the same order; its period is the time that this takes.

A load rotates on these axes once a revolution: under a load a motion can only repeat after whole
revolutions. There the section is stroboscopic, the states once a revolution, and the period a
whole number of revolutions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.runs import Rows

# Smallest number of periods in the window: a single recurrence may be chance.
FEWEST_PERIODS = 3
# If the radius varies by at most this multiple of the states' miss, it may be a spiral inwards.
CLEAR_SWING = 1e6


@dataclass(frozen=True, slots=True)
class Recurrence:
    """How a motion repeats itself.

    Parameters
    ----------
    period : float
        Time after which it repeats [dimensionless].
    missed_by : float
        Largest difference of two states a period apart, in the last two periods, relative to the
        largest state [dimensionless].
    """

    period: float
    missed_by: float


def recurrence(extrema: Rows, tolerance: float) -> Recurrence | None:
    """Return how the motion repeats itself throughout the window; None if it does not.

    `extrema` are those of its radius, as in `rotor_ida.core.runs`. Two states a period apart may
    differ by `tolerance`, relative to the largest state.
    """
    maxima = extrema[extrema["kind"] > 0.0]
    times, states = maxima["time"], maxima["state"]
    most = times.size // FEWEST_PERIODS
    if most == 0:
        return None
    size = float(np.abs(states).max())
    allowed = min(tolerance * size, float(np.ptp(extrema["radius"])) / CLEAR_SWING)
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
    states : ndarray, shape (m, n)
        The states once a revolution, or once in a period that is known.
    revolution : float
        The time between them.
    size : float
        The largest state of the motion.
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
