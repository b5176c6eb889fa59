"""A stretch of an orbit with all that Newton's method asks of it, and all that happens on it.

State and four differences from it are followed together by the core, by one Taylor series in
contact and in closed form in flight; what small changes of omega, zeta and delta0 make of it
follows. Field and Jacobian are continuous where contact begins and ends, so nothing is added there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.core.interface import DONE, STUCK, message_of
from rotor_ida.core.runs import COLUMNS, DIFFERENCES, Asked, follow
from rotor_ida.equations.model import rotating_field
from rotor_ida.errors import SimulationError
from rotor_ida.parallel.jobs import Stop
from rotor_ida.parameters import PARAMETERS, Rotor

MAXIMUM = 1.0  # the kind of an extremum
RTOL = 1e-15
# Absolute tolerance of one step in parts of the relative one.
ATOL = 1e-2


@dataclass(frozen=True, slots=True)
class Shot:
    """A stretch of an orbit, from a start to its end.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start, end : ndarray, shape (4,)
        States ``(x, y, vx, vy)`` on the rotating axes [1].
    duration : float
        Time between them [1].
    monodromy : ndarray, shape (4, 4)
        Derivative of the end by the start [1].
    by_parameter : ndarray, shape (4, n)
        Derivatives of the end by the first n of `rotor_ida.core.runs.COLUMNS` [1]: omega, zeta and
        delta0, and in the whole model what else a machine has. That by delta0 is 0 without
        clearance.
    contacts : ndarray, shape (n, 8)
        Entry, exit and peak time, root of the largest indentation, impulse, angular momentum at the
        peak, energy lost and largest force of each contact, as `rotor_ida.core.runs.Seen` has them;
        NaN where it begins before the start, or ends after the end.
    extrema : ndarray, shape (m, 7)
        Time, radius, kind, -1 or 1, and state of each minimum and maximum of the radius between
        them [1].
    start_rate, end_rate : ndarray, shape (4,)
        Rate of change of the state at the start and at the end [1].
    """

    rotor: Rotor
    start: Values
    end: Values
    duration: float
    monodromy: Values
    by_parameter: Values
    contacts: Values
    extrema: Values
    start_rate: Values
    end_rate: Values


def shoot(
    rotor: Rotor,
    start: Values,
    duration: float,
    stop: Stop,
    rtol: float = RTOL,
    *,
    whole: bool = False,
) -> Shot:
    """Follow a state for a time, with the derivatives of where it ends.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : ndarray, shape (4,)
        ``(x, y, vx, vy)`` on the rotating axes [1], at time 0, when a load points down on them.
    duration : float
        Time to follow it for [1].
    stop : ndarray, shape (1,)
        Anything but 0 asks to stop.
    rtol : float
        Tolerance of one step, relative to the size of the state [1].
    whole : bool
        Whether to differentiate by all that a machine has, even if it is the paper's rotor.

    Raises
    ------
    SimulationError
        If it could not be followed.
    """
    columns = len(COLUMNS) if whole or rotor.beyond else len(PARAMETERS)
    bundle = np.eye(DIFFERENCES + columns, 4)
    seen = follow(
        Asked(
            whole=whole,
            rotor=rotor,
            start=start,
            duration=duration,
            rtol=rtol,
            atol=ATOL * rtol,
            events=True,
            extrema=True,
            bundle=bundle,
            stop=stop,
        )
    )
    end = np.array(seen.state)
    status = seen.status
    if status == DONE and not math.isfinite(sum(bundle.ravel().tolist()) + sum(seen.state)):
        status = STUCK
    if status != DONE:
        x, y, vx, vy = start.tolist()
        reason = f"an orbit could not be followed round: {message_of(status)}"
        raise SimulationError(reason, time=0.0, state=(x, y, vx, vy))
    rates = rotating_field(start, rotor), rotating_field(end, rotor, duration)
    return Shot(
        rotor, start, end, duration, bundle[:DIFFERENCES].T, bundle[DIFFERENCES:].T,
        seen.contacts, seen.extrema, *rates,
    )  # fmt: skip
